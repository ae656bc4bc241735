//! Values that should stay constant: a sensor's bias, its detection probability.
//!
//! There is no correct reference value, only the usual value so far. The usual value follows the present value
//! slowly (an exponential mean over an hour), starting when the present value is reliable. A value has changed if
//! it differs from the usual value by more than chance and a margin. A permanent change becomes usual in turn,
//! which clears the alarm.

/// Time constant of the usual value, seconds.
const MEMORY_S: f64 = 3600.0;

/// Usual value of an estimate.
#[derive(Clone, Copy, Debug, Default)]
pub struct Usual {
    known: Option<UsualValue>,
}

#[derive(Clone, Copy, Debug)]
struct UsualValue {
    value: f64,
    sigma: f64,
    at_ns: i64,
}

impl Usual {
    /// Returns the usual value before `value`, with its standard deviation, at `now_ns` (monotonic, nanoseconds);
    /// `None` without a usual value so far. An estimate that is not `settled` clears the usual value.
    pub fn before(&mut self, value: f64, sigma: f64, settled: bool, now_ns: i64) -> Option<(f64, f64)> {
        if !settled || !value.is_finite() || !sigma.is_finite() {
            self.known = None;
            return None;
        }
        let known = self.known.get_or_insert(UsualValue {
            value,
            sigma,
            at_ns: now_ns,
        });
        let passed_s = (now_ns - known.at_ns).max(0) as f64 / messages::NS_PER_S;
        known.value += (value - known.value) * -(-passed_s / MEMORY_S).exp_m1();
        known.at_ns = now_ns;
        // The smallest standard deviation so far applies.
        known.sigma = known.sigma.min(sigma);
        Some((known.value, known.sigma))
    }
}

#[cfg(test)]
mod tests {
    use test_support::S;

    use super::*;

    #[test]
    fn a_step_stands_out_and_becomes_usual() {
        let mut usual = Usual::default();
        assert_eq!(usual.before(7.0, 1.0, false, 0), None);
        assert_eq!(usual.before(7.0, 1.0, true, 0), Some((7.0, 1.0)));
        let mut at = |now_s: i64, value| usual.before(value, 1.0, true, now_s * S).unwrap().0;
        assert!((at(60, 7.0) - 7.0).abs() < 1e-9);
        assert!(at(120, 107.0) < 9.0, "a minute is nothing");
        assert!(at(3_720, 107.0) > 60.0);
        assert!(at(40_000, 107.0) > 106.0);
        assert_eq!(usual.before(f64::NAN, 1.0, true, 40_000 * S), None);
        assert_eq!(
            usual.before(3.0, 1.0, true, 40_001 * S),
            Some((3.0, 1.0)),
            "it begins anew"
        );
    }
}
