//! The columns that tables of strangers may have: one list, from which reading and help are made.
//!
//! A name carries its unit. Names are compared without case, blanks and marks: `BaseDateTime` is `base_date_time`, and
//! `altitude (m)` is `altitude_m`. A name whose unit differs between programs is not in the list (`altitude`), or has
//! the unit of the program that made the name common (`groundspeed`: knots).

use std::fmt::Write as _;

/// Metres in a foot.
const FOOT_M: f64 = 0.3048;
/// Metres per second in a knot.
const KNOT_MPS: f64 = 1852.0 / 3600.0;

/// Quantity of a column. A table states each quantity once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Time of measurement.
    Time,
    /// Latitude on the WGS-84 ellipsoid, degrees, north positive.
    Latitude,
    /// Longitude, degrees, east positive.
    Longitude,
    /// East in the system frame, metres.
    East,
    /// North in the system frame, metres.
    North,
    /// Up in the system frame, metres.
    Up,
    /// Height above the ellipsoid or the sea, metres.
    Height,
    /// Altitude in the standard atmosphere, metres.
    PressureAltitude,
    /// Horizontal speed, metres per second.
    Speed,
    /// Direction of motion, degrees clockwise from north.
    Course,
    /// Direction of the bow or nose, degrees clockwise from north.
    Heading,
    /// Velocity towards east, metres per second.
    EastVelocity,
    /// Velocity towards north, metres per second.
    NorthVelocity,
    /// Rate of climb, metres per second.
    Climb,
    /// Standard deviation of the position along each horizontal axis, metres.
    Sigma,
    /// 24-bit address of an aircraft.
    Address,
    /// Number of a ship.
    Mmsi,
    /// Mode 3/A code.
    Mode3a,
    /// Callsign.
    Callsign,
    /// Name of a ship, for example.
    Name,
    /// Number or name of the track at its source.
    Track,
    /// Name or number of the sensor.
    Source,
    /// Whether the target is on the ground.
    OnGround,
}

impl Quantity {
    /// Number of quantities.
    pub(super) const COUNT: usize = Self::OnGround as usize + 1;
}

/// A column that a table may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NamedColumn {
    /// The name that documents use.
    pub name: &'static str,
    /// Further names, of the same unit, with blanks between them.
    pub aliases: &'static str,
    /// Its quantity.
    pub quantity: Quantity,
    /// Unit of the values, for documents; empty for texts.
    pub unit: &'static str,
    /// Value of one unit in the unit of the quantity.
    pub(super) scale: f64,
    /// Meaning, for documents.
    pub meaning: &'static str,
}

const fn column(
    (name, aliases): (&'static str, &'static str),
    quantity: Quantity,
    (unit, scale): (&'static str, f64),
    meaning: &'static str,
) -> NamedColumn {
    NamedColumn {
        name,
        aliases,
        quantity,
        unit,
        scale,
        meaning,
    }
}

/// All columns, in the order of the documents.
pub const NAMED_COLUMNS: &[NamedColumn] = &[
    column(
        (
            "time",
            "time_s timestamp t ts datetime base_date_time utc time_utc unix_time",
        ),
        Quantity::Time,
        ("", 1.0),
        "ISO 8601 (UTC without a zone), seconds or milliseconds since 1970, or seconds of the day",
    ),
    column(
        ("latitude", "lat lat_deg latitude_deg latitude_degrees"),
        Quantity::Latitude,
        ("deg", 1.0),
        "on the WGS-84 ellipsoid, north positive",
    ),
    column(
        ("longitude", "lon lng long lon_deg longitude_deg longitude_degrees"),
        Quantity::Longitude,
        ("deg", 1.0),
        "east positive",
    ),
    column(
        ("x", "x_m east_m"),
        Quantity::East,
        ("m", 1.0),
        "east in the system frame, in place of degrees",
    ),
    column(
        ("y", "y_m north_m"),
        Quantity::North,
        ("m", 1.0),
        "north in the system frame",
    ),
    column(
        ("z", "z_m up_m"),
        Quantity::Up,
        ("m", 1.0),
        "up in the system frame, beside x and y",
    ),
    column(
        ("altitude_m", "geoaltitude geoaltitude_m height_m alt_m"),
        Quantity::Height,
        ("m", 1.0),
        "height above the ellipsoid",
    ),
    column(
        ("alt_geom", "geoaltitude_ft"),
        Quantity::Height,
        ("ft", FOOT_M),
        "height above the ellipsoid",
    ),
    column(
        ("flight_level", "fl"),
        Quantity::PressureAltitude,
        ("100 ft", 100.0 * FOOT_M),
        "pressure altitude",
    ),
    column(
        (
            "altitude_ft",
            "altitude_feet alt_ft alt_baro baroaltitude_ft pressure_altitude_ft",
        ),
        Quantity::PressureAltitude,
        ("ft", FOOT_M),
        "pressure altitude",
    ),
    column(
        ("baroaltitude", "baro_altitude_m pressure_altitude_m"),
        Quantity::PressureAltitude,
        ("m", 1.0),
        "pressure altitude",
    ),
    column(
        ("speed_mps", "speed velocity velocity_mps groundspeed_mps"),
        Quantity::Speed,
        ("m/s", 1.0),
        "over ground",
    ),
    column(
        (
            "speed_kn",
            "sog sog_kn sog_knots speed_kt speed_kts speed_knots groundspeed gs",
        ),
        Quantity::Speed,
        ("kn", KNOT_MPS),
        "over ground",
    ),
    column(
        ("speed_kmh", "speed_kph"),
        Quantity::Speed,
        ("km/h", 1.0 / 3.6),
        "over ground",
    ),
    column(
        (
            "course_deg",
            "course course_degrees cog cog_deg cog_degrees track_deg true_track",
        ),
        Quantity::Course,
        ("deg", 1.0),
        "direction of motion, clockwise from true north (from y beside x and y)",
    ),
    column(
        ("heading", "heading_deg heading_degrees true_heading"),
        Quantity::Heading,
        ("deg", 1.0),
        "the course, in a table without another column of it; else unused",
    ),
    column(
        ("vx", "vx_mps"),
        Quantity::EastVelocity,
        ("m/s", 1.0),
        "towards east, in place of speed and course",
    ),
    column(("vy", "vy_mps"), Quantity::NorthVelocity, ("m/s", 1.0), "towards north"),
    column(
        ("climb_mps", "vertrate climb vz vz_mps"),
        Quantity::Climb,
        ("m/s", 1.0),
        "upwards",
    ),
    column(
        ("climb_fpm", "vertical_rate vertical_rate_fpm baro_rate"),
        Quantity::Climb,
        ("ft/min", FOOT_M / 60.0),
        "upwards",
    ),
    column(
        ("sigma_m", "position_sigma_m"),
        Quantity::Sigma,
        ("m", 1.0),
        "standard deviation of the position along each axis",
    ),
    column(
        ("address", "icao24 icao hex icao_address"),
        Quantity::Address,
        ("", 1.0),
        "24-bit address of an aircraft, hexadecimal",
    ),
    column(("mmsi", ""), Quantity::Mmsi, ("", 1.0), "number of a ship"),
    column(
        ("mode_3a", "squawk"),
        Quantity::Mode3a,
        ("", 1.0),
        "Mode 3/A code, octal",
    ),
    column(
        ("callsign", "flight"),
        Quantity::Callsign,
        ("", 1.0),
        "up to eight characters",
    ),
    column(
        ("name", "vessel_name ship_name"),
        Quantity::Name,
        ("", 1.0),
        "up to 20 characters",
    ),
    column(
        ("track", "id track_id track_number sensor_track_id target_id"),
        Quantity::Track,
        ("", 1.0),
        "number or name of the target (track alone: the course, in a table with a speed and no course)",
    ),
    column(
        ("source", "sensor sensor_id source_id"),
        Quantity::Source,
        ("", 1.0),
        "name or number of the sensor; without it, the file is a sensor",
    ),
    column(
        ("on_ground", ""),
        Quantity::OnGround,
        ("", 1.0),
        "true or false, 1 or 0",
    ),
];

impl NamedColumn {
    /// All names, the one of documents first.
    pub fn names(&self) -> impl Iterator<Item = &'static str> + use<> {
        [self.name].into_iter().chain(self.aliases.split_whitespace())
    }
}

