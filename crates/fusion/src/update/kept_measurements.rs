//! Measurements of the last seconds, so that a late report changes the state like a report in time.
//!
//! A late report was measured before other reports that the filter has already used. Extrapolation along the estimated
//! velocity is wrong in turns, and counts the process noise since then as an error of the report. The filter therefore
//! goes back to the latest earlier kept state, and repeats the updates since then, with the late measurement in the
//! right place. The result equals the result in the order of measurement.
//!
//! Each system track has a chain of measurements, in the order of use by the filter, and a few *bases*: states of the
//! filter before certain measurements. The chain begins with the oldest base. Younger bases lie denser, because most
//! late reports are only slightly late: few measurements are then used again.
//!
//! Measurements of all system tracks share a table of fixed size. If the table is full, a system track drops the oldest
//! measurements; if none can be dropped, the chain begins anew. A report from before the chain cannot be used this way.
//! Both tables are reserved at the start, and grow into that room: memory use follows the number of kept measurements.
//!
//! Source: Y. Bar-Shalom, *Update with out-of-sequence measurements in tracking: exact solution*, IEEE Transactions on
//! Aerospace and Electronic Systems 38 (2002), which names going back and using the measurements again as the exact
//! method for any filter. The shorter methods of the paper hold for a single linear model only.

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use source_models::{FilterInnovation, Measurement, Motion};

use crate::tables::system_tracks::SystemSlot;
use crate::update::filter::TargetFilter;
use crate::update::kept_measurement::{KeptMeasurement, StoredMeasurement, UsedMeasurement};

/// Maximum number of bases of a system track.
const BASES_MAX: usize = 4;
/// Distance between bases: number of measurements, or time in nanoseconds.
const BASE_EVERY: u32 = 8;
const BASE_EVERY_NS: i64 = 3_000_000_000;
/// Maximum number of measurements of a system track, and thus of repeated updates.
const CHAIN_MAX: u32 = 128;

/// Place of a measurement in the table.
pub(crate) type Place = u32;
const NOWHERE: Place = Place::MAX;

/// A measurement in a chain.
#[derive(Clone, Copy, Debug)]
struct Link {
    stored: StoredMeasurement,
    /// Time of the filter after the update, nanoseconds: later than a measurement carried forward.
    at_ns: i64,
}

impl Link {
    /// Without a measurement.
    const FREE: Self = Self {
        stored: StoredMeasurement::NONE,
        at_ns: 0,
    };
}

/// A base without the filter: the data needed for each report lie together.
#[derive(Clone, Copy, Debug)]
struct Base {
    /// Place of the filter; `NOWHERE` for a base never used.
    place: Place,
    /// The measurement before the base; none for the oldest base.
    after: Place,
    /// Number of measurements from the base to the next base.
    length: u32,
    /// Time of the filter, nanoseconds.
    time_ns: i64,
}

impl Base {
    const UNUSED: Self = Self {
        place: NOWHERE,
        after: NOWHERE,
        length: 0,
        time_ns: 0,
    };
}

/// The chain of a system track.
#[derive(Clone, Copy, Debug)]
struct Chain {
    first: Place,
    last: Place,
    length: u32,
    /// Number of bases, and the bases, oldest first. The other entries hold places for further bases, or none.
    count: usize,
    bases: [Base; BASES_MAX],
    /// Number of bases that made room for others.
    replaced: u32,
}

impl Chain {
    const EMPTY: Self = Self {
        first: NOWHERE,
        last: NOWHERE,
        length: 0,
        count: 0,
        bases: [Base::UNUSED; BASES_MAX],
        replaced: 0,
    };
}

/// The chains of all system tracks.
#[derive(Debug)]
pub(crate) struct KeptMeasurements {
    /// Greatest age of a report relative to the filter, nanoseconds; 0: nothing is kept.
    window_ns: i64,
    links: Vec<Link>,
    /// For each link, the next place of the chain or of the free places. The table is separate, so that a new
    /// measurement replaces an old measurement without a fetch of the old from memory.
    next: Vec<Place>,
    /// Maximum number of measurements.
    capacity: usize,
    /// First place in the linked list of freed places.
    free: Place,
    /// Number of places available for measurements.
    room: usize,
    /// By place of the system track.
    chains: Vec<Chain>,
    /// Filters of the bases of all chains, at most `BASES_MAX` per chain.
    filters: Vec<TargetFilter>,
}

