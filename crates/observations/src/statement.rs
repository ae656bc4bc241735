//! Statement of a target, or of a fixed station, beside motion, by one message.

use messages::{
    AidKind, Emergency, NAME_MAX, NavigationStatus, StageTimes, TargetCategory, TargetStatement,
    target_statement_bits as bits,
};

/// Fixed station, no target: a base station ashore, or an aid to navigation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixedStation {
    /// Latitude and longitude, radians.
    pub place_rad: [f64; 2],
    /// Name in ASCII, padded with blanks; blank: none is stated.
    pub name: [u8; NAME_MAX],
    /// Kind of an aid to navigation; unknown of a base station.
    pub aid: AidKind,
    /// The aid does not exist at its place: a station ashore transmits for the aid.
    pub is_virtual: bool,
    /// The aid, which floats, is off its position.
    pub is_off_position: bool,
}

/// Statement of a target beside its motion. A value that is `None` or unknown was not stated: the former value holds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Statement {
    /// Number of the track at its source, as in the target's reports; the MMSI of a station.
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
    /// The station, if the sender is a fixed station.
    pub station: Option<FixedStation>,
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
        self.station = later.station.or(self.station);
    }

    /// The sample of source number `source`, with the latest transmission at `time_ns` (UTC, nanoseconds). Sequence
    /// number and time of publication are left to the publisher.
    pub fn sample(&self, source: u16, time_ns: i64, stages: StageTimes) -> TargetStatement {
        let [length_m, width_m] = self.size_m.unwrap_or_default();
        let known = [
            (self.size_m.is_some(), bits::SIZE),
            (self.selected_altitude_m.is_some(), bits::SELECTED_ALTITUDE),
            (self.operator_rad.is_some(), bits::OPERATOR),
            (self.station.is_some(), bits::STATION),
            (self.station.is_some_and(|station| station.is_virtual), bits::VIRTUAL),
            (
                self.station.is_some_and(|station| station.is_off_position),
                bits::OFF_POSITION,
            ),
        ];
        let place_rad = self.station.map(|station| station.place_rad).or(self.operator_rad);
        TargetStatement {
            time_ns,
            stages,
            place_deg: place_rad.unwrap_or_default().map(f64::to_degrees),
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
            aid: self.station.map_or(0, |station| station.aid.code()),
            name: self.station.map_or([b' '; NAME_MAX], |station| station.name),
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

    #[test]
    fn an_aid_that_is_back_at_its_position_is_no_longer_off_it() {
        let aid = |is_off_position| Statement {
            track_number: 992_111_840,
            category: TargetCategory::Aid,
            station: Some(FixedStation {
                place_rad: [0.9, 0.1],
                name: *b"ALTE WESER          ",
                aid: AidKind::PortMark,
                is_virtual: false,
                is_off_position,
            }),
            ..Statement::default()
        };
        let mut known = aid(true);
        assert_eq!(
            known.sample(0, 0, StageTimes::default()).valid,
            bits::STATION | bits::OFF_POSITION
        );
        known.update(&aid(false));
        let sample = known.sample(0, 0, StageTimes::default());
        assert_eq!(
            (sample.valid, sample.aid, &sample.name[..10]),
            (bits::STATION, AidKind::PortMark.code(), &b"ALTE WESER"[..])
        );
        assert!((sample.place_deg[0].to_radians() - 0.9).abs() < 1e-12);
    }
}
