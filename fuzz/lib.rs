//! What every target does with its bytes.

use std::{panic, path::Path, sync::Once};

use amacrine::{
    event::{
        Packet,
        codec::{Arrival, Coded, Coding, Layout},
        file::{self, Compression, Format, Opening, Reader},
    },
    guard,
    plane::Size,
    unit::Micros,
};

/// Reads the bytes as a file of this format: an end or a message, never a panic, and memory
/// in proportion to the bytes. What was read is written in the same format and read again.
pub fn read(format: Format, bytes: &[u8]) {
    spare_what_is_guarded();
    let opening = Opening {
        format: Some(format),
        size: None,
    };
    let Ok(reader) = Reader::of_bytes(Path::new("fuzz"), bytes.to_vec(), &opening) else {
        return;
    };
    let (loaded, _) = file::all(reader);
    let folder = tempfile::tempdir().expect("a folder for temporary files");
    let path = folder.path().join("again");
    if file::write_as(&path, format, Compression::Lz4, &loaded.packet).is_ok() {
        let again = file::read_as(&path, &opening).expect("we wrote it");
        assert_eq!(again.packet.events, loaded.packet.events);
    }
}

/// libFuzzer's hook ends the program at every panic.
fn spare_what_is_guarded() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let hook = panic::take_hook();
        panic::set_hook(Box::new(move |panic| {
            if !guard::is_guarded() {
                hook(panic);
            }
        }));
    });
}

/// Takes five bytes for what sender and receiver agreed on, the rest for address words: events
/// or a message, never a panic. The events are written as words and read again.
pub fn words(bytes: &[u8]) {
    let Some((&[height, width, channels, flags, events], words)) = bytes.split_first_chunk() else {
        return;
    };
    let side = |byte: u8| usize::from(byte) * 7 + 1;
    let coded = Coded {
        size: Size::new(side(height), side(width)),
        channels: channels.max(1),
        layout: if flags & 1 == 0 {
            Layout::Single
        } else {
            Layout::Burst
        },
        huffman: flags & 2 != 0,
        bytes: words.to_vec(),
        bits: (8 * words.len() as u64).saturating_sub(u64::from(flags >> 5)),
        arrivals: vec![Arrival {
            t: Micros(1),
            events: events.into(),
        }],
    };
    let Ok(events) = coded.decode() else { return };
    let mut packet = Packet::new(coded.size, coded.channels);
    packet.events = events;
    let coding = Coding {
        layout: coded.layout,
        book: None,
    };
    let again = coding.encode(&packet).and_then(|coded| coded.decode());
    assert_eq!(again.expect("we wrote it"), packet.events);
}
