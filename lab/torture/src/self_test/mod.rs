//! Test of the judge: defects inserted into a sound record; the judge must name each.
//!
//! A judge without findings is useful only if the judge demonstrably detects defects. The record is of a simulated run
//! ([`sound`]), so that the test needs no deployment, or of a live run.

mod defects;
mod record;
mod sound;

use std::path::Path;

use super::judge::finding::Found;
use super::judge::{Judge, Verdict};
use super::{OwnFailure, ledger};
use defects::DEFECTS;
use record::Record;

/// Inserts each defect into the record of a file, or of a simulated run, and prints the judge's findings.
///
/// # Errors
/// [`OwnFailure`] if the judge misses a defect, or has a finding in the simulated record itself.
pub(super) fn run(path: Option<&Path>) -> anyhow::Result<()> {
    let record = match path {
        Some(path) => {
            let (conditions, events) = ledger::read(path)?;
            Record { conditions, events }
        }
        None => sound::record()?,
    };
    let own = judge(&record);
    let mut missed = try_judge(&record, &own)?;
    println!(
        "{} of {} planted defects found; {} kinds of findings in the record itself",
        DEFECTS.len() - missed.len(),
        DEFECTS.len(),
        own.findings.len()
    );
    // Findings in a live run may be true.
    if path.is_none() && !own.findings.is_empty() {
        missed.push(format!("the sound record is called faulty: {}", own.wrong()));
    }
    if missed.is_empty() {
        return Ok(());
    }
    Err(anyhow::anyhow!("{}", missed.join("; ")).context(OwnFailure))
}

/// Names of the defects that the judge does not find, beside the findings in the record itself.
fn try_judge(record: &Record, own: &Verdict) -> anyhow::Result<Vec<String>> {
    let place = record.place()?;
    let mut missed = Vec::new();
    for defect in &DEFECTS {
        let mut spoilt = record.clone();
        (defect.plant)(&mut spoilt, &place);
        let verdict = judge(&spoilt);
        let is_it = |found: &&Found| {
            let before = own.findings.iter().find(|own| own.finding == found.finding);
            defect.findings.contains(&found.finding) && before.is_none_or(|before| before.count < found.count)
        };
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
            figures.picture.seconds > 180 && figures.picture.targets_s > 4000,
            "{figures:?}"
        );
        assert!(
            figures.epochs > 8 && figures.outages > 200 && figures.rebuild_outages > 20,
            "{figures:?}"
        );
    }

    #[test]
    fn the_judge_finds_every_planted_defect() {
        let record = sound::record().expect("a world");
        let missed = try_judge(&record, &judge(&record)).expect("long enough");
        assert_eq!(missed, Vec::<String>::new());
    }
}
