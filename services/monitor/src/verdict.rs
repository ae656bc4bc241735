//! The verdict: a sentence on the need for attention.

use alarms::AlarmKind;
use messages::{Counter, LifeState, ProcessKind};
use telemetry::{Stage, table};

use crate::report::{Hop, Report, Verdict};
use crate::shares;
use crate::text::{percent, several, times};
use observed::ProcessState;

/// Permitted share of unread reports in a live deployment: reports in transit at the stop.
const UNREAD_SHARE_MAX: f64 = 0.01;
/// Share of reports that may take longer through fusion than configured.
const DEADLINE_MISS_SHARE_MAX: f64 = 0.01;
/// Share of the targets in view that should be held by a single system track.
const HELD_ONCE_SHARE_MIN: f64 = 0.95;

/// Judges everything in `report` but the verdict.
pub(crate) fn on(report: &Report) -> Verdict {
    let concerns = concerns(report);
    let sentence = if concerns.is_empty() {
        praise(report)
    } else {
        format!("Worth a look: {}.", concerns.join("; "))
    };
    Verdict {
        fine: concerns.is_empty(),
        sentence,
    }
}

fn concerns(report: &Report) -> Vec<String> {
    let mut concerns = Vec::new();
    about_processes(report, &mut concerns);
    about_reports(report, &mut concerns);
    about_the_network(report, &mut concerns);
    about_the_recorder(report, &mut concerns);
    about_fusion(report, &mut concerns);
    about_accuracy(report, &mut concerns);
    about_shares(report, &mut concerns);
    about_alarms(report, &mut concerns);
    concerns
}

fn about_processes(report: &Report, concerns: &mut Vec<String>) {
    for process in &report.processes {
        let title = process.title();
        // The monitor is present, as the writer of this report, and ends before the launcher and the keeper.
        let is_watching = matches!(
            process.kind,
            Some(ProcessKind::Monitor | ProcessKind::Keeper | ProcessKind::Launcher)
        );
        match process.state {
            _ if is_watching => {}
            ProcessState::NotHeard => concerns.push(format!("{title} was never heard from")),
            ProcessState::Silent { .. } => concerns.push(format!("{title} has been {}", process.state)),
            ProcessState::Life(LifeState::Failed) => concerns.push(format!("{title} has failed")),
            ProcessState::Life(_) => {}
        }
        if process.restarts > 0 {
            let mut concern = format!("{title} was restarted {}", times(process.restarts.into()));
            if !process.last_end.is_empty() {
                concern.push_str(&format!(" (the last time because it {})", process.last_end));
            }
            if process.kind == Some(ProcessKind::Monitor) && !report.losses.complete {
                concern.push_str(", so this report speaks of the time since then only");
            }
            concerns.push(concern);
        }
    }
}

fn about_reports(report: &Report, concerns: &mut Vec<String>) {
    let taken = taken(report);
    if taken == 0 {
        concerns.push("fusion did not receive a single report".to_owned());
        return;
    }
    for source in &report.sources {
        let delivered = match source.sensor_of {
            Some(_) => source.adapter[Counter::Published] + source.adapter[Counter::Detections],
            None => source.fusion[Counter::Taken],
        };
        if delivered == 0 {
            concerns.push(format!("{} delivered nothing", source.name));
        }
    }
    let losses = &report.losses;
    if losses.reports_lost > 0 {
        concerns.push(format!(
            "{} did not reach fusion, because it fell behind",
            several(losses.reports_lost, "report")
        ));
    }
    let recorded = report.settings.simulated_sources + report.settings.live_sources == 0;
    let allowed = if recorded { 0.0 } else { UNREAD_SHARE_MAX * taken as f64 };
    if losses.complete && losses.reports_unread as f64 > allowed {
        // The reports that a killed fusion process took in its last moment are unknown.
        let up_to = if report.restarts.by_process.contains_key(ProcessKind::Fusion.word()) {
            "up to "
        } else {
            ""
        };
        concerns.push(format!(
            "{up_to}{} published while fusion was not there to read them",
            were(losses.reports_unread, "report")
        ));
    }
}

fn about_the_network(report: &Report, concerns: &mut Vec<String>) {
    for network in &report.network {
        let of = |counter| network.counters[counter];
        if of(Counter::DatagramsDropped) > 0 {
            concerns.push(format!(
                "the kernel dropped {} before {} had read them: raise its buffer_bytes",
                several(of(Counter::DatagramsDropped), "datagram"),
                network.process
            ));
        }
        if of(Counter::SendFailures) > 0 {
            concerns.push(format!(
                "{} could not send {}",
                network.process,
                several(of(Counter::SendFailures), "datagram")
            ));
        }
    }
}

fn about_the_recorder(report: &Report, concerns: &mut Vec<String>) {
    let to_recorder = |hop: &&Hop| hop.to == ProcessKind::Recorder.word();
    let lost: u64 = report.losses.hops.iter().filter(to_recorder).map(|hop| hop.lost).sum();
    if lost > 0 {
        concerns.push(format!(
            "the recorder missed {}, so its files have gaps",
            several(lost, "sample")
        ));
    }
}

