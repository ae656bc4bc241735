//! Golden outputs: texts in the repository that an output is compared with, so that a change of behaviour is a visible
//! change of a file.
//!
//! `UPDATE_GOLDEN=1 cargo test` rewrites the files that differ; `git diff` then shows the accepted changes.

use std::fs;
use std::path::Path;

/// Asserts that `found` is the text of the golden file at `path`; with `UPDATE_GOLDEN` in the environment, writes that
/// file.
///
/// # Panics
/// If the texts differ, with the first different line.
pub fn assert_golden(path: &Path, found: &str) {
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        fs::create_dir_all(path.parent().expect("a folder")).expect("the folder can be made");
        fs::write(path, found).expect("the golden file can be written");
    }
    let golden = fs::read_to_string(path)
        .unwrap_or_else(|error| panic!("{}: {error}; UPDATE_GOLDEN=1 makes it", path.display()));
    if found == golden {
        return;
    }
    let mut pairs = (1..).zip(
        found
            .lines()
            .map(Some)
            .chain([None])
            .zip(golden.lines().map(Some).chain([None])),
    );
    let (line, (found, golden)) = pairs.find(|(_, (found, golden))| found != golden).unwrap_or_default();
    panic!(
        "differs from {} in line {line}; UPDATE_GOLDEN=1 accepts it\n  golden: {}\n  found:  {}",
        path.display(),
        golden.unwrap_or("(ends)"),
        found.unwrap_or("(ends)"),
    );
}

/// Hash of a sequence of bytes: FNV-1a with 64 bits. It is the same everywhere and for ever, which that of the
/// standard library does not promise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Digest(u64);

impl Default for Digest {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Digest {
    /// The hash of these bytes.
    pub fn of(octets: &[u8]) -> Self {
        let mut digest = Self::default();
        digest.add(octets);
        digest
    }

    /// Adds bytes.
    pub fn add(&mut self, octets: &[u8]) {
        for octet in octets {
            self.0 = (self.0 ^ u64::from(*octet)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
}

impl std::fmt::Display for Digest {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{:016x}", self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::Digest;

    /// Test vectors of the authors of FNV.
    #[test]
    fn the_hash_is_fnv_1a() {
        assert_eq!(Digest::of(b"").to_string(), "cbf29ce484222325");
        assert_eq!(Digest::of(b"a").to_string(), "af63dc4c8601ec8c");
        assert_eq!(Digest::of(b"foobar").to_string(), "85944171f73967e8");
    }
}
