//! Settings of association (TI-3).

use settings::SettingsError;

use crate::identity::FactorExponents;

settings::settings! {
    /// Association of reports with system tracks (TI-3).
    #[derive(Copy)]
    pub struct AssociationSettings {
        check AssociationSettings::check;
        /// Identity is used. Without it only position and motion count; identities are still shown.
        use_identity: bool = true;
        /// Probability that a report of a target lies in the gate for joining a track: on d² in the plane (chi-square,
        /// two degrees of freedom).
        join_probability: GateProbability = GateProbability::of(0.999), in [0.5, 1.0 - 1e-12];
        /// Gate on d² in the plane for staying: wider than joining, so that pairs do not flicker.
        keep_gate: f64 = association::distance::gate2(1e-6), in [0.1, 1e6], usually "27.6: probability 0.999999";
        /// Probability that the gate on d² of position, velocity and height together allows for the horizontal
        /// velocity.
        velocity_probability: GateProbability = GateProbability::of(0.999), in [0.5, 1.0 - 1e-12];
        /// Standard deviation of where on a target a sensor's detection point lies; for large targets.
        extent_sigma_m: f64 = 0.0, in [0, 1e4];
        /// Distance within which a second track of one source is taken for another part of the same target.
        target_extent_m: f64 = 0.0, in [0, 1e4];
        /// Largest difference of two known heights for joining.
        height_gate_m: f64 = 600.0, in [0, 1e5];
        /// Reports in a row that must miss the keep gate before a sensor track is taken out.
        split_reports: u32 = 5, in [1, 1e6];
        /// Reports in a row that must find the same other track before two are merged.
        merge_reports: u32 = 2, in [1, 1e6];
        /// Cell width of the neighbourhood grid.
        cell_m: f64 = 1000.0, in [1, 1e6];
        /// Part of the variance of a difference that two tracks of one target have in common: both lag behind the same
        /// manoeuvres.
        error_correlation: f64 = 0.1, in [0, 0.9];
        /// Time for which sensor tracks without a system track wait for the rest of their scan, as a part of their
        /// source's period; 0: each track is processed at once, independent of the others.
        scan_wait: f64 = 0.05, in [0, 1];
        /// Exponents of the factors of association (QF-2).
        exponents: FactorExponents = FactorExponents::default();
    }
}

/// A gate on d² of two degrees of freedom that files state by its probability.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GateProbability {
    probability: f64,
    gate: f64,
}

impl GateProbability {
    /// The gate in which a target lies with this probability.
    pub fn of(probability: f64) -> Self {
        Self {
            probability,
            gate: -2.0 * (1.0 - probability).ln(),
        }
    }

    /// Greatest d².
    pub fn gate(self) -> f64 {
        self.gate
    }
}

settings::spelt_as!(
    GateProbability,
    f64,
    "number",
    |probability| Ok(Self::of(probability)),
    |gate| gate.probability
);

impl AssociationSettings {
    fn check(&self) -> Result<(), SettingsError> {
        settings::within("keep_gate", self.keep_gate, self.join_gate(), 1e6)
    }

    /// Gate on d² in the plane (chi-square, two degrees of freedom) for joining a track.
    pub fn join_gate(&self) -> f64 {
        self.join_probability.gate()
    }

    /// Whether addresses tell targets apart.
    pub fn uses_addresses(&self) -> bool {
        self.use_identity && self.exponents.address > 0.0
    }

    /// Gate on d² of position, velocity and height together.
    pub fn scan_gate(&self) -> f64 {
        self.join_gate() + self.velocity_probability.gate()
    }
}
