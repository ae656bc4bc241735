//! The last lines of bearing, in bounded memory.
//!
//! Stored lines can be processed again if the emitter turns out to be at another place. But a direction finder may
//! give ten lines a second, and the platform may need minutes for a sufficient baseline. Therefore neighbouring lines
//! are merged if no information is lost: two bearings taken a distance s apart, of an emitter at range r, are as good
//! as their mean taken half-way, except for s²/8r² radians.

use kept::{Get, Kept, Put};

use crate::line_of_bearing::LineOfBearing;

/// Most lines of bearing that a filter keeps.
pub const WINDOW_MAX: usize = 64;
/// Largest bias that merging two lines may cause, in standard deviations of their mean.
const LOSS_MAX: f64 = 0.05;

/// Lines in the order of time.
#[derive(Clone, Debug)]
pub(crate) struct Window {
    lines: [LineOfBearing; WINDOW_MAX],
    len: usize,
}

impl Window {
    pub(crate) const EMPTY: Self = Self {
        lines: [LineOfBearing::NONE; WINDOW_MAX],
        len: 0,
    };

    pub(crate) fn all(&self) -> &[LineOfBearing] {
        &self.lines[..self.len]
    }

    pub(crate) fn is_full(&self) -> bool {
        self.len == WINDOW_MAX
    }

    /// Adds the latest; there must be room.
    pub(crate) fn push(&mut self, line: LineOfBearing) {
        debug_assert!(!self.is_full(), "the caller makes room");
        self.lines[self.len] = line;
        self.len += 1;
    }

    pub(crate) fn clear(&mut self) {
        self.len = 0;
    }

    /// Forgets the first `count`.
    pub(crate) fn forget_first(&mut self, count: usize) {
        self.lines.copy_within(count..self.len, 0);
        self.len -= count;
    }

    /// Removes the first unused line; returns whether there was one.
    pub(crate) fn forget_unused(&mut self) -> bool {
        let Some(place) = self.all().iter().position(|line| !line.is_used) else {
            return false;
        };
        self.remove(place);
        true
    }

    /// Lets all count.
    pub(crate) fn use_all(&mut self) {
        for line in &mut self.lines[..self.len] {
            line.is_used = true;
        }
    }

    /// Takes back the last `count`, and all since a time.
    pub(crate) fn take_back(&mut self, count: usize, since_ns: Option<i64>) {
        let first = self.len.saturating_sub(count);
        for (place, line) in self.lines[..self.len].iter_mut().enumerate() {
            if place >= first || since_ns.is_some_and(|since_ns| line.time_ns >= since_ns) {
                line.is_used = false;
            }
        }
    }

    /// Merges neighbours wherever this loses no information, with the emitter at `position_m` (`None`: unknown, then
    /// everywhere); returns the number of freed places.
    pub(crate) fn merge(&mut self, position_m: Option<[f64; 2]>) -> usize {
        let (before, mut kept, mut next) = (self.len, 0, 0);
        while next < before {
            let one = self.lines[next];
            let other = (next + 1 < before).then(|| self.lines[next + 1]);
            let merged = other.filter(|other| may_merge(&one, other, position_m));
            self.lines[kept] = merged.map_or(one, |other| one.merged(&other));
            kept += 1;
            next += if merged.is_some() { 2 } else { 1 };
        }
        self.len = kept;
        before - kept
    }

    fn remove(&mut self, place: usize) {
        self.lines.copy_within(place + 1..self.len, place);
        self.len -= 1;
    }
}

/// Returns whether the error of the mean is small beside its standard deviation.
fn may_merge(one: &LineOfBearing, other: &LineOfBearing, position_m: Option<[f64; 2]>) -> bool {
    if one.is_used != other.is_used {
        return false;
    }
    let Some(position_m) = position_m else { return true };
    let apart = one.squared_distance_m2(other.platform_m);
    let range = one
        .squared_distance_m2(position_m)
        .min(other.squared_distance_m2(position_m));
    let information = one.information + other.information;
    let limit = 8.0 * LOSS_MAX * range;
    apart * apart * information < limit * limit
}

impl Kept for Window {
    const WORDS: usize = <[LineOfBearing; WINDOW_MAX]>::WORDS + usize::WORDS;

    fn put(&self, to: &mut Put<'_>) {
        let Self { lines, len } = self;
        lines.put(to);
        len.put(to);
    }

    fn get(from: &mut Get<'_>) -> Option<Self> {
        let (lines, len) = (Kept::get(from)?, usize::get(from)?);
        (len <= WINDOW_MAX).then_some(Self { lines, len })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(east_m: f64) -> LineOfBearing {
        LineOfBearing {
            time_ns: (east_m * 1e9) as i64,
            platform_m: [east_m, 0.0],
            information: 100.0,
            is_used: true,
            ..LineOfBearing::NONE
        }
    }

    #[test]
    fn neighbours_become_one_where_nothing_is_lost() {
        let window = || {
            let mut window = Window::EMPTY;
            for east in [0.0, 10.0, 30.0, 4_000.0, 8_000.0] {
                window.push(at(east));
            }
            window
        };
        let mut far = window();
        assert_eq!(far.merge(Some([0.0, 1e3])), 1);
        assert_eq!(far.all()[0].platform_m, [5.0, 0.0]);
        assert_eq!(far.all()[0].information, 200.0);
        assert_eq!(far.all()[0].time_ns, 5_000_000_000);
        assert_eq!(far.all()[3], at(8_000.0));
        // Near an emitter no two are alike.
        assert_eq!(window().merge(Some([20.0, 5.0])), 0);
        // With an unknown position, all neighbours are merged.
        assert_eq!(window().merge(None), 2);
    }

    #[test]
    fn what_does_not_count_is_forgotten_first() {
        let mut window = Window::EMPTY;
        for east in [0.0, 1.0, 2.0] {
            window.push(at(east));
        }
        window.take_back(1, Some(1_000_000_000));
        assert!(window.forget_unused() && window.forget_unused() && !window.forget_unused());
        assert_eq!(window.all(), [at(0.0)]);
    }
}
