//! Areas from GeoJSON (RFC 7946).

use serde_json::Value;

use crate::ground::{Degrees, Ground};
use crate::limits::VerticalLimits;
use crate::outline::Outline;
use crate::{Area, AreaError};

/// Fewest positions of a ring: a triangle, and the first position again.
const RING_MIN: usize = 4;

pub(crate) fn read(text: &str, ground: &Ground) -> Result<Vec<Area>, AreaError> {
    let document: Value = serde_json::from_str(text.trim_start_matches('\u{feff}'))
        .map_err(|error| AreaError(format!("is no JSON: {error}")))?;
    let mut found = Vec::new();
    collect(&document, ground, &mut found)?;
    Ok(found)
}

/// Adds the areas of a document, a collection, or a feature.
fn collect(value: &Value, ground: &Ground, found: &mut Vec<Area>) -> Result<(), AreaError> {
    match word(value, "type") {
        Some("FeatureCollection") => {
            let features = list(&value["features"], "features")?;
            features.iter().try_for_each(|feature| collect(feature, ground, found))
        }
        Some("Feature" | "Polygon" | "MultiPolygon" | "GeometryCollection") => {
            let number = found.len() + 1;
            found.push(area(number, value, ground).map_err(|AreaError(fault)| AreaError::of(number, fault))?);
            Ok(())
        }
        other => Err(AreaError(format!(
            "has the type {}; areas are a FeatureCollection of polygons",
            shown(other)
        ))),
    }
}

fn area(number: usize, feature: &Value, ground: &Ground) -> Result<Area, AreaError> {
    let geometry = match word(feature, "type") {
        Some("Feature") => &feature["geometry"],
        _ => feature,
    };
    let mut polygons = Vec::new();
    add_polygons(geometry, ground, &mut polygons)?;
    let properties = &feature["properties"];
    let text = |key: &str| match &properties[key] {
        Value::Null => Ok(None),
        Value::String(text) => Ok(Some(text.as_str())),
        other => Err(AreaError(format!(
            "{key} is {other}; write it as text, as in \"FL95\" or \"2500 ft\""
        ))),
    };
    Ok(Area {
        name: word(properties, "name").map_or_else(|| format!("area {number}"), str::to_owned),
        kind: word(properties, "kind").map(str::to_owned),
        outline: Outline::new(polygons),
        limits: VerticalLimits::read(text("floor")?, text("ceiling")?)?,
    })
}

fn add_polygons(geometry: &Value, ground: &Ground, to: &mut Vec<Vec<Vec<[f64; 2]>>>) -> Result<(), AreaError> {
    let coordinates = &geometry["coordinates"];
    match word(geometry, "type") {
        Some("Polygon") => to.push(polygon(coordinates, ground)?),
        Some("MultiPolygon") => {
            for rings in list(coordinates, "polygons")? {
                to.push(polygon(rings, ground)?);
            }
        }
        Some("GeometryCollection") => {
            for part in list(&geometry["geometries"], "geometries")? {
                add_polygons(part, ground, to)?;
            }
        }
        other => {
            return Err(AreaError(format!(
                "has the geometry {}; an area is a Polygon or MultiPolygon",
                shown(other)
            )));
        }
    }
    match to.is_empty() {
        true => Err(AreaError("has no polygon".to_owned())),
        false => Ok(()),
    }
}

fn polygon(rings: &Value, ground: &Ground) -> Result<Vec<Vec<[f64; 2]>>, AreaError> {
    let rings = list(rings, "rings")?;
    if rings.is_empty() {
        return Err(AreaError("a polygon has no ring".to_owned()));
    }
    rings.iter().map(|points| ring(points, ground)).collect()
}

fn ring(points: &Value, ground: &Ground) -> Result<Vec<[f64; 2]>, AreaError> {
    let points = list(points, "positions")?;
    if points.len() < RING_MIN {
        let what = format!("a ring has {} positions; it needs at least {RING_MIN}", points.len());
        return Err(AreaError(what));
    }
    if points.first() != points.last() {
        let what = "a ring ends elsewhere than it begins; repeat its first position at its end";
        return Err(AreaError(what.to_owned()));
    }
    let corners: Vec<Degrees> = points[1..].iter().map(position).collect::<Result<_, _>>()?;
    ground.ring(&corners)
}

fn position(place: &Value) -> Result<Degrees, AreaError> {
    match (place[0].as_f64(), place[1].as_f64()) {
        (Some(longitude_deg), Some(latitude_deg)) => Ok([longitude_deg, latitude_deg]),
        _ => Err(AreaError(format!(
            "{place} is no position: it lacks two numbers; write [longitude, latitude] in degrees"
        ))),
    }
}

fn word<'a>(value: &'a Value, key: &str) -> Option<&'a str> {
    value[key].as_str()
}

fn shown(word: Option<&str>) -> String {
    word.map_or("none".to_owned(), |word| format!("\"{word}\""))
}

fn list<'a>(value: &'a Value, what: &str) -> Result<&'a [Value], AreaError> {
    let list = value.as_array().map(Vec::as_slice);
    list.ok_or_else(|| AreaError(format!("its coordinates are no list of {what}")))
}

#[cfg(test)]
mod tests {
    use frames::{Geodetic, SystemFrame};

    use super::*;
    use crate::limits::Level;
    use crate::{below, read};

    fn at(latitude_deg: f64, longitude_deg: f64) -> (SystemFrame, Ground) {
        let frame = SystemFrame::at(Geodetic::from_degrees(latitude_deg, longitude_deg, 0.0).unwrap());
        (frame, Ground::of(frame))
    }

