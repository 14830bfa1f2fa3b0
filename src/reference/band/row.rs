//! One row of a channel in one interval, step by step as in [`model`](super::super::model), whose
//! equations are numbered: the whole row takes one step before the next.

use std::ops::Range;

use crate::{
    number::{Number, Real},
    sensor::{Overflowed, SensorError},
};

use super::{
    super::{
        description::{PolarityRule, RefractoryRule},
        drive::{self, Made, log_temporal},
        fire,
        memory::{self, Memory},
        refractory,
        report::Report,
        sheets,
        signal::Padded,
        step::Seen,
    },
    Cells, IntervalInput, Plan, Scratch,
};

/// A row of a channel, and its input in an interval.
pub(super) struct Row<'a, N: Number> {
    pub plan: &'a Plan<N>,
    pub signal: &'a Padded<N::Held>,
    /// The largest signal of all frames so far, without its sign; in fixed point alone.
    pub most: f64,
    pub input: IntervalInput<'a, N>,
    pub channel: usize,
    pub y: usize,
    /// Its cells in the band's arrays.
    pub range: Range<usize>,
    /// Its pixels in the band's picture.
    pub pixels: Range<usize>,
}

impl<N: Number> Row<'_, N> {
    /// Advances the row's cells through the interval, and leaves their trains in `scratch`. Returns
    /// the number of events.
    pub fn advance(
        &self,
        (cells, made): (&mut Cells<N>, &mut Made<N::Held>),
        picture: &mut [N::Held],
        scratch: &mut Scratch<N>,
        report: &mut Report,
    ) -> Result<u64, SensorError> {
        let noise = &self.plan.description.noise;
        if noise.fires() && !cells.fired.is_empty() {
            // Noise events come later, and must know when each cell fired before.
            let fired = &cells.fired[self.range.clone()];
            scratch.rested.copy_from_slice(fired);
        }
        (scratch.trains.channel, scratch.trains.y) = (self.channel, self.y);
        report.overflowed += self.drive(&cells.memory, made, scratch);
        if let Some(exact) = self.plan.exact.get(self.channel) {
            // A memory of drives is one of those so far, or lies between two, but for leak and
            // logarithms.
            let is_held = self.input.sheets.is_none()
                && cells.leak.is_empty()
                && !self.plan.description.channels[self.channel].log_temporal
                && exact.holds(self.most, true);
            if !is_held {
                report.overflowed += self.differences(&cells.memory, scratch);
            }
        }
        let mut events = self.fire(cells, scratch)?;
        if self.is_authors() {
            self.fire_as_authors(cells, scratch)?;
        }
        self.remember(cells, picture, scratch, report)?;
        if !self.is_authors() && !cells.fired.is_empty() {
            events = Some(self.dead_time(cells, scratch, (events, report)));
        }
        Ok(events.unwrap_or_else(|| scratch.trains.events()))
    }

    /// (1), or what stands in its place; how much of it the format does not hold.
    fn drive(
        &self,
        memory: &Memory<N>,
        made: &mut Made<N::Held>,
        scratch: &mut Scratch<N>,
    ) -> Overflowed {
        let (number, y) = (&self.plan.number, self.y);
        let Scratch { drive, parts, .. } = scratch;
        let weights = &self.plan.weights[self.channel];
        let at = (self.channel, y);
        sheets::row(number, self.input.sheets, at, drive, |drive| match memory {
            // The kernel is applied to the pixels' distance from the memory, u - M.
            Memory::RawSnap { .. } => {
                let pixels = self.input.pixels_of(self.channel);
                weights.row(number, pixels, y, drive, parts);
            }
            Memory::PixelStep(_) => weights.row(number, self.signal, y, drive, parts),
            Memory::FilteredSnap { .. } | Memory::FilteredStep(_) => {
                weights.row_in_order(number, (self.signal, made), y, drive, parts);
            }
        });
        let (pixels, most) = match memory {
            Memory::RawSnap { .. } => (self.input.pixels_of(self.channel), 2.0 * self.most),
            _ => (self.signal, self.most),
        };
        let seen = (pixels, most, self.input.sheets);
        let overflowed = self.plan.overflowed(at, seen, drive);
        if self.plan.description.channels[self.channel].log_temporal {
            log_temporal(number, drive, 1e-8);
        }
        overflowed
    }

    /// How many distances (2) from a memory of drives a fixed-point format does not hold.
    fn differences(&self, memory: &Memory<N>, scratch: &mut Scratch<N>) -> Overflowed {
        let (number, range) = (&self.plan.number, self.range.clone());
        let Scratch { drive, .. } = scratch;
        match memory {
            Memory::FilteredSnap { filtered, .. } => {
                drive::differences(number, drive, &filtered[range])
            }
            Memory::FilteredStep(stepped) => {
                let (on, off) = self.plan.thresholds[self.channel].row(self.y);
                stepped.values(number, range.clone(), on, off, &mut scratch.memory);
                let differences = drive::differences(number, drive, &scratch.memory);
                if self.plan.description.noise.leak_hz <= 0.0 {
                    return differences;
                }
                // It holds all that has leaked, too.
                let memories = stepped.overflowed(number, range, (on, off), &scratch.memory);
                Overflowed {
                    at: differences.at.max(memories.at),
                    ..differences
                }
            }
            // Those from a memory of pixels were counted where they were laid out.
            Memory::RawSnap { .. } | Memory::PixelStep(_) => Overflowed::default(),
        }
    }

    /// (2) to (5): the distances from the memory, and the trains. The number of events, where
    /// firing has counted them, and moved the memory, on its way.
    fn fire(
        &self,
        cells: &mut Cells<N>,
        scratch: &mut Scratch<N>,
    ) -> Result<Option<u64>, SensorError> {
        let (number, range) = (&self.plan.number, self.range.clone());
        let (on, off) = self.plan.thresholds[self.channel].row(self.y);
        let Scratch {
            drive,
            parts,
            memory,
            to,
            trains,
            ..
        } = scratch;
        let all_are_numbers = match &mut cells.memory {
            Memory::FilteredStep(stepped) if self.is_authors() => {
                stepped.values(number, range, on, off, memory);
                memory::distance(number, drive, memory, to);
                true
            }
            Memory::FilteredStep(stepped) => {
                let input = &self.input;
                let seen = Seen {
                    drive,
                    on,
                    off,
                    per: self.plan.thresholds[self.channel].inverse(self.y),
                    leak: cells.leak.get(range.clone()).unwrap_or_default(),
                    elapsed: (input.elapsed - input.interval.duration(), input.elapsed),
                };
                // A refractory period needs the times as well.
                let times = input.times || !cells.fired.is_empty();
                let before = &mut cells.before[range.clone()];
                let crossed =
                    stepped.cross(number, range.clone(), before, &seen, times, (trains, to));
                return crossed.map(Some).map_err(|x| {
                    let base = stepped.base[range.start + x];
                    self.uncountable(x, number.real(number.sub(drive[x], base)))
                });
            }
            Memory::PixelStep(_) => {
                // A description with this rule has a memory kernel for each channel.
                if let Some(weights) = &self.plan.memory_weights[self.channel] {
                    let pixels = self.input.pixels_of(self.channel);
                    weights.row(number, pixels, self.y, memory, parts);
                    memory::distance(number, drive, memory, to);
                }
                true
            }
            Memory::FilteredSnap { filtered, .. } => {
                memory::distance(number, drive, &filtered[range.clone()], to);
                if !cells.leak.is_empty() {
                    fall(to, &cells.leak[range], self.input.elapsed);
                }
                fire::snap(to, on, off, trains)
            }
            Memory::RawSnap { .. } => {
                for (to, drive) in to.iter_mut().zip(drive.iter()) {
                    *to = number.real(*drive);
                }
                fire::snap(to, on, off, trains)
            }
        };
        if all_are_numbers {
            return Ok(None);
        }
        let x = to.iter().position(|d| !fire::is_number(*d)).unwrap_or(0);
        Err(self.uncountable(x, to[x]))
    }

    /// (10) to (13): the trains by the released rule, from the distances.
    fn fire_as_authors(
        &self,
        cells: &mut Cells<N>,
        scratch: &mut Scratch<N>,
    ) -> Result<(), SensorError> {
        let thresholds = self.plan.thresholds[self.channel].row(self.y);
        let Scratch {
            to, trains, rested, ..
        } = scratch;
        let fired = if cells.fired.is_empty() {
            // Without a refractory period no cell is ever refractory.
            rested.fill(f64::NEG_INFINITY);
            &mut rested[..]
        } else {
            &mut cells.fired[self.range.clone()]
        };
        let r = self.plan.refractory();
        if refractory::authors(self.input.interval, r, thresholds, to, fired, trains) {
            return Ok(());
        }
        let most = memory::MAX_STEPS.unsigned_abs();
        let mut counts = trains.counts.iter();
        let x = counts.position(|count| count.unsigned_abs() > most);
        let x = x.unwrap_or(0);
        Err(self.uncountable(x, to[x]))
    }

    /// (6) to (8): what the events do to the memory (`picture` where all channels share it), and
    /// their sign where it is the pixel's own.
    fn remember(
        &self,
        cells: &mut Cells<N>,
        picture: &mut [N::Held],
        scratch: &mut Scratch<N>,
        report: &mut Report,
    ) -> Result<(), SensorError> {
        let (number, range) = (&self.plan.number, self.range.clone());
        let Scratch {
            drive, to, trains, ..
        } = scratch;
        match &mut cells.memory {
            // Moved while it fired.
            Memory::FilteredStep(_) if !self.is_authors() => {}
            Memory::FilteredStep(stepped) | Memory::PixelStep(stepped) => {
                stepped
                    .take(range, &trains.counts)
                    .map_err(|x| self.uncountable(x, to[x]))?;
            }
            Memory::FilteredSnap { filtered, pixels } => {
                for (x, cell) in range.enumerate() {
                    if trains.counts[x] == 0 {
                        continue;
                    }
                    // `fire` lowers what is stored by all that has leaked since the first frame, so
                    // what has leaked until now is added to it.
                    let fallen = cells.leak.get(cell).map_or(N::Real::ZERO, |leak| {
                        *leak * N::Real::from_f64(self.input.elapsed)
                    });
                    let memory = number.real(drive[x]) + fallen;
                    filtered[cell] = number.hold_real(memory);
                    if !self.plan.exact.is_empty() && !cells.leak.is_empty() {
                        let held = &filtered[cell..=cell];
                        let lost = drive::held(number, held, &[memory.to_f64()]);
                        report.overflowed.at += lost.at;
                    }
                    if let Some(pixels) = pixels {
                        let now = self.signal.inner(self.y)[x];
                        let own = number.real(number.sub(now, pixels[cell]));
                        pixels[cell] = now;
                        sign(&mut trains.counts[x], own, report);
                    }
                }
            }
            Memory::RawSnap { pixels, before } => {
                // The memory may already be that of another kind, which fired here: the distances
                // are those from the memory before this frame.
                let distances = self.input.pixels_of(self.channel).inner(self.y);
                let pixels = if pixels.is_empty() {
                    &mut picture[self.pixels.clone()]
                } else {
                    &mut pixels[range.clone()]
                };
                for (x, cell) in range.enumerate() {
                    let same = before[cell] == drive[x];
                    before[cell] = drive[x];
                    if trains.counts[x] == 0 {
                        continue;
                    }
                    let own = number.real(distances[x]);
                    pixels[x] = self.signal.inner(self.y)[x];
                    // It fires again although neither its distance nor its pixel has changed.
                    report.livelocked += u64::from(same && own == N::Real::ZERO);
                    if self.plan.description.polarity == PolarityRule::Pixel {
                        sign(&mut trains.counts[x], own, report);
                    }
                }
            }
        }
        Ok(())
    }

    /// (9): removes the events that the dead time loses, of those that were `counted`; returns the
    /// number of the others.
    fn dead_time(
        &self,
        cells: &mut Cells<N>,
        scratch: &mut Scratch<N>,
        (counted, report): (Option<u64>, &mut Report),
    ) -> u64 {
        let fired = &mut cells.fired[self.range.clone()];
        let before = counted.unwrap_or_else(|| scratch.trains.events());
        let (interval, r) = (self.input.interval, self.plan.refractory());
        refractory::dead_time(interval, r, fired, &mut scratch.trains);
        let left = scratch.trains.events();
        report.lost_to_refractory += before - left;
        left
    }

    fn is_authors(&self) -> bool {
        self.plan.description.refractory.rule == RefractoryRule::Authors
    }

    /// The error for a cell whose distance has more events than can be counted, or left the
    /// number format.
    fn uncountable(&self, x: usize, distance: N::Real) -> SensorError {
        let channel = self.channel;
        let at = self.plan.place(channel, self.y, x);
        let (y, x) = (at.y, at.x);
        if fire::is_number(distance) {
            return SensorError::Uncountable { channel, y, x };
        }
        let format = self.plan.number.format();
        SensorError::Overflow {
            channel,
            y,
            x,
            format,
        }
    }
}

/// The memory has fallen by the leak, so the drive lies that much higher above it.
fn fall<R: Real>(distances: &mut [R], leak: &[R], seconds: f64) {
    for (d, leak) in distances.iter_mut().zip(leak) {
        *d = *d + *leak * R::from_f64(seconds);
    }
}

/// Gives an event the sign of the pixel's own change (8); without a change there is no event.
fn sign<R: Real>(count: &mut i32, own: R, report: &mut Report) {
    *count = if own > R::ZERO {
        count.abs()
    } else if own < R::ZERO {
        -count.abs()
    } else {
        report.without_sign += 1;
        0
    };
}
