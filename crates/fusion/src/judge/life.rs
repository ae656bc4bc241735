//! Life of a system track: tentative, confirmed, coasted, suspended, terminated (QF-8), by evidence if available.
//!
//! A track becomes tentative with its first report, and confirmed with sufficient evidence. A confirmed track coasts
//! after a while without reports, and is suspended a life time after the last report. A suspended track is not shown,
//! but its number rests for `numbers.rest_s`; a returning target resumes the track (module `resumption`). A track ends
//! in any of five ways:
//!
//! - Without reports: a tentative track, never shown and without an identity for a return of its target, ends
//!   `tentative_ns` after its last report. Any other track ends after the rest of its number (module `lifetimes`
//!   derives the times from the sources' periods, module `rhythm` from the target's own intervals).
//! - Suspended, if too many others are suspended, or a new track needs the place.
//! - By a merge into another track (module `linking`).
//! - By an order (module `orders`).
//! - In a start from a checkpoint, if the stored track has become too old (module `restore`).
//!
//! A target missed by its sources despite coverage is withheld: its track is tentative until the next detection.

use messages::{Counter, DecisionKind, NO_SOURCE, NS_PER_S, SensorTrack, TrackState};
use serde::{Deserialize, Serialize};
use source_models::{Fact, FollowedTarget, LASTING_REPORTS, TargetFact};

use crate::associate::association_step::{SEARCH_CELLS_MAX, Search};
use crate::explanation::Sink;
use crate::judge::existence::{SingleSourceClaim, awaited, probability};
use crate::publish::outlet::Outlet;
use crate::publish::system_track_message::{publish_change, publish_extrapolated};
use crate::settings::{Settings, SourceSet, SourceSettings};
use crate::tables::sensor_tracks::SensorEntry;
use crate::tables::silent_tracks::SUSPENDED_MAX;
use crate::tables::system_tracks::{SystemEntry, SystemSlot};
use crate::tables::tracks::Tracks;

/// Time between two looks at the followers of a system track, nanoseconds.
const COVERAGE_EVERY_NS: i64 = 4_000_000_000;

/// Ineffective share of the silence for a track that teaches coverage: the silence rests on that coverage.
const UNTAUGHT: f64 = 0.3;
/// Distance within which another track of a source may be the source's track of the target, metres.
const NEAR_M: f64 = 1000.0;
/// Looks granted to every source with coverage before an unsupported claim is accepted.
const CHANCE_LOOKS: f64 = 1.0;
/// Time for which a second track beside a target waits for distinction from another point of the target, in periods of
/// the slowest source.
const PATIENCE_PERIODS: f64 = 30.0;
/// Waiting time of a track beside an earlier track of its sources from before a restart, in periods of the slowest
/// source.
const RESTART_PERIODS: f64 = 4.0;
/// Log-likelihood ratio of two sources in agreement if as many tracks are tentative as confirmed, and the exponent of
/// its decrease: so steep that a few tentative tracks delay no target.
const AGREEMENT: f64 = 2.0;
const AGREEMENT_FALLS: f64 = 5.0;
/// Reports to confirm a target with a matching identity (module `recognition`).
const RECOGNISED_REPORTS: u32 = 2;
/// Share of targets followed here below which a source need not be waited for.
const DETECTION_SELDOM: f64 = 0.1;

/// Times of looks at the deadlines of system tracks.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Life {
    /// Longest time without a look at a system track, nanoseconds, so a deadline can be put off but never missed.
    shortest_fresh_ns: i64,
}

/// Evidence for the target of a system track.
#[derive(Clone, Copy, Debug)]
struct ExistenceEvidence {
    /// Whether the target is believed to exist.
    is_believed: bool,
    /// Logarithm of the likelihood ratio of a target to a false track; NaN before the first evidence.
    log_ratio: f64,
    /// The same with a part of the silence: see [`UNTAUGHT`].
    teaching: f64,
    /// Whether every source with coverage had its chance.
    is_ripe: bool,
    /// Value of the decision: number of witnesses in agreement, or the ratio of a single claim.
    stated: f64,
}