/// Lateness of a report, and availability of the state before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lateness {
    /// The report is not late.
    InTime,
    /// The state before the report is kept.
    Kept,
    /// The report is older than the window.
    BeyondWindow,
    /// The report lies before the chain: the system track is younger, or the table was full.
    BeforeChain,
}

impl KeptMeasurements {
    /// Creates tables for reports up to `window_ns` late: `capacity` measurements of `systems` system tracks.
    pub(crate) fn new(window_ns: i64, capacity: usize, systems: usize) -> Self {
        let (capacity, systems) = if window_ns > 0 { (capacity, systems) } else { (0, 0) };
        Self {
            window_ns,
            links: Vec::with_capacity(capacity),
            next: Vec::with_capacity(capacity),
            capacity,
            free: NOWHERE,
            room: capacity,
            chains: vec![Chain::EMPTY; systems],
            filters: Vec::with_capacity(BASES_MAX * systems),
        }
    }

    /// Whether measurements are kept.
    #[inline]
    pub(crate) fn is_on(&self) -> bool {
        self.window_ns > 0
    }

    /// Returns the lateness of a measurement of `time_ns` for a filter of `filter_ns`.
    #[inline]
    pub(crate) fn lateness(&self, system: SystemSlot, filter_ns: i64, time_ns: i64) -> Lateness {
        if time_ns >= filter_ns || !self.is_on() {
            return Lateness::InTime;
        }
        if filter_ns.saturating_sub(time_ns) > self.window_ns {
            return Lateness::BeyondWindow;
        }
        match self.base_before(system, time_ns) {
            Some(_) => Lateness::Kept,
            None => Lateness::BeforeChain,
        }
    }

    /// Returns the latest base not after `time_ns`.
    fn base_before(&self, system: SystemSlot, time_ns: i64) -> Option<usize> {
        self.bases(system).iter().rposition(|base| base.time_ns <= time_ns)
    }

    /// The bases of a system track.
    #[inline]
    fn bases(&self, system: SystemSlot) -> &[Base] {
        let chain = &self.chains[system as usize];
        &chain.bases[..chain.count]
    }

    /// Forgets all measurements of a system track after the restart or end of the filter.
    pub(crate) fn forget(&mut self, system: SystemSlot) {
        if let Some(chain) = self.chains.get(system as usize) {
            let (last, length) = (chain.last, chain.length);
            self.release(system, last, length);
            self.chains[system as usize].count = 0;
        }
    }

    /// Frees the first `length` measurements of a chain, up to `end`.
    fn release(&mut self, system: SystemSlot, end: Place, length: u32) {
        if length == 0 {
            return;
        }
        let chain = &mut self.chains[system as usize];
        let after = std::mem::replace(&mut self.next[end as usize], self.free);
        self.free = std::mem::replace(&mut chain.first, after);
        self.room += length as usize;
        chain.length -= length;
        if after == NOWHERE {
            chain.last = NOWHERE;
        }
    }

    /// Moves the measurements of `from` to `into`, which continues with the filter of `from`.
    pub(crate) fn take_over(&mut self, from: SystemSlot, into: SystemSlot) {
        if self.is_on() {
            self.forget(into);
            self.chains.swap(from as usize, into as usize);
        }
    }

    /// Changes a system track to another point of the target, at this offset from the previous point: see
    /// [`TargetFilter::shift`].
    pub(crate) fn shift(&mut self, system: SystemSlot, by_m: [f64; 2]) {
        if !self.is_on() {
            return;
        }
        let chain = &self.chains[system as usize];
        for base in &chain.bases[..chain.count] {
            self.filters[base.place as usize].shift(by_m);
        }
        let mut at = chain.first;
        while at != NOWHERE {
            self.links[at as usize].stored.shift(by_m);
            at = self.next[at as usize];
        }
    }

