//! Static data of stations: names, call signs, hulls.
//!
//! A ship sends its name, call sign and dimensions every six minutes (types 5, 19 and 24), its position up to every two
//! seconds. The table keeps the static data of each station for half an hour after they came last; a number may
//! meanwhile have passed to another ship. A full table forgets stations that have been silent for ten minutes, more
//! than three reports of a ship at anchor. If none is silent, further stations are refused: their reports have no
//! static data.

use aivdm::AisMessage;
use aivdm::message::StaticDataReport;
use frames::{Geodetic, SystemFrame};
use messages::{Callsign, Identity};
use observations::{Statement, TargetCategory};
use rustc_hash::FxHashMap;

use super::accuracy;
use super::codes;

/// Time for which static data are used, nanoseconds.
const STATIC_AGE_MAX_NS: u64 = 1_800_000_000_000;
/// After this silence a station may be forgotten, nanoseconds.
const SILENCE_MAX_NS: u64 = 600_000_000_000;
/// Time for which a device is under test after its text has announced that, nanoseconds. A test is a burst of 14 s.
const TEST_AGE_MAX_NS: u64 = 60_000_000_000;
/// Greatest length that is believed, metres: the longest ship has 488.
const LENGTH_MAX_M: u16 = 500;
/// Distances from this one on mean "this or more", metres: along the ship, and across.
const BOUND_M: [u16; 2] = [511, 63];

/// A hull around the antenna of its positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Hull {
    /// Length and width, metres.
    pub(super) size_m: [f32; 2],
    /// Centre of the hull ahead and to starboard of the antenna, metres; `None` if the antenna's place is not stated.
    centre_m: Option<[f64; 2]>,
}

impl Hull {
    /// A hull of the distances from the antenna to bow, stern, port and starboard side; `None` if they are not stated,
    /// bounds, or those of no hull.
    pub(super) fn of([bow, stern, port, starboard]: [u16; 4]) -> Option<Self> {
        let [length, width] = [bow + stern, port + starboard];
        let is_bound = bow.max(stern) >= BOUND_M[0] || port.max(starboard) >= BOUND_M[1];
        if is_bound || width == 0 || width > length || length > LENGTH_MAX_M {
            return None;
        }
        // Bow and port at 0: the size is stated, the antenna's place is not.
        let has_place = (bow, port) != (0, 0);
        let half = |more: u16, less: u16| (f64::from(more) - f64::from(less)) / 2.0;
        Some(Self {
            size_m: [f32::from(length), f32::from(width)],
            centre_m: has_place.then(|| [half(bow, stern), half(starboard, port)]),
        })
    }

    /// Standard deviation of the distance from the antenna to the centre, metres; `None` if [`Self::centre`] leaves
    /// none, with a heading.
    pub(super) fn offset_sigma_m(&self, has_heading: bool) -> Option<f64> {
        match self.centre_m {
            Some(_) if has_heading => None,
            Some([ahead, starboard]) => Some(ahead.hypot(starboard)),
            None => Some(accuracy::offset_sigma_m(Some(self.size_m[0].into()))),
        }
    }

    /// The centre of the hull, whose antenna is at `antenna`; the bow points to `heading_rad`.
    pub(super) fn centre(&self, antenna: Geodetic, heading_rad: f64) -> Geodetic {
        let [ahead, starboard] = self.centre_m.unwrap_or_default();
        let (sine, cosine) = heading_rad.sin_cos();
        let [east, north] = [ahead * sine + starboard * cosine, ahead * cosine - starboard * sine];
        SystemFrame::at(antenna).to_geodetic([east, north, 0.0])
    }
}

/// What one message states about its station.
#[derive(Clone, Copy, Debug)]
pub(super) struct StaticData {
    pub(super) mmsi: u32,
    /// Name and call sign.
    identity: Identity,
    category: TargetCategory,
    hull: Option<Hull>,
}

