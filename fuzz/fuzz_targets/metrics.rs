//! Metrics are evaluations that follow each other, or an error.

#![no_main]

use libfuzzer_sys::fuzz_target;
use rher_runs::{METRICS_FILE, MetricsFile, read_evaluations};
use std::cell::LazyCell;
use tempfile::TempDir;

thread_local! {
    static FOLDER: LazyCell<TempDir> = LazyCell::new(|| TempDir::new().unwrap());
}

fuzz_target!(|file: &[u8]| {
    FOLDER.with(|folder| {
        let path = folder.path().join(METRICS_FILE);
        std::fs::write(&path, file).unwrap();
        if let Ok(evaluations) = read_evaluations(folder.path(), None) {
            assert!(evaluations.iter().all(|evaluation| !evaluation.success.is_empty()));
            let steps = evaluations.iter().map(|evaluation| evaluation.env_steps);
            assert!(steps.is_sorted());
        }
        let run = "00112233445566778899aabbccddeeff".parse().unwrap();
        let _ = MetricsFile::resume(&path, run, 1);
    });
});
