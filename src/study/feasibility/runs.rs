//! Runs of all sensors on the scene.

use super::{FeasibilityError, Question, Stream, Streams, stream::Window};
use crate::{
    array::Arithmetic,
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
    study::{
        design::Design,
        equivalent::{self, Ladder, Likeness},
        quantisation::Ran,
        saturation,
    },
    unit::Micros,
};

/// The memory of all sensors: a chip has one shot a frame, and its memory snaps.
pub(super) const MEMORY: MemoryRule = MemoryRule::FilteredSnap;

impl Question<'_> {
    /// Shows the scene to a plain DVS; what the float sensor and the program said of it is known.
    pub(super) fn watch(
        &self,
        design: &Design<'_>,
        float: Packet,
        program: Option<Ran>,
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
        let (mut frames, mut guard) = (0, Guard::new());
        let packets = rig::watch(scene, &mut [&mut *dvs], |frame| {
            frames += 1;
            guard.frame(frame);
            seen(frame);
        })?;
        let (program, said) = match program {
            Some(Ran {
                compiled,
                chips,
                packets,
            }) => (Some((compiled, chips)), packets.map(Some)),
            None => (None, [None, None]),
        };
        let [exact, silicon] = said;
        let dvs = packets.into_iter().next();
        let mut runs = Runs {
            float,
            dvs: dvs.unwrap_or_else(|| Packet::new(size, 1)),
            exact,
            silicon,
            lost: [0; 2],
            warnings: Vec::new(),
        };
        let judged = [
            ("the float sensor", Some(&runs.float)),
            // Nobody chose the plain DVS's threshold: what there is to warn of it concerns nobody.
            ("the program, no errors", runs.exact.as_ref()),
            ("the program on the chip", runs.silicon.as_ref()),
        ];
        for (subject, packet) in judged {
            if let Some(packet) = packet {
                guard.packet(subject, packet);
            }
        }
        if let Some((program, chips)) = program {
            runs.lost = [0, 1].map(|at: usize| chips[at].lost().total());
            let silicon = Arithmetic::Silicon { seed: self.seed };
            let ends = silicon.ends(self.device, &program.settings());
            saturation::warn(&mut guard, "the program on the chip", chips[1].chip(), ends);
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
    /// How many events of these two all slots of the program would lose.
    pub lost: [u64; 2],
    /// What is to be known of them.
    pub warnings: Vec<Warning>,
}

impl Runs {
    /// All packets in numbers, the plain DVS's judged by the ladder and tuned to equal events, for
    /// which the scene is shown once more; the program's are `judged`, in exact arithmetic and as
    /// silicon.
    pub fn streams(
        &self,
        question: &Question<'_>,
        (design, ladder): (&Design<'_>, &Ladder),
        judged: Option<&[Likeness; 2]>,
        scene: &mut dyn Scene,
        seen: &mut dyn FnMut(&Frame),
    ) -> Result<Streams, FeasibilityError> {
        let window = Window {
            within: question.within,
            frame: Micros::from_seconds(1.0 / scene.fps()),
            seed: question.seed,
        };
        let mut dvs = ladder.judge(&self.dvs)?;
        let mut pairs = [(&self.dvs, &mut dvs)];
        equivalent::tune(ladder, design, MEMORY, scene, &mut pairs, seen)?;
        let stream =
            |packet: &Packet, likeness| Stream::new(packet, Some((&self.float, likeness)), &window);
        let [exact, silicon] = judged.map_or([None; 2], |judged| judged.map(Some));
        let of_program = |packet: &Option<Packet>, likeness: Option<Likeness>, dropped| {
            let both = packet.as_ref().zip(likeness);
            both.map(|(packet, likeness)| {
                let own = stream(packet, likeness)?;
                Ok::<_, FeasibilityError>(Stream { dropped, ..own })
            })
            .transpose()
        };
        Ok(Streams {
            float: Stream::new(&self.float, None, &window)?,
            dvs: stream(&self.dvs, dvs)?,
            exact: of_program(&self.exact, exact, self.lost[0])?,
            silicon: of_program(&self.silicon, silicon, self.lost[1])?,
        })
    }
}
