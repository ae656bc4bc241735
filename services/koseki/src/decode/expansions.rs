//! The content of reserved expansion fields, by the coding rules that were chosen on the command line.

use asterix::{Expansion, NamedRecord, Record};
use telemetry::table::count;

use crate::args::{ChosenEdition, Decode};

/// The item whose content has coding rules of its own.
const EXPANSION_FIELD: &str = "RE";

/// The coding rules of reserved expansion fields that were chosen, and how often fields did not follow them.
pub(super) struct Expansions {
    rules: Vec<(&'static Expansion, Failures)>,
}

#[derive(Default)]
struct Failures {
    count: u64,
    first: String,
}

impl Expansions {
    pub(super) fn new(decode: &Decode) -> Self {
        let rules = decode.editions.iter().filter_map(|chosen| match chosen {
            ChosenEdition::Expansion(rules) => Some((*rules, Failures::default())),
            ChosenEdition::Category(_) => None,
        });
        Self { rules: rules.collect() }
    }

    /// Puts the content of a record's field in the place of its octets. A field that follows other rules keeps them.
    pub(super) fn read(&mut self, record: &Record<'_>, named: &mut NamedRecord) {
        for (rules, failures) in &mut self.rules {
            match rules.read(record) {
                Ok(Some(content)) => {
                    let fields = named.items.iter_mut().filter(|(name, _)| *name == EXPANSION_FIELD);
                    fields.for_each(|(_, value)| *value = content.clone());
                }
                Ok(None) => {}
                Err(error) => {
                    if failures.count == 0 {
                        failures.first = error.to_string();
                    }
                    failures.count += 1;
                }
            }
        }
    }

    /// A line for each of the rules that some fields do not follow.
    pub(super) fn notes(&self) -> String {
        let failed = self.rules.iter().filter(|(_, failures)| failures.count > 0);
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
}
