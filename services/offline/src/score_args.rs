//! Arguments of `koseki score`, and their help.

use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser as _};
use clap::{Args, Subcommand};
use command_line::values::{above_zero, finite, not_negative};
use frames::Geodetic;
use scoring::{CardReference, SURVEILLANCE_STANDARDS};

use crate::values::whole_second;

pub(crate) const SCORE_EXAMPLES: &str = "\
Examples:
  koseki score --truth truth.csv --tracks fused.csv
  koseki score --truth truth.csv --tracks fused.csv --c 100 --gate 50 --json
  koseki score --truth truth.csv --tracks fused.csv --standard ed-142,esassp \\
      --html card.html
  koseki score --truth smoothed.csv --tracks fused.csv --reference smoothed \\
      --standard ed-87 --areas airport.geojson --origin 41.297063,2.078447
  koseki score tracks --truth run1/truth.csv run2/truth.csv \\
      --tracks run1/tracks.csv run2/tracks.csv --since 40
  koseki score fixes --truth case/truth.csv --fixes case/fixes.csv
  koseki score alerts --truth truth.csv --tracks fused.csv --alerts alerts.csv

At each whole second for which the truth has a row, the newest state of each
track is extrapolated to this second and compared with the targets. Heights and
velocities count where both sides know them (height_valid, velocity_valid). The
first lines state what was compared. GOSPA, its parts and OSPA measure the
distance between the picture and the truth. A target keeps its track from second
to second while the track is nearer than the gate; switches, breaks,
completeness and spurious tracks follow from these pairs.

A scorecard follows: errors by phase of movement (straight, entry, turn, exit,
after; level, climb; changes of the climb rate). Position errors have RMS, 50,
90, 95 and 99 %, the others RMS and 95 %; --json and --html have everything.
nees is 1 for an honest covariance; under \"likeliest\" it is that of the velocity
by the likeliest case, which is usually straight flight. A target counts from --settle seconds after
its first row on. --standard adds the lines of a standard: figure, limit and
verdict. Against a truth a line passes or fails; against an independent
instrument, too, and the figures contain the errors of the instrument; against
trajectories smoothed from the same data every line with a limit is \"precision
only\". Without a source for its limit a line has \"no limit known\". --areas adds
a card for each area.

truth:   time_s,target_id (or system_track_id),x,y,z,vx,vy,vz[,address]
         a row per target and whole second
tracks:  time_s,system_track_id (or sensor_track_id),x,y,z,vx,vy,vz
         [,state,address,P00 ... P55,height_valid]
         rows with state tentative or terminated are ignored
         time_s of either file may count from a midnight or from 1970 (UTC). In
         place of x,y,z: latitude,longitude in degrees and height_m above the
         ellipsoid; vx,vy,vz are optional there, or speed and course. The frame
         of x,y,z has its origin at --origin, or the tracks state both (recorded
         tables do). Columns may have the names and units, and times the forms,
         of `koseki fuse --help`; without a number, address or mmsi identifies
         the target
areas:   airspaces (OpenAir), or GeoJSON: polygons with a name and a kind:
         manoeuvring, runway, taxiway, apron, stand, approach, outer-approach,
         terminal or en-route
Columns are found by name, other columns are ignored. A figure that cannot be
computed is null in JSON.";

