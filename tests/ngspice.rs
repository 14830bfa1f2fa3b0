//! The resistor networks against ngspice, which knows nothing of them: operating points of 16x16
//! and 64x64 nodes with mismatch, transients of 16x16 and 32x32, and laterals that bend, agree to
//! 1e-9 of the signal's range. Needs `ngspice` (Debian: apt-get install ngspice; made with 39.3):
//! `cargo test --release --test ngspice -- --ignored`.
//!
//! ngspice leaks 1e-12 S from every node and stops at a part in 1000 unless told otherwise.
//! Its transient is stepped by the trapezoid rule, whose error falls with the square of the
//! step: two runs, one with half the step, are extrapolated to none.

use std::{fmt::Write, fs, process::Command};

use amacrine::{
    mesh::{Laterals, Mismatch, Network, Sheet},
    plane::{Plane, Size},
    rng::{mix, uniform},
};

fn scene(size: Size, seed: u64) -> Plane<f64> {
    Plane::from_shape_fn(size.shape(), |(y, x)| {
        uniform(mix(seed ^ mix((y * 65_536 + x) as u64 + 1)))
    })
}

fn chip(side: usize, seed: u64) -> Network {
    let mismatch = Mismatch {
        lateral: 0.2,
        transverse: 0.2,
        capacitance: 0.1,
    };
    let size = Size::new(side, side);
    let network = Network::uniform(Sheet::new(2.0).unwrap(), size).unwrap();
    network.with_mismatch(mismatch, seed)
}

/// The parts as a netlist. Signals go from `earlier` to `later` in one second.
fn netlist(
    network: &Network,
    laterals: Laterals,
    earlier: &Plane<f64>,
    later: &Plane<f64>,
) -> String {
    let mut text = String::from(
        "* a resistor sheet\n.options gmin=1e-18 abstol=1e-18 vntol=1e-16 itl1=1000\n",
    );
    let own = network.transverse();
    let capacitance = network.capacitance();
    let (down, across) = network.lateral();
    let lateral =
        |text: &mut String, name: &str, (y, x): (usize, usize), to: (usize, usize), g: f64| {
            let (a, b) = (format!("h{y}_{x}"), format!("h{}_{}", to.0, to.1));
            let _ = match laterals {
                Laterals::Linear => writeln!(text, "R{name}{y}_{x} {a} {b} {:e}", 1.0 / g),
                Laterals::Saturating { scale } => {
                    writeln!(
                        text,
                        "B{name}{y}_{x} {a} {b} I={:e}*tanh(V({a},{b})/{scale:e})",
                        g * scale
                    )
                }
                Laterals::Opening { scale } => {
                    writeln!(
                        text,
                        "B{name}{y}_{x} {a} {b} I={:e}*sinh(V({a},{b})/{scale:e})",
                        g * scale
                    )
                }
            };
        };
    for ((y, x), g) in own.indexed_iter() {
        let (from, to) = (earlier[[y, x]], later[[y, x]]);
        let _ = writeln!(text, "V{y}_{x} p{y}_{x} 0 PWL(0 {from:e} 1 {to:e})");
        let _ = writeln!(text, "R{y}_{x} p{y}_{x} h{y}_{x} {:e}", 1.0 / g);
        let _ = writeln!(text, "C{y}_{x} h{y}_{x} 0 {:e}", capacitance[[y, x]]);
        if y + 1 < own.nrows() {
            lateral(&mut text, "d", (y, x), (y + 1, x), down[[y, x]]);
        }
        if x + 1 < own.ncols() {
            lateral(&mut text, "a", (y, x), (y, x + 1), across[[y, x]]);
        }
    }
    text
}

