//! The mesh as a drive: what the sensor fires on is `u - H`, to the event.

use super::{scene, sheet, solve};
use amacrine::{
    event::{Packet, Polarity},
    plane::{Plane, Size},
    reference::{Description, Reference},
    scene::Frame,
    sensor::Sensor,
};

fn description(mesh: &str, memory: &str) -> Description {
    let text = format!(
        "response = \"identity\"\nmemory = \"{memory}\"\n[[channel]]\nmesh = {mesh}\nthreshold = {{ on = 0.1, off = 0.12 }}"
    );
    Description::parse("test.toml", &text, &|_| unreachable!()).unwrap_or_else(|e| panic!("{e}"))
}

fn watch(mesh: &str, memory: &str, frames: &[Plane<f64>]) -> Packet {
    let size = Size::of(&frames[0]);
    let mut sensor = Reference::new(description(mesh, memory), size, 3).unwrap();
    let mut packet = Packet::new(size, 1);
    for (index, light) in (0..).zip(frames) {
        let frame = Frame {
            index,
            seconds: index as f64 * 1e-3,
            light: light.clone().into(),
        };
        sensor.watch(&frame, &mut packet).unwrap();
    }
    packet
}

/// Without a time constant the drive is the settled difference: the counts of a pixel are
/// those of a memory that steps after it.
#[test]
fn fires_on_the_difference() {
    for (height, width) in [(20, 31), (150, 90)] {
        let frames: Vec<_> = (0..4).map(|n| scene(height, width, n)).collect();
        let packet = watch("{ lambda = 3 }", "filtered-step", &frames);
        let drive = |p: &Plane<f64>| p - &solve(sheet(3.0), p);
        let mut memory = drive(&frames[0]);
        let mut net = Plane::<i64>::zeros((height, width));
        for frame in &frames[1..] {
            for ((at, s), memory) in drive(frame).indexed_iter().zip(&mut memory) {
                let theta = if s > memory { 0.1 } else { 0.12 };
                let count = ((s - *memory).abs() / theta).floor() * (s - *memory).signum();
                *memory += count * theta;
                net[at] += count as i64;
            }
        }
        let mut got = Plane::<i64>::zeros((height, width));
        for event in &packet.events {
            let at = (usize::from(event.y), usize::from(event.x));
            got[at] += if event.polarity == Polarity::On {
                1
            } else {
                -1
            };
        }
        assert!(packet.events.len() > 100);
        assert_eq!(got, net);
    }
}

/// A still scene, however textured, is still from the first frame on; v2e's is not.
#[test]
fn still_scenes_are_still() {
    let still = vec![scene(24, 24, 9); 6];
    for memory in ["filtered-step", "filtered-snap"] {
        for mesh in [
            "{ lambda = 10, tau-us = 500 }",
            "{ lambda = 3, tau-us = 0, rule = \"step\" }",
        ] {
            assert_eq!(watch(mesh, memory, &still).events.len(), 0);
        }
    }
    let v2e = watch(
        "{ lambda = 10, tau-us = 500, rule = \"v2e\" }",
        "filtered-step",
        &still,
    );
    assert!(v2e.events.len() > 100, "{}", v2e.events.len());
    // Noise of the resistors: a unit of kT/C well below the thresholds, and well above.
    let quiet = watch(
        "{ lambda = 3, tau-us = 500, noise = 0.001 }",
        "filtered-step",
        &still,
    );
    let loud = watch(
        "{ lambda = 3, tau-us = 500, noise = 0.2 }",
        "filtered-step",
        &still,
    );
    assert_eq!(quiet.events.len(), 0);
    assert!(loud.events.len() > 500, "{}", loud.events.len());
}

