//! Pictures of one packet: every view of any packet can be drawn, its axes have units, PNG and
//! SVG are of one page, animations show every window once; a pixel has the colour of its events.

use std::fs;

use amacrine::{
    event::{Event, Packet, Polarity},
    picture::{
        Drawing, PictureError, ink, raster, svg,
        view::{self, Look, View},
        write_drawing, write_frames,
    },
    plane::Size,
    unit::Micros,
};
use image::{AnimationDecoder, Rgb, codecs::gif::GifDecoder, codecs::png::PngDecoder};
use proptest::prelude::*;

const VIEWS: [View; 7] = [
    View::Overview,
    View::Frame,
    View::Surface,
    View::Cloud,
    View::Rate,
    View::Intervals,
    View::Kinds,
];

fn look(view: View) -> Look<'static> {
    Look {
        title: "a <title> & more",
        view,
        window: Micros(100),
        at: None,
    }
}

fn event(t: u64, x: u16, y: u16, on: bool, channel: u8) -> Event {
    Event {
        t: Micros(t),
        x,
        y,
        polarity: if on { Polarity::On } else { Polarity::Off },
        channel,
    }
}

/// Two kinds, two corners, one pixel that speaks three times.
fn small() -> Packet {
    let mut packet = Packet::new(Size::new(6, 8), 2);
    packet.events = vec![
        event(10, 0, 0, false, 0),
        event(500, 7, 5, true, 1),
        event(510, 7, 5, true, 0),
        event(520, 7, 5, true, 1),
        event(530, 0, 5, false, 0),
    ];
    packet.span = (Micros(0), Micros(1000));
    packet
}

fn texts(drawing: &Drawing) -> String {
    drawing.texts().collect::<Vec<_>>().join("\n")
}

#[test]
fn every_view_says_what_it_shows_and_in_which_unit() {
    let said = |view| texts(&view::draw(&small(), &look(view)).unwrap());
    let has = |view, words: &[&str]| {
        let text = said(view);
        for word in words {
            assert!(text.contains(word), "{view:?}: no {word:?} in\n{text}");
        }
    };
    let facts = "8x6 px, 2 kinds, 0.001 s; 3 ON, 2 OFF";
    for view in VIEWS {
        has(view, &["a <title> & more", facts]);
    }
    // The busiest 100 us: four of the five events, up to 530.
    has(
        View::Frame,
        &["0.00043 s to 0.00053 s: 3 ON, 1 OFF", "3+ ON"],
    );
    has(View::Surface, &["at 0.00053 s; fades by e in 100 us"]);
    has(
        View::Cloud,
        &["t (s)", "x (px)", "all events", "0.0000", "0.0010"],
    );
    has(View::Rate, &["t (s)", "ev/s, in bins of 5 us"]);
    has(
        View::Intervals,
        &[
            "% of intervals",
            "time between a cell's events",
            "1 intervals: half are at most 20 us",
            "ON-ON",
            "OFF-OFF",
            "sign changes",
        ],
    );
    has(
        View::Kinds,
        &["kind 0", "kind 1", "1 ON, 1 OFF", "2 ON, 0 OFF"],
    );
    has(
        View::Overview,
        &["event frame", "time surface", "kind 1", "t (s)"],
    );
}

#[test]
fn a_pixel_has_the_colour_of_its_events() {
    let page = raster(&view::draw(&small(), &look(View::Frame)).unwrap(), 2);
    let count = |ink: Rgb<u8>| page.pixels().filter(|p| **p == ink).count();
    // Panels are 360 points wide: 90 pixels for each of the sensor's, and a patch of the legend.
    assert_eq!(count(ink::ON), 90 * 90 + 24 * 24);
    // The lower left corner: one event, pale.
    let pale = *page.get_pixel(48 + 45, 2 * 374 - 45);
    assert!(
        pale.0[0] > pale.0[2] && pale != ink::OFF && pale != ink::EMPTY,
        "{pale:?}"
    );
}

#[test]
fn png_and_svg_are_of_one_page() {
    let folder = tempfile::tempdir().unwrap();
    for view in VIEWS {
        let drawing = view::draw(&small(), &look(view)).unwrap();
        let [png, svg] = ["a.png", "a.SVG"].map(|name| folder.path().join(name));
        write_drawing(&png, &drawing).unwrap();
        write_drawing(&svg, &drawing).unwrap();
        let (width, height) = drawing.size();
        let picture = image::open(&png).unwrap().into_rgb8();
        assert_eq!(
            picture.dimensions(),
            (2 * width.ceil() as u32, 2 * height.ceil() as u32)
        );
        let text = fs::read_to_string(&svg).unwrap();
        assert!(text.starts_with(&format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\""
        )));
        assert!(text.ends_with("</svg>\n"));
        assert!(
            text.contains(">a &lt;title&gt; &amp; more</text>"),
            "{view:?}"
        );
        let written = text.matches("<text ").count();
        assert_eq!(written, drawing.texts().count(), "{view:?}");
    }
}

