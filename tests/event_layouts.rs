//! HDF5 files in the layouts of others, `event_utils` and MVSEC: what is read of those that h5py
//! wrote, and one message for each way in which they may be wrong. Types of numbers in HDF5 and
//! Parquet: signs, units.
#![cfg(all(feature = "hdf5", feature = "parquet"))]

mod common;

use std::{
    fs,
    path::{Path, PathBuf},
};

use amacrine::{
    event::{
        Event, Polarity,
        file::{self, Loaded, Opening, Reader},
    },
    plane::Size,
};
use common::{good, json, refused, refused_untouched};
use hdf5_pure::{AttrValue, DatasetBuilder, File, Group};
use miette::Diagnostic as _;

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data/event")
        .join(name)
}

/// Times, places and signs.
type Row = (u64, u16, u16, bool);

const ROWS: [Row; 5] = [
    (10, 0, 0, true),
    (20, 5, 4, false),
    (20, 7, 1, true),
    (45_000, 3, 2, true),
    (1_250_000, 2, 3, false),
];

fn rows(loaded: &Loaded) -> Vec<Row> {
    let of = |e: &Event| (e.t.0, e.x, e.y, e.polarity == Polarity::On);
    loaded.packet.events.iter().map(of).collect()
}

#[test]
fn event_utils_is_read() {
    let loaded = file::read(&data("event_utils.h5")).unwrap();
    assert_eq!(rows(&loaded), ROWS);
    assert_eq!(loaded.packet.size, Size::new(5, 8));
    assert!(loaded.size_known);
    assert_eq!(loaded.skipped, 2, "two images");
}

/// Times of the day lose no microsecond; each camera is read alone.
#[test]
fn mvsec_is_read() {
    const DAY: u64 = 1_506_117_889_000_000;
    let path = data("mvsec.h5");
    let read = |stream| {
        let how = Opening {
            stream,
            ..Opening::default()
        };
        file::read_as(&path, &how)
    };
    for (stream, shift, from) in [(0, 0, 0), (1, 1, 1)] {
        let loaded = read(Some(stream)).unwrap();
        let wanted = ROWS[from..].iter();
        let wanted = wanted.map(|(t, x, y, on)| (DAY + t, (x + shift) % 8, *y, *on));
        assert_eq!(rows(&loaded), wanted.collect::<Vec<_>>());
        assert_eq!(loaded.packet.size, Size::new(5, 8));
        assert_eq!((loaded.size_known, loaded.skipped), (true, 7));
    }
    let error = read(None).unwrap_err();
    let says = "two streams of events, 0 (davis/left/events) and 1 (davis/right/events), which";
    assert!(error.to_string().contains(says), "{error}");
    let error = read(Some(2)).unwrap_err();
    let help = error.help().unwrap().to_string();
    assert_eq!(help, "give one of those that there are: 0, 1");
}

/// One camera of a stereo file is chosen in the same way by every verb that reads event files.
#[test]
fn every_verb_reads_one_of_two_cameras() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let both = |name: &str| data(name).display().to_string();
    for stereo in [both("mvsec.h5"), both("two_cameras.aedat4")] {
        let whole: [&[&str]; 6] = [
            &["packets", &stereo, "--json"],
            &["show", &stereo, "-o", "a.png", "--json"],
            &["compare", &stereo, &stereo, "--json"],
            &["voxels", &stereo, "-o", "a.npy", "--window", "1s", "--json"],
            &["convert", &stereo, "b.npy", "--json"],
            &["convert", &stereo, "b.npy", "--json", "--salvage"],
        ];
        for arguments in whole {
            let says = [
                "has two streams of events, 0",
                "choose one by its number: --stream N",
            ];
            refused_untouched(folder, arguments, &says);
            for stream in ["0", "1"] {
                json(folder, &[arguments, &["--stream", stream]].concat());
            }
            let wrong = [arguments, &["--stream", "7"]].concat();
            refused(folder, &wrong, &["no stream of events of number 7", "0, 1"]);
        }
        // Of two files only one may have several.
        good(folder, &["convert", &stereo, "one.npy", "--stream", "1"]);
        let said = json(
            folder,
            &["compare", &stereo, "one.npy", "--stream", "1", "--json"],
        );
        assert_eq!(said["headline"]["f1"], 1.0, "{said}");
    }
    let none = ["compare", "one.npy", "one.npy", "--stream", "1"];
    refused(folder, &none, &["no stream of events of number 1"]);
}

