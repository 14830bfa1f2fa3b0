//! The resistive grids of a sensor while it runs; [`super::surround`] has the equation.

use std::fmt;

use crate::{
    kernel::Kernel,
    mesh::{Between, Euler, Flow, MeshError, Steady},
    number::{F64, Format, Number, Visitor},
    photoreceptor::{Curve, Response},
    plane::{Plane, Size},
    rng::Hash,
    scene::Frame,
    sensor::{SensorError, check_time},
};

use super::{
    description::{Channel, Description, PolarityRule, Stage},
    signal::{Light, Photoreceptors},
    surround::{SheetRule, Surround, Surrounds},
};

/// The resistive grids of a sensor while it runs.
#[derive(Clone, Debug)]
pub(super) struct Sheets {
    name: String,
    seed: u64,
    signal: Plane<f64>,
    /// Time of the frame before, in seconds.
    before: Option<f64>,
    /// For each channel, its grids, if it has some.
    channels: Vec<Option<Running>>,
}

#[derive(Clone, Debug)]
struct Running {
    what: Surrounds,
    moved: Vec<Moved>,
    drive: Plane<f64>,
}

#[derive(Clone, Debug)]
enum Moved {
    /// A grid that settles at once: its solver and its state.
    Settled(Box<(Steady, Plane<f64>)>),
    Exact(Box<Flow>),
    V2e(Euler),
}

impl Sheets {
    /// The grids of a sensor; `None` if it has none.
    pub(super) fn new<'a>(
        name: &str,
        channels: impl Iterator<Item = Option<&'a Surrounds>>,
        size: Size,
        seed: u64,
    ) -> Option<Self> {
        let running = |what: &Surrounds| Running::new(what, size);
        let channels: Vec<_> = channels.map(|what| what.map(running)).collect();
        let any = channels.iter().any(Option::is_some);
        any.then(|| Self::running(name, channels, size, seed))
    }

    fn running(name: &str, channels: Vec<Option<Running>>, size: Size, seed: u64) -> Self {
        Self {
            name: name.to_owned(),
            seed,
            signal: Plane::zeros(size.shape()),
            before: None,
            channels,
        }
    }

    /// Advances the grids by a frame.
    ///
    /// # Errors
    /// When it holds light that the response is not defined for, or that cannot be summed.
    pub(super) fn see<N: Number>(
        &mut self,
        number: &N,
        light: Light<'_, N>,
    ) -> Result<(), SensorError> {
        let mut held = vec![N::ZERO; self.signal.ncols()];
        for (y, mut row) in self.signal.rows_mut().into_iter().enumerate() {
            light.row(y, &mut held)?;
            for (to, held) in row.iter_mut().zip(&held) {
                *to = number.value(*held);
            }
        }
        let seconds = light.frame.seconds;
        let passed = self.before.replace(seconds).map(|before| seconds - before);
        for (channel, running) in self.channels.iter_mut().enumerate() {
            let Some(running) = running else { continue };
            let seed = Hash::raw(self.seed).nth(channel as u64 + 1).bits();
            let seen = running.see(&self.signal, passed, seed);
            seen.map_err(|e| SensorError::Stopped {
                sensor: self.name.clone(),
                why: format!(
                    "frame {}, the mesh of channel {channel}: {e}",
                    light.frame.index
                ),
            })?;
        }
        Ok(())
    }

    /// Row `y` of the drive of a channel, if it has grids.
    pub(super) fn row(&self, channel: usize, y: usize) -> Option<&[f64]> {
        let running = self.channels.get(channel)?.as_ref()?;
        let (start, width) = (y * running.drive.ncols(), running.drive.ncols());
        running.drive.as_slice()?.get(start..start + width)
    }
}

/// The drive of a sensor's resistor sheets by themselves, before any cell holds it: sensors that
/// differ in what their cells do with it may share it ([`Description::behind_sheets`]).
#[derive(Clone, Debug)]
pub struct SheetDrive {
    photoreceptors: Photoreceptors<F64>,
    sheets: Sheets,
    size: Size,
    last: Option<f64>,
}

/// All that the drive of resistor sheets depends on, besides the light and its size: sensors that have
/// the same see the same drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SheetSpec<'a> {
    response: Response,
    surrounds: &'a Surrounds,
    /// Of the noise of their resistors; 0 where they have none.
    seed: u64,
}

impl fmt::Display for SheetSpec<'_> {
    /// One text for each: part of what results are known by.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            response,
            surrounds,
            seed,
        } = self;
        write!(f, "{response:?} {surrounds:?} {seed}")
    }
}

impl SheetDrive {
    /// The sheets at rest.
    #[must_use]
    pub fn new(spec: SheetSpec<'_>, size: Size) -> Self {
        let SheetSpec {
            response,
            surrounds,
            seed,
        } = spec;
        let running = vec![Some(Running::new(surrounds, size))];
        Self {
            photoreceptors: Photoreceptors::new(F64, response),
            sheets: Sheets::running("the resistor sheets", running, size, seed),
            size,
            last: None,
        }
    }

