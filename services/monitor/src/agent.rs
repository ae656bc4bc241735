//! Duty cycle of the monitor.

use std::path::PathBuf;
use std::time::Duration;

use anyhow::Context as _;
use bus::{Bus, Mark, Publisher, Subscriber, Transport, WaitMode, Waiter};
use deployment::Deployment;
use messages::{FrameOrigin, Health, SystemTrack};
use runtime::{Agent, HealthEntry, Now, Options, Turn};

use web::HostName;

use crate::alarm_desk::AlarmDesk;
use crate::files::Files;
use crate::metrics::Metrics;
use crate::report::AlarmReport;
use crate::screen::Screen;
use crate::settings::{MonitorWait, Settings};
use crate::survey::DeploymentSurvey;
use crate::truth_watch::SimulatedTargets;

/// Maximum number of slices taken in a turn: the length of the queue.
const SLICES_PER_TURN: usize = 256;
/// Turns at the end in which waiting slices are still taken, in case a publisher continues.
const TURNS_AT_CLOSE: usize = 1000;
/// Number of looks for the other processes' last messages at the end, and the pause between two looks.
const LOOKS_FOR_LAST_WORDS: usize = 50;
const PAUSE_BETWEEN_LOOKS: Duration = Duration::from_millis(10);
/// Longest sleep: no health message may wait until another message needs the place in the queue.
const SLEEP_MAX_NS: i64 = 100_000_000;

/// Period of messages about the origin of the system frame, nanoseconds.
const ORIGIN_PERIOD_NS: i64 = 200_000_000;

/// Reads both clocks.
pub type ClockReader = Box<dyn Fn() -> Now>;

/// Monitor as an agent, generic over the transport: tests run it in process.
pub struct MonitorAgent<S: Transport> {
    survey: DeploymentSurvey,
    states: Subscriber<S, SystemTrack>,
    health: Subscriber<S, Health>,
    /// Publisher of the origin of the system frame, for readers without the configuration.
    origins: Publisher<S, FrameOrigin>,
    origin: FrameOrigin,
    /// Time of the next message about the origin, monotonic, nanoseconds.
    origin_due_ns: i64,
    alarms: AlarmDesk<S>,
    waiting: TrackWait<S>,
    clock: ClockReader,
    screen: Screen,
    /// Folder of the instance.
    folder: PathBuf,
    files: Option<Files>,
    /// Server of metrics, or the reason for its absence.
    metrics: Option<Result<Metrics, String>>,
    /// Start of the present interval.
    begun: Now,
    interval_ns: i64,
}

/// Way of waiting for system tracks.
enum TrackWait<S: Transport> {
    /// Sleep until a notification.
    Event(Waiter<S>),
    /// Sleep for a fixed time. Without a listener, no publisher wakes the monitor.
    Poll(Duration),
}

impl<S: Transport> TrackWait<S> {
    fn new(wait: MonitorWait, bus: &Bus<S>) -> anyhow::Result<Self> {
        match wait {
            MonitorWait::Event => {
                let mut waiter = bus.waiter(WaitMode::Event);
                waiter.watch(bus, &messages::system_tracks())?;
                Ok(Self::Event(waiter))
            }
            MonitorWait::Poll { pause } => Ok(Self::Poll(pause)),
        }
    }

    fn wait(&mut self, at_most: Duration, states: &Subscriber<S, SystemTrack>) -> anyhow::Result<()> {
        match self {
            Self::Event(waiter) => {
                waiter.wait(at_most, || states.has_slices())?;
            }
            Self::Poll(_) => std::thread::sleep(self.at_most(at_most)),
        }
        Ok(())
    }

    /// Returns the time to sleep if nothing is due for `sleep`.
    fn at_most(&self, sleep: Duration) -> Duration {
        match self {
            Self::Event(_) => sleep,
            Self::Poll(pause) => sleep.min(*pause),
        }
    }
}

