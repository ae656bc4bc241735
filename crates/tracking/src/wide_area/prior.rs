//! What is known before anything is seen (WA-10).
//!
//! Who comes from where is often known: from this bearing come airliners; from that field, fours of the same type. Such
//! knowledge is of a place, not of a target, so it is stated by place: a sector of bearings from a point, or a circle. It
//! applies to a wide-area report by where its targets came from, or where they are if that is not known, and says two
//! things: which types are likely (module `identification`), and how many fly together. Where a
//! formation of four is likely and two are reported, the correction may count on four.
//!
//! Statements that contradict each other are refused, since nobody could say which one holds: probabilities beyond 1, a type
//! or number stated twice, two sectors from one point or two circles that overlap. Where a sector and a circle overlap, the
//! first one listed holds.

use std::f64::consts::TAU;

use observations::WideAreaReport;

use super::report::TARGETS_MAX;

/// Most types that can be described.
pub const TYPES_MAX: usize = 64;
/// Most places of which something can be known.
pub const PRIORS_MAX: usize = 256;

/// All of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Knowledge {
    /// The types that there are.
    pub types: Vec<TargetType>,
    /// What is known of places.
    pub priors: Vec<Prior>,
}

/// A type of target.
#[derive(Clone, Debug, PartialEq)]
pub struct TargetType {
    /// Its name, for people: 1 to 12 printable characters of ASCII.
    pub name: String,
    /// What it emits; empty if that is not known.
    pub emissions: Vec<EmissionBand>,
}

/// Emissions of one kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmissionBand {
    /// Lowest and highest frequency, hertz.
    pub frequency_hz: [f64; 2],
    /// Shortest and longest time between pulses, seconds, if that tells something.
    pub pulse_interval_s: Option<[f64; 2]>,
}

/// What is known of one place.
#[derive(Clone, Debug, PartialEq)]
pub struct Prior {
    /// The place.
    pub place: Place,
    /// (place in the list of types, probability). What is left to 1 is any type.
    pub types: Vec<(usize, f64)>,
    /// (number of targets that fly together, probability). What is left to 1 is any number.
    pub formations: Vec<(u32, f64)>,
    /// Formations of at least this probability raise the number of a report.
    pub formation_probability_min: f64,
}

/// Where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// Bearings from a point.
    Sector {
        /// East and north of the point, metres.
        from_m: [f64; 2],
        /// First and last bearing, clockwise from north, radians.
        bearings_rad: [f64; 2],
    },
    /// A circle.
    Circle {
        /// East and north of its centre, metres.
        centre_m: [f64; 2],
        /// Metres.
        radius_m: f64,
    },
}

impl Place {
    /// Whether a point, east and north in metres, is there.
    pub fn contains(&self, point_m: [f64; 2]) -> bool {
        match self {
            Self::Sector { from_m, bearings_rad } => {
                let bearing = (point_m[0] - from_m[0]).atan2(point_m[1] - from_m[1]);
                (bearing - bearings_rad[0]).rem_euclid(TAU) <= width(*bearings_rad)
            }
            Self::Circle { centre_m, radius_m } => distance(*centre_m, point_m) <= *radius_m,
        }
    }

    /// Whether two places of the same kind have something in common.
    fn overlaps(&self, other: &Self) -> bool {
        match (self, other) {
            (
                Self::Sector { from_m, bearings_rad },
                Self::Sector {
                    from_m: other_from,
                    bearings_rad: other_bearings,
                },
            ) => {
                let begins_in = |one: &[f64; 2], other: &[f64; 2]| (other[0] - one[0]).rem_euclid(TAU) < width(*one);
                from_m == other_from
                    && (begins_in(bearings_rad, other_bearings) || begins_in(other_bearings, bearings_rad))
            }
            (
                Self::Circle { centre_m, radius_m },
                Self::Circle {
                    centre_m: other_centre,
                    radius_m: other_radius,
                },
            ) => distance(*centre_m, *other_centre) < radius_m + other_radius,
            _ => false,
        }
    }

    fn is_whole(&self) -> bool {
        match self {
            Self::Sector { from_m, bearings_rad } => {
                let all = [*from_m, *bearings_rad];
                all.as_flattened().iter().all(|value| value.is_finite()) && width(*bearings_rad) > 0.0
            }
            Self::Circle { centre_m, radius_m } => {
                centre_m.iter().all(|value| value.is_finite()) && *radius_m > 0.0 && radius_m.is_finite()
            }
        }
    }
}

/// Clockwise from the first to the last bearing, radians.
fn width([first, last]: [f64; 2]) -> f64 {
    (last - first).rem_euclid(TAU)
}

fn distance(one: [f64; 2], other: [f64; 2]) -> f64 {
    (one[0] - other[0]).hypot(one[1] - other[1])
}

