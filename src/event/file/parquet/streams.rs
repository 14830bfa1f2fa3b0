//! Reader and writer of event files in Parquet.

use std::{
    fs::File,
    io::{self, Seek, SeekFrom},
    sync::Arc,
};

use bytes::Bytes;
use parquet::{
    basic::{Compression, ZstdLevel},
    column::{
        page::{Page, PageMetadata, PageReader},
        reader::{ColumnReader, get_column_reader},
        writer::ColumnWriter,
    },
    errors::{ParquetError, Result as ParquetResult},
    file::{
        metadata::{KeyValue, RowGroupMetaData},
        properties::WriterProperties,
        reader::{FileReader, SerializedFileReader},
        writer::SerializedFileWriter,
    },
    schema::parser::parse_message_type,
};

use super::{
    super::{
        Fault, Format, Place,
        about::About,
        columns::{self, COLUMNS, OTHERS},
        fault::Stop,
        gate::Raw,
        head::Head,
        origin::Origin,
        source::{BLOCK, Out, Sink, Source},
    },
    kind,
};
use crate::{catch_panic, event::Event};

/// Events of a row group.
const GROUP: usize = 1 << 20;

fn wrong(why: impl Into<String>) -> Stop {
    Stop::layout(Format::Parquet, 0, why)
}

/// Calls the crate, and turns its panics on damaged files into errors.
fn guarded<T>(work: impl FnOnce() -> ParquetResult<T>) -> Result<T, Stop> {
    match catch_panic::catch_ok(work) {
        Some(Ok(done)) => Ok(done),
        Some(Err(e)) => Err(wrong(format!("cannot be read: {e}"))),
        None => Err(wrong("cannot be read: it contradicts itself")),
    }
}

/// Opens the columns of a row group, after checking that their places make sense.
fn opened(
    file: &dyn FileReader,
    group: usize,
    columns: &[(usize, bool)],
) -> ParquetResult<(u64, Vec<ColumnReader>)> {
    let group = file.get_row_group(group)?;
    let mut open = Vec::new();
    for (number, _) in columns {
        let column = group.metadata().column(*number);
        let places = [
            column.compressed_size(),
            column.data_page_offset(),
            column.dictionary_page_offset().unwrap_or(0),
        ];
        if places.iter().any(|place| *place < 0) {
            let why = "a column lies before the start of the file";
            return Err(ParquetError::General(why.into()));
        }
        let pages = Pages(group.get_column_page_reader(*number)?);
        open.push(get_column_reader(
            column.column_descr_ptr(),
            Box::new(pages),
        ));
    }
    let rows = u64::try_from(group.metadata().num_rows()).unwrap_or(0);
    Ok((rows, open))
}

/// Pages of a column. The crate allocates as many values as a dictionary claims, which in a damaged
/// file may be billions; here there are at most as many as bytes.
struct Pages(Box<dyn PageReader>);

impl Iterator for Pages {
    type Item = ParquetResult<Page>;

    fn next(&mut self) -> Option<Self::Item> {
        self.get_next_page().transpose()
    }
}

impl PageReader for Pages {
    fn get_next_page(&mut self) -> ParquetResult<Option<Page>> {
        let page = self.0.get_next_page()?;
        if let Some(Page::DictionaryPage {
            buf, num_values, ..
        }) = &page
            && *num_values as usize > buf.len()
        {
            let why = "a dictionary is said to have more values than bytes";
            return Err(ParquetError::General(why.into()));
        }
        Ok(page)
    }

    fn peek_next_page(&mut self) -> ParquetResult<Option<PageMetadata>> {
        self.0.peek_next_page()
    }

    fn skip_next_page(&mut self) -> ParquetResult<()> {
        self.0.skip_next_page()
    }

    fn at_record_boundary(&mut self) -> ParquetResult<bool> {
        self.0.at_record_boundary()
    }
}

/// Opens a file's stream of events.
pub(super) fn source(origin: &Origin) -> Result<Reading, Stop> {
    let file: Box<dyn FileReader> = match origin {
        Origin::File(path) => {
            let file = File::open(path)?;
            Box::new(guarded(|| SerializedFileReader::new(file))?)
        }
        Origin::Memory(bytes) => {
            let bytes = Bytes::copy_from_slice(bytes);
            Box::new(guarded(|| SerializedFileReader::new(bytes))?)
        }
    };
    let schema = file.metadata().file_metadata().schema_descr_ptr();
    let place = |name: &str| {
        let mut columns = schema.columns().iter();
        columns.position(|column| column.path().string() == name)
    };
    let mut columns = Vec::new();
    for name in COLUMNS {
        match place(name) {
            Some(column) => {
                let unsigned = kind::is_unsigned(&schema.column(column)).map_err(|unit| {
                    wrong(format!(
                        "has a column `{name}` in {unit}: let it be whole microseconds"
                    ))
                })?;
                columns.push((column, unsigned));
            }
            None if name == "channel" => (),
            None => return Err(wrong(format!("has no column `{name}`"))),
        }
    }
    let keys = file.metadata().file_metadata().key_value_metadata();
    let comment = keys.and_then(|keys| {
        let key = keys.iter().find(|key| key.key == "amacrine")?;
        key.value.clone()
    });
    let about = columns::about(comment.as_deref(), columns.len())?;
    hold_rows(&*file)?;
    check_compression(&*file, &columns)?;
    Ok(Reading {
        others: schema.num_columns() > columns.len(),
        file,
        columns,
        about,
        group: 0,
        left: 0,
        open: Vec::new(),
        read: 0,
        first: 0,
    })
}

