//! System tracks as data blocks of CAT062.

use std::io::{self, Write};

use anyhow::Context as _;
use asterix::{Category, registry};
use deployment::Source;
use frames::SystemFrame;
use messages::SystemTrack;
use outgoing::{HeightReference, OutgoingCounts, SystemReports, SystemSource};

/// Largest size of a data block, bytes: with the headers of UDP and IP a block fits an Ethernet frame.
const BLOCK_OCTETS_MAX: usize = 1400;
/// Category of system tracks.
const SYSTEM_TRACKS: u8 = 62;

/// Content and form of the data blocks.
#[derive(Clone, Copy, Debug)]
pub struct BlockForm {
    /// Edition; `None` for the newest known edition.
    pub table: Option<&'static Category>,
    /// System area code and system identification code of the sender.
    pub sender: [u8; 2],
    /// Reference of the heights.
    pub heights: HeightReference,
}

/// Writer of system tracks as data blocks.
#[derive(Debug)]
pub struct TrackBlocks<W> {
    reports: SystemReports,
    out: W,
}

impl<W: Write> TrackBlocks<W> {
    /// Creates a writer for a system with this frame and these sources.
    ///
    /// # Errors
    /// If the edition is not an edition of CAT062.
    pub fn new(out: W, form: &BlockForm, frame: SystemFrame, sources: &[Source]) -> anyhow::Result<Self> {
        let newest = registry::default_edition(SYSTEM_TRACKS);
        let table = form.table.or(newest).context("CAT062 has no table")?;
        let source = |source: &Source| SystemSource {
            number: source.number,
            technology: source.technology,
            code: source.sac_sic.map(|(sac, sic)| [sac, sic]),
        };
        let sources: Vec<_> = sources.iter().map(source).collect();
        let [sac, sic] = form.sender;
        let reports = SystemReports::new(table, sac, sic, frame, &sources, BLOCK_OCTETS_MAX)?;
        Ok(Self {
            reports: reports.with_height(form.heights),
            out,
        })
    }

    /// Writes a state.
    ///
    /// # Errors
    /// If the output fails.
    pub fn write(&mut self, track: &SystemTrack) -> io::Result<()> {
        self.put(|reports, send| reports.report(track, send))
    }

    /// Writes the last block; returns the output, and the counts of records.
    ///
    /// # Errors
    /// If the output fails.
    pub fn finish(mut self) -> io::Result<(W, OutgoingCounts)> {
        self.put(SystemReports::flush)?;
        Ok((self.out, self.reports.counts()))
    }

    /// Performs `what`, and writes the resulting blocks.
    fn put(&mut self, what: impl FnOnce(&mut SystemReports, &mut outgoing::SendBlock<'_>)) -> io::Result<()> {
        let Self { reports, out } = self;
        let mut written = Ok(());
        what(reports, &mut |block| {
            if written.is_ok() {
                written = out.write_all(block);
            }
        });
        written
    }
}