impl ExistenceEvidence {
    /// Too few reports to weigh.
    const NONE: Self = Self {
        is_believed: false,
        log_ratio: f64::NAN,
        teaching: f64::NAN,
        is_ripe: false,
        stated: f64::NAN,
    };

    /// Beyond doubt.
    const fn certain(stated: f64) -> Self {
        Self {
            is_believed: true,
            log_ratio: f64::INFINITY,
            teaching: f64::INFINITY,
            is_ripe: true,
            stated,
        }
    }
}

impl Life {
    pub(crate) fn new(sources: &[SourceSettings]) -> Self {
        Self {
            shortest_fresh_ns: sources.iter().map(|source| source.fresh_ns).min().unwrap_or(1),
        }
    }

    /// The first deadline of a system track that starts at `time_ns`.
    pub(crate) fn first_deadline_ns(&self, time_ns: i64) -> i64 {
        time_ns + self.shortest_fresh_ns
    }

    /// Processes the earliest deadline before `time_ns`, without other events until then; `false` if there is none.
    pub(crate) fn run_timer_before<S: Sink>(
        &self,
        settings: &Settings,
        tracks: &mut Tracks,
        time_ns: i64,
        out: &mut Outlet<'_, S>,
    ) -> bool {
        let Some((deadline_ns, slot)) = tracks.systems.due_before(time_ns) else {
            return false;
        };
        if let Some(due_ns) = run_timer(settings, tracks, slot, deadline_ns, out) {
            let next_ns = due_ns.min(self.look_after(deadline_ns, time_ns));
            tracks.systems.put_back(slot, next_ns);
        } else {
            tracks.systems.free(slot);
        }
        true
    }

    /// Time of the next look at the deadline of a system track after a look at `looked_ns`, if no event can bring the
    /// deadline forward until `until_ns`. Looks are whole multiples of the shortest possible time to such an event
    /// apart.
    fn look_after(&self, looked_ns: i64, until_ns: i64) -> i64 {
        let step_ns = self.shortest_fresh_ns;
        let missing_ns = until_ns.saturating_sub(looked_ns).saturating_sub(1);
        let whole_ns = if missing_ns < step_ns {
            0
        } else {
            missing_ns - missing_ns % step_ns
        };
        looked_ns.saturating_add(whole_ns).saturating_add(step_ns)
    }
}

/// Confirms a system track after a contribution of a report, if the evidence is sufficient now.
pub(crate) fn update_existence<S: Sink>(
    settings: &Settings,
    tracks: &mut Tracks,
    (system, report): (SystemSlot, &SensorTrack),
    out: &mut Outlet<'_, S>,
) {
    let entry = tracks.systems.get(system);
    let now_ns = report.time_of_measurement_ns;
    match entry.life {
        TrackState::Coasted => {
            tracks.systems.set_life(system, TrackState::Confirmed);
            tracks
                .systems
                .get_mut(system)
                .add_evidence(settings.existence.persistence);
        }
        TrackState::Tentative => {
            let evidence = evidence(settings, tracks, system, now_ns);
            if now_ns >= entry.coverage_due_ns && evidence.is_ripe {
                learn_coverage(settings, tracks, (system, now_ns), probability(evidence.teaching));
            }
            tracks.systems.get_mut(system).log_odds = evidence.log_ratio;
            if evidence.is_believed && !may_be_another(settings, tracks, (system, now_ns)) {
                match leader_aside(settings, tracks, (system, now_ns)) {
                    None => confirm(tracks, system, (report, evidence.stated), out),
                    Some(leader) if (Search { settings, tracks }).may_be_large(system, now_ns) => {
                        confirm(tracks, leader, (report, evidence.stated), out);
                        publish_change(settings, tracks, leader, now_ns, out);
                    }
                    Some(_) => {}
                }
            }
        }
        TrackState::Confirmed => {
            let is_due = now_ns >= entry.coverage_due_ns;
            tracks
                .systems
                .get_mut(system)
                .add_evidence(settings.existence.persistence);
            if is_due {
                learn_coverage(settings, tracks, (system, now_ns), 1.0);
            }
        }
        TrackState::Suspended | TrackState::Terminated => {}
    }
    count_target(settings, tracks, system, now_ns);
}

