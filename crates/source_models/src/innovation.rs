//! Innovation of a measurement: input for learning the models of sources and motion.

/// Fit of the model that surely held: normalised innovation squared in the plane.
#[derive(Clone, Copy, Debug)]
pub enum Fit {
    /// The model of straight flight.
    Straight(f64),
    /// The model of agile motion.
    Turning(f64),
    /// Neither did.
    Undecided,
}

/// Manoeuvre of a target that surely does not fly straight.
#[derive(Clone, Copy, Debug)]
pub struct Manoeuvre {
    /// Probability of agile motion.
    pub agile: f64,
    /// Probability of a turn.
    pub turn: f64,
    /// Expected logarithm of the lateral acceleration relative to the usual one, times the probability of a turn.
    pub hardness: f64,
}

/// Difference between a measurement and its prediction.
#[derive(Clone, Copy, Debug)]
pub struct FilterInnovation {
    /// East and north, metres.
    pub residual_m: [f64; 2],
    /// Covariance of the residual (xx, xy, yy), m².
    pub covariance_m2: [f64; 3],
    /// Squared statistical length of the residual.
    pub squared: f64,
    /// Weight of the measurement in the new horizontal position, in [0, 1]; 0 for an unused measurement.
    pub gain: f64,
    /// Fit of the model that surely held.
    pub fit: Fit,
    /// `None` if the target may fly straight.
    pub manoeuvre: Option<Manoeuvre>,
    /// Expected time of straight flight since the last measurement, s.
    pub straight_s: f64,
    /// Whether the target surely flew straight before and surely turns now.
    pub begins_turn: bool,
}
