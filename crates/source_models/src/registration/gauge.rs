//! Gauge of the solution: the common part of the errors of all sources shows in no difference.
//!
//! Without a reference source, the geometric median of all sources is taken as true: a single outlier hardly moves the
//! median. Differences determine the distance from the median, per direction (module `displacement`). Sources with
//! wrong clocks weigh less.
//!
//! Source: E. Weiszfeld, *Sur le point pour lequel la somme des distances de n points donnés est minimum*, Tôhoku
//! Mathematical Journal 43 (1937).

use crate::registration::displacement::{Displacement, MeanErrors, ROWS};
use crate::registration::errors::{ClockError, SourceErrors, clock_of};
use crate::registration::rows::{Errors, TIME, UP};
use crate::settings::SOURCES_MAX;

/// Subtracts the common part of the errors: one step towards the median (Weiszfeld).
pub(super) fn fix(sources: &mut [SourceErrors], displacements: &[Displacement], clocks: &[ClockError]) {
    let is_any_off = clocks.iter().any(|clock| clock.excess_s > 0.0);
    // Range and azimuth biases are observable in absolute terms, from different positions. So is the offset, relative
    // to a source known to have none.
    let is_anchored = sources
        .iter()
        .any(|source| source.samples > 0.0 && !source.model.has_offset());
    let mut middle = match is_any_off {
        true => median_by_clocks(sources, clocks),
        false => step_to_median(sources, displacements, is_anchored),
    };
    if is_anchored {
        middle.fixed_rows_mut::<2>(0).fill(0.0);
    }
    for source in sources.iter_mut().filter(|source| source.samples > 0.0) {
        source.errors -= middle;
    }
}

/// Returns a step from 0 towards the geometric median of the compared sources.
fn step_to_median(sources: &[SourceErrors], displacements: &[Displacement], is_anchored: bool) -> Errors {
    let (mut horizontal, mut up, mut total) = (MeanErrors::new(), 0.0, 0.0);
    let known = || {
        sources
            .iter()
            .zip(displacements)
            .filter(|(source, _)| source.samples > 0.0)
    };
    // Every point between two sources is a median, so both sources have equal weights.
    let are_two = known().count() == 2;
    for (source, displacement) in known() {
        let weight = if are_two {
            1.0
        } else {
            displacement.closeness(&source.beside_stamps())
        };
        let mut errors = source.errors;
        errors[TIME] -= source.stamps.mean_s;
        // The offset of a rotation is the offset of the centre of rotation, except where two sources share a rotation.
        match is_anchored || source.model.is_polar() && !are_two {
            true => horizontal.add(&displacement.by_time(), &errors, weight),
            false => horizontal.add(displacement, &errors, weight),
        }
        let weight = 1.0 / (source.errors[UP] * source.errors[UP] + source.variances[UP]).sqrt();
        up += weight * source.errors[UP];
        total += weight;
    }
    let mut middle = match sources.iter().any(|source| source.stamps.is_coarse()) {
        true => horizontal.mean_at(step_by_stamps(sources)),
        false => horizontal.mean(),
    };
    if total > 0.0 {
        middle[UP] = up / total;
    }
    middle
}

/// Returns a step from 0 towards the time offset that agrees best with the stamps of the compared sources: a fine clock
/// decides against coarse clocks, and a clock far off counts less.
fn step_by_stamps(sources: &[SourceErrors]) -> f64 {
    let known = sources.iter().filter(|source| source.samples > 0.0);
    let (sum, total) = known.fold((0.0, 0.0), |(sum, total), source| {
        let weight = source.stamps.closeness(source.errors[TIME]);
        (
            sum + weight * (source.errors[TIME] - source.stamps.mean_s),
            total + weight,
        )
    });
    if total > 0.0 { sum / total } else { 0.0 }
}

/// Returns the median of each error over the compared sources; sources with wrong clocks weigh less.
fn median_by_clocks(sources: &[SourceErrors], clocks: &[ClockError]) -> Errors {
    let mut middle = Errors::zeros();
    for row in ROWS.into_iter().chain([UP]) {
        let mut values = [(0.0, 0.0); SOURCES_MAX];
        let (mut count, mut total) = (0, 0.0);
        for (own, source) in sources.iter().enumerate() {
            if source.samples > 0.0 {
                let weight = 1.0 / (1.0 + clock_of(clocks, own).excess_s);
                values[count] = (source.errors[row], weight);
                (count, total) = (count + 1, total + weight);
            }
        }
        let values = &mut values[..count];
        values.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        middle[row] = weighted_median(values, total);
    }
    middle
}

/// Returns the weighted median of `values` in rising order, with weights that add up to `total`: the mean of the two
/// middle values if the half lies in between; 0 without values.
fn weighted_median(values: &[(f64, f64)], total: f64) -> f64 {
    let mut before = 0.0;
    let reaches_half = |(_, weight): &(f64, f64)| {
        before += weight;
        before >= 0.5 * total
    };
    let Some(lower) = values.iter().position(reaches_half) else {
        return 0.0;
    };
    let upper = if before == 0.5 * total { lower + 1 } else { lower };
    let value = |place: usize| values.get(place).unwrap_or(&values[lower]).0;
    0.5 * (value(lower) + value(upper))
}
