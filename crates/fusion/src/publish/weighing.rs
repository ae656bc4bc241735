//! Weighing: from the contributions of a system track to the track's state at a reference time.
//!
//! Each source in support of a system track contributes its latest report, brought to the reference time. Further
//! properties (accuracy value, age, quality index …) go to the rule as a [`Candidate`]. The rule gives each
//! contribution its share and yields the common state. Rules with states from the target's filter need only the share
//! of each contribution.

use fusion_rules::candidate::{candidate_of, value};
use messages::{CONTRIBUTIONS_MAX, SensorTrack, TrackState, sensor_track_bits};

use crate::accuracy::{Accuracies, StatedAccuracy};
use crate::history::moved;
use crate::rules::{self, Candidate, RuleFunction, RuleMemory, RuleMethod, Share, Target};
use crate::settings::{DropOut, Settings};
use crate::state::State;
use crate::tables::sensor_tracks::{Role, SensorEntry, SensorSlot};
use crate::tables::system_tracks::SystemSlot;
use crate::tables::tracks::Tracks;

/// The gathering of contributions.
pub(crate) struct Weigher<'a> {
    pub(crate) settings: &'a Settings,
    pub(crate) tracks: &'a Tracks,
    pub(crate) accuracies: &'a Accuracies,
    /// Method of the rule for the gathered contributions.
    pub(crate) method: RuleMethod,
}

/// Description of a target by its contributions, beside its motion.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Stated {
    pub(crate) alerts: u8,
    pub(crate) on_ground: bool,
    /// Whether any contribution states a group or a type.
    pub(crate) is_described: bool,
}

impl Stated {
    #[inline]
    fn add(&mut self, entry: &SensorEntry) {
        self.alerts |= entry.alerts;
        self.on_ground |= entry.on_ground;
        self.is_described |= entry.is_described;
    }
}

/// The contributions to one system track and the result of the rule; `len` entries of each array are in use. Large, and
/// so kept and filled anew for each system track.
#[derive(Debug)]
pub(crate) struct Weighed {
    members: [SensorSlot; CONTRIBUTIONS_MAX],
    candidates: [Candidate; CONTRIBUTIONS_MAX],
    shares: [Share; CONTRIBUTIONS_MAX],
    len: usize,
    /// Number of all contributions, also those without room.
    contributing: u16,
    /// Whether another centre tracks the target, or has done so.
    has_centres: bool,
    /// The members' statements on the target beside its motion.
    stated: Stated,
    /// Sort keys of members, greatest first: source, order in the list of members, and place, from the highest bits on.
    keys: [u64; CONTRIBUTIONS_MAX],
}

impl Default for Weighed {
    fn default() -> Self {
        Self {
            members: [0; CONTRIBUTIONS_MAX],
            candidates: [Candidate::default(); CONTRIBUTIONS_MAX],
            shares: [Share::default(); CONTRIBUTIONS_MAX],
            len: 0,
            contributing: 0,
            has_centres: false,
            stated: Stated::default(),
            keys: [0; CONTRIBUTIONS_MAX],
        }
    }
}

impl Weighed {
    /// The contributing sensor tracks, in the order of their sources.
    pub(crate) fn members(&self) -> &[SensorSlot] {
        &self.members[..self.len]
    }

    /// Number of all contributing sensor tracks. If not all can be held, the first sources are.
    pub(crate) fn contributing(&self) -> u16 {
        self.contributing
    }

    /// Whether a sensor track of the system track, contributing or not, is a track of another centre.
    pub(crate) fn has_centres(&self) -> bool {
        self.has_centres
    }

    /// The members' statements on the target beside its motion.
    pub(crate) fn stated(&self) -> Stated {
        self.stated
    }

    /// Collects the members' statements after the addition of others.
    pub(crate) fn collect_stated(&mut self, tracks: &Tracks) {
        self.stated = Stated::default();
        for member in &self.members[..self.len] {
            self.stated.add(tracks.sensors.get(*member));
        }
    }

    /// One candidate per member.
    pub(crate) fn candidates(&self) -> &[Candidate] {
        &self.candidates[..self.len]
    }

    /// One share per member.
    pub(crate) fn shares(&self) -> &[Share] {
        &self.shares[..self.len]
    }

    /// Weighs by a rule the contributions gathered at `reference_ns`; `last` is the previous state of the target.
    /// `None` if the rule can use no contribution.
    pub(crate) fn fuse(
        &mut self,
        rule: RuleFunction,
        settings: &Settings,
        last: &State,
        memory: &mut RuleMemory,
        reference_ns: i64,
    ) -> Option<State> {
        if self.len == 0 {
            return None;
        }
        let target = Target {
            candidates: &self.candidates[..self.len],
            reference_ns,
            last,
            process_noise_m2ps3: settings.process_noise_m2ps3,
        };
        rules::fuse(rule, &settings.rule, &target, memory, &mut self.shares[..self.len])
    }

