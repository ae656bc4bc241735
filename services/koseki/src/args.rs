//! The command line: every command and option, what they mean when they are left out, and their help.

use std::path::PathBuf;
use std::time::Duration;

use clap::error::ErrorKind;
use clap::{Args, CommandFactory as _, Parser, Subcommand};
use formats::asterix::table::EditionError;
use formats::asterix::{Category, Edition, Expansion, registry};
use formats::containers::Container;
use runtime::config::Config;
use runtime::{ConfigError, Now, Options, Speed};

/// Where recordings are looked for if nobody says otherwise.
const DATA_DEFAULT: &str = "../shared/data";
/// Folder that contains what each instance records.
const OUT_DEFAULT: &str = "records";
/// Longest time that `--for` accepts, seconds: a hundred years.
const SECONDS_MAX: f64 = 3.2e9;
/// Times in files reach this far to either side of 0, seconds; no second beyond is worth scoring.
const SECOND_MAX: f64 = 4e6;

/// Real-time fusion of sensor tracks: one system track per target.
///
/// Koseki is a set of processes that share memory: an adapter for each sensor, fusion, a monitor, a recorder and
/// gateways. This executable contains all of them, and the launcher that starts, watches, restarts and stops them.
#[derive(Debug, Parser)]
#[command(name = "koseki", version, max_term_width = 110, after_help = EXAMPLES, after_long_help = EXAMPLES)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

const EXAMPLES: &str = "\
Examples:
  koseki demo --for 20                          simulated sensors, a live table, a report at the end
  koseki check config/barcelona.toml            is this configuration sound, and are its recordings there?
  koseki up config/barcelona.toml --speed max   the recorded airport, as fast as this machine can
  koseki status                                 what runs, in another terminal
  koseki decode radar.pcap --out radar.jsonl    the ASTERIX records of a recording, one JSON object a line
  koseki fuse --tracks a.csv b.csv --refresh 1 --out fused.csv    files of sensor tracks into one picture

Exit codes: 0 success, 1 failure while running, 2 wrong usage or configuration (with one line that says what).";

/// What can be asked for.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Run the demonstration: simulated sensors, no file or network needed
    #[command(after_help = DEMO_EXAMPLES)]
    Demo(Demo),
    /// Start and supervise a deployment
    #[command(after_help = UP_EXAMPLES)]
    Up(Up),
    /// Validate a configuration and its recordings, and say what it would run
    #[command(after_help = CHECK_EXAMPLES)]
    Check(Check),
    /// Show what runs on this machine
    #[command(after_help = STATUS_EXAMPLES)]
    Status(Status),
    /// Tell a running deployment which condition (weather) holds from now on
    #[command(after_help = CONDITION_EXAMPLES)]
    Condition(Condition),
    /// Decode a recording of ASTERIX: its records as JSON, or statistics of them
    #[command(after_help = DECODE_EXAMPLES)]
    Decode(Decode),
    /// Write what simulated sensors see of a simulated world, and the truth
    #[command(after_help = SIMULATE_EXAMPLES)]
    Simulate(Simulate),
    /// Fuse files of sensor tracks into one file of system tracks
    #[command(after_help = FUSE_EXAMPLES)]
    Fuse(Fuse),
    /// Run every fusion rule on the same sensor tracks, and show them side by side
    #[command(after_help = COMPARE_EXAMPLES)]
    Compare(Compare),
    /// Score tracks or fixes against a known truth
    #[command(after_help = SCORE_EXAMPLES)]
    Score(Score),
    /// Run the adapter of one source or receiver in a deployment that is up
    #[command(after_help = SERVE_EXAMPLES)]
    Adapter(Serve),
    /// Run the fusion process in a deployment that is up
    #[command(after_help = SERVE_EXAMPLES)]
    Fusion(Serve),
    /// Run the monitor in a deployment that is up: latencies, losses, counters
    #[command(after_help = SERVE_EXAMPLES)]
    Monitor(Serve),
    /// Run the recorder in a deployment that is up: tracks as CSV files
    #[command(after_help = SERVE_EXAMPLES)]
    Recorder(Serve),
    /// Run one gateway in a deployment that is up: tracks to other systems, in ASTERIX
    #[command(after_help = SERVE_EXAMPLES)]
    Gateway(Serve),
    /// Run the simulator in a deployment that is up: what simulated sensors send, in ASTERIX
    #[command(after_help = SERVE_EXAMPLES)]
    Simulator(Serve),
}

