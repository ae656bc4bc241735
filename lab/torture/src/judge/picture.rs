//! The picture at each second: the set of tracks against the targets of the world, and against the run without faults.
//!
//! A second is judged a moment later, from the newest states whose reference time is not later. Each track is moved
//! along the track's velocity to the second. A track with an address belongs to the target of the address; a track
//! without an address belongs to the nearest target without a track. Any remaining track is a second track of a target,
//! or a track without a target.
//!
//! Single states are judged on arrival ([`Picture::take`]): a state between two seconds is shown too.

use std::collections::{BTreeMap, VecDeque};

use super::allowances::Allowances;
use super::event::{Life, Second, State, Target, Undisturbed};
use super::finding::{Finding, Findings};
use super::limits::{
    GRACE_S, LASTING, LASTING_S, LATE_S, LONG, LONG_S, NEAR_M, RATE, RATE_S, RATE_STATES, REPEATS, SAME_M, SETTLED_S,
    SINGLE, Spread, WHOLE_MEDIAN, WHOLE_P95, WHOLE_RATE, WHOLE_S,
};
use super::world::{Kinematics, SECOND_NS, World, distance, moved};

/// Errors: position in the plane, height, velocity in the plane.
type Errors = [f64; 3];
const KINDS: [(Finding, &str); 3] = [
    (Finding::Position, "m"),
    (Finding::Height, "m in height"),
    (Finding::Velocity, "m/s"),
];
/// Time in which a target's greatest age and error without faults are looked for, seconds.
const RECENT_S: usize = 10;
/// Errors without faults are summarised anew after so many seconds.
const NORMAL_EVERY_S: u32 = 10;

/// See the module's documentation.
#[derive(Clone, Debug)]
pub(crate) struct Picture {
    world: World,
    begin_mono_ns: i64,
    period_s: f64,
    next: u32,
    tracks: BTreeMap<u32, Track>,
    watches: BTreeMap<u32, Watch>,
    normal: Normal,
    whole: VecDeque<[Vec<Errors>; 2]>,
    is_whole_off: bool,
    errors: [Vec<f64>; 2],
    /// States of all targets in the latest seconds, and states without faults.
    rates: [u32; 2],
    is_rate_off: bool,
    pub(crate) counts: Counts,
}

/// Sums over all judged seconds.
#[derive(Clone, Copy, Debug, Default, serde::Serialize)]
pub(crate) struct Counts {
    pub(crate) seconds: u32,
    /// Targets that were to be shown, were not, and tracks too many: each times seconds.
    pub(crate) targets_s: u64,
    pub(crate) missing_s: u64,
    pub(crate) double_s: u64,
    pub(crate) ghosts_s: u64,
}

/// States of a track since the latest judged second, and the newest before.
#[derive(Clone, Debug, Default)]
struct Track {
    states: VecDeque<State>,
    /// Reference time of the latest state of a report.
    reported_ns: Option<i64>,
    /// Time since which this track has been a track without a target.
    ghost_since: Option<u32>,
    /// States that repeated the one before, and states in a row since then that did not.
    repeats: u32,
    others: u32,
}

/// A target.
#[derive(Clone, Debug, Default)]
struct Watch {
    /// The target in the run without faults, newest last.
    normal: VecDeque<Undisturbed>,
    /// Newest reference time of any track of the target.
    newest_ns: Option<i64>,
    is_missing: bool,
    /// Time since which the target has had a second track.
    double_since: Option<u32>,
    /// Errors of the latest seconds, and errors without faults.
    errors: VecDeque<[Errors; 2]>,
    is_off: [bool; 3],
    /// Whether the target's track had no address, no height or no velocity, and since when.
    lacks_since: [Option<u32>; 3],
    /// States in each of the latest seconds.
    states: VecDeque<u32>,
    came: u32,
    is_rate_off: bool,
}

/// Errors of the run without faults so far, over all targets.
#[derive(Clone, Debug, Default)]
struct Normal {
    errors: [Vec<f64>; 3],
    median: Errors,
    p95: Errors,
}