    /// Gives each contribution its share in the target's filter. `false` without contributions.
    pub(crate) fn share_out(&mut self) -> bool {
        if self.len == 0 {
            return false;
        }
        rules::share_out(&self.candidates[..self.len], &mut self.shares[..self.len]);
        true
    }

    /// Joins the state of the `own` contributions, if any, with the states of other centres, and adds these to the
    /// contributions. `None`, without any addition, if the states cannot be joined.
    pub(crate) fn join_centres(
        &mut self,
        own: Option<&State>,
        centres: &[(SensorSlot, Candidate)],
        shares_none: bool,
    ) -> Option<State> {
        let mut candidates = [Candidate::default(); CONTRIBUTIONS_MAX];
        let mut shares = [Share::default(); CONTRIBUTIONS_MAX];
        for (place, (_, candidate)) in candidates.iter_mut().zip(centres) {
            *place = *candidate;
        }
        let shares = &mut shares[..centres.len()];
        let (state, own_share) = rules::join(own, &candidates[..centres.len()], shares_none, shares)?;
        if own.is_none() {
            (self.len, self.contributing) = (0, 0);
        }
        for share in &mut self.shares[..self.len] {
            share.weight.iter_mut().for_each(|weight| *weight *= own_share);
        }
        for ((member, candidate), share) in centres.iter().zip(shares) {
            let last = self.len;
            self.push(*member, *candidate);
            if let Some(place) = self.members().iter().position(|other| other == member) {
                let end = (last + 1).min(CONTRIBUTIONS_MAX);
                self.shares[place..end].rotate_right(1);
                self.shares[place] = Share {
                    accuracy: f64::INFINITY,
                    ..*share
                };
            }
        }
        Some(state)
    }

    /// Computes the accuracy value of each contribution.
    fn value(&mut self) {
        value(&mut self.candidates[..self.len]);
    }

    fn push(&mut self, member: SensorSlot, candidate: Candidate) {
        let place = self
            .candidates()
            .partition_point(|other| other.source < candidate.source);
        self.contributing += 1;
        if place == CONTRIBUTIONS_MAX {
            return;
        }
        self.len = (self.len + 1).min(CONTRIBUTIONS_MAX);
        self.members[place..self.len].rotate_right(1);
        self.candidates[place..self.len].rotate_right(1);
        self.members[place] = member;
        self.candidates[place] = candidate;
    }
}

/// The source in a key of [`Weighed::keys`].
fn source_of(key: u64) -> u16 {
    (key >> 48) as u16
}

