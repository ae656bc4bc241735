//! The two ways of decoding, compared on one record: typed fields against the tree of named values.

use std::f64::consts::PI;
use std::ptr;

use formats::asterix::categories::{CAT010_V1_1, CAT019_V1_3, CAT020_V1_9, CAT021_V0_23};
use formats::asterix::text::UNDEFINED;
use formats::asterix::typed::fields::*;
use formats::asterix::typed::{cat010, cat019, cat020, cat021_v0_23};
use formats::asterix::{Category, NamedRecord, Record, Value};

const DEGREE: f64 = PI / 180.0;
const NM: f64 = 1852.0;
const FOOT: f64 = 0.3048;
const FLIGHT_LEVEL: f64 = 30.48;

/// Compares all that both ways have; gives the number of values compared, zero for a table without typed reader.
///
/// # Panics
/// If any differ.
pub(crate) fn check(record: &Record<'_>) -> usize {
    let named = NamedRecord::new(record);
    let mut agreement = Agreement {
        named: &named,
        compared: 0,
    };
    let is = |table: &Category| ptr::eq(record.table(), table);
    if is(&CAT010_V1_1) {
        agreement.cat010(record);
    } else if is(&CAT019_V1_3) {
        agreement.cat019(record);
    } else if is(&CAT020_V1_9) {
        agreement.cat020(record);
    } else if is(&CAT021_V0_23) {
        agreement.cat021_v0_23(record);
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

    /// A flag, which is `false` where its extension octet was not sent.
    fn flag(&mut self, path: &[&str], typed: Option<bool>) {
        let sent = self.named.get(path).is_some();
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

    fn cat010(&mut self, record: &Record<'_>) {
        if let Some(message) = cat010::ServiceMessage::read(record) {
            let number = match message.message_type {
                cat010::MessageType::StartOfUpdateCycle => 2,
                cat010::MessageType::PeriodicStatus => 3,
                cat010::MessageType::EventStatus => 4,
                other => panic!("{other:?} is no service message"),
            };
            self.code(&["000"], Some(number));
            self.source(message.source);
            self.time("140", message.time_of_day);
            self.system_status(message.system_status);
        }
        let Some(report) = cat010::TargetReport::read(record) else {
            return;
        };
        self.code(&["000"], Some(1));
        self.source(report.source);
        self.time("140", report.time_of_day);
        self.cat010_descriptor(report.descriptor);
        self.number(&["040", "RHO"], 1.0, report.polar_position.map(|polar| polar.range_m));
        self.number(
            &["040", "TH"],
            DEGREE,
            report.polar_position.map(|polar| polar.azimuth_rad),
        );
        self.cartesian(report.cartesian_position);
        self.geodetic("041", report.geodetic_position);
        self.number(
            &["200", "GSP"],
            NM,
            report.polar_velocity.map(|velocity| velocity.speed_m_s),
        );
        self.number(
            &["200", "TRA"],
            DEGREE,
            report.polar_velocity.map(|velocity| velocity.track_rad),
        );
        self.velocity(report.cartesian_velocity);
        self.acceleration(report.acceleration);
        self.code(&["161", "TRK"], report.track_number.map(u32::from));
        self.track_status(report.track_status);
        self.mode_3a("060", report.mode_3a);
        self.code(&["220"], report.address);
        self.identification(report.identification);
        self.code(&["300"], report.vehicle_fleet.map(u32::from));
        self.flight_level(report.flight_level);
        self.number(&["091"], FOOT, report.measured_height_m);
        self.number(&["270", "LENGTH"], 1.0, report.size.map(|size| size.length_m));
        self.number(
            &["270", "ORIENTATION"],
            DEGREE,
            report.size.and_then(|size| size.orientation_rad),
        );
        self.number(&["270", "WIDTH"], 1.0, report.size.and_then(|size| size.width_m));
        let deviation = report.position_deviation;
        self.number(&["500", "DEVX"], 1.0, deviation.map(|deviation| deviation.sigma_x_m));
        self.number(&["500", "DEVY"], 1.0, deviation.map(|deviation| deviation.sigma_y_m));
        self.number(
            &["500", "COVXY"],
            1.0,
            deviation.map(|deviation| deviation.covariance_xy_m2),
        );
        self.code(&["131"], report.plot_amplitude.map(u32::from));
    }

    fn cat010_descriptor(&mut self, typed: Option<cat010::Descriptor>) {
        use cat010::{Detection, TargetKind};
        let detection = match self.named.get(&["020", "TYP"]) {
            Some(Value::Unsigned(number)) => Some(match number {
                0 => Detection::SsrMultilateration,
                1 => Detection::ModeSMultilateration,
                2 => Detection::AdsB,
                3 => Detection::PrimaryRadar,
                4 => Detection::MagneticLoop,
                5 => Detection::HfMultilateration,
                _ => Detection::Other,
            }),
            _ => None,
        };
        assert_eq!(typed.map(|descriptor| descriptor.detection), detection);
        let kind = match self.named.get(&["020", "TOT"]) {
            Some(Value::Unsigned(1)) => TargetKind::Aircraft,
            Some(Value::Unsigned(2)) => TargetKind::GroundVehicle,
            Some(Value::Unsigned(3)) => TargetKind::Helicopter,
            _ => TargetKind::Undetermined,
        };
        assert_eq!(
            typed.map_or(TargetKind::Undetermined, |descriptor| descriptor.kind),
            kind
        );
        self.flag(&["020", "GBS"], typed.map(|descriptor| descriptor.ground_bit));
        self.flag(&["020", "CRT"], typed.map(|descriptor| descriptor.corrupted));
        self.flag(&["020", "SIM"], typed.map(|descriptor| descriptor.simulated));
        self.flag(&["020", "TST"], typed.map(|descriptor| descriptor.test));
        self.flag(&["020", "RAB"], typed.map(|descriptor| descriptor.field_monitor));
        self.flag(
            &["020", "SPI"],
            typed.map(|descriptor| descriptor.special_identification),
        );
    }

    fn cat019(&mut self, record: &Record<'_>) {
        let message = cat019::ServiceMessage::read(record).expect("every record of the category");
        let number = message.message_type.map(|message_type| match message_type {
            cat019::MessageType::StartOfUpdateCycle => 1,
            cat019::MessageType::PeriodicStatus => 2,
            cat019::MessageType::EventStatus => 3,
            cat019::MessageType::Undefined(number) => number.into(),
        });
        self.code(&["000"], number);
        self.source(message.source);
        self.time("140", message.time_of_day);
        self.system_status(message.system_status);
        self.geodetic("600", message.reference_position);
        self.number(&["610"], 1.0, message.reference_height_m);
        self.number(&["620"], 1.0, message.undulation_m);
    }

    fn cat020(&mut self, record: &Record<'_>) {
        let report = cat020::TargetReport::read(record).expect("every record of the category");
        self.source(report.source);
        self.time("140", report.time_of_day);
        let descriptor = report.descriptor;
        self.flag(&["020", "SSR"], descriptor.map(|descriptor| descriptor.ssr));
        self.flag(&["020", "MS"], descriptor.map(|descriptor| descriptor.mode_s));
        self.flag(&["020", "RAB"], descriptor.map(|descriptor| descriptor.field_monitor));
        self.flag(
            &["020", "SPI"],
            descriptor.map(|descriptor| descriptor.special_identification),
        );
        self.flag(&["020", "GBS"], descriptor.map(|descriptor| descriptor.ground_bit));
        self.flag(&["020", "CRT"], descriptor.map(|descriptor| descriptor.corrupted));
        self.flag(&["020", "SIM"], descriptor.map(|descriptor| descriptor.simulated));
        self.flag(&["020", "TST"], descriptor.map(|descriptor| descriptor.test));
        self.geodetic("041", report.geodetic_position);
        self.cartesian(report.cartesian_position);
        self.velocity(report.cartesian_velocity);
        self.acceleration(report.acceleration);
        self.code(&["161", "TRN"], report.track_number.map(u32::from));
        self.track_status(report.track_status);
        self.mode_3a("070", report.mode_3a);
        self.code(&["220"], report.address);
        self.identification(report.identification);
        self.code(&["300"], report.vehicle_fleet.map(u32::from));
        self.flight_level(report.flight_level);
        self.number(&["110"], FOOT, report.measured_height_m);
        self.number(&["105"], FOOT, report.geometric_height_m);
        let accuracy = report.position_accuracy;
        let dilution = accuracy.and_then(|accuracy| accuracy.dilution);
        self.number(&["500", "DOP", "X"], 1.0, dilution.map(|dilution| dilution.x));
        self.number(&["500", "DOP", "Y"], 1.0, dilution.map(|dilution| dilution.y));
        self.number(&["500", "DOP", "XY"], 1.0, dilution.map(|dilution| dilution.xy));
        let deviation = accuracy.and_then(|accuracy| accuracy.deviation);
        self.number(
            &["500", "SDP", "X"],
            1.0,
            deviation.map(|deviation| deviation.sigma_x_m),
        );
        self.number(
            &["500", "SDP", "Y"],
            1.0,
            deviation.map(|deviation| deviation.sigma_y_m),
        );
        self.number(
            &["500", "SDP", "XY"],
            1.0,
            deviation.map(|deviation| deviation.correlation_xy),
        );
        self.number(
            &["500", "SDH"],
            1.0,
            accuracy.and_then(|accuracy| accuracy.sigma_height_m),
        );
        let devices = match self.named.get(&["400"]) {
            Some(Value::List(octets)) => Some(octets.iter().map(set_flags).sum::<u32>()),
            _ => None,
        };
        assert_eq!(report.contributing_devices, devices);
    }

    fn cat021_v0_23(&mut self, record: &Record<'_>) {
        use cat021_v0_23::{AddressType, AirSpeed};
        let report = cat021_v0_23::TargetReport::read(record).expect("every record of the category");
        self.source(report.source);
        self.time("030", report.time_of_day);
        self.number(&["032"], 1.0, report.time_accuracy_s);
        let descriptor = report.descriptor;
        self.flag(&["040", "GBS"], descriptor.map(|descriptor| descriptor.ground_bit));
        self.flag(&["040", "SIM"], descriptor.map(|descriptor| descriptor.simulated));
        self.flag(&["040", "TST"], descriptor.map(|descriptor| descriptor.test));
        self.flag(&["040", "RAB"], descriptor.map(|descriptor| descriptor.field_monitor));
        self.flag(
            &["040", "SPI"],
            descriptor.map(|descriptor| descriptor.special_identification),
        );
        let address_type = descriptor.map(|descriptor| match descriptor.address_type {
            AddressType::NotUnique => 0,
            AddressType::Icao => 1,
            AddressType::SurfaceVehicle => 2,
            AddressType::Anonymous => 3,
            AddressType::Reserved(number) => number.into(),
        });
        self.code(&["040", "ATP"], address_type);
        self.geodetic("130", report.geodetic_position);
        self.code(&["080"], report.address);
        self.text(&["170"], report.callsign);
        let merit = report.figure_of_merit;
        self.code(&["090", "AC"], merit.map(|merit| merit.acas.into()));
        self.code(&["090", "MN"], merit.map(|merit| merit.multiple_navigation.into()));
        self.code(&["090", "DC"], merit.map(|merit| merit.differential_correction.into()));
        self.code(&["090", "PA"], merit.map(|merit| merit.position_category.into()));
        self.code(&["095"], report.velocity_category.map(u32::from));
        self.number(&["145"], FLIGHT_LEVEL, report.pressure_altitude_m);
        self.number(&["140"], FOOT, report.geometric_altitude_m);
        self.number(&["155"], FOOT / 60.0, report.barometric_rate_m_s);
        self.number(&["157"], FOOT / 60.0, report.geometric_rate_m_s);
        self.number(&["160", "GS"], NM, report.ground_vector.map(|vector| vector.speed_m_s));
        self.number(
            &["160", "TA"],
            DEGREE,
            report.ground_vector.map(|vector| vector.track_rad),
        );
        match report.air_speed {
            Some(AirSpeed::Indicated(speed_m_s)) => {
                self.code(&["150", "IM"], Some(0));
                self.number(&["150", "AS"], NM, Some(speed_m_s));
            }
            Some(AirSpeed::Mach(mach)) => {
                self.code(&["150", "IM"], Some(1));
                self.number(&["150", "AS"], 1.0, Some(mach));
            }
            None => self.code(&["150", "IM"], None),
        }
        self.number(&["151"], NM / 3600.0, report.true_airspeed_m_s);
        self.number(&["152"], DEGREE, report.magnetic_heading_rad);
        self.number(&["165", "ROT"], DEGREE, report.rate_of_turn_rad_s);
        self.number(&["230"], DEGREE, report.roll_angle_rad);
        self.code(&["020"], report.emitter_category.map(u32::from));
        self.code(&["200"], report.target_status.map(u32::from));
    }
}

fn set_flags(octet: &Value) -> u32 {
    match octet {
        Value::Group(flags) => flags.iter().filter(|(_, flag)| *flag == Value::Unsigned(1)).count() as u32,
        other => panic!("{other:?} is no group of flags"),
    }
}
