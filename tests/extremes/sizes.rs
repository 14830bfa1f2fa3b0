//! Sizes from one pixel to 4096x4096: the array in several domains, the reference under every
//! rule, the mesh; each against an equation that is worked out pixel by pixel. One room after
//! the other, so that no two large ones are held at once.

use amacrine::{
    array::Array,
    event::{Packet, Polarity, readout::scan::Order},
    isa::{Bit, Digital, Direction, Primitive, Source},
    mesh::{Between, Float, Flow, Steady},
    plane::{Plane, Size},
    program::{Action, Host},
    reference::{Counts, Description, EventList, Limit, Reference},
    sensor::Sensor,
};

use crate::{
    array::{A, B, C, T, bus, chip, get_image, movx, step, words},
    light::{draw, frame, tiles},
    mesh::{DOUBLE, SINGLE, Waves, furthest, sheet},
    page::{Table, Worst},
};

const SIDE: usize = 4096;
const LINES: [Size; 3] = [Size::new(1, 1), Size::new(1, SIDE), Size::new(SIDE, 1)];
const SQUARE: Size = Size::new(SIDE, SIDE);

pub fn table() -> Table {
    let mut table = Table::default();
    for domain in ["exact", "f32", "f16", "bf16", "q8.8", "q8.24"] {
        let large = ["exact", "f16", "q8.8"].contains(&domain);
        let sizes = sizes(large);
        let mut worst = Worst::default();
        for size in &sizes {
            the_array(domain, *size, &mut worst);
        }
        table.within(
            &format!("array, `{domain}`: two images less their neighbours, events"),
            &names(&sizes),
            &format!("{} pixels", worst.cases()),
            "exact",
            worst,
        );
    }
    silicon(&mut table);
    for rule in [
        "raw-snap",
        "filtered-snap",
        "filtered-step",
        "authors-pixel-step",
    ] {
        let mut worst = Worst::default();
        let sizes = sizes(true);
        let events: Vec<_> = (sizes.iter())
            .map(|size| the_reference(rule, *size, &mut worst).to_string())
            .collect();
        let happens = format!("{} events", events.join(", "));
        let what = format!("reference, `{rule}`: two frames");
        table.within(&what, &names(&sizes), &happens, "exact", worst);
    }
    the_mesh::<f64>("f64", DOUBLE, &mut table);
    the_mesh::<f32>("f32", SINGLE, &mut table);
    table
}

fn sizes(large: bool) -> Vec<Size> {
    LINES.into_iter().chain(large.then_some(SQUARE)).collect()
}

fn names(sizes: &[Size]) -> String {
    let names: Vec<_> = sizes.iter().map(Size::to_string).collect();
    names.join(", ")
}

/// Even light from 0 to 254, so that half of it is a whole number.
fn light(size: Size, seed: u64) -> Plane<f64> {
    let value = |y, x| (64.0 * (draw(seed, y * 61 + x) + 1.0)).floor() * 2.0;
    tiles(size, 61, value)
}

/// An image, less the image to the east, and an event wherever that is above 0.
fn edges(domain: &str, size: Size) -> Box<dyn Array + Send> {
    let mut body = words(get_image(A));
    body.extend(words(movx(B, A, Direction::East)));
    // C = A - B
    body.extend(words([bus(&[T], &[A]), bus(&[C], &[T, B])]));
    body.extend(words([
        Primitive::Where {
            sources: vec![Source::Register(C)],
        },
        Primitive::Or {
            target: Digital(5),
            sources: vec![Bit::Flag],
        },
        Primitive::All,
    ]));
    body.push(step(Action::Host(Host::ScanEvents {
        source: Digital(5),
        polarity: Polarity::On,
        channel: 0,
        slots: 4000,
        order: Order::default(),
        by_rows: false,
    })));
    chip(domain, size, body)
}

fn the_array(domain: &str, size: Size, worst: &mut Worst) {
    let mut chip = edges(domain, size);
    let mut packet = Packet::new(size, 1);
    for n in 0..2u32 {
        let light = light(size, n.into());
        let shown = frame(n.into(), f64::from(n), light);
        let before = packet.events.len() as u64 + packet.dropped.no_slot;
        chip.watch(&shown, &mut packet).unwrap();
        let mut set = 0;
        for ((y, x), got) in chip.analog(C).indexed_iter() {
            // What lies off the array holds 0.
            let east = shown.light.get([y, x + 1]).copied().unwrap_or(0.0);
            let want = (shown.light[[y, x]] - east) / 2.0;
            worst.see(
                (got - want).abs(),
                0.0,
                format_args!("{domain}, {size}: {x}, {y}"),
            );
            set += u64::from(want > 0.0);
        }
        let delivered = packet.events.len() as u64 + packet.dropped.no_slot - before;
        assert_eq!(delivered, set, "{domain}, {size}");
    }
}

