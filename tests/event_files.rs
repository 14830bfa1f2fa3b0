//! Event files of text and numpy: what is written is read back (proptest), the bytes are the
//! ones promised, and each damaged file in `tests/bad/event/` gets one message with its place.
//! The other formats are in
//! `tests/event_formats.rs`; whether other people's readers agree is in `tests/python_readers.rs`.

use std::{fs, path::Path};

use amacrine::{
    event::{
        Dropped, Event, Packet, Polarity,
        file::{self, FileError, Format, Loaded},
    },
    plane::Size,
    unit::Micros,
};
use miette::Diagnostic;
use ndarray::arr1;
use ndarray_npy::WriteNpyExt as _;
use proptest::prelude::*;
use zip::{ZipWriter, write::SimpleFileOptions};

/// A packet of any size, clock and number of channels that all formats can hold.
fn packets(channels: impl Strategy<Value = u8>) -> impl Strategy<Value = Packet> {
    let time = prop_oneof![0..1000_u64, 0..1_u64 << 40, 0..=i64::MAX.unsigned_abs()];
    let events = prop::collection::vec((time, any::<(u16, u16, bool, u8)>()), 0..60);
    let rest = (1..=32768_usize, 1..=32768_usize, any::<[u64; 4]>());
    (channels, events, rest).prop_map(|(channels, mut events, (height, width, more))| {
        events.sort_unstable();
        let mut packet = Packet::new(Size::new(height, width), channels);
        packet.span = (Micros(more[0]), Micros(more[1]));
        packet.dropped = Dropped {
            no_slot: more[2],
            over_limit: more[3],
            ..Dropped::default()
        };
        packet.events = events
            .into_iter()
            .map(|(t, (x, y, on, channel))| Event {
                t: Micros(t),
                x: (usize::from(x) % width) as u16,
                y: (usize::from(y) % height) as u16,
                polarity: if on { Polarity::On } else { Polarity::Off },
                channel: channel % channels,
            })
            .collect();
        packet
    })
}

fn there_and_back(packet: &Packet, name: &str) -> Loaded {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    file::write(&path, packet).unwrap();
    file::read(&path).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn npy_gives_back_the_packet(packet in packets(1..=255_u8)) {
        let loaded = there_and_back(&packet, "a.npy");
        prop_assert!(loaded.size_known && loaded.channels_known);
        prop_assert_eq!(loaded.packet, packet);
    }

    #[test]
    fn csv_gives_back_the_events_and_with_a_comment_the_packet(packet in packets(1..=255_u8)) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        file::write(&path, &packet).unwrap();
        let bare = file::read(&path).unwrap();
        prop_assert!(!bare.size_known && !bare.channels_known);
        prop_assert_eq!(&bare.packet.events, &packet.events);
        prop_assert!(bare.packet.size.width <= packet.size.width);

        let comment = format!(
            "# amacrine size={} channels={} span={}..{} dropped={},{}\n",
            packet.size, packet.channels, packet.span.0.0, packet.span.1.0,
            packet.dropped.no_slot, packet.dropped.over_limit
        );
        fs::write(&path, comment + &fs::read_to_string(&path).unwrap()).unwrap();
        prop_assert_eq!(file::read(&path).unwrap().packet, packet);
    }

    #[test]
    fn txt_gives_back_the_events(packet in packets(Just(1_u8))) {
        prop_assert_eq!(there_and_back(&packet, "a.txt").packet.events, packet.events);
    }

    /// Whatever is in a file, reading it ends in a packet or in a message.
    #[test]
    fn no_file_makes_a_reader_panic(
        packet in packets(1..=3_u8),
        cut in any::<prop::sample::Index>(),
        at in any::<prop::sample::Index>(),
        byte in any::<u8>(),
    ) {
        let folder = tempfile::tempdir().unwrap();
        for format in [Format::Csv, Format::Txt, Format::Npy] {
            let path = folder.path().join("a").with_extension(format.extension());
            let single = Packet { channels: 1, events: vec![], ..packet.clone() };
            let packet = if format == Format::Txt { &single } else { &packet };
            file::write(&path, packet).unwrap();
            let whole = fs::read(&path).unwrap();
            if whole.is_empty() { continue; }
            let mut damaged = whole.clone();
            damaged[at.index(whole.len())] = byte;
            fs::write(&path, damaged).unwrap();
            let _ = file::read(&path);
            let cut = cut.index(whole.len());
            fs::write(&path, &whole[..cut]).unwrap();
            let shortened = file::read(&path);
            if format == Format::Npy {
                prop_assert!(shortened.is_err(), "cut at byte {}", cut);
            }
        }
    }
}

