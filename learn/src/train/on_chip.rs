//! The same kernel on the chip: in few values, in exact arithmetic, on silicon.
//!
//! The decoder is the arm's own, as it was trained. Thresholds meet the target in the float model of the
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
    study::design::{Design, DesignError},
    unit::Micros,
};
use rayon::prelude::*;

use crate::{
    arm::Applied,
    record::{Form, Row},
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
        (clips, place): (&Clips, &Path),
    ) -> Result<Vec<Row>, TrainError> {
        let log = self.arm.cells().is_some_and(|cells| cells.log);
        let [unit] = &applied.kernels[..] else {
            return Ok(Vec::new());
        };
        if log || self.task.sensor.refractory_us > 0.0 {
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
        (clips, place): (&Clips, &Path),
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
        let batch = Batch::new(clips, 0..count);
        let size = batch.size();
        let light = batch.light(self.task.sensor.light_noise, self.draw(Reason::Test, 1));
        let seen: Vec<Vec<Frame>> = self.frames(&light, size);
        let description = design
            .description(MemoryRule::FilteredSnap)
            .map_err(wrong)?;
        let clips = Light::new(&light, self.times(), size);
        let rating = clips.and_then(|clips| rate_threshold(&description, clips, 0, self.target));
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
        let mut rows = Vec::new();
        for form in [Form::Quantised, Form::Exact, Form::Silicon] {
            let packets: Result<Vec<Packet>, DesignError> = { seen.par_iter().enumerate() }
                .map(|(n, frames)| {
                    let mut sensor: Box<dyn Sensor> = match form {
                        Form::Exact => Box::new(program.all_events(program.chip(
                            Arithmetic::Number(Format::F64),
                            size,
                            program.settings(),
                        )?)),
                        Form::Silicon => Box::new(program.all_events(program.chip(
                            Arithmetic::Silicon {
                                seed: self.seed.wrapping_add(n as u64),
                            },
                            size,
                            program.settings(),
                        )?)),
                        _ => design.reference(size, MemoryRule::FilteredSnap, Format::F64)?,
                    };
                    let mut packet = Packet::new(size, sensor.channels());
                    for frame in frames {
                        sensor.watch(frame, &mut packet)?;
                    }
                    Ok(packet)
                })
                .collect();
            let told = self.told(&packets.map_err(wrong)?, size);
            rows.extend(self.rows((&batch, 0), Some(&told), form));
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
