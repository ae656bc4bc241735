//! A sound record: the judge's input for a deployment that recovers from every fault.

use messages::NS_PER_S;
use scenario::{ScenarioSettings, Truth};

use super::record::{Record, SECOND};
use crate::judge::event::{Conditions, Event, Life, State, What};
use crate::judge::limits::Limits;

const TARGETS: u32 = 24;
const LENGTH: i64 = 200 * SECOND;
const FAULT_EVERY: i64 = 10 * SECOND;
const TERMINATE_S: f64 = 25.0;
/// Monotonic time of the begin, nanoseconds.
const BEGIN_NS: i64 = 1_000 * SECOND;
/// A target without detections for a while, and the time.
const UNSEEN: u32 = 5;
const UNSEEN_FROM: i64 = 81 * SECOND;
const COASTS_AFTER: i64 = 4 * SECOND;
const SEEN_AGAIN: i64 = 125 * SECOND;
/// A target that has two tracks for a while, and when.
const TWICE: u32 = 3;
const TWICE_FROM: i64 = 92 * SECOND;
const TWICE_TO: i64 = 96 * SECOND;

/// Faults in their order; the last four come again and again.
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
    /// The subscriber is too slow, and reports its loss.
    Slow,
    Bystander,
    Held,
}

/// The deployment, as far as a subscriber sees it.
struct Deployment {
    events: Vec<Event>,
    truth: Truth,
    epoch: u64,
    incarnation: u64,
    sequence: u64,
    /// Added to all numbers: new ones where the checkpoint is lost.
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
        epoch: 1,
        incarnation: (BEGIN_NS + 1) as u64,
        sequence: 0,
        numbers_from: 1,
        lost: 0,
        silent_until: 0,
        again: false,
    };
    deployment.add(0, What::Joined);
    let tick = SECOND / i64::from(TARGETS);
    for step in 0..LENGTH / tick {
        let now = step * tick;
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
        standby: false,
        terminate_s: TERMINATE_S,
        limits: Limits::new(false, TERMINATE_S, 1.0),
    };
    Ok(Record {
        conditions,
        events: deployment.events,
    })
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
                keeps_numbers: kind != Kind::DamagedCheckpoint,
                rebuilds: kind == Kind::Launcher,
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
            self.epoch += 1;
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
        self.add(
            now + away,
            What::FaultEnds {
                held: kind == Kind::Held,
            },
        );
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
        let [x, y, _] = truth.position_m;
        let wander = f64::from((self.sequence % 41) as u32) - 20.0;
        let sequence = self.sequence;
        self.sequence += 1;
        let state = State {
            sent_ns: BEGIN_NS + now,
            incarnation: self.incarnation,
            sequence,
            epoch: self.epoch,
            number,
            life,
            merged_into,
            of_report: life == Life::Confirmed,
            address: Some(truth.address),
            position_m: Some([x + wander, y - wander]),
            truth_m: Some([x, y]),
        };
        self.add(now, What::State(state));
    }
}
