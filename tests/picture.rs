//! Pictures that are written are pictures that other readers open, and show what the packets
//! hold: the pixels of a sheet and of an animation against the inks that they should have.

use std::{fs, io::Cursor, path::Path};

use amacrine::{
    event::{Event, Packet, Polarity},
    picture::{Moment, PictureError, Show, contact_sheet, ink, write_animation, write_png},
    plane::{Plane, Size},
    unit::Micros,
};
use image::{AnimationDecoder, Rgb, codecs::gif::GifDecoder};

const STEP: u64 = 33_000;

/// A bright disc crosses a striped ground; its rim speaks, ON ahead and OFF behind. The
/// judged packet loses one event in ten, gains some, and has some of the wrong sign.
fn disc(side: u16, frames: u64) -> (Packet, Packet, Vec<Moment>) {
    let size = Size::new(side.into(), side.into());
    let [mut reference, mut judged] = [Packet::new(size, 1), Packet::new(size, 1)];
    let mut moments: Vec<Moment> = Vec::new();
    let half = f64::from(side) / 2.0;
    let light = |n: u64| {
        let centre = (n as f64 + 0.5) / frames as f64 * 2.0 * half;
        Plane::from_shape_fn(size.shape(), |(y, x)| {
            let far = (x as f64 - centre).hypot(y as f64 - half);
            let stripes = 60.0 + 30.0 * (x as f64 / half * 12.0).sin();
            if far < half / 2.0 { 220.0 } else { stripes }
        })
    };
    for n in 1..=frames {
        let (before, now) = (light(n - 1), light(n));
        for ((y, x), value) in now.indexed_iter() {
            let step = value - before[[y, x]];
            if step == 0.0 {
                continue;
            }
            let polarity = if step > 0.0 {
                Polarity::On
            } else {
                Polarity::Off
            };
            let event = Event {
                t: Micros(n * STEP),
                x: x as u16,
                y: y as u16,
                polarity,
                channel: 0,
            };
            reference.events.push(event);
            match (x * 31 + y * 17 + n as usize) % 20 {
                0 | 1 => (),
                2 => judged.events.push(Event {
                    polarity: Polarity::On,
                    ..event
                }),
                3 => judged.events.extend([
                    event,
                    Event {
                        y: (event.y + 3) % side,
                        ..event
                    },
                ]),
                _ => judged.events.push(event),
            }
        }
        moments.push(Moment {
            from: Micros((n - 1) * STEP),
            to: Micros(n * STEP),
            frame: now,
        });
    }
    (reference, judged, moments)
}

fn show<'a>(reference: &'a Packet, judged: &'a Packet) -> Show<'a> {
    Show {
        title: "A disc crosses a striped ground",
        reference: ("float reference", reference),
        device: ("SCAMP-5, one event in ten lost", judged),
    }
}

/// Kept after the test, to be looked at.
fn folder() -> &'static Path {
    Path::new(env!("CARGO_TARGET_TMPDIR"))
}

#[test]
fn a_sheet_shows_both_packets_and_their_difference() {
    let (reference, judged, moments) = disc(64, 12);
    let chosen = [moments[2].clone(), moments[6].clone()];
    let sheet = contact_sheet(&show(&reference, &judged), &chosen).unwrap();
    let path = folder().join("sheet.png");
    write_png(&path, &sheet).unwrap();
    assert_eq!(image::open(&path).unwrap().to_rgb8(), sheet);

    // A pixel of the sensor is a square of 4 by 4, so inks come in sixteens; the legend has
    // squares of 12 by 12 beside.
    let drawn = |ink: Rgb<u8>| (sheet.pixels().filter(|p| **p == ink).count() - 144) / 16;
    let seen = |packet: &Packet, polarity: Polarity| {
        let mut at: Vec<_> = packet
            .events
            .iter()
            .filter(|e| chosen.iter().any(|m| m.from < e.t && e.t <= m.to))
            .filter(|e| e.polarity == polarity)
            .map(|e| (e.t, e.x, e.y))
            .collect();
        at.sort_unstable();
        at.dedup();
        at.len()
    };
    let on = seen(&reference, Polarity::On) + seen(&judged, Polarity::On);
    let off = seen(&reference, Polarity::Off) + seen(&judged, Polarity::Off);
    // Where a judged pixel spoke with both signs the later one covers the other.
    assert!(drawn(ink::ON) <= on && drawn(ink::ON) + 20 > on, "{on}");
    assert!(
        drawn(ink::OFF) <= off && drawn(ink::OFF) + 20 > off,
        "{off}"
    );
    for ink in [ink::MISSING, ink::EXTRA, ink::SWAPPED] {
        assert!(drawn(ink) > 5, "{ink:?}");
    }
}

#[test]
fn identical_packets_differ_nowhere() {
    let (reference, _, moments) = disc(64, 6);
    let sheet = contact_sheet(&show(&reference, &reference), &moments).unwrap();
    for ink in [ink::MISSING, ink::EXTRA] {
        let legend_only = sheet.pixels().filter(|p| **p == ink).count();
        assert_eq!(legend_only, 144);
    }
}

#[test]
fn an_animation_shows_each_moment_and_loops() {
    let (reference, judged, moments) = disc(64, 12);
    let path = folder().join("disc.gif");
    write_animation(&path, &show(&reference, &judged), &moments, 0.1).unwrap();
    let bytes = fs::read(&path).unwrap();
    let looping = bytes.windows(11).any(|w| w == b"NETSCAPE2.0");
    assert!(looping);
    let decoder = GifDecoder::new(Cursor::new(&bytes)).unwrap();
    let frames = decoder.into_frames().collect_frames().unwrap();
    assert_eq!(frames.len(), 12);
    for (frame, moment) in frames.iter().zip(&moments) {
        let page = contact_sheet(&show(&reference, &judged), std::slice::from_ref(moment)).unwrap();
        assert_eq!(frame.buffer().dimensions(), page.dimensions());
        assert_eq!(frame.delay().numer_denom_ms(), (100, 1));
        // The gray scale of one moment is not that of all, so the frame panel is left out.
        for (x, y, shown) in frame.buffer().enumerate_pixels().filter(|(x, ..)| *x > 300) {
            let wanted = page.get_pixel(x, y);
            let far = (0..3)
                .map(|i| shown.0[i].abs_diff(wanted.0[i]))
                .max()
                .unwrap();
            assert!(far <= 14, "x {x} y {y}: {shown:?} for {wanted:?}");
        }
    }
}

#[test]
fn what_cannot_be_shown_is_refused() {
    let (reference, judged, moments) = disc(16, 3);
    let show_it = show(&reference, &judged);
    assert!(matches!(
        contact_sheet(&show_it, &[]),
        Err(PictureError::Nothing)
    ));
    let mut other = moments[0].clone();
    other.frame = Plane::zeros((16, 17));
    let refused = contact_sheet(&show_it, &[other]).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "the frame is 17x16, the sensor is 16x16"
    );
    let many = vec![moments[0].clone(); 300];
    assert!(matches!(
        contact_sheet(&show_it, &many),
        Err(PictureError::TooLarge(_))
    ));
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml/a.gif");
    let refused = write_animation(&path, &show_it, &moments, 0.1).unwrap_err();
    assert!(refused.to_string().contains("a.gif"));
}
