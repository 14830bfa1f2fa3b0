//! An event file, read a block at a time.

use std::{
    fmt,
    path::{Path, PathBuf},
};

use super::{
    FileError, Format, Loaded, about::About, fault::Stop, gate::Gate, origin::Origin,
    source::Source,
};
use crate::{
    event::{Event, Packet},
    plane::Size,
};

/// What a file does not say itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Opening {
    /// Its format, whatever its name and first bytes say.
    pub format: Option<Format>,
    /// The size of its sensor, where the file does not give one; another than the file gives is refused.
    pub size: Option<Size>,
    /// Which of its streams of events, of a file of several cameras: its number in the file.
    pub stream: Option<i32>,
}

/// An event file being read: memory does not grow with its length.
///
/// ```
/// use amacrine::event::file::{Opening, Reader};
///
/// let csv = b"t,x,y,p\n5,1,0,1\n7,0,2,0\n".to_vec();
/// let mut reader = Reader::of_bytes("a.csv".as_ref(), csv, &Opening::default())?;
/// let (mut events, mut sum) = (Vec::new(), 0);
/// while reader.next_block(&mut events)? {
///     sum += events.len();
/// }
/// assert_eq!(sum, 2);
/// assert_eq!(reader.about().size, None);
/// # Ok::<(), amacrine::event::file::FileError>(())
/// ```
pub struct Reader {
    path: PathBuf,
    format: Format,
    size: Option<Size>,
    source: Box<dyn Source>,
    gate: Gate,
    /// The error behind the events of the last block.
    stopped: Option<FileError>,
    ended: bool,
}

impl fmt::Debug for Reader {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Reader")
            .field("path", &self.path)
            .field("format", &self.format)
            .field("size", &self.size)
            .field("ended", &self.ended)
            .finish_non_exhaustive()
    }
}

impl Reader {
    /// Opens a file and reads what stands before its events.
    ///
    /// # Errors
    /// When the format is not known, the file cannot be opened, its header is not as the format
    /// says, or it has no such stream as was asked for.
    pub fn open(path: &Path, how: &Opening) -> Result<Self, FileError> {
        Self::new(path, &Origin::File(path.to_owned()), how)
    }

    /// Reads the bytes of a file called `name`.
    ///
    /// # Errors
    /// As [`Reader::open`].
    pub fn of_bytes(name: &Path, bytes: Vec<u8>, how: &Opening) -> Result<Self, FileError> {
        Self::new(name, &Origin::Memory(bytes.into()), how)
    }

    fn new(path: &Path, origin: &Origin, how: &Opening) -> Result<Self, FileError> {
        let at_fault = |stop| named(path, stop, false);
        let mut chunks = match (origin.chunks(), how.format) {
            (Ok(chunks), _) => chunks,
            // A name that says nothing is the first mistake.
            (Err(e), None) => match Format::from_path(path) {
                Err(FileError::Extension {
                    path, extension, ..
                }) => {
                    return Err(FileError::Extension {
                        path,
                        extension,
                        written: false,
                    });
                }
                _ => return Err(at_fault(e.into())),
            },
            (Err(e), Some(_)) => return Err(at_fault(e.into())),
        };
        let format = if let Some(format) = how.format {
            format
        } else {
            let start = chunks.ahead(4096).map_err(|e| at_fault(e.into()))?;
            Format::of_content(path, start)?
        };
        let Some(streams) = format.entry().streams else {
            let path = path.to_owned();
            return Err(FileError::NotBuilt { path, format });
        };
        let mut reader = Self {
            source: (streams.source)(origin, chunks).map_err(at_fault)?,
            path: path.to_owned(),
            format,
            size: how.size,
            gate: Gate::reading(),
            stopped: None,
            ended: false,
        };
        if let Some(stream) = how.stream {
            reader.choose(stream)?;
        }
        reader.listen();
        match reader.contradiction() {
            Some(error) => Err(error),
            None => Ok(reader),
        }
    }

    /// Takes events in any order of time, from here on; else time that runs backwards is damage.
    pub const fn in_any_order(&mut self) {
        self.gate.in_order = false;
    }

    /// Leaves out all streams of events but one.
    fn choose(&mut self, stream: i32) -> Result<(), FileError> {
        let known = self.streams();
        if known.contains(&stream) {
            self.source.choose(stream);
            return Ok(());
        }
        Err(FileError::NoStream {
            path: self.path.clone(),
            stream,
            known,
        })
    }

    /// The numbers of its streams of events, one for each camera; none where the format has no
    /// room for several.
    #[must_use]
    pub fn streams(&self) -> Vec<i32> {
        self.source.streams()
    }

