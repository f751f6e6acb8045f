//! What a new run takes over from the run of another task: networks and statistics, input by input.

use super::checkpoint::{self, CheckpointError};
use super::identity::run_id;
use super::state::RunState;
use crate::config::{Method, Setting, SettingVisitor, StartedFrom, TrainConfig, Value};
use crate::env::EnvSpec;
use crate::input::InputEncoder;
use crate::learner::state::LearnerState;
use crate::names::Names;
use crate::policy::PolicyInfo;
use std::path::{Path, PathBuf};

/// Settings that say what the networks are, and what their inputs mean.
const SAME: [&str; 5] = [
    "relay.goal_frame",
    "relay.object_order",
    "agent.hidden",
    "agent.critics",
    "agent.critic_layer_norm",
];

/// A trained run from whose networks another one starts, with [`Trainer::new_from`].
///
/// The inputs of the networks are found by their [names](Names). Those that only the new task has
/// start without influence, so that in the sub-tasks of the first object the new run starts with the
/// last policy of the old one, if its environment has all inputs of that one.
///
/// [`Trainer::new_from`]: super::Trainer::new_from
#[derive(Clone, Debug)]
pub struct Pretrained {
    folder: PathBuf,
    state: RunState,
    learner: LearnerState,
    names: Names,
}

/// A run cannot start from another one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PretrainedError {
    /// There is no checkpoint, and so there are no critics.
    #[error(
        "cannot start from `{}`: there is no checkpoint in it; expected the folder of a run with its \
         `checkpoint`, since a policy alone has no critics",
        folder.display()
    )]
    NoCheckpoint {
        /// What was given.
        folder: PathBuf,
    },
    /// The checkpoint cannot be read.
    #[error(transparent)]
    Checkpoint(CheckpointError),
    /// The two runs do not fit each other.
    #[error("cannot start from `{}`: {reason}", folder.display())]
    Unfit {
        /// The run to start from.
        folder: PathBuf,
        /// Why not.
        reason: Unfit,
    },
}

/// Why a run cannot start from another one.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Unfit {
    /// Nothing was learned yet.
    #[error("it has made 0 updates, expected at least 1; train it for longer")]
    Untrained,
    /// The run to start from did not train every sub-task.
    #[error(
        "its `relay.method` is her, which trains the last sub-task only, expected rher; start from a \
         run that was trained with rher"
    )]
    PlainHindsight,
    /// The new run does not train every sub-task.
    #[error(
        "the `relay.method` of the new run is her, which trains the last sub-task only, expected \
         rher; use rher, or start without another run"
    )]
    ForPlainHindsight,
    /// It has objects that the new task does not have.
    #[error(
        "it has {found} objects, expected at most {expected} as in the new task; start from a run \
         with fewer objects"
    )]
    MoreObjects {
        /// Objects of the run to start from.
        found: usize,
        /// Objects of the new task.
        expected: usize,
    },
    /// An object is something else.
    #[error(
        "its object {number} is `{found}`, expected `{expected}` as in the new task; start from a \
         run of a task with the same objects"
    )]
    OtherObject {
        /// Counted from 1.
        number: usize,
        /// What it is in the run to start from.
        found: String,
        /// What it is in the new task.
        expected: String,
    },
    /// The numbers of an action are something else.
    #[error(
        "its actions are ({found}), expected ({expected}) as in the new task; start from a run of a \
         task with the same hand"
    )]
    OtherHand {
        /// Names in the run to start from.
        found: String,
        /// Names in the new task.
        expected: String,
    },
    /// Goals say something else of an object.
    #[error(
        "its goals are of {found}, expected {expected} as in the new task; start from a run of a task \
         with the same goals"
    )]
    OtherGoals {
        /// What they say in the run to start from.
        found: String,
        /// What they say in the new task.
        expected: String,
    },
    /// A setting must be the same and is not.
    #[error(
        "its `{key}` is {found}, expected {expected} as in the new run; set it to {found} there, or \
         start from a run with {expected}"
    )]
    OtherSetting {
        /// Dotted key.
        key: &'static str,
        /// Value in the run to start from.
        found: String,
        /// Value in the new run.
        expected: String,
    },
    /// Nothing says which inputs are the same.
    #[error(
        "nothing says which inputs are the same: it is of {found}, expected {expected}; both \
         environments must have names, or both none and equal dimensions"
    )]
    Unnamed {
        /// The environment of the run to start from.
        found: String,
        /// The new environment.
        expected: String,
    },
}