fn three_events() -> Packet {
    let mut packet = Packet::new(Size::new(4, 6), 1);
    packet.events = [(0, 1, 0, 1), (1_500_000, 5, 3, 0), (1_500_000, 0, 2, 1)]
        .map(|(t, x, y, p)| Event {
            t: Micros(t),
            x,
            y,
            polarity: if p == 1 { Polarity::On } else { Polarity::Off },
            channel: 0,
        })
        .to_vec();
    packet
}

#[test]
fn the_bytes_are_the_promised_ones() {
    let folder = tempfile::tempdir().unwrap();
    let text = |name: &str, packet: &Packet| {
        let path = folder.path().join(name);
        file::write(&path, packet).unwrap();
        fs::read_to_string(&path).unwrap()
    };
    let mut packet = three_events();
    assert_eq!(
        text("a.csv", &packet),
        "t,x,y,p\n0,1,0,1\n1500000,5,3,0\n1500000,0,2,1\n"
    );
    assert_eq!(
        text("a.txt", &packet),
        "0.000000000 1 0 1\n1.500000000 5 3 0\n1.500000000 0 2 1\n"
    );
    packet.channels = 2;
    packet.events[1].channel = 1;
    assert_eq!(
        text("a.CSV", &packet),
        "t,x,y,p,channel\n0,1,0,1,0\n1500000,5,3,0,1\n1500000,0,2,1,0\n"
    );
    let path = folder.path().join("a.npy");
    file::write(&path, &packet).unwrap();
    let npy = fs::read(&path).unwrap();
    assert_eq!(&npy[..8], b"\x93NUMPY\x01\x00");
    let end = npy.iter().position(|b| *b == b'\n').unwrap() + 1;
    assert_eq!(end % 64, 0);
    assert_eq!(npy.len() - end, 3 * 14);
    assert_eq!(
        &npy[end + 14..][..14],
        b"\x60\xe3\x16\0\0\0\0\0\x05\0\x03\0\0\x01"
    );
}

#[test]
fn files_of_others_are_read_too() {
    let folder = tempfile::tempdir().unwrap();
    let read = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        file::read(&path).unwrap()
    };
    let events = three_events().events;
    let columns = read(
        "columns.csv",
        b"# somebody's comment\r\n p, y,x,t\r\n1,0,1,0\r\n\r\n-1,3,5,1500000\r\n1,2,0,1500000",
    );
    assert_eq!(columns.packet.events, events);
    assert_eq!(columns.packet.size, Size::new(4, 6));
    assert!(!columns.size_known);
    let sized = read("sized.csv", b"# amacrine size=346x260\nt,x,y,p\n0,1,0,1\n");
    assert_eq!(sized.packet.size, Size::new(260, 346));
    assert!(sized.size_known && !sized.channels_known);
    // As numpy.savetxt writes, and to the nearest microsecond.
    let seconds = read(
        "seconds.txt",
        b"0.0 1 0 1\n1.500000000000000000e+00 5 3 -1\n1.4999996 0 2 1\n",
    );
    assert_eq!(seconds.packet.events, events);
    // As Python prints small numbers, and numpy whole ones.
    let short = read(
        "short.txt",
        b"0e0 1.0 0.0 1\n1.5 5.000000000000000000e+00 3 0\n15E-1 0 2.0 1.0\n3 0 0 1\n",
    );
    assert_eq!(short.packet.events[..3], events);
    let early = read("early.txt", b"3e-05 1 2 1\n").packet.events;
    assert_eq!(early[0].t, Micros(30));
    // As dv-processing calls its columns.
    let named = read(
        "named.csv",
        b"timestamp,x,y,polarity\n0,1,0,1\n1500000,5,3,0\n1500000,0,2,1\n",
    );
    assert_eq!(named.packet.events, events);
    let nothing = read("nothing.txt", b"");
    assert_eq!(nothing.packet, Packet::new(Size::new(0, 0), 1));

    // Version 2, big-endian, wide, in another order, padded, p as a boolean.
    let header = b"{'shape': (1,), 'fortran_order': True, 'descr': [('p', '|b1'), ('', '|V3'), \
                   ('y', '>u4'), ('x', '<i8'), ('t', '>u8')]}";
    let mut npy = b"\x93NUMPY\x02\x00".to_vec();
    npy.extend((header.len() as u32).to_le_bytes());
    npy.extend(header);
    npy.extend([1, 9, 9, 9]);
    npy.extend(3_u32.to_be_bytes());
    npy.extend(5_u64.to_le_bytes());
    npy.extend(7_u64.to_be_bytes());
    let one = read("other.npy", &npy).packet;
    assert_eq!((one.events.len(), one.size), (1, Size::new(4, 6)));
    let e = one.events[0];
    assert_eq!((e.t, e.x, e.y, e.polarity), (Micros(7), 5, 3, Polarity::On));
}

