//! Settings of formations: number and flight.

use std::f64::consts::{PI, TAU};

use settings::{SettingsError, within};

/// Maximum number of formations of one kind.
const FORMATIONS_MAX: u32 = 10_000;
/// Maximum number of members of a formation.
pub(crate) const MEMBERS_MAX: u32 = 64;
/// Lateral acceleration in turns, m/s² (25° of bank).
const TURN_ACCELERATION_MPS2: f64 = 4.57;
/// Maximum lateral speed of members during joining and parting, m/s.
const SIDEWAYS_MPS: f64 = 50.0;
/// Maximum vertical speed, m/s.
const VERTICAL_MPS: f64 = 20.0;

settings::settings! {
    /// Formations of a kind: targets that arrive separately from far away, join, fly in parallel towards a place,
    /// separate, turn back beside the place, and repeat.
    pub struct FormationSettings {
        check FormationSettings::check;
        /// Number of formations.
        count: u32 = 1, in [1, FORMATIONS_MAX];
        /// Numbers of members of a formation, 1 to 64, with their probabilities, which sum to 1: `[[2, 0.7], [4,
        /// 0.3]]`.
        sizes: Vec<(u32, f64)> = vec![(2, 1.0)], usually "two";
        /// Distance between neighbours while together.
        spacing_m: f64 = 200.0, in [1, 1e5];
        /// Distance between neighbours while apart, at least `spacing_m`.
        apart_m: f64 = 3000.0, in [1, 1e5];
        /// Destination of the formations: east and north.
        position_m: [f64; 2] = [0.0; 2], in [-1e6, 1e6];
        /// First and last bearing of the approaches, seen from the destination, clockwise from north; the formations
        /// are distributed evenly over the sector.
        sector_rad: [f64; 2] = [0.0, TAU], in [-7, 14], usually "from everywhere";
        /// Distances from the destination at which the approach begins and ends.
        way_m: [f64; 2] = [60_000.0, 10_000.0], in [0, 1e6];
        /// Distances from the destination between which the members are together during the approach.
        together_m: [f64; 2] = [45_000.0, 20_000.0], in [0, 1e6];
        /// Distances from the destination between which the formations are approaching when the scenario starts.
        start_m: Option<[f64; 2]> = None, in [0, 1e6], usually "anywhere on their way";
        /// Slowest and fastest speed.
        speed_mps: [f64; 2] = [150.0, 220.0], in [30, 240];
        /// Height.
        height_m: f64 = 3000.0, in [0, 12_000];
        /// Height at the end of the approach, below the sensors' coverage, and on the return.
        low_m: Option<f64> = None, in [0, 12_000], usually "they stay high";
    }
}

impl FormationSettings {
    fn check(&self) -> Result<(), SettingsError> {
        self.check_sizes()?;
        within("apart_m", self.apart_m, self.spacing_m, 1e5)?;
        let [first, last] = self.sector_rad;
        within("sector_rad", last, first, first + TAU)?;
        let [far, near] = self.way_m;
        within("way_m", far, near, 1e6)?;
        within("together_m", self.together_m[0], near, far)?;
        within("together_m", self.together_m[1], near, self.together_m[0])?;
        for start_m in self.start_m.unwrap_or([far; 2]) {
            within("start_m", start_m, near, far)?;
        }
        within("speed_mps", self.speed_mps[1], self.speed_mps[0], 240.0)?;
        within("low_m", self.low_m.unwrap_or(self.height_m), 0.0, self.height_m)?;
        self.speed_mps.into_iter().try_for_each(|speed| self.check_way(speed))
    }

    fn check_sizes(&self) -> Result<(), SettingsError> {
        for (size, probability) in &self.sizes {
            within("sizes", f64::from(*size), 1.0, f64::from(MEMBERS_MAX))?;
            within("sizes", *probability, 0.0, 1.0)?;
        }
        let sum = self.sizes.iter().fold(0.0, |sum, (_, probability)| sum + probability);
        if (sum - 1.0).abs() <= 1e-9 {
            return Ok(());
        }
        let what = format!("the probabilities sum to {sum}, not to 1; write sizes like [[2, 0.7], [4, 0.3]]");
        Err(SettingsError::new("sizes", what))
    }

