//! The text that E2VID reads (`run_reconstruction.py -i`): the first line is `width height`, then
//! one event a line, `t x y p`, time in seconds. Source: <https://github.com/uzh-rpg/rpg_e2vid>.

use std::io;

use super::{
    Fault, Place,
    about::{About, within_reach},
    chunks::Chunks,
    entry::{Entry, Limits, Sign, Streams},
    fault::Stop,
    gate::Raw,
    head::Head,
    line::{Line, Rows, Text, integer, shown},
    source::{Out, Sink},
    txt,
};
use crate::{event::Event, plane::Size};

/// The format's entry in the list of formats.
pub(super) const ENTRY: Entry = Entry {
    name: "e2vid",
    extension: "e2vid",
    limits: Limits {
        channels: false,
        ..Limits::WIDE
    },
    readers: "E2VID (as `events.txt`), pandas, numpy",
    module: "numpy",
    python: "numpy.loadtxt(path, skiprows=1)",
    sign: Sign::Nothing,
    streams: Some(Streams {
        source: |_, chunks| Ok(Box::new(source(chunks))),
        sink: |head, _| Ok(Box::new(sink(head))),
    }),
    rewinds: false,
    remarks: false,
    ..Entry::PLAIN
};

/// A writer of events.
pub(super) fn sink(head: &Head) -> Writing {
    Writing {
        size: head.size,
        rows: txt::sink(),
    }
}

#[derive(Debug)]
pub(super) struct Writing {
    size: Size,
    rows: txt::Writing,
}

impl Sink for Writing {
    fn start(&mut self, out: &mut dyn Out) -> io::Result<()> {
        writeln!(out, "{} {}", self.size.width, self.size.height)
    }

    fn put(&mut self, out: &mut dyn Out, events: &[Event]) -> io::Result<()> {
        self.rows.put(out, events)
    }

    fn finish(&mut self, _: &mut dyn Out, _: &About) -> io::Result<()> {
        Ok(())
    }
}

/// Opens a file's stream of events.
pub(super) fn source(chunks: Chunks) -> Text<SizedText> {
    Text::new(chunks, SizedText { size: None })
}

/// Its lines, the first of which is the size.
#[derive(Debug)]
pub(super) struct SizedText {
    size: Option<Size>,
}

impl Rows for SizedText {
    fn row(&mut self, line: &Line<'_>) -> Result<Option<Raw>, Stop> {
        if self.size.is_some() {
            return txt::Txt.row(line);
        }
        let fields: Vec<&[u8]> = line
            .text
            .split(u8::is_ascii_whitespace)
            .filter(|field| !field.is_empty())
            .collect();
        let [width, height] = fields[..] else {
            let got = fields.len();
            return Err(line.stop(0, Fault::NoSize { got }));
        };
        let side = |name, field| {
            let side = integer(field).and_then(|side| usize::try_from(side).ok());
            side.ok_or_else(|| {
                let found = shown(field);
                line.stop(line.column_of(field), Fault::NotInteger { name, found })
            })
        };
        let size = Size::new(side("height", height)?, side("width", width)?);
        within_reach(size).map_err(|fault| line.stop(0, fault))?;
        self.size = Some(size);
        Ok(None)
    }

    fn size(&self) -> Option<Size> {
        self.size
    }

    fn end(&self) -> Result<(), Stop> {
        if self.size.is_some() {
            return Ok(());
        }
        let place = Place::Line { line: 1, column: 1 };
        Err(Stop::Fault(place, Fault::NoSize { got: 0 }))
    }
}
