//! Comparison of two track pictures of the same time: the displayed picture, and the picture under other settings.

use std::path::{Path, PathBuf};

use scoring::{FileBasis, PICTURE_WORDS, PictureSettings, Timeline};

use crate::args::ComparePictures;
use crate::files::InputError;
use crate::host::Host;
use crate::printed;

/// Name of the file of system tracks in the folder of a run.
const SYSTEM_TRACKS: &str = "system_tracks.csv";

/// Runs the comparison.
///
/// # Errors
/// If a file cannot be read, or the pictures have no time in common.
pub(super) fn run(asked: &ComparePictures, host: &dyn Host) -> anyhow::Result<()> {
    let [first, second] = [&asked.first, &asked.second].map(|path| file(path));
    let read = |file: &PathBuf, basis| {
        let timeline = Timeline::tracks_on(basis, host.open(file)?, asked.max_age);
        timeline.map_err(|error| InputError::new(file, error))
    };
    let before = read(&first, FileBasis::default())?;
    let after = read(&second, before.basis())?;
    let begins = before.first_second().max(after.first_second());
    let settings = PictureSettings {
        cut_off_m: asked.c,
        age_max_s: asked.max_age,
        first_s: asked.t0.or(begins).unwrap_or_default(),
        last_s: before.last_second().min(after.last_second()),
        gate_m: asked.gate,
        ..PictureSettings::default()
    };
    let found = scoring::score_picture(&before, &after, &settings);
    let found = found.map_err(|error| InputError::new(&first, format!("{error}; see --t0")))?;
    printed::show(host, &found, PICTURE_WORDS, asked.json)
}

fn file(path: &Path) -> PathBuf {
    match path.is_dir() {
        true => path.join(SYSTEM_TRACKS),
        false => path.to_owned(),
    }
}
