//! Detection map: probability that each source follows a target at a place, learned or configured (BF-2).
//!
//! The map is a pyramid of square cells: small cells resolve the edge of a coverage, large cells answer in place of
//! small cells with too few targets. A cell takes the probability of the cell above as prior, worth [`GENERAL_WEIGHT`]
//! targets; the top of the pyramid is the source in general.
//!
//! Each target teaches the map with the probability of its existence as weight. A target of a single source thus
//! teaches the blind areas of the other sources, and a false track teaches little.
//!
//! Source: X. R. Li, N. Li, *Integrated real-time estimation of clutter density for tracking*, IEEE Transactions on
//! Signal Processing 48 (2000), for perceivability; D. Mušicki, R. Evans, S. Stankovic, *Integrated probabilistic data
//! association*, IEEE Transactions on Automatic Control 39 (1994), for the recursion of existence.

use association::floor;
use kept::{Get, Kept as _, Put, kept};
use serde::{Deserialize, Serialize};

use crate::settings::CoverageArea;

/// Probability that a source follows a target at a place, before anything was learned.
const DETECTION_PRIOR: f64 = 0.5;
/// Worth of the probability of the cell above in a cell, in observed targets.
const GENERAL_WEIGHT: f64 = 4.0;
/// Widths of the cells of each level, relative to the smallest, from the smallest up.
const LEVELS: [f64; 3] = [1.0, 4.0, 16.0];
/// Observations of a cell are forgotten beyond this number.
const CELL_MEMORY: f64 = 64.0;
/// Observations of a source in general are forgotten beyond this number.
const GENERAL_MEMORY: f64 = 256.0;
/// Largest accepted probability: shadowing is always possible.
const DETECTION_MAX: f64 = 0.98;
/// Number of table places tried for a cell.
const PROBES: usize = 8;

kept! {
    /// Hits and tries.
    #[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
    pub(crate) struct HitCount {
        hits: f32,
        tries: f32,
    }
}

impl HitCount {
    /// Adds a try of this weight, in (0, 1].
    pub(crate) fn add(&mut self, hit: bool, weight: f64, memory: f64) {
        if f64::from(self.tries) >= memory {
            self.hits *= 0.5;
            self.tries *= 0.5;
        }
        let weight = weight as f32;
        if hit {
            self.hits += weight;
        }
        self.tries += weight;
    }

    /// Logarithm of the odds of a hit, with this prior number of hits and of failures.
    pub(crate) fn log_odds(&self, prior: f64) -> f64 {
        let hits = f64::from(self.hits);
        ((hits + prior) / (f64::from(self.tries) - hits + prior)).ln()
    }

    /// Number of tries, after forgetting.
    pub(crate) fn tries(&self) -> f64 {
        f64::from(self.tries)
    }

    /// Share of hits; 0 without a try.
    pub(crate) fn mean(&self) -> f64 {
        f64::from(self.hits) / f64::from(self.tries).max(f64::MIN_POSITIVE)
    }

    fn share(&self, prior: f64, weight: f64) -> f64 {
        (f64::from(self.hits) + weight * prior) / (f64::from(self.tries) + weight)
    }
}

/// Probability that a source follows a target at a place, in [0, 0.98].
#[derive(Clone, Copy, Debug)]
pub struct DetectionProbability {
    /// With the prior that a source detects half of the targets: decides whether to wait for the source.
    pub assumed: f64,
    /// With the prior that a source detects nothing: the evidential weight of the source's silence. Without proven
    /// coverage of a place, a source contributes no evidence against a target there.
    pub shown: f64,
}

/// A cell: its level in [`LEVELS`] and its column together, and its row.
type MapCell = (i32, i32);

/// Coverage of each source: learned per cell, or configured.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct DetectionMap {
    sources: usize,
    /// Width of the smallest cells.
    cell_m: f64,
    /// Cell at each place of the table.
    cells: Vec<Option<MapCell>>,
    tallies: Vec<HitCount>,
    general: Vec<HitCount>,
    areas: Vec<Option<CoverageArea>>,
}

