//! What the parts of a model cost: the numbers of `src/study/plan/costs.toml`, in nanoseconds
//! of one core, as differences between a sensor with the part and one without.

use std::time::Instant;

use amacrine::{
    event::{Packet, readout},
    number::{F16, F32, F64, Number},
    plane::Size,
    reference::{Description, Reference},
    scene::{Frame, OpenOptions, open},
    sensor::Sensor,
};

const SIZE: Size = Size::new(256, 256);

/// Drifting blobs in whole steps of light, as video has it.
fn frames() -> Vec<Frame> {
    let spec = "pattern:noise?width=256&height=256&frames=17&fps=1000&speed=300";
    let mut scene = open(spec, &OpenOptions::default()).expect("the pattern");
    let mut frames = Vec::new();
    while let Some(mut frame) = scene.next_frame().expect("a frame") {
        frame.light.mapv_inplace(f64::round);
        frames.push(frame);
    }
    frames
}

/// Nanoseconds of each pixel and pair of frames, the least of all pairs of many runs, and what
/// was seen.
fn time<N: Number>(number: N, text: &str, frames: &[Frame]) -> (f64, Packet) {
    let none = |_: &str| Err(std::io::Error::other("no file is needed"));
    let description = Description::parse("bench", text, &none).expect("a sensor");
    let mut least = f64::INFINITY;
    let mut packet = Packet::new(SIZE, 1);
    for _ in 0..15 {
        let sensor = Reference::with_number(number, description.clone(), SIZE, 0);
        let mut sensor = sensor.expect("a sensor");
        packet = Packet::new(SIZE, 1);
        sensor
            .watch(&frames[0], &mut packet)
            .expect("the first frame");
        for frame in &frames[1..] {
            let start = Instant::now();
            sensor.watch(frame, &mut packet).expect("a frame");
            least = least.min(start.elapsed().as_secs_f64());
        }
    }
    (least * 1e9 / SIZE.pixels() as f64, packet)
}

fn main() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1);
    pool.build_global().expect("one thread");
    let frames = frames();
    let sensor = |keys: &str, channel: &str, threshold: f64| {
        format!(
            "response = {{ linear = 255 }}\nmemory = \"filtered-step\"\n{keys}\n[[channel]]\n{channel}\nthreshold = {{ on = {threshold}, off = {threshold} }}\n"
        )
    };
    let dvs = |keys: &str, threshold: f64| sensor(keys, "kernel = \"dvs\"", threshold);
    let silent = dvs("", 100.0);
    let csdvs = sensor("", "kernel = \"csdvs-5\"", 100.0);
    let mesh = |more: &str| sensor("", &format!("mesh = {{ lambda = 3{more} }}"), 100.0);
    let least = |text: &str| time(F64, text, &frames).0;
    let one = least(&silent);
    let part = |name: &str, ns: f64| println!("{name:<12} {ns:8.2}");
    for (name, cell, taps) in [
        ("f64", one, least(&csdvs)),
        (
            "f32",
            time(F32, &silent, &frames).0,
            time(F32, &csdvs, &frames).0,
        ),
        (
            "other",
            time(F16, &silent, &frames).0,
            time(F16, &csdvs, &frames).0,
        ),
    ] {
        let tap = (taps - cell) / 24.0;
        part(&format!("cell {name}"), cell - tap);
        part(&format!("tap {name}"), tap);
    }
    let mismatch = silent.replace("off = 100", "off = 100, sigma = 0.001");
    part(
        "low-pass",
        least(&dvs("noise = { cutoff-hz = 300 }", 100.0)) - one,
    );
    part(
        "refractory",
        least(&dvs("refractory = { us = 500 }", 100.0)) - one,
    );
    part("mismatch", least(&mismatch) - one);
    part(
        "strays",
        least(&dvs("noise = { shot-hz = 1 }", 100.0)) - one,
    );
    part(
        "jitter",
        least(&dvs("noise = { jitter-us = 10 }", 100.0)) - one,
    );
    part("sheet", least(&mesh("")) - one);
    part(
        "settling",
        least(&mesh(", tau-us = 500")) - least(&mesh("")),
    );
    part(
        "sheet-noise",
        least(&mesh(", noise = 0.001")) - least(&mesh("")),
    );
    let (busy, mut packet) = time(F64, &dvs("", 0.03), &frames);
    let cells = (SIZE.pixels() * (frames.len() - 1)) as f64;
    let events = packet.events.len() as f64;
    part("event", (busy - one) * cells / events);
    let arbiter = readout::settings::Description::shipped("arbiter").expect("a readout");
    let arbiter = arbiter.readout().expect("a readout");
    packet.events.truncate(1 << 14);
    let mut least = f64::INFINITY;
    for _ in 0..30 {
        let start = Instant::now();
        let read = arbiter.read(&packet);
        least = least.min(start.elapsed().as_secs_f64());
        assert_eq!(read.statistics.events[0], packet.events.len() as u64);
    }
    part("readout", least * 1e9 / packet.events.len() as f64);
}
