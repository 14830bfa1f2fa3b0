//! Runs of all sensors on the scene.

use super::{FeasibilityError, Question, Stream, Streams, stream::Window};
use crate::{
    array::{Arithmetic, Array},
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
    study::{
        design::{Compiled, Design},
        equivalent::{self, Ladder, Likeness},
        saturation,
    },
    unit::Micros,
};

/// The memory of all sensors: a chip has one shot a frame, and its memory snaps.
pub(super) const MEMORY: MemoryRule = MemoryRule::FilteredSnap;

impl Question<'_> {
    /// Shows the scene to a plain DVS and to the program's chips; what the float sensor said of
    /// it is known.
    pub(super) fn watch(
        &self,
        design: &Design<'_>,
        float: Packet,
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
        let mut dvs = plain.reference(size, MEMORY, Format::F64)?;
        let mut chips: Vec<Box<dyn Array + Send>> = Vec::new();
        if let Some(program) = program {
            let silicon = Arithmetic::Silicon { seed: self.seed };
            for arithmetic in [Arithmetic::Number(Format::F64), silicon] {
                chips.push(program.chip(arithmetic, size, program.settings())?);
            }
        }
        let mut sensors: Vec<&mut (dyn Sensor + Send)> = vec![&mut dvs];
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
        let mut runs = Runs {
            float,
            dvs: next().unwrap_or_else(|| Packet::new(size, 1)),
            exact: next(),
            silicon: next(),
            warnings: Vec::new(),
        };
        let judged = [
            ("the float sensor", Some(&runs.float)),
            ("the plain DVS", Some(&runs.dvs)),
            ("the program, no errors", runs.exact.as_ref()),
            ("the program on the chip", runs.silicon.as_ref()),
        ];
        for (subject, packet) in judged {
            if let Some(packet) = packet {
                guard.packet(subject, packet);
            }
        }
        if let Some((chip, program)) = chips.last().zip(program) {
            let silicon = Arithmetic::Silicon { seed: self.seed };
            let ends = silicon.ends(self.device, &program.settings());
            saturation::warn(&mut guard, "the program on the chip", &**chip, ends);
        }
        runs.warnings = guard.warnings();
        Ok((runs, frames))
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
    /// All packets in numbers, judged by the ladder and tuned to equal events; the scene is
    /// shown once more for that.
    pub fn streams(
        &self,
        question: &Question<'_>,
        design: &Design<'_>,
        ladder: &Ladder,
        scene: &mut dyn Scene,
        seen: &mut dyn FnMut(&Frame),
    ) -> Result<Streams, FeasibilityError> {
        let window = Window {
            within: question.within,
            frame: Micros::from_seconds(1.0 / scene.fps()),
            seed: question.seed,
        };
        let packets = [Some(&self.dvs), self.exact.as_ref(), self.silicon.as_ref()];
        let packets: Vec<&Packet> = packets.into_iter().flatten().collect();
        let mut judged: Vec<Likeness> = Vec::new();
        for packet in &packets {
            judged.push(ladder.judge(packet)?);
        }
        let mut pairs: Vec<_> = packets.iter().copied().zip(&mut judged).collect();
        equivalent::tune(ladder, design, MEMORY, scene, &mut pairs, seen)?;
        let mut judged = packets.into_iter().zip(judged);
        let mut next = || {
            let (packet, likeness) = judged.next()?;
            Some(Stream::new(packet, Some((&self.float, likeness)), &window))
        };
        Ok(Streams {
            float: Stream::new(&self.float, None, &window)?,
            dvs: match next() {
                Some(dvs) => dvs?,
                None => Stream::new(&self.dvs, None, &window)?,
            },
            exact: next().transpose()?,
            silicon: next().transpose()?,
        })
    }
}
