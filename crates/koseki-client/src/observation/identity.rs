//! Identities of targets, checked.

use messages::admission::Fault;

use super::fault;

/// Passes a 24-bit address of ICAO on.
///
/// # Errors
/// The fault of a number with more bits.
pub fn address_of(address: u32) -> Result<u32, Fault> {
    let limit = "must be up to six hexadecimal digits";
    let wrong = || fault("address", format!("{address:X}"), limit, "write it as in \"3C6589\"");
    (address < 1 << 24).then_some(address).ok_or_else(wrong)
}

/// Passes a Maritime Mobile Service Identity on.
///
/// # Errors
/// The fault of a number that is none.
pub fn mmsi_of(mmsi: u32) -> Result<u32, Fault> {
    let wrong = || fault("mmsi", mmsi, "must be from 1 to 999999999", "an MMSI has nine digits");
    (1..=999_999_999).contains(&mmsi).then_some(mmsi).ok_or_else(wrong)
}

/// Returns a callsign as samples have it: eight characters, with spaces at the end.
///
/// # Errors
/// The fault of a text that is too long, empty or not ASCII.
pub fn callsign_of(text: &str) -> Result<[u8; 8], Fault> {
    let mut callsign = [b' '; 8];
    if !text.is_ascii() || text.is_empty() || text.len() > callsign.len() {
        let limit = "must be one to eight characters of ASCII";
        return Err(fault("callsign", text, limit, "shorten it"));
    }
    callsign[..text.len()].copy_from_slice(text.as_bytes());
    Ok(callsign)
}
