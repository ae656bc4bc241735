//! `koseki torture`: faults at random on a deployment of its own, and an independent tally of what a subscriber sees.
//!
//! The deployment lives in a folder of its own that goes with it, beside whatever else runs on the machine. Which fault
//! comes when is drawn from the seed alone, so that a run can be repeated. The simulated world goes on whatever dies,
//! the launcher too: an address is one target all the time. After each fault everything must come back:
//! every process, and states of the newest epoch. The tally ([`scoring::NumberTally`]) tells targets apart by their
//! addresses; the launcher's and the subscribers' own counters are not asked.

mod deployment;
mod faults;
mod own_file_systems;
mod resources;
mod sequence_tally;

use std::collections::BTreeSet;
use std::time::Duration;

use anyhow::Context as _;
use offline::Usage;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use runtime::clock::instant;
use serde::Serialize;

use crate::args::Torture;
use deployment::Deployment;
use faults::{FAULTS, Fault};
use resources::Resources;

/// Time after a fault within which everything must be back: a process that dies again and again is started ever later.
const PATIENCE: Duration = Duration::from_secs(60);
/// Time between two faults: a part of it fixed, and a part drawn.
const PAUSE: Duration = Duration::from_millis(1500);
const PAUSE_DRAWN_MS: u64 = 3000;

/// Time between two looks at what is used, seconds.
const RESOURCES_S: f64 = 15.0;

/// Result of a run.
#[derive(Debug, Default, Serialize)]
struct Report {
    seed: u64,
    seconds: f64,
    faults: Vec<Happened>,
    /// Use of the machine, a look each quarter of a minute.
    resources: Vec<Resources>,
    /// Times that a fusion that stood by took over, and those of them from one that stood still.
    take_overs: u64,
    take_overs_from_still: u64,
    /// Samples lost on the way to who looked on: counted, and true by their numbers.
    lost: u64,
    /// States that came, and epochs.
    states: u64,
    epochs: usize,
    /// Targets that went on under another number.
    renumbered: usize,
    /// Numbers that were given twice.
    reused: usize,
    /// States that an older fusion sent after a newer one had begun.
    late: u64,
    /// Files, memory and processes that were left at the end.
    left_behind: Vec<String>,
    /// Faults of the deployment: what was not as it must be; empty if all was.
    wrong: Vec<String>,
}

/// A fault that was caused.
#[derive(Debug, Serialize)]
struct Happened {
    at_s: f64,
    fault: &'static str,
    what: String,
    /// Time until all processes were there and states came again.
    back_s: f64,
    renumbered: usize,
}

/// Runs the faults, and says what came of them.
///
/// # Errors
/// If the deployment does not start, or something was not as it must be.
pub(crate) fn run(torture: &Torture) -> anyhow::Result<()> {
    let is_known = |name: &&String| *name == "none" || FAULTS.iter().any(|fault| fault.name == name.as_str());
    if let Some(unknown) = torture.only.iter().find(|name| !is_known(name)) {
        let names: Vec<&str> = FAULTS.iter().map(|fault| fault.name).collect();
        return Err(Usage(format!("--only {unknown}: there are none and {}", names.join(", "))).into());
    }
    own_file_systems::enter()?;
    let mut report = Report {
        seed: torture.seed,
        ..Report::default()
    };
    let mut deployment = Deployment::start(torture)?;
    let mut random = ChaCha8Rng::seed_from_u64(torture.seed);
    let begun = instant();
    let end = Duration::from_secs_f64(60.0 * torture.minutes);
    let wanted = |fault: &&Fault| torture.only.is_empty() || torture.only.iter().any(|name| name == fault.name);
    let possible: Vec<&Fault> = FAULTS
        .iter()
        .filter(|fault| deployment.has(fault.needs))
        .filter(wanted)
        .collect();
    let mut epochs = BTreeSet::new();
    let mut next_resources_s = 0.0;
    while instant() - begun < end && report.wrong.is_empty() {
        let now_s = (instant() - begun).as_secs_f64();
        if now_s >= next_resources_s {
            report.resources.push(deployment.resources(now_s)?);
            next_resources_s = now_s + RESOURCES_S;
        }
        let pause = PAUSE + Duration::from_millis(random.random_range(0..PAUSE_DRAWN_MS));
        deployment.watch(pause)?;
        if possible.is_empty() {
            continue;
        }
        let fault = possible[random.random_range(0..possible.len())];
        let at_s = (instant() - begun).as_secs_f64();
        let before = deployment.tally().clone();
        let caused = instant();
        let what = (fault.cause)(&mut deployment, &mut random).with_context(|| fault.name)?;
        let back = deployment.until_back(PATIENCE)?;
        let away_ns = deployment.tally().began_ns() - before.latest_ns();
        let renumbered = match fault.keeps_numbers && away_ns < deployment.max_age_ns() {
            true => deployment.tally().renumbered(&before),
            false => {
                deployment.forget_carriers();
                Vec::new()
            }
        };
        epochs.insert(deployment.tally().epoch());
        let back_s = (instant() - caused).as_secs_f64();
        println!("{at_s:7.1} s  {:<20} {what}; back after {back_s:.2} s", fault.name);
        if !renumbered.is_empty() {
            println!("           renumbered (address, before, now): {renumbered:?}");
        }
        if let Some(missing) = back {
            report.wrong.push(format!("{} at {at_s:.1} s: {missing}", fault.name));
        }
        report.renumbered += renumbered.len();
        report.faults.push(Happened {
            at_s,
            fault: fault.name,
            what,
            back_s,
            renumbered: renumbered.len(),
        });
    }
    deployment.look_away();
    (report.take_overs, report.take_overs_from_still, report.lost) = deployment.counted();
    report.wrong.extend_from_slice(deployment.miscounted());
    let tally = deployment.tally();
    (report.states, report.late, report.reused) = (tally.states(), tally.late(), tally.reused().len());
    epochs.insert(tally.epoch());
    report.epochs = epochs.len();
    report.left_behind = deployment.stop()?;
    report.seconds = (instant() - begun).as_secs_f64();
    judge(&mut report);
    conclude(torture, &report)
}

fn judge(report: &mut Report) {
    let counts = [
        (report.renumbered as u64, "targets went on under another number"),
        (report.reused as u64, "numbers were given twice"),
        (report.late, "states were sent by a fusion after a newer one had begun"),
        (report.left_behind.len() as u64, "things were left behind"),
    ];
    let wrong = counts.iter().filter(|(count, _)| *count > 0);
    report
        .wrong
        .extend(wrong.map(|(count, what)| format!("{count} {what}")));
}

fn conclude(torture: &Torture, report: &Report) -> anyhow::Result<()> {
    if let Some(path) = &torture.json {
        let text = serde_json::to_string_pretty(report)?;
        std::fs::write(path, text + "\n").with_context(|| format!("writing {}", path.display()))?;
    }
    let growth = resources::growth(&report.resources);
    println!("resident memory, MiB, at first, in the middle and at last: {growth}");
    println!(
        "{} faults in {:.0} s, {} states of {} epochs, {} lost and counted, {} take-overs ({} from one that stood \
         still): {} targets renumbered, {} numbers given twice, {} left behind",
        report.faults.len(),
        report.seconds,
        report.states,
        report.epochs,
        report.lost,
        report.take_overs,
        report.take_overs_from_still,
        report.renumbered,
        report.reused,
        report.left_behind.len()
    );
    anyhow::ensure!(
        report.wrong.is_empty(),
        "{}; seed {} does it again",
        report.wrong.join("; "),
        report.seed
    );
    Ok(())
}
