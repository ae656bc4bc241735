//! The content of reserved expansion fields, by the coding rules that were chosen.

use asterix::choice::ChosenEdition;
use asterix::{Expansion, NamedRecord, Record, Value};

/// The item with separate coding rules for its content.
const EXPANSION_FIELD: &str = "RE";

/// Coding rules of reserved expansion fields, and how often fields did not follow them.
#[derive(Debug, Default)]
pub struct Expansions {
    /// Rules that were chosen, in the order given.
    pub rules: Vec<(&'static Expansion, ExpansionFailures)>,
}

/// Fields that do not follow the coding rules.
#[derive(Debug, Default)]
pub struct ExpansionFailures {
    /// Number of them.
    pub count: u64,
    /// Fault of the first; empty where there is none.
    pub first: String,
}

impl Expansions {
    /// Coding rules among the chosen editions.
    pub fn new(editions: &[ChosenEdition]) -> Self {
        let rules = editions.iter().filter_map(|chosen| match chosen {
            ChosenEdition::Expansion(rules) => Some((*rules, ExpansionFailures::default())),
            ChosenEdition::Category(_) => None,
        });
        Self { rules: rules.collect() }
    }

    /// Replaces the bytes of a record's field by the decoded content. A field with other rules keeps its bytes.
    pub fn read(&mut self, record: &Record<'_>, named: &mut NamedRecord) {
        if let Some(content) = self.content(record) {
            let fields = named.items.iter_mut().filter(|(name, _)| *name == EXPANSION_FIELD);
            fields.for_each(|(_, value)| *value = content.clone());
        }
    }

    /// The decoded content of a record's field; `None` where it has none, or one with other rules.
    pub fn content(&mut self, record: &Record<'_>) -> Option<Value> {
        let mut found = None;
        for (rules, failures) in &mut self.rules {
            match rules.read(record) {
                Ok(content) => found = content.or(found),
                Err(error) => {
                    if failures.count == 0 {
                        failures.first = error.to_string();
                    }
                    failures.count += 1;
                }
            }
        }
        found
    }
}
