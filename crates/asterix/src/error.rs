//! Errors of ASTERIX bytes.
//!
//! Every error gives the offset of the faulty byte in the caller's bytes, the found and the expected value. Items are
//! named as in the documents: I010/140.

/// Why bytes are no data block, or no record of the table they were read with.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// Fewer bytes than a block header.
    #[error("byte {offset}: a block header takes 3 octets, {available} left")]
    HeaderTruncated {
        /// Offset of the header.
        offset: usize,
        /// The bytes from there on.
        available: usize,
    },
    /// A block length smaller than the header.
    #[error(
        "byte {offset}: block of category {category:03} gives its length as {length} octets, \
         its header alone takes 3"
    )]
    BlockLength {
        /// Offset of the block.
        offset: usize,
        /// The block's category.
        category: u8,
        /// The length it gives.
        length: usize,
    },
    /// A block longer than the bytes.
    #[error(
        "byte {offset}: block of category {category:03} gives its length as {length} octets, \
         {available} left"
    )]
    BlockTruncated {
        /// Offset of the block.
        offset: usize,
        /// The block's category.
        category: u8,
        /// The length it gives.
        length: usize,
        /// The bytes from its begin on.
        available: usize,
    },
    /// No table was given for the block's category.
    #[error("byte {offset}: no table for a block of category {category:03}")]
    NoTable {
        /// Offset of the block.
        offset: usize,
        /// The block's category.
        category: u8,
    },
    /// The last byte of the block announces a further byte of the FSPEC.
    #[error(
        "byte {offset}: category {category:03}: the FSPEC runs off the end of the block \
         after {octets} octets"
    )]
    FspecTruncated {
        /// Offset of the FSPEC.
        offset: usize,
        /// The category.
        category: u8,
        /// Bytes of the FSPEC within the block.
        octets: usize,
    },
    /// An FSPEC longer than any profile.
    #[error(
        "byte {offset}: category {category:03}: the FSPEC goes on after {maximum} octets, \
         the most there can be"
    )]
    FspecTooLong {
        /// Offset of the FSPEC.
        offset: usize,
        /// The category.
        category: u8,
        /// The most bytes allowed.
        maximum: usize,
    },
    /// A record without a single item, such as one of padding.
    #[error("byte {offset}: category {category:03}: the FSPEC announces no item")]
    RecordEmpty {
        /// Offset of the record.
        offset: usize,
        /// The category.
        category: u8,
    },
    /// An FSPEC bit that the edition gives no meaning: wrong edition, or no record at all.
    #[error(
        "byte {offset}: category {category:03}: the FSPEC announces an item at FRN {frn}, \
         where this edition defines none"
    )]
    ItemUndefined {
        /// Offset of the record.
        offset: usize,
        /// The category.
        category: u8,
        /// The field reference number.
        frn: u8,
    },
    /// The item that decides between several profiles is absent, or has a value without profile.
    #[error(
        "byte {offset}: category {category:03}: I{category:03}/{item} decides the profile, \
         {}", describe_choice(*found)
    )]
    ProfileUndecided {
        /// Offset of the record.
        offset: usize,
        /// The category.
        category: u8,
        /// The deciding item.
        item: &'static str,
        /// Value of the deciding element, if present.
        found: Option<u64>,
    },
    /// An item runs off the end of its block.
    #[error(
        "byte {offset}: I{category:03}/{item} takes at least {needed} octets, \
         {available} left"
    )]
    ItemTruncated {
        /// Offset of the item.
        offset: usize,
        /// The category.
        category: u8,
        /// The item.
        item: &'static str,
        /// Length of the item in bytes, as far as known.
        needed: usize,
        /// The bytes from its begin to the end of the block.
        available: usize,
    },
    /// An explicit item of length zero, which can not even hold the length byte.
    #[error("byte {offset}: I{category:03}/{item} gives its length as 0, the least is 1")]
    ExplicitLength {
        /// Offset of the item.
        offset: usize,
        /// The category.
        category: u8,
        /// The item.
        item: &'static str,
    },
    /// An extended item continues after the last part of the edition.
    #[error(
        "byte {offset}: I{category:03}/{item} goes on for more than {tolerated} octets after \
         its last defined part"
    )]
    ExtensionUndefined {
        /// Offset of the item.
        offset: usize,
        /// The category.
        category: u8,
        /// The item.
        item: &'static str,
        /// Number of undefined bytes tolerated: zero in strict mode.
        tolerated: usize,
    },
    /// A compound item announces a subitem that the edition does not define.
    #[error(
        "byte {offset}: I{category:03}/{item} announces a subitem at position {position}, \
         where this edition defines none"
    )]
    SubitemUndefined {
        /// Offset of the item.
        offset: usize,
        /// The category.
        category: u8,
        /// The item.
        item: &'static str,
        /// The position in the item's own FSPEC, from 1.
        position: usize,
    },
    /// A random field sequence announces an item that the edition does not define, or another sequence.
    #[error(
        "byte {offset}: I{category:03}/{item} announces an item at FRN {frn}, \
         where this edition defines none that can be in a sequence"
    )]
    SequenceUndefined {
        /// Offset of the sequence.
        offset: usize,
        /// The category.
        category: u8,
        /// The sequence.
        item: &'static str,
        /// The field reference number.
        frn: u8,
    },
    /// A latitude beyond a pole in a record that another edition reads without one: wrong edition.
    #[error(
        "byte {offset}: category {category:03}: latitude {latitude_deg}°, the limit is 90°: \
         another edition fits"
    )]
    LatitudeImpossible {
        /// Offset of the record.
        offset: usize,
        /// The category.
        category: u8,
        /// The latitude, rounded away from zero, degrees.
        latitude_deg: i32,
    },
    /// A spare bit is set; an error in strict mode only.
    #[error("byte {offset}: I{category:03}/{item} has a spare bit set, expected all zero")]
    SpareBitSet {
        /// Offset of the item.
        offset: usize,
        /// The category.
        category: u8,
        /// The item.
        item: &'static str,
    },
}

