//! Events a second of each event format, read and written, the median of many repetitions, next
//! to a plain copy of the same bytes in memory and to the format's Python reader, where
//! python3 has one (`tests/interop/requirements.txt`).
//!
//! `AMACRINE_BENCH=quick` takes seconds. Further arguments choose formats by their name.

#[path = "common/timed.rs"]
mod timed;

use std::{hint::black_box, path::Path, process::Command, time::Duration};

use amacrine::{
    event::{
        Event, Packet, Polarity,
        file::{self, Compression, Format, Opening, Reader},
    },
    plane::Size,
    unit::Micros,
};

use crate::timed::Timed;

/// Seconds of the median of several readings of one file, by the line that opens it.
const PYTHON: &str = r"
import sys, time
module, line, path = sys.argv[1:]
scope = {}
try:
    exec('import ' + module, scope)
    seconds = []
    for _ in range(5):
        start = time.perf_counter()
        scope['events'] = eval(line, scope, {'path': path})
        # An archive is read when its arrays are asked for.
        if hasattr(scope['events'], 'files'):
            scope['events'] = [scope['events'][name] for name in scope['events'].files]
        seconds.append(time.perf_counter() - start)
    print(sorted(seconds)[2])
except ImportError:
    pass
";

fn main() {
    let quick = std::env::var("AMACRINE_BENCH").as_deref() == Ok("quick");
    let (events, seconds) = if quick {
        (200_000, 0.05)
    } else {
        (1_000_000, 2.0)
    };
    let wanted: Vec<String> = std::env::args()
        .skip(1)
        .filter(|argument| !argument.starts_with('-'))
        .collect();
    let packet = packet(events);
    let folder = tempfile::tempdir().expect("a folder for temporary files");
    println!("{}", timed::cpu());
    println!(
        "{events} events, 640x480, half of them in runs along a row; medians over {seconds} s"
    );
    println!("million events a second; copy: the file's bytes copied in memory; bytes an event");
    println!(
        "{:<8} {:>7} {:>14} {:>14} {:>10} {:>8} {:>8}",
        "format", "bytes", "write", "read", "copy", "python", "ratio"
    );
    for &format in Format::ALL {
        if !wanted.is_empty() && !wanted.iter().any(|name| name == format.name()) {
            continue;
        }
        let extension = match format.extension() {
            extension if extension == format.name() => String::new(),
            extension => format!(".{extension}"),
        };
        let path = folder.path().join(format!("a.{format}{extension}"));
        let write = || file::write_as(&path, format, Compression::default(), &packet);
        if let Err(error) = write() {
            println!("{format:<8} {error}");
            continue;
        }
        let write = timed(seconds, || write().expect("written before"));
        let bytes = std::fs::read(&path).expect("just written");
        let read = timed(seconds, || count(&path, format, events));
        let mut target = vec![0_u8; bytes.len()];
        let copy = timed(seconds, || {
            target.copy_from_slice(black_box(&bytes));
            black_box(&target);
        });
        let rate = |seconds: f64| events as f64 / seconds / 1e6;
        let spread = |time: Timed| format!("{:.1} {:>5}", rate(time.median), time.plus_minus());
        let python = python(format, &path);
        println!(
            "{format:<8} {:>7.2} {:>14} {:>14} {:>10.0} {:>8} {:>8}",
            bytes.len() as f64 / events as f64,
            spread(write),
            spread(read),
            rate(copy.median),
            python.map_or("-".into(), |seconds| format!("{:.1}", rate(seconds))),
            python.map_or("-".into(), |seconds| format!(
                "{:.1}x",
                seconds / read.median
            )),
        );
    }
}

/// The time of a call over so many seconds.
fn timed(seconds: f64, call: impl FnMut()) -> Timed {
    Timed::new(5, Duration::from_secs_f64(seconds), call)
}

/// Reads a file as a stream.
fn count(path: &Path, format: Format, events: usize) {
    let opening = Opening {
        format: Some(format),
        ..Opening::default()
    };
    let mut reader = Reader::open(path, &opening).expect("just written");
    let (mut block, mut sum) = (Vec::new(), 0);
    while reader.next_block(&mut block).expect("just written") {
        sum += black_box(&block).len();
    }
    assert_eq!(sum, events, "{format}");
}

/// Seconds that Python takes for the documented line; `None` without the reader.
fn python(format: Format, path: &Path) -> Option<f64> {
    let out = Command::new("python3")
        .args([
            "-W",
            "ignore",
            "-c",
            PYTHON,
            format.module(),
            format.python(),
        ])
        .arg(path)
        .output()
        .ok()?;
    String::from_utf8(out.stdout).ok()?.trim().parse().ok()
}

/// Single events and runs along a row, as an edge that moves makes them.
fn packet(count: usize) -> Packet {
    let size = Size::new(480, 640);
    let mut packet = Packet::new(size, 1);
    let mut t = 0;
    while packet.events.len() < count {
        let i = packet.events.len() as u64;
        let h = (i ^ i >> 5).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 20;
        t += h >> 36 & 7;
        let run = if h & 1 == 0 { 1 } else { 1 + (h >> 1 & 15) };
        let (x, y) = (h % 620, h / 640 % 480);
        for step in 0..run.min((count - packet.events.len()) as u64) {
            packet.events.push(Event {
                t: Micros(t),
                x: (x + step) as u16,
                y: y as u16,
                polarity: if h >> 40 & 1 == 1 {
                    Polarity::On
                } else {
                    Polarity::Off
                },
                channel: 0,
            });
        }
    }
    packet.span = (Micros(0), Micros(t));
    packet
}
