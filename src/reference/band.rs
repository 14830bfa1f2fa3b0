//! A band of rows: its cells' state, and one pair of frames for all of them, row by row, with
//! the row in cache: drive, distance from memory, fire, refractory, what it does to the memory.

use std::ops::Range;

use crate::{
    lined::Lined,
    number::{Number, Real},
    plane::Size,
    sensor::SensorError,
};

use super::{
    Report,
    description::{Description, MemoryRule, PolarityRule, RefractoryRule},
    drive::{Parts, Products, Weights, log_temporal},
    fire,
    hash::Place,
    memory::{self, Memory, Stepped},
    noise::{Noise, Thresholds},
    refractory::{self, awake},
    signal::{Light, Padded},
    step::Seen,
    stray::Strays,
    surround::{self, Sheets},
    train::{BandSink, Pair, Train, TrainRow},
};

/// What all bands of a sensor share.
#[derive(Clone, Debug)]
pub(super) struct Plan<N: Number> {
    pub(super) number: N,
    pub(super) description: Description,
    pub(super) seed: u64,
    /// For each channel.
    pub(super) weights: Vec<Weights<N::Held>>,
    pub(super) memory_weights: Vec<Option<Weights<N::Held>>>,
    pub(super) thresholds: Vec<Thresholds<N::Real>>,
}

impl<N: Number> Plan<N> {
    pub(super) fn new(number: N, description: Description, size: Size, seed: u64) -> Self {
        let channels = &description.channels;
        let weights = channels
            .iter()
            .map(|c| Weights::new(&number, &c.kernels))
            .collect();
        let memory_weights = channels
            .iter()
            .map(|c| {
                c.memory_kernel
                    .as_ref()
                    .map(|k| Weights::new(&number, std::slice::from_ref(k)))
            })
            .collect();
        let thresholds = channels
            .iter()
            .enumerate()
            .map(|(number, channel)| Thresholds::new(&channel.thresholds, size, seed, number))
            .collect();
        Self {
            number,
            description,
            seed,
            weights,
            memory_weights,
            thresholds,
        }
    }

    fn refractory(&self) -> f64 {
        self.description.refractory.us * 1e-6
    }
}

/// What all bands see of a pair of frames.
#[derive(Debug)]
pub(super) struct Sight<'a, N: Number> {
    /// The frame; none if the bands have taken it in already.
    pub(super) light: Option<Light<'a, N>>,
    /// For each channel, where the memory holds pixels: the memory if it steps, the signal's
    /// distance from it if it snaps.
    pub(super) pixels: &'a [Padded<N::Held>],
    /// Resistor sheets, where channels see through them.
    pub(super) sheets: Option<&'a Sheets>,
    pub(super) pair: Pair,
    /// Seconds since the first frame.
    pub(super) elapsed: f64,
    /// Whether the times of the events are wanted.
    pub(super) times: bool,
}

/// Derived, it would ask for a number that can be copied held.
impl<N: Number> Copy for Sight<'_, N> {}

#[expect(clippy::expl_impl_clone_on_copy, reason = "as above")]
impl<N: Number> Clone for Sight<'_, N> {
    fn clone(&self) -> Self {
        *self
    }
}

/// The cells of some rows, all channels.
#[derive(Clone, Debug)]
pub(super) struct Band<N: Number> {
    pub(super) rows: Range<usize>,
    width: usize,
    /// What its cells see of the last frame.
    pub(super) signal: Padded<N::Held>,
    channels: Vec<Cells<N>>,
    scratch: Scratch<N>,
    pub(super) report: Report,
}

/// The cells of one channel in a band, row after row.
#[derive(Clone, Debug)]
struct Cells<N: Number> {
    memory: Memory<N>,
    /// What the weights make of the signal, for a memory of what they see.
    products: Products<N::Held>,
    /// `W * u` at the frame before, for a memory that steps.
    before: Lined<N::Held>,
    /// When each cell last fired, in seconds; only with a refractory period.
    fired: Vec<f64>,
    /// How far each memory falls in a second; only with leak.
    leak: Vec<N::Real>,
}