impl Normal {
    fn take(&mut self, second: &Second) {
        for seen in second.targets.iter().filter_map(|target| target.undisturbed) {
            for (all, error) in self.errors.iter_mut().zip(seen.errors) {
                all.push(error);
            }
        }
        if second.second <= SETTLED_S || second.second.is_multiple_of(NORMAL_EVERY_S) {
            let spreads = [0, 1, 2].map(|kind| Spread::of(&self.errors[kind]).unwrap_or_default());
            (self.median, self.p95) = (spreads.map(|spread| spread.median), spreads.map(|spread| spread.p95));
        }
    }
}

impl Picture {
    pub(crate) fn new([begin_mono_ns, begin_utc_ns]: [i64; 2], period_s: f64) -> Self {
        Self {
            world: World::new(begin_utc_ns),
            begin_mono_ns,
            period_s,
            next: SETTLED_S,
            tracks: BTreeMap::new(),
            watches: BTreeMap::new(),
            normal: Normal::default(),
            whole: VecDeque::from([Default::default()]),
            is_whole_off: false,
            errors: Default::default(),
            rates: [0; 2],
            is_rate_off: false,
            counts: Counts::default(),
        }
    }

    /// Takes a second of the world, before the second begins.
    pub(crate) fn know(&mut self, second: &Second) {
        self.normal.take(second);
        for target in &second.targets {
            let watch = self.watches.entry(target.address).or_default();
            if watch.normal.len() == LONG_S {
                watch.normal.pop_front();
            }
            match target.undisturbed {
                Some(seen) => watch.normal.push_back(seen),
                None => watch.normal.clear(),
            }
        }
        self.world.take(second);
    }

    /// A newer fusion does not go on with the tracks of the previous fusion.
    pub(crate) fn begin_anew(&mut self) {
        self.tracks.clear();
    }

    /// Takes a state.
    pub(crate) fn take(&mut self, state: &State, findings: &mut Findings) {
        if !self.world.is_known() {
            return;
        }
        if let (Life::Confirmed | Life::Coasted, Some(place_m)) = (state.life, state.position_m) {
            self.judge_state(state, place_m, findings);
            if let Some(watch) = state.address.and_then(|address| self.watches.get_mut(&address)) {
                watch.newest_ns = watch.newest_ns.max(Some(state.time_ns));
            }
        }
        let track = self.tracks.entry(state.number).or_default();
        let repeats = |before: &State| {
            let content = |state: &State| (state.time_ns, state.position_m, state.life, state.of_report);
            content(before) == content(state)
        };
        if track.states.back().is_some_and(repeats) {
            (track.repeats, track.others) = (track.repeats + 1, 0);
            if track.repeats == REPEATS {
                findings.add(Finding::Repeated, || format!("states of {}", state.number));
            }
        } else {
            track.others += 1;
            if track.others == REPEATS {
                track.repeats = 0;
            }
        }
        if state.of_report {
            track.reported_ns = Some(state.time_ns);
            if let Some(watch) = state.address.and_then(|address| self.watches.get_mut(&address)) {
                watch.came += u32::from(!state.of_locator);
            }
        }
        track.states.push_back(state.clone());
    }

    /// Judges a state against the truth at its reference time.
    fn judge_state(&mut self, state: &State, place_m: [f64; 3], findings: &mut Findings) {
        let Some(address) = state.address else { return };
        if !self.watches.contains_key(&address) {
            return findings.add(Finding::Ghost, || {
                format!("{} has the address {address:06X}", state.number)
            });
        }
        if state.time_ns < self.world.utc_ns(SETTLED_S) {
            return;
        }
        let Some(truth) = self.world.target_at(address, state.time_ns) else {
            return;
        };
        let errors = errors(place_m, state, &truth);
        let limits = self.limits_of_state(address, state, &truth);
        for (kind, (finding, unit)) in KINDS.into_iter().enumerate() {
            if errors[kind].is_some_and(|error| error > limits[kind]) {
                let (error, limit) = (errors[kind].unwrap_or_default(), limits[kind]);
                findings.add(finding, || {
                    format!("{address:06X} is shown {error:.0} {unit} off in a state (limit {limit:.0})")
                });
            }
        }
    }

