//! `koseki feed`.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::time::Duration;

use clap::{ArgGroup, Args};
use offline::values::seconds;

use super::tap::mode;

pub(super) const FEED_EXAMPLES: &str = r#"Examples:
  echo '{"latitude": 41.35, "longitude": 2.15, "sigma_m": 20}' | \
      koseki feed --instance demo --source own
  koseki feed --instance demo --source own --tcp 9000 &
  nc 127.0.0.1 9000 < detections.jsonl
  koseki feed --udp 192.0.2.1:9001 --remote --senders 192.0.2.16/28 --json
  koseki feed --unix /run/feed.sock --mode 660 --group 1001

Each line is a JSON object for one external source, which --source or the field
`source` names. Fields:
  any source     time (2026-05-01T10:00:00.5Z), time_s or time_ns (UTC since
                 1970) [default: time of receipt]; latitude, longitude (WGS-84,
                 degrees) and height_m (above the ellipsoid), or position_m
                 (east, north, up in the system frame) or east_m, north_m,
                 up_m; sigma_m and height_sigma_m (standard deviations);
                 address ("3C6589": hexadecimal) or mmsi ("211234560"),
                 callsign, mode_3a ("7000": octal), name
  of detections  in place of a position: range_m and bearing_deg, or
                 bearing_deg alone, each with elevation_deg if measured;
                 range_sigma_m, bearing_sigma_deg, elevation_sigma_deg; the
                 sensor's place as sensor_latitude, sensor_longitude and
                 sensor_height_m (directions are from its true north), or
                 sensor_m (from the system frame's north); range_rate_mps with
                 range_rate_sigma_mps; scan [default: lines with one time are
                 one scan]
  of tracks      track (number); velocity_mps (east, north, up), or speed_mps,
                 course_deg (from true north) and climb_mps;
                 velocity_sigma_mps; state (tentative, confirmed, terminated)
                 [default: confirmed]

The names of columns in `koseki fuse --help` and `koseki track --help` stand for
the fields of the same quantity, in their own units: lat, SOG_knots, icao24,
flight_level, bearing_rad; a timestamp is text, or seconds or milliseconds since
1970.

Lines of koseki tap are accepted as they are: of sensor tracks and detections
with every field, of system tracks as reports of another centre. --source then
names the fed source, if there are several.

A refused line is not published. A connection and standard output get a JSON
object for each refused line, with line, field, value, limit and remedy. All
refused lines are counted by field in the summary and in the alarm
lines-refused, which names the latest.

At most 64 connections are served at a time, 32 of them from one address. A
connection must send its first line within 10 s, and one each 10 minutes. While
places are short, a connection without a line gives way to a new one at once,
and another after a silence of 1 minute. The reason is answered before a
connection is closed; the summary, standard error and the alarm lines-refused
have the counts."#;

/// `koseki feed`.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("inlet").args(["tcp", "udp", "unix"])), group(ArgGroup::new("network").args(["tcp", "udp"])))]
pub(crate) struct Feed {
    /// The instance that is fed [default: the only one that runs]
    #[arg(long, value_name = "NAME")]
    pub(crate) instance: Option<String>,
    /// The external source of lines without a field `source`
    #[arg(long, value_name = "NAME")]
    pub(crate) source: Option<String>,
    /// Accept connections at this port of this machine, or at an address [default: read standard input]
    #[arg(long, value_name = "[ADDRESS:]PORT", value_parser = address)]
    pub(crate) tcp: Option<SocketAddr>,
    /// Receive datagrams at this port of this machine, or at an address
    #[arg(long, value_name = "[ADDRESS:]PORT", value_parser = address)]
    pub(crate) udp: Option<SocketAddr>,
    /// Accept connections at a Unix socket
    #[arg(long, value_name = "FILE")]
    pub(crate) unix: Option<PathBuf>,
    /// Permit an address that other machines reach
    #[arg(long, requires = "network")]
    pub(crate) remote: bool,
    /// Accept only these senders: addresses and networks, separated by commas
    #[arg(long, value_name = "ADDRESSES", value_delimiter = ',', requires = "network")]
    pub(crate) senders: Vec<String>,
    /// File mode of the Unix socket, octal
    #[arg(long, value_name = "MODE", default_value = "600", requires = "unix", value_parser = mode)]
    pub(crate) mode: u32,
    /// Number of the Unix socket's group [default: that of this process]
    #[arg(long, value_name = "GROUP", requires = "unix")]
    pub(crate) group: Option<u32>,
    /// Largest distance of a stated time from this machine's clock, seconds [default: 600]
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub(crate) clock_limit: Option<Duration>,
    /// Print the summary as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Reads an address with a port; a port alone is one of this machine.
fn address(text: &str) -> Result<SocketAddr, String> {
    match text.parse::<u16>() {
        Ok(port) => Ok((IpAddr::V4(Ipv4Addr::LOCALHOST), port).into()),
        Err(_) => text
            .parse()
            .map_err(|_| format!("\"{text}\" is neither a port nor an address, as in 9000 or 192.0.2.1:9000")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_port_alone_is_of_this_machine() {
        assert_eq!(address("9000").unwrap().to_string(), "127.0.0.1:9000");
        assert_eq!(address("192.0.2.1:9000").unwrap().to_string(), "192.0.2.1:9000");
        assert_eq!(address("[::1]:9000").unwrap().to_string(), "[::1]:9000");
        for text in ["localhost:9000", "70000", ""] {
            assert!(address(text).unwrap_err().contains("neither a port"), "{text}");
        }
    }
}
