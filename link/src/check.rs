//! `koseki-link check`: what `koseki check` asks about the links of one configuration, or of two.

use std::path::PathBuf;

use clap::Args;
use deployment::Link;
use serde_json::json;

use crate::mirror::UsageError;
use crate::sides::{self, Findings, Side};
use crate::{side_endpoints, side_places};

/// `koseki-link check`.
#[derive(Debug, Args)]
pub(crate) struct Check {
    /// Configuration of a deployment, or of both that a link joins, TOML files
    #[arg(value_name = "CONFIG", required = true, num_args = 1..=2)]
    configs: Vec<PathBuf>,
    /// Replace a value of the configuration (repeatable; of one configuration only)
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Print what was found as JSON; the exit code is then 0
    #[arg(long)]
    json: bool,
}

fn describe(link: &Link) -> String {
    let mut words = Vec::new();
    let listed = [
        ("listens at", &link.listen),
        ("connects to", &link.connect),
        ("sends", &link.send),
    ];
    words.extend(
        listed
            .iter()
            .filter(|(_, what)| !what.is_empty())
            .map(|(verb, what)| format!("{verb} {}", what.join(", "))),
    );
    let received = link.receive.iter();
    words.extend(received.map(|remote| format!("receives {} of {}", remote.topic, remote.deployment)));
    words.join("; ")
}

/// Checks, and prints what was found.
///
/// # Errors
/// If something is refused, with the last of it.
pub(crate) fn run(check: &Check) -> anyhow::Result<()> {
    let mut found = Findings::default();
    let sides = check.configs.iter().map(|path| Side::read(path, &check.set));
    let sides = sides.collect::<Result<Vec<Side>, _>>()?;
    for side in &sides {
        sides::of_one(side, &mut found);
    }
    match &sides[..] {
        [one] => drop(side_endpoints::of_one(one, &mut found)),
        [west, east] => {
            sides::of_two([west, east], &mut found);
            side_places::check(west, east, &mut found);
            side_endpoints::check([west, east], &mut found);
        }
        _ => {}
    }
    let Findings { mut refused, warnings } = found;
    if check.json {
        let link = |side: &Side, link: &Link| json!({ "configuration": side.config.path, "name": link.name, "text": describe(link) });
        let links: Vec<_> = sides
            .iter()
            .flat_map(|side| side.config.links.iter().map(move |each| link(side, each)))
            .collect();
        println!(
            "{:#}",
            json!({ "refused": refused, "warnings": warnings, "links": links })
        );
        return Ok(());
    }
    for warning in warnings {
        println!("warning: {warning}");
    }
    let Some(last) = refused.pop() else {
        println!("The links are sound.");
        return Ok(());
    };
    for each in refused {
        runtime::notice(format_args!("koseki-link: {each}"));
    }
    Err(UsageError(last).into())
}