/// `koseki score`.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct Score {
    /// Other kinds of files.
    #[command(subcommand)]
    pub(crate) what: Option<ScoreWhat>,
    /// Positions of the targets: a CSV file
    #[arg(long, value_name = "FILE", required = true)]
    pub(crate) truth: Option<PathBuf>,
    /// The tracks to score: a CSV file
    #[arg(long, value_name = "FILE", required = true)]
    pub(crate) tracks: Option<PathBuf>,
    /// Cut-off of GOSPA and OSPA: largest distance between a track and its target, metres
    #[arg(long, value_name = "METRES", default_value_t = 500.0, value_parser = above_zero)]
    pub(crate) c: f64,
    /// Largest distance at which a target keeps its track, metres
    #[arg(long, value_name = "METRES", default_value_t = 250.0, value_parser = above_zero)]
    pub(crate) gate: f64,
    /// Largest age of a state, seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 1.0, value_parser = above_zero)]
    pub(crate) max_age: f64,
    /// First whole second to score [default: 10 s after the begin of the truth, or its begin if it is no longer]
    #[arg(long, value_name = "SECOND", value_parser = whole_second, allow_negative_numbers = true)]
    pub(crate) t0: Option<i64>,
    /// Last whole second to score [default: the last second of the truth]
    #[arg(long, value_name = "SECOND", value_parser = whole_second, allow_negative_numbers = true)]
    pub(crate) t1: Option<i64>,
    /// Least speed of a target for the comparison of directions, m/s
    #[arg(long, value_name = "SPEED", default_value_t = 5.0, value_parser = not_negative)]
    pub(crate) moving: f64,
    #[command(flatten)]
    pub(crate) card: CardArgs,
    /// Print a JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

/// Arguments of the scorecard.
#[derive(Debug, Args)]
#[command(next_help_heading = "Scorecard")]
pub(crate) struct CardArgs {
    /// Standards whose lines are added, separated by commas
    #[arg(long, value_name = "STANDARD", value_delimiter = ',', value_parser = standards())]
    pub(crate) standard: Vec<String>,
    /// Origin of --truth
    #[arg(long, value_name = "REFERENCE", default_value = "truth", value_parser = references())]
    pub(crate) reference: CardReference,
    /// Areas with a card of their own: a GeoJSON file
    #[arg(long, value_name = "FILE", requires = "origin")]
    pub(crate) areas: Option<PathBuf>,
    /// Origin of the frame of x,y,z, for --areas and for places in degrees: latitude and longitude, degrees
    #[arg(long, value_name = "LATITUDE,LONGITUDE", value_parser = origin, allow_hyphen_values = true)]
    pub(crate) origin: Option<Geodetic>,
    /// File for the scorecard with pictures (HTML)
    #[arg(long, value_name = "FILE")]
    pub(crate) html: Option<PathBuf>,
    /// Time from the first row of a target until it counts, seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 25.0, value_parser = not_negative)]
    pub(crate) settle: f64,
    /// Acceleration in the plane above which a target turns or changes its speed, m/s2
    #[arg(long, value_name = "LIMIT", default_value_t = 0.5, value_parser = above_zero)]
    pub(crate) turning: f64,
    /// Vertical acceleration above which a target changes its climb rate, m/s2
    #[arg(long, value_name = "LIMIT", default_value_t = 0.3, value_parser = above_zero)]
    pub(crate) climbing: f64,
}

fn standards() -> PossibleValuesParser {
    PossibleValuesParser::new(SURVEILLANCE_STANDARDS.iter().map(|standard| standard.word))
}

fn references() -> impl clap::builder::TypedValueParser<Value = CardReference> {
    let reference = |word: String| CardReference::ALL.into_iter().find(|known| known.word() == word);
    PossibleValuesParser::new(CardReference::ALL.map(CardReference::word))
        .map(move |word| reference(word).unwrap_or_default())
}

/// Reads a place at height 0.
fn origin(text: &str) -> Result<Geodetic, String> {
    let number = |text: &str| text.trim().parse::<f64>().ok();
    let place = text
        .split_once(',')
        .and_then(|(latitude, longitude)| number(latitude).zip(number(longitude)));
    let Some((latitude_deg, longitude_deg)) = place else {
        return Err("it must be latitude and longitude in degrees, like 41.297063,2.078447".to_owned());
    };
    Geodetic::from_degrees(latitude_deg, longitude_deg, 0.0).map_err(|error| error.to_string())
}

/// Other kinds of files for `koseki score`.
#[derive(Debug, Subcommand)]
pub(crate) enum ScoreWhat {
    /// Score a tracker's separation of close targets, over one or more runs
    #[command(after_help = SCORE_TRACKS_EXAMPLES)]
    Tracks(ScoreTracks),
    /// Score the fixes of a bearings-only locator in a scripted case, over one or more sets of runs
    #[command(after_help = SCORE_FIXES_EXAMPLES)]
    Fixes(ScoreFixes),
    /// Score alerts on tracks by what the targets of the truth do afterwards
    #[command(
        after_help = SCORE_ALERTS_EXAMPLES,
        override_usage = "koseki score alerts [OPTIONS] --truth <FILE> --tracks <FILE>\n         \
                          --alerts <FILE>"
    )]
    Alerts(ScoreAlerts),
}

