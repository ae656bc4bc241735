//! Where the subitems of a compound item lie.

use crate::bits::{fspec_bits, goes_on};
use crate::extent;
use crate::record::{Mode, Record};
use crate::table::{Frn, Item, Layout};

/// The subitems present in a compound item, in the order sent: the place of each in the item's FSPEC, counted from 1,
/// and its octets. Empty where the record has no such item.
pub(super) fn subitems<'a>(record: &Record<'a>, frn: Frn) -> impl Iterator<Item = (usize, &'a [u8])> + use<'a> {
    let (uap, category) = (record.uap(), record.table().number);
    let defined: &'static [Option<Item>] = match uap.item(frn).map(|item| &item.layout) {
        Some(Layout::Compound(subitems)) => subitems,
        _ => &[],
    };
    let (mut present, mut rest) = record.item(frn).map_or((0, &[][..]), split_fspec);
    std::iter::from_fn(move || {
        let place = (present != 0).then(|| present.trailing_zeros() as usize + 1)?;
        present &= present - 1;
        let subitem = defined.get(place - 1)?.as_ref()?;
        let octets = match subitem.fixed_octets {
            Some(octets) => usize::from(octets),
            // The item has been measured before, subitem by subitem.
            None => {
                extent::measure(subitem, uap, rest, Mode::Lenient, category, 0)
                    .ok()?
                    .octets
            }
        };
        let (subitem, behind) = rest.split_at_checked(octets)?;
        rest = behind;
        Some((place, subitem))
    })
}

/// One bit for each subitem present, the first lowest, and the octets behind the FSPEC.
fn split_fspec(item: &[u8]) -> (u64, &[u8]) {
    let mut present = 0;
    for (i, &octet) in item.iter().enumerate() {
        present |= u64::from(fspec_bits(octet)) << (7 * i);
        if !goes_on(octet) {
            return (present, &item[i + 1..]);
        }
    }
    (0, &[])
}
