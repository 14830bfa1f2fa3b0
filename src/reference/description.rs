//! A whole sensor as data: the text of a file in `sensors/`, read and checked.
//!
//! ```toml
//! name = "what it is called"                 # optional
//! source = "where it came from"              # optional
//! response = { linear = 255 }                # "identity", { log = … }, { lin-log = … }
//! memory = "filtered-step"                   # "raw-snap", "filtered-snap", "filtered-step"
//! polarity = "filtered"                      # or "pixel"
//! border = "replicate"                       # or "zero"
//! refractory = { us = 1000, rule = "dead-time" }   # or "authors"; without it: none
//! [noise]                                    # without it: none
//! [[channel]]                                # one for each kind of cell
//! kernel = [[0, -1, 0], [-1, 4, -1], [0, -1, 0]]   # or the name of a built-in or of a file
//! # or, in place of the kernel, a resistor mesh:
//! # mesh = { lambda = 10, tau-us = 500 }
//! gain = -1                                  # optional: scales the weights, here centre-OFF
//! threshold = { on = 0.2, off = 0.2, sigma = 0.03 }
//! ```
//!
//! A channel with `pattern = "2x2"` gives four kernels and four thresholds; the pixel at
//! (x, y) uses number `2 (y mod 2) + (x mod 2)`.

use std::{fmt, ops::Range, path::Path, sync::Arc};

use serde::{
    Deserialize, Deserializer,
    de::{
        MapAccess, SeqAccess, Visitor,
        value::{MapAccessDeserializer, SeqAccessDeserializer},
    },
};
use toml::Spanned;

use crate::{
    kernel::{Kernel, KernelError},
    photoreceptor::Response,
};

use super::{
    noise::{Fault, Noise},
    surround::{self, Surrounds},
};

/// Everything that makes one sensor different from another.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// What it is called.
    pub name: String,
    /// From light to signal.
    pub response: Response,
    /// What an event does to the memory.
    pub memory: MemoryRule,
    /// Where an event's sign comes from.
    pub polarity: PolarityRule,
    /// What lies off the array.
    pub border: Border,
    /// How long a cell is silent after an event.
    pub refractory: Refractory,
    /// What disturbs it.
    pub noise: Noise,
    /// The kinds of cells, at least one.
    pub channels: Vec<Channel>,
}

/// What an event does to the memory; `docs/reference.md` has the equations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MemoryRule {
    /// The memory holds pixels; a pixel that fires stores its own signal (Eq. 2-4 of the paper).
    RawSnap,
    /// The memory holds the filtered signal; a cell that fires stores it.
    FilteredSnap,
    /// The memory holds the filtered signal; each event moves it by one threshold.
    FilteredStep,
    /// The released simulator's old rule: the memory holds pixels, and is moved by thresholds
    /// of the filtered difference. Only to agree with the released code.
    AuthorsPixelStep,
}

/// Where an event's sign comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PolarityRule {
    /// The sign of the filtered difference (the released code).
    #[default]
    Filtered,
    /// The sign of the pixel's own change since it last fired (Eq. 3 of the paper). A cell
    /// whose own pixel has not changed has no sign and emits nothing.
    Pixel,
}

/// What the kernel reads off the array.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Border {
    /// The nearest pixel of the array.
    #[default]
    Replicate,
    /// Zero, after the response.
    Zero,
}

/// How long a cell is silent after an event; `docs/reference.md` has the equations.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Refractory {
    /// Microseconds.
    pub us: f64,
    /// How the silence works.
    #[serde(default)]
    pub rule: RefractoryRule,
}

/// How the silence after an event works.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RefractoryRule {
    /// A real dead time: crossings in it are lost, and the memory moves through them.
    #[default]
    DeadTime,
    /// The supplement's `α_r` and `β_r`, as in the released simulator.
    Authors,
}

