//! States of a platform from a table.

use std::io::BufReader;
use std::path::Path;

use formats::platform_states_csv::PlatformStateReader;
use formats::time_base::is_since_1970;
use platform::State;

use super::{FileBases, SkippedRows};
use crate::files::InputError;
use crate::host::Host;

/// Reads all states. Unusable rows are skipped and counted.
///
/// # Errors
/// If the file cannot be read, differs from the files before in the time base, or has no state with a position.
pub(crate) fn platform_states(
    host: &dyn Host,
    path: &Path,
    (refusals, bases): (&mut SkippedRows, &mut FileBases),
) -> Result<Vec<State>, InputError> {
    let mut states = Vec::new();
    let rows = PlatformStateReader::new(BufReader::new(host.open(path)?), 0);
    for row in rows.map_err(|error| InputError::new(path, error))? {
        states.extend(refusals.usable(path, row)?.map(|sample| State::of_sample(&sample)));
    }
    if let Some(first) = states.first() {
        bases.add(path, is_since_1970(first.time_ns))?;
    }
    match states.iter().any(|state| state.position_m.is_some()) {
        true => Ok(states),
        false => Err(InputError::new(path, "has no row with a position in px, py and pz")),
    }
}
