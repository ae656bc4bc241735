//! Commands on files: their arguments and their help.

mod smooth;

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, Command, Parser, Subcommand};
use command_line::refusal;
use command_line::values::above_zero;
use csv_table::{NamedColumn, SENSOR_COLUMNS, TARGET_COLUMNS, named_columns_help};
use formats::alerts_csv::AlertRow;
use formats::cues_csv::CueRow;
use formats::rows::Row as _;
use frames::Geodetic;
use locating::DroppedEmitter;
use messages::Decision;

use crate::files::Usage;
use crate::locate_columns::{DECISION_COLUMNS, FIX_COLUMNS};
use crate::score_args::{SCORE_EXAMPLES, Score};
use crate::values::{place, refresh, seconds, whole_second};
use smooth::SMOOTH_EXAMPLES;

pub use smooth::Smooth;

/// A command on tables.
#[derive(Debug, Subcommand)]
#[command(mut_subcommands(with_help_on_request))]
pub enum TableCommand {
    /// Write the reports of simulated sensors in a simulated world, and the truth
    #[command(after_help = SIMULATE_EXAMPLES)]
    Simulate(Simulate),
    /// Fuse files of sensor tracks into one file of system tracks
    Fuse(Fuse),
    /// Smooth the system tracks of a recording, or of files of sensor tracks, with later measurements
    #[command(after_help = SMOOTH_EXAMPLES)]
    Smooth(Smooth),
    /// Track targets in files of detections
    Track(TrackArgs),
    /// Locate emitters from files of bearings, measured by a moving platform
    Locate(Locate),
    /// Run every fusion rule on the same sensor tracks, and show the results side by side
    #[command(after_help = COMPARE_EXAMPLES)]
    Compare(Compare),
    /// Score tracks or fixes against a known truth
    #[command(after_help = SCORE_EXAMPLES)]
    Score(Score),
}

/// Lets the help with keys of configurations be made for the given command only, not at each start of any command.
fn with_help_on_request(command: Command) -> Command {
    match command.get_name() {
        "fuse" => command.defer(|command| command.after_help(fuse_examples())),
        "track" => command.defer(|command| command.after_help(track_examples())),
        "locate" => command.defer(|command| command.after_help(locate_examples())),
        _ => command,
    }
}

/// Words without an executable before them.
#[derive(Debug, Parser)]
#[command(no_binary_name = true)]
struct CommandLine {
    #[command(subcommand)]
    command: TableCommand,
}

impl TableCommand {
    /// Parses the command in `words`; the first word is its name.
    ///
    /// # Errors
    /// If `words` are no valid command.
    pub fn of(words: &[String]) -> Result<Self, Usage> {
        let line = CommandLine::try_parse_from(words).map_err(|error| Usage(refusal(&error)))?;
        Ok(line.command)
    }
}

const SIMULATE_EXAMPLES: &str = "\
Examples:
  koseki simulate --scenario demo --seed 1 --out case1
  koseki simulate --scenario dense --seed 3 --for 60 --out case3
  koseki simulate --scenario my.toml --seed 1 --out mine
  koseki simulate --scenario wide-area --set scenario.formation[0].count=1 \\
      --seed 1 --for 200 --out pair

NAME
      demo       a busy airport and its surroundings with five sensors, as in
                 `koseki demo`
      en-route   the same sensors; all targets fly en route, and every target
                 meets another target
      dense      demo with 400 targets
      mode-s     200 targets that cross in a small space; plots of radar-south
                 (sensor 5) have addresses, codes, levels
      wide-area  formations not resolved by two radars but counted by a remote
                 sensor: config/wide-area.toml
      on-board   a ship that rolls and turns, with a radar: platform.csv,
                 detections.csv (from the bow), at_rest.csv (the same looks from
                 a radar at rest), truth.csv and mounting.toml for `koseki track
                 --platform`; --set roll_deg, turn_degps, attitude_sigma_deg,
                 error_time_s, lever_arm_m, … (docs/platform.md)
FILE  a deployment with [scenario] and simulated sources, as config/demo.toml or
      config/coast.toml

