//! Checking the mounting of a direction finder on a platform (EL-11).

use deployment::{Input, OnBoard};
use settings::SettingsError;

use super::checked::{Checked, CheckedSource};
use super::tables::DeploymentTable;

/// Mounts the direction finders among the sources on their platforms.
pub(super) fn mount_finders(file: &DeploymentTable, sources: &mut [CheckedSource]) -> Checked<()> {
    for (number, (raw, source)) in file.sources.iter().zip(sources).enumerate() {
        let Some(on_board) = &raw.on_board else { continue };
        let refused = |part: &str, what: String| Err(SettingsError::new(format!("source[{number}].{part}"), what));
        if !source.has_bearings() || !matches!(source.input, Input::Live(_)) {
            let what = "mounts a live direction finder, with [source.live] and [source.locator]; sensors of detections \
                        on board are a [[tracker.sensor]]";
            return refused("on_board", what.to_owned());
        }
        let named = file
            .platforms
            .iter()
            .position(|platform| platform.name == on_board.platform);
        let Some(place) = named else {
            let names: Vec<&str> = file.platforms.iter().map(|platform| platform.name.as_str()).collect();
            let what = match names.is_empty() {
                true => format!("\"{}\": there is no [[platform]]", on_board.platform),
                false => format!(
                    "\"{}\" is no [[platform]]; there are: {}",
                    on_board.platform,
                    names.join(", ")
                ),
            };
            return refused("on_board.platform", what);
        };
        if file.platforms[place].recorded.is_some() {
            let what = format!(
                "\"{}\" is recorded, and the direction finder is live",
                on_board.platform
            );
            return refused("on_board.platform", what);
        }
        if raw.place.is_some() {
            return refused("place", "the platform's states give the place: leave it out".to_owned());
        }
        source.reading.mount = Some(on_board.mount);
        source.on_board = Some(OnBoard {
            platform: Some(place as u16),
        });
    }
    Ok(())
}

#[cfg(test)]
#[path = "finder_tests.rs"]
mod tests;
