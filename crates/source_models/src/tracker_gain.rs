//! Gain of a source's tracker, from its reports: the relation of a report to the former report and a measurement.
//!
//! Many trackers state a constant covariance, or a diagonal covariance. Such a covariance shows neither the smoothing
//! of the reports nor the length of the error ellipses. The states show both. A tracker predicts the position from the
//! former report, and a measurement moves the position by K·ν and the velocity by L·ν, with the innovation ν. So the
//! change of the velocity is M·(change of the position), with M = L·K⁻¹. Both changes are in the reports, and the
//! errors of the measurement cancel: two or three reports of a track give the symmetric matrix M.
//!
//! In a filter of nearly constant velocity, M has the same axes as the covariance of the measurements. On each axis the
//! ratio ρ = M·T of both gains determines the gain of the position ([`gain_of`]), and hence the measurement itself. The
//! variance of the innovations follows from the variance of the measurements. So the squared innovations give the
//! variance along the long and along the short axis of the source's errors. On old tracks, the gains differ with the
//! variance, so that each track shows its own: an azimuth error grows with the range.
//!
//! A source is undone only if the covariances show no filter, and if M predicts the next change of velocity. A source
//! with measured velocities, or of plots, does not pass this test.
//!
//! A source that clearly fails this test is given up. Only one of eight tracks is tested further, a minute at a time,
//! since the tracker may change.
//!
//! Limits: a tracker with frequent changes of the gain is recovered badly, and fails the test; the variances contain
//! the deviations of targets from straight flight in a period.
//!
//! Source: P. R. Kalata, *The tracking index: a generalized parameter for α-β and α-β-γ target trackers*, IEEE
//! Transactions on Aerospace and Electronic Systems 20 (1984), for gains and variances; R. K. Mehra, *On the
//! identification of variances and adaptive Kalman filtering*, IEEE Transactions on Automatic Control 15 (1970).

use estimation::Symmetric3;
use kept::kept;
use messages::{AXES, Covariance};
use serde::{Deserialize, Serialize};

use crate::principal::Principal;

/// Weight of earlier reports of a track, relative to the latest report.
const MEMORY: f64 = 0.3;
/// Square of the change of position explained by rounding, m².
const ROUNDING_M2: f64 = 0.25;
/// Change of position below which a report repeats a prediction, relative to rounding.
const REPEATED: f64 = 0.04;
/// Weight of equal ratios on all axes, relative to the reports of a track.
const ISOTROPY: f64 = 1e-3;
/// Largest ratio of the gains: for a velocity from the difference of two positions.
const RATIO_MAX: f64 = 1.0;
/// Relative difference of two periods above which the gains of a track differ.
const IRREGULAR: f64 = 0.25;
/// Limits of the ratio of the changes for a tracker of positions.
const RATIO_LEAST: f64 = 0.05;
const RATIO_IMPOSSIBLE: f64 = 1.3;
/// Smallest ratio of the gains, absolute and relative to the ratio along the latest change.
const RATIO_MIN: f64 = 0.02;
const RATIO_MIN_RELATIVE: f64 = 0.3;
/// Least number of samples of each kind for use.
const FITS_MIN: u32 = 8;
const SAMPLES_MIN: u32 = 16;
/// Number of unbounded samples of a mean square, bound of later samples relative to the mean, and least weight of a
/// sample.
const FREE_SAMPLES: u32 = 4;
const SQUARE_MAX: f64 = 9.0;
const SQUARE_GAIN: f64 = 1.0 / 256.0;
/// Difference of the ratios on both axes relative to the sum, above which the ratios differ: for a young track and for
/// an old track.
const CONTRAST_MIN: [f64; 2] = [0.2, 0.05];
/// Relative squared error up to which a change of velocity counts as predicted.
const FORETOLD: f64 = 0.05;
/// Share of predicted changes above which a source is undone, and below which undoing ends; least weight.
const FORETOLD_FROM: f64 = 0.8;
const FORETOLD_UNTIL: f64 = 0.6;
const FORETOLD_GAIN: f64 = 1.0 / 512.0;
/// Changes of velocity before a source can be given up, and share of predicted changes below which a source is given
/// up.
const HOPELESS_SAMPLES: u32 = 64;
const HOPELESS: f64 = 0.3;
/// Number of tracks of a given-up source per teaching track, and duration of the turn of each track, a minute, as a
/// power of two in nanoseconds.
const TEACHES_OF: i64 = 8;
const TEACHES_FOR: u32 = 36;
/// Measurements of a track after the first, from which on the gains change little.
const OLD_UPDATES: u32 = 5;
/// Least number of reports of a track for learning variances from innovations, for known axes, and for learning noise
/// from gains.
const VARIANCE_UPDATES: u32 = 3;
const AXES_UPDATES: u32 = 5;
const NOISE_UPDATES: u32 = 8;
/// Share of a young track's gain up to which the gain teaches the noise.
const NOISE_YOUTH: f64 = 0.2;
/// Least number of changes that show the gains of a track with unknown earlier changes.
const CHANGES_MIN: u32 = 3;
/// Halvings of the range of ratios.
const HALVINGS: u32 = 20;
/// Least variance of a velocity relative to the part explained by the position.
const COMMON_MIN: f64 = 1.05;
/// Bound of a gain below 1: a report is never a measurement alone.
const GAIN_MAX: f64 = 0.98;

