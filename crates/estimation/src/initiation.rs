//! Initiation: the state after a single measured position.
//!
//! A single position does not determine the velocity. The difference of two positions makes the first estimate late,
//! and rough if the two are close in time. Single-point initiation instead starts with prior knowledge: velocity
//! zero, with the standard deviation of target speeds; the second update then determines the velocity (Bar-Shalom et
//! al. 2001, chapter 5; M. Mallick, B. La Scala, *Comparison of single-point and two-point difference track
//! initiation algorithms using position measurements*, 2008).

use messages::{AXES, Covariance, STATE_LEN};

use crate::gaussian::{Gaussian, Symmetric3};

/// A velocity before observation: zero, with these standard deviations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstVelocity {
    /// Standard deviation east and north, m/s.
    pub horizontal_sigma_mps: f64,
    /// Standard deviation up, m/s.
    pub vertical_sigma_mps: f64,
}

/// Variance of a height that was not observed, m²: any height of an aircraft is within a few standard deviations.
const UNOBSERVED_HEIGHT_M2: f64 = 1e4 * 1e4;

impl Gaussian {
    /// Makes the state after a first measured position, of covariance `r`, in the first `D` axes (2: east and north;
    /// 3: also up). In two axes, height is 0 with an uninformative variance.
    pub fn from_first_position<const D: usize>(
        measured_m: [f64; AXES],
        r: &Symmetric3,
        velocity: FirstVelocity,
    ) -> Self {
        const { assert!(D == 2 || D == 3, "a position has two or three axes") };
        let horizontal = velocity.horizontal_sigma_mps * velocity.horizontal_sigma_mps;
        let vertical = velocity.vertical_sigma_mps * velocity.vertical_sigma_mps;
        let mut covariance = Covariance::default();
        for (place, value) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].into_iter().zip(r) {
            covariance.set(place.0, place.1, *value);
        }
        for (component, variance) in [(3, horizontal), (4, horizontal), (5, vertical)] {
            covariance.set(component, component, variance);
        }
        let mut state = Self::new(measured_m, [0.0; AXES], &covariance);
        if D < AXES {
            state.forget_height(velocity);
        }
        state
    }

    /// Resets height and vertical speed to the unobserved state: 0, uncorrelated, with uninformative variances. For
    /// tracks of sensors without height measurements, where prediction would let these variances grow for ever.
    pub fn forget_height(&mut self, velocity: FirstVelocity) {
        let vertical = velocity.vertical_sigma_mps * velocity.vertical_sigma_mps;
        self.replace_vertical([0.0, 0.0], [UNOBSERVED_HEIGHT_M2, vertical]);
    }

    /// Makes height and vertical speed these, uncorrelated with all else, with these variances.
    pub fn replace_vertical(&mut self, mean: [f64; 2], variances: [f64; 2]) {
        for (component, value, variance) in [(2, mean[0], variances[0]), (5, mean[1], variances[1])] {
            self.mean[component] = value;
            for other in 0..STATE_LEN {
                self.covariance.set(component.min(other), component.max(other), 0.0);
            }
            self.covariance.set(component, component, variance);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::AxisNoise;
    use crate::definite::is_usable;

    const VELOCITY: FirstVelocity = FirstVelocity {
        horizontal_sigma_mps: 150.0,
        vertical_sigma_mps: 15.0,
    };
    /// No correlation, variances of 9 m².
    const R: Symmetric3 = [9.0, 0.0, 0.0, 9.0, 0.0, 9.0];

    #[test]
    fn two_and_three_axes() {
        let plane = Gaussian::from_first_position::<2>([1.0, 2.0, 7.0], &R, VELOCITY);
        assert_eq!(plane.position_m(), [1.0, 2.0, 0.0]);
        assert_eq!(plane.covariance.get(2, 2), UNOBSERVED_HEIGHT_M2);
        assert!(is_usable(&plane.covariance));
        let space = Gaussian::from_first_position::<3>([1.0, 2.0, 3.0], &R, VELOCITY);
        assert_eq!(space.position_m(), [1.0, 2.0, 3.0]);
        assert_eq!(space.covariance.get(2, 2), 9.0);
        assert_eq!(space.covariance.get(5, 5), 225.0);
    }

    #[test]
    fn second_position_finds_the_velocity() {
        let first = Gaussian::from_first_position::<2>([0.0; 3], &R, VELOCITY);
        let noise = [1.0, 1.0, 0.1].map(|density| AxisNoise::white(density, 4.0));
        let mut second = first.moved(4.0, noise);
        second
            .update_position::<2>([800.0, -400.0, 0.0], &R)
            .expect("positive definite");
        let [east, north, up] = second.velocity_mps();
        assert!((east - 200.0).abs() < 1.0 && (north + 100.0).abs() < 1.0 && up == 0.0);
    }
}
