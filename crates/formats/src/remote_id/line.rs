//! Lines of JSON to octets.

use base64::Engine as _;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use serde::Deserialize;

use super::message::{MESSAGE_OCTETS, PACK};
use super::reason::{Read, RemoteIdReason};
use crate::target_message::{Refusal, number_of_name, object, utc_ns};

/// Longest line that is read, octets.
pub const LINE_OCTETS_MAX: usize = 4096;

/// Octets of a pack before the first message: type and version, size of a message, number of messages.
const PACK_HEADER_OCTETS: usize = 3;
/// Most messages of a pack.
const PACK_MAX: usize = 9;
/// Octets of the longest pack.
const PAYLOAD_MAX: usize = PACK_HEADER_OCTETS + PACK_MAX * MESSAGE_OCTETS;

/// With or without the padding at the end.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// A line with a message or a pack.
#[derive(Debug)]
pub(super) struct Line {
    /// Time of receipt, UTC, nanoseconds.
    pub(super) received_ns: i64,
    /// Number of the transmitter, if the line names one.
    pub(super) transmitter: Option<u32>,
    payload: [u8; PAYLOAD_MAX],
    /// Place of the messages in the payload.
    begin: usize,
    end: usize,
}

#[derive(Deserialize)]
struct Keys {
    time: f64,
    payload: String,
    mac: Option<String>,
}

impl Line {
    pub(super) fn read(line: &[u8]) -> Read<Self> {
        if line.len() > LINE_OCTETS_MAX {
            return Err(Refusal::new(RemoteIdReason::Length, "line of", line.len()));
        }
        let keys: Keys = object(line).map_err(|error| Refusal::new(RemoteIdReason::Json, "JSON", error))?;
        let time = utc_ns(keys.time).ok_or_else(|| Refusal::new(RemoteIdReason::Time, "time", keys.time));
        let mac = keys.mac.map(|mac| mac.trim().to_ascii_uppercase());
        let transmitter = mac
            .filter(|mac| !mac.is_empty())
            .map(|mac| number_of_name(mac.as_bytes()));
        let payload = keys.payload.trim();
        let wrong = || Refusal::new(RemoteIdReason::Payload, "payload", payload);
        let (octets, length) = octets(payload).ok_or_else(wrong)?;
        let [begin, end] = match length {
            MESSAGE_OCTETS => [0, MESSAGE_OCTETS],
            _ if octets[0] >> 4 != PACK || usize::from(octets[1]) != MESSAGE_OCTETS => return Err(wrong()),
            _ => {
                let end = PACK_HEADER_OCTETS + usize::from(octets[2]) * MESSAGE_OCTETS;
                [PACK_HEADER_OCTETS, end]
            }
        };
        if begin == end || end > length {
            return Err(wrong());
        }
        Ok(Self {
            received_ns: time?,
            transmitter,
            payload: octets,
            begin,
            end,
        })
    }

    pub(super) fn messages(&self) -> impl Iterator<Item = &[u8; MESSAGE_OCTETS]> {
        self.payload[self.begin..self.end].as_chunks().0.iter()
    }
}

/// Octets of a payload, and their number.
fn octets(text: &str) -> Option<([u8; PAYLOAD_MAX], usize)> {
    let is_length = |octets: usize| {
        let of_messages = octets.saturating_sub(PACK_HEADER_OCTETS);
        let is_pack = of_messages > 0 && of_messages.is_multiple_of(MESSAGE_OCTETS) && octets <= PAYLOAD_MAX;
        octets == MESSAGE_OCTETS || is_pack
    };
    let mut octets = [0; PAYLOAD_MAX];
    // No text of base64 has the length of hexadecimal digits: 36 characters or 4 for each 3 octets, not 50 or 2 each.
    if text.len().is_multiple_of(2) && is_length(text.len() / 2) {
        for (octet, digits) in octets.iter_mut().zip(text.as_bytes().as_chunks::<2>().0) {
            let [high, low] = digits.map(|digit| char::from(digit).to_digit(16));
            *octet = (high? << 4 | low?) as u8;
        }
        return Some((octets, text.len() / 2));
    }
    let length = BASE64.decode_slice(text, &mut octets).ok()?;
    is_length(length).then_some((octets, length))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_length_distinguishes_the_two_writings() {
        let hex_lengths: Vec<_> = [25]
            .into_iter()
            .chain((1..=9).map(|count| 3 + 25 * count))
            .map(|octets| 2 * octets)
            .collect();
        for count in hex_lengths.iter().map(|length| length / 2) {
            let written: Vec<u8> = (0..count).map(|place| place as u8 ^ 0xf1).collect();
            let hex: String = written.iter().map(|octet| format!("{octet:02x}")).collect();
            let base64 = BASE64.encode(&written);
            for text in [&hex, &hex.to_uppercase(), &base64, base64.trim_end_matches('=')] {
                let (found, length) = octets(text).unwrap();
                assert_eq!(found[..length], written, "{text}");
            }
            assert!(!hex_lengths.contains(&base64.len()) && !hex_lengths.contains(&base64.trim_end_matches('=').len()));
        }
        for text in [
            "",
            "00",
            "zz",
            &"0".repeat(52),
            &"x".repeat(50),
            &"A".repeat(400),
            &"A".repeat(4000),
        ] {
            assert!(octets(text).is_none(), "{text}");
        }
    }
}
