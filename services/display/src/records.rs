//! Conversion of samples to records of a picture.

use std::f64::consts::{FRAC_PI_2, PI};

use frames::{Geodetic, SystemFrame};
use messages::picture::{
    NO_CODE, PictureArea, PictureAreaKind, PictureBearing, PictureDetection, PictureIdentity, PictureSensorTrack,
    PictureStation, PictureTrack, picture_station_bits, picture_track_bits,
};
use messages::{
    Covariance, Cue, DetectionKind, Quantity, SensorBearing, SensorDetection, SensorTrack, SystemTrack, TargetCategory,
    TargetStatement, WideArea, sensor_detection_bits, sensor_track_bits, target_statement_bits,
};

use crate::vertical;

/// Number of sources with a bit in a record's contributors.
const SOURCES_TOLD: u16 = 64;

/// Returns the record of a state; `before` holds the flags of the track's previous state. The caller sets the ages.
pub(crate) fn track(track: &SystemTrack, frame: Option<&SystemFrame>, before: u8) -> PictureTrack {
    let [east, north, _] = track.position_m;
    let [east_mps, north_mps, _] = track.velocity_mps.map(|speed| speed as f32);
    let vertical = vertical::shown(track, frame, before);
    let [semi_major_m, semi_minor_m, semi_major_rad] = ellipse(&track.covariance);
    let told = track.contributions().iter().map(|part| part.source);
    let sources = told
        .filter(|source| *source < SOURCES_TOLD)
        .fold(0_u64, |sources, source| sources | 1 << source);
    let flag = |is_set: bool, bit: u8| if is_set { bit } else { 0 };
    PictureTrack {
        number: track.track_number,
        east_m: east as f32,
        north_m: north as f32,
        height_m: vertical.height_m,
        east_mps,
        north_mps,
        climb_mps: vertical.climb_mps,
        semi_major_m,
        semi_minor_m,
        semi_major_rad,
        sources_low: sources as u32,
        sources_high: (sources >> 32) as u32,
        main_source: track.selected_source,
        source_count: u8::try_from(track.source_count).unwrap_or(u8::MAX),
        members: u8::try_from(track.members).unwrap_or(u8::MAX),
        state: track.state,
        kind: track.kind,
        alerts: track.alerts,
        flags: flag(track.velocity_valid != 0, picture_track_bits::VELOCITY)
            | vertical.flags
            | flag(track.on_ground != 0, picture_track_bits::ON_GROUND),
        ..PictureTrack::default()
    }
}

/// Returns the time of the latest measurement in a state, UTC, nanoseconds; the state's own time if there is none.
pub(crate) fn measured_ns(track: &SystemTrack) -> i64 {
    let measured = track.contributions().iter().map(|part| part.time_of_measurement_ns);
    measured.max().unwrap_or(track.reference_time_ns)
}

/// Returns the ellipse of one standard deviation: longer and shorter half axis, metres, and direction of the longer
/// axis, radians clockwise from north; zeros for an invalid covariance.
pub(crate) fn ellipse(covariance: &Covariance) -> [f32; 3] {
    let [east, both, north] = [(0, 0), (0, 1), (1, 1)].map(|(row, column)| covariance.get(row, column));
    let (mean, half) = ((east + north) / 2.0, ((east - north) / 2.0).hypot(both));
    let axes = [mean + half, mean - half];
    if !(axes[1] > 0.0 && axes[0].is_finite()) {
        return [0.0; 3];
    }
    let from_east = 0.5 * (2.0 * both).atan2(east - north);
    [
        axes[0].sqrt() as f32,
        axes[1].sqrt() as f32,
        (FRAC_PI_2 - from_east).rem_euclid(PI) as f32,
    ]
}

/// Returns the record of a track's identity and type.
pub(crate) fn identity(track: &SystemTrack) -> PictureIdentity {
    let (identity, target_type) = (&track.identity, &track.target_type);
    PictureIdentity {
        number: track.track_number,
        address: identity.address,
        mode_3a: identity.mode_3a,
        kind: identity.kind,
        valid: identity.valid,
        callsign: identity.callsign,
        name: identity.name,
        type_name: if target_type.is_known() {
            target_type.name
        } else {
            [b' '; 12]
        },
        type_confidence: if target_type.is_known() {
            target_type.confidence
        } else {
            0.0
        },
    }
}

