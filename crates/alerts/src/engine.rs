//! The engine: takes states of system tracks, and keeps the alerts that follow from them.

use std::collections::BTreeMap;

use areas::Level;
use frames::SystemFrame;
use messages::{Alert, AlertKind, SystemTrack, TrackState};

use crate::area_rules::{crossing, inside};
use crate::areas_of::NamedArea;
use crate::board::{AlertKey, Board, Finding, NO_AREA};
use crate::own_rules::{above, below, emergency, speed};
use crate::pair_rules::{PairRule, PairWork};
use crate::sentence::{label, sentence};
use crate::settings::{AlertSettings, KNOT_MPS};
use crate::target::Target;
use crate::targets::{Known, Targets};

/// Greatest speed that widens the search for neighbours, metres per second.
const SPEED_MAX_MPS: f64 = 700.0;
/// Reports after which a target that ends counts as lost.
const REPORTS_MIN: u32 = 8;
/// Least time without a report after which a target's rhythm is broken, seconds.
const SILENCE_MIN_S: f64 = 5.0;
/// Time for which the targets of an alert that was taken over may stay away, nanoseconds.
const AWAITED_NS: i64 = 60_000_000_000;
/// Probability from which a target is in an area that a rule is limited to.
const IN_AREA: f64 = 0.5;

/// A rule, ready for use.
#[derive(Clone, Debug)]
struct Rule {
    settings: AlertSettings,
    pair: PairRule,
    /// Numbers of the areas that it names.
    areas: Vec<u16>,
    lowest: Option<Level>,
    highest: Option<Level>,
}

