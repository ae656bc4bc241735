//! Parts of the checks that several tables need: the result of a check, a place, the limits of reports.

use std::ops::{Deref, DerefMut};

use deployment::Source;
use frames::Geodetic;
use fusion_settings::ReportLimits;
use reception::PlausibilityLimits;
use settings::SettingsError;
use sources::SourceReading;

use super::tables::PlaceTable;

/// A source, and how its data are read.
#[derive(Clone, Debug)]
pub(super) struct CheckedSource {
    pub(super) source: Source,
    pub(super) reading: SourceReading,
}

impl Deref for CheckedSource {
    type Target = Source;

    fn deref(&self) -> &Source {
        &self.source
    }
}

impl DerefMut for CheckedSource {
    fn deref_mut(&mut self) -> &mut Source {
        &mut self.source
    }
}

/// A checked value, or the first mistake with key, value and remedy.
pub(super) type Checked<T> = Result<T, SettingsError>;

pub(super) fn place(key: &str, raw: &PlaceTable) -> Checked<Geodetic> {
    Geodetic::from_degrees(raw.latitude_deg, raw.longitude_deg, raw.height_m).map_err(|error| {
        let part = match error {
            frames::GeodeticError::Latitude(_) => "latitude_deg",
            frames::GeodeticError::Longitude(_) => "longitude_deg",
            frames::GeodeticError::Height(_) => "height_m",
        };
        SettingsError::new(format!("{key}.{part}"), error.to_string())
    })
}

/// Limits of the reports of a source that nobody looks at before fusion; its sensor stands at this place, metres.
pub(super) fn limits(limits: &PlausibilityLimits, place_m: [f64; 2]) -> ReportLimits {
    ReportLimits {
        place_m,
        range_m: limits.range_m,
        speed_mps: limits.speed_mps,
    }
}
