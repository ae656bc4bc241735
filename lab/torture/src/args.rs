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
sometimes full.

The judge compares the picture of each second with the simulated world, and with the same run without faults, which is
computed beside it: targets that are missing, second tracks, tracks without a target, addresses, errors of positions,
heights and velocities, ages. It keeps a ledger of each target over the whole run: a target keeps its number until its
track is terminated, each track is terminated, and no number is assigned twice. Limits of errors are ratios to the run
without faults. A fault excuses only what it takes away itself, for the times that the output states; a fault of a
process that only looks on excuses nothing. Without a simulated world, numbers and times are judged alone.

A record (--record) is a JSON object per line: first the run; then events, among them each state that was received and
each second of the world, with what the run without faults shows. --judge and --self-test take any such record.

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
    /// Write the judge's input, a JSON object per line
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Judge a record again, without a deployment
    #[arg(long, value_name = "FILE", conflicts_with_all = ["config", "record", "json", "self_test"])]
    pub judge: Option<PathBuf>,
    /// Test the judge: inserts many defects into a record (FILE, or of a simulated run); the judge must find each
    #[arg(long, value_name = "FILE", num_args = 0..=1, conflicts_with_all = ["config", "record", "json"])]
    pub self_test: Option<Option<PathBuf>>,
    /// Write the result
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Replace a value of the configuration (repeatable)
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
}
