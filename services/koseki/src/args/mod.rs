//! The command line: commands, options, defaults and help texts.

mod bearings;
mod decode;
mod encode;
mod feed;
mod open;
mod order;
mod recording;
mod replay;
mod secrets;
mod send;
mod tap;
mod values;

use std::ffi::OsString;
use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, Parser, Subcommand};
use offline::values::seconds;
use runtime::{Now, Options, Speed};

use crate::config::Config;
use crate::instances;

use bearings::BEARINGS_EXAMPLES;
pub(crate) use bearings::MeasureBearings;
use decode::DECODE_EXAMPLES;
pub(crate) use decode::DecodeArgs;
use encode::ENCODE_EXAMPLES;
pub(crate) use encode::EncodeArgs;
use feed::FEED_EXAMPLES;
pub(crate) use feed::Feed;
use open::{NEW_EXAMPLES, OPEN_EXAMPLES};
pub(crate) use open::{NewConfig, OpenArgs, SiteKind};
pub(crate) use order::GiveOrder;
use recording::RECORDING_EXAMPLES;
pub(crate) use recording::{
    RecordingCommand, RecordingCut, RecordingExport, RecordingInfo, RecordingMerge, RecordingRepair,
};
use replay::REPLAY_EXAMPLES;
pub(crate) use replay::ReplayArgs;
use send::SEND_EXAMPLES;
pub(crate) use send::{Retime, Send};
use tap::TAP_EXAMPLES;
pub(crate) use tap::{Tap, TapFormat, TapSocket};
use values::{interval, speed};

/// Default folder of recordings.
const DATA_DEFAULT: &str = "../shared/data";
/// Version and commit of the build.
pub(crate) const VERSION: &str = env!("KOSEKI_VERSION");
/// Default parent folder of the instances' records.
const OUT_DEFAULT: &str = "records";

/// Real-time fusion of sensor tracks: one system track per target.
///
/// Koseki is a set of processes that share memory: an adapter for each sensor, fusion, a monitor, a recorder and
/// gateways. This executable contains all of them, and the launcher that starts, watches, restarts and stops them.
#[derive(Debug, Parser)]
#[command(name = "koseki", version = VERSION, max_term_width = 80, after_help = EXAMPLES, after_long_help = EXAMPLES)]
pub(crate) struct Cli {
    /// Base folder of instances [default: see `koseki --help`]
    #[arg(long, value_name = "DIR", global = true)]
    pub(crate) root: Option<PathBuf>,
    #[command(subcommand)]
    pub(crate) command: Command,
}

const EXAMPLES: &str = "\
Examples:
  koseki demo --for 20                        simulated sensors, a live table, a
                                              report at the end
  koseki check config/barcelona.toml          validates a configuration and its
                                              recordings
  koseki up config/barcelona.toml --speed max
                                              the recorded airport, at the
                                              highest speed of this machine
  koseki open tcp://192.168.1.7:30005         a receiver's feed, without a
                                              configuration
  koseki status                               running instances, in another
                                              terminal
  koseki top                                  rates, losses and latencies, live
  koseki decode radar.pcap --out radar.jsonl  the ASTERIX records of a
                                              recording, a JSON object per line
  koseki bench latency --rate 20000           time of a report through fusion,
                                              and the machine's part of the time
  koseki fuse --tracks a.csv b.csv --refresh 1 --out fused.csv
                                              files of sensor tracks into system
                                              tracks
  koseki smooth --tracks a.csv b.csv --refresh 1 --out after.csv
                                              the same system tracks, with later
                                              measurements too
  koseki track --detections radar.csv --out tracks.csv
                                              files of detections into tracks
  koseki locate --bearings flight.csv --out fixes.csv
                                              bearings into positions of
                                              transmitters

The base folder of instances, for a command and its child processes, is that of
--root, or the first folder owned by this user of $KOSEKI_ROOT, /run/koseki,
$XDG_RUNTIME_DIR/koseki and /tmp/koseki-UID.

