//! The one exception, with the words of the command line.

use std::fmt::Write as _;

use miette::{Diagnostic, GraphicalReportHandler, GraphicalTheme, Report};
use pyo3::{PyErr, create_exception, exceptions::PyValueError};

use crate::options::in_python;

create_exception!(
    amacrine,
    Error,
    PyValueError,
    "What is wrong, in the words of the command line: what was given, what was expected, and what to do."
);

create_exception!(
    amacrine._amacrine,
    NotFinite,
    Error,
    "A gradient that goes back, or a sum of it, is NaN or infinite."
);

/// Lines of a text that are shown are cut at so many columns.
const WIDTH: usize = 120;

/// The exception for whatever the library says.
pub fn raised(report: impl Into<Report>) -> PyErr {
    Error::new_err(in_python(&told(&report.into())))
}

/// The exception for a gradient that is not finite, which a layer gives back as NaN.
pub fn not_finite(report: impl Into<Report>) -> PyErr {
    NotFinite::new_err(in_python(&told(&report.into())))
}

/// The exception for what only Python can be wrong about.
pub fn refused(message: impl std::fmt::Display, help: impl std::fmt::Display) -> PyErr {
    Error::new_err(format!("{message}\nhelp: {help}"))
}

/// In words: the message with its causes, then what to do. Where a text is wrong, its lines are
/// shown.
pub fn told(report: &Report) -> String {
    let diagnostic: &(dyn Diagnostic + Send + Sync) = report.as_ref();
    let mut text = String::new();
    for cause in report.chain() {
        let cause = cause.to_string();
        // A transparent error says the same again.
        if text.contains(&cause) {
            continue;
        }
        if !text.is_empty() {
            text += ": ";
        }
        text += &cause;
    }
    if diagnostic.source_code().is_some() || diagnostic.related().is_some() {
        let mut shown = String::new();
        let handler = GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor())
            .with_links(false)
            .with_width(WIDTH);
        // The message stands above already.
        let start = if diagnostic.related().is_some() {
            "Error:"
        } else {
            "   ╭─["
        };
        let rendered = handler.render_report(&mut shown, diagnostic);
        if let (Ok(()), Some(at)) = (rendered, shown.find(start)) {
            return format!("{text}\n{}", shown[at..].trim_end());
        }
    }
    if let Some(help) = diagnostic.help() {
        let _ = write!(text, "\nhelp: {help}");
    }
    text
}
