//! Models of an emitter's motion, from the simplest on.

use kept::kept_variants;

use crate::settings::{EmitterMotionSettings, FilterChoice};
use crate::smoother::Model;

/// A model of an emitter's motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionModel {
    /// A fixed point.
    Fixed,
    /// A point that wanders.
    Wandering,
    /// Straight and uniform.
    Straight,
    /// Straight, with small accelerations.
    Manoeuvring,
    /// None: a ready-made fix, passed on unchanged.
    Given,
}

impl MotionModel {
    /// The word for the model.
    pub fn word(self) -> &'static str {
        match self {
            Self::Fixed => "fixed",
            Self::Wandering => "wandering",
            Self::Straight => "straight",
            Self::Manoeuvring => "manoeuvring",
            Self::Given => "given",
        }
    }

    /// The models that compete, simplest first.
    pub(crate) fn of(choice: FilterChoice) -> &'static [Self] {
        match choice {
            FilterChoice::Auto | FilterChoice::None => &[Self::Fixed, Self::Straight, Self::Manoeuvring],
            FilterChoice::Fixed => &[Self::Fixed, Self::Wandering],
            FilterChoice::Straight => &[Self::Straight, Self::Manoeuvring],
        }
    }

    pub(crate) fn model(self, settings: &EmitterMotionSettings) -> Model {
        let process_noise = match self {
            Self::Fixed | Self::Straight | Self::Given => 0.0,
            Self::Wandering => settings.wandering_noise_m2ps,
            Self::Manoeuvring => settings.manoeuvring_noise_m2ps3,
        };
        Model {
            process_noise,
            range_sigma_m: settings.range_sigma_m,
            speed_sigma_mps: settings.speed_sigma_mps,
            slow_sigma_mps: settings.slow_mps(),
            start: None,
        }
    }
}

kept_variants!(MotionModel {
    Fixed,
    Wandering,
    Straight,
    Manoeuvring,
    Given,
});

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn models_that_stand_by_have_the_noise_of_their_keys() {
        let settings = EmitterMotionSettings {
            wandering_noise_m2ps: 7.0,
            manoeuvring_noise_m2ps3: 0.3,
            ..EmitterMotionSettings::default()
        };
        let models = [
            MotionModel::Fixed,
            MotionModel::Wandering,
            MotionModel::Straight,
            MotionModel::Manoeuvring,
        ];
        let noise = models.map(|motion| motion.model(&settings).process_noise);
        assert_eq!(noise, [0.0, 7.0, 0.0, 0.3]);
    }
}