    /// Begins the chain of a system track with a filter before the first measurement, unless the chain exists.
    #[inline]
    pub(crate) fn begin(&mut self, system: SystemSlot, filter: &TargetFilter) {
        if self.chains[system as usize].count == 0 {
            self.add_base(system, filter);
        }
    }

    /// Appends the measurement of the latest filter update.
    #[inline]
    pub(crate) fn append(&mut self, system: SystemSlot, filter: &TargetFilter, used: &UsedMeasurement<'_>) {
        self.append_with(system, filter, |stored| stored.write(used));
    }

    /// Appends the measurement of the latest filter update.
    pub(crate) fn append_kept(&mut self, system: SystemSlot, filter: &TargetFilter, used: &KeptMeasurement) {
        self.append_with(system, filter, |stored| stored.write_kept(used));
    }

    /// Makes a link the last of a chain; returns the chain's newest base.
    #[inline]
    fn put_last(&mut self, system: SystemSlot, place: Place) -> &mut Base {
        self.next[place as usize] = NOWHERE;
        let chain = &mut self.chains[system as usize];
        match std::mem::replace(&mut chain.last, place) {
            NOWHERE => chain.first = place,
            last => self.next[last as usize] = place,
        }
        chain.length += 1;
        let base = &mut chain.bases[chain.count - 1];
        base.length += 1;
        base
    }

    #[inline]
    fn append_with(&mut self, system: SystemSlot, filter: &TargetFilter, write: impl FnOnce(&mut StoredMeasurement)) {
        let Some(place) = self.take_place(system) else {
            // Later measurements are kept again.
            self.forget(system);
            self.add_base(system, filter);
            return;
        };
        let link = &mut self.links[place as usize];
        write(&mut link.stored);
        link.at_ns = filter.time_ns;
        let base = self.put_last(system, place);
        let passed_ns = filter.time_ns.saturating_sub(base.time_ns);
        if base.length >= BASE_EVERY || passed_ns >= BASE_EVERY_NS {
            self.make_room_for_base(system, filter.time_ns);
            self.add_base(system, filter);
        }
    }

    /// Returns a free place of the table; if necessary, from the oldest measurements of the system track.
    #[inline]
    fn take_place(&mut self, system: SystemSlot) -> Option<Place> {
        let is_full = self.chains[system as usize].length >= CHAIN_MAX || self.room == 0;
        if is_full && !self.drop_oldest(system) {
            return None;
        }
        self.free_place()
    }

    /// Returns a free place, preferably a place used before.
    #[inline]
    fn free_place(&mut self) -> Option<Place> {
        let place = match self.next.get(self.free as usize) {
            Some(next) => std::mem::replace(&mut self.free, *next),
            None => self.new_place()?,
        };
        self.room -= 1;
        Some(place)
    }

    /// Returns a place never used before.
    #[cold]
    fn new_place(&mut self) -> Option<Place> {
        let place = self.links.len();
        if place >= self.capacity {
            return None;
        }
        self.links.push(Link::FREE);
        self.next.push(NOWHERE);
        Some(place as Place)
    }

    /// Drops all measurements before the second base, and makes this base the first; `false` without a second base.
    fn drop_oldest(&mut self, system: SystemSlot) -> bool {
        let [oldest, second] = match &mut self.chains[system as usize] {
            Chain { count: 0 | 1, .. } => return false,
            Chain {
                bases: [oldest, second, ..],
                ..
            } => [oldest, second],
        };
        let (length, end) = (oldest.length, std::mem::replace(&mut second.after, NOWHERE));
        self.release(system, end, length);
        self.drop_base(system, 0);
        true
    }

    /// Removes a base from the order.
    fn drop_base(&mut self, system: SystemSlot, index: usize) {
        let chain = &mut self.chains[system as usize];
        chain.bases[index..chain.count].rotate_left(1);
        chain.count -= 1;
    }

