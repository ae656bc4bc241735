//! Samples as lines of text, by their layout: fields by name, for any type.

use std::io::Write as _;

use messages::layout::{ALL, Layout, Sample, SampleField};
use messages::{
    Identity, IdentityText, PlatformState, SensorTrack, SystemTrack, platform_state_bits, sensor_track_bits,
};

use crate::names::{SampleNames, Word};

/// Form of a line.
#[derive(Clone, Copy, Debug)]
pub enum LineFormat {
    /// A JSON object.
    Json,
    /// Values between commas; the first line names them.
    Csv,
}

/// Columns of a position on the earth; the flight level of system tracks is that of the transponder.
pub(crate) const PLACES: [&str; 4] = ["latitude", "longitude", "height_m", "flight_level"];

/// Writes samples of one layout.
#[derive(Debug)]
pub struct LineWriter {
    layout: &'static Layout,
    format: LineFormat,
    /// Words for codes, bits and sources; `None`: all numbers stay numbers.
    names: Option<SampleNames>,
}

impl LineWriter {
    /// Returns a writer of samples with this layout; without `names`, all numbers stay numbers.
    pub fn new(layout: &'static Layout, format: LineFormat, names: Option<SampleNames>) -> Self {
        Self { layout, format, names }
    }

    /// Latitude, longitude, height and flight level of a sample that has a position, where the frame is known; all are
    /// unknown if the sample's position is unknown.
    fn place(&self, sample: &[u8]) -> Option<[f64; 4]> {
        let field = self.layout.fields.iter().find(|field| field.name == "position_m")?;
        let mut octets = sample.get(field.offset..field.offset + field.size)?.chunks_exact(8);
        let mut next = || octets.next()?.try_into().map(f64::from_le_bytes).ok();
        let [latitude, longitude, height_m] = self.names.as_ref()?.place([next()?, next()?, next()?]);
        let is_platform = self.layout.name == PlatformState::LAYOUT.name;
        let state = Some(sample).filter(|_| is_platform).and_then(PlatformState::of_octets);
        if state.is_some_and(|state| state.valid & platform_state_bits::NO_POSITION != 0) {
            return Some([f64::NAN; 4]);
        }
        let track = self
            .sample_of::<SystemTrack>(sample)
            .filter(|track| track.level_valid != 0);
        let level = track.map_or(f64::NAN, |track| f64::from(track.level) / 4.0);
        let height_m = if self.has_height(sample) { height_m } else { f64::NAN };
        Some([latitude, longitude, height_m, level])
    }

    fn sample_of<T: Sample>(&self, sample: &[u8]) -> Option<T> {
        let is_meant = self.layout.name == T::LAYOUT.name;
        Some(sample).filter(|_| is_meant).and_then(T::of_octets)
    }

    /// Whether the height of a sample's position is known.
    fn has_height(&self, sample: &[u8]) -> bool {
        let of_system = self
            .sample_of::<SystemTrack>(sample)
            .map(|track| track.height_valid != 0);
        let of_sensor = || {
            let track = self.sample_of::<SensorTrack>(sample);
            track.map(|track| track.has(sensor_track_bits::HEIGHT))
        };
        of_system.or_else(of_sensor).unwrap_or(true)
    }

    /// Whether the components of a sample's velocity are known.
    fn has_velocity(&self, sample: &[u8]) -> [bool; 3] {
        if let Some(track) = self.sample_of::<SystemTrack>(sample) {
            let (plane, height) = (track.velocity_valid != 0, track.height_valid != 0);
            return [plane, plane, height && track.covariance.knows_climb()];
        }
        let track = self.sample_of::<SensorTrack>(sample);
        track.map_or([true; 3], |track| {
            // A source that gives its trace alone states no variance of its velocity.
            let states =
                |component: usize, bit: u16| track.has(bit) && (track.gives_trace() || track.states(component));
            [
                states(3, sensor_track_bits::VELOCITY),
                states(4, sensor_track_bits::VELOCITY),
                states(5, sensor_track_bits::VERTICAL_RATE),
            ]
        })
    }

