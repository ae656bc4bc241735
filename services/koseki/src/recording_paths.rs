//! Paths of the system tracks of a recording, for maps and geographic programs: GeoJSON, KML, GPX.
//!
//! Each track is a path of its confirmed states, thinned to a state a second: longitude, latitude, height above the
//! ellipsoid, time. A silence of more than [`GAP_NS`] divides a path into segments, so that no line is drawn across
//! the silence. A selection takes the states within times and an area, and tracks by number or name.
//!
//! Limits: all states of the selection are in memory, 40 bytes each. Altitudes by pressure are not exported: a height
//! is missing where no source measures it.

use std::collections::BTreeMap;
use std::io::Write;

use frames::SystemFrame;
use jiff::Timestamp;
use messages::{SystemTrack, TrackState};
use quick_xml::escape::escape;
use serde_json::{Value, json};

/// Silence that divides a path, nanoseconds.
const GAP_NS: i64 = 60_000_000_000;
/// Shortest time between two states of a path, nanoseconds.
const STEP_NS: i64 = 1_000_000_000;

/// Form of the paths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PathForm {
    /// A feature a track, a line a segment.
    GeoJson,
    /// A track with times a segment.
    Kml,
    /// A track with a segment each.
    Gpx,
}

/// States to export.
#[derive(Clone, Debug, Default)]
pub(crate) struct PathSelection {
    /// Earliest and latest time of a state, UTC, nanoseconds.
    pub(crate) from_ns: Option<i64>,
    pub(crate) to_ns: Option<i64>,
    /// West, south, east, north, degrees; west of east unless the area spans the date line.
    pub(crate) area_deg: Option<[f64; 4]>,
    /// Track numbers, call signs, addresses, MMSIs or names; empty: all.
    pub(crate) targets: Vec<String>,
}

/// A state of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PathPoint {
    time_ns: i64,
    latitude_deg: f64,
    longitude_deg: f64,
    height_m: Option<f64>,
}

/// Path of a track.
#[derive(Debug, Default)]
struct TrackPath {
    /// Words that name the track, in order of preference.
    names: Vec<String>,
    segments: Vec<Vec<PathPoint>>,
}

/// Paths by track number.
#[derive(Debug)]
pub(crate) struct Paths {
    frame: SystemFrame,
    selection: PathSelection,
    tracks: BTreeMap<u32, TrackPath>,
}

impl Paths {
    /// Creates empty paths of positions in `frame`.
    pub(crate) fn new(frame: SystemFrame, selection: PathSelection) -> Self {
        Self {
            frame,
            selection,
            tracks: BTreeMap::new(),
        }
    }

    /// Adds a state.
    pub(crate) fn add(&mut self, track: &SystemTrack) {
        if track.state != TrackState::Confirmed.code() {
            return;
        }
        let path = self.tracks.entry(track.track_number).or_default();
        path.name(track);
        let time_ns = track.reference_time_ns;
        let place = self.frame.to_geodetic(track.position_m);
        let point = PathPoint {
            time_ns,
            latitude_deg: place.latitude_deg(),
            longitude_deg: place.longitude_deg(),
            height_m: (track.height_valid != 0).then(|| place.height_m()),
        };
        if !self.selection.admits(&point) {
            return;
        }
        match path
            .segments
            .last_mut()
            .and_then(|segment| Some((segment.last()?.time_ns, segment)))
        {
            Some((last_ns, _)) if time_ns < last_ns.saturating_add(STEP_NS) => {}
            Some((last_ns, segment)) if time_ns - last_ns <= GAP_NS => segment.push(point),
            _ => path.segments.push(vec![point]),
        }
    }

    /// Writes the selected paths.
    ///
    /// # Errors
    /// If `out` fails.
    pub(crate) fn write(&self, form: PathForm, out: &mut impl Write) -> std::io::Result<()> {
        let selected: Vec<(&u32, &TrackPath)> = self
            .tracks
            .iter()
            .filter(|(number, path)| !path.segments.is_empty() && self.selection.names(**number, path))
            .collect();
        match form {
            PathForm::GeoJson => geojson(&selected, out),
            PathForm::Kml => kml(&selected, out),
            PathForm::Gpx => gpx(&selected, out),
        }
    }
}

impl PathSelection {
    fn admits(&self, point: &PathPoint) -> bool {
        let is_in_time = self.from_ns.is_none_or(|from_ns| point.time_ns >= from_ns)
            && self.to_ns.is_none_or(|to_ns| point.time_ns <= to_ns);
        is_in_time
            && self.area_deg.is_none_or(|[west, south, east, north]| {
                let is_between = if west <= east {
                    (west..=east).contains(&point.longitude_deg)
                } else {
                    point.longitude_deg >= west || point.longitude_deg <= east
                };
                is_between && (south..=north).contains(&point.latitude_deg)
            })
    }

