//! Instances named on a command line. For every command, a wrong name is wrong usage.

use bus::Root;
use offline::Usage;

/// The instance called `name`.
///
/// # Errors
/// If no instance can have this name here.
pub(crate) fn named(name: &str) -> Result<Root, Usage> {
    Root::new(name).map_err(|error| Usage(error.to_string()))
}

/// The instance called `name`, which runs.
///
/// # Errors
/// If no instance can have this name, none of this name runs, or the instances cannot be listed.
pub(crate) fn running(name: &str) -> anyhow::Result<Root> {
    let root = named(name)?;
    let listed = Root::list(root.base())?;
    if !listed.iter().any(|instance| instance.runs && instance.root == root) {
        return Err(nothing_runs_as(name).into());
    }
    Ok(root)
}

/// The running instance called `name`, or the only running instance.
///
/// # Errors
/// As [`running`]; also if there is no name, and none or several run.
pub(crate) fn running_or_only(name: Option<&str>) -> anyhow::Result<Root> {
    if let Some(name) = name {
        return running(name);
    }
    let listed = Root::list(bus::base::find())?;
    let mut running = listed.into_iter().filter(|instance| instance.runs);
    match (running.next(), running.next()) {
        (Some(only), None) => Ok(only.root),
        (None, _) => Err(Usage("no instance runs: start one with `koseki up`".to_owned()).into()),
        (Some(first), Some(second)) => Err(Usage(format!(
            "several instances run, such as {} and {}: choose one with --instance",
            first.root.instance(),
            second.root.instance()
        ))
        .into()),
    }
}

/// Refusal of a name that no instance has.
pub(crate) fn nothing_runs_as(name: &str) -> Usage {
    Usage(format!(
        "no instance {name} runs; `koseki status` shows the running instances"
    ))
}