    /// Returns the sample with NaN in place of the height, the velocity and the rate of climb that are not known.
    pub(crate) fn without_unknown(&self, sample: &[u8]) -> Vec<u8> {
        let mut shown = sample.to_vec();
        let mut blank = |name: &str, known: &[bool]| {
            let Some(field) = self.layout.fields.iter().find(|field| field.name == name) else {
                return;
            };
            let components = shown[field.offset..field.offset + field.size].chunks_exact_mut(8);
            for (component, _) in components.zip(known).filter(|(_, is_known)| !**is_known) {
                component.copy_from_slice(&f64::NAN.to_le_bytes());
            }
        };
        blank("position_m", &[true, true, self.has_height(sample)]);
        blank("velocity_mps", &self.has_velocity(sample));
        let climb = self.layout.fields.iter().find(|field| field.name == "climb_rate_mps");
        let is_unknown = |track: &SystemTrack| track.climb_rate_variance == 0.0;
        if let (Some(field), true) = (climb, self.sample_of(sample).as_ref().is_some_and(is_unknown)) {
            shown[field.offset..field.offset + field.size].copy_from_slice(&f32::NAN.to_le_bytes());
        }
        shown
    }

    /// Whether samples are written with their places.
    fn has_place(&self) -> bool {
        self.place(&vec![0; self.layout.size]).is_some()
    }

    /// Returns the head before the lines: the columns of CSV.
    pub fn head(&self) -> Vec<u8> {
        match self.format {
            LineFormat::Json => Vec::new(),
            LineFormat::Csv => {
                let mut names = Vec::new();
                columns(self.layout, "", &mut |name, _, _| names.push(name), None);
                if self.has_place() {
                    names.extend(PLACES.map(str::to_owned));
                }
                (names.join(",") + "\n").into_bytes()
            }
        }
    }

    /// Appends the line of a sample, given as the bytes of its layout. What is not known of a track's height and motion
    /// is no number, unless all numbers stay as they are.
    pub fn write(&self, sample: &[u8], text: &mut Vec<u8>) {
        match self.names {
            Some(_) => self.write_all(&self.without_unknown(sample), text),
            None => self.write_all(sample, text),
        }
    }

    fn write_all(&self, sample: &[u8], text: &mut Vec<u8>) {
        match self.format {
            LineFormat::Json => {
                self.object(self.layout, sample, text);
                if let Some(place) = self.place(sample) {
                    // Before the closing brace.
                    text.pop();
                    for (name, value) in PLACES.into_iter().zip(place) {
                        let _ = write!(text, ",\"{name}\":");
                        number("f64", &value.to_le_bytes(), "null", text);
                    }
                    text.push(b'}');
                }
            }
            LineFormat::Csv => {
                let mut is_first = true;
                let mut value = |_, (sample, field, kind): (_, _, &str), octets: &[u8]| {
                    if !std::mem::take(&mut is_first) {
                        text.push(b',');
                    }
                    if let Some(spelling) = spelling(sample, kind) {
                        if let Some(spelled) = spelled(spelling, octets) {
                            let _ = write!(text, "{spelled}");
                        }
                        return;
                    }
                    match (kind, self.word((sample, field, kind), octets)) {
                        ("text", _) => csv_text(octets, text),
                        (_, Some(Word::One(word))) => text.extend_from_slice(word.as_bytes()),
                        (_, Some(Word::Bits(set))) => text.extend_from_slice(set.join("|").as_bytes()),
                        (_, Some(Word::Nothing)) => {}
                        _ => number(kind, octets, "", text),
                    }
                };
                columns(self.layout, "", &mut value, Some(sample));
                for value in self.place(sample).into_iter().flatten() {
                    text.push(b',');
                    number("f64", &value.to_le_bytes(), "", text);
                }
            }
        }
        text.push(b'\n');
    }

