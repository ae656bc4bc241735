//! Values of frames of Mode S, a line of JSON for each line of standard input.
//!
//! The lines have any of the forms of `formats::mode_s`. `.ci/compare_mode_s.py` compares the values with those of
//! another decoder. Two numbers as arguments are the receiver's latitude and longitude, degrees.

use std::io::{self, BufRead as _, Write as _};

use formats::mode_s::{
    FrameReader, Framed, ModeSMessage, ModeSOutput, ModeSReader, ModeSRefusal, ModeSSettings, ModeSValue, ReceiverRange,
};
use observations::{Emergency, Observation, Quality, TargetCategory};
use serde_json::{Value, json};

const M_PER_FT: f64 = 0.3048;
const MPS_PER_KT: f64 = 1852.0 / 3600.0;
/// 400 nautical miles.
const RANGE_M: f64 = 740_800.0;

fn main() -> io::Result<()> {
    let numbers: Vec<f64> = std::env::args().skip(1).filter_map(|word| word.parse().ok()).collect();
    let receiver = match numbers[..] {
        [latitude, longitude] => Some(ReceiverRange {
            place_deg: [latitude, longitude],
            range_m: RANGE_M,
        }),
        _ => None,
    };
    let mut reader = ModeSReader::new(ModeSSettings {
        receiver,
        ..ModeSSettings::default()
    });
    let (mut frames, mut out) = (FrameReader::default(), io::BufWriter::new(io::stdout().lock()));
    for line in io::stdin().lock().lines() {
        let line = line? + "\n";
        let mut values = Value::Null;
        frames.take(line.as_bytes(), &mut |framed| values = of_frame(framed));
        let before = *reader.counters();
        let mut position = Value::Null;
        reader.take(line.as_bytes(), None, &mut |ModeSOutput { value, .. }| {
            if let ModeSValue::Observation(observation) = value {
                position = of_observation(&observation);
            }
        });
        let counters = reader.counters();
        let refusal = ModeSRefusal::ALL
            .into_iter()
            .find(|reason| counters.refused(*reason) > before.refused(*reason));
        values["refused"] = json!(refusal.map(|refusal| format!("{refusal:?}")));
        values["observation"] = position;
        writeln!(out, "{values}")?;
    }
    let counters = reader.counters();
    eprintln!(
        "{} accepted, {} other, {} refused, {} unpaired, {} observations, {} statements",
        counters.accepted,
        counters.other,
        counters.refused_sum(),
        counters.unpaired,
        counters.observations,
        counters.statements
    );
    for reason in ModeSRefusal::ALL {
        if counters.refused(reason) > 0 {
            eprintln!("{} {}", counters.refused(reason), reason.sentence());
        }
    }
    out.flush()
}

fn of_frame(framed: Framed) -> Value {
    let Framed::Frame(frame, stamp) = framed else {
        return json!({ "framed": format!("{framed:?}") });
    };
    match ModeSMessage::read(&frame) {
        Ok(Some(message)) => of_message(&message, frame.format(), format!("{stamp:?}")),
        Ok(None) => json!({ "df": frame.format(), "other": true }),
        Err(refusal) => json!({ "df": frame.format(), "error": format!("{refusal:?}") }),
    }
}

fn of_message(message: &ModeSMessage, format: u8, stamp: String) -> Value {
    let in_feet = |height_m: f64| height_m / M_PER_FT;
    let callsign = message
        .callsign
        .map(|callsign| String::from_utf8_lossy(&callsign).trim_end().to_owned());
    json!({
        "df": format,
        "stamp": stamp,
        "icao": format!("{:06x}", message.address),
        "callsign": callsign,
        "category": (message.category != TargetCategory::Unknown).then(|| message.category.word()),
        "altitude_ft": message.altitude_m.map(in_feet),
        "height_ft": message.ellipsoid_height_m.map(in_feet),
        "speed_kt": message.ground_speed_mps.map(|speed| speed / MPS_PER_KT),
        "track_deg": message.track_rad.map(f64::to_degrees),
        "rate_ftpmin": message.vertical_rate_mps.map(|rate| rate * 60.0 / M_PER_FT),
        "nacv": message.velocity_accuracy,
        "squawk": message.mode_3a.map(|code| format!("{code:04o}")),
        "emergency": (message.emergency != Emergency::Unknown).then(|| message.emergency.word()),
        "selected_ft": message.selected_altitude_m.map(in_feet),
        "nacp": message.accuracy.map(|(nacp, _)| nacp),
        "sil": message.accuracy.map(|(_, sil)| sil),
        "version": message.version,
        "type": message.position.map(|_| message.position_type),
        "cpr": message.position.map(|cpr| (u8::from(cpr.is_odd), cpr.latitude, cpr.longitude)),
    })
}

fn of_observation(observation: &Observation) -> Value {
    json!({
        "place_deg": observation.geodetic.map(|place| place.map(f64::to_degrees)),
        "altitude_ft": observation.pressure_altitude_m.map(|altitude_m| altitude_m / M_PER_FT),
        "velocity_mps": observation.velocity,
        "on_ground": observation.on_ground,
        "identity": observation.identity.to_string(),
        "radius95_m": match observation.quality {
            Quality::Radius95(radius_m) => json!(radius_m),
            other => json!(format!("{other:?}")),
        },
    })
}
