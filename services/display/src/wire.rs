//! The wire: what the server of a display and a page in a browser say to each other over a WebSocket at `/ws`.
//!
//! # From the server, binary: pictures
//!
//! A picture is made of the records of [`messages::picture`], as many as its header counts; `page/wire.js`, which is
//! written from the same tables, reads it. A picture is a delta: it has the records of what has changed since the one
//! before, and the numbers of the tracks that have gone. One that is `FULL` begins anew: on connecting, and when a page
//! turns to the past or back to the present. A track that leaves view or filter has gone, too. The next picture is made
//! when the one before was acknowledged: a slow reader skips, and misses nothing that still holds.
//!
//! An identity comes with a track that is new to the reader and when it changes. A sensor track comes when a report is
//! newer; whoever has heard nothing of one for `layer_age_s` forgets it. Detections, bearings and areas are those that
//! came since the picture before.
//!
//! # From the server, text: JSON, `type` says which
//!
//! Times that end in `_s` are seconds since 1970, UTC, as numbers; those that end in `_ns` are nanoseconds as text,
//! since numbers of JavaScript do not hold them. Whatever is not known is `null`.
//!
//! - `hello`: at first, and when the origin becomes known: `version`, `instance`, `origin` {`latitude_deg`,
//!   `longitude_deg`, `height_m`}, `sources` [{`number`, `name`, `kind`, `site_m` [3]}], `history_s`, `layer_age_s`,
//!   `recording` {`name`, `from_s`, `to_s`, `time_s`, `speed`} or `null`, `limits` {`rate_hz` [2], `select`}
//! - `selected`: after each picture, while something is selected: `time_s`, `tracks`, see [`crate::details`]
//! - `history`: once for each newly selected track: `number`, `rows`, see [`crate::details`]
//! - `status`: every second: `time_s`, `fusion` (`running`, `silent`), `data_offset_s` (of the newest states from
//!   the clock, positive: ahead), `history` {`from_s`, `to_s`}, `clients`,
//!   `skipped`, `sources`, `alarms`, `latency`, `processes`, `system`, see [`crate::status`]
//! - `refused`: before the server closes: `error`
//!
//! # From the page, text: JSON, any of [`Wish`]'s fields, in at most [`MESSAGE_MAX`] octets
//!
//! What cannot be read, a field that does not exist included, is refused, and the connection closed.

use messages::TrackState;
use serde::{Deserialize, Deserializer};

/// Longest message of a page, octets.
pub(crate) const MESSAGE_MAX: usize = 4096;
/// Most tracks that can be selected.
pub(crate) const SELECT_MAX: usize = 16;
/// Fewest and most pictures a second.
pub(crate) const RATE_HZ: [f64; 2] = [1.0, 10.0];
/// Time for which a sensor track is shown that is not heard of, seconds.
pub(crate) const LAYER_AGE_S: i64 = 30;

/// Wish of a page; what it does not name stays as it was.
#[derive(Clone, Debug, Default, Deserialize, PartialEq)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct Wish {
    /// Pictures a second; at first 4.
    pub(crate) rate_hz: Option<f64>,
    /// Metres: west, south, east, north; `null`: everything.
    #[serde(deserialize_with = "given")]
    pub(crate) view: Option<Option<[f32; 4]>>,
    /// Layers besides the system tracks.
    pub(crate) layers: Option<Vec<Layer>>,
    /// Numbers of the system tracks of which all is to be known.
    pub(crate) select: Option<Vec<u32>>,
    /// Which system tracks are to be shown; `null`: all.
    #[serde(deserialize_with = "given")]
    pub(crate) filter: Option<Option<Filter>>,
    /// Sequence number of the picture that has come.
    pub(crate) ack: Option<u32>,
    /// `null`: the present. A recording is brought to this moment for all pages; it has no present, and `null` changes
    /// nothing.
    #[serde(deserialize_with = "given")]
    pub(crate) past: Option<Option<Past>>,
}

/// Layer that is shown when it is asked for.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Layer {
    SensorTracks,
    Detections,
    Bearings,
    Areas,
}

