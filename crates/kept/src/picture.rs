//! Snapshot of several values that are replaced together.
//!
//! Each value is a record, and so is the head with the number of values. All records of one snapshot have the same
//! number of writes. A reader therefore finds the copies that belong together: those of the snapshot being written
//! when the writer was killed, or those of the snapshot before.

use std::marker::PhantomData;
use std::sync::atomic::AtomicU64;

use crate::image::{HEAD, Memory, MemoryRefusal, is_marked, mark};
use crate::record::{Copy, RecordArea, mixed};
use crate::value::{Get, Kept, Put};

/// Snapshot of a limited number of values `T`, with a head `F`.
#[derive(Debug)]
pub struct Picture<F, T> {
    memory: Box<dyn Memory>,
    areas: Areas,
    times: u64,
    words: Vec<u64>,
    of: PhantomData<fn(F, T)>,
}

/// Records of a snapshot.
#[derive(Clone, Copy, Debug)]
struct Areas {
    front: RecordArea,
    values: RecordArea,
    fingerprint: u64,
}

impl Areas {
    /// Creates the records; `owner` identifies the owner of the snapshot.
    fn new<F: Kept, T: Kept>(owner: &str, places: usize) -> Self {
        let front = RecordArea {
            first: HEAD,
            places: 1,
            words: u64::WORDS + F::WORDS,
        };
        let values = RecordArea {
            first: HEAD + front.len(),
            places,
            words: T::WORDS,
        };
        let sizes = [front.words, values.words, places];
        let of_sizes = sizes.iter().fold(0, |hash, size| mixed(hash ^ *size as u64));
        Self {
            front,
            values,
            fingerprint: owner
                .bytes()
                .fold(of_sizes, |hash, octet| mixed(hash ^ u64::from(octet))),
        }
    }

    fn len(&self) -> usize {
        HEAD + self.front.len() + self.values.len()
    }
}

impl<F: Kept, T: Kept> Picture<F, T> {
    /// Returns the number of words of memory.
    pub fn words(places: usize) -> usize {
        Areas::new::<F, T>("", places).len()
    }

    /// Opens a snapshot in blank `memory` of [`words`](Self::words) words; `owner` identifies the owner.
    pub fn begin(memory: Box<dyn Memory>, owner: &str, places: usize) -> Self {
        let areas = Areas::new::<F, T>(owner, places);
        mark(memory.words(), areas.fingerprint);
        Self {
            memory,
            areas,
            times: 0,
            words: vec![0; areas.front.words.max(areas.values.words)],
            of: PhantomData,
        }
    }

