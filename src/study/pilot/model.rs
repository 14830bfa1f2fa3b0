//! A model of a plan: the full one or a plainer one, run on the whole sensor.

use std::ops::ControlFlow;

use crate::{
    event::Packet,
    plane::Size,
    reference::{Effect, EventList, Limit, Sinks},
    rig,
    scene::{Scene, upsample},
    unit::Micros,
};

use super::{
    choice::Choice,
    part::Part,
    plan::{Crop, Plan, PlanError, Question},
};

/// A model of a plan, and how it is run.
#[derive(Clone, Debug)]
pub struct Model<'a> {
    /// Of what.
    pub question: &'a Question<'a>,
    /// What it leaves out.
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
            window: plan.crop().cloned(),
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
        let part = self.window.as_ref().map(|window| Part::new(whole, window));
        let packet = self.watched((whole, part.as_ref()), scene, seen)?;
        Ok(match self.question.readout {
            Some(readout) => readout.read(&packet).packet,
            None => packet,
        })
    }

    /// Of a part, or of the whole.
    fn watched(
        &self,
        (whole, part): (Size, Option<&Part>),
        scene: &mut dyn Scene,
        seen: &mut dyn FnMut(),
    ) -> Result<Packet, PlanError> {
        let Question {
            description, seed, ..
        } = *self.question;
        let (format, plain) = (self.choice.format, self.choice.plainer(description));
        let mut sensor = Part::sensor(part, whole, (format, plain, seed))?;
        let mut packet = Packet::new(whole, sensor.channels());
        let list = EventList::new(&mut packet, self.limit);
        let mut list = list.of_part(sensor.size(), part.map(Part::corner));
        let mut span = None;
        rig::play(scene, |frame| {
            let cut = part.map(|part| part.of(&frame));
            let sinks = Sinks {
                list: Some(&mut list),
                ..Sinks::default()
            };
            sensor.watch_into_sinks(cut.as_ref().unwrap_or(&frame), sinks)?;
            let t = Micros::from_seconds(frame.seconds);
            span = Some((span.map_or(t, |(first, _)| first), t));
            seen();
            Ok::<_, PlanError>(ControlFlow::Continue(()))
        })?;
        packet.span = span.unwrap_or(packet.span);
        Ok(packet)
    }
}
