//! Samples as lines of text, by their layout: fields by name, for any type.

use std::io::Write as _;

use messages::layout::{ALL, Layout, SampleField};

/// Form of a line.
#[derive(Clone, Copy, Debug)]
pub(super) enum LineFormat {
    /// A JSON object.
    Json,
    /// Values between commas; the first line names them.
    Csv,
}

/// Writes samples of one layout.
pub(super) struct LineWriter {
    layout: &'static Layout,
    format: LineFormat,
}

impl LineWriter {
    pub(super) fn new(layout: &'static Layout, format: LineFormat) -> Self {
        Self { layout, format }
    }

    /// Head before the lines.
    pub(super) fn head(&self) -> Vec<u8> {
        match self.format {
            LineFormat::Json => Vec::new(),
            LineFormat::Csv => {
                let mut names = Vec::new();
                columns(self.layout, "", &mut |name, _, _| names.push(name), None);
                (names.join(",") + "\n").into_bytes()
            }
        }
    }

    /// Appends the line of a sample.
    pub(super) fn write(&self, sample: &[u8], text: &mut Vec<u8>) {
        match self.format {
            LineFormat::Json => object(self.layout, sample, text),
            LineFormat::Csv => {
                let start = text.len();
                let mut value = |_, kind: &str, octets: &[u8]| {
                    if text.len() > start {
                        text.push(b',');
                    }
                    match kind {
                        "text" => csv_text(octets, text),
                        _ => number(kind, octets, "", text),
                    }
                };
                columns(self.layout, "", &mut value, Some(sample));
            }
        }
        text.push(b'\n');
    }
}

fn layout_of(element: &str) -> Option<&'static Layout> {
    ALL.iter().find(|layout| layout.name == element)
}

/// Returns the fields with content.
fn fields(layout: &Layout) -> impl Iterator<Item = &'static SampleField> + use<> {
    let is_spare = |field: &&SampleField| field.name == "spare" || field.name.starts_with("reserved");
    layout.fields.iter().filter(move |field| !is_spare(field))
}

/// Returns the characters of a byte field without padding.
fn characters(octets: &[u8]) -> String {
    String::from_utf8_lossy(octets).trim_end_matches(['\0', ' ']).to_owned()
}

/// Visits each column with its name, kind and bytes (empty where there is no sample).
fn columns(layout: &Layout, prefix: &str, visit: &mut impl FnMut(String, &str, &[u8]), sample: Option<&[u8]>) {
    for field in fields(layout) {
        let octets = sample.map_or(&[][..], |sample| &sample[field.offset..field.offset + field.size]);
        let name = format!("{prefix}{}", field.name);
        match (field.element(), layout_of(field.element().0)) {
            ((_, None), Some(inner)) => columns(inner, &format!("{name}."), visit, sample.map(|_| octets)),
            // Lists of samples have no place in a table.
            ((_, Some(_)), Some(_)) => {}
            (("u8", Some(_)), None) => visit(name, "text", octets),
            ((kind, Some(count)), None) => {
                for index in 0..count {
                    let size = field.size / count;
                    let one = if octets.is_empty() {
                        octets
                    } else {
                        &octets[index * size..(index + 1) * size]
                    };
                    visit(format!("{name}_{index}"), kind, one);
                }
            }
            ((kind, None), None) => visit(name, kind, octets),
        }
    }
}

fn object(layout: &Layout, sample: &[u8], text: &mut Vec<u8>) {
    let mut separator = b'{';
    for field in fields(layout) {
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
                    value(kind, one, text);
                }
                text.push(b']');
            }
            (kind, None) => value(kind, octets, text),
        }
    }
    text.push(b'}');
}

fn value(kind: &str, octets: &[u8], text: &mut Vec<u8>) {
    match layout_of(kind) {
        Some(layout) => object(layout, octets, text),
        None => number(kind, octets, "null", text),
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
    use messages::layout::Sample as _;
    use messages::{Contribution, SystemTrack};

    use super::*;

    fn line(format: LineFormat, track: SystemTrack) -> String {
        let mut text = Vec::new();
        LineWriter::new(&SystemTrack::LAYOUT, format).write(SystemTrack::octets(&[track]), &mut text);
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
        let json: serde_json::Value = serde_json::from_str(&line(LineFormat::Json, track())).unwrap();
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

    #[test]
    fn every_csv_line_has_the_columns_of_the_head() {
        let lines = LineWriter::new(&SystemTrack::LAYOUT, LineFormat::Csv);
        let table = [lines.head(), line(LineFormat::Csv, track()).into_bytes()].concat();
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