impl Error {
    /// The byte at which the error was noticed, in the bytes the caller passed.
    pub fn offset(&self) -> usize {
        match *self {
            Self::HeaderTruncated { offset, .. }
            | Self::BlockLength { offset, .. }
            | Self::BlockTruncated { offset, .. }
            | Self::NoTable { offset, .. }
            | Self::FspecTruncated { offset, .. }
            | Self::FspecTooLong { offset, .. }
            | Self::RecordEmpty { offset, .. }
            | Self::ItemUndefined { offset, .. }
            | Self::ProfileUndecided { offset, .. }
            | Self::ItemTruncated { offset, .. }
            | Self::ExplicitLength { offset, .. }
            | Self::ExtensionUndefined { offset, .. }
            | Self::SubitemUndefined { offset, .. }
            | Self::SequenceUndefined { offset, .. }
            | Self::LatitudeImpossible { offset, .. }
            | Self::SpareBitSet { offset, .. } => offset,
        }
    }

    /// The category of the block, unless not even its header could be read.
    pub fn category(&self) -> Option<u8> {
        match *self {
            Self::HeaderTruncated { .. } => None,
            Self::BlockLength { category, .. }
            | Self::BlockTruncated { category, .. }
            | Self::NoTable { category, .. }
            | Self::FspecTruncated { category, .. }
            | Self::FspecTooLong { category, .. }
            | Self::RecordEmpty { category, .. }
            | Self::ItemUndefined { category, .. }
            | Self::ProfileUndecided { category, .. }
            | Self::ItemTruncated { category, .. }
            | Self::ExplicitLength { category, .. }
            | Self::ExtensionUndefined { category, .. }
            | Self::SubitemUndefined { category, .. }
            | Self::SequenceUndefined { category, .. }
            | Self::LatitudeImpossible { category, .. }
            | Self::SpareBitSet { category, .. } => Some(category),
        }
    }

    /// The item, if the error was noticed in one.
    pub fn item(&self) -> Option<&'static str> {
        match *self {
            Self::ProfileUndecided { item, .. }
            | Self::ItemTruncated { item, .. }
            | Self::ExplicitLength { item, .. }
            | Self::ExtensionUndefined { item, .. }
            | Self::SubitemUndefined { item, .. }
            | Self::SequenceUndefined { item, .. }
            | Self::SpareBitSet { item, .. } => Some(item),
            _ => None,
        }
    }

    /// Kind of the error in a few words, the same for all errors of a kind: to count them by.
    pub fn label(&self) -> &'static str {
        match self {
            Self::HeaderTruncated { .. } => "block header cut",
            Self::BlockLength { .. } => "impossible block length",
            Self::BlockTruncated { .. } => "block cut",
            Self::NoTable { .. } => "no table of the category",
            Self::FspecTruncated { .. } | Self::FspecTooLong { .. } => "endless FSPEC",
            Self::RecordEmpty { .. } => "record without items",
            Self::ItemUndefined { .. } => "undefined item",
            Self::ProfileUndecided { .. } => "undecided profile",
            Self::ItemTruncated { .. } => "item cut",
            Self::ExplicitLength { .. } => "explicit item of length 0",
            Self::ExtensionUndefined { .. } => "undefined extension",
            Self::SubitemUndefined { .. } => "undefined subitem",
            Self::LatitudeImpossible { .. } => "impossible latitude",
            Self::SequenceUndefined { .. } => "undefined item in a sequence",
            Self::SpareBitSet { .. } => "spare bit set",
        }
    }
}

/// Why the element that decides between profiles did not.
pub(super) fn describe_choice(found: Option<u64>) -> String {
    match found {
        None => "but is absent".to_owned(),
        Some(value) => format!("its value {value} has none"),
    }
}
