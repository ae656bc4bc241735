//! Schedule of the faults: kinds, times and victims, drawn in advance from the seed alone.
//!
//! Pause, kind, victim and duration of each fault are drawn in a fixed order, from a single stream, in advance. The
//! machine's speed and the deployment's reactions have no influence: a longer run has a longer schedule with the same
//! start.

use std::fmt;
use std::time::Duration;

use rand::{Rng, RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

/// Time between two faults: a part fixed, and a part drawn.
const PAUSE_MS: u64 = 1500;
const PAUSE_DRAWN_MS: u64 = 3000;

/// Needs of a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Needs {
    Nothing,
    Standby,
    OwnFileSystems,
}

/// Processes and sources that a fault can hit, in an order that does not change.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Cast {
    pub(super) processes: Vec<String>,
    pub(super) sources: Vec<String>,
}

impl Cast {
    fn process(&self, random: &mut ChaCha8Rng) -> String {
        one_of(&self.processes, random)
    }

    fn source(&self, random: &mut ChaCha8Rng) -> String {
        one_of(&self.sources, random)
    }
}

fn one_of(names: &[String], random: &mut ChaCha8Rng) -> String {
    let index = random.random_range(0..names.len().max(1));
    names.get(index).cloned().unwrap_or_default()
}

/// A fault with all values drawn for the fault.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Act {
    Kill { name: String },
    KillWhileStarting { name: String, after: Duration },
    KillTwo { one: String, other: String },
    KillLauncher,
    Stop { name: String, time: Duration },
    FloodOfOrders,
    HostileReports { source: String, seed: u64 },
    DamagedCheckpoint { seed: u64 },
    FullDisk { time: Duration },
    FullSharedMemory { time: Duration },
    WildClock { source: String, off_s: f64, seed: u64 },
    CorruptMemory { seed: u64 },
}

impl fmt::Display for Act {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Kill { name } => write!(out, "{name}"),
            Self::KillWhileStarting { name, after } => {
                write!(out, "{name}, and its successor after {} ms", after.as_millis())
            }
            Self::KillTwo { one, other } => write!(out, "{one} and {other}"),
            Self::KillLauncher => write!(out, "launcher, started again"),
            Self::Stop { name, time } => write!(out, "{name} for {:.2} s", time.as_secs_f64()),
            Self::FloodOfOrders => write!(out, "2000 orders that mean nothing"),
            Self::HostileReports { source, .. } => write!(out, "200 absurd ones of {source}"),
            Self::DamagedCheckpoint { .. } => write!(out, "1000 words, and fusion killed"),
            Self::FullDisk { time } => write!(out, "no room for recordings for {:.2} s", time.as_secs_f64()),
            Self::FullSharedMemory { time } => write!(out, "no room for {:.2} s", time.as_secs_f64()),
            Self::WildClock { source, off_s, .. } => {
                write!(out, "200 reports of {source} at times some {off_s:.0} s off")
            }
            Self::CorruptMemory { .. } => write!(out, "4000 bytes of its topics"),
        }
    }
}

/// A kind of fault.
#[derive(Debug)]
pub(super) struct Fault {
    pub(super) name: &'static str,
    pub(super) needs: Needs,
    draw: fn(&Cast, &mut ChaCha8Rng) -> Act,
}

const fn fault(name: &'static str, draw: fn(&Cast, &mut ChaCha8Rng) -> Act) -> Fault {
    Fault {
        name,
        needs: Needs::Nothing,
        draw,
    }
}

