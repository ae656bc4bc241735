//! The current scan with all inputs of the update of clusters.

use crate::departure::Departures;
use crate::existence::Survival;
use crate::explanation::{Explanation, Observer, TrackEvent, TrackRecord};
use crate::gating::Gating;
use crate::plot::Plot;
use crate::population::Population;
use crate::sensor::Sensor;
use crate::settings::Settings;
use crate::track::Track;
use crate::unresolved::Unresolved;
use crate::wide_area::support::Support;

/// A scan and the inputs of the update.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ScanContext<'a> {
    pub(crate) before: &'a Population,
    pub(crate) plots: &'a [Plot],
    /// By detection: logarithm of the density of false detections there.
    pub(crate) log_clutter: &'a [f64],
    pub(crate) gating: &'a Gating,
    pub(crate) unresolved: &'a Unresolved,
    pub(crate) departures: &'a Departures,
    pub(crate) settings: &'a Settings,
    pub(crate) sensor: &'a Sensor,
    pub(crate) survival: Survival<'a>,
    pub(crate) support: &'a Support,
    /// Logarithm of the weight of all detections of the scan (WA-1).
    pub(crate) log_weight: f64,
    pub(crate) time_ns: i64,
    /// Serial number of the first detection.
    pub(crate) first_serial: u32,
    /// Receiver of the records, if any.
    pub(crate) observer: Option<&'a dyn Observer>,
}

impl ScanContext<'_> {
    pub(crate) fn explain(&self, event: TrackEvent, track: &Track, value: f64, limit: f64) {
        if let Some(observer) = self.observer {
            let track = TrackRecord::of(track, self.plots, self.first_serial);
            observer.explain(&Explanation::Track {
                event,
                track,
                value,
                limit,
            });
        }
    }
}