    /// Checks that the way is long enough at this speed.
    fn check_way(&self, speed_mps: f64) -> Result<(), SettingsError> {
        let [far, near] = self.way_m;
        let least_m = near + self.descent_m(speed_mps) + 1.0;
        within("way_m", far, least_m, 1e6)?;
        let apart_s = self.lap_s(speed_mps) - self.together_s(speed_mps);
        if 2.0 * self.joining_s(self.members_max()) > apart_s {
            let what = format!(
                "{} is too far: formations of {} at {speed_mps} m/s could not part and join again on their way",
                self.apart_m,
                self.members_max()
            );
            return Err(SettingsError::new("apart_m", what));
        }
        Ok(())
    }

    /// Returns the number of members of the largest formation.
    pub(crate) fn members_max(&self) -> u32 {
        self.sizes.iter().map(|(size, _)| *size).max().unwrap_or(0)
    }

    pub(crate) fn turn_radius_m(speed_mps: f64) -> f64 {
        speed_mps.powi(2) / TURN_ACCELERATION_MPS2
    }

    /// Returns the distance flown during the descent, equal to that of the climb, metres.
    pub(crate) fn descent_m(&self, speed_mps: f64) -> f64 {
        let descent_m = self.height_m - self.low_m.unwrap_or(self.height_m);
        0.5 * PI * descent_m / VERTICAL_MPS * speed_mps
    }

    /// Returns the duration of the way in and back.
    pub(crate) fn lap_s(&self, speed_mps: f64) -> f64 {
        let [far, near] = self.way_m;
        2.0 * (far - near + PI * Self::turn_radius_m(speed_mps)) / speed_mps
    }

    /// Returns the duration of close formation.
    pub(crate) fn together_s(&self, speed_mps: f64) -> f64 {
        (self.together_m[0] - self.together_m[1]) / speed_mps
    }

    /// Returns the duration of joining, and of parting, for this number of members.
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
        settings::check(&FormationSettings::default()).expect("defaults are usable");
        let read = |text: &str| {
            let document = settings::Document::parse(text, &[]).expect("well-formed");
            document.read::<FormationSettings>().map_err(|error| error.to_string())
        };
        for (text, expected) in [
            ("count = 0", "count: 0 is out of range; it must lie between 1 and 10000"),
            ("sizes = []", "sizes: the probabilities sum to 0, not to 1"),
            ("sizes = [[2, 0.7]]", "sizes: the probabilities sum to 0.7, not to 1"),
            (
                "sizes = [[65, 1.0]]",
                "sizes: 65 is out of range; it must lie between 1 and 64",
            ),
            (
                "sizes = [[2, nan]]",
                "sizes: NaN is out of range; it must lie between 0 and 1",
            ),
            (
                "apart_m = 100",
                "apart_m: 100 is out of range; it must lie between 200 and 100000",
            ),
            (
                "together_m = [5e4, 5e3]",
                "together_m: 5000 is out of range; it must lie between 10000 and 50000",
            ),
            (
                "way_m = [4e4, 1e4]",
                "together_m: 45000 is out of range; it must lie between 10000 and 40000",
            ),
            (
                "start_m = [7e4, 5e4]",
                "start_m: 70000 is out of range; it must lie between 10000 and 60000",
            ),
            (
                "speed_mps = [200, 150]",
                "speed_mps: 150 is out of range; it must lie between 200 and 240",
            ),
            (
                "low_m = 5000",
                "low_m: 5000 is out of range; it must lie between 0 and 3000",
            ),
            (
                "height_m = 12000\nlow_m = 0",
                "way_m: 60000 is out of range; it must lie between 151",
            ),
            (
                "sizes = [[64, 1.0]]",
                "apart_m: 3000 is too far: formations of 64 at 150 m/s could not part",
            ),
        ] {
            let message = read(text).expect_err("not usable");
            assert!(message.starts_with(expected), "{text}: {message}");
        }
        assert!(read("size = 2").is_err(), "unknown key");
    }
}
