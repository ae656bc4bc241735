//! System tracks as messages that Foxglove and Lichtblick draw: on a map, and in space.
//!
//! Each second of the data gives two messages: `foxglove.LocationFixes`, positions and covariances of the tracks, and
//! `foxglove.SceneUpdate`, the tracks in the system frame with velocities and labels. Both are JSON in an MCAP file;
//! viewers recognise both by the names of the schemas.

use std::collections::BTreeMap;

use frames::SystemFrame;
use mcap::WriteOptions;
use mcap::records::MessageHeader;
use messages::layout::Sample as _;
use messages::{SystemTrack, TrackState};
use offline::OutputFile;
use recording::Item;
use serde_json::{Value, json};

use crate::config::Config;

/// Time between two pictures, nanoseconds.
const PERIOD_NS: i64 = 1_000_000_000;
/// Age beyond which a state is not shown any more, although no end was published: fusion has died. Targets that are
/// reported every few minutes have states as old as that.
const AGE_MAX_NS: i64 = 900 * PERIOD_NS;
/// Time that a line ahead of a track is long, seconds.
const AHEAD_S: f64 = 60.0;
/// Colours distinguishable with colour blindness: confirmed, coasted.
const CONFIRMED: [f64; 3] = [0.0, 0.45, 0.7];
const COASTED: [f64; 3] = [0.9, 0.6, 0.0];
/// Name of the frame.
const FRAME: &str = "system";

/// Pictures, written in sequence.
pub(crate) struct PictureWriter {
    file: mcap::Writer<OutputFile>,
    places: u16,
    scene: u16,
    frame: SystemFrame,
    topic: String,
    tracks: BTreeMap<u32, SystemTrack>,
    /// Whole second of the next picture; `None` before the first state.
    due_ns: Option<i64>,
    sequence: u32,
}

impl PictureWriter {
    /// Begins a file of the pictures of a deployment of `config`.
    ///
    /// # Errors
    /// If the output cannot be written.
    pub(crate) fn begin(config: &Config, out: OutputFile) -> anyhow::Result<Self> {
        let options = WriteOptions::new().library("koseki").compression(None);
        let mut file = options.create(out)?;
        let mut channel = |name: &str, topic: &str, list: &str| {
            let schema = json!({
                "title": name,
                "type": "object",
                "properties": {list: {"type": "array", "items": {"type": "object"}}},
            });
            let schema = file.add_schema(name, "jsonschema", schema.to_string().as_bytes())?;
            file.add_channel(schema, topic, "json", &BTreeMap::new())
        };
        Ok(Self {
            places: channel("foxglove.LocationFixes", "/system/places", "fixes")?,
            scene: channel("foxglove.SceneUpdate", "/system/scene", "entities")?,
            file,
            frame: config.frame,
            topic: messages::system_tracks().name.as_str().to_owned(),
            tracks: BTreeMap::new(),
            due_ns: None,
            sequence: 0,
        })
    }

