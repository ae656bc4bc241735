//! Existence of targets (BF-2): decided from reports and missing reports of the sources with coverage.
//!
//! Every sensor has false tracks, and a system that shows every reported track shows all of them. Requiring two
//! sources loses targets visible to one source only. The decisive quantity is the information in the silence of the
//! other sources: if a source that tracks nineteen of twenty targets in an area has no track here, a target is
//! unlikely; if it tracks no targets in the area, its silence has no meaning. Let pₖ be the probability that source k
//! tracks a target at this place, learned per cell of the ground from confirmed tracks (or configured). The
//! log-likelihood ratio of a single source's claim is
//!
//! L = Σ ln(1 − pₖ) over the silent sources with coverage + a term for persistence: false tracks end with a
//! probability of about a fifth per scan + a term for an address: noise does not answer interrogations.
//!
//! Three sources in agreement are sufficient, and two if few tracks are false. With many false tracks, two of them
//! coincide sometimes by chance, and the ratio of an agreement is reduced so far that the silence of the other
//! sources, and persistence, count as well. While a shown target may be the same target, seen by other sources at
//! another point, a second track waits: the sources are not silent then. A confirmed track stays confirmed until its
//! sources *report* that they no longer detect the target: each miss since the last report of any source adds ln(1 −
//! its probability of detection).

use kept::{Get, Kept as _, Put, kept};
use serde::{Deserialize, Serialize};

use crate::coverage::CoverageArea;

settings::settings! {
    /// Existence of targets, estimated from reports and missing reports of sources (BF-2). Keys give log-likelihood
    /// ratios of a target to a false track; the ratios of one claim are added.
    #[derive(Copy)]
    pub struct ExistenceSettings {
        /// Log-likelihood ratio above which a target reported by a single source exists; the silence of each source
        /// with coverage of the place counts against the target.
        believed: f64 = -0.7, in [-20, 20], usually "-0.7: about one to two against it";
        /// Worth of each further report of the claim's sensor track: −ln of the share of false tracks that go on.
        persistence: f64 = 0.223, in [0, 10], usually "0.223: one false track in five ends with each report";
        /// Reports before persistence counts.
        persistence_reports: u32 = 3, in [0, 1e6];
        /// Worth of an address: noise does not answer interrogations.
        address: f64 = 5.0, in [0, 20];
        /// Sum of ln(1 − probability of detection) over the misses since the last detection by any source, at which a
        /// confirmed target counts as gone: its track is withheld until the next detection.
        gone: f64 = -6.9, in [-50, -0.1], usually "-6.9: one target in a thousand would be missed that often";
        /// Successive misses of a source that count for this sum: an obstacle that hides a target causes several
        /// misses.
        misses: u32 = 2, in [1, 1000];
    }
}

/// Probability that a source follows a target at a place, before anything was learned.
const DETECTION_PRIOR: f64 = 0.5;
/// Worth of the source's general probability in a cell, in observed targets.
const GENERAL_WEIGHT: f64 = 4.0;
/// Observations of a cell are forgotten beyond this number.
const CELL_MEMORY: f64 = 64.0;
/// Observations of a source in general are forgotten beyond this number.
const GENERAL_MEMORY: f64 = 256.0;
/// Largest probability that is believed: there is always a chance to be shadowed.
const DETECTION_MAX: f64 = 0.98;
/// Places of the table that are tried for one cell.
const PROBES: usize = 8;

kept! {
    /// Hits and tries.
    #[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
    pub(crate) struct Tally {
        hits: f32,
        tries: f32,
    }
}

impl Tally {
    fn add(&mut self, hit: bool, memory: f64) {
        if f64::from(self.tries) >= memory {
            self.hits *= 0.5;
            self.tries *= 0.5;
        }
        self.hits += f32::from(u8::from(hit));
        self.tries += 1.0;
    }

    fn share(&self, prior: f64, weight: f64) -> f64 {
        (f64::from(self.hits) + weight * prior) / (f64::from(self.tries) + weight)
    }
}

