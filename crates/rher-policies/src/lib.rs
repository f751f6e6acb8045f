//! A trained policy for every task, with the settings and the metrics of its run.
//!
//! ```
//! let stack = rher_policies::of("stack").expect("every task has one");
//! let policy = stack.policy();
//! assert_eq!(policy.info().objects, 2);
//! println!("{}", stack.card().command);
//! ```
//!
//! `rher reproduce shipped` makes the files; `runs/README.md` says where they come from.

mod card;

pub use card::Card;

use rher_core::Policy;
use std::path::Path;

/// The run of one task, as far as it is shipped: without its checkpoint.
#[derive(Clone, Copy, Debug)]
pub struct Shipped {
    /// Name of the task.
    pub task: &'static str,
    /// The policy's file.
    pub policy: &'static [u8],
    /// `config.toml`: the settings of the run.
    pub config: &'static [u8],
    /// `metrics.jsonl`: a line for each evaluation.
    pub metrics: &'static [u8],
    card: &'static str,
}

impl Shipped {
    /// The policy.
    #[expect(clippy::missing_panics_doc, reason = "a test reads every file")]
    pub fn policy(&self) -> Policy {
        let read = Policy::from_bytes(self.policy, Path::new(self.task));
        read.expect("a test reads every file")
    }

    /// What is known of it.
    #[expect(clippy::missing_panics_doc, reason = "a test reads every file")]
    pub fn card(&self) -> Card {
        serde_json::from_str(self.card).expect("a test reads every file")
    }
}

/// The files of the runs of these tasks.
macro_rules! shipped {
    ($($task:literal),+) => {
        &[$(Shipped {
            task: $task,
            policy: include_bytes!(concat!("../runs/", $task, "/policy.safetensors")),
            config: include_bytes!(concat!("../runs/", $task, "/config.toml")),
            metrics: include_bytes!(concat!("../runs/", $task, "/metrics.jsonl")),
            card: include_str!(concat!("../runs/", $task, "/card.json")),
        }),+]
    };
}

/// Every shipped run, that of the simplest task first.
pub const ALL: &[Shipped] = shipped![
    "reach",
    "push",
    "pick",
    "slide",
    "insert",
    "obstacle-push",
    "drawer",
    "cue-push",
    "dpush",
    "stack",
    "drawer-box",
    "tpush",
    "tstack"
];

/// The shipped run of a task.
pub fn of(task: &str) -> Option<&'static Shipped> {
    ALL.iter().find(|shipped| shipped.task == task)
}
