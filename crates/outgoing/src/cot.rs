//! Fused tracks as Cursor on Target events (CoT, event schema 2.0 of the MITRE Corporation), as TAK clients read them.
//!
//! | attribute | from | |
//! | --- | --- | --- |
//! | `uid` | name of the deployment and `track_number` | the same for all events of a track |
//! | `type` | identity, ground state, height | `a-u-` and S ship, G on the ground, A in the air, Z unknown |
//! | `how` | | `m-f`: fused by a machine |
//! | `time`, `start` | `reference_time_ns` | |
//! | `stale` | `start` and the time to live of an event | `start` for the end of a track |
//! | `point` | `position_m`, `covariance` | one standard deviation; 9999999 where a value is unknown |
//! | `contact` | call sign, name, address or track number | |
//! | `track` | `velocity_mps` | course from true north at the target, speed, climb angle |
//! | `remarks` | address, code, level, number of sources | for readers |
//!
//! A height above the ellipsoid is sent if the track has one. A deployment that works with pressure altitudes sends the
//! altitude minus the learned difference. Without a learned difference the altitude itself is sent and `le` is unknown.

use std::fmt::Write as _;

use frames::SystemFrame;
use jiff::Timestamp;
use messages::{SystemTrack, TrackState};

use super::place::{self, TargetPlace};
use super::{HeightReference, OutgoingCounts, SendBlock, Unsent};

/// Value of an unknown height or error, by the event schema.
const UNKNOWN: f64 = 9_999_999.0;
/// Room of the longest event, bytes: a datagram of Ethernet's usual size holds it.
const EVENT_OCTETS: usize = 1024;

/// Sends system tracks as Cursor on Target events, one event a block.
#[derive(Debug)]
pub struct CotEvents {
    /// First part of each `uid`.
    name: String,
    frame: SystemFrame,
    height: HeightReference,
    stale_ns: i64,
    event: String,
    counts: OutgoingCounts,
}

impl CotEvents {
    /// A sender for the deployment `name` with this frame; its clients drop a track `stale_ns` after the last event.
    pub fn new(name: &str, frame: SystemFrame, stale_ns: i64) -> Self {
        Self {
            name: name.to_owned(),
            frame,
            height: HeightReference::default(),
            stale_ns,
            event: String::with_capacity(EVENT_OCTETS),
            counts: OutgoingCounts::default(),
        }
    }

    /// Sends heights of this kind; without this call they are geometric.
    #[must_use]
    pub fn with_height(mut self, height: HeightReference) -> Self {
        self.height = height;
        self
    }

    /// Sends the event of a state.
    pub fn report(&mut self, track: &SystemTrack, send: &mut SendBlock<'_>) {
        match self.write(track) {
            Ok(()) => {
                self.counts.records += 1;
                self.counts.blocks += 1;
                send(self.event.as_bytes());
            }
            Err(Unsent::Position) => self.counts.refused_position += 1,
            Err(_) => self.counts.withheld += 1,
        }
    }

    /// Returns the counts of sent and rejected events.
    pub fn counts(&self) -> OutgoingCounts {
        self.counts
    }

