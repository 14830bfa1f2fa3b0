//! The same kernel on the chip: in few values, in exact arithmetic, on silicon.
//!
//! The decoder is the arm's own, as it was trained; and, where the task says so, the same trained on
//! with what the form makes of training clips. A form's threshold is the whole number of LSB that comes
//! nearest to the target, as it would be set on a chip: in the float model of the chip's sensor (memory
//! `filtered-snap`), which the exact program shares, and on silicon.

use std::{path::Path, sync::Arc};

use amacrine::{
    array::Arithmetic,
    compile::Effort,
    event::{Packet, Polarity},
    gradient::{Clips as Light, GradientError, Rated, rate_threshold},
    isa::Device,
    kernel::{
        Kernel,
        quantise::{Erasure, Quantiser, Sum},
    },
    number::Format,
    plane::{Plane, Size},
    reference::{Description, MemoryRule},
    save,
    scene::Frame,
    sensor::Sensor,
    study::design::{Compiled, Design, DesignError},
    unit::Micros,
};
use rayon::prelude::*;

use crate::{
    arm::Applied,
    levels::{Chip, LevelsError, OnChip, Projected},
    record::{Decoder, Form},
    scene::Clips,
};

use super::{
    batch::Batch,
    error::TrainError,
    evaluate::Told,
    export,
    fit::no_program,
    judged::Judged,
    trainee::{Reason, Trainee},
};

/// Held-out clips that are shown to the chip.
const CLIPS: u64 = 32;

/// The largest threshold that a converter sets, LSB.
const HIGHEST: u32 = 127;

/// Held-out clips, and those of training.
#[derive(Clone, Copy)]
pub(super) struct Sources<'a> {
    pub held_out: &'a Clips,
    pub training: &'a Clips,
}

/// A kernel as it is built.
struct Built<'a> {
    chip: &'a Chip,
    made: Arc<OnChip>,
    /// What its program is called.
    title: String,
    seed: u64,
}

impl Built<'_> {
    /// A threshold of so many LSB, in units of kernel times light.
    fn threshold(&self, lsb: u32) -> f64 {
        f64::from(lsb) / self.made.scale
    }

    /// The text of the program with a threshold of so many LSB.
    fn text(&self, lsb: u32) -> String {
        let both = [self.threshold(lsb); 2];
        self.made.program(&[both], &self.title, self.chip)
    }

    /// What a form of it makes of some clips, each seen by a chip of its own, with a threshold of so
    /// many LSB.
    fn packets(
        &self,
        (form, lsb): (Form, u32),
        clips: &[Vec<Frame>],
        (first, size): (u64, Size),
    ) -> Result<Vec<Packet>, DesignError> {
        let sensor = self.made.sensor().clone();
        let device = self.chip.device();
        let program = Compiled::from_text(&self.title, sensor, &self.text(lsb), device)?;
        let design = self.design(self.threshold(lsb));
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

    /// The cell in the float model.
    fn design(&self, threshold: f64) -> Design<'_> {
        Design {
            kernel: &self.made.kernels[0],
            threshold,
            device: self.chip.device(),
            effort: Effort::default(),
            seed: self.seed,
        }
    }

    /// The whole number of LSB with which a form comes nearest to `target` events a pixel and pair, as
    /// a threshold is set on a chip; and what it then makes. `first` is where to look first.
    fn at_rate(
        &self,
        form: Form,
        (target, first): (f64, u32),
        (clips, size): (&[Vec<Frame>], Size),
    ) -> Result<(u32, Vec<Packet>), DesignError> {
        let pairs: usize = clips.iter().map(|frames| frames.len() - 1).sum();
        let cells = (pairs * size.pixels()) as f64;
        let told = |lsb: u32| {
            let packets = self.packets((form, lsb), clips, (0, size))?;
            let events: usize = packets.iter().map(|packet| packet.events.len()).sum();
            // One event in place of none keeps logarithms finite.
            let off = amacrine::elementary::ln(events.max(1) as f64 / cells / target);
            Ok::<_, DesignError>((lsb, off, packets))
        };
        let mut best = told(first.clamp(1, HIGHEST))?;
        let up = best.1 > 0.0;
        let mut stride = (best.0 / 4).max(1);
        // Past the target, then back in steps of one half.
        let (mut low, mut high) = if up {
            (best.0, HIGHEST + 1)
        } else {
            (0, best.0)
        };
        while high - low > 1 {
            let passed = if up { high <= HIGHEST } else { low > 0 };
            let next = match (passed, up) {
                (true, _) => low + (high - low) / 2,
                (false, true) => (low + stride).min(HIGHEST),
                (false, false) => high.saturating_sub(stride).max(1),
            };
            stride = (next / 4).max(1);
            let own = told(next)?;
            if own.1 > 0.0 {
                low = next;
            } else {
                high = next;
            }
            if own.1.abs() < best.1.abs() {
                best = own;
            }
        }
        Ok((best.0, best.2))
    }
}

