//! Settings of the existence of targets.

settings::settings! {
    /// Existence of targets, estimated from reports and missing reports of sources (BF-2). Keys give log-likelihood
    /// ratios of a target to a false track; the ratios of one claim are added.
    #[derive(Copy)]
    pub struct ExistenceSettings {
        /// Log-likelihood ratio above which a target reported by a single source exists; the silence of each source
        /// with coverage of the place counts against the target.
        believed: f64 = -0.7, in [-20, 20], usually "-0.7: about one to two against it";
        /// Additional ratio for a target reported by a single fast source with many false tracks, times the logarithm
        /// of 4 s over the period: further reports come soon.
        patience: f64 = 1.5, in [0, 10], usually "1.5: nine further reports of a source with a period of 1 s";
        /// Worth of each further report of the claim's sensor track: −ln of the share of false tracks that go on.
        persistence: f64 = 0.223, in [0, 10], usually "0.223: one false track in five ends with each report";
        /// Reports before persistence counts.
        persistence_reports: u32 = 3, in [0, 1e6];
        /// Worth of an address: noise does not answer interrogations.
        address: f64 = 5.0, in [0, 20];
        /// Largest worth of a former target that may have come back at its expected place.
        former: f64 = 5.0, in [0, 20];
        /// Sum of ln(1 − probability of detection) over the misses since the last detection by any source, at which a
        /// confirmed target counts as gone: its track is withheld until the next detection.
        gone: f64 = -6.9, in [-50, -0.1], usually "-6.9: one target in a thousand would be missed that often";
        /// Successive misses of a source that count for this sum: an obstacle that hides a target causes several
        /// misses.
        misses: u32 = 2, in [1, 1000];
    }
}

impl ExistenceSettings {
    /// Returns whether a target with this log-likelihood ratio exists. Further reports of a single source are `awaited`
    /// to this degree; 0 for several sources.
    pub fn believes(&self, log_ratio: f64, awaited: f64) -> bool {
        log_ratio > self.believed + self.patience * awaited
    }
}
