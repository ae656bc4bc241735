//! Bytes in canonical form, put together bit by bit: no spare bit set, no byte of an FSPEC too many, no code
//! without a character. Their values have this encoding and no other.

use asterix::table::{Category, Content, Layout, Part, TextCoding, Uap};
use asterix::text::icao_code;

use crate::generator::{Entropy, fspec};
use crate::values::{bits_each, decision, ends_in_fx, parts_sent};

/// Bits, the most significant first.
#[derive(Default)]
struct Bits(Vec<bool>);

impl Bits {
    fn put(&mut self, width: u8, number: u64) {
        self.0.extend((0..width).rev().map(|bit| number >> bit & 1 == 1));
    }

    fn octets(&self) -> impl Iterator<Item = u8> + '_ {
        assert!(self.0.len().is_multiple_of(8), "whole octets");
        self.0
            .chunks(8)
            .map(|bits| bits.iter().fold(0, |octet, &bit| octet << 1 | u8::from(bit)))
    }
}

impl Entropy<'_> {
    /// A record in canonical form.
    pub(crate) fn canonical_record(&mut self, table: &'static Category, uap: &'static Uap) -> Vec<u8> {
        let names: Vec<_> = uap.names().filter(|name| !name.is_empty()).collect();
        let kept = names[usize::from(self.octet()) % names.len()];
        let mut present = vec![];
        let mut items = vec![];
        for name in uap.names() {
            let item = table.item(name);
            let decision = item.and_then(|item| decision(table, uap, item));
            let wanted = name == kept || self.octet().is_multiple_of(3) || decision.is_some();
            present.push(wanted && item.is_some());
            if let Some(item) = item.filter(|_| wanted) {
                self.canonical_item(uap, &item.layout, decision, &mut items);
            }
        }
        [fspec(&present), items].concat()
    }

    fn canonical_item(&mut self, uap: &'static Uap, layout: &Layout, decision: Option<(&str, u64)>, out: &mut Vec<u8>) {
        let mut bits = Bits::default();
        match layout {
            Layout::Element(..) | Layout::Group(_) => {
                self.canonical_bits(layout, decision, &mut vec![], &mut bits);
                out.extend(bits.octets());
            }
            Layout::Extended(extension) => {
                let count = parts_sent(extension, self.octet());
                let mut before = vec![];
                for (i, parts) in extension[..count].iter().enumerate() {
                    self.canonical_bits(&Layout::Group(parts), decision, &mut before, &mut bits);
                    if ends_in_fx(parts) {
                        bits.put(1, u64::from(i + 1 < count));
                    }
                }
                out.extend(bits.octets());
            }
            Layout::Repetitive(inner) => {
                let count = self.octet() % 4;
                out.push(count);
                (0..count).for_each(|_| self.canonical_item(uap, inner, None, out));
            }
            Layout::RepetitiveFx(inner) => {
                for more in (0..1 + self.octet() % 4).rev() {
                    self.canonical_bits(inner, None, &mut vec![], &mut bits);
                    bits.put(1, u64::from(more > 0));
                }
                out.extend(bits.octets());
            }
            Layout::Explicit => {
                let count = self.octet() % 8;
                out.push(count + 1);
                (0..count).for_each(|_| out.push(self.octet()));
            }
            Layout::Compound(subitems) => {
                let present: Vec<bool> = subitems
                    .iter()
                    .map(|subitem| subitem.is_some() && self.octet().is_multiple_of(2))
                    .collect();
                out.extend(fspec(&present));
                for (subitem, _) in subitems.iter().zip(present).filter(|(_, present)| *present) {
                    let layout = &subitem.as_ref().expect("one that is present").layout;
                    self.canonical_item(uap, layout, None, out);
                }
            }
            Layout::RandomSequence => {
                let count = self.octet() % 4;
                out.push(count);
                for _ in 0..count {
                    let (frn, item) = self.item_of_sequence(uap);
                    out.push(frn);
                    self.canonical_item(uap, &item.layout, None, out);
                }
            }
        }
    }

    /// An element or a group. `before` are the numbers of the elements before it, by name.
    fn canonical_bits(
        &mut self,
        layout: &Layout,
        decision: Option<(&str, u64)>,
        before: &mut Vec<(&'static str, u64)>,
        bits: &mut Bits,
    ) {
        match layout {
            Layout::Element(width, content) => {
                self.canonical_content(content, *width, before, bits);
            }
            Layout::Group(parts) => {
                for part in *parts {
                    match part {
                        Part::Spare(width) => bits.put(*width, 0),
                        Part::Group(_, inner) => self.canonical_bits(&Layout::Group(inner), None, &mut vec![], bits),
                        Part::Element { name, bits: width, .. } if decision.is_some_and(|(of, _)| of == *name) => {
                            bits.put(*width, decision.expect("a decision").1);
                        }
                        Part::Element {
                            name,
                            bits: width,
                            content,
                            ..
                        } => {
                            let number = self.canonical_content(content, *width, before, bits);
                            before.push((name, number));
                        }
                    }
                }
            }
            other => panic!("{other:?} has no number of bits"),
        }
    }

    /// Puts an element and gives its number; zero for a text.
    fn canonical_content(&mut self, content: &Content, width: u8, before: &[(&str, u64)], bits: &mut Bits) -> u64 {
        match content {
            Content::Raw | Content::Integer { .. } | Content::Quantity { .. } => {
                let number = self.number(width);
                bits.put(width, number);
                number
            }
            Content::Text(coding) => {
                let each = bits_each(*coding);
                for _ in 0..width / each {
                    let character = self.character(*coding);
                    let code = match coding {
                        TextCoding::Ascii => character,
                        TextCoding::Icao => icao_code(character).expect("a character of the alphabet"),
                        TextCoding::Octal => character - b'0',
                    };
                    bits.put(each, code.into());
                }
                0
            }
            Content::Depends { on, cases, otherwise } => {
                let decider = before
                    .iter()
                    .find(|(name, _)| name == on)
                    .expect("an element before it");
                let case = cases.iter().find(|(case, _)| *case == decider.1);
                self.canonical_content(case.map_or(*otherwise, |(_, content)| content), width, before, bits)
            }
        }
    }
}
