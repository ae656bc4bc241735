//! `koseki simulate`: observations of simulated sensors in a simulated world, as files (FM-9).
//!
//! The world and its sensors come from the demonstration (`scenario`), without a clock: the command requests one
//! delivery after another from each sensor. A run of an hour takes seconds, and the same seed gives the same bytes.
//! Direction finders write a table of bearings (FM-7), in which a transmitter has the target's number, or the snapshots
//! of the antenna arrays (EL-1). Receivers of AIS write lines of NMEA 0183. Wide-area sensors write a table of counts
//! (FM-6).

mod ais;
mod on_board;
mod truth;

use std::io::Write as _;
use std::path::Path;

use anyhow::Context as _;
use configuration::{Config, DEMO};
use formats::bearings_csv::BearingWriter;
use formats::detections_csv::{DetectionWriter, RepliedDetection, RepliedDetectionWriter};
use formats::sensor_tracks_csv::SensorTrackWriter;
use formats::snapshots_csv;
use formats::wide_area_csv::WideAreaWriter;
use messages::SensorTrack;
use observations::sensor_id;
use observations::{Detection, DetectionKind, DetectionPlatform, TransponderReply};
use scenario::{
    ArrayGeometry, Instrument, RadarPlot, SensorSettings, SimulatedAis, SimulatedDirectionFinder, SimulatedSensor,
    SimulatedWideAreaSensor, Truth,
};
use simulator::SensorFeed;

use crate::args::Simulate;
use crate::files::{InputError, Usage, unwritable};
use crate::host::{Host, TableOutput};

use truth::{Observers, write_truth};

/// Scenarios by name: the underlying deployment, and the changes to the deployment.
const NAMED: [(&str, &str, &[&str]); 5] = [
    ("demo", DEMO, &[]),
    (
        "en-route",
        DEMO,
        &[
            "scenario.terminal_share=0.0",
            "scenario.holding_share=0.0",
            "scenario.surface_share=0.0",
            "scenario.crossing_share=1.0",
        ],
    ),
    ("dense", DEMO, &["scenario.targets=400"]),
    (
        "mode-s",
        DEMO,
        &[
            "scenario.targets=200",
            "scenario.half_width_m=40000.0",
            "scenario.terminal_share=0.0",
            "scenario.holding_share=0.0",
            "scenario.surface_share=0.0",
            "scenario.crossing_share=1.0",
            "source[4].simulated.address_probability=0.98",
            "source[4].simulated.code_probability=0.99",
            "source[4].simulated.garbled_probability=0.01",
        ],
    ),
    ("wide-area", include_str!("../../../config/wide-area.toml"), &[]),
];

