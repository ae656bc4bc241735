//! State of one page: the records already sent, and the next picture.

use messages::layout::Sample;
use messages::picture::{
    LayerRecord as _, PictureHeader, PictureIdentity, PictureLayer, PictureSensorTrack, PictureTrack, picture_bits,
};
use messages::{Contribution, Identity, TrackState};
use runtime::Now;
use rustc_hash::FxHashMap;

use crate::history::Then;
use crate::passing::LAYERS;
use crate::reports::LatestReports;
use crate::wire::{Filter, Past, Wish};
use crate::world::{ReceivedRecord, World};

const NS_PER_MS: i64 = 1_000_000;

/// View of one page on the world.
#[derive(Debug)]
pub(crate) struct Viewer {
    rate_hz: f64,
    view: Option<[f32; 4]>,
    filter: Option<Filter>,
    pub(crate) selected: Vec<u32>,
    past: Option<PastView>,
    /// Stamp of the latest sent record of each requested layer.
    layers: [Option<u64>; LAYERS],
    /// Tracks already sent, in the order of their numbers, each with the stamp of its sent state.
    shown: Vec<(u32, u64)>,
    /// Stamps of the identities already sent.
    named: FxHashMap<u32, u64>,
    /// Whether the next picture is a full one, and the generation of the world in the previous picture.
    full: bool,
    generation: u64,
    sequence: u32,
    /// Picture without acknowledgement so far.
    outstanding: Option<u32>,
}

/// View of a page on the past.
#[derive(Debug)]
struct PastView {
    asked: Past,
    /// Time of the request, monotonic, nanoseconds.
    since_ns: i64,
    then: Then,
    /// Sensor tracks at the requested moment.
    latest: LatestReports,
}

/// State from which a picture's record is made.
struct DisplayedState<'a> {
    number: u32,
    stamp: u64,
    time_ns: i64,
    measured_ns: i64,
    record: &'a PictureTrack,
}

impl Default for Viewer {
    fn default() -> Self {
        Self {
            rate_hz: 4.0,
            view: None,
            filter: None,
            selected: Vec::new(),
            past: None,
            layers: [None; LAYERS],
            shown: Vec::new(),
            named: FxHashMap::default(),
            full: true,
            generation: 0,
            sequence: 0,
            outstanding: None,
        }
    }
}

impl Viewer {
    /// Applies a wish.
    pub(crate) fn wish(&mut self, wish: Wish, now: Now) {
        if let Some(rate_hz) = wish.rate_hz {
            self.rate_hz = rate_hz;
        }
        if let Some(view) = wish.view {
            self.view = view;
        }
        if let Some(filter) = wish.filter {
            self.filter = filter;
        }
        if let Some(select) = wish.select {
            self.selected = select;
        }
        if let Some(layers) = wish.layers {
            for layer in PictureLayer::ALL {
                let stamp = &mut self.layers[layer as usize];
                *stamp = layers.contains(&layer).then(|| stamp.unwrap_or(0));
            }
        }
        if let Some(past) = wish.past {
            // Stamps of the present and numbers of the past must not be confused, and a jump through the past
            // invalidates all records of the previous moment.
            self.full |= past.is_some() || self.past.is_some();
            let (then, latest) = self
                .past
                .take()
                .map(|view| (view.then, view.latest))
                .unwrap_or_default();
            self.past = past.map(|asked| PastView {
                asked,
                since_ns: now.mono_ns,
                then,
                latest,
            });
        }
        // An acknowledgement of an earlier picture does not acknowledge the picture in transit.
        self.outstanding = self.outstanding.filter(|sequence| wish.ack != Some(*sequence));
    }

    /// Returns the rate of pictures per second.
    pub(crate) fn rate_hz(&self) -> f64 {
        self.rate_hz
    }

    /// Whether an acknowledgement is outstanding.
    pub(crate) fn is_behind(&self) -> bool {
        self.outstanding.is_some()
    }

    /// Returns the shown moment of the past, UTC, nanoseconds; `None`: the present.
    pub(crate) fn past_ns(&self, world: &World, now: Now) -> Option<i64> {
        let past = self.past.as_ref()?;
        let wanted_s = past.asked.at_s(now.mono_ns - past.since_ns);
        let [from_ns, to_ns] = world.history.span_ns().unwrap_or([i64::MIN; 2]);
        Some(frames::time::ns(wanted_s).clamp(from_ns, to_ns.max(from_ns)))
    }

    /// Returns the shown states of the past, by number; `None`: the present is shown.
    pub(crate) fn then(&self) -> Option<&Then> {
        self.past.as_ref().map(|past| &past.then)
    }

    /// Returns the latest report of a contributor at the shown moment of the past.
    pub(crate) fn report_then(&self, world: &World, part: &Contribution) -> Option<PictureSensorTrack> {
        let number = self
            .past
            .as_ref()?
            .latest
            .reports
            .get(&(part.source, part.track_number))?;
        Some(world.reports.get(*number)?.record)
    }

