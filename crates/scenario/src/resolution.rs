//! Unresolved targets of a radar.
//!
//! A radar resolves two targets separated by more than the length of the pulse in range, or by more than the width
//! of the beam in azimuth. Otherwise their echoes merge. In this model, all targets joined by a chain of unresolved
//! pairs give one plot in the middle, at the time at which the antenna points at the first of them. The plot exists
//! if any member is detected. Occasionally echoes differ enough to be resolved nevertheless: then a link of the
//! chain breaks for one turn.
//!
//! Simplifications: echoes are equally strong, the middle is that of the positions and has the errors of a single
//! target, and false plots merge with nothing. The groups are determined once per delivery.

use std::f64::consts::{PI, TAU};

use observations::DetectionTruth as Of;
use rand::RngExt as _;

use crate::grouping::groups;
use crate::look::{LookParameters, SensorTarget, VisibleTarget};
use crate::measurement::SimulatedMeasurement;
use crate::random::{Purpose, stream};
use crate::schedule::Slot;
use crate::sensor_settings::ResolutionCell;
use crate::truth::Truth;

/// Groups of unresolved targets in one delivery.
#[derive(Debug)]
pub(crate) struct Company {
    /// First member of each target's group, by target number; a target alone is its own first member.
    firsts: Vec<usize>,
    /// Pairs (first, target), sorted.
    members: Vec<(usize, usize)>,
}

impl Company {
    pub(crate) fn find(
        cell: &ResolutionCell,
        looks: &LookParameters,
        slot: &Slot,
        truth: &Truth,
        watched: &[SensorTarget],
    ) -> Self {
        let (time_s, turn) = (slot.time_within_s(0.5), slot.period(&looks.settings).0);
        let [site_east, site_north, _] = looks.settings.coverage.position_m;
        let (mut ids, mut places, mut polar) = (Vec::new(), Vec::new(), Vec::new());
        for (index, watched) in watched.iter().enumerate().take(truth.len()) {
            let target = truth.target_at(index, time_s);
            let position_m = target.position_m;
            let place = (position_m, target.height_m);
            if looks.may_find(index as u64, watched.equipped, time_s, place) {
                let [east, north] = [position_m[0] - site_east, position_m[1] - site_north];
                ids.push(index);
                places.push([east, north]);
                polar.push((east.hypot(north), east.atan2(north)));
            }
        }
        let reach_m = cell.range_m + cell.azimuth_rad * looks.settings.coverage.range_max_m;
        let apart = |one: usize, other: usize| {
            let ((range, azimuth), (other_range, other_azimuth)) = (polar[one], polar[other]);
            let turned_rad = (azimuth - other_azimuth + PI).rem_euclid(TAU) - PI;
            ((range - other_range).abs() / cell.range_m).max(turned_rad.abs() / cell.azimuth_rad)
        };
        let breaks = |one: usize, other: usize| {
            let pair = (ids[one] as u64) << 32 | ids[other] as u64;
            let mut random = stream(looks.seed, Purpose::Resolution, looks.source, pair, turn);
            random.random_bool(cell.resolved_probability)
        };
        let found = groups(&places, reach_m, apart, breaks);
        let mut firsts: Vec<usize> = (0..truth.len()).collect();
        for (place, &first) in found.iter().enumerate() {
            firsts[ids[place]] = ids[first];
        }
        let mut members: Vec<(usize, usize)> = ids.iter().map(|&index| (firsts[index], index)).collect();
        members.sort_unstable();
        Self { firsts, members }
    }

    /// Returns the detection in a look at target number `index`; `alone` is its detection without neighbours.
    /// `None` if there is no detection.
    pub(crate) fn echo(
        &self,
        looks: &LookParameters,
        slot: &Slot,
        (truth, time_s): (&Truth, f64),
        watched: &[SensorTarget],
        (index, alone): (usize, Option<SimulatedMeasurement>),
    ) -> Option<(Of, SimulatedMeasurement)> {
        if self.firsts[index] != index {
            return None;
        }
        let begin = self.members.partition_point(|(first, _)| *first < index);
        let all = self.members[begin..].iter().take_while(|(first, _)| *first == index);
        let all: Vec<usize> = all.map(|(_, member)| *member).collect();
        if all.len() < 2 {
            return alone.map(|found| (Of::Target(index as u32), found));
        }
        let (mut middle_m, mut is_detected) = ([0.0; 3], alone.is_some());
        for &member in &all {
            let state = truth.target_at(member, time_s);
            for (sum, coordinate) in middle_m.iter_mut().zip(state.position_m) {
                *sum += coordinate / all.len() as f64;
            }
            let seen = VisibleTarget::target(state, looks);
            let other = || looks.find(slot, member as u64, watched[member].equipped, time_s, &seen);
            is_detected = is_detected || other().is_some();
        }
        is_detected.then(|| {
            let mut random = stream(looks.seed, Purpose::MergedLook, looks.source, index as u64, slot.number);
            let site_m = looks.settings.coverage.position_m;
            (Of::Merged, looks.settings.errors.measure(site_m, middle_m, &mut random))
        })
    }
}
