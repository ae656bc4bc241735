//! Records as lines of JSON, written while the table is walked: the text of [`NamedRecord::write_json`], without its
//! tree of values.
//!
//! [`NamedRecord::write_json`]: crate::NamedRecord::write_json
//!
//! # Method
//!
//! A record is a sequence of bits that its table divides without gaps, so that one [`BitReader`] passes over all items.
//! Keys are constants of the table, in quotation marks and of one length in memory. Every value is followed by a comma;
//! the end of an object or list takes the place of the last comma. Most quantities are a small number times 2^-n: their
//! decimals are found in whole numbers ([`json_text`](crate::json_text)). Other quantities are written by `zmij`, as
//! `serde_json` does.

use std::mem;

use crate::bit_reader::BitReader;
use crate::bits::{bits, fspec_bits, goes_on, sign_extend};
use crate::expansion;
use crate::json_text::{JsonText, short};
use crate::key::Key;
use crate::named::Value;
use crate::record::Record;
use crate::table::{Content, Item, Layout, Part, TextCoding, Uap};
use crate::text;

/// Key of the category.
const CATEGORY: Key = Key::new("_c");
/// Key of the time of recording.
const TIME_STAMP: Key = Key::new("_ts");
/// Characters of the six-bit codes; zero for a code without one.
const ICAO: [u8; 64] = icao();

/// Lines of JSON, a record each.
#[derive(Debug, Default)]
pub struct JsonLines {
    text: JsonText,
}

impl JsonLines {
    /// Appends a line with a record: items by number, `"_c"`, the category, and with the time of recording `"_ts"`;
    /// `null` if this time is not finite. `expanded` takes the place of the bytes of a reserved expansion field.
    pub fn write(&mut self, record: &Record<'_>, time_stamp_s: Option<f64>, expanded: Option<&Value>) {
        let mut walk = Walk {
            uap: record.uap(),
            octets: record.body(),
            reader: BitReader::new(record.body()),
            text: mem::take(&mut self.text),
        };
        walk.text.octet(b'{');
        for frn in record.frns() {
            let Some(item) = walk.uap.item(frn) else { continue };
            match expanded.filter(|_| item.name == expansion::FIELD) {
                Some(value) => {
                    walk.reader.skip(8 * record.octets(frn).len());
                    walk.text.piece(Some(&item.key)).end();
                    walk.other(value);
                }
                None => walk.layout(Some(&item.key), &item.layout),
            }
        }
        let mut piece = walk.text.piece(Some(&CATEGORY));
        piece.whole(record.table().number.into());
        piece.octet(b',');
        piece.end();
        match time_stamp_s {
            Some(time_stamp_s) if time_stamp_s.is_finite() => walk.quantity(Some(&TIME_STAMP), time_stamp_s),
            // JSON has no such number.
            Some(_) => {
                let mut piece = walk.text.piece(Some(&TIME_STAMP));
                piece.append(b"null,");
                piece.end();
            }
            None => {}
        }
        walk.text.end(b'}');
        self.text = walk.text;
        self.text.end_line();
    }

    /// The lines.
    pub fn text(&self) -> &[u8] {
        self.text.text()
    }

    /// Forgets the lines.
    pub fn clear(&mut self) {
        self.text.clear();
    }
}

struct Walk<'a> {
    uap: &'static Uap,
    /// Octets under `reader`.
    octets: &'a [u8],
    reader: BitReader<'a>,
    text: JsonText,
}

/// The elements of an object that have been read, or may have been.
#[derive(Clone, Copy)]
struct Elements<'p> {
    parts: &'p [&'static [Part]],
    /// Number of the first bit.
    begin: usize,
}

