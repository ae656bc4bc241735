//! Maps as pictures (SVG): the same scale for both axes.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::prelude::{DrawingArea, SVGBackend};

/// Room around the places, as a share of their extent.
const ROOM: f64 = 0.06;
/// Extent of places that are all one.
const EXTENT_MIN: f64 = 1e-3;

/// An area that is drawn on.
pub(crate) type Drawing<'a> = DrawingArea<SVGBackend<'a>, Shift>;
/// Result of drawing.
pub(crate) type Drawn = Result<(), Box<dyn std::error::Error>>;

/// Ranges of both axes that show all `places` on so many pixels, and how much of them a pixel is.
pub(crate) fn equal_scales<'a>(
    places: impl Iterator<Item = &'a (f64, f64)> + Clone,
    pixels: (u32, u32),
) -> (Range<f64>, Range<f64>, f64) {
    let (east, north) = (range(places.clone().map(|at| at.0)), range(places.map(|at| at.1)));
    let (width, height) = (f64::from(pixels.0), f64::from(pixels.1));
    let scale = ((east.end - east.start) / width).max((north.end - north.start) / height);
    (widened(east, scale * width), widened(north, scale * height), scale)
}

/// Least and greatest, with room around them.
pub(crate) fn range(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    let room = ROOM * (high - low).max(EXTENT_MIN);
    low - room..high + room
}

/// The range of this length about the same middle.
fn widened(range: Range<f64>, length: f64) -> Range<f64> {
    let middle = 0.5 * (range.start + range.end);
    middle - 0.5 * length..middle + 0.5 * length
}
