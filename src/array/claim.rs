//! Whether a program computes what its settings say: `[computes]` at its head, held to the kernel
//! that is read back from its words.

use std::collections::BTreeMap;

use super::{
    Array as _, Chip, Exact, Input, Settings,
    crossing::{self, Parting},
    effort,
    taps::{self, NoTaps, TapsError, Why},
};
use crate::{
    event::Packet,
    isa::{Analog, Device, Figure},
    order::Order,
    plane::{Plane, Size},
    program::{Code, Computes},
    rng::Hash,
    unit::Micros,
};

/// The most words times pixels for which a kernel is read back from the words themselves.
pub const MOST_EFFORT: u64 = 1_000_000;

/// A kernel is as stated where no weight differs by more than this part of the largest: settings
/// are decimal, what a chip computes is not.
const NEAR: f64 = 1e-9;

/// How a statement was found to be true.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Proof {
    /// The words were read back as linear forms: for every input.
    Words,
    /// By what one bright pixel leaves behind in exact arithmetic: the words reach too far, or
    /// are too many, for the other.
    Impulse,
}

/// A statement that is true, and of which chip.
#[derive(Clone, Debug, PartialEq)]
pub struct Claim {
    /// How that was found.
    pub proof: Proof,
    /// The scale of the light for which it is stated, where that is another than this chip's.
    pub scaled: Option<Scaled>,
    /// How its threshold was held, where one is stated and the program can be run.
    pub events: Option<HeldEvents>,
}

/// A threshold that was held to what a program fires on random pictures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldEvents {
    /// The threshold, in LSB.
    pub threshold: f64,
    /// How many pictures were shown after the first, each compared with what the cell remembers.
    pub pictures: usize,
    /// Whether OFF and ON are read out as events or as rows of bits. What is not was not held.
    pub reads: [bool; 2],
    /// Whether OFF and ON were called for by any picture.
    pub crossed: [bool; 2],
}

impl HeldEvents {
    /// What was held of OFF and of ON.
    #[must_use]
    pub fn signs(&self) -> [SignHeld; 2] {
        [0, 1].map(|sign| match (self.reads[sign], self.crossed[sign]) {
            (false, _) => SignHeld::NotRead,
            (true, false) => SignHeld::NotCrossed,
            (true, true) => SignHeld::Held,
        })
    }
}

/// What was held of the events of one sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SignHeld {
    /// They are where the threshold says.
    Held,
    /// They are not read out: nothing was seen of them.
    NotRead,
    /// No picture called for one, and there was none.
    NotCrossed,
}

/// A statement that holds for the light of another chip: here the kernel comes times one factor.
#[derive(Clone, Debug, PartialEq)]
pub struct Scaled {
    /// The other chip.
    pub chip: String,
    /// Its scale, in LSB a level.
    pub there: f64,
    /// This chip's, in LSB a level.
    pub here: f64,
}

impl Scaled {
    /// Whether light comes to this chip as to another, but for its scale.
    fn new(other: &Device, device: &Device) -> Option<Self> {
        let scale = |of: &Device| of.value(Figure::LightScale);
        let (there, here) = (scale(other), scale(device));
        (there != here).then(|| Self {
            chip: other.name().to_owned(),
            there,
            here,
        })
    }

    /// How many times what is stated it is here.
    #[must_use]
    pub fn factor(&self) -> f64 {
        self.here / self.there
    }
}

