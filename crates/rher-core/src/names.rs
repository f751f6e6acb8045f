//! Names for what an agent observes and does.

use serde::{Deserialize, Serialize};

/// What the numbers of an observation and of an action are, by which the networks of one task find
/// their inputs in another.
///
/// Every list is empty where nobody knows; otherwise all of them are complete.
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
}

impl Names {
    /// Whether nobody knows them.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// What is wrong with them in an environment with these dimensions: the list, and its problem.
    pub(crate) fn check(
        &self,
        objects: usize,
        obs_dim: usize,
        action_dim: usize,
    ) -> Result<(), (&'static str, String, String)> {
        if self.is_empty() {
            return Ok(());
        }
        let lists = [
            ("names.objects", &self.objects, objects),
            ("names.observation", &self.observation, obs_dim),
            ("names.action", &self.action, action_dim),
        ];
        for (list, names, expected) in lists {
            if names.len() != expected {
                let found = format!("{} names", names.len());
                return Err((list, found, format!("{expected}, or none in every list")));
            }
            let is_repeated = |&index: &usize| names[..index].contains(&names[index]);
            if let Some(index) = (0..names.len()).find(is_repeated) {
                let found = format!("`{}` twice", names[index]);
                return Err((list, found, "a different name for each number".to_owned()));
            }
        }
        Ok(())
    }

    /// These names, or numbers where nobody knows any.
    #[cfg(feature = "train")]
    pub(crate) fn or_numbers(&self, objects: usize, obs_dim: usize, action_dim: usize) -> Self {
        if !self.is_empty() {
            return self.clone();
        }
        let numbered = |what: &str, count| (1..=count).map(|n| format!("{what}{n}")).collect();
        Self {
            objects: numbered("object", objects),
            observation: numbered("observation", obs_dim),
            action: numbered("action", action_dim),
        }
    }
}