/// Every fault there is.
pub(super) const FAULTS: [Fault; 15] = [
    fault("kill", |cast, random| Act::Kill {
        name: cast.process(random),
    }),
    fault("kill-fusion", |_, _| Act::Kill {
        name: "fusion".to_owned(),
    }),
    fault("kill-while-starting", |cast, random| Act::KillWhileStarting {
        name: cast.process(random),
        after: milliseconds(random, 0, 30),
    }),
    fault("kill-two", |cast, random| Act::KillTwo {
        one: cast.process(random),
        other: cast.process(random),
    }),
    Fault {
        needs: Needs::Standby,
        ..fault("kill-standby", |_, _| Act::Kill {
            name: "standby".to_owned(),
        })
    },
    fault("kill-launcher", |_, _| Act::KillLauncher),
    fault("stop", |cast, random| Act::Stop {
        name: cast.process(random),
        time: milliseconds(random, 50, 2500),
    }),
    Fault {
        needs: Needs::Standby,
        ..fault("stop-leader", |_, random| Act::Stop {
            name: "fusion".to_owned(),
            time: milliseconds(random, 150, 3000),
        })
    },
    fault("flood-of-orders", |_, _| Act::FloodOfOrders),
    fault("hostile-reports", |cast, random| Act::HostileReports {
        source: cast.source(random),
        seed: random.next_u64(),
    }),
    fault("damaged-checkpoint", |_, random| Act::DamagedCheckpoint {
        seed: random.next_u64(),
    }),
    Fault {
        needs: Needs::OwnFileSystems,
        ..fault("full-disk", |_, random| Act::FullDisk {
            time: milliseconds(random, 500, 4000),
        })
    },
    Fault {
        needs: Needs::OwnFileSystems,
        ..fault("full-shared-memory", |_, random| Act::FullSharedMemory {
            time: milliseconds(random, 500, 4000),
        })
    },
    fault("wild-clock", |cast, random| Act::WildClock {
        source: cast.source(random),
        off_s: random.random_range(-7200.0..7200.0),
        seed: random.next_u64(),
    }),
    fault("corrupt-memory", |_, random| Act::CorruptMemory {
        seed: random.next_u64(),
    }),
];

fn milliseconds(random: &mut ChaCha8Rng, from: u64, to: u64) -> Duration {
    Duration::from_millis(random.random_range(from..to))
}

/// The next fault, after a pause.
#[derive(Debug)]
pub(super) struct Planned {
    pub(super) pause: Duration,
    pub(super) fault: &'static Fault,
    pub(super) act: Act,
}

/// Faults without end, in order.
#[derive(Debug)]
pub(super) struct Schedule {
    random: ChaCha8Rng,
    cast: Cast,
    possible: Vec<&'static Fault>,
}

impl Schedule {
    pub(super) fn new(seed: u64, cast: Cast, possible: Vec<&'static Fault>) -> Self {
        Self {
            random: ChaCha8Rng::seed_from_u64(seed),
            cast,
            possible,
        }
    }
}

impl Iterator for Schedule {
    type Item = Planned;

    /// `None` only where no fault is possible.
    fn next(&mut self) -> Option<Planned> {
        let random = &mut self.random;
        let pause = Duration::from_millis(PAUSE_MS + random.random_range(0..PAUSE_DRAWN_MS));
        let index = random.random_range(0..self.possible.len().max(1));
        let fault = *self.possible.get(index)?;
        // Draws of a fault shift none of the next.
        let mut own = ChaCha8Rng::seed_from_u64(random.next_u64());
        let act = (fault.draw)(&self.cast, &mut own);
        Some(Planned { pause, fault, act })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn schedule(seed: u64, count: usize) -> Vec<String> {
        let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
        let cast = Cast {
            processes: names(&["fusion", "keeper", "monitor", "radar", "simulator"]),
            sources: names(&["ads-b", "radar"]),
        };
        let planned = Schedule::new(seed, cast, FAULTS.iter().collect()).take(count);
        let text = |planned: Planned| {
            format!(
                "{} ms: {}, {:?}",
                planned.pause.as_millis(),
                planned.fault.name,
                planned.act
            )
        };
        planned.map(text).collect()
    }

    #[test]
    fn a_seed_gives_the_same_schedule_and_a_longer_run_goes_on_with_it() {
        let long = schedule(7, 400);
        assert_eq!(schedule(7, 100), long[..100]);
        assert_ne!(schedule(8, 100), long[..100]);
        for fault in &FAULTS {
            assert!(
                long.iter().any(|line| line.contains(&format!(": {},", fault.name))),
                "{}",
                fault.name
            );
        }
    }

    /// A seed that is published with a finding must give the same faults in later builds, too.
    #[test]
    fn the_schedule_of_a_seed_is_this_one() {
        let expected = [
            "2707 ms: corrupt-memory, CorruptMemory { seed: 6251554697900910198 }",
            "2660 ms: kill-two, KillTwo { one: \"monitor\", other: \"fusion\" }",
            "3631 ms: stop-leader, Stop { name: \"fusion\", time: 2.615s }",
        ];
        assert_eq!(schedule(1, 3), expected);
    }
}
