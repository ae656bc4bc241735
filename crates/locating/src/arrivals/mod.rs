//! Arrival times (FM-11): from rows to hyperbolas.
//!
//! The time of a transmission is unknown, so the n arrival times of a single transmission contain n − 1 differences of
//! distances. The obvious n − 1 differences from the same receiver share that receiver's error; taken as independent,
//! they locate worse than possible and state a wrong covariance. Here all n(n − 1)/2 pairs become lines, each with the
//! information wᵢwⱼ/Σw, w being the inverse variances. The sum over all pairs of wᵢwⱼ(eᵢ − eⱼ)²/Σw equals the sum of
//! wᵢ(eᵢ − ē)²: exactly the likelihood of the arrival times with the time of transmission estimated. So lines that are
//! treated singly give the estimate and covariance of all together. And a wrong arrival time spoils only the pairs with
//! this arrival.
//!
//! Differences that a row states itself (`tdoa`) count as independent; common errors are not known here.
//!
//! Transmissions of reference emitters, with a known place, show the receivers' clocks ([`clocks`]). All differences of
//! two receivers have the error of these clocks in common. So the filters keep differences as measured, correct the
//! differences by the newest estimate of the clocks, and take all lines of the same two receivers as no better than
//! these clocks.

mod clocks;
mod pair_clock;
mod transmission;

use observations::{Arrival, Receiver};

use crate::line_of_bearing::{Hyperbola, LineOfBearing, PairOfClocks, Shape};
use crate::settings::{ArrivalSettings, ClockChoice};
use clocks::Clocks;
pub(crate) use clocks::RECEIVERS_MAX as CLOCKS_MAX;
use pair_clock::{ClockModel, ClockReading};
use transmission::RECEPTIONS_MAX;
pub(crate) use transmission::{Reception, Transmission};

/// Most lines of a transmission.
pub(crate) const LINES_MAX: usize = RECEPTIONS_MAX * (RECEPTIONS_MAX - 1) / 2;
/// Transmissions that are collected at a time.
const OPEN_MAX: usize = 256;
/// A difference of distances beyond the distance of the receivers by so many standard deviations is none.
const IMPOSSIBLE_SIGMAS: f64 = 8.0;
/// A clock that is known so much worse than a time was measured is not used.
const CLOCK_SIGMAS_MAX: f64 = 30.0;

/// Result of an arrival.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ArrivalOutcome {
    /// Lines of this emitter are there.
    Lines,
    /// A transmission of a reference emitter has been used for the clocks.
    Reference,
    /// A transmission at a single receiver.
    Alone,
    /// The receivers' clocks are not known yet.
    ClockUnknown,
    /// No position has this difference of distances.
    Impossible,
}

/// A measured difference, not yet corrected by clocks.
#[derive(Clone, Copy, Debug)]
struct Difference {
    way_m: f64,
    /// Variance of the difference, m², and the information of the line, 1/m².
    variance_m2: f64,
    information: f64,
    /// Weight of the clocks' variance in the variance of the line.
    share: f64,
}

/// Collects transmissions and holds the estimates of the receivers' clocks.
#[derive(Debug)]
pub(crate) struct Arrivals {
    settings: ArrivalSettings,
    clocks: Clocks,
    is_estimated: bool,
    open: Vec<Transmission>,
    lines: Vec<LineOfBearing>,
}

impl Arrivals {
    pub(crate) fn new(settings: ArrivalSettings) -> Self {
        let c = settings.propagation_mps;
        Self {
            clocks: Clocks::new(ClockModel {
                drift_sigma_mps: c * settings.drift_sigma,
                drift_noise: (c * settings.drift_noise_per_root_s).powi(2),
            }),
            is_estimated: settings.clocks == ClockChoice::Estimated,
            settings,
            open: Vec::with_capacity(OPEN_MAX),
            lines: Vec::with_capacity(LINES_MAX),
        }
    }

    /// Lines of the transmission processed last.
    pub(crate) fn lines(&self) -> &[LineOfBearing] {
        &self.lines
    }

