//! The proof of the idea: with a memory that snaps to the filtered signal, one decision a
//! frame, and a kernel whose weights the program computes exactly, the float reference and a
//! program on the array in the `Exact` domain emit identical packets. Random clips, kernels,
//! thresholds and array sizes, and every shipped program that says what it computes.

use std::{collections::BTreeMap, fmt::Write as _, fs, path::Path};

use amacrine::{
    array::{Chip, Exact, Settings},
    event::Packet,
    isa::Device,
    plane::{Plane, Size},
    program::{Overrides, Program},
    reference::{Description, Reference},
    scene::Frame,
    sensor::Sensor,
};
use proptest::prelude::*;

/// The simplest program of a kernel of small whole weights: a shifted copy for each tap, added
/// or subtracted as often as its weight says. A is the light, B the drive, E minus the memory,
/// F minus the threshold.
fn snake(kernel: &[Vec<i32>]) -> String {
    let reach = (kernel.len() as isize / 2, kernel[0].len() as isize / 2);
    let mut filter = "    get_image(A);\n    res(B);\n".to_owned();
    for (y, row) in kernel.iter().enumerate() {
        for (x, &weight) in row.iter().enumerate() {
            if weight == 0 {
                continue;
            }
            let (dy, dx) = (y as isize - reach.0, x as isize - reach.1);
            filter += "    mov(C, A);\n";
            for _ in 0..dx.abs() {
                let _ = writeln!(
                    filter,
                    "    movx(C, C, {});",
                    if dx > 0 { "east" } else { "west" }
                );
            }
            for _ in 0..dy.abs() {
                let _ = writeln!(
                    filter,
                    "    movx(C, C, {});",
                    if dy > 0 { "south" } else { "north" }
                );
            }
            for _ in 0..weight.abs() {
                let _ = writeln!(
                    filter,
                    "    {}(B, B, C);",
                    if weight > 0 { "add" } else { "sub" }
                );
            }
        }
    }
    format!(
        "const threshold = 1;\n\
         init {{\n{filter}    neg(E, B);\n}}\n\
         frame {{\n{filter}\
         scamp5_in(F, -threshold);\n\
         bus(NEWS);\n\
         bus(C, NEWS, B, E);\n\
         where(C, F);\n\
         MOV(R6, FLAG);\n\
         where(B, E, F);\n\
         MOV(R5, FLAG);\n\
         WHERE(R5, R6);\n\
         neg(E, B);\n\
         all();\n\
         scamp5_scan_events(R5, on, 4000);\n\
         scamp5_scan_events(R6, off, 4000);\n}}\n"
    )
}

/// The float model of the same.
fn sensor(kernel: &[Vec<f64>], scale: f64, threshold: f64) -> Description {
    let text = format!(
        "response = {{ linear = {:?} }}\nmemory = \"filtered-snap\"\nborder = \"zero\"\n\
         [[channel]]\nkernel = {kernel:?}\nthreshold = {{ on = {threshold:?}, off = {threshold:?} }}\n",
        1.0 / scale,
    );
    Description::parse("sensor", &text, &|_| unreachable!()).unwrap()
}

fn watch(sensor: &mut dyn Sensor, clip: &[Plane<f64>], fps: f64) -> Packet {
    let mut packet = Packet::new(sensor.size(), sensor.channels());
    for (index, light) in clip.iter().enumerate() {
        let seconds = index as f64 / fps;
        let frame = Frame {
            index: index as u64,
            seconds,
            light: light.clone().into(),
        };
        sensor.watch(&frame, &mut packet).unwrap();
    }
    packet
}

/// Both packets, ties in one order.
fn both(
    program: &str,
    overrides: &Overrides,
    description: Description,
    clip: &[Plane<f64>],
    fps: f64,
) -> [Packet; 2] {
    let device = Device::scamp5();
    let size = Size::of(&clip[0]);
    let program = Program::parse("program", program).unwrap();
    let code = program
        .expand(&device, overrides)
        .unwrap_or_else(|e| panic!("{e:?}"))
        .code;
    let mut chip = Chip::new(
        "chip",
        Exact,
        &code,
        &device,
        size,
        Settings::from_device(&device),
    )
    .unwrap();
    let mut reference = Reference::new(description, size, 0).unwrap();
    let mut packets = [
        watch(&mut reference, clip, fps),
        watch(&mut chip, clip, fps),
    ];
    for packet in &mut packets {
        packet.events = packet.canonical();
    }
    packets
}

