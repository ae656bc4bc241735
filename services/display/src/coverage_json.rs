//! Coverage of the sources as JSON for the page, and as GeoJSON for other programs.

use std::f64::consts::TAU;

use frames::SystemFrame;
use serde_json::{Value, json};

use crate::coverage::{RING_M, SECTORS};
use crate::details::seconds;
use crate::world::World;

/// Returns the coverage for the page: `since_s`, `sectors`, `ring_m`, and `sources` [{`number`, `name`, `site_m`,
/// `cells` [[sector, ring, seen, hits, tries]]}].
pub(crate) fn coverage(world: &World) -> Value {
    let sources = world.sources.iter().map(|fact| {
        let source = &fact.source;
        let cells = world.coverage.cells(usize::from(source.number));
        let cells: Vec<Value> = cells
            .map(|(sector, ring, cell)| json!([sector, ring, cell.seen, cell.hits, cell.tries]))
            .collect();
        json!({"number": source.number, "name": source.name, "site_m": site_m(fact.site_m), "cells": cells})
    });
    json!({
        "since_s": world.coverage.since_ns.map(seconds),
        "sectors": SECTORS,
        "ring_m": RING_M,
        "sources": sources.collect::<Vec<_>>(),
    })
}

fn site_m(site_m: Option<[f64; 2]>) -> [f64; 2] {
    site_m.unwrap_or_default()
}

/// Returns the coverage as GeoJSON: a polygon per cell, with the counts and colours by probability (simplestyle).
pub(crate) fn geojson(world: &World) -> Value {
    let mut features = Vec::new();
    if let Some(frame) = world.observed.frame() {
        for fact in &world.sources {
            let cells = world.coverage.cells(usize::from(fact.source.number));
            features.extend(cells.map(|(sector, ring, cell)| {
                let probability = cell.probability();
                json!({
                    "type": "Feature",
                    "geometry": {"type": "Polygon", "coordinates": [outline(frame, site_m(fact.site_m), sector, ring)]},
                    "properties": {
                        "source": fact.source.name,
                        "azimuth_deg": [sector * 360 / SECTORS, (sector + 1) * 360 / SECTORS],
                        "range_m": [ring as f64 * RING_M, (ring + 1) as f64 * RING_M],
                        "seen": cell.seen,
                        "hits": cell.hits,
                        "tries": cell.tries,
                        "detection_probability": probability,
                        "fill": fill(probability),
                        "fill-opacity": 0.4,
                        "stroke-width": 0,
                    },
                })
            }));
        }
    }
    json!({"type": "FeatureCollection", "features": features})
}

/// Returns the closed outline of a cell, degrees of longitude and latitude.
fn outline(frame: &SystemFrame, [east_m, north_m]: [f64; 2], sector: usize, ring: usize) -> Vec<[f64; 2]> {
    let corner = |sector: usize, ring: usize| {
        let (sin, cos) = (sector as f64 / SECTORS as f64 * TAU).sin_cos();
        let range_m = ring as f64 * RING_M;
        let place = frame.to_geodetic([east_m + range_m * sin, north_m + range_m * cos, 0.0]);
        [place.longitude_deg(), place.latitude_deg()]
    };
    let first = corner(sector, ring);
    let corners = [(sector, ring + 1), (sector + 1, ring + 1), (sector + 1, ring)];
    let others = corners.map(|(sector, ring)| corner(sector, ring));
    [first]
        .into_iter()
        .chain(others)
        .rev()
        .chain([corner(sector + 1, ring)])
        .collect()
}

fn fill(probability: Option<f32>) -> &'static str {
    match probability {
        None => "#8090a0",
        Some(0.9..) => "#2e9e57",
        Some(0.7..) => "#c9b22c",
        Some(0.4..) => "#d97a26",
        Some(_) => "#c0392b",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_is_a_closed_polygon_about_its_site() {
        let frame = SystemFrame::at(frames::Geodetic::from_degrees(41.0, 2.0, 0.0).unwrap());
        let outline = outline(&frame, [0.0, 0.0], 0, 2);
        assert_eq!((outline.len(), outline[0]), (5, outline[4]));
        let latitudes: Vec<f64> = outline.iter().map(|[_, latitude]| *latitude).collect();
        assert!(
            latitudes.iter().all(|latitude| (41.17..41.28).contains(latitude)),
            "{latitudes:?}"
        );
        // Counterclockwise, as GeoJSON asks of outer rings.
        let area: f64 = outline
            .windows(2)
            .map(|pair| pair[0][0] * pair[1][1] - pair[1][0] * pair[0][1])
            .sum();
        assert!(area > 0.0);
    }
}
