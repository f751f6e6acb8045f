//! A checkpoint with a good checksum is a run whose parts fit each other, or an error.

#![no_main]

use libfuzzer_sys::fuzz_target;
use rher_core::Trainer;
use rher_core::testing::Carry;
use rher_core::train::checkpoint::{CHECKPOINT_FOLDER, read_config, read_critic, read_variant};
use std::cell::LazyCell;
use tempfile::TempDir;

/// Bytes of the header: magic, version, length and checksum.
const HEADER: usize = 24;

thread_local! {
    static FOLDER: LazyCell<TempDir> = LazyCell::new(|| {
        let folder = TempDir::new().unwrap();
        std::fs::create_dir(folder.path().join(CHECKPOINT_FOLDER)).unwrap();
        folder
    });
}

fuzz_target!(|file: &[u8]| {
    let Some((header, content)) = file.split_at_checked(HEADER) else { return };
    let mut file = header.to_vec();
    file[12..20].copy_from_slice(&(content.len() as u64).to_le_bytes());
    file[20..24].copy_from_slice(&crc32fast::hash(content).to_le_bytes());
    file.extend(content);
    FOLDER.with(|folder| {
        let folder = folder.path();
        std::fs::write(folder.join(CHECKPOINT_FOLDER).join("current.ckpt"), &file).unwrap();
        if read_config(folder).is_ok() {
            read_variant(folder).unwrap();
            read_critic(folder).unwrap();
            let _ = Trainer::resume(folder, vec![Carry::new()], 1);
        }
    });
});
