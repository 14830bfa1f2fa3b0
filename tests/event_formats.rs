//! Every event format gives back the packet that it got: any events within its limits
//! (proptest: ties, vectors, turns of the clock, silence), the edges of those limits, and
//! what lies behind them refused. Damaged and hostile files end in a message with a place,
//! and `salvage` keeps what was good. Whether other people's readers agree is
//! `tests/interop.rs`.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

use amacrine::{
    event::{
        Dropped, Event, Packet, Polarity,
        file::{self, Compression, FileError, Format, Head, Opening, Place, Reader, Writer},
    },
    plane::Size,
    unit::Micros,
};
use miette::Diagnostic;
use proptest::prelude::*;

/// The formats that this build reads and writes.
fn formats() -> impl Iterator<Item = Format> {
    Format::ALL
        .iter()
        .copied()
        .filter(|format| format.is_built())
}

/// Whether a file says all of the packet, and not only its events.
fn says_all(format: Format) -> bool {
    !matches!(
        format,
        Format::Csv | Format::Txt | Format::E2vid | Format::Es
    )
}

/// Steps of time that matter to some format.
fn steps() -> impl Strategy<Value = u64> {
    prop_oneof![
        6 => Just(0),
        3 => 0..130_u64,
        3 => 0..10_000_u64,
        1 => prop_oneof![Just(127_u64), Just(4096), Just(1 << 24), Just(1 << 31), Just(1 << 32)],
        1 => 0..1_u64 << 26,
        1 => 0..1_u64 << 36,
    ]
}

/// Runs along a row, as vectors hold them, and single events.
fn runs() -> impl Strategy<Value = Vec<(u64, u16, u16, bool, u8, u64)>> {
    prop::collection::vec(
        (
            steps(),
            any::<u16>(),
            any::<u16>(),
            any::<bool>(),
            any::<u8>(),
            prop_oneof![Just(1_u64), any::<u64>(), Just(u64::MAX)],
        ),
        0..30,
    )
}

/// A packet that `format` can hold, made of runs.
fn packet(
    format: Format,
    runs: &[(u64, u16, u16, bool, u8, u64)],
    start: u64,
    size: (u16, u16),
    channels: u8,
) -> Packet {
    let limits = format.limits();
    let (width, height) = (
        usize::from(size.0.min(limits.x)) + 1,
        usize::from(size.1.min(limits.y)) + 1,
    );
    let channels = if limits.channels { channels.max(1) } else { 1 };
    let mut packet = Packet::new(Size::new(height, width), channels);
    packet.span = (Micros(start / 2), Micros(start.saturating_add(77)));
    packet.dropped = Dropped {
        no_slot: start % 1000,
        over_limit: start % 7,
        ..Dropped::default()
    };
    // Silence that is written out is slow: not the longest at every try.
    let longest = if limits.silence < u64::MAX {
        1 << 22
    } else {
        u64::MAX
    };
    let mut t = start.min(longest).min(limits.t / 2);
    for (step, x, y, on, channel, pixels) in runs {
        let step = (*step).min(longest);
        if t + step > limits.t {
            break;
        }
        t += step;
        let from = usize::from(*x) % width;
        for bit in (0..64).filter(|bit| (pixels | 1) >> bit & 1 == 1) {
            if from + bit < width {
                packet.events.push(Event {
                    t: Micros(t),
                    x: (from + bit) as u16,
                    y: (usize::from(*y) % height) as u16,
                    polarity: if *on { Polarity::On } else { Polarity::Off },
                    channel: channel % channels,
                });
            }
        }
    }
    packet
}

fn there_and_back(format: Format, compression: Compression, packet: &Packet) -> file::Loaded {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(format!("a.{}", format.name()));
    file::write_as(&path, format, compression, packet).unwrap();
    file::read(&path).unwrap()
}

