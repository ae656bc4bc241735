//! State of a deployment, as derived by a reader of its topics.

use std::collections::BTreeSet;

use deployment::SourceFacts;
use frames::{Geodetic, SystemFrame};
use messages::{
    Alarm, BatchHeader, Counter, FrameOrigin, Health, LifeState, NO_SOURCE, OrderState, OrderStatus, ProcessKind,
    SystemTrack,
};
use telemetry::{DataOffset, Journey, JourneyEnd, Stages};

use crate::book::{HealthBook, LatestHealth};
use crate::present::PresentAlarms;
use crate::process::{ObservedProcess, process_title};
use crate::source::{self, Delivery, RefusedInput, SourceState};
use crate::track_counts::TrackCounts;

/// Silence after which a process counts as absent, nanoseconds: ten health messages are missing then.
const ABSENT_AFTER_NS: i64 = 2_000_000_000;

/// State of a deployment. See the crate's documentation.
#[derive(Clone, Debug)]
pub struct Deployment {
    /// Configured sources; `None` for a reader without the configuration.
    sources: Option<Vec<SourceFacts>>,
    deliveries: Vec<Delivery>,
    book: HealthBook,
    stages: Stages,
    has_latencies: bool,
    data_offset: DataOffset,
    alarms: PresentAlarms,
    origin: Option<FrameOrigin>,
    frame: Option<SystemFrame>,
    orders: Vec<OrderState>,
    /// Epoch of the fusion process that published the latest system tracks.
    publisher: u64,
    /// Time of the latest sign of life of the leading fusion, monotonic, nanoseconds.
    fusion_ns: i64,
    live_max: u64,
    /// Longest time between two messages that a process repeats unchanged, beyond that of a live process, nanoseconds.
    repeated_ns: i64,
}

impl Default for Deployment {
    /// State for a reader without the configuration.
    fn default() -> Self {
        Self::with_book(None, HealthBook::new(usize::from(NO_SOURCE), i64::MAX))
    }
}

impl Deployment {
    /// Creates the state of a deployment with these `sources`, before any message.
    pub fn new(sources: Vec<SourceFacts>) -> Self {
        let book = HealthBook::new(sources.len(), i64::MAX);
        Self::with_book(Some(sources), book)
    }

    fn with_book(sources: Option<Vec<SourceFacts>>, book: HealthBook) -> Self {
        Self {
            deliveries: vec![Delivery::default(); sources.as_ref().map_or(0, Vec::len)],
            sources,
            book,
            stages: Stages::new(Journey {
                end: JourneyEnd::Published,
                ..Journey::default()
            }),
            has_latencies: true,
            data_offset: DataOffset::default(),
            alarms: PresentAlarms::default(),
            origin: None,
            frame: None,
            orders: Vec::new(),
            publisher: 0,
            fusion_ns: i64::MIN,
            live_max: 0,
            repeated_ns: 0,
        }
    }

    /// Returns this state for a reader that started at `begun_ns` (monotonic, nanoseconds) together with the
    /// deployment: rates of processes that start later count from their start.
    #[must_use]
    pub fn observed_since(mut self, begun_ns: i64) -> Self {
        self.book = HealthBook::new(self.sources.as_ref().map_or(usize::from(NO_SOURCE), Vec::len), begun_ns);
        self
    }

    /// Returns this state for a reader of a recording, which has unchanged messages every `repeated_ns` nanoseconds: so
    /// much later, a process counts as silent or absent.
    #[must_use]
    pub fn of_recording(mut self, repeated_ns: i64) -> Self {
        self.repeated_ns = repeated_ns;
        self
    }

    /// Returns this state with another extent of latencies; `None`: latencies are not recorded.
    #[must_use]
    pub fn with_latencies(mut self, journey: Journey, is_recorded: bool) -> Self {
        (self.stages, self.has_latencies) = (Stages::new(journey), is_recorded);
        self
    }

    /// Returns the state before any message, with the same sources and the same origin.
    #[must_use]
    pub fn emptied(&self) -> Self {
        let empty = match &self.sources {
            Some(sources) => Self::new(sources.clone()),
            None => Self::default(),
        };
        Self {
            origin: self.origin,
            frame: self.frame,
            repeated_ns: self.repeated_ns,
            ..empty
        }
    }
}

