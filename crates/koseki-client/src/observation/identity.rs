//! Identities of targets, checked.

use messages::admission::Fault;
use messages::{Identity, IdentityText, NAME_MAX};

use super::fault;

/// Returns an identity with a number of this kind as well: an aircraft's address, a ship's MMSI or a Mode 3/A code.
///
/// # Errors
/// The fault of a number that no target has, or of an MMSI beside an address: a target is an aircraft or a ship.
pub fn numbered(identity: Identity, kind: IdentityText, number: u32) -> Result<Identity, Fault> {
    if !kind.is_possible(number) {
        let limit = format!("must be {}", kind.form);
        let value = match kind.radix {
            16 => format!("{number:X}"),
            8 => format!("{number:o}"),
            _ => number.to_string(),
        };
        return Err(fault(
            kind.key,
            value,
            &limit,
            format!("write it as in \"{}\"", kind.example),
        ));
    }
    let both = kind.set(identity, number);
    if identity
        .unique_number()
        .is_some_and(|before| both.unique_number() != Some(before))
    {
        let limit = "must not stand beside the other number";
        return Err(fault(
            kind.key,
            kind.of(&both).map_or_else(String::new, |text| text.to_string()),
            limit,
            "a target is an aircraft or a ship: leave one of the two out",
        ));
    }
    Ok(both)
}

/// Passes the name of a ship on.
///
/// # Errors
/// The fault of a text that is too long, empty or not ASCII.
pub fn name_of(text: &str) -> Result<&str, Fault> {
    let is_name = (1..=NAME_MAX).contains(&text.len()) && text.is_ascii();
    let limit = format!("must be one to {NAME_MAX} characters of ASCII");
    is_name
        .then_some(text)
        .ok_or_else(|| fault("name", text, &limit, "shorten it"))
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
