//! The verb `convert`: formats, slices, kinds, sizes, salvage; what it says and what it
//! refuses, with exit code 2 and nothing left behind.

mod common;

use std::fs;

use amacrine::{
    event::{
        Event, Packet, Polarity, file,
        tensor::{Fill, Sides, TimeSurface, frames},
    },
    plane::Size,
    unit::Micros,
};
use common::{good, json, refused, refused_untouched};

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        let mut packet = Packet::new(Size::new(260, 346), 3);
        packet.span = (Micros(0), Micros(3_000_000));
        packet.events = (0..3000_u64)
            .map(|i| Event {
                t: Micros(i * 1000),
                x: (i % 346) as u16,
                y: (i % 260) as u16,
                polarity: if i % 2 == 0 {
                    Polarity::On
                } else {
                    Polarity::Off
                },
                channel: (i % 3) as u8,
            })
            .collect();
        file::write(&folder.path("kinds.npy"), &packet).unwrap();
        packet.channels = 1;
        for e in &mut packet.events {
            e.channel = 0;
        }
        file::write(&folder.path("one.npy"), &packet).unwrap();
        file::write(&folder.path("one.csv"), &packet).unwrap();
        folder
    }

    fn path(&self, name: &str) -> std::path::PathBuf {
        self.0.path().join(name)
    }

    fn said(&self, arguments: &[&str]) -> String {
        good(self.0.path(), &[&["convert"], arguments].concat())
    }

    #[track_caller]
    fn refused(&self, arguments: &[&str], says: &str) {
        let all = [&["convert"], arguments].concat();
        refused_untouched(self.0.path(), &all, &[says]);
    }
}

/// Events in no order of time are refused with the way out, which sorts them; those of one time stay
/// in the order of the file.
#[test]
fn events_in_no_order_are_sorted_where_that_is_asked_for() {
    let folder = Folder::new();
    let at = folder.0.path();
    let sorted = file::read(&folder.path("one.npy")).unwrap().packet;
    let text = fs::read_to_string(folder.path("one.csv")).unwrap();
    let (head, rows): (Vec<&str>, Vec<&str>) = text
        .lines()
        .partition(|line| !line.starts_with(|c: char| c.is_ascii_digit()));
    // Two halves, the later first, and a tie at the end.
    let (early, late) = rows.split_at(1500);
    let all = [&head[..], late, early, &["2999000,1,1,1"]].concat();
    let all: Vec<&str> = all
        .into_iter()
        .filter(|line| !line.starts_with('#'))
        .collect();
    fs::write(folder.path("a.csv"), all.join("\n") + "\n").unwrap();
    for verb in [
        &["convert", "a.csv", "b.npy"][..],
        &["compare", "a.csv", "a.csv"],
    ] {
        refused(at, verb, &["time runs backwards", "convert A B --sort"]);
    }
    let size = ["--size", "346x260"];
    let said = folder.said(&[&["a.csv", "b.npy", "--sort"][..], &size].concat());
    assert!(
        said.contains("sorted by time: 1 event came earlier"),
        "{said}"
    );
    let events = file::read(&folder.path("b.npy")).unwrap().packet.events;
    assert_eq!(events[..3000], sorted.events);
    assert_eq!((events[3000].x, events.len()), (1, 3001));
    // A slice in its own times, from 0.
    let part = [
        "a.csv",
        "c.npy",
        "--sort",
        "--slice",
        "1s..2s",
        "--from-zero",
        "--json",
    ];
    let said = json(at, &[&["convert"], &part[..], &size].concat());
    assert_eq!(said["read"]["out_of_order"], 1);
    let part = file::read(&folder.path("c.npy")).unwrap().packet.events;
    assert_eq!((part[0].t, part.len()), (Micros(0), 1000));
    let least = ["--max-memory", "1K"];
    refused(
        at,
        &[&least[..], &["convert", "a.csv", "d.npy", "--sort"]].concat(),
        &["--sort of a.csv", "3001 events", "--max-memory"],
    );
    assert!(!folder.path("d.npy").exists());
}

