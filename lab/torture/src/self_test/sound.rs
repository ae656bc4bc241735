//! A sound record: the judge's input for a deployment that recovers from every fault.

use messages::NS_PER_S;
use scenario::{ScenarioSettings, Truth};

use super::record::{Record, SECOND};
use crate::judge::event::{Conditions, Event, Life, Part, Second, State, Target, Undisturbed, What};

const TARGETS: u32 = 24;
const LENGTH: i64 = 200 * SECOND;
const FAULT_EVERY: i64 = 10 * SECOND;
const TERMINATE_S: f64 = 25.0;
const PERIOD_S: f64 = 5.0;
/// Monotonic time and UTC of the begin, nanoseconds.
const BEGIN_NS: i64 = 1_000 * SECOND;
const BEGIN_UTC_NS: i64 = 1_800_000_000 * SECOND;
/// A target without detections for a while, and the time.
const UNSEEN: u32 = 5;
const UNSEEN_FROM: i64 = 81 * SECOND;
const COASTS_AFTER: i64 = 4 * SECOND;
const SEEN_AGAIN: i64 = 125 * SECOND;
/// A target that has two tracks for a while, and when.
const TWICE: u32 = 3;
const TWICE_FROM: i64 = 92 * SECOND;
const TWICE_TO: i64 = 96 * SECOND;

/// Faults in order; the last four come again and again.
const FAULTS: [Kind; 8] = [
    Kind::Kill,
    Kind::Launcher,
    Kind::DamagedCheckpoint,
    Kind::Slow,
    Kind::Kill,
    Kind::Bystander,
    Kind::Held,
    Kind::Kill,
];

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Kill,
    Launcher,
    DamagedCheckpoint,
    /// The subscriber is too slow, and reports the loss.
    Slow,
    Bystander,
    Held,
}

/// The deployment, as seen by a subscriber.
struct Deployment {
    events: Vec<Event>,
    truth: Truth,
    epoch: u64,
    continues: bool,
    incarnation: u64,
    sequence: u64,
    /// Added to all numbers: new numbers where the checkpoint is lost.
    numbers_from: u32,
    lost: u64,
    silent_until: i64,
    again: bool,
}

/// Makes the record.
///
/// # Errors
/// If the world cannot be made.
pub(super) fn record() -> anyhow::Result<Record> {
    let settings = ScenarioSettings {
        targets: TARGETS,
        ..ScenarioSettings::default()
    };
    let mut deployment = Deployment {
        events: Vec::new(),
        truth: Truth::new(&settings, 1)?,
        epoch: BEGIN_UTC_NS as u64,
        continues: false,
        incarnation: (BEGIN_NS + 1) as u64,
        sequence: 0,
        numbers_from: 1,
        lost: 0,
        silent_until: 0,
        again: false,
    };
    deployment.second(0);
    deployment.add(0, What::Joined);
    let tick = SECOND / i64::from(TARGETS);
    for step in 0..LENGTH / tick {
        let now = step * tick;
        if step % i64::from(TARGETS) == 0 {
            deployment.second((now / SECOND) as u32 + 1);
        }
        if now > 0 && now % FAULT_EVERY < tick {
            deployment.fault(now);
        }
        deployment.report((step % i64::from(TARGETS)) as u32, now);
    }
    deployment.leave(LENGTH);
    deployment.add(
        LENGTH,
        What::Stopped {
            left_behind: Vec::new(),
        },
    );
    let conditions = Conditions {
        seed: 0,
        terminate_s: TERMINATE_S,
        period_s: PERIOD_S,
        begin_ns: [BEGIN_NS, BEGIN_UTC_NS],
    };
    let mut events = deployment.events;
    events.sort_by_key(|event| event.at_ns);
    Ok(Record { conditions, events })
}

impl Deployment {
    fn add(&mut self, at: i64, what: What) {
        let at_ns = BEGIN_NS + at;
        self.events.push(Event { at_ns, what });
    }

    fn leave(&mut self, at: i64) {
        let lost = std::mem::take(&mut self.lost);
        self.add(
            at,
            What::Left {
                lost,
                lost_at_end: 0,
                whole: true,
            },
        );
    }

