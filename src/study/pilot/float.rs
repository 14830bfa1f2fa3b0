//! The float models of one sensor.

use crate::{
    kernel::Kernel,
    mosaic::{Mosaic, Outside},
    number::Format,
    photoreceptor::Curve,
    plane::Size,
    reference::{Border, Description, Effect, Reference, Region, bands_of},
    sensor::{Sensor, SensorError},
    study::design,
};

use super::{
    choice::Choice,
    estimate::{History, Unseen},
    family::Family,
    look::Look,
    rule,
};

/// The float models of a sensor file, for one seed.
#[derive(Clone, Copy, Debug)]
pub struct Floats<'a> {
    /// The sensor.
    pub description: &'a Description,
    /// Its mismatch and noise.
    pub seed: u64,
    /// What is left out for free, of all models.
    pub base: &'a Choice,
}

impl Floats<'_> {
    /// How far kernels reach.
    fn reach(&self) -> usize {
        let channels = self.description.channels.iter();
        let kernels =
            channels.flat_map(|channel| channel.kernels.iter().chain(&channel.memory_kernel));
        let reach = kernels
            .map(Kernel::reach)
            .map(|(down, right)| down.max(right));
        reach.max().unwrap_or(0)
    }

    /// How many events of one hot cell the model changes; there may be none of them in a sample.
    fn hot_events(&self, model: &Choice, look: &Look) -> u64 {
        let (noise, refractory) = (&self.description.noise, self.description.refractory.us);
        let left_out = |effect| model.leaves_out(effect) && !self.base.leaves_out(effect);
        if noise.hot_fraction <= 0.0 || self.base.leaves_out(Effect::NoiseEvents) {
            return 0;
        }
        let held = if refractory > 0.0 && !self.base.leaves_out(Effect::DeadTime) {
            noise.hot_hz.min(1e6 / refractory)
        } else {
            noise.hot_hz
        };
        let hz = if left_out(Effect::NoiseEvents) {
            held
        } else if left_out(Effect::DeadTime) {
            noise.hot_hz
        } else {
            return 0;
        };
        (hz * look.seconds).ceil() as u64
    }
}

