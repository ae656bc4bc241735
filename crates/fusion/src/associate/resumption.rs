//! Targets that come back, and their former numbers.
//!
//! A system track without reports is suspended, and its number rests (module `life`): for `numbers.rest_s`, and for a
//! target that comes back with its identity for `numbers.identity_rest_s`. A target that comes back must
//! resume the number, and a new target must not. There are three kinds of evidence:
//!
//! - An address: the sensor track joins the system track of its address, suspended or not (module `linking`).
//! - The number of the sensor track at its source; the source may have given the number to another target since.
//! - Motion, with a code or a call sign if there is one. A first report has no velocity worth a comparison. A new
//!   system track is therefore compared at its confirmation, before it is first shown, and then takes over the former
//!   number. Coasted tracks are compared as well: a search by place does not find their expected places.
//!
//! The measure is a likelihood ratio: the former target, against a new target anywhere near, with any velocity
//! ([`NEW_TARGETS`]). The former target has flown straight on, or has manoeuvred as targets do ([`MANOEUVRE_MPS2`]).
//! The longer the silence, the wider is the likelihood of the former target, and the smaller the ratio: a track with
//! an uncertain state takes no newcomers in, however wide its gate would be. If two candidates are nearly equally
//! likely, neither is chosen: a new number is better than a wrong number.

use estimation::{ComparedComponents, Gaussian, statistical_distance};
use messages::{
    Counter, Covariance, Decision, DecisionKind, Identity, NO_SOURCE, NS_PER_S, SensorTrack, TrackState,
    sensor_track_bits,
};
use nalgebra::Matrix4;
use source_models::{Fact, ReportFact, gaussian_of};

use crate::associate::association_step::{SEARCH_CELLS_MAX, Search};
use crate::associate::identity;
use crate::engine::Engine;
use crate::explanation::Sink;
use crate::judge::life;
use crate::settings::IdentitySettings;
use crate::tables::sensor_tracks::SensorSlot;
use crate::tables::system_tracks::{Bond, SystemEntry, SystemSlot};

/// Density of new targets: one in a square of 20 km, with any velocity up to 250 m/s, in 1/(m² · (m/s)²).
const NEW_TARGETS: f64 = 1.0 / (400e6 * 196_350.0);
/// Logarithm of the least likelihood ratio of the former target to a new target.
const LEAST_RATIO: f64 = 4.6;
/// Logarithm of the least ratio of the likelihoods of two candidates.
const LEAST_MARGIN: f64 = 3.0;
/// Logarithms of the likelihood ratio of equal track numbers at a source, call signs and Mode 3/A codes.
const EQUAL_NUMBER: f64 = 6.9;
const EQUAL_CALLSIGN: f64 = 8.0;
const EQUAL_CODE: f64 = 5.7;
/// Probability of a manoeuvre of a silent target, and standard deviation of the mean acceleration in a manoeuvre.
const MANOEUVRES: f64 = 0.2;
const MANOEUVRE_MPS2: f64 = 1.0;
/// Rate of climb assumed for changes of height during a silence, m/s.
const CLIMB_MPS: f64 = 15.0;
/// Variance added to a difference of velocities, m²/s²: a tracker's first velocities lag.
const VELOCITY_FLOOR_M2PS2: f64 = 25.0;
/// Half-width of the search for other new targets at the expected place of a former target, metres.
const RIVALS_M: f64 = 5e3;

