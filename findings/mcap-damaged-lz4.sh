#!/usr/bin/env bash
# mcap 0.26.0 (Rust): where a flipped bit makes a chunk's LZ4 frame undecodable, the reader returns
# `McapError::Io`, although it reads from memory and has the variant `DecompressionError`. Other bits
# of the same chunk are reported as `BadChunkCrc`, and some as `RecordTooLarge`, since the records of
# a chunk are handed out before its checksum is compared. Whether a damaged recording looks like a
# disk that cannot be read or like a damaged file depends on the bit.
#
# A good guess: `Io` means that reading failed, and damage inside a chunk is `DecompressionError` or
# `BadChunkCrc`.
#
# Seen:
#   of 400 flipped bits inside one LZ4 chunk
#   BadChunkCrc: 373
#   Io: 12
#   RecordTooLarge: 15
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir "$folder/src"
cat > "$folder/Cargo.toml" <<'TOML'
[package]
name = "damaged"
version = "0.0.0"
edition = "2024"

[dependencies]
mcap = { version = "=0.26.0", default-features = false, features = ["lz4"] }
TOML
cat > "$folder/src/main.rs" <<'RUST'
use mcap::records::MessageHeader;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{Compression, McapError, WriteOptions};
use std::collections::BTreeMap;
use std::io::Cursor;

const FLIPS: usize = 400;

fn main() {
    let file = recording();
    assert!(read(&file).is_ok(), "the recording itself is wrong");
    // Past the header, the channel and the head of the chunk, before its index and the summary.
    let chunk = file.len() / 4..file.len() / 2;
    let mut counts = BTreeMap::<_, usize>::new();
    for flip in 0..FLIPS {
        let mut damaged = file.clone();
        damaged[chunk.start + flip * chunk.len() / FLIPS] ^= 0x40;
        let error = read(&damaged).err();
        let name = match &error {
            None => "none".to_owned(),
            Some(McapError::Io(_)) => "Io".to_owned(),
            Some(McapError::BadChunkCrc { .. }) => "BadChunkCrc".to_owned(),
            Some(McapError::DecompressionError(_)) => "DecompressionError".to_owned(),
            Some(McapError::RecordTooLarge { .. }) => "RecordTooLarge".to_owned(),
            Some(other) => format!("{other:?}"),
        };
        *counts.entry(name).or_default() += 1;
    }
    println!("of {FLIPS} flipped bits inside one LZ4 chunk");
    for (name, count) in &counts {
        println!("{name}: {count}");
    }
    let as_seen = counts.contains_key("Io") && !counts.contains_key("DecompressionError");
    assert!(as_seen, "mcap behaves differently now");
}

/// A thousand messages of slowly varying numbers in one chunk.
fn recording() -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let options = WriteOptions::new().compression(Some(Compression::Lz4)).chunk_size(Some(1 << 24));
    let mut writer = options.create(&mut file).unwrap();
    let channel_id = writer.add_channel(0, "numbers", "raw", &BTreeMap::new()).unwrap();
    for sequence in 0..1000_u32 {
        let header = MessageHeader {
            channel_id,
            sequence,
            log_time: u64::from(sequence) * 40_000_000,
            publish_time: u64::from(sequence) * 40_000_000,
        };
        let numbers: Vec<u8> = (0..12_u32)
            .flat_map(|k| (f64::from(sequence * (k + 1)) * 0.01).sin().to_le_bytes())
            .collect();
        writer.write_to_known_channel(&header, &numbers).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    file.into_inner()
}

/// Only whole records are taken out; nothing in them is parsed.
fn read(file: &[u8]) -> Result<usize, McapError> {
    let options = LinearReaderOptions::default()
        .with_validate_chunk_crcs(true)
        .with_record_length_limit(1 << 20);
    let mut reader = LinearReader::new_with_options(options);
    let (mut rest, mut count) = (file, 0);
    while let Some(event) = reader.next_event() {
        match event? {
            LinearReadEvent::ReadRequest(wanted) => {
                let (now, later) = rest.split_at(wanted.min(rest.len()));
                reader.insert(now.len()).copy_from_slice(now);
                reader.notify_read(now.len());
                rest = later;
            }
            LinearReadEvent::Record { .. } => count += 1,
        }
    }
    Ok(count)
}
RUST
CARGO_TARGET_DIR="$folder/target" cargo run --quiet --release --manifest-path "$folder/Cargo.toml"