#[test]
fn what_a_format_cannot_hold_is_refused_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |name: &str, packet: &Packet, says: &str| {
        let path = folder.path().join(name);
        let error = file::write(&path, packet).unwrap_err();
        assert!(error.to_string().contains(says), "{error}");
        assert!(error.help().is_some());
        assert!(!path.exists());
    };
    let good = three_events();
    let with = |change: fn(&mut Packet)| {
        let mut packet = good.clone();
        change(&mut packet);
        packet
    };
    refused("a.jpg", &good, "`jpg` is not a known kind");
    refused("a", &good, "known are csv, txt, e2vid");
    refused("a.txt", &with(|p| p.channels = 2), ".txt stores no kinds");
    let far = with(|p| {
        p.size.width = 40_000;
        p.events[1].x = 39_999;
    });
    refused(
        "a.npy",
        &far,
        "event 1: `x` is 39999; it should be 0 to 32767",
    );
    assert_eq!(there_and_back(&far, "a.csv").packet.events, far.events);
    refused(
        "a.csv",
        &with(|p| p.events[2].t = Micros(u64::MAX)),
        "event 2: `t` is",
    );
    refused(
        "a.csv",
        &with(|p| p.events.reverse()),
        "event 2: time runs backwards",
    );
    refused(
        "a.csv",
        &with(|p| p.size.height = 3),
        "off the sensor, which is 6x3",
    );
    refused("a.csv", &with(|p| p.events[0].channel = 1), "has channel 1");
    refused("a.csv", &with(|p| p.size.height = 70_000), "at most 65536");
    let nowhere = file::write(Path::new("Cargo.toml/a.csv"), &good).unwrap_err();
    assert!(matches!(nowhere, FileError::Save(_)));
}

/// Each damaged file, and what is said about it.
const BAD: [(&str, &str); 39] = [
    (
        "empty.e2vid",
        ":1:1: expected `width height`, the size of the sensor, found 0 fields",
    ),
    (
        "no_size.e2vid",
        ":1:1: expected `width height`, the size of the sensor, found 4 fields",
    ),
    (
        "lone_cr.csv",
        ":1:7: expected the header `t,x,y,p` (in any order, and perhaps `channel`), found `p\\r1`",
    ),
    (
        "empty.csv",
        ":1:1: expected the header `t,x,y,p` (in any order, and perhaps `channel`), found no line at all",
    ),
    (
        "no_header.csv",
        ":1:1: expected the header `t,x,y,p` (in any order, and perhaps `channel`), found `0`",
    ),
    (
        "unknown_column.csv",
        ":1:9: expected the header `t,x,y,p` (in any order, and perhaps `channel`), found `colour`",
    ),
    (
        "column_twice.csv",
        ":1:9: expected the header `t,x,y,p` (in any order, and perhaps `channel`), found `x` twice",
    ),
    (
        "missing_column.csv",
        ":1:1: expected the header `t,x,y,p` (in any order, and perhaps `channel`), `p` is missing",
    ),
    ("few_fields.csv", ":3:6: expected 4 fields, found 3"),
    ("many_fields.csv", ":3:9: expected 4 fields, found 6"),
    (
        "not_a_number.csv",
        ":4:3: `x` should be a whole number (at most 19 digits), found `one`",
    ),
    (
        "decimal_time.csv",
        ":2:1: `t` should be a whole number (at most 19 digits), found `0.5`",
    ),
    (
        "negative_time.csv",
        ":2:1: `t` is -5 us; event times are 0 to 9223372036854775807 us",
    ),
    (
        "time_too_large.csv",
        ":2:1: `t` is 9999999999999999999 us; event times are 0 to 9223372036854775807 us",
    ),
    (
        "backwards.csv",
        ":4:1: time runs backwards: 19 us comes after 20 us",
    ),
    (
        "polarity.csv",
        ":3:8: `p` should be 1 for ON, 0 or -1 for OFF, found 2",
    ),
    (
        "x_too_large.csv",
        ":2:4: `x` is 65536; it should be 0 to 65535",
    ),
    ("negative_y.csv", ":2:6: `y` is -1; it should be 0 to 65535"),
    (
        "channel_too_large.csv",
        ":2:10: `channel` is 255; it should be 0 to 254",
    ),
    (
        "off_the_sensor.csv",
        ":4:1: the event at x 10, y 0 is off the sensor, which is 10x8",
    ),
    (
        "undeclared_channel.csv",
        ":3:1: the event has channel 2, but there are only 2, counted from 0",
    ),
    (
        "size_too_large.csv",
        ":1:1: the sensor is 99999x8; a side is at most 65536",
    ),
    (
        "comment.csv",
        ":1:1: the comment `# amacrine …` has a part that cannot be read: `size=10`",
    ),
    (
        "late_comment.csv",
        ":3:1: the comment `# amacrine …` comes twice, or after the first event",
    ),
    ("long_line.csv", ":2:1: a line of more than 4096 bytes"),
    (
        "not_seconds.txt",
        ":2:1: `t` should be seconds, found `soon`",
    ),
    ("few_fields.txt", ":1:1: expected 4 fields, found 3"),
    (
        "e2vid_size.txt",
        ":1:1: the first line has two numbers, like the sensor size in a file for E2VID",
    ),
    (
        "evt4.raw",
        ": byte 0: its header says the encoding 4.0; read are EVT2, EVT2.1 and EVT3",
    ),
    (
        "not_npy.npy",
        ": byte 0: this is not an NPY file: expected the bytes \\x93NUMPY, then a version, 1 to 3",
    ),
    (
        "cut_in_header.npy",
        ": byte 40: the file ends here, in the middle of the header",
    ),
    (
        "cut_in_events.npy",
        ": byte 146: the file ends here, in the middle of event 1",
    ),
    (
        "trailing.npy",
        ": byte 154: the file goes on after its last event",
    ),
    (
        "plain_array.npy",
        ": byte 20: the NPY header should describe records with the fields t, x, y and p",
    ),
    (
        "two_dimensions.npy",
        ": byte 115: the NPY header should have a shape of one dimension, (events,)",
    ),
    (
        "missing_field.npy",
        ": byte 62: the NPY header has no field `p`",
    ),
    (
        "float_time.npy",
        ": byte 33: the NPY header has `<f8` for `t`, which is no integer",
    ),
    (
        "negative_x.npy",
        ": byte 141: `x` is -3; it should be 0 to 65535",
    ),
    (
        "backwards.npy",
        ": byte 141: time runs backwards: 19 us comes after 20 us",
    ),
];