/// Evidence of the gains from the reports of a sensor track.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct GainEvidence {
    /// Σ w·Δ·Δᵀ of the changes of position Δ (xx, xy, yy).
    square: [f64; 3],
    /// Σ w of products of the changes of position and of velocity per second, for the normal equations of M.
    product: [f64; 3],
    /// The same for the height: square and product.
    vertical: [f64; 2],
    /// Measurements of the track, and time before the latest measurement, seconds.
    updates: u32,
    seconds: f64,
    /// Measurements in the sums: fewer for a track with unknown earlier measurements.
    changes: u32,
}

kept! {
    /// Mean of squares, each bounded by a multiple of the mean so far, so that no single square can spoil the mean.
    #[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
    pub(crate) struct MeanSquare {
        mean: f64,
        samples: u32,
    }
}

impl MeanSquare {
    fn add(&mut self, square: f64) {
        self.samples = self.samples.saturating_add(1);
        let bounded = match self.samples > FREE_SAMPLES {
            true => square.min(SQUARE_MAX * self.mean),
            false => square,
        };
        self.mean += (bounded - self.mean) * (1.0 / f64::from(self.samples)).max(SQUARE_GAIN);
    }

    fn is_known(&self) -> bool {
        self.samples >= SAMPLES_MIN
    }

    fn value(&self) -> f64 {
        self.mean
    }
}

kept! {
    /// Share of predicted changes of velocity.
    #[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
    pub(crate) struct FitShare {
        share: f64,
        samples: u32,
    }
}

impl FitShare {
    /// Adds the relative squared error of a predicted change.
    fn add(&mut self, error: f64) {
        self.samples = self.samples.saturating_add(1);
        let fits = f64::from(u8::from(error < FORETOLD));
        self.share += (fits - self.share) * (1.0 / f64::from(self.samples)).max(FORETOLD_GAIN);
    }

    /// Whether the changes are predicted well; `so_far` is the former result.
    fn is_good(&self, so_far: bool) -> bool {
        let least = if so_far { FORETOLD_UNTIL } else { FORETOLD_FROM };
        self.samples >= FITS_MIN && self.share >= least
    }
}

