//! Health messages: every process publishes state and counters several times a second.

use crate::codes;
use crate::layout::sample;
use crate::{Counters, ProcessKind, Registration};

/// [`Health::source`] of a message about the whole process.
pub const NO_SOURCE: u16 = u16::MAX;

/// Size of [`Health::refusal`], bytes.
pub const REFUSAL_MAX: usize = 256;

/// A name in a [`Health`] message: UTF-8, padded with zeros.
pub type HealthName = [u8; 32];

sample! {
    /// State and counters of one process, or of one source within it.
    Health, size 1880 {
        /// Time of this message, monotonic, nanoseconds.
        said_ns: i64,
        /// Monotonic start time of the process, nanoseconds.
        incarnation: u64,
        /// How far the process has got in the time of its data, UTC, nanoseconds; i64::MIN if unknown.
        progress_ns: i64 = i64::MIN,
        /// Operating system's process number.
        process_id: u32,
        /// Source of the counters; 65535 for the process as a whole.
        source: u16 = NO_SOURCE,
        /// Kind of the process: a `ProcessKind` code.
        kind: u8,
        /// A `LifeState` code.
        life: u8,
        /// Restarts of the process so far, as its launcher counts them.
        restarts: u32,
        /// Input outside an adapter's configuration. Of the process: SAC and SIC of the unknown sender with the most
        /// blocks, 0, 0. Of a source: category, edition before and after the point that fits most blocks, 0.
        misfit: [u8; 4] = [0; 4],
        /// Name of the process, UTF-8, padded with zeros.
        name: [u8; 32],
        /// Fault in a few words, empty if there is none; of an adapter's source its name. UTF-8, padded with zeros.
        note: [u8; 56] = [0; 56],
        /// Input that was refused last, one text for each reason, the latest first: time of day (UTC), line or item,
        /// value, limit, remedy. Characters of control and of writing direction are escaped. UTF-8, padded with zeros.
        refusal: [u8; 256] = [0; REFUSAL_MAX],
        /// Values of the counters.
        counters: Counters,
        /// Biases of the source, if estimated by fusion.
        registration: Registration,
    }
}

impl Health {
    /// Returns the name of the process.
    pub fn name(&self) -> &str {
        text(&self.name)
    }

    /// Returns the trouble of the process, or an empty string; in an adapter's message about a source, the name of
    /// the source.
    pub fn note(&self) -> &str {
        text(&self.note)
    }

    /// Returns this message with another note, cut to the available size.
    #[must_use]
    pub fn with_note(mut self, note: &str) -> Self {
        fill(&mut self.note, note);
        self
    }

    /// Returns the input that was refused last, with the reasons; empty if none was.
    pub fn refusal(&self) -> &str {
        text(&self.refusal)
    }

    /// Returns this message with another text of refused input, cut to the available size.
    #[must_use]
    pub fn with_refusal(mut self, refusal: &str) -> Self {
        fill(&mut self.refusal, refusal);
        self
    }

    /// Returns this message with another name, cut to the available size.
    #[must_use]
    pub fn with_name(mut self, name: &str) -> Self {
        fill(&mut self.name, name);
        self
    }

    /// Returns the kind of the process; `None` for a code of another schema.
    pub fn kind(&self) -> Option<ProcessKind> {
        ProcessKind::from_code(self.kind)
    }

    /// Returns the state of the process's life; `None` for a code of another schema.
    pub fn life(&self) -> Option<LifeState> {
        LifeState::from_code(self.life)
    }
}

pub(crate) fn text(bytes: &[u8]) -> &str {
    let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    std::str::from_utf8(&bytes[..end]).unwrap_or("?")
}

pub(crate) fn fill(bytes: &mut [u8], text: &str) {
    let mut end = text.len().min(bytes.len());
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    bytes.fill(0);
    bytes[..end].copy_from_slice(&text.as_bytes()[..end]);
}

/// Returns `text` without characters that control a terminal or change the direction of writing, which are escaped as
/// in `\u{202e}`: for texts that whoever sends data chooses. At most `characters_max` of `text` are shown.
pub fn printable(text: &str, characters_max: usize) -> String {
    let mut shown = String::with_capacity(text.len().min(characters_max));
    for letter in text.chars().take(characters_max) {
        match letter {
            '"' | '\'' | '\\' => shown.push(letter),
            _ => shown.extend(letter.escape_debug()),
        }
    }
    shown
}

codes! {
    /// State in the life of a process.
    pub enum LifeState: u8 {
        /// Opening its topics.
        Starting = 0, "starting";
        /// Doing its work.
        Running = 1, "running";
        /// Done: all its input is processed, and it will exit.
        Finished = 2, "finished";
        /// Unable to continue; the note states the reason.
        Failed = 3, "failed";
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_of_strangers_are_short_and_cannot_control_a_terminal() {
        let hostile = "\u{1b}[2J\u{202e}\"É\"\\\n".to_owned() + &"x".repeat(10_000);
        let shown = printable(&hostile, 12);
        assert_eq!(shown, "\\u{1b}[2J\\u{202e}\"É\"\\\\nxx");
    }

    #[test]
    fn refusals_are_cut_between_characters() {
        let health = Health::default().with_refusal(&"é".repeat(200));
        assert_eq!(health.refusal(), "é".repeat(128));
        assert_eq!(Health::default().refusal(), "");
    }
}