    /// Takes a part of the recording.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub(crate) fn add(&mut self, item: &Item<'_>) -> anyhow::Result<()> {
        let Item::Sample { topic, octets } = item else {
            return Ok(());
        };
        let state = (*topic == self.topic).then(|| SystemTrack::of_octets(octets)).flatten();
        let Some(state) = state else { return Ok(()) };
        let time_ns = state.reference_time_ns;
        let next_ns = (time_ns.div_euclid(PERIOD_NS) + 1) * PERIOD_NS;
        if self.due_ns.is_some_and(|due_ns| time_ns >= due_ns) {
            // After a gap, a single picture is enough.
            self.tell(next_ns - PERIOD_NS)?;
            self.due_ns = Some(next_ns);
        }
        self.due_ns.get_or_insert(next_ns);
        match TrackState::from_code(state.state) {
            Some(TrackState::Confirmed | TrackState::Coasted) => drop(self.tracks.insert(state.track_number, state)),
            _ => drop(self.tracks.remove(&state.track_number)),
        }
        Ok(())
    }

    fn tell(&mut self, time_ns: i64) -> anyhow::Result<()> {
        self.tracks
            .retain(|_, state| time_ns - state.reference_time_ns <= AGE_MAX_NS);
        let stamp = json!({
            "sec": time_ns.div_euclid(PERIOD_NS),
            "nsec": time_ns.rem_euclid(PERIOD_NS),
        });
        let fixes: Vec<Value> = self.tracks.values().map(|state| self.fix(state, &stamp)).collect();
        let entities: Vec<Value> = self.tracks.values().map(|state| entity(state, &stamp)).collect();
        let all = json!({"timestamp": stamp, "type": 1, "id": ""});
        self.write(self.places, time_ns, &json!({"fixes": fixes}))?;
        self.write(self.scene, time_ns, &json!({"deletions": [all], "entities": entities}))?;
        self.sequence += 1;
        Ok(())
    }

    fn write(&mut self, channel_id: u16, time_ns: i64, message: &Value) -> anyhow::Result<()> {
        let header = MessageHeader {
            channel_id,
            sequence: self.sequence,
            log_time: time_ns.max(0) as u64,
            publish_time: time_ns.max(0) as u64,
        };
        Ok(self
            .file
            .write_to_known_channel(&header, message.to_string().as_bytes())?)
    }

    fn fix(&self, state: &SystemTrack, stamp: &Value) -> Value {
        let place = self.frame.to_geodetic(state.position_m);
        let covariance: Vec<f64> = (0..9).map(|index| state.covariance.get(index / 3, index % 3)).collect();
        json!({
            "timestamp": stamp,
            "frame_id": FRAME,
            "latitude": place.latitude_deg(),
            "longitude": place.longitude_deg(),
            "altitude": place.height_m(),
            "position_covariance": covariance,
            "position_covariance_type": 3,
            "color": colour(state),
            "metadata": metadata(state),
        })
    }

    /// Writes the last picture and the end of the file.
    ///
    /// # Errors
    /// If the output cannot be written.
    pub(crate) fn finish(mut self) -> anyhow::Result<()> {
        if let Some(due_ns) = self.due_ns {
            self.tell(due_ns)?;
        }
        self.file.finish()?;
        self.file.into_inner().finish()
    }
}

fn colour(state: &SystemTrack) -> Value {
    let is_coasted = state.state == TrackState::Coasted as u8;
    let [r, g, b] = if is_coasted { COASTED } else { CONFIRMED };
    json!({"r": r, "g": g, "b": b, "a": 1.0})
}

fn metadata(state: &SystemTrack) -> Value {
    let sources = state.source_count.to_string();
    json!([
        {"key": "track", "value": state.track_number.to_string()},
        {"key": "identity", "value": state.identity.to_string()},
        {"key": "sources", "value": sources},
    ])
}

fn entity(state: &SystemTrack, stamp: &Value) -> Value {
    let point = |[x, y, z]: [f64; 3]| json!({"x": x, "y": y, "z": z});
    let ahead: [f64; 3] = std::array::from_fn(|axis| state.position_m[axis] + AHEAD_S * state.velocity_mps[axis]);
    let straight = json!({"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0});
    let pose = json!({"position": point(state.position_m), "orientation": straight});
    let origin = json!({"position": point([0.0; 3]), "orientation": straight});
    let label = format!(
        "{} {}",
        state.track_number,
        state.identity.callsign().unwrap_or_default()
    );
    json!({
        "timestamp": stamp,
        "frame_id": FRAME,
        "id": state.track_number.to_string(),
        "lifetime": {"sec": 0, "nsec": 0},
        "frame_locked": false,
        "metadata": metadata(state),
        "spheres": [{"pose": pose, "size": {"x": 150.0, "y": 150.0, "z": 150.0}, "color": colour(state)}],
        "lines": [{
            "type": 0,
            "pose": origin,
            "thickness": 2.0,
            "scale_invariant": true,
            "points": match state.velocity_valid {
                0 => Vec::new(),
                _ => vec![point(state.position_m), point(ahead)],
            },
            "color": colour(state),
            "colors": [],
            "indices": [],
        }],
        "texts": [{
            "pose": pose,
            "billboard": true,
            "font_size": 12.0,
            "scale_invariant": true,
            "color": colour(state),
            "text": label.trim(),
        }],
        "arrows": [], "cubes": [], "cylinders": [], "triangles": [], "models": [],
    })
}
