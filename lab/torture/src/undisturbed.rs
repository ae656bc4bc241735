//! The run without faults: the same sensors in the same world, received and fused in this process.
//!
//! The judge's limits are ratios to this run. The run has no processes, no network and no clock, so that nothing can
//! disturb the run, and keeps a second ahead of the deployment. The sensors' datagrams go through the decoders,
//! pipelines and the engine of the deployment's processes.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};

use asterix::{Decoder, StatedTables, blocks};
use deployment::{Deployment, Input};
use formats::observation::{self, Reading};
use fusion::Engine;
use messages::{NO_SOURCE, NS_PER_S, SystemTrack, TrackState};
use observations::EmitterMeasurement;
use runtime::clock::Now;
use scenario::{Instrument, SimulatedDirectionFinder, TargetState, Truth};
use simulator::SensorFeed;
use sources::{Pipeline, Samples, SourceReading};
use tracking::wide_area::arrivals::Arrivals;

use crate::judge::event::Undisturbed;
use crate::judge::world::{distance, moved};

/// Seed of the traffic, independent of the faults: other faults must not change the victims.
pub(super) const SEED: u64 = 1;
/// A track farther from every target than this is a sensor's false target, metres.
const STRANGER_M: f64 = 1000.0;

/// Engines of the deployment's processes.
#[derive(Debug)]
pub struct Engines {
    /// Settings of fusion.
    pub fusion: fusion::Settings,
    /// How the data of each source are read, in the order of numbers.
    pub readings: Vec<SourceReading>,
    /// The simulated world, and the observers.
    pub world: scenario::World,
}

/// See the module's documentation.
pub(super) struct UndisturbedRun {
    observers: Vec<Observer>,
    begin_utc_ns: i64,
    engine: Engine,
    tracks: BTreeMap<u32, Shown>,
    locators: BTreeSet<u16>,
}

/// A simulated sensor, and the processing of the sensor's data.
struct Observer {
    instrument: Sender,
    pipeline: Pipeline,
}

enum Sender {
    Asterix(Box<SensorFeed>, Box<Decoder>),
    Bearings(Box<SimulatedDirectionFinder>),
}

/// The newest state of a confirmed track.
struct Shown {
    state: SystemTrack,
    /// States in the present second caused by reports, except states of locators.
    states: u32,
}

/// Tracks of the run at a second.
#[derive(Default)]
pub(super) struct Picture {
    /// The track of each target, and the target's place.
    pub(super) targets: BTreeMap<u32, (Undisturbed, [f64; 2])>,
    /// Places of all other tracks.
    pub(super) strangers_m: Vec<[f64; 2]>,
}

impl UndisturbedRun {
    /// The run of the simulated sensors of `config`, from `begin_utc_ns` on. Arrays of direction finders are left out.
    ///
    /// # Errors
    /// If the settings are unusable.
    pub(super) fn new(config: &Deployment, engines: Engines, begin: Now) -> anyhow::Result<Self> {
        let mut observers = Vec::new();
        for (source, reading) in config.sources.iter().zip(&engines.readings) {
            let Input::Simulated(live) = &source.input else {
                continue;
            };
            let Some(instrument) = engines.world.instrument(source.number) else {
                continue;
            };
            let instrument = match instrument {
                Instrument::Sensor(settings) => {
                    let feed = SensorFeed::new((source, config.frame), settings, SEED, begin.utc_ns)?;
                    Sender::Asterix(
                        Box::new(feed),
                        Box::new(StatedTables::new(&live.asterix.editions, live.asterix.is_strict).decoder()),
                    )
                }
                Instrument::DirectionFinder { settings, array: None } => {
                    let finder = SimulatedDirectionFinder::new(settings, SEED, source.number, begin.utc_ns)?;
                    Sender::Bearings(Box::new(finder))
                }
                Instrument::DirectionFinder { array: Some(_), .. } | Instrument::Ais(_) => continue,
            };
            observers.push(Observer {
                instrument,
                pipeline: Pipeline::new(reading.model, &reading.processing, begin.utc_ns, Arrivals::new())?,
            });
        }
        Ok(Self {
            observers,
            begin_utc_ns: begin.utc_ns,
            engine: Engine::new(engines.fusion)?,
            tracks: BTreeMap::new(),
            locators: locators(config),
        })
    }