/// Light in eighths, so that every sum is exact; mostly still, as scenes are.
fn clips() -> impl Strategy<Value = Vec<Plane<f64>>> {
    let size = prop_oneof![(1usize..=4, 1usize..=4), (1usize..=50, 1usize..=70)];
    (size, 2usize..6, any::<u64>(), 1u64..8).prop_map(|((height, width), frames, seed, busy)| {
        let mut state = seed;
        let mut next = move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            state >> 33
        };
        let mut light = Plane::from_shape_fn((height, width), |_| (next() % 2048) as f64 / 8.0);
        let mut clip = vec![light.clone()];
        for _ in 1..frames {
            light.mapv_inplace(|v| {
                if next() % 8 < busy {
                    (next() % 2048) as f64 / 8.0
                } else {
                    v
                }
            });
            clip.push(light.clone());
        }
        clip
    })
}

fn kernels() -> impl Strategy<Value = Vec<Vec<i32>>> {
    (0usize..=2, 0usize..=2).prop_flat_map(|(ry, rx)| {
        let row = proptest::collection::vec(-2i32..=2, 2 * rx + 1);
        proptest::collection::vec(row, 2 * ry + 1)
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn random_kernels_emit_identical_packets(clip in clips(), kernel in kernels(), quarters in 1u32..400, fps in 1u32..5000) {
        let threshold = f64::from(quarters) / 4.0;
        let weights: Vec<Vec<f64>> = kernel.iter().map(|row| row.iter().map(|w| f64::from(*w)).collect()).collect();
        let overrides = Overrides::from([("threshold".to_owned(), threshold)]);
        // get_image gives half the light.
        let description = sensor(&weights, 0.5, threshold);
        let [reference, chip] = both(&snake(&kernel), &overrides, description, &clip, f64::from(fps));
        prop_assert_eq!(reference, chip);
    }

    #[test]
    fn shipped_programs_emit_identical_packets(clip in clips(), which in 0usize..64, quarters in 1u32..64) {
        let programs = shipped();
        let (name, text) = &programs[which % programs.len()];
        let program = Program::parse(name, text).unwrap();
        let computes = program.settings.computes.clone().unwrap();
        let threshold = f64::from(quarters) / 4.0;
        let overrides = Overrides::from([(computes.threshold.unwrap(), threshold)]);
        let description = sensor(&computes.kernel, computes.scale, threshold);
        let [reference, chip] = both(text, &overrides, description, &clip, 240.0);
        prop_assert_eq!(reference, chip, "{}", name);
    }
}

/// Every program that says which kernel and threshold it computes with.
fn shipped() -> Vec<(String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("programs");
    let mut found = BTreeMap::new();
    for folder in fs::read_dir(root).unwrap() {
        for file in fs::read_dir(folder.unwrap().path()).unwrap() {
            let path = file.unwrap().path();
            let text = fs::read_to_string(&path).unwrap();
            let name = path.display().to_string();
            let computes = Program::parse(&name, &text).unwrap().settings.computes;
            if computes.is_some_and(|computes| computes.threshold.is_some()) {
                found.insert(name, text);
            }
        }
    }
    assert!(found.len() >= 2, "{:?}", found.keys());
    found.into_iter().collect()
}

/// What the property means on one pixel: it decides by `>`, when the frame is taken.
#[test]
fn a_tie_does_not_fire_and_one_more_does() {
    let clip = |last: f64| {
        vec![
            Plane::from_elem((1, 1), 100.0),
            Plane::from_elem((1, 1), last),
        ]
    };
    let text = snake(&[vec![1]]);
    let overrides = Overrides::from([("threshold".to_owned(), 10.0)]);
    for (last, events) in [(120.0, 0), (120.125, 1), (80.0, 0), (79.875, 1)] {
        let [reference, chip] = both(
            &text,
            &overrides,
            sensor(&[vec![1.0]], 0.5, 10.0),
            &clip(last),
            10.0,
        );
        assert_eq!(reference, chip);
        assert_eq!(reference.events.len(), events, "to {last}");
        assert!(reference.events.iter().all(|e| e.t.0 == 100_000));
    }
}
