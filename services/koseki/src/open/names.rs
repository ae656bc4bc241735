//! Names and dates as a configuration has them.

use std::path::Path;

use jiff::tz::TimeZone;
use jiff::{Timestamp, Zoned};

/// Characters of a name.
const NAME_MAX: usize = 24;

/// Returns a name for a file or feed: its letters, digits and hyphens.
pub(super) fn name_of(what: &str) -> String {
    let stem = match what.split_once("://") {
        Some((scheme, _)) => scheme.to_owned(),
        None => {
            let stem = Path::new(what).file_stem().unwrap_or_default();
            stem.to_string_lossy().into_owned()
        }
    };
    let letters = stem
        .chars()
        .map(|letter| if letter.is_ascii_alphanumeric() { letter } else { '-' });
    let name: String = letters.take(NAME_MAX).collect();
    let name = name.trim_matches('-').to_ascii_lowercase();
    if name.is_empty() { "opened".to_owned() } else { name }
}

/// Returns the date of a time, UTC, nanoseconds since 1970.
pub(super) fn date(utc_ns: i64) -> String {
    let at = Timestamp::from_nanosecond(i128::from(utc_ns)).unwrap_or(Timestamp::UNIX_EPOCH);
    let at: Zoned = at.to_zoned(TimeZone::UTC);
    at.date().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_names_of_sources() {
        assert_eq!(name_of("/data/Radar West_2.pcap"), "radar-west-2");
        assert_eq!(name_of("tcp://10.0.0.1:30005"), "tcp");
        assert_eq!(name_of("..."), "opened");
    }

    #[test]
    fn dates_are_those_of_utc() {
        assert_eq!(date(1_717_664_319_147_975_000), "2024-06-06");
    }
}