/// Runs the simulation.
///
/// # Errors
/// If the scenario does not exist, or a file cannot be written.
pub(crate) fn run(simulate: &Simulate, host: &dyn Host) -> anyhow::Result<()> {
    if simulate.scenario == Path::new(on_board::NAME) {
        return on_board::run(simulate, host);
    }
    let config = config(host, &simulate.scenario, &simulate.set)?;
    let instruments = &config.world.instruments;
    let (Some(world), false) = (&config.world.targets, instruments.is_empty()) else {
        let what = "has no [scenario] with simulated sources; take config/demo.toml for a pattern";
        return Err(Usage(format!("--scenario {}: {what}", simulate.scenario.display())).into());
    };
    let out = &simulate.out;
    host.make_folder(out).map_err(|error| unwritable(out, &error))?;
    let truth = Truth::new(world, simulate.seed)?.round(config.frame);
    let end_s = simulate.seconds.as_secs_f64();
    let mut said = String::new();
    let mut observers = Observers::default();
    for (number, instrument) in instruments {
        let source = &config.sources[usize::from(*number)];
        let (id, name) = (sensor_id(source.number), &source.name);
        match instrument {
            Instrument::Sensor(settings) => {
                let mut sensor = SimulatedSensor::new(settings, simulate.seed, source.number, 0)?;
                observers.sensors.push(sensor.clone());
                if simulate.asterix {
                    let feed = SensorFeed::new((source, config.frame), settings, simulate.seed, 0)?;
                    write_asterix(host, out, source.number, feed, &truth, end_s)?;
                }
                let (reports, detections) =
                    write_sensor(host, out, source.number, settings, &mut sensor, &truth, end_s)?;
                said += &format!("sensor {id} {name}: {reports} reports, {detections} detections\n");
            }
            Instrument::DirectionFinder {
                settings,
                array: Some(array),
            } => {
                let mut finder = SimulatedDirectionFinder::new(settings, simulate.seed, source.number, 0)?;
                observers.finders.push(finder.clone());
                let measurements = write_snapshots(host, out, source.number, (&mut finder, array), &truth, end_s)?;
                said += &format!("sensor {id} {name}: {measurements} measurements of its array\n");
            }
            Instrument::DirectionFinder { settings, array: None } => {
                let mut finder = SimulatedDirectionFinder::new(settings, simulate.seed, source.number, 0)?;
                observers.finders.push(finder.clone());
                let bearings = write_bearings(host, out, source.number, &mut finder, &truth, end_s)?;
                said += &format!("sensor {id} {name}: {bearings} bearings\n");
            }
            Instrument::Ais(settings) => {
                let receivers = SimulatedAis::new(settings, simulate.seed, source.number, 0)?;
                observers.receivers.push(receivers.clone());
                let messages = ais::write_ais(host, out, source.number, (receivers, config.frame), &truth, end_s)?;
                said += &format!("sensor {id} {name}: {messages} messages of AIS\n");
            }
        }
    }
    for (number, settings) in &config.world.counting {
        let name = &config.wide_area_sensors[usize::from(*number)].name;
        let simulated = SimulatedWideAreaSensor::new(settings, simulate.seed, *number, 0)?;
        let counts = write_counts(host, out, name, simulated, &truth, end_s)?;
        said += &format!("wide-area sensor {name}: {counts} reports\n");
    }
    let rows = write_truth(host, &out.join("truth.csv"), &truth, &observers, end_s)?;
    said += &format!(
        "{} targets, {rows} rows of truth; files in {}\n",
        truth.len(),
        out.display()
    );
    host.say(&said);
    Ok(())
}

/// Returns the configuration for a name or a file, with values replaced.
fn config(host: &dyn Host, scenario: &Path, set: &[String]) -> anyhow::Result<Config> {
    let named = NAMED.iter().find(|(name, ..)| Path::new(name) == scenario);
    match named {
        Some((_, text, changes)) => {
            let changes: Vec<String> = changes.iter().map(|change| (*change).to_owned()).collect();
            Ok(host.deployment(scenario, text, &[&changes, set].concat())?)
        }
        None if !scenario.exists() => {
            let names = format!("{}, {}", NAMED.map(|(name, ..)| name).join(", "), on_board::NAME);
            let what = format!("there is no such file or scenario; there are {names}");
            Err(InputError::new(scenario, what).into())
        }
        None => Ok(host.deployment(scenario, &configuration::text(scenario)?, set)?),
    }
}

