//! A direction finder's bearing on board in the system's terms (EL-2, EL-11).

use frames::SystemFrame;
use messages::DetectionKind;
use observations::{Bearing, Detection, DetectionPlatform, TransponderReply};

use crate::carried::Refusal;
use crate::mount::Mount;
use crate::pose::Pose;

impl Mount {
    /// Carries a bearing, measured on board, into the system's terms, as [`Mount::carry`] does with a detection. The
    /// platform's heading stays with the bearing: the heading shows turns.
    ///
    /// # Errors
    /// [`Refusal`]: why the bearing cannot be used.
    pub fn carry_bearing(
        &self,
        bearing: &Bearing,
        pose: &Pose,
        frame: Option<&SystemFrame>,
    ) -> Result<Bearing, Refusal> {
        let measured = Detection {
            time_of_measurement_ns: bearing.time_of_measurement_ns,
            sensor_id: 0,
            scan: 0,
            detection_id: 0,
            kind: DetectionKind::Bearing,
            values: [bearing.bearing_rad, 0.0, 0.0],
            range_rate_mps: None,
            sigmas: Some([bearing.sigma_rad, 0.0, 0.0, 0.0]),
            platform_m: bearing.platform_m,
            platform: DetectionPlatform::default(),
            height: None,
            velocity: None,
            reply: TransponderReply::default(),
            truth: None,
        };
        let carried = self.carry(&measured, pose, None, frame)?;
        Ok(Bearing {
            bearing_rad: carried.detection.values[0],
            sigma_rad: carried.covariance[1][1].sqrt(),
            platform_m: carried.detection.platform_m,
            heading_rad: pose.heading.ok().map(|heading| heading.angle_rad),
            ..*bearing
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::{AngleAt, Mount, Pose};
    use observations::Bearing;

    #[test]
    fn a_bearing_from_the_bow_becomes_one_from_north() {
        let bearing = Bearing {
            time_of_measurement_ns: 5,
            emitter_id: Some(3),
            bearing_rad: 0.25,
            sigma_rad: 0.03,
            platform_m: [0.0; 3],
            heading_rad: None,
            frequency_hz: Some(9e9),
            pulse_interval_s: None,
        };
        let angle = |angle_rad| AngleAt {
            angle_rad,
            rate_radps: 0.0,
            sigma_rad: 0.04,
        };
        let pose = Pose {
            time_ns: 5,
            position_m: [10.0, 20.0, 0.0],
            position_sigma_m: 1.0,
            velocity_mps: None,
            velocity_sigma_mps: 1.0,
            heading: Ok(angle(1.0)),
            tilt: Ok([angle(0.0); 2]),
        };
        let carried = Mount::default().carry_bearing(&bearing, &pose, None).unwrap();
        assert!((carried.bearing_rad - 1.25).abs() < 1e-12);
        assert!((carried.sigma_rad - 0.05).abs() < 1e-9, "{}", carried.sigma_rad);
        assert_eq!(
            (carried.platform_m, carried.heading_rad),
            ([10.0, 20.0, 0.0], Some(1.0))
        );
        assert_eq!((carried.emitter_id, carried.frequency_hz), (Some(3), Some(9e9)));
    }
}
