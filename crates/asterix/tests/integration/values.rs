//! Values of any table, as any record of it may have them.

use asterix::named::UNKNOWN_EXTENSION;
use asterix::table::{Category, Content, Item, Layout, Part, Profile, TextCoding, Uap};
use asterix::text::icao_character;
use asterix::{NamedRecord, Value};

use crate::generator::{Entropy, bit_count};

impl Entropy<'_> {
    /// A record of some of a profile's items, at least one.
    pub(crate) fn named_record(&mut self, table: &'static Category, uap: &'static Uap) -> NamedRecord {
        let mut names: Vec<&str> = uap.names().filter(|name| !name.is_empty()).collect();
        let kept = names[usize::from(self.octet()) % names.len()];
        names.retain(|name| *name == kept || self.octet().is_multiple_of(3));
        self.named_record_with(table, uap, &names)
    }

    /// A record of these items of a profile, and of the one that decides for it.
    pub(crate) fn named_record_with(
        &mut self,
        table: &'static Category,
        uap: &'static Uap,
        names: &[&str],
    ) -> NamedRecord {
        let mut record = NamedRecord::of(table.number, []);
        for name in uap.names().filter(|name| !name.is_empty()) {
            let item = table.item(name).expect("a profile names items");
            let decision = decision(table, uap, item);
            if names.contains(&name) || decision.is_some() {
                let mut value = self.value(uap, &item.layout);
                if let Some((element, number)) = decision {
                    set(&mut value, element, number);
                }
                record.items.push((item.name, value));
            }
        }
        record
    }

    fn value(&mut self, uap: &'static Uap, layout: &'static Layout) -> Value {
        match layout {
            Layout::Element(bits, content) => self.content(content, *bits, &[]),
            Layout::Group(parts) => self.group(parts),
            Layout::Extended(extension) => self.extended(extension),
            Layout::Repetitive(inner) => {
                let count = self.count(255);
                Value::list((0..count).map(|_| self.value(uap, inner)))
            }
            Layout::RepetitiveFx(inner) => {
                let count = 1 + self.count(300);
                Value::list((0..count).map(|_| self.value(uap, inner)))
            }
            Layout::Explicit => {
                let count = self.count(254);
                Value::Bytes((0..count).map(|_| self.octet()).collect())
            }
            Layout::Compound(subitems) => {
                let mut members = vec![];
                for subitem in subitems.iter().flatten() {
                    if self.octet().is_multiple_of(2) {
                        members.push((subitem.name, self.value(uap, &subitem.layout)));
                    }
                }
                Value::Group(members)
            }
            Layout::RandomSequence => {
                let count = self.octet() % 4;
                Value::list((0..count).map(|_| {
                    let item = self.item_of_sequence(uap).1;
                    Value::group([(item.name, self.value(uap, &item.layout))])
                }))
            }
        }
    }

    /// A few, now and then the most there can be.
    fn count(&mut self, most: usize) -> usize {
        match self.octet() {
            255 => most,
            octet => usize::from(octet % 4),
        }
    }

    fn group(&mut self, parts: &'static [Part]) -> Value {
        let mut members = vec![];
        self.members(parts, &mut members);
        Value::Group(members)
    }

    fn extended(&mut self, extension: &'static [&'static [Part]]) -> Value {
        let mut members = vec![];
        let count = parts_sent(extension, self.octet());
        extension[..count]
            .iter()
            .for_each(|parts| self.members(parts, &mut members));
        let may_go_on = count == extension.len() && ends_in_fx(extension[count - 1]);
        if may_go_on && self.octet().is_multiple_of(4) {
            let mut octets: Vec<u8> = (0..1 + self.octet() % 4).map(|_| self.octet() | 1).collect();
            *octets.last_mut().expect("an octet") &= 0xFE;
            members.push((UNKNOWN_EXTENSION, Value::Bytes(octets)));
        }
        Value::Group(members)
    }

    fn members(&mut self, parts: &'static [Part], members: &mut Vec<(&'static str, Value)>) {
        for part in parts {
            match part {
                Part::Spare(_) => {}
                Part::Element {
                    name, bits, content, ..
                } => {
                    let value = self.content(content, *bits, members);
                    members.push((name, value));
                }
                Part::Group(name, inner) => members.push((name, self.group(inner))),
            }
        }
    }

    fn content(&mut self, content: &'static Content, bits: u8, before: &[(&'static str, Value)]) -> Value {
        match content {
            Content::Raw | Content::Integer { signed: false } => Value::Unsigned(self.number(bits)),
            Content::Integer { signed: true } => Value::Signed(self.signed_number(bits)),
            Content::Quantity { signed: true, lsb, .. } => Value::Quantity(self.signed_number(bits) as f64 * lsb),
            Content::Quantity { signed: false, lsb, .. } => Value::Quantity(self.number(bits) as f64 * lsb),
            Content::Text(coding) => {
                let count = bits / bits_each(*coding);
                Value::Text((0..count).map(|_| char::from(self.character(*coding))).collect())
            }
            Content::Depends { on, cases, otherwise } => {
                let decider = before
                    .iter()
                    .find(|(name, _)| name == on)
                    .expect("an element before it");
                let case = cases.iter().find(|(case, _)| decider.1 == Value::Unsigned(*case));
                self.content(case.map_or(*otherwise, |(_, content)| content), bits, before)
            }
        }
    }

    /// A number in so many bits, often one at the limits.
    pub(crate) fn number(&mut self, bits: u8) -> u64 {
        let all = u64::MAX >> (64 - bits);
        match self.octet() % 8 {
            0 => 0,
            1 => all,
            2 => all ^ all >> 1, // the most negative
            3 => all >> 1,       // the most positive
            _ => (0..8).fold(0, |number, _| number << 8 | u64::from(self.octet())) & all,
        }
    }

    fn signed_number(&mut self, bits: u8) -> i64 {
        let unused = 64 - bits;
        (self.number(bits) << unused) as i64 >> unused
    }

    /// A character of the coding.
    pub(crate) fn character(&mut self, coding: TextCoding) -> u8 {
        match coding {
            TextCoding::Ascii => b' ' + self.octet() % (b'~' - b' ' + 1),
            TextCoding::Icao => icao_character(self.octet()).unwrap_or(b' '),
            TextCoding::Octal => b'0' + self.octet() % 8,
        }
    }
}

