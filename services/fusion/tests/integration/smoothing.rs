//! Smoothed states of a running fusion: those that the same reports give in files.

use std::path::Path;
use std::sync::Arc;

use bus::{Bus, InProcess, Mark, Root};
use configuration::Config;
use fusion::smoothing::LagSmoother;
use fusion::{Driver, Engine, FilterInput, ReportNumber, Sink};
use fusion_service::{FusionAgent, SmoothingQueue, SmoothingWorker};
use messages::{BatchHeader, Counter, Covariance, SensorTrack, SystemTrack, TrackState, sensor_track_bits};
use runtime::housekeeping::Queues;
use runtime::{Agent, Now, Speed, Turn};
use test_support::{Random, S};

const DAY: i64 = 16_931 * 86_400 * S;
const LAG_S: i64 = 5;

fn config() -> Config {
    let text = format!(
        "name = \"t\"\n[frame]\nlatitude_deg = 0.0\nlongitude_deg = 0.0\n[time]\norder = \"time\"\ndate = \"2016-05-10\"\n\
         [[source]]\nname = \"a\"\n[source.recorded]\nfile = \"a.ast\"\n[recorder]\nenabled = false\n\
         [fusion]\nsmoothing_lag_s = {LAG_S}\n"
    );
    Config::parse(Path::new("t.toml"), &text, &[]).unwrap()
}

/// Reports of three targets that turn.
fn reports() -> Vec<SensorTrack> {
    let mut random = Random::new(3);
    let mut all = Vec::new();
    for step in 0..120u32 {
        let time_s = f64::from(step);
        let angle = 0.02 * (time_s - 40.0).clamp(0.0, 30.0);
        for target in 0..3u32 {
            let place = [
                150.0 * time_s * angle.cos() + random.between(-60.0, 60.0),
                2e4 * f64::from(target) + 150.0 * time_s * angle.sin() + random.between(-60.0, 60.0),
                3e3 + random.between(-40.0, 40.0),
            ];
            all.push(SensorTrack {
                time_of_measurement_ns: DAY + i64::from(step) * S + i64::from(target),
                sequence: all.len() as u64,
                track_number: 1 + target,
                valid: sensor_track_bits::VELOCITY | sensor_track_bits::HEIGHT,
                position_m: place,
                velocity_mps: [150.0 * angle.cos(), 150.0 * angle.sin(), 0.0],
                covariance: Covariance::diagonal([35.0; 3], [20.0; 3]),
                state: TrackState::Confirmed as u8,
                ..SensorTrack::default()
            });
        }
    }
    all
}

/// States that leave a smoother behind an engine.
struct Smoothing(LagSmoother, Vec<SystemTrack>);

impl Sink for Smoothing {
    fn track(&mut self, track: &SystemTrack) {
        let left = &mut self.1;
        self.0.state(track, |state| left.push(*state));
    }

    fn follows_inputs(&self) -> bool {
        true
    }

    fn input(&mut self, input: &FilterInput) {
        let left = &mut self.1;
        self.0.input(input, |state| left.push(*state));
    }
}

type Essence = (u32, i64, u8, [f64; 3], [f64; 3], Covariance);

fn essence(states: &[SystemTrack]) -> Vec<Essence> {
    let of = |state: &SystemTrack| {
        let SystemTrack {
            track_number,
            reference_time_ns,
            state,
            position_m,
            velocity_mps,
            covariance,
            ..
        } = *state;
        (
            track_number,
            reference_time_ns,
            state,
            position_m,
            velocity_mps,
            covariance,
        )
    };
    states.iter().map(of).collect()
}

#[test]
fn a_running_fusion_publishes_the_smoothed_states_that_the_engine_and_a_smoother_give() {
    let (config, all) = (config(), reports());
    let engine = Engine::new(config.engine.clone()).unwrap();
    let mut driver = Driver::begin(engine, (), 1);
    let lag_ns = config.engine.smoothing_lag_ns().unwrap();
    assert_eq!(lag_ns, LAG_S * S);
    let mut expected = Smoothing(LagSmoother::new(lag_ns), Vec::new());
    for report in &all {
        driver.report_in_order(&mut { *report }, ReportNumber::default(), &mut expected);
    }
    driver.advance(i64::MAX, &mut expected);
    let Smoothing(smoother, mut left) = expected;
    { smoother }.finish(|state| left.push(*state));

    let folder = tempfile::tempdir().unwrap();
    let bus: Bus<InProcess> = Bus::open(&Root::in_base(folder.path(), "t").unwrap(), "test").unwrap();
    let sensor_tracks = messages::sensor_tracks("a");
    let _held = (
        bus.hold(&sensor_tracks).unwrap(),
        bus.hold(&messages::system_tracks()).unwrap(),
        bus.hold(&messages::smoothed_tracks()).unwrap(),
        bus.hold(&messages::progress()).unwrap(),
    );
    let mut live = bus.subscriber(&messages::system_tracks(), || 1).unwrap();
    let mut smoothed = bus.subscriber(&messages::smoothed_tracks(), || 1).unwrap();
    let queue = SmoothingQueue::new(config.system_tracks.max);
    let agent = FusionAgent::new(&config, &config.engine, Speed::Max, &bus, 1, Queues::new(None)).unwrap();
    let mut agent = agent.with_smoothing(Some(Arc::clone(&queue)));
    let mut worker = SmoothingWorker::new(queue, lag_ns, &bus, 1);
    let mut source = bus.publisher(&sensor_tracks, 2).unwrap();
    let now = Now {
        mono_ns: 1,
        utc_ns: DAY,
    };
    let (mut received, mut has_ended, mut fused, mut finished) = (Vec::new(), false, 0, false);
    let slices = all.chunks(30);
    let last = slices.len() - 1;
    for (place, slice) in slices.enumerate() {
        let end = place == last;
        let mark = Mark {
            progress_ns: if end {
                i64::MAX
            } else {
                slice[29].time_of_measurement_ns
            },
            sent_ns: 1,
            end,
        };
        source.send(mark, slice.len(), |index, _| slice[index]).unwrap();
        for _ in 0..20 {
            finished |= agent.turn(now).unwrap() == Turn::Finished;
            live.take(usize::MAX, |_, tracks| fused += tracks.len()).unwrap();
        }
        worker.turn().unwrap();
        smoothed
            .take(usize::MAX, |header, tracks| {
                received.extend_from_slice(tracks);
                has_ended |= header.flags & BatchHeader::END != 0;
            })
            .unwrap();
    }
    assert!(finished && has_ended && fused > 360);
    assert!(received.len() > 300 && received.iter().all(|state| state.epoch == 1));
    assert!(received.windows(2).all(|pair| pair[0].sequence + 1 == pair[1].sequence));
    assert_eq!(essence(&received), essence(&left));
    let mut entries = Vec::new();
    agent.health(&mut entries);
    assert_eq!(entries[0].counters[Counter::SmoothingDropped], 0);
}
