//! The plain version: the same model as the obvious loop over pixels, in double precision.

#![expect(
    clippy::needless_range_loop,
    reason = "the plain version is written plainly"
)]

use amacrine::{
    event::{Event, Polarity},
    reference::Description,
    scene::Frame,
    unit::Micros,
};

use crate::{scene::Clip, timing::Timing};

/// A memory that steps, one kernel, one threshold, linear light, replicated borders.
struct Plain {
    kernel: Vec<Vec<f64>>,
    threshold: f64,
    memory: Vec<Vec<f64>>,
    before: Vec<Vec<f64>>,
    last: f64,
    events: Vec<Event>,
}

impl Plain {
    fn new(description: &Description) -> Self {
        let channel = &description.channels[0];
        let rows = channel.kernels[0].weights().rows();
        Self {
            kernel: rows.into_iter().map(|row| row.to_vec()).collect(),
            threshold: channel.thresholds[0].on,
            memory: Vec::new(),
            before: Vec::new(),
            last: 0.0,
            events: Vec::new(),
        }
    }

    /// Events since the frame before, in order of time.
    fn watch(&mut self, frame: &Frame) {
        let (height, width) = frame.light.dim();
        let reach = self.kernel.len() / 2;
        let mut drive = vec![vec![0.0; width]; height];
        for (y, row) in drive.iter_mut().enumerate() {
            for (x, drive) in row.iter_mut().enumerate() {
                for (i, weights) in self.kernel.iter().enumerate() {
                    for (j, weight) in weights.iter().enumerate() {
                        let y = (y + i).saturating_sub(reach).min(height - 1);
                        let x = (x + j).saturating_sub(reach).min(width - 1);
                        *drive += weight * (frame.light[[y, x]] / 255.0);
                    }
                }
            }
        }
        self.events.clear();
        if self.memory.is_empty() {
            self.memory.clone_from(&drive);
        } else {
            for y in 0..height {
                for x in 0..width {
                    self.fire(frame.seconds, (y, x), drive[y][x]);
                }
            }
            self.events.sort_by_key(|event| event.t);
        }
        self.before = drive;
        self.last = frame.seconds;
    }

    fn fire(&mut self, now: f64, (y, x): (usize, usize), drive: f64) {
        let memory = self.memory[y][x];
        let (from, to) = (self.before[y][x] - memory, drive - memory);
        let count = (to.abs() / self.threshold * (1.0 + 1e-12)).floor();
        let polarity = if to > 0.0 {
            Polarity::On
        } else {
            Polarity::Off
        };
        for i in 1..=count as u64 {
            let level = i as f64 * self.threshold * to.signum();
            let place = (level - from) / (to - from);
            let seconds = self.last + place.clamp(0.0, 1.0) * (now - self.last);
            self.events.push(Event {
                t: Micros::from_seconds(seconds),
                x: x as u16,
                y: y as u16,
                polarity,
                channel: 0,
            });
        }
        self.memory[y][x] += count * self.threshold * to.signum();
    }
}

/// What the plain version takes for a pair.
pub struct Pace {
    pub seconds: f64,
    pub events: f64,
}

pub fn pace(description: &Description, clip: &mut Clip, timing: Timing) -> Pace {
    let mut plain = Plain::new(description);
    clip.rewind();
    for _ in 0..=Clip::ROUND {
        plain.watch(clip.advance());
    }
    let mut events = 0;
    for _ in 0..Clip::ROUND {
        plain.watch(clip.advance());
        events += plain.events.len();
    }
    Pace {
        events: events as f64 / Clip::ROUND as f64,
        seconds: timing.time(|| plain.watch(clip.advance())).median,
    }
}
