//! Resolution: merges detections of a scan nearer to each other than the sensor's resolution.
//!
//! A lidar detects two ends of a hull, and a tracker with at most one detection per target and scan makes the second
//! end a second target. Operators know the size of targets, or the resolution of a sensor. Detections of a scan within
//! this distance become a single detection at the mean position, with the errors of a single detection, because the
//! unknown place of the reflections on the hull is an error common to all.
//!
//! Detections are taken in the order of places, from west to east; a detection near enough to the mean of detections
//! already taken is merged with these. So the result does not depend on the order of arrival. At most [`COMPARED_MAX`]
//! means are compared for each detection; with more within reach, detections stay apart.

use observations::DetectionKind;

use crate::plot::Plot;

/// Most means with which a detection is compared.
const COMPARED_MAX: usize = 64;

/// Unites detections of positions nearer than `resolution_m` in the plane; `sizes` is working memory of as many places.
/// Returns how many have gone into others.
pub(crate) fn unite(plots: &mut Vec<Plot>, resolution_m: f64, sizes: &mut [u32]) -> usize {
    let place = |plot: &Plot| plot.measurement.place().map_or([f64::INFINITY; 2], |(place, _)| place);
    plots.sort_unstable_by(|one, other| {
        let (one, other) = (key(one, place(one)), key(other, place(other)));
        one.partial_cmp(&other).unwrap_or(std::cmp::Ordering::Equal)
    });
    let before = plots.len();
    let mut kept = 0;
    for taken in 0..before {
        let plot = plots[taken];
        let [east, north] = place(&plot);
        let compared = plots[..kept].iter().rev().take(COMPARED_MAX);
        let near = compared.enumerate().find(|(_, mean)| {
            let [other_east, other_north] = place(mean);
            let apart = (east - other_east).hypot(north - other_north);
            apart < resolution_m && may_unite(mean, &plot)
        });
        match near {
            Some((back, _)) => {
                let place = kept - 1 - back;
                sizes[place] += 1;
                take_in(&mut plots[place], &plot, 1.0 / f64::from(sizes[place]));
            }
            None => {
                plots[kept] = plot;
                sizes[kept] = 1;
                kept += 1;
            }
        }
    }
    plots.truncate(kept);
    before - kept
}

/// A total order of all that is measured.
fn key(plot: &Plot, [east, north]: [f64; 2]) -> (f64, f64, i64, [f64; 3], Option<f64>) {
    let measurement = &plot.measurement;
    (
        east,
        north,
        plot.time_ns,
        measurement.values,
        measurement.range_rate_mps,
    )
}

/// Whether both are of the same kind, from the same place.
fn may_unite(one: &Plot, other: &Plot) -> bool {
    let (one, other) = (&one.measurement, &other.measurement);
    let rates = one.range_rate_mps.is_some() == other.range_rate_mps.is_some();
    one.kind == other.kind && one.platform_m == other.platform_m && rates
}

/// Moves a mean by `share` of the way to another detection.
fn take_in(mean: &mut Plot, plot: &Plot, share: f64) {
    mean.identity.unite(&plot.identity);
    let (mean, measured) = (&mut mean.measurement, &plot.measurement);
    let has_bearing = matches!(
        mean.kind,
        DetectionKind::RangeBearing | DetectionKind::RangeBearingElevation
    );
    for (number, (value, other)) in mean.values.iter_mut().zip(measured.values).enumerate() {
        let mut difference = other - *value;
        if has_bearing && number == 1 {
            difference = (difference + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI;
        }
        *value += share * difference;
    }
    if let (Some(rate), Some(other)) = (&mut mean.range_rate_mps, measured.range_rate_mps) {
        *rate += share * (other - *rate);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identity::PlotIdentity;
    use crate::measurement::DetectionMeasurement;
    use crate::testing::position;

    fn plots(places: &[[f64; 2]]) -> Vec<Plot> {
        let plot = |[east, north]: &[f64; 2]| Plot {
            time_ns: 0,
            detection_id: 0,
            log_weight: 0.0,
            identity: PlotIdentity::NONE,
            velocity: None,
            measurement: DetectionMeasurement::of(&position(0, *east, *north), None).unwrap(),
        };
        places.iter().map(plot).collect()
    }

    fn united(places: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let mut plots = plots(places);
        let gone = unite(&mut plots, 10.0, &mut vec![0; places.len()]);
        assert_eq!(plots.len() + gone, places.len());
        plots.iter().map(|plot| plot.measurement.place().unwrap().0).collect()
    }

    #[test]
    fn what_is_near_becomes_one_in_any_order() {
        let places = [[0.0, 0.0], [6.0, 0.0], [100.0, 50.0], [0.0, 100.0], [3.0, 6.0]];
        let expected: [[f64; 2]; 3] = [[3.0, 2.0], [0.0, 100.0], [100.0, 50.0]];
        let mut found = united(&places);
        found.sort_by(|one, other| one[1].total_cmp(&other[1]));
        let mut sorted = expected;
        sorted.sort_by(|one, other| one[1].total_cmp(&other[1]));
        assert_eq!(found, sorted);
        let turned: Vec<_> = places.iter().rev().copied().collect();
        assert_eq!(united(&places), united(&turned));
        assert_eq!(united(&[[0.0, 0.0], [10.0, 0.0]]).len(), 2, "just resolved");
    }

    #[test]
    fn thousands_in_one_place_are_one_and_directions_stay() {
        assert_eq!(united(&vec![[5.0, 5.0]; 10_000]), [[5.0, 5.0]]);
        let bearing = DetectionMeasurement {
            kind: DetectionKind::Bearing,
            values: [0.5, 0.0, 0.0],
            range_rate_mps: None,
            sigmas: [0.01; 4],
            platform_m: [0.0; 3],
        };
        let mut directions = vec![
            Plot {
                time_ns: 0,
                detection_id: 0,
                log_weight: 0.0,
                measurement: bearing,
                identity: PlotIdentity::NONE,
                velocity: None,
            };
            3
        ];
        assert_eq!(unite(&mut directions, 10.0, &mut [0; 3]), 0);
        assert_eq!(directions.len(), 3);
    }

    #[test]
    fn bearings_are_averaged_across_the_south() {
        let plot = |bearing: f64| Plot {
            time_ns: 0,
            detection_id: 0,
            log_weight: 0.0,
            identity: PlotIdentity::NONE,
            velocity: None,
            measurement: DetectionMeasurement {
                kind: DetectionKind::RangeBearing,
                values: [100.0, bearing, 0.0],
                range_rate_mps: Some(2.0),
                sigmas: [1.0, 0.01, 0.0, 1.0],
                platform_m: [0.0; 3],
            },
        };
        let mut two = vec![plot(3.13), plot(-3.13)];
        assert_eq!(unite(&mut two, 10.0, &mut [0; 2]), 1);
        let [east, north] = two[0].measurement.place().unwrap().0;
        assert!(east.abs() < 1e-9 && (north + 100.0).abs() < 1e-9, "{east} {north}");
    }
}