fn same(format: Format, packet: &Packet, loaded: &file::Loaded) -> Result<(), TestCaseError> {
    prop_assert_eq!(&loaded.packet.events, &packet.events, "{}", format);
    prop_assert_eq!(loaded.skipped, 0, "{}", format);
    if says_all(format) {
        prop_assert!(loaded.size_known && loaded.channels_known, "{}", format);
        prop_assert_eq!(&loaded.packet, packet, "{}", format);
    } else if matches!(format, Format::Es | Format::E2vid) {
        prop_assert_eq!(loaded.packet.size, packet.size);
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(if cfg!(debug_assertions) { 30 } else { 100 }))]

    #[test]
    fn every_format_gives_back_the_packet(
        runs in runs(),
        start in prop_oneof![Just(0_u64), 0..1_u64 << 20, 0..1_u64 << 33, any::<u64>()],
        size in (any::<u16>(), any::<u16>()),
        channels in any::<u8>(),
    ) {
        for format in formats() {
            // Each turn of a clock costs words: not the longest times at every try.
            let start = start.min(1 << 38);
            let packet = packet(format, &runs, start, size, channels);
            same(format, &packet, &there_and_back(format, Compression::Lz4, &packet))?;
        }
        for compression in [Compression::Zstd, Compression::None] {
            let packet = packet(Format::Aedat4, &runs, start, size, 1);
            same(Format::Aedat4, &packet, &there_and_back(Format::Aedat4, compression, &packet))?;
        }
    }

    /// Whatever is in a file, reading it ends in a packet or in a message, and what stands
    /// before the damage is what was written.
    #[test]
    fn damage_is_a_message_with_a_place(
        runs in runs(),
        damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
        cut in any::<prop::sample::Index>(),
    ) {
        let folder = tempfile::tempdir().unwrap();
        for format in formats() {
            let packet = packet(format, &runs, 1000, (345, 259), 3);
            let path = folder.path().join(format!("a.{}", format.name()));
            file::write_as(&path, format, Compression::Lz4, &packet).unwrap();
            let whole = fs::read(&path).unwrap();
            if whole.is_empty() { continue; }
            let mut damaged = whole.clone();
            for (at, byte) in &damage {
                damaged[at.index(whole.len())] = *byte;
            }
            let opening = Opening { format: Some(format), ..Opening::default() };
            for bytes in [damaged, whole[..cut.index(whole.len())].to_vec()] {
                let cut_short = bytes.len() < whole.len();
                let length = bytes.len() as u64;
                match Reader::of_bytes(&path, bytes, &opening).map(file::all) {
                    Ok((loaded, error)) => {
                        if let Some(error) = error {
                            placed(&error, length)?;
                        }
                        if cut_short {
                            let events = &loaded.packet.events;
                            // A number cut short is another number, so text may end in one.
                            let sure = match format {
                                Format::Csv | Format::Txt | Format::E2vid => events.len().saturating_sub(1),
                                _ => events.len(),
                            };
                            prop_assert_eq!(&events[..sure], &packet.events[..sure], "{}", format);
                        }
                    }
                    Err(error) => placed(&error, length)?,
                }
            }
        }
    }

    /// Bytes that were never an event file.
    #[test]
    fn noise_is_refused_or_read(
        noise in prop::collection::vec(any::<u8>(), 0..600),
        head in 0..6_usize,
    ) {
        let heads: [&[u8]; 6] = [
            b"", b"% end\n", b"#!AER-DAT2.0\r\n", b"#!AER-DAT3.1\r\n#!END-HEADER\r\n",
            b"#!AER-DAT4.0\r\n", b"Event Stream\x02\0\0\x01\xff\0\xff\0",
        ];
        let bytes = [heads[head], &noise[..]].concat();
        for format in formats() {
            let opening = Opening { format: Some(format), ..Opening::default() };
            if let Ok(reader) = Reader::of_bytes(Path::new("noise"), bytes.clone(), &opening) {
                let (loaded, _) = file::all(reader);
                prop_assert!(loaded.packet.events.windows(2).all(|w| w[0].t <= w[1].t));
            }
        }
    }
}

