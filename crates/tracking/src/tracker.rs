//! Scan after scan, late ones included (HT-1, HT-12).
//!
//! A scan that comes after later ones could be used as it comes, by carrying its detections forward; but what was decided
//! without them stays decided. Instead the last scans stay open: they are kept with the population before each. A late
//! one is put in its place, and all from there on are worked off again. So the result is the same, to the last bit, as
//! if every scan had come in order; scans of equal time are in the order of their sensors. Scans older than all open ones
//! are refused and counted.

use observations::{Detection, WideAreaReport};

use crate::clutter::log_density;
use crate::counts::Counts;
use crate::directions::{Claims, Directions};
use crate::explanation::{Explanation, Observer, TrackEvent, TrackRecord};
use crate::gate::gates;
use crate::gating::Gating;
use crate::limits::DETECTION_COUNTS;
use crate::plot::{Plot, admit};
use crate::population::{Cluster, Hypothesis, Population};
use crate::resolution::unite;
use crate::scan_context::ScanContext;
use crate::sensor::Sensor;
use crate::settings::{Clutter, SensorSettings, Settings};
use crate::track::Track;
use crate::track_report::{TrackReport, find_best, group_of, joined, report_of, whereabouts};
use crate::update::{self, Update};
use crate::wide_area::cue::{Cue, cue};
use crate::wide_area::emission::{Emission, EmissionRefusal, Emissions};
use crate::wide_area::expectation::Expectations;
use crate::wide_area::report::{self, ReportRefusal, Reports};

/// Why a scan was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// No settings for a sensor of this number.
    UnknownSensor(u32),
    /// It is older than every open scan.
    TooLate,
}

impl std::fmt::Display for Refusal {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::UnknownSensor(sensor) => write!(formatter, "sensor {sensor} is not configured"),
            Self::TooLate => write!(formatter, "the scan is older than every open one; keep more scans open"),
        }
    }
}

impl std::error::Error for Refusal {}

/// A scan that is still open.
#[derive(Clone, Debug)]
struct OpenScan {
    time_ns: i64,
    /// Place of its sensor in the settings.
    sensor: usize,
    plots: Vec<Plot>,
}

/// The multiple-hypothesis tracker. No clone can be made: it would lack the memory allocated beforehand.
#[derive(Debug)]
pub struct Tracker {
    settings: Settings,
    /// By sensor.
    sensors: Vec<Sensor>,
    /// In order of time, then of sensors; the first `open` count.
    scans: Vec<OpenScan>,
    open: usize,
    /// Before each open scan, then after the last one.
    populations: Vec<Population>,
    gating: Gating,
    update: Update,
    wide_area: Reports,
    emissions: Emissions,
    expectations: Expectations,
    /// Of the clusters after the latest scan.
    described: Expectations,
    log_clutter: Vec<f64>,
    /// By detection of a scan: how many are united in it, whether it lies in a confirmed track's gate; by direction: which
    /// tracks claim it.
    united: Vec<u32>,
    is_inside: Vec<bool>,
    claims: Vec<Claims>,
    /// (number, track, cluster) of each confirmed ancestor's best branch, by their numbers.
    best: Vec<(u32, u32, u32)>,
    reports: Vec<TrackReport>,
    counts: Counts,
}

impl Tracker {
    /// A tracker without tracks. All memory is allocated here.
    ///
    /// # Errors
    /// A sentence on what is wrong with the settings.
    pub fn new(settings: Settings) -> Result<Self, String> {
        if let Some(fault) = settings.fault() {
            return Err(fault);
        }
        let capacity = settings.capacity;
        let gates = gates(settings.gate_probability);
        let sensor = |sensor: &SensorSettings| Sensor::new(sensor, &settings, gates);
        let types = settings.wide_area.knowledge.types.len();
        let population = |_| Population::new(capacity.tracks, settings.sensors.len(), types);
        let scan = |_| OpenScan {
            time_ns: i64::MIN,
            sensor: 0,
            plots: Vec::with_capacity(capacity.detections),
        };
        Ok(Self {
            sensors: settings.sensors.iter().map(sensor).collect(),
            scans: (0..=capacity.open_scans).map(scan).collect(),
            open: 0,
            populations: (0..capacity.open_scans + 2).map(population).collect(),
            gating: Gating::new(capacity.tracks, capacity.detections),
            update: Update::new(capacity.tracks, capacity.detections),
            wide_area: Reports::new(),
            emissions: Emissions::new(types),
            expectations: Expectations::new(capacity.tracks),
            described: Expectations::new(capacity.tracks),
            log_clutter: Vec::with_capacity(capacity.detections),
            united: vec![0; capacity.detections],
            is_inside: vec![false; capacity.detections],
            claims: Vec::with_capacity(capacity.detections),
            best: Vec::with_capacity(capacity.tracks),
            reports: Vec::with_capacity(capacity.tracks),
            counts: Counts::default(),
            settings,
        })
    }

