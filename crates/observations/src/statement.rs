//! What a target states beside its motion, by one message.

use messages::{
    Emergency, NavigationStatus, StageTimes, TargetCategory, TargetStatement, target_statement_bits as bits,
};

/// Statement of a target beside its motion. What is `None` or unknown was not stated, and stays what it was.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Statement {
    /// Number of the track at its source, as in the target's reports.
    pub track_number: u32,
    /// Category.
    pub category: TargetCategory,
    /// Navigation status.
    pub navigation: NavigationStatus,
    /// Emergency.
    pub emergency: Emergency,
    /// Length and width, metres.
    pub size_m: Option<[f32; 2]>,
    /// Altitude selected in the aircraft's autopilot, metres of the standard atmosphere.
    pub selected_altitude_m: Option<f32>,
    /// Latitude and longitude of the operator of an unmanned aircraft, radians.
    pub operator_rad: Option<[f64; 2]>,
}

impl Statement {
    /// Takes over what a later statement states.
    pub fn update(&mut self, later: &Self) {
        let Self { track_number, .. } = *later;
        self.track_number = track_number;
        if later.category != TargetCategory::Unknown {
            self.category = later.category;
        }
        if later.navigation != NavigationStatus::Unknown {
            self.navigation = later.navigation;
        }
        if later.emergency != Emergency::Unknown {
            self.emergency = later.emergency;
        }
        self.size_m = later.size_m.or(self.size_m);
        self.selected_altitude_m = later.selected_altitude_m.or(self.selected_altitude_m);
        self.operator_rad = later.operator_rad.or(self.operator_rad);
    }

    /// The sample of source number `source` at `time_ns` (UTC, nanoseconds); sequence number and time of publication
    /// are left to the publisher.
    pub fn sample(&self, source: u16, time_ns: i64, stages: StageTimes) -> TargetStatement {
        let [length_m, width_m] = self.size_m.unwrap_or_default();
        let known = [
            (self.size_m.is_some(), bits::SIZE),
            (self.selected_altitude_m.is_some(), bits::SELECTED_ALTITUDE),
            (self.operator_rad.is_some(), bits::OPERATOR),
        ];
        TargetStatement {
            time_ns,
            stages,
            operator_deg: self.operator_rad.unwrap_or_default().map(f64::to_degrees),
            length_m,
            width_m,
            selected_altitude_m: self.selected_altitude_m.unwrap_or_default(),
            track_number: self.track_number,
            source,
            category: self.category.code(),
            navigation: self.navigation.code(),
            emergency: self.emergency.code(),
            valid: known
                .into_iter()
                .filter(|(is_known, _)| *is_known)
                .fold(0, |all, (_, bit)| all | bit),
            ..TargetStatement::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_stated_stays_what_it_was() {
        let mut known = Statement {
            track_number: 7,
            category: TargetCategory::Cargo,
            size_m: Some([200.0, 30.0]),
            ..Statement::default()
        };
        known.update(&Statement {
            track_number: 7,
            navigation: NavigationStatus::Anchored,
            ..Statement::default()
        });
        assert_eq!(known.category, TargetCategory::Cargo);
        let sample = known.sample(3, 5, StageTimes::default());
        assert_eq!(
            (sample.length_m, sample.navigation),
            (200.0, NavigationStatus::Anchored.code())
        );
        assert_eq!((sample.valid, sample.source, sample.time_ns), (bits::SIZE, 3, 5));
    }
}