/// A file with these groups, and what is put in.
fn hdf5(path: &Path, groups: &[&str], put: impl Fn(&Group)) {
    // A new file each time: a program that another test is starting may still hold the lock of
    // the one before.
    let _ = std::fs::remove_file(path);
    let file = File::create(path).unwrap();
    for group in groups {
        file.root().create_group(group).unwrap();
    }
    put(&file.root());
    file.commit().unwrap();
    file.close().unwrap();
}

fn column(root: &Group, path: &str, values: impl FnOnce(&mut DatasetBuilder)) {
    root.create_dataset(path, values).unwrap();
}

fn attribute(root: &Group, name: &str, value: AttrValue) {
    root.set_attr(name, value).unwrap();
}

/// A file of `event_utils`, of which one column or attribute, `but`, is put in by `edit`.
fn utils(path: &Path, but: &str, edit: impl Fn(&Group)) {
    hdf5(path, &["events"], |root| {
        for name in ["events/xs", "events/ys", "events/ts", "events/ps"] {
            if name != but {
                column(root, name, |column| {
                    match name {
                        "events/xs" => column.with_i16_data(&[0, 5, 7]),
                        "events/ys" => column.with_i16_data(&[0, 4, 1]),
                        "events/ts" => column.with_f64_data(&[1e-5, 2e-5, 0.045]),
                        _ => column.with_i8_data(&[1, -1, 1]),
                    };
                });
            }
        }
        for (name, value) in [
            ("num_events", AttrValue::I64(3)),
            ("sensor_resolution", AttrValue::I64Array(vec![5, 8])),
        ] {
            if name != but {
                attribute(root, name, value);
            }
        }
        edit(root);
    });
}

fn real(root: &Group, name: &str, values: &[f64]) {
    column(root, name, |column| {
        column.with_f64_data(values);
    });
}

fn short(root: &Group, name: &str, values: &[i16]) {
    column(root, name, |column| {
        column.with_i16_data(values);
    });
}

const T: &str = "events/ts";
const X: &str = "events/xs";
const P: &str = "events/ps";
const EVENTS: &str = "num_events";
const SIZE: &str = "sensor_resolution";

#[test]
fn every_fault_of_event_utils_has_its_message() {
    type Edit = fn(&Group);
    let cases: [(&str, Edit, &str); 13] = [
        (
            T,
            |r| real(r, T, &[1e-5, f64::NAN, 1.0]),
            ": event 1: `t` should be seconds, found `NaN`",
        ),
        (
            T,
            |r| real(r, T, &[1e-5, 2e-5, f64::INFINITY]),
            ": event 2: `t` should be seconds, found `inf`",
        ),
        (
            T,
            |r| real(r, T, &[1e-5, 2e-5, 1e-5]),
            ": event 2: time runs backwards: 10 us comes after 20 us",
        ),
        (
            T,
            |r| real(r, T, &[-1e-5, 2e-5, 1.0]),
            ": event 0: `t` is -10 us",
        ),
        (
            T,
            |r| real(r, T, &[1e-5, 2e-5]),
            "has columns of different lengths",
        ),
        (
            X,
            |r| real(r, X, &[0.0, 3.5, 1.0]),
            ": event 1: `x` should be a whole number (at most 19 digits), found `3.5`",
        ),
        (X, |r| short(r, X, &[0, -1, 1]), ": event 1: `x` is -1"),
        (
            X,
            |r| short(r, X, &[0, 8, 1]),
            ": event 1: the event at x 8, y 4 is off the sensor, which is 8x5",
        ),
        (
            P,
            |r| short(r, P, &[1, 2, 1]),
            ": event 1: `p` should be 1 for ON, 0 or -1 for OFF, found 2",
        ),
        (P, |_| (), "no column `events/ps`"),
        (
            EVENTS,
            |r| attribute(r, EVENTS, AttrValue::I64(4)),
            "`num_events` says 4 events, `events/ts` has 3",
        ),
        (
            EVENTS,
            |r| attribute(r, EVENTS, AttrValue::String("many".into())),
            "an attribute `num_events` of no whole numbers",
        ),
        (
            SIZE,
            |r| attribute(r, SIZE, AttrValue::I64(5)),
            "`sensor_resolution` that is not (height, width)",
        ),
    ];
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.h5");
    utils(&path, "", |_| ());
    assert_eq!(file::read(&path).unwrap().packet.events.len(), 3);
    for (what, edit, says) in cases {
        utils(&path, what, edit);
        let error = file::read(&path).unwrap_err();
        assert!(error.to_string().contains(says), "{error}\n{says}");
        assert!(error.help().is_some(), "{error}");
    }
}

