//! `koseki tap`.

use std::net::SocketAddr;
use std::path::PathBuf;

use clap::{ArgGroup, Args, ValueEnum};
use outgoing::HeightReference;

pub(super) const TAP_EXAMPLES: &str = "\
Examples:
  koseki tap --instance demo | jq -c '[.track_number, .position_m]'
  koseki tap --csv --count 1000 > tracks.csv
  koseki tap --instance demo --asterix --sac 1 --sic 2 > tracks.ast
  koseki tap system/alarms --instance demo
  koseki tap --instance demo --unix /run/tracks.sock --mode 660 --group 1001 &
  socat - UNIX-CONNECT:/run/tracks.sock
  koseki tap --instance demo --tcp 127.0.0.1:9000 &
  curl -sN telnet://127.0.0.1:9000

Each sample is a line with its fields by name, in the units of
docs/integrate.md; codes, bits and sources are words, and positions are also
written as latitude, longitude (WGS-84) and height. An unknown value is null in
JSON and empty in CSV. Identities are text: an address in hexadecimal, a Mode
3/A code in octal, an MMSI in decimal digits. Nested samples are JSON objects;
in CSV they are columns such as stages.fused_ns, and lists are omitted. CAT062
has the items of a gateway, except the kinds of contributing sensors. A socket's
reader that is too slow is disconnected, and may connect again; samples lost by
this program are reported on standard error.";

/// `koseki tap`.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("socket").args(["unix", "serve"])))]
pub(crate) struct Tap {
    /// The topic: also system/alarms, system/alerts, system/decisions, sensor/NAME/tracks, health, …
    #[arg(value_name = "TOPIC", default_value = "system/tracks")]
    topic: String,
    /// The topic, as an option
    #[arg(long = "topic", value_name = "TOPIC", conflicts_with = "topic")]
    topic_option: Option<String>,
    /// The instance that is read [default: the only one that runs]
    #[arg(long, value_name = "NAME")]
    pub(crate) instance: Option<String>,
    /// Form of the samples
    #[arg(long, value_name = "FORM", default_value = "json")]
    format: TapFormat,
    /// The same as --format json
    #[arg(long, conflicts_with_all = ["format", "csv", "asterix"])]
    json: bool,
    /// The same as --format csv
    #[arg(long, conflicts_with_all = ["format", "asterix"])]
    csv: bool,
    /// The same as --format cat062
    #[arg(long, conflicts_with = "format")]
    asterix: bool,
    /// Numbers for codes, bits and sources (not of identities), and no latitude and longitude
    #[arg(long)]
    pub(crate) raw: bool,
    /// Print the JSON Schema of the topic's lines, and end; no instance needs to run
    #[arg(long, conflicts_with_all = ["format", "csv", "asterix", "count", "instance", "socket"])]
    pub(crate) schema: bool,
    /// System area code of the sender, in CAT062
    #[arg(long, value_name = "SAC", default_value_t = 0)]
    pub(crate) sac: u8,
    /// System identification code of the sender, in CAT062
    #[arg(long, value_name = "SIC", default_value_t = 0)]
    pub(crate) sic: u8,
    /// Kind of the system's heights, for CAT062: geometric or barometric
    #[arg(long, value_name = "WORD", default_value = "geometric", value_parser = heights)]
    pub(crate) heights: HeightReference,
    /// End after this number of samples
    #[arg(long, value_name = "SAMPLES")]
    pub(crate) count: Option<u64>,
    /// Serve the lines at this address instead of printing them
    #[arg(long, value_name = "ADDRESS:PORT", conflicts_with = "unix")]
    tcp: Option<SocketAddr>,
    /// Serve the lines at a Unix socket instead of printing them
    #[arg(long, value_name = "FILE")]
    unix: Option<PathBuf>,
    /// Serve the lines at this address or Unix socket
    #[arg(long, value_name = "ADDRESS:PORT|FILE", conflicts_with = "tcp", value_parser = served)]
    serve: Option<TapSocket>,
    /// Permit an address that other machines reach: whoever reaches it reads everything, unencrypted
    #[arg(long)]
    pub(crate) remote: bool,
    /// File mode of the Unix socket, octal
    #[arg(long, value_name = "MODE", default_value = "600", requires = "socket", value_parser = mode)]
    pub(crate) mode: u32,
    /// Number of the Unix socket's group [default: that of this process]
    #[arg(long, value_name = "GROUP", requires = "socket")]
    pub(crate) group: Option<u32>,
}

