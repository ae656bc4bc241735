//! Pressure altitude and height: two quantities, and the difference between both by region.
//!
//! Transponders state a pressure altitude, receivers of satellite navigation a height above the ellipsoid. The weather
//! separates both by up to some hundred metres, alike for all aircraft of a region and a layer of height. Reports with
//! both teach the difference per cell of [`CELL_M`] and layer of [`LAYER_M`]; without enough samples in a cell, the
//! mean of the layer serves. Fusion itself works with the heights of positions, and only publishes the difference.
//!
//! Each difference counts up to three standard deviations, so that a wrong altimeter moves the mean little.

use association::floor;
use serde::{Deserialize, Serialize};

/// Side of a cell, metres: the pressure at sea level changes by about 1 hPa (8 m) over this distance.
const CELL_M: f64 = 100e3;
/// Height of a layer, metres: a day 10 °C too warm adds 70 m per layer.
const LAYER_M: f64 = 2_000.0;
const LAYERS: usize = 10;
/// Number of cells in the table, and number of places tried per cell.
const CELLS: usize = 512;
const PROBES: usize = 8;
/// Differences before a mean is used, and least weight of a difference.
const SAMPLES_MIN: u32 = 16;
const GAIN_MIN: f64 = 1.0 / 256.0;
/// Prior standard deviation of altimeters, metres; bound of a difference in standard deviations; largest difference
/// explained by weather, metres.
const SIGMA_M: f64 = 40.0;
const SIGMAS_MAX: f64 = 3.0;
const DIFFERENCE_MAX_M: f64 = 1_500.0;
/// Mean radius of the earth, metres.
const EARTH_M: f64 = 6.371e6;

/// Mean difference and its scatter.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Mean {
    mean_m: f64,
    variance_m2: f64,
    samples: u32,
}

impl Mean {
    fn add(&mut self, difference_m: f64) {
        if self.samples == 0 {
            (self.mean_m, self.variance_m2) = (difference_m, SIGMA_M * SIGMA_M);
        }
        self.samples = self.samples.saturating_add(1);
        let gain = (1.0 / f64::from(self.samples)).max(GAIN_MIN);
        let bound_m = SIGMAS_MAX * self.variance_m2.sqrt();
        let rest_m = (difference_m - self.mean_m).clamp(-bound_m, bound_m);
        self.mean_m += gain * rest_m;
        self.variance_m2 += gain.min(0.5) * (rest_m * rest_m - self.variance_m2);
        self.variance_m2 = self.variance_m2.max(1.0);
    }

    /// Mean and standard deviation, metres; `None` while too little is known.
    fn known(&self) -> Option<[f64; 2]> {
        (self.samples >= SAMPLES_MIN).then(|| [self.mean_m, self.variance_m2.sqrt()])
    }
}

/// Column, row and layer of a cell.
type CellKey = (i16, i16, u8);

/// Differences of pressure altitude and height, by region.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct PressureOffsets {
    cells: Vec<(CellKey, Mean)>,
    layers: [Mean; LAYERS],
}

impl PressureOffsets {
    pub(crate) fn new() -> Self {
        Self {
            cells: vec![((0, 0, 0), Mean::default()); CELLS],
            layers: [Mean::default(); LAYERS],
        }
    }

    /// Layer of a position.
    #[inline]
    fn layer([x, y, z]: [f64; 3]) -> usize {
        let height_m = z + (x * x + y * y) / (2.0 * EARTH_M);
        (height_m / LAYER_M).clamp(0.0, (LAYERS - 1) as f64) as usize
    }

    fn key(position_m: [f64; 3]) -> CellKey {
        let [x, y, _] = position_m;
        let cell = |value: f64| floor(value / CELL_M).clamp(i16::MIN.into(), i16::MAX.into()) as i16;
        (cell(x), cell(y), Self::layer(position_m) as u8)
    }