impl StaticData {
    /// The static data of a message of type 5, 19 or 24.
    pub(super) fn of(message: &AisMessage) -> Option<Self> {
        macro_rules! distances {
            ($of:ident) => {
                Hull::of([
                    $of.dimension_to_bow,
                    $of.dimension_to_stern,
                    $of.dimension_to_port.into(),
                    $of.dimension_to_starboard.into(),
                ])
            };
        }
        let mmsi = message.mmsi().raw();
        let (name, callsign, ship_type, hull) = match message {
            AisMessage::StaticVoyageData(of) => (of.name.as_str(), of.call_sign.as_str(), of.ship_type, distances!(of)),
            AisMessage::PositionReportClassBExtended(of) => (of.name.as_str(), "", of.ship_type, distances!(of)),
            AisMessage::StaticDataReport(StaticDataReport::A(of)) => (of.name.as_str(), "", 0, None),
            AisMessage::StaticDataReport(StaticDataReport::B(of)) => {
                // Auxiliary craft state the number of their parent ship in place of dimensions.
                let hull = distances!(of).filter(|_| !codes::is_auxiliary_craft(mmsi));
                ("", of.call_sign.as_str(), of.ship_type, hull)
            }
            _ => return None,
        };
        let by_number = codes::category_of_number(mmsi);
        Some(Self {
            mmsi,
            identity: named(Identity::default(), name, callsign),
            category: match by_number {
                TargetCategory::Unknown => codes::category_of_type(ship_type),
                _ => by_number,
            },
            hull,
        })
    }

    /// The statement of the message; `None` if it states neither category nor size.
    pub(super) fn statement(&self) -> Option<Statement> {
        let states = self.category != TargetCategory::Unknown || self.hull.is_some();
        states.then(|| Statement {
            track_number: self.mmsi,
            category: self.category,
            size_m: self.hull.map(|hull| hull.size_m),
            ..Statement::default()
        })
    }
}

/// The identity with a name and a call sign, unless they are empty. Characters from the first `@` on are padding.
pub(super) fn named(mut identity: Identity, name: &str, callsign: &str) -> Identity {
    let (name, callsign) = (unpadded(name), unpadded(callsign));
    if !name.is_empty() {
        identity = identity.with_name(name);
    }
    let mut padded: Callsign = [b' '; 8];
    if let (1..=8, Some(place)) = (callsign.len(), padded.get_mut(..callsign.len())) {
        place.copy_from_slice(callsign.as_bytes());
        identity = identity.with_callsign(padded);
    }
    identity
}

/// A text without its padding.
pub(super) fn unpadded(text: &str) -> &str {
    text.split('@').next().unwrap_or_default().trim_end()
}

/// A station in the table.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Station {
    last_ns: i64,
    static_ns: i64,
    test_ns: Option<i64>,
    /// Name and call sign.
    pub(super) identity: Identity,
    /// Hull, if the dimensions are stated.
    pub(super) hull: Option<Hull>,
}

impl Station {
    /// Whether the station has announced a test.
    pub(super) fn is_under_test(&self) -> bool {
        self.test_ns.is_some()
    }

    /// Notes a message received at `now_ns`, and drops what is too old.
    fn note(&mut self, now_ns: i64) {
        self.last_ns = now_ns;
        if now_ns.abs_diff(self.static_ns) > STATIC_AGE_MAX_NS {
            (self.identity, self.hull) = (Identity::default(), None);
        }
        self.test_ns = self
            .test_ns
            .filter(|test_ns| now_ns.abs_diff(*test_ns) <= TEST_AGE_MAX_NS);
    }
}

/// The stations with static data.
#[derive(Debug)]
pub(super) struct Stations {
    stations: FxHashMap<u32, Station>,
    most: usize,
}

impl Stations {
    pub(super) fn new(most: usize) -> Self {
        let mut stations = FxHashMap::default();
        stations.reserve(most);
        Self { stations, most }
    }

    /// Takes static data received at `now_ns`; whether there was room.
    pub(super) fn take(&mut self, data: &StaticData, now_ns: i64) -> bool {
        let station = self.entry(data.mmsi, now_ns).map(|station| {
            station.static_ns = now_ns;
            station.identity = data.identity.or(&station.identity);
            station.hull = data.hull.or(station.hull);
        });
        station.is_some()
    }

    /// Takes the announcement of a test, or of its end; whether there was room.
    pub(super) fn take_test(&mut self, mmsi: u32, is_test: bool, now_ns: i64) -> bool {
        let station = self.entry(mmsi, now_ns);
        station
            .map(|station| station.test_ns = is_test.then_some(now_ns))
            .is_some()
    }

