//! Settings and inputs for tests.

use crate::innovation::{FilterInnovation, Fit};
use crate::settings::{Accuracy, Settings, SourceSettings};

/// Settings for `sources` like sources.
pub(crate) fn test_settings(sources: usize) -> Settings {
    let source = |index: usize| SourceSettings {
        priority: index as u32,
        ..SourceSettings::of(&format!("source{index}"), 1.0, Accuracy::constant(10.0))
    };
    Settings::of((0..sources).map(source).collect())
}

/// An innovation of 0, that fits so.
pub(crate) fn innovation(fit: Fit) -> FilterInnovation {
    FilterInnovation {
        residual_m: [0.0; 2],
        covariance_m2: [1.0, 0.0, 1.0],
        squared: 0.0,
        gain: 0.5,
        fit,
        manoeuvre: None,
        straight_s: 0.0,
        begins_turn: false,
    }
}
