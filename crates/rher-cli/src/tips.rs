//! What to write instead of options that other programs have.

use clap::error::{ContextKind, ContextValue, ErrorKind};
use rher_envs::Task;

/// Options of other programs, and what does the same here, or why nothing does.
const FOREIGN: [(&[&str], &str); 8] = [
    (
        &["--steps", "--total-timesteps", "--total-steps", "--timesteps", "--num-steps"],
        "`--env-steps N` is the budget in environment steps",
    ),
    (
        &["--lr", "--learning-rate"],
        "`--set agent.actor_learning_rate=0.0005` changes a learning rate",
    ),
    (&["--gamma", "--discount"], "`--set agent.discount=0.98` changes the discount"),
    (
        &["--batch-size", "--batch"],
        "`--set replay.batch_size=256` changes the rows of each sub-task",
    ),
    (
        &["--device", "--gpu", "--cuda", "--gpus"],
        "networks are computed on the CPU; `--workers N` is the number of threads",
    ),
    (&["--num-envs", "--n-envs", "--env-count"], "`--envs N` steps N environments side by side"),
    (
        &["--env", "--env-id", "--task"],
        "the task is an argument without an option: `rher train push`",
    ),
    (&["--seeds"], "`rher sweep push --seeds 1-5` trains several seeds"),
];

/// What is said of `--live` where it is left out.
const WITHOUT_LIVE: &str = "this program was built without the live view, which `cargo install \
                            --path crates/rher-cli --features live` builds in";

/// Adds to an error of the command line what helps whoever comes from elsewhere.
pub(crate) fn add(error: &mut clap::Error) {
    let tip = match error.kind() {
        ErrorKind::UnknownArgument => {
            let Some(ContextValue::String(option)) = error.get(ContextKind::InvalidArg) else {
                return;
            };
            let name = option.split('=').next().unwrap_or(option);
            let found = FOREIGN.iter().find(|(names, _)| names.contains(&name));
            let found = found.map(|(_, tip)| *tip);
            let left_out = (name == "--live" && !cfg!(feature = "live")).then_some(WITHOUT_LIVE);
            found.or(left_out).map(str::to_owned)
        }
        ErrorKind::MissingRequiredArgument => {
            let Some(ContextValue::Strings(missing)) = error.get(ContextKind::InvalidArg) else {
                return;
            };
            let names: Vec<&str> = Task::all().into_iter().map(Task::name).collect();
            let is_task = |argument: &String| argument.contains("TASK");
            missing.iter().any(is_task).then(|| format!("the tasks are {}", names.join(", ")))
        }
        _ => None,
    };
    if let Some(tip) = tip {
        // Not what looks alike.
        error.remove(ContextKind::SuggestedArg);
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
    }
}