/// Confirms a system track with a report.
fn confirm<S: Sink>(
    tracks: &mut Tracks,
    system: SystemSlot,
    (report, stated): (&SensorTrack, f64),
    out: &mut Outlet<'_, S>,
) {
    tracks.systems.set_life(system, TrackState::Confirmed);
    let first = !std::mem::replace(&mut tracks.systems.get_mut(system).was_shown, true);
    if first {
        out.count(report.source, Counter::TracksConfirmed);
    }
    let now_ns = report.time_of_measurement_ns;
    let decision = tracks.decision_on(system, DecisionKind::Confirmed, now_ns, stated);
    out.decision(&decision);
}

/// Weighs the evidence for the target of a system track.
fn evidence(settings: &Settings, tracks: &Tracks, system: SystemSlot, now_ns: i64) -> ExistenceEvidence {
    let (mut sources, mut reports, mut is_established) = (SourceSet::EMPTY, 0u32, false);
    for member in tracks.contributing(system, now_ns) {
        let entry = tracks.sensors.get(member);
        if entry.is_foreign && entry.latest.state == TrackState::Confirmed as u8 {
            // Another centre confirms the track, with any number of sensors.
            return ExistenceEvidence::certain(f64::NAN);
        }
        sources.insert(entry.source);
        is_established |= tracks.is_established(member);
        reports = reports.saturating_add(entry.reports);
    }
    let entry = tracks.systems.get(system);
    let is_recognised = entry.recognition.is_sure();
    let least = match is_recognised {
        true => settings.life.confirm_reports.min(RECOGNISED_REPORTS),
        false => settings.life.confirm_reports,
    };
    if !is_established || entry.recognition.is_doubted() {
        return ExistenceEvidence::NONE;
    }
    let search = Search { settings, tracks };
    if reports < least {
        // The tracks of other points are tracks of the same target.
        let is_enough = || reports.saturating_add(search.sources_aside(system, now_ns).1) >= least;
        if !search.may_be_large(system, now_ns) || !is_enough() {
            return ExistenceEvidence::NONE;
        }
    }
    let witnesses = tracks.sources.witnesses_among(sources);
    if witnesses >= 3 {
        return ExistenceEvidence::certain(f64::from(witnesses));
    }
    let (aside, reports_aside) = search.sources_aside(system, now_ns);
    let (silence, had_their_chance) = silence_of_others(settings, tracks, (system, now_ns), (sources, aside));
    let (purity, awaited) = match (witnesses, sources.iter().next()) {
        // A single source, not a copy of another source.
        (1, Some(source)) => {
            let period_s = settings.sources[usize::from(source)].period_ns as f64 / NS_PER_S;
            let false_share = tracks.sources.false_share(source);
            (tracks.sources.target_log_odds(source), awaited(period_s, false_share))
        }
        _ => (0.0, 0.0),
    };
    let claim = SingleSourceClaim {
        silence,
        purity,
        reports,
        has_address: entry.identity.unique_number().is_some(),
    };
    let agreement = if witnesses >= 2 {
        agreement_log_ratio(tracks)
    } else {
        0.0
    };
    let mut log_ratio = claim.log_ratio(&settings.existence) + agreement;
    let may_be_believed = witnesses >= 2 || reports_aside > 0 || had_their_chance || claim.has_address;
    let believes = |log_ratio| settings.existence.believes(log_ratio, awaited);
    // The search for a former target is long, and seldom decides.
    if may_be_believed && !believes(log_ratio) && believes(log_ratio + settings.existence.former) {
        log_ratio += return_log_ratio(settings, tracks, system, now_ns);
    }
    ExistenceEvidence {
        is_believed: is_recognised || may_be_believed && believes(log_ratio),
        log_ratio,
        teaching: log_ratio - UNTAUGHT * silence,
        is_ripe: had_their_chance,
        stated: if witnesses >= 2 {
            f64::from(witnesses)
        } else {
            log_ratio
        },
    }
}