/// Findings about a target, and what the target itself states.
type Found = Vec<(AlertKey, Finding, &'static str)>;

/// Alerts on targets, from the states of their tracks.
#[derive(Clone, Debug)]
pub struct AlertEngine {
    frame: SystemFrame,
    rules: Vec<Rule>,
    areas: Vec<NamedArea>,
    targets: Targets,
    /// Since when a target is in an area, by its number, rule and area: UTC, nanoseconds.
    since_ns: BTreeMap<(u32, u16, u16), i64>,
    board: Board,
    work: PairWork,
    /// Alerts that were taken over, and the times until which their targets may come back, UTC, nanoseconds.
    awaited: Vec<(AlertKey, i64)>,
    /// Greatest speed of a target so far, metres per second.
    fastest_mps: f64,
    /// Time of the engine, UTC, nanoseconds: the latest reference time.
    now_ns: i64,
    /// Targets without room.
    refused: u64,
    found: Found,
    near: Vec<u32>,
}

impl Rule {
    /// Times for which motion, and a climb, are predicted, seconds.
    fn ahead(&self) -> (f64, f64) {
        (self.settings.look_ahead_s(), self.settings.vertical_look_ahead_s.s())
    }

    /// Judges a target by its own state alone.
    fn alone(&self, known: &Known) -> Option<Finding> {
        let target = &known.target;
        match self.settings.kind.0 {
            AlertKind::Low => below(target, self.lowest?, self.ahead().0),
            AlertKind::Level => {
                let low = self.lowest.and_then(|level| below(target, level, 0.0));
                let high = self.highest.and_then(|level| above(target, level));
                let both = low.into_iter().chain(high);
                both.max_by(|one, other| one.probability.total_cmp(&other.probability))
            }
            AlertKind::Speed => {
                let limits = [self.settings.faster_than_kn, self.settings.slower_than_kn];
                let [least, greatest] = limits.map(|knots| knots.map(|knots| knots * KNOT_MPS));
                Some(speed(target, least, greatest))
            }
            AlertKind::Lost => {
                let silent_s = (target.time_ns - known.reported_ns) as f64 * 1e-9;
                let limit_s = (self.settings.silent_intervals * known.interval_s).max(SILENCE_MIN_S);
                let is_regular = known.updates >= REPORTS_MIN && known.interval_s > 0.0;
                (is_regular && silent_s > limit_s).then(|| Finding::passed(silent_s, limit_s))
            }
            _ => None,
        }
    }
}

impl AlertEngine {
    /// With checked rules, and areas in the plane of `frame`, for at most `capacity` targets at a time.
    pub fn new(rules: &[AlertSettings], areas: Vec<NamedArea>, frame: SystemFrame, capacity: usize) -> Self {
        let level = |text: &Option<String>| text.as_ref().and_then(|text| text.parse().ok());
        let rule = |settings: &AlertSettings| Rule {
            pair: PairRule::of(settings),
            areas: (0..)
                .zip(&areas)
                .filter(|(_, area)| settings.areas.iter().any(|name| area.is_called(name)))
                .map(|(number, _)| number)
                .collect(),
            lowest: level(&settings.above),
            highest: level(&settings.below),
            settings: settings.clone(),
        };
        Self {
            frame,
            rules: rules.iter().map(rule).collect(),
            areas,
            targets: Targets::new(capacity),
            since_ns: BTreeMap::new(),
            board: Board::default(),
            work: PairWork::new(),
            awaited: Vec::new(),
            fastest_mps: 0.0,
            now_ns: i64::MIN,
            refused: 0,
            found: Vec::new(),
            near: Vec::new(),
        }
    }

    /// Takes a state. Adds the alerts that it raises and clears to `changed`.
    pub fn take(&mut self, track: &SystemTrack, changed: &mut Vec<Alert>) {
        self.now_ns = self.now_ns.max(track.reference_time_ns);
        while let Some(ended) = self.board.ended(self.now_ns) {
            changed.push(ended);
        }
        if !self.awaited.is_empty() {
            self.end_awaited(changed);
        }
        if track.state == TrackState::Tentative.code() {
            return;
        }
        match Target::of(track, &self.frame) {
            Some(target) => {
                self.fastest_mps = self.fastest_mps.max(target.speed_mps().min(SPEED_MAX_MPS));
                match self.targets.keep(track, target) {
                    Some(slot) => self.judge(track, slot, changed),
                    None => self.refused += 1,
                }
            }
            None if TrackState::is_off(track.state) => self.end(track, changed),
            None => {}
        }
    }

    /// Takes over the alerts that another engine had in force, and goes on with the numbers after `last`. An alert
    /// whose rule or area is no longer configured is left out. One whose targets do not come back ends after a while.
    pub fn resume(&mut self, last: u64, in_force: &[Alert]) {
        self.board.number_after(last);
        for alert in in_force {
            let is_rule =
                |rule: &&Rule| rule.settings.title() == alert.rule() && Some(rule.settings.kind.0) == alert.kind();
            let rule = (0..)
                .zip(&self.rules)
                .find(|(_, rule)| is_rule(rule))
                .map(|(number, _)| number);
            let area = match alert.area() {
                "" => Some(NO_AREA),
                name => (0..)
                    .zip(&self.areas)
                    .find(|(_, area)| area.title() == name)
                    .map(|(number, _)| number),
            };
            if let (Some(rule), Some(area)) = (rule, area) {
                let key = AlertKey {
                    rule,
                    area,
                    tracks: alert.tracks,
                };
                self.board.put(key, *alert);
                self.awaited.push((key, alert.time_ns + AWAITED_NS));
            }
        }
    }

    /// Number of the last alert that was raised.
    pub fn last_number(&self) -> u64 {
        self.board.last()
    }

    /// Ends the alerts that were taken over, and whose targets have not come back.
    fn end_awaited(&mut self, changed: &mut Vec<Alert>) {
        let now_ns = self.now_ns;
        let due = self.awaited.extract_if(.., |(_, until_ns)| *until_ns <= now_ns);
        for (key, _) in due {
            if !has_all(&self.targets, key) {
                changed.extend(self.board.clear(key, now_ns));
            }
        }
    }

    /// Alerts in force, in the order of rules, areas and targets.
    pub fn in_force(&self) -> impl Iterator<Item = &Alert> {
        self.board.in_force().map(|(_, alert)| alert)
    }

    /// Number of targets and alerts that were left out for lack of room.
    pub fn refused(&self) -> u64 {
        self.refused + self.board.refused()
    }

    /// Number of targets.
    pub fn target_count(&self) -> usize {
        self.targets.len()
    }

    /// Judges a target that has a new state.
    fn judge(&mut self, track: &SystemTrack, slot: u32, changed: &mut Vec<Alert>) {
        let number = track.track_number;
        let mut found = std::mem::take(&mut self.found);
        found.clear();
        for rule in 0..self.rules.len() as u16 {
            self.judge_rule(rule, track, slot, &mut found);
        }
        found.sort_by_key(|(key, ..)| *key);
        // An alert that nothing was found for has no reason any more. That about a lost target ends with its states.
        let standing: Vec<AlertKey> = self.board.of_target(number).collect();
        for key in standing {
            let is_awaited = self.awaited.iter().any(|(awaited, _)| *awaited == key) && !has_all(&self.targets, key);
            if !is_awaited && found.binary_search_by_key(&key, |(key, ..)| *key).is_err() {
                changed.extend(self.board.clear(key, self.now_ns));
            }
        }
        for (key, finding, event) in &found {
            changed.extend(self.state(*key, finding, event));
        }
        self.found = found;
    }

    fn judge_rule(&mut self, rule: u16, track: &SystemTrack, slot: u32, found: &mut Found) {
        let Some(known) = self.targets.at(slot) else {
            return;
        };
        let (of, target) = (&self.rules[usize::from(rule)], &known.target);
        if !target.is_of(of.settings.traffic()) {
            return;
        }
        let kind = of.settings.kind.0;
        if let AlertKind::Enter | AlertKind::Leave | AlertKind::Stay = kind {
            return self.judge_areas(rule, slot, found);
        }
        let key = |area: u16| AlertKey {
            rule,
            area,
            tracks: [track.track_number, 0],
        };
        // The other rules count in their areas only.
        let Some(area) = self.area_of(of, target) else {
            return;
        };
        match kind {
            AlertKind::Conflict | AlertKind::Approach => self.judge_neighbours(rule, slot, found),
            AlertKind::Emergency => {
                found.extend(emergency(track).map(|event| (key(area), Finding::happened(), event)));
            }
            _ => found.extend(of.alone(known).map(|finding| (key(area), finding, ""))),
        }
    }

    /// Judges whether a target is in the areas of a rule, or out of them.
    fn judge_areas(&mut self, rule: u16, slot: u32, found: &mut Found) {
        let Some((number, time_ns)) = self
            .targets
            .at(slot)
            .map(|known| (known.target.number, known.target.time_ns))
        else {
            return;
        };
        for area in self.active_areas(&self.rules[usize::from(rule)], time_ns) {
            let finding = self.judge_area(rule, area, slot);
            let key = AlertKey {
                rule,
                area,
                tracks: [number, 0],
            };
            found.extend(finding.map(|finding| (key, finding, "")));
        }
    }

    /// Numbers of the areas of a rule that are active.
    fn active_areas(&self, rule: &Rule, time_ns: i64) -> Vec<u16> {
        let is_active = |area: &u16| self.areas[usize::from(*area)].is_active(time_ns);
        rule.areas.iter().copied().filter(is_active).collect()
    }

    /// Area of a rule in which a target is; [`NO_AREA`] for a rule that counts everywhere, `None` if it does not count.
    fn area_of(&self, rule: &Rule, target: &Target) -> Option<u16> {
        match rule.settings.areas.is_empty() {
            true => Some(NO_AREA),
            false => self
                .active_areas(rule, target.time_ns)
                .into_iter()
                .find(|area| self.is_inside(target, *area)),
        }
    }

    fn is_inside(&self, target: &Target, area: u16) -> bool {
        inside(target, &self.areas[usize::from(area)], 0.0).is_some_and(|(probability, _)| probability >= IN_AREA)
    }

    /// Judges `enter`, `stay`, and `leave` of a target that has been inside.
    fn judge_area(&mut self, rule: u16, area: u16, slot: u32) -> Option<Finding> {
        let (of, target) = (&self.rules[usize::from(rule)], &self.targets.at(slot)?.target);
        let (kind, zone) = (of.settings.kind.0, &self.areas[usize::from(area)]);
        if kind == AlertKind::Enter {
            return crossing(target, zone, true, of.ahead(), &self.work.draws);
        }
        let (key, is_inside) = ((target.number, rule, area), self.is_inside(target, area));
        if is_inside {
            self.since_ns.entry(key).or_insert(target.time_ns);
        }
        let since_ns = *self.since_ns.get(&key)?;
        if kind == AlertKind::Leave {
            return crossing(target, zone, false, of.ahead(), &self.work.draws);
        }
        if !is_inside {
            self.since_ns.remove(&key);
            return None;
        }
        let (stayed_s, limit_s) = ((target.time_ns - since_ns) as f64 * 1e-9, of.settings.for_s.s());
        (stayed_s >= limit_s).then(|| Finding::passed(stayed_s, limit_s))
    }

    /// Judges a target with each target that may come near. The area of a pair is that of its first target.
    fn judge_neighbours(&mut self, rule: u16, slot: u32, found: &mut Found) {
        let of = &self.rules[usize::from(rule)];
        let Some(target) = self.targets.at(slot).map(|known| &known.target) else {
            return;
        };
        let mut near = std::mem::take(&mut self.near);
        let reach_m = of.pair.reach_m(target.speed_mps() + self.fastest_mps);
        self.targets.near(slot, target.place_m, reach_m, &mut near);
        for other in near
            .iter()
            .filter_map(|other| self.targets.at(*other))
            .map(|known| &known.target)
        {
            if !other.is_of(of.settings.traffic()) || self.area_of(of, other).is_none() {
                continue;
            }
            let [one, two] = if target.number < other.number {
                [target, other]
            } else {
                [other, target]
            };
            let judged = of.pair.judge(one, two, self.now_ns, &mut self.work);
            if let Some((area, finding)) = self.area_of(of, one).zip(judged) {
                let key = AlertKey {
                    rule,
                    area,
                    tracks: [one.number, two.number],
                };
                found.push((key, finding, ""));
            }
        }
        self.near = near;
    }

    /// States a finding on the board; returns the alert if it was raised or cleared.
    fn state(&mut self, key: AlertKey, finding: &Finding, event: &str) -> Option<Alert> {
        let settings = &self.rules[usize::from(key.rule)].settings;
        let area = match key.area {
            NO_AREA => "",
            area => self.areas[usize::from(area)].title(),
        };
        let targets = &self.targets;
        let labels = key.tracks.map(|track| {
            let known = targets.get(track);
            known.map_or(String::new(), |known| label(&known.identity, track))
        });
        let write = |alert: &mut Alert| {
            alert.kind = settings.kind.0.code();
            alert.severity = settings.severity().code();
            let text = sentence(alert, area, [&labels[0], &labels[1]], event);
            *alert = alert.with_texts(settings.title(), area, &text);
        };
        self.board
            .find(key, finding, (settings.probability, self.now_ns), write)
    }

    /// Ends a target.
    fn end(&mut self, track: &SystemTrack, changed: &mut Vec<Alert>) {
        let number = track.track_number;
        let Some(known) = self.targets.get(number).cloned() else {
            return;
        };
        let was_reported = known.updates >= REPORTS_MIN;
        let is_missing = was_reported && track.merged_into == 0 && !known.target.is_on_ground;
        let mut lost = Vec::new();
        for (rule, of) in (0..).zip(&self.rules) {
            if !is_missing || of.settings.kind.0 != AlertKind::Lost || !known.target.is_of(of.settings.traffic()) {
                continue;
            }
            let within = |area: &u16| {
                let zone = &self.areas[usize::from(*area)];
                zone.is_active(self.now_ns)
                    && inside(&known.target, zone, 0.0).is_some_and(|(probability, _)| probability >= IN_AREA)
            };
            let area = match of.settings.areas.is_empty() {
                true => Some(NO_AREA),
                false => of.areas.iter().copied().find(within),
            };
            lost.extend(area.map(|area| AlertKey {
                rule,
                area,
                tracks: [number, 0],
            }));
        }
        let standing: Vec<AlertKey> = self.board.of_target(number).filter(|key| !lost.contains(key)).collect();
        for key in standing {
            changed.extend(self.board.clear(key, self.now_ns));
        }
        for key in lost {
            let silent_s = (self.now_ns - known.reported_ns) as f64 * 1e-9;
            let finding = Finding::passed(silent_s, 0.0);
            changed.extend(self.state(key, &finding, ""));
            let keep_ns = self.rules[usize::from(key.rule)].settings.keep_s.ns();
            if self.board.has(key) {
                self.board.end_at(key, self.now_ns + keep_ns);
            }
        }
        let of_target = (number, 0, 0)..=(number, u16::MAX, u16::MAX);
        let areas: Vec<(u32, u16, u16)> = self.since_ns.range(of_target).map(|(key, _)| *key).collect();
        for key in areas {
            self.since_ns.remove(&key);
        }
        self.targets.remove(number);
    }
}

/// Whether all targets of an alert are there.
fn has_all(targets: &Targets, key: AlertKey) -> bool {
    key.tracks
        .iter()
        .all(|track| *track == 0 || targets.get(*track).is_some())
}

#[cfg(test)]
mod tests {
    use messages::AlarmEvent;

    use super::*;
    use crate::areas_of::named_areas;
    use crate::futures::tests::{frame, state};
    use crate::settings::{AreaSettings, CircleSettings};

    const S: i64 = 1_000_000_000;

    fn rules(text: &str) -> Vec<AlertSettings> {
        settings::settings! {
            pub(super) struct Tables {
                /// Rules.
                alert: Vec<AlertSettings> = Vec::new();
            }
        }
        let document = settings::Document::parse(text, &[]).expect("well-formed");
        document.read::<Tables>().expect("usable").alert
    }

    fn engine(text: &str) -> AlertEngine {
        let circle = |name: &str, longitude_deg| AreaSettings {
            name: name.to_owned(),
            circle: Some(CircleSettings {
                latitude_deg: 46.0,
                longitude_deg,
                radius_nm: 5.0,
            }),
            ..AreaSettings::default()
        };
        // The second one begins where the first one ends.
        let circles = [circle("zone", 7.0), circle("beside", 7.24)];
        let areas = named_areas(&circles, &areas::Ground::of(frame()), &|_| unreachable!()).unwrap();
        AlertEngine::new(&rules(text), areas, frame(), 100)
    }

    /// A target that flies straight through a place at time 0.
    fn flight(number: u32, place_m: [f64; 3], velocity_mps: [f64; 3], time_s: i64) -> SystemTrack {
        let now: [f64; 3] = std::array::from_fn(|axis| place_m[axis] + velocity_mps[axis] * time_s as f64);
        SystemTrack {
            reference_time_ns: time_s * S,
            updates: (time_s + 1_000) as u32,
            ..state(number, now, velocity_mps, [20.0, 0.5])
        }
    }

    fn run(engine: &mut AlertEngine, states: impl IntoIterator<Item = SystemTrack>) -> Vec<(i64, &'static str, u64)> {
        let mut events = Vec::new();
        for state in states {
            let mut changed = Vec::new();
            engine.take(&state, &mut changed);
            events.extend(changed.iter().map(|alert| {
                (
                    alert.time_ns / S,
                    alert.event().map_or("?", AlarmEvent::word),
                    alert.number,
                )
            }));
        }
        events
    }

    #[test]
    fn a_pair_has_one_alert_from_the_look_ahead_until_it_has_passed() {
        let mut engine = engine("[[alert]]\nkind = \"conflict\"");
        let states = (-200..100).flat_map(|time_s| {
            [
                flight(1, [0.0, 0.0, 9_000.0], [200.0, 0.0, 0.0], time_s),
                flight(2, [0.0, 2_000.0, 9_000.0], [-200.0, 0.0, 0.0], time_s),
                flight(3, [0.0, 0.0, 9_700.0], [0.0, 200.0, 0.0], time_s),
            ]
        });
        let events = run(&mut engine, states);
        // Violated while the distance along the way is less than 9,042 m: from 22.6 s before to 22.6 s after.
        assert_eq!(events.len(), 2, "{events:?}");
        assert!(
            (-143..=-141).contains(&events[0].0) && events[0].1 == "raised",
            "{events:?}"
        );
        assert!(
            (23..=24).contains(&events[1].0) && events[1].1 == "cleared",
            "{events:?}"
        );
        assert_eq!(engine.in_force().count(), 0);
    }

    #[test]
    fn entering_staying_and_leaving_are_three_alerts() {
        let text = "[[alert]]\nkind = \"enter\"\nareas = [\"zone\"]\n[[alert]]\nkind = \"stay\"\nareas = [\"zone\"]\n\
                    for_s = 50\n[[alert]]\nkind = \"leave\"\nareas = [\"zone\"]";
        let mut engine = engine(text);
        let events = run(
            &mut engine,
            (-150..150).map(|time_s| flight(1, [0.0, 0.0, 2_000.0], [100.0, 0.0, 0.0], time_s)),
        );
        let at: Vec<(i64, &str)> = events.iter().map(|(time_s, event, _)| (*time_s, *event)).collect();
        assert_eq!(
            at,
            [
                (-92, "raised"),
                (-42, "raised"),
                (93, "cleared"),
                (93, "cleared"),
                (93, "raised")
            ],
            "{events:?}"
        );
    }

    #[test]
    fn a_target_that_ends_or_falls_silent_is_lost_for_a_while() {
        let mut engine = engine("[[alert]]\nkind = \"lost\"\nkeep_s = 30");
        let seen = |time_s| flight(1, [0.0, 0.0, 2_000.0], [100.0, 0.0, 0.0], time_s);
        let events = run(&mut engine, (0..20).map(seen));
        assert_eq!(events, [], "it is reported");
        let silent = |time_s| SystemTrack {
            updates: seen(19).updates,
            ..seen(time_s)
        };
        assert_eq!(run(&mut engine, (20..27).map(silent)), [(25, "raised", 1)]);
        assert_eq!(run(&mut engine, [seen(27)]), [(27, "cleared", 1)]);
        let off = |time_s| SystemTrack {
            state: TrackState::Suspended.code(),
            ..seen(time_s)
        };
        assert_eq!(run(&mut engine, [off(28)]), [(28, "raised", 2)]);
        let other = |time_s| flight(2, [0.0; 3], [0.0; 3], time_s);
        assert_eq!(run(&mut engine, [other(57), other(58)]), [(58, "cleared", 2)]);
        // A merged track is not lost.
        run(&mut engine, (60..80).map(seen));
        let merged = SystemTrack {
            state: TrackState::Terminated.code(),
            merged_into: 2,
            ..seen(80)
        };
        assert_eq!(run(&mut engine, [merged]), []);
        assert_eq!(engine.target_count(), 1);
    }

    #[test]
    fn the_alert_of_a_pair_ends_with_a_target() {
        let mut engine = engine("[[alert]]\nkind = \"conflict\"");
        let near = |number| flight(number, [0.0, 0.0, 9_000.0], [200.0, 0.0, 0.0], 0);
        assert_eq!(run(&mut engine, [near(1), near(2)]), [(0, "raised", 1)]);
        let ended = SystemTrack {
            state: TrackState::Terminated.code(),
            ..near(2)
        };
        assert_eq!(run(&mut engine, [ended]), [(0, "cleared", 1)]);
    }

    #[test]
    fn alerts_in_force_are_taken_over_with_their_numbers() {
        let mut first = engine("[[alert]]\nkind = \"conflict\"");
        let near = |number, time_s| flight(number, [0.0, 0.0, 9_000.0], [200.0, 0.0, 0.0], time_s);
        run(&mut first, [near(1, 0), near(2, 0), near(3, 0)]);
        let in_force: Vec<Alert> = first.in_force().copied().collect();
        assert_eq!(in_force.len(), 3);
        let mut second = engine("[[alert]]\nkind = \"conflict\"");
        second.resume(first.last_number(), &in_force);
        // The first two go on; the third one does not come back.
        let events = run(
            &mut second,
            (1..62).flat_map(|time_s| [near(1, time_s), near(2, time_s)]),
        );
        let ended: Vec<(i64, &str)> = events.iter().map(|(time_s, event, _)| (*time_s, *event)).collect();
        assert_eq!(ended, [(60, "cleared"), (60, "cleared")]);
        assert_eq!(run(&mut second, [near(4, 61)])[0].2, 4, "numbers go on");
        // Another configuration has no such rule.
        let mut other = engine("[[alert]]\nkind = \"emergency\"");
        other.resume(3, &in_force);
        assert_eq!(other.in_force().count(), 0);
    }

    #[test]
    fn a_pair_in_two_areas_has_one_alert() {
        let mut engine = engine("[[alert]]\nkind = \"conflict\"\nareas = [\"beside\", \"zone\"]");
        let at = |number, x, time_s| flight(number, [x, 0.0, 9_000.0], [0.0, 100.0, 0.0], time_s);
        let states = (0..10).flat_map(|time_s| [at(1, 8_000.0, time_s), at(2, 12_000.0, time_s)]);
        assert_eq!(run(&mut engine, states), [(0, "raised", 1)]);
        assert_eq!(
            engine.in_force().next().map(Alert::area),
            Some("zone"),
            "that of the first target"
        );
    }

    #[test]
    fn more_targets_than_there_is_room_for_are_counted() {
        let mut engine = AlertEngine::new(&rules("[[alert]]\nkind = \"emergency\""), Vec::new(), frame(), 2);
        run(&mut engine, (1..5).map(|number| flight(number, [0.0; 3], [0.0; 3], 0)));
        assert_eq!((engine.target_count(), engine.refused()), (2, 2));
    }
}