fn about_fusion(report: &Report, concerns: &mut Vec<String>) {
    let fusion = &report.fusion;
    let dropped = fusion[Counter::DroppedQueue] + fusion[Counter::DroppedTable];
    if dropped > 0 {
        concerns.push(format!(
            "fusion had no room for {}: raise [fusion.capacity]",
            several(dropped, "report")
        ));
    }
    let mismatched = fusion[Counter::RejectedSchema];
    if mismatched > 0 {
        concerns.push(format!(
            "fusion rejected {} of publishers that were built with another layout",
            several(mismatched, "slice")
        ));
    }
    let published = fusion[Counter::Published];
    let misses = fusion[Counter::DeadlineMisses];
    let measured = report.settings.latencies_measured && report.settings.order == "arrival";
    if measured && misses as f64 > DEADLINE_MISS_SHARE_MAX * published as f64 {
        concerns.push(format!(
            "{} of the states took longer through fusion than {}",
            percent(misses as f64 / published.max(1) as f64),
            table::duration(report.settings.deadline_us * 1e3)
        ));
    }
    if measured {
        about_stages(report, concerns);
    }
    if taken(report) > 0 && report.picture.ever_confirmed == 0 {
        concerns.push("no system track was confirmed".to_owned());
    }
}

/// Deadlines of stages other than fusion's own; fusion counts its own misses.
fn about_stages(report: &Report, concerns: &mut Vec<String>) {
    for (stage, figures) in report.stages.iter().filter(|(stage, _)| *stage != Stage::TakenToFused) {
        let (count, misses) = (figures.summary.count, figures.deadline_misses);
        let Some(deadline_us) = figures.deadline_us else {
            continue;
        };
        if misses as f64 > DEADLINE_MISS_SHARE_MAX * count as f64 {
            concerns.push(format!(
                "{} of the states missed a deadline: {} took longer than {}",
                percent(misses as f64 / count.max(1) as f64),
                stage.label(),
                table::duration(deadline_us * 1e3)
            ));
        }
    }
}

fn about_accuracy(report: &Report, concerns: &mut Vec<String>) {
    let Some(accuracy) = report.accuracy.filter(|accuracy| accuracy.pictures > 0) else {
        return;
    };
    if accuracy.held_once_share < HELD_ONCE_SHARE_MIN {
        concerns.push(format!(
            "only {} of the targets in view were held by exactly one system track",
            percent(accuracy.held_once_share)
        ));
    }
    if accuracy.identity_errors > 0 {
        concerns.push(format!(
            "system tracks carried a wrong address {}",
            times(accuracy.identity_errors)
        ));
    }
}

/// Shares of the sources' reports without an alarm.
fn about_shares(report: &Report, concerns: &mut Vec<String>) {
    for source in &report.sources {
        let untold = shares::concerns(&source.name, &source.adapter, source.sensor_of.is_some())
            .filter(|(kind, _)| report.alarms.iter().all(|alarm| alarm.alarm != kind.word()));
        concerns.extend(untold.map(|(_, concern)| concern));
    }
}

/// Alarms not covered by other sentences.
fn about_alarms(report: &Report, concerns: &mut Vec<String>) {
    let told = [
        AlarmKind::SamplesLost,
        AlarmKind::DatagramsDropped,
        AlarmKind::SendFailed,
        AlarmKind::CapacityReached,
        AlarmKind::LayoutMismatch,
        AlarmKind::ProcessRestarted,
        AlarmKind::ProcessDown,
        AlarmKind::ProcessHung,
    ];
    let others = report
        .alarms
        .iter()
        .filter(|alarm| told.iter().all(|kind| kind.word() != alarm.alarm));
    concerns.extend(others.map(|alarm| alarm.text.trim_end_matches('.').to_owned()));
}

fn praise(report: &Report) -> String {
    let (taken, unread) = (taken(report), report.losses.reports_unread);
    let mut sentence = if unread == 0 {
        let reports = several(taken, "published report");
        format!("Nothing to worry about: all {reports} reached fusion, none was lost")
    } else {
        let (reports, unread) = (several(taken, "report"), were(unread, "report"));
        format!("Nothing to worry about: {reports} reached fusion, none was lost, {unread} on the way at the end")
    };
    sentence.push_str(", and no process was restarted");
    let end_to_end = report.stages.iter().find(|(stage, _)| *stage == Stage::EndToEnd);
    if let Some((_, figures)) = end_to_end.filter(|(_, figures)| figures.summary.count > 0) {
        let median = table::duration(figures.summary.p50_ns as f64);
        let reached = if report.settings.monitor_poll_ms.is_some() {
            "were published"
        } else {
            "reached a subscriber"
        };
        sentence.push_str(&format!("; half of the states {reached} within {median}"));
    }
    sentence.push('.');
    sentence
}

fn taken(report: &Report) -> u64 {
    report.sources.iter().map(|source| source.fusion[Counter::Taken]).sum()
}

fn were(count: u64, thing: &str) -> String {
    let verb = if count == 1 { "was" } else { "were" };
    format!("{} {verb}", several(count, thing))
}