const SCORE_TRACKS_EXAMPLES: &str = "\
Examples:
  koseki score tracks --truth truth_0.csv --tracks tracks_0.csv --since 60
  koseki score tracks --truth truth_*.csv --tracks tracks_*.csv --json

At each time of the truth from --since on, exactly as many confirmed tracks
should be near targets as there are targets, each track near another target.
Before --since the targets are not separable, and several tracks are too many.
Positions are compared in the plane; a track counts for 4 s after its newest
row, extrapolated with its velocity.

truth:   time_s,x,y
         a row per target and time
tracks:  time_s,sensor_track_id,x,y,vx,vy,state
         rows with state confirmed or coasted count
Several runs: as many --tracks as --truth, in the same order. Shares and delay_s
are then means over runs, tracks are summed, and JSON has the figures of each
run under \"each\".";

/// `koseki score tracks`.
#[derive(Debug, Args)]
pub(crate) struct ScoreTracks {
    /// Positions of the targets: a CSV file per run
    #[arg(long, value_name = "FILE", required = true, num_args = 1..)]
    pub(crate) truth: Vec<PathBuf>,
    /// The tracks of each run, in the same order
    #[arg(long, value_name = "FILE", required = true, num_args = 1..)]
    pub(crate) tracks: Vec<PathBuf>,
    /// Largest distance of a track near a target, metres
    #[arg(long, value_name = "METRES", default_value_t = 300.0, value_parser = above_zero)]
    pub(crate) gate: f64,
    /// Time from which the targets are separable, seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0, value_parser = finite, allow_negative_numbers = true)]
    pub(crate) since: f64,
    /// Print a JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

const SCORE_FIXES_EXAMPLES: &str = "\
Examples:
  koseki score fixes --truth fixed/truth.csv --fixes fixed/fixes.csv
  koseki score fixes --truth seed1/truth.csv seed2/truth.csv \\
      --fixes seed1/fixes.csv seed2/fixes.csv --json

Cases: fixed
an emitter 50 km broadside of a straight baseline; the last raw fixes beside
their Cramer-Rao bound
       drop    a dropped transmitter drifts in a straight line while the
               aircraft circles; the second half counts
       turn    the aircraft turns by 180 degrees with wrong bearings; the time
               from 500 s on counts
The file meta.json beside each truth names the case, with the baseline (m),
sigma_deg and number of runs.

truth:   time_s,emitter_id,x,y
         a row per emitter and bearing
fixes:   time_s,emitter_id,x,y,vx,vy,raw_x,raw_y
         rows with a time missing in the truth are ignored
Several sets of runs of a case are pooled: as many --fixes as --truth, in the
same order.";

/// `koseki score fixes`.
#[derive(Debug, Args)]
pub(crate) struct ScoreFixes {
    /// Positions of the emitters: a CSV file with meta.json in the same folder, for each set of runs
    #[arg(long, value_name = "FILE", required = true, num_args = 1..)]
    pub(crate) truth: Vec<PathBuf>,
    /// The fixes of each set of runs, in the same order
    #[arg(long, value_name = "FILE", required = true, num_args = 1..)]
    pub(crate) fixes: Vec<PathBuf>,
    /// Print a JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

const SCORE_ALERTS_EXAMPLES: &str = "\
Examples:
  koseki score alerts --truth truth.csv --tracks fused.csv --alerts alerts.csv
  koseki score alerts --truth truth.csv --tracks fused.csv --alerts alerts.csv \\
      --areas zones.geojson --origin 41.2971,2.0785 --json

The truth decides: pairs of aircraft nearer than both minima (conflict), pairs of
ships nearer than theirs (approach), targets inside areas (enter). An alert is
right if this happens to its targets from its raising until its clearing plus the
look-ahead, else it is a nuisance; it is undecided if the truth ends before. A
violation with a right alert is a hit. The lead is the time from the first right
alert to the violation. A hit is in time with a lead of a minute, or if the alert
came within 5 s of the first state of both tracks. Further alerts of a violation
are duplicates. Violations of the same targets less than 30 s apart are one.
Alerts of other kinds are counted.

A target that stays below 100 m and 35 m/s is a ship. Aircraft on the ground, and
two ships that lie still (1 kn), violate no minimum.

truth:   as for `koseki score`
tracks:  as for `koseki score`: the tracks that the alerts name
alerts:  time_s,event,alert,kind,system_track_id[,other_system_track_id,area,
         probability,horizon_s]: as `koseki fuse --alerts` and recorders write them
         time_s counts as the times of the tracks do; rows in the order of time
         event: raised, cleared or predicted
         alert: number, which may come again after its clearing
         kind: enter, leave, stay, conflict, approach, low, speed, level, lost or
         emergency
         system_track_id,other_system_track_id: the tracks; empty for none
         area: name of the entered area; empty for any
         A row predicted has the probability (0 to 1) of a violation within
         horizon_s seconds [default: the look-ahead]; the predictions of each
         kind are compared with frequencies in ten bins.
areas:   airspaces (OpenAir), or GeoJSON; with floors and ceilings
Heights count above the ellipsoid if --origin is given or the tracks state places
in degrees, too; else above the plane of the frame, which is wrong far out.
Columns are found by name, other columns are ignored. A figure that cannot be
computed is null in JSON, which has the misses and the nuisances one by one.";

/// `koseki score alerts`.
#[derive(Debug, Args)]
pub(crate) struct ScoreAlerts {
    /// Positions of the targets: a CSV file
    #[arg(long, value_name = "FILE")]
    pub(crate) truth: PathBuf,
    /// The tracks that have the alerts: a CSV file
    #[arg(long, value_name = "FILE")]
    pub(crate) tracks: PathBuf,
    /// The alerts to score: a CSV file
    #[arg(long, value_name = "FILE")]
    pub(crate) alerts: PathBuf,
    /// Areas for alerts of the kind enter: airspaces (OpenAir) or GeoJSON
    #[arg(long, value_name = "FILE", requires = "origin")]
    pub(crate) areas: Option<PathBuf>,
    /// Origin of the frame of x,y,z: latitude and longitude, degrees
    #[arg(long, value_name = "LATITUDE,LONGITUDE", value_parser = origin, allow_hyphen_values = true)]
    pub(crate) origin: Option<Geodetic>,
    /// Time after the clearing of an alert in which a violation makes it right, seconds [default: conflict 120,
    /// approach 900, enter 0]
    #[arg(long, value_name = "SECONDS", value_parser = not_negative)]
    pub(crate) look_ahead: Option<f64>,
    /// Horizontal minimum of two aircraft, nautical miles
    #[arg(long, value_name = "NM", default_value_t = 5.0, value_parser = above_zero)]
    pub(crate) minimum_nm: f64,
    /// Vertical minimum of two aircraft, feet
    #[arg(long, value_name = "FEET", default_value_t = 1000.0, value_parser = above_zero)]
    pub(crate) minimum_ft: f64,
    /// The same if one of both is above flight level 410, feet
    #[arg(long, value_name = "FEET", default_value_t = 2000.0, value_parser = above_zero)]
    pub(crate) minimum_high_ft: f64,
    /// Minimum of two ships, nautical miles
    #[arg(long, value_name = "NM", default_value_t = 0.5, value_parser = above_zero)]
    pub(crate) minimum_ships_nm: f64,
    /// Largest distance at which a track follows a target, metres
    #[arg(long, value_name = "METRES", default_value_t = 1000.0, value_parser = above_zero)]
    pub(crate) gate: f64,
    /// Largest age of a state of a track, seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0, value_parser = above_zero)]
    pub(crate) max_age: f64,
    /// Origin of --truth
    #[arg(long, value_name = "REFERENCE", default_value = "truth", value_parser = references())]
    pub(crate) reference: CardReference,
    /// Print a JSON object
    #[arg(long)]
    pub(crate) json: bool,
}
