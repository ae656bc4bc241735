//! Conditions of the feeding of sources from outside: second publishers, and refused lines.

use alarms::{AlarmKind, Finding, Round, Subject};

use super::{Conditions, RoundView};

impl Conditions {
    /// Sources with a second publisher, and sources of refused lines.
    pub(super) fn feeding(&self, sight: RoundView<'_>, round: &mut Round<'_>) {
        for (name, which) in &sight.feeding.second {
            let values = [("source", name.clone()), ("which", which.clone())];
            round.find(AlarmKind::SecondPublisher, self.subject_of(name), Finding::Bad, &values);
        }
        for (name, reasons) in &sight.feeding.refused {
            let of = match name.as_str() {
                "" => String::new(),
                name => format!(" for {name}"),
            };
            let values = [("of", of), ("reasons", reasons.clone())];
            round.find(AlarmKind::LinesRefused, self.subject_of(name), Finding::Bad, &values);
        }
    }

    /// Subject of a source, sensor or platform.
    fn subject_of(&self, name: &str) -> Subject {
        let source = self.sources.iter().find(|source| source.facts.name == name);
        source.map_or_else(|| Subject::process(name), |source| Subject::source(source.facts.number))
    }
}