    /// Makes the next picture, with all changes.
    pub(crate) fn picture(&mut self, world: &World, now: Now) -> Vec<u8> {
        let past_ns = self.past_ns(world, now);
        let time_ns = past_ns.unwrap_or_else(|| world.time_ns(now));
        if let Some(past) = &mut self.past {
            world.history.go_to(&mut past.then, time_ns);
            if self.layers[PictureLayer::SensorTracks as usize].is_some() || !self.selected.is_empty() {
                world.reports.go_to(&mut past.latest, time_ns);
            }
        }
        if self.generation != world.generation {
            (self.generation, self.full) = (world.generation, true);
        }
        if std::mem::take(&mut self.full) {
            self.layers.iter_mut().flatten().for_each(|stamp| *stamp = 0);
            self.shown.clear();
            self.named.clear();
            self.sequence = self.sequence.wrapping_add(1);
            return self.compose(world, now, time_ns, picture_bits::FULL);
        }
        self.sequence = self.sequence.wrapping_add(1);
        self.compose(world, now, time_ns, 0)
    }

    fn compose(&mut self, world: &World, now: Now, time_ns: i64, full: u32) -> Vec<u8> {
        let mut blocks = PictureBlocks::new(time_ns);
        let before = std::mem::take(&mut self.shown);
        let mut before = before.into_iter().peekable();
        let mut shown = Vec::with_capacity(world.tracks.len());
        let states: &mut dyn Iterator<Item = DisplayedState<'_>> = match &self.past {
            None => &mut world.tracks.iter().map(|(number, live)| DisplayedState {
                number: *number,
                stamp: live.stamp,
                time_ns: live.track.reference_time_ns,
                measured_ns: live.measured_ns,
                record: &live.record,
            }),
            Some(past) => &mut past.then.states.iter().filter_map(|(number, state)| {
                let moment = world.history.moment(*state)?;
                Some(DisplayedState {
                    number: *number,
                    stamp: *state,
                    time_ns: moment.time_ns,
                    measured_ns: moment.measured_ns,
                    record: &moment.track,
                })
            }),
        };
        for state in states {
            let identity = world.identities.get(&state.number);
            if !self
                .view
                .is_none_or(|view| contains(view, state.record.east_m, state.record.north_m))
                || !self
                    .filter
                    .as_ref()
                    .is_none_or(|filter| filter.admits(state.record, identity))
            {
                continue;
            }
            while let Some((gone, _)) = before.next_if(|(number, _)| *number < state.number) {
                blocks.remove(gone);
            }
            let had = before
                .next_if(|(number, _)| *number == state.number)
                .map(|(_, stamp)| stamp);
            if had != Some(state.stamp) {
                blocks.track(&state);
            }
            if let Some(identity) = identity
                && self.named.get(&state.number) != Some(&identity.stamp)
            {
                self.named.insert(state.number, identity.stamp);
                blocks.identities.push(identity.record);
            }
            shown.push((state.number, state.stamp));
        }
        before.for_each(|(gone, _)| blocks.remove(gone));
        for gone in &blocks.removed {
            self.named.remove(gone);
        }
        self.shown = shown;
        self.layers(world, &mut blocks);
        let recording = world.recording.as_ref().map(|recording| &recording.wanted);
        let past = recording.or(self.past.as_ref().map(|past| &past.asked));
        let flags = [
            (past.is_some(), picture_bits::PAST),
            (past.is_some_and(|past| past.speed == 0.0), picture_bits::PAUSED),
            (
                world.observed.is_fusion_absent(now.mono_ns),
                picture_bits::FUSION_SILENT,
            ),
        ];
        let flags = flags
            .into_iter()
            .filter(|(is_set, _)| *is_set)
            .fold(full, |flags, (_, bit)| flags | bit);
        self.outstanding = Some(self.sequence);
        blocks.octets(self.sequence, flags)
    }

    /// Adds the new records of the requested layers; of the past, only system and sensor tracks are stored.
    fn layers(&mut self, world: &World, blocks: &mut PictureBlocks) {
        let (view, time_ns) = (self.view, blocks.time_ns);
        let in_view = |[east_m, north_m]: [f32; 2]| view.is_none_or(|view| contains(view, east_m, north_m));
        let age = |then_ns| age_ms(time_ns, then_ns);
        for layer in PictureLayer::ALL {
            let (Some(stamp), block) = (&mut self.layers[layer as usize], &mut blocks.layers[layer as usize]) else {
                continue;
            };
            let mut sensor_track = |record: &PictureSensorTrack, time_ns| {
                if record.place_m().is_none_or(in_view) {
                    block.extend_from_slice(Sample::octets(&[record.with_age(age(time_ns))]));
                }
            };
            match (&self.past, layer) {
                (Some(past), PictureLayer::SensorTracks) => {
                    let mut new: Vec<u64> = past.latest.reports.values().copied().collect();
                    new.retain(|number| *number > *stamp);
                    new.sort_unstable();
                    *stamp = new.last().copied().unwrap_or(*stamp);
                    let reports = new.into_iter().filter_map(|number| world.reports.get(number));
                    reports.for_each(|report| sensor_track(&report.record, report.time_ns));
                    continue;
                }
                (Some(_), _) => continue,
                (None, PictureLayer::Stations) => {
                    // Stations that cannot be placed yet are still to be sent.
                    let Some(frame) = world.observed.frame().filter(|_| world.is_dated()) else {
                        continue;
                    };
                    for (time_ns, station) in world.stations.since(*stamp, frame) {
                        block.extend_from_slice(Sample::octets(&[station.with_age(age(time_ns))]));
                    }
                }
                (None, PictureLayer::SensorTracks) => {
                    let new = world.sensor_tracks.values().filter(|heard| heard.stamp > *stamp);
                    new.for_each(|heard| sensor_track(&heard.record, heard.time_ns));
                }
                (None, _) => world.passing.append_since(layer, *stamp, (in_view, age), block),
            }
            *stamp = world.stamp;
        }
    }
}

