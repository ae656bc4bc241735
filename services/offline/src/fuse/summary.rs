//! Summary of inputs and results, as text or as JSON.

use std::fmt::Write as _;
use std::path::Path;

use fusion::Engine;
use messages::admission::{POSITION_MAX_M, SPEED_MAX_MPS};
use messages::{Counter, NS_PER_S, TrackState};
use serde_json::{Value, json};

use crate::files::output_name;
use crate::host::Host;
use crate::reading::{ArrivedReport, DriveTotals, Setup, SkippedRows};

/// Figures of the summary.
pub(crate) struct FuseSummary<'a> {
    pub(crate) out: &'a Path,
    pub(crate) setup: &'a Setup<'a>,
    pub(crate) engine: &'a Engine,
    pub(crate) refusals: &'a SkippedRows,
    pub(crate) driven: DriveTotals,
    /// Rows written.
    pub(crate) written: u64,
    /// Alerts raised, if they were asked for.
    pub(crate) alerts: Option<u64>,
}

/// Counters shown if nonzero: outcome of the reports, by sensor.
const OF_SENSORS: [Counter; 12] = [
    Counter::RejectedExtrapolated,
    Counter::RejectedDuplicate,
    Counter::RejectedContradicted,
    Counter::RejectedFalsePosition,
    Counter::RejectedInvalid,
    Counter::RejectedTooFast,
    Counter::RejectedTooFar,
    Counter::RejectedOutOfOrder,
    Counter::DroppedTable,
    Counter::LateUsed,
    Counter::LateBeyondWindow,
    Counter::LateUnkept,
];
/// Counters of reports that the engine does not look at any further.
const REJECTIONS: [Counter; 3] = [
    Counter::RejectedInvalid,
    Counter::RejectedTooFast,
    Counter::RejectedTooFar,
];
/// Remedy for reports that are too far from the frame of a sensor without a place.
const UNPLACED: &str = "check the unit, or choose a nearer origin";
/// Counters of system tracks.
const OF_TRACKS: [Counter; 6] = [
    Counter::TracksStarted,
    Counter::TracksConfirmed,
    Counter::TracksMerged,
    Counter::TracksTerminated,
    Counter::ContributionsSplit,
    Counter::HandOvers,
];