const DEMO_EXAMPLES: &str = "\
Examples:
  koseki demo                         until Ctrl-C
  koseki demo --for 20 --seed 7       another traffic picture, for 20 seconds
  koseki demo --set scenario.targets=200 --set recorder.enabled=true

The configuration is built in; config/demo.toml is its text. To change more than a few values, edit a copy of that file
and start it with `koseki up`.";

/// `koseki demo`.
#[derive(Debug, Args)]
pub(crate) struct Demo {
    /// Stop after so many seconds [default: run until Ctrl-C]
    #[arg(long = "for", value_name = "SECONDS", value_parser = seconds)]
    pub(crate) seconds: Option<Duration>,
    /// Seed of the simulated world: the same seed gives the same traffic
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Name of this instance; several run side by side under different names
    #[arg(long, value_name = "NAME", default_value = "demo")]
    pub(crate) instance: String,
    /// Replace a value of the configuration (repeatable)
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
    /// Folder for what is recorded [default: records/INSTANCE]
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
}

const UP_EXAMPLES: &str = "\
Examples:
  koseki up config/barcelona.toml                        recordings as fast as they were made
  koseki up config/barcelona.toml --speed 10 --for 60    ten times as fast, for a minute
  koseki up config/barcelona.toml --speed max --data /var/recordings --out /tmp/run1
  koseki up config/barcelona.toml --instance b --set fusion.association.use_identity=false

It ends with Ctrl-C (or SIGTERM), after --for, or when all recordings are worked off. Children that die are restarted.
A second Ctrl-C ends it at once; its shared memory is then removed by the next start.";

/// `koseki up`.
#[derive(Debug, Args)]
pub(crate) struct Up {
    /// Configuration of the deployment, a TOML file
    #[arg(value_name = "CONFIG")]
    pub(crate) config: PathBuf,
    /// Stop after so many seconds [default: when all recordings are worked off, or Ctrl-C]
    #[arg(long = "for", value_name = "SECONDS", value_parser = seconds)]
    pub(crate) seconds: Option<Duration>,
    #[command(flatten)]
    pub(crate) shared: Shared,
}

const CHECK_EXAMPLES: &str = "\
Examples:
  koseki check config/barcelona.toml
  koseki check config/barcelona.toml --data /var/recordings --set fusion.core=1

Nothing is started. A mistake is one line on standard error, with file, line or byte, value and remedy; exit code 2.";

/// `koseki check`.
#[derive(Debug, Args)]
pub(crate) struct Check {
    /// Configuration to validate, a TOML file
    #[arg(value_name = "CONFIG")]
    pub(crate) config: PathBuf,
    /// Folder with recordings [default: $KOSEKI_DATA, else ../shared/data]
    #[arg(long, value_name = "DIR")]
    pub(crate) data: Option<PathBuf>,
    /// Replace a value of the configuration (repeatable)
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
}

const STATUS_EXAMPLES: &str = "\
Examples:
  koseki status
  koseki status --instance demo

Instances are looked for in $XDG_RUNTIME_DIR/koseki, or /tmp/koseki-<user number> where that is not set.";

/// `koseki status`.
#[derive(Debug, Args)]
pub(crate) struct Status {
    /// Show only this instance
    #[arg(long, value_name = "NAME")]
    pub(crate) instance: Option<String>,
}

const CONDITION_EXAMPLES: &str = "\
Examples:
  koseki condition rain --instance barcelona
  koseki condition normal --instance barcelona

Sources name conditions in their configuration: [source.accuracy] conditions = { rain = 3.0 } makes a sensor three times
less accurate while it rains. \"normal\" holds at the start and has factor 1 everywhere.";

/// `koseki condition`.
#[derive(Debug, Args)]
pub(crate) struct Condition {
    /// The condition: a name that some source's accuracy has a factor for, or "normal"
    pub(crate) name: String,
    /// The instance that is told
    #[arg(long, value_name = "NAME")]
    pub(crate) instance: String,
}

const DECODE_EXAMPLES: &str = "\
Examples:
  koseki decode radar.pcap --out radar.jsonl
  koseki decode adsb.ast --edition 21=0.23 --out - | head -1
  koseki decode night.ff --statistics --json night.json

