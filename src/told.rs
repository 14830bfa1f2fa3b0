//! Errors as they are told: a cause that stands in the message before it is not told again.
//!
//! Errors of this library have their cause as [`source`](Error::source), for programs, and in their
//! message, for people. Whoever prints all causes, as `miette` does, would say each twice.

use std::{
    error::Error,
    fmt::{self, Display},
};

use miette::{Diagnostic, LabeledSpan, Severity, SourceCode};

/// A diagnostic whose causes are told once.
pub struct Told<'a> {
    of: &'a dyn Diagnostic,
    cause: Option<Box<Cause>>,
}

/// A cause that is not in the message before it.
#[derive(Debug)]
struct Cause {
    message: String,
    next: Option<Box<Self>>,
}

impl<'a> Told<'a> {
    /// As this diagnostic is to be told.
    #[must_use]
    pub fn new(of: &'a dyn Diagnostic) -> Self {
        let mut told = vec![of.to_string()];
        let mut next = of.source();
        while let Some(cause) = next {
            let message = cause.to_string();
            if !told.last().is_some_and(|last| last.contains(&message)) {
                told.push(message);
            }
            next = cause.source();
        }
        let causes = told.into_iter().skip(1).rev();
        let cause = causes.fold(None, |next, message| {
            Some(Box::new(Cause { message, next }))
        });
        Self { of, cause }
    }
}

impl fmt::Debug for Told<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self.of, f)
    }
}

impl Display for Told<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        Display::fmt(self.of, f)
    }
}

impl Error for Told<'_> {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        self.cause.as_deref().map(|cause| cause as _)
    }
}

impl Diagnostic for Told<'_> {
    fn code<'b>(&'b self) -> Option<Box<dyn Display + 'b>> {
        self.of.code()
    }

    fn severity(&self) -> Option<Severity> {
        self.of.severity()
    }

    fn help<'b>(&'b self) -> Option<Box<dyn Display + 'b>> {
        let of_cause = || self.of.diagnostic_source()?.help();
        self.of.help().or_else(of_cause)
    }

    fn url<'b>(&'b self) -> Option<Box<dyn Display + 'b>> {
        self.of.url()
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.of.source_code()
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        self.of.labels()
    }

    fn related<'b>(&'b self) -> Option<Box<dyn Iterator<Item = &'b dyn Diagnostic> + 'b>> {
        self.of.related()
    }
}

impl Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl Error for Cause {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        self.next.as_deref().map(|cause| cause as _)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, thiserror::Error, Diagnostic)]
    #[error("no room")]
    #[diagnostic(help("make room"))]
    struct End;

    #[derive(Debug, thiserror::Error, Diagnostic)]
    enum Chain {
        #[error("a.npy: {0}")]
        Full(#[source] End),
        #[error("cannot start")]
        Bare(#[source] Box<Self>),
        #[error("step 1: {0}")]
        Step(
            #[source]
            #[diagnostic_source]
            End,
        ),
    }

    #[test]
    fn a_cause_is_told_once() {
        let causes = |of: Chain| {
            let told = Told::new(&of);
            let mut all = vec![told.to_string()];
            let mut next = told.source();
            while let Some(cause) = next {
                all.push(cause.to_string());
                next = cause.source();
            }
            (all.join(" | "), told.help().map(|help| help.to_string()))
        };
        assert_eq!(causes(Chain::Full(End)).0, "a.npy: no room");
        let bare = Chain::Bare(Box::new(Chain::Full(End)));
        assert_eq!(causes(bare).0, "cannot start | a.npy: no room");
        let step = ("step 1: no room".to_owned(), Some("make room".to_owned()));
        assert_eq!(causes(Chain::Step(End)), step);
    }
}