impl FuseSummary<'_> {
    /// Shows the summary: as JSON on standard output, else as text on standard error.
    ///
    /// # Errors
    /// If standard output fails.
    pub(crate) fn show(&self, host: &dyn Host, json: bool) -> anyhow::Result<()> {
        host.show(json.then(|| self.as_json()), || self.as_text())
    }

    /// Whether the engine has rejected every report.
    pub(crate) fn is_unused(&self) -> bool {
        let rejected: u64 = (0..self.setup.sensor_ids.len() as u16)
            .map(|source| {
                REJECTIONS
                    .iter()
                    .map(|counter| self.of_source(source, *counter))
                    .sum::<u64>()
            })
            .sum();
        self.driven.reports > 0 && rejected >= self.driven.reports
    }

    /// Returns a sentence on the value and the limit for which the first report was rejected.
    pub(crate) fn first_rejection(&self, first: &ArrivedReport) -> String {
        let report = &first.track;
        let settings = &self.engine.settings().sources[usize::from(report.source)];
        let limits = &settings.limits;
        let ([x, y, _], [vx, vy, _]) = (report.position_m, report.velocity_mps);
        let columns = ["x", "y", "z"]
            .into_iter()
            .zip(report.position_m)
            .map(|value| (value, POSITION_MAX_M, "m"));
        let speeds = ["vx", "vy", "vz"]
            .into_iter()
            .zip(report.velocity_mps)
            .map(|value| (value, SPEED_MAX_MPS, "m/s"));
        let impossible = columns.chain(speeds).find(|((_, value), max, _)| value.abs() > *max);
        let (distance_m, speed_mps) = ((x - limits.place_m[0]).hypot(y - limits.place_m[1]), vx.hypot(vy));
        let place = match self.setup.named.frame {
            Some(_) => "east and north",
            None => "columns x and y",
        };
        let why = match impossible {
            Some(((column, value), max, unit)) => {
                format!("column {column}: {value} is beyond {max:e} {unit}, which nothing on this planet is")
            }
            None if distance_m > limits.range_m && settings.place_m.is_none() => format!(
                "{place}: {x}, {y} is {:.0} km from the origin of the frame, beyond {:.0} km; {UNPLACED}",
                distance_m / 1e3,
                limits.range_m / 1e3
            ),
            None if distance_m > limits.range_m => format!(
                "{place}: {x}, {y} is {distance_m:.0} m from its sensor, beyond limits.range_m = {}; raise it if \
                 the sensor sees this far",
                limits.range_m
            ),
            None if speed_mps > limits.speed_mps => format!(
                "columns vx and vy: {vx}, {vy} is {speed_mps:.0} m/s, beyond limits.speed_mps = {}; raise it if targets \
                 are this fast",
                limits.speed_mps
            ),
            None => "its covariance is impossible".to_owned(),
        };
        format!("line {}, {why}", first.line)
    }

    fn as_json(&self) -> Value {
        let counters = |of: &[Counter], value: &dyn Fn(Counter) -> u64| -> serde_json::Map<String, Value> {
            of.iter()
                .map(|counter| (counter.label().to_owned(), value(*counter).into()))
                .collect()
        };
        let sensors: Vec<Value> = (0u16..)
            .zip(&self.setup.sensor_ids)
            .map(|(source, id)| {
                let mut sensor = counters(&OF_SENSORS, &|counter| self.of_source(source, counter));
                let settings = &self.engine.settings().sources[usize::from(source)];
                sensor.insert("sensor_id".to_owned(), (*id).into());
                sensor.insert("name".to_owned(), settings.name.as_str().into());
                sensor.insert("period_s".to_owned(), (settings.period_ns as f64 / NS_PER_S).into());
                if let Some(error) = self.engine.sources().gross_error(source) {
                    let partner = self.setup.sensor_ids[usize::from(error.partner)];
                    let told = json!({
                        "kind": error.kind.word(),
                        "value": error.value,
                        "shown_by": partner,
                        "certain": error.is_certain,
                        "removed": error.is_removed,
                    });
                    sensor.insert("gross_error".to_owned(), told);
                }
                if let Some([step_s, sigma_s]) = self.engine.sources().learned(source).and_then(|known| known.stamps_s)
                {
                    sensor.insert("stamps_s".to_owned(), json!([step_s, sigma_s]));
                }
                if let Some(first) = self.engine.sources().counts_with(source) {
                    let first = self.setup.sensor_ids[usize::from(first)];
                    sensor.insert("counts_with".to_owned(), first.into());
                }
                Value::Object(sensor)
            })
            .collect();
        let mut summary = json!({
            "out": self.out.display().to_string(),
            "rule": self.engine.settings().rule.name.0.word(),
            "rows": self.written,
            "reports": self.driven.reports,
            "rows_refused": self.refusals.rows(),
            "refused": self.refusals.by_reason,
            "first_refused": self.refusals.first,
            "sensors": sensors,
            "system_tracks": counters(&OF_TRACKS, &|counter| self.engine.counts().get(counter)),
            "live_tracks": self.live(),
            "engine_s": self.driven.engine_ns as f64 / NS_PER_S,
            "reports_per_s": self.rate(),
        });
        if let Some(raised) = self.alerts {
            summary["alerts_raised"] = raised.into();
        }
        if self.setup.named.any() {
            summary["assumed"] = self.setup.named.assumptions.as_slice().into();
        }
        summary
    }

    fn as_text(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = self.write_text(&mut text);
        text
    }

    fn write_text(&self, text: &mut String) -> std::fmt::Result {
        let driven = &self.driven;
        text.push_str(&self.setup.named.as_text());
        for (source, id) in (0u16..).zip(&self.setup.sensor_ids) {
            let settings = &self.engine.settings().sources[usize::from(source)];
            let reports = self.driven_of(source);
            write!(
                text,
                "sensor {id:<6} {reports:>9} reports, every {:.3} s",
                settings.period_ns as f64 / NS_PER_S
            )?;
            for counter in OF_SENSORS {
                match self.of_source(source, counter) {
                    0 => {}
                    count => write!(text, ", {count} {}", words(counter))?,
                }
            }
            match self.setup.named.sensor_name(*id) {
                Some(name) => writeln!(text, ": {}", name.escape_debug())?,
                None => writeln!(text)?,
            }
            self.write_limits(text, source, *id)?;
            if let Some(error) = self.engine.sources().gross_error(source) {
                let partner = self.setup.sensor_ids[usize::from(error.partner)];
                let verdict = match (error.is_removed, error.is_certain) {
                    (true, _) => "; that is taken off".to_owned(),
                    (_, true) => "; fusion.registration.gross = true takes it off".to_owned(),
                    _ => format!(", or sensor {partner} is off the other way"),
                };
                writeln!(
                    text,
                    "sensor {id:<6} is off by {error}, against sensor {partner}{verdict}"
                )?;
            }
        }
        for (source, id) in (0u16..).zip(&self.setup.sensor_ids) {
            if let Some(first) = self.engine.sources().counts_with(source) {
                let first = self.setup.sensor_ids[usize::from(first)];
                writeln!(
                    text,
                    "sensor {id:<6} counts as one with sensor {first} because of equal errors; if it measures \
                     independently, set independent_of"
                )?;
            }
        }
        for (source, id) in (0u16..).zip(&self.setup.sensor_ids) {
            let learned = self.engine.sources().learned(source).unwrap_or_default();
            if let Some([step_s, sigma_s]) = learned.stamps_s {
                let remedy = match self.engine.settings().sources[usize::from(source)].stamps {
                    Some(_) => "",
                    None => "; if the rounding is known, set stamps",
                };
                writeln!(
                    text,
                    "sensor {id:<6} has stamps that are multiples of {step_s} s (± {sigma_s:.2} s){remedy}"
                )?;
            }
        }
        text.push_str(&self.refusals.as_text());
        let tracks: Vec<String> = OF_TRACKS
            .iter()
            .map(|counter| format!("{} {}", self.engine.counts().get(*counter), words(*counter)))
            .collect();
        writeln!(
            text,
            "system tracks: {}, {} live at the end",
            tracks.join(", "),
            self.live()
        )?;
        if let Some(raised) = self.alerts {
            writeln!(text, "alerts: {raised} raised")?;
        }
        writeln!(
            text,
            "rule {}: {} reports in {:.3} s of the engine, {:.0} a second",
            self.engine.settings().rule.name.0.word(),
            driven.reports,
            driven.engine_ns as f64 / NS_PER_S,
            self.rate()
        )?;
        writeln!(text, "{}: {} rows", output_name(self.out), self.written)
    }

    fn of_source(&self, source: u16, counter: Counter) -> u64 {
        self.engine.counts().source(source).map_or(0, |counts| counts[counter])
    }

    /// Writes which limits rejected reports of sensor `id`, with the remedy.
    fn write_limits(&self, text: &mut String, source: u16, id: u32) -> std::fmt::Result {
        let settings = &self.engine.settings().sources[usize::from(source)];
        let limits = &settings.limits;
        let keys = [
            (
                Counter::RejectedTooFast,
                "limits.speed_mps",
                limits.speed_mps,
                "targets are this fast",
            ),
            (
                Counter::RejectedTooFar,
                "limits.range_m",
                limits.range_m,
                "the sensor sees this far",
            ),
        ];
        for (counter, key, limit, condition) in keys {
            let count = self.of_source(source, counter);
            if count > 0 && counter == Counter::RejectedTooFar && settings.place_m.is_none() {
                let limit_km = limit / 1e3;
                writeln!(
                    text,
                    "sensor {id:<6} is more than {limit_km:.0} km from the origin of the frame in {count} reports; {UNPLACED}"
                )?;
            } else if count > 0 {
                writeln!(
                    text,
                    "sensor {id:<6} exceeds {key} = {limit} in {count} reports; raise {key} if {condition}"
                )?;
            }
        }
        Ok(())
    }

    fn driven_of(&self, source: u16) -> u64 {
        self.driven
            .by_source
            .get(usize::from(source))
            .copied()
            .unwrap_or_default()
    }

    fn live(&self) -> usize {
        self.engine.count_in_state(TrackState::Confirmed) + self.engine.count_in_state(TrackState::Coasted)
    }

    fn rate(&self) -> f64 {
        self.driven.reports as f64 * NS_PER_S / self.driven.engine_ns.max(1) as f64
    }
}

fn words(counter: Counter) -> &'static str {
    match counter {
        Counter::RejectedExtrapolated => "extrapolated by the sensor",
        Counter::RejectedDuplicate => "of a second track on one target",
        Counter::RejectedContradicted => "contradicted by others",
        Counter::RejectedFalsePosition => "of false positions",
        Counter::RejectedInvalid => "invalid",
        Counter::RejectedTooFast => "faster than limits.speed_mps",
        Counter::RejectedTooFar => "too far away",
        Counter::RejectedOutOfOrder => "out of order",
        Counter::DroppedTable => "refused by a full table",
        Counter::LateUsed => "late and used in their place",
        Counter::LateBeyondWindow => "later than late_window_s",
        Counter::LateUnkept => "late beside a young track or a full table",
        Counter::TracksStarted => "started",
        Counter::TracksConfirmed => "confirmed",
        Counter::TracksMerged => "merged",
        Counter::TracksTerminated => "ended",
        Counter::ContributionsSplit => "sensor tracks taken out",
        Counter::HandOvers => "hand-overs",
        other => other.label(),
    }
}
