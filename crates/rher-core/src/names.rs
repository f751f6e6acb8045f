//! Names for what an agent observes and does.

use serde::{Deserialize, Serialize};

/// What the numbers of an observation and of an action are, by which the networks of one task find
/// their inputs in another.
///
/// The first three lists are empty where nobody knows; otherwise all of them are complete.
///
/// ```
/// use rher_core::{EnvSpec, Names};
///
/// let mut spec = EnvSpec::<1>::new("line", 2, 1, 20);
/// let list = |names: &[&str]| names.iter().map(ToString::to_string).collect();
/// spec.names = Names {
///     objects: list(&["block1"]),
///     observation: list(&["gripper.position.x", "block1.position.x"]),
///     action: list(&["gripper.x"]),
///     tail: Vec::new(),
/// };
/// assert!(spec.validate().is_ok());
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Names {
    /// One for each object, in relay order: what kind of object it is, and its number, such as
    /// `block1`.
    pub objects: Vec<String>,
    /// One for each number of an observation: whose it is, what, and along which axis, such as
    /// `block1.position.x`.
    pub observation: Vec<String>,
    /// One for each number of an action, such as `gripper.x`.
    pub action: Vec<String>,
    /// One for each part of what goals say of an object beside its position, such as `yaw`; known or
    /// not whatever the other lists are.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub tail: Vec<String>,
}

impl Names {
    /// Whether nobody knows what observations and actions are.
    pub fn is_empty(&self) -> bool {
        [&self.objects, &self.observation, &self.action].iter().all(|names| names.is_empty())
    }

    /// What is wrong with them in an environment with these dimensions: the list, and its problem.
    pub(crate) fn check(
        &self,
        objects: usize,
        obs_dim: usize,
        action_dim: usize,
        tail: usize,
    ) -> Result<(), (&'static str, String, String)> {
        let lists = [
            ("names.objects", &self.objects, objects),
            ("names.observation", &self.observation, obs_dim),
            ("names.action", &self.action, action_dim),
        ];
        if !self.is_empty() {
            for (list, names, expected) in lists {
                check_list(list, names, expected, ", or none in every list")?;
            }
        }
        if self.tail.is_empty() {
            Ok(())
        } else {
            check_list("names.tail", &self.tail, tail, ", or none")
        }
    }

    /// These names, or numbers where nobody knows any.
    #[cfg(feature = "train")]
    pub(crate) fn or_numbers(
        &self,
        objects: usize,
        obs_dim: usize,
        action_dim: usize,
        tail: usize,
    ) -> Self {
        let numbered = |what: &str, count| (1..=count).map(|n| format!("{what}{n}")).collect();
        let mut names = self.clone();
        if names.is_empty() {
            names.objects = numbered("object", objects);
            names.observation = numbered("observation", obs_dim);
            names.action = numbered("action", action_dim);
        }
        if names.tail.is_empty() {
            names.tail = numbered("tail", tail);
        }
        names
    }
}

/// What is wrong with a list of names.
fn check_list(
    list: &'static str,
    names: &[String],
    expected: usize,
    otherwise: &str,
) -> Result<(), (&'static str, String, String)> {
    if names.len() != expected {
        return Err((list, format!("{} names", names.len()), format!("{expected}{otherwise}")));
    }
    let is_repeated = |&index: &usize| names[..index].contains(&names[index]);
    match (0..names.len()).find(is_repeated) {
        Some(index) => {
            let found = format!("`{}` twice", names[index]);
            Err((list, found, "a different name for each number".to_owned()))
        }
        None => Ok(()),
    }
}
