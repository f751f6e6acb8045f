//! What a user is told about an error.

use crate::exit_code::Status;
use std::error::Error;

/// The exit status of an error, and a way out where there is one.
#[derive(Debug, PartialEq)]
pub(crate) struct Report {
    pub(crate) status: Status,
    pub(crate) hint: Option<String>,
}

impl Report {
    pub(super) fn new(status: Status, hint: impl Into<String>) -> Self {
        Self { status, hint: Some(hint.into()) }
    }

    /// Without a hint: the error says it all.
    pub(super) const fn plain(status: Status) -> Self {
        Self { status, hint: None }
    }
}

/// An error that knows its report; `None` leaves the word to its cause.
pub(super) trait Explain: Error + 'static {
    fn report(&self) -> Option<Report>;
}

/// The report of `cause` if it is an `E`.
pub(super) fn explain<E: Explain>(cause: &(dyn Error + 'static)) -> Option<Report> {
    cause.downcast_ref::<E>()?.report()
}
