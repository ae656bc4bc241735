//! The faults, each with how it is caused.

use std::path::Path;
use std::sync::atomic::Ordering::Relaxed;
use std::time::Duration;

use bus::Mark;
use messages::{Control, Covariance, SensorTrack, TrackState};
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use runtime::clock::{Now, mono_ns};
use runtime::instance::CHECKPOINT;
use rustix::process::Signal;

use super::deployment::Deployment;
use super::own_file_systems::SHARED_MEMORY;

/// Needs of a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Needs {
    Nothing,
    Standby,
    OwnFileSystems,
}

/// A fault.
pub(super) struct Fault {
    pub(super) name: &'static str,
    pub(super) needs: Needs,
    /// Whether every target must keep its number.
    pub(super) keeps_numbers: bool,
    /// Causes it, and says to whom.
    pub(super) cause: fn(&mut Deployment, &mut ChaCha8Rng) -> anyhow::Result<String>,
}

/// Every fault there is.
pub(super) const FAULTS: [Fault; 15] = [
    Fault {
        name: "kill",
        needs: Needs::Nothing,
        keeps_numbers: true,
        cause: |deployment, random| {
            let name = any_child(deployment, random)?;
            deployment.signal(&name, Signal::KILL)?;
            Ok(name)
        },
    },
    Fault {
        name: "kill-fusion",
        needs: Needs::Nothing,
        keeps_numbers: true,
        cause: |deployment, _| {
            deployment.signal("fusion", Signal::KILL)?;
            Ok("fusion".to_owned())
        },
    },
    Fault {
        name: "kill-while-starting",
        needs: Needs::Nothing,
        keeps_numbers: true,
        cause: |deployment, random| {
            let name = any_child(deployment, random)?;
            let dead = deployment.signal(&name, Signal::KILL)?;
            let next = deployment.until_started(&name, dead)?;
            deployment.watch(Duration::from_millis(random.random_range(0..30)))?;
            deployment.signal_process(next, Signal::KILL);
            Ok(format!("{name}, and its successor"))
        },
    },
    Fault {
        name: "kill-two",
        needs: Needs::Nothing,
        keeps_numbers: true,
        cause: |deployment, random| {
            let (one, other) = (any_child(deployment, random)?, any_child(deployment, random)?);
            deployment.signal(&one, Signal::KILL)?;
            if one != other {
                deployment.signal(&other, Signal::KILL)?;
            }
            Ok(format!("{one} and {other}"))
        },
    },
    Fault {
        name: "kill-standby",
        needs: Needs::Standby,
        keeps_numbers: true,
        cause: |deployment, _| {
            deployment.signal("standby", Signal::KILL)?;
            Ok("standby".to_owned())
        },
    },
    Fault {
        name: "kill-launcher",
        needs: Needs::Nothing,
        keeps_numbers: true,
        cause: |deployment, _| {
            deployment.restart()?;
            Ok("launcher, started again".to_owned())
        },
    },
    Fault {
        name: "stop",
        needs: Needs::Nothing,
        keeps_numbers: true,
        cause: |deployment, random| {
            let name = any_child(deployment, random)?;
            let pid = deployment.signal(&name, Signal::STOP)?;
            let pause = Duration::from_millis(random.random_range(50..2500));
            deployment.watch(pause)?;
            deployment.signal_process(pid, Signal::CONT);
            Ok(format!("{name} for {:.2} s", pause.as_secs_f64()))
        },
    },
    Fault {
        name: "stop-leader",
        needs: Needs::Standby,
        keeps_numbers: true,
        cause: |deployment, random| {
            let pid = deployment.signal("fusion", Signal::STOP)?;
            let pause = Duration::from_millis(random.random_range(150..3000));
            deployment.watch(pause)?;
            // The one that took over has killed it, unless it came too late.
            deployment.signal_process(pid, Signal::CONT);
            Ok(format!("fusion for {:.2} s", pause.as_secs_f64()))
        },
    },
    Fault {
        name: "flood-of-orders",
        needs: Needs::Nothing,
        keeps_numbers: true,
        cause: |deployment, _| {
            let bus = deployment.bus()?;
            let mut publisher = bus.publisher(&messages::control(), mono_ns() as u64)?;
            for number in 0..2000 {
                let order = Control::condition(&format!("none-{number}")).unwrap_or_default();
                publisher.send(mark(), 1, |_, _| order)?;
            }
            Ok("2000 orders that mean nothing".to_owned())
        },
    },
    Fault {
        name: "hostile-reports",
        needs: Needs::Nothing,
        keeps_numbers: true,
        cause: |deployment, random| {
            let sources = deployment.sources();
            let name = sources[random.random_range(0..sources.len())].clone();
            let bus = deployment.bus()?;
            let mut publisher = bus.publisher(&messages::sensor_tracks(&name), mono_ns() as u64)?;
            for _ in 0..200 {
                let word: u64 = random.random();
                let wild = f64::from_bits(word);
                let report = SensorTrack {
                    time_of_measurement_ns: word.cast_signed(),
                    track_number: word as u32,
                    state: word as u8,
                    position_m: [wild, -wild, f64::NAN],
                    covariance: Covariance::diagonal([wild; 3], [-1.0; 3]),
                    ..SensorTrack::default()
                };
                publisher.send(mark(), 1, |_, _| report)?;
            }
            Ok(format!("200 absurd ones of {name}"))
        },
    },
    Fault {
        name: "damaged-checkpoint",
        needs: Needs::Nothing,
        // Nobody knows them any more.
        keeps_numbers: false,
        cause: |deployment, random| {
            if let Some(memory) = deployment.root().outlasting(CHECKPOINT)? {
                for _ in 0..1000 {
                    let place = random.random_range(0..memory.words().len());
                    memory.words()[place].store(random.random(), Relaxed);
                }
            }
            deployment.signal("fusion", Signal::KILL)?;
            Ok("1000 words, and fusion killed".to_owned())
        },
    },
    Fault {
        name: "full-disk",
        needs: Needs::OwnFileSystems,
        keeps_numbers: true,
        cause: |deployment, random| {
            let (folder, time) = (deployment.out(), a_while(random));
            deployment.full(&folder, time)?;
            Ok(format!("no room for recordings for {:.2} s", time.as_secs_f64()))
        },
    },
    Fault {
        name: "full-shared-memory",
        needs: Needs::OwnFileSystems,
        // Whoever writes where there is no room is killed, perhaps all of them.
        keeps_numbers: false,
        cause: |deployment, random| {
            let time = a_while(random);
            deployment.full(Path::new(SHARED_MEMORY), time)?;
            Ok(format!("no room for {:.2} s", time.as_secs_f64()))
        },
    },
    Fault {
        name: "wild-clock",
        needs: Needs::Nothing,
        keeps_numbers: true,
        cause: |deployment, random| {
            let sources = deployment.sources();
            let name = sources[random.random_range(0..sources.len())].clone();
            let bus = deployment.bus()?;
            let mut publisher = bus.publisher(&messages::sensor_tracks(&name), mono_ns() as u64)?;
            let off_s = random.random_range(-7200.0..7200.0_f64);
            for number in 0..200 {
                let report = SensorTrack {
                    time_of_measurement_ns: Now::read().utc_ns + (off_s * random.random_range(0.5..2.0) * 1e9) as i64,
                    track_number: 60_000 + number,
                    state: TrackState::Confirmed as u8,
                    position_m: [0; 3].map(|_| random.random_range(-30_000.0..30_000.0)),
                    covariance: Covariance::diagonal([50.0; 3], [5.0; 3]),
                    ..SensorTrack::default()
                };
                publisher.send(mark(), 1, |_, _| report)?;
            }
            Ok(format!("200 reports of {name} at times some {off_s:.0} s off"))
        },
    },
    Fault {
        name: "corrupt-memory",
        needs: Needs::Nothing,
        // What the deployment does with it, nobody can know: it is ended, and must come back.
        keeps_numbers: false,
        cause: |deployment, random| {
            deployment.corrupt(random)?;
            std::thread::sleep(a_while(random));
            deployment.restart()?;
            Ok("4000 octets of its topics, and the launcher started again".to_owned())
        },
    },
];

fn a_while(random: &mut ChaCha8Rng) -> Duration {
    Duration::from_millis(random.random_range(500..4000))
}

fn any_child(deployment: &Deployment, random: &mut ChaCha8Rng) -> anyhow::Result<String> {
    let names: Vec<String> = deployment.children()?.into_keys().collect();
    anyhow::ensure!(!names.is_empty(), "nothing runs");
    Ok(names[random.random_range(0..names.len())].clone())
}

fn mark() -> Mark {
    Mark {
        progress_ns: i64::MIN,
        sent_ns: mono_ns(),
        end: false,
    }
}
