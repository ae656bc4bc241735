//! Ground under the tracks: coasts and borders of the world, and the operator's overlays, in metres of the system
//! frame.
//!
//! The frame is the plane that touches the Earth at the origin. A place is projected onto the plane along the
//! origin's vertical (`frames::SystemFrame::to_local`, without the height). This projection folds back beyond 90
//! degrees of arc from the origin. Places beyond [`REACH_DEG`] are therefore drawn at that distance in the same
//! direction, and lines wholly beyond it are omitted.

use frames::{Geodetic, SystemFrame};
use serde_json::{Value, json};

/// Greatest distance from the origin, degrees of arc.
const REACH_DEG: f64 = 60.0;
/// Resolution of the coast file, in steps per degree.
const STEP_DEG: f64 = 0.0025;
/// First bytes of the coast file.
const MAGIC: &[u8] = b"KCOAST1\n";

/// Projection of places at the origin's height.
#[derive(Clone, Copy, Debug)]
struct Projection {
    frame: SystemFrame,
    /// Unit vector of the origin's vertical.
    up: [f64; 3],
    latitude_rad: f64,
    longitude_rad: f64,
}

fn direction(latitude_rad: f64, longitude_rad: f64) -> [f64; 3] {
    let (sin, cos) = latitude_rad.sin_cos();
    [cos * longitude_rad.cos(), cos * longitude_rad.sin(), sin]
}

impl Projection {
    fn new(frame: SystemFrame) -> Self {
        let origin = frame.to_geodetic([0.0; 3]);
        let [latitude_rad, longitude_rad] = [origin.latitude_deg(), origin.longitude_deg()].map(f64::to_radians);
        Self {
            frame,
            up: direction(latitude_rad, longitude_rad),
            latitude_rad,
            longitude_rad,
        }
    }

    /// Returns metres east and north of a place, and whether the place lies within reach; `None` for an invalid
    /// place.
    fn project(&self, longitude_deg: f64, latitude_deg: f64) -> Option<([f64; 2], bool)> {
        let [latitude_rad, longitude_rad] = [latitude_deg, longitude_deg].map(f64::to_radians);
        let there = direction(latitude_rad, longitude_rad);
        let cosine: f64 = self.up.iter().zip(there).map(|(a, b)| a * b).sum();
        if cosine >= REACH_DEG.to_radians().cos() {
            let place = Geodetic::from_degrees(latitude_deg, longitude_deg, 0.0).ok()?;
            let [east, north, _] = self.frame.to_local(place);
            return Some(([east, north], true));
        }
        // Great circle on the sphere, in the direction of the place.
        let difference = longitude_rad - self.longitude_rad;
        let east = latitude_rad.cos() * difference.sin();
        let north = self.latitude_rad.cos() * latitude_rad.sin()
            - self.latitude_rad.sin() * latitude_rad.cos() * difference.cos();
        let azimuth = east.atan2(north);
        let (sin, cos) = REACH_DEG.to_radians().sin_cos();
        let edge_latitude = (self.latitude_rad.sin() * cos + self.latitude_rad.cos() * sin * azimuth.cos()).asin();
        let edge_longitude = self.longitude_rad
            + (azimuth.sin() * sin * self.latitude_rad.cos())
                .atan2(cos - self.latitude_rad.sin() * edge_latitude.sin());
        let edge_longitude_deg = (edge_longitude.to_degrees() + 540.0).rem_euclid(360.0) - 180.0;
        let edge = Geodetic::from_degrees(edge_latitude.to_degrees(), edge_longitude_deg, 0.0).ok()?;
        let [east, north, _] = self.frame.to_local(edge);
        Some(([east, north], false))
    }
}