/// Returns the entry of a name in a header, and this name as the list spells it.
pub(super) fn find(header: &[u8]) -> Option<(&'static NamedColumn, &'static str)> {
    let entry = |entry: &'static NamedColumn| Some((entry, entry.names().find(|name| is_same(name, header))?));
    NAMED_COLUMNS.iter().find_map(entry)
}

/// Whether two names differ in case, blanks and marks only. Text of another encoding (UTF-16) is no name.
fn is_same(name: &str, header: &[u8]) -> bool {
    if !header.iter().all(|octet| octet.is_ascii_graphic() || *octet == b' ') {
        return false;
    }
    let plain = |octet: &u8| octet.is_ascii_alphanumeric().then(|| octet.to_ascii_lowercase());
    name.as_bytes()
        .iter()
        .filter_map(plain)
        .eq(header.iter().filter_map(plain))
}

/// The list for pages of help: a line for each column, with its unit, its other names and its meaning, in lines of at
/// most `width` characters.
pub fn named_columns_help(width: usize) -> String {
    let mut text = String::new();
    for entry in NAMED_COLUMNS {
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

    #[test]
    fn every_name_is_in_the_list_once_and_finds_its_entry() {
        let mut seen = BTreeSet::new();
        for entry in NAMED_COLUMNS {
            for name in entry.names() {
                let plain: String = name.chars().filter(char::is_ascii_alphanumeric).collect();
                assert!(seen.insert(plain), "{name}");
                assert_eq!(find(name.to_uppercase().as_bytes()), Some((entry, name)));
            }
        }
    }

    #[test]
    fn names_of_known_files_have_their_units() {
        for (header, quantity, value) in [
            ("SOG_knots", Quantity::Speed, 0.514_444),
            ("speed", Quantity::Speed, 1.0),
            ("BaseDateTime", Quantity::Time, 1.0),
            ("# Timestamp", Quantity::Time, 1.0),
            ("altitude (m)", Quantity::Height, 1.0),
            ("Latitude_degrees", Quantity::Latitude, 1.0),
            ("VesselName", Quantity::Name, 1.0),
            ("vertical_rate", Quantity::Climb, 0.005_08),
            ("FL", Quantity::PressureAltitude, 30.48),
        ] {
            let (entry, _) = find(header.as_bytes()).unwrap();
            assert_eq!(entry.quantity, quantity, "{header}");
            assert!((entry.scale - value).abs() < 1e-6, "{header}");
        }
        for unknown in [
            "altitude",
            "Vx m/s",
            "x_speed",
            "lastposupdate",
            "",
            "°",
            "l\0a\0t\0",
            "lät",
        ] {
            assert_eq!(find(unknown.as_bytes()), None, "{unknown}");
        }
    }

    #[test]
    fn the_help_names_every_column_in_narrow_lines() {
        let help = named_columns_help(70);
        assert!(help.lines().all(|line| line.len() <= 70), "{help}");
        assert!(NAMED_COLUMNS.iter().all(|entry| help.contains(entry.name)));
        assert!(help.contains("[km/h]"));
    }
}
