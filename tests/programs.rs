//! Proves what every program of `programs/` computes: against a twin in plain Rust that knows
//! planes and nothing of the chip, on the bundled clip and on the edge cases of pictures, to
//! the bit in `exact`; and that each runs in `q8.8` and `silicon`.

use std::{collections::BTreeMap, fs, path::Path};

use amacrine::{
    array::{Arithmetic, Array, Readings, Settings},
    event::{Packet, Polarity},
    isa::{Bit, Device, Source, Value},
    plane::{Plane, Size},
    program::{Program, Window},
    scene::{OpenOptions, open},
    unit::Micros,
};

type Light = Plane<f64>;
type Bits = Plane<bool>;

/// What a twin says of one frame.
#[derive(Default)]
struct Told {
    analog: Vec<(&'static str, Light)>,
    bits: Vec<(&'static str, Bits)>,
    /// Pixels that are read out as ON and as OFF events.
    events: Option<(Bits, Bits)>,
    readings: Vec<Readings>,
}

type Twin = fn(&[Light]) -> Vec<Told>;

/// Every program with its twin. One that is missing here fails the test.
const TWINS: &[(&str, Twin)] = &[
    ("capture/knee", knee),
    ("capture/local_threshold", local_threshold),
    ("capture/overview", overview),
    ("convolve/diffusion", diffusion),
    ("convolve/edges", edges),
    ("convolve/gaussian", gaussian),
    ("convolve/sobel", sobel),
    ("dvs/activity_filter", activity_filter),
    ("dvs/snap", snap),
    ("features/corners", corners),
    ("motion/background", background),
    ("motion/bounding_box", bounding_box),
    ("motion/frame_difference", frame_difference),
    ("regions/fill_holes", fill_holes),
    ("regions/flood", flood),
    ("regions/shift", shift),
    ("rgc/binary", binary),
    ("rgc/centre_surround", centre_surround),
    ("rgc/direction", direction),
];

// ---- plain arithmetic on planes ---------------------------------------------------------

fn at<T: Copy>(plane: &Plane<T>, (y, x): (usize, usize), dy: isize, dx: isize, outside: T) -> T {
    let place = (y as isize + dy, x as isize + dx);
    let (Ok(y), Ok(x)) = (usize::try_from(place.0), usize::try_from(place.1)) else {
        return outside;
    };
    plane.get((y, x)).copied().unwrap_or(outside)
}

fn map<T: Copy, U>(plane: &Plane<T>, value: impl Fn((usize, usize)) -> U) -> Plane<U> {
    Plane::from_shape_fn(plane.dim(), value)
}

/// As `get_image` gives it.
fn image(light: &Light) -> Light {
    light.mapv(|l| l / 2.0)
}

fn minus(a: &Light, b: &Light) -> Light {
    a - b
}

fn above(a: &Light, level: f64) -> Bits {
    a.mapv(|v| v > level)
}

fn and(a: &Bits, b: &Bits) -> Bits {
    map(a, |p| a[p] && b[p])
}

fn or(a: &Bits, b: &Bits) -> Bits {
    map(a, |p| a[p] || b[p])
}

const FOUR: [(isize, isize); 4] = [(-1, 0), (0, 1), (1, 0), (0, -1)];

fn any_neighbour(bits: &Bits) -> Bits {
    map(bits, |p| {
        FOUR.iter().any(|(dy, dx)| at(bits, p, *dy, *dx, false))
    })
}

/// One step of the resistor net: an eighth of the difference flows along each open link.
fn spread(plane: &Light, open: impl Fn((usize, usize), (isize, isize)) -> bool) -> Light {
    map(plane, |p| {
        let own = plane[p];
        let flow = FOUR.iter().filter(|way| open(p, **way));
        own + flow
            .map(|(dy, dx)| (at(plane, p, *dy, *dx, own) - own) / 8.0)
            .sum::<f64>()
    })
}

fn correlate<const N: usize>(plane: &Light, kernel: [[i32; N]; N]) -> Light {
    let middle = (N / 2) as isize;
    map(plane, |p| {
        let mut sum = 0.0;
        for (j, row) in kernel.iter().enumerate() {
            for (i, weight) in row.iter().enumerate() {
                let (dy, dx) = (j as isize - middle, i as isize - middle);
                sum += f64::from(*weight) * at(plane, p, dy, dx, 0.0);
            }
        }
        sum
    })
}

/// All that can be reached from `seeds` through `mask`, in so many steps.
fn reached(seeds: &Bits, mask: &Bits, steps: usize) -> Bits {
    let mut found = seeds.clone();
    let mut front: Vec<(usize, usize)> = found
        .indexed_iter()
        .filter(|(_, b)| **b)
        .map(|(p, _)| p)
        .collect();
    for _ in 0..steps {
        let mut next = Vec::new();
        for p in front {
            for (dy, dx) in FOUR {
                let (y, x) = (p.0.wrapping_add_signed(dy), p.1.wrapping_add_signed(dx));
                if mask.get((y, x)) == Some(&true) && !found[(y, x)] {
                    found[(y, x)] = true;
                    next.push((y, x));
                }
            }
        }
        front = next;
    }
    found
}

fn none(plane: &Light) -> Bits {
    map(plane, |_| false)
}

// ---- the twins --------------------------------------------------------------------------

fn each(clip: &[Light], of: impl Fn(&Light) -> Told) -> Vec<Told> {
    clip.iter().map(|light| of(&image(light))).collect()
}

/// The first frame, then every later one with what is remembered.
fn remembering<M>(
    clip: &[Light],
    first: impl Fn(&Light) -> M,
    later: impl Fn(&mut M, &Light) -> Told,
) -> Vec<Told> {
    let mut memory = first(&image(&clip[0]));
    let mut told = vec![Told::default()];
    told.extend(clip[1..].iter().map(|l| later(&mut memory, &image(l))));
    told
}

fn knee(clip: &[Light]) -> Vec<Told> {
    each(clip, |x| Told {
        analog: vec![(
            "B",
            x.mapv(|x| if x < 42.0 { 2.0 * x } else { x / 2.0 + 63.0 }),
        )],
        ..Told::default()
    })
}

fn local_threshold(clip: &[Light]) -> Vec<Told> {
    each(clip, |x| {
        let inside = |p: (usize, usize), (dy, dx): (isize, isize)| at(x, p, dy, dx, -1.0) >= 0.0;
        let mean = (0..8).fold(x.clone(), |mean, _| spread(&mean, inside));
        Told {
            bits: vec![("R5", above(&minus(x, &mean), 4.0))],
            analog: vec![("B", mean)],
            ..Told::default()
        }
    })
}

/// The ADC: to the nearest, halves to even.
fn adc(value: f64) -> u8 {
    (value + 128.0).round_ties_even().clamp(0.0, 255.0) as u8
}

fn overview(clip: &[Light]) -> Vec<Told> {
    each(clip, |x| {
        let (height, width) = x.dim();
        let mean = |ys: std::ops::Range<usize>, xs: std::ops::Range<usize>| {
            let count = (ys.len() * xs.len()) as f64;
            let part = x.slice(ndarray::s![ys, xs]);
            part.sum() / count
        };
        let span = |i: usize, n: usize| i * n / 8..((i + 1) * n / 8).max(i * n / 8 + 1).min(n);
        let mut values = Vec::new();
        for row in 0..8 {
            for column in 0..8 {
                // Columns are counted from the right.
                let columns = span(column, width);
                let columns = width - columns.end..width - columns.start;
                values.push(adc(mean(span(row, height), columns)));
            }
        }
        Told {
            bits: vec![("R5", above(x, 95.0))],
            readings: vec![
                Readings::Analog { columns: 8, values },
                Readings::Sum(adc(mean(0..height, 0..width)).into()),
                Readings::Any(x.iter().any(|v| *v > 95.0)),
            ],
            ..Told::default()
        }
    })
}

fn diffusion(clip: &[Light]) -> Vec<Told> {
    each(clip, |x| {
        let step = |dy, dx| map(x, |p| (at(x, p, dy, dx, 0.0) - x[p]).abs() > 12.0);
        let (cut_east, cut_south) = (step(0, 1), step(1, 0));
        let open = |p: (usize, usize), (dy, dx): (isize, isize)| {
            let cut = if dx == 0 { &cut_south } else { &cut_east };
            // Both ends of a link must conduct.
            !cut[p] && !at(cut, p, dy, dx, true)
        };
        Told {
            analog: vec![("F", (0..6).fold(x.clone(), |f, _| spread(&f, open)))],
            ..Told::default()
        }
    })
}

fn edges(clip: &[Light]) -> Vec<Told> {
    each(clip, |x| {
        let across = |p, dy: isize, dx: isize| {
            let (there, back) = (at(x, p, dy, dx, 0.0), at(x, p, -dy, -dx, 0.0));
            (there - back).abs()
        };
        Told {
            bits: vec![("R5", map(x, |p| across(p, 0, 1) + across(p, 1, 0) > 20.0))],
            ..Told::default()
        }
    })
}

fn gaussian(clip: &[Light]) -> Vec<Told> {
    each(clip, |x| Told {
        analog: vec![("A", correlate(x, [[1, 2, 1], [2, 4, 2], [1, 2, 1]]) / 16.0)],
        ..Told::default()
    })
}

fn sobel(clip: &[Light]) -> Vec<Told> {
    each(clip, |x| Told {
        analog: vec![(
            "D",
            correlate(x, [[-1, 0, 1], [-2, 0, 2], [-1, 0, 1]]) / 4.0,
        )],
        ..Told::default()
    })
}

/// What moved by more than a threshold since it was last said; the memory follows there.
fn crossings(memory: &mut Light, drive: &Light, threshold: f64) -> (Bits, Bits) {
    let moved = minus(drive, memory);
    let (on, off) = (above(&moved, threshold), above(&-&moved, threshold));
    *memory = map(
        drive,
        |p| {
            if on[p] || off[p] { drive[p] } else { memory[p] }
        },
    );
    (on, off)
}

fn snap(clip: &[Light]) -> Vec<Told> {
    remembering(clip, Light::clone, |memory, x| {
        let (on, off) = crossings(memory, x, 10.0);
        Told {
            analog: vec![("E", -&*memory)],
            events: Some((on, off)),
            ..Told::default()
        }
    })
}

fn activity_filter(clip: &[Light]) -> Vec<Told> {
    let first = |x: &Light| (x.clone(), none(x));
    remembering(clip, first, |(memory, before), x| {
        let (on, off) = crossings(memory, x, 10.0);
        let now = or(&on, &off);
        let company = any_neighbour(&or(&now, before));
        *before = now;
        Told {
            events: Some((and(&on, &company), and(&off, &company))),
            ..Told::default()
        }
    })
}

/// Frames are told apart by a filter that sees the light about its middle grey.
fn ganglion(clip: &[Light], kernel: [[i32; 5]; 5]) -> Vec<Told> {
    let drive = |x: &Light| correlate(&x.mapv(|x| (x - 64.0) / 16.0), kernel);
    remembering(clip, drive, |memory, x| Told {
        events: Some(crossings(memory, &drive(x), 4.0)),
        ..Told::default()
    })
}

fn centre_surround(clip: &[Light]) -> Vec<Told> {
    ganglion(
        clip,
        [
            [-1, -1, 1, -1, -1],
            [-1, 1, 1, 1, -1],
            [1, 1, 0, 1, 1],
            [-1, 1, 1, 1, -1],
            [-1, -1, 1, -1, -1],
        ],
    )
}

fn binary(clip: &[Light]) -> Vec<Told> {
    // +1 where |dy| + |dx| <= 2.
    let kernel = std::array::from_fn(|j: usize| {
        std::array::from_fn(|i: usize| {
            if j.abs_diff(2) + i.abs_diff(2) <= 2 {
                1
            } else {
                -1
            }
        })
    });
    ganglion(clip, kernel)
}

fn corners(clip: &[Light]) -> Vec<Told> {
    each(clip, |x| {
        let votes = |p: (usize, usize), sign: f64| {
            let far = FOUR.map(|(dy, dx)| at(x, p, 3 * dy, 3 * dx, 0.0));
            far.iter().filter(|v| (**v - x[p]) * sign > 25.0).count()
        };
        let corner = map(x, |p| votes(p, 1.0) >= 3 || votes(p, -1.0) >= 3);
        Told {
            bits: vec![("R5", corner.clone())],
            events: Some((corner, none(x))),
            ..Told::default()
        }
    })
}

fn background(clip: &[Light]) -> Vec<Told> {
    remembering(clip, Light::clone, |model, x| {
        let away = minus(x, model);
        *model = map(x, |p| {
            let towards = match away[p].partial_cmp(&0.0) {
                Some(std::cmp::Ordering::Greater) => 1.0,
                Some(std::cmp::Ordering::Less) => -1.0,
                _ => 0.0,
            };
            model[p] + towards
        });
        let front = away.mapv(|v| v.abs() > 10.0);
        Told {
            analog: vec![("C", model.clone()), ("B", away)],
            bits: vec![("R5", front.clone())],
            events: Some((front, none(x))),
            ..Told::default()
        }
    })
}

fn changed(last: &mut Light, x: &Light) -> Bits {
    let changed = minus(x, last).mapv(|v| v.abs() > 8.0);
    last.assign(x);
    changed
}

fn frame_difference(clip: &[Light]) -> Vec<Told> {
    remembering(clip, Light::clone, |last, x| {
        let changed = changed(last, x);
        Told {
            bits: vec![("R5", changed.clone())],
            events: Some((changed, none(x))),
            ..Told::default()
        }
    })
}

fn bounding_box(clip: &[Light]) -> Vec<Told> {
    remembering(clip, Light::clone, |last, x| {
        let changed = changed(last, x);
        let moved = and(&changed, &any_neighbour(&changed));
        let width = x.dim().1;
        let places = || moved.indexed_iter().filter(|(_, b)| **b).map(|(p, _)| p);
        let rows = || places().map(|p| p.0 as u16);
        // Columns are counted from the right.
        let columns = || places().map(|p| (width - 1 - p.1) as u16);
        let found = rows().min().map(|top| Window {
            top,
            bottom: rows().max().unwrap(),
            right: columns().min().unwrap(),
            left: columns().max().unwrap(),
        });
        Told {
            readings: vec![Readings::Any(found.is_some()), Readings::Box(found)],
            bits: vec![("R6", moved)],
            ..Told::default()
        }
    })
}

/// Ten propagations of half the array each.
const FAR: usize = 10 * 128;

fn flood(clip: &[Light]) -> Vec<Told> {
    each(clip, |x| {
        let mask = above(x, 60.0);
        let width = x.dim().1;
        let seed = map(x, |p| p.0 == 28 && p.1 + 1 + 20 == width && mask[p]);
        Told {
            bits: vec![("R5", reached(&seed, &mask, FAR))],
            ..Told::default()
        }
    })
}

fn fill_holes(clip: &[Light]) -> Vec<Told> {
    each(clip, |x| {
        let dark = x.mapv(|v| v <= 60.0);
        let border = map(x, |p| {
            dark[p] && FOUR.iter().any(|(dy, dx)| at(x, p, *dy, *dx, -1.0) < 0.0)
        });
        // The border is reached by the first step already.
        let outside = reached(&border, &dark, FAR - 1);
        Told {
            bits: vec![("R5", outside.mapv(|b| !b))],
            ..Told::default()
        }
    })
}

fn shift(clip: &[Light]) -> Vec<Told> {
    each(clip, |x| {
        let bright = above(x, 60.0);
        // Five to the east, three to the south.
        Told {
            bits: vec![("R5", map(x, |p| at(&bright, p, -3, -5, false)))],
            ..Told::default()
        }
    })
}

fn direction(clip: &[Light]) -> Vec<Told> {
    let first = |x: &Light| (x.clone(), none(x));
    remembering(clip, first, |(last, before), x| {
        let now = above(&minus(x, last), 8.0);
        last.assign(x);
        let east = map(x, |p| {
            now[p] && at(before, p, 0, -1, false) && !at(before, p, 0, 1, false)
        });
        *before = now;
        Told {
            bits: vec![("R9", east.clone())],
            events: Some((east, none(x))),
            ..Told::default()
        }
    })
}

// ---- the programs -----------------------------------------------------------------------

fn programs() -> Vec<(String, Program)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("programs");
    let mut found = Vec::new();
    for folder in fs::read_dir(root).unwrap() {
        let folder = folder.unwrap().path();
        for file in fs::read_dir(&folder).unwrap() {
            let file = file.unwrap().path();
            let stem = |path: &Path| path.file_stem().unwrap().to_str().unwrap().to_owned();
            let name = format!("{}/{}", stem(&folder), stem(&file));
            let text = fs::read_to_string(&file).unwrap();
            found.push((name.clone(), Program::parse(&name, &text).unwrap()));
        }
    }
    found.sort_by(|a, b| a.0.cmp(&b.0));
    found
}

fn chip(program: &Program, size: Size, arithmetic: &str) -> (Box<dyn Array + Send>, bool) {
    let device = Device::scamp5();
    let expansion = program.expand(&device, &BTreeMap::new()).unwrap();
    let arithmetic: Arithmetic = arithmetic.parse().unwrap();
    let settings = Settings::from_device(&device);
    let chip = arithmetic
        .chip("test", &expansion.code, &device, size, settings)
        .unwrap();
    (chip, expansion.bare)
}

/// Shows a clip; calls back after every frame with the chip and the events of that frame.
fn watch(
    program: &Program,
    clip: &[Light],
    arithmetic: &str,
    mut seen: impl FnMut(usize, &dyn Array, &Packet),
) {
    let size = Size::of(&clip[0]);
    let (mut chip, bare) = chip(program, size, arithmetic);
    for (index, light) in clip.iter().enumerate() {
        let mut packet = Packet::new(size, chip.channels());
        let t = Micros(1000 * index as u64);
        chip.expose(light).unwrap();
        if bare || index > 0 {
            chip.run_frame(t, &mut packet).unwrap();
        } else {
            chip.run_init(t, &mut packet).unwrap();
        }
        seen(index, &*chip, &packet);
    }
}

fn analog(chip: &dyn Array, name: &str) -> Light {
    match chip.device().value_of(name) {
        Some(Value::Source(Source::Register(register))) => chip.analog(register),
        other => panic!("{name} is {other:?}"),
    }
}

fn bits(chip: &dyn Array, name: &str) -> Bits {
    match chip.device().value_of(name) {
        Some(Value::Bit(Bit::Register(register))) => chip.digital(register),
        other => panic!("{name} is {other:?}"),
    }
}

fn compare(what: &str, chip: &dyn Array, packet: &Packet, told: &Told) {
    for (name, expected) in &told.analog {
        assert_eq!(&analog(chip, name), expected, "{what}: {name}");
    }
    for (name, expected) in &told.bits {
        assert_eq!(&bits(chip, name), expected, "{what}: {name}");
    }
    if let Some((on, off)) = &told.events {
        let mut left = [on.clone(), off.clone()];
        for event in &packet.events {
            let side = usize::from(event.polarity == Polarity::Off);
            let pixel = &mut left[side][(event.y.into(), event.x.into())];
            assert!(*pixel, "{what}: {event:?} is one too many");
            *pixel = false;
        }
        let missed = left.iter().flatten().filter(|b| **b).count() as u64;
        assert_eq!(missed, packet.dropped.no_slot, "{what}: events missing");
    }
    if !told.readings.is_empty() {
        let got: Vec<_> = chip.readings().iter().map(|r| r.values.clone()).collect();
        assert_eq!(got, told.readings, "{what}");
    }
}

fn all_agree(clip: &[Light], what: &str) {
    for (name, program) in programs() {
        let (_, twin) = TWINS
            .iter()
            .find(|(twin, _)| *twin == name)
            .unwrap_or_else(|| panic!("programs/{name}.scamp has no twin here"));
        let told = twin(clip);
        assert_eq!(told.len(), clip.len());
        watch(&program, clip, "exact", |index, chip, packet| {
            compare(
                &format!("{name}, {what}, frame {index}"),
                chip,
                packet,
                &told[index],
            );
        });
    }
}

// ---- the pictures -----------------------------------------------------------------------

/// People who walk, out of the bundled clip: 8-bit light, five frames.
fn walkers() -> Vec<Light> {
    let mut scene = open("clips/vtest_256x256.apng", &OpenOptions::default()).unwrap();
    let mut clip = Vec::new();
    for _ in 0..5 {
        let frame = scene.next_frame().unwrap().unwrap();
        clip.push(frame.light.slice(ndarray::s![20..62, 120..191]).to_owned());
        // Every third, so that they have moved.
        scene.next_frame().unwrap();
        scene.next_frame().unwrap();
    }
    clip
}

/// Blobs that drift east, a pixel a frame; whole numbers, so that twins are exact.
fn drift() -> Vec<Light> {
    let spec = "pattern:noise?width=40&height=33&grain=3&low=0&high=255&speed=240&frames=6";
    let mut scene = open(spec, &OpenOptions::default()).unwrap();
    std::iter::from_fn(|| scene.next_frame().unwrap())
        .map(|frame| frame.light.mapv(f64::round))
        .collect()
}

#[test]
fn every_program_does_on_a_real_clip_what_its_twin_does() {
    all_agree(&walkers(), "walkers");
    all_agree(&drift(), "drift");
    assert_eq!(TWINS.len(), programs().len());
}

#[test]
fn and_on_pictures_that_are_easily_forgotten() {
    let mut state = 1u64;
    let mut random = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        f64::from((state >> 56) as u8)
    };
    for (height, width) in [(1, 1), (1, 9), (9, 1), (2, 2), (8, 8), (33, 65)] {
        let plane = |value: &mut dyn FnMut((usize, usize)) -> f64| {
            Light::from_shape_fn((height, width), value)
        };
        let corner = |at: (usize, usize)| plane(&mut |p| if p == at { 255.0 } else { 0.0 });
        let clip = vec![
            plane(&mut |_| 0.0),
            plane(&mut |_| 255.0),
            plane(&mut |(y, x)| if (y + x) % 2 == 0 { 255.0 } else { 0.0 }),
            corner((0, 0)),
            // The chip's (0,0).
            corner((0, width - 1)),
            corner((height - 1, 0)),
            plane(&mut |(y, _)| if y % 3 == 0 { 200.0 } else { 60.0 }),
            plane(&mut |_| random()),
            plane(&mut |_| random()),
            plane(&mut |_| 121.0),
        ];
        all_agree(&clip, &format!("{width}x{height}"));
    }
}