/// Returns the record of a report. The caller sets its age and system track.
pub(crate) fn sensor_track(report: &SensorTrack, frame: Option<&SystemFrame>) -> PictureSensorTrack {
    let [east, north, _] = report.position_m;
    let height = report.has(sensor_track_bits::HEIGHT);
    let [east_mps, north_mps, _] = report.velocity_mps;
    let bits = [
        (sensor_track_bits::ON_GROUND, picture_track_bits::ON_GROUND),
        (sensor_track_bits::HEIGHT, picture_track_bits::HEIGHT),
        (sensor_track_bits::VELOCITY, picture_track_bits::VELOCITY),
    ];
    let set = bits.into_iter().filter(|(bit, _)| report.has(*bit));
    PictureSensorTrack {
        track_number: report.track_number,
        east_m: east as f32,
        north_m: north as f32,
        height_m: height_m(height.then_some(report.position_m), frame),
        east_mps: east_mps as f32,
        north_mps: north_mps as f32,
        source: report.source,
        mode_3a: report.identity.mode_3a().unwrap_or(NO_CODE),
        state: report.state,
        flags: set.fold(0, |flags, (_, flag)| flags | flag),
        ..PictureSensorTrack::default()
    }
}

/// Returns the height above the ellipsoid of a complete position, metres; else NaN.
fn height_m(position_m: Option<[f64; 3]>, frame: Option<&SystemFrame>) -> f32 {
    let place = position_m
        .zip(frame)
        .map(|(position_m, frame)| frame.to_geodetic(position_m));
    place.map_or(f32::NAN, |place| place.height_m() as f32)
}

/// Place of a detection; a ray if only a direction was measured.
pub(crate) enum DetectionPlace {
    /// A point.
    Spot(PictureDetection),
    /// A direction.
    Ray(PictureBearing),
}

/// Returns the record of a detection; `None` if its kind is unknown, or the sample is a mark of time.
pub(crate) fn detection(detection: &SensorDetection, frame: Option<&SystemFrame>) -> Option<DetectionPlace> {
    if detection.valid & sensor_detection_bits::MARK != 0 {
        return None;
    }
    let quantities = DetectionKind::from_code(detection.kind)?.quantities();
    let value = |wanted: Quantity| {
        let place = quantities.iter().position(|quantity| *quantity == wanted)?;
        Some((detection.values[place], detection.sigmas[place]))
    };
    let [from_east, from_north, from_up] = detection.platform_m;
    let elevation = value(Quantity::Elevation).map_or(0.0, |(elevation, _)| elevation);
    let (east, north, up) = match (value(Quantity::Range), value(Quantity::Bearing)) {
        (Some((range, _)), Some((bearing, _))) => {
            let ground = range * elevation.cos();
            let up = value(Quantity::Elevation).map(|_| from_up + range * elevation.sin());
            (
                from_east + ground * bearing.sin(),
                from_north + ground * bearing.cos(),
                up,
            )
        }
        (None, Some((bearing, sigma))) => {
            return Some(DetectionPlace::Ray(PictureBearing {
                east_m: from_east as f32,
                north_m: from_north as f32,
                bearing_rad: bearing as f32,
                sigma_rad: sigma as f32,
                source: detection.source,
                ..PictureBearing::default()
            }));
        }
        _ => {
            let up = value(Quantity::Up).map(|(up, _)| up);
            (value(Quantity::East)?.0, value(Quantity::North)?.0, up)
        }
    };
    Some(DetectionPlace::Spot(PictureDetection {
        east_m: east as f32,
        north_m: north as f32,
        height_m: height_m(up.map(|up| [east, north, up]), frame),
        source: detection.source,
        ..PictureDetection::default()
    }))
}

/// Returns the record of a bearing.
pub(crate) fn bearing(bearing: &SensorBearing) -> PictureBearing {
    PictureBearing {
        east_m: bearing.platform_m[0] as f32,
        north_m: bearing.platform_m[1] as f32,
        bearing_rad: bearing.bearing_rad as f32,
        sigma_rad: bearing.sigma_rad as f32,
        source: bearing.source,
        ..PictureBearing::default()
    }
}

/// Returns the record of a count.
pub(crate) fn count(count: &WideArea) -> PictureArea {
    PictureArea {
        east_m: count.position_m[0] as f32,
        north_m: count.position_m[1] as f32,
        east_mps: count.velocity_mps[0] as f32,
        north_mps: count.velocity_mps[1] as f32,
        number: count.targets,
        sensor: count.sensor,
        kind: PictureAreaKind::Count.code(),
        ..PictureArea::default()
    }
}

/// Returns the record of a cue.
pub(crate) fn cue(cue: &Cue) -> PictureArea {
    PictureArea {
        east_m: cue.position_m[0] as f32,
        north_m: cue.position_m[1] as f32,
        east_mps: cue.velocity_mps[0] as f32,
        north_mps: cue.velocity_mps[1] as f32,
        semi_major_m: cue.half_axes_m[0] as f32,
        semi_minor_m: cue.half_axes_m[1] as f32,
        semi_major_rad: cue.orientation_rad as f32,
        number: cue.track_number,
        sensor: cue.source,
        kind: PictureAreaKind::Cue.code(),
        ..PictureArea::default()
    }
}

