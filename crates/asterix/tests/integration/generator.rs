//! Well-formed records of any table, with any content.

use asterix::table::{Category, Item, Layout, Part, Profile, Uap};

/// The item that says whether there is a target report. Made of anything, it would hardly ever say so.
const MESSAGE_TYPE: &str = "000";

/// Bytes that any number can be taken from, again from the first after the last.
pub(crate) struct Entropy<'a> {
    octets: &'a [u8],
    at: usize,
}

impl<'a> Entropy<'a> {
    /// Numbers taken from these bytes, of which there is at least one.
    pub(crate) fn new(octets: &'a [u8]) -> Self {
        Self { octets, at: 0 }
    }

    pub(crate) fn octet(&mut self) -> u8 {
        self.at += 1;
        self.octets[(self.at - 1) % self.octets.len()]
    }

    /// An item that can be in a random field sequence, and its field reference number.
    pub(crate) fn item_of_sequence(&mut self, uap: &Uap) -> (u8, &'static Item) {
        let items: Vec<_> = (1..)
            .zip(uap.items)
            .filter_map(|(frn, item)| Some((frn, item.as_ref()?)))
            .filter(|(_, item)| !matches!(item.layout, Layout::RandomSequence))
            .collect();
        items[usize::from(self.octet()) % items.len()]
    }

    fn octets(&mut self, count: usize, out: &mut Vec<u8>) {
        (0..count).for_each(|_| out.push(self.octet()));
    }

    /// A well-formed item, spare bits and all.
    fn item(&mut self, uap: &Uap, layout: &Layout, out: &mut Vec<u8>) {
        match layout {
            Layout::Element(bits, _) => self.octets(usize::from(*bits) / 8, out),
            Layout::Group(parts) => self.octets(bit_count(parts) / 8, out),
            Layout::Extended(parts) => {
                let count = 1 + usize::from(self.octet()) % parts.len();
                for (i, part) in parts[..count].iter().enumerate() {
                    let bits = bit_count(part);
                    self.octets(bits.div_ceil(8), out);
                    if !bits.is_multiple_of(8) {
                        set_fx(out, i + 1 < count);
                    }
                }
            }
            Layout::Repetitive(inner) => {
                let count = self.octet() % 4;
                out.push(count);
                (0..count).for_each(|_| self.item(uap, inner, out));
            }
            Layout::RepetitiveFx(inner) => {
                let bits = match inner {
                    Layout::Element(bits, _) => usize::from(*bits),
                    Layout::Group(parts) => bit_count(parts),
                    other => panic!("{other:?} can not be repeated by FX"),
                };
                for more in (0..1 + self.octet() % 4).rev() {
                    self.octets((bits + 1) / 8, out);
                    set_fx(out, more > 0);
                }
            }
            Layout::Explicit => {
                let length = 1 + self.octet() % 8;
                out.push(length);
                self.octets(usize::from(length) - 1, out);
            }
            Layout::Compound(subitems) => {
                let present: Vec<bool> = subitems
                    .iter()
                    .map(|subitem| subitem.is_some() && self.octet().is_multiple_of(2))
                    .collect();
                out.extend(fspec(&present));
                for (subitem, present) in subitems.iter().zip(present) {
                    if let (Some(subitem), true) = (subitem, present) {
                        self.item(uap, &subitem.layout, out);
                    }
                }
            }
            Layout::RandomSequence => {
                let count = self.octet() % 4;
                out.push(count);
                for _ in 0..count {
                    let (frn, item) = self.item_of_sequence(uap);
                    out.push(frn);
                    self.item(uap, &item.layout, out);
                }
            }
        }
    }

    /// A record with some of a profile's items, at least one, and these items.
    pub(crate) fn record(&mut self, table: &'static Category) -> (Vec<u8>, Vec<(&'static str, Vec<u8>)>) {
        let choice = match &table.profile {
            Profile::Single(_) => None,
            Profile::Depends { item, element, cases } => {
                let (value, uap) = &cases[usize::from(self.octet()) % cases.len()];
                Some((*item, *element, *value, uap))
            }
        };
        let uap = choice.map_or(table.uap(), |(.., uap)| uap);
        let decider = choice.map(|(item, ..)| item);
        let mut present: Vec<bool> = uap
            .names()
            .map(|name| {
                let must_be = name == MESSAGE_TYPE || Some(name) == decider;
                must_be || !name.is_empty() && self.octet().is_multiple_of(3)
            })
            .collect();
        if !present.contains(&true) {
            present[0] = true;
        }
        let mut items = vec![];
        for (name, _) in uap.names().zip(&present).filter(|(_, present)| **present) {
            let mut octets = vec![];
            let item = table.item(name).expect("a profile names items");
            self.item(uap, &item.layout, &mut octets);
            if item.name == MESSAGE_TYPE {
                octets[0] %= 5;
            }
            if let Some((decider, element, value, _)) = choice
                && item.name == decider
            {
                set_element(&item.layout, element, value, &mut octets);
            }
            items.push((item.name, octets));
        }
        let mut record = fspec(&present);
        items.iter().for_each(|(_, octets)| record.extend(octets));
        (record, items)
    }
}

/// Gives a value to an element of a group, or of the first part of an extended item.
fn set_element(layout: &Layout, element: &str, value: u64, octets: &mut [u8]) {
    let (Layout::Group(parts) | Layout::Extended([parts, ..])) = layout else {
        panic!("{layout:?} has no element that is always there");
    };
    let is_element = |part: &&Part| matches!(part, Part::Element { name, .. } if *name == element);
    let position = parts
        .iter()
        .position(|part| is_element(&part))
        .expect("the deciding element");
    let end = bit_count(&parts[..=position]);
    for (i, at) in (bit_count(&parts[..position])..end).rev().enumerate() {
        let bit = 0x80 >> (at % 8);
        octets[at / 8] = octets[at / 8] & !bit | if value >> i & 1 == 1 { bit } else { 0 };
    }
}

/// The least bytes that announce these.
pub(crate) fn fspec(present: &[bool]) -> Vec<u8> {
    let mut octets: Vec<u8> = present
        .chunks(7)
        .map(|seven| {
            let bits = seven.iter().enumerate().filter(|(_, present)| **present);
            bits.fold(1, |octet, (i, _)| octet | 0x80 >> i)
        })
        .collect();
    while octets.len() > 1 && octets.last() == Some(&1) {
        octets.pop();
    }
    set_fx(&mut octets, false);
    octets
}

fn set_fx(octets: &mut [u8], goes_on: bool) {
    let last = octets.last_mut().expect("an octet");
    *last = *last & 0xFE | u8::from(goes_on);
}

pub(crate) fn bit_count(parts: &[Part]) -> usize {
    parts
        .iter()
        .map(|part| match part {
            Part::Element { bits, .. } | Part::Spare(bits) => usize::from(*bits),
            Part::Group(_, inner) => bit_count(inner),
        })
        .sum()
}
