//! The names of columns: one list, by which each reader finds its columns in a header, and from which help is made.
//!
//! Archives of receivers, programs of the field and Koseki's own tables state the same quantities under names and in
//! units of their own. A reader asks for a quantity by one of its names ([`Table::optional`](crate::Table::optional)).
//! A header that has exactly this name is read as it stands; else the list gives the column of the same quantity, with
//! the factor between both units.
//!
//! A name carries its unit. Names are compared without case, blanks and marks: `BaseDateTime` is `base_date_time`, and
//! `altitude (m)` is `altitude_m`. A name whose unit differs between programs is not in the list (`altitude`,
//! `bearing`), or has the unit of the program that made the name common (`groundspeed`: knots).
//!
//! Sources of the names: the REST interface and the historical state vectors of the OpenSky Network, the files of
//! Marine Cadastre and of the Solent in Stone Soup, the columns of the Python package traffic.

use std::collections::HashMap;
use std::fmt::Write as _;
use std::sync::LazyLock;

/// Metres in a foot.
const FOOT_M: f64 = 0.3048;
/// Metres in a nautical mile.
const MILE_M: f64 = 1852.0;
/// Metres per second in a knot.
const KNOT_MPS: f64 = MILE_M / 3600.0;
/// Radians in a degree.
const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// A column that a table may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NamedColumn {
    /// The name that documents use.
    pub name: &'static str,
    /// Further names, of the same unit, with blanks between them.
    pub aliases: &'static str,
    /// Its quantity: the name of the entry whose values have the unit of the quantity.
    pub quantity: &'static str,
    /// Unit of the values, for documents; empty for texts.
    pub unit: &'static str,
    /// Value of one unit in the unit of the quantity.
    pub scale: f64,
    /// Meaning, for documents.
    pub meaning: &'static str,
}

macro_rules! named_columns {
    ($($name:literal, $aliases:literal is $quantity:literal in $unit:literal ($scale:expr): $meaning:literal;)+) => {
        &[$(NamedColumn {
            name: $name,
            aliases: $aliases,
            quantity: $quantity,
            unit: $unit,
            scale: $scale,
            meaning: $meaning,
        }),+]
    };
}

/// Columns of targets: time, place, motion and identity, in the order of the documents.
pub const TARGET_COLUMNS: &[NamedColumn] = named_columns! {
    "time", "time_s timestamp t ts datetime base_date_time utc time_utc unix_time" is "time" in "" (1.0):
        "ISO 8601 (UTC without a zone), seconds or milliseconds since 1970, or seconds of the day";
    "latitude", "lat lat_deg latitude_deg latitude_degrees" is "latitude" in "deg" (1.0):
        "on the WGS-84 ellipsoid, north positive";
    "longitude", "lon lng long lon_deg longitude_deg longitude_degrees" is "longitude" in "deg" (1.0): "east positive";
    "x", "x_m east_m" is "x" in "m" (1.0): "east in the system frame, in place of degrees";
    "y", "y_m north_m" is "y" in "m" (1.0): "north in the system frame";
    "z", "z_m up_m" is "z" in "m" (1.0): "up in the system frame, beside x and y";
    "altitude_m", "geoaltitude geoaltitude_m height_m alt_m" is "altitude_m" in "m" (1.0): "height above the ellipsoid";
    "alt_geom", "geoaltitude_ft" is "altitude_m" in "ft" (FOOT_M): "height above the ellipsoid";
    "flight_level", "fl" is "baroaltitude" in "100 ft" (100.0 * FOOT_M): "pressure altitude";
    "altitude_ft", "altitude_feet alt_ft alt_baro baroaltitude_ft pressure_altitude_ft" is "baroaltitude" in
        "ft" (FOOT_M): "pressure altitude";
    "baroaltitude", "baro_altitude_m pressure_altitude_m" is "baroaltitude" in "m" (1.0): "pressure altitude";
    "speed_mps", "speed velocity velocity_mps groundspeed_mps" is "speed_mps" in "m/s" (1.0): "over ground";
    "speed_kn", "sog sog_kn sog_knots speed_kt speed_kts speed_knots groundspeed gs" is "speed_mps" in "kn" (KNOT_MPS):
        "over ground";
    "speed_kmh", "speed_kph" is "speed_mps" in "km/h" (1.0 / 3.6): "over ground";
    "course_deg", "course course_degrees cog cog_deg cog_degrees track_deg true_track" is "course_deg" in "deg" (1.0):
        "direction of motion, clockwise from true north (from y beside x and y)";
    "course_rad", "" is "course_deg" in "rad" (1.0 / DEGREE): "the same";
    "heading", "heading_deg heading_degrees true_heading" is "heading_rad" in "deg" (DEGREE):
        "the course, in a table without another column of it; else unused";
    "heading_rad", "" is "heading_rad" in "rad" (1.0): "the same";
    "vx", "vx_mps" is "vx" in "m/s" (1.0): "towards east, in place of speed and course";
    "vy", "vy_mps" is "vy" in "m/s" (1.0): "towards north";
    "climb_mps", "vertrate climb vz vz_mps" is "climb_mps" in "m/s" (1.0): "upwards";
    "climb_fpm", "vertical_rate vertical_rate_fpm baro_rate" is "climb_mps" in "ft/min" (FOOT_M / 60.0): "upwards";
    "sigma_m", "position_sigma_m" is "sigma_m" in "m" (1.0): "standard deviation of the position along each axis";
    "address", "icao24 icao hex icao_address" is "address" in "" (1.0): "24-bit address of an aircraft, hexadecimal";
    "mmsi", "" is "mmsi" in "" (1.0): "number of a ship";
    "mode_3a", "squawk" is "mode_3a" in "" (1.0): "Mode 3/A code, octal";
    "callsign", "flight" is "callsign" in "" (1.0): "up to eight characters";
    "name", "vessel_name ship_name" is "name" in "" (1.0): "up to 20 characters";
    "track_id", "id track_number sensor_track_id system_track_id target_id" is "track_id" in "" (1.0):
        "number or name of the target";
    "track", "" is "track" in "" (1.0): "the same, or in a table with a speed and no course the course in degrees";
    "source", "sensor sensor_id source_id" is "source" in "" (1.0):
        "name or number of the sensor; without it, the file is a sensor";
    "on_ground", "" is "on_ground" in "" (1.0): "true or false, 1 or 0";
};

