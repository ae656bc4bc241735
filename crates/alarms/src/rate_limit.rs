//! Limit of output lines to reading speed.

/// Maximum number of lines at once.
const BURST: f64 = 8.0;
/// Lines per second after that.
const PER_S: f64 = 1.0;

/// Limit for lines: a few at once, then one per second; further lines are counted (a token bucket).
#[derive(Clone, Copy, Debug)]
pub struct RateLimit {
    allowed: f64,
    at_ns: Option<i64>,
    withheld: u64,
}

impl Default for RateLimit {
    fn default() -> Self {
        Self {
            allowed: BURST,
            at_ns: None,
            withheld: 0,
        }
    }
}

impl RateLimit {
    /// Returns the number of lines withheld since the last permitted line, if another line is permitted at `now_ns`
    /// (monotonic, nanoseconds); `None` if it is withheld.
    pub fn ask(&mut self, now_ns: i64) -> Option<u64> {
        let passed_s = (now_ns - self.at_ns.unwrap_or(now_ns)) as f64 / messages::NS_PER_S;
        self.at_ns = Some(now_ns);
        self.allowed = (self.allowed + passed_s.max(0.0) * PER_S).min(BURST);
        if self.allowed < 1.0 {
            self.withheld += 1;
            return None;
        }
        self.allowed -= 1.0;
        Some(std::mem::take(&mut self.withheld))
    }
}

#[cfg(test)]
mod tests {
    use test_support::S;

    use super::*;

    #[test]
    fn a_burst_passes_and_then_one_a_second() {
        let mut limit = RateLimit::default();
        let passed: Vec<_> = (0..20).filter_map(|_| limit.ask(0)).collect();
        assert_eq!(passed, [0; BURST as usize]);
        assert_eq!(limit.ask(S), Some(12), "the line says how many are missing before it");
        assert_eq!(limit.ask(S), None);
        let later: Vec<_> = (0..20).filter_map(|_| limit.ask(100 * S)).collect();
        assert_eq!(later, [1, 0, 0, 0, 0, 0, 0, 0]);
    }
}