    /// Goes on to the next second; returns the picture then.
    pub(super) fn next(&mut self, second: u32, truth: &Truth) -> Picture {
        let end_s = f64::from(second);
        self.tracks.values_mut().for_each(|shown| shown.states = 0);
        let by_due = |one: &&mut Observer, other: &&mut Observer| one.due_s().total_cmp(&other.due_s());
        while let Some(observer) = self
            .observers
            .iter_mut()
            .min_by(by_due)
            .filter(|next| next.due_s() <= end_s)
        {
            let now_ns = self.begin_utc_ns + (observer.due_s() * NS_PER_S) as i64;
            let samples = observer.deliver(truth, now_ns);
            let (tracks, locators) = (&mut self.tracks, &self.locators);
            for report in &samples.tracks {
                let taken = &mut |state: &SystemTrack| take(tracks, state, locators);
                self.engine.take_at(report, now_ns, taken);
            }
        }
        let now_ns = self.begin_utc_ns + (end_s * NS_PER_S) as i64;
        self.picture(now_ns, &truth.at(end_s).collect::<Vec<_>>())
    }

    fn picture(&self, now_ns: i64, truth: &[TargetState]) -> Picture {
        let mut picture = Picture::default();
        for Shown { state, states } in self.tracks.values() {
            let age_s = (now_ns - state.reference_time_ns) as f64 / NS_PER_S;
            let place_m = moved(state.position_m, state.velocity_mps, age_s);
            let Some((error_m, target)) = nearest(truth, place_m, state.identity.address()) else {
                picture.strangers_m.push([place_m[0], place_m[1]]);
                continue;
            };
            let seen = Undisturbed {
                states: *states,
                has_address: state.identity.address().is_some(),
                has_height: state.height_valid != 0,
                has_velocity: state.velocity_valid != 0,
                age_s,
                errors: [
                    error_m,
                    (place_m[2] - target.position_m[2]).abs(),
                    distance(state.velocity_mps, target.velocity_mps),
                ],
            };
            let rank = |seen: &Undisturbed| (!seen.has_address, seen.age_s);
            let place_m = [place_m[0], place_m[1]];
            match picture.targets.entry(target.address) {
                Entry::Vacant(none) => drop(none.insert((seen, place_m))),
                Entry::Occupied(mut before) if rank(&seen) < rank(&before.get().0) => {
                    picture.strangers_m.push(before.insert((seen, place_m)).1);
                }
                Entry::Occupied(_) => picture.strangers_m.push(place_m),
            }
        }
        picture
    }
}

impl Observer {
    fn due_s(&self) -> f64 {
        match &self.instrument {
            Sender::Asterix(feed, _) => feed.due_s(),
            Sender::Bearings(finder) => finder.next_delivery_s(),
        }
    }

    /// The samples of the next delivery.
    fn deliver(&mut self, truth: &Truth, now_ns: i64) -> Samples {
        let (mut samples, pipeline) = (Samples::default(), &mut self.pipeline);
        pipeline.received(now_ns, now_ns);
        match &mut self.instrument {
            Sender::Asterix(feed, decoder) => feed.deliver(truth, now_ns, &mut |datagram| {
                for record in decoder.records_of(blocks(datagram), datagram.len()).flatten() {
                    match observation::read(&record) {
                        Reading::Target(observed) => pipeline.take(&observed, now_ns, &mut samples),
                        Reading::Service(service) => pipeline.service(&service, now_ns, &mut samples),
                        Reading::Other => {}
                    }
                }
            }),
            Sender::Bearings(finder) => {
                let mut bearings = Vec::new();
                finder.listen(truth, &mut bearings);
                for bearing in bearings {
                    pipeline.emitter(&EmitterMeasurement::Bearing(bearing), now_ns, &mut samples);
                }
            }
        }
        pipeline.elapsed(now_ns, now_ns, &mut samples);
        samples
    }
}

/// Sources with located tracks, by numbers.
pub(super) fn locators(config: &Deployment) -> BTreeSet<u16> {
    let sources = config.sources.iter().filter(|source| source.has_bearings());
    sources.map(|source| source.number).collect()
}

