//! A model of a plan: the full one or a plainer one, run on the whole sensor.

use std::ops::ControlFlow;

use crate::{
    event::Packet,
    plane::Size,
    reference::{Limit, Reference},
    rig,
    scene::{Scene, upsample},
};

use super::{
    effect::{Choice, Effect},
    part::Part,
    plan::{Crop, Plan, PlanError, Question},
};

/// A model of a plan, and how it is run.
#[derive(Clone, Debug)]
pub struct Model<'a> {
    /// Of what.
    pub question: &'a Question<'a>,
    /// Which.
    pub choice: Choice,
    /// What is left of the array.
    pub window: Option<Crop>,
    /// How many events it may list.
    pub limit: Limit,
}

impl<'a> Model<'a> {
    /// The full model.
    #[must_use]
    pub const fn full(question: &'a Question<'a>, limit: Limit) -> Self {
        Self {
            question,
            choice: Choice::full(),
            window: None,
            limit,
        }
    }

    /// The planned one.
    #[must_use]
    pub fn planned(question: &'a Question<'a>, plan: &Plan, limit: Limit) -> Self {
        Self {
            question,
            choice: plan.choice.clone(),
            window: plan.window.clone(),
            limit,
        }
    }

    /// Shows it a scene; `seen` is called after each frame.
    ///
    /// # Errors
    /// When the scene or the sensor cannot go on.
    pub fn run(&self, scene: impl Scene, mut seen: impl FnMut()) -> Result<Packet, PlanError> {
        let keeps = |effect: Effect| !self.choice.leaves_out(effect);
        let contrast = self
            .question
            .upsample
            .filter(|_| keeps(Effect::InsertedFrames));
        let whole = scene.size();
        let mut scene = upsample::by_contrast(scene, contrast)?;
        self.shown(whole, &mut *scene, &mut seen)
    }

    /// The same of a scene with its inserted frames, compiled once.
    fn shown(
        &self,
        whole: Size,
        scene: &mut dyn Scene,
        seen: &mut dyn FnMut(),
    ) -> Result<Packet, PlanError> {
        let keeps = |effect: Effect| !self.choice.leaves_out(effect);
        let window = self
            .window
            .as_ref()
            .filter(|_| !keeps(Effect::Surroundings));
        let part = window.map(|window| Part::new(whole, window));
        let mut packet = self.watched(part.as_ref(), scene, seen)?;
        if let Some(part) = &part {
            part.place(&mut packet.events);
            packet.size = whole;
        }
        Ok(match self.question.readout {
            Some(readout) => readout.read(&packet).packet,
            None => packet,
        })
    }

    /// Of a part, or of the whole.
    fn watched(
        &self,
        part: Option<&Part>,
        scene: &mut dyn Scene,
        seen: &mut dyn FnMut(),
    ) -> Result<Packet, PlanError> {
        let Question {
            description, seed, ..
        } = *self.question;
        let (format, plain) = (self.choice.format, self.choice.plainer(description));
        let mut sensor = match part {
            Some(part) => part.sensor(format, plain, seed)?,
            None => Reference::in_format(format, plain, scene.size(), seed)?,
        };
        sensor.set_limit(self.limit);
        let mut packet = Packet::new(sensor.size(), sensor.channels());
        rig::play(scene, |frame| {
            let frame = match part {
                Some(part) => part.of(&frame),
                None => frame,
            };
            sensor.watch(&frame, &mut packet)?;
            seen();
            Ok::<_, PlanError>(ControlFlow::Continue(()))
        })?;
        Ok(packet)
    }
}
