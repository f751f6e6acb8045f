//! The hashes that every machine must find: the only place where they are kept.
//!
//! A change that moves one of them changes what is learned from a seed: say so in the change log.

use crate::part::Part;
use rher_envs::Task;

/// Tasks whose parts are measured: one object, two of the same kind, two of different kinds.
pub const TASKS: [Task; 3] = [Task::Push, Task::DPush, Task::DrawerBox];

/// By task and part.
const HASHES: &[(Task, Part, &str)] = &[
    (Task::Push, Part::Physics, "290d3ed4d34b3cb8"),
    (Task::Push, Part::Relabeling, "21296095bdce87a7"),
    (Task::Push, Part::Acting, "fff45d84ee7d76fb"),
    (Task::Push, Part::Update, "b74d85d5631dedbb"),
    (Task::Push, Part::UpdateBf16, "0e6c2e139d335ead"),
    (Task::Push, Part::Run, "8f58eba6b459fe8b"),
    (Task::DPush, Part::Physics, "65c29552c6f270bc"),
    (Task::DPush, Part::Relabeling, "9dfeaeb2f4820d04"),
    (Task::DPush, Part::Acting, "815ede42472dbbd4"),
    (Task::DPush, Part::Update, "969790bc2d70997d"),
    (Task::DPush, Part::UpdateBf16, "741d03534f082838"),
    (Task::DPush, Part::Run, "92de439991096f92"),
    (Task::DrawerBox, Part::Physics, "9a4956bbb02c12d3"),
    (Task::DrawerBox, Part::Relabeling, "a6fcdeeb0f33c866"),
    (Task::DrawerBox, Part::Acting, "ca2464f896e25b4e"),
    (Task::DrawerBox, Part::Update, "b50776077d54a139"),
    (Task::DrawerBox, Part::UpdateBf16, "3cdcd530ef865f12"),
    (Task::DrawerBox, Part::Run, "f7676e69fb576008"),
];

/// By task: the tensors in `policy.safetensors` and `metrics.jsonl` without wall clocks after
/// `rher train TASK --seed 1 --env-steps 1200 --until 0 --set evaluation.every_episodes=5
/// --set evaluation.episodes=20 --set evaluation.subtask_episodes=5`.
///
/// These runs have the networks of the preset; plain loops would take minutes.
pub const PRESET_RUNS: [(Task, &str, &str); 3] = [
    (Task::Push, "cbeb5df3221a513c", "5dd3e8ed4b1e0758"),
    (Task::DPush, "e4e916ceb20a1ecf", "60da181761502deb"),
    (Task::DrawerBox, "58a5002fea52cdec", "ebb965978c791db7"),
];

/// The hash of a part; `None` for a task that is not one of [`TASKS`].
pub fn hash(task: Task, part: Part) -> Option<&'static str> {
    let known = HASHES.iter().find(|(of, it, _)| (*of, *it) == (task, part));
    known.map(|(_, _, hash)| *hash)
}
