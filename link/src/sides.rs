//! What two deployments that a link joins have to agree on, found in their configurations.
//!
//! Each configuration may be sound, and the pair is not: what one side sends, the other does not receive. Neither host
//! finds that out before both run; so this module reads both. [`of_one`] finds what one configuration shows.

use std::path::Path;

use bus::{BusError, Payload};
use configuration::{Config, ConfigError};
use deployment::{Deployment, Link, RemoteTopic};
use messages::layout::Sample as _;
use messages::{SensorTrack, Topic, Visitor, WideArea};
use runtime::instance::{Visit, each_stream};
use settings::{Document, SettingsError, nearest};

/// One of the configurations.
pub(crate) struct Side {
    pub(crate) config: Config,
    text: String,
    overrides: Vec<String>,
}

/// What was found, in the order in which it was found.
#[derive(Debug, Default)]
pub(crate) struct Findings {
    /// With these, the link does not work.
    pub(crate) refused: Vec<String>,
    /// With these, it may not be what is meant.
    pub(crate) warnings: Vec<String>,
}

impl Side {
    /// Reads a configuration.
    pub(crate) fn read(path: &Path, overrides: &[String]) -> Result<Self, ConfigError> {
        let text = configuration::text(path)?;
        Ok(Self {
            config: Config::parse(path, &text, overrides)?,
            text,
            overrides: overrides.to_vec(),
        })
    }

    /// File and line of `key`, and what is wrong with it.
    pub(crate) fn at(&self, key: &str, what: impl Into<String>) -> String {
        let error = SettingsError::new(key, what);
        let error = match Document::parse(&self.text, &self.overrides) {
            Ok(document) => document.located(error),
            Err(_) => error,
        };
        let file = self.config.path.clone();
        ConfigError { file, error }.to_string()
    }

    pub(crate) fn text(&self) -> &str {
        &self.text
    }

    pub(crate) fn file(&self) -> String {
        self.config.path.display().to_string()
    }

    /// Each link with its place.
    pub(crate) fn links(&self) -> impl Iterator<Item = (usize, &Link)> {
        self.config.links.iter().enumerate()
    }

    /// Topics that this deployment has, of those that not every deployment has.
    fn topics(&self) -> Vec<String> {
        struct Names(Vec<String>);
        impl Visit for Names {
            fn visit<T: Payload>(&mut self, topic: &Topic<T>, _: usize) -> Result<(), BusError> {
                self.0.push(topic.name.as_str().to_owned());
                Ok(())
            }
        }
        let mut names = Names(Vec::new());
        // Names are collected, which cannot fail.
        let _ = each_stream(&self.config.deployment, 1, &mut names);
        names.0
    }

    /// Topics of its links.
    fn sent(&self) -> Vec<&str> {
        self.config
            .links
            .iter()
            .flat_map(|link| &link.send)
            .map(String::as_str)
            .collect()
    }
}

/// Whether only some deployments have a topic of this name.
fn is_of_some(topic: &str) -> bool {
    [
        "sensor/",
        "wide-area/",
        "platform/",
        "system/own-tracks",
        "system/smoothed",
    ]
    .iter()
    .any(|start| topic.starts_with(start))
}

/// The layout of a topic's samples; `None` for what is no topic.
fn layout(topic: &str) -> Option<u64> {
    struct Layout;
    impl Visitor for Layout {
        type Output = u64;

        fn visit<T: messages::layout::Sample>(self, _: Topic<T>) -> u64 {
            T::SCHEMA
        }
    }
    messages::visit(topic, Layout)
}

fn list(topics: &[&str]) -> String {
    match topics {
        [] => "nothing".to_owned(),
        topics => topics.join(", "),
    }
}

/// What is meant by a topic that is not among `topics`.
fn meant(topic: &str, topics: &[&str]) -> String {
    match nearest(topic, topics) {
        Some(near) => format!("write \"{near}\""),
        None => format!("write one of {}", list(topics)),
    }
}

/// Finds what one configuration shows.
pub(crate) fn of_one(side: &Side, found: &mut Findings) {
    let config = &side.config;
    let own = side.topics();
    let own: Vec<&str> = own.iter().map(String::as_str).collect();
    for (index, link) in side.links() {
        for topic in link
            .send
            .iter()
            .filter(|topic| is_of_some(topic) && !own.contains(&topic.as_str()))
        {
            let what = format!("\"{topic}\" is no topic of this deployment; {}", meant(topic, &own));
            found.refused.push(side.at(&format!("link[{index}].send"), what));
        }
        for (place, remote) in link.receive.iter().enumerate() {
            let at = |key: &str, what: String| side.at(&format!("link[{index}].receive[{place}].{key}"), what);
            if remote.deployment == config.name {
                let what = format!(
                    "\"{}\" is this deployment itself; give the name of the other one",
                    remote.deployment
                );
                found.refused.push(at("deployment", what));
            }
            if let Err(what) = check_kind(remote) {
                found.refused.push(at("topic", what));
            }
            if let Some((key, what)) = forgotten_shares(config, remote) {
                found.refused.push(side.at(&key, what));
            }
        }
    }
}

