//! Height and climb of a target for labels, table, panel, plots, filters, colours and lists.
//!
//! The display shows the newest level of the target's transponder if the level is no older than two periods of its
//! source. Pilots, controllers and all other systems use this level. Below the transition level of a region with a QNH
//! the altitude takes its place, marked `A`. Without a level, the display shows the height above the ellipsoid, marked
//! as such. The up component of the system frame is no height: the Earth curves away beneath
//! the plane.
//!
//! An arrow for climb or descent needs a rate above the noise. It appears at [`BEGINS_MPS`] and at two standard
//! deviations of the rate, and disappears below [`ENDS_MPS`]: a rate between the two changes nothing.

use frames::{SystemFrame, Vertical};
use messages::SystemTrack;
use messages::picture::picture_track_bits::{ALTITUDE, CLIMBS, HEIGHT, LEVEL, SINKS};

/// Rate at which an arrow appears: 500 feet a minute, metres per second.
const BEGINS_MPS: f64 = 2.54;
/// Rate below which an arrow disappears: 250 feet a minute.
const ENDS_MPS: f64 = 1.27;
/// Standard deviations of the rate required for an arrow to appear.
const SURE_SIGMAS: f64 = 2.0;

/// Displayed height of a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DisplayedHeight {
    /// Metres; NaN: unknown.
    pub(crate) height_m: f32,
    /// Rate of the height above the ellipsoid, metres per second; 0 without a height above the ellipsoid, NaN if there
    /// is one and its rate is unknown.
    pub(crate) climb_mps: f32,
    /// The `picture_track_bits` concerning height and climb.
    pub(crate) flags: u8,
}

/// Returns the height above the ellipsoid and its rate; `None` if no source observes height, or the frame is
/// unknown.
pub(crate) fn geometric(track: &SystemTrack, frame: Option<&SystemFrame>) -> Option<Vertical> {
    let frame = frame.filter(|_| track.height_valid != 0)?;
    let vertical = frame.vertical(track.position_m, track.velocity_mps);
    // Fusion works with heights by pressure where transponders state them.
    let height_m = vertical.height_m - track.pressure_offset().unwrap_or_default();
    Some(Vertical { height_m, ..vertical })
}

/// Whether the rate of the height above the ellipsoid is known. The velocity along the plane of the system is part of
/// it.
pub(crate) fn knows_climb(track: &SystemTrack) -> bool {
    track.velocity_valid != 0 && track.covariance.knows_climb()
}

/// Returns the rate of the height above the ellipsoid by the vertical filter, m/s; `None` without such a rate, or if
/// the frame is unknown.
pub(crate) fn filtered_climb_mps(track: &SystemTrack, frame: Option<&SystemFrame>) -> Option<f32> {
    let [vx, vy, _] = track.velocity_mps;
    let velocity_mps = [vx, vy, f64::from(track.climb_rate_mps)];
    let frame = frame.filter(|_| track.velocity_valid != 0 && track.climb_rate_variance > 0.0)?;
    Some(frame.vertical(track.position_m, velocity_mps).climb_mps as f32)
}

/// Returns the displayed height of a state; `before` holds the flags of the track's previous state.
pub(crate) fn shown(track: &SystemTrack, frame: Option<&SystemFrame>, before: u8) -> DisplayedHeight {
    let geometric = geometric(track, frame);
    let altitude_m = track.altitude();
    let level_m = track.level_m();
    let Some(height_m) = altitude_m.or(level_m).or(geometric.map(|geometric| geometric.height_m)) else {
        return DisplayedHeight {
            height_m: f32::NAN,
            climb_mps: 0.0,
            flags: 0,
        };
    };
    let reference = match (altitude_m, level_m) {
        (Some(_), _) => ALTITUDE,
        (None, Some(_)) => LEVEL,
        (None, None) => 0,
    };
    let climb_mps = match knows_climb(track) {
        true => geometric.map_or(0.0, |geometric| geometric.climb_mps),
        false => f64::NAN,
    };
    let sigma_mps = track.covariance.get(5, 5).max(0.0).sqrt();
    let begins = climb_mps.abs() >= BEGINS_MPS.max(SURE_SIGMAS * sigma_mps);
    let arrow = if climb_mps > 0.0 { CLIMBS } else { SINKS };
    let goes_on = before & arrow != 0 && climb_mps.abs() >= ENDS_MPS;
    DisplayedHeight {
        height_m: height_m as f32,
        climb_mps: climb_mps as f32,
        // What is not a number has no arrow.
        flags: HEIGHT | reference | if begins || goes_on { arrow } else { 0 },
    }
}

#[cfg(test)]
mod tests {
    use frames::Geodetic;
    use messages::Covariance;

    use super::*;

    fn frame() -> SystemFrame {
        SystemFrame::at(Geodetic::from_degrees(41.3, 2.1, 0.0).unwrap())
    }

