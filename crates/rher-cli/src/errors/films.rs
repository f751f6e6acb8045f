//! Films.

use super::report::{Explain, Report};
use crate::exit_code::Status;
use crate::film::VideoError;

impl Explain for VideoError {
    fn report(&self) -> Option<Report> {
        let hint = match self {
            Self::NoEncoder { .. } => {
                "install `ffmpeg`, or choose a name that ends in `.gif`, which needs no other program"
            }
            Self::Encoder { .. } => {
                "try another format; a name that ends in `.gif` needs no other program"
            }
        };
        Some(Report::new(Status::Unwritable, hint))
    }
}
