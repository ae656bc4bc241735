//! Deaths of fusion within a report, one life after the other in shared memory.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;

use bus::{Bus, LogReader, Mark, Publisher, Root, SharedMemory, Subscriber, TopicHold};
use configuration::Config;
use fusion::checkpoint::IN_WORK;
use fusion::suspects::report_key;
use messages::{Counter, Covariance, SensorTrack, StepKind, SystemTrack, TrackState, WorkStep, sensor_track_bits};
use runtime::housekeeping::Queues;
use runtime::instance::CHECKPOINT;
use runtime::{Agent as _, HealthEntry, Now, Speed, Turn};
use test_support::S;

use crate::agent::FusionAgent;

const DAY: i64 = 16_931 * 86_400 * S;
/// Epoch of the source's publisher.
const PUBLISHER: u64 = 1_700_000_000_123_456_789;

fn config() -> Config {
    let text = "name = \"t\"\n[frame]\nlatitude_deg = 0.0\nlongitude_deg = 0.0\n[time]\norder = \"arrival\"\n\
                date = \"2016-05-10\"\n[[source]]\nname = \"a\"\n[source.external]\n[recorder]\nenabled = false\n\
                [fusion.association]\nscan_wait = 0.0\n";
    Config::parse(Path::new("t.toml"), text, &[]).unwrap()
}

/// A deployment whose fusion dies again and again.
struct Site {
    config: Config,
    bus: Bus<SharedMemory>,
    _held: [TopicHold; 2],
    source: Publisher<SharedMemory, SensorTrack>,
    system: Subscriber<SharedMemory, SystemTrack>,
    log: LogReader<WorkStep>,
    queues: Arc<Queues>,
    now: Now,
}

/// Runs `test` at a site, whose shared memory is gone afterwards.
fn with_site(test: impl FnOnce(&mut Site)) {
    let folder = tempfile::Builder::new().prefix("k").tempdir_in("/tmp").unwrap();
    let root = Root::in_base(folder.path(), "t").unwrap();
    let claim = root.claim().unwrap();
    let mut site = Site::new(&root);
    test(&mut site);
    drop(site);
    root.remove_outlasting();
    claim.remove().unwrap();
}

impl Site {
    fn new(root: &Root) -> Self {
        let bus: Bus<SharedMemory> = Bus::open(root, "test").unwrap();
        bus.hold_log(&messages::event_log(), 1).unwrap();
        let topic = messages::sensor_tracks("a");
        Self {
            config: config(),
            _held: [bus.hold(&topic).unwrap(), bus.hold(&messages::system_tracks()).unwrap()],
            source: bus.publisher(&topic, PUBLISHER).unwrap(),
            system: bus.subscriber(&messages::system_tracks(), || 1).unwrap(),
            log: bus.log_reader(&messages::event_log()).unwrap(),
            queues: Queues::new(None),
            now: Now {
                mono_ns: 1,
                utc_ns: DAY,
            },
            bus,
        }
    }

    /// A fusion that resumes from what the one before has left.
    fn start(&self) -> FusionAgent<SharedMemory> {
        let (config, speed) = (&self.config, Speed::Factor(1.0));
        let queues = Arc::clone(&self.queues);
        FusionAgent::resumed(config, &config.engine, speed, &self.bus, 1, queues, self.now).unwrap()
    }

    /// Ends `agent` as a kill does while it works off the report with this number of the source.
    fn die_in(&self, agent: FusionAgent<SharedMemory>, sequence: u64) {
        drop(agent);
        let memory = self.bus.root().outlasting(CHECKPOINT).unwrap().unwrap();
        memory.words()[IN_WORK].store(report_key(0, PUBLISHER, sequence), Relaxed);
    }

    /// Sends a report of the target with this number.
    fn send(&mut self, target: u32) {
        let report = SensorTrack {
            time_of_measurement_ns: self.now.utc_ns,
            track_number: target,
            valid: sensor_track_bits::VELOCITY,
            position_m: [1e4 * f64::from(target), 0.0, 0.0],
            covariance: Covariance::diagonal([10.0, 10.0, 100.0], [2.0; 3]),
            state: TrackState::Confirmed as u8,
            ..SensorTrack::default()
        };
        let mark = Mark {
            progress_ns: i64::MIN,
            sent_ns: self.now.mono_ns,
            end: false,
        };
        self.source
            .send(mark, 1, |_, sequence| SensorTrack { sequence, ..report })
            .unwrap();
    }

    /// Works until nothing is left; the targets whose states were published.
    fn settle(&mut self, agent: &mut FusionAgent<SharedMemory>) -> Vec<u32> {
        let states = self.work(agent);
        states
            .iter()
            .map(|track| (track.position_m[0] / 1e4).round() as u32)
            .collect()
    }

    /// Works until nothing is left, for a second; the published states.
    fn work(&mut self, agent: &mut FusionAgent<SharedMemory>) -> Vec<SystemTrack> {
        while agent.turn(self.now).unwrap() == Turn::Worked {}
        self.now.mono_ns += S;
        self.now.utc_ns += S;
        let mut states = Vec::new();
        self.system
            .take(usize::MAX, |_, tracks| states.extend_from_slice(tracks))
            .unwrap();
        states
    }

