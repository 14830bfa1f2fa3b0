//! What a number format takes from the kernels of a sensor.

use crate::{kernel::Loss, number::Format};

use super::{Channel, Description};

impl Description {
    /// What holding its kernels in a format takes from the first kind of cells that it makes another
    /// kind, and which that is; for light from 0 to 255. Resistor sheets are held in no format.
    #[must_use]
    pub fn losses(&self, format: Format) -> Option<(usize, Loss)> {
        let mut kinds = self.channels.iter().enumerate();
        kinds.find_map(|(k, kind)| Some((k, kind.loss(format, self.signal())?)))
    }

    /// The same of a sensor of which a format leaves no kind of cells more than a little of its
    /// kernel.
    #[must_use]
    pub fn lost(&self, format: Format) -> Option<Loss> {
        let losses = self
            .channels
            .iter()
            .map(|kind| kind.loss(format, self.signal()));
        let losses: Option<Vec<Loss>> = losses.collect();
        let losses = losses?;
        losses
            .iter()
            .all(Loss::leaves_little)
            .then(|| losses.first().copied())?
    }

    /// By how much light from 0 to 255 moves the signal.
    fn signal(&self) -> f64 {
        let [dark, bright] = [0.0, 255.0].map(|light| self.response.apply(light).unwrap_or(0.0));
        (bright - dark).abs()
    }
}

impl Channel {
    fn loss(&self, format: Format, signal: f64) -> Option<Loss> {
        if self.surrounds.is_some() {
            return None;
        }
        let mut cells = self.kernels.iter().zip(&self.thresholds);
        cells.find_map(|(kernel, it)| kernel.loss(format, signal, it.on.min(it.off)))
    }
}
