//! `koseki top`: choice of the deployment. The display is in the monitor ([`monitor::top`]).

use bus::{InstanceEntry, Root};
use monitor::top::{Form, Settings, run as look_on};
use offline::Usage;

use crate::args::Top;
use crate::instances;

/// Watches the named instance, or the only running instance.
///
/// # Errors
/// If none runs, several do and none is named, or looking on fails.
pub(crate) fn run(top: &Top) -> anyhow::Result<()> {
    let root = match &top.instance {
        Some(name) => instances::running(name)?,
        None => the_only_one(&Root::list(bus::base::find())?)?,
    };
    let settings = Settings {
        interval: top.interval,
        once: top.once.then_some(match top.json {
            true => Form::Json,
            false => Form::Text,
        }),
    };
    look_on(&root, settings)
}

fn the_only_one(instances: &[InstanceEntry]) -> anyhow::Result<Root> {
    let running: Vec<&InstanceEntry> = instances.iter().filter(|instance| instance.runs).collect();
    match running[..] {
        [only] => Ok(only.root.clone()),
        [] => anyhow::bail!("nothing runs; start a deployment with `koseki up` or `koseki demo`"),
        _ => {
            let names: Vec<&str> = running.iter().map(|instance| instance.root.instance()).collect();
            let names = names.join(", ");
            anyhow::bail!(Usage(format!(
                "several instances run; name one with --instance: {names}"
            )))
        }
    }
}
