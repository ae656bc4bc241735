//! Picture of latency against percentile, for floor, pipeline and the machine itself.
//!
//! The axis of percentiles has as much room for 99 to 99.9 % as for 90 to 99 %, because the tail matters most.

use std::path::Path;

use anyhow::anyhow;
use hdrhistogram::Histogram;
use plotters::prelude::*;
use telemetry::table::{count, duration};

use crate::distributions::Distributions;

const SIZE: (u32, u32) = (960, 600);
/// Sizes in pixels: margin around the picture, width of the vertical axis, and of the legend beside the plot.
const MARGIN: u32 = 16;
const AXIS_WIDTH: u32 = 80;
const LEGEND_WIDTH: u32 = 160;
/// Legend in pixels: position of its first line, line spacing, length of a stroke, and gap between stroke and text.
const LEGEND_TOP: i32 = 60;
const LEGEND_LINE: usize = 22;
const LEGEND_STROKE: i32 = 24;
const LEGEND_GAP: i32 = 8;
/// Values per curve: finer than visible.
const STEPS: u32 = 10;

/// Writes the picture as SVG.
///
/// # Errors
/// If the file cannot be written.
pub(crate) fn write(path: &Path, of: &Distributions) -> anyhow::Result<()> {
    let curves = [
        ("machine alone", &of.jitter.lateness, RGBColor(140, 140, 140)),
        ("bare relay", &of.floor, RGBColor(31, 119, 180)),
        ("pipeline", &of.pipeline, RGBColor(214, 39, 40)),
    ];
    draw(path, of, &curves).map_err(|error| anyhow!("--picture {}: {error}", path.display()))
}

fn draw(
    path: &Path,
    of: &Distributions,
    curves: &[(&str, &Histogram<u64>, RGBColor)],
) -> Result<(), Box<dyn std::error::Error>> {
    let root = SVGBackend::new(path, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let all = || {
        curves
            .iter()
            .map(|(_, histogram, _)| *histogram)
            .filter(|histogram| !histogram.is_empty())
    };
    let low_us = all()
        .map(|histogram| histogram.min().max(10) as f64 * 1e-3)
        .fold(f64::INFINITY, f64::min);
    let high_us = all().map(|histogram| histogram.max() as f64 * 1e-3).fold(1.0, f64::max);
    let last = all()
        .map(|histogram| nines(1.0 - 1.0 / histogram.len().max(2) as f64))
        .fold(1.0, f64::max);
    let mut title = format!(
        "Latency from the intended time, {} reports/s",
        count(of.rate_per_s as u64)
    );
    if of.unanswered > 0 {
        let share = 100.0 * of.unanswered as f64 / of.sent.max(1) as f64;
        title += &format!("; {} ({share:.1} %) unanswered, in no curve", count(of.unanswered));
    }
    let mut chart = ChartBuilder::on(&root)
        .caption(title, ("sans-serif", 20))
        .margin(MARGIN)
        .margin_right(LEGEND_WIDTH)
        .x_label_area_size(48)
        .y_label_area_size(AXIS_WIDTH)
        .build_cartesian_2d(0.0..last, (low_us.min(high_us) * 0.8..high_us * 1.25).log_scale())?;
    chart
        .configure_mesh()
        .x_desc("percentile")
        .y_desc("latency")
        .x_labels(last.ceil() as usize + 1)
        .x_label_formatter(&|nines| percentile(*nines))
        .y_label_formatter(&|us| duration(*us * 1e3))
        .light_line_style(RGBColor(235, 235, 235))
        .draw()?;
    for (_, histogram, colour) in curves {
        let colour = *colour;
        chart.draw_series(LineSeries::new(points(histogram), colour.stroke_width(2)))?;
    }
    // The legend is beside the plot, because curves may lie anywhere in the plot.
    for ((name, _, colour), y) in curves.iter().zip((LEGEND_TOP..).step_by(LEGEND_LINE)) {
        let x = (SIZE.0 - LEGEND_WIDTH) as i32 + LEGEND_GAP;
        root.draw(&PathElement::new(
            vec![(x, y), (x + LEGEND_STROKE, y)],
            colour.stroke_width(2),
        ))?;
        let text = (x + LEGEND_STROKE + LEGEND_GAP, y - LEGEND_GAP);
        root.draw(&Text::new(*name, text, ("sans-serif", 14)))?;
    }
    root.present()?;
    Ok(())
}

/// Converts a histogram to points (nines, microseconds).
fn points(histogram: &Histogram<u64>) -> Vec<(f64, f64)> {
    let end = nines(1.0 - 1.0 / histogram.len().max(2) as f64);
    let steps = histogram.iter_quantiles(STEPS);
    let point = |quantile: f64, value: u64| (nines(quantile).min(end), value.max(1) as f64 * 1e-3);
    steps
        .map(|step| point(step.quantile_iterated_to(), step.value_iterated_to()))
        .collect()
}

/// Returns the number of nines of a quantile: 0.9 has one, 0.99 two.
fn nines(quantile: f64) -> f64 {
    -(1.0 - quantile).max(1e-12).log10()
}

/// Formats a number of nines as a percentage: `99.9%` for three nines.
fn percentile(nines: f64) -> String {
    let decimals = (nines.round() as usize).saturating_sub(2);
    format!("{:.decimals$}%", 100.0 * (1.0 - 10f64.powf(-nines)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recorder::histogram;

    #[test]
    fn the_axis_counts_nines() {
        assert!((nines(0.99) - 2.0).abs() < 1e-9 && nines(0.0) == 0.0);
        let labels = [0.0, 1.0, 2.0, 3.0, 4.0].map(percentile);
        assert_eq!(labels, ["0%", "90%", "99%", "99.9%", "99.99%"]);
    }

    #[test]
    fn a_picture_has_a_line_for_each_curve() {
        let mut of = Distributions::new(1000.0);
        for value in 1..=10_000u64 {
            of.floor.saturating_record(value);
            of.pipeline.saturating_record(10 * value);
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.svg");
        write(&path, &of).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        for word in [
            "<svg",
            "bare relay",
            "pipeline",
            "machine alone",
            "99.9%",
            "1,000 reports/s",
        ] {
            assert!(text.contains(word), "{word}");
        }
        assert!(!text.contains("unanswered"), "all were answered");
        (of.sent, of.unanswered) = (40_000, 16_059);
        write(&path, &of).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains("16,059 (40.1 %) unanswered"), "{text}");
        // An empty recording must not fail.
        assert!(histogram().is_empty());
        write(&path, &Distributions::new(1.0)).unwrap();
    }
}