/// `--flip` counts columns, rows or both from the other side of a sensor whose size is known; files
/// of jAER and v2e say that they need it.
#[test]
fn pixels_are_counted_from_the_other_side() {
    let folder = Folder::new();
    let at = folder.0.path();
    let xy = |name: &str| -> Vec<(u16, u16)> {
        let read = file::read(&folder.path(name)).unwrap().packet;
        read.events.iter().map(|event| (event.x, event.y)).collect()
    };
    fs::write(
        folder.path("a.csv"),
        "t,x,y,p\n1,0,0,1\n2,345,1,0\n3,100,259,1\n",
    )
    .unwrap();
    let size = ["--size", "346x260"];
    for (flip, wanted) in [
        ("x", [(345, 0), (0, 1), (245, 259)]),
        ("y", [(0, 259), (345, 258), (100, 0)]),
        ("xy", [(345, 259), (0, 258), (245, 0)]),
    ] {
        good(
            at,
            &[&["convert", "a.csv", "b.npy", "--flip", flip], &size[..]].concat(),
        );
        assert_eq!(xy("b.npy"), wanted, "{flip}");
        good(at, &["convert", "b.npy", "c.npy", "--flip", flip]);
        assert_eq!(xy("c.npy"), xy("a.csv"), "{flip}");
    }
    refused(
        at,
        &["convert", "a.csv", "d.npy", "--flip", "xy"],
        &["--flip", "a.csv does not say how large", "--size WxH"],
    );
    refused(
        at,
        &["convert", "a.csv", "d.npy", "--flip", "yx"],
        &["x (columns), y (rows) or xy"],
    );
    // The words of v2e's AEDat2Output: (0, 0) of the picture is (345, 259).
    let event = |t: u32, x: u32, y: u32, p: u32| {
        let address = (259 - y) << 22 | (345 - x) << 12 | p << 11;
        (u64::from(address) << 32 | u64::from(t)).to_be_bytes()
    };
    let events = [
        event(1, 0, 0, 1),
        event(2, 345, 1, 0),
        event(3, 100, 259, 1),
    ]
    .concat();
    for (line, says) in [
        (
            "# created by AEDat2Output in v2e (see URL)",
            "written by v2e",
        ),
        (
            "# AEChip: eu.seebetter.ini.chips.davis.DAVIS346B",
            "not written by amacrine",
        ),
    ] {
        let head = format!("#!AER-DAT2.0\r\n{line}\r\n");
        fs::write(folder.path("v.aedat"), [head.as_bytes(), &events].concat()).unwrap();
        let said = folder.said(&["v.aedat", "v.npy", "--size", "346x260"]);
        assert!(said.contains(says) && said.contains("--flip xy"), "{said}");
        let turned = ["v.aedat", "v.npy", "--size", "346x260", "--flip", "xy"];
        let said = folder.said(&turned);
        assert!(!said.contains("note"), "{said}");
        assert_eq!(xy("v.npy"), xy("a.csv"));
    }
    // Our own are as they are.
    good(
        at,
        &[
            &["convert", "a.csv", "o.aedat", "--format", "aedat2"],
            &size[..],
        ]
        .concat(),
    );
    let said = folder.said(&["o.aedat", "o.npy"]);
    assert!(!said.contains("note"), "{said}");
    assert_eq!(xy("o.npy"), xy("a.csv"));
}

#[test]
fn round_and_round() {
    let folder = Folder::new();
    let names = [
        "a.evt3", "b.dat", "c.aedat4", "d.evt2.1", "e.es", "f.npz", "g.aedat3", "h.evt2",
        "i.aedat2",
    ];
    let mut from = "one.npy";
    for to in names {
        let said = folder.said(&[from, to]);
        let last = said.lines().last().unwrap();
        assert!(
            last.starts_with("open     import ") && last.contains(&format!("'{to}'")),
            "{said}"
        );
        from = to;
    }
    let last = file::read(&folder.path(from)).unwrap();
    let first = file::read(&folder.path("one.npy")).unwrap();
    assert_eq!(last.packet.events, first.packet.events);
    assert_eq!(last.packet.size, first.packet.size);
}