    /// Lets confirmed tracks be numbered from `first` on (0 is taken for 1). A tracker that takes another one's place begins
    /// beyond the numbers that the other may have given. To be said before the first scan; later it is not heard.
    pub fn number_from(&mut self, first: u32) {
        if self.counts.scans == 0 {
            let first = first.max(1);
            self.populations
                .iter_mut()
                .for_each(|population| population.next_number = first);
        }
    }

    /// Works in a scan of the sensor `sensor_id` at `time_ns`. No detections at all say something, too.
    ///
    /// # Errors
    /// [`Refusal`], counted, if the scan cannot be used; single detections that cannot be used are left out and counted.
    pub fn scan(&mut self, sensor_id: u32, time_ns: i64, detections: &[Detection]) -> Result<(), Refusal> {
        self.scan_explained(sensor_id, time_ns, detections, None)
    }

    /// As [`Self::scan`], and tells an observer what was considered and decided.
    ///
    /// # Errors
    /// As [`Self::scan`].
    pub fn scan_explained(
        &mut self,
        sensor_id: u32,
        time_ns: i64,
        detections: &[Detection],
        observer: Option<&dyn Observer>,
    ) -> Result<(), Refusal> {
        let place = self
            .place(sensor_id, time_ns)
            .inspect_err(|_| self.counts.refused_scans += 1)?;
        let (sensor, mut place) = place;
        if self.open == self.scans.len() {
            // The oldest one is closed.
            self.scans.rotate_left(1);
            self.populations.rotate_left(1);
            self.open -= 1;
            place -= 1;
        }
        let latest_ns = self.scans[..self.open]
            .last()
            .map_or(time_ns, |scan| scan.time_ns.max(time_ns));
        let scan = &mut self.scans[self.open];
        (scan.time_ns, scan.sensor) = (time_ns, sensor);
        admit(
            detections,
            [time_ns, latest_ns],
            &self.settings.sensors[sensor],
            &self.settings.selection,
            &mut scan.plots,
            &mut self.counts,
        );
        if let Some(resolution_m) = self.settings.sensors[sensor].resolution_m {
            self.counts.united_detections += unite(&mut scan.plots, resolution_m, &mut self.united) as u64;
        }
        self.scans[place..=self.open].rotate_right(1);
        self.counts.late_scans += u64::from(place < self.open);
        self.open += 1;
        self.work_off_from(self.first_changed(place), observer);
        Ok(())
    }

    /// Takes a report of a wide-area sensor at its arrival (WA-2). It is used in the first scan after that; scans that
    /// came before it and are still open are worked off again, later ones of closed scans use it from the next scan on.
    ///
    /// # Errors
    /// [`ReportRefusal`], counted, if the report cannot be used.
    pub fn wide_area(&mut self, report: &WideAreaReport) -> Result<(), ReportRefusal> {
        let settings = &self.settings.wide_area;
        let closed_ns = self.closed_ns();
        let mut report = *report;
        let kept = report::fault(&report, settings.delay_max_ns)
            .map_or(Ok(()), Err)
            .and_then(|()| {
                report.arrival_ns = report.arrival_ns.max(closed_ns.saturating_add(1));
                self.wide_area.keep(report, closed_ns, settings.valid_ns)
            });
        kept.inspect_err(|_| self.counts.wide_area_reports_refused += 1)?;
        self.counts.wide_area_reports += 1;
        let first = self.scans[..self.open].partition_point(|scan| scan.time_ns < report.arrival_ns);
        if first < self.open {
            self.work_off_from(first, None);
        }
        Ok(())
    }

    /// Takes an emission that an on-board receiver has heard (WA-9). It is used in the first scan after it, to identify
    /// the track that it comes from; scans that came before it and are still open identify their tracks again.
    ///
    /// # Errors
    /// [`EmissionRefusal`], counted, if the emission cannot be used.
    pub fn emission(&mut self, emission: &Emission) -> Result<(), EmissionRefusal> {
        let delay_max_ns = self.settings.wide_area.delay_max_ns;
        let kept = self.emissions.keep(emission, self.closed_ns(), delay_max_ns);
        let due_ns = kept.inspect_err(|_| self.counts.emissions_refused += 1)?;
        self.counts.emissions += 1;
        let first = self.scans[..self.open].partition_point(|scan| scan.time_ns < due_ns);
        if first < self.open {
            (first..self.open).for_each(|place| self.identify(place));
            self.report(None);
        }
        Ok(())
    }

