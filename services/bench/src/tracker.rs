//! `koseki bench tracker`: time of a tracker process's engine, from a scan to its tracks, without any bus.

use std::path::PathBuf;

use anyhow::Context as _;
use hdrhistogram::Histogram;
use messages::NS_PER_S;
use runtime::Now;
use runtime::cores::Placement;
use runtime::signals::Stop;
use serde::{Deserialize, Serialize};
use telemetry::table::{Align, TextTable, duration};

use crate::drive::{Clock as _, MachineClock};
use crate::figures::Figures;
use crate::machine::MachineFacts;
use crate::pinned;
use crate::product::Product;
use crate::settings::MeasurementRefusal;
use crate::tracker_load::{LoadTimes, TrackerLoad, drive};

/// Limits of a load.
const SENSORS_MAX: usize = 32;
const DETECTIONS_MAX: usize = 10_000;
const TARGETS_MAX: usize = 10_000;
/// A tracker process takes at most so many scans of a sensor per second.
const SCANS_PER_S: [f64; 2] = [0.01, 10_000.0];

/// Settings of a measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackerBench {
    /// Load.
    pub load: TrackerLoad,
    /// Core to run on.
    pub core: usize,
    /// File for all figures.
    pub json: Option<PathBuf>,
}

/// Figures of a measurement.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TrackerFigures {
    /// Measuring machine.
    pub machine: MachineFacts,
    /// Sensors, targets, and detections in a scan.
    pub sensors: usize,
    /// Targets.
    pub targets: usize,
    /// Scans of each sensor per second.
    pub scans_per_s: f64,
    /// Detections in a scan.
    pub detections: usize,
    /// From the event that ends a scan's wait to the scan's tracks.
    pub latency: Figures,
    /// Work for the events of a scan.
    pub work: Figures,
    /// Mean work for the events of a scan, nanoseconds.
    pub work_mean_ns: f64,
    /// Share of the time for which the tracker worked; the queue grows from 1 on.
    pub busy: f64,
    /// Longest time by which the tracker was behind the data, and that at the end, nanoseconds.
    pub queue_ns: [i64; 2],
    /// Mean number of tracks after a scan.
    pub tracks: f64,
}

/// Measures the tracker of `product`. Returns the text to show.
///
/// # Errors
/// If the settings are invalid, or a file cannot be written.
pub fn run(product: &dyn Product, bench: &TrackerBench) -> anyhow::Result<String> {
    check(&bench.load)?;
    let stop = Stop::on_signals_to_clear_up()?;
    let mut machine = MachineFacts::read();
    let watch = || {
        anyhow::ensure!(!stop.requested(), "stopped before the end; no figures are shown");
        Ok(())
    };
    let place = Placement {
        core: Some(bench.core),
        ..Placement::default()
    };
    let times = pinned::run(place, watch, |abort| {
        let mut tracker = product.tracker(&bench.load.config_text())?;
        let ended = || {
            anyhow::ensure!(!abort.load(std::sync::atomic::Ordering::Relaxed), "ended early");
            Ok(())
        };
        let start_ns = Now::read().utc_ns;
        drive(&mut *tracker, &bench.load, start_ns, || MachineClock.now_ns(), ended)
    })?;
    machine.ended();
    let figures = TrackerFigures::of(machine, &bench.load, &times);
    if let Some(path) = &bench.json {
        let text = serde_json::to_string_pretty(&figures)?;
        std::fs::write(path, text).with_context(|| format!("writing {}", path.display()))?;
    }
    Ok(shown(&figures, bench.load.seconds))
}

fn check(load: &TrackerLoad) -> Result<(), MeasurementRefusal> {
    let refuse = |what: String| Err(MeasurementRefusal(what));
    for (option, value, most) in [
        ("--sensors", load.sensors, SENSORS_MAX),
        ("--targets", load.targets, TARGETS_MAX),
        ("--detections", load.detections, DETECTIONS_MAX),
    ] {
        if !(1..=most).contains(&value) {
            return refuse(format!("{option} {value}: there can be 1 to {most}"));
        }
    }
    let [least, most] = SCANS_PER_S;
    if !(least..=most).contains(&load.scans_per_s) {
        return refuse(format!(
            "--scans {}: it must lie between {least} and {most}",
            load.scans_per_s
        ));
    }
    if !(0.0..1.0).contains(&load.false_share) {
        return refuse(format!("--false {}: a share lies between 0 and 1", load.false_share));
    }
    Ok(())
}

impl TrackerFigures {
    fn of(machine: MachineFacts, load: &TrackerLoad, times: &LoadTimes) -> Self {
        let figures = |histogram: &Histogram<u64>| Figures::of(histogram, 0);
        Self {
            machine,
            sensors: load.sensors,
            targets: load.targets,
            scans_per_s: load.scans_per_s,
            detections: load.detections,
            latency: figures(&times.latency),
            work: figures(&times.work),
            work_mean_ns: times.work.mean(),
            busy: times.busy,
            queue_ns: times.queue_ns,
            tracks: times.tracks,
        }
    }
}