kept! {
    /// Learned properties of a source's tracker.
    #[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
    pub(crate) struct TrackerGain {
        /// Predicted changes of velocity: in the plane, and of the height.
        fit: FitShare,
        vertical_fit: FitShare,
        /// Variance of measurements: mean of both axes, along the long axis, the short axis, and of the height, m².
        both_m2: MeanSquare,
        long_m2: MeanSquare,
        short_m2: MeanSquare,
        vertical_m2: MeanSquare,
        /// Process noise assumed by the tracker, m²/s³: in the plane, and of the height.
        noise: MeanSquare,
        vertical_noise: MeanSquare,
        /// Square of the first change of velocity per axis, m²/s².
        first_m2ps2: MeanSquare,
        /// Variance per axis stated by the latest report, m².
        stated_m2: f64,
        /// Whether the source is undone: both parts.
        is_undone: bool,
        is_height_undone: bool,
    }
}

/// Change of a sensor track from the prediction by the former report to the present report.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Change {
    pub(crate) position_m: [f64; AXES],
    pub(crate) velocity_mps: [f64; AXES],
    pub(crate) seconds: f64,
    pub(crate) has_height: bool,
}

/// Result of undoing a change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Undone {
    /// The measurement minus its prediction, metres, and the covariance, m²; `None` without a measurement.
    pub(crate) measurement: Option<([f64; AXES], Symmetric3)>,
    /// Covariance of the report.
    pub(crate) covariance: Covariance,
}

/// The gains on one axis, with the period as unit of time.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Gains {
    position: f64,
    velocity: f64,
    /// Share of a young track's gain: 1 for a track that has just begun, 0 for a filter in its steady state.
    youth: f64,
    updates: f64,
}

/// Returns whether a track with this number of a hopeless source teaches at this time.
#[inline]
pub(crate) fn teaches(track_number: u32, time_ns: i64) -> bool {
    (i64::from(track_number) + (time_ns >> TEACHES_FOR)) % TEACHES_OF == 0
}

/// Returns the gain of the position where the gain of the velocity is `ratio` times as large, in the steady state of a
/// filter of nearly constant velocity with white acceleration.
fn steady_gain(ratio: f64) -> f64 {
    2.0 * ratio / ((1.0 + 0.5 * ratio) * (1.0 + 0.5 * ratio) - ratio * ratio / 12.0)
}

/// Returns the ratio of the gains of a tracker in steady state with this assumed noise (m²/s³) and measurements of this
/// variance (m²); `None` while either is unknown.
fn usual_ratio(noise: MeanSquare, variance_m2: MeanSquare, seconds: f64) -> Option<f64> {
    if !noise.is_known() || !variance_m2.is_known() {
        return None;
    }
    let (mut least, mut most) = (RATIO_MIN, RATIO_MAX);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (least + most);
        let gains = gains_of(middle, u32::MAX);
        // The larger the gains, the smaller the implied variance.
        let is_larger = noise.value() * gains.implied_s3(seconds) > variance_m2.value();
        (least, most) = if is_larger { (middle, most) } else { (least, middle) };
    }
    Some(0.5 * (least + most))
}

/// Returns the apparent youth of a track with this `ratio` of the gains at report number `n`: 1 where the report uses
/// all measurements of the track alike, 0 in the steady state of a filter.
fn youth(ratio: f64, n: f64) -> f64 {
    let relative = (3.0 / ((2.0 * n - 1.0) * ratio)).min(1.0);
    relative * relative * relative * relative
}

/// Returns the factor by which the gains change with report number `n` of a track with this `ratio`.
fn youth_change(ratio: f64, n: f64) -> f64 {
    1.0 - youth(ratio, n) * 2.0 / (2.0 * n - 1.0)
}

/// Returns the gains of report `number` of a track, from their `ratio`: between the gains of a filter in steady state
/// and the gains of a track that uses all measurements alike.
fn gains_of(ratio: f64, number: u32) -> Gains {
    let n = f64::from(number);
    let of_young = 3.0 / (2.0 * n - 1.0);
    let youth = youth(ratio, n);
    let young_gain = 2.0 * (2.0 * n - 1.0) / (n * (n + 1.0));
    let position = (steady_gain(ratio) + youth * (young_gain - steady_gain(of_young))).clamp(1e-3, GAIN_MAX);
    Gains {
        position,
        velocity: ratio * position,
        youth,
        updates: n,
    }
}

