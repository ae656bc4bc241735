//! Deciding which system track a report belongs to (TI-3).
//!
//! The obvious answer, "the nearest", flickers: of two aircraft side by side, noise makes now one, now the other the
//! nearest. So a sensor track, once joined, *stays*: sensors track their targets well, and their track numbers carry
//! more evidence than one position. It leaves only when
//! - its identity says so: an address belongs to exactly one system track, and the other way round;
//! - it has missed the rest of its system track by more than the keep gate several reports in a row (a wrong join, or
//!   the sensor has swapped targets);
//! - it is alone on its system track and has found the same other one several reports in a row (one target that was
//!   started twice).
//!
//! A report without a system track looks for one by address, then by place: among the system tracks near it, the one
//! with the smallest statistical distance of position and velocity inside the gates. A system track takes one sensor
//! track of a source. A further one of that source within the extent of the target is taken for another part of the
//! same target (surface radars break large aircraft up) and recognised, not used.

use association::distance;
use messages::{SensorTrack, sensor_track_bits};

use crate::sensor_tracks::{Role, SensorSlot, SensorTracks};
use crate::settings::Settings;
use crate::state::State;
use crate::system_tracks::{SystemSlot, SystemTracks};

/// Most cells of the grid along one side of a search.
const SEARCH_CELLS_MAX: i32 = 16;

/// Variance added to a difference of velocities, m²/s²: smoothing lags in turns, whatever a source claims.
const VELOCITY_FLOOR_M2PS2: f64 = 4.0;

/// Variance added to a difference of heights, m²: pressure altitude comes in steps of 100 ft, and drifts with the weather.
const HEIGHT_FLOOR_M2: f64 = 900.0;

/// What a search needs to look at, borrowed from the engine.
pub(crate) struct Search<'a> {
    pub(crate) settings: &'a Settings,
    pub(crate) sensors: &'a SensorTracks,
    pub(crate) systems: &'a SystemTracks,
}

/// How far a report is from a system track.
#[derive(Clone, Copy, Debug)]
struct Fit {
    /// d² of position, of velocity, and of height where both know it.
    cost: f64,
    /// d² of position.
    position: f64,
    /// d² of velocity.
    velocity: f64,
    /// d² of height; 0 where a side knows none.
    height: f64,
    /// Horizontal distance, metres.
    metres: f64,
}

