//! Blocks outside the configuration: of unknown senders, and of other editions.
//!
//! Both are mistakes of a configuration that a count alone does not locate. The most frequent case is therefore
//! named.

use std::collections::BTreeMap;

use asterix::{Block, Edition, StatedTables};
use formats::recording::CategorySurvey;
use messages::Counter;
use runtime::HealthEntry;

/// Maximum number of remembered senders; further senders are counted together.
const STRANGERS_MAX: usize = 32;
/// Number of blocks after which no other edition is tried, if none has fitted.
const TRIED_MAX: u64 = 256;

/// Senders (SAC and SIC) without a configured source, and the number of blocks of each.
#[derive(Debug, Default)]
pub(crate) struct Strangers {
    heard: BTreeMap<(u8, u8), u64>,
    blocks: u64,
}

impl Strangers {
    /// Takes a block of `sender`; `None` without SAC and SIC.
    pub(crate) fn hear(&mut self, sender: Option<(u8, u8)>) {
        self.blocks += 1;
        let Some(sender) = sender else { return };
        if self.heard.len() < STRANGERS_MAX || self.heard.contains_key(&sender) {
            *self.heard.entry(sender).or_default() += 1;
        }
    }

    /// Adds the counts, and names the most frequent sender.
    pub(crate) fn report(&self, health: &mut HealthEntry) {
        let counters = &mut health.counters;
        counters[Counter::RejectedSource] = self.blocks;
        counters[Counter::UnknownSenders] = self.heard.len() as u64;
        if let Some(((sac, sic), blocks)) = self.heard.iter().max_by_key(|(_, blocks)| **blocks) {
            health.misfit = [*sac, *sic, 0, 0];
            counters[Counter::UnknownSenderBlocks] = *blocks;
        }
    }
}

/// Unreadable blocks of a source, by category.
#[derive(Debug)]
pub(crate) struct Misfits {
    configured: StatedTables,
    categories: BTreeMap<u8, CategorySurvey>,
}

impl Misfits {
    pub(crate) fn new(configured: StatedTables) -> Self {
        Self {
            configured,
            categories: BTreeMap::new(),
        }
    }

    /// Tries the other editions on a block that does not fit.
    pub(crate) fn try_others(&mut self, block: &Block<'_>) {
        let Some(table) = self.configured.table(block.category) else {
            return;
        };
        let survey = self
            .categories
            .entry(block.category)
            .or_insert_with(|| CategorySurvey::new(block.category, Some(table)));
        if survey.blocks < TRIED_MAX || survey.better().is_some() {
            // The decoder counts the reason.
            let _ = survey.add(block, Some(table), self.configured.mode());
        }
    }

    /// Returns category, edition and number of blocks of the edition that fits best.
    fn most(&self) -> Option<(u8, Edition, u64)> {
        let better = self.categories.iter().filter_map(|(category, survey)| {
            let (editions, blocks) = survey.better()?;
            Some((*category, *editions.first()?, blocks))
        });
        better.max_by_key(|(.., blocks)| *blocks)
    }

    /// Adds the count, and names the edition that fits.
    pub(crate) fn report(&self, health: &mut HealthEntry) {
        if let Some((category, Edition { major, minor }, blocks)) = self.most() {
            health.counters[Counter::BlocksOfOtherEdition] = blocks;
            health.misfit = [category, major, minor, 0];
        }
    }
}

#[cfg(test)]
mod tests {
    use asterix::{Category, Mode, blocks, registry};
    use frames::{Geodetic, SensorFrame, SystemFrame};
    use messages::{Counters, Covariance, Identity, SensorTrack, TrackState};
    use outgoing::SensorReports;

    use super::*;

    #[test]
    fn the_most_frequent_stranger_is_named() {
        let (mut strangers, mut health) = (Strangers::default(), HealthEntry::default());
        strangers.report(&mut health);
        assert_eq!((health.misfit, health.counters), ([0; 4], Counters::default()));
        for sender in [Some((40, 2)), Some((40, 3)), None, Some((40, 2))] {
            strangers.hear(sender);
        }
        strangers.report(&mut health);
        let of = |counter| health.counters[counter];
        assert_eq!((health.misfit, of(Counter::UnknownSenderBlocks)), ([40, 2, 0, 0], 2));
        assert_eq!((of(Counter::UnknownSenders), of(Counter::RejectedSource)), (2, 4));
        for number in 0..=u8::MAX {
            strangers.hear(Some((number, 0)));
        }
        assert_eq!(strangers.heard.len(), STRANGERS_MAX);
    }

    #[test]
    fn another_edition_that_fits_is_named_and_junk_is_given_up() {
        let old = registry::find(21, Edition::new(0, 23)).unwrap();
        let new = registry::default_edition(21).unwrap();
        let asterix = |table: &Category| {
            let Edition { major, minor } = table.edition;
            StatedTables::new(&[(table.number, [major, minor])], true)
        };
        let system = SystemFrame::at(Geodetic::from_degrees(41.3, 2.1, 0.0).unwrap());
        let frame = SensorFrame::new(&system, system.to_geodetic([0.0; 3]), 0.0);
        let mut reports = SensorReports::new(old, 1, 2, frame, system, 1472).unwrap();
        let mut bytes = Vec::new();
        let track = SensorTrack {
            state: TrackState::Confirmed as u8,
            covariance: Covariance::diagonal([20.0; 3], [2.0; 3]),
            identity: Identity::default().with_address(0x40_0000),
            ..SensorTrack::default()
        };
        let mut keep = |block: &[u8]| bytes.extend_from_slice(block);
        reports.report(&track, &mut keep);
        reports.flush(&mut keep);
        let block = blocks(&bytes).next().unwrap().unwrap();
        assert!(block.records(new, Mode::Strict).any(|record| record.is_err()));
        let (mut misfits, mut health) = (Misfits::new(asterix(new)), HealthEntry::default());
        for _ in 0..142 {
            misfits.try_others(&block);
        }
        misfits.report(&mut health);
        let Edition { major, minor } = old.edition;
        assert_eq!(health.counters[Counter::BlocksOfOtherEdition], 142);
        assert_eq!(health.misfit, [21, major, minor, 0]);
        assert_eq!(misfits.most().map(|(category, ..)| category), Some(21));
        let junk = [48, 0, 5, 0xff, 0xff];
        let junk = blocks(&junk).next().unwrap().unwrap();
        for _ in 0..2 * TRIED_MAX {
            misfits.try_others(&junk);
        }
        assert_eq!(misfits.categories[&48].blocks, TRIED_MAX);
    }
}