impl DetectionMap {
    /// For as many sources as `areas` has entries; `cells` cells, the smallest `cell_m` metres wide.
    pub(crate) fn new(areas: Vec<Option<CoverageArea>>, cells: usize, cell_m: f64) -> Self {
        let (sources, cells) = (areas.len(), cells.next_power_of_two());
        Self {
            sources,
            cell_m,
            cells: vec![None; cells],
            tallies: vec![HitCount::default(); cells * sources],
            general: vec![HitCount::default(); sources],
            areas,
        }
    }

    /// Words of a cell in a checkpoint.
    pub(crate) fn cell_words(&self) -> usize {
        MapCell::WORDS + self.sources * HitCount::WORDS
    }

    /// Number of cells in the table.
    pub(crate) fn places(&self) -> usize {
        self.cells.len()
    }

    /// Keeps the cell at a place of the table; `None` for an empty place.
    pub(crate) fn cell_at(&self, place: usize) -> Option<impl FnOnce(&mut Put<'_>)> {
        let cell = self.cells[place]?;
        let tallies = &self.tallies[place * self.sources..(place + 1) * self.sources];
        Some(move |to: &mut Put<'_>| {
            cell.put(to);
            tallies.iter().for_each(|tally| tally.put(to));
        })
    }

    /// Restores a kept cell.
    pub(crate) fn resume_cell(&mut self, place: usize, from: &mut Get<'_>) {
        self.cells[place] = MapCell::get(from);
        for tally in &mut self.tallies[place * self.sources..(place + 1) * self.sources] {
            *tally = HitCount::get(from).unwrap_or_default();
        }
    }

    /// Knowledge of a source in general.
    pub(crate) fn general_mut(&mut self, source: usize) -> &mut HitCount {
        &mut self.general[source]
    }

    /// Configured coverage of a source.
    #[inline]
    pub(crate) fn area(&self, source: usize) -> Option<&CoverageArea> {
        self.areas[source].as_ref()
    }

    /// Forgets the coverage of a source.
    pub(crate) fn forget(&mut self, source: usize) {
        self.general[source] = HitCount::default();
        for tally in self.tallies.iter_mut().skip(source).step_by(self.sources) {
            *tally = HitCount::default();
        }
    }

    /// Learns from a target at (x, y) with the probability of existence `existence`; `is_detected` states whether a
    /// source follows the target; `None`: the source is left out.
    pub(crate) fn learn(&mut self, [x, y]: [f64; 2], existence: f64, is_detected: impl Fn(u16) -> Option<bool>) {
        // A possibly false track would teach only its own small cells, and so support itself.
        let lowest = if existence < 1.0 { LEVELS.len() - 1 } else { 0 };
        let places: [Option<usize>; LEVELS.len()] =
            std::array::from_fn(|level| (level >= lowest).then(|| self.claim(level, x, y)).flatten());
        for source in 0..self.sources {
            let Some(hit) = is_detected(source as u16) else {
                continue;
            };
            self.general[source].add(hit, existence, GENERAL_MEMORY);
            for place in places.into_iter().flatten() {
                self.tallies[place * self.sources + source].add(hit, existence, CELL_MEMORY);
            }
        }
    }

    /// Probability that `source` follows a target at this place.
    pub(crate) fn probability(&self, source: u16, position_m: [f64; 3]) -> DetectionProbability {
        let index = usize::from(source);
        if let Some(area) = &self.areas[index] {
            let stated = area.probability_at(position_m).min(DETECTION_MAX);
            return DetectionProbability {
                assumed: stated,
                shown: stated,
            };
        }
        let general = &self.general[index];
        let mut detection = DetectionProbability {
            assumed: general.share(DETECTION_PRIOR, GENERAL_WEIGHT),
            shown: general.share(0.0, GENERAL_WEIGHT),
        };
        for level in (0..LEVELS.len()).rev() {
            if let Some(place) = self.place(level, position_m[0], position_m[1]) {
                let tally = &self.tallies[place * self.sources + index];
                for probability in [&mut detection.assumed, &mut detection.shown] {
                    *probability = tally.share(*probability, GENERAL_WEIGHT);
                }
            }
        }
        detection.assumed = detection.assumed.min(DETECTION_MAX);
        detection.shown = detection.shown.min(DETECTION_MAX);
        detection
    }

    /// Index of a cell in the table, if present.
    fn place(&self, level: usize, x: f64, y: f64) -> Option<usize> {
        let cell = self.cell(level, x, y);
        self.probes(cell).find(|place| self.cells[*place] == Some(cell))
    }

    /// Index of a cell in the table, a free index if absent; `None` without room near its place.
    fn claim(&mut self, level: usize, x: f64, y: f64) -> Option<usize> {
        let cell = self.cell(level, x, y);
        let place = self
            .probes(cell)
            .find(|place| self.cells[*place].is_none_or(|other| other == cell))?;
        self.cells[place] = Some(cell);
        Some(place)
    }

    fn probes(&self, cell: MapCell) -> impl Iterator<Item = usize> + use<> {
        let (start, mask) = (hash(cell), self.cells.len() - 1);
        (0..PROBES).map(move |probe| (start.wrapping_add(probe)) & mask)
    }

    fn cell(&self, level: usize, x: f64, y: f64) -> MapCell {
        let width_m = self.cell_m * LEVELS[level];
        // `as` saturates.
        let column = floor(x / width_m).wrapping_mul(LEVELS.len() as i32);
        (column.wrapping_add(level as i32), floor(y / width_m))
    }
}