/// Which system tracks are shown: those that all of it admits.
#[derive(Clone, Debug, Default, Deserialize, PartialEq)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct Filter {
    /// States by word; none given: all.
    #[serde(deserialize_with = "states")]
    pub(crate) states: Option<Vec<TrackState>>,
    /// Some of these sources contributes.
    pub(crate) sources: Option<Vec<u16>>,
    /// Least and greatest height, metres. Tracks without height are shown.
    pub(crate) height_m: Option<[Option<f32>; 2]>,
    /// Callsign, address, code, name or number contains this, in whatever letters.
    pub(crate) text: Option<String>,
}

/// Moment of the past, and how fast time runs from there.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub(crate) struct Past {
    /// Seconds since 1970, UTC.
    pub(crate) time_s: f64,
    /// Seconds a second; 0: it stands still.
    pub(crate) speed: f64,
}

impl Past {
    /// Moment that is wanted so long after it was asked for, seconds since 1970.
    pub(crate) fn at_s(&self, passed_ns: i64) -> f64 {
        self.time_s + self.speed * passed_ns as f64 / messages::NS_PER_S
    }
}

/// A value that is there, if only as `null`.
fn given<'de, D: Deserializer<'de>, T: Deserialize<'de>>(from: D) -> Result<Option<T>, D::Error> {
    T::deserialize(from).map(Some)
}

fn states<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Vec<TrackState>>, D::Error> {
    let words = Option::<Vec<String>>::deserialize(from)?;
    let state = |word: &String| {
        TrackState::from_word(word).ok_or_else(|| serde::de::Error::custom(format!("\"{word}\" is no state")))
    };
    words.map(|words| words.iter().map(state).collect()).transpose()
}

impl Wish {
    /// The wish that `text` is.
    ///
    /// # Errors
    /// If it is none, in a sentence.
    pub(crate) fn read(text: &str) -> Result<Self, String> {
        let wish: Self = serde_json::from_str(text).map_err(|error| error.to_string())?;
        let rates = RATE_HZ[0]..=RATE_HZ[1];
        if wish.rate_hz.is_some_and(|rate_hz| !rates.contains(&rate_hz)) {
            return Err(format!("rate_hz: from {} to {}", RATE_HZ[0], RATE_HZ[1]));
        }
        if wish.select.as_ref().is_some_and(|select| select.len() > SELECT_MAX) {
            return Err(format!("select: at most {SELECT_MAX}"));
        }
        if let Some(Some(past)) = wish.past
            && !(past.time_s.abs() < 9e9 && (0.0..=100.0).contains(&past.speed))
        {
            return Err("past: a time in seconds since 1970, and a speed from 0 to 100".to_owned());
        }
        Ok(wish)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_named_stays_and_null_is_named() {
        assert_eq!(Wish::read("{}").unwrap(), Wish::default());
        let wish =
            Wish::read(r#"{"view": null, "past": null, "ack": 7, "layers": ["sensor_tracks", "areas"]}"#).unwrap();
        assert_eq!((wish.view, wish.past, wish.ack), (Some(None), Some(None), Some(7)));
        assert_eq!(wish.layers, Some(vec![Layer::SensorTracks, Layer::Areas]));
        let wish = Wish::read(r#"{"filter": {"states": ["coasted"], "height_m": [null, 300]}}"#).unwrap();
        let filter = wish.filter.flatten().unwrap();
        assert_eq!(filter.states, Some(vec![TrackState::Coasted]));
        assert_eq!(filter.height_m, Some([None, Some(300.0)]));
    }

    #[test]
    fn what_is_no_wish_is_refused() {
        for text in [
            "",
            "[]x",
            "7",
            r#"{"rate": 4}"#,
            r#"{"rate_hz": 0.5}"#,
            r#"{"rate_hz": 11}"#,
            r#"{"rate_hz": "4"}"#,
            r#"{"view": [1, 2, 3]}"#,
            r#"{"layers": ["all"]}"#,
            r#"{"select": [-1]}"#,
            r#"{"select": [1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16,17]}"#,
            r#"{"filter": {"states": ["sure"]}}"#,
            r#"{"past": {"time_s": 1e300, "speed": 1}}"#,
            r#"{"past": {"time_s": 1, "speed": -1}}"#,
            r#"{"past": {"time_s": 1}}"#,
        ] {
            assert!(Wish::read(text).is_err(), "{text}");
        }
    }
}
