//! Test of the judge: defects inserted into a sound record; the judge must name each.
//!
//! A judge without findings is useful only if it demonstrably detects defects. The record is of a simulated run
//! ([`sound`]), so that the test needs no deployment, or of a live run.

mod defects;
mod record;
mod sound;

use std::path::Path;

use crate::Refused;
use anyhow::Context as _;

use super::judge::finding::Found;
use super::judge::{Judge, Verdict};
use super::{OwnFailure, ledger};
use defects::{DEFECTS, Place};
use record::Record;

/// Inserts each defect into the record of a file, or of a simulated run, and prints the judge's findings.
///
/// # Errors
/// [`OwnFailure`] if the judge misses a defect, or has a finding in the record itself.
pub(super) fn run(path: Option<&Path>) -> anyhow::Result<()> {
    let record = match path {
        Some(path) => {
            let (conditions, events) = ledger::read(path)?;
            Record { conditions, events }
        }
        None => sound::record()?,
    };
    let mut missed = try_judge(&record)?;
    let sound = judge(&record);
    if !sound.findings.is_empty() {
        missed.push(format!("the sound record is called faulty: {}", sound.wrong()));
    }
    println!(
        "{} of {} planted defects found; {} findings in the record itself",
        DEFECTS.len() + sound.findings.len().min(1) - missed.len(),
        DEFECTS.len(),
        sound.findings.len()
    );
    if missed.is_empty() {
        return Ok(());
    }
    Err(anyhow::anyhow!("{}", missed.join("; ")).context(OwnFailure))
}

/// Names of the defects that the judge does not find.
fn try_judge(record: &Record) -> anyhow::Result<Vec<String>> {
    let short = |what: &str| {
        Refused(format!(
            "the record has no {what}: record a longer run, --only kill-fusion"
        ))
    };
    let kill_ns = record
        .kill_ns()
        .with_context(|| short("kill that a newer fusion followed"))?;
    let targets = record.targets_at(kill_ns);
    anyhow::ensure!(
        targets.len() > 1,
        short("two targets that are shown before and after a kill")
    );
    let (unexcused_ns, length_ns) = record.longest_without_excuse();
    anyhow::ensure!(
        length_ns as f64 / 1e9 > record.conditions.limits.silent_track_s + 2.0,
        short("time in which no fault excuses that the end of a track does not come")
    );
    let place = Place {
        kill_ns,
        targets,
        unexcused_ns,
    };
    let mut missed = Vec::new();
    for defect in &DEFECTS {
        let mut spoilt = record.clone();
        (defect.plant)(&mut spoilt, &place);
        let verdict = judge(&spoilt);
        let is_it = |found: &&Found| found.finding == defect.finding;
        match verdict.findings.iter().find(is_it) {
            Some(found) => println!(
                "found   {}: {} ({})",
                defect.name,
                found.finding.text(),
                found.examples.join("; ")
            ),
            None => {
                println!("missed  {}: {}", defect.name, verdict.wrong());
                missed.push(format!("missed: {}", defect.name));
            }
        }
    }
    Ok(missed)
}

fn judge(record: &Record) -> Verdict {
    let mut judge = Judge::new(record.conditions.clone());
    record.events.iter().for_each(|event| judge.take(event));
    judge.verdict()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_judge_finds_nothing_in_a_sound_record() {
        let verdict = judge(&sound::record().expect("a world"));
        assert_eq!(verdict.wrong(), "");
        let figures = &verdict.figures;
        assert_eq!((figures.targets, figures.renumbered, figures.lost), (24, 0, 10));
        assert!(
            figures.epochs > 8 && figures.outages > 200 && figures.rebuild_outages > 20,
            "{figures:?}"
        );
    }

    #[test]
    fn the_judge_finds_every_planted_defect() {
        let record = sound::record().expect("a world");
        assert_eq!(try_judge(&record).expect("long enough"), Vec::<String>::new());
    }
}