/// Whether a topic has what the topic that it feeds wants.
fn check_kind(remote: &RemoteTopic) -> Result<(), String> {
    let (topic, into) = (remote.topic.as_str(), remote.into());
    let Some(given) = layout(topic) else {
        let what = "\"system/own-tracks\" of a centre, or \"sensor/NAME/tracks\" of a sensor";
        return Err(format!("\"{topic}\" is no topic; write {what}"));
    };
    let is_picture = topic == messages::system_tracks().name.as_str() || topic == messages::own_tracks().name.as_str();
    let (fits, wanted) = match into.starts_with("wide-area/") {
        true => (given == WideArea::SCHEMA, "\"wide-area/NAME/reports\""),
        false => {
            let wanted = "\"sensor/NAME/tracks\", or of a centre \"system/own-tracks\"";
            (is_picture || given == SensorTrack::SCHEMA, wanted)
        }
    };
    match fits {
        true => Ok(()),
        false => Err(format!("\"{topic}\" does not fit into \"{into}\"; give {wanted}")),
    }
}

/// The key of a source that another centre feeds, and that does not admit it.
fn forgotten_shares(config: &Config, remote: &RemoteTopic) -> Option<(String, String)> {
    if !remote.topic.starts_with("system/") {
        return None;
    }
    let source = config.sources.iter().find(|source| {
        let topic = messages::sensor_tracks(&source.name).name;
        topic.as_str() == remote.into()
    })?;
    let settings = &config.engine.sources[usize::from(source.number)];
    (!settings.is_centre && settings.shares.is_empty()).then(|| {
        let what = format!(
            "is missing, and {} of \"{}\" fuses sensors that this deployment may have, too: \"{}\" would count them \
             twice; add shares = \"unknown\"",
            remote.topic, remote.deployment, source.name
        );
        (format!("source[{}].shares", source.number), what)
    })
}

/// Finds what contradicts itself between two configurations.
pub(crate) fn of_two([west, east]: [&Side; 2], found: &mut Findings) {
    if west.config.name == east.config.name {
        let what = format!(
            "\"{}\" is the name of the deployment in {}, too; give each its own",
            east.config.name,
            west.file()
        );
        found.refused.push(east.at("name", what));
    } else {
        received(west, east, found);
        received(east, west, found);
        check_company(west, east, found);
    }
}

/// Whether anything is received at all, and both are centres of their own.
fn check_company(west: &Side, east: &Side, found: &mut Findings) {
    let receives = |side: &Side, from: &Side| {
        let mut all = side.config.links.iter().flat_map(|link| &link.receive);
        all.any(|remote| remote.deployment == from.config.name)
    };
    if !receives(west, east) && !receives(east, west) {
        for (side, other) in [(west, east), (east, west)] {
            let other = &other.config.name;
            if side.config.links.is_empty() {
                let what = format!("there is no [[link]], so that nothing goes to or from \"{other}\"; add one");
                found.refused.push(side.at("link", what));
            } else {
                let named: Vec<&str> = side
                    .config
                    .links
                    .iter()
                    .flat_map(|link| &link.receive)
                    .map(|remote| remote.deployment.as_str())
                    .collect();
                let what = format!(
                    "receives from {}, not from \"{other}\"; give deployment = \"{other}\" in a [[link.receive]]",
                    list(&named)
                );
                let key = if named.is_empty() {
                    "link[0].receive"
                } else {
                    "link[0].receive[0].deployment"
                };
                found.refused.push(side.at(key, what));
            }
        }
    }
    let exchanges = |side: &Deployment| side.system_tracks.exchange && side.origin != 0;
    let (first, second) = (&west.config.deployment, &east.config.deployment);
    if exchanges(first) && exchanges(second) && first.origin == second.origin {
        let what = format!(
            "{} is the number of {}, too; give each centre its own",
            second.origin,
            west.file()
        );
        found.refused.push(east.at("origin", what));
    }
    let named = |side: &Side, uid: u32| side.config.sources.iter().any(|source| source.uid == uid);
    for source in &first.sources {
        let is_sensor = !west.config.engine.sources[usize::from(source.number)].is_centre;
        if is_sensor && named(east, source.uid) && exchanges(first) && exchanges(second) {
            let what = format!(
                "\"{}\" counts as one sensor with that of {}; if they are two, give them different names, or each a uid",
                source.name,
                east.file()
            );
            found
                .warnings
                .push(west.at(&format!("source[{}].name", source.number), what));
        }
    }
}

/// Checks what `here` receives from `there`.
fn received(here: &Side, there: &Side, found: &mut Findings) {
    let sent = there.sent();
    let topics = there.topics();
    for (index, link) in here.links() {
        let of_there = link.receive.iter().enumerate();
        for (place, remote) in of_there.filter(|(_, remote)| remote.deployment == there.config.name) {
            let key = format!("link[{index}].receive[{place}].topic");
            let (topic, file) = (remote.topic.as_str(), there.file());
            if topic == messages::system_tracks().name.as_str() {
                let what = format!(
                    "\"{topic}\" of {file} has what it received from here, too, and must not be fed in; send and \
                     receive \"system/own-tracks\""
                );
                found.refused.push(here.at(&key, what));
            } else if is_of_some(topic) && !topics.iter().any(|known| known == topic) && layout(topic).is_some() {
                let fit: Vec<&str> = topics
                    .iter()
                    .map(String::as_str)
                    .filter(|known| layout(known) == layout(topic))
                    .collect();
                let what = match topic.starts_with("system/own") {
                    true => format!("\"{topic}\" is not made by {file}; set exchange = true in [fusion] there"),
                    false => format!("\"{topic}\" is no topic of {file}; {}", meant(topic, &fit)),
                };
                found.refused.push(here.at(&key, what));
            } else if !sent.contains(&topic) && layout(topic).is_some() {
                let what = format!(
                    "\"{topic}\" is not sent by {file}, which sends {}; add it to send there",
                    list(&sent)
                );
                found.refused.push(here.at(&key, what));
            }
        }
    }
}
