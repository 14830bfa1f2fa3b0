//! A model of a plan: the full one or a plainer one, run on the whole sensor.

use std::ops::ControlFlow;

use crate::{
    event::Packet,
    mosaic::Mosaic,
    plane::{At, Size},
    reference::{Limit, Reference},
    rig,
    scene::{Frame, Scene, upsample},
};

use super::{
    effect::{Choice, Effect},
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
        let window = self.window.clone().filter(|_| !keeps(Effect::Surroundings));
        let mosaic = window.map(|(rows, columns)| {
            let at = At {
                y: rows.start,
                x: columns.start,
            };
            let tile = Size::new(rows.len(), columns.len());
            Mosaic::new(whole, tile, 0, vec![at], 1)
        });
        let mut packet = self.watched(mosaic.as_ref(), scene, seen)?;
        if let Some(at) = mosaic.as_ref().and_then(|mosaic| mosaic.tiles().first()) {
            for event in &mut packet.events {
                event.x += at.x as u16;
                event.y += at.y as u16;
            }
            packet.size = whole;
        }
        Ok(match self.question.readout {
            Some(readout) => readout.read(&packet).packet,
            None => packet,
        })
    }

    /// Of a mosaic of one tile, or of the whole.
    fn watched(
        &self,
        mosaic: Option<&Mosaic>,
        scene: &mut dyn Scene,
        seen: &mut dyn FnMut(),
    ) -> Result<Packet, PlanError> {
        let Question {
            description, seed, ..
        } = *self.question;
        let (format, plain) = (self.choice.format, self.choice.plainer(description));
        let mut sensor = match mosaic {
            Some(mosaic) => Reference::on_tiles_in_format(format, plain, mosaic, seed)?,
            None => Reference::in_format(format, plain, scene.size(), seed)?,
        };
        sensor.set_limit(self.limit);
        let mut packet = Packet::new(sensor.size(), sensor.channels());
        rig::play(scene, |frame| {
            let frame = match mosaic {
                Some(mosaic) => cut(&frame, mosaic),
                None => frame,
            };
            sensor.watch(&frame, &mut packet)?;
            seen();
            Ok::<_, PlanError>(ControlFlow::Continue(()))
        })?;
        Ok(packet)
    }
}

/// The part of a frame that a mosaic of one tile shows.
fn cut(frame: &Frame, mosaic: &Mosaic) -> Frame {
    let at = mosaic.tiles().first().copied().unwrap_or(At { y: 0, x: 0 });
    let Size { height, width } = mosaic.size();
    let rows = ndarray::s![at.y..at.y + height, at.x..at.x + width];
    let light = frame.light.slice(rows).to_owned().into();
    Frame { light, ..*frame }
}