    /// Time of the last scan that is never worked off again.
    fn closed_ns(&self) -> i64 {
        if self.open == self.scans.len() {
            self.scans[0].time_ns
        } else {
            self.populations[0].time_ns
        }
    }

    /// The confirmed tracks after the latest scan, by their numbers.
    pub fn tracks(&self) -> &[TrackReport] {
        &self.reports
    }

    /// The confirmed tracks at `time_ns`, into `picture` (WA-11).
    pub fn picture_at(&self, time_ns: i64, picture: &mut Vec<TrackReport>) {
        let noise = self.settings.motion.process_noise_m2ps3;
        picture.clear();
        picture.extend(self.reports.iter().map(|track| track.moved_to(time_ns, noise)));
    }

    /// Where the sensor `sensor_id`, whose detections have a standard deviation of `sigma_m` metres, should look at
    /// `time_ns` for each confirmed track, into `cues` (WA-12).
    pub fn cues_at(&self, (sensor_id, time_ns): (u32, i64), sigma_m: f64, cues: &mut Vec<Cue>) {
        let Settings {
            motion,
            gate_probability,
            ..
        } = &self.settings;
        let look = (sensor_id, time_ns);
        let all = self.reports.iter();
        cues.clear();
        cues.extend(all.map(|track| cue(track, look, sigma_m, *gate_probability, motion)));
    }

    /// What was done and refused so far.
    pub fn counts(&self) -> &Counts {
        &self.counts
    }

    /// Tracks after the latest scan, tentative ones and branches included.
    pub fn branches(&self) -> usize {
        self.latest().tracks.len()
    }

    /// Clusters after the latest scan.
    pub fn clusters(&self) -> usize {
        self.latest().clusters.len()
    }

    pub(crate) fn latest(&self) -> &Population {
        &self.populations[self.open]
    }

    /// The sensor's place in the settings, and the scan's among the open ones.
    fn place(&self, sensor_id: u32, time_ns: i64) -> Result<(usize, usize), Refusal> {
        let mut sensors = self.settings.sensors.iter();
        let sensor = sensors.position(|sensor| sensor.sensor_id == sensor_id);
        let sensor = sensor.ok_or(Refusal::UnknownSensor(sensor_id))?;
        let open = &self.scans[..self.open];
        let place = open.partition_point(|scan| (scan.time_ns, scan.sensor) <= (time_ns, sensor));
        let closed = self.open == self.scans.len() && place == 0;
        // The population before the first open scan may be later than this one, if others have been closed.
        let behind = place == 0 && time_ns < self.populations[0].time_ns;
        if closed || behind {
            return Err(Refusal::TooLate);
        }
        Ok((sensor, place))
    }

    /// The first open scan that is to be worked off again because of the one at `place`: that itself, or one that it
    /// outranks.
    fn first_changed(&self, place: usize) -> usize {
        let selection = &self.settings.selection;
        if selection.priorities.is_empty() {
            return place;
        }
        let earliest_ns = self.scans[place].time_ns.saturating_sub(selection.same_time_ns);
        self.scans[..place].partition_point(|scan| scan.time_ns < earliest_ns)
    }

    /// Whether another open scan at the same time is of a sensor of higher priority (WA-1).
    fn is_outranked(&self, place: usize) -> bool {
        let selection = &self.settings.selection;
        let sensor = |scan: &OpenScan| self.settings.sensors[scan.sensor].sensor_id;
        let scan = &self.scans[place];
        !selection.priorities.is_empty()
            && self.scans[..self.open].iter().any(|other| {
                let apart_ns = other.time_ns.saturating_sub(scan.time_ns);
                selection.outranks(sensor(other), sensor(scan), apart_ns)
            })
    }

    /// Works off the open scans from `first` on.
    fn work_off_from(&mut self, first: usize, observer: Option<&dyn Observer>) {
        for place in first..self.open {
            self.work_off(place, observer);
            self.identify(place);
        }
        self.report(observer);
    }