impl Pretrained {
    /// Reads the last checkpoint of the run in `folder`; `names` says what the numbers of its
    /// environment are ([`EnvSpec::names`]), which no file holds.
    ///
    /// # Errors
    ///
    /// If there is no checkpoint, if it cannot be read, or if there is nothing in it to start from.
    pub fn read(
        folder: &Path,
        names: impl FnOnce(&PolicyInfo) -> Names,
    ) -> Result<Self, PretrainedError> {
        let (state, learner) = checkpoint::read_state(folder).map_err(|error| match error {
            CheckpointError::Missing { .. } => {
                PretrainedError::NoCheckpoint { folder: folder.to_owned() }
            }
            error => PretrainedError::Checkpoint(error),
        })?;
        let PolicyInfo { objects, obs_dim, action_dim, .. } = state.info;
        // Those of another version of the environment say nothing.
        let parts = state.encoder.tail().parts().len();
        let fit = |names: &Names| names.check(objects, obs_dim, action_dim, parts).is_ok();
        let names = Some(names(&state.info)).filter(fit).unwrap_or_default();
        let read = Self { folder: folder.to_owned(), state, learner, names };
        read.check_itself().map_err(|reason| read.unfit(reason))?;
        Ok(read)
    }

    /// What the new run keeps of where it started.
    pub(super) fn origin(&self) -> StartedFrom {
        let RunState { config, info, updates, .. } = &self.state;
        let run = run_id(config, &info.variant);
        StartedFrom { task: info.task.clone(), run, updates: *updates }
    }

    /// The learner that a run with these settings starts with in environments like `spec`; `encoder`
    /// is new and takes over the statistics.
    pub(super) fn hand_over<const N: usize>(
        &self,
        config: &TrainConfig,
        spec: &EnvSpec<N>,
        encoder: &mut InputEncoder,
    ) -> Result<LearnerState, PretrainedError> {
        self.check(config, spec).map_err(|reason| self.unfit(reason))?;
        let PolicyInfo { objects, obs_dim, action_dim, .. } = self.state.info;
        let parts = spec.tolerances.tail.parts().len();
        let new = spec.names.or_numbers(N, spec.obs_dim, spec.action_dim, parts);
        // The parts of both tails are the same, whatever they are called.
        let known = Names { tail: new.tail.clone(), ..self.names.clone() }
            .or_numbers(objects, obs_dim, action_dim, parts);
        let statistics = new.observation.iter().map(|name| similar(name, &new, &known));
        encoder.inherit(&self.state.encoder, &statistics.collect::<Vec<_>>());
        let known_inputs = self.state.encoder.names(&known);
        let inputs = encoder.names(&new);
        let inputs: Vec<_> = inputs.iter().map(|name| place(name, &known_inputs)).collect();
        Ok(self.learner.with_inputs(&inputs))
    }

    fn unfit(&self, reason: Unfit) -> PretrainedError {
        PretrainedError::Unfit { folder: self.folder.clone(), reason }
    }

    /// Whether a run can start from this one at all.
    fn check_itself(&self) -> Result<(), Unfit> {
        if self.state.config.relay.method == Method::Her {
            return Err(Unfit::PlainHindsight);
        }
        if self.state.updates == 0 {
            return Err(Unfit::Untrained);
        }
        Ok(())
    }

    /// Whether a run with these settings can, in environments like `spec`.
    fn check<const N: usize>(&self, config: &TrainConfig, spec: &EnvSpec<N>) -> Result<(), Unfit> {
        if config.relay.method == Method::Her {
            return Err(Unfit::ForPlainHindsight);
        }
        let info = &self.state.info;
        if info.objects > N {
            return Err(Unfit::MoreObjects { found: info.objects, expected: N });
        }
        let known = [info.objects, info.obs_dim, info.action_dim];
        let new = [N, spec.obs_dim, spec.action_dim];
        match (self.names.is_empty(), spec.names.is_empty()) {
            (false, false) => self.check_names(&spec.names)?,
            (true, true) if known == new => {}
            _ => {
                let found = environment(&info.task, known, &self.names);
                let expected = environment(&spec.name, new, &spec.names);
                return Err(Unfit::Unnamed { found, expected });
            }
        }
        let [found, expected] = [self.state.encoder.tail(), &spec.tolerances.tail];
        if !found.means_the_same(expected) {
            let [found, expected] = [found, expected].map(ToString::to_string);
            return Err(Unfit::OtherGoals { found, expected });
        }
        for ((key, found), (_, expected)) in
            must_be_same(&self.state.config).zip(must_be_same(config))
        {
            if found != expected {
                return Err(Unfit::OtherSetting { key, found, expected });
            }
        }
        Ok(())
    }