/// Returns the log-likelihood ratio of a track that may be a former target, against a new target anywhere near; 0 for a
/// track that has been shown already.
fn return_log_ratio(settings: &Settings, tracks: &Tracks, system: SystemSlot, now_ns: i64) -> f64 {
    if tracks.systems.get(system).was_shown || tracks.systems.silent.is_empty() {
        return 0.0;
    }
    let former = Search { settings, tracks }.former(system, now_ns);
    former.map_or(0.0, |(_, ratio)| ratio.min(settings.existence.former))
}

/// Log-likelihood ratio of the silence of all sources but `sources` and those `aside`, and whether all of the silent
/// sources with coverage had a chance.
fn silence_of_others(
    settings: &Settings,
    tracks: &Tracks,
    (system, now_ns): (SystemSlot, i64),
    (sources, aside): (SourceSet, SourceSet),
) -> (f64, bool) {
    let entry = tracks.systems.get(system);
    let (filter, age_ns) = (&entry.filter, (now_ns - entry.first_seen_ns) as f64);
    let group_of = |source: u16| tracks.sources.group_of(source);
    let heard: SourceSet = sources.iter().map(group_of).collect();
    let (mut silence, mut had_their_chance) = (0.0, true);
    for (index, source) in settings.sources.iter().enumerate() {
        // The silence of a source about a target above the source's ceiling is no evidence.
        let may_see = !source.is_out && (!filter.has_height || filter.estimate.mean[2] <= source.ceiling_m);
        let is_silent = !heard.contains(group_of(index as u16))
            && !aside.contains(index as u16)
            && tracks.sources.is_witness_beside(index as u16, sources);
        if is_silent && may_see && !source.is_centre {
            let place_m = filter.estimate.position_m();
            let Some(detection) = tracks.sources.follows_at(index as u16, place_m, now_ns) else {
                continue;
            };
            // The reports of the last seconds may not have come yet.
            let looks = match tracks.sources.late_ns(index as u16) {
                0 => age_ns,
                late_ns => (age_ns - late_ns as f64).max(0.0),
            } / source.period_ns as f64;
            silence += (1.0 - detection.shown * looks.min(1.0)).ln();
            had_their_chance &= detection.assumed < DETECTION_SELDOM || looks >= CHANCE_LOOKS;
        }
    }
    (silence, had_their_chance)
}

/// Teaches the coverage of sources from a system track with the probability of existence `existence`.
fn learn_coverage(settings: &Settings, tracks: &mut Tracks, (system, now_ns): (SystemSlot, i64), existence: f64) {
    let sources = tracks.sources_of(system, now_ns);
    let entry = tracks.systems.get_mut(system);
    entry.coverage_due_ns = now_ns.saturating_add(COVERAGE_EVERY_NS);
    let age_ns = now_ns - entry.first_seen_ns;
    let place_m = entry.filter.estimate.position_m();
    let [x, y, _] = place_m;
    // A source with another track near by may follow the target there: the source is left out.
    let mut near = SourceSet::EMPTY;
    tracks.systems.grid.near(x, y, NEAR_M, SEARCH_CELLS_MAX, |other| {
        near |= tracks.sources_of(other, now_ns);
    });
    let is_known = |(source, settings): &(u16, &SourceSettings)| {
        let is_asked = !near.contains(*source) && age_ns >= settings.period_ns;
        !settings.is_out && (sources.contains(*source) || is_asked)
    };
    let known = (0..).zip(&settings.sources).filter(is_known);
    let asked = known.map(|(source, _)| source).collect();
    let target = FollowedTarget {
        time_ns: now_ns,
        place_m,
        existence,
        follows: sources,
        asked,
    };
    tracks
        .sources
        .learn(settings, Fact::Target(TargetFact::Followed(target)));
}

