//! Options of `koseki open` and `koseki new`.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum};
use offline::values::seconds;

pub(crate) const OPEN_EXAMPLES: &str = "\
Examples:
  koseki open flight.beast --date 2024-06-06     Mode S frames of a receiver
  koseki open tcp://192.168.1.7:30005            the same, live
  koseki open udp://0.0.0.0:10110                AIS, live
  koseki open http://192.168.1.7/data/aircraft.json
  koseki open radar.pcap ads-b.ast --place 41.297,2.078
  koseki open ships.csv --no-display             a table with latitude, longitude

A file's kind, container and edition are found in its bytes, a feed's in the
first seconds. Each decision is printed with its reason; what the data cannot
tell is asked for: --place, --date. The configuration is kept in the folder of
the run: edit it, and start it again by `koseki up`.

Files: ASTERIX (data blocks, pcap, pcapng, final, .gps, hexadecimal lines), Mode
S (Beast, AVR, hexadecimal lines), SBS-1, JSON of readsb, AIS, targets of ships'
radars (TTM, TLL), Remote ID, Cursor on Target, tables of tracks, recordings of
all topics (MCAP).";

/// `koseki open`.
#[derive(Debug, Args)]
pub(crate) struct OpenArgs {
    /// Files, or feeds: tcp://HOST:PORT, udp://ADDRESS:PORT, http://HOST/PATH
    #[arg(value_name = "WHAT", required = true)]
    pub(crate) what: Vec<String>,
    /// Latitude and longitude of the sensors, degrees, for data that are relative to them; also the origin of the
    /// system frame [default: the first position in the data]
    #[arg(long, value_name = "LAT,LON", allow_hyphen_values = true)]
    pub(crate) place: Option<String>,
    /// First day of recordings that state times of day only [default: what the data state]
    #[arg(long, value_name = "YYYY-MM-DD")]
    pub(crate) date: Option<String>,
    /// Print the report only, without the picture
    #[arg(long)]
    pub(crate) no_display: bool,
    /// Write the configuration, and start nothing
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// Stop after this time, seconds [default: at Ctrl-C]
    #[arg(long = "for", value_name = "SECONDS", value_parser = seconds)]
    pub(crate) seconds: Option<Duration>,
    /// Parent folder of the run's records [default: records]
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
}

pub(crate) const NEW_EXAMPLES: &str = "\
Examples:
  koseki new air                     prints a configuration of 25 lines
  koseki new sea --out harbour.toml  writes it: put your places and addresses into
                                     it, then koseki check harbour.toml

docs/configuration.md lists every key; config/ has larger examples.";

/// `koseki new`.
#[derive(Debug, Args)]
pub(crate) struct NewConfig {
    /// Kind of the site
    #[arg(value_name = "KIND", value_enum)]
    pub(crate) kind: SiteKind,
    /// File to write, which must not exist [default: standard output]
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
}

/// Kind of a site.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum SiteKind {
    /// A receiver of aircraft transponders, and a radar
    Air,
    /// A receiver of AIS, and a coastal radar
    Sea,
    /// Remote ID, and a sensor of your own
    Drones,
    /// Two radars and telemetry, recorded
    Range,
    /// Two files, with any rule
    Research,
}
