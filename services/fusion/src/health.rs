//! Health of the sources, as estimated and counted by fusion.

use bus::Transport;
use fusion::{Engine, Learned};
use messages::{Counter, ErrorModel, Registration};
use runtime::HealthEntry;

use crate::inputs::SourceInput;
use crate::source_time::CommonOffsets;

/// Returns the entry of a source for health messages.
pub(crate) fn of_source<S: Transport>(engine: &Engine, input: &SourceInput<S>, common: CommonOffsets) -> HealthEntry {
    let mut entry = HealthEntry {
        source: input.source,
        progress_ns: input.progress_ns,
        counters: engine.counts().source(input.source).copied().unwrap_or_default(),
        registration: registration(engine, input, common),
        ..HealthEntry::default()
    };
    input.count(&mut entry.counters);
    let detection = engine.sources().detection_probability(input.source).unwrap_or_default();
    entry.set(Counter::DetectionPermille, (1e3 * detection).round() as u64);
    entry
}

/// Returns the errors of a source: learned, gross, and of the clock.
fn registration<S: Transport>(engine: &Engine, input: &SourceInput<S>, common: CommonOffsets) -> Registration {
    let mut registration = errors(engine, input.source);
    let source = input.source;
    registration.set_gross_error(
        engine.sources().gross_error(source),
        engine.sources().contradiction(source),
    );
    registration.set_clock_offset(input.time.clock_offset(common.ahead_s));
    registration
}

fn errors(engine: &Engine, source: u16) -> Registration {
    let learned = of_learned(engine.sources().learned(source).unwrap_or_default());
    let Some(known) = engine
        .sources()
        .source_errors(source)
        .filter(|known| known.samples > 0.0)
    else {
        return learned;
    };
    let sigma = known.variances.map(f64::sqrt);
    let [east, north, up, time, range, azimuth] = known.errors.into();
    let bits = known.removed.iter().enumerate();
    Registration {
        comparisons: known.samples,
        offset_m: [east, north, up],
        offset_sigma_m: [sigma[0], sigma[1], sigma[2]],
        time_offset_s: time,
        time_offset_sigma_s: sigma[3],
        range_bias_m: range,
        range_bias_sigma_m: sigma[4],
        azimuth_bias_rad: azimuth,
        azimuth_bias_sigma_rad: sigma[5],
        covariance_inflation: engine.sources().covariance_scale(source).unwrap_or(1.0),
        removed: bits.fold(0, |bits, (error, removed)| bits | u32::from(*removed) << error),
        ..learned
    }
}

/// Learned values of a source beside the biases.
fn of_learned(learned: Learned) -> Registration {
    let number = |value: Option<f64>| value.unwrap_or_default() as f32;
    let [long, short] = learned.measurement_sigma_m.unwrap_or_default();
    let [step_s, sigma_s] = learned.stamps_s.unwrap_or_default();
    Registration {
        long_sigma_m: long as f32,
        short_sigma_m: short as f32,
        height_sigma_m: number(learned.height_sigma_m),
        shape_ratio: number(learned.shape_ratio),
        target_share: number(learned.target_share),
        lateness_s: learned.lateness_s as f32,
        stamp_step_s: step_s as f32,
        stamp_sigma_s: sigma_s as f32,
        detection_probability: learned.detection_probability as f32,
        error_model: learned.error_model.unwrap_or(ErrorModel::Undecided) as u32,
        dependent_sources: learned.dependent.map(|(source, _)| source),
        dependence: learned.dependent.map(|(_, correlation)| correlation as f32),
        ..Registration::default()
    }
}
