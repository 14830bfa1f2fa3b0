//! Text files, line by line, in bounded memory.

use std::io::{BufRead, Read};

use super::{Fault, Place, fault::Stop};

/// Longer than any event or comment.
const LONGEST: usize = 4096;

/// The lines of a text file.
#[derive(Debug)]
pub struct Lines<R> {
    input: R,
    text: Vec<u8>,
    number: u64,
}

impl<R: BufRead> Lines<R> {
    /// From the start.
    pub const fn new(input: R) -> Self {
        Self {
            input,
            text: Vec::new(),
            number: 0,
        }
    }

    /// The next line that is not blank, without its end.
    pub fn next(&mut self) -> Result<Option<Line<'_>>, Stop> {
        loop {
            self.text.clear();
            let mut bounded = Read::take(&mut self.input, LONGEST as u64);
            if bounded.read_until(b'\n', &mut self.text)? == 0 {
                return Ok(None);
            }
            self.number += 1;
            if self.text.len() == LONGEST {
                let fault = Fault::LongLine { limit: LONGEST };
                return Err(Line::new(self.number, &self.text).stop(0, fault));
            }
            if !self.text.trim_ascii().is_empty() {
                break;
            }
        }
        Ok(Some(Line::new(self.number, self.text.trim_ascii_end())))
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

/// A whole number; `None` when it is none, or too long for one.
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

/// A field for an error message: short, and text.
pub fn shown(field: &[u8]) -> String {
    let end = field.len().min(40);
    String::from_utf8_lossy(&field[..end]).into_owned()
}