impl Search<'_> {
    /// Logarithm of the likelihood ratio that a sensor track is the target of the suspended `system`, which had a
    /// member with the same number; `None` if that is excluded.
    pub(crate) fn number_resumes(&self, own: SensorSlot, system: SystemSlot) -> Option<f64> {
        let report = &self.tracks.sensors.get(own).latest;
        let height_m = report.has(sensor_track_bits::HEIGHT).then_some(report.position_m[2]);
        let newcomer = Newcomer {
            time_ns: report.time_of_measurement_ns,
            state: gaussian_of(report),
            height_m,
            identity: &report.identity,
        };
        let ratio = self.ratio(&newcomer, system)? + EQUAL_NUMBER;
        let is_later = newcomer.time_ns > self.tracks.systems.get(system).last_report_ns;
        (is_later && ratio >= LEAST_RATIO).then_some(ratio)
    }

    /// The silent system track with the same target as the new system track `own`, and the logarithm of the likelihood
    /// ratio.
    pub(crate) fn former(&self, own: SystemSlot, now_ns: i64) -> Option<(SystemSlot, f64)> {
        let entry = self.tracks.systems.get(own);
        let newcomer = self.newcomer(entry, now_ns);
        let [x, y, _, vx, vy, _] = newcomer.state.mean;
        let (mut best, mut second) = ((f64::NEG_INFINITY, 0, own), f64::NEG_INFINITY);
        for silent in self.tracks.systems.silent.near([x, y], [vx, vy], now_ns) {
            let Some(ratio) = self.ratio_of(entry, &newcomer, silent) else {
                continue;
            };
            let number = self.tracks.systems.get(silent).number;
            if (ratio, number) > (best.0, best.1) {
                second = best.0;
                best = (ratio, number, silent);
            } else {
                second = second.max(ratio);
            }
        }
        let (ratio, _, former) = best;
        // Written so that NaN is refused.
        let is_sure = ratio >= LEAST_RATIO && ratio - second >= LEAST_MARGIN;
        (is_sure && !self.has_rival(own, former, (ratio, now_ns))).then_some((former, ratio))
    }

    /// Whether another new target may be the target of `former` with nearly the likelihood of `own`.
    fn has_rival(&self, own: SystemSlot, former: SystemSlot, (ratio, now_ns): (f64, i64)) -> bool {
        let systems = &self.tracks.systems;
        let [x, y, _] = systems.get(own).filter.estimate.position_m();
        let mut has_rival = false;
        systems.grid.near(x, y, RIVALS_M, SEARCH_CELLS_MAX, |other| {
            if other == own || other == former {
                return;
            }
            let entry = systems.get(other);
            let theirs = self.ratio_of(entry, &self.newcomer(entry, now_ns), former);
            has_rival |= theirs.is_some_and(|theirs| theirs > ratio - LEAST_MARGIN);
        });
        has_rival
    }

    fn newcomer<'b>(&self, entry: &'b SystemEntry, now_ns: i64) -> Newcomer<'b> {
        let state = entry
            .filter
            .at(now_ns, self.tracks.sources.motion(entry.filter.velocity_mps()));
        Newcomer {
            time_ns: now_ns,
            height_m: entry.filter.has_height.then_some(state.mean[2]),
            state,
            identity: &entry.identity,
        }
    }

    /// The ratio of a system track that began after the last report of the silent track, which contributes no more.
    fn ratio_of(&self, entry: &SystemEntry, newcomer: &Newcomer<'_>, silent: SystemSlot) -> Option<f64> {
        let theirs = self.tracks.systems.get(silent);
        let is_over = self.tracks.contributing(silent, newcomer.time_ns).next().is_none()
            && newcomer.time_ns <= life::rests_until(self.settings, self.tracks, silent, false);
        let is_apart = entry.bond != Bond::Free || theirs.bond == Bond::Apart(entry.number);
        if entry.first_seen_ns <= theirs.last_report_ns || !is_over || is_apart {
            return None;
        }
        self.ratio(newcomer, silent)
    }

    /// Logarithm of the likelihood ratio of the former target to a new target.
    fn ratio(&self, newcomer: &Newcomer<'_>, silent: SystemSlot) -> Option<f64> {
        let entry = self.tracks.systems.get(silent);
        let silence_s = ((newcomer.time_ns - entry.last_report_ns) as f64 / NS_PER_S).max(0.0);
        let uses_identity = self.settings.association.use_identity;
        let exponents = &self.settings.association.exponents;
        if uses_identity && identity::contradict(newcomer.identity, &entry.identity, exponents) {
            return None;
        }
        let state = entry.filter.at(
            newcomer.time_ns,
            self.tracks.sources.motion(entry.filter.velocity_mps()),
        );
        if let Some(height_m) = newcomer.height_m
            && entry.filter.has_height
            && (height_m - entry.filter.estimate.mean[2]).abs()
                > self.settings.association.height_gate_m + CLIMB_MPS * silence_s
        {
            return None;
        }
        let known = if uses_identity {
            equal_identity(newcomer.identity, &entry.identity, &self.settings.identity)
        } else {
            0.0
        };
        let spread_m2 = self.tracks.sources.spread_m2(&self.settings.association, None);
        let straight = log_density(&newcomer.state, &state, [spread_m2, VELOCITY_FLOOR_M2PS2]);
        let change_mps = MANOEUVRE_MPS2 * silence_s;
        let turned_m2 = (0.5 * change_mps * silence_s).powi(2);
        let floors = [spread_m2 + turned_m2, VELOCITY_FLOOR_M2PS2 + change_mps * change_mps];
        let turned = log_density(&newcomer.state, &state, floors);
        let either = ((1.0 - MANOEUVRES) * straight.exp() + MANOEUVRES * turned.exp()).ln();
        Some(either - NEW_TARGETS.ln() + known)
    }
}

