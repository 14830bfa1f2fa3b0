//! What is wrong with a text: where, what was expected, what to do. All faults of a file at
//! once.

use std::{fmt, sync::Arc};

use miette::{Diagnostic, LabeledSpan, NamedSource, SourceCode};

use super::place::{Place, line_column};
use crate::{limit::FAULTS, order::Order};

/// Whether a text can still be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// It cannot.
    Error,
    /// It can, and may not do what its writer thinks.
    Warning,
}

/// What was read, or what is wrong with it.
pub type Read<T> = Result<T, Fault>;

/// The label of a key that is right, and of no use where it stands.
pub const CHANGES_NOTHING: &str = "changes nothing";

/// One thing that is wrong.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// What is wrong.
    pub message: String,
    /// Where in the text.
    pub place: Place,
    /// What stands there.
    pub label: String,
    /// A second place that belongs to it.
    pub also: Option<Box<(Place, String)>>,
    /// What to do.
    pub help: Option<String>,
    /// Whether the text can still be used.
    pub severity: Severity,
}

impl Fault {
    /// An error at a place.
    #[must_use]
    pub fn error(place: Place, message: impl Into<String>, label: impl Into<String>) -> Self {
        Self {
            message: message.into(),
            place,
            label: label.into(),
            also: None,
            help: None,
            severity: Severity::Error,
        }
    }

    /// Whether the text cannot be used.
    #[must_use]
    pub fn is_error(&self) -> bool {
        self.severity == Severity::Error
    }

    /// A warning at a place.
    #[must_use]
    pub fn warning(place: Place, message: impl Into<String>, label: impl Into<String>) -> Self {
        Self {
            severity: Severity::Warning,
            ..Self::error(place, message, label)
        }
    }

    /// With what to do.
    #[must_use]
    pub fn help(self, help: impl Into<String>) -> Self {
        Self {
            help: Some(help.into()),
            ..self
        }
    }

    /// Says where it is written, `file:line:column`, where that is not in the file of its place.
    #[must_use]
    pub fn written(self, origin: Option<&str>) -> Self {
        match origin {
            None => self,
            Some(origin) => Self {
                message: format!("{origin}: {}", self.message),
                ..self
            },
        }
    }

    /// With a second place.
    #[must_use]
    pub fn also(self, place: Place, label: impl Into<String>) -> Self {
        Self {
            also: Some(Box::new((place, label.into()))),
            ..self
        }
    }
}

/// A fault with the file it was found in; what a person is shown.
#[derive(Clone, Debug)]
pub struct Located {
    /// What is wrong.
    pub fault: Fault,
    /// Name of the file.
    pub file: String,
    /// Line, from 1.
    pub line: u32,
    /// Column in characters, from 1.
    pub column: u32,
    source: Arc<NamedSource<String>>,
    /// Whether the lines around it are short enough to be shown.
    shows: bool,
}

/// All faults of one text, in the order of the text. Never empty.
#[derive(Clone, Debug)]
pub struct Faults {
    /// Name of the file.
    pub file: String,
    /// What is wrong.
    pub faults: Vec<Located>,
    /// Whether more is wrong, which is not told.
    pub more: bool,
}

impl Faults {
    /// The faults of a text, sorted by place.
    #[must_use]
    pub fn new(file: &str, text: &str, mut faults: Vec<Fault>) -> Self {
        let more = faults.len() > FAULTS;
        faults.order_by_key(|fault| (fault.place.start, fault.place.end));
        // Places are always equal; the same mistake in two places is told twice.
        faults.dedup_by(|a, b| a == b && a.place.is(b.place));
        if faults.len() > FAULTS {
            // No warning takes the place of an error.
            faults.order_by_key(|fault| fault.severity != Severity::Error);
            faults.truncate(FAULTS);
            faults.order_by_key(|fault| (fault.place.start, fault.place.end));
        }
        let source = Arc::new(NamedSource::new(file, text.to_owned()));
        let locate = |fault: Fault| {
            let (line, column) = line_column(text, fault.place.start);
            let also = fault.also.iter().map(|also| also.0);
            let shows = also
                .chain([fault.place])
                .all(|place| shows(text, place.start) && shows(text, place.end));
            Located {
                shows,
                file: file.to_owned(),
                line,
                column,
                source: Arc::clone(&source),
                fault,
            }
        };
        Self {
            file: file.to_owned(),
            faults: faults.into_iter().map(locate).collect(),
            more,
        }
    }

    /// One fault of a text.
    #[must_use]
    pub fn one(file: &str, text: &str, fault: Fault) -> Self {
        Self::new(file, text, vec![fault])
    }

