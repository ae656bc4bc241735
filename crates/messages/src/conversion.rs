//! Conversion of recorded samples to the layouts of this build.
//!
//! A recording holds the schema of its samples ([`Layout::ros2_schema`]). A layout revision adds, moves and removes
//! fields; the remaining fields keep name and type. A conversion therefore copies each field of the recorded layout to
//! the field of the same name and type. Fields that the recorded layout lacks are 0, the value for "unknown", and are
//! listed by [`Conversion::missing`]. One is derived: whether the velocity of a system track is known, which its
//! covariance shows.
//!
//! The schema comes from a file and may be damaged: sizes, depth and number of fields are bounded.

use std::collections::BTreeMap;
use std::ops::Range;

use crate::SystemTrack;
use crate::layout::{ALL, Layout, Sample as _, SampleField};

/// Maximum size of a recorded sample, bytes.
const SIZE_MAX: usize = 1 << 16;
/// Maximum number of number fields in a recorded sample, fields of contained samples included.
const FIELDS_MAX: usize = 1 << 12;
/// Maximum depth of contained samples.
const DEPTH_MAX: usize = 4;
/// Prefix of the names of samples in schemas.
const PACKAGE: &str = "koseki/";

/// Conversion of samples of one recorded layout to the layout of the same name in this build.
#[derive(Clone, Debug, PartialEq)]
pub struct Conversion {
    recorded_size: usize,
    size: usize,
    copies: Vec<ByteCopy>,
    missing: Vec<Range<usize>>,
    /// Place of `velocity_valid` of a system track whose recorded layout lacks it.
    velocity_valid: Option<usize>,
}

/// Bytes that a conversion copies: offsets in the recorded and in the present sample, and their number.
#[derive(Clone, Copy, Debug, PartialEq)]
struct ByteCopy {
    from: usize,
    to: usize,
    bytes: usize,
}

/// Place of one field of numbers in a recorded sample.
#[derive(Clone, Debug, PartialEq)]
struct NumberField {
    kind: String,
    offset: usize,
    size: usize,
}

impl Conversion {
    /// Returns the conversion from a recorded schema to the layout of sample `name` in this build; `None` if the build
    /// has no such sample, or if the schema is damaged.
    pub fn of_schema(name: &str, schema: &str) -> Option<Self> {
        let name = name.strip_prefix(PACKAGE).unwrap_or(name);
        let layout = ALL.iter().find(|layout| layout.name == name)?;
        let mut recorded = BTreeMap::new();
        let recorded_size = Definitions::of(schema).places("", "", 0, 0, &mut recorded)?;
        let mut conversion = Self {
            recorded_size,
            size: layout.size,
            copies: Vec::new(),
            missing: Vec::new(),
            velocity_valid: None,
        };
        conversion.visit(layout, "", 0, &recorded);
        let place = std::mem::offset_of!(SystemTrack, velocity_valid);
        let lacks = conversion.missing.iter().any(|range| range.contains(&place));
        conversion.velocity_valid = (layout.name == SystemTrack::LAYOUT.name && lacks).then_some(place);
        Some(conversion)
    }

    /// Byte ranges of the converted sample that the recorded layout lacks, rising.
    pub fn missing(&self) -> &[Range<usize>] {
        &self.missing
    }

    /// Replaces the contents of `converted` by the converted sample. Returns `false`, with `converted` empty, if
    /// `recorded` has another size than the schema states.
    pub fn convert(&self, recorded: &[u8], converted: &mut Vec<u8>) -> bool {
        converted.clear();
        if recorded.len() != self.recorded_size {
            return false;
        }
        converted.resize(self.size, 0);
        for copy in &self.copies {
            let from = &recorded[copy.from..copy.from + copy.bytes];
            converted[copy.to..copy.to + copy.bytes].copy_from_slice(from);
        }
        if let Some(place) = self.velocity_valid
            && let Some(track) = SystemTrack::of_octets(converted)
        {
            converted[place] = u8::from(track.covariance.knows_velocity());
        }
        true
    }

    fn visit(&mut self, layout: &Layout, path: &str, base: usize, recorded: &BTreeMap<String, NumberField>) {
        for field in layout.fields {
            let (kind, count) = field.element();
            let path = format!("{path}{}", field.name);
            let offset = base + field.offset;
            match ALL.iter().find(|part| part.name == kind) {
                Some(part) => {
                    for index in 0..count.unwrap_or(1) {
                        let path = element_path(&path, count.map(|_| index));
                        self.visit(part, &format!("{path}."), offset + index * part.size, recorded);
                    }
                }
                None => self.number(field, &path, offset, recorded.get(&path)),
            }
        }
    }

