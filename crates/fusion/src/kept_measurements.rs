//! The measurements of the last seconds, so that a late report changes the state as if it had come in time.
//!
//! A report that comes late was measured before others that the filter has already used. Carrying it forward along the
//! estimated velocity is wrong in turns, and counts the noise of the motion since then as an error of the report. The
//! filter therefore goes back: it takes the latest earlier state that is kept, and uses the measurements since then
//! once more, with the late one in its place. The result equals that of the order of measurement.
//!
//! Each system track has a chain of measurements, in the order in which the filter used them, and a few *bases*: states
//! of the filter before certain measurements. The chain begins with the oldest base. Bases lie the denser the younger
//! they are, because most late reports are little late: few measurements are then used again.
//!
//! Measurements of all system tracks share a table of fixed size. If the table is full, a system track gives up its
//! oldest measurements; without any to give up, the chain begins anew. A report from before the chain cannot be used
//! this way. Both tables are reserved at the start, and grow into that room: their memory is used as far as
//! measurements are kept.
//!
//! Source: Y. Bar-Shalom, *Update with out-of-sequence measurements in tracking: exact solution*, IEEE Transactions on
//! Aerospace and Electronic Systems 38 (2002), which names going back and using the measurements again as the exact
//! method for any filter; its own shorter ways hold for a single linear model only.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::filter::{FilterInnovation, TargetFilter};
use crate::kept_measurement::{KeptMeasurement, UsedMeasurement};
use crate::measurement::Measurement;
use crate::motion::Motion;
use crate::system_tracks::SystemSlot;

/// Most bases of a system track.
const BASES_MAX: usize = 6;
/// A base follows the one before after so many measurements, or after so much time, nanoseconds.
const BASE_EVERY: u32 = 8;
const BASE_EVERY_NS: i64 = 3_000_000_000;
/// Most measurements of one system track: as many are used again at most.
const CHAIN_MAX: u32 = 128;

/// Place of a measurement in the table.
pub(crate) type Place = u32;
const NOWHERE: Place = Place::MAX;

/// A measurement in its chain, or a free place among others.
#[derive(Clone, Copy, Debug)]
struct Link {
    kept: KeptMeasurement,
    /// Time of the filter after it, nanoseconds: later than the measurement if that was carried forward.
    at_ns: i64,
    next: Place,
}

impl Link {
    /// Without a measurement.
    const FREE: Self = Self {
        kept: KeptMeasurement::NONE,
        at_ns: 0,
        next: NOWHERE,
    };
}

/// State of a filter, and the number of measurements from there to the next base.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Base {
    filter: TargetFilter,
    /// The measurement before it; none for the oldest base.
    #[serde(skip)]
    after: Place,
    length: u32,
}

/// The chain of one system track.
#[derive(Clone, Copy, Debug)]
struct Chain {
    first: Place,
    last: Place,
    length: u32,
    /// Number of bases, and their places in the table of bases, oldest first; the others are of free places that the
    /// chain keeps, or nowhere.
    bases: usize,
    order: [Place; BASES_MAX],
    /// Number of bases that made room for others.
    replaced: u32,
}

impl Chain {
    const EMPTY: Self = Self {
        first: NOWHERE,
        last: NOWHERE,
        length: 0,
        bases: 0,
        order: [NOWHERE; BASES_MAX],
        replaced: 0,
    };
}

/// The chains of all system tracks.
#[derive(Debug)]
pub(crate) struct KeptMeasurements {
    /// Greatest age of a report relative to the filter, nanoseconds; 0: nothing is kept.
    window_ns: i64,
    links: Vec<Link>,
    /// Most measurements.
    capacity: usize,
    /// First of the places that have become free, which are linked.
    free: Place,
    /// Number of places that a measurement can take.
    room: usize,
    /// By place of the system track.
    chains: Vec<Chain>,
    /// Of all chains, at most `BASES_MAX` of each.
    bases: Vec<Base>,
}

/// What there is for a late report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lateness {
    /// It is not late.
    InTime,
    /// The state before it is kept.
    Kept,
    /// It is older than the window.
    BeyondWindow,
    /// It lies before the chain: the system track is younger, or the table was full.
    BeforeChain,
}

impl KeptMeasurements {
    /// For reports up to `window_ns` late; `capacity` measurements of so many system tracks.
    pub(crate) fn new(window_ns: i64, capacity: usize, systems: usize) -> Self {
        let (capacity, systems) = if window_ns > 0 { (capacity, systems) } else { (0, 0) };
        Self {
            window_ns,
            links: Vec::with_capacity(capacity),
            capacity,
            free: NOWHERE,
            room: capacity,
            chains: vec![Chain::EMPTY; systems],
            bases: Vec::with_capacity(BASES_MAX * systems),
        }
    }

