//! Areas of `[[area]]` tables, read from their files.

use std::fmt;

use areas::{Area, Ground, VerticalLimits};

use crate::settings::{AreaSettings, NAUTICAL_MILE_M, period_s};

/// Nanoseconds and seconds of a day.
const DAY_S: i64 = 86_400;
const NS_PER_S: i64 = 1_000_000_000;

/// Reads the text of a file of areas, by its name in the configuration.
pub type AreaFile<'a> = dyn Fn(&str) -> std::io::Result<String> + 'a;

/// An area with the names by which rules know it.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedArea {
    /// Name of the `[[area]]` table.
    pub table: String,
    /// The area; its name is that of the file, else that of the table.
    pub area: Area,
    /// Least and greatest east and north, metres.
    pub(crate) bounds_m: [[f64; 2]; 2],
    /// Times of day in which it is active, seconds from and to; empty for always.
    active_s: Vec<[u32; 2]>,
}

/// An area that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct AreaRefusal {
    /// Number of the `[[area]]` table, from 0.
    pub table: usize,
    /// File and fault.
    pub what: String,
}

impl fmt::Display for AreaRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "area[{}]: {}", self.table, self.what)
    }
}

/// Areas of the tables, in their order, and in that of their files.
///
/// # Errors
/// If a file cannot be read, or has no usable area.
pub fn named_areas(
    tables: &[AreaSettings],
    ground: &Ground,
    read: &AreaFile<'_>,
) -> Result<Vec<NamedArea>, AreaRefusal> {
    let mut named = Vec::new();
    for (number, table) in tables.iter().enumerate() {
        let refuse = |what: String| AreaRefusal { table: number, what };
        let given = VerticalLimits::read(table.floor.as_deref(), table.ceiling.as_deref());
        let given = given.map_err(|error| refuse(error.0))?;
        let found = match (&table.file, &table.circle) {
            (Some(file), _) => {
                let text = read(file).map_err(|error| refuse(format!("{file}: cannot be read: {error}")))?;
                areas::read(&text, ground).map_err(|error| refuse(format!("{file}: {error}")))?
            }
            (None, Some(circle)) => {
                let centre = [circle.longitude_deg, circle.latitude_deg];
                let area = Area::circle(&table.name, centre, circle.radius_nm * NAUTICAL_MILE_M, ground);
                vec![area.map_err(|error| refuse(error.0))?]
            }
            (None, None) => {
                let corners: Vec<[f64; 2]> = table
                    .corners_deg
                    .iter()
                    .map(|[latitude, longitude]| [*longitude, *latitude])
                    .collect();
                let area = Area::of_corners(&table.name, &corners, ground);
                vec![area.map_err(|error| refuse(error.0))?]
            }
        };
        let active_s: Result<Vec<[u32; 2]>, String> = table.active.iter().map(|text| period_s(text)).collect();
        let active_s = active_s.map_err(refuse)?;
        for mut area in found {
            area.limits = VerticalLimits {
                floor: given.floor.or(area.limits.floor),
                ceiling: given.ceiling.or(area.limits.ceiling),
            };
            named.push(NamedArea {
                table: table.name.clone(),
                bounds_m: area.outline.bounds_m(),
                area,
                active_s: active_s.clone(),
            });
        }
    }
    Ok(named)
}

impl NamedArea {
    /// Whether a rule that names `name` is about this area.
    pub(crate) fn is_called(&self, name: &str) -> bool {
        self.table == name || self.area.name == name
    }

    /// Name in alerts.
    pub(crate) fn title(&self) -> &str {
        &self.area.name
    }

    /// Whether the area is active at a time, UTC, nanoseconds.
    pub(crate) fn is_active(&self, time_ns: i64) -> bool {
        let second = time_ns.div_euclid(NS_PER_S).rem_euclid(DAY_S) as u32;
        let contains = |[from, to]: &[u32; 2]| match from <= to {
            true => (*from..*to).contains(&second),
            false => second >= *from || second < *to,
        };
        self.active_s.is_empty() || self.active_s.iter().any(contains)
    }

    /// Distance of a place from the border, metres, negative inside; `None` if it is farther than `reach_m` away.
    pub(crate) fn distance_m(&self, place_m: [f64; 2], reach_m: f64) -> Option<f64> {
        let [low, high] = self.bounds_m;
        let is_beyond = |axis: usize| place_m[axis] < low[axis] - reach_m || place_m[axis] > high[axis] + reach_m;
        if is_beyond(0) || is_beyond(1) {
            return None;
        }
        Some(self.area.outline.distance_m(place_m)).filter(|distance_m| *distance_m <= reach_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::futures::tests::frame;
    use crate::settings::CircleSettings;

    #[test]
    fn a_table_gives_the_limits_that_its_file_lacks() {
        let text = r#"{"type": "Polygon", "coordinates": [[[7, 46], [7.1, 46], [7.1, 46.1], [7, 46]]]}"#;
        let table = AreaSettings {
            name: "range".to_owned(),
            file: Some("range.geojson".to_owned()),
            ceiling: Some("FL95".to_owned()),
            active: vec!["22:00-06:00".to_owned()],
            ..AreaSettings::default()
        };
        let ground = Ground::of(frame());
        let named = named_areas(std::slice::from_ref(&table), &ground, &|_| Ok(text.to_owned())).unwrap();
        assert_eq!(named.len(), 1);
        assert_eq!(
            (named[0].area.limits.floor, named[0].area.limits.ceiling),
            (None, Some(areas::Level::Flight(95.0)))
        );
        let hour = |hour: i64| named[0].is_active(hour * 3600 * NS_PER_S);
        assert!(hour(23) && hour(5) && !hour(6) && !hour(21));
        assert!(named[0].is_called("range"));
        let lost = named_areas(&[table], &ground, &|_| Err(std::io::ErrorKind::NotFound.into())).unwrap_err();
        assert_eq!(
            lost.to_string(),
            "area[0]: range.geojson: cannot be read: entity not found"
        );
    }

    #[test]
    fn far_places_have_no_distance() {
        let circle = AreaSettings {
            name: "zone".to_owned(),
            circle: Some(CircleSettings {
                latitude_deg: 46.0,
                longitude_deg: 7.0,
                radius_nm: 5.0,
            }),
            ..AreaSettings::default()
        };
        let named = named_areas(&[circle], &Ground::of(frame()), &|_| unreachable!()).unwrap();
        let distance_m = named[0].distance_m([12_000.0, 0.0], 5_000.0).unwrap();
        assert!((distance_m - 2_740.0).abs() < 10.0, "{distance_m}");
        assert_eq!(named[0].distance_m([20_000.0, 0.0], 5_000.0), None);
        assert!(named[0].distance_m([0.0, 0.0], 0.0).unwrap() < -9_000.0);
    }
}
