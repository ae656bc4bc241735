//! A sensor's own frame, and the error a polar sensor makes in it.

use sguaba::math::RigidBodyTransform;
use sguaba::{coordinate, system};
use uom::si::f64::Length;
use uom::si::length::meter;

use crate::geodetic::{Geodetic, SystemEnu, SystemFrame, metres};

system!(struct SensorEnu using ENU);

/// The East-North-Up frame at a sensor's place, with the sensor's alignment to true north.
#[derive(Clone, Copy, Debug)]
pub struct SensorFrame {
    to_system: RigidBodyTransform<SensorEnu, SystemEnu>,
    north_offset_rad: f64,
}

impl SensorFrame {
    /// The frame of a sensor at `place`, whose azimuth zero points `north_offset_rad` clockwise of true north.
    pub fn new(system: &SystemFrame, place: Geodetic, north_offset_rad: f64) -> Self {
        // SAFETY: `SensorEnu` of this value is, by definition, the tangent frame at `place`; it never leaves the value.
        let from_ecef = unsafe { RigidBodyTransform::ecef_to_enu_at(place.wgs84()) };
        let to_system = from_ecef.inverse().and_then(*system.ecef_to_local());
        Self {
            to_system,
            north_offset_rad,
        }
    }

    /// System position of a Cartesian measurement: metres towards the sensor's own x (its east), y (its north), up.
    pub fn cartesian(&self, [x, y, up]: [f64; 3]) -> [f64; 3] {
        let [east, north] = self.turn([x, y]);
        let local = coordinate!(
            e = Length::new::<meter>(east),
            n = Length::new::<meter>(north),
            u = Length::new::<meter>(up);
            in SensorEnu
        );
        metres(&self.to_system.transform(local))
    }

    /// System position of a polar measurement: range along the ground (m), azimuth clockwise from the sensor's north
    /// (rad), height above the sensor (m).
    pub fn polar(&self, ground_range_m: f64, azimuth_rad: f64, up_m: f64) -> [f64; 3] {
        let (sine, cosine) = azimuth_rad.sin_cos();
        self.cartesian([ground_range_m * sine, ground_range_m * cosine, up_m])
    }

    /// A horizontal velocity given along the sensor's own x and y, in the system frame, metres per second.
    pub fn velocity(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        // A velocity is a difference of two positions: the translation drops out.
        let tip = self.cartesian([x, y, 0.0]);
        let foot = self.cartesian([0.0; 3]);
        [tip[0] - foot[0], tip[1] - foot[1]]
    }

    /// Horizontal position of the sensor in the system frame, metres.
    pub fn place(&self) -> [f64; 2] {
        let [east, north, _] = self.cartesian([0.0; 3]);
        [east, north]
    }

    fn turn(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sine, cosine) = self.north_offset_rad.sin_cos();
        [x * cosine + y * sine, y * cosine - x * sine]
    }
}

/// Accuracy of a polar sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolarSigma {
    /// Standard deviation of range, metres.
    pub range_m: f64,
    /// Standard deviation of azimuth, radians.
    pub azimuth_rad: f64,
}

/// Horizontal position covariance (east², east·north, north²; m²) of a polar measurement at `offset` (east, north) from
/// the sensor: range error along the line of sight, azimuth error times range across it (TI-7).
pub fn polar_covariance(offset: [f64; 2], sigma: PolarSigma) -> [f64; 3] {
    let range = offset[0].hypot(offset[1]);
    let (along, across) = (sigma.range_m.powi(2), (sigma.azimuth_rad * range).powi(2));
    if range < 1e-9 {
        return [along, 0.0, along];
    }
    let [east, north] = [offset[0] / range, offset[1] / range];
    [
        along * east * east + across * north * north,
        (along - across) * east * north,
        along * north * north + across * east * east,
    ]
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    fn system() -> SystemFrame {
        SystemFrame::at(Geodetic::from_degrees(41.297063, 2.078447, 0.0).unwrap())
    }

    fn radar(north_offset_rad: f64) -> SensorFrame {
        let place = Geodetic::from_degrees(41.295618, 2.095114, 0.0).unwrap();
        SensorFrame::new(&system(), place, north_offset_rad)
    }

    #[test]
    fn azimuth_runs_clockwise_from_north() {
        let sensor = radar(0.0);
        let [e0, n0] = sensor.place();
        let [east, north, _] = sensor.polar(1000.0, FRAC_PI_2, 0.0);
        assert!(
            (east - e0 - 1000.0).abs() < 0.1 && (north - n0).abs() < 0.5,
            "{east} {north}"
        );
    }

    #[test]
    fn a_north_offset_turns_clockwise() {
        let [e0, n0] = radar(0.1).place();
        let [east, north, _] = radar(0.1).polar(1000.0, 0.0, 0.0);
        assert!((east - e0 - 1000.0 * 0.1f64.sin()).abs() < 0.5, "{east}");
        assert!((north - n0 - 1000.0 * 0.1f64.cos()).abs() < 0.5, "{north}");
    }

    #[test]
    fn polar_and_cartesian_forms_agree() {
        // A plot of the Barcelona radar that carries both: 1063 m at 219.30908° is (-673, -823) m.
        let sensor = radar(0.0);
        let polar = sensor.polar(1063.0, 219.309_082_031_25f64.to_radians(), 0.0);
        let cartesian = sensor.cartesian([-673.0, -823.0, 0.0]);
        assert!((polar[0] - cartesian[0]).hypot(polar[1] - cartesian[1]) < 1.0);
    }

    #[test]
    fn a_velocity_keeps_its_length() {
        let [vx, vy] = radar(0.3).velocity([30.0, 40.0]);
        assert!((vx.hypot(vy) - 50.0).abs() < 1e-6);
    }

    #[test]
    fn polar_error_is_long_across_the_line_of_sight() {
        let sigma = PolarSigma {
            range_m: 10.0,
            azimuth_rad: 0.01,
        };
        let [ee, en, nn] = polar_covariance([0.0, 5000.0], sigma);
        assert!((ee - 2500.0).abs() < 1e-9 && en.abs() < 1e-9 && (nn - 100.0).abs() < 1e-9);
        let [ee, en, nn] = polar_covariance([3000.0, 3000.0], sigma);
        assert!((ee - nn).abs() < 1e-9 && en < 0.0);
    }
}