/// Columns of measurements from the place of a sensor, in the order of the documents.
pub const SENSOR_COLUMNS: &[NamedColumn] = named_columns! {
    "sensor_latitude", "sensor_lat platform_latitude platform_lat" is "sensor_latitude" in "deg" (1.0):
        "place of the sensor, in degrees";
    "sensor_longitude", "sensor_lon sensor_lng platform_longitude platform_lon" is "sensor_longitude" in "deg" (1.0):
        "east positive";
    "sensor_height_m", "sensor_altitude_m platform_height_m platform_altitude_m" is "sensor_height_m" in "m" (1.0):
        "its height above the ellipsoid; 0 if unknown";
    "px", "sensor_x sensor_east_m platform_x platform_east_m" is "px" in "m" (1.0):
        "east in the system frame, in place of degrees";
    "py", "sensor_y sensor_north_m platform_y platform_north_m" is "py" in "m" (1.0): "north in the system frame";
    "pz", "sensor_z sensor_up_m platform_z platform_up_m" is "pz" in "m" (1.0): "up in the system frame";
    "bearing_deg", "bearing_degrees azimuth_deg azimuth_degrees doa_deg" is "bearing_rad" in "deg" (DEGREE):
        "clockwise from true north at a sensor in degrees, from y at one in metres";
    "bearing_rad", "azimuth_rad doa_rad" is "bearing_rad" in "rad" (1.0): "the same";
    "bearing_sigma_deg", "sigma_deg azimuth_sigma_deg" is "sigma_rad" in "deg" (DEGREE):
        "standard deviation of the bearing";
    "sigma_rad", "bearing_sigma_rad azimuth_sigma_rad" is "sigma_rad" in "rad" (1.0): "the same";
    "elevation_deg", "elevation_degrees" is "elevation_rad" in "deg" (DEGREE): "above the horizontal";
    "elevation_rad", "" is "elevation_rad" in "rad" (1.0): "the same";
    "elevation_sigma_deg", "" is "elevation_sigma_rad" in "deg" (DEGREE): "standard deviation of the elevation";
    "elevation_sigma_rad", "" is "elevation_sigma_rad" in "rad" (1.0): "the same";
    "range_m", "slant_range_m distance_m" is "range_m" in "m" (1.0): "slant range";
    "range_km", "" is "range_m" in "km" (1e3): "slant range";
    "range_nmi", "range_nm" is "range_m" in "nmi" (MILE_M): "slant range";
    "range_sigma_m", "" is "range_sigma_m" in "m" (1.0): "standard deviation of the range";
    "range_rate_mps", "" is "range_rate_mps" in "m/s" (1.0): "positive away from the sensor";
    "range_rate_sigma_mps", "" is "range_rate_sigma_mps" in "m/s" (1.0): "standard deviation of the rate";
    "scan", "scan_number" is "scan" in "" (1.0): "number of the scan; without it, rows of one time are a scan";
    "detection_id", "plot_id" is "detection_id" in "" (1.0): "number of the detection; without it, that of the row";
    "emitter_id", "emitter" is "emitter_id" in "" (1.0): "number of the emitter, if the sensor distinguishes emitters";
    "frequency_hz", "freq_hz" is "frequency_hz" in "Hz" (1.0): "carrier frequency";
    "frequency_mhz", "freq_mhz" is "frequency_hz" in "MHz" (1e6): "carrier frequency";
    "pulse_interval_s", "pri_s" is "pulse_interval_s" in "s" (1.0): "time between two pulses";
    "pulse_interval_us", "pri_us" is "pulse_interval_s" in "us" (1e-6): "time between two pulses";
};

