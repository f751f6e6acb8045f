//! An episode of each group, as a moving picture.

use crate::film::{Animation, Film};
use crate::printer::Printer;
use crate::shipped;
use crate::trained::Trained;
use rher_core::train::checkpoint::POLICY_FILE;
use rher_envs::Task;
use rher_runs::{Group, Run};

/// The first evaluation episode of the group's first run that has a policy, with a caption; none
/// where the environment is not part of this program, or names nothing that can be seen.
pub(super) fn episode(
    group: &Group,
    runs: &[Run],
    printer: Printer,
) -> Option<(String, &'static str, Vec<u8>)> {
    let mut folders = runs.iter().map(|run| &run.folder);
    let folder = folders.find(|folder| folder.join(POLICY_FILE).exists())?;
    group.task.parse::<Task>().ok()?;
    let caption = format!("{group}: the first evaluation episode of {}", shipped::name(folder));
    let film = Trained::load(folder, printer).and_then(|trained| film(&trained));
    match film {
        Ok(film) => film.map(|film| (caption, "image/gif", film)),
        Err(error) => {
            printer.warn(format_args!("no film of `{}`: {error:#}", shipped::name(folder)));
            None
        }
    }
}

/// The first evaluation episode of a policy, as a GIF file; none where its environment names nothing
/// that can be seen.
pub(crate) fn film(trained: &Trained) -> anyhow::Result<Option<Vec<u8>>> {
    let (task, policy, test_policy) = (trained.task, &trained.policy, trained.test_policy());
    let footage = task.visit_with(&trained.options, Film { task, policy, test_policy })??;
    let animation = Animation::of(&footage.images)?;
    Ok(animation.map(Animation::finish).transpose()?)
}
