//! Update: the filter of a system track, and its measurements.

pub(crate) mod assumed;
pub(crate) mod compared_means;
pub(crate) mod comparing;
pub(crate) mod filter;
pub(crate) mod filter_input;
#[cfg(test)]
pub(crate) mod filter_tests;
pub(crate) mod filtering;
pub(crate) mod foresight;
pub(crate) mod kept_measurement;
pub(crate) mod kept_measurements;
pub(crate) mod late;
pub(crate) mod led_off;
pub(crate) mod mean_errors;
pub(crate) mod plane_filter;
pub(crate) mod point_errors;
pub(crate) mod point_leaps;
pub(crate) mod reference_point;
pub(crate) mod vertical_filter;