#[test]
fn slices_kinds_and_json() {
    let folder = Folder::new();
    let said = folder.said(&["one.npy", "part.npy", "--slice", "1s..1.5s", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&said).unwrap();
    let written = &json["written"][0];
    assert_eq!(written["events"], 500);
    assert_eq!(
        (written["first_us"].as_u64(), written["last_us"].as_u64()),
        (Some(1_000_000), Some(1_499_000))
    );
    assert_eq!(
        written["python"],
        "import numpy; events = numpy.load('part.npy')"
    );
    let part = file::read(&folder.path("part.npy")).unwrap().packet;
    assert_eq!(part.span, (Micros(1_000_000), Micros(1_500_000)));

    // A slice beside the recording is empty, and that is said.
    let said = folder.said(&["one.npy", "none.npy", "--slice", "5s..6s"]);
    assert!(
        said.contains("no event is in the slice: those read are from 0 us to 2999000 us"),
        "{said}"
    );

    folder.said(&["kinds.npy", "k.evt3", "--kind", "2", "--slice", "..500ms"]);
    let kind = file::read(&folder.path("k.evt3")).unwrap().packet;
    let times: Vec<u64> = kind.events.iter().map(|e| e.t.0).collect();
    assert_eq!(
        times,
        (0..500)
            .filter(|i| i % 3 == 2)
            .map(|i| i * 1000)
            .collect::<Vec<u64>>()
    );

    for extension in ["evt2", "evt2.1"] {
        let whole = format!("each.{extension}");
        let said = folder.said(&["kinds.npy", &whole, "--each-kind"]);
        let mut sum = 0;
        for kind in 0..3 {
            let name = format!("each.kind{kind}.{extension}");
            assert!(said.contains(&name), "{said}");
            sum += file::read(&folder.path(&name)).unwrap().packet.events.len();
        }
        assert_eq!(sum, 3000);
        assert!(!folder.path(&whole).exists());
    }
}

/// Times of the day, as cameras write them.
const DAY: u64 = 1_700_000_000_000_000;

#[test]
fn times_of_the_day_begin_at_zero_where_that_is_asked_for() {
    let folder = Folder::new();
    let mut packet = file::read(&folder.path("kinds.npy")).unwrap().packet;
    packet.span = (Micros(DAY + 500), Micros(DAY + 3_000_000));
    packet.events.retain(|e| e.t.0 > 0);
    for event in &mut packet.events {
        event.t.0 += DAY;
    }
    file::write(&folder.path("day.npy"), &packet).unwrap();
    packet.channels = 1;
    for event in &mut packet.events {
        event.channel = 0;
    }
    file::write(&folder.path("day.csv"), &packet).unwrap();
    folder.refused(&["day.csv", "a.dat"], "`convert --from-zero`");
    // A span says where the recording begins, else the first event does.
    let first = |name: &str, more: &[&str]| {
        folder.said(&[&[name, "out.npy", "--from-zero"], more].concat());
        let packet = file::read(&folder.path("out.npy")).unwrap().packet;
        (packet.span, packet.events[0].t.0, packet.events.len())
    };
    let whole = (Micros(0), Micros(2_999_500));
    assert_eq!(first("day.npy", &[]), (whole, 500, 2999));
    assert_eq!(first("day.npy", &["--kind", "1"]), (whole, 500, 1000));
    let (_, at, events) = first("day.csv", &["--size", "346x260"]);
    assert_eq!((at, events), (0, 2999));
    let slice = format!("{}us..{}us", DAY + 1_000_000, DAY + 1_500_000);
    let cut = (Micros(0), Micros(500_000));
    assert_eq!(first("day.npy", &["--slice", &slice]), (cut, 0, 500));
    folder.said(&["day.csv", "day.dat", "--from-zero", "--size", "346x260"]);
    let dat = file::read(&folder.path("day.dat")).unwrap().packet;
    assert_eq!((dat.events[0].t.0, dat.events.len()), (0, 2999));
}

/// A span that begins after the first event is stated, not true: no event is lost to it.
#[test]
fn no_event_comes_before_the_start() {
    let folder = Folder::new();
    let mut packet = file::read(&folder.path("one.npy")).unwrap().packet;
    packet.span = (Micros(1_500_000), Micros(3_000_000));
    file::write(&folder.path("late.npy"), &packet).unwrap();
    folder.said(&["late.npy", "out.npy", "--from-zero"]);
    let out = file::read(&folder.path("out.npy")).unwrap().packet;
    assert_eq!(out.events, packet.events);
    let voxels = ["voxels", "late.npy", "-o", "v.npy", "--window", "500ms"];
    let said = common::json(folder.0.path(), &voxels);
    assert_eq!(
        (said["shape"][0].as_u64(), said["from_us"].as_u64()),
        (Some(6), Some(0))
    );
}

/// The windows of such a recording are those in which it lies.
#[test]
fn windows_begin_where_the_recording_does() {
    let folder = Folder::new();
    let mut packet = file::read(&folder.path("one.npy")).unwrap().packet;
    let windows = |name: &str, more: &[&str]| {
        let asked = [
            "voxels", name, "-o", "v.npy", "--window", "500ms", "--bins", "2",
        ];
        let all = [&asked[..], more].concat();
        let said = common::json(folder.0.path(), &all);
        (said["shape"][0].as_u64(), said["from_us"].as_u64())
    };
    assert_eq!(windows("one.npy", &[]), (Some(6), Some(0)));
    packet.span = (Micros(DAY + 700_000), Micros(DAY + 3_000_000));
    packet.events.retain(|e| e.t.0 > 700_000);
    for event in &mut packet.events {
        event.t.0 += DAY;
    }
    file::write(&folder.path("day.npy"), &packet).unwrap();
    assert_eq!(windows("day.npy", &[]), (Some(5), Some(DAY + 500_000)));
    let from = format!("{}us", DAY + 1_000_000);
    let (count, start) = windows("day.npy", &["--from", &from]);
    assert_eq!((count, start), (Some(4), Some(DAY + 1_000_000)));
}

#[test]
fn the_size_and_where_it_comes_from() {
    let folder = Folder::new();
    let said = folder.said(&["one.csv", "a.dat"]);
    assert!(
        said.contains("one.csv, csv, 346x260") && said.contains("does not say its size"),
        "{said}"
    );
    let said = folder.said(&["one.csv", "b.raw", "--format", "evt3", "--size", "640x480"]);
    assert!(
        said.contains("640x480") && !said.contains("does not say"),
        "{said}"
    );
    assert_eq!(
        file::read(&folder.path("b.raw")).unwrap().packet.size,
        Size::new(480, 640)
    );
    // A file that says its size is not given another.
    for size in ["10x10", "1000x1000"] {
        folder.refused(
            &["b.raw", "c.es", "--size", size],
            &format!("b.raw: the file states the sensor size 640x480, but {size} was given"),
        );
    }
    folder.said(&["b.raw", "c.es", "--size", "640x480"]);
    // Text may say it with its first events.
    let text = "# amacrine size=64x48\nt,x,y,p\n5,1,0,1\n";
    fs::write(folder.path("d.csv"), text).unwrap();
    folder.refused(
        &["d.csv", "e.es", "--size", "10x10"],
        "d.csv: the file states the sensor size 64x48, but 10x10 was given",
    );
}

/// Two cameras in one file, as dv-processing writes it: each is read alone, with its size.
#[test]
fn a_camera_of_several_is_chosen() {
    let folder = Folder::new();
    let both = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/data/event/two_cameras.aedat4"
    );
    let says = ["has two streams of events, 0 and 1,", "--stream N"];
    refused_untouched(folder.0.path(), &["convert", both, "b.npy"], &says);
    // No damage, of which something could be kept.
    let salvage = ["convert", both, "b.npy", "--salvage"];
    refused_untouched(folder.0.path(), &salvage, &says);
    folder.refused(
        &[both, "b.npy", "--stream", "2"],
        "no stream of events of number 2",
    );
    folder.refused(
        &["one.npy", "b.npy", "--stream", "0"],
        "no stream of events of number 0",
    );
    for (stream, size, events) in [
        (
            "0",
            Size::new(4, 6),
            &[(10, 1, 2), (20, 5, 3), (30, 0, 0)][..],
        ),
        ("1", Size::new(5, 8), &[(12, 7, 4), (25, 0, 1)]),
    ] {
        folder.said(&[both, "c.npy", "--stream", stream]);
        let read = file::read(&folder.path("c.npy")).unwrap().packet;
        let seen: Vec<_> = read.events.iter().map(|e| (e.t.0, e.x, e.y)).collect();
        assert_eq!((read.size, &seen[..]), (size, events));
    }
}