/// Counts a system track as a target, once, in the purity of its sources: after the agreement of two sources on a
/// confirmed track, or after enough reports.
#[inline]
fn count_target(settings: &Settings, tracks: &mut Tracks, system: SystemSlot, now_ns: i64) {
    if !tracks.systems.get(system).is_counted {
        count_target_if_sure(settings, tracks, system, now_ns);
    }
}

#[inline(never)]
fn count_target_if_sure(settings: &Settings, tracks: &mut Tracks, system: SystemSlot, now_ns: i64) {
    let entry = tracks.systems.get(system);
    let sources = tracks.sources_of(system, now_ns);
    let agree = entry.life == TrackState::Confirmed && tracks.sources.witnesses_among(sources) >= 2;
    if !agree && entry.reports < LASTING_REPORTS {
        return;
    }
    tracks.systems.get_mut(system).is_counted = true;
    for source in sources.iter() {
        tracks.sources.learn(
            settings,
            Fact::Target(TargetFact::Proved {
                source,
                is_target: true,
            }),
        );
    }
}

/// Counts a system track of a single source as no target, once, after the end of its reports.
fn count_false(settings: &Settings, tracks: &mut Tracks, system: SystemSlot) {
    let entry = tracks.systems.get_mut(system);
    let mut contributors = entry.contributors.iter();
    let only = contributors.next().filter(|_| contributors.next().is_none());
    if let Some(source) = only.filter(|_| !entry.is_counted) {
        entry.is_counted = true;
        tracks.sources.learn(
            settings,
            Fact::Target(TargetFact::Proved {
                source,
                is_target: false,
            }),
        );
    }
}

/// Returns the log-likelihood ratio of two sources in agreement: the more unconfirmed tracks there are relative to
/// confirmed tracks, the more often two coincide by chance.
fn agreement_log_ratio(tracks: &Tracks) -> f64 {
    let count = |state| tracks.systems.count_in_state(state) as f64;
    let others = count(TrackState::Tentative) - 1.0;
    let share = others / (count(TrackState::Confirmed) + count(TrackState::Coasted)).max(1.0);
    AGREEMENT - AGREEMENT_FALLS * share.clamp(0.01, 1.0).ln()
}

/// Returns whether the target of a tentative track may be a confirmed target, seen by the other sources at another
/// point, while a later merge of the two is undecided.
fn may_be_another(settings: &Settings, tracks: &Tracks, (system, now_ns): (SystemSlot, i64)) -> bool {
    let entry = tracks.systems.get(system);
    let patience_s = PATIENCE_PERIODS * settings.longest_period_s();
    let search = Search { settings, tracks };
    let is_patient = (now_ns - entry.first_seen_ns) as f64 <= patience_s * NS_PER_S;
    let is_nameless = entry.identity.unique_number().is_none() && !entry.is_foreign;
    let is_new = is_new(settings, entry, now_ns);
    is_nameless
        && (is_patient && search.is_shown_already(system, now_ns)
            || search.is_shown_elsewhere(system, now_ns)
            || is_new && search.was_followed(system, now_ns)
            || search.is_shown_aside(system, now_ns, is_new))
}

/// Whether a system track began so recently that its sources may have restarted.
fn is_new(settings: &Settings, entry: &SystemEntry, now_ns: i64) -> bool {
    (now_ns - entry.first_seen_ns) as f64 <= RESTART_PERIODS * settings.longest_period_s() * NS_PER_S
}

