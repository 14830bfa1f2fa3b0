//! What tells two tasks apart.

use std::fmt::Debug;

use super::Task;

impl Task {
    /// The first key whose value makes another run of it, with what it was and what it is; `None` where
    /// they are alike but for names, arms, targets, seeds, checkpoints and where pictures are.
    #[must_use]
    pub fn changed(&self, was: &Self) -> Option<String> {
        let (own, old) = (self.values(), was.values());
        let mut both = own.into_iter().zip(old);
        both.find_map(|((key, is), (_, was))| {
            (is != was).then(|| format!("`{key}` was {was} and is {is}"))
        })
    }

    /// The keys that results depend on, in the order of a file, each with its value as text.
    fn values(&self) -> Vec<(&'static str, String)> {
        let (scenes, sensor) = (&self.scenes, &self.sensor);
        let motion = &scenes.motion;
        let asked = |value: &dyn Debug| format!("{value:?}");
        let word = |value: Option<f64>| value.map_or("left out".to_owned(), |own| asked(&own));
        vec![
            ("goal", self.goal.word().to_owned()),
            ("loss", asked(&self.loss).to_lowercase()),
            ("steps", asked(&self.steps)),
            ("batch", asked(&self.batch)),
            ("crop", asked(&self.crop)),
            ("network.widths", asked(&self.widths)),
            ("network.convolutions", asked(&self.convolutions)),
            ("rates.network", asked(&self.rates.0)),
            ("rates.kernel", asked(&self.rates.1)),
            ("sparsity.weight", word(self.sparsity)),
            ("scenes.clips", asked(&scenes.clips)),
            ("scenes.frames", asked(&scenes.frames)),
            ("scenes.fps", asked(&scenes.fps)),
            ("scenes.pan", asked(&motion.pan[1])),
            ("scenes.turn", asked(&motion.turn)),
            ("scenes.zoom", asked(&motion.zoom)),
            ("scenes.shear", asked(&motion.shear)),
            ("scenes.gain", asked(&motion.gain)),
            ("scenes.gamma", asked(&motion.gamma)),
            ("scenes.occluded", asked(&motion.occluder)),
            ("sensor.response", asked(&sensor.response)),
            ("sensor.refractory-us", asked(&sensor.refractory_us)),
            ("sensor.light-noise", asked(&sensor.light_noise)),
            ("sensor.mismatch", asked(&sensor.mismatch)),
            ("chip", self.chip.clone().unwrap_or("none".to_owned())),
            ("price.words", asked(&self.price[0])),
            ("price.survival", asked(&self.price[1])),
            ("test.clips", asked(&self.test.0)),
            ("test.crop", asked(&self.test.1)),
            ("retrain.steps", word(self.retrain.map(|own| own.0 as f64))),
            ("retrain.clips", word(self.retrain.map(|own| own.1 as f64))),
        ]
    }
}
