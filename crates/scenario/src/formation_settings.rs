//! What formations there are, and how they fly.

use std::f64::consts::{PI, TAU};

use serde::Deserialize;

use crate::error::{SettingsError, count_within, within};

/// Most formations of one kind.
const FORMATIONS_MAX: u32 = 10_000;
/// Most members of a formation.
pub(crate) const MEMBERS_MAX: u32 = 64;
/// Lateral acceleration in turns, m/s² (25° of bank).
const TURN_ACCELERATION_MPS2: f64 = 4.57;
/// Greatest speed sideways while members join or part, m/s.
const SIDEWAYS_MPS: f64 = 50.0;
/// Greatest vertical speed, m/s.
const VERTICAL_MPS: f64 = 20.0;

/// Formations of one kind: targets that come from far away, each by itself, join, fly side by side towards a place, part
/// again, turn back beside it, and come again. What is not given has the value in brackets.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FormationSettings {
    /// How many formations there are, 1 to 10,000 (1).
    pub count: u32,
    /// How many members one has, 1 to 64, and with what probability; the probabilities sum to 1 (two).
    pub sizes: Vec<(u32, f64)>,
    /// Distance between neighbours while together, metres, 1 to 100,000 (200).
    pub spacing_m: f64,
    /// Distance between neighbours before and after, metres, at least `spacing_m` (3,000).
    pub apart_m: f64,
    /// Where they fly to: east and north, metres (0, 0).
    pub position_m: [f64; 2],
    /// First and last bearing, from there, of where they come from, radians clockwise from north; formations share the sector
    /// evenly (0 and 2π: from everywhere).
    pub sector_rad: [f64; 2],
    /// Farthest and nearest distance of the way in, metres (60,000 and 10,000).
    pub way_m: [f64; 2],
    /// Distances between which they are together on the way in, metres (45,000 and 20,000).
    pub together_m: [f64; 2],
    /// Distances between which they are on the way in when the scenario starts, metres; not given: anywhere on their way.
    pub start_m: Option<[f64; 2]>,
    /// Slowest and fastest speed, m/s, 30 to 240 (150 and 220).
    pub speed_mps: [f64; 2],
    /// Height, metres, 0 to 12,000 (3,000).
    pub height_m: f64,
    /// Height to which they descend at the end of the way in, below what sensors see, and in which they return, metres (not
    /// given: they stay high).
    pub low_m: Option<f64>,
}

impl Default for FormationSettings {
    fn default() -> Self {
        Self {
            count: 1,
            sizes: vec![(2, 1.0)],
            spacing_m: 200.0,
            apart_m: 3000.0,
            position_m: [0.0; 2],
            sector_rad: [0.0, TAU],
            way_m: [60_000.0, 10_000.0],
            together_m: [45_000.0, 20_000.0],
            start_m: None,
            speed_mps: [150.0, 220.0],
            height_m: 3000.0,
            low_m: None,
        }
    }
}

impl FormationSettings {
    /// Checks every value.
    ///
    /// # Errors
    /// The first setting that cannot be used, with its value and what it has to be.
    pub fn validate(&self) -> Result<(), SettingsError> {
        count_within("formation.count", self.count, 1, FORMATIONS_MAX)?;
        self.validate_sizes()?;
        within("formation.spacing_m", self.spacing_m, 1.0, 1e5)?;
        within("formation.apart_m", self.apart_m, self.spacing_m, 1e5)?;
        for coordinate_m in self.position_m {
            within("formation.position_m", coordinate_m, -1e6, 1e6)?;
        }
        let [first, last] = self.sector_rad;
        within("formation.sector_rad", first, -7.0, 7.0)?;
        within("formation.sector_rad", last, first, first + TAU)?;
        let [far, near] = self.way_m;
        within("formation.way_m", near, 0.0, 1e6)?;
        within("formation.way_m", far, near, 1e6)?;
        within("formation.together_m", self.together_m[0], near, far)?;
        within("formation.together_m", self.together_m[1], near, self.together_m[0])?;
        for start_m in self.start_m.unwrap_or([far; 2]) {
            within("formation.start_m", start_m, near, far)?;
        }
        within("formation.speed_mps", self.speed_mps[0], 30.0, 240.0)?;
        within("formation.speed_mps", self.speed_mps[1], self.speed_mps[0], 240.0)?;
        within("formation.height_m", self.height_m, 0.0, 12_000.0)?;
        if let Some(low_m) = self.low_m {
            within("formation.low_m", low_m, 0.0, self.height_m)?;
        }
        self.speed_mps
            .into_iter()
            .try_for_each(|speed| self.validate_way(speed))
    }

