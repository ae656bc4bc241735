//! Continuation of a killed adapter's tracks under the same numbers.
//!
//! Each source's tracks are kept in separate memory beside fusion's checkpoint ([`bus::Outlasting`]). Unusable memory
//! is put aside and reported; track numbers then begin with a number that depends on the time. Tracks from before the
//! begin of the simulated world are ended: such tracks have targets of another world.

use std::sync::Arc;

use deployment::Source;
use runtime::Process;
use runtime::{Now, Publication};
use sources::Pipeline;

/// Continues a source's pipeline from kept tracks, and keeps the tracks for a successor; `None` without tracks to
/// keep.
///
/// # Errors
/// If the machine has no memory for the tracks.
pub(crate) fn go_on(
    process: &Process,
    source: &Source,
    pipeline: &mut Pipeline,
) -> anyhow::Result<Option<Publication>> {
    let (Some(words), Some(max_age_ns)) = (pipeline.kept_words(), process.config.checkpoint.max_age_ns()) else {
        return Ok(None);
    };
    let (root, name, owner) = (process.bus.root(), format!("tracks-{}", source.name), &source.name);
    let now = Now::read();
    let resumed = match root.outlasting(&name) {
        Ok(Some(memory)) => {
            let simulated = process.config.is_simulated();
            let world_ns = if simulated {
                process.options.scenario_start_ns
            } else {
                i64::MIN
            };
            let resumed = pipeline.resume(memory.words(), owner, world_ns.max(now.utc_ns - max_age_ns));
            resumed.map_err(|refused| refused.to_string())
        }
        Ok(None) => Ok(()),
        Err(error) => Err(error.to_string()),
    };
    if let Err(reason) = resumed {
        let aside = root.put_outlasting_aside(&name);
        let aside = aside.map_or_else(String::new, |path| format!(" (put aside: {})", path.display()));
        runtime::notice(format_args!(
            "warning: the tracks kept of {owner} are not used: {reason}{aside}"
        ));
    }
    let memory = Arc::new(root.make_outlasting(&name, words)?);
    pipeline.keep_in(Box::new(Arc::clone(&memory)), owner);
    pipeline.keep(now.utc_ns);
    let what = format!("the tracks of {owner}");
    let mut publication = Publication::new(memory, what);
    publication.tend(now.mono_ns);
    Ok(Some(publication))
}
