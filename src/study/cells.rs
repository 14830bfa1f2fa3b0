//! The cells of a sensor as a chip computes them: kernels and thresholds in kernel times light,
//! 0 to 255, what the program is to remember, and in what it cannot follow the sensor.
//!
//! ```
//! use amacrine::{compile::DriveMemory, reference::Description, study::cells};
//!
//! let sensor = Description::open("rgc-4-on-chip")?;
//! let memory = cells::memory_of(&sensor.name, &sensor)?;
//! assert_eq!(memory, DriveMemory::Shared);
//! let cells = cells::compiled_cells(&sensor.name, &sensor, memory)?;
//! assert_eq!(cells.kinds.len(), 4);
//! assert_eq!(cells.kinds[0].on, 0.6 * 255.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use miette::Diagnostic as _;

use crate::{
    compile::{CellKind, CompileError, DriveMemory, naive_cost},
    kernel::{Kernel, KernelError},
    photoreceptor::Curve,
    reference::{Border, Channel, Description, MemoryRule, Noise, PolarityRule},
};

/// The cells of a sensor as a chip computes them.
#[derive(Clone, Debug, PartialEq)]
pub struct Cells {
    /// The kernel and the thresholds of each kind, in kernel times light (0 to 255); its name where
    /// the sensor says so.
    pub kinds: Vec<CellKind>,
    /// In what a program of them cannot follow the sensor, a sentence each.
    pub notes: Vec<String>,
}

/// Why a sensor's cells are none that a chip computes. `sensor` is what the sensor is called.
#[derive(Clone, Debug, PartialEq, thiserror::Error, miette::Diagnostic)]
pub enum CellsError {
    /// Photodiodes are linear.
    #[error("{sensor}: its response is not linear")]
    #[diagnostic(help(
        "the chip's photodiode is linear: give a sensor with `response = {{ linear = 255 }}`"
    ))]
    Response {
        /// The sensor.
        sensor: String,
    },
    /// A logarithm of the drive.
    #[error(
        "{sensor}, channel {channel}: log-temporal cannot run on the chip, which takes no logarithm"
    )]
    #[diagnostic(help(
        "the chip compares kernel times light itself: give the channel without `log-temporal = true`, and a threshold in kernel times light"
    ))]
    LogTemporal {
        /// The sensor.
        sensor: String,
        /// The kind of cell, from 0.
        channel: usize,
    },
    /// Four kernels, pixel by pixel.
    #[error("{sensor}: a channel has a pattern of kernels")]
    #[diagnostic(help(
        "give every kind of cell one kernel; all pixels of the array run the same program"
    ))]
    Pattern {
        /// The sensor.
        sensor: String,
    },
    /// A resistor mesh in place of a kernel.
    #[error("{sensor}: a channel has a resistor mesh, which cannot be compiled to a program")]
    #[diagnostic(help(
        "give the channel a kernel; `amacrine mesh fit` tells which kernels a mesh carries"
    ))]
    Mesh {
        /// The sensor.
        sensor: String,
    },
    /// A kernel with weights that no verb computes with.
    #[error("{sensor}, channel {channel}: {cause}")]
    #[diagnostic(help("multiply the kernel by a number, and the threshold with it"))]
    Kernel {
        /// The sensor.
        sensor: String,
        /// The kind of cell, from 0.
        channel: usize,
        /// What is wrong with it.
        #[source]
        cause: KernelError,
    },
    /// One threshold is asked for, and there are two.
    #[error("{sensor}: a channel has a threshold of {on} for ON and {off} for OFF")]
    #[diagnostic(help("give both the same threshold; `amacrine compile --sensor` takes two"))]
    TwoThresholds {
        /// The sensor.
        sensor: String,
        /// For ON events, in the sensor's unit.
        on: f64,
        /// For OFF events.
        off: f64,
    },
    /// A memory of the pixel for each kind.
    #[error(
        "{sensor}: each kind has its own memory of the pixel, which the compiler supports on no chip"
    )]
    #[diagnostic(help(
        "add `shared = true`: one memory of the pixel for all kinds, in one register{}",
        // Of more than two kinds no shipped chip of six registers has them.
        if *kinds > 2 { "" } else { ", or write `memory = \"filtered-snap\"`: a memory of the drive for each" }
    ))]
    MemoriesOfPixel {
        /// The sensor.
        sensor: String,
        /// How many kinds it has.
        kinds: usize,
    },
    /// A memory that steps.
    #[error("{sensor}: its memory steps")]
    #[diagnostic(help(
        "the chip decides once a frame and stores the value it saw: give a sensor with `memory = \"filtered-snap\"`, or with `memory = \"raw-snap\"` and `shared = true`, one memory for all kinds"
    ))]
    Steps {
        /// The sensor.
        sensor: String,
    },
    /// Signs of the pixel.
    #[error(
        "{sensor}: its events have the pixel's sign, but those of a compiled program the drive's"
    )]
    #[diagnostic(help("give a sensor with `polarity = \"filtered\"`"))]
    SignOfPixel {
        /// The sensor.
        sensor: String,
    },
    /// Weights that no program computes.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Weights(CompileError),
    /// Several of these.
    #[error("{}", each(all, ToString::to_string))]
    #[diagnostic(help("{}", each(all, help)))]
    Several {
        /// Every reason.
        all: Vec<Self>,
    },
}

