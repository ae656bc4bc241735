//! Maps as pictures (SVG): the same scale for both axes.

use std::error::Error;
use std::io::Write as _;
use std::ops::Range;

use anyhow::anyhow;
use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use crate::files::OutputFile;

/// Margin around the places, as a share of the extent.
const ROOM: f64 = 0.06;
/// Extent of coinciding places.
const EXTENT_MIN: f64 = 1e-3;

/// Drawing area.
pub(crate) type Drawing<'a> = DrawingArea<SVGBackend<'a>, Shift>;
/// Result of drawing.
pub(crate) type Drawn = Result<(), Box<dyn Error>>;

/// A chart of places, east and north in kilometres.
pub(crate) type MapChart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// Writes a picture of `size` pixels, drawn by `draw`, into `file`.
pub(crate) fn picture(
    mut file: OutputFile,
    size: (u32, u32),
    draw: impl FnOnce(&Drawing<'_>) -> Drawn,
) -> anyhow::Result<()> {
    let mut svg = String::new();
    drawn(&mut svg, size, draw).map_err(|error| anyhow!("--picture {}: {error}", file.path().display()))?;
    file.write_all(svg.as_bytes())?;
    file.finish()
}

fn drawn(svg: &mut String, size: (u32, u32), draw: impl FnOnce(&Drawing<'_>) -> Drawn) -> Drawn {
    let root = SVGBackend::with_string(svg, size).into_drawing_area();
    root.fill(&WHITE)?;
    draw(&root)?;
    root.present()?;
    Ok(())
}

/// Begins a chart with axes in `east` and `north`, kilometres.
pub(crate) fn map_chart<'a, 'b>(
    area: &'a Drawing<'b>,
    title: &str,
    east: &Range<f64>,
    north: &Range<f64>,
) -> Result<MapChart<'a, 'b>, Box<dyn Error>> {
    let mut chart = ChartBuilder::on(area)
        .caption(title, ("sans-serif", 20))
        .margin(16)
        .x_label_area_size(40)
        .y_label_area_size(60)
        .build_cartesian_2d(east.clone(), north.clone())?;
    chart
        .configure_mesh()
        .x_desc("east, km")
        .y_desc("north, km")
        .light_line_style(RGBColor(235, 235, 235))
        .draw()?;
    Ok(chart)
}

/// Ends a chart with the legend.
pub(crate) fn draw_legend<'a, 'b: 'a>(chart: &mut MapChart<'a, 'b>) -> Drawn {
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .background_style(WHITE.mix(0.8))
        .border_style(BLACK.mix(0.3))
        .draw()?;
    Ok(())
}

/// Returns ranges of both axes that show all `places` on this number of pixels, and the size of a pixel.
pub(crate) fn equal_scales<'a>(
    places: impl Iterator<Item = &'a (f64, f64)> + Clone,
    pixels: (u32, u32),
) -> (Range<f64>, Range<f64>, f64) {
    let (east, north) = (range(places.clone().map(|at| at.0)), range(places.map(|at| at.1)));
    let (width, height) = (f64::from(pixels.0), f64::from(pixels.1));
    let scale = ((east.end - east.start) / width).max((north.end - north.start) / height);
    (widened(east, scale * width), widened(north, scale * height), scale)
}

/// Returns the range of the values, with a margin.
pub(crate) fn range(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    let room = ROOM * (high - low).max(EXTENT_MIN);
    low - room..high + room
}

/// Returns the range of this length about the same middle.
fn widened(range: Range<f64>, length: f64) -> Range<f64> {
    let middle = 0.5 * (range.start + range.end);
    middle - 0.5 * length..middle + 0.5 * length
}
