//! Whether two configurations mean the same places: exchanged coordinates, and the regions of both.

use toml_edit::{DocumentMut, Item};

use crate::sides::{Findings, Side};

/// Distance between the origins of two systems that exchange tracks, beyond which one of them is doubted, kilometres:
/// targets are common to both, and sensors reach some 500 km.
const FAR_KM: f64 = 1500.0;
/// Radius of the Earth, kilometres: for distances of which only the order counts.
const EARTH_KM: f64 = 6371.0;

/// Latitude and longitude, degrees.
type Place = [f64; 2];

fn distance_km(a: Place, b: Place) -> f64 {
    let [[lat_a, lon_a], [lat_b, lon_b]] = [a, b].map(|place| place.map(f64::to_radians));
    let cosine = lat_a.sin() * lat_b.sin() + lat_a.cos() * lat_b.cos() * (lon_a - lon_b).cos();
    EARTH_KM * cosine.clamp(-1.0, 1.0).acos()
}

fn origin(side: &Side) -> Place {
    let place = side.config.frame.to_geodetic([0.0; 3]);
    [place.latitude_deg(), place.longitude_deg()]
}

/// The place with exchanged coordinates, if there is one.
fn exchanged([latitude, longitude]: Place) -> Option<Place> {
    (longitude.abs() <= 90.0).then_some([longitude, latitude])
}

/// The other signs of a place: south for north, west for east.
fn mirrored([latitude, longitude]: Place) -> [(&'static str, Place); 2] {
    [
        ("latitude_deg", [-latitude, longitude]),
        ("longitude_deg", [latitude, -longitude]),
    ]
}

/// Finds places that contradict each other.
pub(crate) fn check(west: &Side, east: &Side, found: &mut Findings) {
    let (first, second) = (origin(west), origin(east));
    let regions = [regions(west), regions(east)];
    check_regions([west, east], &regions, found);
    let apart_km = distance_km(first, second);
    if apart_km <= FAR_KM {
        return;
    }
    let shown = |[latitude, longitude]: Place| format!("{latitude:.4}, {longitude:.4}");
    for ((side, own), (other, there)) in [((east, second), (west, first)), ((west, first), (east, second))] {
        let is_near = |place: Place| distance_km(place, there) <= FAR_KM;
        let away = format!(
            "({}) is {apart_km:.0} km from the origin of {} ({})",
            shown(own),
            other.file(),
            shown(there)
        );
        if exchanged(own).is_some_and(is_near) {
            let what = format!("{away}; latitude and longitude are exchanged here or there: write the latitude first");
            found.refused.push(side.at("frame.latitude_deg", what));
            return;
        }
        if let Some((key, _)) = mirrored(own).into_iter().find(|(_, place)| is_near(*place)) {
            let what = format!("{away}; its sign is wrong here or there: write south and west with a minus");
            found.refused.push(side.at(&format!("frame.{key}"), what));
            return;
        }
    }
    let what = format!(
        "({}) is {apart_km:.0} km from the origin of {} ({}), so that no target is common; compare [frame] in both",
        shown(second),
        west.file(),
        shown(first)
    );
    found.warnings.push(east.at("frame.latitude_deg", what));
}

/// Name, centre and corners of a region, as written.
#[derive(Debug, PartialEq)]
struct Region {
    name: String,
    origin: i64,
    corners: Vec<Place>,
}

fn regions(side: &Side) -> Vec<Region> {
    let Ok(document) = side.text().parse::<DocumentMut>() else {
        return Vec::new();
    };
    let number = |value: &toml_edit::Value| value.as_float().or(value.as_integer().map(|whole| whole as f64));
    let corner = |value: &toml_edit::Value| {
        let pair = value.as_array()?;
        Some([number(pair.get(0)?)?, number(pair.get(1)?)?])
    };
    let tables = document.get("region").and_then(Item::as_array_of_tables);
    let region = |table: &toml_edit::Table| Region {
        name: table.get("name").and_then(Item::as_str).unwrap_or_default().to_owned(),
        origin: table.get("origin").and_then(Item::as_integer).unwrap_or(0),
        corners: table
            .get("corners_deg")
            .and_then(Item::as_array)
            .map_or_else(Vec::new, |corners| corners.iter().filter_map(corner).collect()),
    };
    tables.map_or_else(Vec::new, |tables| tables.iter().map(region).collect())
}

/// Both sides define the same regions, each of one of the two or of a third centre.
fn check_regions(sides: [&Side; 2], [first, second]: &[Vec<Region>; 2], found: &mut Findings) {
    let [west, east] = sides;
    for (side, own, other, others) in [(west, first, east, second), (east, second, west, first)] {
        for (index, region) in own.iter().enumerate() {
            let file = other.file();
            let there = others.iter().find(|there| there.name == region.name);
            let differs = match there {
                None => (
                    "name",
                    format!("the region \"{}\" is not in {file}; add it there", region.name),
                ),
                // Told once, of the second file.
                Some(_) if std::ptr::eq(side, west) => continue,
                Some(there) if there.origin != region.origin => {
                    let what = format!(
                        "{} is {} in {file}; write the same in both",
                        region.origin, there.origin
                    );
                    ("origin", what)
                }
                Some(there) if there.corners != region.corners => {
                    let place = region
                        .corners
                        .iter()
                        .zip(&there.corners)
                        .find(|(here, there)| here != there);
                    let what = match place {
                        Some((here, there)) => format!("{here:?} is {there:?} in {file}"),
                        None => format!("{} corners are {} in {file}", region.corners.len(), there.corners.len()),
                    };
                    ("corners_deg", format!("{what}; write the same corners in both"))
                }
                Some(_) => continue,
            };
            let (key, what) = differs;
            found.refused.push(side.at(&format!("region[{index}].{key}"), what));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_have_the_right_order() {
        let (barcelona, madrid) = ([41.3, 2.1], [40.4, -3.7]);
        assert!((distance_km(barcelona, madrid) - 500.0).abs() < 20.0);
        assert!(distance_km(barcelona, [2.1, 41.3]) > 5000.0);
        assert_eq!(exchanged([41.3, 120.0]), None);
    }
}
