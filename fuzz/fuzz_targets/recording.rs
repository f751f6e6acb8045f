//! A recording is read to its end, or is an error.

#![no_main]

use libfuzzer_sys::fuzz_target;
use rher_record::Recording;
use std::cell::LazyCell;
use tempfile::TempDir;

thread_local! {
    static FOLDER: LazyCell<TempDir> = LazyCell::new(|| TempDir::new().unwrap());
}

fuzz_target!(|file: &[u8]| {
    FOLDER.with(|folder| {
        for name in ["whole.mcap", "cut-off.part.mcap"] {
            let path = folder.path().join(name);
            std::fs::write(&path, file).unwrap();
            if let Ok(recording) = Recording::open(&path) {
                recording.for_each(drop);
            }
        }
    });
});