    /// Whether measurements are kept.
    #[inline]
    pub(crate) fn is_on(&self) -> bool {
        self.window_ns > 0
    }

    /// How late a measurement of `time_ns` is for a filter of `filter_ns`, and whether the state before it is kept.
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

    /// The latest base that is not after `time_ns`.
    fn base_before(&self, system: SystemSlot, time_ns: i64) -> Option<usize> {
        let bases = 0..self.chains[system as usize].bases;
        bases
            .rev()
            .find(|index| self.base(system, *index).filter.time_ns <= time_ns)
    }

    /// Place of the base number `index` of a system track.
    #[inline]
    fn base_place(&self, system: SystemSlot, index: usize) -> usize {
        self.chains[system as usize].order[index] as usize
    }

    #[inline]
    fn base(&self, system: SystemSlot, index: usize) -> &Base {
        &self.bases[self.base_place(system, index)]
    }

    #[inline]
    fn base_mut(&mut self, system: SystemSlot, index: usize) -> &mut Base {
        let place = self.base_place(system, index);
        &mut self.bases[place]
    }

    /// Forgets all measurements of a system track, whose filter begins anew or is gone.
    pub(crate) fn forget(&mut self, system: SystemSlot) {
        if let Some(chain) = self.chains.get(system as usize) {
            let (last, length) = (chain.last, chain.length);
            self.release(system, last, length);
            self.chains[system as usize].bases = 0;
        }
    }

    /// Frees the first `length` measurements of a chain, up to `end`.
    fn release(&mut self, system: SystemSlot, end: Place, length: u32) {
        if length == 0 {
            return;
        }
        let chain = &mut self.chains[system as usize];
        let after = std::mem::replace(&mut self.links[end as usize].next, self.free);
        self.free = std::mem::replace(&mut chain.first, after);
        self.room += length as usize;
        chain.length -= length;
        if after == NOWHERE {
            chain.last = NOWHERE;
        }
    }

    /// Lets `into` go on with the filter, and thus the measurements, of `from`.
    pub(crate) fn take_over(&mut self, from: SystemSlot, into: SystemSlot) {
        if self.is_on() {
            self.forget(into);
            self.chains.swap(from as usize, into as usize);
        }
    }

    /// The filter of a system track follows another point from now on, so far from the one before: see
    /// [`TargetFilter::shift`].
    pub(crate) fn shift(&mut self, system: SystemSlot, by_m: [f64; 2]) {
        if !self.is_on() {
            return;
        }
        for index in 0..self.chains[system as usize].bases {
            self.base_mut(system, index).filter.shift(by_m);
        }
        let mut at = self.chains[system as usize].first;
        while at != NOWHERE {
            let link = &mut self.links[at as usize];
            for (axis, by) in by_m.into_iter().enumerate() {
                link.kept.measurement.position_m[axis] += by;
                link.kept.point_m[axis] -= by;
            }
            at = link.next;
        }
    }

    /// Begins the chain of a system track with a filter that has used no measurement yet, unless there is one.
    #[inline]
    pub(crate) fn begin(&mut self, system: SystemSlot, filter: &TargetFilter) {
        if self.chains[system as usize].bases == 0 {
            self.add_base(system, filter);
        }
    }

    /// Adds the measurement that the filter has just used.
    #[inline]
    pub(crate) fn append(&mut self, system: SystemSlot, filter: &TargetFilter, used: &UsedMeasurement<'_>) {
        self.append_with(system, filter, |kept| used.write(kept));
    }

    /// Adds the measurement that the filter has just used.
    pub(crate) fn append_kept(&mut self, system: SystemSlot, filter: &TargetFilter, used: &KeptMeasurement) {
        self.append_with(system, filter, |kept| *kept = *used);
    }

    /// Makes a link the last of a chain; returns the number of the chain's newest base.
    #[inline]
    fn put_last(&mut self, system: SystemSlot, place: Place) -> usize {
        let chain = &mut self.chains[system as usize];
        match std::mem::replace(&mut chain.last, place) {
            NOWHERE => chain.first = place,
            last => self.links[last as usize].next = place,
        }
        chain.length += 1;
        chain.bases - 1
    }