/// Samples.
impl Deployment {
    /// Takes a health message.
    pub fn take_health(&mut self, health: &Health) {
        self.book.take(health);
        let Some(kind) = health.kind() else { return };
        if kind == ProcessKind::Fusion && health.source == NO_SOURCE {
            self.live_max = self.live_max.max(health.counters[Counter::LiveTracksMax]);
        }
        let is_alive = health.life() == Some(LifeState::Running);
        // The standby of a fusion has another name.
        if kind == ProcessKind::Fusion && health.name() == kind.word() && is_alive {
            self.fusion_ns = self.fusion_ns.max(health.said_ns);
        }
        let sources = self.sources.iter().flatten().zip(&mut self.deliveries);
        for (source, delivery) in sources {
            if source::concerns(source, kind, health.name(), health.source) {
                delivery.take(source::delivered(&self.book, source), health.said_ns);
            }
        }
    }

    /// Takes a slice of standing alarms, which replaces the previous slice.
    pub fn take_alarms(&mut self, header: &BatchHeader, slice: &[Alarm]) {
        self.alarms.take(header, slice);
    }

    /// Takes the origin of the system frame; returns whether the frame has changed. An invalid place is ignored.
    pub fn take_origin(&mut self, origin: &FrameOrigin) -> bool {
        if self.origin == Some(*origin) {
            return false;
        }
        let place = Geodetic::from_degrees(origin.latitude_deg, origin.longitude_deg, origin.height_m);
        let Ok(place) = place else { return false };
        (self.origin, self.frame) = (Some(*origin), Some(SystemFrame::at(place)));
        true
    }

    /// Takes the list of orders, which replaces the previous list.
    pub fn take_orders(&mut self, orders: &[OrderState]) {
        self.orders.clear();
        self.orders.extend_from_slice(orders);
    }

    /// Takes a slice of system tracks received at `mono_ns` (monotonic) and `utc_ns`, nanoseconds. Returns whether the
    /// publisher has changed: tracks of the previous publisher are no longer valid.
    pub fn take_tracks(&mut self, header: &BatchHeader, tracks: &[SystemTrack], mono_ns: i64, utc_ns: i64) -> bool {
        // A publishing fusion is not silent: health messages are rare in a recording made faster than real time.
        self.fusion_ns = self.fusion_ns.max(mono_ns);
        let sources_utc_ns = utc_ns.saturating_add(self.book.host_offset_ns());
        for track in tracks {
            if self.has_latencies {
                self.stages.record(track, mono_ns, sources_utc_ns);
            }
            self.data_offset.take(track.reference_time_ns, mono_ns, utc_ns);
        }
        // The new epoch may be smaller: a standby fusion may have started before its predecessor.
        let is_another = header.incarnation != self.publisher;
        self.publisher = header.incarnation;
        is_another
    }

    /// Closes the interval of latencies and rates and begins the next.
    pub fn close_interval(&mut self) {
        while self.close_next_source() {}
    }

    /// Does a part of [`Self::close_interval`], so that samples can be taken in between. Returns `false` at the end.
    pub fn close_next_source(&mut self) -> bool {
        if self.stages.close_next_source() {
            return true;
        }
        self.book.close_interval();
        false
    }

    /// Removes guests that have left without a last message, see [`HealthBook::forget_guests`].
    pub fn forget_guests(&mut self, expected: &[(ProcessKind, String)], now_ns: i64, is_gone: impl Fn(u32) -> bool) {
        self.book.forget_guests(expected, now_ns, is_gone);
    }
}

/// State of the deployment as a whole.
impl Deployment {
    /// Returns the health messages.
    pub fn book(&self) -> &HealthBook {
        &self.book
    }

    /// Returns the latencies.
    pub fn stages(&self) -> &Stages {
        &self.stages
    }

    /// Returns the alarms standing at `now_ns` (monotonic, nanoseconds), the worst first; none without a recent slice.
    pub fn alarms(&self, now_ns: i64) -> &[Alarm] {
        self.alarms.at(now_ns).unwrap_or_default()
    }

    /// Returns the origin of the system frame.
    pub fn origin(&self) -> Option<&FrameOrigin> {
        self.origin.as_ref()
    }

