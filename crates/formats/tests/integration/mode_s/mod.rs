//! Frames of Mode S: values of frames from the literature, streams of any division and damage, positions that recover.

mod errors;
mod frames;
mod framing;
mod positions;
mod values;

use formats::mode_s::{ModeSFrame, ModeSOutput, ModeSReader, ModeSSettings, ModeSValue, ReceiverRange};
use observations::{Observation, Statement};

const S: i64 = 1_000_000_000;
/// A moment in November 2023.
const START_NS: i64 = 1_700_000_000 * S;

/// The receiver of the tests.
const RECEIVER: ReceiverRange = ReceiverRange {
    place_deg: [52.0, 4.4],
    range_m: 740_800.0,
};

fn reader(receiver: Option<ReceiverRange>) -> ModeSReader {
    ModeSReader::new(ModeSSettings {
        start_utc_ns: START_NS,
        receiver,
        aircraft_max: 8,
    })
}

/// Outputs of a frame that is received so long after the start.
fn take(reader: &mut ModeSReader, frame: &str, after_s: f64) -> Vec<ModeSOutput> {
    let mut found = Vec::new();
    let received_ns = START_NS + (after_s * 1e9) as i64;
    reader.take(format!("*{frame};\n").as_bytes(), Some(received_ns), &mut |output| {
        found.push(output)
    });
    found
}

fn observed(outputs: &[ModeSOutput]) -> Option<Observation> {
    outputs.iter().find_map(|output| match output.value {
        ModeSValue::Observation(observation) => Some(observation),
        ModeSValue::Statement(_) => None,
    })
}

fn stated(outputs: &[ModeSOutput]) -> Option<Statement> {
    outputs.iter().find_map(|output| match output.value {
        ModeSValue::Statement(statement) => Some(statement),
        ModeSValue::Observation(_) => None,
    })
}

/// Latitude and longitude, degrees, to a ten-thousandth.
fn place(outputs: &[ModeSOutput]) -> Option<[f64; 2]> {
    let place = observed(outputs)?.geodetic?;
    Some(place.map(|angle| (angle.to_degrees() * 1e4).round() / 1e4))
}

/// A frame of data, with a checksum combined with `overlay`.
fn sealed(data: &[u8], overlay: u32) -> String {
    let mut octets = data.to_vec();
    octets.extend([0; 3]);
    let checksum = ModeSFrame::new(&octets).unwrap().syndrome() ^ overlay;
    let end = octets.len() - 3;
    octets[end..].copy_from_slice(&checksum.to_be_bytes()[1..]);
    octets.iter().map(|octet| format!("{octet:02X}")).collect()
}

/// An extended squitter of an address, with a message of 56 bits.
fn squitter(head: u8, address: u32, message: u64) -> String {
    let mut data = vec![head];
    data.extend(&address.to_be_bytes()[1..]);
    data.extend(&message.to_be_bytes()[1..]);
    sealed(&data, 0)
}

/// A message from fields of a value and a number of bits, the rest zero.
fn message(fields: &[(u64, u32)]) -> u64 {
    let (bits, used) = fields.iter().fold((0, 0), |(bits, used), (value, width)| {
        (bits << width | value, used + width)
    });
    bits << (56 - used)
}

/// Position in compact form, by the standard's encoding: parity, latitude, longitude.
fn compact([latitude, longitude]: [f64; 2], is_surface: bool, is_odd: bool) -> [(u64, u32); 3] {
    let span = if is_surface { 90.0 } else { 360.0 };
    let parity = f64::from(u8::from(is_odd));
    let part = |angle: f64, zone: f64| (131_072.0 * angle.rem_euclid(zone) / zone).round() as u64 % 131_072;
    let zone = span / (60.0 - parity);
    let y = part(latitude, zone);
    let shown = zone * (y as f64 / 131_072.0 + (latitude / zone).floor());
    let ratio = (1.0 - (std::f64::consts::PI / 30.0).cos()) / shown.to_radians().cos().powi(2);
    let zones = (std::f64::consts::TAU / (1.0 - ratio).acos()).floor();
    let x = part(longitude, span / (zones - parity).max(1.0));
    [(u64::from(is_odd), 1), (y, 17), (x, 17)]
}

/// An airborne position of type 11 at 38,000 ft.
fn airborne(address: u32, place: [f64; 2], is_odd: bool) -> String {
    let head = [(11, 5), (0, 3), (0xc38, 12), (0, 1)];
    squitter(
        0x8d,
        address,
        message(&[&head[..], &compact(place, false, is_odd)].concat()),
    )
}

/// A surface position of type 7 at 17 kn towards the east.
fn surface(address: u32, place: [f64; 2], is_odd: bool) -> String {
    let head = [(7, 5), (41, 7), (1, 1), (32, 7), (0, 1)];
    squitter(
        0x8c,
        address,
        message(&[&head[..], &compact(place, true, is_odd)].concat()),
    )
}
