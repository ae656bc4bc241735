//! `koseki bench watch`: cost of being watched.
//!
//! The command adds something to a running fusion: a monitor, subscribers, a subscriber that has stopped reading.
//! Alternatively one source sends many times its share, and the effect on the other sources is measured. The cost
//! is far below the machine's noise. Runs with and without the addition are therefore paired, one directly after
//! the other, in alternating order. Only the ratio within each pair counts, summarised by the median ratio with its
//! 95 % interval (see `Ratio`).

use std::ffi::OsString;

use anyhow::Context as _;
use runtime::signals::Stop;
use serde::Serialize;
use telemetry::table::{Align, TextTable, count, duration};

use crate::figures::{Figures, Ratio};
use crate::links::{LinkAccount, LinkWithMirrors};
use crate::machine::{self, MachineFacts};
use crate::measure::{self, LoadPlan};
use crate::product::Product;
use crate::progress::say;
use crate::report::MeasurementOutcome;
use crate::settings::{Flood, MeasurementRefusal, Settings};
use crate::site::{BenchSite, FusionProcess, Running};
use crate::subscribers::Subscribers;

/// Minimum number of pairs for a useful interval.
const PAIRS_MIN: usize = 6;

/// Addition to measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Extra {
    /// The monitor process.
    Monitor,
    /// A subscriber to the system tracks that never reads.
    StoppedSubscriber,
    /// This number of reading subscribers.
    Subscribers(usize),
    /// Link that sends the system tracks to this number of mirrors.
    Link(usize),
    /// Source 0 sends this many times its share; its reports are not measured then.
    Flood(u32),
}

impl std::fmt::Display for Extra {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Monitor => f.write_str("the monitor"),
            Self::StoppedSubscriber => f.write_str("a subscriber that has stopped reading"),
            Self::Subscribers(count) => write!(f, "{count} subscribers"),
            Self::Link(1) => f.write_str("a link and a mirror"),
            Self::Link(mirrors) => write!(f, "a link and {mirrors} mirrors"),
            Self::Flood(factor) => write!(f, "source 0 at {factor} times its rate"),
        }
    }
}

/// Columns of the account of links: processors, and memory of each.
const CARRIED: [&str; 8] = [
    "states",
    "came",
    "conflated",
    "lost, counted",
    "unaccounted",
    "in",
    "link's cores",
    "mirrors' cores",
];

/// Result in the form of JSON.
#[derive(Debug, Serialize)]
struct WatchResult<'a> {
    command: &'static str,
    machine: &'a MachineFacts,
    settings: &'a Settings,
    with: Extra,
    /// Figures with and without, pair by pair.
    pairs: &'a [(Figures, Figures)],
    p50_ratio: Ratio,
    p99_ratio: Ratio,
    p999_ratio: Ratio,
    /// Accounts of the links, pair by pair.
    #[serde(skip_serializing_if = "<[LinkAccount]>::is_empty")]
    carried: &'a [LinkAccount],
}

/// Measures `settings.runs` pairs of runs of `product`. Returns the text to show, and the reason if the figures are
/// unreliable.
///
/// # Errors
/// If the machine cannot do it, a process fails, or the file cannot be written.
pub fn run(
    product: &dyn Product,
    settings: &Settings,
    with: Extra,
    json: Option<&std::path::Path>,
) -> anyhow::Result<MeasurementOutcome> {
    settings.check()?;
    if let Extra::Flood(factor) = with {
        let flooded = Settings {
            flood: Some(flood(factor)),
            ..settings.clone()
        };
        flooded.check()?;
    }
    if settings.runs < PAIRS_MIN {
        let what = format!(
            "--runs {}: fewer than {PAIRS_MIN} pairs give no interval at 95 %",
            settings.runs
        );
        return Err(MeasurementRefusal(what).into());
    }
    let stop = Stop::on_signals_to_clear_up()?;
    let (mut machine, _) = machine::begin(settings);
    let site = BenchSite::prepare(product, settings, &stop)?;
    let plan = LoadPlan {
        rate_per_s: settings.rates_per_s[0],
        seconds: settings.seconds,
        detailed: false,
    };
    let (mut pairs, mut carried) = (Vec::new(), Vec::new());
    for number in 0..settings.runs {
        let with_first = number % 2 == 1;
        let first = one(&site, settings, plan, with_first.then_some(with))?;
        let second = one(&site, settings, plan, (!with_first).then_some(with))?;
        let ((on, by_link), (off, _)) = if with_first { (first, second) } else { (second, first) };
        carried.extend(by_link);
        say(&format!(
            "pair {} of {}: p99 {} with, {} without",
            number + 1,
            settings.runs,
            duration(on.p99_ns as f64),
            duration(off.p99_ns as f64)
        ));
        pairs.push((on, off));
    }
    drop(site);
    machine.ended();
    let ratio = |of: fn(&Figures) -> u64| {
        let values: Vec<(f64, f64)> = pairs.iter().map(|(on, off)| (of(on) as f64, of(off) as f64)).collect();
        Ratio::of_pairs(&values)
    };
    let watched = WatchResult {
        command: "watch",
        machine: &machine,
        settings,
        with,
        p50_ratio: ratio(|figures| figures.p50_ns),
        p99_ratio: ratio(|figures| figures.p99_ns),
        p999_ratio: ratio(|figures| figures.p999_ns),
        pairs: &pairs,
        carried: &carried,
    };
    if let Some(path) = json {
        std::fs::write(path, serde_json::to_string_pretty(&watched)? + "\n")
            .with_context(|| format!("writing {}", path.display()))?;
    }
    Ok(MeasurementOutcome {
        text: shown(&watched),
        failure: failure(&pairs),
    })
}

