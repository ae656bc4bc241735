//! How far a receiver's clock is ahead of another's: offset and drift, from the transmissions of reference emitters.
//!
//! A Kalman filter of two components. Reflected or wrongly assigned arrivals are far off, and may be many; and a clock
//! may be set. So a measurement beyond four standard deviations is left out, and the last few measurements are kept:
//! when most of these are off the filter's line but agree on another, the filter starts again on that line. This also
//! corrects a start with a wrong measurement.

/// Measurements that are kept.
const RECENT: usize = 6;
/// So many measurements on another line restart the filter.
const AGREED: usize = 4;
/// Measurements on the line before the clock counts as known.
const KNOWN_FROM: u32 = 3;
/// Normalised innovations beyond this are off the line.
const DEVIATION_MAX: f64 = 4.0;

/// Assumptions on clocks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ClockModel {
    /// Standard deviation of an unknown drift between two clocks, metres of way per second.
    pub(crate) drift_sigma_mps: f64,
    /// Growth of the drift's variance, (m/s)² per second.
    pub(crate) drift_noise: f64,
}

/// A measured difference of two clocks, in metres of way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ClockReading {
    pub(crate) time_ns: i64,
    pub(crate) ahead_m: f64,
    pub(crate) variance_m2: f64,
}

/// Difference of two clocks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PairClock {
    reference_ns: i64,
    offset_m: f64,
    drift_mps: f64,
    /// Variances of offset and drift, and the covariance.
    offset_m2: f64,
    both: f64,
    drift_m2ps2: f64,
    /// Measurements on the line so far.
    agreed: u32,
    recent: [Option<ClockReading>; RECENT],
    next: usize,
}

impl PairClock {
    pub(crate) const UNKNOWN: Self = Self {
        reference_ns: 0,
        offset_m: 0.0,
        drift_mps: 0.0,
        offset_m2: 0.0,
        both: 0.0,
        drift_m2ps2: 0.0,
        agreed: 0,
        recent: [None; RECENT],
        next: 0,
    };

    /// Difference at a time and the variance, metres and m²; `None` while unknown.
    pub(crate) fn at(&self, time_ns: i64, model: ClockModel) -> Option<(f64, f64)> {
        let off = self
            .recent
            .iter()
            .flatten()
            .filter(|reading| self.is_off(reading, model));
        if self.agreed < KNOWN_FROM || off.count() > RECENT / 2 {
            return None;
        }
        let [offset_m, _, variance_m2, ..] = self.moved(time_ns, model);
        Some((offset_m, variance_m2))
    }

    /// Takes a measurement; measurements older than the last are passed over.
    pub(crate) fn take(&mut self, reading: ClockReading, model: ClockModel) {
        if self.agreed > 0 && reading.time_ns < self.reference_ns {
            return;
        }
        self.recent[self.next] = Some(reading);
        self.next = (self.next + 1) % RECENT;
        if self.agreed == 0 {
            self.begin(reading, model);
        } else if !self.is_off(&reading, model) {
            self.update(reading, model);
        }
        let off = self
            .recent
            .iter()
            .flatten()
            .filter(|reading| self.is_off(reading, model));
        if off.count() >= AGREED
            && let Some(line) = self.agreement(model)
        {
            self.restart(line, model);
        }
    }

    fn begin(&mut self, reading: ClockReading, model: ClockModel) {
        self.reference_ns = reading.time_ns;
        (self.offset_m, self.drift_mps) = (reading.ahead_m, 0.0);
        self.offset_m2 = reading.variance_m2;
        self.both = 0.0;
        self.drift_m2ps2 = model.drift_sigma_mps * model.drift_sigma_mps;
        self.agreed = 1;
    }

    fn update(&mut self, reading: ClockReading, model: ClockModel) {
        let [offset_m, drift_mps, offset_m2, both, drift_m2ps2] = self.moved(reading.time_ns, model);
        let variance_m2 = offset_m2 + reading.variance_m2;
        let innovation_m = reading.ahead_m - offset_m;
        let (gain, drift_gain) = (offset_m2 / variance_m2, both / variance_m2);
        self.reference_ns = reading.time_ns;
        self.offset_m = offset_m + gain * innovation_m;
        self.drift_mps = drift_mps + drift_gain * innovation_m;
        self.offset_m2 = gain * reading.variance_m2;
        self.both = both * (1.0 - gain);
        self.drift_m2ps2 = drift_m2ps2 - drift_gain * both;
        self.agreed = self.agreed.saturating_add(1);
    }