/// Their results are not the exact ones, and are of their kind: bits agree in nearly all
/// pixels, analogue values within a few LSB.
#[test]
fn every_program_runs_in_fixed_point_and_on_silicon() {
    let clip = walkers();
    for (name, program) in programs() {
        let (_, twin) = TWINS.iter().find(|(twin, _)| *twin == name).unwrap();
        let told = twin(&clip);
        for (arithmetic, alike, error) in [("q8.8", 0.99, 0.1), ("silicon", 0.9, 12.0)] {
            watch(&program, &clip, arithmetic, |index, chip, _| {
                let what = format!("{name} in {arithmetic}, frame {index}");
                for (register, expected) in &told[index].bits {
                    let got = bits(chip, register);
                    let same = got.iter().zip(expected).filter(|(a, b)| a == b).count();
                    let part = same as f64 / expected.len() as f64;
                    assert!(part >= alike, "{what}: {register} agrees in {part}");
                }
                for (register, expected) in &told[index].analog {
                    // A constant apart: `divq` leaves one that nobody corrects.
                    let spread = minus(&analog(chip, register), expected).std(0.0);
                    assert!(spread <= error, "{what}: {register} errs by {spread} LSB");
                }
            });
        }
    }
}

/// On one of the clips every program has something to say, and not the same of every pixel.
#[test]
fn the_clips_are_a_test() {
    for (name, twin) in TWINS {
        let mixed = |bits: &Bits| bits.iter().any(|b| *b) && bits.iter().any(|b| !*b);
        let varied = |light: &Light| light.std(0.0) > 1.0;
        let speaks = |told: &Told| {
            let events = told.events.iter().flat_map(|(on, off)| [on, off]);
            let mut bits = told.bits.iter().map(|(_, b)| b).chain(events);
            bits.any(mixed) || told.analog.iter().any(|(_, a)| varied(a))
        };
        let mut told = twin(&walkers());
        told.extend(twin(&drift()));
        assert!(told.iter().any(speaks), "{name}");
    }
}
