//! The last sightings, in bounded memory.
//!
//! Sightings that are kept can be looked at again when the emitter turns out to be somewhere else than was thought. A
//! direction finder may give ten a second, though, and it may take minutes until the platform has flown far enough. So
//! neighbours become one where nothing is lost by it: two bearings taken a distance s apart, of an emitter at range r,
//! are as good as their mean taken half-way, but for s²/8r² radians.

use crate::sighting::Sighting;

/// Most sightings that a filter keeps.
pub const WINDOW_MAX: usize = 64;
/// An error of the mean of so much of its standard deviation is none.
const LOSS_MAX: f64 = 0.1;

/// Sightings in the order of time.
#[derive(Clone, Debug)]
pub(crate) struct Window {
    sightings: [Sighting; WINDOW_MAX],
    len: usize,
}

impl Window {
    pub(crate) const EMPTY: Self = Self {
        sightings: [Sighting::NONE; WINDOW_MAX],
        len: 0,
    };

    pub(crate) fn all(&self) -> &[Sighting] {
        &self.sightings[..self.len]
    }

    pub(crate) fn is_full(&self) -> bool {
        self.len == WINDOW_MAX
    }

    /// Adds the latest; there must be room.
    pub(crate) fn push(&mut self, sighting: Sighting) {
        debug_assert!(!self.is_full(), "the caller makes room");
        self.sightings[self.len] = sighting;
        self.len += 1;
    }

    pub(crate) fn clear(&mut self) {
        self.len = 0;
    }

    /// Forgets the first `count`.
    pub(crate) fn forget_first(&mut self, count: usize) {
        self.sightings.copy_within(count..self.len, 0);
        self.len -= count;
    }

    /// Forgets the first that does not count; whether there was one.
    pub(crate) fn forget_unused(&mut self) -> bool {
        let Some(place) = self.all().iter().position(|sighting| !sighting.is_used) else {
            return false;
        };
        self.remove(place);
        true
    }

    /// Says of the last `count` whether they count.
    pub(crate) fn use_last(&mut self, count: usize, is_used: bool) {
        let first = self.len.saturating_sub(count);
        for sighting in &mut self.sightings[first..self.len] {
            sighting.is_used = is_used;
        }
    }

    /// Makes one of two neighbours: those by which least is lost, where the emitter is at `position_m` (`None`: anywhere,
    /// then those nearest to each other). Whether that was without loss; if not, and not `at_any_loss`, nothing is done.
    pub(crate) fn merge(&mut self, position_m: Option<[f64; 2]>, at_any_loss: bool) -> bool {
        let mut best: Option<(f64, usize)> = None;
        for (place, pair) in self.all().windows(2).enumerate() {
            let loss = loss(&pair[0], &pair[1], position_m);
            if best.is_none_or(|(least, _)| loss < least) {
                best = Some((loss, place));
            }
        }
        let Some((loss, place)) = best else { return false };
        let is_lossless = position_m.is_none() || loss < LOSS_MAX;
        if is_lossless || at_any_loss {
            self.sightings[place] = self.sightings[place].merged(&self.sightings[place + 1]);
            self.remove(place + 1);
        }
        is_lossless
    }

    fn remove(&mut self, place: usize) {
        self.sightings.copy_within(place + 1..self.len, place);
        self.len -= 1;
    }
}

/// Error of the mean over its standard deviation; without a place, squared distance times information.
fn loss(one: &Sighting, other: &Sighting, position_m: Option<[f64; 2]>) -> f64 {
    if one.is_used != other.is_used {
        return f64::MAX;
    }
    let apart = one.distance_m(other.platform_m);
    let information = one.information + other.information;
    match position_m {
        Some(position_m) => {
            let range = one.distance_m(position_m).min(other.distance_m(position_m));
            apart * apart / (8.0 * range * range).max(f64::MIN_POSITIVE) * information.sqrt()
        }
        None => apart * apart * information,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(east_m: f64) -> Sighting {
        Sighting {
            time_ns: (east_m * 1e9) as i64,
            platform_m: [east_m, 0.0],
            information: 100.0,
            is_used: true,
            ..Sighting::NONE
        }
    }

    #[test]
    fn neighbours_become_one_where_nothing_is_lost() {
        let mut window = Window::EMPTY;
        for east in [0.0, 100.0, 110.0, 300.0] {
            window.push(at(east));
        }
        assert!(window.merge(Some([0.0, 10e3]), false));
        assert_eq!(window.all().len(), 3);
        assert_eq!(window.all()[1].platform_m, [105.0, 0.0]);
        assert_eq!(window.all()[1].information, 200.0);
        assert_eq!(window.all()[1].time_ns, 105_000_000_000);
        // Near an emitter no two are alike.
        assert!(!window.merge(Some([100.0, 50.0]), false));
        assert_eq!(window.all().len(), 3);
        assert!(!window.merge(Some([100.0, 50.0]), true));
        assert_eq!(window.all().len(), 2);
    }

    #[test]
    fn what_does_not_count_is_forgotten_first() {
        let mut window = Window::EMPTY;
        for east in [0.0, 1.0, 2.0] {
            window.push(at(east));
        }
        window.use_last(2, false);
        assert!(window.forget_unused() && window.forget_unused() && !window.forget_unused());
        assert_eq!(window.all(), [at(0.0)]);
    }
}
