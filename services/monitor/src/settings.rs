//! Keys of the monitor.

use std::net::SocketAddr;
use std::time::Duration;

use deployment::{Deployment, Fusion, Parts, ReportOrder};
use settings::{KeyTable, Seconds, SettingsError};
use telemetry::{Deadlines, Stage};
use web::HostName;

settings::settings! {
    /// Keys of a deployment's file.
    pub struct Keys {
        /// Monitor process.
        monitor: Settings = Settings::default();
    }

    /// The monitor process.
    pub struct Settings {
        check Settings::check;
        /// Time between two tables.
        interval_s: Seconds = Seconds::of(1.0), in [0.1, 3600];
        /// Whether the monitor writes its files (histogram log, percentiles, JSON).
        files: bool = true;
        /// Kind of waiting for system tracks: `event`, woken for each slice; `poll`, periodic reads, which cost fusion
        /// nothing.
        wait: Option<MonitorWaitWord> = None, usually "event if fusion waits by event, else poll";
        /// Pause between two reads. System tracks that wait longer in the monitor's queue are replaced by newer
        /// tracks, even at low rates.
        poll_ms: f64 = 5.0, in [0.5, 100];
        /// Greatest permitted duration of each stage, without the wait of a report for the end of its scan.
        deadline_us: DeadlineTable = DeadlineTable::default();
        /// Address and port where metrics for Prometheus are served.
        prometheus: Option<String> = None;
        /// Allows an address that other machines can reach.
        prometheus_public: bool = false;
        /// Names of this machine, besides its address and localhost, that requests for metrics may use.
        prometheus_hosts: Vec<HostName> = Vec::new(), usually "none";
        /// Limits beyond which alarms are raised.
        alarms: alarms::Limits = alarms::Limits::default();
    }

    /// Deadlines of the stages, in microseconds. A duration beyond the histograms' range does not count as a latency,
    /// and could never be a miss.
    pub struct DeadlineTable {
        /// In the adapter: from the report's last byte to its hand-over to shared memory.
        ingest_to_publish: Option<f64> = None, in [0.1, LATENCY_MAX_US];
        /// Transport in: until fusion takes the sample.
        publish_to_taken: Option<f64> = None, in [0.1, LATENCY_MAX_US];
        /// In fusion: until the system track was handed over to shared memory.
        taken_to_fused: Option<f64> = None, in [0.1, LATENCY_MAX_US], usually "that of fusion";
        /// Transport out: until the subscriber has the sample.
        fused_to_received: Option<f64> = None, in [0.1, LATENCY_MAX_US];
        /// All of these: from the report's last byte to the subscriber.
        end_to_end: Option<f64> = None, in [0.1, LATENCY_MAX_US];
        /// Age of the data: from the measurement to the subscriber, between the sensor's clock and this machine's
        /// (UTC).
        age: Option<f64> = None, in [0.1, LATENCY_MAX_US];
    }
}

settings::words! {
    /// Words for how the monitor waits.
    pub enum MonitorWaitWord {
        /// Woken for each slice.
        Event = "event",
        /// Looks now and then.
        Poll = "poll",
    }
}

/// Longest latency that can be measured, microseconds.
const LATENCY_MAX_US: f64 = telemetry::VALUE_MAX_NS as f64 / 1e3;

/// How the monitor waits for system tracks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MonitorWait {
    /// Woken for each slice: exact, at the price of a system call of fusion's per slice.
    Event,
    /// Looks now and then, which costs fusion nothing: what comes after fusion is not measured.
    Poll {
        /// Time between two looks.
        pause: Duration,
    },
}

impl Settings {
    fn check(&self) -> Result<(), SettingsError> {
        let Some(text) = &self.prometheus else { return Ok(()) };
        let key = "prometheus";
        let address: SocketAddr = text.parse().map_err(|_| {
            let what = format!("\"{text}\" is no address with a port; write it as in \"127.0.0.1:9464\"");
            SettingsError::new(key, what)
        })?;
        if !address.ip().is_loopback() && !self.prometheus_public {
            let what = format!(
                "{text} can be reached from other machines, and whoever can reach it reads everything; use 127.0.0.1, or \
                 set prometheus_public = true beside it"
            );
            return Err(SettingsError::new(key, what));
        }
        Ok(())
    }

    /// Returns how the monitor waits for the system tracks of `fusion`.
    pub fn waiting(&self, fusion: &Fusion) -> MonitorWait {
        let polls = match self.wait {
            Some(wait) => wait == MonitorWaitWord::Poll,
            // A core that spins for low latency should not pay a system call per slice for being watched.
            None => fusion.wait != deployment::WaitWord::Event,
        };
        match polls {
            true => MonitorWait::Poll {
                pause: Duration::from_nanos((self.poll_ms * 1e6) as u64),
            },
            false => MonitorWait::Event,
        }
    }

    /// Returns the time that each stage of `deployment` may take; fusion's own stage always has a deadline.
    pub fn deadlines(&self, deployment: &Deployment) -> Deadlines {
        if deployment.order == ReportOrder::Time {
            // Reports wait for each other by intention: none is late.
            return Deadlines::default();
        }
        self.configured_deadlines(&deployment.fusion)
    }

    /// Returns the configured deadlines, whether or not reports can be late.
    pub fn configured_deadlines(&self, fusion: &Fusion) -> Deadlines {
        let of_fusion = Deadlines::default().with(Stage::TakenToFused, Some(fusion.deadline_ns() as u64));
        let given = self.deadline_us.given().into_iter();
        given.fold(of_fusion, |deadlines, (stage, given_us)| match given_us {
            Some(given_us) => deadlines.with(stage, Some((given_us * 1e3) as u64)),
            None => deadlines,
        })
    }

    /// Returns the address of the metrics for Prometheus; `None`: there are none.
    pub fn metrics(&self) -> Option<SocketAddr> {
        self.prometheus.as_ref()?.parse().ok()
    }
}

impl DeadlineTable {
    fn given(&self) -> [(Stage, Option<f64>); 6] {
        [
            (Stage::IngestToPublish, self.ingest_to_publish),
            (Stage::PublishToTaken, self.publish_to_taken),
            (Stage::TakenToFused, self.taken_to_fused),
            (Stage::FusedToReceived, self.fused_to_received),
            (Stage::EndToEnd, self.end_to_end),
            (Stage::Age, self.age),
        ]
    }
}

impl Parts for Keys {
    fn tables(&mut self) -> Vec<&mut dyn KeyTable> {
        vec![self]
    }

    fn join(&self, deployment: &mut Deployment) -> Result<(), SettingsError> {
        let settings = &self.monitor;
        let polls = settings.waiting(&deployment.fusion) != MonitorWait::Event;
        if settings.deadline_us.fused_to_received.is_some() && polls {
            let what =
                "a monitor that polls does not measure this stage; set monitor.wait = \"event\", or leave it out";
            let key = format!("monitor.deadline_us.{}", Stage::FusedToReceived.key());
            return Err(SettingsError::new(key, what));
        }
        deployment.services.monitor_files = settings.files;
        Ok(())
    }
}