    /// Limits of a single state: a ratio to the errors without faults, and the target's motion since the latest report,
    /// which is unobservable.
    fn limits_of_state(&self, address: u32, state: &State, truth: &Kinematics) -> Errors {
        let recent = |kind: usize| {
            let seen = self
                .watches
                .get(&address)
                .map(|watch| watch.normal.iter().rev().take(RECENT_S));
            seen.into_iter()
                .flatten()
                .map(|seen| seen.errors[kind])
                .fold(0.0, f64::max)
        };
        let mut limits = [0, 1, 2].map(|kind| SINGLE * self.normal.p95[kind] + 2.0 * recent(kind));
        let reported_ns = self.tracks.get(&state.number).and_then(|track| track.reported_ns);
        let before = reported_ns.and_then(|then_ns| Some((then_ns, self.world.target_at(address, then_ns)?)));
        if let Some((then_ns, then)) = before {
            let seconds = (state.time_ns - then_ns).max(0) as f64 / 1e9;
            let foreseen_m = moved(then.position_m, then.velocity_mps, seconds);
            limits[0] += distance(foreseen_m, truth.position_m) + self.normal.p95[2] * seconds;
            limits[1] += (foreseen_m[2] - truth.position_m[2]).abs() + self.normal.p95[1] * seconds;
            limits[2] += distance(then.velocity_mps, truth.velocity_mps);
        }
        limits
    }

    /// Judges all seconds that are over.
    pub(crate) fn pass(&mut self, at_ns: i64, allowances: &Allowances, findings: &mut Findings) {
        while self.mono_ns(self.next) + (GRACE_S * 1e9) as i64 <= at_ns {
            let Some(second) = self.world.second(self.next).cloned() else {
                return;
            };
            self.judge(&second, allowances, findings);
            self.next += 1;
        }
    }

    fn mono_ns(&self, second: u32) -> i64 {
        self.begin_mono_ns + i64::from(second) * SECOND_NS
    }

    fn judge(&mut self, second: &Second, allowances: &Allowances, findings: &mut Findings) {
        let (number, utc_ns) = (second.second, self.world.utc_ns(second.second));
        self.counts.seconds += 1;
        let shown = self.shown(utc_ns);
        let owners = owners(&shown, second);
        for target in &second.targets {
            let own = owners.get(&target.address).map_or(&[][..], Vec::as_slice);
            let tracks: Vec<&Shown> = own.iter().map(|place| &shown[*place]).collect();
            self.judge_target(number, target, &tracks, allowances, findings);
        }
        self.judge_odd(number, (&shown, &owners), second, findings);
        self.judge_whole(number, allowances, findings);
    }

    /// Tracks that are shown at a time.
    fn shown(&mut self, utc_ns: i64) -> Vec<Shown> {
        let mut shown = Vec::new();
        self.tracks.retain(|number, track| {
            while track.states.len() > 1 && track.states[1].time_ns <= utc_ns {
                track.states.pop_front();
            }
            let Some(state) = track.states.front() else {
                return false;
            };
            if matches!(state.life, Life::Suspended | Life::Terminated) {
                // Any later state belongs to another life of the track.
                track.states.pop_front();
                return !track.states.is_empty();
            }
            if state.time_ns <= utc_ns
                && matches!(state.life, Life::Confirmed | Life::Coasted)
                && let Some(place_m) = state.position_m
            {
                let age_s = (utc_ns - state.time_ns) as f64 / 1e9;
                shown.push(Shown {
                    number: *number,
                    age_s,
                    place_m: moved(place_m, state.velocity_mps.unwrap_or_default(), age_s),
                    state: state.clone(),
                });
            }
            true
        });
        shown
    }