impl Search<'_> {
    /// The system track that `report` (stored in `own`) fits best, without regard to address, other than `not`.
    pub(crate) fn best(&self, report: &SensorTrack, own: SensorSlot, not: Option<SystemSlot>) -> Option<SystemSlot> {
        let settings = &self.settings.association;
        let state = State::of_report(report);
        let sigma = distance::largest_sigma2(state.horizontal()).hypot(settings.extent_sigma_m);
        // The track's own uncertainty and the spread of its members are covered by at least half a cell.
        let reach = (settings.join_gate.sqrt() * sigma).max(settings.target_extent_m) + 0.5 * settings.cell_m;
        let mut best: Option<(f64, u32, SystemSlot)> = None;
        self.systems.grid.near(
            report.position_m[0],
            report.position_m[1],
            reach,
            SEARCH_CELLS_MAX,
            |system| {
                if Some(system) == not {
                    return;
                }
                let Some(cost) = self.join_cost(report, &state, own, system) else {
                    return;
                };
                let number = self.systems.get(system).number;
                if best.is_none_or(|(least, least_number, _)| (cost, number) < (least, least_number)) {
                    best = Some((cost, number, system));
                }
            },
        );
        best.map(|(_, _, system)| system)
    }

    /// What it costs `report` to join `system`; `None` if it may not.
    fn join_cost(&self, report: &SensorTrack, state: &State, own: SensorSlot, system: SystemSlot) -> Option<f64> {
        let settings = &self.settings.association;
        if self.contradicts(report, system) || !self.can_be_seen_together(report, system) {
            return None;
        }
        let now_ns = report.time_of_measurement_ns;
        let fit = self.fit(state, system, own)?;
        let near = match self.speaker(system, report.source, own, now_ns) {
            Some(_) => fit.metres <= settings.target_extent_m && fit.height <= settings.join_gate,
            None => fit.position <= settings.join_gate,
        };
        (near && fit.velocity <= settings.velocity_gate).then_some(fit.cost)
    }

    /// Best fit of `state` to the fresh primaries of `system` other than `own`; to its carried-on state if none is fresh.
    fn fit(&self, state: &State, system: SystemSlot, own: SensorSlot) -> Option<Fit> {
        let fresh = self
            .fresh_primaries(system, state.time_ns)
            .filter(|member| *member != own);
        let of_members = fresh
            .map(|member| self.fit_of(state, &State::of_report(&self.sensors.get(member).latest)))
            .min_by(|a, b| a.cost.total_cmp(&b.cost));
        if of_members.is_some() {
            return of_members;
        }
        let alone = self.systems.members(self.sensors, system).any(|member| member == own);
        (!alone).then(|| self.fit_of(state, &self.systems.get(system).state))
    }

    fn fit_of(&self, state: &State, other: &State) -> Fit {
        let extent = self.settings.association.extent_sigma_m.powi(2);
        let other = other.at(state.time_ns, self.settings.process_noise_m2ps3);
        let add = |a: [f64; 3], b: [f64; 3], extra: f64| [a[0] + b[0] + extra, a[1] + b[1], a[2] + b[2] + extra];
        let delta = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1]];
        let apart = delta(state.position_m, other.position_m);
        let position = distance::squared2(apart, add(state.horizontal(), other.horizontal(), extent));
        // An unknown velocity has a large variance, and so says nothing here.
        let s = add(
            state.horizontal_velocity(),
            other.horizontal_velocity(),
            VELOCITY_FLOOR_M2PS2,
        );
        let velocity = distance::squared2(delta(state.velocity_mps, other.velocity_mps), s);
        let height = if state.has_height && other.has_height {
            let variance = state.covariance.get(2, 2) + other.covariance.get(2, 2) + HEIGHT_FLOOR_M2;
            (state.position_m[2] - other.position_m[2]).powi(2) / variance
        } else {
            0.0
        };
        Fit {
            cost: position + velocity + height,
            position,
            velocity,
            height,
            metres: apart[0].hypot(apart[1]),
        }
    }

    /// Whether the report of `own` still fits the rest of its system track.
    pub(crate) fn still_fits(&self, report: &SensorTrack, own: SensorSlot) -> bool {
        let settings = &self.settings.association;
        let entry = self.sensors.get(own);
        let Some(fit) = self.fit(&State::of_report(report), entry.system, own) else {
            return true;
        };
        fit.position <= settings.keep_gate || (entry.role == Role::Duplicate && fit.metres <= settings.target_extent_m)
    }

    /// Whether no other source contributes to the system track of `own`.
    pub(crate) fn is_alone(&self, own: SensorSlot, now_ns: i64) -> bool {
        let system = self.sensors.get(own).system;
        self.fresh_primaries(system, now_ns).all(|member| member == own)
    }

    /// Whether at most one source contributes to `system`.
    pub(crate) fn has_one_source(&self, system: SystemSlot, now_ns: i64) -> bool {
        self.fresh_primaries(system, now_ns).nth(1).is_none()
    }

    /// The fresh primary of `source` in `system`, other than `own`.
    pub(crate) fn speaker(&self, system: SystemSlot, source: u16, own: SensorSlot, now_ns: i64) -> Option<SensorSlot> {
        self.fresh_primaries(system, now_ns)
            .find(|member| *member != own && self.sensors.get(*member).latest.source == source)
    }

    /// The sensor tracks that contribute to `system` at `now_ns`.
    pub(crate) fn fresh_primaries(&self, system: SystemSlot, now_ns: i64) -> impl Iterator<Item = SensorSlot> {
        self.systems.members(self.sensors, system).filter(move |member| {
            let entry = self.sensors.get(*member);
            entry.role == Role::Primary && self.is_fresh(&entry.latest, now_ns)
        })
    }

    fn is_fresh(&self, report: &SensorTrack, now_ns: i64) -> bool {
        let fresh_ns = self.settings.sources[usize::from(report.source)].fresh_ns;
        now_ns - report.time_of_measurement_ns <= fresh_ns
    }

    /// Contradicting identities veto; absent ones abstain.
    fn contradicts(&self, report: &SensorTrack, system: SystemSlot) -> bool {
        if !self.settings.association.use_identity {
            return false;
        }
        let differ = |a: Option<u32>, b: Option<u32>| matches!((a, b), (Some(a), Some(b)) if a != b);
        let (mine, theirs) = (&report.identity, &self.systems.get(system).identity);
        differ(mine.address(), theirs.address())
            || differ(mine.mode_3a().map(u32::from), theirs.mode_3a().map(u32::from))
    }

    /// Heights must agree where known, and lie within what every source concerned can see.
    fn can_be_seen_together(&self, report: &SensorTrack, system: SystemSlot) -> bool {
        let entry = self.systems.get(system);
        let height = report.has(sensor_track_bits::HEIGHT).then_some(report.position_m[2]);
        let theirs = entry.state.has_height.then_some(entry.state.position_m[2]);
        let ceiling = |source: u16| self.settings.sources[usize::from(source)].ceiling_m;
        if let (Some(a), Some(b)) = (height, theirs)
            && (a - b).abs() > self.settings.association.height_gate_m
        {
            return false;
        }
        theirs.is_none_or(|z| z <= ceiling(report.source))
            && height.is_none_or(|z| {
                self.fresh_primaries(system, report.time_of_measurement_ns)
                    .all(|member| z <= ceiling(self.sensors.get(member).latest.source))
            })
    }
}
