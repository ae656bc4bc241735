//! Lines of AIS receivers from standard input, as one line of JSON for each message: for comparisons with other
//! decoders.
//!
//! Lines that hold no message, or a part of one, give nothing. Refused lines give their number and the reason.

use std::io::{self, BufRead as _, Write as _};

use formats::ais::{AisOutput, AisReader, AisSettings};
use messages::Identity;
use observations::{FixedStation, Observation, Quality, Statement};
use serde_json::{Map, Value, json};

fn main() -> io::Result<()> {
    let mut reader = AisReader::new(AisSettings::default());
    let mut out = io::BufWriter::new(io::stdout().lock());
    for (number, line) in io::stdin().lock().split(b'\n').enumerate() {
        let (line, before) = (line?, *reader.counters());
        let mut fields = Map::new();
        let result = reader.take(0, &line, 0, |_, output| match output {
            AisOutput::Target(observation) => drop(fields.insert("target".to_owned(), target(&observation))),
            AisOutput::OwnShip(observation) => drop(fields.insert("own_ship".to_owned(), target(&observation))),
            AisOutput::Statement(stated) => match &stated.station {
                Some(station) => drop(fields.insert("fixed".to_owned(), fixed(&stated, station))),
                None => {
                    let all = fields.entry("statements").or_insert_with(|| json!([]));
                    all.as_array_mut()
                        .into_iter()
                        .for_each(|all| all.push(statement(&stated)));
                }
            },
        });
        if let Err(error) = result {
            fields.insert("refused".to_owned(), json!(format!("{:?}", error.rejection)));
        }
        let after = reader.counters();
        let types = (1..28).find(|kind| after.types[*kind] > before.types[*kind]);
        if types.is_none() && fields.is_empty() && after.repeats == before.repeats {
            continue;
        }
        fields.insert("line".to_owned(), json!(number));
        fields.insert("type".to_owned(), json!(types));
        writeln!(out, "{}", Value::Object(fields))?;
    }
    eprintln!("{:?}", reader.counters());
    out.flush()
}

fn identity(identity: &Identity) -> Value {
    json!({ "mmsi": identity.mmsi(), "name": identity.name(), "callsign": identity.callsign() })
}

fn target(observation: &Observation) -> Value {
    json!({
        "identity": identity(&observation.identity),
        "track_number": observation.track_number,
        "time_of_day_ns": observation.time_of_day_ns,
        "position_deg": observation.geodetic.map(|position| position.map(f64::to_degrees)),
        "velocity_mps": observation.velocity,
        "pressure_altitude_m": observation.pressure_altitude_m,
        "geometric_height_m": observation.geometric_height_m,
        "is_test": observation.test,
        "alerts": [observation.alerts.stated, observation.alerts.raised],
        "quality": match observation.quality {
            Quality::Radius95(radius_m) => json!({ "radius95_m": radius_m }),
            Quality::Covariance(covariance_m2) => json!({ "covariance_m2": covariance_m2 }),
            Quality::Unknown => json!("unknown"),
            other => json!(format!("{other:?}")),
        },
    })
}

fn statement(statement: &Statement) -> Value {
    json!({
        "track_number": statement.track_number,
        "category": statement.category.word(),
        "navigation": statement.navigation.word(),
        "emergency": statement.emergency.word(),
        "size_m": statement.size_m,
    })
}

fn fixed(stated: &Statement, station: &FixedStation) -> Value {
    json!({
        "mmsi": stated.track_number,
        "name": Some(String::from_utf8_lossy(&station.name).trim_end()).filter(|name| !name.is_empty()),
        "category": stated.category.word(),
        "size_m": stated.size_m,
        "aid_type": station.aid.code(),
        "is_virtual": station.is_virtual,
        "is_off_position": station.is_off_position,
        "position_deg": station.place_rad.map(f64::to_degrees),
    })
}
