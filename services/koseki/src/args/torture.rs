//! `koseki torture`.

use std::path::PathBuf;

use clap::Args;

pub(super) const TORTURE_EXAMPLES: &str = "\
Examples:
  koseki torture --minutes 3 --seed 7 --json torture.json
  koseki torture --set fusion.standby=true
  koseki torture tower.toml --minutes 60
  koseki torture --only none --minutes 30 --json soak.json
  koseki torture --minutes 2 --record events.jsonl
  koseki torture --judge events.jsonl
  koseki torture --self-test

The deployment is one of its own, in a folder of its own: what else runs on the machine is not touched. The seed alone
decides which faults come, when, and whom they hit. As root, disk and shared memory are file systems of its own, and are
full now and then. The judge keeps a ledger of each target over the whole run, told apart by its address: a target keeps
its number until its track is terminated, and each track is terminated; no number is given twice; the target is shown
where it is; after each fault it is shown again in time, and the deployment heals by itself.

Limits on a machine without other work, in seconds, with the second or so between two reports of a target:
                                   median   99 %   worst
  outage of a target at a fault       2.0    4.0     8.0
  the same, fusion.standby = true     1.5    3.0     6.0
  where all starts again                -      -    15.0
  two tracks of one target              -      -    10.0
  silent track, beyond terminate_s      -      -    10.0
The margin for other work of the machine multiplies all of them (--margin, usually 2). Positions are 300 m off at most,
three states in a row; the margin does not change that. Limits with the margin in them are part of output and JSON.

Exit codes: 0 sound; 1 faulty, with reasons; 2 wrong usage or configuration; 3 no verdict, since the command itself
failed or was interrupted. The JSON file is written in each case but 2, and after each fault (\"outcome\": \"running\").";

/// `koseki torture`.
#[derive(Debug, Args)]
pub(crate) struct Torture {
    /// Configuration of what is to suffer [default: the demonstration's]
    #[arg(value_name = "CONFIG")]
    pub(crate) config: Option<PathBuf>,
    /// How long
    #[arg(long, value_name = "MINUTES", default_value_t = 3.0)]
    pub(crate) minutes: f64,
    /// Seed of the faults
    #[arg(long, value_name = "NUMBER", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Cause this fault only (repeatable); none: no fault, to see what is used of the machine in the long run
    #[arg(long, value_name = "FAULT")]
    pub(crate) only: Vec<String>,
    /// Factor on all limits of time, for a machine with other work
    #[arg(long, value_name = "FACTOR", default_value_t = 2.0, value_parser = margin)]
    pub(crate) margin: f64,
    /// Write what the judge sees, one JSON object a line
    #[arg(long, value_name = "FILE")]
    pub(crate) record: Option<PathBuf>,
    /// Judge a record again, and start nothing
    #[arg(long, value_name = "FILE", conflicts_with_all = ["config", "record", "json", "self_test"])]
    pub(crate) judge: Option<PathBuf>,
    /// Try the judge: it has to find each of many defects that are planted in a sound record, FILE or one of a
    /// simulated run, and nothing in the record itself
    #[arg(long, value_name = "FILE", num_args = 0..=1, conflicts_with_all = ["config", "record", "json"])]
    pub(crate) self_test: Option<Option<PathBuf>>,
    /// Write the result
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    /// Replace a value of the configuration (repeatable)
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
}

fn margin(text: &str) -> Result<f64, String> {
    let factor: f64 = text.parse().map_err(|error| format!("{error}"))?;
    if (1.0..=100.0).contains(&factor) {
        return Ok(factor);
    }
    Err("it must lie between 1 and 100".to_owned())
}
