//! The session with links on other hosts.

use anyhow::{Context as _, anyhow};
use deployment::Link;
use serde_json::json;
use zenoh::{Config, Session, Wait as _};

use crate::gate::Gates;
use crate::{access, refused};

/// Bytes of a message at most: a picture of some ten thousand tracks.
pub(crate) const MESSAGE_MAX: usize = 16 << 20;

/// Time that a handshake of another host may take, milliseconds, for TLS and for the link each.
const HANDSHAKE_MS: u64 = 1500;
/// Handshakes of other hosts at a time; the gates bound those of each address.
const HANDSHAKES_MAX: usize = 1000;

/// An endpoint at which handshakes of TLS have that time.
fn with_patience(endpoint: &str) -> String {
    match endpoint.starts_with("tls/") {
        true => format!("{endpoint}#tls_handshake_timeout_ms={HANDSHAKE_MS}"),
        false => endpoint.to_owned(),
    }
}

/// Joins the links that `deployment`'s `link` names. The gates stay open as long as the session.
///
/// # Errors
/// If an endpoint cannot be listened at, or a file for TLS, users or the password cannot be read.
pub(crate) fn open(deployment: &str, link: &Link) -> anyhow::Result<(Session, Gates)> {
    refused::count();
    let mut config = Config::default();
    let mut set = |key: &str, value: serde_json::Value| {
        let refused = |error| anyhow!("{key} = {value}: {error}");
        config.insert_json5(key, &value.to_string()).map_err(refused)
    };
    set("mode", json!("peer"))?;
    // No scouting: the configuration lists a link's peers.
    set("scouting/multicast/enabled", json!(false))?;
    set("scouting/gossip/enabled", json!(false))?;
    let (gates, behind) = Gates::open(&link.listen)?;
    let behind: Vec<String> = behind.iter().map(|endpoint| with_patience(endpoint)).collect();
    set("listen/endpoints", json!(behind))?;
    // Silent connections are closed soon, and do not block others meanwhile.
    set("transport/unicast/accept_timeout", json!(HANDSHAKE_MS))?;
    set("transport/unicast/accept_pending", json!(HANDSHAKES_MAX))?;
    set("connect/endpoints", json!(link.connect))?;
    set("connect/timeout_ms", json!(-1))?;
    set("connect/exit_on_failure", json!(false))?;
    set(
        "connect/retry",
        json!({"period_init_ms": 200, "period_max_ms": 1000, "period_increase_factor": 2}),
    )?;
    // A peer that is gone without a word is noticed after this time.
    set("transport/link/tx/lease", json!(2000))?;
    // A megabyte for each peer: as much as comes while one that is not slow is not looking.
    set("transport/link/tx/queue/size/data", json!(16))?;
    set("transport/link/rx/max_message_size", json!(MESSAGE_MAX))?;
    if let Some(rules) = access::rules(deployment, link) {
        set("access_control", rules)?;
    }
    if let Some(tls) = link.tls() {
        for file in [&tls.authority, &tls.certificate, &tls.key] {
            std::fs::File::open(file).with_context(|| format!("reading {}", file.display()))?;
        }
        set("transport/link/tls/root_ca_certificate", json!(tls.authority))?;
        set("transport/link/tls/enable_mtls", json!(true))?;
        for side in ["listen", "connect"] {
            set(
                &format!("transport/link/tls/{side}_certificate"),
                json!(tls.certificate),
            )?;
            set(&format!("transport/link/tls/{side}_private_key"), json!(tls.key))?;
        }
    }
    if let Some((user, file)) = link.user.as_ref().zip(link.password_file.as_ref()) {
        let text = std::fs::read_to_string(file).with_context(|| format!("reading {file}"))?;
        let password = text.lines().next().unwrap_or_default();
        set("transport/auth/usrpwd/user", json!(user))?;
        set("transport/auth/usrpwd/password", json!(password))?;
    }
    if let Some(file) = &link.users_file {
        std::fs::File::open(file).with_context(|| format!("reading {file}"))?;
        set("transport/auth/usrpwd/dictionary_file", json!(file))?;
    }
    let at = || format!("{} {}", link.listen.join(" "), link.connect.join(" "));
    let session = zenoh::open(config)
        .wait()
        .map_err(|error| anyhow!("joining {}: {error}", at().trim()))?;
    Ok((session, gates))
}