fn contains([west, south, east, north]: [f32; 4], east_m: f32, north_m: f32) -> bool {
    (west..=east).contains(&east_m) && (south..=north).contains(&north_m)
}

/// Returns the milliseconds from `then_ns` to `time_ns`, clamped to the range of the type.
fn age_ms(time_ns: i64, then_ns: i64) -> i32 {
    let age_ms = time_ns.saturating_sub(then_ns) / NS_PER_MS;
    age_ms.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32
}

impl Filter {
    /// Whether the filter admits a track.
    fn admits(&self, track: &PictureTrack, identity: Option<&ReceivedRecord<PictureIdentity>>) -> bool {
        let state = TrackState::from_code(track.state);
        let states = self.states.as_ref();
        let told = u64::from(track.sources_high) << 32 | u64::from(track.sources_low);
        let contributes = |source: &u16| 1_u64.checked_shl(u32::from(*source)).is_some_and(|bit| told & bit != 0);
        let [least, most] = self.height_m.unwrap_or_default();
        let text = self.text.as_deref().unwrap_or_default();
        states.is_none_or(|states| state.is_some_and(|state| states.contains(&state)))
            && self
                .sources
                .as_ref()
                .is_none_or(|sources| sources.iter().any(contributes))
            && !least.is_some_and(|least| track.height_m < least)
            && !most.is_some_and(|most| track.height_m > most)
            && (text.is_empty() || is_called(track.number, identity.map(|known| &known.record), text))
    }
}

/// Whether number, callsign, address, code or name contains `text`.
fn is_called(number: u32, identity: Option<&PictureIdentity>, text: &str) -> bool {
    let identity = identity.map_or_else(Identity::default, |known| Identity {
        address: known.address,
        mode_3a: known.mode_3a,
        kind: known.kind,
        valid: known.valid,
        callsign: known.callsign,
        name: known.name,
        ..Identity::default()
    });
    let known = format!("{number} {identity}");
    known.to_ascii_uppercase().contains(&text.to_ascii_uppercase())
}

/// Blocks of a picture.
struct PictureBlocks {
    time_ns: i64,
    removed: Vec<u32>,
    tracks: Vec<PictureTrack>,
    identities: Vec<PictureIdentity>,
    /// Records of each layer, as they are sent.
    layers: [Vec<u8>; LAYERS],
}

impl PictureBlocks {
    fn new(time_ns: i64) -> Self {
        Self {
            time_ns,
            removed: Vec::new(),
            tracks: Vec::new(),
            identities: Vec::new(),
            layers: Default::default(),
        }
    }

    fn remove(&mut self, number: u32) {
        self.removed.push(number);
    }

    fn track(&mut self, state: &DisplayedState<'_>) {
        self.tracks.push(PictureTrack {
            age_ms: age_ms(self.time_ns, state.time_ns),
            measured_age_ms: age_ms(self.time_ns, state.measured_ns),
            ..*state.record
        });
    }

    /// Encodes the picture for sending; this machine is little-endian, like all machines with shared memory here.
    fn octets(&self, sequence: u32, flags: u32) -> Vec<u8> {
        let mut header = PictureHeader {
            time_ns: self.time_ns,
            sequence,
            flags,
            removed: self.removed.len() as u32,
            tracks: self.tracks.len() as u32,
            identities: self.identities.len() as u32,
            ..PictureHeader::default()
        };
        for layer in PictureLayer::ALL {
            *header.count_mut(layer) = (self.layers[layer as usize].len() / layer.size()) as u32;
        }
        let removed: Vec<u8> = self.removed.iter().flat_map(|number| number.to_le_bytes()).collect();
        [
            PictureHeader::octets(&[header]),
            &removed,
            Sample::octets(&self.tracks),
            Sample::octets(&self.identities),
            &self.layers.concat(),
        ]
        .concat()
    }
}

const _: () = assert!(cfg!(target_endian = "little"), "pictures are little-endian");