/// Found by the fuzzer: 928 bytes whose dictionaries are said to have billions of values.
#[cfg(feature = "parquet")]
#[test]
fn no_room_is_made_for_values_that_are_not_there() {
    let file = Path::new("tests/data/event/long_dictionary.parquet");
    let opening = Opening {
        format: Some(Format::Parquet),
        ..Opening::default()
    };
    let reader = Reader::of_bytes(file, fs::read(file).unwrap(), &opening).unwrap();
    let (_, fault) = file::all(reader);
    let fault = fault.unwrap().to_string();
    assert!(fault.contains("more values than bytes"), "{fault}");
}

/// A message has a place inside of the file, and advice.
fn placed(error: &FileError, length: u64) -> Result<(), TestCaseError> {
    prop_assert!(error.help().is_some(), "{}", error);
    match error {
        FileError::Bad { place, .. } => {
            if let Place::Byte(at) = place {
                prop_assert!(*at <= length, "{}", error);
            }
        }
        FileError::Unreadable { .. } => (),
        other => prop_assert!(false, "{other}"),
    }
    Ok(())
}

fn event(t: u64, x: u16, y: u16, on: bool) -> Event {
    Event {
        t: Micros(t),
        x,
        y,
        polarity: if on { Polarity::On } else { Polarity::Off },
        channel: 0,
    }
}

#[test]
fn empty_and_single() {
    for format in formats() {
        let mut packet = Packet::new(Size::new(260, 346), 1);
        packet.span = (Micros(3), Micros(9));
        same(
            format,
            &packet,
            &there_and_back(format, Compression::Lz4, &packet),
        )
        .unwrap();
        packet.events.push(event(5, 345, 259, true));
        same(
            format,
            &packet,
            &there_and_back(format, Compression::Lz4, &packet),
        )
        .unwrap();
    }
}

/// The largest address and the latest time go through, one more does not.
#[test]
fn the_edges_of_every_format() {
    let folder = tempfile::tempdir().unwrap();
    for format in formats() {
        let limits = format.limits();
        let size = Size::new(usize::from(limits.y) + 1, usize::from(limits.x) + 1);
        let path = folder.path().join(format!("a.{}", format.name()));
        let mut packet = Packet::new(size, 1);
        packet.span = (Micros(0), Micros(1));
        let latest = limits.t.min(limits.silence);
        packet.events = vec![
            event(0, 0, 0, false),
            event(latest, limits.x, limits.y, true),
        ];
        same(
            format,
            &packet,
            &there_and_back(format, Compression::Lz4, &packet),
        )
        .unwrap();

        let refused = |events: Vec<Event>, size| {
            let packet = Packet {
                events,
                size,
                ..packet.clone()
            };
            let error = file::write_as(&path, format, Compression::Lz4, &packet).unwrap_err();
            assert!(matches!(error, FileError::Unwritable { .. }), "{error}");
            assert!(error.help().is_some());
            assert!(!path.exists(), "{format} left something behind");
        };
        let first = event(0, 0, 0, true);
        refused(vec![first, event(latest + 1, 0, 0, true)], size);
        let wider = Size::new(size.height, size.width + 1);
        if let Some(x) = limits.x.checked_add(1) {
            refused(vec![event(1, x, 0, true)], wider);
        }
        if let Some(y) = limits.y.checked_add(1) {
            refused(
                vec![event(1, 0, y, true)],
                Size::new(size.height + 1, size.width),
            );
        }
        if !limits.channels {
            let several = Packet {
                channels: 2,
                ..packet.clone()
            };
            let error = file::write_as(&path, format, Compression::Lz4, &several).unwrap_err();
            let says = format!(".{format} stores no kinds");
            assert!(error.to_string().contains(&says), "{error}");
        }
    }
}

