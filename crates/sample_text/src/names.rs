//! Words for the numbers of samples: codes, bits, sources and places.

use std::collections::BTreeMap;

use frames::SystemFrame;
use messages::NO_SOURCE;
use messages::layout::{ALL, CodeGroup, code_groups};

/// Fields that hold the number of a source.
pub(crate) const SOURCES: [&str; 4] = ["source", "other_source", "trigger_source", "selected_source"];

/// What is needed to write numbers as words.
#[derive(Clone, Debug)]
pub struct SampleNames {
    /// By the names of the sample and of the field.
    codes: BTreeMap<(&'static str, &'static str), CodeGroup>,
    sources: Vec<String>,
    frame: SystemFrame,
}

/// A number in words.
pub(crate) enum Word<'a> {
    /// A single word.
    One(&'a str),
    /// The bits that are set.
    Bits(Vec<&'a str>),
    /// It stands for no source.
    Nothing,
}

impl SampleNames {
    /// Returns the words for an instance with these sources; positions in `frame` are also
    /// written as latitude and longitude.
    pub fn new(sources: Vec<String>, frame: SystemFrame) -> Self {
        let groups = code_groups();
        let fields = ALL
            .iter()
            .flat_map(|layout| layout.fields.iter().map(|field| (layout.name, field)));
        let coded = fields.filter_map(|(sample, field)| Some(((sample, field.name), field.codes(&groups)?)));
        Self {
            codes: coded.collect(),
            sources,
            frame,
        }
    }

    /// Returns the words for the value of a field of a sample; `None` if it is a plain number, or has a code of another
    /// version.
    pub(crate) fn word(&self, sample: &'static str, field: &'static str, value: u64) -> Option<Word<'_>> {
        if SOURCES.contains(&field) {
            return match usize::try_from(value).ok().and_then(|place| self.sources.get(place)) {
                Some(name) => Some(Word::One(name)),
                None if value == u64::from(NO_SOURCE) => Some(Word::Nothing),
                None => None,
            };
        }
        let group = self.codes.get(&(sample, field))?;
        if group.is_flags {
            let set = group.constants.iter().filter(|bit| value & bit.value == bit.value);
            return Some(Word::Bits(set.map(|bit| bit.word).collect()));
        }
        let code = group.constants.iter().find(|code| code.value == value)?;
        Some(Word::One(code.word))
    }

    /// Returns latitude, longitude (degrees) and height (m) of a position in the system frame; NaN for an unknown one.
    pub(crate) fn place(&self, position_m: [f64; 3]) -> [f64; 3] {
        if !position_m.iter().all(|coordinate| coordinate.is_finite()) {
            return [f64::NAN; 3];
        }
        let place = self.frame.to_geodetic(position_m);
        [place.latitude_deg(), place.longitude_deg(), place.height_m()]
    }
}