fn take(tracks: &mut BTreeMap<u32, Shown>, state: &SystemTrack, locators: &BTreeSet<u16>) {
    let is_shown = [TrackState::Confirmed, TrackState::Coasted]
        .map(|life| life as u8)
        .contains(&state.state);
    if !is_shown {
        tracks.remove(&state.track_number);
        return;
    }
    let shown = tracks.entry(state.track_number).or_insert(Shown {
        state: *state,
        states: 0,
    });
    shown.state = *state;
    let is_counted = state.trigger_source != NO_SOURCE && !locators.contains(&state.trigger_source);
    shown.states += u32::from(is_counted);
}

/// The target of this address, else the nearest, if near enough; with the distance in the plane, metres.
fn nearest(truth: &[TargetState], place_m: [f64; 3], address: Option<u32>) -> Option<(f64, &TargetState)> {
    let candidates = truth
        .iter()
        .filter(|target| address.is_none_or(|address| target.address == address));
    let distances = candidates.map(|target| (distance(target.position_m, place_m), target));
    distances
        .filter(|(distance_m, _)| *distance_m < STRANGER_M)
        .min_by(|(one, _), (other, _)| one.total_cmp(other))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use configuration::{BUILT_IN_TORTURE, Config};
    use deployment::Input;

    use super::*;

    /// Times at which sensors restart, and end of a run, seconds.
    const RESTARTS_S: [u32; 3] = [30, 60, 90];
    const END_S: u32 = 110;

    impl UndisturbedRun {
        fn restart(&mut self, source: usize, time_s: f64) {
            match &mut self.observers[source].instrument {
                Sender::Asterix(feed, _) => feed.restart_at(time_s),
                Sender::Bearings(finder) => finder.restart_at(time_s),
            }
        }

        fn numbers(&self) -> BTreeMap<u32, u32> {
            let states = self.tracks.values().map(|shown| &shown.state);
            let named = |state: &SystemTrack| Some((state.identity.address()?, state.track_number));
            states.filter_map(named).collect()
        }
    }

    /// Tracks too many at each second, and the numbers of the targets at the first restart and at the end, of a run in
    /// which these sources, as bits, restart three times.
    fn run(restarted: u32) -> (Vec<usize>, [BTreeMap<u32, u32>; 2]) {
        let config = Config::read(Path::new(BUILT_IN_TORTURE), &[]).expect("built in");
        let truth = Truth::new(config.world.targets.as_ref().expect("simulated"), SEED).expect("valid");
        let truth = truth.round(config.deployment.frame);
        let begin = Now {
            mono_ns: 0,
            utc_ns: 1_780_000_000_000_000_000,
        };
        let engines = Engines {
            fusion: config.engine,
            readings: config.readings.sources,
            world: config.world,
        };
        let mut run = UndisturbedRun::new(&config.deployment, engines, begin).expect("valid");
        let sensors = config
            .deployment
            .sources
            .iter()
            .filter(|source| matches!(source.input, Input::Simulated(_)));
        let (sensors, mut extra, mut before) = (sensors.count(), Vec::new(), BTreeMap::new());
        for second in 0..END_S {
            if second == RESTARTS_S[0] {
                before = run.numbers();
            }
            if RESTARTS_S.contains(&second) {
                let chosen = (0..sensors).filter(|source| restarted & (1 << source) != 0);
                chosen.for_each(|source| run.restart(source, f64::from(second) + 0.01));
            }
            extra.push(run.next(second, &truth).strangers_m.len());
        }
        (extra, [before, run.numbers()])
    }

    /// Every subset of the demonstration's five sensors restarts three times: no target has two tracks for
    /// longer than a period, and none another number.
    #[test]
    fn sensors_that_restart_neither_double_nor_renumber_the_picture() {
        const PERIOD_S: usize = 5;
        let (usual, _) = run(0);
        for restarted in 1..32 {
            let (extra, [before, after]) = run(restarted);
            let more: Vec<bool> = extra.iter().zip(&usual).map(|(found, usual)| found > usual).collect();
            let longest = more.split(|is_more| !is_more).map(<[bool]>::len).max().unwrap_or(0);
            assert!(longest <= PERIOD_S, "{restarted:05b}: two tracks for {longest} s");
            assert!(before.len() > 70, "{}", before.len());
            for (address, number) in before {
                let now = after.get(&address);
                assert!(
                    now.is_none_or(|now| *now == number),
                    "{restarted:05b}: {address:06X} from {number} to {now:?}"
                );
            }
        }
    }
}