    /// The drive at the time of the next frame, `[y, x]`, in the unit of the signal.
    ///
    /// # Errors
    /// When the frame has another size, is not later than the last, or holds light that the response
    /// is not defined for.
    pub fn see(&mut self, frame: &Frame) -> Result<Plane<f64>, SensorError> {
        let got = frame.light.size();
        if got != self.size {
            return Err(SensorError::Size {
                index: frame.index,
                got,
                want: self.size,
            });
        }
        check_time(frame, self.last.replace(frame.seconds))?;
        self.photoreceptors.see(frame);
        let light = Light {
            photoreceptors: &self.photoreceptors,
            frame,
            low_pass: None,
        };
        self.sheets.see(&F64, light)?;
        let mut drive = Plane::zeros(self.size.shape());
        for (y, mut to) in drive.rows_mut().into_iter().enumerate() {
            for (to, from) in to.iter_mut().zip(self.sheets.row(0, y).unwrap_or_default()) {
                *to = *from;
            }
        }
        Ok(drive)
    }
}

impl Description {
    /// What the drive of the sheets of its first kind of cells depends on; none where it has none.
    /// `seed` chooses the noise of their resistors.
    #[must_use]
    pub fn sheets(&self, seed: u64) -> Option<SheetSpec<'_>> {
        let surrounds = self.channels.first()?.surrounds.as_ref()?;
        let is_drawn = surrounds.sheets.iter().any(|sheet| sheet.noise > 0.0);
        Some(SheetSpec {
            response: self.response,
            surrounds,
            seed: if is_drawn { seed } else { 0 },
        })
    }

    /// The cells behind the resistor sheets, as a sensor that is shown the drive of the sheets
    /// ([`SheetDrive`]) in place of light: it has the same events, to the bit, where light is whole
    /// numbers from 0 to 255, or the format `f64`. None where there are no sheets, where cells see
    /// more than their drive, or where the format does not hold the signal as it is.
    #[must_use]
    pub fn behind_sheets(&self, format: Format) -> Option<Self> {
        struct HoldsAll<'a>(&'a Response);
        impl Visitor for HoldsAll<'_> {
            type Output = bool;
            fn visit<N: Number>(self, number: N) -> bool {
                let holds =
                    |value: f64| number.value(number.hold(value)).to_bits() == value.to_bits();
                let signal = |light: u8| self.0.apply(light.into()).is_ok_and(holds);
                holds(1.0) && (0..=u8::MAX).all(signal)
            }
        }
        let [channel] = &self.channels[..] else {
            return None;
        };
        let is_pixel = |kernel: &Kernel| kernel.weights().iter().eq([&1.0]);
        let sees_its_drive = channel.surrounds.is_some()
            && !self.memory.holds_pixels()
            && self.polarity == PolarityRule::Filtered
            && !self.is_influenced(|it| it.stage == Stage::Pixel)
            && !channel.log_temporal
            && channel.kernels.iter().all(is_pixel);
        if !sees_its_drive || !format.visit(HoldsAll(&self.response)) {
            return None;
        }
        let channel = Channel {
            surrounds: None,
            ..channel.clone()
        };
        Some(Self {
            response: Response {
                curve: Curve::Identity,
                round_f32: false,
            },
            channels: vec![channel],
            ..self.clone()
        })
    }
}

impl Running {
    fn new(what: &Surrounds, size: Size) -> Self {
        Self {
            what: what.clone(),
            moved: Vec::new(),
            drive: Plane::zeros(size.shape()),
        }
    }

    fn see(
        &mut self,
        signal: &Plane<f64>,
        passed: Option<f64>,
        seed: u64,
    ) -> Result<(), MeshError> {
        let between = match self.what.rule {
            SheetRule::Step => Between::Step,
            SheetRule::Ramp | SheetRule::V2e => Between::Ramp,
        };
        if let Some(passed) = passed {
            for moved in &mut self.moved {
                match moved {
                    Moved::Settled(at) => at.0.solve_into(signal, &mut at.1)?,
                    Moved::Exact(flow) => flow.advance(signal, passed, between)?,
                    Moved::V2e(euler) => euler.advance(signal, passed)?,
                }
            }
        } else {
            let begin = |(n, sheet): (usize, &Surround)| {
                let Surround {
                    sheet, tau, noise, ..
                } = *sheet;
                if self.what.rule == SheetRule::V2e {
                    return Ok(Moved::V2e(Euler::begin(sheet, tau, signal)?));
                }
                if tau <= 0.0 && noise <= 0.0 {
                    let mut steady = Steady::new(sheet, Size::of(signal))?;
                    let surround = steady.solve(signal)?;
                    return Ok(Moved::Settled(Box::new((steady, surround))));
                }
                let mut flow = Flow::settled(sheet, tau, signal)?;
                if noise > 0.0 {
                    flow = flow.with_noise(noise, Hash::raw(seed).with_mixed(n as u64).bits());
                }
                Ok(Moved::Exact(Box::new(flow)))
            };
            let sheets = self.what.sheets.iter().enumerate().map(begin);
            self.moved = sheets.collect::<Result<_, MeshError>>()?;
        }
        self.drive
            .zip_mut_with(signal, |drive, u| *drive = self.what.centre * u);
        for (Surround { gain, .. }, moved) in self.what.sheets.iter().zip(&self.moved) {
            let surround = match moved {
                Moved::Settled(at) => &at.1,
                Moved::Exact(flow) => flow.surround(),
                Moved::V2e(euler) => euler.surround(),
            };
            self.drive.scaled_add(*gain, surround);
        }
        Ok(())
    }
}

