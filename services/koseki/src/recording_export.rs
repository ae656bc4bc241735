//! `koseki recording export`: content of a recording of all topics in other formats.

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use gateway::OutputFormat;
use messages::SystemTrack;
use messages::layout::Sample as _;
use offline::{BlockForm, OutputFile, TrackBlocks, Usage, check_outputs, unwritable};
use outgoing::HeightReference;
use recorder::Tables;
use recording::{Facts, Item};

use crate::args::RecordingExport;
use crate::config::Config;
use crate::recording_foxglove::PictureWriter;
use crate::recording_info::{files, note_damage};
use crate::recording_paths::{PathForm, PathSelection, Paths};
use crate::replay::{configuration, facts};

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
            ("--geojson", export.geojson.as_ref()),
            ("--kml", export.kml.as_ref()),
            ("--gpx", export.gpx.as_ref()),
        ],
    )?;
    let facts = facts(&paths[0])?;
    let config = configuration(&facts, &paths[0])?;
    let tables = |folder| {
        std::fs::create_dir_all(folder).map_err(|error| unwritable(folder, &error))?;
        Tables::begin(&config, folder, first_day_ns(&facts)?)
    };
    let mut tables = export.csv.as_deref().map(tables).transpose()?;
    let tracks = messages::system_tracks().name;
    let mut blocks = export
        .asterix
        .as_deref()
        .map(|path| blocks(&config, path))
        .transpose()?;
    let pictures = |path: &PathBuf| PictureWriter::begin(&config, OutputFile::begin(path)?);
    let mut pictures = export.foxglove.as_ref().map(pictures).transpose()?;
    let forms = [
        (PathForm::GeoJson, &export.geojson),
        (PathForm::Kml, &export.kml),
        (PathForm::Gpx, &export.gpx),
    ];
    let has_paths = forms.iter().any(|(_, path)| path.is_some());
    let mut lines = has_paths.then(|| Paths::new(config.frame, selection(export)));
    for path in &paths {
        let mut file = BufReader::with_capacity(1 << 18, File::open(path)?);
        recording::read::<_, anyhow::Error>(&mut file, |item| {
            note_damage(path, &item);
            tables.as_mut().map_or(Ok(()), |tables| tables.add(&item))?;
            pictures.as_mut().map_or(Ok(()), |pictures| pictures.add(&item))?;
            if let Item::Sample { topic, octets } = &item
                && *topic == tracks.as_str()
                && let Some(track) = SystemTrack::of_octets(octets)
            {
                blocks.as_mut().map_or(Ok(()), |blocks| blocks.write(&track))?;
                if let Some(lines) = &mut lines {
                    lines.add(&track);
                }
            }
            Ok(())
        })
        .with_context(|| format!("exporting {}", path.display()))?;
    }
    for (form, path) in forms {
        if let (Some(lines), Some(path)) = (&lines, path) {
            let mut file = OutputFile::begin(path)?;
            lines.write(form, &mut file)?;
            file.finish()?;
        }
    }
    tables.map_or(Ok(()), Tables::finish)?;
    pictures.map_or(Ok(()), PictureWriter::finish)?;
    blocks.map_or(Ok(()), |blocks| blocks.finish()?.0.finish())
}

/// States of the paths that are asked for.
fn selection(export: &RecordingExport) -> PathSelection {
    PathSelection {
        from_ns: export.from,
        to_ns: export.to,
        area_deg: export.area,
        targets: export.targets.clone(),
    }
}

/// Midnight from which the recorder's tables count seconds.
fn first_day_ns(facts: &Facts) -> Result<i64, Usage> {
    let said = facts.get("first_day_ns").and_then(|text| text.parse().ok());
    said.ok_or_else(|| Usage("the recording does not contain the day of its times".to_owned()))
}

/// Data blocks of the system tracks, with the settings of this deployment's gateway, if present.
fn blocks(config: &Config, path: &Path) -> anyhow::Result<TrackBlocks<OutputFile>> {
    let form = block_form(config, None, None, None)?;
    TrackBlocks::new(OutputFile::begin(path)?, &form, config.frame, &config.sources)
}

/// Form of the data blocks of a recording: as given, else in the form of its gateway, if present.
pub(crate) fn block_form(
    config: &Config,
    sac: Option<u8>,
    sic: Option<u8>,
    heights: Option<HeightReference>,
) -> anyhow::Result<BlockForm> {
    let of_tracks = |gateway: &&gateway::Settings| gateway.source.is_none() && gateway.format == OutputFormat::Asterix;
    let gateway = config.parts.gateway.gateways.iter().find(of_tracks);
    let of_gateway = gateway.map_or((0, 0, HeightReference::default()), |gateway| {
        (gateway.sac.unwrap_or(0), gateway.sic.unwrap_or(0), gateway.heights)
    });
    Ok(BlockForm {
        table: gateway.map(gateway::Settings::table).transpose()?,
        sender: [sac.unwrap_or(of_gateway.0), sic.unwrap_or(of_gateway.1)],
        heights: heights.unwrap_or(of_gateway.2),
    })
}
