//! A recording as a whole: its container, and its credible records.
//!
//! # The problem
//!
//! A block does not contain the edition of its category, and records have no end mark. With a wrong edition, most
//! blocks end with an error, but an error is detected late, when an item exceeds the block or an FSPEC bit has no
//! meaning; the records before the error are already wrong. Some blocks even fit by accident. In two recordings read
//! with a wrong edition, 3 % of 49,330 blocks of ADS-B (0.23, read as 2.4) and 13 % of 100 blocks of system tracks
//! (an early edition, read as 1.18) fitted. A decoder of single records would print thousands of wrong positions.
//!
//! # The rule
//!
//! - A **block** is accepted only if its records fill it to the last byte.
//! - A **category** is accepted only if at least half of its blocks fit. Otherwise it is *withheld*, and the survey
//!   lists other editions that fit the remaining blocks.
//! - A block with a latitude beyond a pole does not fit if another edition fits the block without such a value. An
//!   edition that the caller has chosen is not doubted so.
//!
//! A recording is therefore read twice: first to [survey](RecordingBytes::survey) it, then for its
//! [records](RecordingBytes::for_each). Finding the items of all records costs little compared with decoding.
//!
//! # Limits
//!
//! The rule applies to whole categories. If two senders use different editions of a category, the smaller sender
//! loses its blocks, of which some fit by accident; decode each sender's recording separately with its own edition.

mod expansions;
mod refusals;
mod statistics;

pub use expansions::{ExpansionFailures, Expansions};
pub use refusals::{RefusalGroup, Refusals};
pub use statistics::{Rate, RecordSender, SenderSummary, Statistics};

use std::collections::{BTreeMap, BTreeSet};

use crate::containers::{Container, ContainerCounts, Datagrams, RecordedDatagram, TimeStamp};
use crate::foreign::Foreign;
use asterix::choice::ChosenEdition;
use asterix::field::{self, Elements};
use asterix::{Block, Category, Edition, Error, Mode, Record, blocks_at, registry};

/// Largest latitude, degrees.
const POLE_DEG: f64 = 90.0;

/// The bytes of a recording, and how to read them.
#[derive(Debug, Clone)]
pub struct RecordingBytes<'a> {
    bytes: &'a [u8],
    container: Container,
    tables: BTreeMap<u8, &'static Category>,
    /// Categories with an edition chosen by the caller.
    chosen: BTreeSet<u8>,
    mode: Mode,
}

/// A record of a recording.
#[derive(Debug, Clone, Copy)]
pub struct LocatedRecord<'r, 'b> {
    /// The record; its offset is relative to the start of the recording, unless its datagram was fragmented.
    pub record: &'r Record<'b>,
    /// Time at which its datagram was recorded, where that is known.
    pub time_stamp: Option<TimeStamp>,
}

/// Content of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordingSurvey {
    /// The kind of the recording.
    pub container: Container,
    /// Sums over its octets on the way to datagrams.
    pub unpacked: ContainerCounts,
    /// The categories of its blocks.
    pub categories: BTreeMap<u8, CategorySurvey>,
    /// Parts that are not given, by reason.
    pub refusals: Refusals,
}

/// Content of a recording in one category.
#[derive(Debug, Clone, PartialEq)]
pub struct CategorySurvey {
    /// The edition it is read with; none if there is no table.
    pub edition: Option<Edition>,
    /// Number of blocks.
    pub blocks: u64,
    /// Number of blocks that do not fit the edition.
    pub blocks_refused: u64,
    /// The records in those that do.
    pub records: u64,
    /// Bytes of the blocks that do.
    pub octets: u64,
    /// Bytes of the blocks that do not.
    pub octets_refused: u64,
    /// For each other edition, how many of the blocks refused fit it; the default first, then by number.
    pub others: Vec<(Edition, u64)>,
    /// Elements with latitudes, if impossible latitudes count against the edition.
    latitudes: Vec<Elements<1>>,
}