impl Weigher<'_> {
    /// Gathers the contributions to `system` at `reference_ns`.
    pub(crate) fn gather(&self, system: SystemSlot, reference_ns: i64, weighed: &mut Weighed) {
        (weighed.len, weighed.contributing, weighed.has_centres) = (0, 0, false);
        match self.method {
            RuleMethod::Filter => self.gather_shares(system, reference_ns, weighed),
            RuleMethod::Candidates(_) => self.gather_states(system, reference_ns, weighed),
        }
    }

    /// The contributions to `system` in the order of their sources, with the share in the filter, and without further
    /// content unless accuracy values are wanted.
    fn gather_shares(&self, system: SystemSlot, reference_ns: i64, weighed: &mut Weighed) {
        let sensors = &self.tracks.sensors;
        let keys = &mut weighed.keys;
        let mut len = 0;
        for (member, entry) in self.tracks.member_entries(system) {
            if entry.is_foreign {
                weighed.has_centres = true;
                continue;
            }
            if !self.tracks.contributes(entry, reference_ns) {
                continue;
            }
            weighed.contributing += 1;
            if len == CONTRIBUTIONS_MAX {
                if source_of(keys[0]) < entry.source {
                    continue;
                }
                keys.rotate_left(1);
                len -= 1;
            }
            let key = u64::from(entry.source) << 48 | u64::from(weighed.contributing) << 32 | u64::from(member);
            // Few members, and mostly from the last source to the first, since the newest member comes first: each goes
            // to its place at once.
            let mut place = len;
            while place > 0 && keys[place - 1] < key {
                keys[place] = keys[place - 1];
                place -= 1;
            }
            keys[place] = key;
            len += 1;
        }
        weighed.len = len;
        weighed.stated = Stated::default();
        let places = weighed.members.iter_mut().zip(&mut weighed.candidates);
        for ((member, candidate), key) in places.zip(keys[..len].iter().rev()) {
            *member = *key as SensorSlot;
            let entry = sensors.get(*member);
            weighed.stated.add(entry);
            candidate.source = source_of(*key);
            candidate.filter_share = entry.share;
            candidate.lambda = f64::INFINITY;
        }
        if self.settings.accuracy_values() {
            self.value_shares(reference_ns, weighed);
        }
    }

    /// Computes the accuracy values of contributions to a filter.
    #[inline(never)]
    fn value_shares(&self, reference_ns: i64, weighed: &mut Weighed) {
        for (member, candidate) in weighed.members[..weighed.len].iter().zip(&mut weighed.candidates) {
            let latest = &self.tracks.sensors.get(*member).latest;
            let later_ns = reference_ns - latest.time_of_measurement_ns;
            let place_m = moved(latest.position_m, latest.velocity_mps, later_ns);
            candidate.alpha = self.alpha(latest, place_m, latest.velocity_mps);
            candidate.residual = self.residual(*member, reference_ns);
            candidate.state.has_height = latest.has(sensor_track_bits::HEIGHT);
        }
        weighed.value();
    }

    /// The contributions to `system`, in the order of their sources, brought to `reference_ns`.
    #[inline(never)]
    fn gather_states(&self, system: SystemSlot, reference_ns: i64, weighed: &mut Weighed) {
        let is_foreign = |member: SensorSlot| self.tracks.sensors.get(member).is_foreign;
        weighed.has_centres = self.tracks.members(system).any(is_foreign);
        for member in self.tracks.contributing_here(system, reference_ns) {
            weighed.push(member, self.candidate(member, reference_ns));
        }
        if self.settings.rule.hand_over.drop_out == DropOut::Blend {
            self.gather_stale(system, reference_ns, weighed);
        }
        weighed.collect_stated(self.tracks);
        weighed.value();
    }

    /// The last reports of sources being left, though no longer fresh (TI-15).
    fn gather_stale(&self, system: SystemSlot, reference_ns: i64, weighed: &mut Weighed) {
        let (sensors, memory) = (&self.tracks.sensors, self.tracks.systems.memory(system));
        for member in self.tracks.members(system) {
            let entry = sensors.get(member);
            let source = entry.latest.source;
            let wanted = entry.role == Role::Primary && !entry.is_foreign && memory.holds(source);
            let known = weighed.candidates().iter().any(|candidate| candidate.source == source);
            if wanted && !known && weighed.len < CONTRIBUTIONS_MAX {
                let candidate = Candidate {
                    stale: true,
                    ..self.candidate(member, reference_ns)
                };
                weighed.push(member, candidate);
            }
        }
    }

    /// The latest report of `member` at `reference_ns`: interpolated if later reports are available, else extrapolated
    /// (QF-6).
    fn state(&self, member: SensorSlot, reported: &State, reference_ns: i64) -> State {
        let between = || {
            self.tracks
                .sensors
                .histories
                .interpolated(member as usize, reference_ns)
        };
        if reported.time_ns > reference_ns
            && let Some((position_m, velocity_mps)) = between()
        {
            // Between two reports the target is known no worse than by either.
            return State {
                time_ns: reference_ns,
                position_m,
                velocity_mps,
                ..*reported
            };
        }
        reported.at(reference_ns, self.settings.process_noise_m2ps3)
    }

    /// Observation error coefficient (TI-8) of the source of this report for its target, with this place and velocity
    /// at the reference time.
    fn alpha(&self, report: &SensorTrack, position_m: [f64; 3], velocity_mps: [f64; 3]) -> f64 {
        let target = (position_m, velocity_mps);
        let stated = StatedAccuracy {
            covariance: &report.covariance,
            method: report.method,
        };
        self.accuracies.alpha(self.settings, report.source, target, stated)
    }

    /// V of `member` (TI-6). A track not yet confirmed by its source is scored like a track with a single report
    /// (TI-10): the velocity is a guess.
    fn residual(&self, member: SensorSlot, reference_ns: i64) -> Option<[f64; 3]> {
        let sensors = &self.tracks.sensors;
        let is_believed = sensors.get(member).latest.state != TrackState::Tentative as u8;
        let kind = self.settings.rule.residual;
        is_believed
            .then(|| sensors.histories.residual(member as usize, kind, reference_ns))
            .flatten()
    }

    /// Whether the next report of a sensor track is overdue by the rhythm of its target.
    fn is_overdue(&self, entry: &SensorEntry, reference_ns: i64) -> bool {
        let interval_ns = self.tracks.systems.get(entry.system).rhythm.interval_ns();
        (reference_ns - entry.time_ns) as f64 > self.settings.rule.overdue_periods * interval_ns as f64
    }

    fn candidate(&self, member: SensorSlot, reference_ns: i64) -> Candidate {
        let (settings, sensors) = (self.settings, &self.tracks.sensors);
        let entry = sensors.get(member);
        let latest = &entry.latest;
        let source = &settings.sources[usize::from(latest.source)];
        let state = self.state(member, &State::of_report(latest), reference_ns);
        let of_report = candidate_of(settings, latest, state, reference_ns);
        Candidate {
            alpha: self.alpha(latest, state.position_m, state.velocity_mps),
            residual: self.residual(member, reference_ns),
            quality: sensors.qualities.index(
                member as usize,
                reference_ns,
                source.period_ns,
                settings.rule.quality_scans,
            ),
            filter_share: entry.share,
            overdue: of_report.overdue && self.is_overdue(entry, reference_ns),
            ..of_report
        }
    }
}