    /// Returns the system frame.
    pub fn frame(&self) -> Option<&SystemFrame> {
        self.frame.as_ref()
    }

    /// Returns the processes, see [`HealthBook::processes`].
    pub fn processes(&self, expected: &[(ProcessKind, String)], now_ns: i64) -> Vec<ObservedProcess> {
        self.book.processes(expected, self.expected_ns(now_ns))
    }

    /// Returns the time up to which messages have arrived from every process that runs at `now_ns`.
    fn expected_ns(&self, now_ns: i64) -> i64 {
        now_ns.saturating_sub(self.repeated_ns)
    }

    /// Returns the orders in force, and orders that ended recently.
    pub fn orders(&self) -> &[OrderState] {
        &self.orders
    }

    /// Returns the orders in force.
    pub fn orders_in_force(&self) -> impl Iterator<Item = &OrderState> {
        let in_force = |state: &&OrderState| state.status() == Some(OrderStatus::InForce);
        self.orders.iter().filter(in_force)
    }

    /// Returns the offset of the data from the machine's clock at `now_ns` (monotonic), nanoseconds, positive: data
    /// ahead. `None` without recent states.
    pub fn data_offset_ns(&self, now_ns: i64) -> Option<i64> {
        self.data_offset.ns(now_ns)
    }

    /// Returns the part of the offset of the data that is not by design, nanoseconds: the fastest source may take one
    /// of its periods to send a measurement, and a tracker a second one, since it uses a scan when the next one begins.
    pub fn unexplained_offset_ns(&self, now_ns: i64) -> Option<i64> {
        let offset_ns = self.data_offset_ns(now_ns)?;
        let sources = || {
            let all = self.configured_sources().iter();
            all.filter(|source| source.sensor_of.is_none())
        };
        let is_tracker = |of: &SourceFacts| {
            self.configured_sources()
                .iter()
                .any(|one| one.sensor_of == Some(of.number))
        };
        let usual_ns = |source: &SourceFacts| source.period_ns * if is_tracker(source) { 2 } else { 1 };
        // A fast source that is silent explains nothing.
        let reporting = sources().filter(|source| !self.is_source_silent(source.number, now_ns));
        let usual_ns = reporting.map(usual_ns).min().or_else(|| sources().map(usual_ns).min());
        Some(match offset_ns < 0 {
            true => (offset_ns + usual_ns.unwrap_or_default()).min(0),
            false => offset_ns,
        })
    }

    /// Whether the leading fusion is absent at `now_ns` (monotonic, nanoseconds): neither health messages nor system
    /// tracks for two seconds.
    pub fn is_fusion_absent(&self, now_ns: i64) -> bool {
        is_absent(self.fusion_ns, self.expected_ns(now_ns))
    }

    /// Whether the launcher stops the deployment.
    pub fn is_stopping(&self) -> bool {
        let launcher = self.book.whole(ProcessKind::Launcher, ProcessKind::Launcher.word());
        launcher.is_some_and(|launcher| launcher.counters()[Counter::Stopping] > 0)
    }

    /// Whether the deployment has ended, by the launcher's last message.
    pub fn has_ended(&self) -> bool {
        let launcher = self.book.whole(ProcessKind::Launcher, ProcessKind::Launcher.word());
        launcher.is_some_and(|launcher| launcher.life() == Some(LifeState::Finished))
    }

    /// Returns the system tracks by state.
    pub fn track_counts(&self) -> TrackCounts {
        TrackCounts::new(&self.book.service(ProcessKind::Fusion, NO_SOURCE), self.live_max)
    }
}

/// States of the sources.
impl Deployment {
    /// Returns the states of all sources in the order of their numbers: the configured ones, or those with messages.
    pub fn sources(&self) -> Vec<SourceState> {
        self.source_numbers()
            .into_iter()
            .map(|number| self.source(number))
            .collect()
    }

    /// Returns the state of a source.
    pub fn source(&self, number: u16) -> SourceState {
        let adapter = match self.configured(number) {
            Some(source) => self.book.adapter(&source.adapter, number),
            None => self.book.adapter_of(number),
        };
        SourceState::new(&self.book, number, self.source_name(number), adapter)
    }

