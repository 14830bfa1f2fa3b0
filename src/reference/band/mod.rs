//! A band of rows: the state of its cells, and one interval for all of them. The work goes row by
//! row while the row is in cache: drive, distance from memory, events, refractory period, memory.

mod cells;
mod disturb;
mod plan;
mod row;

use std::ops::Range;

use crate::{
    aligned::Aligned,
    number::{Number, Real},
    sensor::SensorError,
};

#[cfg(test)]
use super::memory::Stepped;
use super::{
    drive::{self, Made, Parts},
    memory::Memory,
    report::Report,
    sheets::Sheets,
    signal::{Light, Padded},
    train::{BandSink, TrainRow},
};

pub(super) use self::plan::{IntervalInput, Plan};
use self::row::Row;

/// The cells of some rows, all channels.
#[derive(Clone, Debug)]
pub(super) struct Band<N: Number> {
    pub(super) rows: Range<usize>,
    width: usize,
    /// The signal of the last frame, with the rim that the kernels reach.
    pub(super) signal: Padded<N::Held>,
    /// The largest signal of all frames so far, without its sign; in fixed point alone.
    pub(super) most: f64,
    cells: Cells<N>,
    /// Intermediate results of each channel's kernel, shared by the rows.
    made: Vec<Made<N::Held>>,
    /// The memory of the pixels that all channels share; empty where each has its own.
    picture: Vec<N::Held>,
    scratch: Scratch<N>,
    pub(super) report: Report,
}

/// The cells of a band: row after row, and in each row channel after channel, so that what a row
/// takes lies side by side in memory.
#[derive(Clone, Debug)]
struct Cells<N: Number> {
    memory: Memory<N>,
    /// The drive `W * u` at the frame before, for a memory that steps.
    before: Aligned<N::Held>,
    /// When each cell last fired, in seconds; only with a refractory period.
    fired: Vec<f64>,
    /// How far the leak lowers each memory in a second, in the unit of the drive; only with leak.
    leak: Vec<N::Real>,
}

/// Working memory for one row.
#[derive(Clone, Debug)]
struct Scratch<N: Number> {
    drive: Vec<N::Held>,
    parts: Parts<N::Held>,
    memory: Vec<N::Held>,
    to: Vec<N::Real>,
    trains: TrainRow<N::Real>,
    /// When each cell last fired before this interval, in seconds.
    rested: Vec<f64>,
}

impl<N: Number> Band<N> {
    /// A band after the first frame, which sets its memories.
    ///
    /// # Errors
    /// As [`Band::see`].
    pub(super) fn settle(
        plan: &Plan<N>,
        mut signal: Padded<N::Held>,
        rows: Range<usize>,
        light: Light<'_, N>,
        sheets: Option<&Sheets>,
    ) -> Result<Self, SensorError> {
        see(plan, &mut signal, light)?;
        let width = signal.inner(rows.start).len();
        let mut scratch = Scratch {
            drive: vec![N::ZERO; width],
            parts: Parts::default(),
            memory: vec![N::ZERO; width],
            to: vec![N::Real::ZERO; width],
            trains: TrainRow::new(width),
            rested: vec![f64::NEG_INFINITY; width],
        };
        let mut report = Report::default();
        let most = largest(plan, &signal);
        let seen = (&signal, most, sheets);
        let cells = Cells::settle(plan, &rows, seen, &mut scratch, &mut report);
        let picture = if plan.description.shared {
            rows.clone()
                .flat_map(|y| signal.inner(y).iter().copied())
                .collect()
        } else {
            Vec::new()
        };
        Ok(Self {
            rows,
            width,
            signal,
            most,
            cells,
            made: plan.weights.iter().map(|_| Made::default()).collect(),
            picture,
            scratch,
            report,
        })
    }

    /// Computes the signal of a frame.
    ///
    /// # Errors
    /// When it holds light that the response is not defined for.
    pub(super) fn see(&mut self, plan: &Plan<N>, light: Light<'_, N>) -> Result<(), SensorError> {
        see(plan, &mut self.signal, light)?;
        self.most = f64::max(self.most, largest(plan, &self.signal));
        Ok(())
    }