    /// Adds a base after the latest measurement.
    fn add_base(&mut self, system: SystemSlot, filter: &TargetFilter) {
        let chain = &mut self.chains[system as usize];
        let base = &mut chain.bases[chain.count];
        chain.count += 1;
        (base.after, base.length, base.time_ns) = (chain.last, 0, filter.time_ns);
        match self.filters.get_mut(base.place as usize) {
            Some(place) => *place = *filter,
            None => {
                base.place = self.filters.len() as Place;
                self.filters.push(*filter);
            }
        }
    }

    /// Drops bases no longer needed, until another base has room.
    fn make_room_for_base(&mut self, system: SystemSlot, now_ns: i64) {
        // The report before an overtaken report may be older than the window.
        let limit_ns = now_ns.saturating_sub(self.window_ns + self.window_ns / 2);
        while self
            .bases(system)
            .get(1)
            .is_some_and(|second| second.time_ns <= limit_ns)
        {
            self.drop_oldest(system);
        }
        let chain = &mut self.chains[system as usize];
        if chain.count == BASES_MAX {
            // Every second time the newest base, every fourth time the previous base, and so on: older bases are fewer.
            // Never the oldest base, the start of the chain.
            chain.replaced = chain.replaced.wrapping_add(1);
            let index = (BASES_MAX - 1)
                .saturating_sub(chain.replaced.trailing_zeros() as usize)
                .max(1);
            chain.bases[index - 1].length += chain.bases[index].length;
            self.drop_base(system, index);
        }
    }

    /// Inserts a late measurement, of [`Self::lateness`] `Kept`, at the time of measurement: `filter` becomes the same
    /// as with a measurement in time. Returns the innovation at that time, with the weight of the measurement in the
    /// present position. `None`, without any change, if the table has no room or the measurement cannot be used. A
    /// `successor` replaces the measurement at a place, since that measurement depends on the preceding report.
    pub(crate) fn insert<'m>(
        &mut self,
        system: SystemSlot,
        filter: &mut TargetFilter,
        (kept, successor): (&KeptMeasurement, Option<(Place, Measurement)>),
        motion_of: impl Fn(&TargetFilter) -> &'m Motion,
    ) -> Option<FilterInnovation> {
        let place = self.take_place(system)?;
        let effect = self.insert_at(system, filter, (place, kept, successor), motion_of);
        if effect.is_none() {
            self.next[place as usize] = std::mem::replace(&mut self.free, place);
            self.room += 1;
        }
        effect
    }

    fn insert_at<'m>(
        &mut self,
        system: SystemSlot,
        filter: &mut TargetFilter,
        (place, kept, successor): (Place, &KeptMeasurement, Option<(Place, Measurement)>),
        motion_of: impl Fn(&TargetFilter) -> &'m Motion,
    ) -> Option<FilterInnovation> {
        // Making room may have dropped the base.
        let index = self.base_before(system, kept.time_ns)?;
        let base = self.bases(system)[index];
        let (mut again, mut before) = (self.filters[base.place as usize], base.after);
        let mut next = match before {
            NOWHERE => self.chains[system as usize].first,
            before => self.next[before as usize],
        };
        while next != NOWHERE && self.links[next as usize].at_ns <= kept.time_ns {
            let link = &self.links[next as usize];
            link.stored.use_in(&mut again, &motion_of);
            (before, next) = (next, self.next[next as usize]);
        }
        let mut innovation = kept.use_in(&mut again, &motion_of)?;
        if let Some((place, measurement)) = successor {
            self.links[place as usize].stored.replace(&measurement);
        }
        let link = &mut self.links[place as usize];
        link.stored.write_kept(kept);
        link.at_ns = again.time_ns;
        self.next[place as usize] = next;
        let chain = &mut self.chains[system as usize];
        match before {
            NOWHERE => chain.first = place,
            before => self.next[before as usize] = place,
        }
        if next == NOWHERE {
            chain.last = place;
        }
        chain.length += 1;
        chain.bases[index].length += 1;
        let mut later_bases = chain.bases[index + 1..chain.count].iter_mut().peekable();
        while next != NOWHERE {
            let link = &self.links[next as usize];
            let later = link.stored.use_in(&mut again, &motion_of);
            innovation.gain *= 1.0 - later.map_or(0.0, |later| later.gain);
            let at = next;
            next = self.next[at as usize];
            if let Some(base) = later_bases.next_if(|base| base.after == at) {
                base.time_ns = again.time_ns;
                self.filters[base.place as usize] = again;
            }
        }
        *filter = again;
        Some(innovation)
    }

    /// Returns the measurements of a sensor track right before and right after `time_ns` in the chain of a system
    /// track. `None` without a measurement before, or if a measurement has that very time.
    pub(crate) fn around(
        &self,
        system: SystemSlot,
        track: (u16, u32),
        time_ns: i64,
    ) -> Option<(KeptMeasurement, Option<Place>)> {
        let (mut before, mut after) = (None::<&StoredMeasurement>, None::<(i64, Place)>);
        for (place, link) in self.chain(system) {
            let stored = &link.stored;
            if stored.track() != track {
                continue;
            }
            match stored.time_ns().cmp(&time_ns) {
                std::cmp::Ordering::Equal => return None,
                std::cmp::Ordering::Less if before.is_none_or(|before| before.time_ns() < stored.time_ns()) => {
                    before = Some(stored);
                }
                std::cmp::Ordering::Greater if after.is_none_or(|(after_ns, _)| stored.time_ns() < after_ns) => {
                    after = Some((stored.time_ns(), place));
                }
                _ => {}
            }
        }
        before.map(|before| (before.kept(), after.map(|(_, place)| place)))
    }

    /// Returns the measurements of a system track with places, in the order of use.
    fn chain(&self, system: SystemSlot) -> impl Iterator<Item = (Place, &Link)> {
        let at = |place: Place| Some((place, self.links.get(place as usize)?));
        let first = self.chains[system as usize].first;
        std::iter::successors(at(first), move |(place, _)| at(self.next[*place as usize]))
    }

    /// The measurement at a place.
    pub(crate) fn at(&self, place: Place) -> KeptMeasurement {
        self.links[place as usize].stored.kept()
    }

    /// Number of measurements kept.
    #[cfg(test)]
    pub(crate) fn len(&self) -> usize {
        self.capacity - self.room
    }
}