fn hash((column, row): MapCell) -> usize {
    let mixed = (column as u32).wrapping_mul(0x9e37_79b1) ^ (row as u32).wrapping_mul(0x85eb_ca77);
    (mixed ^ (mixed >> 15)) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A map without configured coverage, with cells of 1 km.
    fn map(sources: usize, cells: usize) -> DetectionMap {
        DetectionMap::new(vec![None; sources], cells, 1000.0)
    }

    #[test]
    fn each_place_has_its_own_probability() {
        let mut map = map(3, 64);
        for _ in 0..100 {
            map.learn([500.0, 500.0], 1.0, |source| Some(source != 2));
            map.learn([5500.0, 500.0], 1.0, |source| Some(source == 0));
        }
        let here = map.probability(1, [500.0, 500.0, 0.0]).shown;
        let there = map.probability(1, [5500.0, 500.0, 0.0]).shown;
        assert!(here > 0.9 && there < 0.1, "{here} {there}");
        assert!(map.probability(2, [500.0, 500.0, 0.0]).assumed < 0.05);
    }

    #[test]
    fn a_place_never_seen_is_judged_by_the_larger_cells_around_it() {
        let mut map = map(1, 64);
        let unknown = map.probability(0, [0.0; 3]);
        assert_eq!((unknown.assumed, unknown.shown), (DETECTION_PRIOR, 0.0));
        for _ in 0..100 {
            map.learn([500.0, 500.0], 1.0, |_| Some(true));
            map.learn([90_500.0, 500.0], 1.0, |_| Some(false));
        }
        let beside_seen = map.probability(0, [3500.0, 500.0, 0.0]).shown;
        let beside_blind = map.probability(0, [93_500.0, 500.0, 0.0]).shown;
        assert!(beside_seen > 0.9 && beside_blind < 0.1, "{beside_seen} {beside_blind}");
        let far = map.probability(0, [500e3, 0.0, 0.0]).shown;
        assert!((0.4..0.6).contains(&far), "{far}");
    }

    #[test]
    fn a_doubtful_track_does_not_teach_its_own_small_cells() {
        let mut map = map(1, 64);
        for _ in 0..20 {
            map.learn([500.0, 500.0], 1.0, |_| Some(true));
        }
        for _ in 0..20 {
            map.learn([4500.0, 500.0], 0.2, |_| Some(false));
        }
        let doubtful = map.probability(0, [4500.0, 500.0, 0.0]).shown;
        assert!(doubtful > 0.7, "{doubtful}");
        for _ in 0..20 {
            map.learn([4500.0, 500.0], 1.0, |_| Some(false));
        }
        assert!(map.probability(0, [4500.0, 500.0, 0.0]).shown < 0.3);
    }

    #[test]
    fn a_full_table_falls_back_to_the_source_in_general() {
        let mut map = map(1, 8);
        for column in 0..1000 {
            map.learn([f64::from(column) * 1000.0, 0.0], 1.0, |_| Some(true));
        }
        assert!(map.probability(0, [995e3, 0.0, 0.0]).shown > 0.9);
    }
}