/// A uniform flicker passes until the sheet has followed: `dP exp(-t/τ)`.
#[test]
fn flicker_fades_with_tau() {
    let frames = [0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0].map(|v| Plane::from_elem((3, 4), v));
    let packet = watch(
        "{ lambda = 10, tau-us = 2000, rule = \"step\" }",
        "filtered-snap",
        &frames,
    );
    let at = |t: u64| {
        packet
            .events
            .iter()
            .filter(|e| e.t.0 == t && e.x == 2 && e.y == 1)
            .count()
    };
    // exp(-1/2), then differences from the frame that last fired, against 0.12.
    let mut memory = 0.0f64;
    for n in 1..7u64 {
        let drive = (-(n as f64) * 0.5).exp();
        let fires = drive - memory > 0.1 || memory - drive > 0.12;
        if fires {
            memory = drive;
        }
        assert_eq!(at(n * 1000), usize::from(fires), "frame {n}");
    }
}

#[test]
fn two_sheets_are_the_sum_of_two() {
    let frames: Vec<_> = (0..3).map(|n| scene(16, 16, n)).collect();
    let one = watch("{ lambda = 3 }", "filtered-snap", &frames);
    let same = watch(
        "{ centre = 2, sheets = [{ gain = -1, lambda = 3 }, { gain = -1, lambda = 0 }] }",
        "filtered-snap",
        &frames,
    );
    assert_eq!(one, same);
    let other = watch(
        "{ centre = 0, sheets = [{ gain = 1, lambda = 1 }, { gain = -1, lambda = 4 }] }",
        "filtered-snap",
        &frames,
    );
    assert_ne!(one, other);
}

#[test]
fn what_makes_no_sense_is_refused() {
    let message = |mesh: &str, rest: &str, memory: &str| {
        let text = format!(
            "response = \"identity\"\nmemory = \"{memory}\"\n[[channel]]\nmesh = {mesh}\n{rest}\nthreshold = {{ on = 0.1, off = 0.1 }}"
        );
        let refused = Description::parse("t.toml", &text, &|_| unreachable!());
        refused.unwrap_err().to_string()
    };
    let step = "filtered-step";
    for (mesh, rest, memory, want) in [
        (
            "{ lambda = -1 }",
            "",
            step,
            "t.toml:4:19: `mesh.lambda` is -1",
        ),
        ("{ lambda = nan }", "", step, "`mesh.lambda` is NaN"),
        (
            "{ lambda = 1, tau-us = -5 }",
            "",
            step,
            "t.toml:4:31: `mesh.tau-us` is -5",
        ),
        (
            "{ lambda = 1, noise = inf }",
            "",
            step,
            "`mesh.noise` is inf",
        ),
        ("{ }", "", step, "missing key `lambda`, `sheets`"),
        (
            "{ lambda = 1, sheets = [{ gain = 1, lambda = 1 }] }",
            "",
            step,
            "only one of `lambda`, `sheets` can be given",
        ),
        (
            "{ tau-us = 3, sheets = [{ gain = 1, lambda = 2 }] }",
            "",
            step,
            "tau-us stands beside sheets",
        ),
        (
            "{ lambda = 1, lambda-y = 2, rule = \"v2e\" }",
            "",
            step,
            "v2e's sheet has one space constant",
        ),
        (
            "{ lambda = 1, colour = 2 }",
            "",
            step,
            "unknown key `colour`",
        ),
        (
            "{ lambda = 1, rule = \"crank\" }",
            "",
            step,
            "unknown value `crank`",
        ),
        (
            "{ lambda = 1, centre = 1e300 }",
            "gain = 1e300",
            step,
            "mesh.centre, times the channel's gain, is inf",
        ),
        (
            "{ lambda = 1 }",
            "kernel = \"dvs\"",
            step,
            "only one of `kernel`, `mesh` can be given",
        ),
        (
            "{ lambda = 1 }",
            "pattern = \"2x2\"",
            step,
            "a mesh stands in place of a kernel",
        ),
        (
            "{ lambda = 1 }",
            "",
            "raw-snap",
            "a mesh stands in place of a kernel",
        ),
    ] {
        let got = message(mesh, rest, memory);
        assert!(got.contains(want), "{got}, not {want}");
    }
}