    /// Returns the input that adapters have refused last.
    pub fn refused_input(&self) -> Vec<RefusedInput> {
        let stated = self.book.all().filter(|(.., latest)| !latest.refusal().is_empty());
        let of = |kind, source, latest: LatestHealth<'_>| match source {
            NO_SOURCE => process_title(kind, latest.name()),
            source => self.source_name(source),
        };
        let refused = stated.map(|(kind, source, latest)| RefusedInput {
            of: of(kind, source, latest),
            text: latest.refusal().to_owned(),
        });
        refused.collect()
    }

    /// Returns the name of a source; "others" for [`NO_SOURCE`], and the number as in files for an unknown source.
    pub fn source_name(&self, number: u16) -> String {
        self.known_name(number).map_or_else(
            || match number {
                NO_SOURCE => "others".to_owned(),
                // In files, sources count from 1.
                number => format!("source {}", u32::from(number) + 1),
            },
            str::to_owned,
        )
    }

    /// Returns the name of a source, if it is known.
    pub fn known_name(&self, number: u16) -> Option<&str> {
        match &self.sources {
            Some(_) => self.configured(number).map(|source| source.name.as_str()),
            None => Some(number)
                .filter(|number| *number != NO_SOURCE)
                .and_then(|number| self.book.source_name(number)),
        }
    }

    /// Returns the configured sources; empty for a reader without the configuration.
    pub fn configured_sources(&self) -> &[SourceFacts] {
        self.sources.as_deref().unwrap_or_default()
    }

    fn configured(&self, number: u16) -> Option<&SourceFacts> {
        self.configured_sources().iter().find(|source| source.number == number)
    }

    fn source_numbers(&self) -> BTreeSet<u16> {
        match &self.sources {
            Some(sources) => sources.iter().map(|source| source.number).collect(),
            None => {
                let has_sources = [ProcessKind::Adapter, ProcessKind::Fusion];
                let entries = self.book.all().filter(|(kind, ..)| has_sources.contains(kind));
                entries
                    .map(|(_, source, _)| source)
                    .filter(|source| *source != NO_SOURCE)
                    .collect()
            }
        }
    }

    /// Whether nothing is known of a sensor of a tracker: where recordings are joined, the tracker alone is counted.
    pub fn is_counted_with_tracker(&self, source: &SourceFacts) -> bool {
        let own = self.book.about(ProcessKind::Adapter, &source.adapter, source.number);
        source.sensor_of.is_some() && own.is_none()
    }

    /// Returns the number of samples delivered by a configured source; 0 for another one.
    pub fn delivered(&self, number: u16) -> u64 {
        self.delivery(number).map_or(0, |(_, delivery)| delivery.count)
    }

    /// Whether a configured source has delivered nothing for its longest usual silence at `now_ns` (monotonic,
    /// nanoseconds), or nothing at all.
    pub fn is_source_silent(&self, number: u16, now_ns: i64) -> bool {
        self.delivery(number).is_none_or(|(source, delivery)| {
            let is_over = |after_ns: i64| delivery.grown_ns < now_ns - after_ns;
            delivery.grown_ns == i64::MIN || source.silent_after_ns.is_some_and(is_over)
        })
    }

    /// Whether no process publishes health messages about a configured source at `now_ns` (monotonic, nanoseconds):
    /// its adapter is absent; for a source without an adapter, fusion.
    pub fn is_source_absent(&self, number: u16, now_ns: i64) -> bool {
        self.configured(number).is_none_or(|source| match source.is_external {
            true => self.is_fusion_absent(now_ns),
            false => {
                let adapter_ns = self.book.time_ns(ProcessKind::Adapter, &source.adapter);
                is_absent(adapter_ns.unwrap_or(i64::MIN), self.expected_ns(now_ns))
            }
        })
    }

    fn delivery(&self, number: u16) -> Option<(&SourceFacts, &Delivery)> {
        let mut sources = self.configured_sources().iter().zip(&self.deliveries);
        sources.find(|(source, _)| source.number == number)
    }
}

/// Whether a process with its latest sign of life at `alive_ns` is absent at `now_ns`.
fn is_absent(alive_ns: i64, now_ns: i64) -> bool {
    now_ns.saturating_sub(alive_ns) > ABSENT_AFTER_NS
}

#[cfg(test)]
#[path = "deployment_tests.rs"]
mod tests;
