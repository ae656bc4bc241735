//! Records of the models for a successor of the process: sources, pairs, classes of motion, cells of coverage.

use kept::{Get, Put, kept};
use messages::{Bias, BiasKind};

use crate::alignment::PairFindings;
use crate::detection_map::HitCount;
use crate::manoeuvres::{CLASSES, Class};
use crate::moving_sources::SourcePose;
use crate::registration::{KeptErrors, SourcePair};
use crate::source_model::SourceModel;
use crate::sources::Sources;
use crate::stamps::Stamps;

kept! {
    /// All knowledge of a source.
    #[derive(Clone, Copy, Debug)]
    pub struct KeptSource {
        model: SourceModel,
        errors: KeptErrors,
        detection: HitCount,
        pose: Option<SourcePose>,
        purity: HitCount,
        /// Accepted gross bias, and the removed bias.
        gross: (Option<Bias>, Option<(BiasKind, [f64; 2])>),
        stamps: Stamps,
    }
}

kept! {
    /// All knowledge of an ordered pair of sources.
    #[derive(Clone, Copy, Debug)]
    pub struct KeptPair {
        sums: SourcePair,
        gross: PairFindings,
        /// Share of copies, mean squares of differences, and whether that makes the two dependent.
        dependence: ((f64, [f64; 2]), bool),
    }
}

kept! {
    /// All knowledge of the motion of a class of targets.
    #[derive(Clone, Copy, Debug)]
    pub struct KeptClass {
        class: Class,
    }
}

impl Sources {
    /// Number of classes of motion.
    pub const CLASSES: usize = CLASSES;

    /// Number of cells of the learned coverage, and the words of a cell.
    pub fn kept_cells(&self) -> (usize, usize) {
        (self.coverage.places(), self.coverage.cell_words())
    }

    /// The record of a source.
    pub fn kept_source(&mut self, source: usize) -> KeptSource {
        KeptSource {
            model: self.models[source],
            errors: self.registration.kept(source),
            detection: *self.coverage.general_mut(source),
            pose: *self.moving.pose_mut(source),
            purity: *self.purity.tally_mut(source),
            gross: self.alignment.bias_of(source),
            stamps: self.stamps[source],
        }
    }

    /// Continues with the record of a source.
    pub fn resume_source(&mut self, source: usize, kept: &KeptSource) {
        self.models[source] = kept.model;
        self.registration.resume(source, &kept.errors);
        *self.coverage.general_mut(source) = kept.detection;
        *self.moving.pose_mut(source) = kept.pose;
        *self.purity.tally_mut(source) = kept.purity;
        self.alignment.resume(source, kept.gross);
        self.stamps[source] = kept.stamps;
    }

    /// The record of a pair of sources.
    pub fn kept_pair(&mut self, place: usize) -> KeptPair {
        KeptPair {
            sums: self.registration.pairs()[place],
            gross: *self.alignment.pair_mut(place),
            dependence: self.dependence.kept(place),
        }
    }

    /// Continues with the record of a pair of sources.
    pub fn resume_pair(&mut self, place: usize, kept: &KeptPair) {
        self.registration.resume_pair(place, kept.sums);
        *self.alignment.pair_mut(place) = kept.gross;
        self.dependence.resume(place, kept.dependence);
    }

    /// The record of a class of motion.
    pub fn kept_class(&mut self, place: usize) -> KeptClass {
        KeptClass {
            class: self.manoeuvres.classes_mut()[place],
        }
    }

    /// Continues with the record of a class of motion.
    pub fn resume_class(&mut self, place: usize, kept: &KeptClass) {
        self.manoeuvres.classes_mut()[place] = kept.class;
    }

    /// Writes a cell of the coverage; `None` if nothing was learned there.
    pub fn kept_cell(&self, place: usize) -> Option<impl FnOnce(&mut Put<'_>)> {
        self.coverage.cell_at(place)
    }

    /// Continues with a kept cell of the coverage.
    pub fn resume_cell(&mut self, place: usize, from: &mut Get<'_>) {
        self.coverage.resume_cell(place, from);
    }
}

#[cfg(test)]
mod tests {
    use messages::SensorTrack;

    use super::*;
    use crate::innovation::Fit;
    use crate::settings::Settings;
    use crate::testing::{innovation, test_settings};

    const SOURCES: usize = 3;

    fn settings(removes_gross: bool) -> Settings {
        let mut settings = test_settings(SOURCES);
        settings.registration.gross = removes_gross;
        settings
    }

    fn successor(of: &mut Sources, removes_gross: bool) -> Sources {
        let mut next = Sources::new(&settings(removes_gross));
        (0..SOURCES).for_each(|source| next.resume_source(source, &of.kept_source(source)));
        (0..SOURCES * SOURCES).for_each(|place| next.resume_pair(place, &of.kept_pair(place)));
        (0..CLASSES).for_each(|place| next.resume_class(place, &of.kept_class(place)));
        next
    }

    #[test]
    fn how_targets_turn_which_sources_copy_and_gross_errors_are_still_known() {
        let mut models = Sources::new(&settings(true));
        let error = Bias {
            kind: BiasKind::Azimuth,
            value: [0.01, 0.0],
            partner: 0,
            is_certain: true,
            is_removed: true,
        };
        let fast_mps = [100.0, 0.0, 0.0];
        models
            .alignment
            .resume(2, (Some(error), Some((error.kind, error.value))));
        for step in 0..100 {
            models.manoeuvres.learn(fast_mps, &innovation(Fit::Turning(50.0)));
            for source in [0, 1] {
                models.dependence.learn(&SensorTrack {
                    source,
                    time_of_measurement_ns: step * 1_000_000_000,
                    ..SensorTrack::default()
                });
            }
        }
        let known = |models: &Sources| {
            (
                models.motion(fast_mps).turns.density_m2ps3,
                models.alignment.bias_of(2),
                [0, 1, 2].map(|source| models.group_of(source)),
            )
        };
        let learned = known(&models);
        assert!(learned.0[0] > 60.0 && learned.2 == [0, 0, 2], "{learned:?}");
        assert_eq!(known(&successor(&mut models, true)), learned);
        // Without removal, reports stay unchanged.
        let (believed, removed) = successor(&mut models, false).alignment.bias_of(2);
        assert!(removed.is_none() && believed.is_some_and(|error| !error.is_removed));
    }
}
