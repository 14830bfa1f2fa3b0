//! What noise does to a row of cells: noise events, and jitter.

use std::ops::Range;

use crate::{
    number::Number,
    reference::{
        noise_event::NoiseEvents,
        refractory::awake,
        train::{BandSink, Interval, Train},
    },
    sensor::SensorError,
};

use super::{Band, IntervalInput, Plan, Scratch};

impl<N: Number> Band<N> {
    /// The noise events of a row that its dead time leaves, by column and then in order of time; its
    /// trains are those of its crossings.
    pub(super) fn noise_events(
        &mut self,
        plan: &Plan<N>,
        channel: usize,
        y: usize,
        interval: Interval,
    ) -> Vec<(usize, Train)> {
        let range = self.range(channel, y);
        let (noise, response) = (&plan.description.noise, plan.description.response);
        let (dt, refractory) = (interval.duration(), plan.refractory());
        let Scratch { trains, rested, .. } = &mut self.scratch;
        let fired = &mut self.cells.fired;
        let seen = self.signal.inner(y);
        let all = NoiseEvents::new(noise, plan.seed, interval.index, dt);
        let mut noise_events = Vec::new();
        for x in 0..self.width {
            let place = plan.place(channel, y, x);
            if !all.may_be(place) {
                continue;
            }
            let light = || response.light(plan.number.value(seen[x]));
            for (u, polarity) in all.in_cell(place, light) {
                if refractory > 0.0 {
                    let before = (rested[x] - interval.from) / dt;
                    if !awake(u, trains.get(x).as_ref(), before, refractory / dt) {
                        self.report.lost_to_refractory += 1;
                        continue;
                    }
                    rested[x] = interval.from + u * dt;
                    let fired = &mut fired[range.start + x];
                    *fired = fired.max(rested[x]);
                }
                noise_events.push((
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
        self.report.events += noise_events.len() as u64;
        noise_events
    }

    /// Moves the events of a row's trains a little, each by itself, where their times matter.
    pub(super) fn jitter(
        &mut self,
        plan: &Plan<N>,
        channel: usize,
        y: usize,
        input: IntervalInput<'_, N>,
    ) {
        let (noise, interval) = (&plan.description.noise, input.interval);
        if noise.jitter_us <= 0.0 || !input.times {
            return;
        }
        let trains = &mut self.scratch.trains;
        for x in 0..self.width {
            let Some(train) = trains.get(x) else { continue };
            let place = plan.place(channel, y, x);
            let moved = noise.jitter(train, place, interval.index, interval.duration());
            trains.set(x, Some(moved));
        }
    }

    /// Passes the noise events of a row to the sink: first a row with the first such event of each
    /// cell, then one with the second, and so on, as a row has one train a cell.
    pub(super) fn disturb<S: BandSink>(
        &mut self,
        noise_events: &[(usize, Train)],
        sink: &mut S,
    ) -> Result<(), SensorError> {
        let trains = &mut self.scratch.trains;
        // Of each cell, which of them are left.
        let mut left: Vec<Range<usize>> = Vec::new();
        for of_cell in noise_events.chunk_by(|a, b| a.0 == b.0) {
            let start = left.last().map_or(0, |before| before.end);
            left.push(start..start + of_cell.len());
        }
        while !left.is_empty() {
            trains.counts.fill(0);
            left.retain_mut(|events| {
                let next = events.next().and_then(|n| noise_events.get(n));
                if let Some((x, train)) = next {
                    trains.set(*x, Some(*train));
                }
                events.start < events.end
            });
            sink.row(trains)?;
        }
        Ok(())
    }
}