DIR/truth.csv            a row per whole second and visible target
DIR/sensor_tracks_K.csv  reports of sensor K, for `koseki fuse`
DIR/detections_K.csv     detections of sensor K, the input of its own tracker;
                         truth_id -1 is a false target, merged are several
                         targets in the same detection; columns of replies (as
                         for `koseki track`) if a sensor has address_probability
                         or code_probability
DIR/asterix_K.ast        with --asterix, data sent by sensor K: for `koseki
                         decode` and `koseki send`
DIR/bearings_K.csv       in place of both, bearings of direction finder K, for
                         `koseki locate`; emitter_id is the target's
DIR/snapshots_K.csv      in place of these, if the finder has an array: for
                         `koseki bearings --array` and `koseki send`
DIR/ais_K.nmea           lines of the receivers of AIS of source K, from
                         2020-01-01 on: `koseki open`, or a recording of AIS
DIR/wide_area_NAME.csv   counts of the wide-area sensor of this name, for
                         `koseki track --wide-area`
Times begin at 0. The same scenario and seed give the same bytes.";

/// `koseki simulate`.
#[derive(Debug, Args)]
pub struct Simulate {
    /// Name of a scenario, or a configuration with a scenario
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) scenario: PathBuf,
    /// Seed of the simulated world: the same seed gives the same traffic
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Folder for the files
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Simulated time, seconds
    #[arg(long = "for", value_name = "SECONDS", default_value = "120", value_parser = seconds)]
    pub(crate) seconds: Duration,
    /// Write the ASTERIX data of each sensor, too
    #[arg(long)]
    pub(crate) asterix: bool,
    /// Replace a value of the scenario's configuration (repeatable)
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
}

const FUSE_EXAMPLES: &str = "\
Examples:
  koseki fuse --tracks radar.csv adsb.csv --refresh 1 --out fused.csv
  koseki fuse --tracks all.csv --rule best-source --out fused.csv --json
  koseki fuse --tracks all.csv --config sensors.toml --out fused.csv
  koseki fuse --tracks radar.csv adsb.csv --out fused.csv --picture seven.svg \\
      --track 7
  koseki fuse --tracks ships.csv --sigma 15 --out fused.csv

FILE     time_s,sensor_id,sensor_track_id,x,y,z,vx,vy,vz,P00,P01,…,P55,state
         and, if known,
         address,mode_3a,callsign,method,trace,height_valid,velocity_valid, of
         ships mmsi,name, and from `koseki track`
         kind,members,type,type_confidence (docs/wide-area.md); a row per
         report, in the order of time. Metres, m/s, the upper triangle of the
         covariance row by row, or instead only its trace over east and north;
         state is tentative, confirmed, coasted or terminated. A file may
         contain several sensors; several files are merged by time. Unusable
         rows are omitted and counted; a file is refused if more than 1 % of its
         rows are out of order. Times count on across midnight, or from 1970
         (UTC) in all files. With a column arrival_s (absolute, not before
         time_s), rows are delivered in its order, whatever their order in the
         file, and time passes with it; a row that is late by up to
         fusion.late_window_s (10 s) changes the states as if it had come in
         time.
FILE     or a table with columns of these names, in any case and order: time,
         latitude and longitude (or x and y), and others. Rows are in the order
         of time. Columns with other names are not used, and listed. An empty
         value, nan, null or None is unknown. Without sigma_m, positions have
         30 m if the targets have address or mmsi, else 100 m. Without --origin
         or a deployment in --config, the first position is the origin. The
         summary lists all assumptions. --out has utc, latitude and longitude,
         too.
{NAMED}
--out    time_s,system_track_id,x,y,z,vx,vy,vz,state,sources,weights,selected,
         lambda,address,mode_3a,callsign,P00,…,P55 and more, at the end
         mmsi,name and steady_weight,…,steady_P55, the velocity without a
         manoeuvre; a row per update. With --refresh a row per confirmed or
         coasted track at every whole multiple of the interval. Several values
         in a column are joined with |.
--explain {DECISION}
         decision: started, joined, split, merged, confirmed, coasted, ended,
         hand_over and more; value was compared with limit.
--alerts  {ALERT}
         docs/alerts.md has the rules and what each column is.
--smoothed rows as in --out. A state has the age of --smoothing-lag, or up to a
         quarter more. Without --refresh there are at most two a second of a
         track.
