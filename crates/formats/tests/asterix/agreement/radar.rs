//! Categories of radars: 001 and 002, 034 and 048.

use asterix::typed::fields::{Emergency, FlightLevel};
use asterix::typed::{cat001, cat002, cat034, cat048};
use asterix::{Record, Value};

use super::{Agreement, DEGREE, FLIGHT_LEVEL, FOOT, NM};

impl Agreement<'_> {
    pub(super) fn cat001(&mut self, record: &Record<'_>) {
        let report = cat001::TargetReport::read(record).expect("every record of the category");
        self.source(report.source);
        self.number(&["141"], 128.0, report.time.map(|time| time.ticks.into()));
        self.cat001_descriptor(report.descriptor);
        self.slant(report.slant_position);
        self.number(
            &["042", "X"],
            NM,
            report.cartesian_position.map(|position| position.x_m),
        );
        self.number(
            &["042", "Y"],
            NM,
            report.cartesian_position.map(|position| position.y_m),
        );
        self.velocity_polar("200", ["GSP", "HDG"], report.polar_velocity);
        self.code(&["161"], report.track_number.map(u32::from));
        let status = report.track_status;
        self.flag(&["170", "CON"], status.map(|status| status.tentative));
        self.flag(&["170", "MAN"], status.map(|status| status.manoeuvring));
        self.flag(&["170", "DOU"], status.map(|status| status.doubtful));
        self.flag(&["170", "GHO"], status.map(|status| status.ghost));
        self.flag(&["170", "TRE"], status.map(|status| status.ended));
        self.mode_3a("070", report.mode_3a);
        let level = report.flight_level;
        self.number(&["090", "HGT"], FLIGHT_LEVEL, level.map(|level| level.altitude_m));
        self.flag(&["090", "V"], level.map(|level| level.not_validated));
        self.flag(&["090", "G"], level.map(|level| level.garbled));
    }

    fn cat001_descriptor(&mut self, typed: Option<cat001::Descriptor>) {
        use cat001::Detection;
        self.flag(&["020", "TYP"], typed.map(|descriptor| descriptor.is_track));
        let detection = typed.map(|descriptor| match descriptor.detection {
            Detection::None => 0,
            Detection::Primary => 1,
            Detection::Secondary => 2,
            Detection::Combined => 3,
        });
        self.code(&["020", "SSRPSR"], detection);
        self.flag(&["020", "SIM"], typed.map(|descriptor| descriptor.simulated));
        self.flag(
            &["020", "SPI"],
            typed.map(|descriptor| descriptor.special_identification),
        );
        self.flag(&["020", "RAB"], typed.map(|descriptor| descriptor.field_monitor));
        self.flag(&["020", "TST"], typed.map(|descriptor| descriptor.test));
        let emergency = typed.map(|descriptor| match descriptor.emergency {
            Emergency::None => 0,
            Emergency::UnlawfulInterference => 1,
            Emergency::CommunicationFailure => 2,
            Emergency::General => 3,
            other => panic!("{other:?}"),
        });
        let sent = self.is_sent(&["020", "DS1DS2"]);
        self.code(&["020", "DS1DS2"], emergency.filter(|_| sent));
        assert!(sent || emergency.is_none_or(|emergency| emergency == 0));
        self.flag(&["020", "ME"], typed.map(|descriptor| descriptor.military_emergency));
        self.flag(
            &["020", "MI"],
            typed.map(|descriptor| descriptor.military_identification),
        );
    }

    pub(super) fn cat002(&mut self, record: &Record<'_>) {
        use cat002::MessageType;
        let message = cat002::ServiceMessage::read(record).expect("every record of the category");
        let number = message.message_type.map(|message_type| match message_type {
            MessageType::NorthMarker => 1,
            MessageType::SectorCrossing => 2,
            MessageType::SouthMarker => 3,
            MessageType::BlindZoneBegins => 8,
            MessageType::BlindZoneEnds => 9,
            MessageType::Undefined(number) => number.into(),
        });
        self.code(&["000"], number);
        self.source(message.source);
        self.time("030", message.time_of_day);
        self.number(&["020"], DEGREE, message.sector_azimuth_rad);
        self.number(&["041"], 1.0, message.antenna_period_s);
    }

    pub(super) fn cat034(&mut self, record: &Record<'_>) {
        use cat034::MessageType;
        let message = cat034::ServiceMessage::read(record).expect("every record of the category");
        let number = message.message_type.map(|message_type| match message_type {
            MessageType::NorthMarker => 1,
            MessageType::SectorCrossing => 2,
            MessageType::GeographicalFilter => 3,
            MessageType::JammingStrobe => 4,
            MessageType::SolarStorm => 5,
            MessageType::SecondaryJammingStrobe => 6,
            MessageType::ModeSJammingStrobe => 7,
            MessageType::Undefined(number) => number.into(),
        });
        self.code(&["000"], number);
        self.source(message.source);
        self.time("030", message.time_of_day);
        self.number(&["020"], DEGREE, message.sector_azimuth_rad);
        self.number(&["041"], 1.0, message.antenna_period_s);
        let status = message.status;
        self.flag(&["050", "COM", "NOGO"], status.map(|status| status.unreleased));
        self.flag(&["050", "COM", "RDPR"], status.map(|status| status.restarted));
        self.any_flag(
            [&["050", "COM", "OVLRDP"], &["050", "COM", "OVLXMT"]],
            status.map(|status| status.overloaded),
        );
        self.flag(&["050", "COM", "TSV"], status.map(|status| status.time_source_invalid));
        self.geodetic("120", message.position.map(|position| position.place));
        self.number(&["120", "HGT"], 1.0, message.position.map(|position| position.height_m));
    }

    pub(super) fn cat048(&mut self, record: &Record<'_>) {
        let report = cat048::TargetReport::read(record).expect("every record of the category");
        self.source(report.source);
        self.time("140", report.time_of_day);
        self.cat048_descriptor(report.descriptor);
        self.slant(report.slant_position);
        self.number(
            &["042", "X"],
            NM,
            report.cartesian_position.map(|position| position.x_m),
        );
        self.number(
            &["042", "Y"],
            NM,
            report.cartesian_position.map(|position| position.y_m),
        );
        self.velocity_polar("200", ["GSP", "HDG"], report.polar_velocity);
        self.code(&["161", "TRN"], report.track_number.map(u32::from));
        self.cat048_track(&report);
        self.mode_3a("070", report.mode_3a);
        self.signed_flight_level(report.flight_level);
        self.number(&["110", "3DH"], FOOT, report.measured_height_m);
        self.code(&["220"], report.address);
        self.text(&["240"], report.callsign);
        self.transponder(&["230"], report.transponder);
        self.advisory(&["260"], report.resolution_advisory);
        self.warnings(report.warnings);
        self.registers(record);
    }

    fn cat048_descriptor(&mut self, typed: Option<cat048::Descriptor>) {
        use cat048::Detection;
        let detection = typed.map(|descriptor| match descriptor.detection {
            Detection::None => 0,
            Detection::Primary => 1,
            Detection::Secondary => 2,
            Detection::Combined => 3,
            Detection::AllCall => 4,
            Detection::RollCall => 5,
            Detection::AllCallCombined => 6,
            Detection::RollCallCombined => 7,
        });
        self.code(&["020", "TYP"], detection);
        self.flag(&["020", "SIM"], typed.map(|descriptor| descriptor.simulated));
        self.flag(
            &["020", "SPI"],
            typed.map(|descriptor| descriptor.special_identification),
        );
        self.flag(&["020", "RAB"], typed.map(|descriptor| descriptor.field_monitor));
        self.flag(&["020", "TST"], typed.map(|descriptor| descriptor.test));
        self.flag(&["020", "ERR"], typed.map(|descriptor| descriptor.beyond_range));
        self.flag(&["020", "ME"], typed.map(|descriptor| descriptor.military_emergency));
        self.flag(
            &["020", "MI"],
            typed.map(|descriptor| descriptor.military_identification),
        );
    }

    fn cat048_track(&mut self, report: &cat048::TargetReport) {
        let status = report.track_status;
        self.flag(&["170", "CNF"], status.map(|status| status.tentative));
        self.flag(&["170", "DOU"], status.map(|status| status.doubtful));
        self.flag(&["170", "MAH"], status.map(|status| status.manoeuvring));
        self.flag(&["170", "TRE"], status.map(|status| status.ended));
        self.flag(&["170", "GHO"], status.map(|status| status.ghost));
        self.flag(&["170", "SUP"], status.map(|status| status.from_neighbour));
        self.flag(&["170", "TCC"], status.map(|status| status.slant_corrected));
        let quality = report.track_quality;
        self.number(&["210", "SIGX"], NM, quality.map(|quality| quality.sigma_x_m));
        self.number(&["210", "SIGY"], NM, quality.map(|quality| quality.sigma_y_m));
        self.number(&["210", "SIGV"], NM, quality.map(|quality| quality.sigma_speed_m_s));
        self.number(&["210", "SIGH"], DEGREE, quality.map(|quality| quality.sigma_track_rad));
    }

    /// In two's complement, which only the last edition's table knows.
    fn signed_flight_level(&mut self, typed: Option<FlightLevel>) {
        let named = self.named.get(&["090", "FL"]).and_then(Value::as_f64);
        let signed = named.map(|level| if level >= 2048.0 { level - 4096.0 } else { level });
        let typed_level = typed.map(|level| level.altitude_m / FLIGHT_LEVEL);
        assert_eq!(
            typed_level.map(|level| level * 4.0).map(f64::round),
            signed.map(|level| level * 4.0)
        );
        self.flag(&["090", "V"], typed.map(|level| level.not_validated));
        self.flag(&["090", "G"], typed.map(|level| level.garbled));
    }

    fn warnings(&mut self, typed: Option<cat048::Warnings>) {
        let Some(Value::List(named)) = self.named.get(&["030"]) else {
            assert_eq!(typed, None);
            return;
        };
        let typed = typed.expect("warnings");
        for number in 0..=u8::MAX {
            let given = named.iter().any(|value| value.as_f64() == Some(number.into()));
            assert_eq!(typed.contains(number), given, "{number}");
        }
        self.compared += named.len();
    }

    fn registers(&mut self, record: &Record<'_>) {
        let typed: Vec<_> = cat048::registers(record).collect();
        let named = match self.named.get(&["250"]) {
            Some(Value::List(named)) => &named[..],
            _ => &[],
        };
        assert_eq!(typed.len(), named.len());
        for (typed, named) in typed.iter().zip(named) {
            let digit = |name| named.get(name).and_then(Value::as_f64);
            assert_eq!(digit("BDS1"), Some((typed.number >> 4).into()));
            assert_eq!(digit("BDS2"), Some((typed.number & 0x0F).into()));
            let content = typed
                .content
                .iter()
                .fold(0, |bits, octet| bits << 8 | u64::from(*octet));
            assert_eq!(named.get("MBDATA"), Some(&Value::Unsigned(content)));
            self.compared += 1;
        }
    }
}
