//! The records of an MCAP file, which may be damaged: no length in it is believed.

use mcap::McapError;
use mcap::records::{Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::fs::File;
use std::io::{BufReader, Read as _};

/// Longest record or chunk that is read, in bytes: the lengths in a damaged file ask for memory
/// that nobody has. Those that are written are a hundredth of it.
const LONGEST_RECORD: u64 = 1 << 28;

/// The most bytes that LZ4 makes of one.
const LARGEST_EXPANSION: u64 = 255;

/// The records of a file, one after the other.
pub(crate) struct Records {
    file: BufReader<File>,
    /// Bytes of the file that were not read yet.
    left: u64,
    reader: LinearReader,
}

impl Records {
    /// Reads a file of this many bytes; chunks can be skipped, with all messages.
    pub(crate) fn new(file: BufReader<File>, length: u64, skip_chunks: bool) -> Self {
        let longest = LONGEST_RECORD.min(length.saturating_mul(LARGEST_EXPANSION));
        let options = LinearReaderOptions::default()
            .with_skip_end_magic(true)
            .with_validate_chunk_crcs(!skip_chunks)
            .with_emit_chunks(skip_chunks)
            .with_record_length_limit(longest as usize);
        Self { file, left: length, reader: LinearReader::new_with_options(options) }
    }

    /// Hands the next record to `take` if it is one that matters; whether there was any.
    pub(crate) fn next(&mut self, take: impl FnOnce(Record<'_>)) -> Result<bool, McapError> {
        while let Some(event) = self.reader.next_event() {
            // The reader itself reads nothing: what it calls an I/O error is of the decompression.
            let event = event.map_err(|error| match error {
                McapError::Io(error) => McapError::DecompressionError(error.to_string()),
                error => error,
            });
            match event? {
                LinearReadEvent::ReadRequest(wanted) => {
                    // A length in a damaged file asks for more than there is.
                    let wanted = self.left.min(wanted as u64) as usize;
                    let read = self.file.read(self.reader.insert(wanted))?;
                    self.left -= read as u64;
                    self.reader.notify_read(read);
                }
                LinearReadEvent::Record { data, opcode } => {
                    match opcode {
                        op::CHANNEL | op::METADATA if !strings_fit(opcode, data) => {
                            return Err(McapError::UnexpectedEof);
                        }
                        op::CHANNEL | op::METADATA | op::MESSAGE => {
                            take(mcap::parse_record(opcode, data)?);
                        }
                        _ => {}
                    }
                    return Ok(true);
                }
            }
        }
        Ok(false)
    }
}

/// Whether the strings of a record end inside it: its parser reserves what their lengths say.
fn strings_fit(opcode: u8, record: &[u8]) -> bool {
    fn skip_string(bytes: &mut &[u8]) -> Option<()> {
        let (length, rest) = bytes.split_first_chunk()?;
        *bytes = rest.get(u32::from_le_bytes(*length) as usize..)?;
        Some(())
    }
    // Two numbers of 16 bits, the topic and its encoding; or a name. Then a map of strings.
    let (numbers, strings) = if opcode == op::CHANNEL { (4, 2) } else { (0, 1) };
    let walk = || {
        let mut rest = record.get(numbers..)?;
        for _ in 0..strings {
            skip_string(&mut rest)?;
        }
        let (length, rest) = rest.split_first_chunk()?;
        let mut map = rest.get(..u32::from_le_bytes(*length) as usize)?;
        while !map.is_empty() {
            skip_string(&mut map)?;
        }
        Some(())
    };
    walk().is_some()
}
