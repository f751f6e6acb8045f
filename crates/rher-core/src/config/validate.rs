//! Checks that settings are in their ranges.

use super::{EngineKind, Precision, TrainConfig, VERSION};
use crate::setting::{Setting, SettingVisitor, Value};

/// A setting is outside its range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("`{key}` is {value}, expected {expected}")]
pub struct ConfigError {
    /// Dotted key of the setting, as in `--set`.
    pub key: &'static str,
    /// Its value.
    pub value: Box<str>,
    /// The values that it accepts.
    pub expected: Box<str>,
    /// Dotted key of another setting, if the range depends on one.
    pub depends_on: Option<&'static str>,
}

impl ConfigError {
    /// Whether the setting with this dotted key has a part in the error.
    pub fn concerns(&self, key: &str) -> bool {
        self.key == key || self.depends_on == Some(key)
    }
}

impl TrainConfig {
    /// Checks what the types do not: that every setting is in its range.
    ///
    /// # Errors
    ///
    /// For the first setting, in the order of the file, that is not.
    pub fn validate(&self) -> Result<(), ConfigError> {
        if self.version != VERSION {
            return Err(ConfigError {
                key: "version",
                value: self.version.to_string().into(),
                expected: format!("{VERSION}, the version of this program").into(),
                depends_on: None,
            });
        }
        self.visit(&mut Ranges)?;
        if (self.agent.engine, self.agent.precision) == (EngineKind::Burn, Precision::Bf16) {
            return Err(ConfigError {
                key: "agent.precision",
                value: Precision::Bf16.name().into(),
                expected:
                    "`f32` with the engine `burn`, which has no other; the engine `fused` has \
                           both"
                        .into(),
                depends_on: Some("agent.engine"),
            });
        }
        let exploration = &self.exploration;
        if exploration.guide + exploration.random > 1.0 + f32::EPSILON {
            return Err(ConfigError {
                key: "exploration.guide",
                value: exploration.guide.to_string().into(),
                expected: "at most 1 − `exploration.random`".into(),
                depends_on: Some("exploration.random"),
            });
        }
        Ok(())
    }
}

/// Checks each setting by itself.
struct Ranges;

impl SettingVisitor for Ranges {
    type Error = ConfigError;

    fn visit<T: Value>(&mut self, setting: &'static Setting, value: &T) -> Result<(), ConfigError> {
        if value.fits(setting.range) {
            return Ok(());
        }
        Err(ConfigError {
            key: setting.key,
            value: format!("{value:?}").into(),
            expected: setting.expected().into(),
            depends_on: None,
        })
    }
}