impl<'a> RecordingBytes<'a> {
    /// Returns a recording of the kind determined by its bytes, with the default edition of every category.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            container: Container::detect(bytes),
            tables: registry::defaults().map(|table| (table.number, table)).collect(),
            chosen: BTreeSet::new(),
            mode: Mode::Lenient,
        }
    }

    /// Takes it for a recording of this kind.
    pub fn in_container(mut self, container: Container) -> Self {
        self.container = container;
        self
    }

    /// Reads categories with the tables among these editions instead of the defaults.
    pub fn with_editions(self, editions: &[ChosenEdition]) -> Self {
        editions.iter().fold(self, |recording, chosen| match chosen {
            ChosenEdition::Category(table) => recording.with_table(table),
            ChosenEdition::Expansion(_) => recording,
        })
    }

    /// Reads a category with this edition's table instead of the default.
    pub fn with_table(mut self, table: &'static Category) -> Self {
        self.tables.insert(table.number, table);
        self.chosen.insert(table.number);
        self
    }

    /// Demands this of every block.
    pub fn with_mode(mut self, mode: Mode) -> Self {
        self.mode = mode;
        self
    }

    /// Looks at every block.
    pub fn survey(&self) -> RecordingSurvey {
        let mut datagrams = Datagrams::new(self.container, self.bytes);
        let (mut categories, mut refusals) = (BTreeMap::new(), Refusals::default());
        for piece in datagrams.by_ref() {
            match piece {
                Ok(datagram) => self.survey_datagram(&datagram, &mut categories, &mut refusals),
                Err(skipped) => refusals.skipped(&skipped),
            }
        }
        RecordingSurvey {
            container: self.container,
            unpacked: *datagrams.counts(),
            categories,
            refusals,
        }
    }

    fn survey_datagram(
        &self,
        datagram: &RecordedDatagram<'_>,
        categories: &mut BTreeMap<u8, CategorySurvey>,
        refusals: &mut Refusals,
    ) {
        let end = datagram.offset + datagram.bytes.len();
        for block in blocks_at(datagram.offset, &datagram.bytes) {
            let block = match block {
                Ok(block) => block,
                Err(error) => {
                    refusals.error(&error, end - error.offset());
                    continue;
                }
            };
            let table = self.tables.get(&block.category).copied();
            let category = categories.entry(block.category).or_insert_with(|| {
                let mut category = CategorySurvey::new(block.category, table);
                if self.chosen.contains(&block.category) {
                    category.latitudes.clear();
                }
                category
            });
            if let Err(error) = category.add(&block, table, self.mode) {
                refusals.error(&error, block.bytes.len());
            }
        }
    }

    /// Gives every record that can be believed by the survey of this recording, in the order recorded.
    ///
    /// # Errors
    /// The first that `visit` gives, which ends it.
    pub fn for_each<E>(
        &self,
        survey: &RecordingSurvey,
        mut visit: impl FnMut(LocatedRecord<'_, '_>) -> Result<(), E>,
    ) -> Result<(), E> {
        for datagram in Datagrams::new(self.container, self.bytes).flatten() {
            for block in blocks_at(datagram.offset, &datagram.bytes).flatten() {
                let Some((table, category)) = self.believed(survey, block.category) else {
                    continue;
                };
                if category.blocks_refused > 0 && category.judge(&block, table, self.mode).is_err() {
                    continue;
                }
                for record in block.records(table, self.mode).flatten() {
                    let (record, time_stamp) = (&record, datagram.time_stamp);
                    visit(LocatedRecord { record, time_stamp })?;
                }
            }
        }
        Ok(())
    }

    fn believed<'s>(
        &self,
        survey: &'s RecordingSurvey,
        category: u8,
    ) -> Option<(&'static Category, &'s CategorySurvey)> {
        let surveyed = survey.categories.get(&category)?;
        let table = self.tables.get(&category)?;
        (!surveyed.is_withheld()).then_some((table, surveyed))
    }
}

impl RecordingSurvey {
    /// The blocks of all categories.
    pub fn blocks(&self) -> u64 {
        self.categories.values().map(|category| category.blocks).sum()
    }

    /// The records that are given.
    pub fn records(&self) -> u64 {
        self.given().map(|category| category.records).sum()
    }

    /// Returns whether most of the surveyed bytes are in blocks whose records are given.
    pub fn is_mostly_read(&self, bytes: &[u8]) -> bool {
        let octets: u64 = self.given().map(|category| category.octets).sum();
        2 * octets > bytes.len() as u64
    }

    /// Returns whether most bytes of the datagrams are in blocks of categories with a name and without a table.
    pub fn is_mostly_without_table(&self) -> bool {
        let named = self.categories.iter().filter(|(number, category)| {
            category.edition.is_none() && registry::name_without_table(**number).is_some()
        });
        let octets: u64 = named.map(|(_, category)| category.octets_refused).sum();
        2 * octets > self.unpacked.datagram_octets
    }

    /// Kind of the surveyed bytes if they are no recording: text, and other kinds where less than half can be decoded.
    /// Captures have marks of their own.
    pub fn foreign(&self, bytes: &[u8]) -> Option<Foreign> {
        match self.container {
            Container::Raw if self.is_mostly_read(bytes) => Foreign::as_text(bytes),
            Container::Raw => Foreign::of(bytes),
            Container::Pcap | Container::PcapNg | Container::Final | Container::Gps | Container::Hex => None,
        }
    }

