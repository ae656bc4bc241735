//! Arguments of `koseki torture`.

use std::path::PathBuf;

use clap::Args;

/// Text after the help of the command.
pub const EXAMPLES: &str = "\
Examples:
  koseki torture --minutes 3 --seed 7 --json torture.json
  koseki torture --set fusion.standby=true
  koseki torture tower.toml --minutes 60
  koseki torture --only none --minutes 30 --json soak.json
  koseki torture --minutes 2 --record events.jsonl
  koseki torture --judge events.jsonl
  koseki torture --self-test

The command starts a separate deployment in a separate folder; other deployments are not affected. The seed alone
determines kind, time and victim of each fault. As root, disk and shared memory are separate file systems, which are
sometimes full. The judge keeps a ledger of each target, identified by address, over the whole run. Requirements: a
target keeps its number until its track is terminated, and each track is terminated; no number is assigned twice; the
shown position is correct; after each fault the target is shown again in time, and the deployment recovers.

Limits on a machine without other work, in seconds, including the second or so between two reports of a target:
                                   median   99 %   worst
  outage of a target at a fault       2.0    4.0     8.0
  the same, fusion.standby = true     1.5    3.0     6.0
  outage at a restart of all            -      -    15.0
  two tracks of one target              -      -    10.0
  silent track, beyond terminate_s      -      -    10.0
The margin for other work of the machine multiplies all limits (--margin, usually 2). Position errors exceed 300 m in
fewer than three successive states; the margin does not change this limit. Output and JSON contain the resulting limits.

Exit codes: 0 sound; 1 faulty, with reasons; 2 wrong usage or configuration; 3 no verdict, because the command itself
failed or was interrupted. The JSON file is written except with code 2, and after each fault (\"outcome\": \"running\").";

/// Arguments of `koseki torture`.
#[derive(Debug, Args)]
pub struct Torture {
    /// Configuration of the deployment under test [default: the demonstration's, with a direction finder]
    #[arg(value_name = "CONFIG")]
    pub config: Option<PathBuf>,
    /// Duration
    #[arg(long, value_name = "MINUTES", default_value_t = 3.0)]
    pub minutes: f64,
    /// Seed of the faults
    #[arg(long, value_name = "NUMBER", default_value_t = 1)]
    pub seed: u64,
    /// Inject this fault only (repeatable); none: no fault, to measure the use of the machine in the long run
    #[arg(long, value_name = "FAULT")]
    pub only: Vec<String>,
    /// Factor on all limits of time, for a machine with other work
    #[arg(long, value_name = "FACTOR", default_value_t = 2.0, value_parser = margin)]
    pub margin: f64,
    /// Write the judge's input, a JSON object per line
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Judge a record again, without a deployment
    #[arg(long, value_name = "FILE", conflicts_with_all = ["config", "record", "json", "self_test"])]
    pub judge: Option<PathBuf>,
    /// Test the judge: inserts many defects into a sound record (FILE, or of a simulated run); the judge must find each
    /// defect, and none in the record itself
    #[arg(long, value_name = "FILE", num_args = 0..=1, conflicts_with_all = ["config", "record", "json"])]
    pub self_test: Option<Option<PathBuf>>,
    /// Write the result
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Replace a value of the configuration (repeatable)
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
}

fn margin(text: &str) -> Result<f64, String> {
    let factor: f64 = text.parse().map_err(|error| format!("{error}"))?;
    if (1.0..=100.0).contains(&factor) {
        return Ok(factor);
    }
    Err("it must lie between 1 and 100".to_owned())
}