    fn write(&mut self, track: &SystemTrack) -> Result<(), Unsent> {
        match TrackState::from_code(track.state) {
            None | Some(TrackState::Tentative) => return Err(Unsent::Withheld),
            Some(_) => {}
        }
        let place = TargetPlace::new(&self.frame, track.position_m).ok_or(Unsent::Position)?;
        let stale_ns = if TrackState::is_off(track.state) {
            0
        } else {
            self.stale_ns
        };
        let at = |after_ns: i64| {
            let time_ns = track.reference_time_ns.saturating_add(after_ns);
            let time = Timestamp::from_nanosecond(time_ns.into()).unwrap_or(Timestamp::UNIX_EPOCH);
            time.strftime("%Y-%m-%dT%H:%M:%S%.3fZ").to_string()
        };
        let (start, stale) = (at(0), at(stale_ns));
        let event = &mut self.event;
        event.clear();
        event.push_str("<?xml version=\"1.0\" encoding=\"UTF-8\"?><event version=\"2.0\" uid=\"koseki.");
        escaped(event, &self.name);
        let kind = kind(track);
        let number = track.track_number;
        // Writing to memory cannot fail.
        let _ = write!(
            event,
            ".{number}\" type=\"{kind}\" how=\"m-f\" time=\"{start}\" start=\"{start}\" stale=\"{stale}\">"
        );
        let (latitude, longitude) = (place.geodetic.latitude_deg(), place.geodetic.longitude_deg());
        let (hae, le) = height(track, &place, self.height);
        let ce = circular_error(track);
        let _ = write!(
            event,
            "<point lat=\"{latitude:.7}\" lon=\"{longitude:.7}\" hae=\"{hae:.1}\" ce=\"{ce:.1}\" le=\"{le:.1}\"/>"
        );
        event.push_str("<detail><contact callsign=\"");
        contact(event, track);
        event.push_str("\"/>");
        movement(event, track, &place);
        remarks(event, track);
        event.push_str("</detail></event>\n");
        Ok(())
    }
}

/// Type of the event: an atom of unknown affiliation in its dimension.
fn kind(track: &SystemTrack) -> &'static str {
    let identity = &track.identity;
    if identity.mmsi().is_some() {
        "a-u-S"
    } else if track.on_ground != 0 {
        "a-u-G"
    } else if track.height_valid != 0 || identity.address().is_some() || identity.mode_3a().is_some() {
        "a-u-A"
    } else {
        "a-u-Z"
    }
}

/// Height above the ellipsoid and its standard deviation, metres.
fn height(track: &SystemTrack, place: &TargetPlace, reference: HeightReference) -> (f64, f64) {
    if track.height_valid == 0 {
        return (UNKNOWN, UNKNOWN);
    }
    let height_m = place.geodetic.height_m();
    let variance_m2 = place::position_covariance(&track.covariance, place.up(), place.up());
    match (track.pressure_offset(), reference) {
        (Some(offset_m), _) => {
            let sigma_m = f64::from(track.pressure_offset_sigma_m);
            (height_m - offset_m, error(variance_m2 + sigma_m * sigma_m))
        }
        (None, HeightReference::Geometric) => (height_m, error(variance_m2)),
        (None, HeightReference::Barometric) => (height_m, UNKNOWN),
    }
}

/// Standard deviation in the plane along the longer axis of the ellipse, metres.
fn circular_error(track: &SystemTrack) -> f64 {
    let covariance = &track.covariance;
    let [xx, xy, yy] = [(0, 0), (0, 1), (1, 1)].map(|(row, column)| covariance.get(row, column));
    error((xx + yy) / 2.0 + ((xx - yy) / 2.0).hypot(xy))
}

fn error(variance: f64) -> f64 {
    // Written so that NaN is unknown.
    if variance > 0.0 && variance < UNKNOWN * UNKNOWN {
        variance.sqrt()
    } else {
        UNKNOWN
    }
}

/// Name of the target for readers.
fn contact(event: &mut String, track: &SystemTrack) {
    let identity = &track.identity;
    let text = |text: Option<&'_ str>| text.map(str::trim).filter(|text| !text.is_empty()).map(str::to_owned);
    let named = text(identity.callsign()).or_else(|| text(identity.name()));
    let numbered = || {
        let number = identity.address_text().or_else(|| identity.mmsi_text());
        number.map(|number| number.to_string())
    };
    let name = named.or_else(numbered);
    escaped(event, &name.unwrap_or_else(|| format!("track {}", track.track_number)));
}

/// Course, speed and climb angle at the target.
fn movement(event: &mut String, track: &SystemTrack, place: &TargetPlace) {
    let has_height = track.height_valid != 0;
    let [east, north] = place
        .horizontal(has_height)
        .map(|axis| place::along(axis, track.velocity_mps));
    let speed = east.hypot(north);
    if track.velocity_valid == 0 || !speed.is_finite() {
        return;
    }
    // A course of 359.96° or more is 0.0 when rounded.
    let course = (east.atan2(north).to_degrees().rem_euclid(360.0) * 10.0).round() % 3600.0 / 10.0;
    let _ = write!(event, "<track course=\"{course:.1}\" speed=\"{speed:.1}\"");
    let climb = place::along(place.up(), track.velocity_mps);
    if has_height && track.covariance.knows_climb() && climb.is_finite() {
        let _ = write!(event, " slope=\"{:.1}\"", climb.atan2(speed).to_degrees());
    }
    event.push_str("/>");
}