--config a deployment as for `koseki up` (sensor_id 1 is its first source), or
         [fusion] and [[sensor]] alone:
           [fusion.rule]
           name = \"best-source\"
           [[sensor]]
{KEYS}
         docs/configuration.md lists the keys of [fusion] and their permitted
         values.
         A first pass over the files determines missing settings: sensors,
         periods, stated accuracy, sizes of tables.

The same files and options give the same bytes.";

/// Divides names of columns, apart by commas, into lines behind the words of an option.
fn in_lines(columns: &str) -> String {
    const LINE: usize = 70;
    let mut lines = vec![String::new()];
    for name in columns.split_inclusive(',') {
        match lines.last_mut() {
            Some(line) if line.len() + name.len() <= LINE => line.push_str(name),
            _ => lines.push(name.to_owned()),
        }
    }
    lines.join("\n         ")
}

/// Whether the command line asks for a text of help. The parser makes the texts of all commands at each start.
fn is_help_asked() -> bool {
    let asks = ["--help", "-h", "help", "generate"];
    std::env::args_os().any(|word| asks.iter().any(|asked| word == *asked))
}

/// Names of columns in lines of help.
fn names_of(columns: &[NamedColumn]) -> String {
    let named = named_columns_help(columns, 69);
    let lines: Vec<_> = named.lines().map(|line| format!("           {line}")).collect();
    lines.join("\n")
}

/// Returns the help of `koseki fuse`, with the keys of a sensor and the named columns; empty unless help is asked for.
fn fuse_examples() -> String {
    if !is_help_asked() {
        return String::new();
    }
    let text = FUSE_EXAMPLES.replace("{KEYS}", configuration::sensor_help().trim_end());
    let text = text.replace("{NAMED}", &names_of(TARGET_COLUMNS));
    text.replace("{DECISION}", &in_lines(&Decision::columns()))
        .replace("{ALERT}", &in_lines(&AlertRow::columns()))
}