impl Gains {
    /// Returns the variance of innovations in straight flight, relative to the variance of measurements.
    fn innovation(&self) -> f64 {
        let (a, b, before) = (self.position, self.velocity, self.updates - 1.0);
        let steady = (2.0 * a * a + 2.0 * b + a * b) / (a * (4.0 - 2.0 * a - b));
        let young = (4.0 * before + 2.0) / (before * (before - 1.0)).max(1.0);
        1.0 + steady.max(young)
    }

    /// Returns the variance of measurements implied by these gains, relative to the process noise, s³.
    fn implied_s3(&self, seconds: f64) -> f64 {
        seconds * seconds * seconds * (1.0 - self.position) / (self.velocity * self.velocity)
    }

    /// Returns the covariance of a report relative to the variance of measurements: position, position with velocity,
    /// and velocity.
    fn report(&self, seconds: f64) -> [f64; 3] {
        let (a, b, n) = (self.position, self.velocity, self.updates);
        let steady = b * (2.0 * a - b) / (2.0 * (1.0 - a));
        let young = 12.0 / (n * (n * n - 1.0));
        // A valid covariance requires more than the square of the common part.
        let of_velocity = (steady + self.youth * (young - steady)).max(COMMON_MIN * b * b / a);
        [a, b / seconds, of_velocity / (seconds * seconds)]
    }

    /// Returns the variance of the track's measurements: as implied by the gains, and `common_m2` for a young track.
    fn variance_m2(&self, seconds: f64, noise_m2ps3: f64, common_m2: f64) -> f64 {
        let own_m2 = noise_m2ps3 * self.implied_s3(seconds);
        own_m2 + self.youth * (common_m2 - own_m2)
    }
}

impl GainEvidence {
    /// No evidence.
    pub const NONE: Self = Self {
        square: [0.0; 3],
        product: [0.0; 3],
        vertical: [0.0; 2],
        updates: 0,
        seconds: 0.0,
        changes: 0,
    };

    /// Returns M (xx, xy, yy) by least squares; equal ratios on all axes, `ratio`, have a small weight.
    fn matrix(&self, ratio: f64, seconds: f64) -> [f64; 3] {
        let [xx, xy, yy] = self.square;
        if xx + yy <= 0.0 {
            return [ratio, 0.0, ratio];
        }
        let weight = ISOTROPY * (xx + yy);
        let (a, c, d) = (xx + weight, yy + weight, xx + yy + weight);
        let [p, q, r] = self.product.map(|product| product * seconds);
        let (p, r) = (p + weight * ratio, r + weight * ratio);
        let cross = (q - xy * (p / a + r / c)) / (d - xy * xy * (1.0 / a + 1.0 / c));
        [(p - xy * cross) / a, cross, (r - xy * cross) / c]
    }

    /// Makes a track as old as its number of `reports`: reports that taught nothing had measurements, too.
    #[inline]
    pub(crate) fn grow_to(&mut self, reports: u32) {
        self.updates = self.updates.max(reports.saturating_sub(1));
    }

    /// Whether too few changes of an old track were seen: the gain, a divisor, may have any value.
    fn is_thin(&self) -> bool {
        self.changes < self.updates.min(CHANGES_MIN)
    }

    /// Weight of earlier reports: the gains of a young track change from report to report.
    fn memory(&self) -> f64 {
        MEMORY * (f64::from(self.updates.min(OLD_UPDATES)) - 1.0) / (f64::from(OLD_UPDATES) - 1.0)
    }

    /// Adds the change of the latest counted report.
    fn add(&mut self, [x, y]: [f64; 2], [vx, vy]: [f64; 2], ratio: f64) {
        let memory = self.memory();
        let change = youth_change(ratio, f64::from(self.updates) + 1.0);
        let weight = 1.0 / (x * x + y * y + ROUNDING_M2);
        let square = [x * x, x * y, y * y];
        let product = [x * vx, x * vy + y * vx, y * vy];
        for (sum, value) in self.square.iter_mut().zip(square) {
            *sum = memory * *sum + weight * value;
        }
        for (sum, value) in self.product.iter_mut().zip(product) {
            *sum = memory * change * *sum + weight * value;
        }
    }