/// Runs ngspice; the last line of its table as a plane.
fn ngspice(netlist: &str, size: Size, run: &str) -> Plane<f64> {
    let folder = tempfile::tempdir().unwrap();
    let nodes = |form: fn(usize, usize) -> String| -> Vec<String> {
        (0..size.pixels())
            .map(|i| form(i / size.width, i % size.width))
            .collect()
    };
    let saved = nodes(|y, x| format!("v(h{y}_{x})")).join(" ");
    // The operating point is found to all digits; a transient keeps to the step that is asked for.
    let tolerance = if run == "op" { "1e-12" } else { "1e-4" };
    let control = format!(
        ".options reltol={tolerance}\n.control\nset filetype=ascii\nset numdgt=17\nsave {saved}\n{run}\nwrite out.raw\nquit\n.endc\n.end\n"
    );
    fs::write(
        folder.path().join("sheet.cir"),
        format!("{netlist}{control}"),
    )
    .unwrap();
    let out = Command::new("ngspice")
        .args(["-b", "sheet.cir"])
        .current_dir(folder.path())
        .output()
        .expect("ngspice is installed: apt-get install ngspice");
    let raw = fs::read_to_string(folder.path().join("out.raw"))
        .unwrap_or_else(|e| panic!("{e}: {}", String::from_utf8_lossy(&out.stderr)));
    let (head, values) = raw.split_once("Values:\n").unwrap();
    // What each column is: `number name kind`.
    let names: Vec<&str> = head
        .split_once("Variables:\n")
        .unwrap()
        .1
        .lines()
        .filter_map(|line| line.split_whitespace().nth(1))
        .collect();
    let numbers: Vec<f64> = values
        .split_whitespace()
        .map(|v| v.parse().unwrap())
        .collect();
    // Each point begins with its number.
    let last = &numbers[numbers.len() - names.len()..];
    let value = |name: String| {
        let column = names.iter().position(|known| *known == name);
        last[column.unwrap_or_else(|| panic!("no {name}"))]
    };
    let values = nodes(|y, x| format!("v(h{y}_{x})")).into_iter().map(value);
    Plane::from_shape_vec(size.shape(), values.collect()).unwrap()
}

fn furthest(a: &Plane<f64>, b: &Plane<f64>) -> f64 {
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}

#[test]
#[ignore = "needs ngspice (apt-get install ngspice)"]
fn operating_points_agree() {
    for (side, seed) in [(16, 1), (16, 2), (64, 1), (64, 2)] {
        let network = chip(side, seed);
        let signal = scene(Size::new(side, side), seed);
        let settled = network.settle(&signal).unwrap().surround;
        let text = netlist(&network, Laterals::Linear, &signal, &signal);
        let error = furthest(&ngspice(&text, Size::of(&signal), "op"), &settled);
        println!("{side}x{side}: {error:e}");
        assert!(error < 1e-12, "{side}x{side}: {error:e}");
    }
}

#[test]
#[ignore = "needs ngspice (apt-get install ngspice)"]
fn transients_agree() {
    for (side, seed) in [(16, 3), (16, 4), (32, 3)] {
        let network = chip(side, seed);
        let size = Size::new(side, side);
        let (earlier, later) = (scene(size, seed), scene(size, !seed));
        let start = network.settle(&earlier).unwrap().surround;
        let moved = network.advance(&start, (&earlier, &later), 1.0).unwrap();
        let text = netlist(&network, Laterals::Linear, &earlier, &later);
        let run = |step: f64| ngspice(&text, size, &format!("tran {step} 1 0 {step}"));
        let (coarse, fine) = (run(0.005), run(0.0025));
        let steps = furthest(&fine, &moved);
        let error = furthest(&(&fine * (4.0 / 3.0) - &coarse * (1.0 / 3.0)), &moved);
        println!("{side}x{side}: {steps:e}, extrapolated {error:e}");
        assert!(error < 1e-9, "{side}x{side}: {error:e}");
    }
}

#[test]
#[ignore = "needs ngspice (apt-get install ngspice)"]
fn bending_laterals_agree() {
    let size = Size::new(16, 16);
    for laterals in [
        Laterals::Saturating { scale: 0.1 },
        Laterals::Opening { scale: 0.1 },
    ] {
        let network = chip(16, 5);
        let signal = scene(size, 5);
        let text = netlist(&network, laterals, &signal, &signal);
        let bent = network.with_laterals(laterals).unwrap();
        let settled = bent.settle(&signal).unwrap().surround;
        let error = furthest(&ngspice(&text, size, "op"), &settled);
        println!("{laterals:?}: {error:e}");
        assert!(error < 1e-9, "{laterals:?}: {error:e}");
    }
}