    #[inline]
    fn append_with(&mut self, system: SystemSlot, filter: &TargetFilter, write: impl FnOnce(&mut KeptMeasurement)) {
        let Some(place) = self.take_place(system) else {
            // What comes later is kept again.
            self.forget(system);
            self.add_base(system, filter);
            return;
        };
        let newest = self.put_last(system, place);
        let link = &mut self.links[place as usize];
        write(&mut link.kept);
        (link.at_ns, link.next) = (filter.time_ns, NOWHERE);
        let base = self.base_mut(system, newest);
        base.length += 1;
        let passed_ns = filter.time_ns.saturating_sub(base.filter.time_ns);
        if base.length >= BASE_EVERY || passed_ns >= BASE_EVERY_NS {
            self.make_room_for_base(system, filter.time_ns);
            self.add_base(system, filter);
        }
    }

    /// A free place of the table; if need be, one of the oldest measurements of the system track.
    #[inline]
    fn take_place(&mut self, system: SystemSlot) -> Option<Place> {
        let is_full = self.chains[system as usize].length >= CHAIN_MAX || self.room == 0;
        if is_full && !self.drop_oldest(system) {
            return None;
        }
        self.free_place()
    }

    /// A free place: one that was used before, if there is one.
    #[inline]
    fn free_place(&mut self) -> Option<Place> {
        let place = match self.links.get(self.free as usize) {
            Some(link) => std::mem::replace(&mut self.free, link.next),
            None => self.new_place()?,
        };
        self.room -= 1;
        Some(place)
    }

    /// A place that was never used.
    #[cold]
    fn new_place(&mut self) -> Option<Place> {
        let place = self.links.len();
        (place < self.capacity).then(|| self.links.push(Link::FREE))?;
        Some(place as Place)
    }

    /// Drops what is older than the second base, which becomes the first; `false` without a second base.
    fn drop_oldest(&mut self, system: SystemSlot) -> bool {
        if self.chains[system as usize].bases < 2 {
            return false;
        }
        let length = self.base(system, 0).length;
        let end = std::mem::replace(&mut self.base_mut(system, 1).after, NOWHERE);
        self.release(system, end, length);
        self.drop_base(system, 0);
        true
    }

    /// Takes a base out of the order.
    fn drop_base(&mut self, system: SystemSlot, index: usize) {
        let chain = &mut self.chains[system as usize];
        chain.order[index..chain.bases].rotate_left(1);
        chain.bases -= 1;
    }

    /// Adds a base after the latest measurement.
    fn add_base(&mut self, system: SystemSlot, filter: &TargetFilter) {
        let chain = &mut self.chains[system as usize];
        let (index, after) = (chain.bases, chain.last);
        chain.bases += 1;
        if chain.order[index] == NOWHERE {
            chain.order[index] = self.bases.len() as Place;
            self.bases.push(Base {
                filter: *filter,
                after,
                length: 0,
            });
            return;
        }
        let base = self.base_mut(system, index);
        base.filter = *filter;
        (base.after, base.length) = (after, 0);
    }

    /// Drops bases that are no longer needed, until there is room for another one.
    fn make_room_for_base(&mut self, system: SystemSlot, now_ns: i64) {
        // The report before an overtaken one may be older than the window.
        let limit_ns = now_ns.saturating_sub(self.window_ns + self.window_ns / 2);
        while self.chains[system as usize].bases > 1 && self.base(system, 1).filter.time_ns <= limit_ns {
            self.drop_oldest(system);
        }
        let chain = &mut self.chains[system as usize];
        if chain.bases == BASES_MAX {
            // Every second time the newest, every fourth time the one before, and so on: the older, the fewer.
            // Never the oldest, where the chain begins.
            chain.replaced = chain.replaced.wrapping_add(1);
            let index = (BASES_MAX - 1)
                .saturating_sub(chain.replaced.trailing_zeros() as usize)
                .max(1);
            let length = self.base(system, index).length;
            self.base_mut(system, index - 1).length += length;
            self.drop_base(system, index);
        }
    }

