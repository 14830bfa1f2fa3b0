//! The traits of readers and writers of event files.

use std::io::{self, Seek, Write};

use super::{Fault, Place, about::About, chunks::Chunks, fault::Stop};
use crate::event::Event;

/// Events of a block, about: their memory stays in the second-level cache.
pub const BLOCK: usize = 1 << 13;

/// A file being read.
pub trait Source: Send {
    /// What the file has said of itself so far.
    fn about(&self) -> About;

    /// The numbers of its streams of events, where the format may have several.
    fn streams(&self) -> Vec<i32> {
        Vec::new()
    }

    /// Leaves out all streams of events but this one of [`Source::streams`]. Before the first
    /// [`Source::fill`].
    fn choose(&mut self, _stream: i32) {}

    /// Adds the next events; false at the end of the file.
    ///
    /// What came before damage is added before the damage is reported.
    fn fill(&mut self, events: &mut Vec<Event>) -> Result<bool, Stop>;

    /// The place of an event by its index in the last [`Source::fill`]; after the last fill, index
    /// 0 is the end of the file.
    fn place(&self, event: usize) -> Place;

    /// Records so far that are no events of a pixel: triggers, frames, motion, and events
    /// before the first time.
    fn skipped(&self) -> u64 {
        0
    }

    /// A remark about the file that is no error.
    fn note(&self) -> Option<&'static str> {
        None
    }
}

/// A file being written.
pub trait Sink: Send {
    /// Writes what stands before the events.
    fn start(&mut self, out: &mut dyn Out) -> io::Result<()>;

    /// Writes events; they have been checked.
    fn put(&mut self, out: &mut dyn Out, events: &[Event]) -> io::Result<()>;

    /// Writes the end, and what the start could not know: `about` has the number of events, and
    /// their times.
    fn finish(&mut self, out: &mut dyn Out, about: &About) -> io::Result<()>;
}

/// Where a file goes.
pub trait Out: Write + Seek {}

impl<T: Write + Seek> Out for T {}

/// A decoder of a stream of words, each of which depends only on those before it.
pub trait Words: Clone + Send {
    /// Bytes of the shortest word.
    const STEP: usize;

    /// Decodes the whole words at the front of `bytes` and returns how many bytes they had; an
    /// error has its distance from the front.
    fn read(&mut self, bytes: &[u8], events: &mut Vec<Event>) -> Result<usize, (usize, Fault)>;

    /// See [`Source::skipped`].
    fn skipped(&self) -> u64 {
        0
    }

    /// See [`Source::note`].
    fn note(&self) -> Option<&'static str> {
        None
    }
}

/// A file that is a stream of words behind a header.
pub struct Stream<W> {
    chunks: Chunks,
    words: W,
    about: About,
    /// The decoder's state before the last chunk, that chunk, and its place: to find the place of
    /// an event again.
    before: W,
    chunk: Vec<u8>,
    from: u64,
}

impl<W: Words> Stream<W> {
    /// The words from here on.
    pub fn new(chunks: Chunks, words: W, about: About) -> Self {
        Self {
            from: chunks.at(),
            before: words.clone(),
            chunk: Vec::new(),
            chunks,
            words,
            about,
        }
    }
}

impl<W: Words> Source for Stream<W> {
    fn about(&self) -> About {
        self.about.clone()
    }

    fn fill(&mut self, events: &mut Vec<Event>) -> Result<bool, Stop> {
        let longest = 16 * W::STEP;
        self.chunks.ahead(longest)?;
        self.before.clone_from(&self.words);
        self.from = self.chunks.at();
        self.chunk.clear();
        let here = self.chunks.here();
        if here.is_empty() {
            return Ok(false);
        }
        // As many events at a time as stay in the cache.
        let here = &here[..here.len().min(longest.max(BLOCK * 4))];
        self.chunk.extend_from_slice(here);
        match self.words.read(here, events) {
            Ok(0) => Err(self.chunks.truncated("an event".into())),
            Ok(used) => {
                self.chunks.eat(used);
                Ok(true)
            }
            Err((at, fault)) => Err(Stop::Fault(Place::Byte(self.from + at as u64), fault)),
        }
    }

    fn place(&self, event: usize) -> Place {
        // Decodes the chunk again, word by word.
        let mut words = self.before.clone();
        let mut events = Vec::new();
        let (mut at, mut end) = (0, W::STEP);
        while let Some(word) = self.chunk.get(at..end) {
            match words.read(word, &mut events) {
                Ok(0) => end += W::STEP,
                Ok(used) if events.len() <= event => {
                    at += used;
                    end = at + W::STEP;
                }
                _ => break,
            }
        }
        Place::Byte(self.from + at as u64)
    }

    fn skipped(&self) -> u64 {
        self.words.skipped()
    }
    fn note(&self) -> Option<&'static str> {
        self.words.note()
    }
}