/// The bits of one character.
pub(crate) fn bits_each(coding: TextCoding) -> u8 {
    match coding {
        TextCoding::Ascii => 8,
        TextCoding::Icao => 6,
        TextCoding::Octal => 3,
    }
}

/// A number of parts of an extended item the last of which has an element, if it is not the first. A part of spare
/// bits alone leaves no trace among the values.
pub(crate) fn parts_sent(extension: &[&[Part]], choice: u8) -> usize {
    let has_element = |parts: &[Part]| parts.iter().any(|part| !matches!(part, Part::Spare(_)));
    let mut count = 1 + usize::from(choice) % extension.len();
    while count > 1 && !has_element(extension[count - 1]) {
        count -= 1;
    }
    count
}

/// True if a part of an extended item has an FX bit, as the last may not have.
pub(crate) fn ends_in_fx(part: &[Part]) -> bool {
    !bit_count(part).is_multiple_of(8)
}

/// The element of this item that decides for this profile, and the value with which it does.
pub(crate) fn decision(table: &'static Category, uap: &Uap, item: &Item) -> Option<(&'static str, u64)> {
    match &table.profile {
        Profile::Depends {
            item: decider,
            element,
            cases,
        } if *decider == item.name => {
            let case = cases.iter().find(|(_, case)| std::ptr::eq(case, uap));
            Some((element, case.expect("a profile of the table").0))
        }
        _ => None,
    }
}

fn set(value: &mut Value, element: &str, number: u64) {
    let Value::Group(members) = value else {
        panic!("the deciding item is a group");
    };
    let member = members.iter_mut().find(|(name, _)| *name == element);
    member.expect("the deciding element").1 = number.into();
}

/// The profiles of a table, one or several.
pub(crate) fn profiles(table: &'static Category) -> Vec<&'static Uap> {
    match &table.profile {
        Profile::Single(uap) => vec![uap],
        Profile::Depends { cases, .. } => cases.iter().map(|(_, uap)| uap).collect(),
    }
}
