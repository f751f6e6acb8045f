//! A plan with the right hash of its lines is a plan that can be written again, or an error.

#![no_main]

use libfuzzer_sys::fuzz_target;
use rher_runs::settings;
use rher_runs::sweep::{Cell, Plan};
use serde_json::Value;
use sha2::{Digest as _, Sha256};
use std::cell::LazyCell;
use tempfile::TempDir;

thread_local! {
    static FOLDER: LazyCell<TempDir> = LazyCell::new(|| TempDir::new().unwrap());
}

/// Everything that a cell says.
fn content(cell: &Cell) -> (String, String, String) {
    let folder = cell.folder.to_str().unwrap().to_owned();
    (cell.group.clone(), folder, settings::to_toml(&cell.settings).unwrap())
}

fuzz_target!(|file: &[u8]| {
    // A wrong hash would keep out almost everything.
    let mut file = file.to_vec();
    if let Some(end) = file.iter().position(|byte| *byte == b'\n')
        && let Ok(Value::Object(mut first)) = serde_json::from_slice(&file[..end])
    {
        let hash = &Sha256::digest(&file[end + 1..])[..16];
        let hash: String = hash.iter().map(|byte| format!("{byte:02x}")).collect();
        first.insert("id".to_owned(), hash.into());
        file.splice(..end, Value::Object(first).to_string().into_bytes());
    }
    FOLDER.with(|folder| {
        let [path, again] = ["plan.jsonl", "again.jsonl"].map(|name| folder.path().join(name));
        std::fs::write(&path, &file).unwrap();
        if let Ok(plan) = Plan::read(&path) {
            let _ = std::fs::remove_file(&again);
            Plan::write(&again, plan.cells().to_vec()).unwrap();
            let read = Plan::read(&again).unwrap();
            assert!(plan.cells().iter().map(content).eq(read.cells().iter().map(content)));
        }
    });
});