/// A newly appeared target.
struct Newcomer<'a> {
    time_ns: i64,
    state: Gaussian,
    height_m: Option<f64>,
    identity: &'a Identity,
}

/// Logarithm of the likelihood ratio of equal codes or call signs.
fn equal_identity(one: &Identity, other: &Identity, settings: &IdentitySettings) -> f64 {
    let callsign = one
        .callsign()
        .is_some_and(|callsign| other.callsign() == Some(callsign));
    let code = one
        .mode_3a()
        .is_some_and(|code| other.mode_3a() == Some(code) && !settings.is_shared(code));
    match (callsign, code) {
        (true, _) => EQUAL_CALLSIGN,
        (false, true) => EQUAL_CODE,
        (false, false) => 0.0,
    }
}

/// Logarithm of the density of the difference of two states in the plane, position and velocity, with variances added
/// per axis of both.
fn log_density(one: &Gaussian, other: &Gaussian, [position_m2, velocity_m2ps2]: [f64; 2]) -> f64 {
    let mut wider = *one;
    for axis in 0..2 {
        wider.covariance.upper[Covariance::index(axis, axis)] += position_m2;
        wider.covariance.upper[Covariance::index(axis + 3, axis + 3)] += velocity_m2ps2;
    }
    let d2 = statistical_distance(&wider, other, ComparedComponents::HorizontalPositionAndVelocity);
    let components = [0, 1, 3, 4];
    let sum = |row: usize, column: usize| {
        let (row, column) = (components[row], components[column]);
        wider.covariance.get(row, column) + other.covariance.get(row, column)
    };
    let determinant = Matrix4::from_fn(sum).determinant();
    -0.5 * (d2 + determinant.ln()) - 2.0 * std::f64::consts::TAU.ln()
}

