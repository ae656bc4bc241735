//! Access control: which other link may have, and give, which keys.
//!
//! If a link lists its peers, all rights not listed here are refused: each peer may request its permitted topics, may
//! send the topics that this link takes for its own deployment, and may compare clocks. Zenoh's interceptors enforce
//! the rules at the network's edge, by the common name of the certificate or by the user.

use deployment::Link;
use messages::{SystemTrack, system_tracks};
use serde_json::{Value, json};

use crate::keys;

const ALL: [&str; 9] = [
    "put",
    "delete",
    "declare_subscriber",
    "query",
    "declare_queryable",
    "reply",
    "liveliness_token",
    "declare_liveliness_subscriber",
    "liveliness_query",
];

/// Returns the rules of `deployment`'s `link` in the form of Zenoh's configuration; `None` for a link without a list
/// of peers.
pub(crate) fn rules(deployment: &str, link: &Link) -> Option<Value> {
    if link.peers.is_empty() {
        return None;
    }
    let rule = |id: &str, keys: &[String], flow: &str, messages: &[&str]| {
        json!({
            "id": format!("{id}-{flow}"), "key_exprs": keys, "flows": [flow], "messages": messages,
            "permission": "allow",
        })
    };
    let mut rules: Vec<Value> = Vec::new();
    let mut common = Vec::new();
    let mut allow = |to: &mut Vec<String>, id: &str, keys: &[String], ingress: &[&str], egress: &[&str]| {
        // Zenoh has no rule with an empty list.
        if !keys.is_empty() {
            rules.push(rule(id, keys, "ingress", ingress));
            rules.push(rule(id, keys, "egress", egress));
            to.extend([format!("{id}-ingress"), format!("{id}-egress")]);
        }
    };
    allow(&mut common, "clocks", &["koseki-clock/**".to_owned()], &ALL, &ALL);
    let mut subjects = Vec::new();
    let mut policies = Vec::new();
    for (index, peer) in link.peers.iter().enumerate() {
        let read = peer.read(link);
        let mut had: Vec<String> = read
            .iter()
            .map(|topic| keys::topic_of_any_layout(deployment, topic))
            .collect();
        had.extend(had.clone().iter().map(|key| keys::again(key)));
        if read.iter().any(|topic| topic == system_tracks().name.as_str()) {
            had.push(keys::picture::<SystemTrack>(deployment));
        }
        let mut own = common.clone();
        let id = format!("had-{index}");
        let (asked, answered) = (["declare_subscriber", "query"], ["put", "reply", "declare_queryable"]);
        allow(&mut own, &id, &had, &asked, &answered);
        let of_peer = link.receive.iter().filter(|topic| topic.deployment == peer.gives());
        let mut given: Vec<String> = of_peer
            .map(|topic| keys::topic_of_any_layout(&topic.deployment, &topic.topic))
            .collect();
        given.extend(given.clone().iter().map(|key| keys::again(key)));
        allow(&mut own, &format!("given-{index}"), &given, &answered, &asked);
        let mut identities = Vec::new();
        for (kind, is_used) in [
            ("cert_common_names", link.tls().is_some()),
            ("usernames", link.users_file.is_some()),
        ] {
            if is_used {
                let id = format!("{kind}-{index}");
                subjects.push(json!({"id": id, kind: [peer.name]}));
                identities.push(id);
            }
        }
        policies.push(json!({"rules": own, "subjects": identities}));
    }
    Some(json!({
        "enabled": true, "default_permission": "deny", "rules": rules, "subjects": subjects, "policies": policies,
    }))
}
