//! `rher export`: a policy as a model, or its episodes as a dataset of demonstrations.

mod dataset;

use crate::cli::{ExportArgs, FormatName};
use crate::errors::OtherFormat;
use crate::exit_code::Status;
use crate::printer::Printer;
use crate::running::note_policy;
use crate::shipped;
use rher_core::OnnxModel;
use rher_core::train::checkpoint::POLICY_FILE;
use rher_record::RecordingInfo;
use rher_record::export::{DatasetFormat, DatasetId};

pub(crate) fn export(args: &ExportArgs, printer: Printer) -> anyhow::Result<Status> {
    match args.format {
        FormatName::Onnx => {
            let ExportArgs { dataset_id, episodes, seed, .. } = args;
            let of_datasets = [
                ("--dataset-id", dataset_id.is_some()),
                ("--episodes", episodes.is_some()),
                ("--seed", seed.is_some()),
            ];
            if let Some((option, _)) = of_datasets.into_iter().find(|(_, is_given)| *is_given) {
                return Err(OtherFormat::of_dataset(option).into());
            }
            model(args, printer)
        }
        FormatName::Minari => {
            let format = |info: &RecordingInfo| {
                let id = args.dataset_id.clone();
                DatasetFormat::Minari(id.unwrap_or_else(|| DatasetId::of_task(&info.task)))
            };
            dataset::export(args, &format, printer)
        }
        FormatName::Lerobot => {
            if args.dataset_id.is_some() {
                return Err(OtherFormat::NO_IDENTITY.into());
            }
            dataset::export(args, &|_| DatasetFormat::Lerobot, printer)
        }
    }
}

/// Writes the policy of a run, a file, or a task as a model.
fn model(args: &ExportArgs, printer: Printer) -> anyhow::Result<Status> {
    let place = shipped::folder(&args.path, printer)?;
    let file = if place.is_dir() { place.join(POLICY_FILE) } else { place.into_owned() };
    let model = OnnxModel::of_file(&file)?;
    note_policy(&args.path, printer);
    let contract = model.save(&args.out)?;
    printer.note(format_args!("`{}` and `{}`", args.out.display(), contract.display()));
    Ok(Status::Success)
}