/// A DVS128 has addresses of its own, and a set bit for OFF.
#[test]
fn a_recording_of_a_dvs128_is_read_as_one() {
    let folder = tempfile::tempdir().unwrap();
    let read = |chip: &str, records: &[(u32, u32)]| {
        let mut bytes = format!("#!AER-DAT2.0\r\n# AEChip: {chip}\r\n").into_bytes();
        for (address, t) in records {
            bytes.extend(address.to_be_bytes());
            bytes.extend(t.to_be_bytes());
        }
        let path = folder.path().join("a.aedat");
        fs::write(&path, bytes).unwrap();
        file::read(&path).unwrap()
    };
    let records = [
        (3 << 8 | 5 << 1, 10),
        // From outside, as its mark says.
        (1 << 15, 11),
        (127 << 8 | 127 << 1 | 1, 12),
    ];
    for chip in ["ch.unizh.ini.jaer.chip.retina.DVS128", "Tmpdiff128"] {
        let loaded = read(chip, &records);
        let seen = loaded.packet.events.iter();
        let seen: Vec<_> = seen.map(|e| (e.t.0, e.x, e.y, e.polarity)).collect();
        let want = [(10, 5, 3, Polarity::On), (12, 127, 127, Polarity::Off)];
        assert_eq!((seen, loaded.skipped), (want.to_vec(), 1), "{chip}");
        assert_eq!(loaded.packet.size, Size::new(128, 128));
        assert!(loaded.size_known);
    }
    let davis = read("DAVI346", &[(3 << 22 | 5 << 12 | 1 << 11, 10)]);
    let event = davis.packet.events[0];
    assert_eq!((event.x, event.y, event.polarity), (5, 3, Polarity::On));
}

/// What is compressed in another way is not damaged, and nothing is kept of it.
#[cfg(feature = "hdf5")]
#[test]
fn columns_that_cannot_be_unpacked_are_no_damage() {
    for name in ["blosc.h5", "layout_5.h5"] {
        let path = Path::new("tests/bad/event").join(name);
        for error in [
            file::read(&path).unwrap_err(),
            file::salvage(&path, &file::Opening::default()).unwrap_err(),
        ] {
            let text = error.to_string();
            let says = "the column `events/t` is stored in a way that is not read";
            assert!(text.contains(says), "{text}");
            let help = error.help().unwrap().to_string();
            assert!(help.contains("h5repack -f NONE"), "{help}");
        }
    }
}

