//! Admit: checks of reports, their times, and positions that targets report themselves.

pub(crate) mod admitting;
pub(crate) mod host_clock;
pub(crate) mod inlet;
pub(crate) mod verification;
pub(crate) mod verifying;
