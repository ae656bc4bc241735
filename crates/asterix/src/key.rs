//! Names in the tables as keys of JSON.

use std::fmt;

/// Most octets of a [`Key`].
pub(super) const KEY_OCTETS: usize = 24;

/// A name as the key of a JSON object: in quotation marks, with the colon.
#[derive(Clone, Copy)]
pub struct Key {
    /// The text, and zeros behind it: a copy of constant length takes a few instructions.
    pub(super) text: [u8; KEY_OCTETS],
    pub(super) length: u8,
}

impl Key {
    /// The key of a name. Does not compile where the name is too long, or is not the same in JSON.
    pub(super) const fn new(name: &str) -> Self {
        let name = name.as_bytes();
        assert!(name.len() + 3 <= KEY_OCTETS, "a name is too long for a key");
        let mut text = [0; KEY_OCTETS];
        text[0] = b'"';
        let mut i = 0;
        while i < name.len() {
            let is_plain = matches!(name[i], b' '..=b'~') && name[i] != b'"' && name[i] != b'\\';
            assert!(is_plain, "a name needs an escape in JSON");
            text[i + 1] = name[i];
            i += 1;
        }
        text[name.len() + 1] = b'"';
        text[name.len() + 2] = b':';
        Self {
            text,
            length: name.len() as u8 + 3,
        }
    }
}

impl fmt::Debug for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.text[..usize::from(self.length)].escape_ascii().fmt(f)
    }
}