/// Returns the track to be shown in place of a new tentative track: another point of the same target, of a source that
/// comes first.
fn leader_aside(settings: &Settings, tracks: &Tracks, (system, now_ns): (SystemSlot, i64)) -> Option<SystemSlot> {
    let entry = tracks.systems.get(system);
    let may_follow = entry.identity.unique_number().is_none() && !entry.is_foreign && is_new(settings, entry, now_ns);
    may_follow
        .then(|| Search { settings, tracks }.leader_aside(system, now_ns))
        .flatten()
}

/// Lets a system track with a due deadline coast, rest or terminate. Returns the next deadline; `None` after
/// termination.
fn run_timer<S: Sink>(
    settings: &Settings,
    tracks: &mut Tracks,
    slot: SystemSlot,
    deadline_ns: i64,
    out: &mut Outlet<'_, S>,
) -> Option<i64> {
    let entry = tracks.systems.get(slot);
    let tentative_ns = match settings.life.tentative_s {
        Some(stated) => stated.ns(),
        None => tracks.sources.tentative_ns().max(entry.rhythm.fresh_ns()),
    };
    let (coast_ns, last_ns) = (entry.fresh_until_ns, entry.last_report_ns);
    let end_ns = ends_at(tracks, slot);
    let due_ns = match entry.life {
        TrackState::Terminated => return None,
        TrackState::Tentative if entry.was_shown => end_ns,
        TrackState::Tentative => last_ns.saturating_add(tentative_ns),
        TrackState::Confirmed => coast_ns,
        TrackState::Coasted => end_ns,
        TrackState::Suspended => rests_until(settings, tracks, slot, entry.is_known),
    };
    if deadline_ns < due_ns {
        return Some(due_ns);
    }
    if entry.life == TrackState::Confirmed && coast_ns < end_ns {
        tracks.systems.set_life(slot, TrackState::Coasted);
        out.decision(&tracks.decision_on(slot, DecisionKind::Coasted, deadline_ns, f64::NAN));
        publish_change(settings, tracks, slot, deadline_ns, out);
        return Some(end_ns);
    }
    let may_rest = entry.life != TrackState::Suspended && settings.numbers.rest_s.ns() > 0;
    let is_known = may_rest && is_known(tracks, slot);
    if may_rest && (entry.was_shown || is_known) {
        tracks.systems.get_mut(slot).is_known = is_known;
        suspend(settings, tracks, slot, deadline_ns, out);
        return Some(rests_until(settings, tracks, slot, is_known));
    }
    end(settings, tracks, slot, deadline_ns, 0, out);
    None
}

/// When a confirmed system track without further reports ends, nanoseconds.
fn ends_at(tracks: &Tracks, slot: SystemSlot) -> i64 {
    let entry = tracks.systems.get(slot);
    // Only certain targets have gaps; the display of a false track is not prolonged.
    let usual_ns = match entry.is_counted {
        true => tracks.sources.silence_of(entry.contributors),
        false => tracks.sources.terminate_ns(),
    };
    let terminate_ns = tracks.sources.silence_at(entry.rhythm, usual_ns);
    entry.last_report_ns.saturating_add(terminate_ns)
}

/// Time until which a target may resume the number of a silent system track, nanoseconds: by identity, or else by
/// motion alone.
pub(crate) fn rests_until(settings: &Settings, tracks: &Tracks, slot: SystemSlot, by_identity: bool) -> i64 {
    let numbers = &settings.numbers;
    let rest_ns = match by_identity {
        true => numbers.rest_s.ns().max(numbers.identity_rest_s.ns()),
        false => numbers.rest_s.ns(),
    };
    ends_at(tracks, slot).saturating_add(rest_ns)
}

/// Whether the target of a resting system track can return by identity: by its address, or by the number of a sensor
/// track confirmed by its source. The number is valid for this time only with long expected silences: sources reuse
/// numbers for other targets.
fn is_known(tracks: &Tracks, slot: SystemSlot) -> bool {
    let entry = tracks.systems.get(slot);
    let is_believed = |member: &SensorEntry| member.latest.state == TrackState::Confirmed as u8;
    let is_seldom = !entry.was_shown || entry.rhythm.is_slow();
    entry.identity.unique_number().is_some()
        || is_seldom && tracks.member_entries(slot).any(|(_, member)| is_believed(member))
}