    /// Uses a late measurement, whose [`Self::lateness`] is `Kept`, in its place: `filter` becomes what it would be if
    /// the measurement had come in time. Returns the innovation at that time, with the weight of the measurement in the
    /// present position. `None`, and nothing changes, if the table has no room or the measurement
    /// cannot be used. The measurement at the place of a `successor` is another one from now on: it depends on the one
    /// before.
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
            self.links[place as usize].next = std::mem::replace(&mut self.free, place);
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
        let Base {
            filter: mut again,
            after: mut before,
            ..
        } = *self.base(system, index);
        let mut next = match before {
            NOWHERE => self.chains[system as usize].first,
            before => self.links[before as usize].next,
        };
        while next != NOWHERE && self.links[next as usize].at_ns <= kept.time_ns {
            let link = &self.links[next as usize];
            link.kept.use_in(&mut again, &motion_of);
            (before, next) = (next, link.next);
        }
        let mut innovation = kept.use_in(&mut again, &motion_of)?;
        if let Some((place, measurement)) = successor {
            self.links[place as usize].kept.measurement = measurement;
        }
        self.links[place as usize] = Link {
            kept: *kept,
            at_ns: again.time_ns,
            next,
        };
        let chain = &mut self.chains[system as usize];
        match before {
            NOWHERE => chain.first = place,
            before => self.links[before as usize].next = place,
        }
        if next == NOWHERE {
            chain.last = place;
        }
        chain.length += 1;
        let bases = chain.bases;
        self.base_mut(system, index).length += 1;
        let mut index = index + 1;
        while next != NOWHERE {
            let link = &self.links[next as usize];
            let later = link.kept.use_in(&mut again, &motion_of);
            innovation.gain *= 1.0 - later.map_or(0.0, |later| later.gain);
            let at = std::mem::replace(&mut next, link.next);
            if index < bases && self.base(system, index).after == at {
                let base_here = self.base_mut(system, index);
                base_here.filter = again;
                index += 1;
            }
        }
        *filter = again;
        Some(innovation)
    }

    /// The measurements of a source's track right before and right after `time_ns` in the chain of a system track.
    /// `None` if there is none before, or if one has that very time.
    pub(crate) fn around(
        &self,
        system: SystemSlot,
        track: (u16, u32),
        time_ns: i64,
    ) -> Option<(&KeptMeasurement, Option<Place>)> {
        let (mut before, mut after) = (None::<&KeptMeasurement>, None::<(i64, Place)>);
        for (place, link) in self.chain(system) {
            let kept = &link.kept;
            if kept.track != track {
                continue;
            }
            match kept.time_ns.cmp(&time_ns) {
                std::cmp::Ordering::Equal => return None,
                std::cmp::Ordering::Less if before.is_none_or(|before| before.time_ns < kept.time_ns) => {
                    before = Some(kept);
                }
                std::cmp::Ordering::Greater if after.is_none_or(|(after_ns, _)| kept.time_ns < after_ns) => {
                    after = Some((kept.time_ns, place));
                }
                _ => {}
            }
        }
        before.map(|before| (before, after.map(|(_, place)| place)))
    }

    /// The measurements of a system track, in the order of their use, with their places.
    fn chain(&self, system: SystemSlot) -> impl Iterator<Item = (Place, &Link)> {
        let at = |place: Place| Some((place, self.links.get(place as usize)?));
        std::iter::successors(at(self.chains[system as usize].first), move |(_, link)| at(link.next))
    }

    /// The measurement at a place.
    pub(crate) fn at(&self, place: Place) -> &KeptMeasurement {
        &self.links[place as usize].kept
    }

    /// Number of measurements kept.
    #[cfg(test)]
    pub(crate) fn len(&self) -> usize {
        self.capacity - self.room
    }
}

/// A chain by itself: its bases, its measurements with the time of the filter after each, and how many bases made room.
type ChainContent = (Vec<Base>, Vec<(KeptMeasurement, i64)>, u32);

impl Serialize for KeptMeasurements {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let content = |system: usize| -> ChainContent {
            let system = system as SystemSlot;
            let bases = (0..self.chains[system as usize].bases).map(|index| *self.base(system, index));
            let links = self.chain(system).map(|(_, link)| (link.kept, link.at_ns));
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
            for base in bases.into_iter().take(BASES_MAX) {
                new.add_base(system, &base.filter);
                new.restore(system, base.length, &mut links);
            }
        }
        Ok(new)
    }
}

impl KeptMeasurements {
    /// Appends measurements from elsewhere to the newest base of a chain.
    fn restore(&mut self, system: SystemSlot, length: u32, from: &mut impl Iterator<Item = (KeptMeasurement, i64)>) {
        for (kept, at_ns) in from.take(length as usize) {
            let Some(place) = self.free_place() else {
                return;
            };
            self.links[place as usize] = Link {
                kept,
                at_ns,
                next: NOWHERE,
            };
            let newest = self.put_last(system, place);
            self.base_mut(system, newest).length += 1;
        }
    }
}

#[cfg(test)]
#[path = "kept_measurements_tests.rs"]
mod tests;