FILE holds data blocks and nothing else, or is a capture (pcap, pcapng), or has frames of the final format; its first
octets tell. A line of output has the item numbers of a record as keys, \"_c\" for its category and \"_ts\" for the
second in which it was recorded, where that is known.

What cannot be decoded is summed up on standard error, and is no failure. Only blocks that fit their edition to the last
octet are given, and only categories of which half of the blocks do: the others were made by another edition. The file
is read into memory whole.";

/// `koseki decode`.
#[derive(Debug, Args)]
pub(crate) struct Decode {
    /// The recording
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// Read a category by this edition, as in 21=0.23 (repeatable) [default: see --help]
    #[arg(long = "edition", value_name = "CAT=ED", value_parser = edition, long_help = editions_help())]
    pub(crate) editions: Vec<ChosenEdition>,
    /// Kind of the recording: raw, pcap, pcapng or final [default: what its first octets tell]
    #[arg(long, value_name = "KIND")]
    pub(crate) container: Option<Container>,
    /// Refuse blocks with spare bits set, or with items that go on beyond their edition
    #[arg(long)]
    pub(crate) strict: bool,
    /// File for the records, one JSON object a line; - for standard output
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// Print who sent how much and when, and what was refused
    #[arg(long)]
    pub(crate) statistics: bool,
    /// File for the same statistics as JSON
    #[arg(long, value_name = "FILE", requires = "statistics")]
    pub(crate) json: Option<PathBuf>,
}