/// Refuses columns that are packed as this program cannot unpack.
fn check_compression(file: &dyn FileReader, columns: &[(usize, bool)]) -> Result<(), Stop> {
    let all = |group| columns.iter().map(move |(number, _)| (group, *number));
    for (group, number) in file.metadata().row_groups().iter().flat_map(all) {
        let group: &RowGroupMetaData = group;
        let column = group.column(number);
        let packed = column.compression();
        let name = format!("{packed:?}");
        if !matches!(
            packed,
            Compression::UNCOMPRESSED | Compression::SNAPPY | Compression::ZSTD(_)
        ) {
            let fault = Fault::Compressed {
                column: column.column_path().string(),
                why: format!(
                    "its compression is {}; ZSTD, SNAPPY and none are read",
                    name.split('(').next().unwrap_or_default()
                ),
                way: "write it again with compression=\"zstd\"",
            };
            return Err(Stop::Fault(Place::Event(0), fault));
        }
    }
    Ok(())
}

/// Cross-checks the row counts of a file, of its row groups and of their columns.
fn hold_rows(file: &dyn FileReader) -> Result<(), Stop> {
    let stated = file.metadata().file_metadata().num_rows();
    let mut sum = 0_i64;
    for (number, group) in file.metadata().row_groups().iter().enumerate() {
        let rows = group.num_rows();
        sum = sum.saturating_add(rows);
        for column in group.columns() {
            // A column of lists has more values than rows.
            let flat = column.column_descr().max_rep_level() == 0;
            if flat && column.num_values() != rows {
                let one = format!(
                    "row group {number} says that it has {}",
                    crate::unit::counted(rows, "row")
                );
                let (name, values) = (column.column_path(), column.num_values());
                let other = format!(
                    "its column {name} has {}",
                    crate::unit::counted(values, "value")
                );
                return Err(Stop::twice(Format::Parquet, 0, one, other));
            }
        }
    }
    if sum != stated {
        let one = format!(
            "its footer says that it has {}",
            crate::unit::counted(stated, "row")
        );
        return Err(Stop::twice(
            Format::Parquet,
            0,
            one,
            format!("its row groups have {sum}"),
        ));
    }
    Ok(())
}

/// Reads the columns side by side.
pub(super) struct Reading {
    file: Box<dyn FileReader>,
    /// Numbers of these columns in the file.
    /// Their numbers, and whether theirs have no sign.
    columns: Vec<(usize, bool)>,
    about: About,
    /// The next row group, rows left of this one, and its columns.
    group: usize,
    left: u64,
    open: Vec<ColumnReader>,
    /// Whether there are other columns.
    others: bool,
    read: u64,
    first: u64,
}

/// Reads `count` integers of a column.
fn integers(column: &mut ColumnReader, unsigned: bool, count: usize) -> ParquetResult<Vec<i128>> {
    /// What a column of one type gives.
    macro_rules! read {
        ($column:expr, $number:expr) => {{
            let mut values = Vec::with_capacity(count);
            let mut levels = Vec::new();
            while values.len() < count {
                let want = count - values.len();
                let (rows, _, _) =
                    $column.read_records(want, Some(&mut levels), None, &mut values)?;
                if rows == 0 {
                    break;
                }
            }
            values.into_iter().map($number).collect()
        }};
    }
    Ok(match column {
        ColumnReader::BoolColumnReader(column) => read!(column, i128::from),
        ColumnReader::Int32ColumnReader(column) if unsigned => {
            read!(column, |value| i128::from(value.cast_unsigned()))
        }
        ColumnReader::Int64ColumnReader(column) if unsigned => {
            read!(column, |value| i128::from(value.cast_unsigned()))
        }
        ColumnReader::Int32ColumnReader(column) => read!(column, i128::from),
        ColumnReader::Int64ColumnReader(column) => read!(column, i128::from),
        _ => return Err(ParquetError::General("a column is not of integers".into())),
    })
}

impl Source for Reading {
    fn about(&self) -> About {
        self.about.clone()
    }

