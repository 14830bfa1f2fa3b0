//! The same kernel on the chip: in few values, in exact arithmetic, on silicon.
//!
//! The decoder is the arm's own, as it was trained; and, where the task says so, the same trained on
//! with what the form makes of training clips. Thresholds meet the target in the float model of the
//! chip's sensor (memory `filtered-snap`), and are rounded to whole steps of the chip.

use std::path::Path;

use amacrine::{
    array::Arithmetic,
    compile::Effort,
    event::{Packet, Polarity},
    gradient::{Clips as Light, Rated, rate_threshold},
    isa::Device,
    kernel::{
        Kernel,
        quantise::{Quantiser, Sum},
    },
    number::Format,
    plane::{Plane, Size},
    reference::MemoryRule,
    save,
    scene::Frame,
    sensor::Sensor,
    study::design::{Compiled, Design, DesignError},
    unit::Micros,
};
use rayon::prelude::*;

use crate::{
    arm::{Applied, Start},
    record::{Decoder, Form, Row},
    scene::Clips,
};

use super::{
    batch::Batch,
    error::TrainError,
    evaluate::Told,
    trainee::{Reason, Trainee},
};

/// States that the search for a program looks at.
const EFFORT: Effort = Effort { states: 40_000 };

/// Held-out clips that are shown to the chip.
const CLIPS: u64 = 32;

/// Held-out clips, and those of training.
#[derive(Clone, Copy)]
pub(super) struct Sources<'a> {
    pub held_out: &'a Clips,
    pub training: &'a Clips,
}

/// A kernel as it is built.
struct Built<'a> {
    design: Design<'a>,
    program: Compiled,
    seed: u64,
}

impl Built<'_> {
    /// What a form of it makes of some clips, each seen by a chip of its own.
    fn packets(
        &self,
        form: Form,
        clips: &[Vec<Frame>],
        (first, size): (u64, Size),
    ) -> Result<Vec<Packet>, DesignError> {
        let Self {
            design, program, ..
        } = self;
        let chip = |arithmetic| {
            let chip = program.chip(arithmetic, size, program.settings())?;
            Ok::<Box<dyn Sensor>, DesignError>(Box::new(program.all_events(chip)))
        };
        let one = |(n, frames): (usize, &Vec<Frame>)| {
            let mut sensor: Box<dyn Sensor> = match form {
                Form::Exact => chip(Arithmetic::Number(Format::F64))?,
                Form::Silicon => chip(Arithmetic::Silicon {
                    seed: self.seed.wrapping_add(first + n as u64),
                })?,
                _ => design.reference(size, MemoryRule::FilteredSnap, Format::F64)?,
            };
            let mut packet = Packet::new(size, sensor.channels());
            for frame in frames {
                sensor.watch(frame, &mut packet)?;
            }
            Ok(packet)
        };
        clips.par_iter().enumerate().map(one).collect()
    }
}

