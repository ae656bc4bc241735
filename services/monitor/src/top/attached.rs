//! Joins a deployment as a reader, and detects the deployment's end.
//!
//! A deployment ends in either of two ways. The launcher announces the end, and waits two seconds for readers to leave
//! before removing the shared memory; or the launcher was killed, and no process holds the instance any more.

use std::time::Duration;

use anyhow::Context as _;
use bus::{Bus, BusError, Root, SharedMemory, Subscriber, Transport};
use messages::{Alarm, FrameOrigin, Health, SystemTrack};
use runtime::Now;

use super::watch::DeploymentWatch;
use crate::display::overview::Overview;

/// Name of this reader in the deployment.
const OWN_NAME: &str = "top";
/// Slices taken in a look: the length of the queue.
const SLICES_PER_LOOK: usize = 256;

/// Attachment to a deployment that runs.
pub(super) struct Attached<S: Transport> {
    states: Subscriber<S, SystemTrack>,
    health: Subscriber<S, Health>,
    origins: Subscriber<S, FrameOrigin>,
    alarms: Subscriber<S, Alarm>,
    _bus: Bus<S>,
    watch: DeploymentWatch,
    clock: fn() -> Now,
    /// When the interval at hand began.
    begun: Now,
    interval_ns: i64,
    root: Root,
}

/// Outcome of a look.
#[derive(Debug)]
pub(super) enum Look {
    /// Nothing is to be shown yet.
    Nothing,
    /// An interval is over.
    Interval(Box<Overview>),
    /// The deployment has ended.
    Ended,
}

impl Attached<SharedMemory> {
    /// Joins the deployment that runs under `root`.
    ///
    /// # Errors
    /// If the deployment does not run, or is just being started or stopped.
    pub(super) fn join(root: &Root, interval: Duration, clock: fn() -> Now) -> anyhow::Result<Self> {
        let joined = Bus::open(root, OWN_NAME).and_then(|bus| Self::new(root, bus, interval, clock));
        joined.map_err(|error| match error {
            BusError::NotRunning { .. } | BusError::NoSuchTopic { .. } => anyhow::anyhow!(
                "instance {} does not run, or is just being started or stopped; `koseki status` shows what runs",
                root.instance()
            ),
            error => error.into(),
        })
    }

    /// Takes the arrivals, and closes a finished interval.
    ///
    /// # Errors
    /// If shared memory fails although the deployment runs.
    pub(super) fn look(&mut self, now: Now) -> anyhow::Result<Look> {
        match self.look_at(now) {
            Ok(Look::Interval(overview)) if self.is_held()? => Ok(Look::Interval(overview)),
            Ok(Look::Interval(_)) => Ok(Look::Ended),
            Err(_) if !self.is_held()? => Ok(Look::Ended),
            look => Ok(look?),
        }
    }

    /// Whether anybody runs the instance.
    fn is_held(&self) -> anyhow::Result<bool> {
        let holder = self.root.holder();
        Ok(holder.context("looking whether the instance runs")?.is_some())
    }
}

impl<S: Transport> Attached<S> {
    /// Joins over `bus`.
    ///
    /// # Errors
    /// If a topic cannot be opened.
    pub(super) fn new(root: &Root, bus: Bus<S>, interval: Duration, clock: fn() -> Now) -> Result<Self, BusError> {
        let now_ns = || clock().mono_ns as u64;
        let begun = clock();
        Ok(Self {
            states: bus.subscriber(&messages::system_tracks(), now_ns)?,
            health: bus.subscriber(&messages::health(), now_ns)?,
            origins: bus.subscriber(&messages::frame_origin(), now_ns)?,
            alarms: bus.subscriber(&messages::alarms(), now_ns)?,
            _bus: bus,
            watch: DeploymentWatch::new(root.instance(), begun),
            clock,
            begun,
            interval_ns: interval.as_nanos() as i64,
            root: root.clone(),
        })
    }