    fn names(&self, number: u32, path: &TrackPath) -> bool {
        let number = number.to_string();
        let is_it =
            |wanted: &String| *wanted == number || path.names.iter().any(|name| name.eq_ignore_ascii_case(wanted));
        self.targets.is_empty() || self.targets.iter().any(is_it)
    }
}

impl TrackPath {
    /// Notes the names in a state: those that come later are added.
    fn name(&mut self, track: &SystemTrack) {
        let identity = &track.identity;
        let texts = [
            identity.callsign().map(|callsign| callsign.trim().to_owned()),
            identity.name().map(|name| name.trim().to_owned()),
            identity.address_text().map(|text| text.to_string()),
            identity.mmsi_text().map(|text| text.to_string()),
        ];
        for text in texts.into_iter().flatten().filter(|text| !text.is_empty()) {
            if !self.names.contains(&text) {
                self.names.push(text);
            }
        }
    }

    /// What a person calls the track.
    fn title(&self, number: u32) -> String {
        self.names.first().cloned().unwrap_or_else(|| format!("#{number}"))
    }
}

fn geojson(tracks: &[(&u32, &TrackPath)], out: &mut impl Write) -> std::io::Result<()> {
    writeln!(out, "{{\"type\":\"FeatureCollection\",\"features\":[")?;
    for (place, (number, path)) in tracks.iter().enumerate() {
        let coordinates = |point: &PathPoint| match point.height_m {
            Some(height_m) => json!([
                rounded(point.longitude_deg),
                rounded(point.latitude_deg),
                height_m.round()
            ]),
            None => json!([rounded(point.longitude_deg), rounded(point.latitude_deg)]),
        };
        let lines: Vec<Vec<Value>> = path
            .segments
            .iter()
            .map(|segment| segment.iter().map(coordinates).collect())
            .collect();
        let times: Vec<Vec<String>> = path
            .segments
            .iter()
            .map(|segment| segment.iter().map(|point| utc_text(point.time_ns)).collect())
            .collect();
        let feature = json!({
            "type": "Feature",
            "properties": {"track": number, "name": path.title(**number), "names": path.names, "times": times},
            "geometry": {"type": "MultiLineString", "coordinates": lines},
        });
        let comma = if place + 1 < tracks.len() { "," } else { "" };
        writeln!(out, "{feature}{comma}")?;
    }
    writeln!(out, "]}}")
}

/// Time as in 2026-05-01T10:00:00.000Z.
fn utc_text(time_ns: i64) -> String {
    let at = Timestamp::from_nanosecond(i128::from(time_ns)).unwrap_or(Timestamp::UNIX_EPOCH);
    at.strftime("%Y-%m-%dT%H:%M:%S%.3fZ").to_string()
}

/// Degrees to a centimetre.
fn rounded(degrees: f64) -> f64 {
    (degrees * 1e7).round() / 1e7
}

fn kml(tracks: &[(&u32, &TrackPath)], out: &mut impl Write) -> std::io::Result<()> {
    writeln!(
        out,
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\" \
         xmlns:gx=\"http://www.google.com/kml/ext/2.2\">\n<Document>"
    )?;
    for (number, path) in tracks {
        writeln!(
            out,
            "<Placemark><name>{}</name><gx:MultiTrack>",
            escape(path.title(**number))
        )?;
        for segment in &path.segments {
            let mode = if segment.iter().all(|point| point.height_m.is_some()) {
                "absolute"
            } else {
                "clampToGround"
            };
            writeln!(out, "<gx:Track><altitudeMode>{mode}</altitudeMode>")?;
            for point in segment {
                writeln!(out, "<when>{}</when>", utc_text(point.time_ns))?;
            }
            for point in segment {
                let height_m = point.height_m.unwrap_or_default();
                writeln!(
                    out,
                    "<gx:coord>{:.7} {:.7} {height_m:.0}</gx:coord>",
                    point.longitude_deg, point.latitude_deg
                )?;
            }
            writeln!(out, "</gx:Track>")?;
        }
        writeln!(out, "</gx:MultiTrack></Placemark>")?;
    }
    writeln!(out, "</Document>\n</kml>")
}