/// Writes the reports and detections of a sensor up to `end_s`; returns the numbers of both. A sensor that delivers
/// plots reports no tracks.
fn write_sensor(
    host: &dyn Host,
    folder: &Path,
    source: u16,
    settings: &SensorSettings,
    sensor: &mut SimulatedSensor,
    truth: &Truth,
    end_s: f64,
) -> anyhow::Result<(u64, u64)> {
    let id = sensor_id(source);
    let reports_path = folder.join(format!("sensor_tracks_{id}.csv"));
    let plots_path = folder.join(format!("detections_{id}.csv"));
    let unwritten = || format!("{} cannot be written", folder.display());
    let mut tracks = SensorTrackWriter::begin(host.begin(&reports_path)?, 0).with_context(unwritten)?;
    let plots_table = host.begin(&plots_path)?;
    let mut detections = DetectionTable::begin(plots_table, settings.receives_replies()).with_context(unwritten)?;
    let end_ns = frames::time::ns(end_s);
    let (mut reports, mut plots): (Vec<SensorTrack>, Vec<RadarPlot>) = Default::default();
    let (mut report_count, mut plot_count) = (0, 0);
    while sensor.progress_s() <= end_s {
        host.progress(sensor.progress_s() as u64, end_s as u64)?;
        sensor.scan_with_plots(truth, &mut reports, &mut plots);
        for report in reports
            .drain(..)
            .filter(|report| report.time_of_measurement_ns <= end_ns && !settings.plots)
        {
            tracks.write(&report).with_context(unwritten)?;
            report_count += 1;
        }
        for plot in plots.drain(..).filter(|plot| plot.time_of_measurement_ns <= end_ns) {
            plot_count += 1;
            detections
                .write(&detection(id, plot_count, &plot))
                .with_context(unwritten)?;
        }
    }
    tracks.into_inner().finish()?;
    detections.finish()?;
    Ok((report_count, u64::from(plot_count)))
}

/// Table of detections: with the columns of replies if the sensor receives any, so that other tables stay unchanged.
enum DetectionTable {
    Plain(DetectionWriter<Box<dyn TableOutput>>),
    Replied(RepliedDetectionWriter<Box<dyn TableOutput>>),
}

impl DetectionTable {
    fn begin(out: Box<dyn TableOutput>, has_replies: bool) -> std::io::Result<Self> {
        Ok(match has_replies {
            true => Self::Replied(RepliedDetectionWriter::begin(out, 0)?),
            false => Self::Plain(DetectionWriter::begin(out, 0)?),
        })
    }

    fn write(&mut self, detection: &Detection) -> std::io::Result<()> {
        match self {
            Self::Plain(table) => table.write(detection),
            Self::Replied(table) => table.write(&RepliedDetection(*detection)),
        }
    }

    fn finish(self) -> anyhow::Result<()> {
        match self {
            Self::Plain(table) => table.into_inner().finish(),
            Self::Replied(table) => table.into_inner().finish(),
        }
    }
}

/// Writes the messages of a sensor up to `end_s`: bare data blocks in the order of sending.
fn write_asterix(
    host: &dyn Host,
    folder: &Path,
    source: u16,
    mut feed: SensorFeed,
    truth: &Truth,
    end_s: f64,
) -> anyhow::Result<()> {
    let path = folder.join(format!("asterix_{}.ast", sensor_id(source)));
    let mut out = host.begin(&path)?;
    let mut written = Ok(());
    while feed.due_s() <= end_s {
        host.progress(feed.due_s() as u64, end_s as u64)?;
        feed.deliver(truth, frames::time::ns(feed.due_s()), &mut |datagram| {
            if written.is_ok() {
                written = out.write_all(datagram);
            }
        });
    }
    written.with_context(|| format!("{} cannot be written", path.display()))?;
    out.finish()
}

/// Writes the bearings of a direction finder up to `end_s`; returns the number of bearings.
fn write_bearings(
    host: &dyn Host,
    folder: &Path,
    source: u16,
    finder: &mut SimulatedDirectionFinder,
    truth: &Truth,
    end_s: f64,
) -> anyhow::Result<u64> {
    let path = folder.join(format!("bearings_{}.csv", sensor_id(source)));
    let unwritten = || format!("{} cannot be written", path.display());
    let mut table = BearingWriter::begin(host.begin(&path)?, 0).with_context(unwritten)?;
    let (mut heard, mut count) = (Vec::new(), 0);
    while finder.measured_s() <= end_s {
        host.progress(finder.measured_s() as u64, end_s as u64)?;
        heard.clear();
        finder.listen(truth, &mut heard);
        for bearing in &heard {
            table.write(bearing).with_context(unwritten)?;
        }
        count += heard.len() as u64;
    }
    table.into_inner().finish()?;
    Ok(count)
}