/// What is said of each, as one sentence.
fn each(all: &[CellsError], said: impl Fn(&CellsError) -> String) -> String {
    all.iter().map(said).collect::<Vec<_>>().join("; and ")
}

/// What to do about one.
fn help(error: &CellsError) -> String {
    error
        .help()
        .map_or_else(String::new, |help| help.to_string())
}

impl CellsError {
    /// The same behind those before it: all that is to be mended, or what can never fit.
    fn behind(self, before: Option<Self>) -> Self {
        let never = |it: &Self| matches!(it, Self::Mesh { .. } | Self::Pattern { .. });
        match before {
            None => self,
            Some(before) if never(&before) => before,
            Some(_) if never(&self) => self,
            Some(before) => {
                let flat = [before, self].into_iter().flat_map(|it| match it {
                    Self::Several { all } => all,
                    one => vec![one],
                });
                Self::Several {
                    all: flat.collect(),
                }
            }
        }
    }
}

/// The cells of a sensor, whatever it remembers; it is called `sensor` in messages.
///
/// # Errors
/// When the response is not linear, or a channel is no kernel that can be compiled, or has a
/// logarithm of its drive.
pub fn cells(sensor: &str, description: &Description) -> Result<Cells, CellsError> {
    let called = || sensor.to_owned();
    let mut faults = None;
    let mut add = |fault: CellsError| faults = Some(fault.behind(faults.take()));
    if description.channels.iter().any(|it| it.surrounds.is_some()) {
        add(CellsError::Mesh { sensor: called() });
    }
    let white = match description.response.curve {
        Curve::Identity => 1.0,
        Curve::Linear { white } => white,
        Curve::Log { .. } | Curve::LinLog { .. } => {
            add(CellsError::Response { sensor: called() });
            1.0
        }
    };
    let mut kinds = Vec::new();
    for (i, channel) in description.channels.iter().enumerate() {
        match kind(sensor, i, channel, white) {
            Ok(kind) => kinds.push(kind),
            Err(fault) => add(fault),
        }
    }
    match faults {
        Some(faults) => Err(faults),
        None => Ok(Cells {
            kinds,
            notes: Vec::new(),
        }),
    }
}

fn kind(sensor: &str, channel: usize, of: &Channel, white: f64) -> Result<CellKind, CellsError> {
    let sensor = || sensor.to_owned();
    let ([kernel], [threshold]) = (&of.kernels[..], &of.thresholds[..]) else {
        return Err(CellsError::Pattern { sensor: sensor() });
    };
    if of.log_temporal {
        return Err(CellsError::LogTemporal {
            sensor: sensor(),
            channel,
        });
    }
    kernel.workable().map_err(|cause| CellsError::Kernel {
        sensor: sensor(),
        channel,
        cause,
    })?;
    Ok(CellKind {
        name: of.name.clone(),
        kernel: kernel.clone(),
        on: threshold.on * white,
        off: threshold.off * white,
    })
}

impl Cells {
    /// One threshold for each kind, for ON and OFF.
    ///
    /// # Errors
    /// When a kind has two.
    pub fn thresholds(&self, sensor: &str) -> Result<Vec<f64>, CellsError> {
        let one = |kind: &CellKind| {
            if kind.on == kind.off {
                return Ok(kind.on);
            }
            Err(CellsError::TwoThresholds {
                sensor: sensor.to_owned(),
                on: kind.on,
                off: kind.off,
            })
        };
        self.kinds.iter().map(one).collect()
    }
}

/// The kinds of cells of a sensor for a study, which compiles their kernels itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Studied {
    /// What each is called.
    pub names: Vec<String>,
    /// The kernel of each.
    pub kernels: Vec<Kernel>,
    /// The threshold of each, for ON and OFF, in kernel times light (0 to 255).
    pub thresholds: Vec<f64>,
    /// What a program of several must remember to follow the sensor.
    pub memory: Option<DriveMemory>,
    /// In what programs cannot follow the sensor, a sentence each.
    pub notes: Vec<String>,
}

/// The kinds of cells of a sensor for a study; `sensor` is what it is called.
///
/// # Errors
/// As [`compiled_cells`], and when a kind has two thresholds.
pub fn studied(sensor: &str, description: &Description) -> Result<Studied, CellsError> {
    let several = description.channels.len() > 1;
    let followed = memory_of(sensor, description).ok();
    let memory = followed.filter(|_| several);
    let cells = compiled_cells(sensor, description, memory.unwrap_or(DriveMemory::Analogue))?;
    let thresholds = cells.thresholds(sensor)?;
    let name = |(i, kind): (usize, &CellKind)| match &kind.name {
        Some(own) => own.clone(),
        None if several => format!("{sensor}[{i}]"),
        None => sensor.to_owned(),
    };
    Ok(Studied {
        names: cells.kinds.iter().enumerate().map(name).collect(),
        kernels: cells.kinds.into_iter().map(|kind| kind.kernel).collect(),
        thresholds,
        memory,
        notes: cells.notes,
    })
}

