//! Kernel files: TOML with the weights, or with the formula they come from.
//!
//! ```toml
//! name = "centre-surround-5x5"
//! source = "where it came from"
//! weights = [[0, -1, 0], [-1, 4, -1], [0, -1, 0]]   # or one of the next two
//! centre-surround = 5                 # centre 1, the others -1/(k*k - 1)
//! gaussians = [{ sigma = 1, gain = 1 }, { sigma = 2, gain = -1 }]
//! ```
//!
//! Learned kernels come as `.npy` arrays of shape (rows, columns).

use std::path::Path;

use super::{Gaussian, Kernel, KernelError};
use crate::{
    config::{Fault, Faults, File, Key, Kind, Range, Read, Section, Table},
    limit::{KERNEL_SIDE, KERNELS},
    npy,
    plane::Plane,
};

/// What an array of kernels is.
pub const SHAPES: &str = "give an array of shape (k,k), (K,k,k) or (K,1,k,k), rows and columns odd in number, of finite floats or integers; numpy.pad adds rows and columns of zeros";

/// What to give instead of too many kernels.
pub const FEWER: &str =
    "give as many as that: a sensor, and a program, have a kind of cell for each kernel";

/// That there are so many kernels, where there may not be.
#[must_use]
pub fn wrong_number(kernels: usize) -> String {
    format!("{kernels} kernels; 1 to {KERNELS} kernels at most")
}

/// A kernel file that cannot be used.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum KernelFileError {
    /// Not text.
    #[error("it is not text in UTF-8")]
    NotText,
    /// Not a two-dimensional array of numbers in the format of numpy.
    #[error("{0}")]
    Array(String),
    /// Not TOML, or not the keys and values of a kernel file.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Wrong(#[from] Faults),
    /// Not a kernel.
    #[error("{0}")]
    Kernel(#[from] KernelError),
    /// A formula with a parameter it is not defined for.
    #[error("{0}")]
    Parameter(String),
}

/// A kernel file.
pub const FILE: File = File {
    title: "a kernel of amacrine",
    kind: Kind::Table(&KERNEL),
    see: "a kernel file has one of `weights`, `centre-surround` and `gaussians`; kernels/ has examples",
};

/// Weights as they are written: rows of numbers, row 0 to the north.
pub const ROWS: Kind = some(&some(&Kind::Number(Range::FREE)));

/// A list that is not empty.
const fn some(of: &'static Kind) -> Kind {
    Kind::List {
        of,
        least: 1,
        most: usize::MAX,
    }
}

const KERNEL: Table = Table {
    one_of: &["weights", "centre-surround", "gaussians"],
    keys: &[
        Key::optional("name", Kind::Text, "what it is called, for people"),
        Key::optional("source", Kind::Text, "where it came from, for people"),
        Key::optional(
            "weights",
            ROWS,
            "rows of numbers, row 0 to the north; rows and columns are odd in number",
        )
        .example("weights = [[0, -1, 0], [-1, 4, -1], [0, -1, 0]]"),
        Key::optional(
            "centre-surround",
            Kind::Whole {
                least: 0,
                most: i64::MAX as u64,
            },
            "side of a square whose centre is 1 and whose other weights are equal and sum to -1",
        )
        .unit("px")
        .example("centre-surround = 5"),
        Key::optional(
            "gaussians",
            Kind::list(&Kind::Table(&GAUSSIAN)),
            "a sum of Gaussians, each cut at 3 sigma and normalised before its gain",
        )
        .example("gaussians = [{ sigma = 1, gain = 1 }, { sigma = 2, gain = -1 }]"),
    ],
};

const GAUSSIAN: Table = Table::new(&[
    Key::required(
        "sigma",
        Kind::Number(Range {
            above: true,
            ..Range::between(0.0, 20.0)
        }),
        "its standard deviation",
    )
    .unit("px")
    .example("sigma = 1"),
    Key::required("gain", Kind::Number(Range::FREE), "the sum of its weights").example("gain = 1"),
]);

impl KernelFileError {
    /// What is wrong, with the file that it is wrong with.
    #[must_use]
    pub fn in_file(&self, name: &str) -> String {
        match self {
            Self::Wrong(faults) => faults.to_string(),
            other => format!("{name}: {other}"),
        }
    }
}