impl<S: Transport> MonitorAgent<S> {
    /// Creates a monitor called `name` on `bus`.
    ///
    /// The monitor called `monitor` writes its files to the deployment's folder; an additional monitor writes to a
    /// subfolder of the same name.
    ///
    /// # Errors
    /// If a topic cannot be opened or a file cannot be created.
    /// If a topic cannot be opened or a file not be made.
    pub fn new(
        (config, settings): (&Deployment, &Settings),
        options: &Options,
        name: &str,
        bus: &Bus<S>,
        clock: ClockReader,
        screen: Screen,
    ) -> anyhow::Result<Self> {
        let topic = messages::system_tracks();
        let waiting = TrackWait::new(settings.waiting(&config.fusion), bus)?;
        let now_ns = || clock().mono_ns as u64;
        let (states, health) = (
            bus.subscriber(&topic, now_ns)?,
            bus.subscriber(&messages::health(), now_ns)?,
        );
        let begun = clock();
        let origin = config.frame.to_geodetic([0.0; 3]);
        let folder = match name {
            "monitor" => options.out.clone(),
            other => options.out.join(other),
        };
        let files = || Files::create(&folder, begun.utc_ns);
        let survey = DeploymentSurvey::new((config, settings), options, name, begun);
        let hosts: Vec<String> = settings
            .prometheus_hosts
            .iter()
            .map(HostName::in_small_letters)
            .collect();
        let serve = |address| {
            let begin = survey.snapshot(begun, states.counts());
            Metrics::serve(address, &hosts, begin).map_err(|error| format!("{error:#}"))
        };
        Ok(Self {
            metrics: settings.metrics().map(serve),
            folder: bus.root().path().to_owned(),
            survey,
            states,
            health,
            origins: bus.publisher(&messages::frame_origin(), begun.mono_ns as u64)?,
            origin: FrameOrigin {
                latitude_deg: origin.latitude_deg(),
                longitude_deg: origin.longitude_deg(),
                height_m: origin.height_m(),
            },
            origin_due_ns: i64::MIN,
            alarms: AlarmDesk::new((config, settings), name, &folder, bus, begun)?,
            waiting,
            clock,
            screen,
            files: settings.files.then(files).transpose()?,
            begun,
            interval_ns: settings.interval_s.ns(),
        })
    }

    /// Compares the picture with the targets of a simulated world from now on.
    pub fn compare_with(&mut self, targets: SimulatedTargets) {
        self.survey.compare_with(targets);
    }

    /// Returns the address of the metrics, or the reason for their absence; `None` without configured metrics.
    pub fn metrics(&self) -> Option<Result<String, &str>> {
        let metrics = self.metrics.as_ref()?;
        Some(metrics.as_ref().map(Metrics::url).map_err(String::as_str))
    }

    /// Publishes the origin of the system frame when due.
    fn say_origin(&mut self, now: Now) -> anyhow::Result<()> {
        if now.mono_ns < self.origin_due_ns {
            return Ok(());
        }
        self.origin_due_ns = now.mono_ns + ORIGIN_PERIOD_NS;
        let mark = Mark {
            progress_ns: i64::MIN,
            sent_ns: now.mono_ns,
            end: false,
        };
        let origin = self.origin;
        self.origins.send(mark, 1, |_, _| origin)?;
        Ok(())
    }

    /// Takes waiting slices. Returns whether more may be waiting.
    fn take(&mut self) -> anyhow::Result<bool> {
        let (survey, alarms, clock) = (&mut self.survey, &mut self.alarms, &self.clock);
        let slices = self.states.take(SLICES_PER_TURN, |header, tracks| {
            let received = clock();
            survey.receive(header, tracks, received);
            alarms.receive(header, tracks, received);
        })?;
        let of_health = self.health.take(SLICES_PER_TURN, |_, slice| {
            slice.iter().for_each(|health| survey.observed.take_health(health))
        })?;
        Ok(slices == SLICES_PER_TURN || of_health == SLICES_PER_TURN)
    }

    fn take_all(&mut self) -> anyhow::Result<()> {
        for _ in 0..TURNS_AT_CLOSE {
            if !self.take()? {
                break;
            }
        }
        Ok(())
    }

    /// Closes the present interval. Returns the interval's length, nanoseconds.
    ///
    /// With many sources this takes longer than the queue of system tracks lasts. The interval is therefore closed in
    /// parts, and waiting slices are taken in between.
    fn close_interval(&mut self, now: Now) -> anyhow::Result<i64> {
        while self.survey.observed.close_next_source() {
            self.take()?;
        }
        self.log_interval(now)
    }