    /// `Ok` when no fault is an error.
    ///
    /// # Errors
    /// All faults, warnings too, when one of them is an error.
    pub fn check(file: &str, text: &str, faults: Vec<Fault>) -> Result<(), Self> {
        if faults.iter().any(|f| f.severity == Severity::Error) {
            return Err(Self::new(file, text, faults));
        }
        Ok(())
    }

    /// Each with its place, a line each.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        self.faults.iter().map(ToString::to_string).collect()
    }
}

/// The longest line that is shown, in bytes.
const SHOWN: usize = 2000;

/// Whether the line of a byte, and those beside it, are short enough to be shown.
fn shows(text: &str, byte: usize) -> bool {
    let (before, after) = text.split_at(text.floor_char_boundary(byte));
    let above = before.rsplit('\n').take(2).map(str::len);
    let below = after.split('\n').take(2).map(str::len);
    above.chain(below).all(|length| length <= SHOWN)
}

/// Leaves out what would not be told, where there is much: so that a text that is wrong
/// everywhere does not take memory and time without end.
pub fn thin(faults: &mut Vec<Fault>) {
    if faults.len() <= 4 * FAULTS {
        return;
    }
    for severity in [Severity::Error, Severity::Warning] {
        let mut kept = 0;
        faults.retain(|fault| {
            kept += usize::from(fault.severity == severity);
            fault.severity != severity || kept <= FAULTS + 1
        });
    }
}

/// Whether so much is wrong that there is no use in going on.
#[must_use]
pub fn enough(faults: &[Fault]) -> bool {
    let errors = faults.iter().filter(|f| f.severity == Severity::Error);
    errors.count() > FAULTS
}

impl fmt::Display for Located {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            file, line, column, ..
        } = self;
        write!(f, "{file}:{line}:{column}: {}", self.fault.message)
    }
}

impl std::error::Error for Located {}

impl Diagnostic for Located {
    fn severity(&self) -> Option<miette::Severity> {
        Some(match self.fault.severity {
            Severity::Error => miette::Severity::Error,
            Severity::Warning => miette::Severity::Warning,
        })
    }

    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        let help = self.fault.help.as_ref()?;
        Some(Box::new(help))
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.shows.then_some(&self.source as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let length = self.source.inner().len();
        // A label past the end of the text would hide the text.
        let label = move |place: Place, text: &str| {
            let start = place.start.min(length);
            let end = place.end.clamp(start, length);
            LabeledSpan::new(Some(text.to_owned()), start, end - start)
        };
        let also = self.fault.also.iter();
        let also = also.map(move |also| label(also.0, &also.1));
        Some(Box::new(
            std::iter::once(label(self.fault.place, &self.fault.label)).chain(also),
        ))
    }
}

impl fmt::Display for Faults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.faults.as_slice() {
            [only] if !self.more => only.fmt(f),
            all => {
                let is_error = |it: &&Located| it.fault.severity == Severity::Error;
                let errors = all.iter().filter(is_error).count();
                write!(f, "{}: ", self.file)?;
                let many = |count: usize, what: &str| match count {
                    1 => format!("1 {what}"),
                    count => format!("{count} {what}s"),
                };
                match (errors, all.len() - errors) {
                    (0, warnings) => f.write_str(&many(warnings, "warning"))?,
                    (1, 0) => f.write_str("1 thing is wrong")?,
                    (errors, 0) => write!(f, "{errors} things are wrong")?,
                    (errors, warnings) => write!(
                        f,
                        "{} and {}",
                        many(errors, "error"),
                        many(warnings, "warning")
                    )?,
                }
                if self.more {
                    f.write_str(", and more are not shown")?;
                }
                Ok(())
            }
        }
    }
}

impl std::error::Error for Faults {}

impl Diagnostic for Faults {
    fn severity(&self) -> Option<miette::Severity> {
        let error = |l: &Located| l.fault.severity == Severity::Error;
        Some(if self.faults.iter().any(error) {
            miette::Severity::Error
        } else {
            miette::Severity::Warning
        })
    }

    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.only()?.help()
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.only()?.source_code()
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        self.only()?.labels()
    }

    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn Diagnostic> + 'a>> {
        if self.only().is_some() {
            return None;
        }
        Some(Box::new(self.faults.iter().map(|l| l as &dyn Diagnostic)))
    }
}

impl Faults {
    /// The fault, when there is one alone: it is then shown without a heading.
    fn only(&self) -> Option<&Located> {
        match self.faults.as_slice() {
            [only] if !self.more => Some(only),
            _ => None,
        }
    }
}