    /// Number of a receiver's clock; `None` if there are too many receivers.
    pub(crate) fn clock(&mut self, receiver: &Receiver) -> Option<usize> {
        self.clocks.number(receiver.name)
    }

    /// Adds an arrival time at a receiver. A transmission that is complete before is returned.
    pub(crate) fn collect(&mut self, arrival: &Arrival, reception: Reception) -> Option<Transmission> {
        let (time_ns, together_ns) = (arrival.time_of_measurement_ns, self.together_ns());
        let is_same = |open: &Transmission| {
            open.emitter_id == arrival.emitter_id && open.reference_m.is_some() == arrival.reference_m.is_some()
        };
        let place = self.open.iter().position(is_same);
        if let Some(open) = place.map(|place| &mut self.open[place])
            && open.may_take(time_ns, together_ns, &reception)
        {
            open.push(reception);
            return None;
        }
        let place = place.or_else(|| (self.open.len() == OPEN_MAX).then_some(0));
        let complete = place.map(|place| self.open.remove(place));
        let begun = Transmission::new(time_ns, arrival.emitter_id, arrival.reference_m, reception);
        self.open.push(begun);
        complete
    }

    /// Removes a transmission that is complete at `now_ns`; `None` as time: any.
    pub(crate) fn complete(&mut self, now_ns: Option<i64>) -> Option<Transmission> {
        let together_ns = self.together_ns();
        let is_over = |open: &Transmission| now_ns.is_none_or(|now_ns| now_ns - open.time_ns > together_ns);
        let place = self.open.iter().position(is_over)?;
        Some(self.open.remove(place))
    }

    /// Makes the lines of a transmission, or uses the transmission for the clocks.
    pub(crate) fn process(&mut self, transmission: &Transmission) -> ArrivalOutcome {
        self.lines.clear();
        let (time_ns, receptions) = (transmission.time_ns, transmission.receptions());
        if receptions.len() < 2 {
            return ArrivalOutcome::Alone;
        }
        if let Some(reference_m) = transmission.reference_m {
            for (place, other) in receptions.iter().enumerate() {
                for one in &receptions[..place] {
                    let variance_s2 = one.sigma_s * one.sigma_s + other.sigma_s * other.sigma_s;
                    let both = [(one.receiver, one.clock), (other.receiver, other.clock)];
                    self.calibrate(time_ns, both, reference_m, one.after(other), variance_s2);
                }
            }
            return ArrivalOutcome::Reference;
        }
        self.pair_up(time_ns, receptions)
    }

    /// Makes the line of a stated difference, or uses the difference for the clocks.
    pub(crate) fn difference(
        &mut self,
        arrival: &Arrival,
        both: [(Receiver, usize); 2],
        tdoa_s: f64,
    ) -> ArrivalOutcome {
        self.lines.clear();
        let (time_ns, variance_s2) = (arrival.time_of_measurement_ns, arrival.sigma_s * arrival.sigma_s);
        if let Some(reference_m) = arrival.reference_m {
            self.calibrate(time_ns, both, reference_m, tdoa_s, variance_s2);
            return ArrivalOutcome::Reference;
        }
        let c = self.settings.propagation_mps;
        let variance_m2 = c * c * variance_s2;
        let measured = Difference {
            way_m: c * tdoa_s,
            variance_m2,
            information: 1.0 / variance_m2,
            share: 1.0,
        };
        match self.line(time_ns, both, measured) {
            Ok(line) => {
                self.lines.push(line);
                ArrivalOutcome::Lines
            }
            Err(outcome) => outcome,
        }
    }