/// One kind of cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// What it is called.
    pub name: Option<String>,
    /// One kernel, or four for a 2x2 pattern; with sheets, the pixel alone.
    pub kernels: Vec<Kernel>,
    /// The resistor sheets that it sees through in place of a kernel.
    pub surrounds: Option<Surrounds>,
    /// As many thresholds as kernels.
    pub thresholds: Vec<Threshold>,
    /// The kernel that the memory is seen through; only for [`MemoryRule::AuthorsPixelStep`].
    pub memory_kernel: Option<Kernel>,
    /// `a ln(max(W u, 1e-8) + 1)` in place of `W u`: the released simulator's `log_temporal`.
    pub log_temporal: bool,
}

/// When a cell fires.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Threshold {
    /// For ON events, above zero.
    pub on: f64,
    /// For OFF events, a positive magnitude.
    pub off: f64,
    /// Standard deviation of the fixed-pattern mismatch, same unit as the thresholds.
    #[serde(default)]
    pub sigma: f64,
}

/// What is wrong with a sensor file, and where.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("{file}:{line}:{column}: {message}")]
pub struct DescriptionError {
    /// The file's name as it was given.
    pub file: String,
    /// From 1.
    pub line: usize,
    /// From 1.
    pub column: usize,
    /// What is wrong.
    pub message: String,
    /// What to do.
    #[help]
    pub advice: Option<String>,
    #[source_code]
    source_code: Arc<miette::NamedSource<String>>,
    #[label("here")]
    span: miette::SourceSpan,
}

/// Reads a file that a sensor file names; the path is as written there.
pub type ReadFile<'a> = dyn Fn(&str) -> std::io::Result<Vec<u8>> + 'a;

impl Description {
    /// Reads the text of a sensor file called `file`; `read` opens the kernel files it names.
    ///
    /// # Errors
    /// The first thing that is wrong, with its line and column.
    pub fn parse(file: &str, text: &str, read: &ReadFile<'_>) -> Result<Self, DescriptionError> {
        let door = Door { file, text, read };
        if let Err(e) = toml::from_str::<toml::Table>(text) {
            return Err(door.syntax(&e));
        }
        let written: Written = toml::from_str(text).map_err(|e| door.key(&e))?;
        door.check(written)
    }
}

/// The file being read: knows how to point into it.
struct Door<'a> {
    file: &'a str,
    text: &'a str,
    read: &'a ReadFile<'a>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct Written {
    name: Option<String>,
    #[expect(dead_code, reason = "for people")]
    source: Option<String>,
    response: Response,
    memory: Spanned<MemoryRule>,
    #[serde(default)]
    polarity: Option<Spanned<PolarityRule>>,
    #[serde(default)]
    border: Border,
    refractory: Option<Spanned<Refractory>>,
    noise: Option<Spanned<Noise>>,
    channel: Option<Spanned<Vec<Spanned<WrittenChannel>>>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct WrittenChannel {
    name: Option<String>,
    kernel: Option<Spanned<WrittenKernels>>,
    mesh: Option<Spanned<surround::Written>>,
    threshold: Spanned<WrittenThresholds>,
    pattern: Option<Spanned<String>>,
    gain: Option<Spanned<f64>>,
    memory_kernel: Option<Spanned<WrittenKernel>>,
    #[serde(default)]
    log_temporal: bool,
}

#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "expected rows of numbers, such as [[0, -1, 0], [-1, 4, -1], [0, -1, 0]], or the name of a built-in kernel or of a kernel file (with pattern = \"2x2\": an array of four)"
)]
enum WrittenKernels {
    One(WrittenKernel),
    Several(Vec<WrittenKernel>),
}

#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "expected rows of numbers or the name of a built-in kernel or of a kernel file"
)]
enum WrittenKernel {
    Rows(Vec<Vec<f64>>),
    Name(String),
}

enum WrittenThresholds {
    One(Threshold),
    Several(Vec<Threshold>),
}

/// Not an untagged enum, whose errors do not say which key is wrong.
impl<'de> Deserialize<'de> for WrittenThresholds {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either;

        impl<'de> Visitor<'de> for Either {
            type Value = WrittenThresholds;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("{ on = number, off = number, sigma = number }, where sigma may be left out (with pattern = \"2x2\": an array of four)")
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
                Threshold::deserialize(MapAccessDeserializer::new(map)).map(WrittenThresholds::One)
            }

            fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<Self::Value, A::Error> {
                Vec::deserialize(SeqAccessDeserializer::new(seq)).map(WrittenThresholds::Several)
            }
        }

        deserializer.deserialize_any(Either)
    }
}

/// Kinds of cells that a pixel may have, as many as the paper's largest sensor.
const MOST_CHANNELS: usize = 16;

/// What is missing, and how it might read.
const EXAMPLES: [(&str, &str); 6] = [
    ("response", "response = { linear = 255 }"),
    ("memory", "memory = \"filtered-step\""),
    ("threshold", "threshold = { on = 0.2, off = 0.2 }"),
    ("on", "on = 0.2"),
    ("off", "off = 0.2, a positive magnitude"),
    ("us", "us = 1000"),
];

type Checked<T> = Result<T, DescriptionError>;

impl Door<'_> {
    fn check(&self, written: Written) -> Checked<Description> {
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

    fn scaled(&self, kernel: &Kernel, gain: f64, span: &Range<usize>) -> Checked<Kernel> {
        Kernel::new(kernel.weights() * gain).map_err(|e| {
            self.wrong(
                span.clone(),
                &format!("with gain {gain:e}: {e}"),
                "give a smaller gain",
            )
        })
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

    fn memory_kernel(
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

    fn kernel(&self, written: WrittenKernel, span: &Range<usize>) -> Checked<Kernel> {
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

    /// The text is not TOML.
    fn syntax(&self, e: &toml::de::Error) -> DescriptionError {
        self.wrong(
            e.span().unwrap_or(0..0),
            &format!("not TOML: {}", e.message().trim()),
            "write key = value; words go in quotes, as in memory = \"filtered-step\"",
        )
    }

    /// The text is TOML, and a key is missing, unknown, or of another kind.
    fn key(&self, e: &toml::de::Error) -> DescriptionError {
        let message = e.message().trim();
        let missing = message.strip_prefix("missing field `");
        let example = missing.and_then(|rest| {
            let (_, example) = EXAMPLES
                .iter()
                .find(|(key, _)| rest.strip_suffix('`') == Some(key))?;
            Some(format!("add it, such as {example}"))
        });
        let message = message
            .replace("missing field", "missing key")
            .replace("unknown field", "unknown key")
            .replace("unknown variant", "unknown value");
        let advice = example.unwrap_or("docs/reference.md lists every key of a sensor file".into());
        self.wrong(e.span().unwrap_or(0..0), &message, &advice)
    }

    /// Where `key` is given a value, from `start` on; there if it is not found.
    fn place_of(&self, key: &str, start: usize) -> Range<usize> {
        let rest = self.text.get(start..).unwrap_or("");
        let given = |at: &usize| rest[at + key.len()..].trim_start().starts_with('=');
        let found = rest.match_indices(key).map(|(at, _)| at).find(given);
        found.map_or(start..start, |at| start + at..start + at + key.len())
    }

    fn wrong(&self, span: Range<usize>, message: &str, advice: &str) -> DescriptionError {
        let before = self.text.get(..span.start).unwrap_or(self.text);
        let line_start = before.rfind('\n').map_or(0, |at| at + 1);
        DescriptionError {
            file: self.file.to_owned(),
            line: before.matches('\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
            message: message.to_owned(),
            advice: Some(advice.to_owned()),
            source_code: miette::NamedSource::new(self.file, self.text.to_owned()).into(),
            span: (span.start, span.end.saturating_sub(span.start)).into(),
        }
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
            re -= weight * phase.cos();
            im -= weight * phase.sin();
        }
        f64::hypot(re, im)
    };
    (0..GRID * GRID)
        .map(|i| at(angle(i / GRID), angle(i % GRID)))
        .fold(0.0, f64::max)
}

fn stem(file: &str) -> &str {
    let name = file.rsplit(['/', '\\']).next().unwrap_or(file);
    name.strip_suffix(".toml").unwrap_or(name)
}
