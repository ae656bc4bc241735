//! The last lines of bearing, in bounded memory.
//!
//! Stored lines can be processed again if the emitter turns out to be at another place. But a direction finder may give
//! ten lines a second, and the platform may need minutes for a sufficient baseline. Therefore neighbouring lines are
//! merged if no information is lost: two bearings taken a distance s apart, of an emitter at range r, are as good as
//! the mean taken half-way, except for s²/8r² radians.

use kept::{Get, Kept, Put};

use crate::line_of_bearing::LineOfBearing;

/// Most lines of bearing that a filter keeps.
pub const WINDOW_MAX: usize = 64;

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

    /// Removes the first unused line; returns whether such a line existed.
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
            let merged = other.filter(|other| one.may_merge(other, position_m));
            self.lines[kept] = merged.map_or(one, |other| one.merged(&other));
            kept += 1;
            next += if merged.is_some() { 2 } else { 1 };
        }
        self.len = kept;
        before - kept
    }

    /// Merges each difference of arrival times with the next difference of the same receivers, wherever both fit the
    /// emitter's positions and the emitter's way in between is too short to lose information. Returns the number of
    /// freed places.
    pub(crate) fn merge_pairs(&mut self, position_at: impl Fn(i64) -> [f64; 2]) -> usize {
        let mut is_merged = [false; WINDOW_MAX];
        for place in 0..self.len {
            let one = self.lines[place];
            let is_next = |later: &usize| !is_merged[*later] && one.is_of_same_pair(&self.lines[*later]);
            let later = (place + 1..self.len).find(is_next).filter(|_| !is_merged[place]);
            if let Some(later) = later
                && one.may_merge_moving(&self.lines[later], &position_at)
            {
                self.lines[place] = one.merged(&self.lines[later]);
                is_merged[later] = true;
            }
        }
        let (before, mut kept) = (self.len, 0);
        for (place, is_merged) in is_merged[..before].iter().enumerate() {
            if *is_merged {
                continue;
            }
            // A merged line is later than the line formerly in this place.
            let line = self.lines[place];
            let first = self.lines[..kept].partition_point(|other| other.time_ns <= line.time_ns);
            self.lines.copy_within(first..kept, first + 1);
            self.lines[first] = line;
            kept += 1;
        }
        self.len = kept;
        before - kept
    }

    /// Corrects the differences of arrival times by the present estimate of the clocks: the lead of a clock over
    /// another at a time, and the variance, metres and m².
    pub(crate) fn set_clocks(&mut self, ahead: &impl Fn([u16; 2], i64) -> Option<(f64, f64)>) {
        for place in 0..self.len {
            let Some(numbers) = self.lines[place].clocks().map(|clocks| clocks.numbers) else {
                continue;
            };
            let all = self.all().iter().filter_map(LineOfBearing::clocks);
            let together: f64 = all
                .filter(|all| all.numbers == numbers)
                .map(|all| all.information)
                .sum();
            let line = &mut self.lines[place];
            if let Some((ahead_m, variance_m2)) = ahead(numbers, line.time_ns) {
                line.set_clocks(ahead_m, variance_m2, together);
            }
        }
    }

    fn remove(&mut self, place: usize) {
        self.lines.copy_within(place + 1..self.len, place);
        self.len -= 1;
    }
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
    use crate::line_of_bearing::{Ray, Shape};

    fn at(east_m: f64) -> LineOfBearing {
        LineOfBearing {
            time_ns: (east_m * 1e9) as i64,
            shape: Shape::Ray(Ray {
                platform_m: [east_m, 0.0],
                sine: 0.0,
                cosine: 1.0,
            }),
            information: 100.0,
            is_used: true,
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
        assert_eq!(far.all()[0].origin_m(), [5.0, 0.0]);
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
