//! Text files, read line by line in bounded memory.

use super::{Fault, Place, about::About, chunks::Chunks, fault::Stop, gate::Raw, source::Source};
use crate::{event::Event, plane::Size};

/// Longer than any event or comment.
const LONGEST: usize = 4096;

/// The meaning of the lines of a text format.
pub trait Rows: Send {
    /// The event of a line that is neither blank nor a comment, if it has one.
    fn row(&mut self, line: &Line<'_>) -> Result<Option<Raw>, Stop>;

    /// The size of the sensor, where a line has said it.
    fn size(&self) -> Option<Size> {
        None
    }

    /// Where the value of a field of this name begins in a line of an event.
    fn column(&self, _line: &Line<'_>, _name: &str) -> usize {
        0
    }

    /// At the end of the file.
    fn end(&self) -> Result<(), Stop> {
        Ok(())
    }
}

/// A text file being read.
pub struct Text<R> {
    chunks: Chunks,
    rows: R,
    about: Option<About>,
    /// Lines so far, and those of the last block's events.
    number: u64,
    places: Vec<u64>,
    begun: bool,
    /// The lines in hand.
    lines: Vec<u8>,
}

impl<R: Rows> Text<R> {
    /// From the start.
    pub const fn new(chunks: Chunks, rows: R) -> Self {
        Self {
            chunks,
            rows,
            about: None,
            number: 0,
            places: Vec::new(),
            begun: false,
            lines: Vec::new(),
        }
    }

    /// With what is said of it elsewhere.
    pub fn about_it(mut self, about: Option<About>) -> Self {
        self.about = about;
        self
    }

    /// Reads whole lines.
    fn lines_of(&mut self, part: &[u8], events: &mut Vec<Event>) -> Result<(), Stop> {
        for text in part.split_inclusive(|b| *b == b'\n') {
            if text.len() >= LONGEST {
                let fault = Fault::LongLine { limit: LONGEST };
                return Err(Line::new(self.number + 1, text).stop(0, fault));
            }
            if let Some(event) = self.take(text)? {
                events.push(event);
                self.places.push(self.number);
            }
        }
        Ok(())
    }

    /// Reads one line; returns its event, if it has one.
    fn take(&mut self, text: &[u8]) -> Result<Option<Event>, Stop> {
        self.number += 1;
        // The byte order mark of some spreadsheets.
        let mark = (self.number == 1).then(|| text.strip_prefix(b"\xef\xbb\xbf"));
        let text = mark.flatten().unwrap_or(text);
        let line = Line::new(self.number, text.trim_ascii_end());
        if line.text.trim_ascii_start().is_empty() {
            return Ok(None);
        }
        if let Some(comment) = line.comment() {
            let about = About::parse(&comment).map_err(|fault| line.stop(0, fault))?;
            if about.is_some() {
                if self.about.is_some() || self.begun {
                    let why = "comes twice, or after the first event".into();
                    return Err(line.stop(0, Fault::About { why }));
                }
                self.about = about;
            }
            return Ok(None);
        }
        let Some(raw) = self.rows.row(&line)? else {
            return Ok(None);
        };
        self.begun = true;
        raw.event().map(Some).map_err(|fault| {
            let column = fault
                .field()
                .map_or(0, |name| self.rows.column(&line, name));
            line.stop(column, fault)
        })
    }
}

impl<R: Rows> Source for Text<R> {
    fn about(&self) -> About {
        let about = self.about.clone().unwrap_or_default();
        About {
            size: about.size.or_else(|| self.rows.size()),
            ..about
        }
    }

    fn fill(&mut self, events: &mut Vec<Event>) -> Result<bool, Stop> {
        self.places.clear();
        // The lines of one chunk, out of the reader's hands.
        let here = self.chunks.ahead(LONGEST)?;
        let Some(end) = here.iter().rposition(|b| *b == b'\n') else {
            // The last line may lack its end.
            if here.is_empty() {
                self.rows.end()?;
                return Ok(false);
            }
            if here.len() >= LONGEST {
                let fault = Fault::LongLine { limit: LONGEST };
                return Err(Line::new(self.number + 1, here).stop(0, fault));
            }
            let last = here.to_vec();
            self.chunks.eat(last.len());
            if let Some(event) = self.take(&last)? {
                events.push(event);
                self.places.push(self.number);
            }
            return Ok(true);
        };
        let mut part = std::mem::take(&mut self.lines);
        part.clear();
        part.extend_from_slice(&here[..=end]);
        self.chunks.eat(part.len());
        let read = self.lines_of(&part, events);
        self.lines = part;
        read.map(|()| true)
    }

    fn place(&self, event: usize) -> Place {
        let line = self.places.get(event).copied().unwrap_or(self.number);
        Place::Line { line, column: 1 }
    }
}

/// One line.
#[derive(Clone, Copy, Debug)]
pub struct Line<'a> {
    number: u64,
    /// Its bytes.
    pub text: &'a [u8],
}

impl<'a> Line<'a> {
    const fn new(number: u64, text: &'a [u8]) -> Self {
        Self { number, text }
    }

    /// What is wrong at byte `at` of this line.
    pub const fn stop(&self, at: usize, fault: Fault) -> Stop {
        Stop::Fault(
            Place::Line {
                line: self.number,
                column: at as u64 + 1,
            },
            fault,
        )
    }

    /// Whether it is the first of its file.
    pub const fn is_first(&self) -> bool {
        self.number == 1
    }

    /// What follows the `#` of a comment.
    pub fn comment(&self) -> Option<String> {
        let text = self.text.trim_ascii_start().strip_prefix(b"#")?;
        Some(String::from_utf8_lossy(text).into_owned())
    }

    /// Where `field`, a part of this line, starts.
    pub fn column_of(&self, field: &[u8]) -> usize {
        field
            .as_ptr()
            .addr()
            .saturating_sub(self.text.as_ptr().addr())
    }
}

/// Parses a whole number; `None` when it is none, or has more than 19 digits.
pub fn integer(text: &[u8]) -> Option<i128> {
    let (negative, digits) = match text.strip_prefix(b"-") {
        Some(digits) => (true, digits),
        None => (false, text.strip_prefix(b"+").unwrap_or(text)),
    };
    // 19 digits: all of 63 bits, and no overflow on the way.
    if digits.is_empty() || digits.len() > 19 {
        return None;
    }
    let value = digits.iter().try_fold(0_u64, |sum, digit| {
        digit
            .is_ascii_digit()
            .then(|| sum * 10 + u64::from(digit - b'0'))
    })?;
    Some(if negative {
        -i128::from(value)
    } else {
        value.into()
    })
}

/// Writes a whole number.
pub fn decimal(text: &mut Vec<u8>, mut value: u64) {
    let mut digits = [0; 20];
    let mut first = digits.len();
    loop {
        first -= 1;
        digits[first] = b'0' + (value % 10) as u8;
        value /= 10;
        if value == 0 {
            break;
        }
    }
    text.extend_from_slice(&digits[first..]);
}

/// A field as it is shown in error messages: short, and valid text that a terminal shows.
pub fn shown(field: &[u8]) -> String {
    let end = field.len().min(40);
    let mut text = String::new();
    for letter in String::from_utf8_lossy(&field[..end]).chars() {
        if letter.is_control() {
            text.extend(letter.escape_default());
        } else {
            text.push(letter);
        }
    }
    text
}
