//! The results as Parquet: a column each, none where a cell is empty.

use std::{
    fmt::Write as _,
    io::{self, Write},
};

use parquet::{
    basic::{Compression, ZstdLevel},
    column::writer::ColumnWriter,
    data_type::ByteArray,
    errors::Result as ParquetResult,
    file::{properties::WriterProperties, writer::SerializedFileWriter},
    schema::parser::parse_message_type,
};

use super::table::{self, Holds, Row};

/// Writes the rows.
pub(in crate::study::sweep) fn write(
    out: &mut dyn Write,
    columns: &[String],
    rows: &[Row],
) -> io::Result<()> {
    let bytes = encode(columns, rows).map_err(io::Error::other)?;
    out.write_all(&bytes)
}

fn encode(columns: &[String], rows: &[Row]) -> ParquetResult<Vec<u8>> {
    let mut schema = String::from("message sweep {");
    for name in columns {
        let (holds, means) = match table::holds(name) {
            Holds::Text => ("binary", " (UTF8)"),
            Holds::Whole => ("int64", ""),
            Holds::Real => ("double", ""),
        };
        let _ = write!(schema, " optional {holds} {name}{means};");
    }
    let schema = parse_message_type(&(schema + " }"))?;
    let properties = WriterProperties::builder()
        .set_compression(Compression::ZSTD(ZstdLevel::default()))
        .build();
    let mut file = SerializedFileWriter::new(Vec::new(), schema.into(), properties.into())?;
    let mut group = file.next_row_group()?;
    let mut names = columns.iter();
    while let (Some(mut column), Some(name)) = (group.next_column()?, names.next()) {
        let cells = || {
            rows.iter()
                .map(|row| row.get(name).filter(|cell| !cell.is_null()))
        };
        let there: Vec<i16> = cells().map(|cell| cell.is_some().into()).collect();
        match column.untyped() {
            ColumnWriter::ByteArrayColumnWriter(writer) => {
                let all: Vec<ByteArray> = cells()
                    .flatten()
                    .map(|cell| cell.as_str().unwrap_or_default().into())
                    .collect();
                writer.write_batch(&all, Some(&there), None)?;
            }
            ColumnWriter::Int64ColumnWriter(writer) => {
                let all: Vec<i64> = cells()
                    .flatten()
                    .map(|cell| cell.as_i64().unwrap_or_default())
                    .collect();
                writer.write_batch(&all, Some(&there), None)?;
            }
            ColumnWriter::DoubleColumnWriter(writer) => {
                let all: Vec<f64> = cells()
                    .flatten()
                    .map(|cell| cell.as_f64().unwrap_or_default())
                    .collect();
                writer.write_batch(&all, Some(&there), None)?;
            }
            _ => {}
        }
        column.close()?;
    }
    group.close()?;
    file.into_inner()
}
