//! Limits by which a run is judged.
//!
//! Time limits hold for a machine without other work; a margin extends them for a loaded machine. The margin is an
//! argument of the command and part of every result, so that an extended limit is always recognisable.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Median, 99 % and worst of a set of values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Spread {
    pub(crate) median: f64,
    pub(crate) p99: f64,
    pub(crate) worst: f64,
}

impl Spread {
    /// Spread of these values; `None` if there are none.
    pub(crate) fn of(values: &[f64]) -> Option<Self> {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let at = |share: f64| Some(sorted[((share * sorted.len() as f64) as usize).min(sorted.len().checked_sub(1)?)]);
        Some(Self {
            median: at(0.5)?,
            p99: at(0.99)?,
            worst: at(1.0)?,
        })
    }

    fn times(self, factor: f64) -> Self {
        Self {
            median: factor * self.median,
            p99: factor * self.p99,
            worst: factor * self.worst,
        }
    }
}

impl fmt::Display for Spread {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            out,
            "median {:.2}, 99 % {:.2}, worst {:.2}",
            self.median, self.p99, self.worst
        )
    }
}

/// Outage of a target at a fault, seconds, in which the second or so between two of its reports is included.
const OUTAGE_S: Spread = Spread {
    median: 2.0,
    p99: 4.0,
    worst: 8.0,
};
/// Outage of a target at a fault where a second fusion stands by, seconds.
const OUTAGE_WITH_STANDBY_S: Spread = Spread {
    median: 1.5,
    p99: 3.0,
    worst: 6.0,
};
/// Outage where the whole deployment starts again, seconds.
const REBUILD_S: f64 = 15.0;
/// Time for which a target may have two tracks, seconds.
const TWO_TRACKS_S: f64 = 10.0;
/// Time after which a silent track counts as forgotten, beyond that after which it has to end, seconds.
const FORGOTTEN_S: f64 = 10.0;
/// Error of a position in the plane, metres, which no machine's load excuses.
const POSITION_M: f64 = 300.0;

/// Limits, with the margin in them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Limits {
    pub(crate) margin: f64,
    pub(crate) outage_s: Spread,
    pub(crate) rebuild_s: f64,
    pub(crate) two_tracks_s: f64,
    pub(crate) silent_track_s: f64,
    pub(crate) position_m: f64,
}

impl Limits {
    /// Returns the limits of a deployment with or without a standby; its tracks end after `terminate_s` without a
    /// report.
    pub(crate) fn new(standby: bool, terminate_s: f64, margin: f64) -> Self {
        let outage_s = if standby { OUTAGE_WITH_STANDBY_S } else { OUTAGE_S };
        Self {
            margin,
            outage_s: outage_s.times(margin),
            rebuild_s: margin * REBUILD_S,
            two_tracks_s: margin * TWO_TRACKS_S,
            silent_track_s: terminate_s + margin * FORGOTTEN_S,
            position_m: POSITION_M,
        }
    }
}

impl fmt::Display for Limits {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            out,
            "outage of a target {} s, at a rebuild {:.1} s; two tracks of a target {:.1} s; silent track {:.1} s; \
             position {:.0} m (times include a margin of {} for the machine's other work)",
            self.outage_s, self.rebuild_s, self.two_tracks_s, self.silent_track_s, self.position_m, self.margin
        )
    }
}