    /// Name of the instance.
    pub(super) fn instance(&self) -> &str {
        self.root.instance()
    }

    /// As [`Attached::look`], without checking for a holder of the instance.
    pub(super) fn look_at(&mut self, now: Now) -> Result<Look, BusError> {
        let (watch, clock) = (&mut self.watch, self.clock);
        self.states
            .take(SLICES_PER_LOOK, |header, tracks| watch.receive(header, tracks, clock()))?;
        let observed = &mut watch.observed;
        self.origins.take(SLICES_PER_LOOK, |_, slice| {
            for origin in slice {
                observed.take_origin(origin);
            }
        })?;
        self.alarms
            .take(SLICES_PER_LOOK, |header, slice| observed.take_alarms(header, slice))?;
        self.health.take(SLICES_PER_LOOK, |_, slice| {
            slice.iter().for_each(|health| observed.take_health(health))
        })?;
        if observed.has_ended() {
            return Ok(Look::Ended);
        }
        let length_ns = now.mono_ns - self.begun.mono_ns;
        if length_ns < self.interval_ns {
            return Ok(Look::Nothing);
        }
        self.begun = now;
        let mut overview = self.watch.close_interval(now, length_ns, self.states.counts());
        overview.page = deployment::page_of(self.root.path());
        Ok(Look::Interval(Box::new(overview)))
    }
}

#[cfg(test)]
mod tests {
    use bus::{InProcess, Mark};
    use messages::{LifeState, ProcessKind};

    use super::*;

    const BEGUN: Now = Now {
        mono_ns: 100_000_000_000,
        utc_ns: 1_700_000_000_000_000_000,
    };

    fn after(ms: i64) -> Now {
        Now {
            mono_ns: BEGUN.mono_ns + ms * 1_000_000,
            utc_ns: BEGUN.utc_ns + ms * 1_000_000,
        }
    }

    #[test]
    fn intervals_are_shown_until_the_launcher_says_that_all_has_ended() {
        let folder = tempfile::tempdir().unwrap();
        let root = Root::in_base(folder.path(), "test").unwrap();
        let bus: Bus<InProcess> = Bus::open(&root, "launcher").unwrap();
        let _held = [
            bus.hold(&messages::system_tracks()).unwrap(),
            bus.hold(&messages::health()).unwrap(),
            bus.hold(&messages::frame_origin()).unwrap(),
            bus.hold(&messages::alarms()).unwrap(),
        ];
        let mut health = bus.publisher(&messages::health(), 200).unwrap();
        let mut tracks = bus.publisher(&messages::system_tracks(), 200).unwrap();
        let own: Bus<InProcess> = Bus::open(&root, OWN_NAME).unwrap();
        let mut attached = Attached::new(&root, own, Duration::from_millis(500), || BEGUN).unwrap();
        let mark = Mark {
            progress_ns: i64::MIN,
            sent_ns: 0,
            end: false,
        };
        let mut say = |life: LifeState| {
            let health_of_launcher = Health {
                kind: ProcessKind::Launcher as u8,
                life: life as u8,
                ..Health::default()
            };
            let launcher = health_of_launcher.with_name("launcher");
            health.send(mark, 1, |_, _| launcher).unwrap();
        };
        say(LifeState::Running);
        tracks.send(mark, 100, |_, _| SystemTrack::default()).unwrap();
        assert!(matches!(attached.look_at(after(499)).unwrap(), Look::Nothing));
        let Look::Interval(overview) = attached.look_at(after(500)).unwrap() else {
            panic!("the interval is over")
        };
        assert_eq!(
            (overview.instance.as_str(), overview.interval_ns),
            ("test", 500_000_000)
        );
        assert_eq!((overview.processes.len(), overview.missed), (1, 0));
        assert!(matches!(attached.look_at(after(501)).unwrap(), Look::Nothing));
        say(LifeState::Finished);
        assert!(matches!(attached.look_at(after(502)).unwrap(), Look::Ended));
    }
}
