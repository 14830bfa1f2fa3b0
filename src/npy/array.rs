//! Arrays that fit in memory.

use std::io::{self, Write};

use super::{Element, Header, HeaderError, Number, framed};

/// Bytes that are written at once.
const BLOCK: usize = 1 << 16;

/// An array of plain numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// How its numbers were stored.
    pub number: Number,
    /// Numbers along each axis.
    pub shape: Vec<usize>,
    /// The numbers, the last axis running fastest. Whole numbers that no `f64` equals are rounded.
    pub values: Vec<f64>,
}

/// A file that is no array of plain numbers.
#[derive(Debug, thiserror::Error)]
pub enum ArrayError {
    /// Its header cannot be read.
    #[error(transparent)]
    Header(#[from] HeaderError),
    /// Numbers of another type.
    #[error(
        "its numbers are {0}; expected floats or integers (of others, such as bfloat16, `array.astype('float32')` makes them)"
    )]
    Type(String),
    /// More numbers than any file has.
    #[error("its header promises an array of shape {shape:?}, the file has {bytes} bytes")]
    Shape {
        /// What the header says.
        shape: Vec<u64>,
        /// The file's bytes.
        bytes: usize,
    },
    /// Too few numbers.
    #[error("missing {0} bytes of data specified in header")]
    Missing(usize),
    /// Too many numbers.
    #[error("it has {0} bytes after its last number")]
    Trailing(usize),
}

impl Array {
    /// The array in the bytes of a file.
    ///
    /// # Errors
    /// When they are not those of an array of floats, whole numbers or truth values.
    pub fn read(bytes: &[u8]) -> Result<Self, ArrayError> {
        let mut rest = bytes;
        let (header, _) = Header::read(&mut rest)?;
        let Some(number) = Number::named(&header.descr) else {
            return Err(ArrayError::Type(header.descr));
        };
        let wrong = || ArrayError::Shape {
            shape: header.shape.clone(),
            bytes: bytes.len(),
        };
        let axes: Option<Vec<usize>> = { header.shape.iter() }
            .map(|n| usize::try_from(*n).ok())
            .collect();
        let shape = axes.ok_or_else(wrong)?;
        // Axes of no length promise nothing, whatever the others say.
        let product = |n: usize, axis: &usize| n.checked_mul((*axis).max(1));
        let most = shape.iter().try_fold(number.bytes(), product);
        let most = most.ok_or_else(wrong)?;
        let want = if shape.contains(&0) { 0 } else { most };
        if rest.len() < want {
            // Before room is made for what the header says.
            return Err(if want / number.bytes() > bytes.len() {
                wrong()
            } else {
                ArrayError::Missing(want - rest.len())
            });
        }
        if rest.len() > want {
            return Err(ArrayError::Trailing(rest.len() - want));
        }
        let stored = rest.chunks_exact(number.bytes());
        let values: Vec<f64> = stored.map(|bytes| number.read(bytes).nearest()).collect();
        Ok(Self {
            number,
            values: if header.fortran {
                last_axis_first(&shape, &values)
            } else {
                values
            },
            shape,
        })
    }
}

/// The numbers of an array whose first axis runs fastest, in the order in which the last one does.
fn last_axis_first(shape: &[usize], values: &[f64]) -> Vec<f64> {
    let mut places = vec![0_usize];
    let mut stride = values.len();
    for axis in shape.iter().rev() {
        stride /= (*axis).max(1);
        let steps = (0..*axis).map(|n| n * stride);
        // Axes that were taken before run faster.
        places = steps
            .flat_map(|step| places.iter().map(move |place| step + place))
            .collect();
    }
    { places.iter() }
        .filter_map(|place| values.get(*place).copied())
        .collect()
}