    /// Place of a cell, or the free place for the cell; `None` if other cells take all places.
    fn place(&self, key: CellKey) -> Option<usize> {
        let (column, row, layer) = key;
        let first = (i64::from(column) * 73 + i64::from(row) * 179 + i64::from(layer) * 29).rem_euclid(CELLS as i64);
        let places = (0..PROBES).map(|probe| (first as usize + probe) % CELLS);
        let mut fitting = places.filter(|place| {
            let (other, mean) = &self.cells[*place];
            mean.samples == 0 || *other == key
        });
        fitting.next()
    }

    /// Learns from a report at `position_m` (system frame) with a pressure altitude `difference_m` above its geometric
    /// height.
    pub(crate) fn learn(&mut self, position_m: [f64; 3], difference_m: f64) {
        // NaN is in no range.
        if !(-DIFFERENCE_MAX_M..=DIFFERENCE_MAX_M).contains(&difference_m) {
            return;
        }
        let key = Self::key(position_m);
        if let Some(place) = self.place(key) {
            let (own, mean) = &mut self.cells[place];
            *own = key;
            mean.add(difference_m);
        }
        self.layers[usize::from(key.2)].add(difference_m);
    }

    /// Pressure altitude less height at `position_m`, and its standard deviation for one aircraft, metres; `None`
    /// without enough samples.
    pub(crate) fn at(&self, position_m: [f64; 3]) -> Option<[f64; 2]> {
        let layer = &self.layers[Self::layer(position_m)];
        // Without any report of both there is no cell to look for.
        if layer.samples < SAMPLES_MIN {
            return None;
        }
        let cell = self.place(Self::key(position_m));
        let known = cell.and_then(|place| self.cells[place].1.known());
        known.or_else(|| layer.known())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_difference_is_that_of_the_region_and_the_layer() {
        let mut offsets = PressureOffsets::new();
        assert_eq!(offsets.at([0.0, 0.0, 10_500.0]), None);
        for step in 0..200 {
            let noise_m = 20.0 * f64::from(step % 5 - 2);
            offsets.learn([5e4, 5e4, 10_500.0], 300.0 + noise_m);
            offsets.learn([-5e4, 5e4, 10_500.0], 200.0 + noise_m);
            offsets.learn([5e4, 5e4, 900.0], 50.0 + noise_m);
        }
        for (place, expected_m) in [
            ([2e4, 9e4, 11_000.0], 300.0),
            ([-2e4, 9e4, 11_000.0], 200.0),
            ([2e4, 9e4, 100.0], 50.0),
            ([9e5, 9e5, 10_500.0 - 1.27e5], 250.0),
        ] {
            let [difference_m, sigma_m] = offsets.at(place).unwrap();
            assert!((difference_m - expected_m).abs() < 6.0, "{place:?}: {difference_m}");
            assert!((15.0..70.0).contains(&sigma_m), "{sigma_m}");
        }
        assert_eq!(offsets.at([0.0, 0.0, 5_000.0]), None, "another layer");
    }

    #[test]
    fn a_wrong_altimeter_moves_the_mean_little_and_nonsense_not_at_all() {
        let mut offsets = PressureOffsets::new();
        for step in 0..400 {
            offsets.learn([0.0, 0.0, 9_000.0], if step % 10 == 9 { 1_400.0 } else { 100.0 });
            offsets.learn([0.0, 0.0, 9_000.0], f64::NAN);
            offsets.learn([0.0, 0.0, 9_000.0], 1e9);
        }
        let [difference_m, _] = offsets.at([0.0, 0.0, 9_000.0]).unwrap();
        assert!((80.0..130.0).contains(&difference_m), "{difference_m}");
    }

    #[test]
    fn more_cells_than_places_leave_the_layer() {
        let mut offsets = PressureOffsets::new();
        for column in -400..400 {
            for _ in 0..20 {
                offsets.learn([CELL_M * (f64::from(column) + 0.5), 0.0, -1e6], 40.0);
            }
        }
        for column in [-400, 0, 399] {
            let place = [CELL_M * (f64::from(column) + 0.5), 0.0, -1e6];
            let [difference_m, _] = offsets.at(place).unwrap();
            assert!((difference_m - 40.0).abs() < 1e-9);
        }
    }
}
