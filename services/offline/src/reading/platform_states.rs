//! States of a platform from a table.

use std::io::BufReader;
use std::path::Path;

use formats::platform_states_csv::PlatformStateReader;
use platform::State;

use super::SkippedRows;
use crate::files::InputError;
use crate::host::Host;

/// Reads all states. Unusable rows are skipped and counted.
///
/// # Errors
/// If the file cannot be read, or has no state with a position.
pub(crate) fn platform_states(
    host: &dyn Host,
    path: &Path,
    refusals: &mut SkippedRows,
) -> Result<Vec<State>, InputError> {
    let mut states = Vec::new();
    let rows = PlatformStateReader::new(BufReader::new(host.open(path)?), 0);
    for row in rows.map_err(|error| InputError::new(path, error))? {
        states.extend(refusals.usable(path, row)?.map(|sample| State::of_sample(&sample)));
    }
    match states.iter().any(|state| state.position_m.is_some()) {
        true => Ok(states),
        false => Err(InputError::new(path, "has no row with a position in px, py and pz")),
    }
}
