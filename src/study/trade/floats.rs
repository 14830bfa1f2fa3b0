//! The models of a sensor file: without each of its effects, and in other numbers.

use crate::{
    number::Format,
    reference::Effect,
    study::pilot::{Choice, Floats, Look, rule},
};

impl Floats<'_> {
    /// What is left out one at a time, and the number formats; `inserts` says whether frames are
    /// inserted, which is then an effect, too.
    #[must_use]
    pub fn models(&self, formats: &[Format], inserts: bool) -> Vec<Choice> {
        let effects = Effect::ALL.iter().copied();
        let effects = effects.filter(|effect| effect.is_in(self.description, inserts));
        let plainer = effects.map(|it| Choice::full().and_without(it));
        let others = formats.iter().map(|format| Choice {
            format: *format,
            without: Vec::new(),
        });
        plainer.chain(others).collect()
    }

    /// Whether a model is another's alternative: of several numbers there is one.
    #[must_use]
    pub fn alternative(&self, model: &Choice) -> bool {
        model.format != Format::F64
    }

    /// Why a model changes nothing, where rules say so.
    #[must_use]
    pub fn free(&self, model: &Choice, look: &Look) -> Option<&'static str> {
        // What rules say holds in double precision.
        let is_free = |effect: &Effect| match effect {
            Effect::DeadTime => rule::has_no_close_crossings(self.description, look),
            Effect::InsertedFrames => {
                rule::needs_no_inserted_frames(&model.plainer(self.description)).is_some()
            }
            _ => false,
        };
        let left_out = !model.without.is_empty() && model.without.iter().all(is_free);
        (model.format == Format::F64 && left_out)
            .then_some("the light and the sensor's rules say so")
    }
}
