//! Update of a cluster that a scan does not touch: a single track, and no detection in the gate.
//!
//! Most clusters are false detections a moment ago. This update follows from the general update
//! ([`crate::cluster_update`]) and has the same result to the last bit, counts included; but nothing has to be posed,
//! drawn, compared and separated. Any less simple case is left to the general update.

use crate::branching::{lacks_company, miss};
use crate::counts::TrackerCounts;
use crate::log_sum::{log_add, log_sum};
use crate::population::{Cluster, Hypothesis, Population};
use crate::scan_context::ScanContext;
use crate::settings::Limit;
use crate::splitting::DetectionCounts;
use crate::track::Track;

/// At most: with the track and without.
const HYPOTHESES: usize = 2;

/// A hypothesis of the cluster.
#[derive(Clone, Copy, Debug, Default)]
struct Child {
    log_reliability: f64,
    has_track: bool,
}

/// Updates a cluster without detections. `false`, and no change, if the update is not simple.
pub(crate) fn update(
    scan: &ScanContext<'_>,
    cluster: &Cluster,
    next: &mut Population,
    counts: &mut TrackerCounts,
) -> bool {
    let reduction = &scan.settings.reduction;
    let hypotheses = &scan.before.hypotheses[cluster.hypotheses.start as usize..cluster.hypotheses.end as usize];
    let is_simple = cluster.tracks.len() == 1
        && hypotheses.len() <= HYPOTHESES
        && reduction.hypotheses_max >= HYPOTHESES
        && scan.settings.splitting.tentative_tracks == Limit::Off
        && scan.observer.is_none()
        && scan.unresolved.pairs.is_empty()
        && scan.support.is_silent()
        && next.has_room(1, HYPOTHESES, 1);
    if !is_simple {
        return false;
    }
    // Written at once: a track is large, and copies were half of the cost.
    let number = cluster.tracks.start;
    next.tracks.push(scan.before.tracks[number as usize]);
    let goes_on = next
        .tracks
        .last_mut()
        .is_some_and(|track| goes_on(scan, (number, track)));
    if !goes_on {
        next.tracks.pop();
        return false;
    }
    let log_miss = scan.gating.log_misses[cluster.tracks.start as usize];
    // The hypotheses, most reliable first, and the share dropped so far: none but for rounding.
    let parents = hypotheses.iter().map(|hypothesis| hypothesis.log_reliability);
    let mut dropped = (1.0 - log_sum(parents).exp()).max(0.0);
    let mut children = [Child::default(); HYPOTHESES];
    for (child, hypothesis) in children.iter_mut().zip(hypotheses) {
        child.has_track = !hypothesis.members.is_empty();
        let miss = if child.has_track { log_miss } else { 0.0 };
        child.log_reliability = hypothesis.log_reliability + miss;
    }
    let children = &mut children[..hypotheses.len()];
    // Drawn in this order; a child that cannot matter is not drawn.
    if children.len() == HYPOTHESES && children[0].log_reliability < children[1].log_reliability {
        children.swap(0, 1);
    }
    let (mut drawn, mut taken, mut left) = (0, 0.0, 0.0);
    let best = children[0].log_reliability;
    for child in children.iter() {
        let share = (child.log_reliability - best).exp();
        if share < reduction.reliability_min {
            left = share;
            break;
        }
        (drawn, taken) = (drawn + 1, taken + share);
    }
    counts.hypotheses_drawn += drawn as u64;
    dropped += left / (left + taken);
    let children = &mut children[..drawn];
    let (kept, share) = reduce(children, reduction.reliability_min.ln(), counts);
    dropped += share;
    counts.drop_probability(dropped);
    let children = &mut children[..kept];
    let kept = match children.iter().any(|child| child.has_track) {
        true => finish(children, reduction.reliability_min.ln(), counts),
        false => 0,
    };
    #[cfg(test)]
    tests::UPDATES.with(|updates| updates.set(updates.get() + 1));
    // The last hypothesis with the track may just have been dropped.
    match children[..kept].iter().any(|child| child.has_track) {
        true => write(&children[..kept], cluster, next),
        false => drop(next.tracks.pop()),
    }
    true
}

/// Lets the track have no detection. `false` if the track ends, or may be confirmed.
fn goes_on(scan: &ScanContext<'_>, (number, track): (u32, &mut Track)) -> bool {
    miss(scan, (number, track), false);
    let deletion = &scan.settings.deletion.of(track, &scan.settings.identity);
    !deletion.is_met(track, scan.time_ns)
        && !lacks_company(scan, usize::from(track.is_confirmed()), track)
        && (track.is_confirmed() || !scan.settings.confirmation.is_seen_enough(track))
}

/// As [`crate::hypothesis_store::HypothesisStore::reduce`]. Returns the number of children kept, and the share of the
/// others.
fn reduce(children: &mut [Child], log_least: f64, counts: &mut TrackerCounts) -> (usize, f64) {
    let sum = |children: &[Child]| log_sum(children.iter().map(|child| child.log_reliability));
    let total = sum(children);
    let reliable = children
        .iter()
        .take_while(|child| child.log_reliability >= total + log_least);
    let kept = reliable.count().max(1);
    counts.hypotheses_pruned += (children.len() - kept) as u64;
    let left = sum(&children[..kept]);
    children[..kept]
        .iter_mut()
        .for_each(|child| child.log_reliability -= left);
    (kept, (1.0 - (left - total).exp()).max(0.0))
}

/// As [`crate::separation`] does with the hypotheses of a part. Returns the number of hypotheses kept.
fn finish(children: &mut [Child], log_least: f64, counts: &mut TrackerCounts) -> usize {
    let reliable = children.iter().take_while(|child| child.log_reliability >= log_least);
    let kept = reliable.count().max(1);
    counts.hypotheses_pruned += (children.len() - kept) as u64;
    let first = children[0].log_reliability;
    let others = children[1..kept].iter();
    let left = others.fold(first, |sum, child| log_add(sum, child.log_reliability));
    children[..kept]
        .iter_mut()
        .for_each(|child| child.log_reliability -= left);
    kept
}

/// Writes the hypotheses and the cluster of the track written last.
fn write(children: &[Child], cluster: &Cluster, next: &mut Population) {
    let (place, first) = (next.tracks.len() as u32 - 1, next.hypotheses.len() as u32);
    let mut reliability = 0.0;
    for child in children {
        let begin = next.members.len() as u32;
        if child.has_track {
            next.members.push(place);
            reliability += child.log_reliability.exp();
        }
        next.hypotheses.push(Hypothesis {
            log_reliability: child.log_reliability,
            members: begin..next.members.len() as u32,
        });
    }
    next.tracks[place as usize].reliability = reliability;
    let detections = DetectionCounts::of(std::iter::once(cluster), 0);
    next.clusters.push(Cluster {
        tracks: place..place + 1,
        hypotheses: first..next.hypotheses.len() as u32,
        detections: detections.detections,
        scans: detections.scans,
    });
}

#[cfg(test)]
#[path = "quiet_tests.rs"]
mod tests;