    fn word(&self, (sample, field, kind): (&'static str, &'static str, &str), octets: &[u8]) -> Option<Word<'_>> {
        let value = unsigned(kind, octets)?;
        self.names.as_ref()?.word(sample, field, value)
    }

    fn object(&self, layout: &'static Layout, sample: &[u8], text: &mut Vec<u8>) {
        let mut separator = b'{';
        for field in fields(layout) {
            for spelling in spellings(layout, field) {
                text.push(separator);
                separator = b',';
                let _ = match spelled(spelling, sample) {
                    Some(spelled) => write!(text, "\"{}\":\"{spelled}\"", spelling.key),
                    None => write!(text, "\"{}\":null", spelling.key),
                };
            }
            if is_spelled(layout, field) {
                continue;
            }
            text.push(separator);
            separator = b',';
            let _ = write!(text, "\"{}\":", field.name);
            let octets = &sample[field.offset..field.offset + field.size];
            match field.element() {
                ("u8", Some(_)) => {
                    // A text can always be written.
                    let _ = serde_json::to_writer(&mut *text, &characters(octets));
                }
                (kind, Some(count)) => {
                    let all = octets.chunks(field.size / count);
                    // Elements behind the last used element have no content.
                    let held = match layout_of(kind) {
                        Some(_) => all
                            .clone()
                            .rposition(|one| one.iter().any(|octet| *octet != 0))
                            .map_or(0, |last| last + 1),
                        None => count,
                    };
                    text.push(b'[');
                    for (index, one) in all.take(held).enumerate() {
                        if index > 0 {
                            text.push(b',');
                        }
                        self.value((layout.name, field.name, kind), one, text);
                    }
                    text.push(b']');
                }
                (kind, None) => self.value((layout.name, field.name, kind), octets, text),
            }
        }
        text.push(b'}');
    }

    fn value(&self, field: (&'static str, &'static str, &'static str), octets: &[u8], text: &mut Vec<u8>) {
        if let Some(layout) = layout_of(field.2) {
            return self.object(layout, octets, text);
        }
        match self.word(field, octets) {
            // A text can always be written.
            Some(Word::One(word)) => _ = serde_json::to_writer(&mut *text, word),
            Some(Word::Bits(set)) if set.is_empty() => text.extend_from_slice(b"[]"),
            Some(Word::Bits(set)) => _ = write!(text, "[\"{}\"]", set.join("\",\"")),
            Some(Word::Nothing) => text.extend_from_slice(b"null"),
            None => number(field.2, octets, "null", text),
        }
    }
}

pub(crate) fn layout_of(element: &str) -> Option<&'static Layout> {
    ALL.iter().find(|layout| layout.name == element)
}

/// Returns the fields with content.
pub(crate) fn fields(layout: &Layout) -> impl Iterator<Item = &'static SampleField> + use<> {
    let is_spare = |field: &&SampleField| field.name == "spare" || field.name.starts_with("reserved");
    layout.fields.iter().filter(move |field| !is_spare(field))
}

/// Returns what text has in place of a number of an identity: keys of their own for the numbers of aircraft and of
/// ships, in the digits that people write. None for every other field.
pub(crate) fn spellings(layout: &Layout, field: &SampleField) -> impl Iterator<Item = &'static IdentityText> + use<> {
    const OF_NUMBER: &[IdentityText] = &[IdentityText::ADDRESS, IdentityText::MMSI];
    const OF_CODE: &[IdentityText] = &[IdentityText::MODE_3A];
    let found = match field.name {
        "address" if layout.name == Identity::LAYOUT.name => OF_NUMBER,
        "mode_3a" if layout.name == Identity::LAYOUT.name => OF_CODE,
        _ => &[],
    };
    found.iter()
}

pub(crate) fn is_spelled(layout: &Layout, field: &SampleField) -> bool {
    spellings(layout, field).next().is_some()
}

/// Returns a number of an identity, given as the bytes of its layout, in its digits; `None` if it is not known.
fn spelled(spelling: &IdentityText, identity: &[u8]) -> Option<messages::Spelled> {
    spelling.of(&Identity::of_octets(identity)?)
}

/// Returns the spelling of a column of CSV, of which [`columns`] gives the key as the kind.
fn spelling(sample: &str, kind: &str) -> Option<&'static IdentityText> {
    const ALL: &[IdentityText] = &IdentityText::ALL;
    let is_meant = |text: &&IdentityText| sample == Identity::LAYOUT.name && text.key == kind;
    ALL.iter().find(is_meant)
}

