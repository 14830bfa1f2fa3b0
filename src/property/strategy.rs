//! What a design meets, at random: kernels, scenes, formats, devices, programs.

use std::{fmt, ops::RangeInclusive};

use proptest::{collection::vec, prelude::*, sample::select};

use crate::{
    array::Arithmetic,
    isa::{Device, Figure},
    kernel::Kernel,
    number::Format,
    plane::{Plane, Size},
    scene::{Frame, held::Held},
};

/// A few pictures, one after the other.
#[derive(Clone, PartialEq)]
pub struct Clip {
    /// Light from 0 to 255, `[y, x]`, all of one size.
    pub frames: Vec<Plane<f64>>,
    /// Pictures per second.
    pub fps: f64,
}

impl Clip {
    /// Its frames as a scene, from the first on.
    #[must_use]
    pub fn scene(&self) -> Held {
        let size = self.frames.first().map_or(Size::new(0, 0), Size::of);
        let frames = self.frames.iter().enumerate().map(|(index, light)| Frame {
            index: index as u64,
            seconds: index as f64 / self.fps,
            light: light.clone().into(),
        });
        Held::new(frames.collect(), size, self.fps)
    }
}

impl fmt::Debug for Clip {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.frames.first().map_or((0, 0), Plane::dim);
        writeln!(f, "{} x {} pixels, {} frames/s", size.1, size.0, self.fps)?;
        for (i, frame) in self.frames.iter().enumerate() {
            writeln!(f, "frame {i}\n{frame}")?;
        }
        Ok(())
    }
}

/// Square kernels of an odd side, of whole weights times 2^-`fraction`.
pub fn kernels(
    sides: &'static [usize],
    levels: RangeInclusive<i32>,
    fraction: u32,
) -> impl Strategy<Value = Kernel> {
    let scale = 2f64.powi(-(fraction as i32));
    select(sides).prop_flat_map(move |side| {
        vec(levels.clone(), side * side).prop_filter_map("an even side", move |levels| {
            let weights = levels.iter().map(|level| f64::from(*level) * scale);
            let plane = Plane::from_shape_vec((side, side), weights.collect()).ok()?;
            Kernel::new(plane).ok()
        })
    })
}

/// Whole levels of light from 0 to 254 (255 saturates a capture), a part of the pixels changing
/// from frame to frame: still pictures, single pixels, and everything at once.
pub fn clips(size: Size, frames: RangeInclusive<usize>) -> impl Strategy<Value = Clip> {
    let first = vec(0u8..255, size.pixels());
    let change = (0..size.pixels().max(1), 0u8..255);
    let changes = vec(vec(change, 0..=size.pixels()), frames);
    (first, changes).prop_map(move |(first, changes)| {
        let shape = (size.height, size.width);
        let mut light: Vec<f64> = first.into_iter().map(f64::from).collect();
        let mut frames = Vec::new();
        for change in changes {
            // The first frame is as it was drawn.
            for (at, level) in change.into_iter().filter(|_| !frames.is_empty()) {
                light[at] = f64::from(level);
            }
            frames.extend(Plane::from_shape_vec(shape, light.clone()));
        }
        Clip { frames, fps: 100.0 }
    })
}

/// Arithmetics of the array: floats, 16 and 32 bits of fixed point, chips of silicon.
pub fn formats() -> impl Strategy<Value = Arithmetic> {
    let fixed = (8u32..=12, prop_oneof![Just(16u32), Just(32)])
        .prop_filter_map("a format", |(whole, bits)| {
            format!("q{whole}.{}", bits - whole).parse().ok()
        });
    let others = Format::examples().filter(|format| !matches!(format, Format::Fixed(_)));
    let others: Vec<Format> = others.collect();
    prop_oneof![
        others.len() as u32 => select(others).prop_map(Arithmetic::Number),
        1 => fixed,
        1 => any::<u64>().prop_map(|seed| Arithmetic::Silicon { seed }),
    ]
}

/// What-if chips: the real one with other errors, from none to twice its own.
pub fn devices() -> impl Strategy<Value = Device> {
    let count = Figure::of_a_store().count();
    vec(0.0..2.0f64, count).prop_filter_map("a chip", |times| {
        let start = Device::scamp5();
        let mut all = Figure::of_a_store().zip(times);
        all.try_fold(start, |device, (figure, times)| {
            let value = device.value(figure) * times;
            device.what_if(figure, value).ok()
        })
    })
}

/// Straight chip text over the registers A to D, from `get_image(A)` on: so many statements.
pub fn programs(statements: RangeInclusive<usize>) -> impl Strategy<Value = String> {
    let register = || select(&["A", "B", "C", "D"][..]);
    let towards = select(&["north", "east", "south", "west"][..]);
    let three = || (register(), register(), register());
    let apart = |(y, a, b): &(&str, &str, &str)| y != a && y != b && a != b;
    let statement = prop_oneof![
        three()
            .prop_filter("aliases", apart)
            .prop_map(|(y, a, b)| format!("add({y}, {a}, {b});")),
        three()
            .prop_filter("aliases", apart)
            .prop_map(|(y, a, b)| format!("sub({y}, {a}, {b});")),
        (register(), register()).prop_map(|(y, a)| format!("mov({y}, {a});")),
        (register(), register())
            .prop_filter("aliases", |(y, a)| y != a)
            .prop_map(|(y, a)| format!("divq({y}, {a});")),
        (register(), register(), towards).prop_map(|(y, a, to)| format!("movx({y}, {a}, {to});")),
    ];
    vec(statement, statements).prop_map(|all| {
        let clear = ["res(B);", "res(C);", "res(D);", "get_image(A);"].map(String::from);
        [clear.to_vec(), all].concat().join("\n") + "\n"
    })
}