impl Kernel {
    /// Reads a kernel file's text; `name` is for messages.
    ///
    /// # Errors
    /// When the text is not a kernel file, or what it says is not a kernel.
    pub fn from_toml(name: &str, text: &str) -> Result<Self, KernelFileError> {
        let kernel = FILE.read(name, text, |root| {
            let file = Section::new(root, &KERNEL);
            let wrong = |key: &str, what: String| {
                Fault::error(file.place_of(key), what, "here").help(FILE.see)
            };
            if let Some(rows) = file.get("weights") {
                let rows = rows.as_rows().unwrap_or_default();
                return Self::from_rows(&rows).map_err(|e| wrong("weights", e.to_string()));
            }
            if let Some(side) = file.maybe_whole("centre-surround") {
                let side = usize::try_from(side).unwrap_or(usize::MAX);
                let made = Self::centre_surround(side);
                return made.map_err(|e| wrong("centre-surround", e.to_string()));
            }
            let part = |part: &Section<'_>| {
                let (sigma, gain) = (part.number("sigma")?, part.number("gain")?);
                Ok(Gaussian { sigma, gain })
            };
            let parts = file.tables("gaussians");
            let parts = parts.iter().map(part).collect::<Read<Vec<_>>>()?;
            Kernel::from_gaussians(&parts).map_err(|e| wrong("gaussians", e.to_string()))
        })?;
        Ok(kernel)
    }

    /// Reads a kernel file as it comes from the disk, TOML or `.npy`; `name` tells which where
    /// the bytes do not, and is told in messages.
    ///
    /// # Errors
    /// As [`Kernel::from_toml`] and [`Kernel::from_npy`], and when it is neither.
    pub fn from_bytes(name: &str, bytes: &[u8]) -> Result<Self, KernelFileError> {
        let array = Path::new(name).extension().is_some_and(|e| e == "npy");
        if array || bytes.starts_with(npy::MAGIC) {
            return Self::from_npy(bytes);
        }
        let text = std::str::from_utf8(bytes).map_err(|_| KernelFileError::NotText)?;
        Self::from_toml(name, text)
    }

    /// Reads a `.npy` array of shape (rows, columns), row 0 north.
    ///
    /// # Errors
    /// When it is not such an array of floats or integers, or is not a kernel.
    pub fn from_npy(bytes: &[u8]) -> Result<Self, KernelFileError> {
        let array = weights(bytes).map_err(|error| KernelFileError::Array(error.to_string()))?;
        let &[rows, columns] = array.shape.as_slice() else {
            let shape: Vec<String> = array.shape.iter().map(usize::to_string).collect();
            return Err(KernelFileError::Array(format!(
                "it has shape ({}); one kernel has two axes, rows and columns",
                shape.join(",")
            )));
        };
        let weights = Plane::from_shape_vec((rows, columns), array.values);
        Ok(Self::new(weights.map_err(|error| {
            KernelFileError::Array(error.to_string())
        })?)?)
    }

    /// Reads a `.npy` array of shape (kernels, rows, columns), or (kernels, 1, rows, columns) as
    /// `PyTorch` has it; `None` when it is none.
    fn planes_from_npy(bytes: &[u8]) -> Option<Vec<Plane<f64>>> {
        let array = weights(bytes).ok()?;
        let (&[_, rows, columns] | &[_, 1, rows, columns]) = array.shape.as_slice() else {
            return None;
        };
        // No weights can be any number of kernels.
        if array.values.is_empty() {
            return Some(Vec::new());
        }
        let planes = array.values.chunks_exact(rows * columns);
        planes
            .map(|plane| Plane::from_shape_vec((rows, columns), plane.to_vec()).ok())
            .collect()
    }

    /// The kernels of a file called `name` that is an array of several; `None` where it is none.
    ///
    /// # Errors
    /// What is wrong with the array, and what to do: there are too many of them, or one is no
    /// kernel.
    #[must_use]
    pub fn several_from_npy(
        name: &str,
        bytes: &[u8],
    ) -> Option<Result<Vec<Self>, (String, &'static str)>> {
        // A kernel of one plane is no array of several.
        if !bytes.starts_with(npy::MAGIC) || Self::from_npy(bytes).is_ok() {
            return None;
        }
        let planes = Self::planes_from_npy(bytes)?;
        let shape = weights(bytes).map_or_else(|_| Vec::new(), |array| array.shape);
        if planes.is_empty() && shape.first().is_some_and(|kernels| *kernels > 0) {
            let sides: Vec<String> = shape.iter().map(ToString::to_string).collect();
            let what = format!(
                "{name}: an array of shape ({}) has no weights",
                sides.join(",")
            );
            return Some(Err((what, SHAPES)));
        }
        if planes.is_empty() || planes.len() > KERNELS {
            let what = format!("{name}: {}", wrong_number(planes.len()));
            return Some(Err((what, FEWER)));
        }
        let kernels = (0..).zip(planes).map(|(i, plane)| {
            Self::new(plane).map_err(|e| (format!("{name}, kernel {i}: {e}"), SHAPES))
        });
        Some(kernels.collect())
    }

    /// Centre 1 and a surround of equal weights that sum to -1, `side` by `side`.
    ///
    /// # Errors
    /// When `side` is even, or below 3.
    pub fn centre_surround(side: usize) -> Result<Self, KernelFileError> {
        if side < 3 {
            return Err(KernelFileError::Parameter(format!(
                "centre-surround must be an odd side of 3 or more, it is {side}"
            )));
        }
        if side > KERNEL_SIDE {
            return Err(KernelError::Size {
                height: side,
                width: side,
            }
            .into());
        }
        let others = -1.0 / ((side * side - 1) as f64);
        let mut weights = Plane::from_elem((side, side), others);
        weights[[side / 2, side / 2]] = 1.0;
        Ok(Self::new(weights)?)
    }
}