/// Writes an array, the last axis running fastest.
///
/// # Errors
/// When it cannot be written, or there are more or fewer numbers than the shape says.
pub fn write<T: Element>(
    out: &mut (impl Write + ?Sized),
    shape: &[usize],
    values: impl ExactSizeIterator<Item = T>,
) -> io::Result<()> {
    let count = shape
        .iter()
        .fold(1, |n: usize, side| n.saturating_mul(*side));
    if values.len() != count {
        let why = format!(
            "{} numbers, and an array of shape {shape:?} has {count}",
            values.len()
        );
        return Err(io::Error::new(io::ErrorKind::InvalidInput, why));
    }
    let axes: Vec<_> = shape.iter().map(usize::to_string).collect();
    let comma = if axes.len() == 1 { "," } else { "" };
    let text = format!(
        "{{'descr': '{}', 'fortran_order': False, 'shape': ({}{comma})}}",
        T::DESCRIPTION,
        axes.join(", ")
    );
    let mut bytes = framed(&text, 0)?;
    for value in values {
        if bytes.len() >= BLOCK {
            out.write_all(&bytes)?;
            bytes.clear();
        }
        bytes.extend(value.bytes().as_ref());
    }
    out.write_all(&bytes)
}

#[cfg(test)]
mod tests {
    use ndarray_npy::WriteNpyExt;

    use super::*;
    use crate::npy::Kind;

    fn other<T: ndarray_npy::WritableElement>(array: &ndarray::ArrayD<T>) -> Vec<u8> {
        let mut bytes = Vec::new();
        array.write_npy(&mut bytes).unwrap();
        bytes
    }

    /// What `ndarray-npy` writes is read, rows or columns first, and the same bytes are written.
    #[test]
    fn another_writer_says_the_same() {
        let numbers = ndarray::Array::from_iter((0..24).map(|n| f64::from(n) - 7.5));
        let array = numbers.into_shape_with_order((2, 3, 4)).unwrap();
        let values: Vec<f64> = array.iter().copied().collect();
        let bytes = other(&array.clone().into_dyn());
        let read = Array::read(&bytes).unwrap();
        assert_eq!((&read.shape[..], &read.values), (&[2, 3, 4][..], &values));
        assert_eq!(read.number.kind, Kind::F8);
        let mut own = Vec::new();
        write(&mut own, &[2, 3, 4], values.iter().copied()).unwrap();
        assert_eq!(own, bytes);
        let mut line = Vec::new();
        write(&mut line, &[3], [1_u8, 2, 255].into_iter()).unwrap();
        assert_eq!(line, other(&ndarray::arr1(&[1_u8, 2, 255]).into_dyn()));
        // A transposed array is written with its first axis running fastest.
        let columns = array.t().to_owned().into_dyn();
        let columns = columns.as_standard_layout().reversed_axes();
        let bytes = other(&columns.to_owned());
        assert!(String::from_utf8_lossy(&bytes).contains("'fortran_order': True"));
        let read = Array::read(&bytes).unwrap();
        assert_eq!((&read.shape[..], &read.values), (&[2, 3, 4][..], &values));
    }

    #[test]
    fn what_the_header_promises_must_be_there() {
        let said = |bytes: &[u8]| Array::read(bytes).unwrap_err().to_string();
        let good = other(&ndarray::arr2(&[[1.0, 2.0]]).into_dyn());
        for cut in 0..good.len() {
            said(&good[..cut]);
        }
        assert!(said(&good[..good.len() - 3]).contains("missing 3 bytes"));
        assert!(said(&[&good[..], b"xy"].concat()).contains("2 bytes after"));
        let lie = |shape: &str| {
            let text = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}}}");
            said(&framed(&text, 0).unwrap())
        };
        assert!(lie("(1099511627776, 1048576)").contains("promises an array of shape"));
        assert!(lie("(18446744073709551615, 2, 0)").contains("promises an array of shape"));
        assert!(lie("(1000, 1000)").contains("promises an array of shape"));
        let complex = "{'descr': '<c8', 'fortran_order': False, 'shape': (1,)}";
        assert!(said(&framed(complex, 0).unwrap()).contains("numbers are <c8"));
        let truth = other(&ndarray::arr1(&[true, false]).into_dyn());
        assert_eq!(Array::read(&truth).unwrap().values, [1.0, 0.0]);
    }
}
