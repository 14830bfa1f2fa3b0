//! The text that E2VID reads, as the one member of a zip archive, as its own recordings come;
//! the remark is the comment of the archive.

use std::{
    fs::File,
    io::{self, BufReader, BufWriter, Seek, SeekFrom, Write},
};

use zip::{CompressionMethod, ZipArchive, ZipWriter, write::SimpleFileOptions};

use super::{
    Format, Place,
    about::About,
    e2vid,
    entry::{Entry, Limits, Sign, Streams},
    fault::Stop,
    head::Head,
    npz::{Steady, archived, member},
    origin::Origin,
    source::{Out, Sink, Source},
};
use crate::event::Event;

/// The format's entry in the list of formats.
pub(super) const ENTRY: Entry = Entry {
    name: "zip",
    extension: "zip",
    limits: Limits {
        channels: false,
        ..Limits::WIDE
    },
    readers: "E2VID, pandas",
    module: "pandas",
    python: "pandas.read_csv(path, sep=' ', header=None, names=['t', 'x', 'y', 'p'], skiprows=1)",
    sign: Sign::Archive("txt"),
    index_at_end: true,
    streams: Some(Streams {
        source: |origin, _| source(origin),
        sink: |head, _| Ok(Box::new(sink(head)?)),
    }),
    ..Entry::PLAIN
};

/// What the text is called in the archive.
const MEMBER: &str = "events.txt";

/// Opens a file's stream of events.
pub(super) fn source(origin: &Origin) -> Result<Box<dyn Source>, Stop> {
    let wrong = |why: String| Stop::layout(Format::E2vidZip, 0, why);
    let input = BufReader::new(origin.open()?);
    let mut archive =
        ZipArchive::new(input).map_err(|e| wrong(format!("cannot be read as an archive: {e}")))?;
    archived(Format::E2vidZip, origin, &archive)?;
    let names: Result<Vec<String>, _> = archive
        .file_names()
        .map(|name| name.map(std::borrow::Cow::into_owned))
        .collect();
    let names = names.map_err(|e| wrong(format!("has a name that is no text: {e}")))?;
    let [name] = &names[..] else {
        let count = names.len();
        return Err(wrong(format!(
            "holds {count} files; it should hold one, the text of the events"
        )));
    };
    let chunks = member(Format::E2vidZip, origin, &mut archive, name)?;
    let comment = String::from_utf8_lossy(archive.comment()).into_owned();
    let about = About::parse(&comment).map_err(|fault| Stop::Fault(Place::Byte(0), fault))?;
    Ok(Box::new(e2vid::source(chunks).about_it(about)))
}

/// A writer of events.
pub(super) fn sink(head: &Head) -> io::Result<Writing> {
    Ok(Writing {
        rows: e2vid::sink(head),
        text: BufWriter::new(tempfile::tempfile()?),
    })
}

/// The text, in a temporary file until it is whole.
#[derive(Debug)]
pub(super) struct Writing {
    rows: e2vid::Writing,
    text: BufWriter<File>,
}

impl Sink for Writing {
    fn start(&mut self, _: &mut dyn Out) -> io::Result<()> {
        self.rows.start(&mut self.text)
    }

    fn put(&mut self, _: &mut dyn Out, events: &[Event]) -> io::Result<()> {
        self.rows.put(&mut self.text, events)
    }

    fn finish(&mut self, out: &mut dyn Out, about: &About) -> io::Result<()> {
        self.text.flush()?;
        let mut steady = Steady::new(out);
        let written = archive(&mut steady, self.text.get_mut(), about);
        // The first error.
        steady.lost.map_or(written, Err)
    }
}

fn archive(out: &mut Steady<'_>, text: &mut File, about: &About) -> io::Result<()> {
    let length = text.seek(SeekFrom::End(0))?;
    text.seek(SeekFrom::Start(0))?;
    let mut zip = ZipWriter::new(out);
    zip.set_comment(about.to_string())?;
    // The same file for the same events: no clock.
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .large_file(length >= 1 << 31);
    zip.start_file(MEMBER, options)?;
    io::copy(text, &mut zip)?;
    zip.finish()?;
    Ok(())
}