    fn number(&mut self, field: &SampleField, path: &str, offset: usize, place: Option<&NumberField>) {
        let (kind, _) = field.element();
        let known = place.filter(|place| place.kind == kind);
        let bytes = known.map_or(0, |place| place.size.min(field.size));
        if let Some(place) = known {
            match self.copies.last_mut() {
                Some(last) if last.from + last.bytes == place.offset && last.to + last.bytes == offset => {
                    last.bytes += bytes;
                }
                _ => self.copies.push(ByteCopy {
                    from: place.offset,
                    to: offset,
                    bytes,
                }),
            }
        }
        // Reserved fields are 0 in every layout.
        if bytes < field.size && !is_reserved(path) {
            let missing = offset + bytes..offset + field.size;
            match self.missing.last_mut() {
                Some(last) if last.end == missing.start => last.end = missing.end,
                _ => self.missing.push(missing),
            }
        }
    }
}

fn is_reserved(path: &str) -> bool {
    let name = path.rsplit('.').next().unwrap_or(path);
    name == "spare" || name.starts_with("reserved")
}

fn element_path(path: &str, index: Option<usize>) -> String {
    index.map_or_else(|| path.to_owned(), |index| format!("{path}[{index}]"))
}

/// Field lines of a recorded schema by sample; the recorded sample itself has an empty name.
struct Definitions<'a>(BTreeMap<&'a str, Vec<&'a str>>);

impl<'a> Definitions<'a> {
    fn of(schema: &'a str) -> Self {
        let mut definitions: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        let mut name = "";
        for line in schema.lines() {
            match line.strip_prefix("MSG: ") {
                Some(next) => name = next.trim(),
                None if line.starts_with('=') => {}
                None => definitions.entry(name).or_default().push(line),
            }
        }
        Self(definitions)
    }

    /// Adds the places of the number fields of sample `name`, which begins at byte `start`. Returns the sample's end;
    /// `None` if the schema is damaged. Samples have no padding apart from fields.
    fn places(
        &self,
        name: &str,
        path: &str,
        start: usize,
        depth: usize,
        places: &mut BTreeMap<String, NumberField>,
    ) -> Option<usize> {
        let mut end = start;
        for line in self.0.get(name).filter(|_| depth < DEPTH_MAX)? {
            let mut words = line.split('#').next()?.split_whitespace();
            let (kind, field) = match (words.next(), words.next()) {
                (Some(kind), Some(field)) => (kind, field),
                (None, _) => continue,
                _ => return None,
            };
            let (kind, count) = match kind.split_once('[') {
                Some((kind, count)) => (kind, Some(count.strip_suffix(']')?.parse::<usize>().ok()?)),
                None => (kind, None),
            };
            let path = format!("{path}{field}");
            match number_type(kind) {
                Some((kind, size)) => {
                    let size = size.checked_mul(count.unwrap_or(1))?;
                    let place = NumberField {
                        kind,
                        offset: end,
                        size,
                    };
                    places.insert(path, place);
                    end = end.checked_add(size)?;
                }
                None => {
                    for index in 0..count.unwrap_or(1) {
                        let path = element_path(&path, count.map(|_| index));
                        end = self.places(kind, &format!("{path}."), end, depth + 1, places)?;
                    }
                }
            }
            if end > SIZE_MAX || places.len() > FIELDS_MAX {
                return None;
            }
        }
        Some(end)
    }
}

