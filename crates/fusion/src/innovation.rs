//! What a measurement shows beside its prediction: what the models of sources and motion learn from.

/// How well the model that surely held foretold a measurement: normalised innovation squared in the plane.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Fit {
    Straight(f64),
    /// The model of agile motion.
    Turning(f64),
    /// Neither did.
    Undecided,
}

/// What a target does that surely does not fly straight.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Manoeuvre {
    /// Probabilities of agile motion and of a turn.
    pub(crate) agile: f64,
    pub(crate) turn: f64,
    /// Expected logarithm of the lateral acceleration relative to the usual one, times the probability of a turn.
    pub(crate) hardness: f64,
}

/// Difference between a measurement and its prediction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FilterInnovation {
    /// East and north, metres.
    pub(crate) residual_m: [f64; 2],
    /// Covariance of the residual (xx, xy, yy), m².
    pub(crate) covariance_m2: [f64; 3],
    /// Squared statistical length of the residual.
    pub(crate) squared: f64,
    /// Weight of the measurement in the new horizontal position, in [0, 1]; 0 if it was not used.
    pub(crate) gain: f64,
    pub(crate) fit: Fit,
    /// `None` if the target may fly straight.
    pub(crate) manoeuvre: Option<Manoeuvre>,
    /// Time for which the target is expected to have flown straight since the last measurement, s.
    pub(crate) straight_s: f64,
    /// Whether the target, which surely flew straight, surely turns.
    pub(crate) begins_turn: bool,
}