Exit codes: 0 success; 1 failure while running, or an unusable result (no report
received, the recorder failed, reports of a measurement lost); 2 wrong usage or
configuration. Wrong usage is also a file of the command line that is absent,
unreadable, of another kind, or has nothing that can be used, and a place where
nothing can be written. A line on standard error states the reason.";

/// Commands.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Run the demonstration: simulated sensors, no file or network needed
    #[command(after_help = DEMO_EXAMPLES)]
    Demo(Demo),
    /// Open files or feeds of any known kind, without a configuration: fuse them and show the picture
    #[command(after_help = OPEN_EXAMPLES)]
    Open(OpenArgs),
    /// Print a commented configuration to begin a site with
    #[command(after_help = NEW_EXAMPLES)]
    New(NewConfig),
    /// Start and supervise a deployment
    #[command(after_help = UP_EXAMPLES)]
    Up(Up),
    /// Validate a configuration and its recordings, and print a summary of the deployment
    #[command(after_help = CHECK_EXAMPLES)]
    Check(Check),
    /// Check whether this machine is fit for a deployment, and print remedies
    #[command(after_help = DOCTOR_EXAMPLES)]
    Doctor(Doctor),
    #[cfg_attr(not(feature = "generate"), doc = "Write rules for Prometheus")]
    #[cfg_attr(
        feature = "generate",
        doc = "Write rules for Prometheus, completions for shells, man pages"
    )]
    #[command(after_help = GENERATE_EXAMPLES, subcommand)]
    Generate(Generate),
    /// Show the running instances of this machine
    #[command(after_help = STATUS_EXAMPLES)]
    Status(Status),
    /// Watch a running deployment: rates, losses, latencies, counters, processes
    #[command(after_help = TOP_EXAMPLES)]
    Top(Top),
    /// Give an order to a running deployment, or list the orders in force
    #[command(after_help = order::help())]
    Order(GiveOrder),
    /// Order a weather condition: short for `koseki order condition name=NAME`
    #[command(after_help = CONDITION_EXAMPLES)]
    Condition(ConditionArgs),
    /// Write the samples of a topic as lines of text, or serve the lines at a socket
    #[command(after_help = TAP_EXAMPLES)]
    Tap(Tap),
    /// Publish lines of JSON as the samples of external sources
    #[command(after_help = FEED_EXAMPLES)]
    Feed(Feed),
    /// Summarise, cut, merge or export a recording of all topics
    #[command(after_help = RECORDING_EXAMPLES, subcommand)]
    Recording(RecordingCommand),
    /// Fuse a recording of all topics again: with the same result, bit for bit, or with other settings
    #[command(after_help = REPLAY_EXAMPLES)]
    Replay(ReplayArgs),
    /// Decode a recording of ASTERIX into JSON records or statistics
    #[command(after_help = DECODE_EXAMPLES)]
    Decode(DecodeArgs),
    /// Encode JSON records, in the form of `decode`, into ASTERIX
    #[command(after_help = ENCODE_EXAMPLES)]
    Encode(EncodeArgs),
    #[command(flatten)]
    OnTables(offline::TableCommand),
    /// Measure bearings of emitters from snapshots of an antenna array
    #[command(after_help = BEARINGS_EXAMPLES)]
    Bearings(MeasureBearings),
    /// Send a recording to the network with the original timing
    #[command(after_help = SEND_EXAMPLES)]
    Send(Send),
    /// Measure latency and throughput of the real processes, beside a bare relay (by koseki-lab)
    #[command(disable_help_flag = true)]
    Bench(PassedOn),
    /// Inject random faults into a separate deployment, and judge the effects on a subscriber (by koseki-lab)
    #[command(disable_help_flag = true)]
    Torture(PassedOn),
    /// The launcher's anchor process, which holds the topics open
    #[command(hide = true)]
    Keeper(Serve),
    /// Run the adapter of a source or receiver in a running deployment
    #[command(after_help = SERVE_EXAMPLES)]
    Adapter(Serve),
    /// Run the fusion process in a running deployment
    #[command(after_help = SERVE_EXAMPLES)]
    Fusion(Serve),
    /// Run the monitor in a running deployment: latencies, losses, counters
    #[command(after_help = MONITOR_EXAMPLES)]
    Monitor(Serve),
    /// Run the recorder in a running deployment: tracks as CSV files
    #[command(after_help = SERVE_EXAMPLES)]
    Recorder(Serve),
    /// Find events and dangers about targets in a running deployment: conflicts, closest approach, areas, lost targets
    #[command(after_help = SERVE_EXAMPLES)]
    Alerts(Serve),
    /// Run a gateway in a running deployment: tracks to other systems, in ASTERIX
    #[command(after_help = SERVE_EXAMPLES)]
    Gateway(Serve),
    /// Join deployments on several hosts: make two centres, renew certificates, run a link (by koseki-link)
    #[command(after_help = LINK_EXAMPLES)]
    Link(LinkArgs),
    /// Show the track picture in browsers: run the display in a running deployment, or show a recording
    #[command(after_help = DISPLAY_EXAMPLES)]
    Display(DisplayArgs),
    /// Run the simulator in a running deployment: data of simulated sensors, in ASTERIX
    #[command(after_help = SERVE_EXAMPLES)]
    Simulator(Serve),
}

