//! Categories of an airport's sensors: 010, 019, 020.

use asterix::typed::{cat010, cat019, cat020};
use asterix::{Record, Value};

use super::{Agreement, DEGREE, FOOT, set_flags};

impl Agreement<'_> {
    pub(super) fn cat010(&mut self, record: &Record<'_>) {
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
        self.velocity_polar("200", ["GSP", "TRA"], report.polar_velocity);
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

    pub(super) fn cat019(&mut self, record: &Record<'_>) {
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

    pub(super) fn cat020(&mut self, record: &Record<'_>) {
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
        self.transponder(&["230"], report.transponder);
        self.advisory(&["260"], report.resolution_advisory);
    }
}