/// A statement that is not true.
#[derive(Clone, Debug, PartialEq, thiserror::Error, miette::Diagnostic)]
pub enum ClaimError {
    /// The chip has no such register.
    #[error("[computes] names register {name}, which is no analogue register of {chip}")]
    #[diagnostic(help("name the register that holds the drive when a frame ends"))]
    Register {
        /// The name.
        name: String,
        /// The chip.
        chip: String,
    },
    /// Another kernel.
    #[error(
        "[computes] is false: it says that {register} is the light, times {scale}, under {stated}; the program computes {found}"
    )]
    #[diagnostic(help("if the program is right, write `kernel = {found}` in its [computes]"))]
    Kernel {
        /// Where it should be.
        register: String,
        /// From light times weights to LSB.
        scale: f64,
        /// The rows that are stated.
        stated: String,
        /// The rows that are computed, with the same scale.
        found: String,
    },
    /// It is not light alone.
    #[error(
        "[computes] is false: {register} is no map of the light alone; it depends on what {others} held when the frame began"
    )]
    #[diagnostic(help(
        "state the register in which the drive is, before the memory is subtracted: register = \"NAME\""
    ))]
    Others {
        /// Where it should be.
        register: String,
        /// Registers.
        others: String,
    },
    /// The threshold is no constant of the program.
    #[error("[computes] names the threshold {name}, which is no constant of the program")]
    #[diagnostic(help(
        "name the constant that the drive is compared with: `const threshold = 10;`"
    ))]
    Threshold {
        /// The name.
        name: String,
    },
    /// It fires elsewhere.
    #[error(
        "[computes] is false: the drive is compared with {threshold} LSB of change, and where it has changed by {moved:.3} LSB since the last event the program {does}{when}"
    )]
    #[diagnostic(help(
        "an event is where the drive, less its value at the cell's last event, is above the threshold (ON) or below minus it (OFF); `init` stores the first drive, and a cell that fires its present one"
    ))]
    Events {
        /// The stated threshold.
        threshold: f64,
        /// A change of the drive.
        moved: f64,
        /// What the program does there.
        does: &'static str,
        /// When: after the first frame it hangs on what the frames before left in the memory.
        when: &'static str,
    },
    /// It is not linear.
    #[error("[computes] is false: {register} is no linear map of the light: {why}")]
    #[diagnostic(help(
        "state the register in which the drive is (register = \"NAME\"), or leave [computes] out"
    ))]
    NotLinear {
        /// Where it should be.
        register: String,
        /// The line, and why.
        why: String,
    },
}

/// Holds what a program says of itself to what its words compute: its kernel in every case, its
/// threshold and what cells remember on some random pictures. `constants` are those of the program,
/// and `others` the chips that it may be written for: what it states may be so with their scale of
/// the light.
///
/// # Errors
/// When it computes something else, with what it computes.
pub fn check(
    computes: &Computes,
    code: &Code,
    device: &Device,
    settings: Settings,
    constants: &BTreeMap<String, f64>,
    others: &[&Device],
) -> Result<Claim, ClaimError> {
    let name = computes.register.as_deref().unwrap_or("A");
    let names = &device.registers().analog;
    let register = names.iter().position(|known| known == name);
    let Some(register) = register.map(|number| Analog(number as u8)) else {
        return Err(ClaimError::Register {
            name: name.to_owned(),
            chip: device.name().to_owned(),
        });
    };
    let not_linear = |why: String| ClaimError::NotLinear {
        register: name.to_owned(),
        why,
    };
    let traced = effort(&code.frame, device).is_some_and(|effort| effort <= MOST_EFFORT);
    let taps = traced.then(|| taps::read(&code.frame, device, settings, register));
    // Thirds are linear, and are not read.
    let taps = taps.filter(
        |it| !matches!(it, Err(TapsError::NoTaps(NoTaps { why, .. })) if *why == Why::Parts),
    );
    let (found, proof) = if let Some(taps) = taps {
        let taps = taps.map_err(|why: TapsError| not_linear(why.to_string()))?;
        let mut others: Vec<String> = taps
            .taps
            .keys()
            .filter_map(|(input, ..)| match input {
                Input::Light => None,
                Input::Register(register) => Some(device.analog_name(*register)),
            })
            .collect();
        others.order_by(Ord::cmp);
        others.dedup();
        if !others.is_empty() {
            return Err(ClaimError::Others {
                register: name.to_owned(),
                others: others.join(", "),
            });
        }
        (taps.kernel(Input::Light), Proof::Words)
    } else {
        let far = Far {
            code,
            device,
            settings,
            register,
        };
        (far.kernel().map_err(not_linear)?, Proof::Impulse)
    };
    let stated = plane(&computes.kernel);
    let found = found.mapv(|weight| weight / computes.scale + 0.0);
    let scaled = { others.iter() }
        .filter_map(|other| Scaled::new(other, device))
        .map(Some);
    for scaled in std::iter::once(None).chain(scaled) {
        let factor = scaled.as_ref().map_or(1.0, Scaled::factor);
        let kernel = &stated * factor;
        if same(&kernel, &found) {
            let kernel = kernel * computes.scale;
            let events = fires(computes, &kernel, code, device, settings, constants)?;
            return Ok(Claim {
                proof,
                scaled,
                events,
            });
        }
    }
    Err(ClaimError::Kernel {
        register: name.to_owned(),
        scale: computes.scale,
        stated: rows(&stated),
        found: rows(&found),
    })
}