const DEMO_EXAMPLES: &str = "\
Examples:
  koseki demo                         until Ctrl-C
  koseki demo --for 20 --seed 7       another traffic picture, for 20 seconds
  koseki demo --set scenario.targets=200 --set recorder.enabled=true

The configuration is built in; its text is config/demo.toml. To change more than
a few values, edit a copy of that file and start the copy with `koseki up`.";

/// `koseki demo`.
#[derive(Debug, Args)]
pub(crate) struct Demo {
    /// Stop after this time, seconds [default: run until Ctrl-C]
    #[arg(long = "for", value_name = "SECONDS", value_parser = seconds)]
    pub(crate) seconds: Option<Duration>,
    /// Seed of the simulated world: the same seed gives the same traffic
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Name of this instance; several run side by side under different names
    #[arg(long, value_name = "NAME", default_value = "demo")]
    pub(crate) instance: String,
    /// Run without the display for browsers
    #[arg(long)]
    pub(crate) no_display: bool,
    /// Replace a value of the configuration (repeatable)
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
    /// Parent folder of recordings: each start creates a subfolder, and the link `latest` points to the newest
    /// [default: records/INSTANCE]
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
}

const UP_EXAMPLES: &str = "\
Examples:
  koseki up config/barcelona.toml  recordings at their original speed
  koseki up config/barcelona.toml --speed 10 --for 60
                                   ten times as fast, for a minute
  koseki up config/barcelona.toml --speed max --data /var/recordings \\
      --out /tmp/run1
  koseki up config/barcelona.toml --instance b \\
      --set fusion.association.use_identity=false

A deployment ends with Ctrl-C (or SIGTERM), after --for, or at the end of all
recordings. The launcher restarts dead child processes. A second Ctrl-C ends the
deployment at once; the next start then removes its shared memory.

With live inputs, the next start goes on with the track numbers, and within
checkpoint.max_age_s with the tracks. With --fresh it does not.";

/// `koseki up`.
#[derive(Debug, Args)]
pub(crate) struct Up {
    /// Configuration of the deployment, a TOML file
    #[arg(value_name = "CONFIG")]
    pub(crate) config: PathBuf,
    /// Stop after this time, seconds [default: at the end of all recordings, or Ctrl-C]
    #[arg(long = "for", value_name = "SECONDS", value_parser = seconds)]
    pub(crate) seconds: Option<Duration>,
    /// Begin without the tracks of the last run, and with track numbers that were not given today
    #[arg(long)]
    pub(crate) fresh: bool,
    #[command(flatten)]
    pub(crate) shared: DeploymentArgs,
}