    /// Offset, drift, and the three values of the covariance at a time.
    fn moved(&self, time_ns: i64, model: ClockModel) -> [f64; 5] {
        let after_s = (time_ns - self.reference_ns) as f64 * 1e-9;
        let noise = model.drift_noise * after_s.abs();
        let both = self.both + after_s * self.drift_m2ps2;
        [
            self.offset_m + after_s * self.drift_mps,
            self.drift_mps,
            self.offset_m2 + after_s * (self.both + both) + noise * after_s * after_s / 3.0,
            both + noise * after_s / 2.0,
            self.drift_m2ps2 + noise,
        ]
    }

    fn is_off(&self, reading: &ClockReading, model: ClockModel) -> bool {
        let [offset_m, _, variance_m2, ..] = self.moved(reading.time_ns, model);
        let innovation_m = reading.ahead_m - offset_m;
        innovation_m * innovation_m > DEVIATION_MAX * DEVIATION_MAX * (variance_m2 + reading.variance_m2)
    }

    /// The line through two of the kept measurements on which most others are, as a filter; `None` if there is none.
    fn agreement(&self, model: ClockModel) -> Option<Self> {
        let mut best: Option<(usize, Self)> = None;
        for (place, one) in self.recent.iter().flatten().enumerate() {
            for other in self.recent.iter().flatten().skip(place + 1) {
                let (one, other) = if one.time_ns <= other.time_ns {
                    (one, other)
                } else {
                    (other, one)
                };
                let mut line = Self::UNKNOWN;
                line.begin(*one, model);
                if line.is_off(other, model) {
                    continue;
                }
                line.update(*other, model);
                let on = self
                    .recent
                    .iter()
                    .flatten()
                    .filter(|reading| !line.is_off(reading, model));
                let count = on.count();
                if count >= AGREED && best.as_ref().is_none_or(|(most, _)| count > *most) {
                    best = Some((count, line));
                }
            }
        }
        best.map(|(_, line)| line)
    }

    /// Starts again with the kept measurements that are on `line`, in the order of time.
    fn restart(&mut self, line: Self, model: ClockModel) {
        self.agreed = 0;
        for step in 0..RECENT {
            let Some(reading) = self.recent[(self.next + step) % RECENT] else {
                continue;
            };
            if line.is_off(&reading, model) {
                continue;
            }
            match self.agreed {
                0 => self.begin(reading, model),
                _ => self.update(reading, model),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODEL: ClockModel = ClockModel {
        drift_sigma_mps: 3_000.0,
        drift_noise: 0.0,
    };

    fn reading(second: i64, ahead_m: f64) -> ClockReading {
        ClockReading {
            time_ns: second * 1_000_000_000,
            ahead_m,
            variance_m2: 400.0,
        }
    }

    #[test]
    fn offset_and_drift_are_those_of_the_line() {
        let mut clock = PairClock::UNKNOWN;
        for second in 0..40 {
            assert_eq!(clock.at(second * 1_000_000_000, MODEL).is_some(), second >= 3);
            clock.take(reading(second, 1e5 - 250.0 * second as f64), MODEL);
        }
        let (ahead_m, variance_m2) = clock.at(50_000_000_000, MODEL).unwrap();
        assert!((ahead_m - (1e5 - 12_500.0)).abs() < 0.1, "{ahead_m}");
        // Least squares on 40 equidistant points of variance 400, 30.5 s behind the middle.
        let expected = 400.0 / 40.0 + 400.0 * 30.5 * 30.5 / (40.0 * (1_600.0 - 1.0) / 12.0);
        assert!((variance_m2 / expected - 1.0).abs() < 0.01, "{variance_m2} {expected}");
    }

    #[test]
    fn a_wrong_start_and_a_set_clock_are_noticed() {
        let mut clock = PairClock::UNKNOWN;
        let mut wrong = 0;
        for second in 0..200 {
            let set_m = if second < 100 { 0.0 } else { 5e6 };
            let is_wrong = second == 0 || second % 5 == 3;
            let off_m = if is_wrong { 900.0 + 40.0 * second as f64 } else { 0.0 };
            clock.take(reading(second, set_m + off_m + 3.0 * second as f64), MODEL);
            if let Some((ahead_m, _)) = clock.at(second * 1_000_000_000, MODEL) {
                wrong += u32::from((ahead_m - set_m - 3.0 * second as f64).abs() > 100.0);
            }
        }
        assert!(clock.at(200_000_000_000, MODEL).is_some());
        assert!(wrong <= 6, "{wrong} times wrong");
    }
}
