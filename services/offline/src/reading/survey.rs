//! First pass over sensor tracks: determines the sensors, the report intervals and accuracies, and the number of
//! concurrent tracks. Memory holds only the live tracks and a sample of each sensor's figures.

use std::path::PathBuf;

use configuration::SeenSensor;
use messages::SensorTrack;
use rustc_hash::FxHashMap;

use super::arrivals::{ArrivedReport, RowOrder};
use super::kept::KeptRows;
use super::merged::MergedRows;
use super::named::NamedTables;
use super::progress::Progress;
use super::sensors::Sensors;
use crate::host::Host;

/// Maximum number of figures for a median; the first figures count.
const SAMPLE_MAX: usize = 100_000;
/// A track without a report for this long has ended, nanoseconds. Sensors with a longer scan period are rare.
const LIVE_NS: i64 = 60_000_000_000;

/// Sensors in the files.
#[derive(Debug, Default)]
pub(crate) struct FileSurvey {
    /// By `sensor_id`.
    pub(crate) sensors: Vec<SeenSensor>,
    /// First unusable row.
    pub(crate) first_refusal: Option<String>,
    /// Id of the first sensor beyond the maximum number, if any.
    pub(crate) excess: Option<u32>,
    /// Whether a file has stated arrivals.
    pub(crate) has_arrivals: bool,
    /// The rows, if small enough for memory.
    pub(crate) kept: Option<KeptRows>,
}

#[derive(Default)]
struct SurveyedSensor {
    intervals_ns: Vec<i64>,
    sigmas_m: Vec<f64>,
    live: usize,
    live_max: usize,
}

impl FileSurvey {
    /// Reads all of `files` once.
    ///
    /// # Errors
    /// If a file cannot be read, or lacks a column.
    pub(crate) fn of(
        host: &dyn Host,
        files: (&[PathBuf], &NamedTables),
        accurate: Option<Vec<u32>>,
    ) -> anyhow::Result<Self> {
        let open = Sensors {
            open: true,
            accurate,
            ..Sensors::default()
        };
        let mut merged = MergedRows::open(host, files, open, RowOrder::Time)?;
        let progress = Progress::new(host, merged.octets_in_all);
        let mut sensors: Vec<SurveyedSensor> = Vec::new();
        let mut latest: FxHashMap<(u16, u32), i64> = FxHashMap::default();
        let mut pruned_ns = i64::MIN;
        while let Some(ArrivedReport { track: report, .. }) = merged.next()? {
            let now_ns = report.time_of_measurement_ns;
            if now_ns.saturating_sub(pruned_ns) > LIVE_NS {
                pruned_ns = now_ns;
                latest.retain(|(source, _), last_ns| {
                    let lives = now_ns - *last_ns <= LIVE_NS;
                    sensors[usize::from(*source)].live -= usize::from(!lives);
                    lives
                });
            }
            let source = usize::from(report.source);
            sensors.resize_with(sensors.len().max(source + 1), SurveyedSensor::default);
            let before_ns = latest.insert((report.source, report.track_number), now_ns);
            sensors[source].add(&report, before_ns);
            progress.at(*merged.octets.borrow())?;
        }
        merged.check_order()?;
        let known = merged.sensors.borrow().clone();
        let seen = known.ids.iter().zip(sensors).filter(|(_, sensor)| sensor.live_max > 0);
        let mut seen: Vec<SeenSensor> = seen.map(|(id, sensor)| sensor.seen(*id)).collect();
        seen.sort_unstable_by_key(|sensor| sensor.id);
        Ok(Self {
            sensors: seen,
            first_refusal: merged.refusals.first.first().cloned(),
            excess: known.excess,
            has_arrivals: merged.has_arrivals(),
            kept: merged.into_kept(),
        })
    }
}

impl SurveyedSensor {
    fn add(&mut self, report: &SensorTrack, before_ns: Option<i64>) {
        match before_ns.map(|before_ns| report.time_of_measurement_ns - before_ns) {
            Some(interval_ns) if interval_ns > 0 => sample(&mut self.intervals_ns, interval_ns),
            Some(_) => {}
            None => self.live += 1,
        }
        self.live_max = self.live_max.max(self.live);
        let covariance = &report.covariance;
        sample(
            &mut self.sigmas_m,
            (0.5 * (covariance.get(0, 0) + covariance.get(1, 1))).sqrt(),
        );
    }

    fn seen(mut self, id: u32) -> SeenSensor {
        SeenSensor {
            id,
            period_ns: median(&mut self.intervals_ns, i64::cmp),
            sigma_m: median(&mut self.sigmas_m, f64::total_cmp),
            tracks_max: self.live_max,
        }
    }
}

fn sample<T>(sample: &mut Vec<T>, figure: T) {
    if sample.len() < SAMPLE_MAX {
        sample.push(figure);
    }
}

/// Returns the median; of an even number of figures, the upper of the two middle figures.
fn median<T: Copy>(figures: &mut [T], order: fn(&T, &T) -> std::cmp::Ordering) -> Option<T> {
    let middle = figures.len() / 2;
    (!figures.is_empty()).then(|| *figures.select_nth_unstable_by(middle, order).1)
}