impl Knowledge {
    /// What is wrong or contradictory, in one sentence that counts priors from 1; `None` if nothing is.
    pub fn fault(&self) -> Option<String> {
        let band = |[low, high]: [f64; 2]| low > 0.0 && high >= low && high.is_finite();
        let emits = |target: &&TargetType| {
            let whole =
                |emission: &EmissionBand| band(emission.frequency_hz) && emission.pulse_interval_s.is_none_or(band);
            !target.emissions.iter().all(whole)
        };
        if let Some(target) = self.types.iter().find(emits) {
            return Some(format!(
                "type {:?}: bands need a positive lower end that is not above the upper one",
                target.name
            ));
        }
        if self.types.len() > TYPES_MAX || self.priors.len() > PRIORS_MAX {
            return Some(format!(
                "at most {TYPES_MAX} types and {PRIORS_MAX} priors can be described"
            ));
        }
        for (place, target) in self.types.iter().enumerate() {
            if messages::TargetType::new(&target.name, 1.0).is_none() {
                return Some(format!(
                    "type {:?}: its name must have 1 to {} printable characters",
                    target.name,
                    messages::TYPE_NAME_MAX
                ));
            }
            if self.types[..place].iter().any(|other| other.name == target.name) {
                return Some(format!("type {:?} is described twice", target.name));
            }
        }
        for (place, prior) in self.priors.iter().enumerate() {
            if let Some(fault) = prior.fault(self.types.len()) {
                return Some(format!("prior {}: {fault}", place + 1));
            }
            if let Some(other) = self.priors[..place]
                .iter()
                .position(|other| other.place.overlaps(&prior.place))
            {
                return Some(format!(
                    "priors {} and {} speak of the same place; let them adjoin, or join them",
                    other + 1,
                    place + 1
                ));
            }
        }
        None
    }

    /// What is known of a point, east and north in metres.
    pub fn at(&self, point_m: [f64; 2]) -> Option<&Prior> {
        self.priors.iter().find(|prior| prior.place.contains(point_m))
    }

    /// What is known of a report's targets.
    pub fn of(&self, report: &WideAreaReport) -> Option<&Prior> {
        let [east, north, _] = report.position_m;
        self.at(report.origin_m.unwrap_or([east, north]))
    }

    /// The number of targets that a report is taken to mean.
    pub fn targets(&self, report: &WideAreaReport) -> u32 {
        // No formation makes targets of none.
        let prior = self.of(report).filter(|_| report.targets > 0);
        prior.map_or(report.targets, |prior| prior.raised(report.targets))
    }
}

