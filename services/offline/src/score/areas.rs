//! Areas from GeoJSON (RFC 7946).

use std::fmt::Display;
use std::path::Path;

use frames::{Geodetic, SystemFrame};
use scoring::{AreaKind, PolygonRings, ScoredArea};
use serde_json::Value;

use crate::files::InputError;
use crate::host::Host;

/// Fewest positions of a ring: a triangle, and the first position again.
const RING_MIN: usize = 4;

/// Reads the areas of a file in the frame with this origin.
///
/// # Errors
/// If the file is no GeoJSON with polygons.
pub(super) fn read(host: &dyn Host, file: &Path, origin: Geodetic) -> Result<Vec<ScoredArea>, InputError> {
    let text = host.text(file)?;
    areas(&text, &SystemFrame::at(origin)).map_err(|fault| InputError::new(file, fault))
}

fn areas(text: &str, frame: &SystemFrame) -> Result<Vec<ScoredArea>, String> {
    let document: Value = serde_json::from_str(text).map_err(|error| format!("is no JSON: {error}"))?;
    let alone = std::slice::from_ref(&document);
    let features: &[Value] = match word(&document, "type") {
        Some("FeatureCollection") => document["features"].as_array().map(Vec::as_slice).unwrap_or_default(),
        Some("Feature" | "Polygon" | "MultiPolygon") => alone,
        other => {
            return Err(format!(
                "has the type {other:?}; areas are a FeatureCollection of polygons"
            ));
        }
    };
    if features.is_empty() {
        return Err("has no features; areas are a FeatureCollection of polygons".to_owned());
    }
    let read = |(number, feature): (usize, &Value)| {
        area(number, feature, frame).map_err(|fault| format!("feature {number}: {fault}"))
    };
    (1..).zip(features).map(read).collect()
}

fn area(number: usize, feature: &Value, frame: &SystemFrame) -> Result<ScoredArea, String> {
    let geometry = match word(feature, "type") {
        Some("Feature") => &feature["geometry"],
        _ => feature,
    };
    let coordinates = &geometry["coordinates"];
    let polygons = match word(geometry, "type") {
        Some("Polygon") => vec![polygon(coordinates, frame)?],
        Some("MultiPolygon") => {
            let polygons = list(coordinates, "polygons")?.iter();
            polygons.map(|rings| polygon(rings, frame)).collect::<Result<_, _>>()?
        }
        other => {
            return Err(format!(
                "has the geometry {other:?}; an area is a Polygon or MultiPolygon"
            ));
        }
    };
    let properties = &feature["properties"];
    let name = word(properties, "name").map_or_else(|| format!("area {number}"), str::to_owned);
    let kind = match &properties["kind"] {
        Value::Null => None,
        kind => Some(kind.as_str().and_then(AreaKind::from_word).ok_or_else(|| {
            let words = AreaKind::ALL.map(|kind| kind.word).join(", ");
            format!("the kind {kind} is unknown; kinds are {words}")
        })?),
    };
    Ok(ScoredArea { name, kind, polygons })
}

fn polygon(rings: &Value, frame: &SystemFrame) -> Result<PolygonRings, String> {
    let rings = list(rings, "rings")?;
    if rings.is_empty() {
        return Err("a polygon has no ring".to_owned());
    }
    rings.iter().map(|points| ring(points, frame)).collect()
}

fn ring(points: &Value, frame: &SystemFrame) -> Result<Vec<[f64; 2]>, String> {
    let points = list(points, "positions")?;
    if points.len() < RING_MIN {
        return Err(format!(
            "a ring has {} positions; it needs at least {RING_MIN}",
            points.len()
        ));
    }
    if points.first() != points.last() {
        return Err("a ring ends elsewhere than it begins; repeat its first position at its end".to_owned());
    }
    points[1..].iter().map(|place| position(place, frame)).collect()
}

fn position(place: &Value, frame: &SystemFrame) -> Result<[f64; 2], String> {
    let faulty =
        |fault: &dyn Display| format!("{place} is no position: {fault}; write [longitude, latitude] in degrees");
    let (Some(longitude_deg), Some(latitude_deg)) = (place[0].as_f64(), place[1].as_f64()) else {
        return Err(faulty(&"it lacks two numbers"));
    };
    let place = Geodetic::from_degrees(latitude_deg, longitude_deg, 0.0).map_err(|error| faulty(&error))?;
    let [east, north, _] = frame.to_local(place);
    Ok([east, north])
}

