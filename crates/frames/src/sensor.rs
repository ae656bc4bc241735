//! A sensor's own frame, and the error a polar sensor makes in it.
//!
//! # Slant range and height
//!
//! A radar measures the straight distance to a target and its azimuth, not its elevation; the height comes from the
//! target itself. To place the target, the line of sight is raised until its end has that height above the earth. On
//! a sphere of radius R this is the triangle of the earth's centre, the sensor and the target, with three known
//! sides: R + h₀, ρ and R + h. On the ellipsoid R depends on place and azimuth. The triangle is therefore solved
//! with the radius of curvature at the sensor (Euler's formula), the height of the resulting point is computed on
//! the ellipsoid, and the difference is added to h; after two rounds the error is less than a centimetre at 400 km.
//! Taking the slant range for a range along the ground instead would put an aircraft at flight level 350 and 20 km
//! almost 3 km off.

use std::f64::consts::TAU;

use sguaba::math::RigidBodyTransform;
use sguaba::{coordinate, system};
use uom::si::f64::Length;
use uom::si::length::meter;

use crate::geodetic::{Geodetic, SystemEnu, SystemFrame, metres};

system!(struct SensorEnu using ENU);

/// Semi-major axis of the WGS-84 ellipsoid, metres.
const SEMI_MAJOR_AXIS_M: f64 = 6_378_137.0;
/// Square of the WGS-84 ellipsoid's first eccentricity.
const ECCENTRICITY_SQUARED: f64 = 6.694_379_990_14e-3;
/// Corrections of the height found on the ellipsoid.
const HEIGHT_ROUNDS: usize = 2;

/// The East-North-Up frame at a sensor's place, with the sensor's alignment to true north.
#[derive(Clone, Copy, Debug)]
pub struct SensorFrame {
    to_system: RigidBodyTransform<SensorEnu, SystemEnu>,
    system: SystemFrame,
    north_offset_rad: f64,
    latitude_rad: f64,
    height_m: f64,
}

/// Where a polar sensor sees a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighting {
    /// Straight distance, metres.
    pub slant_range_m: f64,
    /// Clockwise from the sensor's north, radians in [0, 2π).
    pub azimuth_rad: f64,
    /// Above the sensor's horizontal plane, radians.
    pub elevation_rad: f64,
}

impl SensorFrame {
    /// Returns the direction of the sensor's own north, radians clockwise from true north.
    pub fn north_offset_rad(&self) -> f64 {
        self.north_offset_rad
    }

    /// Makes the frame of a sensor at `place`; its azimuth zero points `north_offset_rad` clockwise of true north.
    pub fn new(system: &SystemFrame, place: Geodetic, north_offset_rad: f64) -> Self {
        // SAFETY: `SensorEnu` of this value is, by definition, the tangent frame at `place`; it never leaves the value.
        let from_ecef = unsafe { RigidBodyTransform::ecef_to_enu_at(place.wgs84()) };
        let to_system = from_ecef.inverse().and_then(*system.ecef_to_local());
        Self {
            to_system,
            system: *system,
            north_offset_rad,
            latitude_rad: place.latitude_deg().to_radians(),
            height_m: place.height_m(),
        }
    }