#[test]
fn damage_and_what_is_kept() {
    let folder = Folder::new();
    folder.said(&["one.npy", "a.dat"]);
    let mut bytes = fs::read(folder.path("a.dat")).unwrap();
    bytes.truncate(bytes.len() - 8 * 1000 - 3);
    fs::write(folder.path("cut.dat"), &bytes).unwrap();
    folder.refused(&["cut.dat", "b.evt3"], "in the middle of an event");
    let said = folder.said(&["cut.dat", "b.evt3", "--salvage"]);
    assert!(
        said.contains("damage   cut.dat: byte ") && said.contains("1999 events"),
        "{said}"
    );
    assert_eq!(
        file::read(&folder.path("b.evt3"))
            .unwrap()
            .packet
            .events
            .len(),
        1999
    );
    // Of an archive nothing is kept, and it is not said that something could be.
    folder.said(&["one.npy", "a.npz"]);
    let bytes = fs::read(folder.path("a.npz")).unwrap();
    fs::write(folder.path("cut.npz"), &bytes[..bytes.len() / 2]).unwrap();
    // Nor is it advised.
    folder.refused(&["cut.npz", "b.csv"], "its index is at the end");
    let salvage = ["cut.npz", "b.csv", "--salvage"];
    folder.refused(&salvage, "nothing is kept of it");
    // What is whole, and not read, is no damage: its own advice stands.
    let foreign = [
        ("evt4.raw", "metavision_file_to_raw"),
        #[cfg(feature = "hdf5")]
        ("blosc.h5", "h5repack -f NONE"),
        #[cfg(feature = "hdf5")]
        ("prophesee.h5", "read are the layouts of DSEC"),
    ];
    for (name, advice) in foreign {
        fs::copy(format!("tests/bad/event/{name}"), folder.path(name)).unwrap();
        folder.refused(&[name, "b.csv", "--salvage"], advice);
    }
}