    /// Replaces the snapshot. Values beyond the number of places are left out.
    pub fn write<'a>(&mut self, front: &F, values: impl Iterator<Item = &'a T>)
    where
        T: 'a,
    {
        let (
            memory,
            Areas {
                front: area,
                values: each,
                ..
            },
        ) = (self.memory.words(), &self.areas);
        self.times += 1;
        let mut count: u64 = 0;
        for (place, value) in values.take(each.places).enumerate() {
            value.put(&mut Put::new(&mut self.words));
            each.write(memory, place, self.times, &self.words[..each.words]);
            count += 1;
        }
        let mut put = Put::new(&mut self.words);
        count.put(&mut put);
        front.put(&mut put);
        area.write(memory, 0, self.times, &self.words[..area.words]);
    }

    /// Reads the latest whole snapshot, or the snapshot before; `None` if none was written.
    ///
    /// # Errors
    /// If neither is whole, or the snapshot has another owner.
    pub fn read(memory: &[AtomicU64], owner: &str, places: usize) -> Result<Option<(F, Vec<T>)>, MemoryRefusal> {
        let areas = Areas::new::<F, T>(owner, places);
        if !is_marked(memory, areas.len(), areas.fingerprint) {
            return Err(MemoryRefusal::Foreign);
        }
        let mut words = Vec::new();
        let copies = [0, 1].map(|copy| areas.front.read_copy(memory, 0, copy, &mut words));
        if copies == [Copy::Blank, Copy::Blank] {
            return Ok(None);
        }
        let mut newest = [0, 1];
        newest.sort_by_key(|copy| match copies[*copy] {
            Copy::Whole(times) => std::cmp::Reverse(times),
            Copy::Blank | Copy::Broken => std::cmp::Reverse(0),
        });
        let mut of_copy = newest.into_iter().filter_map(|copy| {
            let Copy::Whole(times) = areas.front.read_copy(memory, 0, copy, &mut words) else {
                return None;
            };
            let mut get = Get(&words);
            let (count, front) = (u64::get(&mut get)?, F::get(&mut get)?);
            let mut of_record = Vec::new();
            let values = (0..usize::try_from(count).ok()?.min(places)).map(|place| {
                let found = areas.values.read_copy(memory, place, copy, &mut of_record);
                (found == Copy::Whole(times)).then(|| T::get(&mut Get(&of_record)))?
            });
            Some((front, values.collect::<Option<Vec<T>>>()?))
        });
        of_copy.next().map(Some).ok_or(MemoryRefusal::Damaged(1))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::Ordering::Relaxed;

    use proptest::prelude::*;

    use super::*;

    const PLACES: usize = 3;

    type Numbers = Picture<i64, (u32, f64)>;

    fn blank() -> Arc<Vec<AtomicU64>> {
        Arc::new((0..Numbers::words(PLACES)).map(|_| AtomicU64::new(0)).collect())
    }

    fn copied(memory: &Arc<Vec<AtomicU64>>) -> Vec<u64> {
        memory.words().iter().map(|word| word.load(Relaxed)).collect()
    }

    type Found = Option<(i64, Vec<(u32, f64)>)>;

    fn read(memory: &Arc<Vec<AtomicU64>>) -> Result<Found, MemoryRefusal> {
        Numbers::read(memory.words(), "a", PLACES)
    }

    proptest! {
        /// A writer that is killed between any two stores, in any order of stores, leaves the old or the new
        /// snapshot.
        #[test]
        fn a_picture_is_never_half_new(
            pictures in prop::collection::vec(
                (any::<i64>(), prop::collection::vec((any::<u32>(), -1e9..1e9), 0..5)),
                1..6,
            ),
            stored in prop::collection::vec(any::<bool>(), Numbers::words(PLACES)),
        ) {
            let memory = blank();
            let mut writer = Numbers::begin(Box::new(memory.clone()), "a", PLACES);
            prop_assert_eq!(read(&memory).unwrap(), None);
            let mut before = None;
            for (nth, (front, values)) in pictures.iter().enumerate() {
                let old = copied(&memory);
                writer.write(front, values.iter());
                let new = Some((*front, values[..values.len().min(PLACES)].to_vec()));
                prop_assert_eq!(&read(&memory).unwrap(), &new);
                if nth + 1 == pictures.len() {
                    for (word, _) in stored.iter().enumerate().filter(|(_, stored)| !**stored) {
                        memory.words()[word].store(old[word], Relaxed);
                    }
                    // Of a first snapshot, some records may be missing: no record is used then.
                    match read(&memory) {
                        Ok(found) => prop_assert!(found == before || found == new, "{found:?}"),
                        Err(_) => prop_assert!(before.is_none()),
                    }
                }
                before = new;
            }
        }
    }

    #[test]
    fn another_ones_picture_is_refused() {
        let memory = blank();
        let _ = Numbers::begin(Box::new(memory.clone()), "a", PLACES);
        assert_eq!(Numbers::read(memory.words(), "b", PLACES), Err(MemoryRefusal::Foreign));
        assert_eq!(
            Numbers::read(memory.words(), "a", PLACES + 1),
            Err(MemoryRefusal::Foreign)
        );
    }
}
