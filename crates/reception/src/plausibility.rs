//! Telling impossible values from surprising ones.
//!
//! A transponder with a latitude of −71° at Barcelona, a decoder that swaps two tracks, a clock that jumps: such
//! values must not reach fusion. But a first report, or a report after a long gap, may correctly be far from all
//! earlier reports. Therefore one report never causes the rejection of its *successors*: the rejected report is kept,
//! and if the next reports agree with the rejected report rather than with the earlier reports, the earlier reports
//! are discarded.

use messages::Counter;

use super::PlausibilityLimits;
use super::alert_memory::AlertMemory;
use super::velocity::Positions;

/// Refused reports in a row that agree with each other before they are believed.
const AGREEING: u32 = 3;

/// Memory of one track.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct TrackMemory {
    pub(crate) positions: Positions,
    pub(crate) last_position_m: [f64; 3],
    /// Time (UTC, nanoseconds) and height (metres) of the last report that had one.
    pub(crate) last_height: Option<(i64, f64)>,
    /// Time (UTC, nanoseconds) of the level that the transponder stated last, and that level.
    pub(crate) last_level: Option<(i64, i16)>,
    pub(crate) alerts: AlertMemory,
    refused: Option<(i64, [f64; 2])>,
    agreeing: u32,
}

impl TrackMemory {
    /// Whether the track may have got to `position` at `time_ns`; remembers it if so.
    pub(crate) fn accepts(&mut self, limits: &PlausibilityLimits, time_ns: i64, position: [f64; 2]) -> bool {
        if reachable(limits, self.positions.newest(), time_ns, position) {
            self.refused = None;
            self.agreeing = 0;
            self.positions.push(time_ns, position);
            return true;
        }
        let agrees = self.refused.is_some() && reachable(limits, self.refused, time_ns, position);
        self.agreeing = if agrees { self.agreeing + 1 } else { 1 };
        self.refused = Some((time_ns, position));
        if self.agreeing < AGREEING {
            return false;
        }
        self.refused = None;
        self.agreeing = 0;
        self.positions.clear();
        self.positions.push(time_ns, position);
        true
    }
}

fn reachable(limits: &PlausibilityLimits, from: Option<(i64, [f64; 2])>, time_ns: i64, to: [f64; 2]) -> bool {
    let Some((from_ns, from)) = from else { return true };
    let seconds = (time_ns - from_ns).abs() as f64 / messages::NS_PER_S;
    (to[0] - from[0]).hypot(to[1] - from[1]) <= limits.speed_mps * seconds + limits.jump_m
}

/// The source's running time: refuses stamps that lie far from it, unless the source insists.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TimeCheck {
    refused_ns: Option<i64>,
}

impl TimeCheck {
    pub(crate) fn new() -> Self {
        Self { refused_ns: None }
    }

    /// Checks `time_ns` against the running time. Two stamps in a row that agree with each other are believed: there
    /// was a gap.
    pub(crate) fn check(&mut self, limits: &PlausibilityLimits, running_ns: i64, time_ns: i64) -> Result<(), Counter> {
        let near = |other: i64| (time_ns - other).abs() <= limits.running_step().ns();
        let insists = time_ns > running_ns && self.refused_ns.is_some_and(near);
        if near(running_ns) || insists {
            self.refused_ns = None;
            return Ok(());
        }
        self.refused_ns = Some(time_ns);
        Err(Counter::RejectedTime)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use test_support::S;

    fn limits() -> PlausibilityLimits {
        PlausibilityLimits {
            range_m: 1e5,
            height_min_m: -500.0,
            height_max_m: 2e4,
            speed_mps: 100.0,
            jump_m: 50.0,
            time_step_s: Some(settings::Seconds::of(10.0)),
            tracks: 10,
        }
    }

    #[test]
    fn a_single_outlier_is_refused_and_a_real_move_is_believed() {
        let (limits, mut memory) = (limits(), TrackMemory::default());
        assert!(memory.accepts(&limits, 0, [0.0, 0.0]));
        assert!(!memory.accepts(&limits, S, [5000.0, 0.0]));
        assert!(memory.accepts(&limits, 2 * S, [150.0, 0.0]), "the track itself goes on");
        for second in 3..5 {
            assert!(!memory.accepts(&limits, second * S, [9000.0, 0.0]));
        }
        assert!(memory.accepts(&limits, 5 * S, [9100.0, 0.0]), "three that agree");
        assert!(memory.accepts(&limits, 6 * S, [9200.0, 0.0]));
    }

    #[test]
    fn scattered_outliers_are_never_believed() {
        let (limits, mut memory) = (limits(), TrackMemory::default());
        assert!(memory.accepts(&limits, 0, [0.0, 0.0]));
        for step in 1..20 {
            assert!(!memory.accepts(&limits, step * S / 10, [1e4 * step as f64, 0.0]));
        }
    }

    #[test]
    fn a_time_far_off_is_refused_once_and_a_gap_is_believed() {
        let (limits, mut check) = (limits(), TimeCheck::new());
        assert_eq!(check.check(&limits, 100 * S, 105 * S), Ok(()));
        assert_eq!(check.check(&limits, 105 * S, 400 * S), Err(Counter::RejectedTime));
        assert_eq!(
            check.check(&limits, 105 * S, 106 * S),
            Ok(()),
            "the outlier is forgotten"
        );
        assert_eq!(check.check(&limits, 106 * S, 400 * S), Err(Counter::RejectedTime));
        assert_eq!(check.check(&limits, 106 * S, 401 * S), Ok(()));
        assert_eq!(check.check(&limits, 401 * S, 5 * S), Err(Counter::RejectedTime));
        assert_eq!(
            check.check(&limits, 401 * S, 6 * S),
            Err(Counter::RejectedTime),
            "time does not run backwards"
        );
    }
}