impl Trainee<'_> {
    /// Rows of the compiled kernel, and its program in a folder; none where a chip has no such sensor:
    /// several kinds, patterns, a logarithm, a refractory period.
    ///
    /// # Errors
    /// When a sensor fails, or a file cannot be written; not where the chip refuses a kernel.
    pub(super) fn on_chip(
        &self,
        applied: &Applied,
        rated: &Rated,
        (clips, place): (Sources<'_>, &Path),
    ) -> Result<Vec<Row>, TrainError> {
        let cells = self.arm.cells();
        // Resistors are not a program.
        let other = cells.is_some_and(|cells| cells.log || matches!(cells.start, Start::Mesh(_)));
        let [unit] = &applied.kernels[..] else {
            return Ok(Vec::new());
        };
        if other || self.task.sensor.refractory_us > 0.0 {
            return Ok(Vec::new());
        }
        match self.compiled(applied, unit, rated, (clips, place)) {
            Ok(rows) => Ok(rows),
            Err(TrainError::Design { cause, .. }) if cause.is_refusal() => Ok(Vec::new()),
            Err(other) => Err(other),
        }
    }

    fn compiled(
        &self,
        applied: &Applied,
        unit: &Kernel,
        rated: &Rated,
        (clips, place): (Sources<'_>, &Path),
    ) -> Result<Vec<Row>, TrainError> {
        let wrong = |cause: DesignError| TrainError::Design {
            arm: self.arm.name.clone(),
            cause,
        };
        let device = Device::scamp5();
        let own = rated.description.channels[0].thresholds[0].on * 255.0;
        let levels: Plane<f64> = if let Some([levels]) = applied.levels.as_deref() {
            levels.clone()
        } else {
            let quantised = Quantiser::TERNARY.quantise(unit, Sum::Free, self.seed);
            let quantised = quantised.map_err(|cause| wrong(cause.into()))?;
            quantised.levels.weights().clone()
        };
        let most = levels
            .iter()
            .fold(1.0, |most: f64, level| most.max(level.abs()));
        let mut power = 1.0;
        while power < most {
            power *= 2.0;
        }
        let levels = levels / power;
        let norm = levels.iter().map(|w| w * w).sum::<f64>().sqrt();
        let kernel = Kernel::new(levels).map_err(|cause| TrainError::Levels {
            arm: self.arm.name.clone(),
            step: self.state.step,
            cause: cause.into(),
        })?;
        let mut design = Design {
            kernel: &kernel,
            threshold: own * norm,
            device: &device,
            effort: EFFORT,
            seed: self.seed,
        };
        let count = CLIPS.min(self.task.test.0);
        let batch = Batch::new(clips.held_out, 0..count);
        let size = batch.size();
        let light = batch.light(self.task.sensor.light_noise, self.draw(Reason::Test, 1));
        let seen: Vec<Vec<Frame>> = self.frames(&light, size);
        let description = design
            .description(MemoryRule::FilteredSnap)
            .map_err(wrong)?;
        let lit = Light::new(&light, self.times(), size);
        let rating = lit.and_then(|lit| rate_threshold(&description, lit, 0, self.target));
        design.threshold = rating
            .map_err(|cause| TrainError::Gradient {
                arm: self.arm.name.clone(),
                step: self.state.step,
                cause,
            })?
            .description
            .channels[0]
            .thresholds[0]
            .on;
        // Once to know the chip's step, once with a whole number of them.
        let first = design.compile("learned").map_err(wrong)?;
        let scale = first.program.scale;
        design.threshold = (design.threshold * scale).round().max(1.0) / scale;
        let program = design.compile("learned").map_err(wrong)?;
        let text = &program.program.text;
        save::save(&place.join("program.scamp"), |out| {
            out.write_all(text.as_bytes())
        })?;
        let built = Built {
            design,
            program,
            seed: self.seed,
        };
        let mut rows = Vec::new();
        let shown = self.task.retrain.map(|(steps, count)| {
            let batch = Batch::new(clips.training, 0..count);
            let light = batch.light(self.task.sensor.light_noise, self.draw(Reason::Test, 2));
            let frames = self.frames(&light, batch.size());
            (steps, batch, frames)
        });
        // Exact programs mostly make the float model's events: what is learned from them is the same.
        let mut learned: Option<(Told, Self)> = None;
        for form in [Form::Quantised, Form::Exact, Form::Silicon] {
            let packets = built.packets(form, &seen, (0, size)).map_err(wrong)?;
            let told = self.told(&packets, size);
            rows.extend(self.rows((&batch, 0), Some(&told), (form, Decoder::Own)));
            let Some((steps, shown, frames)) = &shown else {
                continue;
            };
            // Other chips than those it is judged on.
            let packets = built.packets(form, frames, (CLIPS, shown.size()));
            let emitted = self.told(&packets.map_err(wrong)?, shown.size());
            let known = learned.take().filter(|(told, _)| *told == emitted);
            let (emitted, other) = if let Some(known) = known {
                known
            } else {
                let other = self.retrained(*steps, shown, &emitted)?;
                (emitted, other)
            };
            rows.extend(other.rows((&batch, 0), Some(&told), (form, Decoder::Retrained)));
            learned = Some((emitted, other));
        }
        Ok(rows)
    }

    fn frames(&self, light: &[f32], size: Size) -> Vec<Vec<Frame>> {
        let shape = (size.height, size.width);
        let times = self.times();
        let clip = |light: &[f32]| {
            let frames = light.chunks(size.pixels()).zip(times).enumerate();
            frames
                .map(|(n, (light, seconds))| Frame {
                    index: n as u64,
                    seconds: *seconds,
                    light: Plane::from_shape_fn(shape, |(y, x)| {
                        f64::from(light[y * size.width + x])
                    })
                    .into(),
                })
                .collect()
        };
        light
            .chunks(times.len() * size.pixels())
            .map(clip)
            .collect()
    }

    /// Events of a packet as voxels: bins are centred on the frames, and these events happen there.
    fn told(&self, packets: &[Packet], size: Size) -> Told {
        let frames: Vec<Micros> = self
            .times()
            .iter()
            .map(|t| Micros::from_seconds(*t))
            .collect();
        let voxels = |packet: &Packet| {
            let mut voxels = vec![0.0; frames.len() * size.pixels()];
            for event in &packet.events {
                let at = frames
                    .iter()
                    .position(|t| *t >= event.t)
                    .unwrap_or(frames.len() - 1);
                let sign = if event.polarity == Polarity::On {
                    1.0
                } else {
                    -1.0
                };
                let pixel = usize::from(event.y) * size.width + usize::from(event.x);
                voxels[at * size.pixels() + pixel] += sign;
            }
            voxels
        };
        Told {
            voxels: packets.iter().map(voxels).collect(),
            events: packets
                .iter()
                .map(|packet| packet.events.len() as u64)
                .collect(),
        }
    }
}
