//! Spare bits, which a sender shall leave zero: looked at in strict mode only.

use super::bits::{bits, fspec_bits, goes_on};
use super::table::{Item, Layout, Part, Uap, extent_of_part};

/// True if a measured item has a spare bit set.
pub(super) fn any_set(item: &'static Item, uap: &'static Uap, bytes: &[u8]) -> bool {
    let mut walk = SpareWalk {
        uap,
        bytes,
        at: 0,
        found: false,
    };
    walk.layout(&item.layout);
    walk.found
}

struct SpareWalk<'a> {
    uap: &'static Uap,
    bytes: &'a [u8],
    at: usize,
    found: bool,
}

impl SpareWalk<'_> {
    fn layout(&mut self, layout: &'static Layout) {
        match layout {
            Layout::Element(bits, _) => self.at += usize::from(*bits) / 8,
            Layout::Group(parts) => {
                self.parts(parts, self.at * 8);
                self.at += layout.bit_count() as usize / 8;
            }
            Layout::Extended(parts) => {
                for part in *parts {
                    self.parts(part, self.at * 8);
                    let (octets, ends_in_fx) = extent_of_part(part);
                    self.at += octets;
                    if !ends_in_fx || !goes_on(self.bytes[self.at - 1]) {
                        return;
                    }
                }
            }
            Layout::Repetitive(inner) => {
                let count = self.octet();
                (0..count).for_each(|_| self.layout(inner));
            }
            Layout::RepetitiveFx(inner) => loop {
                if let Layout::Group(parts) = inner {
                    self.parts(parts, self.at * 8);
                }
                self.at += inner.bit_count() as usize / 8 + 1;
                if !goes_on(self.bytes[self.at - 1]) {
                    return;
                }
            },
            Layout::Explicit => {
                let length = usize::from(self.octet());
                self.at += length - 1;
            }
            Layout::Compound(subitems) => {
                let mut positions = subitems.iter();
                let mut present = Vec::new();
                loop {
                    let octet = self.octet();
                    let flags = fspec_bits(octet);
                    for (i, subitem) in positions.by_ref().take(7).enumerate() {
                        if flags >> i & 1 == 1 {
                            present.extend(subitem);
                        }
                    }
                    if !goes_on(octet) {
                        break;
                    }
                }
                present.iter().for_each(|subitem| self.layout(&subitem.layout));
            }
            Layout::RandomSequence => {
                for _ in 0..self.octet() {
                    let frn = self.octet();
                    let item = self.uap.item_in_sequence(frn).expect("measured");
                    self.layout(&item.layout);
                }
            }
        }
    }

    fn parts(&mut self, parts: &'static [Part], mut at: usize) {
        for part in parts {
            match part {
                Part::Spare(width) => {
                    let width = usize::from(*width);
                    self.found |= bits(self.bytes, at, width) != 0;
                    at += width;
                }
                Part::Element { bits, .. } => at += usize::from(*bits),
                Part::Group(_, inner) => {
                    self.parts(inner, at);
                    at += Layout::Group(inner).bit_count() as usize;
                }
            }
        }
    }

    fn octet(&mut self) -> u8 {
        self.at += 1;
        self.bytes[self.at - 1]
    }
}