/// What the chip errs by does not depend on how large it is.
fn silicon(table: &mut Table) {
    let spread = |size: Size| {
        let mut chip = edges("silicon", size);
        // The same light everywhere: what the chip errs by depends on it.
        let shown = frame(0, 0.0, Plane::from_elem(size.shape(), 100.0));
        chip.watch(&shown, &mut Packet::new(size, 1)).unwrap();
        let got = chip.analog(C);
        let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0);
        for ((y, x), got) in got.indexed_iter() {
            if let Some(east) = shown.light.get([y, x + 1]) {
                let error = got - (shown.light[[y, x]] - east) / 2.0;
                (sum, squares, count) = (sum + error, squares + error * error, count + 1.0);
            }
        }
        let mean: f64 = sum / count;
        (squares / count - mean * mean).sqrt()
    };
    let small = spread(Size::new(256, 256));
    for (height, width) in [(1, SIDE), (1024, 1024)] {
        let size = Size::new(height, width);
        let mut worst = Worst::default();
        // Six standard deviations of a spread over so many pixels, of which neighbours share half.
        let spread_of = |pixels: usize| 6.0 * small / (pixels as f64).sqrt();
        let bound = spread_of(size.pixels()) + spread_of(1 << 16);
        worst.see((spread(size) - small).abs(), bound, size);
        table.within(
            "array, `silicon`: the spread of its errors",
            &size.to_string(),
            &format!("{small:.1} LSB, as on 256x256"),
            "six standard deviations",
            worst,
        );
    }
}

/// How many events there are.
fn the_reference(rule: &str, size: Size, worst: &mut Worst) -> usize {
    let stepped = rule.ends_with("step");
    let weights = [[0.0, -1.0, 0.0], [-1.0, 6.0, -1.0], [0.0, -1.0, 0.0]];
    let kernel = if rule == "authors-pixel-step" {
        "kernel = [[1]]\nmemory-kernel = [[1]]"
    } else {
        "kernel = [[0, -1, 0], [-1, 6, -1], [0, -1, 0]]"
    };
    let text = format!(
        "response = \"identity\"\nmemory = \"{rule}\"\n[[channel]]\n{kernel}\nthreshold = {{ on = 64, off = 64 }}\n"
    );
    let description = Description::parse("sizes.toml", &text, &|_| unreachable!()).unwrap();
    let mut reference = Reference::new(description, size, 0).unwrap();
    let counts = Counts::new(size, 1);
    let mut packet = Packet::new(size, 1);
    let before = light(size, 0);
    // One pixel in sixteen changes.
    let after = Plane::from_shape_fn(size.shape(), |(y, x)| {
        let more = if (5 * y + x) % 16 == 0 { 101.0 } else { 0.0 };
        before[[y, x]] + more
    });
    let near = |plane: &Plane<f64>, y: usize, x: usize| -> f64 {
        if rule == "authors-pixel-step" {
            return plane[[y, x]];
        }
        let at = |dy: usize, dx: usize| {
            let (y, x) = ((y + dy).max(1) - 1, (x + dx).max(1) - 1);
            plane[[y.min(size.height - 1), x.min(size.width - 1)]]
        };
        (0..9)
            .map(|i| weights[i / 3][i % 3] * at(i / 3, i % 3))
            .sum()
    };
    let want = Plane::from_shape_fn(size.shape(), |(y, x)| {
        let distance: f64 = near(&after, y, x) - near(&before, y, x);
        let whole = (distance.abs() / 64.0).floor();
        let count = if stepped {
            whole
        } else {
            f64::from(u8::from(distance.abs() > 64.0))
        };
        (count * distance.signum()) as i32
    });
    let list = EventList::new(&mut packet, Limit::default());
    let mut sink = (counts, list);
    reference
        .watch_into(&frame(0, 0.0, before), &mut sink)
        .unwrap();
    reference
        .watch_into(&frame(1, 1e-3, after), &mut sink)
        .unwrap();
    let counts = sink.0;
    let mut found = Plane::<i32>::zeros(size.shape());
    for event in &packet.events {
        found[[event.y.into(), event.x.into()]] += event.polarity.sign();
    }
    let same = found == want && counts.planes()[0] == want;
    worst.see(
        f64::from(u8::from(!same)),
        0.0,
        format_args!("{rule}, {size}"),
    );
    assert!(packet.events.is_sorted_by_key(|event| event.t));
    packet.events.len()
}

fn the_mesh<T: Float>(name: &str, claim: f64, table: &mut Table) {
    let (mut still, mut moving) = (Worst::default(), Worst::default());
    for size in sizes(true) {
        for lambda in [0.5, 10.0, 1e4] {
            let waves = Waves::new(size, 0.3, 1.0, 8);
            let signal = waves.signal().mapv(T::nearest);
            let want = waves.through(|fy, fx| sheet(lambda).gain(fy, fx));
            let mut steady = Steady::<T>::new(sheet(lambda), size).unwrap();
            let error = furthest(&steady.solve(&signal).unwrap(), &want);
            let bound = claim * (waves.range() + 0.3);
            still.see(error, bound, format_args!("{size}, λ {lambda}"));
            drop(steady);
            if size == SQUARE && lambda != 10.0 {
                continue;
            }
            let mut flow = Flow::<T>::settled(sheet(lambda), 1e-3, &signal).unwrap();
            flow.advance(&signal, 1e-3, Between::Ramp).unwrap();
            let error = furthest(flow.surround(), &want);
            moving.see(error, bound, format_args!("{size}, λ {lambda}, in time"));
        }
    }
    let bound = format!("{claim:.0e} of the brightest light");
    let sizes = names(&sizes(true));
    for (how, worst) in [("settled", still), ("a frame in time", moving)] {
        let what = format!("mesh, {name}: {how}, λ 0.5 to 1e4");
        table.within(&what, &sizes, "its error", &bound, worst);
    }
}
