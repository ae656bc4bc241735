//! Selection of tracks for a user: an area and a range of flight levels.

use frames::SystemFrame;

use crate::settings::{Area, Settings};

/// Area and flight levels of a user.
#[derive(Clone, Debug)]
pub(crate) struct TrackSelection {
    frame: SystemFrame,
    area: Option<Area>,
    levels: Option<[f64; 2]>,
}

impl TrackSelection {
    /// Returns the selection of the user of `gateway`, for tracks in `frame`.
    pub(crate) fn new(gateway: &Settings, frame: SystemFrame) -> Self {
        Self {
            frame,
            area: gateway.area,
            levels: gateway.levels,
        }
    }

    /// Whether the selection contains a position in the system frame, metres. A track of unknown height is on all
    /// levels.
    pub(crate) fn admits(&self, position_m: [f64; 3], has_height: bool) -> bool {
        if self.area.is_none() && self.levels.is_none() {
            return true;
        }
        let place = self.frame.to_geodetic(position_m);
        let in_area = self
            .area
            .is_none_or(|area| is_in(&area, place.latitude_deg(), place.longitude_deg()));
        let level = place.flight_level();
        in_area
            && self
                .levels
                .is_none_or(|[low, high]| !has_height || (low..=high).contains(&level))
    }
}

fn is_in(area: &Area, latitude_deg: f64, longitude_deg: f64) -> bool {
    let (south, north, west, east) = (area.south_deg, area.north_deg, area.west_deg, area.east_deg);
    let between = if west <= east {
        (west..=east).contains(&longitude_deg)
    } else {
        longitude_deg >= west || longitude_deg <= east
    };
    between && (south..=north).contains(&latitude_deg)
}

#[cfg(test)]
mod tests {
    use super::*;
    use frames::Geodetic;

    /// A selection round 50° north, 10° east, where the frame has its origin.
    fn selection(area: Option<Area>, levels: Option<[f64; 2]>) -> TrackSelection {
        let origin = Geodetic::from_degrees(50.0, 10.0, 0.0).unwrap();
        TrackSelection {
            frame: SystemFrame::at(origin),
            area,
            levels,
        }
    }

    #[test]
    fn a_track_counts_where_it_is_and_on_its_level() {
        let area = Area {
            south_deg: 49.9,
            north_deg: 50.1,
            west_deg: 9.9,
            east_deg: 10.1,
        };
        let both = selection(Some(area), Some([50.0, 200.0]));
        let level_100 = 10_000.0 * 0.3048;
        assert!(both.admits([0.0, 0.0, level_100], true));
        assert!(!both.admits([0.0, 0.0, 1000.0], true), "below");
        assert!(!both.admits([0.0, 0.0, 9000.0], true), "above");
        assert!(both.admits([0.0, 0.0, 9000.0], false), "who knows");
        for outside in [[0.0, 12_000.0], [0.0, -12_000.0], [8000.0, 0.0], [-8000.0, 0.0]] {
            assert!(!both.admits([outside[0], outside[1], level_100], true), "{outside:?}");
        }
        assert!(selection(None, None).admits([1e6, 1e6, -1e3], true));
    }

    #[test]
    fn an_area_may_lie_across_the_antimeridian() {
        let area = Area {
            south_deg: -20.0,
            north_deg: 20.0,
            west_deg: 170.0,
            east_deg: -170.0,
        };
        let inside = [175.0, -175.0, 180.0, -180.0].map(|longitude_deg| is_in(&area, 0.0, longitude_deg));
        assert_eq!(inside, [true; 4]);
        assert!(!is_in(&area, 0.0, 0.0) && !is_in(&area, 30.0, 175.0));
    }
}
