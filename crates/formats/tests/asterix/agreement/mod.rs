//! The two ways of decoding, compared on one record: typed fields against the tree of named values.

mod ads_b;
mod airport;
mod radar;
mod system;

use std::f64::consts::PI;

use asterix::text::UNDEFINED;
use asterix::typed::fields::*;
use asterix::{Edition, NamedRecord, Record, Value};

const DEGREE: f64 = PI / 180.0;
const NM: f64 = 1852.0;
const FOOT: f64 = 0.3048;
const FLIGHT_LEVEL: f64 = 30.48;

/// Compares all that both ways have; gives the number of values compared, zero for a table of the tests alone.
///
/// # Panics
/// If any differ.
pub(crate) fn check(record: &Record<'_>) -> usize {
    let named = NamedRecord::new(record);
    let mut agreement = Agreement {
        named: &named,
        compared: 0,
    };
    let table = record.table();
    match table.number {
        1 => agreement.cat001(record),
        2 => agreement.cat002(record),
        10 => agreement.cat010(record),
        19 => agreement.cat019(record),
        20 => agreement.cat020(record),
        21 if table.edition < Edition::new(1, 0) => agreement.cat021_v0(record),
        21 => agreement.cat021_v2(record),
        23 => agreement.cat023(record),
        34 => agreement.cat034(record),
        48 => agreement.cat048(record),
        62 => agreement.cat062(record),
        63 => agreement.cat063(record),
        65 => agreement.cat065(record),
        _ => {} // an invented category
    }
    agreement.compared
}

struct Agreement<'n> {
    named: &'n NamedRecord,
    compared: usize,
}

