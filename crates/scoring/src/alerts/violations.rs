//! What happens in the truth: pairs of targets nearer than the minima, and targets inside areas.
//!
//! Between two seconds, targets move along straight lines, so that a pair is nearer than the minima from a root of a
//! quadratic equation to the other one. An area is entered where its border is crossed, found by halving. Violations
//! of the same subject with less than half a minute between them are one.
//!
//! A target is a ship if its whole truth is below 100 m and slower than 35 m/s, else an aircraft. Aircraft on the
//! ground, and two ships that lie still, violate no minimum. An aircraft and a ship have none.
//!
//! Limits: a corner of an area that is cut within a second is not seen. Flight levels are heights above the ellipsoid
//! in hundreds of feet, and the ellipsoid is the mean sea level: a simulated atmosphere and sea are no others.

use std::collections::{BTreeMap, BTreeSet};

use areas::{Area, Level, below};
use frames::SystemFrame;

use super::{APPROACH, CONFLICT, ENTER, FOOT_M, Minima};
use crate::near::near_pairs;
use crate::picture::{Timeline, TimelinePass};
use crate::states::KinematicState;

/// Longest time between two violations that are one, seconds.
const SAME_S: f64 = 30.0;
/// What a distance must be below a minimum, metres: decimals in files are rounded.
const ROUNDING_M: f64 = 0.01;
/// Flight level 410, metres: above it, the vertical minimum is the greater one.
const HIGH_M: f64 = 41_000.0 * FOOT_M;
/// Greatest height and speed of ships, metres and m/s.
const SHIP_HEIGHT_M: f64 = 100.0;
const SHIP_SPEED_MPS: f64 = 35.0;
/// Height up to which an aircraft is on the ground, metres.
const GROUND_M: f64 = 10.0;
/// Speed up to which a ship lies still, m/s: one knot.
const STILL_MPS: f64 = 1852.0 / 3600.0;
/// Rounds of halving a second.
const HALVINGS: u32 = 20;

/// What violates: a target or a pair of targets, and perhaps an area by its place in the list.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Subject {
    pub(super) kind: &'static str,
    pub(super) one: i64,
    pub(super) other: Option<i64>,
    pub(super) area: Option<usize>,
}

impl Subject {
    pub(super) fn pair(kind: &'static str, one: i64, other: i64) -> Self {
        Self {
            kind,
            one: one.min(other),
            other: Some(one.max(other)),
            area: None,
        }
    }

    pub(super) fn targets(&self) -> impl Iterator<Item = i64> + use<> {
        [Some(self.one), self.other].into_iter().flatten()
    }
}

/// Time of a violation, seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Violation {
    pub(super) begins_s: f64,
    pub(super) ends_s: f64,
}

impl Violation {
    pub(super) fn is_within(&self, from_s: f64, to_s: f64) -> bool {
        self.begins_s <= to_s && self.ends_s >= from_s
    }
}

/// Everything that happens in a truth.
#[derive(Debug, Default)]
pub(super) struct Violations {
    by_subject: BTreeMap<Subject, Vec<Violation>>,
    /// Last second of each target.
    ends_s: BTreeMap<i64, i64>,
    ships: BTreeSet<i64>,
    pub(super) area_names: Vec<String>,
}

/// A target at a second.
#[derive(Clone, Copy, Debug)]
struct Placed {
    id: i64,
    position_m: [f64; 3],
    height_m: f64,
    speed_mps: f64,
}

impl Violations {
    pub(super) fn of(
        truth: &Timeline,
        (first_s, last_s): (i64, i64),
        frame: Option<&SystemFrame>,
        minima: &Minima,
        areas: &[Area],
    ) -> Self {
        let mut found = Self {
            area_names: areas.iter().map(|area| area.name.clone()).collect(),
            ..Self::default()
        };
        found.find_ships(truth, (first_s, last_s), frame);
        let mut pass = TimelinePass::new(truth);
        let mut before: Vec<Placed> = Vec::new();
        for second in first_s..=last_s {
            let now: Vec<Placed> = pass.at(second).iter().map(|state| Placed::of(state, frame)).collect();
            found.ends_s.extend(now.iter().map(|target| (target.id, second)));
            let moves = moves(&before, &now);
            let begin_s = (second - 1) as f64;
            found.add_pairs(&moves, begin_s, minima);
            found.add_areas(&moves, begin_s, frame, areas);
            before = now;
        }
        found
    }