/// Writes the snapshots of a direction finder's array up to `end_s`; returns the number of measurements.
fn write_snapshots(
    host: &dyn Host,
    folder: &Path,
    source: u16,
    (finder, array): (&mut SimulatedDirectionFinder, &ArrayGeometry),
    truth: &Truth,
    end_s: f64,
) -> anyhow::Result<u64> {
    let path = folder.join(format!("snapshots_{}.csv", sensor_id(source)));
    let unwritten = || format!("{} cannot be written", path.display());
    let mut table = host.begin(&path)?;
    snapshots_csv::write_header(&mut table, array.antennas_m.len()).with_context(unwritten)?;
    let (mut measured, mut count) = (Vec::new(), 0);
    while finder.measured_s() <= end_s {
        host.progress(finder.measured_s() as u64, end_s as u64)?;
        measured.clear();
        finder.take_snapshots(array, truth, &mut measured);
        for measurement in &measured {
            snapshots_csv::write_rows(&mut table, measurement, 0).with_context(unwritten)?;
        }
        count += measured.len() as u64;
    }
    table.finish()?;
    Ok(count)
}

/// Writes the counts of a wide-area sensor up to `end_s`, in the order of arrival; returns the number of reports.
fn write_counts(
    host: &dyn Host,
    folder: &Path,
    name: &str,
    mut sensor: SimulatedWideAreaSensor,
    truth: &Truth,
    end_s: f64,
) -> anyhow::Result<u64> {
    let path = folder.join(format!("wide_area_{name}.csv"));
    let unwritten = || format!("{} cannot be written", path.display());
    let mut table = WideAreaWriter::begin(host.begin(&path)?, 0).with_context(unwritten)?;
    let (mut observed, mut count) = (Vec::new(), 0);
    while sensor.observed_s() <= end_s {
        host.progress(sensor.observed_s() as u64, end_s as u64)?;
        observed.clear();
        sensor.observe(truth, &mut observed);
        for report in &observed {
            table.write(report).with_context(unwritten)?;
        }
        count += observed.len() as u64;
    }
    table.into_inner().finish()?;
    Ok(count)
}

/// Converts a plot: a radar without height gives range and bearing; a sensor that measures height gives a position.
fn detection(sensor_id: u32, number: u32, plot: &RadarPlot) -> Detection {
    let [east, north, up] = plot.position_m;
    let [sigma_east, sigma_north, sigma_up] = plot.sigma_m;
    let (kind, values, sigmas) = match (plot.polar_sigma, plot.height) {
        (Some([range_sigma_m, azimuth_sigma_rad]), false) => {
            let [range_m, azimuth_rad] = plot.polar();
            let sigmas = [range_sigma_m, azimuth_sigma_rad, 0.0, 0.0];
            (DetectionKind::RangeBearing, [range_m, azimuth_rad, 0.0], sigmas)
        }
        (None, false) => {
            let sigmas = [sigma_east, sigma_north, 0.0, 0.0];
            (DetectionKind::Position2, [east, north, 0.0], sigmas)
        }
        (_, true) => {
            let sigmas = [sigma_east, sigma_north, sigma_up, 0.0];
            (DetectionKind::Position3, [east, north, up], sigmas)
        }
    };
    Detection {
        time_of_measurement_ns: plot.time_of_measurement_ns,
        sensor_id,
        scan: plot.scan as u32,
        detection_id: number,
        kind,
        values,
        range_rate_mps: None,
        sigmas: Some(sigmas),
        platform_m: plot.site_m,
        platform: DetectionPlatform::default(),
        height: None,
        velocity: None,
        reply: TransponderReply {
            identity: plot.identity,
            level: plot.level,
            ..TransponderReply::default()
        },
        truth: Some(plot.of),
    }
}