    /// Makes the population after the open scan at `place` of the one before it.
    fn work_off(&mut self, place: usize, observer: Option<&dyn Observer>) {
        let is_outranked = self.is_outranked(place);
        self.counts.outranked_scans += u64::from(is_outranked);
        let log_kept_weight = self.settings.selection.log_kept_weight();
        let (before, after) = self.populations.split_at_mut(place + 1);
        let (before, next) = (&before[place], &mut after[0]);
        let OpenScan { time_ns, sensor, plots } = &self.scans[place];
        if is_outranked && log_kept_weight.is_none() {
            next.carry_on(before);
            return;
        }
        next.follow(before, *time_ns);
        next.next_serial = next.next_serial.wrapping_add(plots.len() as u32).max(1);
        let counts = &mut self.counts;
        counts.scans += 1;
        self.log_clutter.clear();
        let memory = &mut next.sensors[*sensor];
        let looking = self.sensors[*sensor].at(*time_ns, plots, memory);
        let directions_only = memory.sees_directions_only();
        let estimate = &mut memory.clutter;
        plots.iter().for_each(|plot| estimate.see(&plot.measurement));
        let density = match self.settings.sensors[*sensor].clutter {
            Clutter::Density(density) => density,
            Clutter::Learned => estimate.density(plots.len(), looking.extent()),
        };
        if let Some(observer) = observer {
            observer.explain(&Explanation::Scan {
                sensor_id: self.settings.sensors[*sensor].sensor_id,
                time_ns: *time_ns,
                detections: plots.len(),
                clutter_density: density,
            });
        }
        let guess = &self.settings.first_guess;
        self.log_clutter
            .extend(plots.iter().map(|plot| log_density(&plot.measurement, density, guess)));
        if !directions_only {
            self.expectations.find(
                before,
                *time_ns,
                self.wide_area.list(),
                &self.settings.wide_area,
                self.settings.wide_area.lasts(),
                counts,
            );
            next.reports_ns = *time_ns;
            self.gating.run(before, plots, *time_ns, &looking, counts);
            let outside = outside(before, &self.gating, &mut self.is_inside[..plots.len()]);
            next.sensors[*sensor].clutter.count(outside);
        }
        let scan = ScanContext {
            before,
            plots,
            log_clutter: &self.log_clutter,
            gating: &self.gating,
            settings: &self.settings,
            sensor: &looking,
            expectations: &self.expectations,
            log_weight: log_kept_weight.filter(|_| is_outranked).unwrap_or(0.0),
            time_ns: *time_ns,
            first_serial: before.next_serial,
            observer,
        };
        if directions_only {
            self.claims.clear();
            self.claims.resize(plots.len(), Claims::NONE);
            let directions = Directions::of(&scan);
            for track in before.tracks.iter().filter(|track| track.is_confirmed()) {
                directions.claim(track, &mut self.claims);
            }
            for cluster in &before.clusters {
                self.update.take_in(&scan, cluster, &self.claims, next, counts);
            }
            let outside = self.claims.iter().filter(|claims| !claims.are_made()).count();
            next.sensors[*sensor].clutter.count(outside);
            return;
        }
        let mut of_none = &self.gating.plots[..];
        for group in self.gating.clusters.chunk_by(|one, other| one.0 == other.0) {
            let of_group = of_none
                .iter()
                .take_while(|(standing, _)| *standing == group[0].0)
                .count();
            let (plots, rest) = of_none.split_at(of_group);
            of_none = rest;
            self.update.run(&scan, group, plots, next, counts);
        }
        for &(_, plot) in of_none {
            begin_cluster(&scan, plot, next, counts);
        }
    }

    /// What is known of the tracks after the open scan at `place`, from what was known of those before it (WA-9).
    fn identify(&mut self, place: usize) {
        let wide_area = &self.settings.wide_area;
        let knowledge = &wide_area.knowledge;
        if knowledge.types.is_empty() {
            return;
        }
        let (before, after) = self.populations.split_at_mut(place + 1);
        let (before, next) = (&before[place], &mut after[0]);
        find_best(next, &mut self.best);
        if !knowledge.priors.is_empty() {
            let (reports, uncounted) = (self.wide_area.list(), &mut Counts::default());
            self.described
                .find(next, next.time_ns, reports, wide_area, true, uncounted);
        }
        let (tracks, identities) = (&next.tracks, &mut next.identities);
        identities.follow(&before.identities, self.best.iter().map(|(number, ..)| *number));
        if !knowledge.priors.is_empty() {
            for (nth, (.., cluster)) in self.best.iter().enumerate() {
                if let Some(origin) = self.described.of(*cluster).origin {
                    identities.came_from(nth, origin);
                }
            }
        }
        let time_ns = self.scans[place].time_ns;
        for emission in self.emissions.between(before.emissions_ns, time_ns) {
            let best = self.best.iter().map(|(_, track, _)| &tracks[*track as usize]);
            let heard = best.map(|track| whereabouts(track, emission.time_ns));
            let found = identities.emitted(emission, heard, knowledge);
            self.counts.emissions_used += 1;
            self.counts.emissions_unclear += u64::from(found.is_none());
        }
        next.emissions_ns = time_ns;
    }

