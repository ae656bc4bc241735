//! A velocity from successive positions, for sources that send none.

/// How many positions are used.
const POSITIONS: usize = 5;
/// Positions older than this say nothing about the present velocity, nanoseconds.
const SPAN_MAX_NS: i64 = 8_000_000_000;
/// A shorter baseline makes noise into speed, nanoseconds.
const SPAN_MIN_NS: i64 = 900_000_000;

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

    /// Slope of the least-squares line through the positions, metres per second; `None` with too short a baseline.
    pub(crate) fn velocity(&self) -> Option<[f64; 2]> {
        let (now_ns, _) = self.newest()?;
        let recent = |back: &usize| now_ns - self.nth(*back).0 <= SPAN_MAX_NS;
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
        Some([slope(0), slope(1)])
    }

    fn nth(&self, back: usize) -> (i64, [f64; 2]) {
        self.ring[(self.newest + POSITIONS - back) % POSITIONS]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: i64 = 1_000_000_000;

    #[test]
    fn a_straight_path_gives_its_velocity() {
        let mut positions = Positions::default();
        assert_eq!(positions.velocity(), None);
        for second in 0..9 {
            positions.push(second * S, [3.0 * second as f64, 100.0 - 4.0 * second as f64]);
        }
        let [vx, vy] = positions.velocity().unwrap();
        assert!((vx - 3.0).abs() < 1e-9 && (vy + 4.0).abs() < 1e-9);
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
}