/// The numbers of an array; truth values are no weights.
fn weights(bytes: &[u8]) -> Result<npy::Array, npy::ArrayError> {
    let array = npy::Array::read(bytes)?;
    if array.number.kind == npy::Kind::B1 {
        return Err(npy::ArrayError::Type("truth values".to_owned()));
    }
    Ok(array)
}

/// Each Gaussian is cut at `int(6 sigma) + 1` (made odd) and normalised to sum 1 before its
/// gain, as in the released Neural Ganglion Sensors simulator.
#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formulas_have_the_sums_they_promise() {
        let cs = Kernel::from_toml("k", "centre-surround = 5").unwrap();
        assert!(cs.sum().abs() < 1e-15);
        let dog = Kernel::from_toml(
            "k",
            "gaussians = [{ sigma = 1, gain = 1.3 }, { sigma = 2, gain = -0.9 }]",
        )
        .unwrap();
        assert_eq!(dog.weights().dim(), (13, 13));
        assert!((dog.sum() - 0.4).abs() < 1e-12);
    }

    #[test]
    fn one_way_only() {
        let said = |text: &str| Kernel::from_toml("k.toml", text).unwrap_err().to_string();
        let ways = "`weights`, `centre-surround`, `gaussians`";
        assert_eq!(said(""), format!("k.toml:1:1: missing key {ways}"));
        let both = said("weights = [[1]]\ncentre-surround = 3");
        assert_eq!(both, format!("k.toml:2:1: only one of {ways} can be given"));
        assert!(said("dog = 3").starts_with("k.toml:1:1: unknown key `dog`"));
        let sigma = said("gaussians = [{ sigma = 30, gain = 1 }]");
        assert_eq!(sigma, "k.toml:1:24: `sigma` is 30");
    }

    fn npy<T: ndarray_npy::WritableElement>(array: &ndarray::ArrayD<T>) -> Vec<u8> {
        let mut bytes = Vec::new();
        ndarray_npy::WriteNpyExt::write_npy(array, &mut bytes).unwrap();
        bytes
    }

    #[test]
    fn arrays_are_kernels() {
        let rows = ndarray::arr2(&[[0.0, -1.0, 0.5], [1.0, 4.0, 2.0], [0.0, 3.0, -9.0]]).into_dyn();
        let want =
            Kernel::from_toml("k", "weights = [[0, -1, 0.5], [1, 4, 2], [0, 3, -9]]").unwrap();
        assert_eq!(Kernel::from_npy(&npy(&rows)).unwrap(), want);
        let single = rows.mapv(|w| w as f32);
        assert_eq!(Kernel::from_npy(&npy(&single)).unwrap(), want);
        // Column by column, as numpy stores a transposed array.
        let columns = rows.t().as_standard_layout().to_owned();
        let columns = columns.t().to_owned();
        assert_eq!(Kernel::from_npy(&npy(&columns)).unwrap(), want);
        let whole = ndarray::arr2(&[[2i64]]).into_dyn();
        assert_eq!(
            Kernel::from_npy(&npy(&whole)).unwrap(),
            Kernel::from_rows(&[vec![2.0]]).unwrap()
        );
    }

    #[test]
    fn several_kernels_come_with_or_without_an_axis_of_inputs() {
        let flat = npy(&ndarray::ArrayD::<f64>::ones(vec![2, 3, 3]));
        let torch = npy(&ndarray::ArrayD::<f64>::ones(vec![2, 1, 3, 3]));
        let planes = Kernel::planes_from_npy(&torch).unwrap();
        assert_eq!(planes.len(), 2);
        assert_eq!(Some(planes), Kernel::planes_from_npy(&flat));
        let inputs = npy(&ndarray::ArrayD::<f64>::ones(vec![2, 3, 3, 3]));
        assert!(Kernel::planes_from_npy(&inputs).is_none());
    }

    #[test]
    fn bad_arrays_are_refused() {
        let message = |bytes: &[u8]| Kernel::from_npy(bytes).unwrap_err().to_string();
        let good = npy(&ndarray::arr2(&[[1.0; 3]; 3]).into_dyn());
        assert!(message(&good[..good.len() - 1]).contains("missing"));
        for cut in 0..good.len() {
            message(&good[..cut]);
        }
        let deep = npy(&ndarray::ArrayD::<f64>::zeros(vec![1, 1, 3, 3]));
        assert!(message(&deep).contains("it has shape (1,1,3,3)"));
        let bools = npy(&ndarray::arr2(&[[true]]).into_dyn());
        assert!(message(&bools).contains("floats or integers"));
        let even = npy(&ndarray::arr2(&[[1.0; 2]; 3]).into_dyn());
        assert!(message(&even).contains("must be odd"));
        let mut absurd = good.clone();
        absurd[6] = 2;
        absurd[8..12].fill(0xff);
        assert!(message(&absurd).contains("header"));
    }
}
