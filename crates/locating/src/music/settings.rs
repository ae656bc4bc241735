//! The settings of an antenna array.

use std::f64::consts::TAU;

use settings::Degrees;

use super::{AntennaArray, Music, MusicError, MusicSettings, SourceCount};

settings::settings! {
    /// An antenna array, and how bearings are measured with it (EL-1).
    pub struct ArraySettings {
        /// Antennas, in the order of the samples: at least two.
        antennas as "antenna": Vec<ElementPosition>;
        /// Highest frequency that is measured: it decides how fine the search is.
        frequency_max_hz: f64, in [above 0];
        /// Direction of the array's forward axis, clockwise from the platform's heading.
        forward_deg: Degrees = Degrees::of(0.0), in [-360, 360];
        /// Sector covered by the antennas, clockwise from the first angle to the second, from the forward axis.
        /// Bearings outside are omitted; for a line of antennas, which cannot distinguish left from right, the sector
        /// selects a side.
        sector_deg: [Degrees; 2] = [Degrees::of(0.0), Degrees::of(360.0)], in [-360, 360];
        /// Number of transmitters, where it is known.
        transmitters: Option<usize> = None, in [1, 1000], usually "estimated";
        /// Estimator of the number: minimum description length, or Akaike's criterion, which finds weak transmitters
        /// earlier but sometimes one too many.
        criterion: ModelOrderCriterion = ModelOrderCriterion::Mdl;
        /// Largest number of paths of a transmitter, direct and by reflection. Above 1, snapshots that MUSIC does not
        /// resolve are explained by coherent waves, if they can be.
        paths: usize = 1, in [1, 4];
        /// Standard deviation of the phase error of an antenna after calibration.
        phase_sigma_deg: Degrees = Degrees::of(0.0), in [0, 180];
    }

    /// Position of an antenna in the frame of the platform.
    #[derive(Copy)]
    pub struct ElementPosition {
        /// Distance to the right.
        right_m: f64, in [-1e6, 1e6];
        /// Distance forward.
        forward_m: f64, in [-1e6, 1e6];
    }
}

settings::words! {
    /// How the number of transmitters is estimated.
    pub enum ModelOrderCriterion {
        /// Minimum description length.
        Mdl = "mdl",
        /// Akaike's information criterion.
        Aic = "aic",
    }
}

impl ArraySettings {
    /// The array, ready to measure.
    ///
    /// # Errors
    /// As [`AntennaArray::new`] and [`Music::new`].
    pub fn music(&self) -> Result<Music, MusicError> {
        let estimated = match self.criterion {
            ModelOrderCriterion::Mdl => SourceCount::Mdl,
            ModelOrderCriterion::Aic => SourceCount::Aic,
        };
        let settings = MusicSettings {
            sources: self.transmitters.map_or(estimated, SourceCount::Given),
            frequency_max_hz: self.frequency_max_hz,
            phase_sigma_rad: self.phase_sigma_deg.rad(),
            paths: self.paths,
        };
        Music::new(AntennaArray::new(&self.antennas)?, settings)
    }

    /// Returns whether the antennas receive a bearing, radians clockwise from the forward axis.
    pub fn hears(&self, bearing_rad: f64) -> bool {
        let [from, to] = self.sector_deg.map(Degrees::rad);
        let width = match (to - from).rem_euclid(TAU) {
            0.0 => TAU,
            width => width,
        };
        (bearing_rad - from).rem_euclid(TAU) <= width
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sector_goes_clockwise_and_a_whole_turn_is_everything() {
        let with = |from, to| ArraySettings {
            sector_deg: [from, to].map(Degrees::of),
            ..ArraySettings::default()
        };
        let hears = |settings: &ArraySettings, deg: f64| settings.hears(deg.to_radians());
        let ahead = with(-90.0, 90.0);
        assert!(hears(&ahead, 0.0) && hears(&ahead, 300.0) && !hears(&ahead, 180.0));
        let behind = with(90.0, -90.0);
        assert!(!hears(&behind, 0.0) && hears(&behind, 180.0));
        assert!(hears(&with(0.0, 360.0), 123.0) && hears(&with(-180.0, 180.0), 123.0));
    }

    #[test]
    fn what_the_array_lacks_is_said_with_line_and_remedy() {
        let read = |text: &str| {
            let read = settings::Document::parse(text, &[]).and_then(|document| document.read::<ArraySettings>());
            read.map_err(|error| (error.line, error.to_string()))
        };
        let pair = "frequency_max_hz = 1e9\n[[antenna]]\nright_m = 0\nforward_m = 0\n[[antenna]]\nright_m = 0.1\n";
        let (line, what) = read(pair).unwrap_err();
        assert!(
            line == Some(5) && what.contains("antenna[1].forward_m"),
            "{line:?} {what}"
        );
        let array = read(&format!("{pair}forward_m = 0\n")).unwrap();
        assert_eq!(array.music().unwrap().array().len(), 2);
        let (_, what) = read("criterion = \"map\"").unwrap_err();
        assert!(what.contains("mdl"), "{what}");
    }
}