/// Where the lines are served.
#[derive(Clone, Debug)]
pub(crate) enum TapSocket {
    /// At an address.
    Tcp(SocketAddr),
    /// At a Unix socket.
    Unix(PathBuf),
}

impl Tap {
    /// The topic that is read.
    pub(crate) fn topic(&self) -> &str {
        self.topic_option.as_ref().unwrap_or(&self.topic)
    }

    /// Form of the samples.
    pub(crate) fn format(&self) -> TapFormat {
        match (self.csv, self.asterix) {
            (true, _) => TapFormat::Csv,
            (_, true) => TapFormat::Cat062,
            _ if self.json => TapFormat::Json,
            _ => self.format,
        }
    }

    /// Where the lines are served; `None`: they are printed.
    pub(crate) fn socket(&self) -> Option<TapSocket> {
        let unix = self.unix.clone().map(TapSocket::Unix);
        self.serve.clone().or(unix).or(self.tcp.map(TapSocket::Tcp))
    }
}

/// Form of the samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum TapFormat {
    /// A JSON object per line
    Json,
    /// Comma-separated values; the first line has the names
    Csv,
    /// ASTERIX data blocks, of system tracks
    Cat062,
}

fn heights(text: &str) -> Result<HeightReference, String> {
    HeightReference::from_word(text).ok_or_else(|| format!("\"{text}\" is neither geometric nor barometric"))
}

/// Reads an address with a port, or the file of a Unix socket: a name with a colon is a file only with a slash.
fn served(text: &str) -> Result<TapSocket, String> {
    match text.parse() {
        Ok(address) => Ok(TapSocket::Tcp(address)),
        Err(_) if text.contains(':') && !text.contains('/') => Err(format!(
            "\"{text}\" is no address: numbers, as in 127.0.0.1:9000 or [::1]:9000; a file's name, as in ./{text}"
        )),
        Err(_) => Ok(TapSocket::Unix(text.into())),
    }
}

pub(super) fn mode(text: &str) -> Result<u32, String> {
    let mode = u32::from_str_radix(text, 8).ok().filter(|mode| *mode <= 0o777);
    mode.ok_or_else(|| format!("\"{text}\" is no mode: three octal digits, as in 660"))
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Debug, Parser)]
    struct Program {
        #[command(flatten)]
        tap: Tap,
    }

    fn socket(words: &str) -> Result<Option<TapSocket>, String> {
        let parsed = Program::try_parse_from(std::iter::once("tap").chain(words.split_whitespace()));
        parsed
            .map(|program| program.tap.socket())
            .map_err(|error| error.to_string())
    }

    #[test]
    fn lines_are_served_at_an_address_or_a_file_and_a_name_with_a_port_is_refused() {
        for address in ["127.0.0.1:9000", "[::1]:9000"] {
            let served = socket(&format!("--serve {address}"));
            assert!(
                matches!(&served, Ok(Some(TapSocket::Tcp(at))) if at.to_string() == address),
                "{served:?}"
            );
        }
        for file in ["/run/tracks.sock", "tracks.sock", "./localhost:9000"] {
            let served = socket(&format!("--serve {file}"));
            assert!(
                matches!(&served, Ok(Some(TapSocket::Unix(at))) if at.as_os_str() == file),
                "{served:?}"
            );
        }
        for text in ["localhost:9000", "127.0.0.1:99999", ":9000"] {
            let error = socket(&format!("--serve {text}")).unwrap_err();
            assert!(error.contains("is no address"), "{error}");
        }
    }

    #[test]
    fn the_mode_and_the_group_of_a_socket_need_a_socket() {
        assert!(matches!(socket(""), Ok(None)));
        for option in ["--mode 660", "--group 1001"] {
            assert!(socket(option).is_err(), "{option}");
            assert!(socket(&format!("{option} --tcp 127.0.0.1:9000")).is_err(), "{option}");
            for place in ["--unix a.sock", "--serve a.sock"] {
                assert!(socket(&format!("{option} {place}")).is_ok(), "{option} {place}");
            }
        }
        assert!(socket("--unix a.sock --serve b.sock").is_err());
    }
}