impl Prior {
    fn fault(&self, types: usize) -> Option<&'static str> {
        let twice = |numbers: &[usize]| (1..numbers.len()).any(|place| numbers[..place].contains(&numbers[place]));
        let named: Vec<usize> = self.types.iter().map(|(number, _)| *number).collect();
        let sizes: Vec<usize> = self.formations.iter().map(|(size, _)| *size as usize).collect();
        let of_types = self.types.iter().map(|(_, probability)| *probability);
        let of_sizes = self.formations.iter().map(|(_, probability)| *probability);
        let sum = |all: &mut dyn Iterator<Item = f64>| all.sum::<f64>();
        let proper = |probability: f64| (0.0..=1.0).contains(&probability);
        let checks = [
            (
                self.place.is_whole(),
                "a sector needs two different bearings, a circle a positive radius",
            ),
            (
                of_types.clone().chain(of_sizes.clone()).all(proper),
                "probabilities lie between 0 and 1",
            ),
            (
                sum(&mut of_types.clone()) <= 1.0 + 1e-9,
                "the probabilities of its types sum to more than 1",
            ),
            (
                sum(&mut of_sizes.clone()) <= 1.0 + 1e-9,
                "the probabilities of its formations sum to more than 1",
            ),
            (
                named.iter().all(|number| *number < types),
                "it names a type that is not described",
            ),
            (!twice(&named), "it names a type twice"),
            (!twice(&sizes), "it names a formation twice"),
            (
                sizes.iter().all(|size| (1..=TARGETS_MAX as usize).contains(size)),
                "formations have 1 to 256 members",
            ),
            (
                self.formation_probability_min > 0.0 && self.formation_probability_min <= 1.0,
                "the least probability of formations must be above 0, at most 1",
            ),
        ];
        checks.iter().find(|(holds, _)| !holds).map(|(_, sentence)| *sentence)
    }

    /// The size of the likeliest formation that is likely enough and larger, else the number itself.
    pub fn raised(&self, targets: u32) -> u32 {
        let likely = self
            .formations
            .iter()
            .filter(|(size, probability)| *size > targets && *probability >= self.formation_probability_min);
        let best = likely.max_by(|(one, a), (other, b)| a.total_cmp(b).then(other.cmp(one)));
        best.map_or(targets, |(size, _)| *size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn from_the_north_east() -> Knowledge {
        Knowledge {
            types: vec![TargetType {
                name: "patrol".to_owned(),
                emissions: Vec::new(),
            }],
            priors: vec![Prior {
                place: Place::Sector {
                    from_m: [1e3, 0.0],
                    bearings_rad: [0.2, 1.0],
                },
                types: vec![(0, 0.7)],
                formations: vec![(4, 0.8), (2, 0.1)],
                formation_probability_min: 0.5,
            }],
        }
    }

    fn report(bearing_rad: f64, targets: u32) -> WideAreaReport {
        WideAreaReport {
            time_ns: 0,
            arrival_ns: 0,
            position_m: [1e3 + 5e4 * bearing_rad.sin(), 5e4 * bearing_rad.cos(), 0.0],
            velocity_mps: [0.0; 3],
            targets,
            origin_m: None,
        }
    }

    #[test]
    fn fours_are_expected_only_from_their_sector() {
        let knowledge = from_the_north_east();
        assert_eq!(knowledge.fault(), None);
        for (bearing, targets, expected) in [
            (0.5, 2, 4),
            (0.5, 4, 4),
            (0.5, 5, 5),
            (0.5, 0, 0),
            (0.1, 2, 2),
            (1.1, 2, 2),
            (3.6, 2, 2),
        ] {
            assert_eq!(
                knowledge.targets(&report(bearing, targets)),
                expected,
                "{bearing} {targets}"
            );
        }
        let mut elsewhere = report(2.0, 2);
        elsewhere.origin_m = Some([2e4, 3e4]);
        assert_eq!(knowledge.targets(&elsewhere), 4, "where they came from counts");
        let mut unlikely = knowledge;
        unlikely.priors[0].formations[0].1 = 0.4;
        assert_eq!(unlikely.targets(&report(0.5, 2)), 2);
    }

    #[test]
    fn a_sector_may_span_north() {
        let place = Place::Sector {
            from_m: [0.0; 2],
            bearings_rad: [6.0, 0.3],
        };
        assert!(place.contains([0.0, 1.0]) && place.contains([-0.1, 1.0]) && !place.contains([0.0, -1.0]));
    }

    #[test]
    fn what_contradicts_itself_is_refused_with_its_number() {
        type Spoil = fn(&mut Knowledge);
        let cases: [(&str, Spoil); 11] = [
            ("type \"a long name indeed\": its name", |all| {
                all.types[0].name = "a long name indeed".to_owned()
            }),
            ("at most 64 types", |all| all.types = vec![all.types[0].clone(); 65]),
            ("prior 1: the probabilities of its types", |all| {
                all.priors[0].types[0].1 = 0.9999 + 0.01
            }),
            ("prior 1: the probabilities of its formations", |all| {
                all.priors[0].formations[1].1 = 0.3
            }),
            ("prior 1: probabilities lie", |all| {
                all.priors[0].formations[0].1 = f64::NAN
            }),
            ("prior 1: it names a formation twice", |all| {
                all.priors[0].formations[1].0 = 4
            }),
            ("prior 1: it names a type that", |all| all.priors[0].types[0].0 = 1),
            ("prior 1: formations have", |all| all.priors[0].formations[0].0 = 10_000),
            ("prior 1: a sector needs", |all| {
                all.priors[0].place = Place::Sector {
                    from_m: [0.0; 2],
                    bearings_rad: [1.0, 1.0],
                };
            }),
            ("priors 1 and 2 speak of the same place", |all| {
                let mut other = all.priors[0].clone();
                other.place = Place::Sector {
                    from_m: [1e3, 0.0],
                    bearings_rad: [0.9, 1.5],
                };
                all.priors.push(other);
            }),
            ("type \"patrol\" is described twice", |all| {
                all.types.push(all.types[0].clone())
            }),
        ];
        for (expected, spoil) in cases {
            let mut knowledge = from_the_north_east();
            spoil(&mut knowledge);
            let fault = knowledge.fault().unwrap_or_default();
            let by_value = expected.ends_with("types") && fault.contains("probabilities lie");
            assert!(fault.starts_with(expected) || by_value, "{expected}: {fault}");
        }
        let mut adjoining = from_the_north_east();
        let mut other = adjoining.priors[0].clone();
        other.place = Place::Sector {
            from_m: [1e3, 0.0],
            bearings_rad: [1.0, 1.5],
        };
        adjoining.priors.push(other);
        assert_eq!(adjoining.fault(), None);
    }
}
