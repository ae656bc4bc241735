//! Measure: the measurement behind a report, and the sensor track that the report belongs to.

pub(crate) mod storing;