impl NamedColumn {
    /// All names, the one of documents first.
    pub fn names(&self) -> impl Iterator<Item = &'static str> + use<> {
        [self.name].into_iter().chain(self.aliases.split_whitespace())
    }

    /// Returns the entry of a name as a header or a line spells it, and this name as the list spells it.
    pub fn find(spelled: &[u8]) -> Option<(&'static Self, &'static str)> {
        static BY_NAME: LazyLock<HashMap<Vec<u8>, (&'static NamedColumn, &'static str)>> = LazyLock::new(|| {
            let entries = TARGET_COLUMNS.iter().chain(SENSOR_COLUMNS);
            let named =
                entries.flat_map(|entry| entry.names().map(move |name| (plain(name.as_bytes()), (entry, name))));
            named.collect()
        });
        // Text of another encoding (UTF-16) is no name.
        let is_text = spelled.iter().all(|octet| octet.is_ascii_graphic() || *octet == b' ');
        is_text.then(|| BY_NAME.get(&plain(spelled)).copied()).flatten()
    }

    /// The entry's place in the list.
    pub(crate) fn place(&self) -> u16 {
        let mut entries = TARGET_COLUMNS.iter().chain(SENSOR_COLUMNS);
        entries.position(|entry| entry.name == self.name).unwrap_or_default() as u16
    }

    /// The entry at a place of the list.
    pub(crate) fn at(place: u16) -> &'static Self {
        let place = usize::from(place);
        match TARGET_COLUMNS.get(place) {
            Some(entry) => entry,
            None => &SENSOR_COLUMNS[place - TARGET_COLUMNS.len()],
        }
    }

    /// Returns the one of `known` names that states the quantity of a name as a line spells it, and the value of one of
    /// its units in the unit of the known name. An altitude by pressure stands for a height, as in tables.
    pub fn among(spelled: &str, known: &[&'static str]) -> Option<(&'static str, f64)> {
        /// Quantities that are taken for another where only this one is known.
        const TAKEN_FOR: [(&str, &str); 2] = [("baroaltitude", "altitude_m"), ("track_id", "track")];
        let (entry, _) = Self::find(spelled.as_bytes())?;
        let other = TAKEN_FOR.iter().find(|(quantity, _)| *quantity == entry.quantity);
        let quantities = [Some(entry.quantity), other.map(|(_, other)| *other)];
        quantities.into_iter().flatten().find_map(|quantity| {
            known.iter().find_map(|name| {
                let (of_known, _) = Self::find(name.as_bytes()).filter(|(known, _)| known.quantity == quantity)?;
                Some((*name, entry.scale / of_known.scale))
            })
        })
    }
}

/// A name without case, blanks and marks.
fn plain(name: &[u8]) -> Vec<u8> {
    let plain = |octet: &u8| octet.is_ascii_alphanumeric().then(|| octet.to_ascii_lowercase());
    name.iter().filter_map(plain).collect()
}

