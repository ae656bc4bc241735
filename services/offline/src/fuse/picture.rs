//! System tracks drawn as SVG, over the contributing reports.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::bail;
use messages::{SensorTrack, SystemTrack, TrackState};
use plotters::prelude::*;

use crate::files::OutputFile;
use crate::picture::{Drawing, Drawn, draw_legend, equal_scales, map_chart, picture};

const SIZE: (u32, u32) = (960, 960);
/// Pixels beside the map: axes, labels and margins.
const ASIDE: u32 = 110;
const SYSTEM: RGBColor = RGBColor(20, 20, 20);
/// Colours of the sensors, in the order of the ids; repeated after the last.
const SENSORS: [RGBColor; 7] = [
    RGBColor(31, 119, 180),
    RGBColor(255, 127, 14),
    RGBColor(44, 160, 44),
    RGBColor(214, 39, 40),
    RGBColor(148, 103, 189),
    RGBColor(140, 86, 75),
    RGBColor(23, 190, 207),
];

/// East and north, kilometres.
type MapPoint = (f64, f64);

/// Positions to draw.
#[derive(Debug)]
pub(super) struct TrackDrawing {
    /// System track to draw; `None` for all.
    about: Option<u32>,
    /// By source number.
    reports_km: BTreeMap<u16, Vec<MapPoint>>,
    /// By the system track's number.
    tracks_km: BTreeMap<u32, Vec<MapPoint>>,
}

impl TrackDrawing {
    /// Creates an empty picture of a system track and its surroundings, or of everything.
    pub(super) fn new(about: Option<u32>) -> Self {
        Self {
            about,
            reports_km: BTreeMap::new(),
            tracks_km: BTreeMap::new(),
        }
    }

    /// Adds an input report.
    pub(super) fn report(&mut self, report: &SensorTrack) {
        let place = kilometres(&report.position_m);
        self.reports_km.entry(report.source).or_default().push(place);
    }

    /// Adds a state of a system track; states hidden from users are not drawn.
    pub(super) fn state(&mut self, track: &SystemTrack) {
        if track.state == TrackState::Confirmed as u8 || track.state == TrackState::Coasted as u8 {
            let place = kilometres(&track.position_m);
            self.tracks_km.entry(track.track_number).or_default().push(place);
        }
    }

    /// Draws the picture; `sensor_ids` are the names of the sources in files.
    ///
    /// # Errors
    /// If there is nothing to draw, or the file cannot be written.
    pub(super) fn draw(&self, file: OutputFile, sensor_ids: &[u32]) -> anyhow::Result<()> {
        let path = file.path().display();
        match self.about {
            None if self.tracks_km.is_empty() => bail!("--picture {path}: there is no confirmed track"),
            Some(number) if !self.tracks_km.contains_key(&number) => {
                bail!("--picture {path}: system track {number} is never confirmed; --out has their numbers")
            }
            _ => picture(file, SIZE, |root| self.draw_map(root, sensor_ids)),
        }
    }

    fn draw_map(&self, area: &Drawing<'_>, sensor_ids: &[u32]) -> Drawn {
        let shown = |number: &u32| self.about.is_none_or(|about| about == *number);
        let places = self.tracks_km.iter().filter(|(number, _)| shown(number));
        let map = (SIZE.0 - ASIDE, SIZE.1 - ASIDE);
        let (east, north, pixel_km) = equal_scales(places.flat_map(|(_, places)| places), map);
        let inside = |at: &MapPoint| east.contains(&at.0) && north.contains(&at.1);
        let title = match self.about {
            Some(number) => format!("System track {number}, its surroundings, and their reports"),
            None => format!("{} system tracks, and their reports", self.tracks_km.len()),
        };
        let mut chart = map_chart(area, &title, &east, &north)?;
        for (place, (source, reports)) in self.reports_km.iter().enumerate() {
            let colour = SENSORS[place % SENSORS.len()];
            let id = sensor_ids.get(usize::from(*source)).copied().unwrap_or_default();
            let dots = one_a_pixel(reports.iter().copied().filter(inside), 2.0 * pixel_km);
            chart
                .draw_series(dots.into_iter().map(|at| Circle::new(at, 2, colour.mix(0.5).filled())))?
                .label(format!("sensor {id}"))
                .legend(move |(x, y)| Circle::new((x + 12, y), 3, colour.filled()));
        }
        let mut label = Some("system track");
        let parts = self.tracks_km.values().flat_map(|track| track.split(|at| !inside(at)));
        for part in parts.filter(|part| part.len() > 1) {
            let drawn = chart.draw_series(LineSeries::new(thinned(part, pixel_km), SYSTEM))?;
            if let Some(label) = label.take() {
                drawn
                    .label(label)
                    .legend(|(x, y)| PathElement::new(vec![(x, y), (x + 24, y)], SYSTEM));
            }
        }
        draw_legend(&mut chart)
    }
}

fn kilometres(position_m: &[f64; 3]) -> MapPoint {
    (position_m[0] * 1e-3, position_m[1] * 1e-3)
}

/// Keeps a single place in each square of `size_km`.
fn one_a_pixel(places: impl Iterator<Item = MapPoint>, size_km: f64) -> Vec<MapPoint> {
    let mut taken = BTreeSet::new();
    let square = |place: &MapPoint| ((place.0 / size_km) as i64, (place.1 / size_km) as i64);
    places.filter(|place| taken.insert(square(place))).collect()
}

/// Thins a line: drops points nearer than `pixel_km` to the previous point, but not the last point.
fn thinned(line: &[MapPoint], pixel_km: f64) -> Vec<MapPoint> {
    let mut thin: Vec<MapPoint> = Vec::new();
    for (number, at) in line.iter().enumerate() {
        let is_far = thin
            .last()
            .is_none_or(|last| (last.0 - at.0).hypot(last.1 - at.1) >= pixel_km);
        if is_far || number + 1 == line.len() {
            thin.push(*at);
        }
    }
    thin
}