    fn judge_target(
        &mut self,
        second: u32,
        target: &Target,
        tracks: &[&Shown],
        allowances: &Allowances,
        findings: &mut Findings,
    ) {
        let (at_ns, utc_ns) = (self.mono_ns(second), self.world.utc_ns(second));
        let address = target.address;
        let Some(watch) = self.watches.get_mut(&address) else {
            return;
        };
        let states = std::mem::take(&mut watch.came);
        if let Some(newest) = tracks.iter().map(|track| track.state.time_ns).max() {
            watch.newest_ns = watch.newest_ns.max(Some(newest));
        }
        // A target absent from the run without faults for so long need not be shown.
        let Some(seen) = target
            .undisturbed
            .filter(|_| watch.normal.len() > RECENT_S.min(SETTLED_S as usize))
        else {
            (watch.errors, watch.lacks_since, watch.is_missing) = (VecDeque::new(), [None; 3], false);
            watch.states.clear();
            return;
        };
        self.counts.targets_s += 1;
        let recent = watch.normal.iter().rev().take(RECENT_S);
        let period_s = recent.map(|seen| seen.age_s).fold(1.0, f64::max);
        let begin_ns = self.begin_mono_ns;
        let newest_ns = watch
            .newest_ns
            .map_or(begin_ns, |newest_ns| at_ns - (utc_ns - newest_ns));
        let age_s = (at_ns - newest_ns) as f64 / 1e9;
        let limit_s = period_s + LATE_S + allowances.missing_s(newest_ns, at_ns, period_s);
        let is_missing = age_s > limit_s;
        self.counts.missing_s += u64::from(is_missing);
        if is_missing && !std::mem::replace(&mut watch.is_missing, true) {
            findings.add(Finding::Missing, || {
                format!("{address:06X} at {second} s, its newest state {age_s:.1} s old (limit {limit_s:.1} s)")
            });
        }
        watch.is_missing &= is_missing;
        let since_ns = at_ns - (RATE_S as i64 + 5) * SECOND_NS;
        let is_first = self.counts.seconds == 1;
        watch.take_rate(
            states,
            is_first || allowances.missing_s(since_ns, at_ns, period_s) > 0.0,
        );
        let off = watch.rate_off();
        if let (Some([states, normal]), false) = (off, watch.is_rate_off) {
            findings.add(Finding::Rate, || {
                format!("{address:06X} at {second} s, {states} in {RATE_S} s, without faults {normal}")
            });
        }
        watch.is_rate_off = off.is_some();
        let rates = &mut self.rates;
        if let Some([states, normal]) = watch.rate() {
            *rates = [rates[0] + states, rates[1] + normal];
        }
        let Some(best) = tracks.iter().min_by(|one, other| one.age_s.total_cmp(&other.age_s)) else {
            watch.errors.clear();
            return;
        };
        let lacks = [
            seen.has_address && best.state.address.is_none(),
            seen.has_height && !best.state.has_height,
            seen.has_velocity && best.state.velocity_mps.is_none(),
        ];
        let what = ["address", "height", "velocity"];
        for ((since, lacks), what) in watch.lacks_since.iter_mut().zip(lacks).zip(what) {
            if !lacks {
                *since = None;
            } else if second == *since.get_or_insert(second) + self.period_s.ceil() as u32 {
                findings.add(Finding::Lacks, || {
                    format!("{} of {address:06X} without its {what}", best.number)
                });
            }
        }
        // Beyond the usual age, a target may have turned: single states are judged with that, lasting errors without.
        if best.age_s > seen.age_s.max(period_s) + 0.5 {
            return;
        }
        let truth = Kinematics {
            position_m: target.position_m,
            velocity_mps: target.velocity_mps,
        };
        let found = errors(best.place_m, &best.state, &truth);
        let found: Errors = std::array::from_fn(|kind| found[kind].unwrap_or(seen.errors[kind]));
        watch.take_errors([found, seen.errors]);
        let (normal, renewal) = (&self.normal, allowances.renewal(at_ns, self.period_s));
        for (kind, (finding, unit)) in KINDS.into_iter().enumerate() {
            let off = watch.lasting_error(kind, normal, renewal);
            if let Some((error, limit)) = off
                && !watch.is_off[kind]
            {
                findings.add(finding, || {
                    format!("{address:06X} at {second} s, {error:.0} {unit} off for long (limit {limit:.0})")
                });
            }
            watch.is_off[kind] = off.is_some();
        }
        self.errors[0].push(found[0]);
        self.errors[1].push(seen.errors[0]);
        if let Some([all, normal]) = self.whole.back_mut() {
            all.push(found);
            normal.push(seen.errors);
        }
    }

