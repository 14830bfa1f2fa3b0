//! Words: why a bound is what it is.

use crate::number::Format;

use super::{
    Bounds, Choice, Effect, Offer, bounds::Bound, chance::FAILS, perturbation::Perturbation,
};

impl Bound {
    /// Nothing changes.
    pub const NOTHING: Self = Self {
        events: 0.0,
        share: 0.0,
    };
}

impl Bounds {
    /// Everything that could be left out, by itself and with what has to go with it.
    #[must_use]
    pub fn offers(&self, formats: &[Format], choice: &Choice) -> Vec<Offer> {
        let offer = |what: String, format: Format, effect: Option<Effect>, why: String| {
            let alone = self.alone(format, effect);
            let with = alone.as_ref().map_or_else(
                || self.present.needs(effect),
                |(choice, _)| {
                    let others = choice.without.iter();
                    others.copied().filter(|e| Some(*e) != effect).collect()
                },
            );
            Offer {
                what,
                bound: alone.as_ref().map(|(_, bound)| *bound),
                model: alone.map(|(choice, _)| choice),
                with,
                left_out: match effect {
                    Some(effect) => choice.leaves_out(effect),
                    None => choice.format == format,
                },
                why,
            }
        };
        let there = Effect::ALL.into_iter().filter(|e| self.is_there(*e));
        let effects = there.map(|e| offer(e.to_string(), Format::F64, Some(e), self.why(e)));
        let formats = formats.iter().filter(|f| **f != Format::F64).map(|f| {
            let what = format!("f64, for {f}");
            offer(what, *f, None, self.why_format(*f))
        });
        effects.chain(formats).collect()
    }

    /// Whether the full model has it at all.
    fn is_there(&self, effect: Effect) -> bool {
        let present = self.present;
        match effect {
            Effect::Surroundings => self.crop,
            Effect::Readout => self.readout.is_some(),
            Effect::Strays => present.strays,
            Effect::Jitter => present.jitter,
            Effect::Refractory => present.dead_time,
            Effect::Upsampling => self.inserts,
            Effect::LowPass => present.low_pass,
            Effect::Settling => present.settling,
            Effect::SheetNoise => present.sheet_noise,
            Effect::Mismatch => present.mismatch,
        }
    }

    fn why(&self, effect: Effect) -> String {
        let seed = format!("for all but one in {:.0e} seeds", 1.0 / FAILS);
        let Some(followed) = &self.followed else {
            return if effect == Effect::Surroundings {
                self.why_window()
            } else {
                "what a cell of this memory does depends on all it did before, and no bound is known".to_owned()
            };
        };
        match effect {
            Effect::Surroundings => self.why_window(),
            Effect::Readout => "the longest wait if all events of a pair of frames come at once"
                .to_owned(),
            Effect::Strays => format!(
                "at most {:.0} stray events, {seed}{}",
                self.stray_events(),
                if self.present.dead_time {
                    ", and the events that they may silence"
                } else {
                    ""
                }
            ),
            Effect::Jitter => format!(
                "an event is moved by more than {:.1} us with a chance of at most {:.1e}; {seed}",
                self.within * 1e6,
                super::chance::beyond(
                    self.within * 1e6 / self.description.noise.jitter_us
                )
            ),
            Effect::Refractory => format!(
                "{} of {} crossings come less than {} us after an event",
                followed.crossings - followed.events,
                followed.crossings,
                self.description.refractory.us
            ),
            Effect::Upsampling if !self.upsampled => {
                "only where the drive is a straight line between two frames, and neither jitter nor stray events nor a mesh's noise are drawn for each frame, do frames in between say nothing new".to_owned()
            }
            Effect::Upsampling => "between two frames the drive is a straight line: frames in between say nothing new, but for rounding".to_owned(),
            Effect::LowPass => self.why_ladder(
                effect,
                &format!("a photoreceptor lags by at most {:.2e}", self.light.low_pass),
            ),
            Effect::Settling => self.why_ladder(
                effect,
                &format!("a sheet lags by at most {:.2e}", self.light.settling),
            ),
            Effect::SheetNoise => {
                self.why_ladder(effect, &format!("no node is off by more than its noise allows, {seed}"))
            }
            Effect::Mismatch => self.why_ladder(effect, "no threshold is off by more than 8.6 sigma"),
        }
    }

    fn why_window(&self) -> String {
        match self.window() {
            Some((rows, columns)) => format!(
                "nothing changes outside of columns {} to {} and rows {} to {}, grown by what kernels reach",
                columns.start,
                columns.end - 1,
                rows.start,
                rows.end - 1
            ),
            None if self.present.leak => "every cell leaks".to_owned(),
            None if self.present.sheets => "a resistor sheet reaches everywhere".to_owned(),
            None => "the light changes nearly everywhere".to_owned(),
        }
    }

    fn why_ladder(&self, effect: Effect, what: &str) -> String {
        let place = self.models.ladder.iter().position(|e| *e == effect);
        match place {
            None => {
                "v2e's sheets stop early: the smallest change may change how many steps they take"
                    .to_owned()
            }
            Some(place) if self.models.which.contains(&(Format::F64, place + 1)) => {
                format!("{what}: these events are so near a threshold that they may change")
            }
            Some(_) => format!("{what}: more than a quarter of a threshold"),
        }
    }

    fn why_format(&self, format: Format) -> String {
        if self.followed.is_none() {
            return "what a cell of this memory does depends on all it did before, and no bound is known".to_owned();
        }
        if self.present.v2e {
            return "v2e's sheets stop early: the smallest change may change how many steps they take".to_owned();
        }
        let off = Perturbation::of_format(format, &self.description, &self.light);
        if off.most <= 0.0 {
            return format!("{format} cannot hold what this light makes of the kernels");
        }
        format!(
            "distances are off by at most {:.1e} of a threshold by rounding the drive",
            off.size(&self.description)
        )
    }
}