    /// The sender of a message received at `now_ns`, with what it has stated lately.
    pub(super) fn sender(&mut self, mmsi: u32, now_ns: i64) -> Station {
        let station = self.stations.get_mut(&mmsi);
        station.map_or_else(Station::default, |station| {
            station.note(now_ns);
            *station
        })
    }

    fn entry(&mut self, mmsi: u32, now_ns: i64) -> Option<&mut Station> {
        if self.stations.len() >= self.most && !self.stations.contains_key(&mmsi) {
            self.stations
                .retain(|_, station| now_ns.abs_diff(station.last_ns) <= SILENCE_MAX_NS);
            if self.stations.len() >= self.most {
                return None;
            }
        }
        let station = self.stations.entry(mmsi).or_default();
        station.note(now_ns);
        Some(station)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: i64 = 1_000_000_000;

    #[test]
    fn a_hull_has_a_size_and_a_centre_or_is_none() {
        let hull = Hull::of([225, 70, 1, 31]).unwrap();
        assert_eq!((hull.size_m, hull.centre_m), ([295.0, 32.0], Some([77.5, 15.0])));
        let hull = Hull::of([0, 80, 0, 12]).unwrap();
        assert_eq!((hull.size_m, hull.centre_m), ([80.0, 12.0], None));
        assert_eq!(Hull::of([0, 80, 4, 8]).unwrap().centre_m, Some([-40.0, 2.0]));
        for distances in [
            [0, 0, 0, 0],
            [10, 10, 0, 0],
            [0, 0, 3, 3],
            [511, 0, 20, 20],
            [100, 20, 63, 3],
            [4, 5, 10, 10],
            [300, 201, 20, 20],
        ] {
            assert_eq!(Hull::of(distances), None, "{distances:?}");
        }
    }

    #[test]
    fn the_centre_lies_where_the_bow_points() {
        let hull = Hull::of([225, 75, 2, 32]).unwrap();
        let antenna = Geodetic::from_degrees(60.0, -180.0, 0.0).unwrap();
        let frame = SystemFrame::at(antenna);
        for (heading_deg, expected) in [(0.0, [15.0, 75.0]), (90.0, [75.0, -15.0]), (225.0, [-63.64, -42.43])] {
            let centre = frame.to_local(hull.centre(antenna, f64::to_radians(heading_deg)));
            assert!(
                (centre[0] - expected[0]).hypot(centre[1] - expected[1]) < 0.01,
                "{heading_deg}: {centre:?}"
            );
        }
        assert!(hull.centre(antenna, 1.5 * std::f64::consts::PI).longitude_deg().abs() <= 180.0);
    }

    #[test]
    fn padding_is_no_part_of_texts() {
        let of = |name, callsign| named(Identity::default(), name, callsign);
        let found = of("EVER GIVEN  @@REST", "H3RC   ");
        assert_eq!((found.name(), found.callsign()), (Some("EVER GIVEN"), Some("H3RC")));
        assert_eq!(of("@@@@", "   "), Identity::default());
    }

    fn data(mmsi: u32, name: &str) -> StaticData {
        StaticData {
            mmsi,
            identity: named(Identity::default(), name, ""),
            category: TargetCategory::Unknown,
            hull: None,
        }
    }

    #[test]
    fn static_data_age_and_a_full_table_refuses_until_a_station_is_silent() {
        let mut stations = Stations::new(2);
        assert!(stations.take(&data(1, "ONE"), 0) && stations.take(&data(2, "TWO"), 300 * S));
        assert!(!stations.take(&data(3, "THREE"), 600 * S));
        assert_eq!(stations.sender(2, 600 * S).identity.name(), Some("TWO"));
        assert!(stations.take(&data(3, "THREE"), 601 * S), "the first is forgotten");
        assert_eq!(stations.sender(1, 601 * S).identity.name(), None);
        assert_eq!(stations.sender(3, 2401 * S).identity.name(), Some("THREE"));
        assert_eq!(stations.sender(3, 2402 * S).identity.name(), None);
        assert!(stations.take(&data(3, ""), 2403 * S));
        assert_eq!(
            stations.sender(3, 2403 * S).identity.name(),
            None,
            "old names do not come back"
        );
        assert_eq!(stations.stations.len(), 2);
    }
}
