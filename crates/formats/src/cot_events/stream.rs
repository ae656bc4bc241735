//! Octets to events.
//!
//! An event begins with `<event` and ends with `</event>`. Octets between events, such as declarations of XML, are
//! counted only.

use super::reason::CotReason;

/// Longest event that is read, octets.
pub const EVENT_OCTETS_MAX: usize = 1 << 16;

const BEGIN: &[u8] = b"<event";
const END: &[u8] = b"</event";
/// Octets of an end with the most blanks before its bracket.
const END_MAX: usize = 16;

/// Divides a stream into events.
#[derive(Debug)]
pub(super) struct EventStream {
    /// The event that has begun, else as much as may be the beginning of one.
    octets: Vec<u8>,
    is_inside: bool,
    between: u64,
}

impl EventStream {
    pub(super) fn new() -> Self {
        Self {
            octets: Vec::with_capacity(EVENT_OCTETS_MAX),
            is_inside: false,
            between: 0,
        }
    }

    /// Octets that belong to no event.
    pub(super) fn between(&self) -> u64 {
        self.between
    }

    /// Takes octets; calls `each` for each whole event, and for the octets of each refused one.
    pub(super) fn take(&mut self, octets: &[u8], each: &mut dyn FnMut(&[u8], Option<CotReason>)) {
        for octet in octets {
            self.octets.push(*octet);
            if self.is_inside {
                self.inside(*octet, each);
            } else if begins(&self.octets) {
                self.is_inside = true;
            } else if self.octets.len() > BEGIN.len() {
                self.octets.remove(0);
                self.between += 1;
            }
        }
    }

    /// The input has ended.
    pub(super) fn end(&mut self, each: &mut dyn FnMut(&[u8], Option<CotReason>)) {
        if self.is_inside {
            each(&self.octets, Some(CotReason::Partial));
        } else {
            self.between += self.octets.len() as u64;
        }
        self.octets.clear();
        self.is_inside = false;
    }

    fn inside(&mut self, octet: u8, each: &mut dyn FnMut(&[u8], Option<CotReason>)) {
        if octet == b'>' && ends(&self.octets) {
            each(&self.octets, None);
            self.octets.clear();
            self.is_inside = false;
        } else if begins(&self.octets) {
            // The event before was cut.
            let cut = self.octets.len() - BEGIN.len() - 1;
            each(&self.octets[..cut], Some(CotReason::Partial));
            self.octets.drain(..cut);
        } else if self.octets.len() >= EVENT_OCTETS_MAX {
            each(&self.octets, Some(CotReason::Length));
            self.octets.clear();
            self.is_inside = false;
        }
    }
}

/// Whether these octets end in the begin of an event and one more.
fn begins(octets: &[u8]) -> bool {
    let Some((last, before)) = octets.split_last() else {
        return false;
    };
    let is_delimiter = last.is_ascii_whitespace() || [b'>', b'/'].contains(last);
    is_delimiter && before.ends_with(BEGIN)
}

/// Whether these octets end in the end of an event.
fn ends(octets: &[u8]) -> bool {
    let last = &octets[octets.len().saturating_sub(END_MAX)..];
    let begin = last.iter().rposition(|octet| *octet == b'<').unwrap_or(0);
    let blanks = last[begin..].strip_prefix(END).and_then(|rest| rest.strip_suffix(b">"));
    blanks.is_some_and(|blanks| blanks.iter().all(u8::is_ascii_whitespace))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parts(text: &str) -> (Vec<(String, Option<CotReason>)>, u64) {
        let mut stream = EventStream::new();
        let mut found = Vec::new();
        let mut each = |octets: &[u8], reason| found.push((String::from_utf8_lossy(octets).into_owned(), reason));
        stream.take(text.as_bytes(), &mut each);
        stream.end(&mut each);
        (found, stream.between())
    }

    #[test]
    fn a_stream_is_divided_at_the_ends_of_events() {
        let (found, between) = parts("<?xml?><event a='1'><b></b></event>\n<events/><event></event ><event x");
        let texts: Vec<_> = found.iter().map(|(text, reason)| (text.as_str(), *reason)).collect();
        assert_eq!(
            texts,
            [
                ("<event a='1'><b></b></event>", None),
                ("<event></event >", None),
                ("<event x", Some(CotReason::Partial)),
            ]
        );
        assert_eq!(between, 7 + 1 + 9);
    }

    #[test]
    fn a_cut_event_does_not_take_the_next_one_with_it() {
        let (found, _) = parts("<event uid='1'><point lat=<event uid='2'></event>");
        let texts: Vec<_> = found.iter().map(|(text, reason)| (text.as_str(), *reason)).collect();
        assert_eq!(
            texts,
            [
                ("<event uid='1'><point lat=", Some(CotReason::Partial)),
                ("<event uid='2'></event>", None),
            ]
        );
    }

    #[test]
    fn an_endless_event_is_refused_at_its_bound() {
        let (found, between) = parts(&format!("<event >{}", ">".repeat(EVENT_OCTETS_MAX)));
        assert_eq!(found.len(), 1);
        assert_eq!(
            (found[0].0.len(), found[0].1),
            (EVENT_OCTETS_MAX, Some(CotReason::Length))
        );
        assert_eq!(between, 8);
    }
}
