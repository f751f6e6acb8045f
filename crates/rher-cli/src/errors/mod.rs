//! Every error that a user can see, with its exit status and its hint.

mod files;
mod films;
mod learner;
mod program;
mod recordings;
mod report;
mod runs;
mod settings;
mod sweeps;

pub(crate) use program::{
    ForeignTask, Invisible, NotReal, OtherBits, OtherFormat, OtherRun, RepeatedKey, SameRun,
};
pub(crate) use report::Report;
pub(crate) use sweeps::NoCellNumber;

use crate::exit_code::Status;
use crate::film::VideoError;
use crate::printer::StdoutError;
use report::explain;
use rher_core::OnnxError;
use rher_core::evaluate::EvaluateError;
use rher_core::event::ObserverError;
use rher_core::files::FileError;
use rher_core::learner::engines::EngineError;
use rher_core::learner::simd::SimdError;
use rher_core::policy::PolicyError;
use rher_core::train::checkpoint::CheckpointError;
use rher_core::train::{PretrainedError, TrainError};
use rher_envs::TaskNameError;
use rher_record::export::ExportError;
use rher_record::{PlayError, ReadError};
use rher_runs::sweep::{AttemptError, ClaimError, Lost, PlanError};
use rher_runs::{
    ConfigFileError, MetricsError, OtherSettings, RunDirError, RunError, RunFilesError,
    SettingsError,
};
use std::error::Error;

/// The errors with a report.
const KNOWN: &[fn(&(dyn Error + 'static)) -> Option<Report>] = &[
    explain::<SettingsError>,
    explain::<RunFilesError>,
    explain::<RunDirError>,
    explain::<PlanError>,
    explain::<ClaimError>,
    explain::<AttemptError>,
    explain::<Lost>,
    explain::<NoCellNumber>,
    explain::<OtherSettings>,
    explain::<MetricsError>,
    explain::<ConfigFileError>,
    explain::<OtherRun>,
    explain::<RunError>,
    explain::<TrainError>,
    explain::<EngineError>,
    explain::<SimdError>,
    explain::<PretrainedError>,
    explain::<CheckpointError>,
    explain::<PolicyError>,
    explain::<OnnxError>,
    explain::<EvaluateError>,
    explain::<ReadError>,
    explain::<PlayError>,
    explain::<ExportError>,
    #[cfg(feature = "live")]
    explain::<rher_record::LiveError>,
    explain::<FileError>,
    explain::<VideoError>,
    explain::<StdoutError>,
    explain::<ForeignTask>,
    explain::<OtherFormat>,
    explain::<RepeatedKey>,
    explain::<SameRun>,
    explain::<NotReal>,
    explain::<OtherBits>,
    explain::<TaskNameError>,
    explain::<Invisible>,
];

/// The report of whatever a command returned: that of the first cause that has one.
pub(crate) fn report(error: &anyhow::Error) -> Report {
    error.chain().find_map(of_cause).unwrap_or(Report::plain(Status::Failure))
}

fn of_cause(cause: &(dyn Error + 'static)) -> Option<Report> {
    match cause.downcast_ref() {
        // What watches a run may fail with any error.
        Some(TrainError::Observer(ObserverError(cause))) => of_cause(cause.as_ref()),
        _ => KNOWN.iter().find_map(|explain| explain(cause)),
    }
}