/// `koseki fuse`.
#[derive(Debug, Args)]
pub struct Fuse {
    #[command(flatten)]
    pub(crate) input: OfflineInput,
    /// Rule for the weights of sources; auto suits unknown data best [default: the rule in --config, else auto]
    #[arg(long, value_name = "RULE")]
    pub(crate) rule: Option<String>,
    /// Write rows at whole multiples of this interval, seconds [default: a row per update]
    #[arg(long, value_name = "SECONDS", value_parser = refresh)]
    pub(crate) refresh: Option<Duration>,
    /// File for the system tracks; - for standard output
    #[arg(long, value_name = "FILE")]
    pub(crate) out: PathBuf,
    /// File for decisions with their reasons, a row per decision
    #[arg(long, value_name = "FILE")]
    pub(crate) explain: Option<PathBuf>,
    /// File for alerts on targets, by the [[alert]] tables of the deployment in --config
    #[arg(long, value_name = "FILE", requires = "config")]
    pub(crate) alerts: Option<PathBuf>,
    /// File for the system tracks of some seconds ago, smoothed with the measurements since then
    #[arg(long, value_name = "FILE")]
    pub(crate) smoothed: Option<PathBuf>,
    /// Age of the states in --smoothed, seconds [default: fusion.smoothing_lag_s in --config, else 10]
    #[arg(long, value_name = "SECONDS", requires = "smoothed", value_parser = refresh)]
    pub(crate) smoothing_lag: Option<Duration>,
    /// File for a plot (SVG): the system tracks over their reports
    #[arg(long, value_name = "FILE")]
    pub(crate) picture: Option<PathBuf>,
    /// The system track in the plot [default: all]
    #[arg(long, value_name = "N", requires = "picture")]
    pub(crate) track: Option<u32>,
    /// Print the summary as a JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

/// Inputs and settings of the offline engines of fusion.
#[derive(Debug, Args)]
pub(crate) struct OfflineInput {
    /// Sensor tracks: CSV files, each in the order of time, or with times of arrival
    #[arg(long, value_name = "FILE", required = true, num_args = 1..)]
    pub(crate) tracks: Vec<PathBuf>,
    /// Description of the sensors, and settings of fusion: a TOML file
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// Origin of the plane for tables in degrees [default: that of a deployment in --config, else the first position]
    #[arg(long, value_name = "LAT,LON[,HEIGHT]", value_parser = place, allow_hyphen_values = true)]
    pub(crate) origin: Option<Geodetic>,
    /// Standard deviation of positions in tables of named columns without sigma_m, metres [default: 30 or 100]
    #[arg(long, value_name = "METRES", value_parser = above_zero)]
    pub(crate) sigma: Option<f64>,
    /// Whether an origin has no use without positions in degrees.
    #[arg(skip = true)]
    pub(crate) needs_degrees: bool,
}

const TRACK_EXAMPLES: &str = "\
Examples:
  koseki track --detections radar.csv --out tracks.csv
  koseki track --detections radar.csv lidar.csv camera.csv \\
      --config sensors.toml --out tracks.csv
  koseki track --detections radar.csv --out tracks.csv --explain why.csv --json
  koseki track --detections radar.csv --wide-area counts.csv --out tracks.csv
  koseki track --detections radar.csv --wide-area counts.csv \\
      --emissions heard.csv --config types.toml --out tracks.csv
  koseki track --detections radar.csv --period 1 --cues looks.csv \\
      --out tracks.csv
  koseki track --detections radar.csv --platform ship.csv \\
      --config mounting.toml --out tracks.csv

FILE     time_s,sensor_id,scan,detection_id,kind,m0,m1,m2,m3,s0,s1,s2,s3,px,py,
         pz
         a row per detection, in any order. kind: position2 (x, y), position3,
         range_bearing (m, rad clockwise from north), range_bearing_elevation,
         bearing, bearing_elevation; m: values in that order, m3 the range rate,
         if any; s: the standard deviations of m; p: position of the sensor;
         metres, radians, m/s; values not measured by a kind are empty.
         Optional: address (hexadecimal), mode_3a (octal), callsign, mmsi, name,
         level (flight level) of the transponder's reply, and address_age_s,
         mode_3a_age_s, callsign_age_s, level_age_s; all may be empty. With a
         reply in any row, --out has mmsi, level, the ages of the track's values
         and name at the end. Optional columns of a moving platform:
         docs/platform.md.
         Detections with the same sensor_id and scan belong to the same scan: an
         antenna turn or an image. A missing scan number is a scan without
         detections. A row of the kind none, with its other values empty, is a
         scan without detections at its time, also before the first detection
         and after the last one. Several files are merged by time. Unusable rows
         are omitted and counted. A recording of the Autoferry data set
         (scenarioN_detections.json) can be read directly: sensors 1 lidar, 2
         radar (position2), 3 infrared camera, 4 camera (bearing); its standard
         deviations must be in --config. A recording of a deployment with a
         [[tracker]] (MCAP) gives the tracks of this tracker again, with its
         recorded settings.
FILE     or a table without kind and m0 to m3, with columns of the following
         names, in any case and order, and the names of `koseki fuse --help`:
         time, latitude and longitude (or x and y), altitude_m or flight_level,
         sigma_m and identities of a target; or time, bearing_deg, range_m and
         elevation_deg of what was measured, and latitude and longitude (or px,
         py, pz) of the sensor. Without source, each file is a sensor. Rows of
         one time are a scan: name a column scan where an antenna turns. An
         empty value, nan, null or None is unknown. --out has latitude and
         longitude at the end.
{NAMED}
--platform     time_s[,px,py,pz,vx,vy,vz,heading_rad,pitch_rad,roll_rad,
         position_sigma_m,velocity_sigma_mps,
         heading_sigma_rad,pitch_sigma_rad,roll_sigma_rad]
         a row per state, or part of a state, of the platform that carries the
         sensors (docs/platform.md). Detections are then as the sensors measured
         them: bearings from the nose, p unused. [platform] and
         [[platform.sensor]] of --config give the mounting. Detections without a
         state near their time are refused and counted.
--wide-area    time_s,arrival_s,x,y,z,vx,vy,vz,count[,route]
         a row per report of the number of targets around a place
         (docs/wide-area.md); arrival_s counts like time_s; route: east and
         north of earlier places, oldest first, joined with |.
--emissions    time_s,emitter_id,bearing_rad,sigma_rad,px,py,pz,frequency_hz[,
         pulse_interval_s]
         a row per received emission, as for `koseki locate`; with the types and
         priors of --config, emissions identify the tracks.
--out    time_s,sensor_id,sensor_track_id,x,y,z,vx,vy,vz,P00,…,P55,state,…,kind,
         members,type,type_confidence,hypotheses,reliability
         a row for each confirmed track after each scan, or with --period at its
         whole multiples; state is confirmed, or coasted after a scan without a
         detection of the target; sensor_id is 0, the tracker; kind is group for
         unresolved targets, with their expected number; type is the target's
         type, if known.
--cues   {CUE}
         after each scan, an ellipse per sensor and confirmed track for the
         sensor's next look; its longer axis is clockwise from north.
--explain the results for each scan, cluster, hypothesis and track, with
          reasons; docs/tracking.md describes the columns
--config a deployment as for `koseki up` (sensor_id 1 is its first source; the
         source's [source.tracker] applies), or the following keys. All keys are
         optional; keys of a sensor state facts, the other keys apply to all
         sensors:
{KEYS}
         Advice on settings: docs/tracking.md; [wide_area] and [selection]:
         docs/wide-area.md; permitted values: docs/configuration.md.

The same files and options give the same bytes.";

/// Returns the help of `koseki track`, with the keys of its configuration.
fn track_examples() -> String {
    let text = TRACK_EXAMPLES.replace("{KEYS}", configuration::tracking_help().trim_end());
    text.replace("{NAMED}", &names_of(SENSOR_COLUMNS))
        .replace("{CUE}", &in_lines(&CueRow::columns()))
}

/// `koseki track`.
#[derive(Debug, Args)]
pub struct TrackArgs {
    /// Detections: CSV files, recordings of the Autoferry data set, or a deployment's recordings of all topics (MCAP)
    #[arg(long, value_name = "FILE", required = true, num_args = 1..)]
    pub(crate) detections: Vec<PathBuf>,
    /// Origin of the plane for tables in degrees, and for latitude and longitude in --out [default: that of a
    /// deployment in --config, else the first place]
    #[arg(long, value_name = "LAT,LON[,HEIGHT]", value_parser = place, allow_hyphen_values = true)]
    pub(crate) origin: Option<Geodetic>,
    /// States of the platform that carries the sensors: a CSV file
    #[arg(long, value_name = "FILE")]
    pub(crate) platform: Option<PathBuf>,
    /// Counts of a wide-area sensor, which reports late: a CSV file
    #[arg(long, value_name = "FILE")]
    pub(crate) wide_area: Option<PathBuf>,
    /// Emissions received by an on-board receiver, to identify types of targets: a CSV file of bearings
    #[arg(long, value_name = "FILE")]
    pub(crate) emissions: Option<PathBuf>,
    /// Description of the sensors, and settings of the tracker: a TOML file
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// Tracker process whose detections are taken from a recording, if the recording has several
    #[arg(long, value_name = "NAME")]
    pub(crate) tracker: Option<String>,
    /// File for the tracks; - for standard output
    #[arg(long, value_name = "FILE")]
    pub(crate) out: PathBuf,
    /// Write the tracks at whole multiples of this period, instead of after each scan, seconds
    #[arg(long, value_name = "SECONDS", value_parser = refresh)]
    pub(crate) period: Option<Duration>,
    /// File for decisions with their reasons
    #[arg(long, value_name = "FILE")]
    pub(crate) explain: Option<PathBuf>,
    /// File for cues: places for each sensor's next look
    #[arg(long, value_name = "FILE")]
    pub(crate) cues: Option<PathBuf>,
    /// Print the summary as a JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

const LOCATE_EXAMPLES: &str = "\
Examples:
  koseki locate --bearings flight.csv --out fixes.csv
  koseki locate --bearings flight.csv --filter fixed --select staged \\
      --out fixes.csv --explain why.csv
  koseki locate --bearings flight.csv --out fixes.csv --picture emitter7.svg \\
      --emitter 7
  koseki locate --bearings arrivals.csv --out fixes.csv
      rows of kind toa or tdoa
  koseki locate --fixes radar.csv --select interval --out smooth.csv
      fixes as they are, selected
  koseki locate --bearings flight.csv --fixes radar.csv --out fixes.csv
      both in one filter
  koseki locate --bearings bearings_a.csv --bearings arrivals_a.csv --out f.csv
      as a deployment has recorded them
  koseki locate finders.pcap --bearing-sigma-deg 1.5 --out fixes.csv
      a recording of direction finders (ASTERIX, category 205)

FILE     as --bearings, before the files there
--bearings time_s,emitter_id,bearing_rad,sigma_rad,px,py,pz[,heading_rad,
         frequency_hz]
         a row per bearing, in the order of time. Radians clockwise from north,
         metres east, north and up; p is the position of the platform. A file
         may contain any number of emitters. If emitter_id is empty, frequency
         and direction identify the emitter, numbered from 1000001 on. Unusable
         rows are omitted and counted. In place of px,py,pz: latitude and
         longitude; bearings are then from true north there, and --out has
         latitude and longitude at the end. Columns may have any of the
         following names, in any case and order, and the names of `koseki fuse
         --help` for time and place; times as there:
{NAMED}
         With a column kind, a file mixes kinds of rows; values that a kind does
         not use may be empty:
         bearing   as above; also if kind is empty
         toa       receiver,t_s,sigma_s,px,py,pz: seconds since midnight at
                   which a transmission arrived at a receiver, by its clock, the
                   standard deviation in seconds, and the receiver's position.
                   Rows of one emitter_id with the same time_s (to a
                   millisecond) are one transmission, of 2 to 8 receivers.
         tdoa      receiver,receiver_2,tdoa_s,sigma_s,px,py,pz,px_2,py_2,pz_2:
                   arrival at receiver minus arrival at receiver_2. Rows count
                   as independent; of more than two receivers, toa rows locate
                   better.
         Both need emitter_id. receiver is a name of 1 to 16 characters. With
         reference_x,reference_y,reference_z the place of the emitter is known;
         such rows show how far the receivers' clocks are ahead and drift, and
         are not located. In a file with such a row, arrivals before the clocks
         are known are omitted; in others, clocks are exact.
         A recording of ASTERIX, in any container of `koseki decode`, has the
         reports of direction finders (category 205) in place of rows, as for a
         recorded source with [source.locator]: bearings from true north at the
         place in the report or at --place, and positions where no bearing has
         come for 10 s. Without SAC and SIC, the reports of all senders locate
         the same emitters.
--date   of the first report of such recordings (UTC); otherwise that of the
         container, and without any, times count from midnight, as in tables
         without dates. 1970-01-01 always counts from midnight.
--fixes  time_s,emitter_id,x,y,z and Pxx,Pxy,Pyy (m²), or variance_m2, the sum
         of both, or sigma_m along each axis; in place of x,y,z: latitude,
         longitude and altitude_m
         a row per fix, in the order of time
--filter
         auto      by the data: fixed point, straight motion or manoeuvring, the
                   simplest model that explains the bearings
         fixed     a fixed or wandering point
         straight  straight motion, or manoeuvring
         none      fixes of --fixes as they are; the default without --bearings.
                   Other rows as with auto.
--select
         auto      every fix steers the output, which never jumps: the best
                   choice for unknown data
         none      fixes without selection
         interval  a fix per interval sets the direction of the output, which
                   moves in straight lines
         minimum   … a fix at each minimum of the variance
         staged    intervals at first, later minima if they are frequent enough
--dropped 7:36000:100,-200:50
         emitter 7 was dropped at this time of the day (seconds, UTC), at this
         place (metres east and north, with its standard deviation): the first
         fix comes with the first bearing
--out    {FIX}
         a row per bearing, transmission or fix as soon as the geometry allows a
         fix: the output; the trace of the filter's covariance; the filter's own
         fix (raw) with its covariance; the most likely model; 0 in agreed while
         its bearings are not used.
--explain {DECISION}
         value was compared with limit
--config a TOML file; every key has a default:
{KEYS}
The same file and options give the same bytes. `koseki score fixes` scores the
output against a truth.";

/// Returns the help of `koseki locate`, with the keys of its configuration.
fn locate_examples() -> String {
    let text = LOCATE_EXAMPLES.replace("{KEYS}", &configuration::locating_help());
    text.replace("{NAMED}", &names_of(SENSOR_COLUMNS))
        .replace("{FIX}", &in_lines(FIX_COLUMNS))
        .replace("{DECISION}", &in_lines(DECISION_COLUMNS))
}

/// `koseki locate`.
#[derive(Debug, Args)]
pub struct Locate {
    /// Files as for --bearings
    #[arg(value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
    /// Bearings and arrival times in the order of time: a CSV file, or a recording of direction finders (repeatable)
    #[arg(long, value_name = "FILE", required_unless_present_any = ["fixes", "files"])]
    pub(crate) bearings: Vec<PathBuf>,
    /// Ready-made fixes of emitters: a CSV file in the order of time
    #[arg(long, value_name = "FILE")]
    pub(crate) fixes: Option<PathBuf>,
    /// States of the platform: a CSV file as for `koseki track`; bearings are then from its nose
    #[arg(long, value_name = "FILE")]
    pub(crate) platform: Option<PathBuf>,
    /// Motion of emitters: auto, fixed, straight or none [default: as in --config, else auto; for fixes alone none]
    #[arg(long, value_name = "FILTER")]
    pub(crate) filter: Option<String>,
    /// Selection of fixes: auto, none, interval, minimum or staged [default: the value in --config, else auto]
    #[arg(long, value_name = "SELECTION")]
    pub(crate) select: Option<String>,
    /// Origin of the plane for tables in degrees, and for latitude and longitude in --out [default: the first place]
    #[arg(long, value_name = "LAT,LON[,HEIGHT]", value_parser = place, allow_hyphen_values = true)]
    pub(crate) origin: Option<Geodetic>,
    /// Standard deviation of bearings of recordings, degrees [default: bearing_sigma_deg in --config, else 2]
    #[arg(long, value_name = "DEGREES", value_parser = above_zero)]
    pub(crate) bearing_sigma_deg: Option<f64>,
    /// Day of the first report of recordings, year-month-day (UTC) [default: as the container states, if it does]
    #[arg(long, value_name = "DATE", value_parser = configuration::day_ns)]
    pub(crate) date: Option<i64>,
    /// Place of the finder of recordings, or reference point of its system, where reports need it
    #[arg(long, value_name = "LAT,LON[,HEIGHT]", value_parser = place, allow_hyphen_values = true)]
    pub(crate) place: Option<Geodetic>,
    /// System area code of the only sender of recordings whose reports are used
    #[arg(long, value_name = "SAC", requires = "sic")]
    pub(crate) sac: Option<u8>,
    /// System identification code of this sender
    #[arg(long, value_name = "SIC", requires = "sac")]
    pub(crate) sic: Option<u8>,
    /// Emitter that the platform dropped, with time and place (repeatable)
    #[arg(long, value_name = "ID:TIME_S:EAST,NORTH[:SIGMA_M]", value_parser = dropped)]
    pub(crate) dropped: Vec<DroppedEmitter>,
    /// Settings of filters and selection: a TOML file
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// File for the fixes; - for standard output
    #[arg(long, value_name = "FILE")]
    pub(crate) out: PathBuf,
    /// File for decisions with their reasons, a row per decision
    #[arg(long, value_name = "FILE")]
    pub(crate) explain: Option<PathBuf>,
    /// File for a plot (SVG) of an emitter's fixes and output
    #[arg(long, value_name = "FILE")]
    pub(crate) picture: Option<PathBuf>,
    /// The emitter in the plot [default: the first]
    #[arg(long, value_name = "N", requires = "picture")]
    pub(crate) emitter: Option<u32>,
    /// Print the summary as a JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

/// Reads a dropped emitter.
fn dropped(text: &str) -> Result<DroppedEmitter, String> {
    let parts: Vec<&str> = text.split(':').collect();
    let form = "it must be ID:TIME_S:EAST,NORTH or ID:TIME_S:EAST,NORTH:SIGMA_M, as in 7:36000:0,0:50";
    let number = |text: &str| text.parse::<f64>().map_err(|_| format!("{text} is no number; {form}"));
    let (id, time_s, place, sigma_m) = match parts[..] {
        [id, time_s, place] => (id, time_s, place, None),
        [id, time_s, place, sigma_m] => (id, time_s, place, Some(number(sigma_m)?)),
        _ => return Err(form.to_owned()),
    };
    let (east, north) = place.split_once(',').ok_or(form)?;
    let dropped = DroppedEmitter {
        emitter_id: id
            .parse()
            .map_err(|_| format!("{id} is no number of an emitter; {form}"))?,
        time_s: number(time_s)?,
        position_m: [number(east)?, number(north)?],
        ..DroppedEmitter::default()
    };
    let dropped = DroppedEmitter {
        sigma_m: sigma_m.unwrap_or(dropped.sigma_m),
        ..dropped
    };
    settings::check(&dropped).map_err(|error| error.to_string())?;
    Ok(dropped)
}

const COMPARE_EXAMPLES: &str = "\
Examples:
  koseki compare --tracks radar.csv adsb.csv --truth truth.csv
  koseki compare --tracks all.csv --truth truth.csv --c 100 --gate 50 --markdown
  koseki compare --tracks all.csv --config sensors.toml --json

Inputs as for `koseki fuse`, figures as from `koseki score` (see the --help of
both); without --truth only figures that need no truth. us_per_report is the
time of the engine alone. Every rule has a separate engine. There are no output
files.";

/// `koseki compare`.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct Compare {
    /// Existing pictures.
    #[command(subcommand)]
    pub(crate) what: Option<CompareWhat>,
    #[command(flatten)]
    pub(crate) input: OfflineInput,
    /// Positions of the targets: a CSV file as for `koseki score`
    #[arg(long, value_name = "FILE")]
    pub(crate) truth: Option<PathBuf>,
    /// Interval of the comparison, at whole multiples, seconds
    #[arg(long, value_name = "SECONDS", default_value = "1", value_parser = refresh)]
    pub(crate) refresh: Duration,
    /// Cut-off of GOSPA and OSPA: largest distance between a track and its target, metres
    #[arg(long, value_name = "METRES", default_value_t = 500.0, value_parser = above_zero)]
    pub(crate) c: f64,
    /// Largest distance at which a target keeps its track, metres
    #[arg(long, value_name = "METRES", default_value_t = 250.0, value_parser = above_zero)]
    pub(crate) gate: f64,
    /// First whole second to score [default: 10 s after the begin of the truth, or its begin if it is no longer]
    #[arg(long, value_name = "SECOND", value_parser = whole_second, allow_negative_numbers = true)]
    pub(crate) t0: Option<i64>,
    /// Print a JSON object
    #[arg(long)]
    pub(crate) json: bool,
    /// Print the table as Markdown
    #[arg(long, conflicts_with = "json")]
    pub(crate) markdown: bool,
}

/// Further things to compare.
#[derive(Debug, Subcommand)]
pub(crate) enum CompareWhat {
    /// Compare two track pictures of the same time, for example as recorded and fused again with other settings
    #[command(after_help = COMPARE_PICTURES_EXAMPLES)]
    Pictures(ComparePictures),
}

const COMPARE_PICTURES_EXAMPLES: &str = "\
Examples:
  koseki replay records/tower/latest --config other.toml --out other.csv
  koseki compare pictures records/tower/latest other.csv
  koseki compare pictures before.csv after.csv --max-age 5 --json

The first picture serves as the truth: its confirmed and coasted tracks are the
targets for the comparison at each whole second, with the figures of `koseki
score`. A missed target is a track only in the first picture, a false target a
track only in the second picture. Columns are found by name:
time_s,system_track_id,x,y,z,vx,vy,vz,state.";

/// `koseki compare pictures`.
#[derive(Debug, Args)]
pub(crate) struct ComparePictures {
    /// System tracks of the first picture: a CSV file, or the folder of a recording
    pub(crate) first: PathBuf,
    /// System tracks of the second picture
    pub(crate) second: PathBuf,
    /// Cut-off of GOSPA and OSPA: largest distance between two tracks of the same target, metres
    #[arg(long, value_name = "METRES", default_value_t = 500.0, value_parser = above_zero)]
    pub(crate) c: f64,
    /// Largest distance at which a target keeps its track, metres
    #[arg(long, value_name = "METRES", default_value_t = 250.0, value_parser = above_zero)]
    pub(crate) gate: f64,
    /// Largest age of a state, seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 5.0, value_parser = above_zero)]
    pub(crate) max_age: f64,
    /// First whole second to compare [default: the first second of either picture]
    #[arg(long, value_name = "SECOND", value_parser = whole_second, allow_negative_numbers = true)]
    pub(crate) t0: Option<i64>,
    /// Print a JSON object
    #[arg(long)]
    pub(crate) json: bool,
}