    /// A state at a distance (nautical miles) and bearing (degrees), 11 km high, outbound at 230 m/s and climbing.
    fn outbound(distance_nm: f64, bearing_deg: f64, climb_mps: f64) -> SystemTrack {
        let frame = frame();
        let (sin, cos) = bearing_deg.to_radians().sin_cos();
        let [east, north] = [sin, cos].map(|share| share * distance_nm * 1852.0);
        let at = |seconds: f64| {
            let [east, north] = [east + 230.0 * seconds * sin, north + 230.0 * seconds * cos];
            // The plane's point with the wanted height: that height is the plane's height plus the sagitta.
            let mut up = 0.0;
            for _ in 0..4 {
                up += 11_000.0 + climb_mps * seconds - frame.to_geodetic([east, north, up]).height_m();
            }
            [east, north, up]
        };
        let (from, to) = (at(-0.5), at(0.5));
        SystemTrack {
            position_m: at(0.0),
            velocity_mps: [0, 1, 2].map(|axis| to[axis] - from[axis]),
            height_valid: 1,
            velocity_valid: 1,
            covariance: Covariance::diagonal([30.0; 3], [1.0; 3]),
            ..SystemTrack::default()
        }
    }

    #[test]
    fn a_level_flight_keeps_its_height_and_has_no_arrow_out_to_160_miles() {
        for distance_nm in [0.0, 10.0, 50.0, 100.0, 160.0] {
            for bearing_deg in [0.0, 75.0, 200.0, 310.0] {
                let track = outbound(distance_nm, bearing_deg, 0.0);
                let shown = shown(&track, Some(&frame()), 0);
                assert!((shown.height_m - 11_000.0).abs() < 0.1, "{distance_nm} NM: {shown:?}");
                assert!(shown.climb_mps.abs() < 0.05, "{distance_nm} NM: {shown:?}");
                assert_eq!(shown.flags, HEIGHT, "{distance_nm} NM");
            }
        }
        let climbing = shown(&outbound(160.0, 30.0, 8.0), Some(&frame()), 0);
        assert!((climbing.climb_mps - 8.0).abs() < 0.05, "{climbing:?}");
        assert_eq!(climbing.flags, HEIGHT | CLIMBS);
    }

    #[test]
    fn an_arrow_begins_late_and_ends_late() {
        let flags = |climb_mps: f64, before: u8| shown(&outbound(20.0, 10.0, climb_mps), Some(&frame()), before).flags;
        assert_eq!(flags(2.0, 0), HEIGHT, "too slow to begin");
        assert_eq!(flags(3.0, 0), HEIGHT | CLIMBS);
        assert_eq!(flags(2.0, HEIGHT | CLIMBS), HEIGHT | CLIMBS, "goes on");
        assert_eq!(flags(1.0, HEIGHT | CLIMBS), HEIGHT, "ends");
        assert_eq!(flags(-2.0, HEIGHT | CLIMBS), HEIGHT, "does not turn round at once");
        assert_eq!(flags(-3.0, HEIGHT | CLIMBS), HEIGHT | SINKS);
        let mut unsure = outbound(20.0, 10.0, 5.0);
        unsure.covariance = Covariance::diagonal([30.0; 3], [4.0; 3]);
        assert_eq!(shown(&unsure, Some(&frame()), 0).flags, HEIGHT, "noise is no climb");
    }

    #[test]
    fn the_altitude_goes_before_the_level() {
        let mut track = outbound(20.0, 75.0, 0.0);
        (track.level, track.level_valid) = (140, 1);
        (track.altitude_m, track.qnh_hpa) = (1_000.0, 1_005.0);
        let shown = shown(&track, Some(&frame()), 0);
        assert_eq!((shown.height_m, shown.flags), (1_000.0, HEIGHT | ALTITUDE));
    }

    #[test]
    fn the_height_above_the_ellipsoid_is_without_the_weather() {
        let mut track = outbound(20.0, 75.0, 0.0);
        (track.pressure_offset_m, track.pressure_offset_sigma_m) = (300.0, 30.0);
        let height_m = geometric(&track, Some(&frame())).unwrap().height_m;
        assert!((height_m - 10_700.0).abs() < 0.1, "{height_m}");
    }

    #[test]
    fn the_transponders_level_goes_before_the_height() {
        let mut track = outbound(160.0, 75.0, 0.0);
        (track.level, track.level_valid) = (1_440, 1);
        let level = shown(&track, Some(&frame()), 0);
        assert_eq!((level.height_m, level.flags), (360.0 * 30.48, HEIGHT | LEVEL));
        assert!(level.climb_mps.abs() < 0.05, "{level:?}");
        // A level needs neither another height nor a frame.
        track.height_valid = 0;
        assert_eq!(
            shown(&track, None, 0),
            DisplayedHeight {
                climb_mps: 0.0,
                ..level
            }
        );
    }

    #[test]
    fn without_height_or_frame_nothing_is_shown() {
        let mut track = outbound(20.0, 10.0, 5.0);
        assert!(shown(&track, None, 0).height_m.is_nan());
        track.height_valid = 0;
        let none = shown(&track, Some(&frame()), HEIGHT | CLIMBS);
        assert!(none.height_m.is_nan() && none.flags == 0, "{none:?}");
    }

    #[test]
    fn the_filtered_rate_is_that_of_the_height_above_the_ellipsoid() {
        // Level above the ellipsoid 160 nautical miles away is a descent in the plane.
        let mut track = outbound(160.0, 30.0, 0.0);
        assert_eq!(filtered_climb_mps(&track, Some(&frame())), None, "no filter");
        (track.climb_rate_mps, track.climb_rate_variance) = (track.velocity_mps[2] as f32 + 3.0, 0.25);
        let climb_mps = filtered_climb_mps(&track, Some(&frame())).unwrap();
        assert!((climb_mps - 3.0).abs() < 0.05, "{climb_mps}");
        assert_eq!(filtered_climb_mps(&track, None), None);
    }
}