    /// All pairs of the receptions with known clocks.
    fn pair_up(&mut self, time_ns: i64, receptions: &[Reception]) -> ArrivalOutcome {
        let c = self.settings.propagation_mps;
        let variance_m2 = |one: &Reception| c * c * one.sigma_s * one.sigma_s;
        let weights: f64 = receptions.iter().map(|one| 1.0 / variance_m2(one)).sum();
        // By this factor a pair's variance exceeds the variance of the difference, and so does the variance of the
        // clocks.
        let share = 0.5 * receptions.len() as f64;
        let mut is_any_known = false;
        for (place, other) in receptions.iter().enumerate() {
            for one in &receptions[..place] {
                let both = [(one.receiver, one.clock), (other.receiver, other.clock)];
                let variances_m2 = [one, other].map(variance_m2);
                let measured = Difference {
                    way_m: c * one.after(other),
                    variance_m2: variances_m2[0] + variances_m2[1],
                    information: 1.0 / (variances_m2[0] * variances_m2[1] * weights),
                    share,
                };
                let line = self.line(time_ns, both, measured);
                is_any_known |= line != Err(ArrivalOutcome::ClockUnknown);
                self.lines.extend(line);
            }
        }
        match (self.lines.is_empty(), is_any_known) {
            (false, _) => ArrivalOutcome::Lines,
            (true, true) => ArrivalOutcome::Impossible,
            (true, false) => ArrivalOutcome::ClockUnknown,
        }
    }

    /// A hyperbola.
    ///
    /// # Errors
    /// If no position has this difference of distances, or the clocks are not known.
    fn line(
        &self,
        time_ns: i64,
        both: [(Receiver, usize); 2],
        measured: Difference,
    ) -> Result<LineOfBearing, ArrivalOutcome> {
        let [one, other] = both.map(|(receiver, _)| receiver.position_m);
        let ahead = self.ahead(both[0].1, both[1].1, time_ns);
        let worst_m2 = CLOCK_SIGMAS_MAX * CLOCK_SIGMAS_MAX * measured.variance_m2;
        let (ahead_m, clock_m2) = ahead
            .filter(|(_, clock_m2)| *clock_m2 <= worst_m2)
            .ok_or(ArrivalOutcome::ClockUnknown)?;
        let margin_m = IMPOSSIBLE_SIGMAS * (measured.variance_m2 + clock_m2).sqrt();
        let difference_m = measured.way_m - ahead_m;
        if difference_m.abs() > distance_m(one, other) + margin_m {
            return Err(ArrivalOutcome::Impossible);
        }
        let mut line = LineOfBearing {
            time_ns,
            shape: Shape::Hyperbola(Hyperbola {
                receivers_m: [one, other].map(|[east, north, _]| [east, north]),
                heights_m: [one, other].map(|[_, _, up]| up - self.settings.emitter_height_m),
                difference_m,
                clocks: PairOfClocks {
                    numbers: both.map(|(_, clock)| clock as u16),
                    ahead_m,
                    information: measured.information,
                    share: measured.share,
                },
            }),
            information: measured.information,
            is_used: true,
        };
        line.set_clocks(ahead_m, clock_m2, measured.information);
        Ok(line)
    }

    /// How far a clock is ahead of another, and the variance, metres and m²; `None` if unknown.
    pub(crate) fn ahead(&self, one: usize, other: usize, time_ns: i64) -> Option<(f64, f64)> {
        match self.is_estimated {
            true => self.clocks.ahead(one, other, time_ns),
            false => Some((0.0, 0.0)),
        }
    }

    /// Whether clocks are estimated.
    pub(crate) fn is_estimated(&self) -> bool {
        self.is_estimated
    }

    fn calibrate(
        &mut self,
        time_ns: i64,
        both: [(Receiver, usize); 2],
        reference_m: [f64; 3],
        difference_s: f64,
        variance_s2: f64,
    ) {
        if self.settings.clocks == ClockChoice::Exact {
            return;
        }
        self.is_estimated = true;
        let c = self.settings.propagation_mps;
        let [one_m, other_m] = both.map(|(receiver, _)| distance_m(receiver.position_m, reference_m));
        let reading = ClockReading {
            time_ns,
            ahead_m: c * difference_s - (one_m - other_m),
            variance_m2: c * c * variance_s2,
        };
        self.clocks.take(both[0].1, both[1].1, reading);
    }

    fn together_ns(&self) -> i64 {
        (self.settings.together_max_s * 1e9) as i64
    }
}

fn distance_m(one: [f64; 3], other: [f64; 3]) -> f64 {
    let squares = (0..3).map(|axis| (one[axis] - other[axis]).powi(2));
    squares.sum::<f64>().sqrt()
}
