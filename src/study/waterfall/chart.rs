//! The waterfall as a picture.

use super::Waterfall;
use crate::{
    compare::fate::Fate,
    picture::{Classes, Drawing, WaterfallShow, WaterfallStep, waterfall},
};

impl Waterfall {
    /// A page with a row for each step; [`picture::svg`](crate::picture::svg) and
    /// [`picture::raster`](crate::picture::raster) make a file of it.
    #[must_use]
    pub fn drawing(&self, title: &str) -> Drawing {
        let steps: Vec<_> = self
            .steps
            .iter()
            .map(|step| WaterfallStep {
                name: step.name,
                forward: classes(step.forward),
                backward: step.backward.map(classes),
            })
            .collect();
        waterfall(&WaterfallShow {
            title,
            captions: &self.captions(),
            whole: self.float_events,
            steps: &steps,
            ends: classes(self.ends),
        })
    }

    /// What was run, in two lines.
    #[must_use]
    pub fn captions(&self) -> [String; 2] {
        let Self {
            float_events,
            chip_events,
            windows,
            program,
            ..
        } = self;
        [
            format!(
                "{float_events} events of the float sensor are 100 %, {chip_events} leave the chip; kept within {}, mistimed within {}",
                windows.narrow, windows.wide
            ),
            format!(
                "{} on cells of {}: {} words a frame, the light halved {} times, a threshold of {:.3} LSB",
                self.to,
                self.arithmetic,
                program.words,
                program.prescale_bits,
                program.threshold_lsb
            ),
        ]
    }
}

const fn classes(fate: Fate) -> Classes {
    Classes {
        kept: fate.kept,
        mistimed: fate.mistimed,
        wrong_sign: fate.wrong_sign,
        lost: fate.lost,
        extra: fate.extra,
    }
}