    /// Numbers of the reports that the event log has, with their kind.
    fn logged(&mut self) -> Vec<(StepKind, u32)> {
        let mut reports = Vec::new();
        while let Some((_, steps)) = self.log.read() {
            let kinds = steps
                .iter()
                .map(|step| (StepKind::from_code(step.kind).unwrap(), step.sequence));
            reports.extend(kinds.filter(|(kind, _)| matches!(kind, StepKind::Report | StepKind::Quarantine)));
        }
        reports
    }

    fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.bus.root().base()).unwrap().flatten();
        let names = entries.map(|entry| entry.file_name().to_str().unwrap().to_owned());
        names.filter(|name| name.contains("quarantined")).collect()
    }
}

fn quarantined(agent: &FusionAgent<SharedMemory>) -> u64 {
    let mut entries: Vec<HealthEntry> = Vec::new();
    agent.health(&mut entries);
    assert_eq!(
        entries[0].counters[Counter::Quarantined],
        entries[1].counters[Counter::Quarantined]
    );
    entries[0].counters[Counter::Quarantined]
}

#[test]
fn a_report_in_which_fusion_dies_twice_is_passed_over_and_no_other() {
    with_site(|site| {
        let mut agent = site.start();
        (1..=3).for_each(|target| site.send(target));
        assert_eq!(site.settle(&mut agent), [1, 2, 3]);
        site.die_in(agent, 3);
        let agent = site.start();
        site.die_in(agent, 3);
        let mut agent = site.start();
        (4..=5).for_each(|target| site.send(target));
        assert_eq!(site.settle(&mut agent), [5]);
        assert_eq!(quarantined(&agent), 1);
        let expected = [0, 1, 2].map(|number| (StepKind::Report, number));
        let then = [(StepKind::Quarantine, 3), (StepKind::Report, 4)];
        assert_eq!(site.logged(), [&expected[..], &then].concat());
        assert_eq!(site.queues.quarantined.pop().map(|report| report.track_number), Some(4));
        assert_eq!(site.files(), ["t.checkpoint-quarantined"]);

        // The next report of the same target is used, and a later death elsewhere quarantines nothing.
        site.send(4);
        assert_eq!(site.settle(&mut agent), [4]);
        drop(agent);
        let agent = site.start();
        assert_eq!(quarantined(&agent), 0);
    });
}

#[test]
fn kills_from_outside_quarantine_nothing_and_lose_nothing() {
    with_site(|site| {
        let mut agent = site.start();
        site.send(1);
        assert_eq!(site.settle(&mut agent), [1]);
        for (target, sequence) in (2..8).zip(1..) {
            // A kill within the next report; then one between reports.
            site.die_in(agent, sequence);
            agent = site.start();
            site.send(target);
            assert_eq!(site.settle(&mut agent), [target]);
            drop(agent);
            agent = site.start();
        }
        assert_eq!(quarantined(&agent), 0);
        let reports: Vec<_> = (0..7).map(|number| (StepKind::Report, number)).collect();
        assert_eq!(site.logged(), reports);
        assert_eq!(site.files(), [""; 0]);
    });
}

#[test]
fn a_number_that_rests_outlives_a_killed_fusion() {
    with_site(|site| {
        let mut agent = site.start();
        let mut shown = Vec::new();
        for _ in 0..8 {
            (1..=2).for_each(|target| site.send(target));
            shown = site.work(&mut agent);
        }
        let numbers = |states: &[SystemTrack], state: TrackState| -> Vec<u32> {
            let of_state = states.iter().filter(|track| track.state == state as u8);
            of_state.map(|track| track.track_number).collect()
        };
        let both = numbers(&shown, TrackState::Confirmed);
        assert_eq!(both.len(), 2);
        // The second target alone is reported on; the number of the first rests.
        let mut meanwhile = Vec::new();
        for _ in 0..30 {
            site.send(2);
            meanwhile.extend(site.work(&mut agent));
        }
        assert_eq!(numbers(&meanwhile, TrackState::Suspended), both[..1]);
        for _ in 0..2 {
            drop(agent);
            agent = site.start();
            site.send(2);
            let states = site.work(&mut agent);
            assert_eq!(numbers(&states, TrackState::Confirmed), both[1..]);
            let is_of_second = |track: &SystemTrack| track.track_number == both[1];
            assert!(
                states.iter().all(is_of_second),
                "nobody is told of the number that rests"
            );
        }
        site.send(1);
        assert_eq!(numbers(&site.work(&mut agent), TrackState::Confirmed), both[..1]);
    });
}

#[test]
fn a_checkpoint_that_could_not_be_published_is_published_later_with_all_tracks() {
    with_site(|site| {
        let place = site.bus.root().base().join("t.checkpoint");
        std::fs::create_dir(&place).unwrap();
        let mut agent = site.start();
        let mut numbers = Vec::new();
        for _ in 0..8 {
            (1..=2).for_each(|target| site.send(target));
            numbers = site.work(&mut agent).iter().map(|track| track.track_number).collect();
        }
        assert_eq!(numbers.len(), 2);
        assert!(site.bus.root().outlasting(CHECKPOINT).is_err());
        std::fs::remove_dir(&place).unwrap();
        (1..=2).for_each(|target| site.send(target));
        site.work(&mut agent);
        drop(agent);
        let mut agent = site.start();
        (1..=2).for_each(|target| site.send(target));
        let after: Vec<u32> = site.work(&mut agent).iter().map(|track| track.track_number).collect();
        assert_eq!(after, numbers);
    });
}