impl Trainee<'_> {
    /// Rows of the compiled kernel; its program, and the sensor that the program is, go into a folder
    /// where one is given, with what they are of. None where a chip has no such sensor
    /// ([`no_program`]), or its compiler refuses it: then a remark says why.
    ///
    /// # Errors
    /// When a sensor fails, or a file cannot be written; not where the chip refuses a kernel.
    pub(super) fn on_chip(
        &self,
        applied: &Applied,
        rated: &Rated,
        (clips, into): (Sources<'_>, Option<(&Path, &str)>),
    ) -> Result<Judged, TrainError> {
        if let Some(why) = no_program(self.task, self.arm) {
            return Ok(Judged::without(why));
        }
        let [unit] = &applied.kernels[..] else {
            return Ok(Judged::default());
        };
        match self.compiled(applied, unit, rated, (clips, into)) {
            Err(TrainError::Design { cause, .. }) if cause.is_refusal() => {
                Ok(Judged::refused(&cause))
            }
            other => other,
        }
    }

    /// The kernel in the few values of its program, and what they have taken from it.
    fn in_few(
        &self,
        applied: &Applied,
        unit: &Kernel,
    ) -> Result<(Projected, Vec<String>), TrainError> {
        if let [few] = applied.few() {
            return Ok((few.clone(), Vec::new()));
        }
        let quantised = Quantiser::TERNARY.quantise(unit, Sum::Free, self.seed);
        let quantised = quantised.map_err(|cause| TrainError::Design {
            arm: self.arm.name.clone(),
            cause: cause.into(),
        })?;
        let told = |erasure: &Erasure| format!("rounded to ternary for the program: {erasure}");
        let erasures = quantised.erasures(unit);
        let few = Projected::new(quantised.levels.weights(), quantised.scale);
        Ok((few, erasures.iter().map(told).collect()))
    }

    fn compiled(
        &self,
        applied: &Applied,
        unit: &Kernel,
        rated: &Rated,
        (clips, into): (Sources<'_>, Option<(&Path, &str)>),
    ) -> Result<Judged, TrainError> {
        let wrong = |cause: DesignError| TrainError::Design {
            arm: self.arm.name.clone(),
            cause,
        };
        let levels = |cause| TrainError::Levels {
            arm: self.arm.name.clone(),
            step: self.state.step,
            cause,
        };
        let own = rated.description.channels[0].thresholds[0].on * self.white();
        let (few, mut remarks) = self.in_few(applied, unit)?;
        let (kernel, power) = few.kernel().map_err(levels)?;
        let count = CLIPS.min(self.task.test.0);
        let batch = Batch::new(clips.held_out, 0..count);
        let size = batch.size();
        let light = batch.light(self.task.sensor.light_noise, self.draw(Reason::Test, 1));
        let seen: Vec<Vec<Frame>> = self.frames(&light, size);
        let chip = Chip::new(Device::scamp5(), Effort::default(), self.seed);
        let unit = few.norm() / power;
        let threshold = self.with_memory((&kernel, own * unit), &chip, (&light, size))?;
        let made = match chip.compile(&[few], threshold / unit) {
            Ok(made) => made,
            // What the chip refuses has no rows of it.
            Err(LevelsError::Compile(cause)) => return Ok(Judged::refused(&cause)),
            Err(cause) => return Err(levels(cause)),
        };
        let built = Built {
            chip: &chip,
            made,
            title: self.name(),
            seed: self.seed,
        };
        if self.held() && self.task.chip.is_some() && !self.snaps() {
            remarks.push(
                "trained without the chip in the loop: its compiler found no program then"
                    .to_owned(),
            );
        }
        let first = ((threshold * built.made.scale).round() as u32).clamp(1, HIGHEST);
        let mut rows = Vec::new();
        let shown = self.task.retrain.map(|(steps, count)| {
            let batch = Batch::new(clips.training, 0..count);
            let light = batch.light(self.task.sensor.light_noise, self.draw(Reason::Test, 2));
            let frames = self.frames(&light, batch.size());
            (steps, batch, frames)
        });
        // Exact programs mostly make the float model's events: what is learned from them is the same.
        let mut learned: Option<(Told, Self)> = None;
        let mut lsb = first;
        for form in [Form::Quantised, Form::Exact, Form::Silicon] {
            // In exact arithmetic it is the threshold of the float model.
            if let (Form::Exact, Some(into)) = (form, into) {
                self.export((&built, lsb), &remarks, into)?;
            }
            // Where events have a price it is the learned one, whatever its rate.
            let packets = if form == Form::Exact || self.task.sparsity.is_some() {
                built.packets((form, lsb), &seen, (0, size))
            } else {
                let found = built.at_rate(form, (self.target, lsb), (&seen, size));
                found.map(|(found, packets)| {
                    lsb = found;
                    packets
                })
            };
            let packets = packets.map_err(wrong)?;
            let told = self.told(&packets, size);
            rows.extend(self.rows((&batch, 0), Some(&told), (form, Decoder::Own)));
            let Some((steps, shown, frames)) = &shown else {
                continue;
            };
            // Other chips than those it is judged on.
            let packets = built.packets((form, lsb), frames, (CLIPS, shown.size()));
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
        Ok(Judged { rows, remarks })
    }

    /// The threshold that meets the target with the chip's memory, in units of kernel times light; the
    /// one that is given where events have a price.
    fn with_memory(
        &self,
        (kernel, own): (&Kernel, f64),
        chip: &Chip,
        (light, size): (&[f32], Size),
    ) -> Result<f64, TrainError> {
        if self.task.sparsity.is_some() {
            return Ok(own);
        }
        let design = Design {
            kernel,
            threshold: own,
            device: chip.device(),
            effort: Effort::default(),
            seed: self.seed,
        };
        let description = design.description(MemoryRule::FilteredSnap);
        let description = description.map_err(|cause| TrainError::Design {
            arm: self.arm.name.clone(),
            cause,
        })?;
        let lit = Light::new(light, self.times(), size);
        let rating = lit.and_then(|lit| rate_threshold(&description, lit, 0, self.target));
        match rating {
            Ok(rating) => Ok(rating.description.channels[0].thresholds[0].on),
            // A memory that snaps makes one event a pair at most: the least threshold is the nearest.
            Err(GradientError::Rate { .. }) => Ok(0.0),
            Err(cause) => Err(self.gradient_error(cause)),
        }
    }

    /// Writes the program with a threshold of so many LSB, and the sensor that it is in exact
    /// arithmetic: its levels, its whole threshold, its memory.
    fn export(
        &self,
        (built, lsb): (&Built<'_>, u32),
        remarks: &[String],
        (place, source): (&Path, &str),
    ) -> Result<(), TrainError> {
        let text = export::program_text(&built.text(lsb), remarks);
        save::save_durably(&place.join("program.scamp"), |out| {
            out.write_all(text.as_bytes())
        })?;
        let design = built.design(built.threshold(lsb));
        let sensor = design.description(MemoryRule::FilteredSnap);
        let sensor = sensor.map_err(|cause| TrainError::Design {
            arm: self.arm.name.clone(),
            cause,
        })?;
        let sensor = Description {
            name: format!("{}-chip", self.name()),
            ..sensor
        };
        let told = { remarks.iter().cloned() }
            .chain(export::light_noise(self.task.sensor.light_noise))
            .collect::<Vec<_>>();
        export::sensor(&place.join("sensor-chip.toml"), &sensor, (source, &told))
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