const CHECK_EXAMPLES: &str = "\
Examples:
  koseki check config/barcelona.toml
  koseki check config/barcelona.toml --data /var/recordings --set fusion.core=1
  koseki check config/barcelona.toml --json
  koseki check west/west.toml east/east.toml      both sides of a link

Of two configurations, the command finds what contradicts itself between them:
topics, `shares`, endpoints, certificates, peers, coordinates, regions. Links
are checked by koseki-link; without it, two configurations are refused.

The command starts no process. A mistake is reported in a line on standard
error, with file, line or byte, value and remedy; the exit code is then 2.";

/// `koseki check`.
#[derive(Debug, Args)]
pub(crate) struct Check {
    /// Configuration to validate, a TOML file
    #[arg(value_name = "CONFIG")]
    pub(crate) config: PathBuf,
    /// Configuration of the deployment at the other end of a link
    #[arg(value_name = "OTHER", conflicts_with = "set")]
    pub(crate) other: Option<PathBuf>,
    /// Print the summary as JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Folder with recordings [default: $KOSEKI_DATA, else ../shared/data]
    #[arg(long, value_name = "DIR")]
    pub(crate) data: Option<PathBuf>,
    /// Replace a value of the configuration (repeatable)
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
}

const DOCTOR_EXAMPLES: &str = "\
Examples:
  koseki doctor  for a deployment that waits by event, as the demonstration does
  koseki doctor /etc/koseki/site.toml
  koseki doctor site.toml --json | jq '.[] | select(.verdict != \"good\")'

The output has a line per check: result, requirement, and the remedy as a
command. Run the check as the user, and with the limits, of the later
deployment. Exit code 1 if this machine cannot satisfy a requirement of the
configuration.";

/// `koseki doctor`.
#[derive(Debug, Args)]
pub(crate) struct Doctor {
    /// Configuration of the deployment [default: the demonstration's]
    #[arg(value_name = "CONFIG")]
    pub(crate) config: Option<PathBuf>,
    /// Print the findings as JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Replace a value of the configuration (repeatable)
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
}

#[cfg(not(feature = "generate"))]
const GENERATE_EXAMPLES: &str = "\
Examples:
  koseki generate alerts > /etc/prometheus/rules/koseki.yml

Packages contain completions for shells and man pages, too; this executable does
not write them, since it was built without `--features generate`.";

#[cfg(feature = "generate")]
const GENERATE_EXAMPLES: &str = "\
Examples:
  koseki generate alerts > /etc/prometheus/rules/koseki.yml
  koseki generate completions bash > \\
      /usr/share/bash-completion/completions/koseki
  koseki generate man --out /usr/local/share/man/man1

Packages contain all of these.";

/// `koseki generate`.
#[derive(Debug, Subcommand)]
pub(crate) enum Generate {
    /// Print completions of commands and options for a shell
    #[cfg(any(test, feature = "generate"))]
    Completions {
        /// The shell
        #[arg(value_name = "SHELL")]
        shell: clap_complete::Shell,
    },
    /// Write a man page for each command
    #[cfg(any(test, feature = "generate"))]
    Man {
        /// Folder for the pages; created if missing
        #[arg(long, value_name = "DIR")]
        out: PathBuf,
    },
    /// Print alerting rules of Prometheus for Koseki's alarms
    Alerts,
}

const STATUS_EXAMPLES: &str = "\
Examples:
  koseki status
  koseki status --instance demo
  koseki status --json | jq '.[].alarms'

The folder after each instance is the instance's folder: see --root.";

/// `koseki status`.
#[derive(Debug, Args)]
pub(crate) struct Status {
    /// Show only this instance; exit code 2 if the instance does not run
    #[arg(long, value_name = "NAME")]
    pub(crate) instance: Option<String>,
    /// Print everything as JSON: a list of instances
    #[arg(long)]
    pub(crate) json: bool,
}

