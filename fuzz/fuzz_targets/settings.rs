//! A settings file is the settings of a run, or an error.

#![no_main]

use libfuzzer_sys::fuzz_target;
use rher_envs::Task;
use rher_runs::{Asked, CONFIG_FILE, ConfigFile, settings};
use std::cell::LazyCell;
use tempfile::TempDir;

thread_local! {
    static FOLDER: LazyCell<TempDir> = LazyCell::new(|| TempDir::new().unwrap());
}

fuzz_target!(|file: &[u8]| {
    FOLDER.with(|folder| {
        let path = folder.path().join(CONFIG_FILE);
        std::fs::write(&path, file).unwrap();
        let asked = Asked { config: Some(path), ..Asked::default() };
        for task in [Task::REACH, Task::CUE_PUSH] {
            if let Ok(settings) = settings::resolve(task, &asked) {
                settings.config.validate().unwrap();
                settings::to_toml(&settings).unwrap();
            }
        }
        if let Ok(Some(file)) = ConfigFile::read(folder.path()) {
            let _ = file.settings();
        }
    });
});
