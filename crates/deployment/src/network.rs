//! Network inputs and outputs of a deployment.

use std::net::SocketAddr;

use asterix::{Category, Decoder, Edition, Mode, registry};
use formats::sbs::SbsSettings;
use settings::SettingsError;

/// A network input: one socket, read by one adapter process, with one sensor or several behind it.
#[derive(Clone, Debug)]
pub struct Receiver {
    /// Its name, which is that of its adapter process.
    pub name: String,
    /// Where the data come from.
    pub transport: ReceiverTransport,
}

/// Where a receiver's data come from.
#[derive(Clone, Debug)]
pub enum ReceiverTransport {
    /// ASTERIX in datagrams.
    Udp(net::ReceiverSettings),
    /// ASTERIX in datagrams to this port of the deployment's own loopback address: what the simulator sends.
    Loopback {
        /// The port.
        port: u16,
    },
    /// Rows of detections from a server.
    Rows {
        /// The server.
        server: SocketAddr,
    },
    /// Lines of SBS-1 (BaseStation) from a server.
    Sbs {
        /// The server.
        server: SocketAddr,
        /// How its lines are read.
        settings: SbsSettings,
    },
}

/// How ASTERIX records are read.
#[derive(Clone, Debug)]
pub struct Asterix {
    /// Tables of the categories whose edition the file states.
    pub tables: Vec<&'static Category>,
    /// How closely records must follow their edition.
    pub mode: Mode,
}

impl Asterix {
    /// Table that a category is read by; `None` if there is none.
    pub fn table(&self, category: u8) -> Option<&'static Category> {
        let stated = self.tables.iter().find(|table| table.number == category).copied();
        stated.or_else(|| registry::default_edition(category))
    }

    /// A decoder that reads so.
    pub fn decoder(&self) -> Decoder {
        let decoder = Decoder::new(self.mode);
        self.tables
            .iter()
            .fold(decoder, |decoder, table| decoder.with_table(table))
    }
}

/// A source behind a receiver.
#[derive(Clone, Debug)]
pub struct Live {
    /// Name of the receiver.
    pub receiver: String,
    /// How its records are read.
    pub asterix: Asterix,
}

/// An output to the network: one gateway process.
#[derive(Clone, Debug, PartialEq)]
pub struct NetworkOutput {
    /// Its name, which is that of its process.
    pub name: String,
    /// Where its datagrams go, and how; `None` if its readers connect.
    pub sender: Option<net::SenderSettings>,
}

/// Returns the table of a category's edition, or of its default edition.
///
/// # Errors
/// If there is none; the error is that of the key `key`.
pub fn category(key: &str, number: u8, edition: Option<&str>) -> Result<&'static Category, SettingsError> {
    let Some(edition) = edition else {
        return registry::default_edition(number)
            .ok_or_else(|| SettingsError::new(key, format!("category {number} is not known")));
    };
    let table = edition
        .parse::<Edition>()
        .ok()
        .and_then(|edition| registry::find(number, edition));
    table.ok_or_else(|| {
        let mut known: Vec<String> = registry::editions(number).map(ToString::to_string).collect();
        if known.is_empty() {
            known = registry::defaults().map(ToString::to_string).collect();
        }
        let what = format!(
            "category {number} edition \"{edition}\" is not known; there are: {}",
            known.join(", ")
        );
        SettingsError::new(key, what)
    })
}