/// Projects coasts and borders from the file made by `coastlines.py`. The result holds pairs of metres east and
/// north (f32, little-endian); NaN, NaN ends a line, and infinity, infinity separates the land polygons from the
/// borders. `None` if the file has another format.
pub(crate) fn coast(file: &[u8], frame: &SystemFrame) -> Option<Vec<u8>> {
    let projection = Projection::new(*frame);
    let mut rest = file.strip_prefix(MAGIC)?;
    let mut count = || {
        let (octets, after) = rest.split_first_chunk::<4>()?;
        rest = after;
        Some(u32::from_le_bytes(*octets))
    };
    let (rings, borders) = (count()?, count()?);
    let mut out = Vec::new();
    let put = |out: &mut Vec<u8>, pair: [f32; 2]| out.extend(pair.iter().flat_map(|value| value.to_le_bytes()));
    for line in 0..rings.checked_add(borders)? {
        if line == rings {
            put(&mut out, [f32::INFINITY; 2]);
        }
        let begin = out.len();
        let (mut longitude, mut latitude, mut is_near) = (0, 0, false);
        for _ in 0..number(&mut rest)? {
            longitude += signed(number(&mut rest)?);
            latitude += signed(number(&mut rest)?);
            let place = projection.project(longitude as f64 * STEP_DEG, latitude as f64 * STEP_DEG);
            if let Some(([east, north], is_within)) = place {
                is_near |= is_within;
                put(&mut out, [east as f32, north as f32]);
            }
        }
        match is_near {
            true => put(&mut out, [f32::NAN; 2]),
            false => out.truncate(begin),
        }
    }
    Some(out)
}

fn number(rest: &mut &[u8]) -> Option<u64> {
    let mut value = 0;
    for shift in (0..63).step_by(7) {
        let (octet, after) = rest.split_first()?;
        *rest = after;
        value |= u64::from(octet & 127) << shift;
        if *octet < 128 {
            return Some(value);
        }
    }
    None
}

fn signed(zigzag: u64) -> i64 {
    (zigzag >> 1) as i64 ^ -((zigzag & 1) as i64)
}

/// Converts the coordinates of GeoJSON from longitudes and latitudes to metres east and north.
///
/// # Errors
/// A sentence, if the text is no collection of features.
pub(crate) fn overlay(name: &str, text: &str, frame: &SystemFrame) -> Result<Value, String> {
    let mut collection: Value = serde_json::from_str(text).map_err(|error| error.to_string())?;
    let projection = Projection::new(*frame);
    let features = collection.get_mut("features").and_then(Value::as_array_mut);
    let features = features.ok_or("it is no FeatureCollection of GeoJSON")?;
    for (number, feature) in features.iter_mut().enumerate() {
        if let Some(coordinates) = feature.pointer_mut("/geometry/coordinates") {
            to_metres(coordinates, &projection).map_err(|error| format!("feature {}: {error}", number + 1))?;
        }
    }
    Ok(json!({"name": name, "features": features}))
}

/// Converts polygons of GeoJSON to land in the form of [`coast`], without borders.
///
/// # Errors
/// A sentence, if the text is no collection of features, or has no polygon.
pub(crate) fn land(text: &str, frame: &SystemFrame) -> Result<Vec<u8>, String> {
    let collection = overlay("", text, frame)?;
    let mut octets = Vec::new();
    for feature in collection["features"].as_array().into_iter().flatten() {
        let coordinates = &feature["geometry"]["coordinates"];
        match feature["geometry"]["type"].as_str() {
            Some("Polygon") => add_rings(&mut octets, coordinates),
            Some("MultiPolygon") => coordinates.as_array().into_iter().flatten().for_each(|polygon| {
                add_rings(&mut octets, polygon);
            }),
            _ => {}
        }
    }
    match octets.is_empty() {
        true => Err("it has no polygon of land".to_owned()),
        false => Ok(octets),
    }
}

fn add_rings(octets: &mut Vec<u8>, polygon: &Value) {
    for ring in polygon.as_array().into_iter().flatten() {
        let points = ring.as_array().into_iter().flatten();
        let pairs = points.filter_map(|point| Some([point[0].as_f64()? as f32, point[1].as_f64()? as f32]));
        for value in pairs.chain([[f32::NAN; 2]]).flatten() {
            octets.extend(value.to_le_bytes());
        }
    }
}