/// Turns of the clocks: EVT2 after 2^34 us, EVT3 after 2^24, AEDAT3 after 2^31.
#[test]
fn turns_of_the_clock() {
    for format in [Format::Evt2, Format::Evt21, Format::Evt3, Format::Aedat3] {
        for turn in [1_u64 << 24, 1 << 31, 1 << 34] {
            let mut packet = Packet::new(Size::new(4, 2048), 1);
            for around in [
                turn - 4097,
                turn - 4096,
                turn - 64,
                turn - 1,
                turn,
                turn + 1,
                turn + 63,
            ] {
                for x in 0..20 {
                    packet.events.push(event(around, x, 1, true));
                }
            }
            for more in 1..4 {
                packet
                    .events
                    .push(event(turn * more + (turn - 1), 2047, 3, false));
                packet.events.push(event(turn * (more + 1), 2047, 3, false));
            }
            packet.span = (Micros(0), Micros(1));
            same(
                format,
                &packet,
                &there_and_back(format, Compression::Lz4, &packet),
            )
            .unwrap();
        }
    }
}

/// Memory does not follow what a file promises.
#[test]
fn promises_cost_nothing() {
    let cases: [(Format, Vec<u8>); 4] = [
        (
            Format::Aedat4,
            [&b"#!AER-DAT4.0\r\n"[..], &[0xFF, 0xFF, 0xFF, 0x03]].concat(),
        ),
        (
            Format::Aedat3,
            [
                &b"#!AER-DAT3.1\r\n#!END-HEADER\r\n\x01\0\x01\0\x08\0\0\0\x04\0\0\0\0\0\0\0"[..],
                &[0xFF; 12],
            ]
            .concat(),
        ),
        (
            Format::Aedat3,
            [
                &b"#!AER-DAT3.1\r\n#!END-HEADER\r\n\x02\0\x01\0\0\0\0\0\x04\0\0\0\0\0\0\0"[..],
                &[0xFF; 12],
            ]
            .concat(),
        ),
        (Format::Evt3, [b"% ".to_vec(), vec![b'x'; 1 << 20]].concat()),
    ];
    for (format, bytes) in cases {
        let opening = Opening {
            format: Some(format),
            ..Opening::default()
        };
        let read = Reader::of_bytes(Path::new("promise"), bytes, &opening).map(file::all);
        let error = match read {
            Ok((loaded, error)) => {
                assert!(loaded.packet.events.is_empty());
                error
            }
            Err(error) => Some(error),
        };
        assert!(error.is_some(), "{format}");
    }
}

/// Words that no writer of ours writes: vectors of eight, triggers, what comes before the
/// first time, the reader's own upper parts.
#[test]
fn words_of_cameras() {
    let read = |format, text: &str, words: &[u8]| {
        let opening = Opening {
            format: Some(format),
            ..Opening::default()
        };
        let bytes = [text.as_bytes(), words].concat();
        let reader = Reader::of_bytes(Path::new("camera"), bytes, &opening).unwrap();
        let (loaded, error) = file::all(reader);
        assert!(error.is_none(), "{error:?}");
        loaded
    };
    let words = |words: &[u16]| -> Vec<u8> { words.iter().flat_map(|w| w.to_le_bytes()).collect() };
    let header = "% date 2024-01-01\n% geometry 640x480\n% end\n";
    let evt3 = [
        0x2001, 0x3002, 0x4FFF, // an event and a vector before any time: 13 left out
        0x8001, 0x6005, 0x0007, // 4101 us, row 7
        0x3810, 0x5081, 0x4001, // ON from column 16: 16, 23, and 12 later 24
        0xA000, 0x7001, 0xE000, 0xF000, // a trigger, others: left out
        0x2009, // OFF at column 9
    ];
    let loaded = read(Format::Evt3, header, &words(&evt3));
    assert_eq!(
        loaded.packet.events,
        [
            event(4101, 16, 7, true),
            event(4101, 23, 7, true),
            event(4101, 24, 7, true),
            event(4101, 9, 7, false)
        ]
    );
    assert_eq!(
        (loaded.packet.size, loaded.skipped),
        (Size::new(480, 640), 15)
    );

    // The two halves of a word exchanged.
    let word: u64 = 0x8000_0001_0000_0000;
    let pixels: u64 = 1 << 60 | 3 << 54 | 32 << 43 | 5 << 32 | 0x8000_0001;
    let legacy: Vec<u8> = [word, pixels]
        .iter()
        .flat_map(|w| w.rotate_left(32).to_le_bytes())
        .collect();
    for header in [
        "% format EVT21;endianness=legacy\n% end\n",
        "% format EVT21\n% endianness legacy\n% end\n",
    ] {
        let loaded = read(Format::Evt21, header, &legacy);
        assert_eq!(
            loaded.packet.events,
            [event(67, 32, 5, true), event(67, 63, 5, true)],
            "{header}"
        );
    }
    // Of the others nobody has said what that would be.
    for format in [Format::Evt2, Format::Evt3] {
        let opening = Opening {
            format: Some(format),
            ..Opening::default()
        };
        let bytes = b"% endianness legacy\n% end\n".to_vec();
        let refused = Reader::of_bytes(Path::new("camera"), bytes, &opening).map(|_| ());
        let error = refused.unwrap_err().to_string();
        assert!(error.contains("legacy-endian"), "{format}: {error}");
    }

    let dat1 = [
        b"\x00\x08".to_vec(),
        ((300_u64 + (200 << 9) + (1 << 17)) << 32 | 7)
            .to_le_bytes()
            .to_vec(),
    ]
    .concat();
    let loaded = read(Format::Dat, "% Data file\n% Version 1\n", &dat1);
    assert_eq!(loaded.packet.events, [event(7, 300, 200, true)]);
}

