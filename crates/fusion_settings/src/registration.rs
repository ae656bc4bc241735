//! Settings of registration (BF-3).

use crate::source_ref::SourceRef;

settings::settings! {
    /// Systematic errors of the sources (BF-3).
    pub struct RegistrationSettings {
        /// Whether biases are estimated and removed.
        enabled: bool = true;
        /// Name of the source that is taken as true.
        reference_source: Option<SourceRef> = None, usually "the middle of all sources";
        /// Time constant with which old comparisons are forgotten.
        memory_s: f64 = 600.0, in [1, 1e6];
        /// Removal of gross biases of azimuth, range, time or place (with which none of a source's tracks join), if a
        /// third source, the reference source or addresses identify the faulty source. Gross biases are always
        /// reported.
        gross: bool = false;
    }
}