    /// Height of the sensor above the ellipsoid, metres.
    pub fn height_m(&self) -> f64 {
        self.height_m
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

    /// System position of a target at a straight distance (m) and azimuth (clockwise from the sensor's north, rad), at
    /// a height above the ellipsoid (m). A range too short to reach that height is one straight up.
    pub fn slant(&self, slant_range_m: f64, azimuth_rad: f64, height_m: f64) -> [f64; 3] {
        let radius_m = self.radius_of_curvature(azimuth_rad + self.north_offset_rad);
        let mut triangle_height_m = height_m;
        let mut position_m = [0.0; 3];
        for _ in 0..=HEIGHT_ROUNDS {
            let sine = sine_of_elevation(radius_m + self.height_m, slant_range_m, radius_m + triangle_height_m);
            let along_m = slant_range_m * (1.0 - sine * sine).max(0.0).sqrt();
            let (sin, cos) = azimuth_rad.sin_cos();
            position_m = self.cartesian([along_m * sin, along_m * cos, slant_range_m * sine]);
            triangle_height_m += height_m - self.system.to_geodetic(position_m).height_m();
        }
        position_m
    }

    /// System position of a point above the sensor's plane: metres towards the sensor's own x and y, and height above
    /// the ellipsoid (m), which the plane leaves as the earth curves away beneath it.
    pub fn above(&self, [x, y]: [f64; 2], height_m: f64) -> [f64; 3] {
        let radius_m = self.radius_of_curvature(x.atan2(y) + self.north_offset_rad);
        let sagitta_m = (x * x + y * y) / (2.0 * radius_m);
        self.cartesian([x, y, height_m - self.height_m - sagitta_m])
    }

    /// Where the sensor sees a system position.
    pub fn sighting(&self, position_m: [f64; 3]) -> Sighting {
        let [x, y, up] = self.to_cartesian(position_m);
        Sighting {
            slant_range_m: (x * x + y * y + up * up).sqrt(),
            azimuth_rad: x.atan2(y).rem_euclid(TAU),
            elevation_rad: up.atan2(x.hypot(y)),
        }
    }

    /// Metres towards the sensor's own x, y and up, of a system position: the inverse of
    /// [`cartesian`](Self::cartesian).
    pub fn to_cartesian(&self, [east, north, up]: [f64; 3]) -> [f64; 3] {
        let position = coordinate!(
            e = Length::new::<meter>(east),
            n = Length::new::<meter>(north),
            u = Length::new::<meter>(up);
            in SystemEnu
        );
        let local = self.to_system.inverse_transform(position);
        let [e, n, u] = [local.enu_east(), local.enu_north(), local.enu_up()].map(|length| length.get::<meter>());
        let (sine, cosine) = self.north_offset_rad.sin_cos();
        [e * cosine - n * sine, e * sine + n * cosine, u]
    }

    /// Along the sensor's own x and y, of a horizontal velocity in the system frame: the inverse of
    /// [`velocity`](Self::velocity), metres per second.
    pub fn to_velocity(&self, [vx, vy]: [f64; 2]) -> [f64; 2] {
        let [x0, y0, z0] = self.cartesian([0.0; 3]);
        let tip = self.to_cartesian([x0 + vx, y0 + vy, z0]);
        [tip[0], tip[1]]
    }

    /// Radius of the ellipsoid's curvature at the sensor in the direction of a true azimuth, metres: Euler's formula
    /// over the radii in the meridian and across it.
    fn radius_of_curvature(&self, azimuth_rad: f64) -> f64 {
        let first = 1.0 - ECCENTRICITY_SQUARED * self.latitude_rad.sin().powi(2);
        let across_m = SEMI_MAJOR_AXIS_M / first.sqrt();
        let meridian_m = SEMI_MAJOR_AXIS_M * (1.0 - ECCENTRICITY_SQUARED) / first.powf(1.5);
        let (sine, cosine) = azimuth_rad.sin_cos();
        1.0 / (cosine * cosine / meridian_m + sine * sine / across_m)
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

/// Sine of the angle above the horizontal at which a line of `range` ends at `far` from the earth's centre, seen from
/// `near` from it.
fn sine_of_elevation(near: f64, range: f64, far: f64) -> f64 {
    if range < 1e-9 {
        return 0.0;
    }
    // (far² − near² − range²) / (2·near·range), written so that nearly equal squares are not subtracted.
    (((far - near) * (far + near) - range * range) / (2.0 * near * range)).clamp(-1.0, 1.0)
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

    use proptest::prelude::*;

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
    fn a_bias_of_azimuth_ends_with_the_opposite_north_offset() {
        let truth = [12e3, -31e3, 0.0];
        for (configured, bias) in [(0.0, 0.009), (0.2, -0.02)] {
            // The sensor's azimuths are `bias` too large; positions are right with `configured - bias`.
            let seen = radar(configured - bias).sighting(truth);
            let shown = |north_offset| {
                let sensor: SensorFrame = radar(north_offset);
                let [east, north, _] = sensor.polar(seen.slant_range_m, seen.azimuth_rad, seen.elevation_rad);
                (east - truth[0]).hypot(north - truth[1])
            };
            assert!(shown(configured) > 250.0 && shown(configured - bias) < 1.0);
        }
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
    fn ground_and_slant_range_differ_where_it_matters() {
        // Flight level 350 at 20 km: the right triangle on a flat earth is good to some metres here.
        let sensor = radar(0.0);
        let [e0, n0] = sensor.place();
        let height_m = 350.0 * 30.48;
        let [east, north, _] = sensor.slant(20_000.0, FRAC_PI_2, height_m);
        let ground_m = (20_000.0f64.powi(2) - height_m.powi(2)).sqrt();
        assert!(((east - e0) - ground_m).abs() < 20.0, "{east}");
        assert!((north - n0).abs() < 5.0, "{north}");
    }

    #[test]
    fn a_range_too_short_for_the_height_is_straight_up() {
        let sensor = radar(0.0);
        let [e0, n0] = sensor.place();
        let [east, north, up] = sensor.slant(5000.0, 1.0, 9000.0);
        assert!((east - e0).hypot(north - n0) < 20.0 && (up - 5000.0).abs() < 1.0);
        assert_eq!(sensor.slant(0.0, 1.0, 0.0)[2], sensor.cartesian([0.0; 3])[2]);
    }

    #[test]
    fn heights_above_the_plane_follow_the_earth() {
        let sensor = radar(0.2);
        for offset in [[0.0, 0.0], [60e3, -20e3], [-100e3, 150e3]] {
            let place = system().to_geodetic(sensor.above(offset, 3000.0));
            assert!(
                (place.height_m() - 3000.0).abs() < 3.0,
                "{offset:?}: {}",
                place.height_m()
            );
        }
    }

    proptest! {
        /// A radar's measurement of any place gives, with that place's height, the place back.
        #[test]
        fn a_sighting_leads_back(
            east in -400e3..400e3f64, north in -400e3..400e3f64, height in 0.0..20e3f64, offset in -0.5..0.5f64,
        ) {
            let place = system().to_geodetic([east, north, height]);
            let position = system().to_local(place);
            let sensor = radar(offset);
            let seen = sensor.sighting(position);
            let found = sensor.slant(seen.slant_range_m, seen.azimuth_rad, place.height_m());
            let off: f64 = (0..3).map(|axis| (found[axis] - position[axis]).powi(2)).sum::<f64>().sqrt();
            prop_assert!(off < 0.05 || seen.slant_range_m < 100.0, "{off} m at {} m", seen.slant_range_m);
            let back = sensor.cartesian(sensor.to_cartesian(position));
            prop_assert!((0..3).all(|axis| (back[axis] - position[axis]).abs() < 1e-6));
            let velocity = sensor.velocity(sensor.to_velocity([120.0, -50.0]));
            prop_assert!((velocity[0] - 120.0).abs() < 0.5 && (velocity[1] + 50.0).abs() < 0.5, "{velocity:?}");
        }
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
