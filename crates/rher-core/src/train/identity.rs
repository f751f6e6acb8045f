//! The identity of a run, from its settings.

use crate::config::{StartedFrom, TrainConfig};
use crate::policy::RunId;
use crate::setting::{Setting, SettingVisitor, Value};
use sha2::{Digest as _, Sha256};

/// What may change when a run is resumed.
const NOT_HASHED: [&str; 4] = ["env_steps", "until", "agent.engine", "agent.precision"];

/// The identity of a run with these settings, in environments that were made with `variant`.
///
/// It is the first 128 bits of the SHA-256 of a line `key=value` for each setting, values as JSON,
/// in the order of the settings file, after a line for `variant`; then, if it started from another run,
/// a line for each fact about that one.
#[expect(clippy::missing_panics_doc, reason = "it cannot panic, as the expectation says")]
pub fn run_id(config: &TrainConfig, variant: &str) -> RunId {
    let mut lines = Lines(Sha256::new());
    lines.add("variant", &variant);
    let Ok(()) = config.visit(&mut lines);
    if let Some(StartedFrom { task, run, updates }) = &config.from {
        lines.add("from.task", task);
        lines.add("from.run", run);
        lines.add("from.updates", updates);
    }
    let digest: [u8; 32] = lines.0.finalize().into();
    let first = digest.first_chunk().expect("a SHA-256 has more than 16 bytes");
    RunId(u128::from_be_bytes(*first))
}

/// Settings that came after the identity did, with the value of every run from before: as if they
/// were not there, so that such a run keeps its identity.
const LATER: [(&str, &str); 4] = [
    ("relay.fine_scale", "false"),
    ("relay.redraw_met", "0.0"),
    ("relay.choose_order", "false"),
    ("agent.deployed", "\"trained\""),
];

struct Lines(Sha256);

impl Lines {
    fn add(&mut self, key: &str, value: &impl serde::Serialize) {
        let value = serde_json::to_string(value).expect("a setting can be written as JSON");
        if LATER.contains(&(key, &*value)) {
            return;
        }
        self.0.update(format!("{key}={value}\n"));
    }
}

impl SettingVisitor for Lines {
    type Error = std::convert::Infallible;

    fn visit<T: Value>(&mut self, setting: &'static Setting, value: &T) -> Result<(), Self::Error> {
        if !NOT_HASHED.contains(&setting.key) {
            self.add(setting.key, value);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{EngineKind, Precision, Preset, StartedFrom};

    #[test]
    fn a_run_is_known_by_its_settings_and_its_seed() {
        let config = || Preset::Fast.config("push", 1);
        let id = run_id(&config(), "");

        let mut longer = config();
        longer.env_steps += 1;
        longer.until = 0.5;
        longer.agent.engine = EngineKind::Burn;
        longer.agent.precision = Precision::F32;
        assert_eq!(run_id(&longer, ""), id);

        let mut other = config();
        other.seed += 1;
        assert_ne!(run_id(&other, ""), id);
        let mut other = config();
        other.replay.batch_size += 1;
        assert_ne!(run_id(&other, ""), id);
        assert_ne!(run_id(&config(), "[task]\n"), id);

        let from = |updates| {
            let mut config = config();
            config.from = Some(StartedFrom { task: "push".to_owned(), run: id, updates });
            run_id(&config, "")
        };
        assert_ne!(from(1), id);
        assert_ne!(from(1), from(2));
    }
}