    fn fault(&mut self, now: i64) {
        let index = (now / FAULT_EVERY - 1) as usize;
        let kind = FAULTS[if index < FAULTS.len() { index } else { 4 + index % 4 }];
        self.add(
            now,
            What::FaultBegins {
                fault: "simulated".to_owned(),
                act: String::new(),
                takes: match kind {
                    Kind::Kill | Kind::Held => vec![Part::Fusion],
                    Kind::Launcher => vec![Part::Memory],
                    Kind::DamagedCheckpoint => vec![Part::Fusion, Part::Numbers],
                    Kind::Slow | Kind::Bystander => Vec::new(),
                },
            },
        );
        let away = match kind {
            Kind::Kill | Kind::DamagedCheckpoint => SECOND * 4 / 5,
            Kind::Held => SECOND * 3 / 2,
            Kind::Launcher => 3 * SECOND,
            Kind::Slow | Kind::Bystander => 0,
        };
        self.silent_until = now + away;
        if kind == Kind::Launcher {
            self.leave(now);
            self.add(now + away / 2, What::Joined);
        }
        if matches!(kind, Kind::Kill | Kind::Launcher | Kind::DamagedCheckpoint) {
            self.epoch = (BEGIN_UTC_NS + now + away - SECOND / 10) as u64;
            self.continues = kind != Kind::DamagedCheckpoint;
            (self.incarnation, self.sequence) = ((BEGIN_NS + now + away - SECOND / 10) as u64, 0);
        }
        if kind == Kind::DamagedCheckpoint {
            self.numbers_from += 1000;
        }
        if kind == Kind::Slow {
            self.sequence += 10;
            self.lost += 10;
            self.add(now + SECOND / 100, What::Lost { samples: 10 });
        }
        let lasts = if kind == Kind::Held { away } else { 0 };
        self.add(now + lasts, What::FaultEnds);
        self.add(now + away, What::Back);
    }

    fn report(&mut self, target: u32, now: i64) {
        if now < self.silent_until {
            return;
        }
        let number = self.numbers_from + target;
        if target != UNSEEN || !(UNSEEN_FROM..SEEN_AGAIN).contains(&now) {
            self.state(target, number, Life::Confirmed, now, 0);
        } else {
            let since = now - UNSEEN_FROM;
            if (COASTS_AFTER..COASTS_AFTER + SECOND).contains(&since) {
                self.state(target, number, Life::Coasted, now, 0);
            } else if since > (TERMINATE_S * NS_PER_S) as i64 && !std::mem::replace(&mut self.again, true) {
                self.state(target, number, Life::Suspended, now, 0);
            }
        }
        if target == TWICE && (TWICE_FROM..TWICE_TO + SECOND).contains(&now) {
            let (life, into) = if now < TWICE_TO {
                (Life::Confirmed, 0)
            } else {
                (Life::Terminated, number)
            };
            self.state(target, number + 700, life, now, into);
        }
    }

    fn state(&mut self, target: u32, number: u32, life: Life, now: i64, merged_into: u32) {
        let truth = self.truth.target_at(target as usize, now as f64 / NS_PER_S);
        let [x, y, z] = truth.position_m;
        let [vx, vy, vz] = truth.velocity_mps;
        let wander = wander_m(self.sequence);
        let sequence = self.sequence;
        self.sequence += 1;
        let state = State {
            sent_ns: BEGIN_NS + now,
            incarnation: self.incarnation,
            sequence,
            epoch: self.epoch,
            continues: self.continues,
            number,
            life,
            merged_into,
            of_report: life == Life::Confirmed,
            of_locator: false,
            address: Some(truth.address),
            time_ns: BEGIN_UTC_NS + now,
            position_m: Some([x + wander, y - wander, z + 0.5 * wander]),
            velocity_mps: Some([vx + 0.2 * wander, vy, vz]),
            has_height: true,
            sources: Vec::new(),
        };
        self.add(now, What::State(state));
    }

    /// The world at a second, and the picture of a run without faults.
    fn second(&mut self, second: u32) {
        let time_s = f64::from(second);
        let is_seen = |id: u32| id != UNSEEN || !(UNSEEN_FROM..SEEN_AGAIN).contains(&(i64::from(second) * SECOND));
        let targets = self.truth.at(time_s).map(|target| {
            let wander = wander_m(u64::from(second * TARGETS + target.id)).abs();
            Target {
                address: target.address,
                position_m: target.position_m,
                velocity_mps: target.velocity_mps,
                undisturbed: is_seen(target.id).then_some(Undisturbed {
                    states: 1,
                    has_address: true,
                    has_height: true,
                    has_velocity: true,
                    age_s: 1.0 - f64::from(target.id) / f64::from(TARGETS),
                    errors: [wander * 2.0_f64.sqrt(), 0.5 * wander, 0.2 * wander],
                }),
            }
        });
        let targets = targets.collect();
        self.add(
            (i64::from(second) - 1) * SECOND,
            What::Second(Second {
                second,
                targets,
                strangers_m: Vec::new(),
            }),
        );
    }
}

/// Error that a sample has on each axis, metres.
fn wander_m(sample: u64) -> f64 {
    f64::from((sample % 41) as u32) - 20.0
}
