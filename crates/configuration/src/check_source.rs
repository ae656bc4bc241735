//! Checking one source, of a file or of a tracker process.
//!
//! Each check names its key as the file spells it, so that the error can name the line.

use std::path::PathBuf;

use frames::{SensorFrame, SystemFrame};
use fusion_settings::{AccuracyTable, CoverageArea, SourceSettings};
use locating::music::ArraySettings;
use reception::ConversionModel;
use scenario::{ArrayGeometry, Instrument, SensorKind, SensorSettings};
use settings::{Degrees, SettingsError};

use super::check_network::{Network, asterix, simulated_sac_sic, technology};
use super::checked::{Checked, CheckedSource, limits, place};
use super::external_detections::takes_detections;
use super::tables::{PlaceTable, RecordedTable, SourceTable};
use super::tracker::source_tracker;
use deployment::{Input, Links, Recorded, RecordedFormat, SampleDelivery, Source};
use sources::{FinderSettings, Processing, SourceReading, TrackerSettings};

/// Shortest silence that is told, seconds: processes speak five times a second.
const SILENT_MIN_S: f64 = 1.0;

/// The source number `index` that `raw` describes, how its tracks come about, and how fusion weighs them.
pub(super) fn check_source(
    index: usize,
    raw: &SourceTable,
    system: &SystemFrame,
    origin: &PlaceTable,
    network: &mut Network,
) -> Checked<(CheckedSource, SourceSettings)> {
    let key = |part: &str| format!("source[{index}].{part}");
    let sensor_place = raw.place.as_ref().unwrap_or(origin);
    let mut origin = place(&key("place"), sensor_place)?;
    let (input, adapter) = match (
        &raw.recorded,
        &raw.live,
        &raw.simulated,
        &raw.simulated_direction_finder,
        &raw.simulated_ais,
    ) {
        (Some(recorded), ..) => (Input::Recorded(check_recorded(index, recorded)?), raw.name.clone()),
        (_, Some(live), ..) => (Input::Live(network.live(index, live)?), live.receiver.clone()),
        (_, _, Some(simulated), ..) => {
            origin = system.to_geodetic(simulated.position_m.unwrap_or_default());
            (Input::Simulated(network.simulated(index, &raw.name)), raw.name.clone())
        }
        (_, _, _, Some(_), _) => (Input::Simulated(network.simulated(index, &raw.name)), raw.name.clone()),
        (_, _, _, _, Some(_)) => (
            Input::Simulated(network.simulated_ais(index, &raw.name)),
            raw.name.clone(),
        ),
        _ => (Input::External, raw.name.clone()),
    };
    let sender = raw.recorded.as_ref().map(|recorded| &recorded.sender);
    let sender = sender.or(raw.live.as_ref().map(|live| &live.sender));
    let instrument = instrument(raw);
    let instrument = instrument.as_ref();
    let tracker = check_tracker(index, raw, (&input, instrument), network)?
        .map(|settings| Processing::Detections(Box::new(settings)));
    let locator = check_locator(index, raw, (&input, instrument), network)?
        .map(|settings| Processing::Bearings(Box::new(settings)));
    let processing = tracker.or(locator).unwrap_or(Processing::Tracks);
    let model = ConversionModel {
        number: index as u16,
        sac_sic: match (&input, sender) {
            (Input::Simulated(_), _) if raw.simulated_ais.is_none() => Some(simulated_sac_sic(index as u16)),
            (_, sender) => sender.and_then(|sender| sender.identity.sac_sic()),
        },
        method: sender.map(|sender| sender.method).unwrap_or_default(),
        positions: sender.map(|sender| sender.positions).unwrap_or_default(),
        frame: SensorFrame::new(system, origin, sensor_place.north_offset_deg.rad()),
        system: *system,
        height_m: origin.height_m(),
        assumed_height_m: raw.assumed_height_m,
        qnh_hpa: raw.qnh_hpa,
        limits: raw.limits,
        covariance: raw.covariance,
        is_on_board: false,
    };
    let source = Source {
        number: index as u16,
        uid: raw.uid.unwrap_or_else(|| messages::sensor_uid(&raw.name)),
        name: raw.name.clone(),
        technology: raw
            .technology
            .unwrap_or_else(|| technology(&input, instrument, network)),
        delivers: delivery(&processing),
        links: Links::default(),
        on_board: None,
        takes_orders: false,
        silent_after_ns: silent_after_ns(raw, &input),
        period_ns: settings::Seconds::of(raw.period_s()).ns(),
        required: raw.required,
        sac_sic: model.sac_sic,
        frame: model.frame,
        stated_place_deg: raw
            .place
            .as_ref()
            .map(|place| [place.latitude_deg, place.longitude_deg]),
        has_statements: match &input {
            Input::Live(live) | Input::Simulated(live) => network.feed(&live.receiver).is_some(),
            Input::Recorded(recorded) => recorded.format.feed().is_some(),
            _ => false,
        },
        clock_step: model.limits.clock_step(),
        tracks_max: model.limits.tracks,
        input,
        adapter,
    };
    let place_m = source.frame.place();
    let usual = (raw.period_s(), u32::from(source.number));
    let weighed = SourceSettings::new(&raw.name, &raw.weighing, usual, place_m, &AccuracyTable::default());
    let mut weighed = weighed.map_err(|error| error.under(&format!("source[{index}]")))?;
    weighed.sensor_uid = source.uid;
    use deployment::Technology;
    let is_self_reported = [Technology::AdsB, Technology::Ais].contains(&source.technology);
    weighed.is_self_reported = raw.weighing.self_reported.unwrap_or(is_self_reported);
    let is_radar = |simulated: &SensorSettings| simulated.kind == SensorKind::Radar;
    if raw.place.is_some() || raw.simulated.as_ref().is_some_and(is_radar) {
        weighed.place_m = Some(place_m);
    }
    if source.is_taken_as_it_is() {
        // The adapter has checked everything that it publishes.
        weighed.limits = limits(&model.limits, place_m);
    }
    if source.has_bearings() {
        // A direction finder hears what transmits: its silence is no evidence of absence.
        weighed.coverage.get_or_insert_with(CoverageArea::none);
        weighed.is_registered = raw.weighing.registered.unwrap_or(false);
    }
    let reading = SourceReading {
        model,
        mount: None,
        processing,
    };
    Ok((CheckedSource { source, reading }, weighed))
}