    fn add_height(&mut self, z: f64, vz: f64) {
        let memory = self.memory();
        let weight = 1.0 / (z * z + ROUNDING_M2);
        for (sum, value) in self.vertical.iter_mut().zip([z * z, z * vz]) {
            *sum = memory * *sum + weight * value;
        }
    }
}

impl TrackerGain {
    /// Whether the source's tracker is undone.
    #[inline]
    pub(crate) fn is_undone(&self) -> bool {
        self.is_undone
    }

    /// Returns the variance of the source's measurements relative to the stated variance; `None` if the source is not
    /// undone.
    pub(crate) fn claim(&self) -> Option<f64> {
        self.is_undone.then(|| self.both_m2.value() / self.stated_m2)
    }

    /// Standard deviations of the source's measurements along the long and the short axis of the error ellipse, metres;
    /// `None` if the source is not undone.
    pub(crate) fn plane_sigma_m(&self) -> Option<[f64; 2]> {
        let of_axis = |axis: &MeanSquare| {
            if axis.is_known() {
                axis.value()
            } else {
                self.both_m2.value()
            }
        };
        self.is_undone
            .then(|| [of_axis(&self.long_m2).sqrt(), of_axis(&self.short_m2).sqrt()])
    }

    /// Standard deviation of the source's heights, metres; `None` if heights are not undone.
    pub(crate) fn height_sigma_m(&self) -> Option<f64> {
        self.is_height_undone.then(|| self.vertical_m2.value().sqrt())
    }

    /// Whether too little is known for a decision.
    pub(crate) fn is_open(&self) -> bool {
        !self.is_undone && (self.fit.samples < FITS_MIN || (self.fit.is_good(false) && !self.both_m2.is_known()))
    }

    /// Returns whether so few changes of the source are predicted that few tracks teach.
    #[inline]
    pub(crate) fn is_hopeless(&self) -> bool {
        !self.is_undone && self.fit.samples >= HOPELESS_SAMPLES && self.fit.share < HOPELESS
    }

    /// Decides whether enough is known to undo the source's tracker.
    fn decide(&mut self) {
        self.is_undone = self.both_m2.is_known() && self.fit.is_good(self.is_undone);
        self.is_height_undone = self.vertical_m2.is_known() && self.vertical_fit.is_good(self.is_height_undone);
    }

    /// Returns the covariance of a track's first report with the covariance `stated`; `None` while too little is known.
    pub(crate) fn first(&self, stated: &Covariance) -> Option<Covariance> {
        if !self.is_undone {
            return None;
        }
        let mut covariance = *stated;
        for axis in 0..2 {
            covariance.set(axis, axis, self.both_m2.value());
            let velocity = covariance.get(axis + AXES, axis + AXES);
            covariance.set(axis + AXES, axis + AXES, velocity.max(self.first_m2ps2.value()));
        }
        covariance.set(0, 1, 0.0);
        if self.is_height_undone {
            covariance.set(2, 2, self.vertical_m2.value());
        }
        Some(covariance)
    }

