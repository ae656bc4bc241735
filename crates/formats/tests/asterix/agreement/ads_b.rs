//! Categories of ADS-B: 021 in both layouts, 023.

use asterix::typed::{cat021_v0, cat021_v2, cat023};
use asterix::{Record, Value};

use super::{Agreement, DEGREE, FLIGHT_LEVEL, FOOT, NM};

impl Agreement<'_> {
    pub(super) fn cat021_v0(&mut self, record: &Record<'_>) {
        use cat021_v0::{AddressType, AirSpeed};
        let report = cat021_v0::TargetReport::read(record).expect("every record of the category");
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
        self.velocity_polar("160", ["GS", "TA"], report.ground_vector);
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
        self.emergency(&["200"], report.emergency);
        self.mode_3a("070", report.mode_3a);
    }

    pub(super) fn cat021_v2(&mut self, record: &Record<'_>) {
        let report = cat021_v2::TargetReport::read(record).expect("every record of the category");
        self.source(report.source);
        self.code(&["015"], report.service.map(u32::from));
        for (item, time) in [
            ("071", report.position_time),
            ("072", report.velocity_time),
            ("073", report.position_reception),
            ("075", report.velocity_reception),
            ("077", report.transmission),
        ] {
            self.time(item, time);
        }
        self.fine_time("074", report.position_reception_fraction);
        self.fine_time("076", report.velocity_reception_fraction);
        self.cat021_v2_descriptor(report.descriptor);
        let position = if self.is_sent(&["131"]) { "131" } else { "130" };
        self.geodetic(position, report.geodetic_position);
        self.code(&["080"], report.address);
        self.code(&["161", "TRNUM"], report.track_number.map(u32::from));
        self.text(&["170"], report.callsign);
        let digits = match self.named.get(&["070", "MODE3A"]) {
            Some(Value::Text(digits)) => Some(digits.clone()),
            _ => None,
        };
        assert_eq!(report.mode_3a.map(|code| format!("{code:04o}")), digits);
        self.number(&["145"], FLIGHT_LEVEL, report.pressure_altitude_m);
        let greatest = self.number_at(&["140"]) == Some(204_793.75);
        self.number_in_range(&["140"], greatest, FOOT, report.geometric_height_m);
        let out = |item: &str| self.number_at(&[item, "RE"]) == Some(1.0);
        let [out_155, out_157, out_160] = ["155", "157", "160"].map(out);
        self.number_in_range(&["155", "BVR"], out_155, FOOT / 60.0, report.barometric_rate_m_s);
        self.number_in_range(&["157", "GVR"], out_157, FOOT / 60.0, report.geometric_rate_m_s);
        let vector = report.ground_vector;
        self.number_in_range(&["160", "GS"], out_160, NM, vector.map(|vector| vector.speed_m_s));
        self.number_in_range(&["160", "TA"], out_160, DEGREE, vector.map(|vector| vector.track_rad));
        self.cat021_v2_quality(&report);
        self.cat021_v2_status(&report);
        self.code(&["020"], report.emitter_category.map(u32::from));
    }

    fn number_at(&self, path: &[&str]) -> Option<f64> {
        self.named.get(path).and_then(Value::as_f64)
    }

    fn fine_time(&mut self, item: &str, typed: Option<cat021_v2::FineTime>) {
        let second = typed.map(|time| match time.second {
            Some(0) => 0,
            Some(1) => 1,
            Some(-1) => 2,
            None => 3,
            other => panic!("{other:?}"),
        });
        self.code(&[item, "FSI"], second);
        let fraction_s = typed.map(|time| f64::from(time.fraction) / (1u32 << 30) as f64);
        self.number(&[item, "TOMRP"], 1.0, fraction_s);
    }

    fn cat021_v2_descriptor(&mut self, typed: Option<cat021_v2::Descriptor>) {
        use cat021_v2::AddressType;
        let address_type = typed.map(|descriptor| match descriptor.address_type {
            AddressType::Icao => 0,
            AddressType::Duplicate => 1,
            AddressType::SurfaceVehicle => 2,
            AddressType::Anonymous => 3,
            AddressType::Reserved(number) => number.into(),
        });
        self.code(&["040", "ATP"], address_type);
        self.flag(&["040", "RAB"], typed.map(|descriptor| descriptor.field_monitor));
        self.flag(&["040", "GBS"], typed.map(|descriptor| descriptor.ground_bit));
        self.flag(&["040", "SIM"], typed.map(|descriptor| descriptor.simulated));
        self.flag(&["040", "TST"], typed.map(|descriptor| descriptor.test));
        let suspect = self.number_at(&["040", "CL"]) == Some(1.0);
        assert_eq!(typed.is_some_and(|descriptor| descriptor.suspect), suspect);
        self.flag(&["040", "LLC"], typed.map(|descriptor| descriptor.list_failed));
        self.flag(
            &["040", "IPC"],
            typed.map(|descriptor| descriptor.position_check_failed),
        );
        self.flag(&["040", "NOGO"], typed.map(|descriptor| descriptor.unreleased));
        self.flag(&["040", "CPR"], typed.map(|descriptor| descriptor.decoding_failed));
        self.flag(&["040", "LDPJ"], typed.map(|descriptor| descriptor.jumped));
        self.flag(&["040", "RCF"], typed.map(|descriptor| descriptor.range_check_failed));
    }

    fn cat021_v2_quality(&mut self, report: &cat021_v2::TargetReport) {
        let quality = report.quality;
        self.code(
            &["090", "NUCRNACV"],
            quality.map(|quality| quality.velocity_category.into()),
        );
        self.code(
            &["090", "NUCPNIC"],
            quality.map(|quality| quality.integrity_category.into()),
        );
        let further = |category: fn(&cat021_v2::QualityIndicators) -> Option<u8>| {
            quality.as_ref().and_then(category).map(u32::from)
        };
        self.code(&["090", "SIL"], further(|quality| quality.integrity_level));
        self.code(&["090", "NACP"], further(|quality| quality.accuracy_category));
        self.code(&["090", "GVA"], further(|quality| quality.altitude_accuracy));
        self.code(&["090", "PIC"], further(|quality| quality.containment_category));
        self.code(&["210", "VN"], report.version.map(u32::from));
    }

    fn cat021_v2_status(&mut self, report: &cat021_v2::TargetReport) {
        use cat021_v2::SurveillanceStatus;
        let status = report.target_status;
        self.emergency(&["200", "PS"], status.map(|status| status.emergency));
        self.flag(&["200", "ME"], status.map(|status| status.military_emergency));
        let surveillance = status.map(|status| match status.surveillance {
            SurveillanceStatus::None => 0,
            SurveillanceStatus::PermanentAlert => 1,
            SurveillanceStatus::TemporaryAlert => 2,
            SurveillanceStatus::SpecialIdentification => 3,
        });
        self.code(&["200", "SS"], surveillance);
        self.flag(&["008", "RA"], report.advised);
        let advisory = report.resolution_advisory;
        self.code(&["260", "ARA"], advisory.map(|advisory| advisory.advisories.into()));
        self.flag(&["260", "RAT"], advisory.map(|advisory| advisory.terminated));
        self.flag(&["260", "MTE"], advisory.map(|advisory| advisory.multiple_threats));
    }

    pub(super) fn cat023(&mut self, record: &Record<'_>) {
        use cat023::{ReportType, ServiceStatus};
        let message = cat023::ServiceMessage::read(record).expect("every record of the category");
        let number = message.report_type.map(|report_type| match report_type {
            ReportType::StationStatus => 1,
            ReportType::ServiceStatus => 2,
            ReportType::ServiceStatistics => 3,
            ReportType::Undefined(number) => number.into(),
        });
        self.code(&["000"], number);
        self.source(message.source);
        self.time("070", message.time_of_day);
        let status = message.station_status;
        self.flag(&["100", "NOGO"], status.map(|status| status.unreleased));
        self.any_flag(
            [&["100", "ODP"], &["100", "OXT"]],
            status.map(|status| status.overloaded),
        );
        self.flag(&["100", "TSV"], status.map(|status| status.time_source_invalid));
        self.flag(&["100", "SPO"], status.map(|status| status.spoofed));
        self.flag(&["100", "RN"], status.map(|status| status.renumbered));
        let service = message.service_status.map(|status| match status {
            ServiceStatus::Unknown => 0,
            ServiceStatus::Failed => 1,
            ServiceStatus::Disabled => 2,
            ServiceStatus::Degraded => 3,
            ServiceStatus::Normal => 4,
            ServiceStatus::Initialising => 5,
            ServiceStatus::Undefined(number) => number.into(),
        });
        self.code(&["110", "STAT"], service);
        self.number(&["200"], NM, message.range_m);
    }
}
