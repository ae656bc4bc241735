//! The simulated world in which the deployment lives, as the truth that the judge compares with.

use std::collections::BTreeMap;

use messages::NS_PER_S;
use scenario::Truth;

use ::deployment::Deployment;

/// Seed of the traffic, independent of the faults: other faults must not change the victims.
pub(super) const SEED: u64 = 1;

/// Where every target is at any time; empty where the configuration has no simulated world.
pub(super) struct World {
    truth: Option<Truth>,
    start_utc_ns: i64,
    by_address: BTreeMap<u32, usize>,
}

impl World {
    /// The world that `config` describes, from `start_utc_ns` on.
    ///
    /// # Errors
    /// If its settings cannot be used.
    pub(super) fn new(config: &Deployment, start_utc_ns: i64) -> anyhow::Result<Self> {
        let truth = match &config.scenario {
            Some(settings) => Some(Truth::new(settings, SEED)?),
            None => None,
        };
        let targets = truth.iter().flat_map(|truth| truth.at(0.0));
        Ok(Self {
            by_address: targets.map(|target| target.address).zip(0..).collect(),
            truth,
            start_utc_ns,
        })
    }

    /// East and north of the target of this address at a time, metres.
    pub(super) fn place_m(&self, address: u32, utc_ns: i64) -> Option<[f64; 2]> {
        let (truth, index) = (self.truth.as_ref()?, *self.by_address.get(&address)?);
        let time_s = utc_ns.checked_sub(self.start_utc_ns)? as f64 / NS_PER_S;
        let [east_m, north_m, _] = truth.target_at(index, time_s).position_m;
        Some([east_m, north_m])
    }
}
