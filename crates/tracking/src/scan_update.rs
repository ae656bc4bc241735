//! Update by a scan: from the population before to the population after.

use crate::cluster_update::ClusterUpdate;
use crate::clutter::log_density;
use crate::counts::TrackerCounts;
use crate::coupling::Coupling;
use crate::crossing::Crossings;
use crate::departure::Departures;
use crate::designation::designate;
use crate::directions::{Claims, Directions};
use crate::existence::Survival;
use crate::explanation::{Explanation, Observer};
use crate::gate::gates;
use crate::gating::Gating;
use crate::identity::ScanReplies;
use crate::limits::PAIRS_MAX;
use crate::plot::Scan;
use crate::population::Population;
use crate::scan_clusters::run_clusters;
use crate::scan_context::ScanContext;
use crate::sensor::Sensor;
use crate::settings::Settings;
use crate::track::Track;
use crate::unresolved::Unresolved;
use crate::wide_area::support::Support;

/// Working memory, reused for each scan.
#[derive(Debug)]
pub(crate) struct ScanUpdate {
    /// By sensor.
    sensors: Vec<Sensor>,
    gating: Gating,
    coupling: Coupling,
    unresolved: Unresolved,
    departures: Departures,
    replies: ScanReplies,
    clusters: ClusterUpdate,
    log_clutter: Vec<f64>,
    /// By detection: set for a detection in a confirmed track's gate; by direction: the claims of tracks.
    is_inside: Vec<bool>,
    claims: Vec<Claims>,
    /// Starts at crossings of directions, if there are any.
    crossings: Option<Box<Crossings>>,
}

impl ScanUpdate {
    pub(crate) fn new(settings: &Settings) -> Self {
        let (tracks, detections) = (settings.capacity.tracks(), settings.capacity.detections());
        let gates = gates(settings.gate.probability);
        let sensors = settings.sensors.iter();
        Self {
            sensors: sensors
                .enumerate()
                .map(|(place, sensor)| Sensor::new(sensor, settings, gates).in_place(place))
                .collect(),
            gating: Gating::new(tracks, detections),
            unresolved: Unresolved::new(
                tracks,
                settings
                    .sensors
                    .iter()
                    .any(|sensor| sensor.model.resolution_cell.is_some()),
            ),
            departures: Departures::new(detections),
            coupling: Coupling::new(tracks, 4 * tracks + PAIRS_MAX, detections),
            replies: ScanReplies::new(detections, settings.identity, settings.initiation.height_sigma_m),
            clusters: ClusterUpdate::new(tracks, detections),
            log_clutter: Vec::with_capacity(detections),
            is_inside: vec![false; detections],
            claims: Vec::with_capacity(detections),
            crossings: Crossings::new(settings),
        }
    }