    /// Tracks too many: a second track of a target, or a track without a target.
    fn judge_odd(
        &mut self,
        second: u32,
        (shown, owners): (&[Shown], &BTreeMap<u32, Vec<usize>>),
        truth: &Second,
        findings: &mut Findings,
    ) {
        let mut permitted_m = truth.strangers_m.clone();
        let mut is_permitted = |track: &Shown| {
            let near = |stranger_m: &[f64; 2]| {
                (stranger_m[0] - track.place_m[0]).hypot(stranger_m[1] - track.place_m[1]) < SAME_M
            };
            let twin = permitted_m.iter().position(near);
            twin.map(|twin| permitted_m.swap_remove(twin)).is_some()
        };
        let limit = self.period_s.ceil() as u32;
        let mut is_owned = vec![false; shown.len()];
        for (address, places) in owners {
            places.iter().for_each(|place| is_owned[*place] = true);
            let second_tracks = places[1..].iter().filter(|place| !is_permitted(&shown[**place]));
            let doubles: Vec<u32> = second_tracks.map(|place| shown[*place].number).collect();
            self.counts.double_s += doubles.len() as u64;
            let Some(watch) = self.watches.get_mut(address) else {
                continue;
            };
            if doubles.is_empty() {
                watch.double_since = None;
            } else if second == *watch.double_since.get_or_insert(second) + limit {
                let own = shown[places[0]].number;
                findings.add(Finding::Double, || {
                    format!("{doubles:?} beside {own} of {address:06X} until {second} s")
                });
            }
        }
        for (place, track) in shown.iter().enumerate() {
            let Some(entry) = self.tracks.get_mut(&track.number) else {
                continue;
            };
            if is_owned[place] || is_permitted(track) {
                entry.ghost_since = None;
                continue;
            }
            self.counts.ghosts_s += 1;
            if second == *entry.ghost_since.get_or_insert(second) + limit {
                findings.add(Finding::Ghost, || {
                    format!("{} at {:.0?} m until {second} s", track.number, track.place_m)
                });
            }
        }
    }

    /// All errors of the latest seconds against the errors without faults.
    fn judge_whole(&mut self, second: u32, allowances: &Allowances, findings: &mut Findings) {
        let rates = std::mem::take(&mut self.rates);
        let is_rate_off = is_off(rates, WHOLE_RATE);
        if is_rate_off && !self.is_rate_off {
            let [states, normal] = rates;
            findings.add(Finding::Rate, || {
                format!("all targets at {second} s, {states} in {RATE_S} s, without faults {normal}")
            });
        }
        self.is_rate_off = is_rate_off;
        let renewal = allowances.renewal(self.mono_ns(second), self.period_s);
        let ratios = renewal.unwrap_or([WHOLE_MEDIAN, WHOLE_P95, LASTING]);
        if self.whole.len() == WHOLE_S {
            let mut is_off = false;
            for (kind, (_, unit)) in KINDS.into_iter().enumerate() {
                let of = |side: usize| {
                    let all = self.whole.iter().flat_map(|sides| &sides[side]);
                    Spread::of(&all.map(|errors| errors[kind]).collect::<Vec<_>>()).unwrap_or_default()
                };
                let (found, normal) = (of(0), of(1));
                let pairs = [
                    ("median", found.median, normal.median.max(self.normal.median[kind])),
                    ("95 %", found.p95, normal.p95.max(self.normal.p95[kind])),
                ];
                for ((name, found, normal), ratio) in pairs.into_iter().zip(ratios) {
                    if found > ratio * normal {
                        is_off = true;
                        if !self.is_whole_off {
                            findings.add(Finding::Whole, || {
                                format!("{name} {found:.1} {unit} at {second} s, without faults {normal:.1}")
                            });
                        }
                    }
                }
            }
            self.is_whole_off = is_off;
            self.whole.pop_front();
        }
        self.whole.push_back(Default::default());
    }

    /// Errors of positions in the plane at all seconds, and errors without faults.
    pub(crate) fn spreads(&self) -> [Option<Spread>; 2] {
        [Spread::of(&self.errors[0]), Spread::of(&self.errors[1])]
    }
}