#[test]
fn refusals() {
    let folder = Folder::new();
    folder.refused(&["-", "a.npy", "--from", "npy"], "- is no file");
    #[cfg(unix)]
    folder.refused(
        &["/dev/null", "a.npy", "--from", "npy"],
        "reads what it converts twice",
    );
    folder.refused(&["one.npy", "a.foo"], "what it writes: --format NAME");
    fs::write(folder.path("b.foo"), "1 2 3\n").unwrap();
    folder.refused(&["b.foo", "a.npy"], "what it reads: --from NAME");
    folder.refused(
        &["one.npy", "a.raw"],
        "`.raw` files come in several formats: evt2, evt2.1, evt3",
    );
    folder.refused(
        &["one.npy", "a.jpg"],
        "`jpg` is not a known kind of event file",
    );
    folder.refused(&["one.npy", "a.mcap"], "`amacrine show EVENTS -o NAME.mcap");
    folder.refused(&["kinds.npy", "a.evt3"], ".evt3 stores no kinds");
    folder.refused(
        &["kinds.npy", "a.evt3", "--kind", "3"],
        "there is no kind 3: it has 3 kinds",
    );
    folder.refused(
        &["one.npy", "a.evt3", "--format", "evt4"],
        "`evt4` is no format",
    );
    folder.refused(
        &["one.npy", "a.evt3", "--slice", "2s..1s"],
        "FROM is after TO",
    );
    folder.refused(
        &["one.npy", "a.evt3", "--slice", "1..2"],
        "is not a duration",
    );
    folder.refused(&["one.csv", "a.evt3", "--size", "0x5"], "such as 346x260");
    folder.refused(
        &["one.csv", "a.evt3", "--size", "100x260"],
        "is off the sensor, which is 100x260",
    );
    for compression in ["zstd", "none", "lz4"] {
        folder.refused(
            &["one.npy", "a.csv", "--compression", compression],
            &format!(
                "a.csv: compression {compression} was asked for, but csv has no choice of compression"
            ),
        );
    }
    folder.refused(&["nothing.npy", "a.evt3"], "nothing.npy: ");
    fs::write(folder.path("noise.raw"), [7; 64]).unwrap();
    folder.refused(
        &["noise.raw", "a.evt3"],
        "neither the extension nor the first bytes say",
    );
}

