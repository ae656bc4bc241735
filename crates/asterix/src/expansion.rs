//! Content of reserved expansion fields.
//!
//! Most profiles end with a *reserved expansion field*, RE: an explicit item, which readers without knowledge of its
//! content can skip. EUROCONTROL uses the field to extend a category without a new edition; separate documents,
//! *coding rules* with their own editions, define the content. A record does not contain the edition of its sender's
//! coding rules. Therefore the decoder of whole records keeps the content as bytes ([`Value::Bytes`]), and this
//! module decodes the content for callers that know the edition: a byte with eight flags, most significant first,
//! followed by the announced subitems.
//!
//! The *special purpose field*, SP, is explicit as well. Its content is a matter of the sender: there are no tables.

use super::error::Error;
use super::extent;
use super::mode::Mode;
use super::named::{UNKNOWN_EXTENSION, Value, decode};
use super::record::Record;
use super::table::{Edition, Item};

/// The flags there are: a byte of them.
const FLAGS: usize = 8;
/// The item that is one.
pub(super) const FIELD: &str = "RE";

/// Edition of the coding rules for the reserved expansion field of a category.
#[derive(Debug)]
pub struct Expansion {
    /// The category.
    pub number: u8,
    /// The edition of the coding rules.
    pub edition: Edition,
    /// Their document's number.
    pub document: &'static str,
    /// Subitem that each flag announces; `None` where one has no meaning.
    pub items: &'static [Option<Item>],
}

impl Expansion {
    /// Coding rules with these items. Does not compile with more than eight.
    pub(super) const fn new(
        number: u8,
        edition: Edition,
        document: &'static str,
        items: &'static [Option<Item>],
    ) -> Self {
        assert!(items.len() <= FLAGS, "there are more items than flags");
        Self {
            number,
            edition,
            document,
            items,
        }
    }

    /// Decodes the field of a record, as a group; `None` where the record is of another category or has no such field.
    ///
    /// Bytes behind the last subitem are kept as [`UNKNOWN_EXTENSION`].
    ///
    /// # Errors
    /// A flag without meaning, and subitems that run off the end of the field: signs of another edition.
    pub fn read(&'static self, record: &Record<'_>) -> Result<Option<Value>, Error> {
        let category = record.table().number;
        let Some((offset, field)) = record.item_at(FIELD).filter(|_| category == self.number) else {
            return Ok(None);
        };
        let mut members = Vec::new();
        let Some((&flags, mut rest)) = field[1..].split_first() else {
            return Ok(Some(Value::Group(members))); // a field of nothing but its length
        };
        for i in (0..FLAGS).filter(|i| flags & 0x80 >> i != 0) {
            let subitem = self
                .items
                .get(i)
                .and_then(Option::as_ref)
                .ok_or(Error::SubitemUndefined {
                    offset,
                    category,
                    item: FIELD,
                    position: i + 1,
                })?;
            let begin = offset + field.len() - rest.len();
            let octets = extent::measure(subitem, record.uap(), rest, Mode::Lenient, category, begin)?.octets;
            let (bytes, behind) = rest.split_at(octets);
            members.push((subitem.name, decode(subitem, record.uap(), bytes)));
            rest = behind;
        }
        if !rest.is_empty() {
            members.push((UNKNOWN_EXTENSION, Value::Bytes(rest.to_vec())));
        }
        Ok(Some(Value::Group(members)))
    }
}