/// Rust type and size in bytes of a number type of ROS 2; `None` for other types.
fn number_type(kind: &str) -> Option<(String, usize)> {
    let (letter, bits) = [("uint", "u"), ("int", "i"), ("float", "f")]
        .into_iter()
        .find_map(|(prefix, letter)| kind.strip_prefix(prefix).map(|bits| (letter, bits)))?;
    let bits: usize = bits.parse().ok().filter(|bits| matches!(bits, 8 | 16 | 32 | 64))?;
    Some((format!("{letter}{bits}"), bits / 8))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Covariance, PlatformState};

    #[test]
    fn a_present_layout_converts_to_itself() {
        for layout in ALL {
            let conversion = Conversion::of_schema(layout.name, &layout.ros2_schema()).unwrap();
            assert_eq!((conversion.recorded_size, conversion.missing()), (layout.size, &[][..]));
            let bytes: Vec<u8> = (0..layout.size).map(|byte| byte as u8).collect();
            let mut converted = Vec::new();
            assert!(conversion.convert(&bytes, &mut converted));
            assert_eq!(converted, bytes, "{}", layout.name);
        }
    }

    #[test]
    fn moved_fields_keep_their_values_and_new_fields_are_missing() {
        // Layout of a former build: another order, without standard deviations, with a field that has gone.
        let schema = "float64[3] velocity_mps # Velocity.\nint64 time_ns # Time.\nfloat32 draught_m # Gone.\n\
                      uint32 valid # Another type.\n";
        let conversion = Conversion::of_schema("koseki/PlatformState", schema).unwrap();
        let mut recorded = Vec::new();
        for value in [1.5f64, -2.5, 3.5] {
            recorded.extend(value.to_le_bytes());
        }
        recorded.extend(77i64.to_le_bytes());
        recorded.extend([0xff; 8]);
        let mut converted = Vec::new();
        assert!(conversion.convert(&recorded, &mut converted));
        let state = PlatformState::of_octets(&converted).unwrap();
        let expected = PlatformState {
            time_ns: 77,
            velocity_mps: [1.5, -2.5, 3.5],
            ..PlatformState::default()
        };
        assert_eq!(state, expected);
        let is_missing = |offset: usize| conversion.missing().iter().any(|range| range.contains(&offset));
        assert!(!is_missing(std::mem::offset_of!(PlatformState, velocity_mps)));
        assert!(is_missing(std::mem::offset_of!(PlatformState, heading_rad)));
        assert!(is_missing(std::mem::offset_of!(PlatformState, valid)));
        assert!(!conversion.convert(&recorded[1..], &mut converted));
    }

    #[test]
    fn a_recorded_covariance_shows_whether_the_velocity_is_known() {
        let schema = SystemTrack::LAYOUT.ros2_schema().replace("velocity_valid", "reserved");
        let conversion = Conversion::of_schema("SystemTrack", &schema).unwrap();
        for (sigma_mps, expected) in [(3.0, 1), (100.0, 0)] {
            let track = SystemTrack {
                covariance: Covariance::diagonal([10.0; 3], [sigma_mps; 3]),
                ..SystemTrack::default()
            };
            let mut converted = Vec::new();
            assert!(conversion.convert(SystemTrack::octets(&[track]), &mut converted));
            assert_eq!(SystemTrack::of_octets(&converted).unwrap().velocity_valid, expected);
        }
    }

    #[test]
    fn contained_samples_are_converted_by_their_own_fields() {
        let schema = format!(
            "uint32 track_number # Number.\nkoseki/Contribution[2] contributions # Shares.\n{}\nMSG: \
             koseki/Contribution\nuint16 source # Source.\nfloat64 weight # Weight.\n",
            "=".repeat(80)
        );
        let conversion = Conversion::of_schema("SystemTrack", &schema).unwrap();
        let mut recorded = 9u32.to_le_bytes().to_vec();
        for (source, weight) in [(3u16, 0.25f64), (4, 0.75)] {
            recorded.extend(source.to_le_bytes());
            recorded.extend(weight.to_le_bytes());
        }
        let mut converted = Vec::new();
        assert!(conversion.convert(&recorded, &mut converted));
        let track = SystemTrack::of_octets(&converted).unwrap();
        let shares = track.contributions.map(|share| (share.source, share.weight));
        assert_eq!(
            (track.track_number, &shares[..3]),
            (9, &[(3, 0.25), (4, 0.75), (0, 0.0)][..])
        );
    }

    #[test]
    fn damaged_schemas_give_no_conversion() {
        let nested = "koseki/A[60000] a #\nMSG: koseki/A\nkoseki/A[60000] a #\n";
        for schema in [
            "",
            "float64",
            "float64[ position_m",
            "float64[-1] position_m",
            "float64[99999999999999999999] position_m",
            "float64[8193] position_m",
            "text name",
            nested,
        ] {
            assert_eq!(Conversion::of_schema("SystemTrack", schema), None, "{schema}");
        }
        assert_eq!(Conversion::of_schema("Unheard", "uint8 a"), None);
    }
}
