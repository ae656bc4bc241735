//! `koseki torture`: reads the deployment under test.

use std::path::Path;

use configuration::{BUILT_IN_TORTURE, Config};
use messages::NS_PER_S;
use torture::{Engines, Tested, Torture};

use crate::product;

/// Runs the command.
///
/// # Errors
/// As [`torture::run`].
pub(crate) fn run(torture: &Torture) -> anyhow::Result<()> {
    torture::run(torture, read)
}

fn read(torture: &Torture) -> anyhow::Result<Tested> {
    let path = torture.config.as_deref().unwrap_or(Path::new(BUILT_IN_TORTURE));
    let config = Config::read(path, &torture.set)?;
    let settings = &config.engine;
    let fresh_ns = settings.sources.iter().map(|source| source.fresh_ns).max();
    Ok(Tested {
        executable: product::koseki()?,
        path: path.to_owned(),
        terminate_s: settings.life.terminate_ns(fresh_ns.unwrap_or_default()) as f64 / NS_PER_S,
        deployment: config.deployment,
        engines: Engines {
            fusion: config.engine,
            readings: config.readings.sources,
            world: config.world,
        },
    })
}
