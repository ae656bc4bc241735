//! Whether a file is text, by its beginning.
//!
//! Data blocks have no mark, so that letters of text are lengths of blocks by accident. What is text is recognised
//! before anything is looked for that has no mark.

use std::borrow::Cow;

/// Bytes at the beginning of a text that are looked at.
pub(crate) const TEXT_BYTES: usize = 1 << 12;
/// Byte order mark.
pub(crate) const MARK: char = '\u{feff}';

/// Beginning of a file as text, if all of it is text: letters without control characters, in UTF-8 or, with few letters
/// beyond ASCII, in a code page of an older system.
pub(crate) fn text(bytes: &[u8]) -> Option<Cow<'_, str>> {
    /// Letters of which at most one is no ASCII.
    const OF_ASCII: usize = 8;
    let beginning = &bytes[..bytes.len().min(TEXT_BYTES)];
    let text = match std::str::from_utf8(beginning) {
        Ok(text) => Cow::Borrowed(text),
        // The last letter may be cut.
        Err(error) if error.valid_up_to() + 4 > beginning.len() && bytes.len() > TEXT_BYTES => {
            Cow::Borrowed(std::str::from_utf8(&beginning[..error.valid_up_to()]).ok()?)
        }
        Err(_) => {
            let others = beginning.iter().filter(|octet| !octet.is_ascii()).count();
            (OF_ASCII * others <= beginning.len()).then(|| String::from_utf8_lossy(beginning))?
        }
    };
    let is_text = |letter: char| !letter.is_control() || letter.is_ascii_whitespace();
    text.trim_start_matches(MARK).chars().all(is_text).then_some(text)
}