/// A recording without events has the size that was given, and none is written as a fact where none
/// is known.
#[test]
fn a_recording_without_events_has_the_size_that_was_given() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("none.csv"), "t,x,y,p\n").unwrap();
    refused(
        folder,
        &["convert", "none.csv", "none.npz"],
        &["does not say how large its sensor is", "give --size WxH"],
    );
    assert!(!folder.join("none.npz").exists());
    for name in ["none.aedat4", "none.npz", "none.es", "none.h5"] {
        let said = json(
            folder,
            &["convert", "none.csv", name, "--size", "48x32", "--json"],
        );
        assert_eq!(said["read"]["width"], 48, "{name}");
        let said = good(folder, &["packets", name]);
        assert!(said.contains("48x32"), "{name}: {said}");
    }
    // Where the size stands in the file, it is known.
    good(folder, &["convert", "none.npz", "none.e2vid"]);
    let said = json(folder, &["convert", "none.e2vid", "again.npz", "--json"]);
    assert_eq!(said["read"]["width"], 48);
}

/// Of a part it is not known what was lost of it.
#[test]
fn a_part_does_not_say_what_was_lost() {
    let folder = Folder::new();
    let mut packet = file::read(&folder.path("one.npy")).unwrap().packet;
    packet.dropped.no_slot = 17;
    file::write(&folder.path("lost.npy"), &packet).unwrap();
    let said = folder.said(&["lost.npy", "part.npy", "--slice", "1s..2s"]);
    assert!(said.contains("17 events lost on the way"), "{said}");
    let said = folder.said(&["lost.npy", "whole.npz"]);
    assert!(!said.contains("lost on the way"), "{said}");
}

/// As spreadsheets write it, and with the column of the field that is wrong.
#[test]
fn csv_of_spreadsheets() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("a.csv"), "\u{feff}t,x,y,p\n1,2,3,1\n").unwrap();
    good(folder, &["convert", "a.csv", "a.npy"]);
    for (line, place) in [
        ("1,70000,3,1", ":2:3: `x` is 70000"),
        ("1,2,3,5", ":2:7:"),
        ("-1,2,3,1", ":2:1:"),
        ("1,2,-3,1", ":2:5: `y` is -3"),
    ] {
        std::fs::write(folder.join("b.csv"), format!("t,x,y,p\n{line}\n")).unwrap();
        refused(folder, &["convert", "b.csv", "b.npy"], &[place]);
    }
    for (first, way) in [
        (
            "2,3,1,1",
            "names the columns in their order: t,x,y,p, or x,y,p,t",
        ),
        (",t,x,y,p", "to_csv(path, index=False)"),
        ("t;x;y;p", "let commas stand between the columns"),
        ("t,x,y,p\r1,2,3,1\r", "a lone \\r"),
        (
            "t,x,y,colour",
            "let the first line name the columns: t,x,y,p",
        ),
    ] {
        std::fs::write(folder.join("b.csv"), format!("{first}\n1,2,3,1\n")).unwrap();
        refused(folder, &["convert", "b.csv", "b.npy"], &[way]);
    }
}

