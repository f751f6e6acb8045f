//! Settings: their values, their files and their documents.

use rher_core::config::Preset;
use rher_envs::{OptionValue, Task};
use rher_runs::settings::{Comments, from_table, list, reference, resolve, to_toml, to_toml_with};
use rher_runs::{Asked, Settings};
use sha2::{Digest as _, Sha256};
use std::fmt::Write as _;
use std::path::Path;

/// Settings of a task, changed by `set`.
fn settings(task: Task, preset: Preset, set: &[(&str, &str)]) -> Settings {
    let set = set.iter().map(|(key, value)| {
        let table: toml::Table = format!("value = {value}").parse().unwrap();
        ((*key).to_owned(), table["value"].clone())
    });
    let asked = Asked { preset: Some(preset), set: set.collect(), ..Asked::default() };
    resolve(task, &asked).unwrap()
}

/// `tests/runs/data/presets.txt` is a list of the SHA-256 of what `rher config <TASK> --preset
/// <PRESET>` printed before settings were declared in one place. A change of a default changes it;
/// the change log then says so.
#[test]
fn settings_of_every_preset_stay_as_they_are() {
    let mut hashes = String::new();
    for task in Task::ALL {
        for preset in [Preset::Fast, Preset::SampleEfficient, Preset::Paper] {
            let text = to_toml(&settings(*task, preset, &[])).unwrap();
            let hash = Sha256::digest(text.as_bytes());
            let hash: String =
                hash[..8].iter().fold(String::new(), |text, byte| text + &format!("{byte:02x}"));
            writeln!(hashes, "{task} {} {hash}", preset.name()).unwrap();
        }
    }
    renew("data/presets.txt", &hashes);
    assert_eq!(hashes, include_str!("data/presets.txt"));
}

#[test]
fn files_of_earlier_runs_are_read_and_written_as_they_were() {
    let stack = settings(
        Task::STACK,
        Preset::Fast,
        &[("randomize.mass", "[0.5, 2]"), ("agent.hidden", "[64, 32]"), ("seed", "7")],
    );
    let obstacle = settings(
        Task::OBSTACLE_PUSH,
        Preset::Fast,
        &[("randomize.mass", "[0.5, 2]"), ("task.observe_obstacle", "false")],
    );
    assert_eq!(obstacle.options.task.0["observe_obstacle"], OptionValue::Flag(false));
    let drawer = settings(Task::DRAWER_BOX, Preset::Fast, &[]);
    for (name, file, settings) in [
        ("data/stack.toml", include_str!("data/stack.toml"), stack),
        ("data/obstacle-push.toml", include_str!("data/obstacle-push.toml"), obstacle),
        ("data/drawer-box.toml", include_str!("data/drawer-box.toml"), drawer),
    ] {
        renew(name, &to_toml(&settings).unwrap());
        let read = from_table(file.parse().unwrap()).unwrap();
        assert_eq!(to_toml(&read).unwrap(), file);
        assert_eq!(to_toml(&settings).unwrap(), file);
        for comments in [Comments::Short, Comments::Full] {
            let text = to_toml_with(&settings, comments).unwrap();
            assert_eq!(from_table(text.parse().unwrap()).unwrap(), read, "{text}");
        }
    }
}

#[test]
fn every_setting_is_explained_in_every_document() {
    let page = reference().unwrap();
    let list = list();
    for task in Task::ALL {
        let settings = settings(*task, Preset::Fast, &[]);
        let plain = to_toml(&settings).unwrap();
        let mut section = String::new();
        for line in plain.lines() {
            if let Some(name) = line.strip_prefix('[') {
                section = name.replace(']', ".");
            } else if let Some((name, _)) = line.split_once(" = ") {
                let key = format!("{section}{name}");
                assert!(page.contains(&format!("\n### `{key}`\n\n")), "{key}");
                assert!(list.contains(&format!("\n  {key} ")), "{key}");
            }
        }
        for comments in [Comments::Short, Comments::Full] {
            let text = to_toml_with(&settings, comments).unwrap();
            let mut above = "";
            for line in text.lines() {
                if line.contains(" = ") && !line.starts_with('#') {
                    assert!(above.starts_with("# "), "{line}");
                }
                above = line;
            }
        }
    }
}

#[test]
fn the_page_of_settings_is_what_the_program_writes() {
    let page = reference().unwrap();
    renew("../../docs/settings.md", &page);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/settings.md");
    assert!(
        std::fs::read_to_string(path).unwrap() == page,
        "renew it: RHER_RENEW_DOCS=1 cargo test --release --test runs"
    );
}

/// Writes a file below `tests/runs/` anew if that is asked for; what the compiler has read of it is
/// still the old text.
fn renew(file: &str, text: &str) {
    if std::env::var_os("RHER_RENEW_DOCS").is_some() {
        let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/runs");
        std::fs::write(tests.join(file), text).unwrap();
    }
}
