//! All keys for people, from their declarations.

use deployment::Parts;
use settings::Shared;

use super::locating::LocatingTable;
use super::offline::{OfflineSensorTable, OfflineTable};
use super::tables::DeploymentTable;
use super::tracker::TrackingTable;

/// Spaces before the keys in help texts.
const INDENT: &str = "           ";

const HEAD: &str = "\
# Configuration

Every key of every file that `koseki` reads, made from the declarations in the source; do not edit it by hand.

Files are TOML. Unknown keys are refused. A key whose type ends in `or \"off\"` may be switched off by that word, which is \
the same as leaving it out where the default is `\"off\"`. `--set key.path=value` replaces a value of a deployment's file; \
`source[0].period_s` is a key of the first `[[source]]`.

- *Tracking*: `koseki track --config`.
- *Locating*: `koseki locate --config`.
- *Fusion of files*: `koseki fuse --config`.
- *Deployment*: `koseki up`, `koseki check`, and `--config` of `koseki fuse`, `koseki track` and `koseki simulate`.
";

/// The keys that a site sets: the heading of their table, and their names.
const OF_A_SITE: &[(&str, &[&str])] = &[
    ("## Deployment", &["name"]),
    ("### `[frame]`", &["latitude_deg", "longitude_deg"]),
    ("### `[[receiver]]`", &["name"]),
    ("### `[receiver.udp]`", &["listen", "interface"]),
    ("### `[receiver.tcp]`", &["connect"]),
    ("### `[[source]]`", &["name", "place"]),
    ("### `[source.live]`", &["receiver"]),
    ("### `[source.recorded]`", &["file"]),
    ("### `[[sensor]]`", &["period_s"]),
    (
        "### `[source.covariance]`",
        &["range_sigma_m", "azimuth_sigma_deg", "position_sigma_m"],
    ),
    ("### `[[gateway]]`", &["name", "send_to"]),
    ("### `[recorder]`", &["enabled"]),
    ("### `[checkpoint]`", &["durable"]),
    ("### `[display]`", &["listen"]),
];

/// The rows of the keys that a site sets, as they stand in the `document`, with the path of each key.
///
/// # Panics
/// If a key is in no table of that heading.
fn of_a_site(document: &str) -> String {
    let mut text = String::from(
        "
## The keys that a site sets

Most deployments set these twenty and leave all others as they are. Each stands again in its table below.

| Key | Type | Unit | Range | Default | |
|---|---|---|---|---|---|
",
    );
    for (heading, keys) in OF_A_SITE {
        let sections = document.split("\n##").map(|section| format!("##{section}"));
        let tables: Vec<String> = sections
            .filter(|section| section.lines().next() == Some(heading))
            .collect();
        let table = heading.trim_matches(|character: char| !character.is_ascii_lowercase());
        let table = if heading.contains('`') {
            format!("{table}.")
        } else {
            String::new()
        };
        // The keys of a source begin with those of a sensor.
        let table = if table == "sensor." { "source." } else { &table };
        for key in *keys {
            let begin = format!("| `{key}` |");
            let mut rows = tables.iter().flat_map(|table| table.lines());
            let row = rows
                .find(|row| row.starts_with(&begin))
                .unwrap_or_else(|| panic!("{heading} has no key {key}"));
            text += &format!("| `{table}{key}` |{}\n", &row[begin.len()..]);
        }
    }
    text
}

/// The document `docs/configuration.md`: all keys, with those of the services `P`, by table with name, type, unit,
/// range, default and text.
pub fn reference<P: Parts>() -> String {
    let (mut deployment, mut services) = (DeploymentTable::default(), P::default());
    let deployment = Shared::new(&mut deployment, services.tables());
    let offline = OfflineTable::default();
    let (tracking, locating) = (TrackingTable::default(), LocatingTable::default());
    let files: [(&str, &str, &dyn settings::KeyTable); 4] = [
        (
            "Tracking",
            "The tracker and its sensors; every table may be left out.",
            &tracking,
        ),
        ("Locating", "The locator; every table may be left out.", &locating),
        (
            "Fusion of files",
            "A first pass over the files determines the settings that are not configured.",
            &offline,
        ),
        (
            "Deployment",
            "The processes of a deployment and what they work on.",
            &deployment,
        ),
    ];
    let tables = settings::reference(&files);
    HEAD.to_owned() + &of_a_site(&tables) + &tables
}

/// The keys of `koseki track --config` with their defaults, a line each, for its help.
pub fn tracking_help() -> String {
    settings::help(&TrackingTable::default(), INDENT)
}

/// The keys of `koseki locate --config` with their defaults, a line each, for its help.
pub fn locating_help() -> String {
    settings::help(&LocatingTable::default(), INDENT)
}

/// The keys of `[[sensor]]` in `koseki fuse --config` with their defaults, a line each, for its help.
pub fn sensor_help() -> String {
    settings::help(&OfflineSensorTable::default(), INDENT)
}