const TOP_EXAMPLES: &str = "\
Examples:
  koseki top                         the only running deployment, in the
                                     terminal
  koseki top --instance demo --interval 0.5
  koseki top --once | grep rejected  all tables, once
  koseki top --once --json           the same for programs
  koseki top > top.log               one line per interval

Pages: sources, tracks (number, identity, place, flight level, speed, sources,
age), stages, counters, processes, alarms. Keys: h explains all keys; q, Esc or
Ctrl-C ends; Tab, arrows and 1 to 6 turn pages; up and down select a row; i
changes between the last interval and the total since the start; p pauses. With
NO_COLOR set there are no colours.

The command does not disturb the deployment: no process waits for `top` or wakes
it. The time from fusion to a subscriber is therefore not measured; end to end
ends at the publication by fusion. `koseki bench`, or a monitor with wait =
\"event\", measures the rest.";

/// `koseki top`.
#[derive(Debug, Args)]
pub(crate) struct Top {
    /// Name of the instance [default: the only running instance]
    #[arg(long, value_name = "NAME")]
    pub(crate) instance: Option<String>,
    /// Time between two tables
    #[arg(long, value_name = "SECONDS", default_value = "1", value_parser = interval)]
    pub(crate) interval: Duration,
    /// Print all tables after the first interval, and end
    #[arg(long)]
    pub(crate) once: bool,
    /// Print the tables as JSON
    #[arg(long, requires = "once")]
    pub(crate) json: bool,
}

const CONDITION_EXAMPLES: &str = "\
Examples:
  koseki condition rain --instance barcelona
  koseki condition normal --instance barcelona

Sources name conditions in their configuration: [source.accuracy] conditions = {
rain = 3.0 } makes a sensor three times less accurate while it rains. \"normal\"
holds at the start and has factor 1 everywhere.";

/// `koseki condition`.
#[derive(Debug, Args)]
pub(crate) struct ConditionArgs {
    /// The condition: a name with a factor in some source's accuracy, or "normal"
    pub(crate) name: String,
    /// The instance that receives the order
    #[arg(long, value_name = "NAME")]
    pub(crate) instance: String,
}

const SERVE_EXAMPLES: &str = "\
Examples:
  koseki adapter --config config/barcelona.toml --name radar
  koseki monitor --config config/barcelona.toml --name second-monitor

`koseki up` starts all of these processes. Run a process by hand as a second
monitor, or to replace a process during an experiment. Use the same
configuration, --instance, --set, --data and --speed as for `koseki up`, which
must be running, because the launcher creates the shared memory.";

const DISPLAY_EXAMPLES: &str = "\
Examples:
  koseki display --instance tower --listen 127.0.0.1:8950
      a running instance or a mirror, without its file
  koseki display --recording records/tower/latest
  koseki display --config config/barcelona.toml --name second-display \\
      --listen 127.0.0.1:8950

Without a configuration, sites of sensors, overlays, orders and the comparison
of rules are missing.

