//! What the numbers of a column stand for.

use parquet::{
    basic::{ConvertedType, LogicalType, TimeUnit},
    schema::types::ColumnDescriptor,
};

/// Whether the numbers of a column have no sign; the error says what they are, where they are no
/// whole numbers or microseconds.
pub fn is_unsigned(column: &ColumnDescriptor) -> Result<bool, &'static str> {
    let unit = match column.logical_type_ref() {
        Some(LogicalType::Integer(of)) => return Ok(!of.is_signed),
        Some(LogicalType::Timestamp(of) | LogicalType::Time(of)) => Some(&of.unit),
        _ => None,
    };
    match (unit, column.converted_type()) {
        (Some(TimeUnit::MILLIS), _)
        | (None, ConvertedType::TIMESTAMP_MILLIS | ConvertedType::TIME_MILLIS) => {
            Err("milliseconds")
        }
        (Some(TimeUnit::NANOS), _) => Err("nanoseconds"),
        (None, kind) => Ok(matches!(
            kind,
            ConvertedType::UINT_8
                | ConvertedType::UINT_16
                | ConvertedType::UINT_32
                | ConvertedType::UINT_64
        )),
        _ => Ok(false),
    }
}