/// What a program has to remember to follow a sensor.
///
/// # Errors
/// When no program remembers that: the memory steps, or each kind has one of the pixel.
pub fn memory_of(sensor: &str, description: &Description) -> Result<DriveMemory, CellsError> {
    let sensor = || sensor.to_owned();
    match description.memory {
        MemoryRule::FilteredSnap => Ok(DriveMemory::Analogue),
        MemoryRule::RawSnap if description.shared || description.channels.len() == 1 => {
            Ok(DriveMemory::Shared)
        }
        MemoryRule::RawSnap => Err(CellsError::MemoriesOfPixel {
            sensor: sensor(),
            kinds: description.channels.len(),
        }),
        MemoryRule::FilteredStep | MemoryRule::AuthorsPixelStep => {
            Err(CellsError::Steps { sensor: sensor() })
        }
    }
}

/// What a program has to remember to follow a sensor, and its cells, as [`memory_of`] and
/// [`compiled_cells`] have them. What can never fit is said first, else all that is to be mended: of
/// kernels that are taken as they are, `exact`, their weights too.
///
/// # Errors
/// As of both.
pub fn of_program(
    sensor: &str,
    description: &Description,
    exact: bool,
) -> Result<(DriveMemory, Cells), CellsError> {
    let memory = memory_of(sensor, description);
    let own = *memory.as_ref().unwrap_or(&DriveMemory::Analogue);
    let fault = match (memory, compiled_cells(sensor, description, own)) {
        (Ok(memory), Ok(cells)) => return Ok((memory, cells)),
        (memory, Err(fault)) => fault.behind(memory.err()),
        (Err(fault), Ok(_)) => fault,
    };
    let weights = { weights(sensor, description).into_iter() }.filter(|_| exact);
    Err(weights.fold(fault, |before, own| own.behind(Some(before))))
}

/// The kernels whose weights no program computes as they are.
fn weights(sensor: &str, description: &Description) -> Vec<CellsError> {
    let several = description.channels.len() > 1;
    let channels = description.channels.iter().enumerate();
    let kernels = channels.flat_map(|(i, channel)| channel.kernels.iter().map(move |it| (i, it)));
    let fault = |(i, kernel): (usize, &Kernel)| {
        let called = if several {
            format!("{sensor}[{i}]")
        } else {
            sensor.to_owned()
        };
        let refused = naive_cost(std::slice::from_ref(kernel)).err()?;
        Some(CellsError::Weights(refused.of_kernel(&called)))
    };
    { kernels.filter(|(_, kernel)| kernel.workable().is_ok()) }
        .filter_map(fault)
        .collect()
}

/// The cells of a sensor for a program that remembers in this way, with notes of all that it does
/// otherwise than the sensor.
///
/// # Errors
/// As [`cells`], and when the events have the signs of the pixel.
pub fn compiled_cells(
    sensor: &str,
    description: &Description,
    memory: DriveMemory,
) -> Result<Cells, CellsError> {
    let cells = cells(sensor, description);
    let sign = (description.polarity == PolarityRule::Pixel).then(|| CellsError::SignOfPixel {
        sensor: sensor.to_owned(),
    });
    let mut cells = match (cells, sign) {
        (Ok(cells), None) => cells,
        (cells, Some(sign)) => return Err(sign.behind(cells.err())),
        (Err(fault), None) => return Err(fault),
    };
    let (rule, stored) = match memory {
        DriveMemory::Shared => (MemoryRule::RawSnap, "raw-snap"),
        DriveMemory::Analogue | DriveMemory::Bits(_) => (MemoryRule::FilteredSnap, "filtered-snap"),
    };
    if description.memory != rule {
        cells.notes.push(format!(
            "{sensor}: its memory is not {stored}; one decision a frame stores what was seen"
        ));
    }
    if description.border == Border::Replicate {
        cells.notes.push(format!(
            "{sensor} replicates the border; off the array the chip sees 0"
        ));
    }
    if description.noise != Noise::NONE {
        cells.notes.push(format!(
            "{sensor} has noise in its cells; the program has that of the chip alone"
        ));
    }
    let mut thresholds = { description.channels.iter() }.flat_map(|channel| &channel.thresholds);
    if thresholds.any(|threshold| threshold.sigma > 0.0) {
        cells.notes.push(format!(
            "{sensor} has mismatch of its thresholds; the program has the chip's alone"
        ));
    }
    if description.refractory.us > 0.0 {
        cells.notes.push(format!(
            "{sensor} has a refractory period; the program has none, a cell fires once a frame at most"
        ));
    }
    Ok(cells)
}