impl Agreement<'_> {
    /// A number: ours in SI units, theirs times `unit`.
    fn number(&mut self, path: &[&str], unit: f64, typed: Option<f64>) {
        let named = self.named.get(path).and_then(Value::as_f64).map(|number| number * unit);
        let near = match (named, typed) {
            (Some(named), Some(typed)) => (named - typed).abs() <= 1e-12 * named.abs(),
            (None, None) => true,
            _ => false,
        };
        assert!(near, "{path:?}: named {named:?}, typed {typed:?} in {:?}", self.named);
        self.compared += usize::from(typed.is_some());
    }

    /// A number of which the typed way makes a code or a flag.
    fn code(&mut self, path: &[&str], typed: Option<u32>) {
        self.number(path, 1.0, typed.map(f64::from));
    }

    fn is_sent(&self, path: &[&str]) -> bool {
        self.named.get(path).is_some()
    }

    /// A flag, which is `false` where its extension octet was not sent, or its edition has none.
    fn flag(&mut self, path: &[&str], typed: Option<bool>) {
        let sent = self.is_sent(path);
        assert!(sent || typed != Some(true), "{path:?} was not sent");
        self.code(path, typed.filter(|_| sent).map(u32::from));
    }

    fn text(&mut self, path: &[&str], typed: Option<Callsign>) {
        let Some(Value::Text(named)) = self.named.get(path) else {
            assert_eq!(typed, None, "{path:?}");
            return;
        };
        let named = named.replace(UNDEFINED, "?");
        match typed {
            Some(typed) => {
                assert_eq!(typed.as_bytes(), named.as_bytes(), "{path:?}");
                assert_eq!(typed.as_str(), named.trim_end_matches(' '), "{path:?}");
            }
            None => assert!(
                !named.contains(|c: char| c.is_ascii_alphanumeric()),
                "{path:?}: {named}"
            ),
        }
        self.compared += 1;
    }

    fn source(&mut self, typed: Option<Source>) {
        self.code(&["010", "SAC"], typed.map(|source| source.sac.into()));
        self.code(&["010", "SIC"], typed.map(|source| source.sic.into()));
    }

    fn time(&mut self, item: &str, typed: Option<TimeOfDay>) {
        self.number(&[item], 1.0, typed.map(TimeOfDay::seconds));
        self.number(&[item], 128.0, typed.map(|time| time.ticks.into()));
    }

    fn geodetic(&mut self, item: &str, typed: Option<GeodeticPosition>) {
        self.number(&[item, "LAT"], DEGREE, typed.map(|position| position.latitude_rad));
        self.number(&[item, "LON"], DEGREE, typed.map(|position| position.longitude_rad));
    }

    fn cartesian(&mut self, typed: Option<CartesianPosition>) {
        self.number(&["042", "X"], 1.0, typed.map(|position| position.x_m));
        self.number(&["042", "Y"], 1.0, typed.map(|position| position.y_m));
    }

    fn velocity(&mut self, typed: Option<CartesianVelocity>) {
        self.number(&["202", "VX"], 1.0, typed.map(|velocity| velocity.vx_m_s));
        self.number(&["202", "VY"], 1.0, typed.map(|velocity| velocity.vy_m_s));
    }

    fn acceleration(&mut self, typed: Option<CartesianAcceleration>) {
        self.number(&["210", "AX"], 1.0, typed.map(|acceleration| acceleration.ax_m_s2));
        self.number(&["210", "AY"], 1.0, typed.map(|acceleration| acceleration.ay_m_s2));
    }

    fn mode_3a(&mut self, item: &str, typed: Option<Mode3A>) {
        let digits = match self.named.get(&[item, "MODE3A"]) {
            Some(Value::Text(digits)) => Some(digits.clone()),
            _ => None,
        };
        assert_eq!(typed.map(|mode| format!("{:04o}", mode.code)), digits);
        self.flag(&[item, "V"], typed.map(|mode| mode.not_validated));
        self.flag(&[item, "G"], typed.map(|mode| mode.garbled));
        self.flag(&[item, "L"], typed.map(|mode| mode.not_extracted));
    }

    fn flight_level(&mut self, typed: Option<FlightLevel>) {
        self.number(&["090", "FL"], FLIGHT_LEVEL, typed.map(|level| level.altitude_m));
        self.flag(&["090", "V"], typed.map(|level| level.not_validated));
        self.flag(&["090", "G"], typed.map(|level| level.garbled));
    }

    fn identification(&mut self, typed: Option<Identification>) {
        self.code(
            &["245", "STI"],
            typed.map(|identification| identification.origin.into()),
        );
        self.text(
            &["245", "CHR"],
            typed.and_then(|identification| identification.callsign),
        );
    }

    fn track_status(&mut self, typed: Option<TrackStatus>) {
        let extrapolation = |status: TrackStatus| match status.extrapolation {
            Extrapolation::None => 0,
            Extrapolation::Unstated | Extrapolation::BetweenScans => 1,
            Extrapolation::MaskedArea => 2,
            Extrapolation::NotDetected => 3,
        };
        self.flag(&["170", "CNF"], typed.map(|status| status.tentative));
        self.flag(&["170", "TRE"], typed.map(|status| status.ended));
        self.code(&["170", "CST"], typed.map(extrapolation));
        self.flag(&["170", "MAH"], typed.map(|status| status.manoeuvring));
        self.flag(&["170", "STH"], typed.map(|status| status.smoothed));
        self.flag(&["170", "GHO"], typed.map(|status| status.ghost));
    }

    fn system_status(&mut self, typed: Option<SystemStatus>) {
        let availability = |status: SystemStatus| match status.availability {
            Availability::Operational => 0,
            Availability::Degraded => 1,
            Availability::Unusable => 2,
            Availability::Undefined => 3,
        };
        self.code(&["550", "NOGO"], typed.map(availability));
        self.flag(&["550", "OVL"], typed.map(|status| status.overloaded));
        self.flag(&["550", "TSV"], typed.map(|status| status.time_source_invalid));
        self.flag(&["550", "TTF"], typed.map(|status| status.test_target_failed));
    }

    fn velocity_polar(&mut self, item: &str, [speed, track]: [&str; 2], typed: Option<PolarVelocity>) {
        self.number(&[item, speed], NM, typed.map(|velocity| velocity.speed_m_s));
        self.number(&[item, track], DEGREE, typed.map(|velocity| velocity.track_rad));
    }

    fn slant(&mut self, typed: Option<PolarPosition>) {
        self.number(&["040", "RHO"], NM, typed.map(|position| position.range_m));
        self.number(&["040", "THETA"], DEGREE, typed.map(|position| position.azimuth_rad));
    }

    fn transponder(&mut self, path: &[&str], typed: Option<Transponder>) {
        let element = |name| [path, &[name]].concat();
        self.code(
            &element("COM"),
            typed.map(|transponder| transponder.communications.into()),
        );
        self.flag(&element("ARC"), typed.map(|transponder| transponder.fine_altitude));
        let status = self.named.get(&element("STAT")).and_then(Value::as_f64);
        let Some((status, typed)) = status.zip(typed.map(|transponder| transponder.flight_status)) else {
            assert_eq!((status, typed), (None, None));
            return;
        };
        assert_eq!(typed.alert, [2.0, 3.0, 4.0].contains(&status));
        assert_eq!(typed.special_identification, [4.0, 5.0].contains(&status));
        assert_eq!(typed.on_ground == Some(true), [1.0, 3.0].contains(&status));
        assert_eq!(typed.on_ground == Some(false), [0.0, 2.0].contains(&status));
    }

    fn emergency(&mut self, path: &[&str], typed: Option<Emergency>) {
        let number = typed.map(|emergency| match emergency {
            Emergency::None => 0,
            Emergency::General => 1,
            Emergency::Medical => 2,
            Emergency::MinimumFuel => 3,
            Emergency::CommunicationFailure => 4,
            Emergency::UnlawfulInterference => 5,
            Emergency::Downed => 6,
            Emergency::Undefined(number) => number.into(),
        });
        self.code(path, number);
    }

    /// An advisory that the table has as one number of 56 bits.
    fn advisory(&mut self, path: &[&str], typed: Option<ResolutionAdvisory>) {
        let Some(Value::Unsigned(bits)) = self.named.get(path) else {
            assert_eq!(typed, None, "{path:?}");
            return;
        };
        let bit = |number: u32| bits >> (56 - number) & 1 == 1;
        let typed = typed.expect("an advisory");
        assert_eq!(u64::from(typed.advisories), bits >> 34 & 0x3FFF);
        assert_eq!(
            (typed.terminated, typed.multiple_threats, typed.is_active()),
            (bit(27), bit(28), !bit(27) && (bit(9) || bit(28)))
        );
        self.compared += 1;
    }

    /// A number that is `None` where its record says that it is out of range.
    fn number_in_range(&mut self, path: &[&str], out: bool, unit: f64, typed: Option<f64>) {
        if out {
            assert_eq!(typed, None, "{path:?}");
        } else {
            self.number(path, unit, typed);
        }
    }

    /// Several flags of which the typed way makes one: any of them.
    fn any_flag(&mut self, paths: [&[&str]; 2], typed: Option<bool>) {
        let set = paths.map(|path| self.named.get(path).and_then(Value::as_f64));
        assert_eq!(typed.unwrap_or(false), set.contains(&Some(1.0)), "{paths:?}");
        self.compared += usize::from(typed.is_some());
    }
}

fn set_flags(octet: &Value) -> u32 {
    match octet {
        Value::Group(flags) => flags.iter().filter(|(_, flag)| *flag == Value::Unsigned(1)).count() as u32,
        other => panic!("{other:?} is no group of flags"),
    }
}