    /// Learns from a change of a track, and undoes the change; `None` while too little is known. `stated` is the
    /// covariance of the report.
    pub(crate) fn take(&mut self, evidence: &mut GainEvidence, change: &Change, stated: &Covariance) -> Option<Undone> {
        let seconds = change.seconds;
        self.stated_m2 = 0.5 * (stated.get(0, 0) + stated.get(1, 1));
        let [x, y, z] = change.position_m;
        let [vx, vy, vz] = change.velocity_mps.map(|velocity| velocity * seconds);
        let squared = x * x + y * y;
        let is_update = squared > REPEATED * ROUNDING_M2;
        let product = x * vx + y * vy;
        let ratio = (product / squared.max(f64::MIN_POSITIVE)).clamp(RATIO_MIN, RATIO_MAX);
        if is_update {
            let moved = vx * vx + vy * vy + ROUNDING_M2;
            if product > RATIO_IMPOSSIBLE * squared || product < RATIO_LEAST * squared {
                // A measured velocity follows the target: the velocity changes as much as the position, or not at all.
                self.fit.add(1.0);
            } else if evidence.changes >= 2 && (seconds - evidence.seconds).abs() > IRREGULAR * seconds {
                // After a look without a detection the gains differ.
            } else if evidence.changes >= 2 {
                let change = youth_change(ratio, f64::from(evidence.updates) + 2.0);
                let [xx, xy, yy] = evidence.matrix(ratio, seconds).map(|value| change * value);
                let (ex, ey) = (vx - xx * x - xy * y, vy - xy * x - yy * y);
                self.fit.add((ex * ex + ey * ey) / moved);
            } else if evidence.changes == 1 {
                // A single former change shows no matrix yet, but both changes have nearly the same direction.
                self.fit.add(1.0 - product * product.abs() / (squared * moved));
            } else if evidence.updates == 0 {
                self.first_m2ps2.add(0.5 * (vx * vx + vy * vy) / (seconds * seconds));
            }
            evidence.updates = evidence.updates.saturating_add(1);
            evidence.changes = evidence.changes.saturating_add(1);
            evidence.add([x, y], [vx / seconds, vy / seconds], ratio);
            evidence.seconds = seconds;
        }
        let is_thin = evidence.is_thin();
        // The first report has no change.
        let number = evidence.updates.saturating_add(1).max(2);
        let matrix = if is_thin {
            let usual = usual_ratio(self.noise, self.both_m2, seconds)?;
            [usual, 0.0, usual]
        } else {
            evidence.matrix(ratio, seconds)
        };
        let mut principal = Principal::of(matrix);
        let contrast_min = CONTRAST_MIN[usize::from(number >= NOISE_UPDATES)];
        let has_axes = number >= AXES_UPDATES - 1 && principal.contrast() > contrast_min;
        if !has_axes {
            let middle = if number >= AXES_UPDATES - 1 {
                0.5 * (matrix[0] + matrix[2])
            } else {
                ratio
            };
            principal.values = [middle; 2];
        }
        let least = RATIO_MIN.max(if is_thin { 0.0 } else { RATIO_MIN_RELATIVE * ratio });
        let gain = |value: f64| gains_of(value.clamp(least, RATIO_MAX), number);
        let gains = [gain(principal.values[0]), gain(principal.values[1])];
        let components = principal.along([x, y]);
        let innovation: [f64; 2] = std::array::from_fn(|axis| components[axis] / gains[axis].position);
        if is_update && !is_thin {
            self.learn(&gains, innovation, has_axes, seconds);
        }
        let height = change
            .has_height
            .then(|| self.take_height(evidence, (z, vz), number, seconds))
            .flatten();
        self.decide();
        if !self.is_undone {
            return None;
        }
        let noise = self.noise_or(0.0);
        let commons = match has_axes && self.short_m2.is_known() {
            true => [self.long_m2.value(), self.short_m2.value().min(self.long_m2.value())],
            false => [self.both_m2.value(); 2],
        };
        let variances: [f64; 2] = std::array::from_fn(|axis| {
            let common_m2 = commons[axis];
            match noise > 0.0 {
                true => gains[axis].variance_m2(seconds, noise, common_m2),
                false => common_m2,
            }
        });
        let mut covariance = *stated;
        let reports = gains.map(|gains| gains.report(seconds));
        for (part, (row, column)) in [(0, 0), (0, AXES), (AXES, AXES)].into_iter().enumerate() {
            let values = std::array::from_fn(|axis| reports[axis][part] * variances[axis]);
            let [xx, xy, yy] = principal.matrix(values);
            covariance.set(row, column, xx);
            covariance.set(row, column + 1, xy);
            covariance.set(row + 1, column + 1, yy);
            if part == 1 {
                covariance.set(row + 1, column, xy);
            }
        }
        let [xx, xy, yy] = principal.matrix(variances);
        let [east, north] = principal.vector(innovation);
        let (mut up, mut zz) = (z, stated.get(2, 2));
        if let Some((gains, innovation)) = height.filter(|_| self.is_height_undone) {
            let common_m2 = self.vertical_m2.value();
            zz = match self.vertical_noise.is_known() {
                true => gains.variance_m2(seconds, self.vertical_noise.value(), common_m2),
                false => common_m2,
            };
            let report = gains.report(seconds);
            up = innovation;
            covariance.set(2, 2, report[0] * zz);
            covariance.set(2, 5, report[1] * zz);
            covariance.set(5, 5, report[2] * zz);
        }
        let measurement = is_update.then_some(([east, north, up], [xx, xy, 0.0, yy, 0.0, zz]));
        Some(Undone {
            measurement,
            covariance,
        })
    }

