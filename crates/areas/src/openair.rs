//! Areas from OpenAir files of airspaces.

use openair::{Airspace, Altitude, Coord, Direction, Geometry, PolygonSegment};

use crate::ground::{Degrees, Ground};
use crate::limits::VerticalLimits;
use crate::outline::Outline;
use crate::{Area, AreaError};

const NAUTICAL_MILE_M: f64 = 1852.0;

pub(crate) fn read(text: &str, ground: &Ground) -> Result<Vec<Area>, AreaError> {
    let mut found = Vec::new();
    for airspace in openair::parse(text.as_bytes()) {
        let number = found.len() + 1;
        let airspace = airspace.map_err(|fault| {
            AreaError::of(
                number,
                format!("{fault}; areas are GeoJSON, or airspaces in the OpenAir format"),
            )
        })?;
        found.push(area(number, &airspace, ground).map_err(|AreaError(fault)| AreaError::of(number, fault))?);
    }
    Ok(found)
}

fn area(number: usize, airspace: &Airspace, ground: &Ground) -> Result<Area, AreaError> {
    let corners = match &airspace.geom {
        Geometry::Circle { centerpoint, radius } => {
            ground.circle(degrees(centerpoint), NAUTICAL_MILE_M * f64::from(*radius))?
        }
        Geometry::Polygon { segments } => {
            let mut corners = Vec::new();
            for segment in segments {
                add(segment, ground, &mut corners)?;
            }
            if corners.len() > 1 && corners.first() == corners.last() {
                corners.pop();
            }
            corners
        }
    };
    if corners.len() < 3 {
        return Err(AreaError(format!("has {} corners; it needs at least 3", corners.len())));
    }
    let (floor, ceiling) = (words(&airspace.lower_bound), words(&airspace.upper_bound));
    Ok(Area {
        name: airspace.name.clone().unwrap_or_else(|| format!("area {number}")),
        kind: None,
        outline: Outline::new(vec![vec![ground.ring(&corners)?]]),
        limits: VerticalLimits::read(Some(&floor), Some(&ceiling))?,
    })
}

/// A level in the words of [`VerticalLimits::read`].
fn words(level: &Altitude) -> String {
    match level {
        Altitude::Gnd => "GND".to_owned(),
        Altitude::FeetAmsl(feet) => format!("{feet} ft"),
        Altitude::FeetAgl(feet) => format!("{feet} ft AGL"),
        Altitude::FlightLevel(level) => format!("FL{level}"),
        Altitude::Unlimited => "unlimited".to_owned(),
        Altitude::Other(text) => text.clone(),
    }
}

fn degrees(place: &Coord) -> Degrees {
    [place.lng, place.lat]
}

fn add(segment: &PolygonSegment, ground: &Ground, corners: &mut Vec<Degrees>) -> Result<(), AreaError> {
    match segment {
        PolygonSegment::Point(place) => corners.push(degrees(place)),
        PolygonSegment::ArcSegment(arc) => {
            let [from, to] = [arc.angle_start, arc.angle_end].map(|angle| f64::from(angle).to_radians());
            let radius_m = NAUTICAL_MILE_M * f64::from(arc.radius);
            corners.extend(ground.arc(
                degrees(&arc.centerpoint),
                radius_m,
                [from, turned(from, to, arc.direction)],
            )?);
        }
        PolygonSegment::Arc(arc) => {
            let centre = degrees(&arc.centerpoint);
            let ([from, from_m], [to, to_m]) = (
                ground.seen(centre, degrees(&arc.start))?,
                ground.seen(centre, degrees(&arc.end))?,
            );
            let places = ground.arc(centre, 0.5 * (from_m + to_m), [from, turned(from, to, arc.direction)])?;
            // Files round the radius: the ends are where the file has them.
            corners.push(degrees(&arc.start));
            corners.extend(&places[1..places.len() - 1]);
            corners.push(degrees(&arc.end));
        }
    }
    Ok(())
}

/// The second angle, less than a turn from the first in this direction.
fn turned(from: f64, to: f64, direction: Direction) -> f64 {
    let turn = std::f64::consts::TAU;
    match direction {
        Direction::Cw => from + (to - from).rem_euclid(turn),
        Direction::Ccw => from - (from - to).rem_euclid(turn),
    }
}

#[cfg(test)]
mod tests {
    use frames::{Geodetic, SystemFrame};