/// Returns the record of a station that is no target; `None` if its place is none. The caller sets the age.
pub(crate) fn station(stated: &TargetStatement, frame: &SystemFrame) -> Option<PictureStation> {
    let [latitude_deg, longitude_deg] = stated.place_deg;
    let place = Geodetic::from_degrees(latitude_deg, longitude_deg, 0.0).ok()?;
    let [east_m, north_m, _] = frame.to_local(place).map(|metres| metres as f32);
    let has_size = stated.valid & target_statement_bits::SIZE != 0;
    let flags = [
        (
            stated.category == TargetCategory::BaseStation.code(),
            picture_station_bits::BASE,
        ),
        (
            stated.valid & target_statement_bits::VIRTUAL != 0,
            picture_station_bits::VIRTUAL,
        ),
        (
            stated.valid & target_statement_bits::OFF_POSITION != 0,
            picture_station_bits::OFF_POSITION,
        ),
    ];
    let set = flags.into_iter().filter(|(is_set, _)| *is_set);
    (east_m.is_finite() && north_m.is_finite()).then(|| PictureStation {
        east_m,
        north_m,
        length_m: if has_size { stated.length_m } else { 0.0 },
        width_m: if has_size { stated.width_m } else { 0.0 },
        mmsi: stated.track_number,
        name: stated.name,
        source: stated.source,
        aid: stated.aid,
        flags: set.fold(0, |flags, (_, flag)| flags | flag),
        ..PictureStation::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mark_of_time_is_no_detection() {
        let mark = SensorDetection {
            kind: messages::DetectionMark::EmptyScan.code(),
            valid: sensor_detection_bits::MARK,
            ..SensorDetection::default()
        };
        assert!(
            DetectionKind::from_code(mark.kind).is_some(),
            "the codes are those of detections, too"
        );
        assert!(detection(&mark, None).is_none());
    }

    #[test]
    fn the_ellipse_lies_as_the_covariance_says() {
        let mut covariance = Covariance::diagonal([30.0, 10.0, 1.0], [1.0; 3]);
        let near = |found: [f32; 3], expected: [f32; 3]| {
            let pairs = found.into_iter().zip(expected);
            assert!(
                pairs.into_iter().all(|(a, b)| (a - b).abs() < 1e-3),
                "{found:?} {expected:?}"
            );
        };
        near(ellipse(&covariance), [30.0, 10.0, std::f32::consts::FRAC_PI_2]);
        covariance = Covariance::diagonal([10.0, 30.0, 1.0], [1.0; 3]);
        let [.., direction] = ellipse(&covariance);
        assert!(
            direction.min(std::f32::consts::PI - direction) < 1e-3,
            "north: {direction}"
        );
        // Half way between north and east: equal variances, positive covariance.
        covariance = Covariance::diagonal([10.0, 10.0, 1.0], [1.0; 3]);
        covariance.set(0, 1, 50.0);
        near(
            ellipse(&covariance),
            [150_f32.sqrt(), 50_f32.sqrt(), std::f32::consts::FRAC_PI_4],
        );
        covariance.set(0, 1, f64::NAN);
        assert_eq!(ellipse(&covariance), [0.0; 3]);
    }

    #[test]
    fn detections_are_where_they_were_measured_from() {
        let frame = SystemFrame::at(frames::Geodetic::from_degrees(41.3, 2.1, 0.0).unwrap());
        let measured = |kind: DetectionKind, values: [f64; 3]| {
            let platform_m = [100.0, 200.0, 10.0];
            let measured = SensorDetection {
                kind: kind as u8,
                values,
                platform_m,
                ..SensorDetection::default()
            };
            detection(&measured, Some(&frame))
        };
        let east = std::f64::consts::FRAC_PI_2;
        match measured(DetectionKind::RangeBearing, [1_000.0, east, 0.0]) {
            Some(DetectionPlace::Spot(spot)) => {
                assert!((spot.east_m - 1_100.0).abs() < 1e-3 && (spot.north_m - 200.0).abs() < 1e-3);
                assert!(spot.height_m.is_nan());
            }
            _ => panic!("a spot"),
        }
        assert!(
            matches!(measured(DetectionKind::Bearing, [east, 0.0, 0.0]), Some(DetectionPlace::Ray(ray)) if ray.east_m == 100.0)
        );
        let place = measured(DetectionKind::Position3, [0.0, 2.0, 3.0]);
        assert!(
            matches!(place, Some(DetectionPlace::Spot(spot)) if spot.north_m == 2.0 && (spot.height_m - 3.0).abs() < 1e-3)
        );
        // 200 km out the plane is 3.1 km above the ellipsoid.
        let place = measured(DetectionKind::Position3, [200e3, 0.0, 0.0]);
        assert!(matches!(place, Some(DetectionPlace::Spot(spot)) if (spot.height_m - 3_135.0).abs() < 10.0));
    }
}