/// Content of a chain: bases with lengths, measurements with the time of the filter after each, and number of bases
/// that made room.
type ChainContent = (Vec<(TargetFilter, u32)>, Vec<(StoredMeasurement, i64)>, u32);

impl Serialize for KeptMeasurements {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let content = |system: usize| -> ChainContent {
            let system = system as SystemSlot;
            let bases = self.bases(system).iter();
            let bases = bases.map(|base| (self.filters[base.place as usize], base.length));
            let links = self.chain(system).map(|(_, link)| (link.stored, link.at_ns));
            (bases.collect(), links.collect(), self.chains[system as usize].replaced)
        };
        let chains: Vec<ChainContent> = (0..self.chains.len()).map(content).collect();
        (self.window_ns, self.capacity, chains).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for KeptMeasurements {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let (window_ns, capacity, chains): (i64, usize, Vec<ChainContent>) = Deserialize::deserialize(deserializer)?;
        let mut new = Self::new(window_ns, capacity, chains.len());
        for (system, (bases, links, replaced)) in (0..).zip(chains) {
            new.chains[system as usize].replaced = replaced;
            let mut links = links.into_iter();
            for (filter, length) in bases.into_iter().take(BASES_MAX) {
                new.add_base(system, &filter);
                new.restore(system, length, &mut links);
            }
        }
        Ok(new)
    }
}

impl KeptMeasurements {
    /// Appends measurements from elsewhere to the newest base of a chain.
    fn restore(&mut self, system: SystemSlot, length: u32, from: &mut impl Iterator<Item = (StoredMeasurement, i64)>) {
        for (stored, at_ns) in from.take(length as usize) {
            let Some(place) = self.free_place() else {
                return;
            };
            self.links[place as usize] = Link { stored, at_ns };
            self.put_last(system, place);
        }
    }
}

#[cfg(test)]
#[path = "kept_measurements_tests.rs"]
mod tests;