/// Integers are microseconds, floating point seconds; seconds that look like microseconds are told.
#[test]
fn the_unit_of_times_goes_by_their_type() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.h5");
    let times = |whole: bool| {
        utils(&path, T, |root| {
            column(root, T, |column| {
                if whole {
                    column.with_i64_data(&[10, 20, 45_000]);
                } else {
                    column.with_f64_data(&[10.0, 20.0, 45_000.0]);
                }
            });
        });
        let said = json(folder.path(), &["convert", "a.h5", "a.npy", "--json"]);
        let last = said["written"][0]["last_us"].as_u64().unwrap();
        (last, said["read"]["note"].as_str().map(str::to_owned))
    };
    assert_eq!(times(true), (45_000, None));
    let (last, note) = times(false);
    assert_eq!(last, 45_000_000_000);
    assert!(note.unwrap().contains("all times are whole seconds"));
}

/// Damage is named, and what stands before it is kept; other shapes are refused.
#[test]
fn damage_of_mvsec() {
    let folder = tempfile::tempdir().unwrap();
    let write = |columns: u64, values: &[f64]| {
        let path = folder.path().join("a.h5");
        hdf5(&path, &["davis", "davis/right"], |root| {
            let shape = [values.len() as u64 / columns, columns];
            column(root, "davis/right/events", |rows| {
                rows.with_f64_data(values).with_shape(&shape);
            });
        });
    };
    let t = 1_506_117_889.0;
    write(4, &[3.0, 2.0, t, 1.0, 4.0, f64::NAN, t, -1.0]);
    let says = ": event 1: `y` should be a whole number (at most 19 digits), found `NaN`";
    refused(folder.path(), &["convert", "a.h5", "a.npy"], &[says]);
    let said = good(folder.path(), &["convert", "a.h5", "a.npy", "--salvage"]);
    assert!(
        said.contains("damage   a.h5: event 1") && said.contains("1 event"),
        "{said}"
    );
    write(5, &[3.0, 2.0, t, 1.0, 0.0]);
    let says = "has `davis/right/events` of the shape (1, 5), not (N, 4)";
    refused(folder.path(), &["convert", "a.h5", "a.npy"], &[says]);
}

/// `v2e --dvs_h5`: rows of time, x, y and sign; pictures, where there are some, say the size.
#[test]
fn rows_of_v2e_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.h5");
    let write = |width: u64, values: &[u32], pictures: bool| {
        hdf5(&path, &[], |root| {
            column(root, "events", |rows| {
                let count = values.len() as u64 / width;
                rows.with_u32_data(values).with_shape(&[count, width]);
            });
            if pictures {
                column(root, "frame", |frames| {
                    frames.with_u8_data(&[0; 24]).with_shape(&[2, 3, 4]);
                });
            }
        });
        file::read(&path)
    };
    let values = [15, 3, 2, 0, 4_000_000_000, 0, 1, 1];
    let wanted = [(15, 3, 2, false), (4_000_000_000, 0, 1, true)];
    let loaded = write(4, &values, false).unwrap();
    assert_eq!((rows(&loaded), loaded.size_known), (wanted.to_vec(), false));
    let loaded = write(4, &values, true).unwrap();
    assert_eq!((rows(&loaded), loaded.size_known), (wanted.to_vec(), true));
    assert_eq!((loaded.packet.size, loaded.skipped), (Size::new(3, 4), 2));
    let error = write(2, &values, false).unwrap_err().to_string();
    assert!(
        error.contains("has `events` of the shape (4, 2), not (N, 4)"),
        "{error}"
    );
}

/// The layout of DSEC is in whole microseconds: a fraction of one, which was cut off, is refused.
#[test]
fn times_of_dsec_are_whole() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.h5");
    let write = |times: &[f64]| {
        hdf5(&path, &["events"], |root| {
            for name in ["events/x", "events/y", "events/p"] {
                short(root, name, &[1, 0]);
            }
            real(root, "events/t", times);
        });
        file::read(&path)
    };
    let error = write(&[0.25, 1.5]).unwrap_err().to_string();
    assert!(
        error.contains(": event 0: `t` should be a whole number (at most 19 digits), found `0.25`"),
        "{error}"
    );
    let loaded = write(&[250_000.0, 1_500_000.0]).unwrap();
    assert_eq!(rows(&loaded)[1].0, 1_500_000);
}

