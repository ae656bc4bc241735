//! Settings for tests.

use crate::settings::{Accuracy, RuleName, Settings, SourceSettings};

/// Settings for `sources` like sources, in the order of their priority, with the simplest rule.
pub(crate) fn test_settings(sources: usize) -> Settings {
    let source = |index: usize| SourceSettings {
        priority: index as u32,
        ..SourceSettings::of(&format!("source{index}"), 1.0, Accuracy::constant(10.0))
    };
    let mut settings = Settings::of((0..sources).map(source).collect());
    settings.rule.name = RuleName(messages::FusionRule::BestSource);
    settings
}
