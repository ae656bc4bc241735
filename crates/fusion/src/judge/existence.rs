//! Existence of targets (BF-2): decided from reports and missing reports of the sources with coverage.
//!
//! Every sensor has false tracks; a system without selection shows all false tracks. Requiring two sources loses
//! targets visible to a single source. The decisive quantity is the information in the silence of the other sources. If
//! a source with tracks of nineteen of twenty targets in an area has no track here, a target is unlikely. If the source
//! tracks no targets in the area, its silence has no meaning. Let pₖ be the probability that source k tracks a target
//! at this place, configured or learned by the module `detection_map`. The log-likelihood ratio of a single source's
//! claim is
//!
//! L = Σ ln(1 − pₖ) over the silent sources with coverage + the purity of the source: the share of targets among its
//! new tracks (module `purity`) + a term for persistence: false tracks end with a probability of about a fifth per
//! scan + a term for an address: noise does not answer interrogations.
//!
//! A sensor that looks four times as often has four times as many false tracks, and its next looks come as much sooner.
//! So more reports of a fast source with many false tracks are awaited (`existence.patience`): a false track counts as
//! much as a delay of the targets by some seconds. A track at the expected place of a former target is believed early.
//!
//! The silence of a source counts in proportion to the elapsed part of its period since the claim began: before its
//! first look, a source is no evidence. Three sources in agreement are sufficient, and two if few tracks are false.
//! With many false tracks, two of them coincide sometimes by chance. The ratio of an agreement is then so small that
//! the silence of the other sources, and persistence, count as well.
//!
//! A second report with the same address or MMSI, within reach of the target, needs none of this (module
//! `recognition`).
//!
//! While a shown target may be the same target, observed by other sources at another point, a second track waits: the
//! sources are not silent then. Before the spread of the points is known, the points may lie as far apart as the target
//! is large by its type and speed: of the tracks of a long ship, the track of the first source is shown. The reports of
//! all of them count for it, as reports of one target, and no silent source is awaited. The same waiting holds
//! for a source in conflict with two other sources in agreement (module `alignment`). Until the removal of its bias,
//! its tracks are not shown beside tracks of other sources with like velocity within `identity.reach_m`. A confirmed
//! track stays confirmed until its sources *report* the loss of the target: each miss since the last report of any
//! source adds ln(1 − its probability of detection). The probability of existence from L and the misses is published.
//!
//! Source: D. Mušicki, R. Evans, S. Stankovic, *Integrated probabilistic data association*, IEEE Transactions on
//! Automatic Control 39 (1994), for the recursion of existence.

use crate::settings::ExistenceSettings;

/// Probability with this logarithm of its odds.
pub(crate) fn probability(log_odds: f64) -> f64 {
    1.0 / (1.0 + (-log_odds).exp())
}

/// Period from which no reports beyond the usual number are awaited, seconds.
const SLOW_S: f64 = 4.0;
/// Inverse of the share of false tracks among the new tracks of a source, above which all further reports are awaited.
const MANY_FALSE: f64 = 3.0;

/// Returns to what degree further reports of a single source are awaited.
pub(crate) fn awaited(period_s: f64, false_share: f64) -> f64 {
    (SLOW_S / period_s).ln().max(0.0) * (MANY_FALSE * false_share).min(1.0)
}

/// Evidence for a target reported by a single source.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SingleSourceClaim {
    /// Σ ln(1 − pₖ) over the silent sources.
    pub(crate) silence: f64,
    /// Logarithm of the odds that a new track of the source is a target.
    pub(crate) purity: f64,
    /// Reports of the source's track so far.
    pub(crate) reports: u32,
    pub(crate) has_address: bool,
}

impl SingleSourceClaim {
    /// L, the logarithm of how much likelier a target is than a false track.
    pub(crate) fn log_ratio(&self, settings: &ExistenceSettings) -> f64 {
        let further = self.reports.saturating_sub(settings.persistence_reports);
        let persistence = settings.persistence * f64::from(further);
        let address = if self.has_address { settings.address } else { 0.0 };
        self.silence + self.purity + persistence + address
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn claim(silence: f64, reports: u32) -> SingleSourceClaim {
        SingleSourceClaim {
            silence,
            purity: 0.0,
            reports,
            has_address: false,
        }
    }

    fn is_believed(claim: &SingleSourceClaim, settings: &ExistenceSettings) -> bool {
        settings.believes(claim.log_ratio(settings), 0.0)
    }

    #[test]
    fn silence_of_sources_that_cover_the_place_is_telling() {
        assert!(!is_believed(
            &claim((1.0_f64 - 0.9).ln(), 5),
            &ExistenceSettings::default()
        ));
        assert!(is_believed(
            &claim((1.0_f64 - 0.1).ln(), 5),
            &ExistenceSettings::default()
        ));
        let of_a_noisy_source = SingleSourceClaim {
            purity: -1.5,
            ..claim((1.0_f64 - 0.1).ln(), 5)
        };
        assert!(!is_believed(&of_a_noisy_source, &ExistenceSettings::default()));
    }

    #[test]
    fn more_reports_of_a_fast_source_with_many_false_tracks_are_awaited() {
        let settings = ExistenceSettings::default();
        let reports_at = |period_s: f64, false_share: f64| {
            let awaited = awaited(period_s, false_share);
            let believed = |reports: &u32| settings.believes(claim(0.0, *reports).log_ratio(&settings), awaited);
            (1..100).find(believed).expect("believed at last")
        };
        for (period_s, false_share) in [(4.0, 1.0), (12.0, 1.0), (1.0, 0.0)] {
            assert_eq!(reports_at(period_s, false_share), 1, "{period_s} {false_share}");
        }
        assert_eq!([0.2, 0.5, 1.0].map(|share| reports_at(1.0, share)), [6, 10, 10]);
        assert_eq!(reports_at(0.25, 0.5), 19);
    }

    #[test]
    fn persistence_and_addresses_speak_for_a_claim() {
        assert!(!is_believed(&claim(-4.0, 4), &ExistenceSettings::default()));
        assert!(is_believed(&claim(-4.0, 30), &ExistenceSettings::default()));
        let patient = ExistenceSettings {
            persistence_reports: 30,
            ..ExistenceSettings::default()
        };
        assert!(!is_believed(&claim(-4.0, 30), &patient));
        let mut with_address = claim(-4.0, 4);
        with_address.has_address = true;
        assert!(is_believed(&with_address, &ExistenceSettings::default()));
        let strict = ExistenceSettings {
            believed: 3.0,
            ..ExistenceSettings::default()
        };
        assert!(!is_believed(&with_address, &strict));
    }
}
