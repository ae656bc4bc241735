//! Records of a file, and fields of records.
//!
//! The container library's reader allocates as much memory as a record states, and a damaged file can state any size.
//! This module therefore cuts each record within its file or chunk, and each field within its record: memory follows
//! the size of the file.

use std::collections::BTreeMap;
use std::io::Read as _;

use mcap::records::op;

use crate::{CDR, RecordingError};

/// Largest chunk, bytes: a recorder ends a chunk with the slice after which it holds 1 MiB, and no slice is longer than
/// some MiB. A few kilobytes of a hostile file unpack to gigabytes; a reader takes no more memory than this for them.
const UNPACKED_MAX: u64 = 16 << 20;
/// Logarithm of the largest window of a compressed chunk, bytes: what the usual levels of compression need.
const WINDOW_LOG_MAX: u32 = 24;

/// Bytes before the data of a record: code and length.
pub(crate) const HEAD: usize = 9;

/// Bytes before the sample of a message: channel, number, two times.
const MESSAGE_HEAD: u64 = 2 + 4 + 8 + 8;

/// Returns code and length of a record.
pub(crate) fn head_of(head: &[u8; HEAD]) -> (u8, u64) {
    let (code, length) = head.split_first().expect("nine octets");
    (*code, u64::from_le_bytes(length.try_into().expect("eight octets")))
}

/// Whether records of this kind contain items. Other records are skipped.
pub(crate) fn is_needed(code: u8) -> bool {
    matches!(code, op::CHUNK | op::METADATA | op::SCHEMA | op::CHANNEL | op::MESSAGE)
}

/// Returns why a record without items, with this code, length and beginning, is damaged; `None` if it is not.
///
/// Such a record has no checksum: a wrong length would hide the chunks behind it.
pub(crate) fn contradiction(code: u8, length: u64, begin: &[u8]) -> Option<&'static str> {
    let is_right = match code {
        op::MESSAGE_INDEX => begin
            .get(2..6)
            .and_then(|count| count.try_into().ok())
            .is_some_and(|count| length == 6 + u64::from(u32::from_le_bytes(count))),
        op::FOOTER => length == 20,
        op::DATA_END => length == 4,
        op::CHUNK_INDEX | op::ATTACHMENT_INDEX | op::STATISTICS | op::METADATA_INDEX | op::SUMMARY_OFFSET => {
            return Some("a record of the summary is among the data");
        }
        _ => true,
    };
    (!is_right).then_some("the length of a record contradicts its contents")
}

/// Whether there are records of this code: those of the format, and others' own.
pub(crate) fn is_known(code: u8) -> bool {
    const OWN_MIN: u8 = 0x80;
    (op::HEADER..=op::DATA_END).contains(&code) || code >= OWN_MIN
}

/// Data of a record or chunk, and its offset in the file for errors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fields<'a> {
    left: &'a [u8],
    place: u64,
}

impl<'a> Fields<'a> {
    pub(crate) fn of(data: &'a [u8], place: u64) -> Self {
        Self { left: data, place }
    }