/// Readers of AEDAT2 take lines that start with `#` for comments; so may an event.
#[test]
fn a_first_event_that_looks_like_a_comment() {
    for y in 136..150 {
        let mut packet = Packet::new(Size::new(260, 346), 1);
        packet.events = vec![
            event(0x0A0A_0A0A, 20, y, true),
            event(0x0A0A_0A0B, 1, y, false),
        ];
        packet.span = (Micros(0), Micros(1));
        let loaded = there_and_back(Format::Aedat2, Compression::Lz4, &packet);
        same(Format::Aedat2, &packet, &loaded).unwrap();
    }
}

/// The first event of a file without `% end` may begin with the byte of a comment.
#[test]
fn a_first_event_that_begins_like_a_header() {
    for format in [Format::Evt2, Format::Evt21, Format::Evt3] {
        for step in 0..64 {
            let mut packet = Packet::new(Size::new(260, 346), 1);
            // The upper part of the time ends in the byte of `%`; later words have that of a line's end.
            let first = if format == Format::Evt3 {
                0x25 << 12
            } else {
                0x25 << 6
            };
            packet.events = (0..400)
                .map(|i| event(first + i / 50 + step, (i % 256) as u16, 10, i % 3 == 0))
                .collect();
            packet.span = (packet.events[0].t, packet.events[399].t);
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("a.raw");
            file::write_as(&path, format, Compression::Lz4, &packet).unwrap();
            let bytes = std::fs::read(&path).unwrap();
            let end = b"% end\n";
            let at = bytes.windows(end.len()).position(|it| it == end).unwrap();
            let mut bare = format!("% evt {}\n", &format.name()[3..]).into_bytes();
            bare.extend_from_slice(&bytes[at + end.len()..]);
            std::fs::write(&path, bare).unwrap();
            let read = file::read(&path).unwrap().packet;
            assert_eq!(read.events, packet.events, "{format} {step}");
        }
    }
}

