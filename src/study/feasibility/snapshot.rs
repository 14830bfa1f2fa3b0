//! A snapshot of the scene: its busiest frame, and the events in it.

use std::ops::ControlFlow;

use super::FeasibilityError;
use crate::{
    event::{Event, Packet},
    plane::Plane,
    rig,
    scene::{Image, Scene, SceneError},
    unit::Micros,
};

/// One moment of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    /// Time of the frame.
    pub at: Micros,
    /// Light, `[y, x]`.
    pub light: Plane<f64>,
    /// Events of the float sensor at this time.
    pub float: Vec<Event>,
    /// Events of the chip; none where there is no program.
    pub chip: Option<Vec<Event>>,
}

impl Snapshot {
    /// The frame at which the float sensor has most events; the first where it has none. The
    /// scene is read up to it.
    pub(super) fn new(
        float: &Packet,
        chip: Option<&Packet>,
        scene: &mut dyn Scene,
    ) -> Result<Self, FeasibilityError> {
        let mut at = float.span.0;
        let mut most = 0;
        for frame in float.events.chunk_by(|a, b| a.t == b.t) {
            if let Some(event) = frame.first()
                && frame.len() > most
            {
                (most, at) = (frame.len(), event.t);
            }
        }
        let mut light = Image::from(Plane::zeros((0, 0)));
        rig::play(scene, |frame| {
            light = frame.light;
            let reached = Micros::from_seconds(frame.seconds) >= at;
            Ok::<_, SceneError>(if reached {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            })
        })?;
        let then = |packet: &Packet| {
            let events = packet.events.iter().filter(|event| event.t == at);
            events.copied().collect()
        };
        Ok(Self {
            at,
            light: light.into_plane(),
            float: then(float),
            chip: chip.map(then),
        })
    }
}
