//! Checking what the file says of the display.

use std::net::SocketAddr;
use std::path::PathBuf;

use settings::SettingsError;

use super::check::Checked;
use super::tables::DisplayTable;
use deployment::{Display, TOKEN_MIN};

pub(super) fn check_display(raw: &DisplayTable) -> Checked<Option<Display>> {
    let Some(listen) = &raw.listen else { return Ok(None) };
    let listen: SocketAddr = listen.parse().map_err(|_| {
        let what = format!("\"{listen}\" is no address with a port; write it as in \"127.0.0.1:8900\"");
        SettingsError::new("display.listen", what)
    })?;
    if !listen.ip().is_loopback() {
        public(raw, listen)?;
    }
    let tokens = [
        ("display.token", &raw.token),
        ("display.operator_token", &raw.operator_token),
    ];
    for (key, token) in tokens {
        let allowed = |letter: char| letter.is_ascii_alphanumeric() || letter == '-' || letter == '_';
        if let Some(token) = token
            && (token.len() < TOKEN_MIN || !token.chars().all(allowed))
        {
            let what = format!("needs {TOKEN_MIN} letters, digits, - or _, or more; `openssl rand -hex 16` makes one");
            return Err(SettingsError::new(key, what));
        }
    }
    if raw.operator_token.is_some() {
        check_operators(raw, listen)?;
    }
    Ok(Some(Display {
        listen,
        more_ports: raw.more_ports,
        hosts: hosts("display.hosts", &raw.hosts)?,
        token: raw.token.clone(),
        operator_token: raw.operator_token.clone(),
        history_s: i64::from(raw.history_s),
        history_octets: raw.history_mb as usize * 1_000_000,
        overlays: raw.overlays.iter().map(PathBuf::from).collect(),
    }))
}

/// Needs of a display that accepts orders.
fn check_operators(raw: &DisplayTable, listen: SocketAddr) -> Checked<()> {
    if !listen.ip().is_loopback() {
        let what = format!(
            "orders need a loopback address, and {listen} can be reached from other machines without encryption; use \
             127.0.0.1 behind a proxy that ends TLS"
        );
        return Err(SettingsError::new("display.operator_token", what));
    }
    if raw.operator_token == raw.token {
        let what = "is the token of all viewers; give operators another one";
        return Err(SettingsError::new("display.operator_token", what));
    }
    Ok(())
}

/// Needs of an address that other machines can reach.
fn public(raw: &DisplayTable, listen: SocketAddr) -> Checked<()> {
    if !raw.insecure {
        let what = format!(
            "{listen} can be reached from other machines, and nothing is encrypted; use 127.0.0.1 behind a proxy that \
             ends TLS, or set insecure = true beside it"
        );
        return Err(SettingsError::new("display.listen", what));
    }
    if raw.token.is_none() {
        let what = format!("{listen} can be reached from other machines; give a token that browsers have to show");
        return Err(SettingsError::new("display.token", what));
    }
    Ok(())
}

/// Names of this machine that the key `key` gives, in small letters.
pub(super) fn hosts(key: &str, names: &[String]) -> Checked<Vec<String>> {
    let check = |name: &String| {
        let allowed = |letter: char| letter.is_ascii_alphanumeric() || letter == '-' || letter == '.';
        if name.is_empty() || !name.chars().all(allowed) {
            let what = format!("\"{name}\" is no name of a machine; write it without a port, as in \"koseki.example\"");
            return Err(SettingsError::new(key, what));
        }
        Ok(name.to_ascii_lowercase())
    };
    names.iter().map(check).collect()
}
