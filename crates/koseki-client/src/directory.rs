//! What runs here: instances, the topics of an instance, and the names of its sources.

use std::fs;

use bus::{Root, base};

use crate::connection::Connection;
use crate::error::Error;

/// File in the folder of a running instance that lists the names of its sources, a line each.
const SOURCES: &str = "sources";

/// Returns the names of the instances that run, in their order.
///
/// # Errors
/// If the folder of the instances cannot be read.
pub fn instances() -> Result<Vec<String>, Error> {
    let entries = Root::list(base::find())?;
    let running = entries.into_iter().filter(|entry| entry.runs);
    Ok(running.map(|entry| entry.root.instance().to_owned()).collect())
}

/// Returns the names of the topics of the deployment at `root`, in their order.
///
/// # Errors
/// If it does not run.
pub fn topics(root: &Root) -> Result<Vec<String>, Error> {
    Ok(Connection::open(root)?.bus.topics()?)
}

/// Returns the names of the sources of the deployment at `root`, by their numbers in samples. Empty if it does not run.
pub fn sources(root: &Root) -> Vec<String> {
    let names = fs::read_to_string(root.path().join(SOURCES)).unwrap_or_default();
    names.lines().map(str::to_owned).collect()
}
