//! `koseki recording export`: content of a recording of all topics in other formats.

use std::fs::File;
use std::io::{self, BufReader, Write as _};
use std::path::PathBuf;

use anyhow::Context as _;
use asterix::registry;
use messages::SystemTrack;
use messages::layout::Sample as _;
use offline::{OutputFile, Usage, check_outputs};
use outgoing::{SystemReports, SystemSource};
use recorder::Tables;
use recording::{Facts, Item};

use crate::args::RecordingExport;
use crate::config::Config;
use crate::recording_foxglove::PictureWriter;
use crate::recording_info::files;
use crate::replay::{configuration, facts};

/// Largest size of a data block, bytes: with the headers of UDP and IP it fits an Ethernet frame.
const BLOCK_OCTETS_MAX: usize = 1400;
/// Category of system tracks.
const SYSTEM_TRACKS: u8 = 62;

/// Exports.
///
/// # Errors
/// If the recording cannot be read, or something cannot be written.
pub(crate) fn run(export: &RecordingExport) -> anyhow::Result<()> {
    let paths = files(&export.path)?;
    check_outputs(
        &paths,
        &[
            ("--csv", export.csv.as_ref()),
            ("--asterix", export.asterix.as_ref()),
            ("--foxglove", export.foxglove.as_ref()),
        ],
    )?;
    let facts = facts(&paths[0])?;
    let config = configuration(&facts, &paths[0])?;
    let tables = |folder| Tables::begin(&config, folder, first_day_ns(&facts)?);
    let mut tables = export.csv.as_deref().map(tables).transpose()?;
    let mut blocks = export
        .asterix
        .as_deref()
        .map(|path| TrackBlocks::begin(&config, OutputFile::begin(path)?));
    let mut blocks = blocks.take().transpose()?;
    let pictures = |path: &PathBuf| PictureWriter::begin(&config, OutputFile::begin(path)?);
    let mut pictures = export.foxglove.as_ref().map(pictures).transpose()?;
    for path in &paths {
        let mut file = BufReader::with_capacity(1 << 18, File::open(path)?);
        recording::read::<_, anyhow::Error>(&mut file, |item| {
            tables.as_mut().map_or(Ok(()), |tables| tables.add(&item))?;
            pictures.as_mut().map_or(Ok(()), |pictures| pictures.add(&item))?;
            Ok(blocks.as_mut().map_or(Ok(()), |blocks| blocks.add(&item))?)
        })
        .with_context(|| format!("exporting {}", path.display()))?;
    }
    tables.map_or(Ok(()), Tables::finish)?;
    pictures.map_or(Ok(()), PictureWriter::finish)?;
    blocks.map_or(Ok(()), TrackBlocks::finish)
}

/// Midnight from which the recorder's tables count their seconds.
fn first_day_ns(facts: &Facts) -> Result<i64, Usage> {
    let said = facts.get("first_day_ns").and_then(|text| text.parse().ok());
    said.ok_or_else(|| Usage("the recording does not contain the day of its times".to_owned()))
}

/// System tracks as data blocks.
struct TrackBlocks {
    reports: SystemReports,
    topic: String,
    out: OutputFile,
}

impl TrackBlocks {
    fn begin(config: &Config, out: OutputFile) -> anyhow::Result<Self> {
        let table = registry::default_edition(SYSTEM_TRACKS).context("CAT062 has a table")?;
        let sources = config.sources.iter().map(|source| SystemSource {
            number: source.number,
            technology: source.technology,
        });
        let sources: Vec<_> = sources.collect();
        // With the settings of this deployment's gateway, if present.
        let of_tracks = |gateway: &&gateway::Settings| gateway.source.is_none();
        let gateway = config.parts.gateway.gateways.iter().find(of_tracks);
        let table = gateway.map_or(Ok(table), gateway::Settings::table)?;
        let (sac, sic) = gateway.map_or((0, 0), |gateway| (gateway.sac, gateway.sic));
        let reports = SystemReports::new(table, sac, sic, config.frame, &sources, BLOCK_OCTETS_MAX)?;
        Ok(Self {
            reports: reports.with_height(gateway.map_or_else(Default::default, |gateway| gateway.heights)),
            topic: messages::system_tracks().name.as_str().to_owned(),
            out,
        })
    }

    fn add(&mut self, item: &Item<'_>) -> io::Result<()> {
        match item {
            Item::Sample { topic, octets } if *topic == self.topic => match SystemTrack::of_octets(octets) {
                Some(track) => self.put(|reports, send| reports.report(&track, send)),
                None => Ok(()),
            },
            _ => Ok(()),
        }
    }

    /// Does `what`, and writes the blocks that come of it.
    fn put(&mut self, what: impl FnOnce(&mut SystemReports, &mut outgoing::SendBlock<'_>)) -> io::Result<()> {
        let Self { reports, out, .. } = self;
        let mut written = Ok(());
        what(reports, &mut |block| {
            if written.is_ok() {
                written = out.write_all(block);
            }
        });
        written
    }

    fn finish(mut self) -> anyhow::Result<()> {
        self.put(SystemReports::flush)?;
        self.out.finish()
    }
}