fn shown(figures: &TrackerFigures, seconds: f64) -> String {
    let mut columns = vec![("", Align::Left)];
    columns.extend(Figures::NAMES.map(|name| (name, Align::Right)));
    let mut table = TextTable::new(&columns);
    let mut row = |name: &str, figures: &Figures| {
        let mut cells = vec![name.to_owned()];
        cells.extend(figures.values().map(|value| duration(value as f64)));
        table.row(cells);
    };
    row("from the end of a scan's wait to its tracks", &figures.latency);
    row("work for a scan", &figures.work);
    let [most_ns, end_ns] = figures.queue_ns.map(|behind_ns| duration(behind_ns as f64));
    let grows = if figures.queue_ns[1] as f64 > 0.01 * NS_PER_S * seconds {
        "the queue grows"
    } else {
        "the queue does not grow"
    };
    format!(
        "{} sensors with {} scans/s of {} detections each; {} targets, {:.0} tracks\n\n{table}\
         work: {} in the mean, {:.1} % of the time; \
         behind the data by {most_ns} at most, by {end_ns} at the end: {grows}\n",
        figures.sensors,
        figures.scans_per_s,
        figures.detections,
        figures.targets,
        figures.tracks,
        duration(figures.work_mean_ns),
        100.0 * figures.busy,
    )
}

#[cfg(test)]
mod tests {
    use messages::SensorDetection;

    use super::*;
    use crate::product::TrackerStage;

    /// A tracker that finishes each scan with its mark, and takes `work_ns` for an event.
    struct Ideal {
        work_ns: i64,
        scan_ns: i64,
        progress_ns: i64,
        clock: std::rc::Rc<std::cell::Cell<i64>>,
    }

    impl TrackerStage for Ideal {
        fn event(&mut self, _: usize, event: &SensorDetection) -> usize {
            self.clock.set(self.clock.get() + self.work_ns);
            let is_mark = event.valid & messages::sensor_detection_bits::MARK != 0;
            if is_mark {
                self.progress_ns = self.scan_ns;
            }
            self.scan_ns = event.time_of_measurement_ns;
            usize::from(is_mark) * 160
        }

        fn progress_ns(&self) -> i64 {
            self.progress_ns
        }
    }

    fn times(work_ns: i64) -> LoadTimes {
        let load = TrackerLoad {
            sensors: 2,
            targets: 30,
            scans_per_s: 10.0,
            detections: 9,
            false_share: 0.0,
            warm_up_s: 0.5,
            seconds: 1.0,
        };
        let clock = std::rc::Rc::new(std::cell::Cell::new(0));
        let mut ideal = Ideal {
            work_ns,
            scan_ns: 0,
            progress_ns: i64::MIN,
            clock: clock.clone(),
        };
        drive(&mut ideal, &load, 1000, || clock.get(), || Ok::<(), ()>(())).unwrap()
    }

    #[test]
    fn latency_counts_the_work_before_it_and_the_queue() {
        let fast = times(1_000_000);
        assert_eq!((fast.latency.len(), fast.work.len()), (20, 20));
        // Nine detections and a mark, every 50 ms.
        assert!(
            (fast.latency.max() as f64 / 10e6 - 1.0).abs() < 2e-3,
            "{}",
            fast.latency.max()
        );
        assert!((fast.busy - 0.2).abs() < 1e-9);
        assert_eq!((fast.queue_ns, fast.tracks), ([0, 0], 160.0));
        let slow = times(10_000_000);
        assert!((slow.busy - 2.0).abs() < 1e-9);
        // 100 ms of work every 50 ms, twenty times.
        assert_eq!(slow.queue_ns, [950_000_000; 2]);
        assert!((slow.latency.max() as f64 / 1.05e9 - 1.0).abs() < 2e-3);
    }

    #[test]
    fn loads_are_checked() {
        let load = TrackerLoad {
            sensors: 8,
            targets: 160,
            scans_per_s: 250.0,
            detections: 50,
            false_share: 0.1,
            warm_up_s: 1.0,
            seconds: 1.0,
        };
        assert_eq!(check(&load), Ok(()));
        for wrong in [
            TrackerLoad { sensors: 33, ..load },
            TrackerLoad { targets: 0, ..load },
            TrackerLoad { detections: 0, ..load },
            TrackerLoad {
                scans_per_s: f64::NAN,
                ..load
            },
            TrackerLoad {
                false_share: 1.0,
                ..load
            },
        ] {
            assert!(check(&wrong).is_err(), "{wrong:?}");
        }
    }
}
