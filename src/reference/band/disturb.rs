//! What noise makes cells fire besides what the scene does.

use crate::{
    number::Number,
    reference::{
        reason::Place,
        refractory::awake,
        stray::Strays,
        train::{BandSink, Pair, Train},
    },
    sensor::SensorError,
};

use super::{Band, Plan, Scratch};

impl<N: Number> Band<N> {
    /// Tells of what noise makes the cells of a row fire, besides what the scene did: a row
    /// with the first such event of each cell, one with the second, and so on.
    pub(super) fn disturb<S: BandSink>(
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
            for (u, polarity) in all.in_cell(place, light) {
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
