//! Latest records of the layers that pass: detections, bearings, areas.
//!
//! Each layer keeps its latest records as they are sent, in the order of arrival. A page that wants a layer gets the
//! records since its previous picture, each with its age. Nothing here depends on the kind of a record: a further layer
//! is a line in the table of layers.

use std::collections::VecDeque;

use messages::picture::{LayerRecord, PictureLayer};

/// Maximum number of stored records of a layer.
const RECENT_MAX: usize = 8_192;
/// Number of layers.
pub(crate) const LAYERS: usize = PictureLayer::ALL.len();

/// Latest records by layer, see the module's documentation.
#[derive(Debug, Default)]
pub(crate) struct Passing {
    by_layer: [VecDeque<PassingRecord>; LAYERS],
}

/// A record as it is sent, without its age.
#[derive(Debug)]
struct PassingRecord {
    /// Arrival.
    stamp: u64,
    /// Time of validity, UTC, nanoseconds.
    time_ns: i64,
    place_m: Option<[f32; 2]>,
    octets: Box<[u8]>,
    aged: fn(&[u8], i32, &mut Vec<u8>),
}

impl Passing {
    /// Adds a record of `time_ns` that arrived as number `stamp`.
    pub(crate) fn add<T: LayerRecord>(&mut self, stamp: u64, time_ns: i64, record: &T) {
        let recent = &mut self.by_layer[T::LAYER as usize];
        if recent.len() == RECENT_MAX {
            recent.pop_front();
        }
        recent.push_back(PassingRecord {
            stamp,
            time_ns,
            place_m: record.place_m(),
            octets: T::octets(std::slice::from_ref(record)).into(),
            aged: append_aged::<T>,
        });
    }

    /// Appends the records of a layer after `stamp` to a picture, the latest first: those at a place in `view`, and
    /// those without a place. `age_ms` is the age of a time in the picture.
    pub(crate) fn append_since(
        &self,
        layer: PictureLayer,
        stamp: u64,
        (in_view, age_ms): (impl Fn([f32; 2]) -> bool, impl Fn(i64) -> i32),
        out: &mut Vec<u8>,
    ) {
        let recent = self.by_layer[layer as usize].iter().rev();
        let new = recent.take_while(|record| record.stamp > stamp);
        for record in new.filter(|record| record.place_m.is_none_or(&in_view)) {
            (record.aged)(&record.octets, age_ms(record.time_ns), out);
        }
    }
}

/// Appends the record of these octets with its age.
fn append_aged<T: LayerRecord>(octets: &[u8], age_ms: i32, out: &mut Vec<u8>) {
    if let Some(record) = T::of_octets(octets) {
        out.extend_from_slice(T::octets(&[record.with_age(age_ms)]));
    }
}

#[cfg(test)]
mod tests {
    use messages::layout::Sample as _;
    use messages::picture::{PictureBearing, PictureDetection};

    use super::*;

    fn detection(east_m: f32) -> PictureDetection {
        PictureDetection {
            east_m,
            ..PictureDetection::default()
        }
    }

    #[test]
    fn a_reader_gets_what_is_new_in_its_view_with_the_age() {
        let mut passing = Passing::default();
        for stamp in 1..5 {
            passing.add(stamp, 1000 * stamp as i64, &detection(stamp as f32));
        }
        let bearing = PictureBearing {
            east_m: -99.0,
            ..PictureBearing::default()
        };
        passing.add(5, 5000, &bearing);
        let records = |layer: PictureLayer| {
            let (mut out, view) = (Vec::new(), |[east_m, _]: [f32; 2]| (0.0..4.0).contains(&east_m));
            passing.append_since(layer, 1, (view, |time_ns| 7000 - time_ns as i32), &mut out);
            out
        };
        let detections = records(PictureLayer::Detections);
        let found = detections
            .chunks(size_of::<PictureDetection>())
            .map(PictureDetection::of_octets);
        let found: Vec<(f32, i32)> = found
            .map(Option::unwrap)
            .map(|found| (found.east_m, found.age_ms))
            .collect();
        assert_eq!(found, [(3.0, 4000), (2.0, 5000)]);
        let bearings = records(PictureLayer::Bearings);
        assert_eq!(
            PictureBearing::of_octets(&bearings),
            Some(bearing.with_age(2000)),
            "out of view"
        );
        assert!(records(PictureLayer::Areas).is_empty());
    }

    #[test]
    fn the_oldest_give_way() {
        let mut passing = Passing::default();
        for stamp in 0..RECENT_MAX as u64 + 10 {
            passing.add(stamp + 1, 0, &detection(0.0));
        }
        let mut out = Vec::new();
        passing.append_since(PictureLayer::Detections, 0, (|_| true, |_| 0), &mut out);
        assert_eq!(out.len(), RECENT_MAX * size_of::<PictureDetection>());
    }
}