/// A file of another layout is told apart from one that was cut.
#[cfg(feature = "hdf5")]
#[test]
fn other_layouts_are_no_damage() {
    let path = Path::new("tests/bad/event/prophesee.h5");
    let error = file::read(path).unwrap_err();
    let text = error.to_string();
    let says = "no column `events/t`: it has `CD/events`, as files of Prophesee do";
    assert!(text.contains(says), "{text}");
    assert!(
        error
            .help()
            .unwrap()
            .to_string()
            .contains("a line of Python")
    );
    let folder = tempfile::tempdir().unwrap();
    let whole = folder.path().join("whole.h5");
    let mut packet = Packet::new(Size::new(4, 6), 1);
    packet.events = vec![Event {
        t: Micros(10),
        x: 1,
        y: 2,
        polarity: Polarity::On,
        channel: 0,
    }];
    packet.span = (Micros(0), Micros(20));
    file::write(&whole, &packet).unwrap();
    let mut bytes = fs::read(&whole).unwrap();
    bytes.pop();
    let cut = folder.path().join("cut.h5");
    fs::write(&cut, &bytes).unwrap();
    let error = file::read(&cut).unwrap_err();
    let says = format!(": byte {}: the file ends here", bytes.len());
    assert!(error.to_string().contains(&says), "{error}");
    assert!(error.help().unwrap().to_string().contains("was cut short"));
}

#[test]
fn every_damaged_file_gets_its_message() {
    let folder = Path::new("tests/bad/event");
    for (name, says) in BAD {
        let path = folder.join(name);
        let error = file::read(&path).unwrap_err();
        assert_eq!(error.to_string(), format!("{}{says}", path.display()));
        assert!(error.help().is_some(), "{name}");
    }
    let mut tested: Vec<&str> = BAD.iter().map(|(name, _)| *name).collect();
    tested.extend([
        "blosc.h5",
        "gzip.parquet",
        "layout_5.h5",
        "nanoseconds.parquet",
        "prophesee.h5",
    ]);
    tested.sort_unstable();
    let mut there: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    there.sort_unstable();
    assert_eq!(tested, there, "one file a message");
}

/// What is wrong with an archive's arrays is said of the array, and the help of arrays.
#[test]
fn arrays_that_are_no_events_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("e.npz");
    let said = |names: [&str; 4], float: bool| {
        let mut archive = ZipWriter::new(fs::File::create(&path).unwrap());
        for name in names {
            let how = SimpleFileOptions::default();
            archive.start_file(format!("{name}.npy"), how).unwrap();
            if float && name == "t" {
                arr1(&[0.001, 0.002]).write_npy(&mut archive).unwrap();
            } else {
                arr1(&[1_u16, 1]).write_npy(&mut archive).unwrap();
            }
        }
        archive.finish().unwrap();
        let error = file::read(&path).unwrap_err();
        (error.to_string(), error.help().unwrap().to_string())
    };
    for (names, float, words) in [
        (["ts", "x", "y", "p"], false, "the npz file holds `ts.npy`"),
        (["t", "x", "y", "channel"], false, "has no array `p`"),
        (["t", "x", "y", "p"], true, "an array `t` whose NPY header"),
    ] {
        let (text, help) = said(names, float);
        assert!(text.contains(words), "{text}");
        let save = "np.savez('e.npz', t=t, x=x, y=y, p=p)";
        assert!(
            help.contains(save) && help.contains("whole micro"),
            "{help}"
        );
    }
}

#[test]
fn a_missing_file_is_named() {
    let error = file::read(Path::new("nowhere/a.csv")).unwrap_err();
    assert!(error.to_string().starts_with("nowhere/a.csv: "), "{error}");
}

/// A header may promise any number of events; memory follows what is there.
#[test]
fn a_promise_of_many_events_costs_nothing() {
    let header = b"{'descr': [('t','<i8'),('x','<i2'),('y','<i2'),('p','i1')], \
                   'fortran_order': False, 'shape': (18446744073709551615,)}";
    let mut npy = b"\x93NUMPY\x01\x00".to_vec();
    npy.extend((header.len() as u16).to_le_bytes());
    npy.extend(header);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.npy");
    fs::write(&path, npy).unwrap();
    let error = file::read(&path).unwrap_err().to_string();
    assert!(error.contains("in the middle of event 0"), "{error}");
}