fn word<'a>(value: &'a Value, key: &str) -> Option<&'a str> {
    value[key].as_str()
}

fn list<'a>(value: &'a Value, what: &str) -> Result<&'a [Value], String> {
    let list = value.as_array().map(Vec::as_slice);
    list.ok_or_else(|| format!("its coordinates are no list of {what}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame() -> SystemFrame {
        SystemFrame::at(Geodetic::from_degrees(41.3, 2.1, 0.0).unwrap())
    }

    /// A square of about 2 km about the origin.
    const RING: &str = "[[2.088, 41.291], [2.112, 41.291], [2.112, 41.309], [2.088, 41.309], [2.088, 41.291]]";

    #[test]
    fn polygons_become_metres_in_the_plane() {
        let text = format!(
            r#"{{"type": "FeatureCollection", "features": [
              {{"type": "Feature", "properties": {{"name": "Runway", "kind": "runway"}},
                "geometry": {{"type": "Polygon", "coordinates": [{RING}]}}}},
              {{"type": "Feature", "properties": null,
                "geometry": {{"type": "MultiPolygon", "coordinates": [[{RING}], [{RING}]]}}}}]}}"#
        );
        let found = areas(&text, &frame()).unwrap();
        assert_eq!(
            (found[0].name.as_str(), found[0].kind),
            ("Runway", Some(AreaKind::RUNWAY))
        );
        assert_eq!(
            (found[1].name.as_str(), found[1].kind, found[1].polygons.len()),
            ("area 2", None, 2)
        );
        let [east, north] = found[0].polygons[0][0][0];
        // 0.012° of longitude at 41.291° are 1005 m, 0.009° of latitude 1000 m.
        assert!(
            (east - 1005.0).abs() < 1.0 && (north + 999.5).abs() < 1.0,
            "{east} {north}"
        );
        assert!(found[0].contains([0.0, 0.0]) && found[0].contains([990.0, -990.0]));
        assert!(!found[0].contains([1020.0, 0.0]) && !found[0].contains([0.0, 1020.0]));
        let alone = format!(r#"{{"type": "Polygon", "coordinates": [{RING}]}}"#);
        assert_eq!(areas(&alone, &frame()).unwrap()[0].name, "area 1");
    }

    #[test]
    fn what_is_no_area_is_refused_with_its_place_and_remedy() {
        let polygon = |coordinates: &str| format!(r#"{{"type": "Polygon", "coordinates": {coordinates}}}"#);
        let kind = format!(
            r#"{{"type": "Feature", "properties": {{"kind": "lake"}},
              "geometry": {{"type": "Polygon", "coordinates": [{RING}]}}}}"#
        );
        for (text, expected) in [
            ("{", "is no JSON"),
            ("[]", "areas are a FeatureCollection"),
            (r#"{"type": "FeatureCollection"}"#, "has no features"),
            (
                r#"{"type": "FeatureCollection", "features": [{"type": "Feature", "geometry": null}]}"#,
                "feature 1: has the geometry None",
            ),
            (
                r#"{"type": "Feature", "geometry": {"type": "LineString"}}"#,
                "an area is a Polygon",
            ),
            (&polygon("7"), "no list of rings"),
            (&polygon("[]"), "no ring"),
            (&polygon("[[[2, 41], [3, 41], [2, 41]]]"), "has 3 positions"),
            (
                &polygon("[[[2, 41], [3, 41], [3, 42], [2, 42]]]"),
                "repeat its first position",
            ),
            (
                &polygon("[[[2, 41], [3, 41], [3, \"x\"], [2, 41]]]"),
                "it lacks two numbers",
            ),
            (
                &polygon("[[[41, 2], [3, 141], [3, 42], [41, 2]]]"),
                "write [longitude, latitude]",
            ),
            (&kind, "the kind \"lake\" is unknown; kinds are manoeuvring, runway"),
        ] {
            let fault = areas(text, &frame()).unwrap_err();
            assert!(fault.contains(expected), "{text}: {fault}");
        }
    }
}
