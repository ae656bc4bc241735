//! Times of day of records: read from bytes, and moved there.
//!
//! A recording sent again later has outdated times in its records. Moving all times by the same number of ticks of
//! 1/128 s, across midnight if necessary, gives the same recording at another time; all other bytes are unchanged.

use crate::block::blocks;
use crate::mode::Mode;
use crate::record::Record;
use crate::table::Category;

/// Ticks of 1/128 s in a second.
pub const TICKS_PER_S: u32 = 128;
/// Ticks in a day.
pub const TICKS_PER_DAY: u32 = 86_400 * TICKS_PER_S;

/// Time of day of a record, ticks; `None` where it states none.
pub fn time_of_day(record: &Record<'_>) -> Option<u32> {
    let mut times = record.table().times.iter().filter_map(|name| record.item_named(name));
    times.find_map(ticks)
}

/// The first time of day in data blocks that are read by `tables`, ticks.
pub fn first_time_of_day(octets: &[u8], tables: impl Fn(u8) -> Option<&'static Category>) -> Option<u32> {
    records(octets, &tables).find_map(|record| time_of_day(&record))
}

/// Adds `by` ticks to every time of day in data blocks that are read by `tables`; how many times there were. Records
/// behind one that cannot be read stay as they are.
pub fn move_times(octets: &mut [u8], by: u32, tables: impl Fn(u8) -> Option<&'static Category>) -> usize {
    let of_record = |record: Record<'_>| {
        let times = record.table().times.iter().filter_map(move |name| record.item_at(name));
        times
            .filter_map(|(place, item)| Some((place, ticks(item)?)))
            .collect::<Vec<_>>()
    };
    let times: Vec<(usize, u32)> = records(octets, &tables).flat_map(of_record).collect();
    for (place, ticks) in &times {
        let moved = (u64::from(*ticks) + u64::from(by)) % u64::from(TICKS_PER_DAY);
        octets[*place..place + 3].copy_from_slice(&(moved as u32).to_be_bytes()[1..]);
    }
    times.len()
}

fn records<'a>(
    octets: &'a [u8],
    tables: &impl Fn(u8) -> Option<&'static Category>,
) -> impl Iterator<Item = Record<'a>> {
    blocks(octets)
        .filter_map(Result::ok)
        .filter_map(|block| Some((tables(block.category)?, block)))
        .flat_map(|(table, block)| block.records(table, Mode::Lenient).filter_map(Result::ok))
}

fn ticks(item: &[u8]) -> Option<u32> {
    let [high, middle, low, ..] = *item else { return None };
    Some(u32::from_be_bytes([0, high, middle, low]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::registry;

    /// Two blocks: CAT048 with I048/010 and I048/140 in each of two records, CAT034 with I034/010, 000 and 030.
    const TWO_BLOCKS: &[u8] = &[
        48, 0, 15, 0xC0, 1, 2, 0x00, 0x01, 0x80, 0xC0, 1, 2, 0xA8, 0xBF, 0xFF, //
        34, 0, 10, 0xE0, 1, 2, 1, 0x00, 0x02, 0x00,
    ];

    #[test]
    fn times_move_and_nothing_else_does() {
        let mut octets = TWO_BLOCKS.to_vec();
        assert_eq!(first_time_of_day(&octets, registry::default_edition), Some(0x180));
        assert_eq!(move_times(&mut octets, TICKS_PER_S, registry::default_edition), 3);
        assert_eq!(octets[6..9], [0x00, 0x02, 0x00]);
        assert_eq!(
            octets[12..15],
            [0x00, 0x00, 0x7F],
            "a second after the last tick of the day"
        );
        assert_eq!(octets[22..25], [0x00, 0x02, 0x80]);
        assert_eq!(
            move_times(&mut octets, TICKS_PER_DAY - TICKS_PER_S, registry::default_edition),
            3
        );
        assert_eq!(octets, TWO_BLOCKS);
    }

    #[test]
    fn what_cannot_be_read_stays() {
        let mut octets = TWO_BLOCKS[..20].to_vec();
        assert_eq!(move_times(&mut octets, 5, registry::default_edition), 2);
        let mut unknown = [250, 0, 5, 1, 2];
        assert_eq!(move_times(&mut unknown, 5, registry::default_edition), 0);
    }
}
