//! Checking what the file says of the monitor.

use std::net::SocketAddr;
use std::time::Duration;

use bus::WaitMode;
use telemetry::{Deadlines, Stage};

use settings::SettingsError;

use super::check::Checked;
use super::check_display::hosts;
use super::tables::{DeadlineTable, MonitorTable, MonitorWord};
use deployment::{Fusion, Monitor, MonitorWait};

pub(super) fn check_monitor(raw: &MonitorTable, fusion: &Fusion) -> Checked<Monitor> {
    let polls = match raw.wait {
        Some(wait) => wait == MonitorWord::Poll,
        // A core that spins for low latency should not pay a system call per slice for being watched.
        None => fusion.wait != WaitMode::Event,
    };
    let wait = match polls {
        true => MonitorWait::Poll {
            pause: Duration::from_nanos((raw.poll_ms * 1e6) as u64),
        },
        false => MonitorWait::Event,
    };
    Ok(Monitor {
        interval_ns: raw.interval_s.ns(),
        files: raw.files,
        wait,
        deadlines: deadlines(&raw.deadline_us, wait, fusion.deadline_ns)?,
        alarms: raw.alarms,
        metrics_hosts: hosts("monitor.prometheus_hosts", &raw.prometheus_hosts)?,
        metrics: raw
            .prometheus
            .as_deref()
            .map(|address| metrics(address, raw.prometheus_public))
            .transpose()?,
    })
}

fn deadlines(raw: &DeadlineTable, wait: MonitorWait, fusion_ns: i64) -> Checked<Deadlines> {
    let given_us = [
        (Stage::IngestToPublish, raw.ingest_to_publish),
        (Stage::PublishToTaken, raw.publish_to_taken),
        (Stage::TakenToFused, raw.taken_to_fused),
        (Stage::FusedToReceived, raw.fused_to_received),
        (Stage::EndToEnd, raw.end_to_end),
        (Stage::Age, raw.age),
    ];
    let mut deadlines = Deadlines::default().with(Stage::TakenToFused, Some(fusion_ns as u64));
    for (stage, given_us) in given_us {
        let Some(given_us) = given_us else { continue };
        let key = format!("monitor.deadline_us.{}", stage.key());
        if stage == Stage::FusedToReceived && wait != MonitorWait::Event {
            let what =
                "a monitor that polls does not measure this stage; set monitor.wait = \"event\", or leave it out";
            return Err(SettingsError::new(key, what));
        }
        deadlines = deadlines.with(stage, Some((given_us * 1e3) as u64));
    }
    Ok(deadlines)
}

/// Where metrics are served.
fn metrics(text: &str, public: bool) -> Checked<SocketAddr> {
    let key = "monitor.prometheus";
    let address: SocketAddr = text.parse().map_err(|_| {
        let what = format!("\"{text}\" is no address with a port; write it as in \"127.0.0.1:9464\"");
        SettingsError::new(key, what)
    })?;
    if !address.ip().is_loopback() && !public {
        let what = format!(
            "{text} can be reached from other machines, and whoever can reach it reads everything; use 127.0.0.1, or set \
             prometheus_public = true beside it"
        );
        return Err(SettingsError::new(key, what));
    }
    Ok(address)
}