impl Family for Floats<'_> {
    type Model = Choice;

    fn full(&self) -> Choice {
        self.base.clone()
    }

    /// A cell sees what its kernel reaches, and its memory is its own. Where the memory holds
    /// pixels it sees the memories of its neighbours, which see those of theirs: then there is no
    /// end to it, but for a kernel of one pixel. A resistor sheet reaches everywhere.
    fn halo(&self) -> Result<usize, &'static str> {
        let description = self.description;
        if description
            .channels
            .iter()
            .any(|channel| channel.surrounds.is_some())
        {
            return Err("a resistor sheet reaches over the whole sensor, and its tiles are not it");
        }
        let reach = self.reach();
        if description.memory.holds_pixels() && reach > 0 {
            return Err(
                "with this memory what a cell does reaches its neighbours, and theirs: the events of a tile are not those of the whole sensor",
            );
        }
        let dark = || {
            description
                .response
                .apply(0.0)
                .is_ok_and(|signal| signal.to_bits() == 0)
        };
        if description.border == Border::Zero && !dark() {
            return Err(
                "off the sensor there is 0, which no light makes in this response: tiles at the border cannot be shown",
            );
        }
        Ok(reach.next_multiple_of(2))
    }

    fn outside(&self) -> Outside {
        match self.description.border {
            Border::Replicate => Outside::Nearest,
            Border::Zero => Outside::Dark,
        }
    }

    fn is_relative(&self) -> bool {
        let logarithmic = matches!(
            self.description.response.curve,
            Curve::Log { .. } | Curve::LinLog { .. }
        );
        logarithmic || self.description.channels.iter().any(|c| c.log_temporal)
    }

    fn fires_alone(&self) -> bool {
        self.description.fires_alone()
    }

    fn sees_inserted(&self, model: &Choice) -> bool {
        !model.leaves_out(Effect::InsertedFrames)
    }

    fn on_tiles(
        &self,
        model: &Choice,
        mosaic: &Mosaic,
    ) -> Result<Box<dyn Sensor + Send>, SensorError> {
        let description = model.plainer(self.description);
        let (format, seed) = (model.format, self.seed);
        Ok(Reference::on_tiles_in_format(
            format,
            description,
            mosaic,
            seed,
        )?)
    }

    fn whole(&self, model: &Choice, size: Size) -> Result<Box<dyn Sensor + Send>, SensorError> {
        design::float(
            model.plainer(self.description),
            size,
            self.seed,
            model.format,
        )
    }

    /// What rounding changes in one cell it changes in those that see the same; each cell's noise is
    /// its own. Saturation is in a place, and so is what the scene makes of a dead time, a bandwidth,
    /// the frames, and of mismatch: which cells are near a threshold.
    fn unseen(&self, model: &Choice, look: &Look) -> Unseen {
        let saturates =
            model.format != Format::F64 && rule::may_saturate(model.format, self.description, look);
        let of_the_scene = |effect: &Effect| {
            effect.influence().unseen == Region::Tile && !self.base.leaves_out(*effect)
        };
        let history = if saturates || model.without.iter().any(of_the_scene) {
            History::Tile
        } else if model.format != self.base.format {
            History::Alike
        } else {
            History::Cell
        };
        Unseen {
            history,
            at_least: self.hot_events(model, look),
        }
    }

    fn together(&self, models: &[Choice]) -> Option<Choice> {
        let mut all = self.base.clone();
        for model in models {
            if model.format != Format::F64 {
                all.format = model.format;
            }
            for effect in &model.without {
                all = all.and_without(*effect);
            }
        }
        Some(all)
    }

    fn parts(&self, size: Size) -> usize {
        bands_of(size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        plane::Size,
        study::pilot::look::{Grid, Look},
    };

    /// What the scene makes of a dead time or of frames is in a place: a sample without a change says
    /// nothing of a tile that was not in it. Rounding and each cell's own noise are everywhere.
    #[test]
    fn what_the_scene_makes_changes_whole_tiles() {
        let description = Description::open("dvs-v2e").unwrap();
        let base = Choice::full().and_without(Effect::DeadTime);
        let family = Floats {
            description: &description,
            seed: 0,
            base: &base,
        };
        let size = Size::new(8, 8);
        let look = Look {
            grid: Grid { size, side: 4 },
            activity: vec![1.0; 4],
            extremes: Vec::new(),
            range: (0.0, 255.0),
            steepest: 100.0,
            seconds: 1.0,
            changing: (0..8, 0..8),
        };
        let unseen = |effect| family.unseen(&base.clone().and_without(effect), &look);
        for effect in [Effect::InsertedFrames, Effect::Bandwidth, Effect::Mismatch] {
            assert_eq!(unseen(effect), History::Tile.into(), "{effect}");
        }
        // What is free is left out of the full model as well.
        for effect in [Effect::DeadTime, Effect::Leak, Effect::Jitter] {
            assert_eq!(unseen(effect), History::Cell.into(), "{effect}");
        }
        // In a second, of a cell that there may be none of in a sample.
        let noise = &description.noise;
        let hot = noise.hot_fraction > 0.0 && noise.hot_hz > 0.0;
        let strays = if hot { noise.hot_hz.ceil() as u64 } else { 0 };
        assert_eq!(unseen(Effect::NoiseEvents).at_least, strays);
        assert_eq!(unseen(Effect::NoiseEvents).history, History::Cell);
        // No light that there is comes near the end of single precision.
        let description = Description::open("laplacian").unwrap();
        let base = Choice::full();
        let family = Floats {
            description: &description,
            seed: 0,
            base: &base,
        };
        let mut single = base.clone();
        single.format = Format::F32;
        assert_eq!(family.unseen(&single, &look), History::Alike.into());
        // A hot cell has as many events as its dead time lets through, and all of them without it.
        let mut description = Description::open("dvs-v2e").unwrap();
        (description.noise.hot_fraction, description.noise.hot_hz) = (0.01, 500.0);
        description.refractory.us = 10_000.0;
        let family = Floats {
            description: &description,
            seed: 0,
            base: &base,
        };
        let least = |effect| {
            let model = base.clone().and_without(effect);
            family.unseen(&model, &look).at_least
        };
        assert_eq!(least(Effect::NoiseEvents), 100);
        assert_eq!(least(Effect::DeadTime), 500);
        assert_eq!(least(Effect::Mismatch), 0);
    }
}
