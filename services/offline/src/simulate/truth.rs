//! Truth of a simulation: the targets that its instruments can locate, second by second.

use std::io::Write as _;
use std::path::Path;

use anyhow::Context as _;
use scenario::{SimulatedAis, SimulatedDirectionFinder, SimulatedSensor, TargetState, Truth};

use crate::host::Host;

/// Instruments that can locate a target. Wide-area counts are excluded: such counts locate no single target.
#[derive(Default)]
pub(super) struct Observers {
    pub(super) sensors: Vec<SimulatedSensor>,
    pub(super) finders: Vec<SimulatedDirectionFinder>,
    pub(super) receivers: Vec<SimulatedAis>,
}

impl Observers {
    fn observe(&self, target: &TargetState) -> bool {
        self.sensors.iter().any(|sensor| sensor.observes(target))
            || self.finders.iter().any(|finder| finder.transmits(target))
            || self.receivers.iter().any(|receivers| receivers.observes(target))
    }
}

/// Writes the positions of all targets visible to some sensor; returns the number of rows.
pub(super) fn write_truth(
    host: &dyn Host,
    path: &Path,
    truth: &Truth,
    observers: &Observers,
    end_s: f64,
) -> anyhow::Result<u64> {
    let unwritten = || format!("{} cannot be written", path.display());
    let mut out = host.begin(path)?;
    writeln!(out, "time_s,target_id,x,y,z,vx,vy,vz").with_context(unwritten)?;
    let mut rows = 0;
    for second in 0..=end_s as i64 {
        host.progress(second.cast_unsigned(), end_s as u64)?;
        for target in truth.at(second as f64).filter(|target| observers.observe(target)) {
            let ([x, y, z], [vx, vy, vz]) = (target.position_m, target.velocity_mps);
            let id = target.id;
            writeln!(out, "{second},{id},{x:.3},{y:.3},{z:.3},{vx:.3},{vy:.3},{vz:.3}").with_context(unwritten)?;
            rows += 1;
        }
    }
    out.finish()?;
    Ok(rows)
}
