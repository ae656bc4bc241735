//! Length of the readable part of a file.
//!
//! A file consists of magic bytes and records: a code, a length of eight bytes, and the data. A chunk is one record.
//! A killed process leaves the beginning of a file, so that all whole records are sound.

use std::io::{ErrorKind, Read, Seek, SeekFrom};

use crate::record::{HEAD, head_of, is_known};

/// Code of the last record.
const FOOTER: u8 = 0x02;
/// Code of the record after the data.
const DATA_END: u8 = 0x0f;

/// Usable beginning of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReadablePart {
    /// Length of whole data records from the beginning, bytes; 0 for a file of another kind.
    pub bytes: u64,
    /// Whether the file has its end.
    pub is_ended: bool,
}

/// Returns the usable beginning of a file.
///
/// # Errors
/// If the file cannot be read at all.
pub fn whole<R: Read + Seek>(file: &mut R) -> std::io::Result<ReadablePart> {
    let file_bytes = file.seek(SeekFrom::End(0))?;
    file.rewind()?;
    let mut magic = [0; mcap::MAGIC.len()];
    if !read(file, &mut magic)? || magic != *mcap::MAGIC {
        return Ok(ReadablePart {
            bytes: 0,
            is_ended: false,
        });
    }
    whole_from(file, magic.len() as u64, file_bytes)
}

/// Returns the end of the whole records from `from` on, in a file of so many bytes.
///
/// # Errors
/// If the file cannot be read at all.
fn whole_from<R: Read + Seek>(file: &mut R, from: u64, file_bytes: u64) -> std::io::Result<ReadablePart> {
    file.seek(SeekFrom::Start(from))?;
    let mut at = ReadablePart {
        bytes: from,
        is_ended: false,
    };
    let mut magic = [0; mcap::MAGIC.len()];
    let mut next = from;
    let mut in_data = true;
    let mut head = [0; HEAD];
    while read(file, &mut head)? {
        let (code, length) = head_of(&head);
        let end = (next + head.len() as u64).saturating_add(length);
        if end > file_bytes || !is_known(code) {
            break;
        }
        file.seek(SeekFrom::Start(end))?;
        next = end;
        in_data &= code != DATA_END;
        if in_data {
            at.bytes = end;
        }
        if code == FOOTER {
            at.is_ended = read(file, &mut magic)? && magic == *mcap::MAGIC;
            break;
        }
    }
    Ok(at)
}

/// Fills `bytes`; `false` if the file ends before.
fn read<R: Read>(file: &mut R, bytes: &mut [u8]) -> std::io::Result<bool> {
    match file.read_exact(bytes) {
        Ok(()) => Ok(true),
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => Ok(false),
        Err(error) => Err(error),
    }
}

/// Returns an end of file without index, for a file that was cut after its whole records.
pub fn closing() -> Vec<u8> {
    let mut bytes = vec![DATA_END];
    bytes.extend(4u64.to_le_bytes());
    bytes.extend([0; 4]);
    bytes.push(FOOTER);
    bytes.extend(20u64.to_le_bytes());
    bytes.extend([0; 20]);
    bytes.extend(mcap::MAGIC);
    bytes
}
