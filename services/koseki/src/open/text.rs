//! The configuration of what was opened.

use std::fmt::Write as _;
use std::path::Path;

use jiff::tz::TimeZone;
use jiff::{Timestamp, Zoned};

use super::judge::{Opened, OpenedInput};

/// Characters of a name.
const NAME_MAX: usize = 24;

/// Values of a configuration.
#[derive(Debug)]
pub(super) struct ConfigText<'a> {
    pub(super) name: &'a str,
    /// Origin of the system frame, degrees.
    pub(super) place_deg: [f64; 2],
    /// First day of recordings.
    pub(super) date: Option<String>,
    /// Address for browsers.
    pub(super) listen: Option<String>,
    pub(super) opened: &'a [Opened],
}

impl ConfigText<'_> {
    /// Returns the file.
    pub(super) fn text(&self) -> String {
        let [latitude, longitude] = self.place_deg;
        let mut out = format!(
            "# Written by `koseki open`; start it again by `koseki up`.\nname = \"{}\"\n\n[frame]\nlatitude_deg = \
             {latitude:?}\nlongitude_deg = {longitude:?}\n",
            self.name
        );
        if let Some(date) = &self.date {
            // By time of measurement: the same files give the same tracks, and the run ends with them.
            let _ = write!(out, "\n[time]\ndate = \"{date}\"\norder = \"time\"\n");
        }
        if let Some(listen) = &self.listen {
            let _ = write!(out, "\n[display]\nlisten = \"{listen}\"\n");
        }
        if self.date.is_some() {
            out.push_str("\n[recorder]\nformat = [\"mcap\"]\n");
        }
        let mut names = Vec::new();
        for opened in self.opened {
            opened.write(&mut names, &mut out);
        }
        out
    }
}

impl Opened {
    /// Appends the tables of the sources; `names` are those in use.
    fn write(&self, names: &mut Vec<String>, out: &mut String) {
        let receiver = match &self.input {
            OpenedInput::File(_) => None,
            OpenedInput::Feed(keys) => {
                let name = new_name(&format!("{}-in", self.label), names);
                let _ = write!(out, "\n[[receiver]]\nname = \"{name}\"\n{keys}");
                Some(name)
            }
        };
        for source in &self.sources {
            let label = match source.suffix.as_str() {
                "" => self.label.clone(),
                suffix => format!("{}-{suffix}", self.label),
            };
            let name = new_name(&label, names);
            let _ = write!(out, "\n[[source]]\nname = \"{name}\"\n{}", source.keys);
            match (&self.input, &receiver) {
                (OpenedInput::File(path), _) => {
                    let _ = write!(out, "[source.recorded]\nfile = {:?}\n", path.display().to_string());
                }
                (OpenedInput::Feed(_), name) => {
                    let _ = write!(
                        out,
                        "[source.live]\nreceiver = \"{}\"\n",
                        name.as_deref().unwrap_or_default()
                    );
                }
            }
            out.push_str(&source.input_keys);
            out.push_str(&source.tables);
        }
    }
}

/// Returns a name that is not in use, and notes it.
fn new_name(wanted: &str, names: &mut Vec<String>) -> String {
    let name = (1..)
        .map(|count| match count {
            1 => wanted.to_owned(),
            count => format!("{wanted}-{count}"),
        })
        .find(|name| !names.contains(name))
        .unwrap_or_default();
    names.push(name.clone());
    name
}

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
        let mut names = Vec::new();
        let given: Vec<String> = (0..3).map(|_| new_name("a", &mut names)).collect();
        assert_eq!(given, ["a", "a-2", "a-3"]);
    }

    #[test]
    fn dates_are_those_of_utc() {
        assert_eq!(date(1_717_664_319_147_975_000), "2024-06-06");
    }
}
