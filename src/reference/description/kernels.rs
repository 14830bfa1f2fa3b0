//! The kernels of a channel: rows, built-in ones, files.

use std::{ops::Range, path::Path};

use toml::Spanned;

use crate::{
    elementary,
    kernel::{Kernel, KernelError},
    plane::Plane,
};

use super::{MemoryRule, check::Checked, door::Door, written::WrittenKernel};

impl Door<'_> {
    pub(super) fn scaled(
        &self,
        kernel: &Kernel,
        gain: f64,
        span: &Range<usize>,
    ) -> Checked<Kernel> {
        let scaled = kernel.weights() * gain;
        let is_zero = |weights: &Plane<f64>| weights.iter().all(|w| *w == 0.0);
        if is_zero(&scaled) && !is_zero(kernel.weights()) {
            let what = format!("with gain {gain:e}: every weight becomes 0");
            return Err(self.wrong(span.clone(), &what, "give a larger gain"));
        }
        Kernel::new(scaled).map_err(|e| {
            let advice = match e {
                KernelError::Subnormal { .. } => "give a larger gain",
                _ => "give a smaller gain",
            };
            self.wrong(span.clone(), &format!("with gain {gain:e}: {e}"), advice)
        })
    }

    pub(super) fn memory_kernel(
        &self,
        memory: MemoryRule,
        written: Option<Spanned<WrittenKernel>>,
        gain: f64,
        whole: Range<usize>,
    ) -> Checked<Option<Kernel>> {
        match (written, memory) {
            (None, MemoryRule::AuthorsPixelStep) => Err(self.wrong(
                whole,
                "memory = \"authors-pixel-step\" needs a memory-kernel",
                "give the kernel that the memory is seen through (often the channel's own)",
            )),
            (None, _) => Ok(None),
            (Some(written), MemoryRule::AuthorsPixelStep) => {
                let span = written.span();
                let kernel = self.kernel(written.into_inner(), &span)?;
                let kernel = self.scaled(&kernel, gain, &span)?;
                self.stable(&kernel, span)?;
                Ok(Some(kernel))
            }
            (Some(written), _) => Err(self.wrong(
                written.span(),
                "memory-kernel is only for memory = \"authors-pixel-step\"",
                "leave it out: the memory of the other rules is seen through the channel's own kernel, or holds the filtered signal",
            )),
        }
    }

    /// Events move the pixels' memory by what the filtered difference was, which moves that
    /// difference by the kernel's answer to it: what is left of a pattern of spatial frequency
    /// f is 1 - W(f) of it. Above 1 in size it grows.
    fn stable(&self, kernel: &Kernel, span: Range<usize>) -> Checked<()> {
        let worst = growth(kernel);
        if worst <= MOST_GROWTH {
            return Ok(());
        }
        Err(self.wrong(
            span,
            &format!("a pixel memory stepped by filtered thresholds runs away through this kernel: what an event should remove grows up to {worst:.2} times with each frame"),
            "use memory = \"filtered-step\" or \"raw-snap\", which are stable with any kernel",
        ))
    }

    pub(super) fn kernel(&self, written: WrittenKernel, span: &Range<usize>) -> Checked<Kernel> {
        match written {
            WrittenKernel::Rows(rows) => Kernel::from_rows(&rows).map_err(|e: KernelError| {
                self.wrong(
                    span.clone(),
                    &e.to_string(),
                    "kernels are 1x1, 3x3, 5x5, …: rows of numbers, row 0 to the north",
                )
            }),
            WrittenKernel::Name(name) => self.named(&name, span),
        }
    }

    fn named(&self, name: &str, span: &Range<usize>) -> Checked<Kernel> {
        if let Some(kernel) = Kernel::builtin(name) {
            return Ok(kernel);
        }
        let bytes = (self.read)(name).map_err(|e| {
            let known: Vec<_> = Kernel::builtin_names().collect();
            self.wrong(
                span.clone(),
                &format!("kernel \"{name}\" is neither built in nor a file that can be read ({e})"),
                &format!(
                    "give a file beside the sensor file, rows of numbers, or one of {}",
                    known.join(", ")
                ),
            )
        })?;
        let (kernel, advice) = if Path::new(name).extension().is_some_and(|e| e == "npy") {
            let advice = "give a two-dimensional array of numbers; in numpy: np.save(file, kernel)";
            (Kernel::from_npy(&bytes), advice)
        } else {
            let advice = "a kernel file is TOML with one of `weights`, `centre-surround` and `gaussians`, or a .npy array";
            (Kernel::from_toml_bytes(&bytes), advice)
        };
        kernel.map_err(|e| {
            self.wrong(
                span.clone(),
                &format!("kernel file \"{name}\": {e}"),
                advice,
            )
        })
    }
}

/// How much a pixel memory stepped by filtered thresholds may grow in a frame. 1 would be
/// stable for ever; the kernels that the released simulator's reference outputs were made with
/// reach 1.13.
const MOST_GROWTH: f64 = 1.25;

/// The largest |1 - W(f)| of a kernel, over a grid of spatial frequencies.
fn growth(kernel: &Kernel) -> f64 {
    const GRID: usize = 32;
    let (reach_y, reach_x) = kernel.reach();
    let angle = |i: usize| std::f64::consts::TAU * i as f64 / GRID as f64;
    let at = |fy: f64, fx: f64| {
        let (mut re, mut im) = (1.0, 0.0);
        for ((y, x), weight) in kernel.weights().indexed_iter() {
            let phase = fy * (y as f64 - reach_y as f64) + fx * (x as f64 - reach_x as f64);
            re -= weight * elementary::cos(phase);
            im -= weight * elementary::sin(phase);
        }
        elementary::hypot(re, im)
    };
    (0..GRID * GRID)
        .map(|i| at(angle(i / GRID), angle(i % GRID)))
        .fold(0.0, f64::max)
}