/// One row of everything.
#[derive(Clone, Debug)]
struct Scratch<N: Number> {
    drive: Vec<N::Held>,
    parts: Parts<N::Held>,
    memory: Vec<N::Held>,
    to: Vec<N::Real>,
    trains: TrainRow<N::Real>,
    /// When each cell had last fired before this pair, in seconds.
    rested: Vec<f64>,
}

impl<N: Number> Band<N> {
    /// A band whose memory is what it sees at the first frame.
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

    /// Takes in a frame.
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

    /// How far each memory of row `y` falls in a second; empty without leak.
    pub(super) fn leak_row(&self, channel: usize, y: usize) -> &[N::Real] {
        let leak = &self.channels[channel].leak;
        leak.get(self.range(y)).unwrap_or_default()
    }

    /// The cells of row `y` in the band's own arrays.
    fn range(&self, y: usize) -> Range<usize> {
        let start = (y - self.rows.start) * self.width;
        start..start + self.width
    }

    /// One pair of frames: row by row, and for each row channel by channel, while what they
    /// see is in cache.
    pub(super) fn advance<S: BandSink>(
        &mut self,
        plan: &Plan<N>,
        sight: Sight<'_, N>,
        sink: &mut S,
    ) -> Result<(), SensorError> {
        if let Some(light) = sight.light {
            self.see(plan, light)?;
            for (cells, weights) in self.channels.iter_mut().zip(&plan.weights) {
                weights.multiply(&plan.number, &self.signal, &mut cells.products);
            }
        }
        for y in self.rows.clone() {
            for channel in 0..plan.weights.len() {
                self.report.events += self.row(plan, channel, y, sight)?;
                sink.row(&self.scratch.trains)?;
                if plan.description.noise.fires() {
                    self.disturb(plan, channel, y, sight.pair, sink)?;
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
        sight: Sight<'_, N>,
    ) -> Result<u64, SensorError> {
        let Sight {
            pixels,
            sheets,
            pair,
            elapsed,
            times,
            ..
        } = sight;
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
            products,
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
        surround::row(number, sheets, (channel, y), drive, |drive| match state {
            Memory::RawSnap { .. } => weights.row(number, &pixels[channel], y, drive, parts),
            Memory::PixelStep(_) => weights.row(number, signal, y, drive, parts),
            Memory::FilteredSnap { .. } | Memory::FilteredStep(_) => {
                weights.row_of(number, (signal, products), y, drive, parts);
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
                    elapsed: (elapsed - pair.duration(), elapsed),
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
                // Without a refractory period all cells are always rested.
                rested.fill(f64::NEG_INFINITY);
                &mut rested[..]
            } else {
                &mut fired[range.clone()]
            };
            let r = plan.refractory();
            if !refractory::authors(pair, r, (on, off), to, fired, trains) {
                let mut counts = trains.counts.iter();
                let most = memory::MOST.unsigned_abs();
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
                    // The leak goes on from here.
                    let fallen = leak
                        .get(cell)
                        .map_or(N::Real::ZERO, |leak| *leak * N::Real::of(elapsed));
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
            refractory::dead_time(pair, plan.refractory(), fired, trains);
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
                    Some(
                        description
                            .noise
                            .jitter(train, place, pair.index, pair.duration()),
                    ),
                );
            }
        }
        Ok(events.unwrap_or_else(|| trains.events()))
    }

    /// Tells of what noise makes the cells of a row fire, besides what the scene did: a row
    /// with the first such event of each cell, one with the second, and so on.
    fn disturb<S: BandSink>(
        &mut self,
        plan: &Plan<N>,
        channel: usize,
        y: usize,
        pair: Pair,
        sink: &mut S,
    ) -> Result<(), SensorError> {
        let range = self.range(y);
        let (noise, response) = (&plan.description.noise, plan.description.response);
        let (dt, refractory) = (pair.duration(), plan.refractory());
        let Scratch { trains, rested, .. } = &mut self.scratch;
        let fired = &mut self.channels[channel].fired;
        let seen = self.signal.inner(y);
        let all = Strays::new(noise, plan.seed, pair.index, dt);
        let mut strays = Vec::new();
        for x in 0..self.width {
            let place = Place {
                seed: plan.seed,
                channel,
                y,
                x,
            };
            if !all.may_be(place) {
                continue;
            }
            let light = || response.light(plan.number.value(seen[x]));
            for (u, polarity) in all.of(place, light) {
                if refractory > 0.0 {
                    let before = (rested[x] - pair.from) / dt;
                    if !awake(u, trains.get(x).as_ref(), before, refractory / dt) {
                        self.report.lost_to_refractory += 1;
                        continue;
                    }
                    rested[x] = pair.from + u * dt;
                    let fired = &mut fired[range.start + x];
                    *fired = fired.max(rested[x]);
                }
                strays.push((
                    x,
                    Train {
                        polarity,
                        count: 1,
                        first: u,
                        spacing: 0.0,
                    },
                ));
            }
        }
        self.report.events += strays.len() as u64;
        while !strays.is_empty() {
            trains.counts.fill(0);
            let mut told = None;
            strays.retain(|(x, train)| {
                if told == Some(*x) {
                    return true;
                }
                told = Some(*x);
                trains.set(*x, Some(*train));
                false
            });
            sink.row(trains)?;
        }
        Ok(())
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

impl<N: Number> Cells<N> {
    fn settle(
        plan: &Plan<N>,
        channel: usize,
        rows: &Range<usize>,
        (signal, sheets): (&Padded<N::Held>, Option<&Sheets>),
        scratch: &mut Scratch<N>,
    ) -> Self {
        let (number, description) = (&plan.number, &plan.description);
        let width = scratch.drive.len();
        let cells = rows.len() * width;
        let mut filtered = Vec::with_capacity(cells);
        let mut pixels = Vec::with_capacity(cells);
        for y in rows.clone() {
            let Scratch { drive, parts, .. } = scratch;
            surround::row(number, sheets, (channel, y), drive, |drive| {
                plan.weights[channel].row(number, signal, y, drive, parts);
            });
            if description.channels[channel].log_temporal {
                log_temporal(number, &mut scratch.drive, 0.0);
            }
            filtered.extend_from_slice(&scratch.drive);
            pixels.extend_from_slice(signal.inner(y));
        }
        let steps = description.memory == MemoryRule::FilteredStep;
        let before = if steps {
            Lined::of(5, &filtered)
        } else {
            Lined::default()
        };
        let thresholds = &plan.thresholds[channel];
        let noise = description.noise;
        let place = |cell: usize| Place {
            seed: plan.seed,
            channel,
            y: rows.start + cell / width,
            x: cell % width,
        };
        let on = |cell: usize| {
            let (on, _) = thresholds.row(rows.start + cell / width);
            on[cell % width]
        };
        if noise.leak_hz > 0.0 {
            for (cell, memory) in filtered.iter_mut().enumerate() {
                let fallen = N::Real::of(Noise::leaked(place(cell))) * on(cell);
                *memory = number.hold_real(number.real(*memory) - fallen);
            }
        }
        let memory = match description.memory {
            MemoryRule::RawSnap => Memory::RawSnap {
                pixels,
                before: vec![N::ZERO; cells],
            },
            MemoryRule::FilteredSnap => Memory::FilteredSnap {
                filtered,
                pixels: (description.polarity == PolarityRule::Pixel).then_some(pixels),
            },
            MemoryRule::FilteredStep => {
                Memory::FilteredStep(Stepped::new(&filtered, thresholds.equal))
            }
            MemoryRule::AuthorsPixelStep => {
                Memory::PixelStep(Stepped::new(&pixels, thresholds.equal))
            }
        };
        let refractory = plan.refractory();
        // Before its first event a cell is ready, whenever its first frame is.
        let fired = if refractory > 0.0 {
            vec![f64::NEG_INFINITY; cells]
        } else {
            Vec::new()
        };
        let leak = if noise.leak_hz > 0.0 {
            let leak = |cell| N::Real::of(noise.leak(place(cell), on(cell).to_f64()));
            (0..cells).map(leak).collect()
        } else {
            Vec::new()
        };
        Self {
            memory,
            products: Products::default(),
            before,
            fired,
            leak,
        }
    }
}

/// The memory has fallen, so the drive stands higher above it.
fn fall<R: Real>(distances: &mut [R], leak: &[R], seconds: f64) {
    for (d, leak) in distances.iter_mut().zip(leak) {
        *d = *d + *leak * R::of(seconds);
    }
}

/// Gives an event the sign of the pixel's own change; without one there is no event.
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