/// The columns for pages of help: a line for each, with its unit, its other names and its meaning, in lines of at most
/// `width` characters.
pub fn named_columns_help(columns: &[NamedColumn], width: usize) -> String {
    let mut text = String::new();
    for entry in columns {
        let mut words = entry.names().collect::<Vec<_>>().join(", ");
        // Writing to a string cannot fail.
        if !entry.unit.is_empty() {
            let _ = write!(words, " [{}]", entry.unit);
        }
        let _ = write!(words, ": {}", entry.meaning);
        let mut length = 0;
        for word in words.split(' ') {
            let is_first = length == 0;
            if !is_first && length + 1 + word.len() > width {
                text.push_str("\n  ");
                length = 2;
            } else if !is_first {
                text.push(' ');
                length += 1;
            }
            text.push_str(word);
            length += word.len();
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    fn all() -> impl Iterator<Item = &'static NamedColumn> {
        TARGET_COLUMNS.iter().chain(SENSOR_COLUMNS)
    }

    #[test]
    fn every_name_is_in_the_list_once_and_finds_its_entry() {
        let mut seen = BTreeSet::new();
        for entry in all() {
            for name in entry.names() {
                assert!(seen.insert(plain(name.as_bytes())), "{name}");
                assert_eq!(NamedColumn::find(name.to_uppercase().as_bytes()), Some((entry, name)));
            }
            let (base, _) = NamedColumn::find(entry.quantity.as_bytes()).unwrap();
            assert_eq!(
                (base.name, base.quantity, base.scale),
                (entry.quantity, entry.quantity, 1.0)
            );
        }
    }

    #[test]
    fn names_of_known_files_have_their_units() {
        for (header, quantity, value) in [
            ("SOG_knots", "speed_mps", 0.514_444),
            ("speed", "speed_mps", 1.0),
            ("BaseDateTime", "time", 1.0),
            ("# Timestamp", "time", 1.0),
            ("altitude (m)", "altitude_m", 1.0),
            ("Latitude_degrees", "latitude", 1.0),
            ("VesselName", "name", 1.0),
            ("vertical_rate", "climb_mps", 0.005_08),
            ("FL", "baroaltitude", 30.48),
            ("Azimuth (deg)", "bearing_rad", 0.017_453),
        ] {
            let (entry, _) = NamedColumn::find(header.as_bytes()).unwrap();
            assert_eq!(entry.quantity, quantity, "{header}");
            assert!((entry.scale - value).abs() < 1e-6, "{header}");
        }
        for unknown in [
            "altitude",
            "bearing",
            "Vx m/s",
            "x_speed",
            "lastposupdate",
            "",
            "°",
            "l\0a\0t\0",
            "lät",
        ] {
            assert_eq!(NamedColumn::find(unknown.as_bytes()), None, "{unknown}");
        }
    }

    #[test]
    fn a_name_stands_for_a_known_one_of_its_quantity() {
        let known = [
            "height_m",
            "speed_mps",
            "bearing_deg",
            "track",
            "time",
            "time_s",
            "sensor_east_m",
        ];
        for (spelled, name, scale) in [
            ("FL", "height_m", 30.48),
            ("altitude_m", "height_m", 1.0),
            ("sog", "speed_mps", 0.514_444),
            ("azimuth_deg", "bearing_deg", 1.0),
            ("bearing_rad", "bearing_deg", 57.295_78),
            ("id", "track", 1.0),
            ("timestamp", "time", 1.0),
            ("px", "sensor_east_m", 1.0),
        ] {
            let (found, factor) = NamedColumn::among(spelled, &known).unwrap();
            assert_eq!(found, name, "{spelled}");
            assert!((factor - scale).abs() < 1e-5, "{spelled}: {factor}");
        }
        assert_eq!(NamedColumn::among("mmsi", &known), None);
        assert_eq!(NamedColumn::among("altitude", &known), None);
    }

    #[test]
    fn the_help_names_every_column_in_narrow_lines() {
        for columns in [TARGET_COLUMNS, SENSOR_COLUMNS] {
            let help = named_columns_help(columns, 70);
            assert!(help.lines().all(|line| line.len() <= 70), "{help}");
            assert!(columns.iter().all(|entry| help.contains(entry.name)));
        }
        assert!(named_columns_help(TARGET_COLUMNS, 70).contains("[km/h]"));
    }
}
