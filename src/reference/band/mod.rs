//! A band of rows: the state of its cells, and one interval for all of them. The work goes row by
//! row while the row is in cache: drive, distance from memory, events, refractory period, memory.

mod cells;
mod disturb;
mod plan;

use std::ops::Range;

use crate::{
    aligned::Aligned,
    number::{Number, Real},
    sensor::SensorError,
};

use super::{
    description::{PolarityRule, RefractoryRule},
    drive::{Made, Parts, log_temporal},
    fire,
    memory::{self, Memory},
    reason::Place,
    refractory,
    report::Report,
    sheets::{self, Sheets},
    signal::{Light, Padded},
    step::Seen,
    train::{BandSink, TrainRow},
};

pub(super) use self::plan::{IntervalInput, Plan};

/// The cells of some rows, all channels.
#[derive(Clone, Debug)]
pub(super) struct Band<N: Number> {
    pub(super) rows: Range<usize>,
    width: usize,
    /// The signal of the last frame, with the rim that the kernels reach.
    pub(super) signal: Padded<N::Held>,
    channels: Vec<Cells<N>>,
    scratch: Scratch<N>,
    pub(super) report: Report,
}

/// The cells of one channel in a band, row after row.
#[derive(Clone, Debug)]
struct Cells<N: Number> {
    memory: Memory<N>,
    /// Intermediate results of the kernel, shared by the rows.
    made: Made<N::Held>,
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
        let channels = (0..plan.weights.len())
            .map(|channel| Cells::settle(plan, channel, &rows, (&signal, sheets), &mut scratch))
            .collect();
        Ok(Self {
            rows,
            width,
            signal,
            channels,
            scratch,
            report: Report::default(),
        })
    }

    /// Computes the signal of a frame.
    ///
    /// # Errors
    /// When it holds light that the response is not defined for.
    pub(super) fn see(&mut self, plan: &Plan<N>, light: Light<'_, N>) -> Result<(), SensorError> {
        see(plan, &mut self.signal, light)
    }

    /// Row `y` of a pixel memory, or of the filtered one.
    pub(super) fn memory_row(&self, plan: &Plan<N>, channel: usize, y: usize, out: &mut [N::Held]) {
        let range = self.range(y);
        match &self.channels[channel].memory {
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
        let leak = &self.channels[channel].leak;
        leak.get(self.range(y)).unwrap_or_default()
    }

    /// The indices of row `y` in the band's arrays.
    fn range(&self, y: usize) -> Range<usize> {
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
            for (cells, weights) in self.channels.iter_mut().zip(&plan.weights) {
                weights.multiply(&plan.number, &self.signal, &mut cells.made);
            }
        }
        for y in self.rows.clone() {
            for channel in 0..plan.weights.len() {
                self.report.events += self.row(plan, channel, y, input)?;
                sink.row(&self.scratch.trains)?;
                if plan.description.noise.fires() {
                    self.disturb(plan, channel, y, input.interval, sink)?;
                }
            }
        }
        Ok(())
    }

    /// One row of a channel; how many events it makes.
    #[expect(
        clippy::too_many_lines,
        reason = "one row from drive to memory, a paragraph for each memory rule"
    )]
    fn row(
        &mut self,
        plan: &Plan<N>,
        channel: usize,
        y: usize,
        input: IntervalInput<'_, N>,
    ) -> Result<u64, SensorError> {
        let IntervalInput {
            pixels,
            sheets,
            interval,
            elapsed,
            times,
            ..
        } = input;
        let range = self.range(y);
        let (number, description) = (&plan.number, &plan.description);
        let Self {
            signal,
            channels,
            scratch,
            report,
            ..
        } = self;
        let Scratch {
            drive,
            parts,
            memory,
            to,
            trains,
            rested,
        } = scratch;
        let Cells {
            memory: state,
            made,
            before,
            fired,
            leak,
        } = &mut channels[channel];
        let (on, off) = plan.thresholds[channel].row(y);
        let authors = description.refractory.rule == RefractoryRule::Authors;
        let beyond = |x, distance: N::Real| {
            if fire::is_number(distance) {
                return SensorError::Uncountable { channel, y, x };
            }
            let format = number.format();
            SensorError::Overflow {
                channel,
                y,
                x,
                format,
            }
        };
        if description.noise.fires() && !fired.is_empty() {
            rested.copy_from_slice(&fired[range.clone()]);
        }
        (trains.channel, trains.y) = (channel, y);

        let weights = &plan.weights[channel];
        sheets::row(number, sheets, (channel, y), drive, |drive| match state {
            Memory::RawSnap { .. } => weights.row(number, &pixels[channel], y, drive, parts),
            Memory::PixelStep(_) => weights.row(number, signal, y, drive, parts),
            Memory::FilteredSnap { .. } | Memory::FilteredStep(_) => {
                weights.row_in_order(number, (signal, made), y, drive, parts);
            }
        });
        if description.channels[channel].log_temporal {
            log_temporal(number, drive, 1e-8);
        }
        let mut snapped = true;
        let mut events = None;
        match state {
            Memory::FilteredStep(stepped) if authors => {
                stepped.values(number, range.clone(), on, off, memory);
                memory::distance(number, drive, memory, to);
            }
            Memory::FilteredStep(stepped) => {
                let seen = Seen {
                    drive,
                    on,
                    off,
                    per: plan.thresholds[channel].inverse(y),
                    leak: leak.get(range.clone()).unwrap_or_default(),
                    elapsed: (elapsed - interval.duration(), elapsed),
                };
                let times = times || !fired.is_empty();
                let before = &mut before[range.clone()];
                let crossed =
                    stepped.cross(number, range.clone(), before, &seen, times, (trains, to));
                events = Some(crossed.map_err(|x| {
                    let base = stepped.base[range.start + x];
                    beyond(x, number.real(number.sub(drive[x], base)))
                })?);
            }
            Memory::PixelStep(_) => {
                let Some(weights) = &plan.memory_weights[channel] else {
                    return Ok(0);
                };
                weights.row(number, &pixels[channel], y, memory, parts);
                memory::distance(number, drive, memory, to);
            }
            Memory::FilteredSnap { filtered, .. } => {
                memory::distance(number, drive, &filtered[range.clone()], to);
                if !leak.is_empty() {
                    fall(to, &leak[range.clone()], elapsed);
                }
                snapped = fire::snap(to, on, off, trains);
            }
            Memory::RawSnap { .. } => {
                for (to, drive) in to.iter_mut().zip(drive.iter()) {
                    *to = number.real(*drive);
                }
                snapped = fire::snap(to, on, off, trains);
            }
        }
        if !snapped {
            let x = to.iter().position(|d| !fire::is_number(*d)).unwrap_or(0);
            return Err(beyond(x, to[x]));
        }
        if authors {
            let fired = if fired.is_empty() {
                // Without a refractory period no cell is ever refractory.
                rested.fill(f64::NEG_INFINITY);
                &mut rested[..]
            } else {
                &mut fired[range.clone()]
            };
            let r = plan.refractory();
            if !refractory::authors(interval, r, (on, off), to, fired, trains) {
                let mut counts = trains.counts.iter();
                let most = memory::MAX_STEPS.unsigned_abs();
                let x = counts.position(|count| count.unsigned_abs() > most);
                let x = x.unwrap_or(0);
                return Err(beyond(x, to[x]));
            }
        }
        match state {
            Memory::FilteredStep(_) if !authors => {}
            Memory::FilteredStep(stepped) | Memory::PixelStep(stepped) => {
                stepped
                    .take(range.clone(), &trains.counts)
                    .map_err(|x| beyond(x, to[x]))?;
            }
            Memory::FilteredSnap { filtered, pixels } => {
                for (x, cell) in range.clone().enumerate() {
                    if trains.counts[x] == 0 {
                        continue;
                    }
                    // The leak goes on from the time of the event.
                    let fallen = leak
                        .get(cell)
                        .map_or(N::Real::ZERO, |leak| *leak * N::Real::from_f64(elapsed));
                    filtered[cell] = number.hold_real(number.real(drive[x]) + fallen);
                    if let Some(pixels) = pixels {
                        let now = signal.inner(y)[x];
                        let own = number.real(number.sub(now, pixels[cell]));
                        pixels[cell] = now;
                        sign(&mut trains.counts[x], own, report);
                    }
                }
            }
            Memory::RawSnap { pixels, before } => {
                for (x, cell) in range.clone().enumerate() {
                    let same = before[cell] == drive[x];
                    before[cell] = drive[x];
                    if trains.counts[x] == 0 {
                        continue;
                    }
                    let now = signal.inner(y)[x];
                    let own = number.real(number.sub(now, pixels[cell]));
                    pixels[cell] = now;
                    report.livelocked += u64::from(same && own == N::Real::ZERO);
                    if description.polarity == PolarityRule::Pixel {
                        sign(&mut trains.counts[x], own, report);
                    }
                }
            }
        }
        if !authors && !fired.is_empty() {
            let fired = &mut fired[range];
            let before = trains.events();
            refractory::dead_time(interval, plan.refractory(), fired, trains);
            let left = trains.events();
            report.lost_to_refractory += before - left;
            events = Some(left);
        }
        if description.noise.jitter_us > 0.0 && times {
            for x in 0..self.width {
                let Some(train) = trains.get(x) else { continue };
                let place = Place {
                    seed: plan.seed,
                    channel,
                    y,
                    x,
                };
                trains.set(
                    x,
                    Some(description.noise.jitter(
                        train,
                        place,
                        interval.index,
                        interval.duration(),
                    )),
                );
            }
        }
        Ok(events.unwrap_or_else(|| trains.events()))
    }
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