/// Of what begins in the first ten minutes times are absolute, as readers take them that add no
/// offset; later they count from the millisecond of the first event.
#[test]
fn what_begins_early_has_no_offset() {
    let folder = tempfile::tempdir().unwrap();
    let (csv, path) = (folder.path().join("a.csv"), folder.path().join("a.h5"));
    for (first, offset) in [
        (0, 0),
        (5_012_345, 0),
        (599_999_999, 0),
        (600_000_000, 600_000_000),
        (1_700_000_000_012_345, 1_700_000_000_012_000),
    ] {
        fs::write(
            &csv,
            format!("t,x,y,p\n{first},1,2,0\n{},3,4,1\n", first + 2100),
        )
        .unwrap();
        good(folder.path(), &["convert", "a.csv", "a.h5"]);
        let times: Vec<u64> = rows(&file::read(&path).unwrap())
            .iter()
            .map(|row| row.0)
            .collect();
        assert_eq!(times, [first, first + 2100]);
        let file = File::open(&path).unwrap();
        let numbers = |name: &str| file.dataset(name).unwrap().read_i64().unwrap();
        assert_eq!(numbers("t_offset"), [offset]);
        assert_eq!(numbers("events/t")[0], first as i64 - offset);
        let index = numbers("ms_to_idx");
        let since = first - offset as u64;
        let wanted = |ms: usize| i64::from(ms as u64 * 1000 > since);
        assert!((0..index.len()).all(|ms| index[ms] == wanted(ms)));
        assert_eq!(index.len() as u64, (since + 2100) / 1000 + 1);
    }
}

/// Times that need the bit of the sign are neither cut off nor negative; other columns are told.
#[test]
fn numbers_without_a_sign_keep_their_value() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.h5");
    hdf5(&path, &["events"], |root| {
        for name in ["events/x", "events/y", "events/p", "events/z"] {
            short(root, name, &[1, 0]);
        }
        column(root, "events/t", |times| {
            times.with_u64_data(&[1, (1 << 63) + 5]);
        });
    });
    let error = file::read(&path).unwrap_err().to_string();
    assert!(
        error.contains(": event 1: `t` is 9223372036854775813 us"),
        "{error}"
    );
    let path = data("unsigned.parquet");
    let loaded = file::read(&path).unwrap();
    let times: Vec<u64> = rows(&loaded).iter().map(|row| row.0).collect();
    assert_eq!(times, [3_000_000_000, 4_294_967_295]);
    let path = path.display().to_string();
    let said = json(folder.path(), &["convert", &path, "b.npy", "--json"]);
    let note = said["read"]["note"].as_str().unwrap();
    assert_eq!(
        note,
        "other columns than t, x, y, p and channel are left out"
    );
}

/// A file of polars, with compression="gzip".
#[cfg(feature = "parquet")]
#[test]
fn a_compression_that_is_not_read_is_named() {
    let error = file::read(Path::new("tests/bad/event/gzip.parquet")).unwrap_err();
    let says = "column `t` is stored in a way that is not read: its compression is GZIP";
    assert!(error.to_string().contains(says), "{error}");
    let help = error.help().unwrap().to_string();
    assert_eq!(help, "write it again with compression=\"zstd\"");
}

#[test]
fn nanoseconds_are_refused() {
    let error = file::read(Path::new("tests/bad/event/nanoseconds.parquet")).unwrap_err();
    let error = error.to_string();
    let says = "has a column `t` in nanoseconds: let it be whole microseconds";
    assert!(error.contains(says), "{error}");
}

/// A file that was cut anywhere is refused, or has all its events; a byte that was changed ends
/// nothing but the reading.
#[test]
fn cut_and_changed_files_are_survived() {
    for (name, stream) in [("event_utils.h5", None), ("mvsec.h5", Some(1))] {
        let how = Opening {
            stream,
            ..Opening::default()
        };
        let whole = std::fs::read(data(name)).unwrap();
        let read = |bytes: Vec<u8>| {
            let reader = Reader::of_bytes(Path::new("a.h5"), bytes, &how).ok()?;
            Some(file::all(reader))
        };
        let wanted = rows(&read(whole.clone()).unwrap().0);
        for cut in 0..whole.len() {
            if let Some((loaded, None)) = read(whole[..cut].to_vec()) {
                assert_eq!(rows(&loaded), wanted, "{name} cut at byte {cut}");
            }
            let mut changed = whole.clone();
            changed[cut] ^= 1 << (cut % 8);
            read(changed);
        }
    }
}