/// Removes a system track without reports from the picture and lets its number rest.
fn suspend<S: Sink>(settings: &Settings, tracks: &mut Tracks, slot: SystemSlot, now_ns: i64, out: &mut Outlet<'_, S>) {
    if tracks.systems.count_in_state(TrackState::Suspended) >= SUSPENDED_MAX
        && let Some(oldest) = tracks.systems.longest_suspended(None)
    {
        end(settings, tracks, oldest, now_ns, 0, out);
    }
    tracks.suspend(slot);
    // A track with an address, never shown so far, may still turn out to be a target.
    let entry = tracks.systems.get(slot);
    if entry.was_shown || entry.identity.unique_number().is_none() {
        count_false(settings, tracks, slot);
    }
    out.decision(&tracks.decision_on(slot, DecisionKind::Suspended, now_ns, f64::NAN));
    publish_extrapolated(settings, tracks, slot, now_ns, out);
}

/// Counts a miss of a contributing source with an expected target, the last of `misses` in a row.
pub(crate) fn count_miss<S: Sink>(
    settings: &Settings,
    tracks: &mut Tracks,
    (system, report, misses): (SystemSlot, &SensorTrack, u32),
    out: &mut Outlet<'_, S>,
) {
    let source = report.source;
    let entry = tracks.systems.get_mut(system);
    if entry.life == TrackState::Tentative {
        return;
    }
    tracks.sources.learn(
        settings,
        Fact::Scan {
            source,
            is_detected: false,
        },
    );
    if misses <= settings.existence.misses {
        entry.absence += (1.0 - tracks.sources.detection(source)).ln();
    }
    if entry.absence < settings.existence.gone {
        suppress(settings, tracks, system, report.time_of_measurement_ns, out);
    }
}

/// Makes a system track tentative again after its sources lost the target: the track is withheld until the next
/// detection.
#[cold]
pub(crate) fn suppress<S: Sink>(
    settings: &Settings,
    tracks: &mut Tracks,
    system: SystemSlot,
    now_ns: i64,
    out: &mut Outlet<'_, S>,
) {
    let entry = tracks.systems.get(system);
    if !matches!(entry.life, TrackState::Confirmed | TrackState::Coasted) {
        return;
    }
    let absence = entry.absence;
    tracks.systems.set_life(system, TrackState::Tentative);
    out.decision(&tracks.decision_on(system, DecisionKind::Withheld, now_ns, absence));
    publish_change(settings, tracks, system, now_ns, out);
}

/// Publishes the present state of a system track.
pub(crate) fn publish<S: Sink>(settings: &Settings, tracks: &mut Tracks, slot: SystemSlot, out: &mut Outlet<'_, S>) {
    let time_ns = tracks.systems.get(slot).state.time_ns;
    publish_change(settings, tracks, slot, time_ns, out);
}

/// Terminates a system track together with its remaining, stale sensor tracks.
pub(crate) fn end<S: Sink>(
    settings: &Settings,
    tracks: &mut Tracks,
    slot: SystemSlot,
    now_ns: i64,
    merged_into: u32,
    out: &mut Outlet<'_, S>,
) {
    while let Some(member) = tracks.systems.get(slot).members {
        tracks.drop_sensor_track(member);
    }
    tracks.systems.end(slot);
    tracks.kept.forget(slot);
    tracks.systems.get_mut(slot).merged_into = merged_into;
    if merged_into == 0 {
        count_false(settings, tracks, slot);
    }
    out.count(NO_SOURCE, Counter::TracksTerminated);
    out.decision(&tracks.decision_on(slot, DecisionKind::Ended, now_ns, f64::NAN));
    publish_extrapolated(settings, tracks, slot, now_ns, out);
}