    /// A square of about 2 km about the origin.
    const RING: &str = "[[2.088, 41.291], [2.112, 41.291], [2.112, 41.309], [2.088, 41.309], [2.088, 41.291]]";

    #[test]
    fn polygons_become_metres_in_the_plane() {
        let text = format!(
            r#"{{"type": "FeatureCollection", "features": [
              {{"type": "Feature", "properties": {{"name": "Runway", "kind": "runway", "ceiling": "FL95"}},
                "geometry": {{"type": "Polygon", "coordinates": [{RING}]}}}},
              {{"type": "Feature", "properties": null,
                "geometry": {{"type": "MultiPolygon", "coordinates": [[{RING}], [{RING}]]}}}}]}}"#
        );
        let (_, ground) = at(41.3, 2.1);
        let found = read(&text, &ground).unwrap();
        assert_eq!(
            (found[0].name.as_str(), found[0].kind.as_deref()),
            ("Runway", Some("runway"))
        );
        assert_eq!(found[0].limits.ceiling, Some(Level::Flight(95.0)));
        assert_eq!((found[1].name.as_str(), found[1].kind.as_deref()), ("area 2", None));
        assert_eq!(found[1].outline.polygons().len(), 2);
        let [east, north] = found[0].outline.polygons()[0][0][0];
        // 0.012° of longitude at 41.291° are 1005 m, 0.009° of latitude 1000 m.
        assert!(
            (east - 1005.0).abs() < 1.0 && (north + 999.5).abs() < 1.0,
            "{east} {north}"
        );
        let outline = &found[0].outline;
        assert!(outline.contains([0.0, 0.0]) && outline.contains([990.0, -990.0]));
        assert!(!outline.contains([1020.0, 0.0]) && !outline.contains([0.0, 1020.0]));
        let alone = format!(r#"{{"type": "Polygon", "coordinates": [{RING}]}}"#);
        assert_eq!(read(&alone, &ground).unwrap()[0].name, "area 1");
    }

    #[test]
    fn an_area_across_180_degrees_is_one_however_it_is_written() {
        let (frame, ground) = at(0.0, 179.0);
        let square =
            |west: &str, east: &str| format!("[[[{west}, -1], [{east}, -1], [{east}, 1], [{west}, 1], [{west}, -1]]]");
        let cut = format!("[{}, {}]", square("178", "180"), square("-180", "-178"));
        for text in [
            format!(r#"{{"type": "Polygon", "coordinates": {}}}"#, square("178", "182")),
            format!(r#"{{"type": "Polygon", "coordinates": {}}}"#, square("178", "-178")),
            format!(r#"{{"type": "MultiPolygon", "coordinates": {cut}}}"#),
        ] {
            let area = &read(&text, &ground).unwrap()[0];
            for (longitude_deg, expected_km) in [(179.5, -110.6), (180.0, -110.6), (-179.5, -110.6), (-177.5, 55.6)] {
                let place = Geodetic::from_degrees(0.0, longitude_deg, 10_000.0).unwrap();
                let distance_m = area.outline.distance_m(below(&frame, frame.to_local(place)));
                assert!(
                    (distance_m / 1e3 - expected_km).abs() < 1.0,
                    "{text} {longitude_deg}: {distance_m}"
                );
            }
        }
    }

    #[test]
    fn sides_are_straight_in_longitude_and_latitude_and_heights_do_not_matter() {
        // A side of 400 km along a parallel: in the plane its middle would be 2.7 km off.
        let (frame, ground) = at(45.0, 2.0);
        let text = r#"{"type": "Polygon", "coordinates": [[[2, 45], [7, 45], [7, 46], [2, 46], [2, 45]]]}"#;
        let area = &read(text, &ground).unwrap()[0];
        for (latitude_deg, expected_m) in [(44.999, 111.1), (45.001, -111.1)] {
            for height_m in [0.0, 12_000.0] {
                let place = Geodetic::from_degrees(latitude_deg, 4.5, height_m).unwrap();
                let distance_m = area.outline.distance_m(below(&frame, frame.to_local(place)));
                assert!(
                    (distance_m - expected_m).abs() < 5.0,
                    "{latitude_deg} {height_m}: {distance_m}"
                );
            }
        }
    }

    #[test]
    fn what_is_no_area_is_refused_with_its_place_and_remedy() {
        let polygon = |coordinates: &str| format!(r#"{{"type": "Polygon", "coordinates": {coordinates}}}"#);
        let floor = |floor: &str| {
            format!(
                r#"{{"type": "Feature", "properties": {{"floor": {floor}}},
              "geometry": {{"type": "Polygon", "coordinates": [{RING}]}}}}"#
            )
        };
        let (_, ground) = at(41.3, 2.1);
        for (text, expected) in [
            ("{", "is no JSON"),
            ("[]", "areas are a FeatureCollection"),
            (r#"{"type": "FeatureCollection"}"#, "no list of features"),
            (r#"{"type": "FeatureCollection", "features": []}"#, "has no area"),
            (
                r#"{"type": "FeatureCollection", "features": [{"type": "Feature", "geometry": null}]}"#,
                "area 1: has the geometry none",
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
            (
                &polygon("[[[142, 2], [143, 2], [143, 3], [142, 2]]]"),
                "more than 60 degrees",
            ),
            (&floor("7"), "write it as text"),
            (&floor("\"900 ft AGL\""), "area 1: the level 900 ft AGL is above ground"),
        ] {
            let fault = read(text, &ground).unwrap_err().0;
            assert!(fault.contains(expected), "{text}: {fault}");
        }
    }
}