    /// The format it is read as.
    #[must_use]
    pub const fn format(&self) -> Format {
        self.format
    }

    /// What the file has said of itself so far, and the size from [`Opening`] where it says
    /// none. Text files may say it with the first block.
    #[must_use]
    pub fn about(&self) -> About {
        self.gate.about.clone()
    }

    /// Records so far that are no events of a pixel and were left out: triggers, frames,
    /// motion, and events before the first time.
    #[must_use]
    pub fn skipped(&self) -> u64 {
        self.source.skipped()
    }

    /// A remark about the file that is no error, known at its end.
    #[must_use]
    pub fn note(&self) -> Option<&'static str> {
        self.source.note()
    }

    /// The smallest sensor that holds the events so far.
    #[must_use]
    pub const fn reach(&self) -> Size {
        self.gate.reach
    }

    /// One more than the largest channel so far.
    #[must_use]
    pub const fn kinds(&self) -> u8 {
        self.gate.channels
    }

    /// All that is known so far of these events, which came from here.
    #[must_use]
    pub fn loaded(&self, events: Vec<Event>) -> Loaded {
        let (gate, about) = (&self.gate, &self.gate.about);
        let packet = Packet {
            size: about.size.unwrap_or(gate.reach),
            channels: about.channels.unwrap_or(gate.channels),
            names: about.names.clone(),
            span: about.span.or(gate.times()).unwrap_or_default(),
            dropped: about.dropped.unwrap_or_default(),
            events,
        };
        Loaded {
            packet,
            size_known: about.size.is_some(),
            channels_known: about.channels.is_some(),
            dropped_known: about.dropped.is_some(),
            skipped: self.skipped(),
        }
    }

    fn listen(&mut self) {
        self.gate.about = self.source.about();
        // No sensor is without pixels: some writers mean that they do not know.
        let said = self.gate.about.size.filter(|it| it.pixels() > 0);
        self.gate.about.size = said.or(self.size);
    }

    /// A size that was given, of a file that says another.
    fn contradiction(&self) -> Option<FileError> {
        let (asked, said) = (self.size?, self.gate.about.size?);
        (said != asked).then(|| FileError::OtherSize {
            path: self.path.clone(),
            said,
            asked,
        })
    }

    /// How many events are left; they are read where the file does not say it.
    ///
    /// # Errors
    /// As [`Reader::next_block`].
    pub fn count(&mut self) -> Result<u64, FileError> {
        let before = self.gate.events;
        if let Some(all) = self.gate.about.events {
            return Ok(all.saturating_sub(before));
        }
        let mut block = Vec::new();
        while self.next_block(&mut block)? {}
        Ok(self.gate.events - before)
    }

    /// Puts the next events into `events`, in place of what was there; false at the end.
    ///
    /// # Errors
    /// When the file is damaged: after the last good event, with the place of the damage.
    pub fn next_block(&mut self, events: &mut Vec<Event>) -> Result<bool, FileError> {
        events.clear();
        while events.is_empty() && !self.ended {
            if let Some(error) = self.stopped.take() {
                self.ended = true;
                return Err(error);
            }
            match self.source.fill(events) {
                Ok(true) => (),
                Ok(false) => {
                    self.listen();
                    if let Err(fault) = self.gate.complete() {
                        let stop = Stop::Fault(self.source.place(0), fault);
                        self.stopped = Some(named(&self.path, stop, true));
                        continue;
                    }
                    self.ended = true;
                }
                Err(stop) => self.stopped = Some(named(&self.path, stop, true)),
            }
            self.listen();
            if let Some(error) = self.contradiction() {
                events.clear();
                self.ended = true;
                return Err(error);
            }
            if let Err((at, fault)) = self.gate.admit(events) {
                let place = self.source.place(at);
                let stop = Stop::Fault(place, fault);
                self.stopped = Some(named(&self.path, stop, true));
                self.ended = false;
                events.truncate(at);
                // The good ones pass alone.
                if let Err((at, _)) = self.gate.admit(events) {
                    events.truncate(at);
                }
            }
        }
        Ok(!events.is_empty())
    }
}

/// Adds the name of the file to an error, and whether it came behind the header.
fn named(path: &Path, stop: Stop, opened: bool) -> FileError {
    let path = path.to_owned();
    match stop {
        Stop::Io(cause) => FileError::Unreadable { path, cause },
        Stop::Fault(place, fault) => FileError::Bad {
            path,
            place,
            fault,
            opened,
        },
    }
}
