//! The cells of one channel, from frame to frame: drive, memory, fire, refractory in turn.

use crate::{
    event::Polarity,
    plane::{Plane, Size},
    sensor::SensorError,
};

use super::{
    Report,
    description::{Channel, Description, Memory, PolarityRule, RefractoryRule},
    drive::{Padded, log_temporal},
    fire,
    memory::{State, Steps},
    noise::Mismatch,
    refractory,
    train::{Cell, Pair, Sink, Train},
};

/// All cells of one channel.
#[derive(Clone, Debug)]
pub(super) struct Cells {
    channel: usize,
    thresholds: Mismatch,
    /// What the memory is compared with: `W * u`, or the distance itself for pixel memories.
    drive: Plane<f64>,
    /// The same at the frame before.
    before: Plane<f64>,
    memory: Option<State>,
    /// When each cell last fired, in seconds; only with a refractory period.
    fired: Option<Plane<f64>>,
}

impl Cells {
    pub(super) fn new(description: &Description, channel: usize, size: Size, seed: u64) -> Self {
        let refractory = description.refractory.us * 1e-6;
        let nominal = &description.channels[channel].thresholds;
        Self {
            channel,
            thresholds: Mismatch::new(nominal, size, seed, channel),
            drive: Plane::zeros(size.shape()),
            before: Plane::zeros(size.shape()),
            memory: None,
            // As in the released code: before its first event, a cell is just ready.
            fired: (refractory > 0.0).then(|| Plane::from_elem(size.shape(), -refractory)),
        }
    }

    /// The memory as it stands; `None` before the first frame.
    pub(super) fn memory(&self) -> Option<Plane<f64>> {
        Some(match self.memory.as_ref()? {
            State::RawSnap { pixels } => pixels.clone(),
            State::FilteredSnap { filtered, .. } => filtered.clone(),
            State::FilteredStep { base, steps } | State::PixelStep { base, steps, .. } => {
                self.stepped(base, steps)
            }
        })
    }

    fn stepped(&self, base: &Plane<f64>, steps: &Plane<Steps>) -> Plane<f64> {
        Plane::from_shape_fn(base.dim(), |(y, x)| {
            steps[[y, x]].value(base[[y, x]], self.thresholds.at(y, x))
        })
    }

    /// The first frame: the memory becomes what it sees.
    pub(super) fn settle(
        &mut self,
        description: &Description,
        signal: &Plane<f64>,
        padded: &mut Padded,
    ) {
        let written = &description.channels[self.channel];
        filter(written, description, signal, padded, 0.0, &mut self.drive);
        let steps = Plane::from_elem(signal.dim(), Steps::default());
        let own_pixel = description.polarity == PolarityRule::Pixel;
        self.memory = Some(match (description.memory, &written.memory_kernel) {
            (Memory::RawSnap, _) => {
                self.drive.fill(0.0);
                State::RawSnap {
                    pixels: signal.clone(),
                }
            }
            (Memory::FilteredSnap, _) => State::FilteredSnap {
                filtered: self.drive.clone(),
                pixels: own_pixel.then(|| signal.clone()),
            },
            (Memory::AuthorsPixelStep, Some(kernel)) => State::PixelStep {
                base: signal.clone(),
                steps,
                seen_through: kernel.clone(),
            },
            (Memory::FilteredStep | Memory::AuthorsPixelStep, _) => State::FilteredStep {
                base: self.drive.clone(),
                steps,
            },
        });
    }

    /// One pair of frames: tells `sink` of every train.
    pub(super) fn advance<S: Sink>(
        &mut self,
        description: &Description,
        signal: &Plane<f64>,
        padded: &mut Padded,
        pair: Pair,
        sink: &mut S,
        report: &mut Report,
    ) -> Result<(), SensorError> {
        let written = &description.channels[self.channel];
        std::mem::swap(&mut self.drive, &mut self.before);
        match self.memory.as_ref() {
            None => return Ok(()),
            Some(State::RawSnap { pixels }) => {
                padded.fill(&(signal - pixels), description.border);
                padded.drive(&written.kernels, &mut self.drive);
            }
            Some(State::FilteredSnap { .. } | State::FilteredStep { .. }) => {
                filter(written, description, signal, padded, 1e-8, &mut self.drive);
            }
            Some(State::PixelStep {
                base,
                steps,
                seen_through,
            }) => {
                filter(written, description, signal, padded, 1e-8, &mut self.drive);
                padded.fill(&self.stepped(base, steps), description.border);
                let mut remembered = Plane::zeros(signal.dim());
                padded.drive(std::slice::from_ref(seen_through), &mut remembered);
                self.drive -= &remembered;
            }
        }
        let (height, width) = signal.dim();
        for y in 0..height {
            for x in 0..width {
                let Some(train) = self.fire(description, signal, pair, y, x, report)? else {
                    continue;
                };
                report.events += train.count;
                sink.train(
                    Cell {
                        channel: self.channel,
                        y,
                        x,
                    },
                    train,
                )?;
            }
        }
        Ok(())
    }

