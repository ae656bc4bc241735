//! A velocity from successive positions, for sources that send none.

/// Number of positions that are used.
const POSITIONS: usize = 5;
/// Greatest age of a position used for the present velocity, nanoseconds.
const SPAN_MAX_NS: i64 = 8_000_000_000;
/// But so many are used in any case, as a radar that turns in 12 s has no newer ones …
const POSITIONS_MIN: usize = 3;
/// … unless they are older than this, nanoseconds.
const SILENCE_MAX_NS: i64 = 40_000_000_000;
/// A shorter baseline makes noise into speed, nanoseconds.
const SPAN_MIN_NS: i64 = 900_000_000;

/// The line through a track's last positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Slope {
    /// Metres per second.
    pub(crate) velocity_mps: [f64; 2],
    /// Sum of the squares of the times' distances from their mean, s²: the variance of a position divided by this is
    /// that of the velocity.
    pub(crate) spread_s2: f64,
    /// Age of the mean of the times, at which the target had this velocity, seconds.
    pub(crate) age_s: f64,
}

/// The last positions of one track.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Positions {
    ring: [(i64, [f64; 2]); POSITIONS],
    count: usize,
    newest: usize,
}

impl Positions {
    pub(crate) fn push(&mut self, time_ns: i64, position: [f64; 2]) {
        self.newest = (self.newest + 1) % POSITIONS;
        self.ring[self.newest] = (time_ns, position);
        self.count = (self.count + 1).min(POSITIONS);
    }

    pub(crate) fn newest(&self) -> Option<(i64, [f64; 2])> {
        (self.count > 0).then(|| self.ring[self.newest])
    }

    pub(crate) fn clear(&mut self) {
        self.count = 0;
    }

    /// Slope of the least-squares line through the positions; `None` with too short a baseline.
    pub(crate) fn velocity(&self) -> Option<Slope> {
        let (now_ns, _) = self.newest()?;
        let recent = |back: &usize| {
            let age_ns = now_ns - self.nth(*back).0;
            age_ns <= SPAN_MAX_NS || *back < POSITIONS_MIN && age_ns <= SILENCE_MAX_NS
        };
        let count = (0..self.count).take_while(recent).count();
        if now_ns - self.nth(count.checked_sub(1)?).0 < SPAN_MIN_NS {
            return None;
        }
        let seconds = |back: usize| (self.nth(back).0 - now_ns) as f64 / messages::NS_PER_S;
        let n = count as f64;
        let mean_time = (0..count).map(seconds).sum::<f64>() / n;
        let spread: f64 = (0..count).map(|back| (seconds(back) - mean_time).powi(2)).sum();
        let slope = |axis: usize| {
            let mean = (0..count).map(|back| self.nth(back).1[axis]).sum::<f64>() / n;
            (0..count)
                .map(|back| (seconds(back) - mean_time) * (self.nth(back).1[axis] - mean))
                .sum::<f64>()
                / spread
        };
        Some(Slope {
            velocity_mps: [slope(0), slope(1)],
            spread_s2: spread,
            age_s: -mean_time,
        })
    }

    fn nth(&self, back: usize) -> (i64, [f64; 2]) {
        self.ring[(self.newest + POSITIONS - back) % POSITIONS]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use test_support::S;

    #[test]
    fn a_straight_path_gives_its_velocity() {
        let mut positions = Positions::default();
        assert_eq!(positions.velocity(), None);
        for second in 0..9 {
            positions.push(second * S, [3.0 * second as f64, 100.0 - 4.0 * second as f64]);
        }
        let slope = positions.velocity().unwrap();
        let [vx, vy] = slope.velocity_mps;
        assert!((vx - 3.0).abs() < 1e-9 && (vy + 4.0).abs() < 1e-9);
        assert!((slope.spread_s2 - 10.0).abs() < 1e-9, "five times a second apart");
        assert!((slope.age_s - 2.0).abs() < 1e-9);
    }

    #[test]
    fn short_baselines_and_old_positions_give_none() {
        let mut positions = Positions::default();
        positions.push(0, [0.0; 2]);
        positions.push(S / 2, [10.0; 2]);
        assert_eq!(positions.velocity(), None, "half a second");
        positions.push(60 * S, [20.0; 2]);
        assert_eq!(positions.velocity(), None, "a minute of silence");
    }

    #[test]
    fn a_slow_radar_gives_a_velocity_from_its_last_three_turns() {
        let mut positions = Positions::default();
        // A turn of 12 s, and 90° to the left after the second.
        for (turn, position) in [[0.0, 0.0], [1200.0, 0.0], [1200.0, 1200.0], [1200.0, 2400.0]]
            .iter()
            .enumerate()
        {
            positions.push(12 * S * turn as i64, *position);
        }
        let slope = positions.velocity().unwrap();
        assert_eq!((slope.velocity_mps, slope.spread_s2), ([0.0, 100.0], 288.0));
    }
}