    fn find_ships(&mut self, truth: &Timeline, (first_s, last_s): (i64, i64), frame: Option<&SystemFrame>) {
        let mut is_ship: BTreeMap<i64, bool> = BTreeMap::new();
        let mut pass = TimelinePass::new(truth);
        for second in first_s..=last_s {
            for target in pass.at(second).iter().map(|state| Placed::of(state, frame)) {
                let is_low = target.height_m < SHIP_HEIGHT_M && target.speed_mps < SHIP_SPEED_MPS;
                *is_ship.entry(target.id).or_insert(true) &= is_low;
            }
        }
        self.ships = is_ship
            .into_iter()
            .filter_map(|(id, is_ship)| is_ship.then_some(id))
            .collect();
    }

    fn add_pairs(&mut self, moves: &[[Placed; 2]], begin_s: f64, minima: &Minima) {
        let way_m = |[from, to]: &[Placed; 2]| {
            let [east, north] = [0, 1].map(|axis| to.position_m[axis] - from.position_m[axis]);
            east.hypot(north)
        };
        let farthest_m = moves.iter().map(way_m).fold(0.0, f64::max);
        for (kind, minimum_m) in [(CONFLICT, minima.horizontal_m), (APPROACH, minima.ships_m)] {
            let of_kind = |target: &Placed| match kind {
                APPROACH => self.ships.contains(&target.id),
                _ => !self.ships.contains(&target.id) && target.height_m > GROUND_M,
            };
            let moves: Vec<[Placed; 2]> = moves.iter().filter(|[from, _]| of_kind(from)).copied().collect();
            let places: Vec<[f64; 2]> = moves.iter().map(|[from, _]| plane(from)).collect();
            for pair in near_pairs(&places, &places, minimum_m + 2.0 * farthest_m) {
                let (one, other) = (&moves[pair.target], &moves[pair.track]);
                if one[0].id < other[0].id
                    && let Some([from, to]) = violated(kind, one, other, minima)
                {
                    let subject = Subject::pair(kind, one[0].id, other[0].id);
                    self.add(subject, begin_s + from, begin_s + to);
                }
            }
        }
    }

    fn add_areas(&mut self, moves: &[[Placed; 2]], begin_s: f64, frame: Option<&SystemFrame>, areas: &[Area]) {
        // East and north on the ground below, and height.
        let below = |target: &Placed| {
            let [east_m, north_m] = frame.map_or(plane(target), |frame| below(frame, target.position_m));
            [east_m, north_m, target.height_m]
        };
        for [from, to] in moves.iter().filter(|_| !areas.is_empty()) {
            let ends = [from, to].map(below);
            for (place, area) in areas.iter().enumerate() {
                let on_way = |share: f64| [0, 1, 2].map(|axis| ends[0][axis] + share * (ends[1][axis] - ends[0][axis]));
                let at = |share: f64| is_inside(area, on_way(share));
                let (begins, ends) = match (at(0.0), at(1.0)) {
                    (false, false) => continue,
                    (true, true) => (0.0, 1.0),
                    (false, true) => (crossing(&at), 1.0),
                    (true, false) => (0.0, crossing(&at)),
                };
                let subject = Subject {
                    kind: ENTER,
                    one: from.id,
                    other: None,
                    area: Some(place),
                };
                self.add(subject, begin_s + begins, begin_s + ends);
            }
        }
    }

    fn add(&mut self, subject: Subject, begins_s: f64, ends_s: f64) {
        let of_subject = self.by_subject.entry(subject).or_default();
        match of_subject.last_mut() {
            Some(last) if begins_s - last.ends_s < SAME_S => last.ends_s = ends_s,
            _ => of_subject.push(Violation { begins_s, ends_s }),
        }
    }

    /// Number of targets.
    pub(super) fn targets(&self) -> u64 {
        self.ends_s.len() as u64
    }

    /// Every violation of a kind, by subject and time.
    pub(super) fn of_kind(&self, kind: &str) -> impl Iterator<Item = (Subject, Violation)> {
        let subjects = self.by_subject.iter().filter(move |(subject, _)| subject.kind == kind);
        subjects.flat_map(|(subject, all)| all.iter().map(move |violation| (*subject, *violation)))
    }

    /// The violations of a subject in a time, seconds, with their places.
    pub(super) fn within(&self, subject: &Subject, from_s: f64, to_s: f64) -> impl Iterator<Item = Violation> {
        let all = self.by_subject.get(subject).into_iter().flatten();
        all.filter(move |violation| violation.is_within(from_s, to_s)).copied()
    }

    /// Last second for which the truth has all targets of a subject.
    pub(super) fn end_s(&self, subject: &Subject) -> f64 {
        let ends = subject.targets().filter_map(|target| self.ends_s.get(&target));
        ends.min().map_or(f64::NEG_INFINITY, |second| *second as f64)
    }
}