/// A format, what is done to its file, how many of the three events are kept, and what is said.
type Damage = (Format, Compression, fn(&mut Vec<u8>), usize, &'static str);

/// The last bytes off.
fn cut<const N: usize>(bytes: &mut Vec<u8>) {
    bytes.truncate(bytes.len() - N);
}

const DAMAGE: [Damage; 18] = [
    (
        Format::Evt2,
        Compression::Lz4,
        cut::<1>,
        2,
        "in the middle of an event",
    ),
    (
        Format::Evt21,
        Compression::Lz4,
        cut::<3>,
        2,
        "in the middle of an event",
    ),
    (
        Format::Evt3,
        Compression::Lz4,
        cut::<1>,
        2,
        "in the middle of an event",
    ),
    (
        Format::Dat,
        Compression::Lz4,
        cut::<1>,
        2,
        "in the middle of an event",
    ),
    (
        Format::Aedat2,
        Compression::Lz4,
        cut::<1>,
        2,
        "in the middle of an event",
    ),
    (
        Format::Aedat3,
        Compression::Lz4,
        cut::<1>,
        2,
        "in the middle of an event",
    ),
    (
        Format::Es,
        Compression::Lz4,
        cut::<1>,
        2,
        "in the middle of an event",
    ),
    (
        Format::Npz,
        Compression::Lz4,
        cut::<1>,
        0,
        "cannot be read as an archive",
    ),
    (
        Format::Evt2,
        Compression::Lz4,
        |b| {
            let n = b.len();
            b[n - 1] = 0x50;
        },
        2,
        "a word of kind 5, which evt2 does not have",
    ),
    (
        Format::Evt2,
        Compression::Lz4,
        |b| {
            // The time of the last event back to 192.
            let n = b.len();
            let word = u32::from_le_bytes(b[n - 4..].try_into().unwrap()) & !(0x3F << 22);
            b[n - 4..].copy_from_slice(&word.to_le_bytes());
        },
        2,
        "time runs backwards: 192 us comes after 200 us",
    ),
    (
        Format::Dat,
        Compression::Lz4,
        |b| {
            let n = b.len();
            b[n - 1] = 0x70;
        },
        2,
        "`p` should be 1 for ON, 0 or -1 for OFF, found 7",
    ),
    (
        Format::Es,
        Compression::Lz4,
        |b| {
            let n = b.len();
            b[n - 1] = 9;
        },
        2,
        "is off the sensor, which is 640x480",
    ),
    (
        Format::Es,
        Compression::Lz4,
        |b| b[0] = b'e',
        0,
        "the es file does not start with `Event Stream`",
    ),
    (
        Format::Es,
        Compression::Lz4,
        |b| b[15] = 2,
        0,
        "holds events of kind 2",
    ),
    (
        Format::Dat,
        Compression::Lz4,
        |b| b.retain(|c| *c != b'%'),
        0,
        "holds records of kind",
    ),
    (
        Format::Aedat4,
        Compression::None,
        |b| {
            let at = b.windows(4).position(|w| w == b"EVTS").unwrap();
            let at = at + b[at + 4..].windows(4).position(|w| w == b"EVTS").unwrap() + 4;
            b[at + 20] = 0xFF;
        },
        0,
        "has a packet that cannot be read",
    ),
    (
        Format::Aedat4,
        Compression::Lz4,
        |b| {
            let at = b.windows(6).position(|w| w == b"</dv>\n").unwrap();
            let at = b[at + 6..].iter().position(|c| *c != 0).unwrap() + at + 6;
            b[at + 4 + 30] ^= 0xFF;
        },
        0,
        "cannot be decompressed",
    ),
    (
        Format::Aedat4,
        Compression::Lz4,
        |b| b[13] = b'!',
        0,
        "does not start with `#!AER-DAT4.0",
    ),
];

#[test]
fn damage_has_its_message() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a");
    let mut packet = Packet::new(Size::new(480, 640), 1);
    packet.span = (Micros(0), Micros(99));
    packet.events = vec![
        event(100, 1, 2, true),
        event(200, 3, 4, false),
        event(200, 639, 479, true),
    ];
    for (format, compression, change, wanted, says) in DAMAGE {
        file::write_as(&path, format, compression, &packet).unwrap();
        let mut bytes = fs::read(&path).unwrap();
        change(&mut bytes);
        fs::write(&path, bytes).unwrap();
        let opening = Opening {
            format: Some(format),
            ..Opening::default()
        };
        let (kept, error) = match file::salvage(&path, &opening) {
            Ok((loaded, error)) => (loaded.packet.events, error.expect("damage is seen")),
            Err(error) => (Vec::new(), error),
        };
        let said = error.to_string();
        assert!(said.contains(says), "{format}: {said}");
        assert_eq!(kept, packet.events[..wanted], "{format}: {said}");
        let start = format!("{}: byte ", path.display());
        assert!(said.starts_with(&start), "{format}: {said}");
    }
}

