//! `koseki fuse`: files of sensor tracks into one file of system tracks (FM-5).
//!
//! The engine is the one of the live process, driven as that one is in order of time (PL-12): the same reports give the
//! same bytes. Files are read twice, first to learn what the engine needs to know of the sensors ([`crate::offline`]).

mod rows;
mod summary;

use std::time::Duration;

use anyhow::Context as _;
use fusion::Engine;

use crate::args::{Fuse, Usage};
use crate::files::{OutputFile, is_same_file};
use crate::offline::{Setup, drive, rule};
use rows::Rows;
use summary::Summary;

/// Fuses.
///
/// # Errors
/// If what is asked for makes no sense, or a file cannot be read or written.
pub(crate) fn run(fuse: &Fuse) -> anyhow::Result<()> {
    check_out(fuse)?;
    let named = fuse.rule.as_deref().map(rule).transpose()?;
    let mut setup = Setup::of(&fuse.input)?;
    if let Some(rule) = named {
        setup.settings.rule.rule = rule;
    }
    if let Some(refresh) = fuse.refresh {
        setup.settings.refresh_ns = Some(nanoseconds(refresh));
    }
    let mut engine = Engine::new(setup.settings.clone())?;
    let mut reports = setup.reports()?;
    let out = OutputFile::begin(&fuse.out)?;
    let unwritten = || format!("{} cannot be made", fuse.out.display());
    let mut rows = Rows::begin(out, setup.sensor_ids.clone(), setup.settings.refresh_ns).with_context(unwritten)?;
    let driven = drive(&mut engine, &mut reports, |state| rows.take(state)).with_context(unwritten)?;
    let (out, written) = rows.finish().with_context(unwritten)?;
    out.finish()?;
    let summary = Summary {
        out: &fuse.out,
        setup: &setup,
        engine: &engine,
        refusals: &reports.refusals,
        driven,
        written,
    };
    summary.show(fuse.json)
}

/// What is read must not be written over.
fn check_out(fuse: &Fuse) -> Result<(), Usage> {
    let mut inputs = fuse.input.tracks.iter().chain(&fuse.input.config);
    match inputs.find(|input| is_same_file(input, &fuse.out)) {
        Some(input) => Err(Usage(format!(
            "--out {} is an input; name another file",
            input.display()
        ))),
        None => Ok(()),
    }
}

/// The argument is checked to fit.
fn nanoseconds(time: Duration) -> i64 {
    time.as_nanos() as i64
}
