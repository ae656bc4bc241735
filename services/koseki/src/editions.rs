//! Sentences on categories with blocks that do not fit the edition in use.
//!
//! `decode`, `check`, `up` and `send` survey a recording in the same way ([`formats::recording`]) and name the same
//! edition; each adds the place where the user chooses the edition.

use asterix::Edition;
use formats::recording::CategorySurvey;
use telemetry::table::count;

/// Maximum number of editions shown, among equally fitting editions.
const SHOWN_MAX: usize = 4;

/// Returns a note on a category with blocks that do not fit: the consequence, and a suggestion, which `choose` words.
/// `None` if all fit, or the category has no table.
pub(crate) fn verdict(
    number: u8,
    category: &CategorySurvey,
    strict: bool,
    choose: impl Fn(Edition) -> String,
) -> Option<String> {
    let edition = category.edition.filter(|_| category.blocks_refused > 0)?;
    let refused = count(category.blocks_refused);
    let of = match category.blocks {
        1 => "1 block does".to_owned(),
        blocks => format!("{} blocks do", count(blocks)),
    };
    let consequence = match category.is_withheld() {
        true => "none of its records is given, because blocks may fit by accident",
        false => "they are left out",
    };
    let strictly = if strict { " strictly" } else { "" };
    let remedy = remedy(category, strict, choose);
    Some(format!(
        "category {number:03}: {refused} of {of} not fit edition {edition}{strictly}: {consequence}{remedy}"
    ))
}

fn remedy(category: &CategorySurvey, strict: bool, choose: impl Fn(Edition) -> String) -> String {
    let list = |editions: &[Edition]| {
        let names: Vec<String> = editions.iter().map(ToString::to_string).collect();
        names.join(", ")
    };
    if let Some((editions, fitting)) = category.better() {
        let (first, fitting) = (editions[0], count(fitting));
        let so_do = match &editions[1..editions.len().min(SHOWN_MAX)] {
            [] => String::new(),
            same => format!(" (so do {})", list(same)),
        };
        return format!("; edition {first} fits {fitting} of them{so_do}: {}", choose(first));
    }
    if !category.is_withheld() {
        return String::new();
    }
    let others: Vec<Edition> = category.others.iter().map(|(edition, _)| *edition).collect();
    match (others.is_empty(), strict) {
        (true, _) => "; there is no table of another edition".to_owned(),
        (false, true) => format!("; the other editions here ({}) fit no better", list(&others)),
        (false, false) => format!(
            "; the other editions here ({}) fit no better, so the sender uses one that is not known",
            list(&others)
        ),
    }
}