    use crate::limits::Level;
    use crate::{Ground, below, read};

    const AIRSPACES: &str = "* a comment\nAC D\nAN Ring\nAL 2500 ft\nAH FL65\nV X=47:00:00 N 008:00:00 E\nDC 5\n\n\
        AC R\nAN Half\nAL GND\nAH UNL\nV X=47:00:00 N 008:00:00 E\nV D=+\nDA 10,270,90\n\n\
        AC Q\nAN Bay\nAL SFC\nAH 3000 ft\nDP 47:00:00 N 008:00:00 E\nDP 47:00:00 N 009:00:00 E\n\
        DP 48:00:00 N 009:00:00 E\nV D=+\nV X=48:00:00 N 008:30:00 E\nDB 48:00:00 N 008:40:00 E,48:00:00 N 008:20:00 E\n\
        DP 48:00:00 N 008:00:00 E\n";

    #[test]
    fn circles_arcs_and_corners_become_areas() {
        let frame = SystemFrame::at(Geodetic::from_degrees(47.0, 8.0, 0.0).unwrap());
        let found = read(AIRSPACES, &Ground::of(frame)).unwrap();
        let names: Vec<&str> = found.iter().map(|area| area.name.as_str()).collect();
        assert_eq!(names, ["Ring", "Half", "Bay"]);
        assert_eq!(found[0].limits.floor, Some(Level::Sea(762.0)));
        assert_eq!(found[0].limits.ceiling, Some(Level::Flight(65.0)));
        assert_eq!((found[1].limits.floor, found[1].limits.ceiling), (None, None));
        let distance_m = |area: usize, latitude_deg: f64, longitude_deg: f64| {
            let place = Geodetic::from_degrees(latitude_deg, longitude_deg, 3000.0).unwrap();
            found[area].outline.distance_m(below(&frame, frame.to_local(place)))
        };
        let near =
            |found_m: f64, expected_m: f64| assert!((found_m - expected_m).abs() < 15.0, "{found_m} {expected_m}");
        // A minute of latitude is 1853 m here.
        near(distance_m(0, 47.0, 8.0), -9260.0);
        near(distance_m(0, 47.1, 8.0), 11_117.0 - 9260.0);
        near(distance_m(1, 47.1, 8.0), -(18_520.0 - 11_117.0));
        assert!(distance_m(1, 46.99, 8.0) > 1000.0, "south of the half");
        assert!(distance_m(2, 47.5, 8.5) < 0.0);
        assert!(
            distance_m(2, 47.95, 8.5) > 0.0,
            "in the bay, which the arc cuts out southwards"
        );
        assert!(distance_m(2, 47.95, 8.9) < 0.0);
        let other_way = AIRSPACES.replace("V D=+\nV X=48", "V D=-\nV X=48");
        let bulge = &read(&other_way, &Ground::of(frame)).unwrap()[2].outline;
        for latitude_deg in [47.95, 48.05] {
            let place = Geodetic::from_degrees(latitude_deg, 8.5, 0.0).unwrap();
            assert!(
                bulge.contains(below(&frame, frame.to_local(place))),
                "the other way round it adds to the area"
            );
        }
    }

    #[test]
    fn what_cannot_be_used_is_refused_with_the_reason() {
        let ground = Ground::of(SystemFrame::at(Geodetic::from_degrees(47.0, 8.0, 0.0).unwrap()));
        for (text, expected) in [
            ("name,lat,lon\n", "the OpenAir format"),
            (
                "AC D\nAN X\nAL 500 ft AGL\nAH FL65\nV X=47:00:00 N 008:00:00 E\nDC 5\n",
                "there is no terrain",
            ),
            (
                "AC D\nAN X\nAL GND\nAH FL65\nV X=47:00:00 N 008:00:00 E\nDC 0\n",
                "a radius of 0 m",
            ),
            (
                "AC D\nAN X\nAL GND\nAH FL65\nDP 47:00:00 N 008:00:00 E\n",
                "has 1 corners",
            ),
            (
                "AC D\nAN X\nAL GND\nAH 65 parsecs\nV X=47:00:00 N 008:00:00 E\nDC 5\n",
                "is no level",
            ),
            ("* nothing\n", "has no area"),
        ] {
            let fault = read(text, &ground).unwrap_err().0;
            assert!(fault.contains(expected), "{text}: {fault}");
        }
    }
}