/// Returns `land` with the borders of `world`, both in the form of [`coast`].
pub(crate) fn with_land(mut land: Vec<u8>, world: &[u8]) -> Vec<u8> {
    let end = f32::INFINITY.to_le_bytes();
    let borders = world.chunks_exact(8).position(|pair| pair[..4] == end);
    if let Some(pair) = borders {
        land.extend(&world[8 * pair..]);
    }
    land
}

fn to_metres(coordinates: &mut Value, projection: &Projection) -> Result<(), String> {
    let list = coordinates.as_array_mut().ok_or("coordinates are lists")?;
    if let [Value::Number(longitude), Value::Number(latitude), ..] = &list[..] {
        let degrees = longitude.as_f64().zip(latitude.as_f64());
        let degrees = degrees.filter(|(longitude, latitude)| longitude.abs() <= 180.0 && latitude.abs() <= 90.0);
        let place = degrees.and_then(|(longitude, latitude)| projection.project(longitude, latitude));
        let ([east, north], _) = place.ok_or_else(|| format!("[{longitude}, {latitude}] is no place"))?;
        *coordinates = json!([east, north]);
        return Ok(());
    }
    list.iter_mut().try_for_each(|each| to_metres(each, projection))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame() -> SystemFrame {
        SystemFrame::at(Geodetic::from_degrees(41.3, 2.1, 0.0).unwrap())
    }

    fn pairs(octets: &[u8]) -> Vec<[f32; 2]> {
        let value = |place: usize| f32::from_le_bytes(octets[place..place + 4].try_into().unwrap());
        (0..octets.len())
            .step_by(8)
            .map(|place| [value(place), value(place + 4)])
            .collect()
    }

    fn file(rings: &[&[(i64, i64)]]) -> Vec<u8> {
        let mut out = MAGIC.to_vec();
        out.extend((rings.len() as u32).to_le_bytes());
        out.extend(0_u32.to_le_bytes());
        let mut put = |mut value: u64| {
            while value > 127 {
                out.push(value as u8 & 127 | 128);
                value >>= 7;
            }
            out.push(value as u8);
        };
        let zigzag = |value: i64| ((value << 1) ^ (value >> 63)) as u64;
        for ring in rings {
            put(ring.len() as u64);
            let mut before = (0, 0);
            for (x, y) in *ring {
                put(zigzag(x - before.0));
                put(zigzag(y - before.1));
                before = (*x, *y);
            }
        }
        out
    }

    #[test]
    fn lines_are_where_the_frame_puts_their_points_and_those_beyond_the_horizon_are_gone() {
        let near = [(840, 16_520), (1_240, 16_520), (840, 16_520)];
        let far = [(71_000, -16_000), (71_400, -16_000)];
        let octets = coast(&file(&[&near, &far]), &frame()).unwrap();
        let found = pairs(&octets);
        assert_eq!(found.len(), 4, "{found:?}");
        assert!(found[0][0].abs() < 1.0 && found[0][1].abs() < 1.0, "the origin");
        assert!((found[1][0] - 83_700.0).abs() < 200.0, "a degree east: {found:?}");
        assert!(found[3][0].is_nan());
        for broken in [&b"KCOAST2\n"[..], b"", &file(&[&near])[..18]] {
            assert_eq!(coast(broken, &frame()), None);
        }
    }

    #[test]
    fn places_on_the_ground_by_which_the_page_is_tested() {
        let mut rows = Vec::new();
        for origin in [
            [41.3, 2.1, 0.0],
            [-33.9, 151.2, 120.0],
            [0.0, -179.9, 0.0],
            [78.2, 15.5, 450.0],
        ] {
            let [latitude, longitude, height] = origin;
            let frame = SystemFrame::at(Geodetic::from_degrees(latitude, longitude, height).unwrap());
            for (north_deg, east_deg) in [(0.0, 0.0), (0.01, -0.02), (-0.5, 0.75), (3.0, 3.0), (-6.0, 1.0)] {
                let turned = (longitude + east_deg + 540.0_f64).rem_euclid(360.0) - 180.0;
                let place = Geodetic::from_degrees(latitude + north_deg, turned, 0.0).unwrap();
                let [east, north, _] = frame.to_local(place);
                // Processors differ in the last digits.
                let metres = [east, north].map(|value| (value * 1e6).round() / 1e6 + 0.0);
                let place = [place.latitude_deg(), place.longitude_deg()].map(|value| (value * 1e9).round() / 1e9);
                rows.push(json!({"origin": origin, "metres": metres, "place": place}).to_string());
            }
        }
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../.ci/display/places.json");
        test_support::assert_golden(&path, &format!("[\n{}\n]\n", rows.join(",\n")));
    }

    #[test]
    fn what_is_beyond_reach_is_put_at_its_edge() {
        let projection = Projection::new(frame());
        let radius = |longitude, latitude| {
            let ([east, north], within) = projection.project(longitude, latitude).unwrap();
            (east.hypot(north), east.atan2(north).to_degrees(), within)
        };
        let edge_m = 6_371e3 * REACH_DEG.to_radians().sin();
        for (longitude, latitude, azimuth) in [(2.1, -80.0, 180.0), (-177.9, 60.0, 0.0), (122.1, 0.0, 90.0)] {
            let (distance, direction, within) = radius(longitude, latitude);
            assert!(
                !within && (distance - edge_m).abs() < 40e3,
                "{longitude} {latitude}: {distance}"
            );
            let turn = (direction - azimuth + 540.0).rem_euclid(360.0) - 180.0;
            assert!(turn.abs() < 45.0, "{longitude} {latitude}: {direction}");
        }
    }

    #[test]
    fn a_file_of_land_replaces_the_land_and_keeps_the_borders() {
        let text = r#"{"features": [
            {"geometry": {"type": "Polygon", "coordinates": [[[2.1, 41.3], [2.2, 41.3], [2.2, 41.4], [2.1, 41.3]]]}},
            {"geometry": {"type": "Point", "coordinates": [2.1, 41.3]}}]}"#;
        let own = land(text, &frame()).unwrap();
        assert_eq!(own.len(), 5 * 8);
        let mut world = [1.0_f32, 2.0, f32::NAN, f32::NAN].map(f32::to_le_bytes).concat();
        world.extend([f32::INFINITY, f32::INFINITY, 7.0, 8.0].map(f32::to_le_bytes).concat());
        let joined = pairs(&with_land(own, &world));
        assert_eq!((joined.len(), joined[5][0], joined[6]), (7, f32::INFINITY, [7.0, 8.0]));
        assert!(
            land(r#"{"features": []}"#, &frame())
                .unwrap_err()
                .contains("no polygon")
        );
    }

    #[test]
    fn an_overlay_is_turned_into_metres() {
        let text = r#"{"type": "FeatureCollection", "features": [
            {"type": "Feature", "properties": {"ref": "06L"}, "geometry": {"type": "Polygon",
             "coordinates": [[[2.1, 41.3, 5], [2.2, 41.3], [2.1, 41.3]]]}}]}"#;
        let found = overlay("airport", text, &frame()).unwrap();
        let ring = &found["features"][0]["geometry"]["coordinates"][0];
        assert_eq!(
            (ring.as_array().unwrap().len(), ring[0].as_array().unwrap().len()),
            (3, 2)
        );
        assert!((ring[1][0].as_f64().unwrap() - 8_370.0).abs() < 20.0, "{ring}");
        for wrong in ["", "{}", r#"{"features": [{"geometry": {"coordinates": [300, 95]}}]}"#] {
            assert!(overlay("x", wrong, &frame()).is_err(), "{wrong}");
        }
    }
}
