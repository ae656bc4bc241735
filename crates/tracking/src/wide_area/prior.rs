//! Prior knowledge about places: likely types and sizes of formations (WA-10).
//!
//! The usual origin of targets is often known: airliners come from this bearing; groups of four of the same type come
//! from that field. Such knowledge refers to a place: a sector of bearings from a point, or a circle. The knowledge
//! applies to a wide-area report by the origin of the targets, or by the position if the origin is unknown. The content
//! is the likely types (module `identification`) and the likely sizes of formations. If a formation of four is likely
//! and two are reported, the correction may count on four.
//!
//! Contradictory statements are rejected, because no rule could choose between them: probabilities beyond 1, a type
//! or number stated twice, two sectors from one point, or two circles that overlap. If a sector and a circle
//! overlap, the first in the list holds.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;

use observations::WideAreaReport;
use settings::{Degrees, SettingsError};

use super::report::TARGETS_MAX;

/// Most types that can be described.
pub const TYPES_MAX: usize = 64;
/// Most places of which something can be known.
pub const PRIORS_MAX: usize = 256;
/// Rounding errors of a sum of probabilities.
const SUM_MORE: f64 = 1e-9;

settings::settings! {
    /// Types of targets, and what is known of places (WA-10).
    pub struct Knowledge {
        check Knowledge::check;
        /// Type of target.
        types as "type": Vec<TargetType> = Vec::new();
        /// Prior knowledge about a place.
        priors as "prior": Vec<Prior> = Vec::new();
    }

    /// Type of target.
    pub struct TargetType {
        check TargetType::check;
        /// Name, for people: 1 to 12 printable characters of ASCII, none of them `,`, `|` or `"`.
        name: String;
        /// Kinds of emissions of the type, as far as known.
        emissions: Vec<EmissionBand> = Vec::new();
    }

    /// Kind of emission.
    #[derive(Copy)]
    pub struct EmissionBand {
        check EmissionBand::check;
        /// Lowest and highest frequency.
        frequency_hz: [f64; 2];
        /// Shortest and longest time between pulses, if characteristic.
        pulse_interval_s: Option<[f64; 2]> = None;
    }

    /// Prior knowledge about a place: exactly one of `sector` and `circle`.
    pub struct Prior {
        check Prior::check;
        /// Bearings from a point.
        sector: Option<Sector> = None;
        /// A circle.
        circle: Option<Circle> = None;
        /// Probabilities of types, by name. The remainder to 1 is the probability of any other type.
        types: BTreeMap<String, f64> = BTreeMap::new(), in [0, 1];
        /// Probabilities of formations with this number of targets. The remainder to 1 is the probability of any
        /// other number.
        formations: BTreeMap<String, f64> = BTreeMap::new(), in [0, 1];
        /// Formations of at least this probability raise the number of a report.
        formation_probability_min: f64 = 0.5, in [1e-6, 1];
    }

    /// Bearings from a point.
    #[derive(Copy)]
    pub struct Sector {
        check Sector::check;
        /// East and north of the point.
        from_m: [f64; 2], in [-1e7, 1e7];
        /// First and last bearing, clockwise from north.
        bearings_deg: [Degrees; 2], in [-360, 360];
    }

    /// A circle in the plane.
    #[derive(Copy)]
    pub struct Circle {
        /// East and north of the circle's centre.
        centre_m: [f64; 2], in [-1e7, 1e7];
        /// Radius.
        radius_m: f64, in [1e-3, 1e7];
    }
}

impl Sector {
    fn check(&self) -> Result<(), SettingsError> {
        if self.width_rad() > 0.0 {
            return Ok(());
        }
        let [first, last] = self.bearings_deg.map(Degrees::deg);
        let what = format!(
            "[{first}, {last}]: write two different bearings, clockwise from the first to the last; all around is a circle"
        );
        Err(SettingsError::new("bearings_deg", what))
    }

    fn contains(&self, point_m: [f64; 2]) -> bool {
        let bearing = (point_m[0] - self.from_m[0]).atan2(point_m[1] - self.from_m[1]);
        self.clockwise_rad(bearing) <= self.width_rad()
    }

    /// From the first to the last bearing.
    fn width_rad(&self) -> f64 {
        self.clockwise_rad(self.bearings_deg[1].rad())
    }

    /// From the first bearing to this bearing.
    fn clockwise_rad(&self, bearing_rad: f64) -> f64 {
        (bearing_rad - self.bearings_deg[0].rad()).rem_euclid(TAU)
    }

    fn overlaps(&self, other: &Self) -> bool {
        let begins_in = |one: &Self, other: &Self| one.clockwise_rad(other.bearings_deg[0].rad()) < one.width_rad();
        self.from_m == other.from_m && (begins_in(self, other) || begins_in(other, self))
    }
}

