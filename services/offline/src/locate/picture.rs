//! Fixes of an emitter as a picture: the platform's path, the filter's estimates, and the outputs.

use anyhow::bail;
use locating::EmitterReport;
use observations::Bearing;
use plotters::prelude::*;

use crate::files::OutputFile;
use crate::picture::{Drawing, Drawn, draw_legend, equal_scales, map_chart, picture, range};

const SIZE: (u32, u32) = (960, 1040);
/// Height of the map in the picture, pixels.
const MAP_HEIGHT: u32 = 680;
const PLATFORM: RGBColor = RGBColor(170, 170, 170);
const RAW: RGBColor = RGBColor(31, 119, 180);
const OUTPUT: RGBColor = RGBColor(214, 39, 40);
/// Pixels beside the map: axes, labels and margins.
const ASIDE: u32 = 110;

/// Paths drawn for an emitter.
#[derive(Debug, Default)]
pub(super) struct Paths {
    /// Number of the emitter; without an argument, the emitter of the first fix.
    emitter: Option<u32>,
    platform_km: Vec<(f64, f64)>,
    raw_km: Vec<(f64, f64)>,
    output_km: Vec<(f64, f64)>,
    /// Time and standard deviation of the position.
    sigma_m: Vec<(f64, f64)>,
    /// Positions of selections.
    selected_km: Vec<(f64, f64)>,
}

impl Paths {
    pub(super) fn new(emitter: Option<u32>) -> Self {
        Self {
            emitter,
            ..Self::default()
        }
    }

    /// Adds the bearing, if the report has a bearing, and the resulting report.
    pub(super) fn take(&mut self, bearing: Option<&Bearing>, report: Option<&EmitterReport>) {
        let of_bearing = bearing.and_then(|bearing| bearing.emitter_id);
        let number = report.map(|report| report.number).or(of_bearing);
        if self.emitter.is_none() {
            self.emitter = number;
        }
        if self.emitter.is_none() || self.emitter != number {
            return;
        }
        let km = |[east, north, _]: [f64; 3]| (east * 1e-3, north * 1e-3);
        self.platform_km.extend(bearing.map(|bearing| km(bearing.platform_m)));
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

    /// Draws the picture as SVG.
    ///
    /// # Errors
    /// If there is nothing to draw, or the file cannot be written.
    pub(super) fn draw(&self, file: OutputFile) -> anyhow::Result<()> {
        if self.raw_km.is_empty() {
            let what = match self.emitter {
                Some(emitter) => format!("emitter {emitter} has no fix"),
                None => "no emitter has a fix".to_owned(),
            };
            bail!("--picture {}: {what}", file.path().display());
        }
        picture(file, SIZE, |root| {
            let (map, below) = root.split_vertically(MAP_HEIGHT);
            self.draw_map(&map)?;
            self.draw_sigma(&below)
        })
    }

    fn draw_map(&self, area: &Drawing<'_>) -> Drawn {
        // The platform's path is drawn only near the fixes.
        let fixes = self.raw_km.iter().chain(&self.output_km);
        let (east, north, _) = equal_scales(fixes, (SIZE.0 - ASIDE, MAP_HEIGHT - ASIDE));
        let title = format!("Emitter {} located", self.emitter.unwrap_or_default());
        let mut chart = map_chart(area, &title, &east, &north)?;
        let inside = |at: &(f64, f64)| east.contains(&at.0) && north.contains(&at.1);
        let parts = self.platform_km.split(|at| !inside(at)).filter(|part| part.len() > 1);
        for (index, part) in parts.enumerate() {
            let drawn = chart.draw_series(LineSeries::new(part.iter().copied(), PLATFORM))?;
            if index == 0 {
                drawn
                    .label("platform")
                    .legend(|(x, y)| PathElement::new(vec![(x, y), (x + 24, y)], PLATFORM));
            }
        }
        let paths = [
            ("fixes of the filter", &self.raw_km, RAW, 1),
            ("output", &self.output_km, OUTPUT, 2),
        ];
        for (name, path, colour, width) in paths {
            chart
                .draw_series(LineSeries::new(path.iter().copied(), colour.stroke_width(width)))?
                .label(name)
                .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 24, y)], colour.stroke_width(width)));
        }
        let selected = self.selected_km.iter().map(|at| Circle::new(*at, 4, OUTPUT.filled()));
        chart
            .draw_series(selected)?
            .label("selected fixes")
            .legend(|(x, y)| Circle::new((x + 12, y), 4, OUTPUT.filled()));
        draw_legend(&mut chart)
    }

    fn draw_sigma(&self, area: &Drawing<'_>) -> Drawn {
        let time = range(self.sigma_m.iter().map(|at| at.0));
        // A logarithmic axis that spans the values: a wider axis would be mostly empty.
        let sigma = self.sigma_m.iter().map(|at| at.1).filter(|sigma_m| *sigma_m > 0.0);
        let low_m = sigma.clone().fold(f64::INFINITY, f64::min).min(1e6);
        let sigma = 0.9 * low_m..1.1 * sigma.fold(low_m, f64::max);
        let mut chart = ChartBuilder::on(area)
            .caption(
                "Standard deviation of the filter's fixes: root of the variance value",
                ("sans-serif", 16),
            )
            .margin(16)
            .x_label_area_size(40)
            .y_label_area_size(60)
            .build_cartesian_2d(time, sigma.log_scale())?;
        chart
            .configure_mesh()
            .x_desc("time, s")
            .y_desc("standard deviation, m")
            .light_line_style(RGBColor(235, 235, 235))
            .draw()?;
        chart.draw_series(LineSeries::new(self.sigma_m.iter().copied(), RAW))?;
        Ok(())
    }
}
