//! What a reader does behind damage: where the next chunk begins, and which channels there are.
//!
//! A recorder writes chunks that are complete by themselves: each holds whole slices and has a checksum. A flipped
//! bit in a chunk therefore costs this chunk. If the bit is in a length, the next chunk is found by its beginning:
//! its code, and three sizes that agree with each other. Records outside chunks have no checksum; each length is
//! compared with the contents, so that a wrong length hides no chunk.
//!
//! Two bits cost more. Channels are described in the chunk in which they begin, and again in the summary at the end of
//! a complete file: in a file without an end, a damaged description costs all samples of its channels. A bit in the
//! first eight bytes costs the whole file, which then does not begin as a recording.

use std::io::{self, ErrorKind, Read, Seek, SeekFrom};
use std::ops::Range;

use mcap::records::op;

use crate::record::{HEAD, head_of};

/// Bytes from the beginning of a chunk to its records: head, two times, size, checksum, name of the compression, stored
/// size. The name is empty or `zstd`; a chunk without compression is longer than this by a message.
const CHUNK_HEAD: usize = NAME + ZSTD.len() + 8;
/// Place of the name.
const NAME: usize = HEAD + 8 + 8 + 8 + 4 + 4;
/// Name of the compression.
const ZSTD: &[u8] = b"zstd";
/// Bytes searched at once.
const BLOCK: usize = 1 << 16;
/// Bytes from the beginning of the last record to the end of a complete file.
const FOOTER: usize = HEAD + 20 + mcap::MAGIC.len();

/// Returns the place of the first chunk that begins within `places` and is whole in a file of `length` bytes.
///
/// # Errors
/// If the file cannot be read.
pub(crate) fn next_chunk<R: Read + Seek>(file: &mut R, places: Range<u64>, length: u64) -> io::Result<Option<u64>> {
    let mut block = Vec::with_capacity(BLOCK);
    let mut begin = places.start;
    while begin < places.end {
        block.clear();
        file.seek(SeekFrom::Start(begin))?;
        let bytes = (places.end - begin).saturating_add(CHUNK_HEAD as u64 - 1);
        file.by_ref().take(bytes.min(BLOCK as u64)).read_to_end(&mut block)?;
        let found = block.windows(CHUNK_HEAD).enumerate().find(|(at, window)| {
            let head = window.first_chunk().expect("as long as a head");
            is_chunk(head, length.saturating_sub(begin + *at as u64))
        });
        if let Some((at, _)) = found {
            return Ok(Some(begin + at as u64));
        }
        // The last bytes may begin a head that continues in the next block.
        let Some(searched) = (block.len() + 1)
            .checked_sub(CHUNK_HEAD)
            .filter(|searched| *searched > 0)
        else {
            break;
        };
        begin += searched as u64;
    }
    Ok(None)
}

/// Whether the record of another program from `place` to `end` is a chunk with a wrong code, or hides a chunk.
///
/// # Errors
/// If the file cannot be read.
pub(crate) fn hides_chunk<R: Read + Seek>(file: &mut R, place: u64, end: u64, length: u64) -> io::Result<bool> {
    let mut head = [0; CHUNK_HEAD];
    if length.saturating_sub(place) >= CHUNK_HEAD as u64 {
        file.seek(SeekFrom::Start(place))?;
        file.read_exact(&mut head)?;
        head[0] = op::CHUNK;
    }
    Ok(is_chunk(&head, length - place) || next_chunk(file, place + 1..end, length)?.is_some())
}

/// Whether a chunk begins with these bytes and ends within `left` bytes.
fn is_chunk(head: &[u8; CHUNK_HEAD], left: u64) -> bool {
    if head[0] != op::CHUNK {
        return false;
    }
    let (_, length) = head_of(head.first_chunk().expect("a longer array"));
    let number = |at: usize| u64::from_le_bytes(head[at..at + 8].try_into().expect("eight bytes"));
    let name = match head[NAME - 4..NAME] {
        [0, 0, 0, 0] => 0,
        [4, 0, 0, 0] if head[NAME..].starts_with(ZSTD) => ZSTD.len(),
        _ => return false,
    };
    let (size, stored) = (number(HEAD + 16), number(NAME + name));
    (size == stored || name > 0)
        && stored.checked_add((NAME + name + 8 - HEAD) as u64) == Some(length)
        && length.checked_add(HEAD as u64).is_some_and(|bytes| bytes <= left)
}

/// Returns the place of the summary that the end of a complete file states, 0 without a summary; `None` if the file has
/// no end.
///
/// # Errors
/// If the file cannot be read.
pub(crate) fn footer<R: Read + Seek>(file: &mut R, length: u64) -> io::Result<Option<u64>> {
    let Some(footer) = length.checked_sub(FOOTER as u64) else {
        return Ok(None);
    };
    let mut end = [0; FOOTER];
    file.seek(SeekFrom::Start(footer))?;
    file.read_exact(&mut end)?;
    let (code, stated) = head_of(end.first_chunk().expect("a longer array"));
    let summary = u64::from_le_bytes(end[HEAD..HEAD + 8].try_into().expect("eight bytes"));
    let is_end = code == op::FOOTER && stated == 20 && end.ends_with(mcap::MAGIC);
    Ok(is_end.then_some(summary))
}

/// Passes code and data of the records in the summary of a complete file to `visit`, if they have at most `bytes_max`.
///
/// # Errors
/// If the file cannot be read.
pub(crate) fn summary<R: Read + Seek>(
    file: &mut R,
    length: u64,
    bytes_max: usize,
    mut visit: impl FnMut(u8, &[u8]),
) -> io::Result<()> {
    let (Some(mut at), footer) = (footer(file, length)?, length.saturating_sub(FOOTER as u64)) else {
        return Ok(());
    };
    if at == 0 {
        return Ok(());
    }
    let mut data = Vec::new();
    while at + (HEAD as u64) <= footer {
        let mut head = [0; HEAD];
        file.seek(SeekFrom::Start(at))?;
        match file.read_exact(&mut head) {
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => break,
            read => read?,
        }
        let (code, length) = head_of(&head);
        let Some(next) = (at + HEAD as u64).checked_add(length).filter(|next| *next <= footer) else {
            break;
        };
        if length <= bytes_max as u64 {
            data.clear();
            file.by_ref().take(length).read_to_end(&mut data)?;
            visit(code, &data);
        }
        at = next;
    }
    Ok(())
}
