//! Protocol between the server of a display and a page in a browser, over a WebSocket at `/ws`.
//!
//! # From the server, binary: pictures
//!
//! A picture consists of the records of [`messages::picture`]; its header counts them. `page/wire.js`, generated
//! from the same tables, reads it. A picture is a delta: it holds the records changed since the previous picture,
//! and the numbers of removed tracks. A `FULL` picture replaces everything: on connecting, and when a page turns to
//! the past or back to the present. A track that leaves view or filter counts as removed. The server makes the next
//! picture after the acknowledgement of the previous picture: a slow reader skips pictures but misses no record
//! that is still valid.
//!
//! The server sends an identity with a track new to the reader, and on change. It sends a sensor track with each
//! newer report; the page drops sensor tracks without a report for `layer_age_s`. It likewise sends stations that are
//! no targets, all that are known to a page that joins; the page drops those without a report for `station_age_s`.
//! Detections, bearings and areas are those received since the previous picture.
//!
//! # From the server, text: JSON, distinguished by `type`
//!
//! Times ending in `_s` are seconds since 1970, UTC, as numbers. Times ending in `_ns` are nanoseconds as text,
//! because they exceed the exact range of JavaScript's numbers. An unknown value is `null`.
//!
//! - `hello`: at first, and when the origin becomes known: `version`, `instance`, `origin` {`latitude_deg`,
//!   `longitude_deg`, `height_m`}, `sources` [{`number`, `name`, `kind`, `site_m` [3]}], `declination_deg`,
//!   `history_s`, `layer_age_s`, `station_age_s`, `recording` {`name`, `from_s`, `to_s`, `time_s`, `speed`} or `null`,
//!   `operators` (whether there are any), `labels` {`lines` of fields, `prefer`}, `limits` {`rate_hz` [2], `select`}
//! - `selected`: after each picture, while tracks are selected: `time_s`, `tracks`, see [`crate::details`]
//! - `history`: once for each newly selected track: `number`, `rows`, see [`crate::details`]
//! - `status`: every second: `time_s`, `fusion` (`running`, `silent`), `data_offset_s` (of the newest states from
//!   the clock, positive: ahead), `unexplained_offset_s` (the part that the sources' rhythm does not explain), `replay`
//!   (whether the deployment replays recordings), `history` {`from_s`, `to_s`}, `clients`, `skipped`, `sources`,
//!   `alarms`, `latency`, `processes`, `system`, see [`crate::status`]
//! - `refused`: before the server closes: `error`
//!
//! # From the page, text: JSON, any of [`Wish`]'s fields, in at most [`MESSAGE_MAX`] bytes
//!
//! The server refuses unreadable messages, including unknown fields, and closes the connection.

use messages::TrackState;
use messages::picture::PictureLayer;
use serde::{Deserialize, Deserializer};

/// Maximum length of a page's message, bytes.
pub(crate) const MESSAGE_MAX: usize = 4096;
/// Maximum number of selected tracks.
pub(crate) const SELECT_MAX: usize = 16;
/// Lowest and highest rate of pictures per second.
pub(crate) const RATE_HZ: [f64; 2] = [1.0, 10.0];
/// Display time of a sensor track without new reports, seconds.
pub(crate) const LAYER_AGE_S: i64 = 30;
/// Display time of a base station or an aid to navigation without new reports, seconds: three reports of an aid, which
/// come every three minutes, and one more for delays.
pub(crate) const STATION_AGE_S: i64 = 600;

/// Wish of a page; absent fields leave their values unchanged.
#[derive(Clone, Debug, Default, Deserialize, PartialEq)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct Wish {
    /// Pictures per second; initially 4.
    pub(crate) rate_hz: Option<f64>,
    /// Metres: west, south, east, north; `null`: everything.
    #[serde(deserialize_with = "given")]
    pub(crate) view: Option<Option<[f32; 4]>>,
    /// Layers besides the system tracks, by word.
    #[serde(deserialize_with = "layers")]
    pub(crate) layers: Option<Vec<PictureLayer>>,
    /// Numbers of the system tracks for which the page requests all details.
    pub(crate) select: Option<Vec<u32>>,
    /// Filter of the system tracks; `null`: all are shown.
    #[serde(deserialize_with = "given")]
    pub(crate) filter: Option<Option<Filter>>,
    /// Sequence number of the received picture.
    pub(crate) ack: Option<u32>,
    /// `null`: the present. For a recording, this moment is set for all pages; a recording has no present, and
    /// `null` changes nothing.
    #[serde(deserialize_with = "given")]
    pub(crate) past: Option<Option<Past>>,
}

/// Filter of system tracks: a track must satisfy every given field.
#[derive(Clone, Debug, Default, Deserialize, PartialEq)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct Filter {
    /// States by word; none given: all.
    #[serde(deserialize_with = "states")]
    pub(crate) states: Option<Vec<TrackState>>,
    /// At least one of these sources contributes.
    pub(crate) sources: Option<Vec<u16>>,
    /// Lowest and highest height, metres. Tracks without height are shown.
    pub(crate) height_m: Option<[Option<f32>; 2]>,
    /// Text contained in callsign, address, code, name or number; case is ignored.
    pub(crate) text: Option<String>,
}

/// Moment of the past, and the speed of time from there.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub(crate) struct Past {
    /// Seconds since 1970, UTC.
    pub(crate) time_s: f64,
    /// Seconds per second; 0: time stands still.
    pub(crate) speed: f64,
}

impl Past {
    /// Returns the wanted moment at this time after the request, seconds since 1970.
    pub(crate) fn at_s(&self, passed_ns: i64) -> f64 {
        self.time_s + self.speed * passed_ns as f64 / messages::NS_PER_S
    }
}

/// Reads a present value, including `null`.
fn given<'de, D: Deserializer<'de>, T: Deserialize<'de>>(from: D) -> Result<Option<T>, D::Error> {
    T::deserialize(from).map(Some)
}

fn states<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Vec<TrackState>>, D::Error> {
    words(from, "state", TrackState::from_word)
}

fn layers<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Vec<PictureLayer>>, D::Error> {
    words(from, "layer", PictureLayer::from_word)
}

/// Reads the values of words that are each a `kind`.
fn words<'de, D: Deserializer<'de>, T>(
    from: D,
    kind: &str,
    value: impl Fn(&str) -> Option<T>,
) -> Result<Option<Vec<T>>, D::Error> {
    let words = Option::<Vec<String>>::deserialize(from)?;
    let read = |word: &String| value(word).ok_or_else(|| serde::de::Error::custom(format!("\"{word}\" is no {kind}")));
    words.map(|words| words.iter().map(read).collect()).transpose()
}

impl Wish {
    /// Parses a wish.
    ///
    /// # Errors
    /// A sentence, if `text` is no valid wish.
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
        assert_eq!(wish.layers, Some(vec![PictureLayer::SensorTracks, PictureLayer::Areas]));
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
