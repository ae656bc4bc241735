//! `koseki recording cut`, `merge` and `repair`: recordings of all topics, copied to the bit.

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use offline::{InputError, OutputFile, Usage, check_outputs};
use recording::{Compression, RecordingError, RecordingPart};

use crate::args::{RecordingCut, RecordingMerge, RecordingRepair};
use crate::recording_info::files;
use crate::replay::facts;

/// Fact: which start of which deployment is recorded.
const RUN: &str = "run";

/// Copies a part.
///
/// # Errors
/// If the recording cannot be read, or the copy not be written.
pub(crate) fn cut(cut: RecordingCut) -> anyhow::Result<()> {
    let since_1970 = |time_ns: i64| time_ns.max(0) as u64;
    let part = RecordingPart {
        from_ns: cut.from.map(since_1970),
        to_ns: cut.to.map(since_1970),
        topics: cut.topics,
        ..whole()
    };
    copy(&files(&cut.path)?, &part, &cut.out)
}

/// All of a recording; a copy is always compressed.
fn whole() -> RecordingPart {
    RecordingPart {
        compression: Compression::Zstd,
        ..RecordingPart::default()
    }
}

/// Copies the readable part of a damaged recording.
///
/// # Errors
/// If the recording cannot be read or nothing in it is readable, or the copy cannot be written.
pub(crate) fn repair(repair: &RecordingRepair) -> anyhow::Result<()> {
    copy(&files(&repair.path)?, &whole(), &repair.out)
}

/// Copies several files into a single file.
///
/// # Errors
/// If the files belong to different recordings, a file cannot be read, or the copy cannot be written.
pub(crate) fn merge(merge: &RecordingMerge) -> anyhow::Result<()> {
    let mut paths = Vec::new();
    for path in &merge.paths {
        paths.extend(files(path)?);
    }
    copy(&paths, &whole(), &merge.out)
}

/// Copies into the file `out`, which is written only if there is a sample to copy.
fn copy(paths: &[PathBuf], part: &RecordingPart, out: &Path) -> anyhow::Result<()> {
    check_outputs(paths, &[("--out", Some(&out.to_owned()))])?;
    let run = |path: &PathBuf| Ok::<_, anyhow::Error>(facts(path)?.remove(RUN));
    let first = run(&paths[0])?;
    for path in paths {
        if run(path)? != first {
            let (path, first) = (path.display(), paths[0].display());
            return Err(Usage(format!("{path} is of another start than {first}: merge files of one")).into());
        }
    }
    let opened = paths.iter().map(|path| {
        let opened = File::open(path).with_context(|| format!("reading {}", path.display()))?;
        Ok(BufReader::with_capacity(1 << 18, opened))
    });
    let opened = opened.collect::<anyhow::Result<Vec<_>>>()?;
    let mut file = OutputFile::begin(out)?;
    let copied = recording::copy(opened, part, &mut file).map_err(|error| match error {
        RecordingError::UnknownTopic { .. } => Usage(format!("--topics: the recording {error}")).into(),
        error => anyhow::Error::from(error),
    })?;
    if copied.samples == 0 {
        let (parts, bytes) = (copied.damaged, copied.damaged_bytes);
        let is_part = part.from_ns.or(part.to_ns).is_some() || !part.topics.is_empty();
        let of_part = if is_part { " of these times and topics" } else { "" };
        let what = format!("no sample{of_part} can be read; damaged parts: {parts} ({bytes} bytes)");
        return Err(InputError::new(&paths[0], what).into());
    }
    file.finish()?;
    let skipped = match copied.damaged {
        0 => String::new(),
        parts => format!("; damaged parts skipped: {parts} ({} bytes)", copied.damaged_bytes),
    };
    crate::print(&format!("{} samples in {}{skipped}\n", copied.samples, out.display()))
}