fn remarks(event: &mut String, track: &SystemTrack) {
    let identity = &track.identity;
    let _ = write!(event, "<remarks>track {}", track.track_number);
    if let Some(address) = identity.address_text() {
        let _ = write!(event, ", address {address}");
    }
    if let Some(mmsi) = identity.mmsi_text() {
        let _ = write!(event, ", MMSI {mmsi}");
    }
    if let Some(code) = identity.mode_3a_text() {
        let _ = write!(event, ", code {code}");
    }
    if let Some(level_m) = track.level_m() {
        let _ = write!(event, ", FL {:03.0}", level_m / 0.3048 / 100.0);
    }
    if let Some(name) = track.target_type.name() {
        event.push_str(", type ");
        escaped(event, name);
    }
    let _ = write!(event, ", sources {}</remarks>", track.source_count);
}

/// Adds a text with the characters that XML reserves, and without characters that XML does not have.
fn escaped(event: &mut String, text: &str) {
    for character in text.chars() {
        match character {
            '&' => event.push_str("&amp;"),
            '<' => event.push_str("&lt;"),
            '>' => event.push_str("&gt;"),
            '"' => event.push_str("&quot;"),
            '\'' => event.push_str("&apos;"),
            control if control.is_control() => event.push('?'),
            other => event.push(other),
        }
    }
}

#[cfg(test)]
mod tests {
    use frames::Geodetic;
    use messages::{Covariance, Identity};
    use proptest::prelude::*;

    use super::*;

    fn events() -> CotEvents {
        let frame = SystemFrame::at(Geodetic::from_degrees(52.0, 13.0, 0.0).unwrap());
        CotEvents::new("site", frame, 30_000_000_000)
    }

    /// An aircraft 3,000 m above the origin that flies east and climbs.
    fn aircraft() -> SystemTrack {
        let mut covariance = Covariance::default();
        for (axis, variance) in [900.0, 400.0, 100.0].into_iter().enumerate() {
            covariance.set(axis, axis, variance);
        }
        SystemTrack {
            reference_time_ns: 1_792_000_000_250_000_000,
            track_number: 17,
            state: TrackState::Confirmed.code(),
            source_count: 3,
            height_valid: 1,
            velocity_valid: 1,
            position_m: [0.0, 0.0, 3000.0],
            velocity_mps: [200.0, 0.0, 10.0],
            covariance,
            identity: Identity::default()
                .with_address(0x4c_a7b3)
                .with_mode_3a(0o7421)
                .with_callsign(*b"RYR48CP "),
            ..SystemTrack::default()
        }
    }

    fn sent(events: &mut CotEvents, track: &SystemTrack) -> String {
        let mut text = String::new();
        events.report(track, &mut |block| {
            text.push_str(std::str::from_utf8(block).unwrap());
        });
        text
    }

    #[test]
    fn an_aircraft_is_one_event() {
        assert_eq!(
            sent(&mut events(), &aircraft()),
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?><event version=\"2.0\" uid=\"koseki.site.17\" type=\"a-u-A\" \
             how=\"m-f\" time=\"2026-10-14T17:46:40.250Z\" start=\"2026-10-14T17:46:40.250Z\" \
             stale=\"2026-10-14T17:47:10.250Z\"><point lat=\"52.0000000\" lon=\"13.0000000\" hae=\"3000.0\" ce=\"30.0\" \
             le=\"10.0\"/><detail><contact callsign=\"RYR48CP\"/><track course=\"90.0\" speed=\"200.0\" slope=\"2.9\"/>\
             <remarks>track 17, address 4CA7B3, code 7421, sources 3</remarks></detail></event>\n"
        );
    }