/// Whether it fires where its threshold says, and what was seen of that.
fn fires(
    computes: &Computes,
    kernel: &Plane<f64>,
    code: &Code,
    device: &Device,
    settings: Settings,
    constants: &BTreeMap<String, f64>,
) -> Result<Option<HeldEvents>, ClaimError> {
    let Some(name) = &computes.threshold else {
        return Ok(None);
    };
    let threshold = constants.get(name).copied();
    let threshold = threshold.ok_or_else(|| ClaimError::Threshold { name: name.clone() })?;
    // What cannot be run is told by whoever runs it.
    let steps = (threshold, computes.step.unwrap_or(0.0));
    let Ok(seen) = crossing::parts(kernel, steps, code, device, settings) else {
        return Ok(None);
    };
    match seen.parting {
        None => Ok(Some(HeldEvents {
            threshold,
            pictures: crossing::FRAMES,
            reads: seen.reads,
            crossed: seen.crossed,
        })),
        Some(Parting {
            moved,
            fired,
            frame,
        }) => Err(ClaimError::Events {
            threshold,
            moved,
            does: match fired {
                0 => "does not fire",
                1 => "fires ON",
                crossing::TWICE => "fires more than once in a frame",
                _ => "fires OFF",
            },
            when: if frame == 1 {
                ""
            } else {
                ": its memory is not what it should be after an event, or without one"
            },
        }),
    }
}

fn plane(rows: &[Vec<f64>]) -> Plane<f64> {
    let width = rows.first().map_or(0, Vec::len);
    Plane::from_shape_fn((rows.len(), width), |(y, x)| {
        rows.get(y)
            .and_then(|row| row.get(x))
            .copied()
            .unwrap_or(0.0)
    })
}

/// Whether two centred kernels have the same weights; beyond its sides a kernel is 0.
fn same(a: &Plane<f64>, b: &Plane<f64>) -> bool {
    let largest = a.iter().fold(0.0, |most: f64, w| most.max(w.abs()));
    let half = |of: fn((usize, usize)) -> usize| (of(a.dim()).max(of(b.dim())) / 2) as isize;
    let (rows, columns) = (half(|dim| dim.0), half(|dim| dim.1));
    let at = |kernel: &Plane<f64>, y: isize, x: isize| {
        let (height, width) = kernel.dim();
        let row = (height / 2).checked_add_signed(y);
        let column = (width / 2).checked_add_signed(x);
        let place = row.zip(column);
        place
            .and_then(|place| kernel.get(place))
            .copied()
            .unwrap_or(0.0)
    };
    (-rows..=rows)
        .all(|y| (-columns..=columns).all(|x| (at(a, y, x) - at(b, y, x)).abs() <= NEAR * largest))
}

/// A kernel as settings have it: `[[1, 2, 1], [2, 4, 2]]`.
#[must_use]
pub fn rows(kernel: &Plane<f64>) -> String {
    let row = |row: ndarray::ArrayView1<'_, f64>| {
        let weights: Vec<String> = row.iter().map(ToString::to_string).collect();
        format!("[{}]", weights.join(", "))
    };
    let rows: Vec<String> = kernel.rows().into_iter().map(row).collect();
    format!("[{}]", rows.join(", "))
}

/// A program whose words reach too far, or are too many, to be read back: it is seen by what it
/// leaves behind.
struct Far<'a> {
    code: &'a Code,
    device: &'a Device,
    settings: Settings,
    register: Analog,
}