    fn given(&self) -> impl Iterator<Item = &CategorySurvey> {
        self.categories.values().filter(|category| !category.is_withheld())
    }
}

impl CategorySurvey {
    /// Nothing was seen yet of category `number`, which is read by `table`.
    pub fn new(number: u8, table: Option<&'static Category>) -> Self {
        let edition = table.map(|table| table.edition);
        let others = registry::editions(number).filter(|other| Some(other.edition) != edition);
        Self {
            edition,
            blocks: 0,
            blocks_refused: 0,
            records: 0,
            octets: 0,
            octets_refused: 0,
            others: others.map(|other| (other.edition, 0)).collect(),
            latitudes: table.map(latitudes).unwrap_or_default(),
        }
    }

    /// Whether too few blocks fit, so that fits may be accidental: none of the category's records is returned.
    pub fn is_withheld(&self) -> bool {
        2 * self.blocks_refused > self.blocks
    }

    /// The other editions that fit most of the blocks refused, and how many; none if no other fits half of them.
    pub fn better(&self) -> Option<(Vec<Edition>, u64)> {
        let most = self.others.iter().map(|(_, fitting)| *fitting).max()?;
        let best = self.others.iter().filter(|(_, fitting)| *fitting == most);
        (2 * most >= self.blocks_refused && most > 0).then(|| (best.map(|(edition, _)| *edition).collect(), most))
    }

    /// Counts a block.
    ///
    /// # Errors
    /// Why it does not fit.
    pub fn add(&mut self, block: &Block<'_>, table: Option<&'static Category>, mode: Mode) -> Result<(), Error> {
        self.blocks += 1;
        let fitted = match table {
            Some(table) => self.judge(block, table, mode),
            None => Err(Error::NoTable {
                offset: block.offset,
                category: block.category,
            }),
        };
        match fitted {
            Ok(records) => {
                self.records += records;
                self.octets += block.bytes.len() as u64;
            }
            Err(_) => {
                self.blocks_refused += 1;
                self.octets_refused += block.bytes.len() as u64;
                for (edition, fitting) in &mut self.others {
                    let other = registry::find(block.category, *edition);
                    *fitting += u64::from(other.is_some_and(|other| fits_well(block, other, mode)));
                }
            }
        }
        fitted.map(|_| ())
    }

    /// Returns the number of records in a block, if they fill the block and their latitudes do not indicate another
    /// edition.
    ///
    /// # Errors
    /// Fault of the first that does not fit.
    fn judge(&self, block: &Block<'_>, table: &'static Category, mode: Mode) -> Result<u64, Error> {
        match fit(block, table, mode, &self.latitudes)? {
            (_, Some(impossible)) if self.has_better(block, mode) => Err(impossible),
            (records, _) => Ok(records),
        }
    }

    /// Whether another edition reads a block without an impossible latitude.
    fn has_better(&self, block: &Block<'_>, mode: Mode) -> bool {
        let mut others = self.others.iter();
        others.any(|(edition, _)| {
            registry::find(block.category, *edition).is_some_and(|other| fits_well(block, other, mode))
        })
    }
}

fn latitudes(table: &Category) -> Vec<Elements<1>> {
    field::named(table, "LAT")
}

fn fits_well(block: &Block<'_>, table: &'static Category, mode: Mode) -> bool {
    matches!(fit(block, table, mode, &latitudes(table)), Ok((_, None)))
}

/// Returns the number of records in a block, if they fill the block, and the first of these `latitudes` beyond a
/// pole, if any.
///
/// # Errors
/// Fault of the first that does not fit.
fn fit(
    block: &Block<'_>,
    table: &'static Category,
    mode: Mode,
    latitudes: &[Elements<1>],
) -> Result<(u64, Option<Error>), Error> {
    block
        .records(table, mode)
        .try_fold((0, None), |(count, impossible), record| {
            let record = record?;
            let beyond = || {
                let values = latitudes.iter().filter_map(|latitude| latitude.quantity(&record));
                values.map(f64::to_degrees).find(|degrees| degrees.abs() > POLE_DEG)
            };
            let error = |latitude: f64| Error::LatitudeImpossible {
                offset: record.offset(),
                category: block.category,
                latitude_deg: (latitude.signum() * latitude.abs().ceil()) as i32,
            };
            Ok((count + 1, impossible.or_else(|| beyond().map(error))))
        })
}