    fn validate_sizes(&self) -> Result<(), SettingsError> {
        if self.sizes.is_empty() {
            let limit = "a list of sizes with probabilities, like [[2, 0.7], [4, 0.3]]";
            return Err(SettingsError::new("formation.sizes", "[]", limit));
        }
        for (size, probability) in &self.sizes {
            count_within("formation.sizes", *size, 1, MEMBERS_MAX)?;
            within("formation.sizes", *probability, 0.0, 1.0)?;
        }
        let sum: f64 = self.sizes.iter().map(|(_, probability)| probability).sum();
        if (sum - 1.0).abs() > 1e-9 {
            let limit = "probabilities that sum to 1";
            return Err(SettingsError::new(
                "formation.sizes",
                format_args!("a sum of {sum}"),
                limit,
            ));
        }
        Ok(())
    }

    /// Whether the way is long enough at this speed.
    fn validate_way(&self, speed_mps: f64) -> Result<(), SettingsError> {
        let [far, near] = self.way_m;
        let least_m = near + self.descent_m(speed_mps) + 1.0;
        within("formation.way_m", far, least_m, 1e6)?;
        let apart_s = self.lap_s(speed_mps) - self.together_s(speed_mps);
        if 2.0 * self.joining_s(self.members_max()) > apart_s {
            let limit = format_args!(
                "less: formations of {} at {speed_mps} m/s could not part and join again on their way",
                self.members_max()
            );
            return Err(SettingsError::new("formation.apart_m", self.apart_m, limit));
        }
        Ok(())
    }

    /// Members of the largest formation.
    pub(crate) fn members_max(&self) -> u32 {
        self.sizes.iter().map(|(size, _)| *size).max().unwrap_or(0)
    }

    pub(crate) fn turn_radius_m(speed_mps: f64) -> f64 {
        speed_mps.powi(2) / TURN_ACCELERATION_MPS2
    }

    /// Way on which they descend, and climb again, metres.
    pub(crate) fn descent_m(&self, speed_mps: f64) -> f64 {
        let descent_m = self.height_m - self.low_m.unwrap_or(self.height_m);
        0.5 * PI * descent_m / VERTICAL_MPS * speed_mps
    }

    /// Duration of the way in and back.
    pub(crate) fn lap_s(&self, speed_mps: f64) -> f64 {
        let [far, near] = self.way_m;
        2.0 * (far - near + PI * Self::turn_radius_m(speed_mps)) / speed_mps
    }

    /// For how long they are together.
    pub(crate) fn together_s(&self, speed_mps: f64) -> f64 {
        (self.together_m[0] - self.together_m[1]) / speed_mps
    }

    /// For how long a formation of so many members joins, and parts.
    pub(crate) fn joining_s(&self, members: u32) -> f64 {
        let outermost = 0.5 * f64::from(members.saturating_sub(1));
        (0.5 * PI * outermost * (self.apart_m - self.spacing_m) / SIDEWAYS_MPS).max(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_name_key_value_and_limit() {
        FormationSettings::default().validate().expect("defaults are usable");
        let refused = |text: &str| {
            let settings: FormationSettings = toml::from_str(text).expect("well-formed");
            settings.validate().expect_err("not usable").to_string()
        };
        for (text, expected) in [
            ("count = 0", "formation.count = 0: must be between 1 and 10000"),
            ("sizes = []", "formation.sizes = []: must be a list of sizes with"),
            (
                "sizes = [[2, 0.7]]",
                "formation.sizes = a sum of 0.7: must be probabilities that sum to 1",
            ),
            ("sizes = [[65, 1.0]]", "formation.sizes = 65: must be between 1 and 64"),
            ("sizes = [[2, nan]]", "formation.sizes = NaN: must be between 0 and 1"),
            (
                "apart_m = 100",
                "formation.apart_m = 100: must be between 200 and 100000",
            ),
            (
                "together_m = [5e4, 5e3]",
                "formation.together_m = 5000: must be between 10000 and 50000",
            ),
            (
                "way_m = [4e4, 1e4]",
                "formation.together_m = 45000: must be between 10000 and 40000",
            ),
            (
                "start_m = [7e4, 5e4]",
                "formation.start_m = 70000: must be between 10000 and 60000",
            ),
            (
                "speed_mps = [200, 150]",
                "formation.speed_mps = 150: must be between 200 and 240",
            ),
            ("low_m = 5000", "formation.low_m = 5000: must be between 0 and 3000"),
            (
                "height_m = 12000\nlow_m = 0",
                "formation.way_m = 60000: must be between 151",
            ),
            (
                "sizes = [[64, 1.0]]",
                "formation.apart_m = 3000: must be less: formations of 64 at 150 m/s could not part",
            ),
        ] {
            let message = refused(text);
            assert!(message.starts_with(expected), "{text}: {message}");
        }
        assert!(toml::from_str::<FormationSettings>("size = 2").is_err(), "unknown key");
    }
}