/// Where each source follows targets: learned per cell, or configured.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Coverage {
    sources: usize,
    cell_m: f64,
    /// Which cell each place of the table holds.
    cells: Vec<Option<(i32, i32)>>,
    tallies: Vec<Tally>,
    general: Vec<Tally>,
    areas: Vec<Option<CoverageArea>>,
}

impl Coverage {
    /// For as many sources as `areas` has entries; `cells` cells of `cell_m` metres.
    pub(crate) fn new(areas: Vec<Option<CoverageArea>>, cells: usize, cell_m: f64) -> Self {
        let (sources, cells) = (areas.len(), cells.next_power_of_two());
        Self {
            sources,
            cell_m,
            cells: vec![None; cells],
            tallies: vec![Tally::default(); cells * sources],
            general: vec![Tally::default(); sources],
            areas,
        }
    }

    /// Words that a checkpoint keeps of a cell.
    pub(crate) fn cell_words(&self) -> usize {
        <(i32, i32)>::WORDS + self.sources * Tally::WORDS
    }

    /// Number of cells that the table has room for.
    pub(crate) fn places(&self) -> usize {
        self.cells.len()
    }

    /// Keeps the cell at a place of the table; whether there is one.
    pub(crate) fn cell_at(&self, place: usize) -> Option<impl FnOnce(&mut Put<'_>)> {
        let cell = self.cells[place]?;
        let tallies = &self.tallies[place * self.sources..(place + 1) * self.sources];
        Some(move |to: &mut Put<'_>| {
            cell.put(to);
            tallies.iter().for_each(|tally| tally.put(to));
        })
    }

    /// Takes in a cell that was kept.
    pub(crate) fn resume_cell(&mut self, place: usize, from: &mut Get<'_>) {
        self.cells[place] = <(i32, i32)>::get(from);
        for tally in &mut self.tallies[place * self.sources..(place + 1) * self.sources] {
            *tally = Tally::get(from).unwrap_or_default();
        }
    }

    /// Knowledge of a source in general.
    pub(crate) fn general_mut(&mut self, source: usize) -> &mut Tally {
        &mut self.general[source]
    }

    /// Forgets where a source detects targets.
    pub(crate) fn forget(&mut self, source: usize) {
        self.general[source] = Tally::default();
        for tally in self.tallies.iter_mut().skip(source).step_by(self.sources) {
            *tally = Tally::default();
        }
    }

    /// Learns from a confirmed track at (x, y): `is_detected` states whether a source contributes; `None`: the source
    /// is not asked.
    pub(crate) fn learn(&mut self, x: f64, y: f64, is_detected: impl Fn(u16) -> Option<bool>) {
        let place = self.claim(x, y);
        for source in 0..self.sources {
            let Some(hit) = is_detected(source as u16) else {
                continue;
            };
            self.general[source].add(hit, GENERAL_MEMORY);
            if let Some(place) = place {
                self.tallies[place * self.sources + source].add(hit, CELL_MEMORY);
            }
        }
    }

    /// Probability that `source` follows a target at this place.
    pub(crate) fn detection_probability(&self, source: u16, position_m: [f64; 3]) -> f64 {
        let index = usize::from(source);
        if let Some(area) = &self.areas[index] {
            return area.probability_at(position_m).min(DETECTION_MAX);
        }
        let general = self.general[index].share(DETECTION_PRIOR, GENERAL_WEIGHT);
        let cell = self.place(position_m[0], position_m[1]).map_or(general, |place| {
            self.tallies[place * self.sources + index].share(general, GENERAL_WEIGHT)
        });
        cell.min(DETECTION_MAX)
    }

    /// Returns the index of a cell in the table, if present.
    fn place(&self, x: f64, y: f64) -> Option<usize> {
        let cell = self.cell(x, y);
        self.probes(cell).find(|place| self.cells[*place] == Some(cell))
    }

    /// Returns the index of a cell in the table, a free index if absent; `None` without room near its place.
    fn claim(&mut self, x: f64, y: f64) -> Option<usize> {
        let cell = self.cell(x, y);
        let place = self
            .probes(cell)
            .find(|place| self.cells[*place].is_none_or(|other| other == cell))?;
        self.cells[place] = Some(cell);
        Some(place)
    }

    fn probes(&self, cell: (i32, i32)) -> impl Iterator<Item = usize> + use<> {
        let (start, mask) = (hash(cell), self.cells.len() - 1);
        (0..PROBES).map(move |probe| (start.wrapping_add(probe)) & mask)
    }

    fn cell(&self, x: f64, y: f64) -> (i32, i32) {
        // `as` saturates.
        ((x / self.cell_m).floor() as i32, (y / self.cell_m).floor() as i32)
    }
}