    fn noise_or(&self, other: f64) -> f64 {
        match self.noise.is_known() {
            true => self.noise.value(),
            false => other,
        }
    }

    /// Learns variances and noise from an innovation along both axes.
    fn learn(&mut self, gains: &[Gains; 2], innovation: [f64; 2], has_axes: bool, seconds: f64) {
        if gains[0].updates < f64::from(VARIANCE_UPDATES) {
            return;
        }
        let squares: [f64; 2] = std::array::from_fn(|axis| {
            let innovation_m = innovation[axis];
            innovation_m * innovation_m / gains[axis].innovation()
        });
        let mean = 0.5 * (squares[0] + squares[1]);
        self.both_m2.add(mean);
        if gains[0].updates >= f64::from(AXES_UPDATES) {
            let [long, short] = if has_axes { squares } else { [mean; 2] };
            self.long_m2.add(long);
            self.short_m2.add(short);
        }
        let is_steady = gains[0].updates >= f64::from(NOISE_UPDATES) && gains[0].youth < NOISE_YOUTH;
        if is_steady {
            let implied = |axis: usize| squares[axis] / gains[axis].implied_s3(seconds);
            self.noise.add(0.5 * (implied(0) + implied(1)));
        }
    }

    /// The height's part of [`Self::take`]: gains and innovation.
    fn take_height(
        &mut self,
        evidence: &mut GainEvidence,
        (z, vz): (f64, f64),
        number: u32,
        seconds: f64,
    ) -> Option<(Gains, f64)> {
        let [square, product] = evidence.vertical;
        let is_update = z * z > REPEATED * ROUNDING_M2;
        let is_thin = evidence.is_thin();
        if is_update && !is_thin {
            // A source that measures no climb, or measures the climb beside the height, shows no filter.
            if !(RATIO_LEAST * z * z..=RATIO_IMPOSSIBLE * z * z).contains(&(z * vz)) {
                self.vertical_fit.add(1.0);
            } else if square > 0.0 {
                let error = vz - product / square * z;
                self.vertical_fit.add(error * error / (vz * vz + ROUNDING_M2));
            }
        }
        if is_update {
            evidence.add_height(z, vz);
        }
        let [square, product] = evidence.vertical;
        let ratio = match square > 0.0 {
            _ if is_thin => usual_ratio(self.vertical_noise, self.vertical_m2, seconds)?,
            true => product / square,
            false => RATIO_MAX,
        };
        let gains = gains_of(ratio.clamp(RATIO_MIN, RATIO_MAX), number);
        let innovation = z / gains.position;
        if is_update && !is_thin && number >= VARIANCE_UPDATES {
            let square = innovation * innovation / gains.innovation();
            self.vertical_m2.add(square);
            if number >= NOISE_UPDATES && gains.youth < NOISE_YOUTH {
                self.vertical_noise.add(square / gains.implied_s3(seconds));
            }
        }
        Some((gains, innovation))
    }
}

#[cfg(test)]
#[path = "tracker_gain_tests.rs"]
mod tests;
