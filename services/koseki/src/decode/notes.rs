//! Sentences for standard error: content, omitted blocks, and suggested editions.

use std::fmt::Write as _;

use asterix::{Edition, registry};
use formats::recording::{Expansions, RecordingSurvey, RefusalGroup};
use telemetry::table::count;

use crate::args::DecodeArgs;
use crate::editions;

/// Reasons that are shown; `--statistics` shows all.
const REASONS_SHOWN_MAX: usize = 20;
/// Categories without a table that are shown.
const CATEGORIES_SHOWN_MAX: usize = 8;

/// Returns notes on a recording: a line with its content, and a line for each omission.
pub(super) fn notes(decode: &DecodeArgs, survey: &RecordingSurvey) -> String {
    let mut text = format!(
        "koseki: {}: {} of {} in {} ({})\n",
        decode.file.display(),
        several(survey.records(), "record"),
        several(survey.blocks(), "block"),
        several(survey.unpacked.datagrams, "datagram"),
        survey.container,
    );
    // Writing to a string cannot fail.
    let mut note = |line: &str| writeln!(text, "koseki: {line}").unwrap_or(());
    for (number, category) in &survey.categories {
        let try_it = |edition: Edition| format!("try --edition {number}={edition}");
        if let Some(line) = editions::verdict(*number, category, decode.strict, try_it) {
            note(&line);
        }
    }
    without_table(survey).iter().for_each(|line| note(line));
    let refusals = survey.refusals.by_count();
    // A table is clearer.
    let shown = if decode.shows_statistics() {
        0
    } else {
        REASONS_SHOWN_MAX
    };
    for refusal in refusals.iter().take(shown) {
        note(&sentence(refusal));
    }
    if !decode.shows_statistics() && refusals.len() > shown {
        note(&format!(
            "and for {} more reasons; --statistics shows all",
            refusals.len() - shown
        ));
    }
    text
}

/// A line for each of the chosen coding rules that some reserved expansion fields do not follow.
pub(super) fn of_expansions(expansions: &Expansions) -> String {
    let failed = expansions.rules.iter().filter(|(_, failures)| failures.count > 0);
    let notes = failed.map(|(rules, failures)| {
        format!(
            "koseki: I{:03}/RE: {} not follow the coding rules ed {} (left as octets), the first: {}\n",
            rules.number,
            match failures.count {
                1 => "1 field does".to_owned(),
                fields => format!("{} fields do", count(fields)),
            },
            rules.edition,
            failures.first
        )
    });
    notes.collect()
}

/// Returns notes on categories without a decoder: a line for each that is known by name, and one for all others; a
/// capture with other traffic may have many.
fn without_table(survey: &RecordingSurvey) -> Vec<String> {
    let categories = survey.categories.iter();
    let categories = categories.filter(|(_, category)| category.edition.is_none());
    let (named, others): (Vec<_>, Vec<_>) =
        categories.partition(|(number, _)| registry::name_without_table(**number).is_some());
    let mut lines: Vec<String> = named
        .into_iter()
        .filter_map(|(number, category)| {
            let name = registry::name_without_table(*number)?;
            let blocks = several(category.blocks, "block");
            Some(format!("category {number:03}: {name}; no table here ({blocks})"))
        })
        .collect();
    let mut names: Vec<String> = others
        .into_iter()
        .map(|(number, category)| format!("{number:03} ({})", several(category.blocks, "block")))
        .collect();
    if names.len() > CATEGORIES_SHOWN_MAX {
        let more = names.len() - CATEGORIES_SHOWN_MAX;
        names.truncate(CATEGORIES_SHOWN_MAX);
        names.push(format!("{more} more"));
    }
    if !names.is_empty() {
        lines.push(format!(
            "left out, since there is no table of the category: {}",
            names.join(", ")
        ));
    }
    lines
}

fn sentence(refusal: &RefusalGroup) -> String {
    let place = match (refusal.category, refusal.item) {
        (Some(category), Some(item)) => format!(" in I{category:03}/{item}"),
        (Some(category), None) => format!(" in category {category:03}"),
        (None, _) => String::new(),
    };
    format!(
        "{} x {}{place} ({}), the first: {}",
        count(refusal.count),
        refusal.reason,
        several(refusal.octets, "octet"),
        refusal.first
    )
}

fn several(number: u64, what: &str) -> String {
    let plural = if number == 1 { "" } else { "s" };
    format!("{} {what}{plural}", count(number))
}