fn hash((column, row): (i32, i32)) -> usize {
    let mixed = (column as u32).wrapping_mul(0x9e37_79b1) ^ (row as u32).wrapping_mul(0x85eb_ca77);
    (mixed ^ (mixed >> 15)) as usize
}

/// Evidence for a target that only one source reports.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Claim {
    /// Σ ln(1 − pₖ) over the sources that are silent.
    pub(crate) silence: f64,
    /// Reports of the source's track so far.
    pub(crate) reports: u32,
    pub(crate) has_address: bool,
}

impl Claim {
    /// L, the logarithm of how much likelier a target is than a false track.
    pub(crate) fn log_ratio(&self, settings: &ExistenceSettings) -> f64 {
        let further = self.reports.saturating_sub(settings.persistence_reports);
        let persistence = settings.persistence * f64::from(further);
        let address = if self.has_address { settings.address } else { 0.0 };
        self.silence + persistence + address
    }

    pub(crate) fn is_believed(&self, settings: &ExistenceSettings) -> bool {
        self.log_ratio(settings) > settings.believed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn claim(silence: f64, reports: u32) -> Claim {
        Claim {
            silence,
            reports,
            has_address: false,
        }
    }

    #[test]
    fn silence_of_sources_that_cover_the_place_is_telling() {
        let mut coverage = Coverage::new(vec![None; 3], 64, 1000.0);
        for _ in 0..100 {
            coverage.learn(500.0, 500.0, |source| Some(source != 2));
            coverage.learn(5500.0, 500.0, |source| Some(source == 0));
        }
        let here = coverage.detection_probability(1, [500.0, 500.0, 0.0]);
        let there = coverage.detection_probability(1, [5500.0, 500.0, 0.0]);
        assert!(here > 0.9 && there < 0.1, "{here} {there}");
        assert!(coverage.detection_probability(2, [500.0, 500.0, 0.0]) < 0.05);
        assert!(!claim((1.0 - here).ln(), 5).is_believed(&ExistenceSettings::default()));
        assert!(claim((1.0 - there).ln(), 5).is_believed(&ExistenceSettings::default()));
    }

    #[test]
    fn a_place_never_seen_is_judged_by_the_source_in_general() {
        let mut coverage = Coverage::new(vec![None; 1], 64, 1000.0);
        assert_eq!(coverage.detection_probability(0, [0.0; 3]), DETECTION_PRIOR);
        for _ in 0..100 {
            coverage.learn(0.0, 0.0, |_| Some(true));
        }
        assert!(coverage.detection_probability(0, [50e3, 0.0, 0.0]) > 0.9);
    }

    #[test]
    fn persistence_and_addresses_speak_for_a_claim() {
        assert!(!claim(-4.0, 4).is_believed(&ExistenceSettings::default()));
        assert!(claim(-4.0, 30).is_believed(&ExistenceSettings::default()));
        let patient = ExistenceSettings {
            persistence_reports: 30,
            ..ExistenceSettings::default()
        };
        assert!(!claim(-4.0, 30).is_believed(&patient));
        let mut with_address = claim(-4.0, 4);
        with_address.has_address = true;
        assert!(with_address.is_believed(&ExistenceSettings::default()));
        let strict = ExistenceSettings {
            believed: 3.0,
            ..ExistenceSettings::default()
        };
        assert!(!with_address.is_believed(&strict));
    }

    #[test]
    fn a_full_table_falls_back_to_the_source_in_general() {
        let mut coverage = Coverage::new(vec![None; 1], 8, 10.0);
        for column in 0..100 {
            coverage.learn(f64::from(column) * 10.0, 0.0, |_| Some(true));
        }
        assert!(coverage.detection_probability(0, [995.0, 0.0, 0.0]) > 0.9);
    }
}