/// The drive of row `y` of a channel: by its grids if it has some, else by `kernel`.
pub(super) fn row<N: Number>(
    number: &N,
    sheets: Option<&Sheets>,
    (channel, y): (usize, usize),
    out: &mut [N::Held],
    kernel: impl FnOnce(&mut [N::Held]),
) {
    let Some(drive) = sheets.and_then(|sheets| sheets.row(channel, y)) else {
        return kernel(out);
    };
    for (to, drive) in out.iter_mut().zip(drive) {
        *to = number.hold(*drive);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{event::Packet, reference::Reference, rng::Hash, sensor::Sensor};

    struct Both<'a> {
        whole: &'a Description,
        cells: &'a Description,
        lights: &'a [Plane<f64>],
    }

    fn watched(sensor: &mut dyn Sensor, frames: &[Plane<f64>]) -> Packet {
        let mut packet = Packet::new(sensor.size(), sensor.channels());
        for (index, light) in (0..).zip(frames) {
            let frame = Frame {
                index,
                seconds: 0.01 * index as f64,
                light: light.clone().into(),
            };
            sensor.watch(&frame, &mut packet).unwrap();
        }
        packet
    }

    impl Visitor for Both<'_> {
        type Output = [Packet; 2];
        fn visit<N: Number>(self, number: N) -> [Packet; 2] {
            let size = Size::of(&self.lights[0]);
            let mut drive = SheetDrive::new(self.whole.sheets(3).unwrap(), size);
            let drives: Vec<_> = { self.lights.iter().enumerate() }
                .map(|(index, light)| {
                    let (index, light) = (index as u64, light.clone());
                    let seconds = 0.01 * index as f64;
                    let frame = Frame {
                        index,
                        seconds,
                        light: light.into(),
                    };
                    drive.see(&frame).unwrap()
                })
                .collect();
            let sensor = |description: &Description| {
                Reference::with_number(number, description.clone(), size, 3).unwrap()
            };
            [
                watched(&mut sensor(self.whole), self.lights),
                watched(&mut sensor(self.cells), &drives),
            ]
        }
    }

    #[test]
    fn cells_behind_sheets_have_the_events_of_the_sensor() {
        let size = Size::new(12, 20);
        let lights: Vec<_> = (0..8)
            .map(|n| {
                Plane::from_shape_fn(size.shape(), |(y, x)| {
                    let place = Hash::new(5).with(n).with((y * size.width + x) as u64);
                    (256.0 * place.uniform()).floor()
                })
            })
            .collect();
        let none = |name: &str| Err(std::io::Error::other(name.to_owned()));
        let sensor = |text: &str| Description::parse("sheets", text, &none).unwrap();
        for rules in [
            "memory = \"filtered-snap\"\nrefractory = { us = 12000 }",
            "memory = \"filtered-step\"\nnoise = { leak-hz = 1 }",
        ] {
            for mesh in [
                "{ lambda = 2, tau-us = 4000 }",
                "{ lambda = 3, rule = \"step\", tau-us = 900, noise = 0.5 }",
                "{ centre = 0, sheets = [{ gain = 1, lambda = 1 }, { gain = -1, lambda = 4 }] }",
            ] {
                let text = format!(
                    "response = \"identity\"\n{rules}\n[[channel]]\nmesh = {mesh}\nthreshold = {{ on = 9, off = 7, sigma = 1 }}\n"
                );
                let whole = sensor(&text);
                for format in ["f64", "f32", "f16", "bf16", "q16.16"] {
                    let format: Format = format.parse().unwrap();
                    let cells = whole.behind_sheets(format).unwrap();
                    let [own, apart] = format.visit(Both {
                        whole: &whole,
                        cells: &cells,
                        lights: &lights,
                    });
                    assert!(own.events.len() > 500, "{text} {format}");
                    assert_eq!(own, apart, "{text} {format}");
                }
                // 255 is beyond it.
                assert!(whole.behind_sheets("q8.8".parse().unwrap()).is_none());
            }
        }
        let bare = "response = \"identity\"\nmemory = \"filtered-step\"\n[[channel]]\nkernel = [[1]]\nthreshold = { on = 9, off = 9 }\n";
        assert!(sensor(bare).behind_sheets(Format::F64).is_none());
        let pixel = "response = \"identity\"\nmemory = \"filtered-snap\"\npolarity = \"pixel\"\n[[channel]]\nmesh = { lambda = 2 }\nthreshold = { on = 9, off = 9 }\n";
        assert!(sensor(pixel).behind_sheets(Format::F64).is_none());
    }
}