impl Placed {
    fn of(state: &KinematicState<3>, frame: Option<&SystemFrame>) -> Self {
        let (position_m, velocity_mps) = (state.position_m, state.velocity_mps);
        Self {
            id: state.id,
            position_m,
            height_m: frame.map_or(position_m[2], |frame| frame.vertical(position_m, velocity_mps).height_m),
            speed_mps: state.velocity_mps[0].hypot(state.velocity_mps[1]),
        }
    }
}

/// From one second to the next, of the targets that both have; both are in the order of numbers.
fn moves(before: &[Placed], now: &[Placed]) -> Vec<[Placed; 2]> {
    let from = |to: &Placed| before.binary_search_by_key(&to.id, |from| from.id).ok();
    now.iter().filter_map(|to| Some([before[from(to)?], *to])).collect()
}

fn plane(target: &Placed) -> [f64; 2] {
    [target.position_m[0], target.position_m[1]]
}

fn is_inside(area: &Area, [east_m, north_m, height_m]: [f64; 3]) -> bool {
    let level_m = |level: Level| match level {
        Level::Flight(level) => 100.0 * FOOT_M * level,
        Level::Sea(height_m) => height_m,
    };
    area.limits.floor.is_none_or(|floor| height_m >= level_m(floor))
        && area.limits.ceiling.is_none_or(|ceiling| height_m <= level_m(ceiling))
        && area.outline.contains([east_m, north_m])
}

/// Share of the second at which `is_inside` changes.
fn crossing(is_inside: &impl Fn(f64) -> bool) -> f64 {
    let (begin, mut low, mut high) = (is_inside(0.0), 0.0, 1.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        match is_inside(middle) == begin {
            true => low = middle,
            false => high = middle,
        }
    }
    high
}

/// Part of a second in which two targets are nearer than the minima.
fn violated(kind: &str, one: &[Placed; 2], other: &[Placed; 2], minima: &Minima) -> Option<[f64; 2]> {
    let apart_m = [0, 1].map(|end| [0, 1].map(|axis| other[end].position_m[axis] - one[end].position_m[axis]));
    if kind == APPROACH {
        let moves = one[0].speed_mps.max(other[0].speed_mps) > STILL_MPS;
        return nearer(apart_m, minima.ships_m - ROUNDING_M).filter(|_| moves);
    }
    let high = one[0].height_m.max(other[0].height_m) > HIGH_M;
    let vertical_m = if high {
        minima.vertical_high_m
    } else {
        minima.vertical_m
    };
    let heights_m = [0, 1].map(|end| [other[end].height_m - one[end].height_m, 0.0]);
    let in_plane = nearer(apart_m, minima.horizontal_m - ROUNDING_M)?;
    let vertical = nearer(heights_m, vertical_m - ROUNDING_M)?;
    let both = [in_plane[0].max(vertical[0]), in_plane[1].min(vertical[1])];
    (both[0] < both[1]).then_some(both)
}

/// Part of a straight way, as shares of it, nearer than a distance to the origin.
fn nearer([from, to]: [[f64; 2]; 2], distance_m: f64) -> Option<[f64; 2]> {
    let way = [to[0] - from[0], to[1] - from[1]];
    let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
    // |from + s way|² = distance²: a s² + 2 b s + c = 0.
    let (a, b, c) = (dot(way, way), dot(from, way), dot(from, from) - distance_m * distance_m);
    if a == 0.0 {
        return (c < 0.0).then_some([0.0, 1.0]);
    }
    let root = b * b - a * c;
    if root <= 0.0 {
        return None;
    }
    let shares = [(-b - root.sqrt()) / a, (-b + root.sqrt()) / a];
    let part = [shares[0].max(0.0), shares[1].min(1.0)];
    (part[0] < part[1]).then_some(part)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn the_near_part_of_a_way_is_that_of_many_points(
            from in prop::array::uniform2(-20.0..20.0f64), to in prop::array::uniform2(-20.0..20.0f64),
            distance_m in 0.5..15.0f64,
        ) {
            let part = nearer([from, to], distance_m);
            for step in 0..=200 {
                let share = f64::from(step) / 200.0;
                let [x, y] = [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]));
                // On the border either is right.
                if (x.hypot(y) - distance_m).abs() > 1e-9 {
                    let is_in = part.is_some_and(|[first, last]| (first..=last).contains(&share));
                    prop_assert_eq!(is_in, x.hypot(y) < distance_m, "{:?} {}", part, share);
                }
            }
        }
    }
}