fn gpx(tracks: &[(&u32, &TrackPath)], out: &mut impl Write) -> std::io::Result<()> {
    writeln!(
        out,
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<gpx version=\"1.1\" creator=\"koseki\" \
         xmlns=\"http://www.topografix.com/GPX/1/1\">"
    )?;
    for (number, path) in tracks {
        writeln!(
            out,
            "<trk><name>{}</name><number>{number}</number>",
            escape(path.title(**number))
        )?;
        for segment in &path.segments {
            writeln!(out, "<trkseg>")?;
            for point in segment {
                write!(
                    out,
                    "<trkpt lat=\"{:.7}\" lon=\"{:.7}\">",
                    point.latitude_deg, point.longitude_deg
                )?;
                if let Some(height_m) = point.height_m {
                    write!(out, "<ele>{height_m:.0}</ele>")?;
                }
                writeln!(out, "<time>{}</time></trkpt>", utc_text(point.time_ns))?;
            }
            writeln!(out, "</trkseg>")?;
        }
        writeln!(out, "</trk>")?;
    }
    writeln!(out, "</gpx>")
}

#[cfg(test)]
mod tests {
    use frames::Geodetic;
    use messages::Identity;

    use super::*;

    const S: i64 = 1_000_000_000;

    fn state(number: u32, second: i64, east_m: f64) -> SystemTrack {
        SystemTrack {
            track_number: number,
            reference_time_ns: 1_717_664_319 * S + second * S,
            position_m: [east_m, 0.0, 0.0],
            state: TrackState::Confirmed.code(),
            identity: Identity::default().with_callsign(*b"A<B     "),
            ..SystemTrack::default()
        }
    }

    fn text(selection: PathSelection, form: PathForm) -> String {
        let frame = SystemFrame::at(Geodetic::from_degrees(50.0, 8.0, 0.0).unwrap());
        let mut paths = Paths::new(frame, selection);
        // A state twice a second, then a silence of two minutes.
        for half in 0..6 {
            paths.add(&SystemTrack {
                reference_time_ns: state(7, 0, 0.0).reference_time_ns + half * S / 2,
                ..state(7, 0, half as f64)
            });
        }
        paths.add(&state(7, 120, 200.0));
        paths.add(&state(8, 0, 90_000.0));
        let tentative = SystemTrack {
            state: TrackState::Tentative.code(),
            ..state(9, 0, 0.0)
        };
        paths.add(&tentative);
        let mut out = Vec::new();
        paths.write(form, &mut out).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn a_path_is_thinned_and_divided_by_silence() {
        let all: Value = serde_json::from_str(&text(PathSelection::default(), PathForm::GeoJson)).unwrap();
        let features = all["features"].as_array().unwrap();
        assert_eq!(features.len(), 2, "no path of a tentative track");
        let lines = features[0]["geometry"]["coordinates"].as_array().unwrap();
        let points: Vec<usize> = lines.iter().map(|line| line.as_array().unwrap().len()).collect();
        assert_eq!(points, [3, 1]);
        assert_eq!(features[0]["properties"]["times"][0][0], "2024-06-06T08:58:39.000Z");
        assert_eq!(
            (&features[0]["properties"]["name"], &lines[0][0][1]),
            (&"A<B".into(), &50.0.into())
        );
    }

    #[test]
    fn names_are_escaped_and_heights_left_out_where_unknown() {
        let [kml, gpx] = [PathForm::Kml, PathForm::Gpx].map(|form| text(PathSelection::default(), form));
        assert!(
            kml.contains("<name>A&lt;B</name>") && kml.matches("<when>").count() == 5,
            "{kml}"
        );
        assert!(
            gpx.contains("<name>A&lt;B</name>") && gpx.matches("<trkpt").count() == 5,
            "{gpx}"
        );
        assert!(!gpx.contains("<ele>") && gpx.matches("<trkseg>").count() == 3, "{gpx}");
    }

    #[test]
    fn a_selection_takes_times_area_and_targets() {
        let count = |selection| text(selection, PathForm::Gpx).matches("<trkpt").count();
        let later = PathSelection {
            from_ns: Some(1_717_664_319 * S + 100 * S),
            ..PathSelection::default()
        };
        assert_eq!(count(later), 1);
        let near = PathSelection {
            area_deg: Some([7.9, 49.9, 8.1, 50.1]),
            ..PathSelection::default()
        };
        assert_eq!(count(near), 4);
        let across = PathSelection {
            area_deg: Some([9.0, 49.0, 7.0, 51.0]),
            ..PathSelection::default()
        };
        assert_eq!(count(across), 1, "an area that spans the date line");
        let of = |target: &str| PathSelection {
            targets: vec![target.to_owned()],
            ..PathSelection::default()
        };
        assert_eq!((count(of("8")), count(of("a<b")), count(of("none"))), (1, 5, 0));
    }
}