    #[test]
    fn an_unknown_height_and_an_unknown_error_are_stated_as_such() {
        let mut track = SystemTrack {
            height_valid: 0,
            identity: Identity::default(),
            covariance: Covariance::default(),
            ..aircraft()
        };
        let text = sent(&mut events(), &track);
        assert!(
            text.contains("hae=\"9999999.0\" ce=\"9999999.0\" le=\"9999999.0\""),
            "{text}"
        );
        assert!(text.contains("type=\"a-u-Z\"") && !text.contains("slope"), "{text}");
        assert!(text.contains("callsign=\"track 17\""), "{text}");
        track.identity = Identity::default().with_mmsi(211_234_560).with_name("A <&> \"B\"");
        let text = sent(&mut events(), &track);
        assert!(text.contains("type=\"a-u-S\""), "{text}");
        assert!(text.contains("callsign=\"A &lt;&amp;&gt; &quot;B&quot;\""), "{text}");
    }

    #[test]
    fn a_pressure_altitude_becomes_a_height_where_the_difference_is_known() {
        let mut barometric = events().with_height(HeightReference::Barometric);
        let mut track = aircraft();
        assert!(sent(&mut barometric, &track).contains("hae=\"3000.0\" ce=\"30.0\" le=\"9999999.0\""));
        (track.pressure_offset_m, track.pressure_offset_sigma_m) = (-120.0, 24.0);
        assert!(sent(&mut barometric, &track).contains("hae=\"3120.0\" ce=\"30.0\" le=\"26.0\""));
    }

    #[test]
    fn the_last_event_of_a_track_is_stale_at_once() {
        let ended = SystemTrack {
            state: TrackState::Terminated.code(),
            ..aircraft()
        };
        let text = sent(&mut events(), &ended);
        assert!(text.contains("stale=\"2026-10-14T17:46:40.250Z\""), "{text}");
    }

    #[test]
    fn states_that_no_client_gets_are_counted() {
        let mut events = events();
        let tentative = SystemTrack {
            state: TrackState::Tentative.code(),
            ..aircraft()
        };
        let nowhere = SystemTrack {
            position_m: [f64::NAN; 3],
            ..aircraft()
        };
        assert_eq!(sent(&mut events, &tentative) + &sent(&mut events, &nowhere), "");
        let counts = events.counts();
        assert_eq!((counts.records, counts.withheld, counts.refused_position), (0, 1, 1));
    }

    #[test]
    fn an_unknown_velocity_and_an_unknown_climb_are_left_out() {
        let still = SystemTrack {
            velocity_valid: 0,
            ..aircraft()
        };
        assert!(!sent(&mut events(), &still).contains("<track"));
        let mut unsure = aircraft();
        unsure.covariance.set(5, 5, 400.0);
        let text = sent(&mut events(), &unsure);
        assert!(text.contains("speed=\"200.0\"/>"), "{text}");
    }

    proptest! {
        /// Whatever a track contains, its event has no reserved character outside the markup and fits a datagram.
        #[test]
        fn events_are_whole(
            name in prop::array::uniform20(any::<u8>()),
            callsign in prop::array::uniform8(any::<u8>()),
            velocity in prop::array::uniform3(any::<f64>()),
            variances in prop::array::uniform3(any::<f64>()),
            time_ns in any::<i64>(),
        ) {
            let mut covariance = Covariance::default();
            for (axis, variance) in variances.into_iter().enumerate() {
                covariance.set(axis, axis, variance);
            }
            let mut identity = Identity::default().with_mmsi(1).with_callsign(callsign).with_name("x");
            identity.name = name;
            let track = SystemTrack { identity, covariance, velocity_mps: velocity, reference_time_ns: time_ns, ..aircraft() };
            let text = sent(&mut events(), &track);
            prop_assert!(text.len() <= 1472, "{}", text.len());
            prop_assert_eq!(text.matches('<').count(), text.matches('>').count());
            prop_assert_eq!(text.matches('"').count() % 2, 0);
            prop_assert!(!text.contains("NaN") && !text.contains("inf"), "{}", text);
            prop_assert!(text.trim_end().chars().all(|character| !character.is_control()), "{}", text);
        }
    }
}