A recording must contain all topics: [recorder] format = [\"csv\", \"mcap\"]. The
page of a recording needs no deployment; it is served to this machine only, at
the first free port from 8900, with play, pause and a time slider. `koseki up`
starts the display of a deployment if the configuration has [display].";

const MONITOR_EXAMPLES: &str = "\
Examples:
  koseki monitor --config config/barcelona.toml --name second-monitor
  koseki monitor --config config/barcelona.toml --name exact \\
      --set monitor.wait=event --set monitor.files=false

`koseki up` starts a monitor. For a further monitor, use the same configuration,
--instance, --set, --data and --speed as for `koseki up`, which must be running.

[monitor] wait in the configuration selects the kind of waiting. \"event\": fusion
wakes the monitor for each slice, at a cost of about ten microseconds. \"poll\"
(the default if fusion spins): the monitor reads every poll_ms, without cost for
fusion; transport out is then not measured (shown as -), and end to end ends at
the publication by fusion. `koseki bench`, or a monitor with wait = \"event\",
measures transport out. prometheus = \"127.0.0.1:9464\" serves metrics at
http://127.0.0.1:9464/metrics.";

const LINK_EXAMPLES: &str = "\
Examples:
  koseki link init west=west.example east=east.example
      two centres: configurations, certificates, authority
  koseki link renew west/west.toml east/east.toml --authority authority
      new certificates and keys
  koseki link --config config/west.toml --name to-east
      a link of a running deployment

`koseki link init --help` and `koseki link renew --help` show the options of
these commands.

`koseki up` starts a link for each [[link]] of the configuration. The program
koseki-link is built separately (cargo build --release --manifest-path
link/Cargo.toml). Search order: $KOSEKI_LINK, the folder of koseki, link/target
and target of the checkout in which koseki was built, PATH. docs/hosts.md
describes links.";

/// `koseki adapter`, `fusion`, `alerts`, `monitor`, `recorder`, `gateway`, `link`, `simulator`.
#[derive(Debug, Args)]
pub(crate) struct Serve {
    /// Configuration of the deployment, a TOML file
    // clap puts no flattened argument into the group `Serve`: the group is present exactly if a `Serve` is given.
    #[arg(long, value_name = "CONFIG", group = "Serve")]
    pub(crate) config: PathBuf,
    /// Name of the process: for an adapter, its source or receiver; for a gateway or link, its configured name
    /// [default: the command's name]
    #[arg(long, value_name = "NAME")]
    pub(crate) name: Option<String>,
    #[command(flatten)]
    pub(crate) shared: DeploymentArgs,
    /// Process number of the launcher; this process ends with the launcher
    #[arg(long, value_name = "PID", hide = true)]
    pub(crate) launcher: Option<u32>,
}

/// `koseki link`.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true)]
pub(crate) struct LinkArgs {
    #[command(subcommand)]
    pub(crate) files: Option<LinkFiles>,
    #[command(flatten)]
    pub(crate) serve: Option<Serve>,
}

/// Commands on the files of links, which koseki-link executes.
#[derive(Debug, Subcommand)]
#[command(disable_help_subcommand = true)]
pub(crate) enum LinkFiles {
    /// Make two centres that exchange tracks: their configurations, certificates and authority
    #[command(disable_help_flag = true)]
    Init(PassedOn),
    /// Renew the certificates of links
    #[command(disable_help_flag = true)]
    Renew(PassedOn),
}

/// Arguments for koseki-link or koseki-lab.
#[derive(Debug, Args)]
pub(crate) struct PassedOn {
    /// Arguments; --help shows them
    #[arg(value_name = "ARGUMENTS", trailing_var_arg = true, allow_hyphen_values = true)]
    pub(crate) arguments: Vec<OsString>,
}

/// `koseki display`.
#[derive(Debug, Args)]
pub(crate) struct DisplayArgs {
    /// Show this recording (a folder, or a file of a recording), with labels, maps and start view of CONFIG, if given
    #[arg(long, value_name = "RECORDING", conflicts_with_all = ["instance", "name"])]
    pub(crate) recording: Option<PathBuf>,
    /// Configuration of the deployment, a TOML file; without it, a running instance is shown as far as its topics go
    #[arg(long, value_name = "CONFIG")]
    pub(crate) config: Option<PathBuf>,
    /// Address and port for browsers [default: display.listen; without a configuration the first free port of this
    /// machine from 8900]
    #[arg(long, value_name = "ADDRESS")]
    pub(crate) listen: Option<String>,
    /// Name of the process [default: display]
    #[arg(long, value_name = "NAME", requires = "config")]
    pub(crate) name: Option<String>,
    #[command(flatten)]
    pub(crate) shared: DeploymentArgs,
    /// Process number of the launcher; this process ends with the launcher
    #[arg(long, value_name = "PID", hide = true, requires = "config")]
    pub(crate) launcher: Option<u32>,
}

/// Options that a deployment and each of its processes have in common.
#[derive(Debug, Args)]
pub(crate) struct DeploymentArgs {
    /// Folder with recordings [default: $KOSEKI_DATA, else ../shared/data]
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Replay speed of recordings: seconds of the recording per second, or max (without loss at any speed)
    #[arg(long, value_name = "FACTOR|max", default_value = "1", value_parser = speed)]
    speed: Speed,
    /// Parent folder of recordings: each start creates a subfolder, and the link `latest` points to the newest
    /// [default: records/INSTANCE]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Name of this instance; several run side by side under different names [default: the configuration's name]
    #[arg(long, value_name = "NAME")]
    pub(crate) instance: Option<String>,
    /// Replace a value of the configuration, as in fusion.rule.name="best-source" (repeatable)
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
    /// Seed of the simulated world, if the configuration has a simulated world
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Begin of the simulated world, UTC, nanoseconds [default: now]
    #[arg(long, value_name = "NS", hide = true, allow_negative_numbers = true)]
    scenario_start: Option<i64>,
}

/// Returns the configured deployment and the options of its processes.
///
/// # Errors
/// If the configuration is invalid.
pub(crate) fn deployment(path: &std::path::Path, shared: DeploymentArgs) -> anyhow::Result<(Config, Options)> {
    // Checked before the file is read: an invalid name is wrong with any file.
    if let Some(instance) = &shared.instance {
        instances::named(instance)?;
    }
    // Children get the options of the command line; the environment is theirs already.
    let replaced = secrets::replaced(&shared.set, |variable| std::env::var(variable).ok())?;
    let config = Config::read(path, &replaced)?;
    let instance = shared.instance.unwrap_or_else(|| config.name.clone());
    let options = Options {
        overrides: shared.set,
        data: data_folder(shared.data),
        out: out_folder(shared.out, &instance),
        speed: shared.speed,
        seed: shared.seed,
        scenario_start_ns: shared.scenario_start.unwrap_or_else(|| Now::read().utc_ns),
        launcher: None,
        instance,
    };
    Ok((config, options))
}

/// Returns the folder of recordings: the option, else `$KOSEKI_DATA`, else the default.
pub(crate) fn data_folder(given: Option<PathBuf>) -> PathBuf {
    let from_environment = || std::env::var_os("KOSEKI_DATA").filter(|folder| !folder.is_empty());
    given
        .or_else(|| from_environment().map(PathBuf::from))
        .unwrap_or_else(|| PathBuf::from(DATA_DEFAULT))
}

/// Returns the parent folder of an instance's records.
pub(crate) fn out_folder(given: Option<PathBuf>, instance: &str) -> PathBuf {
    given.unwrap_or_else(|| PathBuf::from(OUT_DEFAULT).join(instance))
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;

    use super::*;

    #[test]
    fn the_definitions_are_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn wrong_usage_is_one_line() {
        let cases: [&[&str]; 7] = [
            &["koseki", "score"],
            &["koseki", "score", "--truth", "a.csv"],
            &["koseki", "score", "tracks", "--truth", "a.csv"],
            &[
                "koseki", "score", "--truth", "a.csv", "--tracks", "b.csv", "--t0", "0.5",
            ],
            &["koseki"],
            &["koseki", "upp"],
            &["koseki", "up", "a.toml", "--speed", "fast"],
        ];
        for case in cases {
            let error = Cli::try_parse_from(case).unwrap_err();
            let words: Vec<String> = case.iter().map(|word| (*word).to_owned()).collect();
            let line = command_line::usage_line(&error, &Cli::command(), &words);
            assert_eq!(line.lines().count(), 1, "{line}");
            assert!(!line.contains("error:") && line.contains("--help"), "{line}");
        }
    }
}