impl Watch {
    fn take_errors(&mut self, errors: [Errors; 2]) {
        if self.errors.len() == LONG_S {
            self.errors.pop_front();
        }
        self.errors.push_back(errors);
    }

    /// The error of a kind that lasts, with its limit, if it is above the limit.
    fn lasting_error(&self, kind: usize, normal: &Normal, renewal: Option<[f64; 3]>) -> Option<(f64, f64)> {
        let median = |seconds: usize, side: usize| {
            let latest = self.errors.iter().rev().take(seconds).map(|sides| sides[side][kind]);
            Spread::of(&latest.collect::<Vec<_>>()).unwrap_or_default().median
        };
        let over = |seconds: usize, normal: f64, ratio: f64| {
            let error = median(seconds, 0);
            let limit = ratio * normal.max(median(seconds, 1));
            (self.errors.len() >= seconds && error > limit).then_some((error, limit))
        };
        let long = || over(LONG_S, normal.median[kind], LONG).filter(|_| renewal.is_none());
        let lasting = renewal.map_or(LASTING, |[.., lasting]| lasting);
        over(LASTING_S, normal.p95[kind], lasting).or_else(long)
    }

    /// Counts the states of a second; times after faults do not count.
    fn take_rate(&mut self, states: u32, is_disturbed: bool) {
        if is_disturbed {
            self.states.clear();
            self.is_rate_off = false;
            return;
        }
        if self.states.len() == RATE_S {
            self.states.pop_front();
        }
        self.states.push_back(states);
    }

    /// States of the latest seconds, and states without faults; `None` after faults.
    fn rate(&self) -> Option<[u32; 2]> {
        let normal = self.normal.iter().rev().take(RATE_S).map(|seen| seen.states).sum();
        (self.states.len() == RATE_S).then(|| [self.states.iter().sum(), normal])
    }

    /// The same, if too few, or far too many: more sources may observe the target than without faults.
    fn rate_off(&self) -> Option<[u32; 2]> {
        self.rate().filter(|rate| is_off(*rate, RATE))
    }
}

/// Whether a number of states is outside of this ratio to that without faults.
fn is_off([states, normal]: [u32; 2], ratio: std::ops::Range<f64>) -> bool {
    states.abs_diff(normal) > RATE_STATES && !ratio.contains(&(f64::from(states) / f64::from(normal)))
}

/// A track that is shown at a second.
struct Shown {
    number: u32,
    age_s: f64,
    /// The track's place, moved to the second.
    place_m: [f64; 3],
    state: State,
}

/// Places of the tracks of each target, the target's own first; tracks without a target are missing.
fn owners(shown: &[Shown], second: &Second) -> BTreeMap<u32, Vec<usize>> {
    let mut owners: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    let mut nameless = Vec::new();
    for (place, track) in shown.iter().enumerate() {
        match track.state.address {
            Some(address) => owners.entry(address).or_default().push(place),
            None => nameless.push(place),
        }
    }
    // The freshest is the target's own.
    for places in owners.values_mut() {
        places.sort_by(|one, other| shown[*one].age_s.total_cmp(&shown[*other].age_s));
    }
    for place in nameless {
        let near = |target: &&Target| distance(target.position_m, shown[place].place_m) < NEAR_M;
        let by_distance = |one: &&Target, other: &&Target| {
            let to = |target: &Target| distance(target.position_m, shown[place].place_m);
            to(one).total_cmp(&to(other))
        };
        let free = |target: &&Target| !owners.contains_key(&target.address) && target.undisturbed.is_some();
        let targets = || second.targets.iter().filter(near);
        let nearest = targets()
            .filter(free)
            .min_by(by_distance)
            .or_else(|| targets().min_by(by_distance));
        if let Some(target) = nearest {
            owners.entry(target.address).or_default().push(place);
        }
    }
    owners
}

/// Errors of a state, where the state has values.
fn errors(place_m: [f64; 3], state: &State, truth: &Kinematics) -> [Option<f64>; 3] {
    [
        Some(distance(place_m, truth.position_m)),
        state.has_height.then_some((place_m[2] - truth.position_m[2]).abs()),
        state
            .velocity_mps
            .map(|velocity_mps| distance(velocity_mps, truth.velocity_mps)),
    ]
}