/// The byte that is named is that of the event, however many went before.
#[test]
fn the_place_is_that_of_the_event() {
    let folder = tempfile::tempdir().unwrap();
    let events: Vec<Event> = (0..50_000_u64)
        .map(|i| event(i / 3, (i % 640) as u16, (i / 640 % 480) as u16, i % 2 == 0))
        .collect();
    let mut packet = Packet::new(Size::new(480, 640), 1);
    packet.events = events;
    for (format, bytes) in [
        (Format::Evt2, 4),
        (Format::Dat, 8),
        (Format::Aedat2, 8),
        (Format::Npy, 13),
        (Format::Es, 5),
        (Format::Aedat3, 8),
    ] {
        let path = folder.path().join("a");
        file::write_as(&path, format, Compression::default(), &packet).unwrap();
        let whole = fs::read(&path).unwrap();
        // The last event goes off the sensor: the only one, and its place is known.
        let mut damaged = whole.clone();
        let at = whole.len() - bytes;
        // Bytes of its coordinates.
        let (from, to) = match format {
            Format::Evt2 => (0, 2),
            Format::Dat => (4, 6),
            Format::Aedat2 => (0, 1),
            Format::Npy => (9, 10),
            Format::Es => (2, 3),
            _ => (3, 4),
        };
        for byte in &mut damaged[at + from..at + to] {
            *byte |= 0x7F;
        }
        let opening = Opening {
            format: Some(format),
            ..Opening::default()
        };
        let reader = Reader::of_bytes(Path::new("a"), damaged, &opening).unwrap();
        let (loaded, error) = file::all(reader);
        assert_eq!(loaded.packet.events.len(), 49_999, "{format}");
        match error {
            Some(FileError::Bad { place, .. }) => {
                assert_eq!(place, Place::Byte(at as u64), "{format}");
            }
            other => panic!("{format}: {other:?}"),
        }
    }
}

/// Writing is whole or not at all, and block after block is the same as at once.
#[test]
fn blocks_and_the_whole_are_the_same_file() {
    let folder = tempfile::tempdir().unwrap();
    let mut packet = Packet::new(Size::new(480, 640), 1);
    packet.events = (0..30_000_u64)
        .map(|i| {
            event(
                i * i / 100,
                (i * 7 % 640) as u16,
                (i / 9 % 480) as u16,
                i % 2 == 0,
            )
        })
        .collect();
    packet.span = (Micros(0), Micros(10_000_000));
    for format in formats() {
        let names: BTreeSet<PathBuf> = (0..2).map(|n| folder.path().join(format!("{n}"))).collect();
        let mut files = names.iter();
        let (whole, parts) = (files.next().unwrap(), files.next().unwrap());
        file::write_as(whole, format, Compression::Lz4, &packet).unwrap();
        let mut writer =
            Writer::create(parts, format, Compression::Lz4, &Head::from_packet(&packet)).unwrap();
        for events in packet.events.chunks(777) {
            writer.put(events).unwrap();
            assert!(!parts.exists());
        }
        assert_eq!(writer.finish().unwrap(), 30_000);
        let opening = Opening {
            format: Some(format),
            ..Opening::default()
        };
        assert_eq!(
            file::read_as(parts, &opening).unwrap(),
            file::read_as(whole, &opening).unwrap(),
            "{format}"
        );
        fs::remove_file(whole).unwrap();
        fs::remove_file(parts).unwrap();
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}
