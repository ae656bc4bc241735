//! The simulated world in which the deployment lives, and the run without faults that the judge compares with.

use messages::NS_PER_S;
use runtime::clock::Now;
use scenario::Truth;

use ::deployment::Deployment;

use super::judge::event::{Second, Target};
use super::undisturbed::{Engines, SEED, UndisturbedRun};

/// How long before a second the world is known at that second, nanoseconds.
const AHEAD_NS: i64 = 1_000_000_000;

/// Where every target is at any time, and the picture of a run without faults.
pub(super) struct World {
    truth: Truth,
    undisturbed: UndisturbedRun,
    begin_mono_ns: i64,
    next: u32,
}

impl World {
    /// The world that `config` describes, from `begin` on; `None` where the configuration has no simulated world.
    ///
    /// # Errors
    /// If the settings are unusable.
    pub(super) fn new(config: &Deployment, engines: Engines, begin: Now) -> anyhow::Result<Option<Self>> {
        let Some(settings) = &engines.world.targets else {
            return Ok(None);
        };
        Ok(Some(Self {
            truth: Truth::new(settings, SEED)?.round(config.frame),
            undisturbed: UndisturbedRun::new(config, engines, begin)?,
            begin_mono_ns: begin.mono_ns,
            next: 0,
        }))
    }

    /// Returns the next second of the world; `None` if not near yet.
    pub(super) fn next(&mut self, now_mono_ns: i64) -> Option<Second> {
        let second = self.next;
        if now_mono_ns < self.begin_mono_ns + (f64::from(second) * NS_PER_S) as i64 - AHEAD_NS {
            return None;
        }
        self.next += 1;
        let picture = self.undisturbed.next(second, &self.truth);
        let targets = self.truth.at(f64::from(second)).map(|target| Target {
            address: target.address,
            position_m: target.position_m,
            velocity_mps: target.velocity_mps,
            undisturbed: picture.targets.get(&target.address).map(|(seen, _)| *seen),
        });
        Some(Second {
            second,
            targets: targets.collect(),
            strangers_m: picture.strangers_m,
        })
    }
}
