//! Categories of surveillance data processing systems: 062, 063, 065.

use asterix::typed::fields::Availability;
use asterix::typed::{cat062, cat063, cat065};
use asterix::{Record, Value};

use super::{Agreement, DEGREE, FLIGHT_LEVEL, FOOT, NM};

impl Agreement<'_> {
    pub(super) fn cat062(&mut self, record: &Record<'_>) {
        let track = cat062::TrackMessage::read(record).expect("every record of the category");
        self.source(track.source);
        self.code(&["015"], track.service.map(u32::from));
        self.time("070", track.time_of_day);
        self.geodetic("105", track.geodetic_position);
        let position = track.cartesian_position;
        self.number(&["100", "X"], 1.0, position.map(|position| position.x_m));
        self.number(&["100", "Y"], 1.0, position.map(|position| position.y_m));
        let velocity = track.cartesian_velocity;
        self.number(&["185", "VX"], 1.0, velocity.map(|velocity| velocity.vx_m_s));
        self.number(&["185", "VY"], 1.0, velocity.map(|velocity| velocity.vy_m_s));
        self.acceleration(track.acceleration);
        self.cat062_code(track.mode_3a);
        self.identification(track.identification);
        self.code(&["040"], track.track_number.map(u32::from));
        self.cat062_status(track.track_status);
        self.number(&["136"], FLIGHT_LEVEL, track.measured_altitude_m);
        self.number(&["130"], FOOT, track.geometric_altitude_m);
        let barometric = track.barometric_altitude;
        self.number(
            &["135", "CTB"],
            FLIGHT_LEVEL,
            barometric.map(|altitude| altitude.altitude_m),
        );
        self.flag(&["135", "QNH"], barometric.map(|altitude| altitude.corrected));
        self.number(&["220"], FOOT / 60.0, track.vertical_rate_m_s);
        self.code(&["300"], track.vehicle_fleet.map(u32::from));
        self.cat062_aircraft(&track.aircraft);
        self.cat062_accuracy(&track.accuracy);
    }

    fn cat062_code(&mut self, typed: Option<cat062::TrackCode>) {
        let digits = match self.named.get(&["060", "MODE3A"]) {
            Some(Value::Text(digits)) => Some(digits.clone()),
            _ => None,
        };
        assert_eq!(typed.map(|mode| format!("{:04o}", mode.code)), digits);
        self.flag(&["060", "V"], typed.map(|mode| mode.not_validated));
        self.flag(&["060", "G"], typed.map(|mode| mode.garbled));
        self.flag(&["060", "CH"], typed.map(|mode| mode.changed));
    }

    fn cat062_status(&mut self, typed: Option<cat062::SystemTrackStatus>) {
        self.flag(&["080", "MON"], typed.map(|status| status.one_sensor));
        self.flag(&["080", "SPI"], typed.map(|status| status.special_identification));
        self.flag(&["080", "MRH"], typed.map(|status| status.geometric_height_better));
        self.flag(&["080", "CNF"], typed.map(|status| status.tentative));
        self.flag(&["080", "SIM"], typed.map(|status| status.simulated));
        self.flag(&["080", "TSE"], typed.map(|status| status.ended));
        self.flag(&["080", "TSB"], typed.map(|status| status.begun));
        self.flag(&["080", "ME"], typed.map(|status| status.military_emergency));
        self.flag(&["080", "CST"], typed.map(|status| status.coasting));
        let sent = self.is_sent(&["080", "EMS"]);
        self.emergency(&["080", "EMS"], typed.map(|status| status.emergency).filter(|_| sent));
        self.flag(&["080", "PFT"], typed.map(|status| status.doubtful));
        self.flag(&["080", "FPLT"], typed.map(|status| status.from_flight_plan));
        self.flag(&["080", "SFC"], typed.map(|status| status.on_surface));
    }

    fn cat062_aircraft(&mut self, typed: &cat062::AircraftData) {
        self.code(&["380", "ADR"], typed.address);
        self.text(&["380", "ID"], typed.callsign);
        self.transponder(&["380", "COM"], typed.transponder);
        self.flag(&["380", "SAB", "GBS"], typed.ads_b.map(|status| status.ground_bit));
        self.emergency(&["380", "SAB", "STAT"], typed.ads_b.map(|status| status.emergency));
        self.advisory(&["380", "ACS"], typed.resolution_advisory);
        self.number(&["380", "BVR"], FOOT / 60.0, typed.barometric_rate_m_s);
        self.number(&["380", "GVR"], FOOT / 60.0, typed.geometric_rate_m_s);
        self.code(&["380", "EMC"], typed.emitter_category.map(u32::from));
    }

    fn cat062_accuracy(&mut self, typed: &cat062::Accuracy) {
        let part = |two: Option<[f64; 2]>, i: usize| two.map(|two| two[i]);
        for (i, axis) in ["X", "Y"].into_iter().enumerate() {
            self.number(&["500", "APC", axis], 1.0, part(typed.sigma_position_m, i));
            self.number(&["500", "ATV", axis], 1.0, part(typed.sigma_velocity_m_s, i));
        }
        for (i, axis) in ["LAT", "LON"].into_iter().enumerate() {
            self.number(&["500", "APW", axis], DEGREE, part(typed.sigma_geodetic_rad, i));
        }
        let root = typed
            .covariance_xy_m2
            .map(|covariance| covariance.abs().sqrt() * covariance.signum());
        self.number(&["500", "COV"], 1.0, root);
        self.number(&["500", "AGA"], FOOT, typed.sigma_geometric_altitude_m);
        self.number(&["500", "ABA"], FLIGHT_LEVEL, typed.sigma_barometric_altitude_m);
        self.number(&["500", "ARC"], FOOT / 60.0, typed.sigma_vertical_rate_m_s);
    }

    pub(super) fn cat063(&mut self, record: &Record<'_>) {
        use cat063::Connection;
        let message = cat063::SensorMessage::read(record).expect("every record of the category");
        self.source(message.source);
        self.time("030", message.time_of_day);
        self.code(&["050", "SAC"], message.sensor.map(|sensor| sensor.sac.into()));
        self.code(&["050", "SIC"], message.sensor.map(|sensor| sensor.sic.into()));
        let status = message.status;
        let connection = status.map(|status| match status.connection {
            Connection::Operational => 0,
            Connection::Degraded => 1,
            Connection::Initialising => 2,
            Connection::None => 3,
        });
        self.code(&["060", "CON"], connection);
        self.flag(&["060", "OPS"], status.map(|status| status.unreleased));
        self.any_flag(
            [&["060", "ODP"], &["060", "OXT"]],
            status.map(|status| status.overloaded),
        );
        self.flag(&["060", "TSV"], status.map(|status| status.time_source_invalid));
        self.number(&["070"], 0.001, message.time_bias_s);
        let range = message.range_bias;
        self.number(&["080", "SRG"], 1.0, range.map(|range| range.gain_error));
        self.number(&["080", "SRB"], NM, range.map(|range| range.bias_m));
        self.number(&["081"], DEGREE, message.azimuth_bias_rad);
    }

    pub(super) fn cat065(&mut self, record: &Record<'_>) {
        use cat065::MessageType;
        let message = cat065::ServiceMessage::read(record).expect("every record of the category");
        let number = message.message_type.map(|message_type| match message_type {
            MessageType::SystemStatus => 1,
            MessageType::EndOfBatch => 2,
            MessageType::ServiceStatus => 3,
            MessageType::Undefined(number) => number.into(),
        });
        self.code(&["000"], number);
        self.source(message.source);
        self.time("030", message.time_of_day);
        self.code(&["020"], message.batch.map(u32::from));
        let status = message.system_status;
        let availability = status.map(|status| match status.availability {
            Availability::Operational => 0,
            Availability::Degraded => 1,
            Availability::Unusable => 2,
            Availability::Undefined => 3,
        });
        self.code(&["040", "NOGO"], availability);
        self.flag(&["040", "OVL"], status.map(|status| status.overloaded));
        self.flag(&["040", "TSV"], status.map(|status| status.time_source_invalid));
        self.flag(&["040", "STTN"], status.map(|status| status.numbering));
        self.code(&["050"], message.service_report.map(u32::from));
    }
}