    /// Whether objects and actions are the same.
    fn check_names(&self, new: &Names) -> Result<(), Unfit> {
        let objects = self.names.objects.iter().zip(&new.objects);
        for (index, (found, expected)) in objects.enumerate() {
            if found != expected {
                let (found, expected) = (found.clone(), expected.clone());
                return Err(Unfit::OtherObject { number: index + 1, found, expected });
            }
        }
        if self.names.action != new.action {
            let [found, expected] = [&self.names.action, &new.action].map(|list| list.join(", "));
            return Err(Unfit::OtherHand { found, expected });
        }
        Ok(())
    }
}

/// Where `name` is in `names`.
fn place(name: &str, names: &[String]) -> Option<usize> {
    names.iter().position(|other| other == name)
}

/// Which number of the observation `known` varies like the one that is called `name` in `new`: that
/// number itself, that of the first object for those of the others, and for a distance between any
/// two things that between the first object and the gripper.
fn similar(name: &str, new: &Names, known: &Names) -> Option<usize> {
    // A number that is there once more has the name of the first, and a count.
    let name = name.split('#').next().unwrap_or(name);
    let find = |name: &str| place(name, &known.observation);
    let of_first = |rest: &str| find(&format!("{}.{rest}", known.objects.first()?));
    find(name).or_else(|| {
        let (owner, rest) = name.split_once('.')?;
        let is_object = new.objects.iter().any(|object| object == owner);
        let of_object = is_object.then(|| of_first(rest)).flatten();
        of_object.or_else(|| {
            let (_, axis) = rest.strip_prefix("from_")?.split_once('.')?;
            of_first(&format!("from_gripper.{axis}"))
        })
    })
}

/// An environment in words; `dimensions` are its objects and the lengths of an observation and of an
/// action.
fn environment(task: &str, dimensions: [usize; 3], names: &Names) -> String {
    let [objects, observation, action] = dimensions;
    let names = if names.is_empty() { "without names" } else { "with names" };
    format!(
        "`{task}` with {objects} objects, observations of {observation} and actions of {action} \
         {names}"
    )
}

/// The settings in [`SAME`], with their values as text.
fn must_be_same(config: &TrainConfig) -> impl Iterator<Item = (&'static str, String)> {
    let mut texts = Texts(Vec::new());
    let Ok(()) = config.visit(&mut texts);
    texts.0.into_iter()
}

struct Texts(Vec<(&'static str, String)>);

impl SettingVisitor for Texts {
    type Error = std::convert::Infallible;

    fn visit<T: Value>(&mut self, setting: &'static Setting, value: &T) -> Result<(), Self::Error> {
        if SAME.contains(&setting.key) {
            let value = serde_json::to_value(value).expect("a setting can be written as JSON");
            let text = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
            self.0.push((setting.key, text));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(names: &[&str]) -> Vec<String> {
        names.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn what_is_new_is_taken_to_vary_like_what_is_most_similar() {
        let observation = [
            "gripper.velocity.x",
            "block1.position.x",
            "block1.from_gripper.x",
            "block2.position.x",
            "block1.from_block2.x",
        ];
        let observation = list(&observation);
        let objects = list(&["block1", "block2"]);
        let known = Names { objects, observation, ..Names::default() };
        let objects = list(&["block1", "block2", "puck3"]);
        let new = Names { objects, ..Names::default() };
        let cases = [
            // Itself, also where its numbers are there once more.
            ("block2.position.x", Some(3)),
            ("gripper.velocity.x#2", Some(0)),
            // Of the first object.
            ("puck3.position.x", Some(1)),
            ("puck3.from_gripper.x", Some(2)),
            ("block2.from_block2.x", Some(4)),
            // Any other distance.
            ("block2.from_puck3.x", Some(2)),
            ("obstacle.from_gripper.x", Some(2)),
            // Nothing is.
            ("obstacle.position.x", None),
            ("puck3.position.z", None),
            ("puck3.charge", None),
            ("charge", None),
        ];
        for (name, expected) in cases {
            assert_eq!(similar(name, &new, &known), expected, "{name}");
        }
    }
}
