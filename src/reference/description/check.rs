//! What is written in a sensor file, checked.

use std::ops::Range;

use toml::Spanned;

use super::{
    super::{
        noise::{Fault, Noise},
        surround::{self, Surrounds},
    },
    Channel, Description, DescriptionError, MemoryRule, PolarityRule, Refractory, RefractoryRule,
    Threshold,
    door::Door,
    written::{Written, WrittenChannel, WrittenKernel, WrittenKernels, WrittenThresholds},
};

/// Kinds of cells that a pixel may have, as many as the paper's largest sensor.
const MOST_CHANNELS: usize = 16;

/// What was written, if it is right.
pub(super) type Checked<T> = Result<T, DescriptionError>;

impl Door<'_> {
    pub(super) fn check(&self, written: Written) -> Checked<Description> {
        let memory = *written.memory.get_ref();
        let refractory = self.refractory(memory, written.refractory)?;
        let polarity = self.polarity(memory, written.polarity)?;
        let noise = self.noise(memory, refractory, written.noise)?;
        let Some(channels) = written.channel else {
            return Err(self.wrong(
                0..0,
                "there is no [[channel]]",
                "add one [[channel]] with a kernel and a threshold for each kind of cell",
            ));
        };
        let listed = channels.span();
        let channels = channels.into_inner();
        if channels.is_empty() || channels.len() > MOST_CHANNELS {
            let beyond = channels.get(MOST_CHANNELS).map(Spanned::span);
            return Err(self.wrong(
                beyond.unwrap_or(listed),
                &format!("there are {} channels", channels.len()),
                "give one to sixteen [[channel]] tables",
            ));
        }
        let channels = channels
            .into_iter()
            .map(|channel| self.channel(memory, channel))
            .collect::<Checked<_>>()?;
        Ok(Description {
            name: written.name.unwrap_or_else(|| stem(self.file).to_owned()),
            response: written.response,
            memory,
            polarity,
            border: written.border,
            refractory,
            noise,
            channels,
        })
    }

    fn refractory(
        &self,
        memory: MemoryRule,
        written: Option<Spanned<Refractory>>,
    ) -> Checked<Refractory> {
        let Some(written) = written else {
            let rule = match memory {
                MemoryRule::AuthorsPixelStep => RefractoryRule::Authors,
                _ => RefractoryRule::DeadTime,
            };
            return Ok(Refractory { us: 0.0, rule });
        };
        let (span, refractory) = (written.span(), written.into_inner());
        if !(refractory.us >= 0.0 && refractory.us.is_finite()) {
            return Err(self.wrong(
                span,
                &format!("the refractory period is {} us", refractory.us),
                "give zero or a positive number of microseconds",
            ));
        }
        let snaps = matches!(memory, MemoryRule::RawSnap | MemoryRule::FilteredSnap);
        if snaps && refractory.rule == RefractoryRule::Authors {
            return Err(self.wrong(
                span,
                "the authors' refractory rule counts the steps of a memory, and this memory snaps",
                "use rule = \"dead-time\", or memory = \"filtered-step\"",
            ));
        }
        if memory == MemoryRule::AuthorsPixelStep && refractory.rule == RefractoryRule::DeadTime {
            return Err(self.wrong(
                span,
                "memory = \"authors-pixel-step\" exists to agree with the released code, whose refractory rule is its own",
                "use rule = \"authors\"",
            ));
        }
        Ok(refractory)
    }

    fn polarity(
        &self,
        memory: MemoryRule,
        written: Option<Spanned<PolarityRule>>,
    ) -> Checked<PolarityRule> {
        let Some(written) = written else {
            return Ok(PolarityRule::default());
        };
        let steps = matches!(
            memory,
            MemoryRule::FilteredStep | MemoryRule::AuthorsPixelStep
        );
        if steps && *written.get_ref() == PolarityRule::Pixel {
            return Err(self.wrong(
                written.span(),
                "polarity = \"pixel\" needs the pixel as it was when the cell last fired, and a memory that steps does not keep it",
                "use polarity = \"filtered\", or memory = \"raw-snap\" or \"filtered-snap\"",
            ));
        }
        Ok(written.into_inner())
    }

    fn noise(
        &self,
        memory: MemoryRule,
        refractory: Refractory,
        written: Option<Spanned<Noise>>,
    ) -> Checked<Noise> {
        let Some(written) = written else {
            return Ok(Noise::NONE);
        };
        let (span, noise) = (written.span(), written.into_inner());
        match noise.check(memory, refractory.rule) {
            Ok(()) => Ok(noise),
            Err(Fault {
                key,
                message,
                advice,
            }) => Err(self.wrong(self.place_of(key, span.start), &message, &advice)),
        }
    }

    fn channel(&self, memory: MemoryRule, written: Spanned<WrittenChannel>) -> Checked<Channel> {
        let whole = written.span();
        let written = written.into_inner();
        let four = match &written.pattern {
            None => false,
            Some(name) if name.get_ref() == "2x2" => true,
            Some(name) => {
                return Err(self.wrong(
                    name.span(),
                    &format!("unknown pattern \"{}\"", name.get_ref()),
                    "the only pattern is \"2x2\"; leave it out for the same kernel everywhere",
                ));
            }
        };
        let gain = self.gain(written.gain)?;
        let mesh = written.mesh.map(|mesh| (mesh.span(), mesh.into_inner()));
        let surrounds = match mesh {
            None => None,
            Some((span, mesh)) => {
                let alone = written.kernel.is_none()
                    && !four
                    && !written.log_temporal
                    && matches!(memory, MemoryRule::FilteredSnap | MemoryRule::FilteredStep);
                Some(self.surrounds(mesh, alone, gain, span)?)
            }
        };
        let (kernel_span, kernel) = match (written.kernel, &surrounds) {
            (Some(kernel), _) => (kernel.span(), kernel.into_inner()),
            (None, Some(_)) => (
                whole.clone(),
                WrittenKernels::One(WrittenKernel::Rows(vec![vec![1.0]])),
            ),
            (None, None) => {
                return Err(self.wrong(
                    whole.start..whole.start,
                    "missing key `kernel`",
                    "add it, such as kernel = \"csdvs-5\", or in its place mesh = { lambda = 10 }",
                ));
            }
        };
        let kernels: Vec<_> = match (kernel, four) {
            (WrittenKernels::One(one), false) => vec![self.kernel(one, &kernel_span)?],
            (WrittenKernels::Several(four), true) if four.len() == 4 => four
                .into_iter()
                .map(|kernel| self.kernel(kernel, &kernel_span))
                .collect::<Checked<_>>()?,
            (WrittenKernels::Several(_), false) => {
                return Err(self.wrong(
                    kernel_span,
                    "several kernels in one channel",
                    "add pattern = \"2x2\" for four kernels, or one [[channel]] for each",
                ));
            }
            (_, true) => return Err(self.wrong(
                kernel_span,
                "pattern = \"2x2\" needs four kernels",
                "give kernel = [k0, k1, k2, k3]; the pixel at (x, y) uses number 2*(y%2) + (x%2)",
            )),
        };
        let threshold_span = written.threshold.span();
        let thresholds = match (written.threshold.into_inner(), four) {
            (WrittenThresholds::One(one), false) => vec![one],
            (WrittenThresholds::Several(several), true) if several.len() == 4 => several,
            (WrittenThresholds::Several(_), false) => {
                return Err(self.wrong(
                    threshold_span,
                    "several thresholds in one channel",
                    "add pattern = \"2x2\" for four thresholds, or give one",
                ));
            }
            (_, true) => {
                return Err(self.wrong(
                    threshold_span,
                    "pattern = \"2x2\" needs four thresholds",
                    "give threshold = [{ … }, { … }, { … }, { … }]",
                ));
            }
        };
        for threshold in &thresholds {
            self.threshold(*threshold, &threshold_span)?;
        }
        let memory_kernel = self.memory_kernel(memory, written.memory_kernel, gain, whole)?;
        let kernels = kernels
            .iter()
            .map(|kernel| self.scaled(kernel, gain, &kernel_span))
            .collect::<Checked<_>>()?;
        Ok(Channel {
            name: written.name,
            kernels,
            surrounds,
            thresholds,
            memory_kernel,
            log_temporal: written.log_temporal,
        })
    }

    fn surrounds(
        &self,
        written: surround::Written,
        alone: bool,
        gain: f64,
        span: Range<usize>,
    ) -> Checked<Surrounds> {
        if !alone {
            return Err(self.wrong(
                span,
                "a mesh stands in place of a kernel, before a memory of the filtered signal",
                "use memory = \"filtered-step\" or \"filtered-snap\", and no kernel, pattern or log-temporal in this channel",
            ));
        }
        written.checked(gain).map_err(|fault| {
            let Fault {
                key,
                message,
                advice,
            } = fault;
            self.wrong(self.place_of(key, span.start), &message, &advice)
        })
    }

    fn gain(&self, written: Option<Spanned<f64>>) -> Checked<f64> {
        let Some(written) = written else {
            return Ok(1.0);
        };
        let gain = *written.get_ref();
        if gain == 0.0 || !gain.is_finite() {
            return Err(self.wrong(
                written.span(),
                &format!("gain is {gain}"),
                "give a finite number other than zero: -1 exchanges ON and OFF",
            ));
        }
        Ok(gain)
    }

    fn threshold(&self, threshold: Threshold, span: &Range<usize>) -> Checked<()> {
        let positive = |value: f64| value > 0.0 && value.is_finite();
        for (name, value) in [("on", threshold.on), ("off", threshold.off)] {
            if !positive(value) {
                return Err(self.wrong(
                    self.place_of(name, span.start),
                    &format!("threshold.{name} is {value}"),
                    "give a finite number above zero; `off` is a positive magnitude",
                ));
            }
        }
        if !(threshold.sigma >= 0.0 && threshold.sigma.is_finite()) {
            return Err(self.wrong(
                self.place_of("sigma", span.start),
                &format!("threshold.sigma is {}", threshold.sigma),
                "give zero or a positive standard deviation, in the unit of the threshold",
            ));
        }
        Ok(())
    }
}

fn stem(file: &str) -> &str {
    let name = file.rsplit(['/', '\\']).next().unwrap_or(file);
    name.strip_suffix(".toml").unwrap_or(name)
}