impl Far<'_> {
    /// Side of the array, in pixels.
    const SIDE: usize = 65;

    /// What is in the register after a frame with this picture, `init` in the dark before it.
    fn left_by(&self, picture: &Plane<f64>) -> Result<Plane<f64>, String> {
        let size = Size::new(Self::SIDE, Self::SIDE);
        let chip = Chip::new(
            "computes",
            Exact,
            self.code,
            self.device,
            size,
            self.settings,
        );
        let mut chip = chip.map_err(|why| why.to_string())?;
        let mut packet = Packet::new(size, 1);
        let dark = Plane::zeros(size.shape());
        chip.expose(&dark).map_err(|why| why.to_string())?;
        let ran = chip.run_init(Micros(0), &mut packet);
        ran.map_err(|why| why.to_string())?;
        chip.expose(picture).map_err(|why| why.to_string())?;
        let ran = chip.run_frame(Micros(1), &mut packet);
        ran.map_err(|why| why.to_string())?;
        Ok(chip.analog(self.register))
    }

    /// The kernel that its words are, if they are one.
    fn kernel(&self) -> Result<Plane<f64>, String> {
        let dark = self.left_by(&Plane::zeros((Self::SIDE, Self::SIDE)))?;
        let kernel = self.impulse(&dark)?;
        self.superposes(&kernel, &dark)?;
        Ok(kernel)
    }

    /// What a bright pixel leaves around itself, for one unit of light; `dark`: what is left without.
    fn impulse(&self, dark: &Plane<f64>) -> Result<Plane<f64>, String> {
        const LEVEL: f64 = 64.0;
        let (side, middle) = (Self::SIDE, Self::SIDE / 2);
        let mut picture = Plane::zeros((side, side));
        picture[(middle, middle)] = LEVEL;
        let spread = self.left_by(&picture)? - dark;
        // What is left at (y, x) of the pixel in the middle is the weight that the pixel at (y, x)
        // gives to the middle one: the kernel, turned around.
        let far = |along: fn((usize, usize)) -> usize| {
            let left = spread.indexed_iter().filter(|(_, value)| **value != 0.0);
            let distance = left.map(|(at, _)| along(at).abs_diff(middle));
            distance.max().unwrap_or(0)
        };
        let (down, right) = (far(|at| at.0), far(|at| at.1));
        Ok(Plane::from_shape_fn(
            (2 * down + 1, 2 * right + 1),
            |(y, x)| spread[(middle + down - y, middle + right - x)] / LEVEL,
        ))
    }

    /// Whether spots of several brightnesses leave behind what the kernel makes of them, with what is
    /// left in the dark. Spots are small: what reaches far spoils wide borders.
    fn superposes(&self, kernel: &Plane<f64>, dark: &Plane<f64>) -> Result<(), String> {
        const BRIGHTEST: [f64; 3] = [8.0, 64.0, 255.0];
        const RADIUS: usize = 4;
        let side = Self::SIDE;
        let rim = kernel.nrows().max(kernel.ncols()) / 2;
        let inside = || rim..side.saturating_sub(rim);
        let size: f64 = kernel.iter().map(|weight| weight.abs()).sum();
        for (n, most) in BRIGHTEST.into_iter().enumerate() {
            let light = |(y, x): (usize, usize)| {
                let is_spot = y.abs_diff(side / 2).max(x.abs_diff(side / 2)) <= RADIUS;
                let value = Hash::new(n as u64).with((y * side + x) as u64).uniform();
                if is_spot { most * value } else { 0.0 }
            };
            let picture = Plane::from_shape_fn((side, side), light);
            let left = self.left_by(&picture)?;
            for at in inside().flat_map(|y| inside().map(move |x| (y, x))) {
                let want = crossing::drive(kernel, &picture, at);
                let got = left[at] - dark[at];
                if (got - want).abs() > NEAR * size * most {
                    return Err(format!(
                        "under random light up to {most} it leaves {got} where a pixel alone says {want}"
                    ));
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kernel_is_the_same_with_zeros_around_it() {
        let small = plane(&[vec![0.1]]);
        let large = plane(&[vec![0.0; 3], vec![0.0, 0.1 + 1e-12, 0.0], vec![0.0; 3]]);
        assert!(same(&small, &large) && same(&large, &small));
        let east = plane(&[vec![0.0, 0.0, 0.1]]);
        assert!(!same(&small, &east) && !same(&large, &east));
    }
}