    /// Of each confirmed ancestor the most reliable branch (HT-10).
    fn report(&mut self, observer: Option<&dyn Observer>) {
        let population = &self.populations[self.open];
        let (settings, wide_area) = (&self.settings, &self.settings.wide_area);
        let (reports, describes) = (self.wide_area.list(), wide_area.describes_tracks());
        let uncounted = &mut Counts::default();
        self.described
            .find(population, population.time_ns, reports, wide_area, describes, uncounted);
        let of = |track: u32| &population.tracks[track as usize];
        find_best(population, &mut self.best);
        self.reports.clear();
        for (nth, &(_, track, place)) in self.best.iter().enumerate() {
            let cluster = &population.clusters[place as usize];
            let expectation = self.described.of(place);
            let report = |track: &Track| TrackReport {
                origin_m: expectation.origin.and_then(|origin| origin.reported_m()),
                target_type: population.identities.target_type(nth, &wide_area.knowledge),
                ..report_of(track, cluster, population.time_ns, settings)
            };
            let Some(group) = group_of(population, cluster, &expectation, wide_area) else {
                self.reports.push(report(of(track)));
                continue;
            };
            // The group has the smallest number.
            if self.best[..nth].iter().all(|(.., other)| *other != place) {
                let confirmed = cluster.tracks.clone().map(of).filter(|track| track.is_confirmed());
                let joined = joined(confirmed.map(report), group, population.time_ns, &settings.motion);
                if let (Some(observer), Some(joined)) = (observer, &joined) {
                    observer.explain(&Explanation::Group {
                        number: joined.number,
                        members: group.members,
                        probability: group.probability,
                        limit: wide_area.groups.map_or(f64::NAN, |groups| groups.probability_min),
                    });
                }
                self.reports.extend(joined);
            }
        }
    }
}

/// How many detections lie in no confirmed track's gate. All branches of a pair of targets have the same ones in theirs.
fn outside(before: &Population, gating: &Gating, is_inside: &mut [bool]) -> usize {
    is_inside.fill(false);
    let confirmed = |track: u32| before.tracks[track as usize].is_confirmed();
    for pair in gating.pairs.iter().filter(|pair| confirmed(pair.track)) {
        is_inside[pair.plot as usize] = true;
    }
    is_inside.iter().filter(|is_inside| !**is_inside).count()
}

/// A cluster of one detection that is in no gate: false, or the first of a new track (HT-4).
fn begin_cluster(scan: &ScanContext<'_>, plot: u32, next: &mut Population, counts: &mut Counts) {
    let weight = (scan.log_weight + scan.plots[plot as usize].log_weight).exp();
    let share = scan.settings.new_target_share * weight;
    let reliability = share / (1.0 + share);
    if reliability <= 0.0 || reliability < scan.settings.reduction.reliability_min {
        return;
    }
    let Some(mut track) = update::begin(scan, plot, None, next.next_root) else {
        return;
    };
    if !next.has_room(1, 2, 1) {
        counts.refused_tracks += 1;
        return;
    }
    track.reliability = reliability;
    if let Some(observer) = scan.observer {
        observer.explain(&Explanation::Track {
            event: TrackEvent::Started,
            track: TrackRecord::of(&track, scan.plots, scan.first_serial),
            value: reliability,
            limit: f64::NAN,
        });
    }
    next.next_root = next.next_root.wrapping_add(1).max(1);
    let (place, hypothesis, member) = (
        next.tracks.len() as u32,
        next.hypotheses.len() as u32,
        next.members.len() as u32,
    );
    next.tracks.push(track);
    next.members.push(place);
    let mut both = [
        ((1.0 - reliability).ln(), member..member),
        (reliability.ln(), member..member + 1),
    ];
    if reliability > 0.5 {
        both.swap(0, 1);
    }
    next.hypotheses
        .extend(both.into_iter().map(|(log_reliability, members)| Hypothesis {
            log_reliability,
            members,
        }));
    let mut detections = [0.0; DETECTION_COUNTS];
    detections[0] = 1.0;
    next.clusters.push(Cluster {
        tracks: place..place + 1,
        hypotheses: hypothesis..hypothesis + 2,
        detections,
        scans: 1,
    });
}
