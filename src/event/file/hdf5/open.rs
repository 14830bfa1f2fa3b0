//! An HDF5 file opened, and what may be wrong with one of its data sets.

use hdf5_pure::{AttrValue, Dataset, Error, File, FormatError};

use super::super::{Fault, Format, Place, fault::Stop, origin::Origin};

/// What to do about a filter that is not read.
const UNPACK: &str = "unpack it first: `h5repack -f NONE IN.h5 OUT.h5`";

/// Where the events of a layout that is not read are, and whose it is.
const OTHERS: [(&str, &str); 1] = [("CD/events", "Prophesee")];

pub fn wrong(why: impl Into<String>) -> Stop {
    Stop::layout(Format::Hdf5, 0, why)
}

/// What HDF5 itself says of a file that it cannot read.
#[expect(clippy::needless_pass_by_value, reason = "it maps errors")]
pub fn unreadable(why: Error) -> Stop {
    wrong(format!("cannot be read: {why}"))
}

/// Opens the file.
pub fn open(origin: &Origin) -> Result<File, Stop> {
    match origin {
        Origin::File(path) => File::open_streaming(path),
        Origin::Memory(bytes) => File::from_bytes(bytes.to_vec()),
    }
    .map_err(unreadable)
}

/// A column, whose first value can be unpacked.
pub fn column(file: &File, path: &str) -> Result<Dataset, Stop> {
    let column = file.dataset(path).map_err(|e| missing(file, path, &e))?;
    let rows = column.shape().map_err(unreadable)?.first().copied();
    // Damage comes later; a filter or a layout that is not known is none.
    if rows.is_some_and(|rows| rows > 0)
        && let Err(e) = column.read_raw_rows(0, 1)
        && let Error::Format(
            FormatError::UnsupportedFilter(_) | FormatError::InvalidLayoutVersion(_),
        ) = e
    {
        let (column, why) = (path.to_owned(), e.to_string());
        let way = UNPACK;
        let fault = Fault::Compressed { column, why, way };
        return Err(Stop::Fault(Place::Event(0), fault));
    }
    Ok(column)
}

/// The length of a column, which has one dimension and is as long as those before it.
pub fn length(column: &Dataset, name: &str, before: &mut Option<u64>) -> Result<(), Stop> {
    let shape = column.shape().map_err(unreadable)?;
    let [length] = shape[..] else {
        return Err(wrong(format!("has `{name}` of {} dimensions", shape.len())));
    };
    if *before.get_or_insert(length) == length {
        return Ok(());
    }
    Err(wrong("has columns of different lengths"))
}

/// Why a column is not there: the file was cut, or is laid out in another way.
fn missing(file: &File, path: &str, why: &Error) -> Stop {
    if let Error::Format(FormatError::UnexpectedEof {
        expected,
        available,
    }) = why
        && *available as u64 == file.file_size()
    {
        let inside = format!("at least {expected} bytes");
        return Stop::Fault(Place::Byte(*available as u64), Fault::Truncated { inside });
    }
    let mut others = OTHERS.iter();
    let found = match others.find(|(path, _)| file.dataset(path).is_ok()) {
        Some((path, whose)) => format!("it has `{path}`, as files of {whose} do"),
        None => why.to_string(),
    };
    let (column, why) = (path.to_owned(), found);
    Stop::Fault(Place::Byte(0), Fault::Column { column, why })
}

/// The whole numbers of an attribute of the file; nothing where it has none of this name.
pub fn attribute(file: &File, name: &str) -> Result<Option<Vec<i64>>, Stop> {
    let attributes = file.root().attrs().map_err(unreadable)?;
    let Some(value) = attributes.get(name) else {
        return Ok(None);
    };
    let numbers = whole(value);
    let numbers =
        numbers.ok_or_else(|| wrong(format!("has an attribute `{name}` of no whole numbers")))?;
    Ok(Some(numbers))
}

/// The whole numbers that an attribute has, whatever their type.
fn whole(value: &AttrValue) -> Option<Vec<i64>> {
    fn all<T: Copy + TryInto<i64>>(values: &[T]) -> Option<Vec<i64>> {
        values
            .iter()
            .map(|value| (*value).try_into().ok())
            .collect()
    }
    let real = |values: &[f64]| {
        let whole = |value: &f64| value.fract() == 0.0 && value.abs() < 2_f64.powi(53);
        let each = values
            .iter()
            .map(|value| whole(value).then_some(*value as i64));
        each.collect()
    };
    match value {
        AttrValue::I8(value) => all(&[*value]),
        AttrValue::I16(value) => all(&[*value]),
        AttrValue::I32(value) => all(&[*value]),
        AttrValue::I64(value) => all(&[*value]),
        AttrValue::U8(value) => all(&[*value]),
        AttrValue::U16(value) => all(&[*value]),
        AttrValue::U32(value) => all(&[*value]),
        AttrValue::U64(value) => all(&[*value]),
        AttrValue::F32(value) => real(&[f64::from(*value)]),
        AttrValue::F64(value) => real(&[*value]),
        AttrValue::I8Array(values) => all(values),
        AttrValue::I16Array(values) => all(values),
        AttrValue::I32Array(values) => all(values),
        AttrValue::I64Array(values) => all(values),
        AttrValue::U8Array(values) => all(values),
        AttrValue::U16Array(values) => all(values),
        AttrValue::U32Array(values) => all(values),
        AttrValue::U64Array(values) => all(values),
        AttrValue::F32Array(values) => {
            let values: Vec<f64> = values.iter().copied().map(f64::from).collect();
            real(&values)
        }
        AttrValue::F64Array(values) => real(values),
        _ => None,
    }
}