    /// Writes the closed interval and begins the next. Returns the closed interval's length, nanoseconds.
    fn log_interval(&mut self, now: Now) -> anyhow::Result<i64> {
        let length_ns = now.mono_ns - self.begun.mono_ns;
        if self.files.is_some() {
            let sources: Vec<u16> = self.survey.observed.stages().sources().collect();
            for source in [None].into_iter().chain(sources.into_iter().map(Some)) {
                if let Some(files) = &mut self.files {
                    let survey = &self.survey;
                    let name = |number| survey.source_name(number);
                    files.log_interval(survey.observed.stages(), source, self.begun.utc_ns, length_ns, name);
                }
                self.take()?;
            }
        }
        if let Some(Ok(metrics)) = &self.metrics {
            let mut snapshot = self.survey.snapshot(now, self.states.counts());
            snapshot.alarms = self.alarm_reports();
            metrics.hand_over(snapshot);
        }
        self.begun = now;
        Ok(length_ns)
    }

    fn look_at_alarms(&mut self, now: Now) -> anyhow::Result<()> {
        let screen = &mut self.screen;
        self.alarms.turn(now, &mut self.survey, &mut |line| screen.say(line))
    }

    /// Returns the alarms raised so far.
    fn alarm_reports(&self) -> Vec<AlarmReport> {
        let name = |number| self.survey.source_name(number).to_owned();
        self.alarms
            .history()
            .map(|alarm| AlarmReport::new(alarm, name))
            .collect()
    }

    /// Returns the monitor's fault in a few words; empty without a fault.
    fn note(&self) -> String {
        let of_files = self.files.as_ref().map(Files::note).filter(|note| !note.is_empty());
        let of_metrics = || match &self.metrics {
            Some(Err(refusal)) => Some(refusal.clone()),
            _ => None,
        };
        of_files.or_else(of_metrics).unwrap_or_default()
    }

    /// Waits for the processes that end together with the monitor, perhaps a moment later.
    fn wait_for_last_words(&mut self) -> anyhow::Result<()> {
        for _ in 0..LOOKS_FOR_LAST_WORDS {
            self.take_all()?;
            if self.survey.others_have_ended((self.clock)()) {
                break;
            }
            self.wait(PAUSE_BETWEEN_LOOKS)?;
        }
        self.take_all()
    }
}

impl<S: Transport> Agent for MonitorAgent<S> {
    fn turn(&mut self, now: Now) -> anyhow::Result<Turn> {
        // The complete second first, then the rest.
        self.survey.pass(now);
        self.say_origin(now)?;
        let more = self.take()?;
        self.look_at_alarms(now)?;
        if now.mono_ns - self.begun.mono_ns >= self.interval_ns {
            let length_ns = self.close_interval(now)?;
            let mut overview = self
                .survey
                .overview(now, length_ns, self.states.counts(), self.alarms.standing());
            overview.page = deployment::page_of(&self.folder);
            self.screen.show(&overview);
        }
        if more {
            return Ok(Turn::Worked);
        }
        let until_interval_ns = self.begun.mono_ns + self.interval_ns - now.mono_ns;
        let until_due_ns = self.survey.due_utc_ns().saturating_sub(now.utc_ns);
        let sleep_ns = until_interval_ns.min(until_due_ns).clamp(0, SLEEP_MAX_NS);
        Ok(Turn::Idle(self.waiting.at_most(Duration::from_nanos(sleep_ns as u64))))
    }

    fn wait(&mut self, at_most: Duration) -> anyhow::Result<()> {
        self.waiting.wait(at_most, &self.states)
    }

    fn health(&self, entries: &mut Vec<HealthEntry>) {
        entries.push(HealthEntry {
            note: self.note(),
            counters: self.survey.own_counters(self.states.counts()),
            ..HealthEntry::default()
        });
        entries.extend(
            self.survey
                .own_counters_by_source()
                .map(|(source, counters)| HealthEntry {
                    source,
                    counters,
                    ..HealthEntry::default()
                }),
        );
    }

    fn close(&mut self, now: Now) -> anyhow::Result<()> {
        let looked = self.look_at_alarms(now);
        let taken = self.wait_for_last_words().and(looked);
        // Without pause: later slices would be missing from the report.
        self.survey.observed.close_interval();
        let taken = taken.and(self.log_interval((self.clock)()).map(drop));
        let report = self.survey.report(now, self.states.counts(), self.alarm_reports());
        self.screen.end(&report);
        let survey = &self.survey;
        let finish =
            |files: Files| files.finish(survey.observed.stages(), &report, |number| survey.source_name(number));
        let finished = self.files.take().map_or(Ok(()), finish);
        let shown = match self.screen.failure() {
            None => Ok(()),
            Some(error) => Err(error).context("writing to standard output"),
        };
        taken.and(finished).and(shown)
    }
}
