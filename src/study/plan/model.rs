//! Model: the full one or a plainer one, run; and what lies between two.

use std::ops::{ControlFlow, Range};

use ndarray::s;

use crate::{
    compare::{CompareError, Pair, matching},
    event::{Packet, readout::Readout},
    number::{Format, Number, Visitor},
    plane::Size,
    reference::{Description, Limit, Reference},
    rig,
    scene::{Frame, Scene, SceneError, upsample},
    sensor::Sensor,
    unit::Micros,
};

use super::{Choice, Effect, Open, Plan, PlanError, Question, cost};

/// Rows and columns.
pub type Window = (Range<usize>, Range<usize>);

/// A sensor and the way it is run.
#[derive(Clone, Debug)]
pub struct Model {
    description: Description,
    format: Format,
    seed: u64,
    contrast: Option<f64>,
    window: Option<Window>,
    readout: Option<Readout>,
    limit: Limit,
}

/// What two models' events differ by.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Change {
    /// Events of the full model.
    pub events: u64,
    /// Those without a partner in the plainer one.
    pub missing: u64,
    /// Events of the plainer one without a partner.
    pub extra: u64,
    /// Both, for each event of the full model; 0 where neither has any.
    pub share: f64,
}

impl Model {
    /// The full model.
    #[must_use]
    pub fn full(question: &Question<'_>, limit: Limit) -> Self {
        Self {
            description: question.description.clone(),
            format: Format::F64,
            seed: question.seed,
            contrast: question.upsample,
            window: None,
            readout: question.readout,
            limit,
        }
    }

    /// The planned one.
    #[must_use]
    pub fn planned(question: &Question<'_>, plan: &Plan, limit: Limit) -> Self {
        Self::chosen(question, &plan.choice, plan.window.clone(), limit)
    }

    /// Any choice; `window` is what is left of the array where its surroundings are left out.
    #[must_use]
    pub fn chosen(
        question: &Question<'_>,
        choice: &Choice,
        window: Option<Window>,
        limit: Limit,
    ) -> Self {
        let keeps = |effect: Effect| !choice.leaves_out(effect);
        Self {
            description: cost::plainer(question.description, choice),
            format: choice.format,
            contrast: question.upsample.filter(|_| keeps(Effect::Upsampling)),
            window: window.filter(|_| !keeps(Effect::Surroundings)),
            readout: question.readout.filter(|_| keeps(Effect::Readout)),
            seed: question.seed,
            limit,
        }
    }

    /// Shows it a scene; `seen` is called after each frame.
    ///
    /// # Errors
    /// When the scene or the sensor cannot go on.
    pub fn run(self, open: &mut Open<'_>, seen: impl FnMut()) -> Result<Packet, PlanError> {
        let mut scene = open()?;
        scene = upsample::by_contrast(scene, self.contrast)?;
        let whole = scene.size();
        let readout = self.readout;
        let window = self.window.clone();
        if let Some(window) = window.clone() {
            scene = Box::new(Cut { scene, window });
        }
        let format = self.format;
        let mut packet = format.visit(Watch {
            model: self,
            scene,
            seen,
        })?;
        if let Some((rows, columns)) = window {
            for event in &mut packet.events {
                event.x += columns.start as u16;
                event.y += rows.start as u16;
            }
            packet.size = whole;
        }
        Ok(match readout {
            Some(readout) => readout.read(&packet).packet,
            None => packet,
        })
    }
}

/// A model that watches, in whatever format.
struct Watch<F> {
    model: Model,
    scene: Box<dyn Scene>,
    seen: F,
}

impl<F: FnMut()> Visitor for Watch<F> {
    type Output = Result<Packet, PlanError>;

    fn visit<N: Number>(mut self, number: N) -> Self::Output {
        let size = self.scene.size();
        let Model {
            description, seed, ..
        } = self.model;
        let sensor = Reference::with_number(number, description, size, seed)?;
        let mut sensor = sensor.with_limit(self.model.limit);
        let mut packet = Packet::new(size, sensor.channels());
        rig::play(&mut self.scene, |frame| {
            sensor.watch(&frame, &mut packet)?;
            (self.seen)();
            Ok::<_, PlanError>(ControlFlow::Continue(()))
        })?;
        Ok(packet)
    }
}

/// Part of a scene.
struct Cut {
    scene: Box<dyn Scene>,
    window: Window,
}

impl Scene for Cut {
    fn size(&self) -> Size {
        let (rows, columns) = &self.window;
        Size::new(rows.len(), columns.len())
    }

    fn fps(&self) -> f64 {
        self.scene.fps()
    }

    fn fps_is_assumed(&self) -> bool {
        self.scene.fps_is_assumed()
    }

    fn frames(&self) -> Option<u64> {
        self.scene.frames()
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        let (rows, columns) = self.window.clone();
        let frame = self.scene.next_frame()?;
        Ok(frame.map(|frame| Frame {
            light: frame.light.slice(s![rows, columns]).to_owned(),
            ..frame
        }))
    }
}

impl Change {
    /// What `plain` changes of `full`: events without a partner of their cell and sign within
    /// the window, found as [`matching`] finds them.
    ///
    /// # Errors
    /// When the packets are not of one size.
    pub fn between(full: &Packet, plain: &Packet, within: Micros) -> Result<Self, CompareError> {
        let matched = matching::matched(&Pair::new(full, plain)?, within);
        let events = full.events.len() as u64;
        let (missing, extra) = (events - matched, plain.events.len() as u64 - matched);
        let alone = (missing + extra) as f64;
        Ok(Self {
            events,
            missing,
            extra,
            share: if alone > 0.0 {
                alone / events as f64
            } else {
                0.0
            },
        })
    }
}