/// Returns the characters of a byte field without padding.
fn characters(octets: &[u8]) -> String {
    String::from_utf8_lossy(octets).trim_end_matches(['\0', ' ']).to_owned()
}

/// Visits each column with its name, the sample, the field and the kind of its value, and its bytes (empty where there
/// is no sample). A number of an identity has its key as the kind, and the bytes of the whole identity.
fn columns(
    layout: &'static Layout,
    prefix: &str,
    visit: &mut impl FnMut(String, (&'static str, &'static str, &'static str), &[u8]),
    sample: Option<&[u8]>,
) {
    for field in fields(layout) {
        let octets = sample.map_or(&[][..], |sample| &sample[field.offset..field.offset + field.size]);
        for spelling in spellings(layout, field) {
            let name = format!("{prefix}{}", spelling.key);
            visit(
                name,
                (layout.name, field.name, spelling.key),
                sample.unwrap_or_default(),
            );
        }
        if is_spelled(layout, field) {
            continue;
        }
        let name = format!("{prefix}{}", field.name);
        match (field.element(), layout_of(field.element().0)) {
            ((_, None), Some(inner)) => columns(inner, &format!("{name}."), visit, sample.map(|_| octets)),
            // Lists of samples have no place in a table.
            ((_, Some(_)), Some(_)) => {}
            (("u8", Some(_)), None) => visit(name, (layout.name, field.name, "text"), octets),
            ((kind, Some(count)), None) => {
                for index in 0..count {
                    let size = field.size / count;
                    let one = if octets.is_empty() {
                        octets
                    } else {
                        &octets[index * size..(index + 1) * size]
                    };
                    visit(format!("{name}_{index}"), (layout.name, field.name, kind), one);
                }
            }
            ((kind, None), None) => visit(name, (layout.name, field.name, kind), octets),
        }
    }
}

/// Returns an unsigned number: codes and bits are of this kind.
fn unsigned(kind: &str, octets: &[u8]) -> Option<u64> {
    match kind {
        "u8" => octets.first().copied().map(u64::from),
        "u16" => octets.try_into().map(u16::from_le_bytes).ok().map(u64::from),
        "u32" => octets.try_into().map(u32::from_le_bytes).ok().map(u64::from),
        "u64" => octets.try_into().map(u64::from_le_bytes).ok(),
        _ => None,
    }
}

/// Appends a number, or `unknown` for a number that is not finite; the least time also means "unknown".
fn number(kind: &str, octets: &[u8], unknown: &str, text: &mut Vec<u8>) {
    macro_rules! of {
        ($number:ty) => {
            octets.try_into().map(<$number>::from_le_bytes).ok()
        };
    }
    let integer = match kind {
        "u8" => of!(u8).map(i128::from),
        "u16" => of!(u16).map(i128::from),
        "u32" => of!(u32).map(i128::from),
        "u64" => of!(u64).map(i128::from),
        "i8" => of!(i8).map(i128::from),
        "i16" => of!(i16).map(i128::from),
        "i32" => of!(i32).map(i128::from),
        "i64" => of!(i64).filter(|time| *time != i64::MIN).map(i128::from),
        _ => None,
    };
    let real = match kind {
        "f32" => of!(f32).filter(|real| real.is_finite()).map(|real| format!("{real:?}")),
        "f64" => of!(f64).filter(|real| real.is_finite()).map(|real| format!("{real:?}")),
        _ => None,
    };
    let written = integer.map(|integer| integer.to_string()).or(real);
    text.extend_from_slice(written.as_deref().unwrap_or(unknown).as_bytes());
}

fn csv_text(octets: &[u8], text: &mut Vec<u8>) {
    let characters = characters(octets);
    if characters.contains([',', '"', '\n', '\r']) {
        let _ = write!(text, "\"{}\"", characters.replace('"', "\"\""));
    } else {
        text.extend_from_slice(characters.as_bytes());
    }
}

#[cfg(test)]
mod tests {
    use frames::{Geodetic, SystemFrame};
    use messages::{Contribution, Covariance, NO_SOURCE, TrackState, contribution_bits};

    use super::*;

    fn line(format: LineFormat, track: SystemTrack, names: Option<SampleNames>) -> String {
        let mut text = Vec::new();
        LineWriter::new(&SystemTrack::LAYOUT, format, names).write(SystemTrack::octets(&[track]), &mut text);
        String::from_utf8(text).unwrap()
    }

    fn track() -> SystemTrack {
        let mut track = SystemTrack {
            track_number: 7,
            position_m: [1.5, f64::NAN, -1e-300],
            ..SystemTrack::default()
        };
        track.identity.callsign = *b"A\"B,C   ";
        track.contributions[1] = Contribution {
            source: 3,
            ..Contribution::default()
        };
        track
    }

    #[test]
    fn a_json_line_has_every_field_and_unknown_numbers_are_null() {
        let json: serde_json::Value = serde_json::from_str(&line(LineFormat::Json, track(), None)).unwrap();
        assert_eq!(json["track_number"], 7);
        assert_eq!(json["position_m"], serde_json::json!([1.5, null, -1e-300]));
        assert_eq!(json["identity"]["callsign"], "A\"B,C");
        assert_eq!(json["contributions"].as_array().map(Vec::len), Some(2));
        assert_eq!(json["contributions"][1]["source"], 3);
        let is_unused = |name: &str| matches!(name, "spare" | "reserved");
        assert!(
            json.as_object()
                .is_some_and(|fields| !fields.keys().any(|name| is_unused(name)))
        );
        let named = SystemTrack::LAYOUT.fields.iter().filter(|field| !is_unused(field.name));
        assert_eq!(json.as_object().map(serde_json::Map::len), Some(named.count()));
    }

    fn names() -> SampleNames {
        let origin = Geodetic::from_degrees(45.0, 9.0, 0.0).unwrap();
        SampleNames::new(
            ["north", "south", "west", "wam"].map(str::to_owned).to_vec(),
            SystemFrame::at(origin),
        )
    }

    #[test]
    fn codes_bits_and_sources_are_words_and_positions_are_on_the_earth() {
        let mut track = SystemTrack {
            state: TrackState::Confirmed as u8,
            selected_source: NO_SOURCE,
            trigger_source: 9,
            position_m: [0.0, 1000.0, 50.0],
            height_valid: 1,
            level: 1401,
            level_valid: 1,
            ..track()
        };
        track.contributions[1].flags = contribution_bits::CENTRE;
        let json: serde_json::Value = serde_json::from_str(&line(LineFormat::Json, track, Some(names()))).unwrap();
        assert_eq!(json["state"], "confirmed");
        assert_eq!(
            (&json["selected_source"], &json["trigger_source"]),
            (&serde_json::Value::Null, &9.into())
        );
        assert_eq!(json["contributions"][1]["source"], "wam");
        assert_eq!(json["contributions"][1]["flags"], serde_json::json!(["CENTRE"]));
        assert_eq!(json["alerts"], serde_json::json!([]));
        // A kilometre to the north is 1/111.1 of a degree.
        assert!((json["latitude"].as_f64().unwrap() - 45.0 - 1.0 / 111.13).abs() < 1e-4);
        assert!((json["height_m"].as_f64().unwrap() - 50.0).abs() < 0.1);
        assert_eq!(
            (&json["longitude"], &json["flight_level"]),
            (&9.0.into(), &350.25.into())
        );
        let lines = LineWriter::new(&SystemTrack::LAYOUT, LineFormat::Csv, Some(names()));
        let table = [lines.head(), line(LineFormat::Csv, track, Some(names())).into_bytes()].concat();
        let mut reader = csv::Reader::from_reader(&table[..]);
        let head = reader.headers().unwrap().clone();
        let row = reader.records().next().unwrap().unwrap();
        let at = |name: &str| &row[head.iter().position(|column| column == name).unwrap()];
        assert_eq!(
            (at("state"), at("selected_source"), at("flight_level")),
            ("confirmed", "", "350.25")
        );
    }

    #[test]
    fn a_height_and_a_motion_that_are_not_known_are_no_numbers() {
        let known = SystemTrack {
            height_valid: 1,
            velocity_valid: 1,
            climb_rate_variance: 1.0,
            ..SystemTrack::default()
        };
        let unsure = SystemTrack {
            covariance: Covariance::diagonal([1.0; 3], [1.0, 1.0, 20.0]),
            climb_rate_variance: 0.0,
            ..known
        };
        let nulls = |track: SystemTrack| {
            let json: serde_json::Value = serde_json::from_str(&line(LineFormat::Json, track, Some(names()))).unwrap();
            let velocity = &json["velocity_mps"];
            let values = [
                &json["position_m"][2],
                &json["height_m"],
                &velocity[0],
                &velocity[1],
                &velocity[2],
                &json["climb_rate_mps"],
            ];
            values.map(|value| u8::from(value.is_null()))
        };
        assert_eq!(nulls(known), [0; 6]);
        assert_eq!(
            nulls(SystemTrack {
                height_valid: 0,
                ..known
            }),
            [1, 1, 0, 0, 1, 0]
        );
        assert_eq!(
            nulls(SystemTrack {
                velocity_valid: 0,
                ..known
            }),
            [0, 0, 1, 1, 0, 0]
        );
        assert_eq!(nulls(unsure), [0, 0, 0, 0, 1, 1]);
        let raw: serde_json::Value =
            serde_json::from_str(&line(LineFormat::Json, SystemTrack::default(), None)).unwrap();
        assert_eq!(
            raw["velocity_mps"],
            serde_json::json!([0.0, 0.0, 0.0]),
            "all numbers stay"
        );
    }

    #[test]
    fn a_platform_state_without_position_has_no_place() {
        let written = |valid, format| {
            let state = PlatformState {
                valid,
                ..PlatformState::default()
            };
            let lines = LineWriter::new(&PlatformState::LAYOUT, format, Some(names()));
            let mut text = lines.head();
            lines.write(PlatformState::octets(&[state]), &mut text);
            String::from_utf8(text).unwrap()
        };
        let place = |valid| {
            let json: serde_json::Value = serde_json::from_str(&written(valid, LineFormat::Json)).unwrap();
            ["latitude", "longitude", "height_m"].map(|name| json[name].as_f64())
        };
        assert_eq!(place(platform_state_bits::NO_POSITION), [None; 3]);
        let [latitude, longitude, height_m] = place(0).map(Option::unwrap);
        assert!((latitude - 45.0).abs() < 1e-9 && (longitude - 9.0).abs() < 1e-9 && height_m.abs() < 1e-6);
        let table = written(platform_state_bits::NO_POSITION, LineFormat::Csv);
        assert!(table.ends_with(",,,,\n"), "{table}");
        assert!(table.starts_with("time_ns,") && table.contains(",latitude,longitude,height_m,flight_level\n"));
    }

    #[test]
    fn every_documented_code_of_a_field_is_found() {
        let groups = messages::layout::code_groups();
        let layouts = messages::layout::ALL.iter();
        let fields = layouts.flat_map(|layout| layout.fields.iter().map(|field| (layout.name, field)));
        let mut found = 0;
        for (sample, field) in fields {
            let mentions = field.doc.contains("` code") || field.doc.contains("_bits`");
            assert_eq!(
                mentions,
                field.codes(&groups).is_some(),
                "{sample}.{}: {}",
                field.name,
                field.doc
            );
            found += usize::from(mentions);
        }
        assert!(found > 30, "{found}");
    }

    #[test]
    fn every_csv_line_has_the_columns_of_the_head() {
        let lines = LineWriter::new(&SystemTrack::LAYOUT, LineFormat::Csv, None);
        let table = [lines.head(), line(LineFormat::Csv, track(), None).into_bytes()].concat();
        let mut reader = csv::Reader::from_reader(&table[..]);
        let head = reader.headers().unwrap().clone();
        let row = reader.records().next().unwrap().unwrap();
        let at = |name: &str| &row[head.iter().position(|column| column == name).unwrap()];
        assert_eq!(
            (at("track_number"), at("position_m_0"), at("position_m_1")),
            ("7", "1.5", "")
        );
        assert_eq!(at("identity.callsign"), "A\"B,C");
    }
}