fn delivery(processing: &Processing) -> SampleDelivery {
    match processing {
        Processing::Tracks | Processing::Plots => SampleDelivery::Tracks,
        Processing::Detections(tracker) => SampleDelivery::Detections {
            cues: tracker.outputs.cues,
        },
        Processing::Bearings(finder) => SampleDelivery::Bearings {
            array: finder.array.is_some(),
        },
    }
}

/// Silence that is an alarm.
fn silent_after_ns(raw: &SourceTable, input: &Input) -> Option<i64> {
    let is_expected = !matches!(input, Input::Recorded(_)) && raw.silent_periods > 0.0;
    is_expected.then(|| ((raw.silent_periods * raw.period_s()).max(SILENT_MIN_S) * messages::NS_PER_S) as i64)
}

fn check_tracker(
    index: usize,
    raw: &SourceTable,
    (input, instrument): (&Input, Option<&Instrument>),
    network: &Network,
) -> Checked<Option<TrackerSettings>> {
    let Some(tracker) = &raw.tracker else { return Ok(None) };
    let key = || format!("source[{index}].tracker");
    let has_detections = match input {
        Input::Recorded(recorded) => recorded.format == RecordedFormat::Asterix,
        Input::Live(live) => network.feed(&live.receiver).is_none(),
        Input::Simulated(_) => matches!(instrument, Some(Instrument::Sensor(sensor)) if sensor.plots),
        // Its tracker is a process of its own.
        Input::External if takes_detections(raw) => return Ok(None),
        Input::External | Input::Tracker(_) => false,
    };
    if !has_detections {
        let what = "takes plots in ASTERIX; leave it out where a source has tracks already, give a simulated sensor \
                    plots = true, and an external source input = \"detections\"";
        return Err(SettingsError::new(key(), what));
    }
    source_tracker(tracker, index as u16, raw.weighing.period_s).map(Some)
}

/// A direction finder has bearings and nothing else, whether it is simulated or said to be one by its
/// `[source.locator]`.
fn check_locator(
    index: usize,
    raw: &SourceTable,
    (input, instrument): (&Input, Option<&Instrument>),
    network: &Network,
) -> Checked<Option<FinderSettings>> {
    let key = |part: &str| format!("source[{index}].{part}");
    let may_have_bearings = match input {
        Input::Live(live) => network.is_udp(&live.receiver),
        Input::Simulated(_) => matches!(instrument, Some(Instrument::DirectionFinder { .. })),
        Input::Recorded(recorded) => recorded.format == RecordedFormat::Asterix,
        Input::External | Input::Tracker(_) => false,
    };
    let locator = match (&raw.locator, input) {
        (Some(locator), _) if may_have_bearings => *locator,
        (Some(_), _) => {
            let what = "takes bearings: of a [[receiver]] with [receiver.udp], of a [source.recorded] in ASTERIX \
                        (category 205), or of a [source.simulated_direction_finder]";
            return Err(SettingsError::new(key("locator"), what));
        }
        (None, Input::Simulated(_)) if may_have_bearings => locating::Settings::default(),
        (None, _) => return Ok(None),
    };
    let array = raw.array.clone();
    if array.is_some() && matches!(input, Input::Recorded(_)) {
        let what = "measures bearings from live snapshots: leave it out of a recording";
        return Err(SettingsError::new(key("array"), what));
    }
    if let Some(array) = &array {
        array
            .music()
            .map_err(|error| SettingsError::new(key("array"), error.to_string()))?;
    }
    Ok(Some(FinderSettings {
        locator,
        array,
        dropped: raw.dropped.clone(),
    }))
}

/// The instrument of a simulated source.
pub(super) fn instrument(raw: &SourceTable) -> Option<Instrument> {
    if let Some(sensor) = &raw.simulated {
        return Some(Instrument::Sensor(Box::new(sensor.clone())));
    }
    if let Some(receivers) = &raw.simulated_ais {
        return Some(Instrument::Ais(Box::new(receivers.clone())));
    }
    raw.simulated_direction_finder
        .as_ref()
        .map(|finder| Instrument::DirectionFinder {
            settings: Box::new(finder.clone()),
            array: raw.array.as_ref().map(|array| Box::new(geometry(array))),
        })
}

/// Geometry of an array, for the simulation of its snapshots.
fn geometry(array: &ArraySettings) -> ArrayGeometry {
    ArrayGeometry {
        antennas_m: array
            .antennas
            .iter()
            .map(|antenna| [antenna.right_m, antenna.forward_m])
            .collect(),
        forward_rad: array.forward_deg.rad(),
        sector_rad: array.sector_deg.map(Degrees::rad),
        frequency_max_hz: array.frequency_max_hz,
    }
}

fn check_recorded(index: usize, raw: &RecordedTable) -> Checked<Recorded> {
    Ok(Recorded {
        file: PathBuf::from(&raw.file),
        format: raw.format,
        asterix: asterix(&format!("source[{index}].recorded.editions"), &raw.sender.reading)?,
        origin: raw.sender.origin,
        reorder_ns: raw.reorder_s.ns(),
        truncated: raw.truncated,
    })
}