    fn fill(&mut self, events: &mut Vec<Event>) -> Result<bool, Stop> {
        self.first = self.read;
        while self.left == 0 {
            // No values behind those of the last row.
            for (column, name) in self.open.iter_mut().zip(COLUMNS) {
                if !guarded(|| integers(column, false, 1))?.is_empty() {
                    let one = format!("row group {} says how many rows it has", self.group - 1);
                    let fault = Fault::twice(
                        Format::Parquet,
                        one,
                        format!("its pages of `{name}` have more"),
                    );
                    return Err(Stop::Fault(Place::Event(self.read), fault));
                }
            }
            self.open.clear();
            if self.group == self.file.num_row_groups() {
                return Ok(false);
            }
            let opened = guarded(|| opened(&*self.file, self.group, &self.columns))?;
            (self.left, self.open) = opened;
            self.group += 1;
        }
        let count = self.left.min(BLOCK as u64) as usize;
        let mut columns = Vec::new();
        let signs = self.columns.iter().map(|(_, unsigned)| *unsigned);
        for ((column, name), unsigned) in self.open.iter_mut().zip(COLUMNS).zip(signs) {
            let values = guarded(|| integers(column, unsigned, count))?;
            if values.len() != count {
                return Err(wrong(format!(
                    "has a column `{name}` with missing values, or that ends early"
                )));
            }
            columns.push(values);
        }
        for i in 0..count {
            let value = |n: usize| Ok(columns.get(n).map_or(0, |c: &Vec<i128>| c[i]));
            let event = columns::raw(value)
                .and_then(Raw::event)
                .map_err(|fault| Stop::Fault(self.place(i), fault))?;
            events.push(event);
        }
        self.read += count as u64;
        self.left -= count as u64;
        Ok(true)
    }

    fn note(&self) -> Option<&'static str> {
        self.others.then_some(OTHERS)
    }

    fn place(&self, event: usize) -> Place {
        Place::Event(self.first + event as u64)
    }
}

/// A writer of events.
pub(super) fn sink(head: &Head) -> Writing {
    Writing {
        head: head.clone(),
        writer: None,
        rest: Vec::new(),
    }
}

pub(super) struct Writing {
    head: Head,
    writer: Option<SerializedFileWriter<File>>,
    /// Events that do not fill a row group yet.
    rest: Vec<Event>,
}

impl Writing {
    fn begin(&mut self) -> ParquetResult<()> {
        let channel = if self.head.channels > 1 {
            "REQUIRED INT32 channel (INTEGER(8,false));"
        } else {
            ""
        };
        let schema = parse_message_type(&format!(
            "message events {{ REQUIRED INT64 t; REQUIRED INT32 x (INTEGER(16,false)); \
             REQUIRED INT32 y (INTEGER(16,false)); REQUIRED INT32 p (INTEGER(8,false)); {channel} }}"
        ))?;
        let properties = WriterProperties::builder()
            .set_compression(Compression::ZSTD(ZstdLevel::default()))
            .build();
        let file = tempfile::tempfile()?;
        let writer = SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties))?;
        self.writer = Some(writer);
        Ok(())
    }

    /// Writes the events that wait as a row group.
    fn write(&mut self) -> ParquetResult<()> {
        if self.rest.is_empty() {
            return Ok(());
        }
        let Some(writer) = &mut self.writer else {
            return Ok(());
        };
        let mut group = writer.next_row_group()?;
        for number in 0.. {
            let Some(mut column) = group.next_column()? else {
                break;
            };
            let events = self.rest.iter();
            match column.untyped() {
                ColumnWriter::Int64ColumnWriter(column) => {
                    let values: Vec<i64> = events.map(|e| e.t.0 as i64).collect();
                    column.write_batch(&values, None, None)?;
                }
                ColumnWriter::Int32ColumnWriter(column) => {
                    let value = |e: &Event| match number {
                        1 => i32::from(e.x),
                        2 => i32::from(e.y),
                        3 => i32::from(e.polarity.bit()),
                        _ => i32::from(e.channel),
                    };
                    let values: Vec<i32> = events.map(value).collect();
                    column.write_batch(&values, None, None)?;
                }
                _ => return Err(ParquetError::General("a column of another type".into())),
            }
            column.close()?;
        }
        group.close()?;
        self.rest.clear();
        Ok(())
    }
}

impl Sink for Writing {
    fn start(&mut self, _: &mut dyn Out) -> io::Result<()> {
        self.begin().map_err(io::Error::other)
    }

    fn put(&mut self, _: &mut dyn Out, mut events: &[Event]) -> io::Result<()> {
        while !events.is_empty() {
            let room = GROUP - self.rest.len();
            let (now, later) = events.split_at(room.min(events.len()));
            self.rest.extend_from_slice(now);
            events = later;
            if self.rest.len() == GROUP {
                self.write().map_err(io::Error::other)?;
            }
        }
        Ok(())
    }

    fn finish(&mut self, out: &mut dyn Out, about: &About) -> io::Result<()> {
        self.write().map_err(io::Error::other)?;
        if let Some(mut writer) = self.writer.take() {
            let about = KeyValue::new("amacrine".into(), about.to_string());
            writer.append_key_value_metadata(about);
            let mut file = writer.into_inner().map_err(io::Error::other)?;
            file.seek(SeekFrom::Start(0))?;
            io::copy(&mut file, out)?;
        }
        Ok(())
    }
}
