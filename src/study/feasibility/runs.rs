//! Runs of all sensors on the scene.

use super::{FeasibilityError, Question, Stream, Streams, stream::Window};
use crate::{
    array::{Arithmetic, Array, AtBorder},
    event::Packet,
    kernel::Kernel,
    number::Format,
    plane::Plane,
    reference::MemoryRule,
    rig::{
        self,
        guard::{Guard, Warning},
    },
    scene::{Frame, Scene},
    sensor::Sensor,
    study::design::{Compiled, Design},
    unit::Micros,
};

impl Question<'_> {
    /// Shows the scene to the float sensor, to a plain DVS, and to the program's chips.
    pub(super) fn watch(
        &self,
        design: &Design<'_>,
        program: Option<&Compiled>,
        scene: &mut dyn Scene,
        seen: &mut dyn FnMut(&Frame),
    ) -> Result<(Runs, u64), FeasibilityError> {
        let size = scene.size();
        let alone = one_pixel();
        let plain = Design {
            kernel: &alone,
            ..*design
        };
        let float =
            |design: &Design<'_>| design.reference(size, MemoryRule::FilteredSnap, Format::F64);
        let (mut float, mut dvs) = (float(design)?, float(&plain)?);
        let mut chips: Vec<Box<dyn Array + Send>> = Vec::new();
        if let Some(program) = program {
            let silicon = Arithmetic::Silicon { seed: self.seed };
            for arithmetic in [Arithmetic::Number(Format::F64), silicon] {
                chips.push(program.chip(arithmetic, size, program.settings())?);
            }
        }
        let mut sensors: Vec<&mut (dyn Sensor + Send)> = vec![&mut float, &mut dvs];
        sensors.extend(
            chips
                .iter_mut()
                .map(|chip| chip as &mut (dyn Sensor + Send)),
        );
        let (mut frames, mut guard) = (0, Guard::new());
        let packets = rig::watch(scene, &mut sensors, |frame| {
            frames += 1;
            guard.frame(frame);
            seen(frame);
        })?;
        let mut packets = packets.into_iter();
        let mut next = || packets.next();
        let empty = || Packet::new(size, 1);
        let mut said = Runs {
            float: next().unwrap_or_else(empty),
            dvs: next().unwrap_or_else(empty),
            exact: next(),
            silicon: next(),
            warnings: Vec::new(),
        };
        let judged = [
            ("the float sensor", Some(&said.float)),
            ("the plain DVS", Some(&said.dvs)),
            ("the program, no errors", said.exact.as_ref()),
            ("the program on the chip", said.silicon.as_ref()),
        ];
        for (subject, packet) in judged {
            if let Some(packet) = packet {
                guard.packet(subject, packet);
            }
        }
        if let Some((chip, program)) = chips.last().zip(program) {
            let silicon = Arithmetic::Silicon { seed: self.seed };
            let ends = silicon.ends(self.device, &program.settings());
            for at in ends.map_or(Vec::new(), |ends| AtBorder::registers(&**chip, ends)) {
                let place = format!("{} after the last frame", at.register);
                let counted = (at.pixels, at.of);
                let subject = "the program on the chip";
                guard.warn(Warning::saturation(subject, &place, counted, at.ends));
            }
        }
        said.warnings = guard.warnings();
        Ok((said, frames))
    }
}

/// The kernel of a plain DVS.
fn one_pixel() -> Kernel {
    Kernel::new(Plane::ones((1, 1))).expect("one finite weight is a kernel")
}

/// The packets of all sensors on the scene.
pub(super) struct Runs {
    pub float: Packet,
    pub dvs: Packet,
    pub exact: Option<Packet>,
    pub silicon: Option<Packet>,
    /// What is to be known of them.
    pub warnings: Vec<Warning>,
}

impl Runs {
    pub fn streams(&self, question: &Question<'_>, fps: f64) -> Result<Streams, FeasibilityError> {
        let window = Window {
            within: question.within,
            frame: Micros::from_seconds(1.0 / fps),
            seed: question.seed,
        };
        let judged = |packet: &Packet| Stream::new(packet, Some(&self.float), &window);
        Ok(Streams {
            float: Stream::new(&self.float, None, &window)?,
            dvs: judged(&self.dvs)?,
            exact: self.exact.as_ref().map(judged).transpose()?,
            silicon: self.silicon.as_ref().map(judged).transpose()?,
        })
    }
}