    /// One cell: what it fires, and what that does to its memory.
    fn fire(
        &mut self,
        description: &Description,
        signal: &Plane<f64>,
        pair: Pair,
        y: usize,
        x: usize,
        report: &mut Report,
    ) -> Result<Option<Train>, SensorError> {
        let at = [y, x];
        let threshold = self.thresholds.at(y, x);
        let (drive, before, now) = (self.drive[at], self.before[at], signal[at]);
        let uncountable = SensorError::Uncountable {
            channel: self.channel,
            y,
            x,
        };
        let Some(memory) = self.memory.as_mut() else {
            return Ok(None);
        };
        match memory {
            State::FilteredStep { base, steps } => {
                let held = steps[at].value(base[at], threshold);
                if description.refractory.rule == RefractoryRule::Authors {
                    let train = self.authors(description, pair, at, drive - held);
                    if let (Some(train), Some(State::FilteredStep { steps, .. })) =
                        (train, self.memory.as_mut())
                    {
                        steps[at]
                            .take(train.polarity, train.count)
                            .ok_or(uncountable)?;
                    }
                    return Ok(train);
                }
                let Some(train) = fire::ramp(before - held, drive - held, threshold) else {
                    return Ok(None);
                };
                steps[at]
                    .take(train.polarity, train.count)
                    .ok_or(uncountable)?;
                Ok(self.rest(description, pair, at, train, report))
            }
            State::PixelStep { steps, .. } => {
                let _ = steps;
                let train = self.authors(description, pair, at, drive);
                if let (Some(train), Some(State::PixelStep { steps, .. })) =
                    (train, self.memory.as_mut())
                {
                    steps[at]
                        .take(train.polarity, train.count)
                        .ok_or(uncountable)?;
                }
                Ok(train)
            }
            State::FilteredSnap { filtered, pixels } => {
                let Some(polarity) = fire::snap(drive - filtered[at], threshold) else {
                    return Ok(None);
                };
                filtered[at] = drive;
                let own = pixels
                    .as_mut()
                    .map(|pixels| now - std::mem::replace(&mut pixels[at], now));
                Ok(self.shot(description, pair, at, polarity, own, report))
            }
            State::RawSnap { pixels } => {
                let Some(polarity) = fire::snap(drive, threshold) else {
                    return Ok(None);
                };
                let own = now - std::mem::replace(&mut pixels[at], now);
                if own == 0.0 && drive == before {
                    report.livelocked += 1;
                }
                let own = (description.polarity == PolarityRule::Pixel).then_some(own);
                Ok(self.shot(description, pair, at, polarity, own, report))
            }
        }
    }

    /// A single event when the frame is taken, signed by the pixel's own change if that is given.
    fn shot(
        &mut self,
        description: &Description,
        pair: Pair,
        at: [usize; 2],
        filtered: Polarity,
        own: Option<f64>,
        report: &mut Report,
    ) -> Option<Train> {
        let polarity = match own {
            None => filtered,
            Some(change) if change > 0.0 => Polarity::On,
            Some(change) if change < 0.0 => Polarity::Off,
            Some(_) => {
                report.without_sign += 1;
                return None;
            }
        };
        let train = Train {
            polarity,
            count: 1,
            first: 1.0,
            spacing: 0.0,
        };
        self.rest(description, pair, at, train, report)
    }

    /// The dead time after an event.
    fn rest(
        &mut self,
        description: &Description,
        pair: Pair,
        at: [usize; 2],
        train: Train,
        report: &mut Report,
    ) -> Option<Train> {
        let Some(fired) = self.fired.as_mut() else {
            return Some(train);
        };
        let dt = pair.duration();
        let r = description.refractory.us * 1e-6;
        let kept = refractory::dead_time(train, r / dt, (pair.from - fired[at]) / dt);
        report.lost_to_refractory += train.count - kept.map_or(0, |kept| kept.count);
        if let Some(kept) = kept {
            fired[at] = pair.from + kept.last() * dt;
        }
        kept
    }

    /// The released simulator's rule.
    fn authors(
        &mut self,
        description: &Description,
        pair: Pair,
        at: [usize; 2],
        d: f64,
    ) -> Option<Train> {
        let r = description.refractory.us * 1e-6;
        let threshold = self.thresholds.at(at[0], at[1]);
        let since = self
            .fired
            .as_ref()
            .map_or(0.0, |fired| pair.from - fired[at]);
        let train = refractory::authors(d, threshold, pair.duration(), r, since)?;
        if let Some(fired) = self.fired.as_mut() {
            fired[at] = pair.from + train.last() * pair.duration();
        }
        Some(train)
    }
}

/// `W * u`, and the logarithm after it where the channel has one.
fn filter(
    written: &Channel,
    description: &Description,
    signal: &Plane<f64>,
    padded: &mut Padded,
    floor: f64,
    out: &mut Plane<f64>,
) {
    padded.fill(signal, description.border);
    padded.drive(&written.kernels, out);
    if written.log_temporal {
        log_temporal(out, floor);
    }
}
