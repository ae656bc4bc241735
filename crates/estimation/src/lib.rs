//! Gaussian state of a target, and the filter operations on the state.
//!
//! A target's state is position and velocity, (x, y, z, vx, vy, vz), in the system's East-North-Up frame; the estimate
//! is a [`Gaussian`]: a mean and a 6×6 covariance. All tracking and comparison of tracks consists of a few operations:
//!
//! - [`prediction`](NearlyConstantVelocity): to another time,
//! - [`update`](Gaussian::update_position): improvement by a measured position,
//! - [`initiation`](Gaussian::from_first_position): begin from a single measured position,
//! - [`mixture`](Gaussian::mixture): a single state from two states that hold with some probability,
//! - [`plane`](Plane) and [`vertical`](Vertical): the same for parts of a state, and coordinated turns,
//! - [`smoother`](Smoother): improve the states of an interval by later measurements,
//! - [`distance`](statistical_distance): test whether two states belong to the same target,
//! - [`recovery`](recovered): which measurement is behind a sensor track's latest report?
//! - [`definite`](repaired): is an external covariance usable, or can a usable covariance be made?
//! - [`combination`](correlated_combination): a single estimate from several estimates of the same target.
//!
//! All values live on the stack (nalgebra's statically sized matrices): nothing here allocates but the smoother, so
//! that all operations can run in fusion's steady state. Nothing reads a clock: time is an argument.
//!
//! Sources: Y. Bar-Shalom, X. R. Li, T. Kirubarajan, *Estimation with Applications to Tracking and Navigation*
//! (Wiley, 2001), for all but [`repaired`]; the modules name the chapter.

#![forbid(unsafe_code)]

mod backward;
mod clock;
mod combination;
mod common_noise;
mod definite;
mod dense;
mod distance;
mod filtered_step;
mod gaussian;
mod initiation;
mod inverse;
mod mixture;
mod motion;
mod plane;
mod plane_pair;
mod recovery;
mod rows;
mod smoother;
#[cfg(test)]
mod smoother_tests;
#[cfg(test)]
mod testing;
mod update;
mod vertical;

pub use clock::SourceClock;
pub use combination::{
    Criterion, Estimate, INPUTS_MAX, correlated_combination, information_sum, intersection_weights,
    weighted_information,
};
pub use common_noise::SteadyFilter;
pub use definite::{is_positive_definite, is_usable, repaired};
pub use distance::{ComparedComponents, length, squared_length, statistical_distance};
pub use filtered_step::{LinearModel, Moment, Switching};
pub use gaussian::{Gaussian, Matrix3, Matrix6, Symmetric3, Vector6, packed, unpacked};
pub use initiation::FirstVelocity;
pub use inverse::inverse3;
pub use motion::{AxisNoise, NearlyConstantVelocity};
pub use plane::{Plane, Residual, Rotation};
pub use plane_pair::{Moments, PlanePair, Residuals, Two};
pub use recovery::{Recovered, implied_noise, recovered};
pub use smoother::{Smoothed, Smoother};
pub use update::Innovation;
pub use vertical::Vertical;
