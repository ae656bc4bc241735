//! Destinations of datagrams in the configuration, and mistakes in them.

use std::net::SocketAddr;

use net::NetError;
use settings::SettingsError;

/// Address and port that datagrams go to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Destination(pub SocketAddr);

impl Default for Destination {
    fn default() -> Self {
        Self(SocketAddr::from(([0; 4], 0)))
    }
}

impl Destination {
    fn parse(text: String) -> Result<Self, String> {
        let address: SocketAddr = text.parse().map_err(|_| {
            format!(
                "\"{text}\" is no address and port; write a multicast group or an address, as in \"239.1.2.3:8610\""
            )
        })?;
        match address.port() {
            0 => Err("port 0 is no port; give one from 1 to 65535".to_owned()),
            _ => Ok(Self(address)),
        }
    }
}

settings::spelt_as!(Destination, String, "text", Self::parse, |to| to.0.to_string());

/// Names the key of a setting that no sender can have.
pub(crate) fn sender_mistake(error: NetError) -> SettingsError {
    match error {
        NetError::Setting { setting, value, reason } => {
            let key = match setting {
                "time to live" => "ttl",
                "interface" => "interface",
                _ => "send_to",
            };
            SettingsError::new(key, format!("{value} {reason}"))
        }
        other => SettingsError::new("send_to", other.to_string()),
    }
}