/// What is told of the first window is where its events come from, however windows lie.
#[test]
fn the_first_window_is_where_it_is_told_to_be() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let lines: Vec<String> = (0..300).map(|n| format!("{},1,1,1\n", 1000 * n)).collect();
    fs::write(folder.join("a.csv"), format!("t,x,y,p\n{}", lines.concat())).unwrap();
    let beyond = [
        "voxels", "a.csv", "-o", "v.npy", "--window", "50ms", "--from", "300ms",
    ];
    let told = [
        "--from 0.300000 s: a.csv ends at 0.299000 s",
        "before its end",
    ];
    common::refused(folder, &beyond, &told);
    for (more, from, ms, between) in [
        (&["--every", "50ms"][..], 100_000, 51, 0),
        (&["--every", "20ms"], 70_000, 51, 0),
        // Those of 100 to 119 ms, 171 to 190 and 241 to 260.
        (&["--every", "70ms"], 120_000, 51, 60),
        (&["--align", "centred"], 75_000, 51, 0),
    ] {
        let arguments = [
            "voxels", "a.csv", "-o", "v.npy", "--window", "50ms", "--from", "100ms",
        ];
        let rest = ["--bins", "1", "--size", "4x4", "--json"];
        let said = json(folder, &[&arguments[..], more, &rest].concat());
        assert_eq!(said["from_us"], from, "{more:?}");
        assert_eq!(said["between_windows"], between, "{more:?}");
        // The events of that window, its first bound included.
        let first = 1 + from / 1000;
        let own =
            (first..first + ms).filter(|n| (from..=from + 50_000).contains(&((n - 1) * 1000)));
        let array: ndarray::ArrayD<f32> = ndarray_npy::read_npy(folder.join("v.npy")).unwrap();
        let sum = array.index_axis(ndarray::Axis(0), 0).sum();
        assert_eq!(sum, own.count() as f32, "{more:?}");
    }
}

/// Surfaces and frames of a recording of several blocks that begins late, against the library's of
/// the whole packet; what a frame of 16 bits does not hold.
#[test]
fn surfaces_and_frames_are_those_of_the_whole_packet() {
    const LATE: u64 = 5_000_000;
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mut packet = Packet::new(Size::new(4, 5), 1);
    packet.events = (0..100_000_u64)
        .map(|n| Event {
            t: Micros(LATE + n * n / 50_000),
            x: (n * 7 % 5) as u16,
            y: (n * 11 % 4) as u16,
            polarity: Polarity::of(n % 3 == 0),
            channel: 0,
        })
        .collect();
    let end = packet.events.last().unwrap().t;
    packet.span = (Micros(LATE), end);
    file::write(&folder.join("e.npy"), &packet).unwrap();
    let read = || -> ndarray::ArrayD<f32> { ndarray_npy::read_npy(folder.join("a.npy")).unwrap() };

    let made = ["voxels", "e.npy", "-o", "a.npy", "--json"];
    let asked = ["--as", "surfaces", "--every", "7ms", "--tau", "20ms"];
    let said = json(folder, &[&made[..], &asked].concat());
    // The last multiple of 7 ms before it, and one step on.
    let first = LATE / 7000 * 7000 + 7000;
    let times: Vec<Micros> = (0..=(end.0 - first).div_ceil(7000))
        .map(|n| Micros(first + n * 7000))
        .collect();
    let mut how = TimeSurface::new(0.02).unwrap();
    how.sides = Sides::Split;
    assert_eq!(said["first_us"], first);
    assert_eq!(said["shape"], serde_json::json!([times.len(), 1, 2, 4, 5]));
    let got = read().into_raw_vec_and_offset().0;
    assert_eq!(got, how.of(&packet, &times).unwrap());

    let asked = ["--as", "frames", "--count", "30000"];
    let said = json(folder, &[&made[..], &asked].concat());
    assert_eq!(said["events_left_over"], 10_000);
    assert_eq!(said["shape"], serde_json::json!([4, 1, 1, 4, 5]));
    let want = frames(&packet, 30_000, Sides::Signed, Fill::Count).unwrap();
    let got = read().into_raw_vec_and_offset().0;
    assert!(got.iter().map(|n| *n as i32).eq(want));
    let asked = ["--as", "frames", "--count", "100000", "--polarity", "split"];
    refused(
        folder,
        &[&made[..], &asked, &["--half"]].concat(),
        &["a pixel of a frame has", "up to 2048", "leave --half out"],
    );
}