    /// Returns the remaining bytes.
    pub(crate) fn rest(self) -> &'a [u8] {
        self.left
    }

    pub(crate) fn damaged(&self, reason: &'static str) -> RecordingError {
        RecordingError::damaged(self.place, reason)
    }

    fn take(&mut self, count: u64) -> Result<&'a [u8], RecordingError> {
        let count = usize::try_from(count).ok();
        let (taken, left) = count
            .and_then(|count| self.left.split_at_checked(count))
            .ok_or_else(|| self.damaged("a field is longer than its record"))?;
        self.left = left;
        Ok(taken)
    }

    fn array<const COUNT: usize>(&mut self) -> Result<[u8; COUNT], RecordingError> {
        Ok(self
            .take(COUNT as u64)?
            .try_into()
            .expect("as many octets as asked for"))
    }

    pub(crate) fn u16(&mut self) -> Result<u16, RecordingError> {
        self.array().map(u16::from_le_bytes)
    }

    pub(crate) fn u32(&mut self) -> Result<u32, RecordingError> {
        self.array().map(u32::from_le_bytes)
    }

    pub(crate) fn u64(&mut self) -> Result<u64, RecordingError> {
        self.array().map(u64::from_le_bytes)
    }

    /// Returns bytes with their number in front.
    pub(crate) fn octets(&mut self) -> Result<&'a [u8], RecordingError> {
        let count = self.u32()?;
        self.take(count.into())
    }

    pub(crate) fn text(&mut self) -> Result<&'a str, RecordingError> {
        let octets = self.octets()?;
        std::str::from_utf8(octets).map_err(|_| self.damaged("a text is not UTF-8"))
    }

    /// Returns texts by name.
    pub(crate) fn map(&mut self) -> Result<BTreeMap<String, String>, RecordingError> {
        let mut pairs = Self::of(self.octets()?, self.place);
        let mut map = BTreeMap::new();
        while !pairs.left.is_empty() {
            let name = pairs.text()?;
            let value = pairs.text()?;
            if map.insert(name.to_owned(), value.to_owned()).is_some() {
                return Err(self.damaged("a name is there twice"));
            }
        }
        Ok(map)
    }

    /// Checks that a record outside chunks ends where its fields end. A message has no length of its own, but begins as
    /// all messages of a recorder do.
    pub(crate) fn check(mut self, code: u8) -> Result<(), RecordingError> {
        match code {
            op::HEADER => drop((self.text()?, self.text()?)),
            op::SCHEMA => drop((self.u16()?, self.text()?, self.text()?, self.octets()?)),
            op::CHANNEL => drop((self.u16()?, self.u16()?, self.text()?, self.text()?, self.octets()?)),
            op::METADATA => drop((self.text()?, self.octets()?)),
            op::MESSAGE => {
                self.take(MESSAGE_HEAD)?;
                self.left = if self.left.starts_with(&CDR) { &[] } else { self.left };
            }
            _ => return Ok(()),
        }
        match self.left {
            [] => Ok(()),
            _ => Err(self.damaged("the length of a record contradicts its contents")),
        }
    }

    /// Returns code and data of the next record of a chunk; `None` at the end.
    pub(crate) fn record(&mut self) -> Result<Option<(u8, Fields<'a>)>, RecordingError> {
        if self.left.is_empty() {
            return Ok(None);
        }
        let (head, left) = self
            .left
            .split_first_chunk()
            .ok_or_else(|| self.damaged("a record in the chunk is cut off"))?;
        let (code, length) = head_of(head);
        self.left = left;
        let data = self
            .take(length)
            .map_err(|_| self.damaged("a record in the chunk is longer than the chunk"))?;
        Ok(Some((code, Self::of(data, self.place))))
    }

    /// Returns the records of a chunk, after checks of its stated size and checksum; those of a compressed chunk are
    /// in `unpacked`.
    pub(crate) fn records(mut self, unpacked: &'a mut Vec<u8>) -> Result<Self, RecordingError> {
        let _times_ns = (self.u64()?, self.u64()?);
        let (size, checksum) = (self.u64()?, self.u32()?);
        let compression = self.text()?;
        if !matches!(compression, "" | "lz4" | "zstd") {
            return Err(self.damaged("the compression of the chunk has no known name"));
        }
        if compression == "lz4" {
            return Err(RecordingError::UnknownCompression(compression.to_owned()));
        }
        let stored = self.u64()?;
        let stored = self.take(stored)?;
        let is_packed = !compression.is_empty();
        if size != stored.len() as u64 && !is_packed || !self.left.is_empty() {
            return Err(self.damaged("the sizes of the chunk contradict each other"));
        }
        let records = match is_packed {
            true => unpack(stored, size, unpacked).map_err(|reason| self.damaged(reason))?,
            false => stored,
        };
        if checksum != 0 && checksum != crc32fast::hash(records) {
            return Err(self.damaged("the checksum of the chunk is wrong"));
        }
        Ok(Self::of(records, self.place))
    }
}

/// Returns the `size` bytes that `packed` contains, by way of `unpacked`; or the kind of damage.
///
/// Memory follows what is unpacked, not what a damaged chunk states.
fn unpack<'u>(packed: &[u8], size: u64, unpacked: &'u mut Vec<u8>) -> Result<&'u [u8], &'static str> {
    if size > UNPACKED_MAX {
        return Err("the chunk states more than 16 MiB, and no recorder writes such chunks");
    }
    unpacked.clear();
    let mut decoder =
        zstd::Decoder::with_buffer(packed).map_err(|_| "no memory for the compressed data of the chunk")?;
    let window = decoder.window_log_max(WINDOW_LOG_MAX);
    window
        .and_then(|()| decoder.take(size + 1).read_to_end(unpacked))
        .map_err(|_| "the compressed data of the chunk contradict themselves")?;
    match unpacked.len() as u64 == size {
        true => Ok(unpacked),
        false => Err("the sizes of the chunk contradict each other"),
    }
}
