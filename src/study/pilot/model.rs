//! A model of a plan: the full one or a plainer one, run on the whole sensor.

use std::ops::ControlFlow;

use crate::{
    event::Packet,
    mosaic::Mosaic,
    number::{Number, Visitor},
    plane::{At, Size},
    reference::{Limit, Reference},
    rig,
    scene::{Frame, Scene, upsample},
    sensor::Sensor,
};

use super::{
    effect::{Choice, Effect},
    plan::{Plan, PlanError, Question, Window},
};

/// A model of a plan, and how it is run.
#[derive(Clone, Debug)]
pub struct Model<'a> {
    /// Of what.
    pub question: &'a Question<'a>,
    /// Which.
    pub choice: Choice,
    /// What is left of the array.
    pub window: Option<Window>,
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
    pub fn run(&self, scene: impl Scene, seen: impl FnMut()) -> Result<Packet, PlanError> {
        let keeps = |effect: Effect| !self.choice.leaves_out(effect);
        let contrast = self
            .question
            .upsample
            .filter(|_| keeps(Effect::InsertedFrames));
        let whole = scene.size();
        let mut scene = upsample::by_contrast(scene, contrast)?;
        let window = self.window.clone().filter(|_| !keeps(Effect::Surroundings));
        let mosaic = window.map(|(rows, columns)| {
            let at = At {
                y: rows.start,
                x: columns.start,
            };
            let tile = Size::new(rows.len(), columns.len());
            Mosaic::new(whole, tile, 0, vec![at], 1)
        });
        let mut packet = self.choice.format.visit(Watch {
            model: self,
            mosaic: mosaic.as_ref(),
            scene: &mut *scene,
            seen,
        })?;
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
}

/// A model that watches, in whatever format.
struct Watch<'a, F> {
    model: &'a Model<'a>,
    mosaic: Option<&'a Mosaic>,
    scene: &'a mut (dyn Scene + 'a),
    seen: F,
}

impl<F: FnMut()> Visitor for Watch<'_, F> {
    type Output = Result<Packet, PlanError>;

    fn visit<N: Number>(mut self, number: N) -> Self::Output {
        let Question {
            description, seed, ..
        } = *self.model.question;
        let plain = self.model.choice.plainer(description);
        let sensor = match self.mosaic {
            Some(mosaic) => Reference::on_tiles(number, plain, mosaic, seed)?,
            None => Reference::with_number(number, plain, self.scene.size(), seed)?,
        };
        let mut sensor = sensor.with_limit(self.model.limit);
        let mut packet = Packet::new(sensor.size(), sensor.channels());
        rig::play(self.scene, |frame| {
            let frame = match self.mosaic {
                Some(mosaic) => cut(&frame, mosaic),
                None => frame,
            };
            sensor.watch(&frame, &mut packet)?;
            (self.seen)();
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