    /// Makes the population `next` of the population before a scan; the logarithm is that of the detections' weight
    /// (WA-1).
    pub(crate) fn run(
        &mut self,
        (scan, log_weight): (&Scan, f64),
        (before, next): (&Population, &mut Population),
        settings: &Settings,
        support: &mut Support,
        observer: Option<&dyn Observer>,
        counts: &mut TrackerCounts,
    ) {
        let seconds = before.seconds_until(scan.time_ns);
        let known = (&self.sensors[..], &before.sensors[..]);
        let survival = Survival::new(seconds, &before.life, known, &settings.deletion);
        if settings.sensors[scan.sensor].model.designates {
            let sensor = &self.sensors[scan.sensor];
            return designate(scan, (before, next), (sensor, &survival), settings, observer, counts);
        }
        let Scan { time_ns, sensor, plots } = scan;
        next.follow(before, *time_ns);
        next.next_serial = next.next_serial.wrapping_add(plots.len() as u32).max(1);
        counts.scans += 1;
        let memory = &mut next.sensors[*sensor];
        let looking = self.sensors[*sensor].at(*time_ns, plots, memory);
        let directions_only = memory.sees_directions_only();
        let estimate = &mut memory.clutter;
        plots.iter().for_each(|plot| estimate.see(&plot.measurement));
        let known = settings.sensors[*sensor].model.clutter_density;
        let density = known.unwrap_or_else(|| estimate.density(plots.len(), looking.extent()));
        if let Some(observer) = observer {
            observer.explain(&Explanation::Scan {
                sensor_id: settings.sensors[*sensor].sensor_id,
                time_ns: *time_ns,
                detections: plots.len(),
                clutter_density: density,
            });
        }
        let guess = &settings.initiation;
        self.departures.clear();
        self.log_clutter.clear();
        self.log_clutter
            .extend(plots.iter().map(|plot| log_density(&plot.measurement, density, guess)));
        if !directions_only {
            support.begin_scan(before, *time_ns, &settings.wide_area, counts);
            next.support.reports_ns = *time_ns;
            self.replies.read(plots.iter().map(|plot| &plot.identity));
            self.gating
                .run(before, plots, (*time_ns, &self.replies), (&looking, &survival), counts);
            self.unresolved
                .find((before, &self.gating), plots, (*time_ns, &self.replies), &looking);
            let is_inside = &mut self.is_inside[..plots.len()];
            outside(before, &self.gating, is_inside);
            counts.dropped_comparisons +=
                self.departures
                    .find((before, plots), &self.gating, is_inside, &looking, settings);
            let seen = (&plots[..], &self.log_clutter[..]);
            let found = (&mut self.gating, &self.unresolved, &self.departures);
            self.coupling.run(found, before, seen, &looking, settings);
        }
        let scan = ScanContext {
            before,
            plots,
            log_clutter: &self.log_clutter,
            gating: &self.gating,
            unresolved: &self.unresolved,
            departures: &self.departures,
            settings,
            sensor: &looking,
            survival,
            support,
            log_weight,
            time_ns: *time_ns,
            first_serial: before.next_serial,
            observer,
        };
        let outside = if directions_only && let Some(crossings) = &mut self.crossings {
            crossings.run((&scan, density), &mut self.clusters, &mut self.claims, next, counts)
        } else if directions_only {
            run_directions(&scan, &mut self.clusters, &mut self.claims, next, counts)
        } else {
            run_clusters(&scan, &mut self.clusters, next, counts);
            if looking.learns {
                let in_view = |track: &Track| looking.probability_in_view(track.motion.widest());
                next.sensors[*sensor].rate.count(&next.tracks, in_view);
            }
            outside(before, &self.gating, &mut self.is_inside[..plots.len()])
        };
        next.sensors[*sensor].clutter.count(outside);
        let confirmed = next.next_number.wrapping_sub(before.next_number);
        let present = [before.present(), next.present()];
        next.life.count(seconds, present, confirmed);
    }
}

/// Lets all tracks take directions. Returns how many of these lie in no confirmed track's gate.
fn run_directions(
    scan: &ScanContext<'_>,
    clusters: &mut ClusterUpdate,
    claims: &mut Vec<Claims>,
    next: &mut Population,
    counts: &mut TrackerCounts,
) -> usize {
    claims.clear();
    claims.resize(scan.plots.len(), Claims::NONE);
    let directions = Directions::of(scan);
    for track in scan.before.tracks.iter().filter(|track| track.is_confirmed()) {
        directions.claim(track, claims);
    }
    for cluster in &scan.before.clusters {
        clusters.run_directions(scan, cluster, claims, next, counts);
    }
    claims.iter().filter(|claims| !claims.are_made()).count()
}

/// Number of detections that lie in no confirmed track's gate. All branches of a pair of targets have the same
/// detections in the gate.
fn outside(before: &Population, gating: &Gating, is_inside: &mut [bool]) -> usize {
    is_inside.fill(false);
    let confirmed = |track: u32| before.tracks[track as usize].is_confirmed();
    for pair in gating.pairs.iter().filter(|pair| confirmed(pair.track)) {
        is_inside[pair.plot as usize] = true;
    }
    is_inside.iter().filter(|is_inside| !**is_inside).count()
}
