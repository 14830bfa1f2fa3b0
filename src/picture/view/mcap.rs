//! A packet as an MCAP recording, for viewers of ROS 2: for each kind of
//! cell its events (`dvs_msgs/msg/EventArray`) and pictures of them (`sensor_msgs/msg/Image`), window
//! by window.
//!
//! Topics are `/events` and `/image`; of several kinds `/events/kind0_NAME` and `/image/kind0_NAME`,
//! and so on, since no part of a topic may begin with a digit. A window's messages have the time of
//! its end. <https://mcap.dev/spec>, <https://mcap.dev/spec/registry>; names of topics:
//! <https://design.ros2.org/articles/topic_and_service_names.html>.

use std::{collections::BTreeMap, path::Path};

use mcap::{WriteOptions, Writer, records::MessageHeader};

use super::{frame, window::Window};
use crate::{
    event::{Event, Packet, Polarity},
    picture::error::{PictureError, check_size},
    save::AtomicFile,
    unit::Micros,
};

/// What a header and a time are, in the language of ROS 2.
const HEADER: &str = "std_msgs/Header header\n";
const PARTS: &str =
    "================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
";

/// Events, as the drivers of event cameras for ROS 2 publish them.
const EVENTS: &str = "uint32 height
uint32 width
dvs_msgs/Event[] events
";
const EVENT: &str =
    "================================================================================
MSG: dvs_msgs/Event
uint16 x
uint16 y
builtin_interfaces/Time ts
bool polarity
";

/// A picture.
const IMAGE: &str = "uint32 height
uint32 width
string encoding
uint8 is_bigendian
uint32 step
uint8[] data
";

/// What the sensor is called in the tree of frames of reference.
const FRAME: &str = "amacrine";

/// The channels of one kind of cell.
struct Topics {
    events: u16,
    image: u16,
}

/// Writes a recording of a packet, whole or not at all; of how many windows.
///
/// # Errors
/// When the sensor has no pixels, or the file cannot be written.
pub fn write(path: &Path, packet: &Packet, window: Micros) -> Result<u64, PictureError> {
    check_size(packet.size)?;
    let mut file = AtomicFile::create(path)?;
    let written = record(&mut file, packet, window);
    let windows = written.map_err(|cause| file.failed(std::io::Error::other(cause)))?;
    file.keep()?;
    Ok(windows)
}

fn record(file: &mut AtomicFile, packet: &Packet, window: Micros) -> mcap::McapResult<u64> {
    let options = WriteOptions::new()
        .compression(None)
        .profile("ros2")
        .library(concat!("amacrine ", env!("CARGO_PKG_VERSION")));
    let mut writer = Writer::with_options(file, options)?;
    let events = writer.add_schema(
        "dvs_msgs/msg/EventArray",
        "ros2msg",
        [HEADER, EVENTS, PARTS, EVENT].concat().as_bytes(),
    )?;
    let image = writer.add_schema(
        "sensor_msgs/msg/Image",
        "ros2msg",
        [HEADER, IMAGE, PARTS].concat().as_bytes(),
    )?;
    let mut kinds = Vec::new();
    for kind in 0..packet.channels {
        let under = topic(packet, kind);
        let none = BTreeMap::new();
        kinds.push(Topics {
            events: writer.add_channel(events, &format!("/events{under}"), "cdr", &none)?,
            image: writer.add_channel(image, &format!("/image{under}"), "cdr", &none)?,
        });
    }
    let (from, to) = packet.span;
    let step = window.0.max(1);
    let windows = to.0.saturating_sub(from.0).div_ceil(step).max(1);
    for i in 0..windows {
        let end = Micros((from.0 + (i + 1) * step).min(to.0.max(from.0 + 1)));
        let own = Window {
            // The first holds what came at the very start.
            from: Micros(from.0 + i * step),
            to: end,
            tau: if i == 0 { Micros(u64::MAX) } else { Micros(0) },
        };
        let all = own.events(packet);
        for (kind, topics) in (0..).zip(&kinds) {
            let of_kind = || all.iter().filter(move |event| event.channel == kind);
            let pixels = frame::pixels(all, packet.size, Some(kind));
            let messages = [
                (topics.events, event_array(packet, end, of_kind())),
                (topics.image, picture(packet, end, pixels.as_raw())),
            ];
            for (channel_id, message) in messages {
                let header = MessageHeader {
                    channel_id,
                    sequence: i as u32,
                    log_time: end.0.saturating_mul(1000),
                    publish_time: end.0.saturating_mul(1000),
                };
                writer.write_to_known_channel(&header, &message)?;
            }
        }
    }
    writer.finish()?;
    Ok(windows)
}

