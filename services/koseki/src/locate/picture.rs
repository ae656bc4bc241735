//! One emitter's fixes as a picture: where the platform flew, what the filter said, and what was put out.

use std::path::Path;

use anyhow::anyhow;
use locating::EmitterReport;
use observations::Bearing;
use plotters::prelude::*;

use crate::picture::{Drawing, Drawn, draw_legend, equal_scales, map_chart, picture, range};

const SIZE: (u32, u32) = (960, 1040);
/// Share of the picture for the map, in pixels.
const MAP_HEIGHT: u32 = 680;
const PLATFORM: RGBColor = RGBColor(170, 170, 170);
const RAW: RGBColor = RGBColor(31, 119, 180);
const OUTPUT: RGBColor = RGBColor(214, 39, 40);
/// Pixels beside the map: axes, their labels and margins.
const ASIDE: u32 = 110;

/// Paths that are drawn of an emitter.
#[derive(Debug, Default)]
pub(super) struct Paths {
    /// Number of the emitter; that of the first fix if nobody said.
    emitter: Option<u32>,
    platform_km: Vec<(f64, f64)>,
    raw_km: Vec<(f64, f64)>,
    output_km: Vec<(f64, f64)>,
    /// Time and standard deviation of the position.
    sigma_m: Vec<(f64, f64)>,
    /// Places at which selections were made.
    selected_km: Vec<(f64, f64)>,
}

impl Paths {
    pub(super) fn new(emitter: Option<u32>) -> Self {
        Self {
            emitter,
            ..Self::default()
        }
    }

    /// Takes a bearing, and what came of it.
    pub(super) fn take(&mut self, bearing: &Bearing, report: Option<&EmitterReport>) {
        let number = report.map(|report| report.number).or(bearing.emitter_id);
        if self.emitter.is_none() {
            self.emitter = number;
        }
        if self.emitter.is_none() || self.emitter != number {
            return;
        }
        let km = |[east, north, _]: [f64; 3]| (east * 1e-3, north * 1e-3);
        self.platform_km.push(km(bearing.platform_m));
        let Some(report) = report else { return };
        let [east, north] = report.raw.position_m;
        self.raw_km.push(km([east, north, 0.0]));
        self.output_km.push(km(report.output.position_m));
        let time_s = frames::time::seconds(report.time_ns);
        self.sigma_m.push((time_s, report.raw.variance_m2().sqrt()));
        if report.output.is_selected && report.output.decision.is_some() {
            self.selected_km.push(km(report.output.position_m));
        }
    }

    /// Draws it as SVG.
    ///
    /// # Errors
    /// If there is nothing to draw, or the file cannot be written.
    pub(super) fn draw(&self, file: &Path) -> anyhow::Result<()> {
        if self.raw_km.is_empty() {
            let what = match self.emitter {
                Some(emitter) => format!("emitter {emitter} has no fix"),
                None => "no emitter has a fix".to_owned(),
            };
            return Err(anyhow!("--picture {}: {what}", file.display()));
        }
        let drawn = picture(file, SIZE, |root| {
            let (map, below) = root.split_vertically(MAP_HEIGHT);
            self.draw_map(&map)?;
            self.draw_sigma(&below)
        });
        drawn.map_err(|error| anyhow!("--picture {}: {error}", file.display()))
    }

    fn draw_map(&self, area: &Drawing<'_>) -> Drawn {
        // The platform is drawn as far as it comes near.
        let fixes = self.raw_km.iter().chain(&self.output_km);
        let (east, north, _) = equal_scales(fixes, (SIZE.0 - ASIDE, MAP_HEIGHT - ASIDE));
        let title = format!("Emitter {}: fixes and output", self.emitter.unwrap_or_default());
        let mut chart = map_chart(area, &title, &east, &north)?;
        let inside = |at: &(f64, f64)| east.contains(&at.0) && north.contains(&at.1);
        let parts = self.platform_km.split(|at| !inside(at)).filter(|part| part.len() > 1);
        for part in parts {
            chart.draw_series(LineSeries::new(part.iter().copied(), PLATFORM))?;
        }
        for (name, path, colour, width) in [("filter", &self.raw_km, RAW, 1), ("output", &self.output_km, OUTPUT, 2)] {
            chart
                .draw_series(LineSeries::new(path.iter().copied(), colour.stroke_width(width)))?
                .label(name)
                .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 24, y)], colour.stroke_width(width)));
        }
        chart.draw_series(self.selected_km.iter().map(|at| Circle::new(*at, 4, OUTPUT.filled())))?;
        draw_legend(&mut chart)
    }

    fn draw_sigma(&self, area: &Drawing<'_>) -> Drawn {
        let time = range(self.sigma_m.iter().map(|at| at.0));
        let sigma = range(self.sigma_m.iter().map(|at| at.1));
        let mut chart = ChartBuilder::on(area)
            .caption("Root of the variance value", ("sans-serif", 16))
            .margin(16)
            .x_label_area_size(40)
            .y_label_area_size(60)
            .build_cartesian_2d(time, (sigma.start.max(0.1) * 0.9..sigma.end.max(0.2) * 1.1).log_scale())?;
        chart
            .configure_mesh()
            .x_desc("time, s")
            .y_desc("m")
            .light_line_style(RGBColor(235, 235, 235))
            .draw()?;
        chart.draw_series(LineSeries::new(self.sigma_m.iter().copied(), RAW))?;
        Ok(())
    }
}
