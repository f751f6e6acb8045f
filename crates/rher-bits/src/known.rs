//! The hashes that every machine must find: the only place where they are kept.
//!
//! A change that moves one of them changes what is learned from a seed: say so in the change log.

use crate::part::Part;
use rher_envs::Task;

/// Tasks whose parts are measured: one object, two of the same kind, two of different kinds.
pub const TASKS: [Task; 3] = [Task::PUSH, Task::DPUSH, Task::DRAWER_BOX];

/// By task and part.
const HASHES: &[(Task, Part, &str)] = &[
    (Task::PUSH, Part::Physics, "290d3ed4d34b3cb8"),
    (Task::PUSH, Part::Relabeling, "0b825063a836088d"),
    (Task::PUSH, Part::Acting, "22a74072cc4d0904"),
    (Task::PUSH, Part::Update, "343d029e8570ef93"),
    (Task::PUSH, Part::UpdateBf16, "a5fc871163d944c0"),
    (Task::PUSH, Part::Run, "1d054067c50d397c"),
    (Task::DPUSH, Part::Physics, "65c29552c6f270bc"),
    (Task::DPUSH, Part::Relabeling, "25e2efae09462da1"),
    (Task::DPUSH, Part::Acting, "bec254d35d51fead"),
    (Task::DPUSH, Part::Update, "df8b15fe1573dff8"),
    (Task::DPUSH, Part::UpdateBf16, "0286a770e3ad517b"),
    (Task::DPUSH, Part::Run, "9cc701f54e11ba60"),
    (Task::DRAWER_BOX, Part::Physics, "9a4956bbb02c12d3"),
    (Task::DRAWER_BOX, Part::Relabeling, "6ca7f9803173e20f"),
    (Task::DRAWER_BOX, Part::Acting, "0574bcd4566f137d"),
    (Task::DRAWER_BOX, Part::Update, "698af37de18b1b92"),
    (Task::DRAWER_BOX, Part::UpdateBf16, "031f8337100d657c"),
    (Task::DRAWER_BOX, Part::Run, "8d5025e70609fa82"),
];

/// By task: the tensors in `policy.safetensors` and `metrics.jsonl` without wall clocks after
/// `rher train TASK --seed 1 --env-steps 1200 --until 0 --set evaluation.every_episodes=5
/// --set evaluation.episodes=20 --set evaluation.subtask_episodes=5`.
///
/// These runs have the networks of the preset; plain loops would take minutes.
pub const PRESET_RUNS: [(Task, &str, &str); 3] = [
    (Task::PUSH, "bfe75469cc4698be", "4fbd918883104249"),
    (Task::DPUSH, "c0c754e9b741466e", "b35814ec1d1e6d03"),
    (Task::DRAWER_BOX, "8929a777dcd34e03", "93fc0f4044b670bb"),
];

/// The hash of a part; `None` for a task that is not one of [`TASKS`].
pub fn hash(task: Task, part: Part) -> Option<&'static str> {
    let known = HASHES.iter().find(|(of, it, _)| (*of, *it) == (task, part));
    known.map(|(_, _, hash)| *hash)
}