/// What follows `/events` and `/image`: nothing of one kind, else its number and its name, as far as
/// a topic may have it: ASCII letters and digits, and no `_` beside another.
fn topic(packet: &Packet, kind: u8) -> String {
    if packet.channels == 1 {
        return String::new();
    }
    let name = packet.names.get(usize::from(kind));
    let name = name.map_or("", String::as_str);
    let words = name.split(|c: char| !c.is_ascii_alphanumeric());
    let words = words.filter(|word| !word.is_empty());
    words.fold(format!("/kind{kind}"), |topic, word| topic + "_" + word)
}

fn event_array<'a>(
    packet: &Packet,
    at: Micros,
    events: impl Iterator<Item = &'a Event> + Clone,
) -> Vec<u8> {
    let mut cdr = Cdr::new(at);
    cdr.u32(packet.size.height as u32);
    cdr.u32(packet.size.width as u32);
    cdr.u32(events.clone().count() as u32);
    for event in events {
        cdr.u16(event.x);
        cdr.u16(event.y);
        cdr.time(event.t);
        cdr.u8((event.polarity == Polarity::On).into());
    }
    cdr.bytes
}

fn picture(packet: &Packet, at: Micros, pixels: &[u8]) -> Vec<u8> {
    let mut cdr = Cdr::new(at);
    cdr.u32(packet.size.height as u32);
    cdr.u32(packet.size.width as u32);
    cdr.text("rgb8");
    cdr.u8(0);
    cdr.u32(3 * packet.size.width as u32);
    cdr.u32(pixels.len() as u32);
    cdr.bytes.extend_from_slice(pixels);
    cdr.bytes
}

/// A message as ROS 2 serialises it: little-endian, numbers at multiples of their size.
struct Cdr {
    bytes: Vec<u8>,
}

impl Cdr {
    /// The bytes before the message: the byte order.
    const START: [u8; 4] = [0, 1, 0, 0];

    /// A message that begins with a header of this time.
    fn new(at: Micros) -> Self {
        let mut cdr = Self {
            bytes: Self::START.to_vec(),
        };
        cdr.time(at);
        cdr.text(FRAME);
        cdr
    }

    fn align(&mut self, size: usize) {
        let message = self.bytes.len() - Self::START.len();
        let to = Self::START.len() + message.next_multiple_of(size);
        self.bytes.resize(to, 0);
    }

    fn u8(&mut self, value: u8) {
        self.bytes.push(value);
    }

    fn u16(&mut self, value: u16) {
        self.align(2);
        self.bytes.extend(value.to_le_bytes());
    }

    fn u32(&mut self, value: u32) {
        self.align(4);
        self.bytes.extend(value.to_le_bytes());
    }

    /// Seconds and nanoseconds.
    fn time(&mut self, t: Micros) {
        let seconds = u32::try_from(t.0 / 1_000_000).unwrap_or(i32::MAX as u32);
        self.u32(seconds);
        self.u32((t.0 % 1_000_000 * 1000) as u32);
    }

    fn text(&mut self, text: &str) {
        self.u32(text.len() as u32 + 1);
        self.bytes.extend(text.bytes());
        self.bytes.push(0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::view::tests::packet;

    /// What is written, read back by the crate: every event once, in its window, at its topic.
    #[test]
    fn every_event_is_in_one_message_of_its_kind() {
        let mut all = packet(&[
            (0, 1, 2, true),
            (3, 0, 0, false),
            (250, 5, 3, true),
            (999, 2, 1, false),
        ]);
        all.channels = 2;
        all.names = vec!["centre, on_2é".to_owned(), "縁".to_owned()];
        all.events[2].channel = 1;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.mcap");
        assert_eq!(write(&path, &all, Micros(250)).unwrap(), 4);
        let bytes = std::fs::read(&path).unwrap();
        let mut counts: BTreeMap<String, Vec<u32>> = BTreeMap::new();
        for message in mcap::MessageStream::new(&bytes).unwrap() {
            let message = message.unwrap();
            // A header of 8 + 4 + 9 bytes and 3 of padding, and the size.
            let count = u32::from_le_bytes(message.data[36..40].try_into().unwrap());
            let topic = message.channel.topic.clone();
            if topic.starts_with("/events") {
                counts.entry(topic).or_default().push(count);
            } else {
                // Three bytes for each pixel end the message.
                let pixels = message.data.len() - 6 * 4 * 3;
                assert_eq!(message.data[pixels - 4..pixels], 72_u32.to_le_bytes());
            }
        }
        let wanted = [
            ("/events/kind0_centre_on_2".to_owned(), vec![2, 0, 0, 1]),
            ("/events/kind1".to_owned(), vec![1, 0, 0, 0]),
        ];
        assert_eq!(counts, BTreeMap::from(wanted));
    }
}
