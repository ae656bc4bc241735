//! Admit: checks of reports, times of reports, and self-reported positions of targets.

pub(crate) mod admitting;
pub(crate) mod host_clock;
pub(crate) mod inlet;
pub(crate) mod verification;
pub(crate) mod verifying;
