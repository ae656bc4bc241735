//! Sizes of targets by type.

use std::collections::BTreeMap;

use messages::TargetType;

const VESSEL: &str = "vessel";

settings::settings! {
    /// Sizes of targets: different points of one target lie no farther apart. Larger differences between sources are
    /// errors, not points.
    pub struct TargetSizeSettings {
        /// Targets of unknown type.
        unknown_m: f64 = 80.0, in [1, 5000];
        /// Speed below which a target of unknown type may be a vessel, m/s: it is as large as one then.
        slow_mps: f64 = 20.0, in [0, 1000];
        /// Targets by type.
        type_m: BTreeMap<String, f64> = BTreeMap::from([("aircraft".to_owned(), 80.0), (VESSEL.to_owned(), 450.0)]),
            in [1, 5000];
    }
}

impl TargetSizeSettings {
    /// Size of a target of this type, metres, that moves with a speed in m/s.
    pub fn of(&self, target_type: &TargetType, speed_mps: f64) -> f64 {
        let slow = (speed_mps < self.slow_mps).then_some(VESSEL);
        let named = target_type.name().or(slow).and_then(|name| self.type_m.get(name));
        *named.unwrap_or(&self.unknown_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_size_is_looked_up_by_type() {
        let sizes = TargetSizeSettings::default();
        let of = |name| sizes.of(&TargetType::new(name, 0.9).unwrap(), 100.0);
        let unknown = |speed_mps| sizes.of(&TargetType::default(), speed_mps);
        assert_eq!(
            [of("vessel"), of("A320"), unknown(100.0), unknown(9.0)],
            [450.0, 80.0, 80.0, 450.0]
        );
    }

    #[test]
    fn stated_sizes_take_the_place_of_the_usual_ones() {
        let sizes = TargetSizeSettings {
            unknown_m: 30.0,
            type_m: BTreeMap::from([("ferry".to_owned(), 120.0)]),
            ..TargetSizeSettings::default()
        };
        let of = |name| sizes.of(&TargetType::new(name, 0.9).unwrap(), 9.0);
        assert_eq!(
            [of("ferry"), of("vessel"), sizes.of(&TargetType::default(), 0.0)],
            [120.0, 30.0, 30.0]
        );
    }
}