/// Returns the reason why the figures are unreliable, if any: unanswered reports are in no figure.
fn failure(pairs: &[(Figures, Figures)]) -> Option<String> {
    let unanswered: u64 = pairs.iter().map(|(on, off)| on.lost + off.lost).sum();
    (unanswered > 0).then(|| {
        let unanswered = count(unanswered);
        format!("{unanswered} reports were not answered: the figures cover the other reports only")
    })
}

/// Executes one measurement of a fresh fusion, with or without the addition.
fn one(
    site: &BenchSite,
    settings: &Settings,
    plan: LoadPlan,
    with: Option<Extra>,
) -> anyhow::Result<(Figures, Option<LinkAccount>)> {
    let mut settings = settings.clone();
    if let Some(Extra::Flood(factor)) = with {
        settings.flood = Some(flood(factor));
    }
    let settings = &settings;
    let fusion = site.start_fusion(settings, plan.rate_per_s)?;
    let (mut _monitor, mut _subscribers, mut links) = (None, None, None);
    match with {
        None | Some(Extra::Flood(_)) => {}
        Some(Extra::Monitor) => _monitor = Some(monitor(site, &fusion)?),
        Some(Extra::StoppedSubscriber) => _subscribers = Some(Subscribers::start(site, 1, false)?),
        Some(Extra::Subscribers(count)) => _subscribers = Some(Subscribers::start(site, count, true)?),
        Some(Extra::Link(mirrors)) => links = Some(LinkWithMirrors::start(site, &fusion, mirrors)?),
    }
    let measured = measure::running_pipeline(site, fusion, settings, plan)?;
    let figures = Figures::of(measured.recorder.end_to_end(), measured.unanswered());
    Ok((figures, links.map(LinkWithMirrors::carried).transpose()?))
}

fn flood(factor: u32) -> Flood {
    Flood {
        source: 0,
        factor: f64::from(factor),
    }
}

fn monitor<'a>(site: &'a BenchSite, fusion: &FusionProcess<'_>) -> anyhow::Result<Running<'a>> {
    let arguments: Vec<OsString> = vec!["monitor".into(), "--config".into(), fusion.config().into()];
    site.start("the monitor", arguments)
}

fn shown(watched: &WatchResult<'_>) -> String {
    let mut text = format!(
        "With {}, against without: {} pairs of {} s at {} reports/s, wait {}; load {:.1} before and {:.1} after\n\n",
        watched.with,
        watched.pairs.len(),
        watched.settings.seconds,
        watched.settings.rates_per_s[0],
        watched.settings.wait.word(),
        watched.machine.load_before,
        watched.machine.load_after
    );
    let columns = ["latency", "with", "without", "ratio", "95 % interval"];
    let mut table = TextTable::new(&columns.map(|name| {
        let align = if name == "latency" { Align::Left } else { Align::Right };
        (name, align)
    }));
    let side = |on: bool| {
        let runs = watched.pairs.iter().map(|pair| if on { pair.0 } else { pair.1 });
        Figures::median(&runs.collect::<Vec<_>>())
    };
    let (on, off) = (side(true), side(false));
    let rows = [
        ("p50", on.p50_ns, off.p50_ns, watched.p50_ratio),
        ("p99", on.p99_ns, off.p99_ns, watched.p99_ratio),
        ("p99.9", on.p999_ns, off.p999_ns, watched.p999_ratio),
    ];
    for (name, on, off, ratio) in rows {
        table.row([
            name.to_owned(),
            duration(on as f64),
            duration(off as f64),
            format!("{:.3}", ratio.median),
            format!("{:.3} … {:.3}", ratio.low, ratio.high),
        ]);
    }
    text.push_str(&table.to_string());
    text.push_str(&format!(
        "Unanswered reports of all runs: {} with, {} without.\n",
        on.lost, off.lost
    ));
    let mut table = TextTable::new(&CARRIED.map(|name| (name, Align::Right)));
    for each in watched.carried {
        table.row([
            each.states.to_string(),
            each.came.to_string(),
            each.conflated.to_string(),
            each.lost.to_string(),
            each.unaccounted.to_string(),
            format!("{:.1} s", each.seconds),
            format!("{:.2}, {:.0} MB", each.link_cores, each.link_mb),
            format!("{:.2}, {:.0} MB", each.mirror_cores, each.mirror_mb),
        ]);
    }
    if !watched.carried.is_empty() {
        text.push_str("\nSamples sent by the link, and their fate at all mirrors together:\n\n");
        text.push_str(&table.to_string());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unanswered_reports_on_either_side_are_a_failure() {
        let figures = |lost| Figures {
            lost,
            ..Figures::default()
        };
        assert_eq!(failure(&[(figures(0), figures(0))]), None);
        let failure = failure(&[(figures(2), figures(0)), (figures(0), figures(3))]).unwrap();
        assert!(failure.starts_with("5 reports were not answered"), "{failure}");
    }
}