impl EmissionBand {
    fn check(&self) -> Result<(), SettingsError> {
        let band = |key: &str, [low, high]: [f64; 2]| {
            // Written so that NaN is rejected.
            if low > 0.0 && low <= high && high.is_finite() {
                return Ok(());
            }
            let what = format!("[{low}, {high}]: write the lowest and the highest value, greater than 0");
            Err(SettingsError::new(key, what))
        };
        band("frequency_hz", self.frequency_hz)?;
        self.pulse_interval_s
            .map_or(Ok(()), |interval_s| band("pulse_interval_s", interval_s))
    }
}

impl TargetType {
    fn check(&self) -> Result<(), SettingsError> {
        let name = self.name.as_str();
        // Names are columns of files that have no quotes.
        let fits =
            messages::TargetType::new(name, 1.0).is_some() && name.trim() == name && !name.contains([',', '|', '"']);
        if fits {
            return Ok(());
        }
        let what = format!(
            "{name:?} cannot be a name: use 1 to {} printable ASCII characters, none of them , | or \", and no blank at \
             either end",
            messages::TYPE_NAME_MAX
        );
        Err(SettingsError::new("name", what))
    }
}

impl Knowledge {
    /// Checks the statement for contradictions.
    fn check(&self) -> Result<(), SettingsError> {
        let most = [
            ("type", self.types.len(), TYPES_MAX),
            ("prior", self.priors.len(), PRIORS_MAX),
        ];
        if let Some((key, count, most)) = most.into_iter().find(|(_, count, most)| count > most) {
            return Err(SettingsError::new(
                key,
                format!("there are {count}; at most {most} can be described"),
            ));
        }
        for (index, target) in self.types.iter().enumerate() {
            if self.types[..index].iter().any(|other| other.name == target.name) {
                let what = format!("{:?} is the name of an earlier type; move its keys there", target.name);
                return Err(SettingsError::new(format!("type[{index}].name"), what));
            }
        }
        for (index, prior) in self.priors.iter().enumerate() {
            let is_described = |name: &&String| self.types.iter().any(|target| target.name == **name);
            if let Some(name) = prior.types.keys().find(|name| !is_described(name)) {
                let what = format!("no [[wide_area.type]] is named {name:?}; describe it there, or correct the name");
                return Err(SettingsError::new(format!("prior[{index}].types.{name}"), what));
            }
            if let Some(other) = self.priors[..index].iter().position(|other| other.overlaps(prior)) {
                let what = format!("priors {} and {} overlap; separate or join them", other + 1, index + 1);
                return Err(SettingsError::new(format!("prior[{index}]"), what));
            }
        }
        Ok(())
    }

    /// Prior knowledge of a point, east and north in metres.
    pub fn at(&self, point_m: [f64; 2]) -> Option<&Prior> {
        self.priors.iter().find(|prior| prior.contains(point_m))
    }

    /// Prior knowledge of a report's targets, by origin or position.
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
    fn check(&self) -> Result<(), SettingsError> {
        if self.sector.is_some() == self.circle.is_some() {
            let what = "needs exactly one of sector and circle: configure its place";
            return Err(SettingsError::new("", what));
        }
        let mut sizes = BTreeSet::new();
        for size in self.formations.keys() {
            let error = |what| Err(SettingsError::new(format!("formations.{size}"), what));
            match members(size) {
                None => {
                    return error(format!(
                        "{size:?} is no number of members; it must lie between 1 and {TARGETS_MAX}"
                    ));
                }
                Some(members) if !sizes.insert(members) => {
                    return error(format!("formations of {members} are stated twice; remove one entry"));
                }
                Some(_) => (),
            }
        }
        for (key, probabilities) in [("types", &self.types), ("formations", &self.formations)] {
            let sum: f64 = probabilities.values().sum();
            if sum > 1.0 + SUM_MORE {
                let what = format!("the probabilities sum to {sum:.6}; lower them until they sum to 1 at most");
                return Err(SettingsError::new(key, what));
            }
        }
        Ok(())
    }

    /// Whether a point, east and north in metres, is at the place.
    pub fn contains(&self, point_m: [f64; 2]) -> bool {
        let in_circle = |circle: &Circle| distance(circle.centre_m, point_m) <= circle.radius_m;
        self.sector.is_some_and(|sector| sector.contains(point_m)) || self.circle.as_ref().is_some_and(in_circle)
    }