impl Engine {
    /// Resumes the suspended system track of a sensor track, which has just joined it with `report`.
    #[cold]
    pub(crate) fn resume_number(&mut self, sensor: SensorSlot, report: &SensorTrack, sink: &mut impl Sink) {
        let system = self.tracks.sensors.get(sensor).system;
        let decision = self.tracks.decision(sensor, DecisionKind::Resumed, f64::NAN, f64::NAN);
        let out = &mut self.outbox.to(sink);
        out.decision(&decision);
        out.count(NO_SOURCE, Counter::NumbersResumed);
        let entry = self.tracks.systems.get(system);
        let silence_ns = report.time_of_measurement_ns - entry.last_report_ns;
        let (was_shown, reports, first_seen_ns) = (entry.was_shown, entry.reports, entry.first_seen_ns);
        if was_shown && !entry.rhythm.is_slow() {
            self.tracks.sources.learn(
                &self.settings,
                Fact::Report(ReportFact::Gap {
                    source: report.source,
                    gap_ns: silence_ns,
                }),
            );
        }
        if !was_shown {
            self.recognise(sensor, system);
        }
        // The number at the source has served, whatever the evidence for the return was.
        self.tracks.recall(sensor, true);
        let shown_ns = self.tracks.systems.get(system).state.time_ns;
        self.tracks.for_members(system, |member| member.share = 0.0);
        self.tracks.restart_filter(sensor);
        self.outbox.to(sink).input(|| self.tracks.input(sensor, None));
        let entry = self.tracks.sensors.get_mut(sensor);
        entry.share = 1.0;
        let started_ns = entry.started_ns;
        let life = match was_shown {
            true => TrackState::Coasted,
            false => TrackState::Tentative,
        };
        self.tracks.systems.set_life(system, life);
        self.tracks.systems.forget_state(system);
        let entry = self.tracks.systems.get_mut(system);
        if entry.state.time_ns < shown_ns {
            entry.state = entry.state.at(shown_ns, self.settings.process_noise_m2ps3);
        }
        (entry.first_seen_ns, entry.astray, entry.duplicate) = (started_ns, 0, None);
        entry.point_source = NO_SOURCE;
        if !was_shown {
            // The earlier reports count for the confirmation, which is still to come.
            (entry.first_seen_ns, entry.is_counted) = (first_seen_ns, false);
            let sensor = self.tracks.sensors.get_mut(sensor);
            sensor.reports = sensor.reports.saturating_add(reports);
        }
        self.tracks.assign_role(sensor);
        self.update(sensor, report, None, sink);
    }

    /// Gives the new system track of a sensor track, confirmed at `now_ns`, the number of a silent system track of the
    /// same target, if any.
    #[cold]
    pub(crate) fn take_former_number(&mut self, sensor: SensorSlot, now_ns: i64, sink: &mut impl Sink) {
        let own = self.tracks.sensors.get(sensor).system;
        let search = Search {
            settings: &self.settings,
            tracks: &self.tracks,
        };
        let Some((former, ratio)) = search.former(own, now_ns) else {
            return;
        };
        let SystemEntry {
            number,
            identity,
            bond,
            ownership,
            reports,
            state,
            ..
        } = *self.tracks.systems.get(former);
        let entry = self.tracks.systems.get_mut(own);
        let young = entry.number;
        (entry.bond, entry.ownership) = (bond, ownership);
        entry.reports = entry.reports.saturating_add(reports);
        let shown = entry.state;
        if entry.state.time_ns < state.time_ns {
            entry.state = entry.state.at(state.time_ns, self.settings.process_noise_m2ps3);
        }
        // A process that dies here leaves two tracks of the same number; the next process drops the silent track.
        self.tracks.renumber(own, number);
        let entry = self.tracks.systems.get_mut(former);
        (entry.number, entry.state, entry.bond, entry.kept_ns) = (young, shown, Bond::Free, i64::MIN);
        let out = &mut self.outbox.to(sink);
        // Inputs from before the silence are no evidence for the path afterwards.
        out.input(|| self.tracks.input(sensor, None));
        out.decision(&Decision {
            time_ns: now_ns,
            kind: DecisionKind::Resumed.code(),
            system_track: number,
            other_system_track: young,
            value: ratio,
            limit: LEAST_RATIO,
            ..Decision::default()
        });
        out.count(NO_SOURCE, Counter::NumbersResumed);
        let ended_ns = now_ns.max(shown.time_ns);
        life::end(&self.settings, &mut self.tracks, former, ended_ns, number, out);
        self.tracks.systems.identify(own, &identity);
    }

    /// Ends a suspended system track, so that `source` can start a new one in its place.
    #[cold]
    pub(crate) fn make_room(&mut self, source: u16, sink: &mut impl Sink) {
        let Some(oldest) = self.tracks.systems.longest_suspended(Some(source)) else {
            return;
        };
        let end_ns = self.schedule.now_ns();
        let out = &mut self.outbox.to(sink);
        life::end(&self.settings, &mut self.tracks, oldest, end_ns, 0, out);
        self.tracks.systems.vacate(oldest, source);
    }
}
