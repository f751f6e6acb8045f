//! What a controller has to know of an environment beyond its dimensions.

use serde::{Deserialize, Serialize};

/// How fast an environment acts, and what its numbers measure: what a controller has to provide so
/// that a policy acts on a robot as it did in training.
///
/// It is kept with the policy, see [`Policy::control`](crate::Policy::control). Whatever nobody
/// knows is empty.
///
/// ```
/// use rher_core::{Control, EnvSpec};
///
/// let mut spec = EnvSpec::<1>::new("line", 2, 1, 20);
/// spec.control = Control {
///     rate_hz: Some(20.0),
///     frame: "x along the rail, from its left end".to_owned(),
///     observation_units: vec!["m".to_owned(), "m".to_owned()],
///     action_units: vec!["0.05 m/step".to_owned()],
/// };
/// assert!(spec.validate().is_ok());
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Control {
    /// Actions in a second; `None` where a step takes no fixed time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<f32>,
    /// The frame of all positions, in words: its axes and its origin.
    pub frame: String,
    /// The unit of each number of an observation, such as `m`, `rad` or `m/step`.
    pub observation_units: Vec<String>,
    /// What a 1 is in each number of an action, such as `0.05 m/step`.
    pub action_units: Vec<String>,
}

impl Control {
    /// What is wrong with it in an environment with these dimensions: the field, its value, and
    /// what was expected.
    pub(crate) fn check(
        &self,
        obs_dim: usize,
        action_dim: usize,
    ) -> Result<(), (&'static str, String, String)> {
        if let Some(rate) = self.rate_hz.filter(|rate| !(rate.is_finite() && *rate > 0.0)) {
            let expected = "a number of actions in a second, more than 0".to_owned();
            return Err(("control.rate_hz", rate.to_string(), expected));
        }
        let lists = [
            ("control.observation_units", &self.observation_units, obs_dim),
            ("control.action_units", &self.action_units, action_dim),
        ];
        for (list, units, expected) in lists {
            if !units.is_empty() && units.len() != expected {
                let found = format!("{} units", units.len());
                return Err((list, found, format!("{expected}, or none")));
            }
        }
        Ok(())
    }
}