    /// Whether two places of the same kind have something in common.
    fn overlaps(&self, other: &Self) -> bool {
        let circles =
            |(one, other): (Circle, Circle)| distance(one.centre_m, other.centre_m) < one.radius_m + other.radius_m;
        self.sector
            .zip(other.sector)
            .is_some_and(|(one, other)| one.overlaps(&other))
            || self.circle.zip(other.circle).is_some_and(circles)
    }

    /// The size of the likeliest formation that is likely enough and larger, else the number itself.
    pub fn raised(&self, targets: u32) -> u32 {
        let sizes = self.formations.iter();
        let likely = sizes
            .filter_map(|(size, probability)| Some((members(size)?, *probability)))
            .filter(|(size, probability)| *size > targets && *probability >= self.formation_probability_min);
        let best = likely.max_by(|(one, a), (other, b)| a.total_cmp(b).then(other.cmp(one)));
        best.map_or(targets, |(size, _)| size)
    }
}

/// Number of members in the key of a formation; `None` if the key is not a number.
fn members(size: &str) -> Option<u32> {
    size.parse().ok().filter(|members| (1..=TARGETS_MAX).contains(members))
}

fn distance(one: [f64; 2], other: [f64; 2]) -> f64 {
    (one[0] - other[0]).hypot(one[1] - other[1])
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
                sector: Some(sector([1e3, 0.0], [0.2, 1.0])),
                types: [("patrol".to_owned(), 0.7)].into(),
                formations: [("4".to_owned(), 0.8), ("2".to_owned(), 0.1)].into(),
                ..Prior::default()
            }],
        }
    }

    fn sector(from_m: [f64; 2], bearings_rad: [f64; 2]) -> Sector {
        Sector {
            from_m,
            bearings_deg: bearings_rad.map(Degrees::of_rad),
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
        assert_eq!(settings::check(&knowledge), Ok(()));
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
        unlikely.priors[0].formations.insert("4".to_owned(), 0.4);
        assert_eq!(unlikely.targets(&report(0.5, 2)), 2);
    }

    #[test]
    fn a_sector_may_span_north() {
        let place = sector([0.0; 2], [6.0, 0.3]);
        assert!(place.contains([0.0, 1.0]) && place.contains([-0.1, 1.0]) && !place.contains([0.0, -1.0]));
    }

    #[test]
    fn what_contradicts_itself_is_refused_with_its_key() {
        type Spoil = fn(&mut Knowledge);
        fn formation(all: &mut Knowledge, members: &str, probability: f64) {
            all.priors[0].formations.insert(members.to_owned(), probability);
        }
        fn beside(all: &mut Knowledge, bearings_rad: [f64; 2]) {
            let sector = Some(sector([1e3, 0.0], bearings_rad));
            let other = Prior {
                sector,
                ..all.priors[0].clone()
            };
            all.priors.push(other);
        }
        let cases: [(&str, Spoil); 11] = [
            ("type[0].name: \"a long name indeed\" cannot be a name", |all| {
                all.types[0].name = "a long name indeed".to_owned()
            }),
            ("type: there are 65; at most 64", |all| {
                all.types = vec![all.types[0].clone(); 65]
            }),
            ("prior[0].types: the probabilities sum to 1.00", |all| {
                all.priors[0].types.insert("ferry".to_owned(), 0.301);
            }),
            ("prior[0].formations: the probabilities sum to 1.1", |all| {
                formation(all, "2", 0.3)
            }),
            ("prior[0].formations.4: NaN is out of range", |all| {
                formation(all, "4", f64::NAN)
            }),
            ("prior[0].formations.4: formations of 4 are stated twice", |all| {
                formation(all, "04", 0.1)
            }),
            (
                "prior[0].types.ferry: no [[wide_area.type]] is named \"ferry\"",
                |all| {
                    all.priors[0].types.insert("ferry".to_owned(), 0.3);
                },
            ),
            ("prior[0].formations.10000: \"10000\" is no number of members", |all| {
                formation(all, "10000", 0.1)
            }),
            ("prior[0].sector.bearings_deg: ", |all| {
                all.priors[0].sector = Some(sector([0.0; 2], [1.0, 1.0]));
            }),
            ("prior[1]: priors 1 and 2 overlap", |all| beside(all, [0.9, 1.5])),
            ("type[1].name: \"patrol\" is the name of an earlier type", |all| {
                all.types.push(all.types[0].clone())
            }),
        ];
        for (expected, spoil) in cases {
            let mut knowledge = from_the_north_east();
            spoil(&mut knowledge);
            let error = settings::check(&knowledge).unwrap_err().to_string();
            assert!(error.starts_with(expected), "{expected}: {error}");
        }
        let mut adjoining = from_the_north_east();
        beside(&mut adjoining, [1.0, 1.5]);
        assert_eq!(settings::check(&adjoining), Ok(()));
    }
}
