//! Keys of the labels on the map.

use serde_json::{Value, json};
use settings::SettingsError;

/// Most lines of a label.
const LINES_MAX: usize = 3;
/// Most fields of a line.
const FIELDS_MAX: usize = 6;

settings::words! {
    /// Field of a label.
    pub enum LabelField {
        /// Callsign; without it code, address, or number of the track.
        Name = "name",
        /// Callsign.
        Callsign = "callsign",
        /// 24-bit address, or MMSI.
        Address = "address",
        /// Mode 3/A code.
        Code = "code",
        /// Number of the system track.
        Number = "number",
        /// Type of the aircraft or ship.
        Type = "type",
        /// Level, altitude or height, with an arrow for climb or descent.
        Level = "level",
        /// Rate of climb: hundreds of feet a minute, or metres per second.
        Climb = "climb",
        /// Ground speed: knots, or metres per second.
        Speed = "speed",
        /// Track angle, degrees.
        Angle = "angle",
        /// Number of contributing sources.
        Sources = "sources",
        /// Source with the largest weight.
        Main = "main",
    }
}

settings::settings! {
    /// Labels of the tracks on the map.
    pub struct LabelSettings {
        check LabelSettings::check;
        /// Fields of each line, the most important line first: one to three lines. The first line also has the members
        /// of a group, and alerts.
        lines: Vec<Vec<LabelField>> = default_lines();
        /// Filter of the page, as in "fl<100 main=approach": tracks that match it get their labels before others.
        prefer: Option<String> = None;
    }
}

fn default_lines() -> Vec<Vec<LabelField>> {
    use LabelField::{Level, Main, Name, Sources, Speed, Type};
    vec![vec![Name], vec![Level, Speed], vec![Sources, Main, Type]]
}

impl LabelSettings {
    fn check(&self) -> Result<(), SettingsError> {
        let lines = self.lines.len();
        if !(1..=LINES_MAX).contains(&lines) {
            let what = format!("has {lines} lines; a label has 1 to {LINES_MAX}");
            return Err(SettingsError::new("lines", what));
        }
        match self
            .lines
            .iter()
            .position(|line| !(1..=FIELDS_MAX).contains(&line.len()))
        {
            Some(line) => {
                let found = self.lines[line].len();
                let what = format!("line {} has {found} fields; a line has 1 to {FIELDS_MAX}", line + 1);
                Err(SettingsError::new("lines", what))
            }
            None => Ok(()),
        }
    }

    /// Returns the labels as the page reads them: `lines` of words, and the filter `prefer`, empty without one.
    pub(crate) fn message(&self) -> Value {
        let words = |line: &Vec<LabelField>| line.iter().map(|field| field.word()).collect::<Vec<_>>();
        let lines: Vec<_> = self.lines.iter().map(words).collect();
        json!({"lines": lines, "prefer": self.prefer.as_deref().unwrap_or_default()})
    }
}