/// A packet that may be empty, of one pixel, or of one moment.
fn any_packet() -> impl Strategy<Value = Packet> {
    (1..40_usize, 1..40_usize, 1..9_u8).prop_flat_map(|(height, width, channels)| {
        let event = (
            prop_oneof![0..3000_u64, Just(u64::MAX / 4)],
            0..width as u16,
            0..height as u16,
            any::<bool>(),
            0..channels,
        );
        (prop::collection::vec(event, 0..60), any::<bool>()).prop_map(move |(mut events, span)| {
            events.sort_unstable();
            let mut packet = Packet::new(Size::new(height, width), channels);
            packet.events = events
                .into_iter()
                .map(|(t, x, y, on, c)| self::event(t, x, y, on, c))
                .collect();
            if span && let Some(last) = packet.events.last() {
                packet.span = (packet.events[0].t, last.t);
            }
            packet
        })
    })
}

/// Without what is embedded, whose letters may spell anything.
fn without_pictures(svg: &str) -> String {
    let mut parts = svg.split("base64,");
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        text.push_str(part.split_once('"').unwrap().1);
    }
    text
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn any_packet_can_be_drawn(packet in any_packet(), at in prop::option::of(any::<u64>())) {
        for view in VIEWS {
            let look = Look { at: at.map(Micros), ..look(view) };
            let drawing = view::draw(&packet, &look).unwrap();
            prop_assert!(raster(&drawing, 1).width() > 300);
            let text = without_pictures(&svg(&drawing));
            prop_assert!(!text.contains("NaN") && !text.contains("inf\""), "{view:?}");
        }
    }
}

#[test]
fn a_sensor_without_pixels_or_with_too_many_is_refused() {
    for view in VIEWS {
        let nothing = view::draw(&Packet::new(Size::new(0, 5), 1), &look(view));
        assert!(matches!(nothing, Err(PictureError::NoPixels(_))));
        let wide = view::draw(&Packet::new(Size::new(1, 1 << 17), 1), &look(view));
        assert!(matches!(wide, Err(PictureError::TooLarge(_))));
    }
}

/// Times of the day would run into what is beside them.
#[test]
fn late_recordings_count_from_their_beginning() {
    const BEGIN: u64 = 1_600_000_000_000_250;
    let mut packet = small();
    for event in &mut packet.events {
        event.t.0 += BEGIN;
    }
    packet.span = (Micros(BEGIN), Micros(BEGIN + 1000));
    for view in VIEWS {
        let said = texts(&view::draw(&packet, &look(view)).unwrap());
        assert!(said.contains("times from 1600000000 s on"), "{said}");
        assert_eq!(said.matches("16000000").count(), 1, "{said}");
    }
}

#[test]
fn animations_show_every_window_once() {
    let folder = tempfile::tempdir().unwrap();
    let packet = small();
    let pages = || view::frames(&packet, "t", Micros(0), Micros(1000), Micros(250)).unwrap();
    let seen: Vec<_> = pages().collect();
    assert_eq!(seen.len(), 4);
    let [gif, apng] = ["a.gif", "a.apng"].map(|name| folder.path().join(name));
    write_frames(&gif, pages(), 0.25).unwrap();
    write_frames(&apng, pages(), 0.25).unwrap();
    let read = |path| std::io::BufReader::new(fs::File::open(path).unwrap());
    let gif = GifDecoder::new(read(&gif)).unwrap().into_frames();
    let apng = PngDecoder::new(read(&apng))
        .unwrap()
        .apng()
        .unwrap()
        .into_frames();
    let gif = gif.collect_frames().unwrap();
    let apng = apng.collect_frames().unwrap();
    assert_eq!((gif.len(), apng.len()), (4, 4));
    for (i, page) in seen.iter().enumerate() {
        assert_eq!(apng[i].delay().numer_denom_ms(), (250, 1));
        assert_eq!(gif[i].delay().numer_denom_ms(), (250, 1));
        for (x, y, ink) in page.enumerate_pixels() {
            let in_apng = apng[i].buffer().get_pixel(x, y).0;
            assert_eq!(in_apng[..3], ink.0);
            let in_gif = gif[i].buffer().get_pixel(x, y).0;
            let near = in_gif.iter().zip(ink.0).all(|(a, b)| a.abs_diff(b) <= 8);
            assert!(near, "frame {i} at {x}, {y}: {in_gif:?} for {ink:?}");
        }
    }
    let none = view::frames(&packet, "t", Micros(5), Micros(5), Micros(250)).unwrap();
    let refused = write_frames(&folder.path().join("b.gif"), none, 0.1);
    assert!(matches!(refused, Err(PictureError::Nothing)));
}