impl Walk<'_> {
    /// Writes an item or a part of one, with its key if it has one.
    fn layout(&mut self, key: Option<&Key>, layout: &'static Layout) {
        match layout {
            Layout::Element(width, content) => self.element(key, *width, content, Elements::NONE),
            Layout::Group(parts) => {
                self.text.begin(key, b'{');
                self.parts(parts, Elements::of(&[parts], self.reader.position()));
                self.text.end(b'}');
            }
            Layout::Extended(extension) => self.extended(key, extension),
            Layout::Repetitive(inner) => {
                self.text.begin(key, b'[');
                for _ in 0..self.reader.octet() {
                    self.layout(None, inner);
                }
                self.text.end(b']');
            }
            Layout::RepetitiveFx(inner) => {
                self.text.begin(key, b'[');
                loop {
                    self.layout(None, inner);
                    if self.reader.number(1) == 0 {
                        break;
                    }
                }
                self.text.end(b']');
            }
            Layout::Explicit => {
                self.text.begin(key, b'"');
                for _ in 1..self.reader.octet() {
                    self.hexadecimal();
                }
                self.text.append(b"\",");
            }
            Layout::Compound(subitems) => self.compound(key, subitems),
            Layout::RandomSequence => self.random_sequence(key),
        }
    }

    fn extended(&mut self, key: Option<&Key>, extension: &'static [&'static [Part]]) {
        let elements = Elements::of(extension, self.reader.position());
        self.text.begin(key, b'{');
        let mut goes_on_after = true;
        for part in extension {
            self.parts(part, elements);
            // Only a part without an FX bit ends with an octet.
            goes_on_after = !self.reader.is_between_octets() && self.reader.number(1) == 1;
            if !goes_on_after {
                break;
            }
        }
        if goes_on_after {
            self.text.append(b"\"_unknown_extension\":\"");
            while goes_on(self.hexadecimal()) {}
            self.text.append(b"\",");
        }
        self.text.end(b'}');
    }

    fn compound(&mut self, key: Option<&Key>, subitems: &'static [Option<Item>]) {
        let mut present = 0_u64;
        for shift in (0..u64::BITS).step_by(7) {
            let octet = self.reader.octet();
            present |= u64::from(fspec_bits(octet)) << shift;
            if !goes_on(octet) {
                break;
            }
        }
        self.text.begin(key, b'{');
        while present != 0 {
            if let Some(Some(subitem)) = subitems.get(present.trailing_zeros() as usize) {
                self.layout(Some(&subitem.key), &subitem.layout);
            }
            present &= present - 1;
        }
        self.text.end(b'}');
    }

    fn random_sequence(&mut self, key: Option<&Key>) {
        self.text.begin(key, b'[');
        for _ in 0..self.reader.octet() {
            let frn = self.reader.octet();
            let item = self.uap.item_in_sequence(frn).expect("measured");
            self.text.octet(b'{');
            self.layout(Some(&item.key), &item.layout);
            self.text.end(b'}');
        }
        self.text.end(b']');
    }

    fn parts(&mut self, parts: &'static [Part], elements: Elements<'_>) {
        for part in parts {
            match part {
                Part::Element { key, bits, content, .. } => self.element(Some(key), *bits, content, elements),
                Part::Spare(width) if *width <= 32 => drop(self.reader.number(u32::from(*width))),
                Part::Spare(width) => self.reader.skip(usize::from(*width)),
                Part::Group(name, inner) => {
                    self.text.octet(b'"');
                    self.text.append(name.as_bytes());
                    self.text.append(b"\":{");
                    self.parts(inner, Elements::of(&[inner], self.reader.position()));
                    self.text.end(b'}');
                }
            }
        }
    }

    /// Writes an element, with its key if it has one.
    #[inline(always)]
    fn element(&mut self, key: Option<&Key>, width: u8, content: &'static Content, elements: Elements<'_>) {
        match content {
            Content::Raw | Content::Integer { signed: false } => {
                let number = self.reader.number(width.into());
                let mut piece = self.text.piece(key);
                match number {
                    0..10 => piece.pair_of([b'0' + number as u8, b',']),
                    _ => {
                        piece.whole(number);
                        piece.octet(b',');
                    }
                }
                piece.end();
            }
            Content::Quantity { signed, lsb, .. } => self.product(key, width, *signed, *lsb),
            _ => self.rare(key, width, content, elements),
        }
    }

    /// Writes a number times the least significant bit.
    fn product(&mut self, key: Option<&Key>, width: u8, signed: bool, lsb: f64) {
        let number = self.reader.number(width.into());
        let (is_negative, magnitude) = match sign_extend(number, width.into()) {
            extended if signed => (extended < 0, extended.unsigned_abs()),
            _ => (false, number),
        };
        let mut piece = self.text.piece(key);
        if short(&mut piece, is_negative, magnitude, lsb) {
            piece.octet(b',');
            piece.end();
        } else {
            let quantity = magnitude as f64 * lsb;
            self.quantity(key, if is_negative { -quantity } else { quantity });
        }
    }

    /// Writes an element of a content that is less frequent.
    #[inline(never)]
    fn rare(&mut self, key: Option<&Key>, width: u8, content: &'static Content, elements: Elements<'_>) {
        match content {
            Content::Integer { signed: true } => {
                let number = sign_extend(self.reader.number(width.into()), width.into());
                let mut piece = self.text.piece(key);
                piece.sign(number < 0);
                piece.whole(number.unsigned_abs());
                piece.octet(b',');
                piece.end();
            }
            Content::Text(coding) => self.characters(key, *coding, width),
            Content::Depends { .. } => {
                let chosen = self.chosen(content, elements);
                self.rare(key, width, chosen, elements);
            }
            _ => self.element(key, width, content, elements),
        }
    }

    /// The content that an earlier element decides on.
    #[inline(never)]
    fn chosen(&self, content: &'static Content, elements: Elements<'_>) -> &'static Content {
        let Content::Depends { on, cases, otherwise } = content else {
            return content;
        };
        let decider = elements.number(on, self.octets, self.reader.position());
        let case = cases.iter().find(|(case, _)| Some(*case) == decider);
        case.map_or(*otherwise, |(_, content)| content)
    }

    fn characters(&mut self, key: Option<&Key>, coding: TextCoding, width: u8) {
        let begin = self.reader.position();
        let codes = self.reader.number(width.into());
        let mut piece = self.text.piece(key);
        piece.octet(b'"');
        let is_plain = match coding {
            TextCoding::Icao => piece.characters::<6>(codes, width, |code| ICAO[usize::from(code & 63)]),
            TextCoding::Octal => piece.characters::<3>(codes, width, |code| b'0' + code),
            TextCoding::Ascii => piece.characters::<8>(codes, width, |code| match code {
                b'"' | b'\\' => 0,
                b' '..=b'~' => code,
                _ => 0,
            }),
        };
        if is_plain {
            piece.octet(b'"');
            piece.octet(b',');
            piece.end();
        } else {
            self.text.piece(key).end(); // again, without the characters
            self.other(&Value::Text(text::decode(coding, self.octets, begin, width.into())));
        }
    }

    /// Writes an octet as two digits, and gives it.
    fn hexadecimal(&mut self) -> u8 {
        let octet = self.reader.octet();
        let digit = |digit: u8| b"0123456789abcdef"[usize::from(digit)];
        let mut piece = self.text.piece(None);
        piece.octet(digit(octet >> 4));
        piece.octet(digit(octet & 15));
        piece.end();
        octet
    }

    /// Writes a quantity of any digits.
    fn quantity(&mut self, key: Option<&Key>, quantity: f64) {
        let mut buffer = zmij::Buffer::new();
        let digits = buffer.format_finite(quantity).as_bytes();
        let mut piece = self.text.piece(key);
        piece.append(digits);
        piece.octet(b',');
        piece.end();
    }

    /// Writes a value that no other method writes.
    #[cold]
    #[inline(never)]
    fn other(&mut self, value: &Value) {
        serde_json::to_writer(&mut self.text, value).expect("memory takes every write, and names are strings");
        self.text.octet(b',');
    }
}

impl<'p> Elements<'p> {
    const NONE: Elements<'static> = Elements { parts: &[], begin: 0 };

    fn of(parts: &'p [&'static [Part]], begin: usize) -> Self {
        Self { parts, begin }
    }

    /// The code or number of this name, if it has been read before bit `end`.
    fn number(self, name: &str, octets: &[u8], end: usize) -> Option<u64> {
        let mut at = self.begin;
        for parts in self.parts {
            for part in *parts {
                let width = match part {
                    Part::Element { bits: width, .. } | Part::Spare(width) => usize::from(*width),
                    Part::Group(_, inner) => crate::table::bit_count(inner) as usize,
                };
                if at + width > end {
                    return None;
                }
                match part {
                    Part::Element {
                        name: found,
                        content: Content::Raw | Content::Integer { signed: false },
                        ..
                    } if *found == name => return Some(bits(octets, at, width)),
                    _ => at += width,
                }
            }
            at = at.next_multiple_of(8); // behind the FX bit
        }
        None
    }
}

const fn icao() -> [u8; 64] {
    let mut characters = [0; 64];
    let mut code = 0;
    while code < 64 {
        if let Some(character) = text::icao_character(code as u8) {
            characters[code] = character;
        }
        code += 1;
    }
    characters
}