    /// Bytes of its cells that must last to the next frame.
    #[cfg(test)]
    pub(super) fn kept(&self) -> usize {
        let Cells {
            memory,
            before,
            fired,
            // Drawn anew, it is the same.
            leak: _,
        } = &self.cells;
        let held = size_of::<N::Held>();
        let stepped = |it: &Stepped<N>| {
            let Stepped { base, net, off } = it;
            size_of_val(&**base) + size_of_val(&**net) + off.as_ref().map_or(0, |off| 8 * off.len())
        };
        let memory = match memory {
            // The distances are for the report.
            Memory::RawSnap { pixels, before: _ } => held * pixels.len(),
            Memory::FilteredSnap { filtered, pixels } => {
                held * (filtered.len() + pixels.as_ref().map_or(0, Vec::len))
            }
            Memory::FilteredStep(it) | Memory::PixelStep(it) => stepped(it),
        };
        memory + held * (before.len() + self.picture.len()) + 8 * fired.len()
    }

    /// Row `y` of a pixel memory, or of the filtered one.
    pub(super) fn memory_row(&self, plan: &Plan<N>, channel: usize, y: usize, out: &mut [N::Held]) {
        let range = self.range(channel, y);
        match &self.cells.memory {
            Memory::RawSnap { pixels, .. } if pixels.is_empty() => {
                out.copy_from_slice(&self.picture[self.pixels(y)]);
            }
            Memory::RawSnap { pixels, .. } => out.copy_from_slice(&pixels[range]),
            Memory::FilteredSnap { filtered, .. } => out.copy_from_slice(&filtered[range]),
            Memory::FilteredStep(stepped) | Memory::PixelStep(stepped) => {
                let (on, off) = plan.thresholds[channel].row(y);
                stepped.values(&plan.number, range, on, off, out);
            }
        }
    }

    /// How far the leak lowers each memory of row `y` in a second; empty without leak.
    pub(super) fn leak_row(&self, channel: usize, y: usize) -> &[N::Real] {
        let leak = &self.cells.leak;
        leak.get(self.range(channel, y)).unwrap_or_default()
    }

    /// The indices of a channel's row `y` among the band's cells.
    fn range(&self, channel: usize, y: usize) -> Range<usize> {
        let start = ((y - self.rows.start) * self.made.len() + channel) * self.width;
        start..start + self.width
    }

    /// The indices of row `y` among the band's pixels.
    fn pixels(&self, y: usize) -> Range<usize> {
        let start = (y - self.rows.start) * self.width;
        start..start + self.width
    }

    /// Advances all cells through one interval: row by row, and in each row channel by channel,
    /// while the signal is in cache.
    pub(super) fn advance<S: BandSink>(
        &mut self,
        plan: &Plan<N>,
        input: IntervalInput<'_, N>,
        sink: &mut S,
    ) -> Result<(), SensorError> {
        if let Some(light) = input.light {
            self.see(plan, light)?;
            for (made, weights) in self.made.iter_mut().zip(&plan.weights) {
                weights.multiply(&plan.number, &self.signal, made);
            }
        }
        for y in self.rows.clone() {
            for channel in 0..plan.weights.len() {
                let row = Row {
                    plan,
                    signal: &self.signal,
                    most: self.most,
                    input,
                    channel,
                    y,
                    range: self.range(channel, y),
                    pixels: self.pixels(y),
                };
                let cells = (&mut self.cells, &mut self.made[channel]);
                let scratch = &mut self.scratch;
                let picture = &mut self.picture;
                self.report.events += row.advance(cells, picture, scratch, &mut self.report)?;
                // The dead time keeps noise events from where the events were before the jitter,
                // which changes no counts.
                let noise_events = if plan.description.noise.fires() {
                    self.noise_events(plan, channel, y, input.interval)
                } else {
                    Vec::new()
                };
                self.jitter(plan, channel, y, input);
                sink.row(&self.scratch.trains)?;
                if !noise_events.is_empty() {
                    self.disturb(&noise_events, sink)?;
                }
            }
        }
        Ok(())
    }
}

/// The largest signal, without its sign; 0 in formats that are not fixed point.
fn largest<N: Number>(plan: &Plan<N>, signal: &Padded<N::Held>) -> f64 {
    if plan.exact.is_empty() {
        return 0.0;
    }
    drive::largest(&plan.number, signal)
}

fn see<N: Number>(
    plan: &Plan<N>,
    signal: &mut Padded<N::Held>,
    light: Light<'_, N>,
) -> Result<(), SensorError> {
    let border = plan.description.border;
    let mut rows = signal.needed();
    rows.try_for_each(|y| signal.fill(y, border, N::ZERO, |row| light.row(y, row)))
}