/// What `--edition` chooses.
#[derive(Clone, Copy, Debug)]
pub(crate) enum ChosenEdition {
    /// The table of a category.
    Category(&'static Category),
    /// The coding rules of its reserved expansion field.
    Expansion(&'static Expansion),
}

const SIMULATE_EXAMPLES: &str = "\
Examples:
  koseki simulate --scenario demo --seed 1 --out case1
  koseki simulate --scenario dense --seed 3 --for 60 --out case3
  koseki simulate --scenario my.toml --seed 1 --out mine

NAME  demo      a busy airport and its surroundings, seen by four sensors: what `koseki demo` shows
      en-route  the same sensors; all targets fly en route, and all of them meet another one on their way
      dense     demo with 400 targets
FILE  a deployment with [scenario] and simulated sources, as config/demo.toml

DIR/truth.csv            a row per whole second and target that some sensor could see there
DIR/sensor_tracks_K.csv  what sensor K reports, for `koseki fuse`
DIR/detections_K.csv     what it detected before its own tracker made tracks of it; truth_id -1 is a false target
Times begin at 0. The same scenario and seed give the same bytes.";

/// `koseki simulate`.
#[derive(Debug, Args)]
pub(crate) struct Simulate {
    /// Name of a scenario, or a configuration with one
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) scenario: PathBuf,
    /// Seed of the simulated world: the same seed gives the same traffic
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Folder for the files
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// How long a time is simulated, seconds
    #[arg(long = "for", value_name = "SECONDS", default_value = "120", value_parser = seconds)]
    pub(crate) seconds: Duration,
}

const FUSE_EXAMPLES: &str = "\
Examples:
  koseki fuse --tracks radar.csv adsb.csv --refresh 1 --out fused.csv
  koseki fuse --tracks all.csv --rule best-source --out fused.csv --json
  koseki fuse --tracks all.csv --config sensors.toml --out fused.csv

FILE     time_s,sensor_id,sensor_track_id,x,y,z,vx,vy,vz,P00,P01,…,P55,state   a row per report, in the order of time
         and, where known, address,mode_3a,callsign,method,trace,height_valid,velocity_valid. Metres, m/s, the upper
         triangle of the covariance row by row; state is tentative, confirmed, coasted or terminated. A file may hold
         several sensors; several files are merged by time. Rows that cannot be used are left out and counted.
--out    time_s,system_track_id,x,y,z,vx,vy,vz,state,sources,weights,selected,lambda,address,mode_3a,callsign,P00,…,P55
         and more, a row per update. With --refresh a row at every whole multiple of it for each track that is confirmed or
         coasted. Several values in a column are joined with |.
--explain time_s,decision,system_track_id,other_system_track_id,sensor_id,other_sensor_id,sensor_track_id,value,limit
         decision: started, joined, split, merged, confirmed, coasted, ended, hand_over and more; value is what was
         compared with limit.
--config a deployment as for `koseki up` (sensor_id 1 is its first source), or [fusion] and [[sensor]] alone:
           [fusion.rule]
           name = \"best-source\"
           [[sensor]]
           id = 3                # the sensor_id of the files
           period_s = 4.0        # time between two reports of a track
           fresh_s = 10.0        # age beyond which a report no longer counts
           priority = 1          # of equally good sensors the one with the smallest number is taken
           [sensor.accuracy]
           sigma_m = 50.0
           adjustment = 1.0      # more makes it count less
           [sensor.coverage]     # where it sees; else that is learned from its reports
           polygon_m = [[-9e3, -9e3], [9e3, -9e3], [0, 9e3]]    # or range_m, sector_deg and the sensor's position_m
           probability = 0.9     # that it follows a target in there
         What is not configured, a first pass over the files tells: sensors, periods, accuracy as stated, sizes of tables.

The same files and options give the same bytes.";

/// `koseki fuse`.
#[derive(Debug, Args)]
pub(crate) struct Fuse {
    #[command(flatten)]
    pub(crate) input: OfflineInput,
    /// How sources are weighed; auto is the best there is for unknown data [default: what --config says, else auto]
    #[arg(long, value_name = "RULE")]
    pub(crate) rule: Option<String>,
    /// Write rows at whole multiples of so many seconds [default: a row per update]
    #[arg(long, value_name = "SECONDS", value_parser = refresh)]
    pub(crate) refresh: Option<Duration>,
    /// File for the system tracks
    #[arg(long, value_name = "FILE")]
    pub(crate) out: PathBuf,
    /// File for what was decided and why, a row per decision
    #[arg(long, value_name = "FILE")]
    pub(crate) explain: Option<PathBuf>,
    /// Print what was read and found as one JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

/// What the offline engines of fusion are given.
#[derive(Debug, Args)]
pub(crate) struct OfflineInput {
    /// Sensor tracks: CSV files, each in the order of time
    #[arg(long, value_name = "FILE", required = true, num_args = 1..)]
    pub(crate) tracks: Vec<PathBuf>,
    /// What is known of the sensors, and settings of fusion: a TOML file
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
}

const COMPARE_EXAMPLES: &str = "\
Examples:
  koseki compare --tracks radar.csv adsb.csv --truth truth.csv
  koseki compare --tracks all.csv --truth truth.csv --c 100 --gate 50 --markdown
  koseki compare --tracks all.csv --config sensors.toml --json

Inputs are those of `koseki fuse`, figures those of `koseki score` (see their --help); without --truth those that need
none. us_per_report is the time of the engine alone. Every rule has an engine of its own; nothing is written.";

/// `koseki compare`.
#[derive(Debug, Args)]
pub(crate) struct Compare {
    #[command(flatten)]
    pub(crate) input: OfflineInput,
    /// Where the targets are: a CSV file as for `koseki score`
    #[arg(long, value_name = "FILE")]
    pub(crate) truth: Option<PathBuf>,
    /// System tracks are compared at whole multiples of so many seconds
    #[arg(long, value_name = "SECONDS", default_value = "1", value_parser = refresh)]
    pub(crate) refresh: Duration,
    /// Cut-off of GOSPA and OSPA: distance from which a track is no track of a target, metres
    #[arg(long, value_name = "METRES", default_value_t = 500.0, value_parser = above_zero)]
    pub(crate) c: f64,
    /// Distance up to which a target keeps its track, metres
    #[arg(long, value_name = "METRES", default_value_t = 250.0, value_parser = above_zero)]
    pub(crate) gate: f64,
    /// First whole second to score
    #[arg(long, value_name = "SECOND", default_value = "10", value_parser = whole_second, allow_negative_numbers = true)]
    pub(crate) t0: i64,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
    /// Print the table as Markdown
    #[arg(long, conflicts_with = "json")]
    pub(crate) markdown: bool,
}

const SCORE_EXAMPLES: &str = "\
Examples:
  koseki score --truth truth.csv --tracks fused.csv
  koseki score --truth truth.csv --tracks fused.csv --c 100 --gate 50 --json
  koseki score tracks --truth run1/truth.csv run2/truth.csv --tracks run1/tracks.csv run2/tracks.csv --since 40
  koseki score fixes --truth case/truth.csv --fixes case/fixes.csv

At each whole second, the newest state of each track is moved to that second and held against the targets: GOSPA with its
parts and OSPA say how far the picture is from the truth; targets keep their tracks from second to second while these are
nearer than the gate, which gives switches, breaks, completeness and spurious tracks.

truth:   time_s,target_id,x,y,z,vx,vy,vz                            a row per target and whole second
tracks:  time_s,system_track_id (or sensor_track_id),x,y,z,vx,vy,vz  rows with state tentative or terminated are left out
Columns are found by name, others are ignored. A figure that cannot be computed is null in JSON.";

/// `koseki score`.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub(crate) struct Score {
    /// What else is scored.
    #[command(subcommand)]
    pub(crate) what: Option<ScoreWhat>,
    /// Where the targets are: a CSV file
    #[arg(long, value_name = "FILE", required = true)]
    pub(crate) truth: Option<PathBuf>,
    /// The tracks to score: a CSV file
    #[arg(long, value_name = "FILE", required = true)]
    pub(crate) tracks: Option<PathBuf>,
    /// Cut-off of GOSPA and OSPA: distance from which a track is no track of a target, metres
    #[arg(long, value_name = "METRES", default_value_t = 500.0, value_parser = above_zero)]
    pub(crate) c: f64,
    /// Distance up to which a target keeps its track, metres
    #[arg(long, value_name = "METRES", default_value_t = 250.0, value_parser = above_zero)]
    pub(crate) gate: f64,
    /// A state older than this does not show, seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 1.0, value_parser = above_zero)]
    pub(crate) max_age: f64,
    /// First whole second to score
    #[arg(long, value_name = "SECOND", default_value = "10", value_parser = whole_second, allow_negative_numbers = true)]
    pub(crate) t0: i64,
    /// Last whole second to score [default: the last that the truth reaches]
    #[arg(long, value_name = "SECOND", value_parser = whole_second, allow_negative_numbers = true)]
    pub(crate) t1: Option<i64>,
    /// Directions are compared of targets faster than this, m/s
    #[arg(long, value_name = "SPEED", default_value_t = 5.0, value_parser = not_negative)]
    pub(crate) moving: f64,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

/// What `koseki score` scores beside pictures.
#[derive(Debug, Subcommand)]
pub(crate) enum ScoreWhat {
    /// Score how well a tracker tells targets apart, over one or more runs
    #[command(after_help = SCORE_TRACKS_EXAMPLES)]
    Tracks(ScoreTracks),
    /// Score the fixes of a bearings-only locator in a scripted case, over one or more sets of runs
    #[command(after_help = SCORE_FIXES_EXAMPLES)]
    Fixes(ScoreFixes),
}

const SCORE_TRACKS_EXAMPLES: &str = "\
Examples:
  koseki score tracks --truth truth_0.csv --tracks tracks_0.csv --since 60
  koseki score tracks --truth truth_*.csv --tracks tracks_*.csv --json

At each time of the truth from --since on: are exactly as many confirmed tracks near targets as there are targets, each
near another one? Before it, targets cannot be told apart yet, and several tracks are too many. Positions are compared in
the plane; a track shows for 4 s after its newest row, moved along its velocity.

truth:   time_s,x,y                                         a row per target and time
tracks:  time_s,sensor_track_id,x,y,vx,vy,state             rows with state confirmed or coasted count
Several runs: as many --tracks as --truth, in the same order. Shares and delay_s are then means over runs, tracks are added
up, and JSON has the figures of each run under \"each\".";

/// `koseki score tracks`.
#[derive(Debug, Args)]
pub(crate) struct ScoreTracks {
    /// Where the targets are: a CSV file for each run
    #[arg(long, value_name = "FILE", required = true, num_args = 1..)]
    pub(crate) truth: Vec<PathBuf>,
    /// The tracks of each run, in the same order
    #[arg(long, value_name = "FILE", required = true, num_args = 1..)]
    pub(crate) tracks: Vec<PathBuf>,
    /// A track is near a target if it is nearer than this, metres
    #[arg(long, value_name = "METRES", default_value_t = 300.0, value_parser = above_zero)]
    pub(crate) gate: f64,
    /// From when on targets can be told apart, seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0, value_parser = finite, allow_negative_numbers = true)]
    pub(crate) since: f64,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

const SCORE_FIXES_EXAMPLES: &str = "\
Examples:
  koseki score fixes --truth fixed/truth.csv --fixes fixed/fixes.csv
  koseki score fixes --truth seed1/truth.csv seed2/truth.csv --fixes seed1/fixes.csv seed2/fixes.csv --json

Cases: fixed   an emitter 50 km broadside of a straight baseline; the last raw fixes beside their Cramer-Rao bound
       drop    a dropped transmitter drifts straight on while the aircraft circles; the second half counts
       turn    the aircraft turns by 180 degrees with wrong bearings; from 500 s on counts
Which case it is stands in the file meta.json beside each truth, with the baseline (m), sigma_deg and number of runs.

truth:   time_s,emitter_id,x,y                              a row per emitter and bearing
fixes:   time_s,emitter_id,x,y,vx,vy,raw_x,raw_y            rows of times that the truth lacks are left out
Several sets of runs of one case are pooled: as many --fixes as --truth, in the same order.";

/// `koseki score fixes`.
#[derive(Debug, Args)]
pub(crate) struct ScoreFixes {
    /// Where the emitters are: a CSV file with meta.json beside it, for each set of runs
    #[arg(long, value_name = "FILE", required = true, num_args = 1..)]
    pub(crate) truth: Vec<PathBuf>,
    /// The fixes of each set, in the same order
    #[arg(long, value_name = "FILE", required = true, num_args = 1..)]
    pub(crate) fixes: Vec<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

const SERVE_EXAMPLES: &str = "\
Examples:
  koseki adapter --config config/barcelona.toml --name radar
  koseki monitor --config config/barcelona.toml --name second-monitor

`koseki up` starts all of these by itself. Run one by hand to look on with a second monitor, or to replace a process
while trying something; give the same configuration, --instance, --set, --data and --speed as to `koseki up`, which must
be running: it creates the shared memory.";

/// `koseki adapter`, `fusion`, `monitor`, `recorder`, `gateway`, `simulator`.
#[derive(Debug, Args)]
pub(crate) struct Serve {
    /// Configuration of the deployment, a TOML file
    #[arg(long, value_name = "CONFIG")]
    pub(crate) config: PathBuf,
    /// Name of the process; for an adapter, of its source or receiver; for a gateway, its own [default: the command's name]
    #[arg(long, value_name = "NAME")]
    pub(crate) name: Option<String>,
    #[command(flatten)]
    pub(crate) shared: Shared,
    /// When the simulated world began, UTC, nanoseconds [default: now]
    #[arg(long, value_name = "NS", hide = true, allow_negative_numbers = true)]
    pub(crate) scenario_start: Option<i64>,
    /// Process number of the launcher, whose end this process follows
    #[arg(long, value_name = "PID", hide = true)]
    pub(crate) launcher: Option<u32>,
}

/// Options that a deployment and each of its processes have in common.
#[derive(Debug, Args)]
pub(crate) struct Shared {
    /// Folder with recordings [default: $KOSEKI_DATA, else ../shared/data]
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Replay speed of recordings: seconds of the recording per second, or max (nothing is lost at any speed)
    #[arg(long, value_name = "FACTOR|max", default_value = "1", value_parser = speed)]
    speed: Speed,
    /// Folder for what is recorded [default: records/INSTANCE]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Name of this instance; several run side by side under different names [default: the configuration's name]
    #[arg(long, value_name = "NAME")]
    instance: Option<String>,
    /// Replace a value of the configuration, as in fusion.rule.name="best-source" (repeatable)
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Seed of the simulated world, where the configuration has one
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
}

/// A command line that is well-formed, but makes no sense.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub(crate) struct Usage(pub(crate) String);

/// The deployment that `config` describes, and the options that its processes are started with.
///
/// # Errors
/// If the configuration cannot be used.
pub(crate) fn deployment(path: &std::path::Path, shared: Shared) -> Result<(Config, Options), ConfigError> {
    let config = Config::read(path, &shared.set)?;
    let instance = shared.instance.unwrap_or_else(|| config.name.clone());
    let options = Options {
        overrides: shared.set,
        data: data_folder(shared.data),
        out: out_folder(shared.out, &instance),
        speed: shared.speed,
        seed: shared.seed,
        scenario_start_ns: Now::read().utc_ns,
        launcher: None,
        instance,
    };
    Ok((config, options))
}

/// Where recordings are looked for.
pub(crate) fn data_folder(given: Option<PathBuf>) -> PathBuf {
    let from_environment = || std::env::var_os("KOSEKI_DATA").filter(|folder| !folder.is_empty());
    given
        .or_else(|| from_environment().map(PathBuf::from))
        .unwrap_or_else(|| PathBuf::from(DATA_DEFAULT))
}

/// Where an instance's records are written.
pub(crate) fn out_folder(given: Option<PathBuf>, instance: &str) -> PathBuf {
    given.unwrap_or_else(|| PathBuf::from(OUT_DEFAULT).join(instance))
}

/// What clap says about wrong usage, in one line.
pub(crate) fn usage_line(error: &clap::Error) -> String {
    if error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        let command = Cli::command();
        let commands: Vec<&str> = command.get_subcommands().map(clap::Command::get_name).collect();
        return format!(
            "a command is missing; there are {} (see `koseki --help`)",
            commands.join(", ")
        );
    }
    let text = error.to_string();
    let words: Vec<&str> = text
        .lines()
        .take_while(|line| !line.starts_with("Usage:"))
        .filter(|line| !line.trim().is_empty() && !line.starts_with("For more information"))
        .map(str::trim)
        .collect();
    let words = words.join(" ");
    let what = words.strip_prefix("error: ").unwrap_or(&words);
    let first = std::env::args().nth(1);
    let command = first.filter(|word| Cli::command().find_subcommand(word).is_some());
    match command {
        Some(command) => format!("{what} (see `koseki {command} --help`)"),
        None => format!("{what} (see `koseki --help`)"),
    }
}

/// What `CAT=ED` or `CAT/RE=ED` chooses.
fn edition(text: &str) -> Result<ChosenEdition, String> {
    let (category, edition) = text
        .split_once('=')
        .ok_or("write a category and its edition, as in 21=0.23")?;
    let (category, is_expansion) = match category.strip_suffix("/RE") {
        Some(category) => (category, true),
        None => (category, false),
    };
    let number: u8 = category.parse().map_err(|_| "a category is a number up to 255")?;
    let edition: Edition = edition.parse().map_err(|error: EditionError| error.to_string())?;
    let (chosen, what, there_are) = match is_expansion {
        true => (
            registry::find_expansion(number, edition).map(ChosenEdition::Expansion),
            "reserved expansion field of category",
            expansions_of(number),
        ),
        false => (
            registry::find(number, edition).map(ChosenEdition::Category),
            "category",
            editions_of(number),
        ),
    };
    chosen.ok_or_else(|| match there_are.as_str() {
        "" => format!("there is no table for the {what} {number:03}; see `koseki decode --help`"),
        editions => format!("{what} {number:03} has no such edition here; there are {editions}"),
    })
}

/// The editions of a category that there are tables for, the default first.
fn editions_of(category: u8) -> String {
    let editions = registry::editions(category).map(|table| table.edition.to_string());
    editions.collect::<Vec<_>>().join(", ")
}

/// The same of the coding rules of its reserved expansion field.
fn expansions_of(category: u8) -> String {
    let expansions = registry::EXPANSIONS.iter().filter(|rules| rules.number == category);
    let editions = expansions.map(|rules| rules.edition.to_string());
    editions.collect::<Vec<_>>().join(", ")
}

fn editions_help() -> String {
    let mut text =
        "Read a category by this edition, as in 21=0.23 (repeatable). The first of each is the default:".to_owned();
    for table in registry::defaults() {
        let number = table.number;
        text.push_str(&format!("\n  {number:03}: {}", editions_of(number)));
        let expansions = expansions_of(number);
        if !expansions.is_empty() {
            text.push_str(&format!("\n  {number:03}/RE: {expansions}"));
        }
    }
    text.push_str(
        "\nReserved expansion fields (RE) are shown as octets unless an edition of their coding rules is named.",
    );
    text
}

fn seconds(text: &str) -> Result<Duration, String> {
    let seconds: f64 = text.parse().map_err(|_| "write a number of seconds".to_owned())?;
    if seconds > 0.0 && seconds <= SECONDS_MAX {
        return Ok(Duration::from_secs_f64(seconds));
    }
    Err(format!("it must be more than 0 and at most {SECONDS_MAX}"))
}

fn refresh(text: &str) -> Result<Duration, String> {
    let time = seconds(text)?;
    if (Duration::from_millis(1)..=Duration::from_secs(3600)).contains(&time) {
        return Ok(time);
    }
    Err("it must lie between 0.001 and 3600".to_owned())
}

fn speed(text: &str) -> Result<Speed, String> {
    if text == "max" {
        return Ok(Speed::Max);
    }
    let factor: f64 = text.parse().map_err(|_| "write a factor, or max".to_owned())?;
    if factor > 0.0 && factor.is_finite() {
        return Ok(Speed::Factor(factor));
    }
    Err("a factor must be more than 0; write max for as fast as possible".to_owned())
}

fn finite(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| "write a number".to_owned())?;
    number
        .is_finite()
        .then_some(number)
        .ok_or_else(|| "it must be finite".to_owned())
}

fn above_zero(text: &str) -> Result<f64, String> {
    let number = finite(text)?;
    (number > 0.0)
        .then_some(number)
        .ok_or_else(|| "it must be more than 0".to_owned())
}

fn not_negative(text: &str) -> Result<f64, String> {
    let number = finite(text)?;
    (number >= 0.0)
        .then_some(number)
        .ok_or_else(|| "it must not be negative".to_owned())
}

fn whole_second(text: &str) -> Result<i64, String> {
    let second = finite(text)?;
    if second.fract() == 0.0 && second.abs() <= SECOND_MAX {
        return Ok(second as i64);
    }
    Err(format!("pictures are scored at whole seconds up to {SECOND_MAX}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_definitions_are_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn speeds_and_times_are_checked() {
        assert_eq!(speed("2.5"), Ok(Speed::Factor(2.5)));
        assert_eq!(speed("max"), Ok(Speed::Max));
        for wrong in ["0", "-1", "nan", "inf", "fast", ""] {
            assert!(speed(wrong).is_err(), "{wrong}");
        }
        assert_eq!(seconds("1.5"), Ok(Duration::from_millis(1500)));
        for wrong in ["0", "-1", "nan", "inf", "1e30", "soon"] {
            assert!(seconds(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn editions_are_found_or_the_ones_there_are_named() {
        let chosen = edition("21=0.23").unwrap();
        assert!(matches!(chosen, ChosenEdition::Category(table) if table.to_string() == "CAT021 ed 0.23"));
        let chosen = edition("048/RE=1.13").unwrap();
        assert!(matches!(chosen, ChosenEdition::Expansion(rules) if rules.edition == Edition::new(1, 13)));
        for (wrong, expected) in [
            ("21", "as in 21=0.23"),
            ("x=1.0", "a number up to 255"),
            ("300=1.0", "a number up to 255"),
            ("21=023", "is no edition"),
            ("21=9.9", "there are 2.4, 2.1"),
            ("99=1.0", "no table for the category 099"),
            ("48/RE=1.31", "there are 1.11, 1.12, 1.13"),
            ("10/RE=1.1", "no table for the reserved expansion field of category 010"),
        ] {
            let line = edition(wrong).unwrap_err();
            assert!(line.contains(expected), "{line}");
        }
    }

    #[test]
    fn distances_and_seconds_to_score_are_checked() {
        assert_eq!((above_zero("0.5"), not_negative("0")), (Ok(0.5), Ok(0.0)));
        for wrong in ["0", "-1", "nan", "inf", "far"] {
            assert!(above_zero(wrong).is_err(), "{wrong}");
        }
        assert!(not_negative("-0.1").is_err() && finite("inf").is_err());
        assert_eq!((whole_second("10"), whole_second("-3.0")), (Ok(10), Ok(-3)));
        for wrong in ["0.5", "1e7", "nan", "noon"] {
            assert!(whole_second(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn wrong_usage_is_one_line() {
        let cases: [&[&str]; 9] = [
            &["koseki", "score"],
            &["koseki", "score", "--truth", "a.csv"],
            &["koseki", "score", "tracks", "--truth", "a.csv"],
            &[
                "koseki", "score", "--truth", "a.csv", "--tracks", "b.csv", "--t0", "0.5",
            ],
            &["koseki"],
            &["koseki", "upp"],
            &["koseki", "up"],
            &["koseki", "up", "a.toml", "--speed", "fast"],
            &["koseki", "demo", "--fro", "3"],
        ];
        for case in cases {
            let error = Cli::try_parse_from(case).unwrap_err();
            let line = usage_line(&error);
            assert_eq!(line.lines().count(), 1, "{line}");
            assert!(!line.contains("error:") && line.contains("--help"), "{line}");
        }
    }
}
