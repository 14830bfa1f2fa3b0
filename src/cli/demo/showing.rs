//! One showing of the clip: every cell, on the array and in float, judged by its float sensor.

use super::cell::{Cell, OnChip};
use crate::{
    array::{Arithmetic, Array},
    cli::output::timed::Timed,
    compare::window,
    event::Packet,
    number::Format,
    plane::Size,
    reference::MemoryRule,
    rig::{self, guard::Guard},
    scene::{Frame, Scene},
    sensor::Sensor,
    study::{
        equivalent::{self, Ladder, Likeness, RUNGS},
        saturation,
    },
    unit::Micros,
};

/// The memory of all sensors: a chip has one shot a frame, and its memory snaps.
const MEMORY: MemoryRule = MemoryRule::FilteredSnap;

/// What was seen and said at one frame rate.
pub(super) struct Showing<'a> {
    /// Frames a second.
    pub fps: f64,
    pub frames: u64,
    /// Events within this match.
    pub window: Micros,
    pub rows: Vec<Row<'a>>,
}

/// What one sensor said.
pub(super) struct Row<'a> {
    pub cell: &'a Cell,
    pub chip: Option<Judged<'a>>,
    pub packet: Packet,
    /// Frames a second of computing.
    pub speed: f64,
}

/// A program in one arithmetic, against the cell's float sensor.
pub(super) struct Judged<'a> {
    pub program: &'a OnChip,
    pub domain: Arithmetic,
    pub likeness: Likeness,
}

type Chip = Timed<Box<dyn Array + Send>>;

/// All that watches for one cell.
struct Watching<'a> {
    cell: &'a Cell,
    float: Timed<Box<dyn Sensor + Send>>,
    ladder: Vec<Box<dyn Sensor + Send>>,
    chips: Vec<(&'a OnChip, Arithmetic, Chip)>,
}

impl<'a> Watching<'a> {
    fn new(cell: &'a Cell, size: Size, seed: u64) -> miette::Result<Self> {
        let design = cell.design(seed);
        let mut chips = Vec::new();
        for program in &cell.programs {
            let compiled = &program.compiled;
            for domain in &program.domains {
                let chip = compiled.chip(*domain, size, compiled.settings())?;
                chips.push((program, *domain, Timed::new(chip)));
            }
        }
        Ok(Self {
            cell,
            float: Timed::new(design.reference(size, MEMORY, Format::F64)?),
            ladder: equivalent::sensors(&design, size, MEMORY)?,
            chips,
        })
    }

    fn sensors(&mut self) -> Vec<&mut (dyn Sensor + Send)> {
        let mut all: Vec<&mut (dyn Sensor + Send)> = vec![&mut self.float];
        for sensor in &mut self.ladder {
            all.push(sensor);
        }
        for (_, _, chip) in &mut self.chips {
            all.push(chip);
        }
        all
    }
}

impl<'a> Showing<'a> {
    /// Shows the scene to all of them at once.
    pub fn new(
        cells: &'a [Cell],
        scene: &mut dyn Scene,
        seed: u64,
        guard: &mut Guard,
        mut seen: impl FnMut(&Frame),
    ) -> miette::Result<Self> {
        let (size, fps) = (scene.size(), scene.fps());
        let window = window::headline(fps);
        let mut all = cells
            .iter()
            .map(|cell| Watching::new(cell, size, seed))
            .collect::<miette::Result<Vec<_>>>()?;
        let mut sensors: Vec<_> = all.iter_mut().flat_map(Watching::sensors).collect();
        let mut frames = 0;
        let packets = rig::watch(scene, &mut sensors, |frame| {
            frames += 1;
            guard.frame(frame);
            seen(frame);
        })?;
        let mut packets = packets.into_iter();
        let mut next = || packets.next().unwrap_or_else(|| Packet::new(size, 1));
        let mut rows = Vec::new();
        for Watching {
            cell, float, chips, ..
        } in all
        {
            let truth = next();
            let rungs: Vec<_> = RUNGS.iter().map(|_| next()).collect();
            let ladder = Ladder::new(truth, &rungs, window, fps, seed)?;
            rows.push(Row {
                cell,
                chip: None,
                packet: ladder.reference().clone(),
                speed: float.speed(),
            });
            guard.packet(&format!("{}, float", cell.name), ladder.reference());
            for (program, domain, chip) in chips {
                let packet = next();
                let subject = format!("{} in {} {domain}", cell.name, program.to);
                guard.packet(&subject, &packet);
                let compiled = &program.compiled;
                let ends = domain.ends(&compiled.device, &compiled.settings());
                saturation::warn(guard, &subject, &*chip.sensor, ends);
                rows.push(Row {
                    cell,
                    chip: Some(Judged {
                        program,
                        domain,
                        likeness: ladder.judge(&packet)?,
                    }),
                    packet,
                    speed: chip.speed(),
                });
            }
        }
        Ok(Self {
            fps,
            frames,
            window,
            rows,
        })
    }

    /// The float sensor of the kernel that the chip can carry.
    pub fn reference(&self) -> Option<&Row<'a>> {
        let chosen = self.chosen().next()?.cell;
        let own = |row: &&Row<'_>| row.chip.is_none() && row.cell.name == chosen.name;
        self.rows.iter().find(own)
    }

    /// The kernel that the chip can carry, in each arithmetic.
    pub fn chosen(&self) -> impl Iterator<Item = &Row<'a>> {
        self.rows.iter().filter(|row| {
            let program = row.chip.as_ref().map(|chip| chip.program);
            program.is_some_and(OnChip::is_chosen)
        })
    }
}

impl Row<'_> {
    /// The arithmetic; none for a float sensor.
    pub fn domain(&self) -> Option<Arithmetic> {
        self.chip.as_ref().map(|chip| chip.domain)
    }

    /// What it runs in: `float`, or the arithmetic's name.
    pub fn runs_in(&self) -> String {
        self.domain().map_or("float".to_owned(), |d| d.to_string())
    }

    /// Events of a pixel in a second.
    pub fn per_pixel_second(&self) -> f64 {
        let (from, to) = self.packet.span;
        let seconds = to.seconds() - from.seconds();
        self.packet.events.len() as f64 / (self.packet.size.pixels() as f64 * seconds)
    }
}
