//! A buffered reader that knows its place in the file, for error messages.

use std::io::{self, ErrorKind, Read};

use super::{Fault, Place, fault::Stop};

/// Bytes asked of the system at once.
const CHUNK: usize = 1 << 16;

/// Longer than any line of a header.
const LONGEST_LINE: usize = 1 << 12;

/// A stream of bytes with look-ahead.
pub struct Chunks {
    input: Box<dyn Read + Send>,
    buffer: Vec<u8>,
    start: usize,
    end: usize,
    at: u64,
}

impl Chunks {
    /// From the start of `input`.
    pub fn new(input: Box<dyn Read + Send>) -> Self {
        Self {
            input,
            buffer: vec![0; CHUNK],
            start: 0,
            end: 0,
            at: 0,
        }
    }

    /// Offset in the file of the next byte.
    pub const fn at(&self) -> u64 {
        self.at
    }

    /// The bytes in the buffer.
    pub fn here(&self) -> &[u8] {
        &self.buffer[self.start..self.end]
    }

    /// At least the next `want` bytes, unless the file ends before.
    pub fn ahead(&mut self, want: usize) -> io::Result<&[u8]> {
        if self.end - self.start < want {
            self.buffer.copy_within(self.start..self.end, 0);
            self.end -= self.start;
            self.start = 0;
            if self.buffer.len() < want {
                self.buffer.resize(want, 0);
            }
            while self.end < self.buffer.len() {
                match self.input.read(&mut self.buffer[self.end..]) {
                    Ok(0) => break,
                    Ok(n) => self.end += n,
                    Err(e) if e.kind() == ErrorKind::Interrupted => (),
                    Err(e) => return Err(e),
                }
            }
        }
        Ok(self.here())
    }

    /// Consumes bytes of the buffer.
    pub fn eat(&mut self, bytes: usize) {
        self.start = self.end.min(self.start + bytes);
        self.at += bytes as u64;
    }

    /// Fills `part`; where the file ends before, the error says inside of what.
    pub fn fill(&mut self, part: &mut [u8], inside: impl Fn() -> String) -> Result<(), Stop> {
        let here = self.ahead(part.len())?;
        let Some(bytes) = here.get(..part.len()) else {
            return Err(self.truncated(inside()));
        };
        part.copy_from_slice(bytes);
        self.eat(part.len());
        Ok(())
    }

    /// The next `N` bytes; where the file ends before, the error says inside of what.
    pub fn take<const N: usize>(&mut self, inside: &str) -> Result<[u8; N], Stop> {
        let mut bytes = [0; N];
        self.fill(&mut bytes, || inside.into())?;
        Ok(bytes)
    }

    /// The next `length` bytes, in memory that grows only as bytes arrive, whatever length the file
    /// claims.
    pub fn block(&mut self, length: usize, inside: &str) -> Result<Vec<u8>, Stop> {
        let mut block = Vec::new();
        self.block_into(length, &mut block, inside)?;
        Ok(block)
    }

    /// As [`block`](Self::block), in place of what `block` holds.
    pub fn block_into(
        &mut self,
        length: usize,
        block: &mut Vec<u8>,
        inside: &str,
    ) -> Result<(), Stop> {
        block.clear();
        while block.len() < length {
            let here = self.ahead(1)?;
            let part = &here[..here.len().min(length - block.len())];
            if part.is_empty() {
                return Err(self.truncated(inside.into()));
            }
            block.extend_from_slice(part);
            let eaten = part.len();
            self.eat(eaten);
        }
        Ok(())
    }

    /// The next line without its end, if it starts with `mark` and is text: an event may begin
    /// with the same byte.
    pub fn line(&mut self, mark: u8) -> Result<Option<String>, Stop> {
        let here = self.ahead(LONGEST_LINE)?;
        let here = &here[..here.len().min(LONGEST_LINE)];
        let end = here.iter().position(|b| *b == b'\n');
        let text = here[..end.unwrap_or(here.len())].trim_ascii_end();
        let is_text = |b: &u8| *b == b'\t' || !b.is_ascii_control();
        if here.first() != Some(&mark) || !text.iter().all(is_text) {
            return Ok(None);
        }
        let Some(end) = end else {
            let fault = if here.len() < LONGEST_LINE {
                return Err(self.truncated("a line of the header".into()));
            } else {
                Fault::LongLine {
                    limit: LONGEST_LINE,
                }
            };
            return Err(self.stop(fault));
        };
        let line = String::from_utf8_lossy(text).into_owned();
        self.eat(end + 1);
        Ok(Some(line))
    }

    /// An error at the next byte.
    pub const fn stop(&self, fault: Fault) -> Stop {
        Stop::Fault(Place::Byte(self.at), fault)
    }

    /// The error for a file that ends too early.
    pub fn truncated(&self, inside: String) -> Stop {
        let end = self.at + self.here().len() as u64;
        Stop::Fault(Place::Byte(end), Fault::Truncated { inside })
    }
}
