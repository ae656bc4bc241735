//! Targets: properties and paths.

use std::sync::Arc;

use messages::Callsign;

use crate::formation::Formation;
use crate::path::{ClosedPath, Kinematics};

/// Kind of a target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TargetKind {
    /// Aircraft between airports, fast and high.
    EnRoute,
    /// Aircraft that departs, flies a wide circuit, and lands.
    Terminal,
    /// Aircraft in a holding pattern.
    Holding,
    /// Vehicle on the airport's surface.
    Surface,
    /// Ship.
    Ship,
    /// Aircraft that flies in formation for a part of its path.
    Formation,
}

impl TargetKind {
    /// Returns the maximum speed of targets of this kind, m/s, vertical speed included.
    pub fn speed_max_mps(self) -> f64 {
        match self {
            Self::EnRoute => 260.0,
            Self::Formation => 300.0,
            Self::Terminal => 200.0,
            Self::Holding => 130.0,
            Self::Surface => 20.0,
            Self::Ship => 30.0,
        }
    }
}

/// One target at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TargetState {
    /// Number of the target, from 0.
    pub id: u32,
    /// Kind of the target.
    pub kind: TargetKind,
    /// East, north, up, metres.
    pub position_m: [f64; 3],
    /// East, north, up, metres per second.
    pub velocity_mps: [f64; 3],
    /// Height above the ellipsoid, metres; above the plane if the Earth is flat.
    pub height_m: f64,
    /// 24-bit address; no two targets share one.
    pub address: u32,
    /// Callsign, padded with blanks; no two targets share one.
    pub callsign: Callsign,
    /// Mode 3/A code; vehicles and ships have none, and the codes of more than 3,840 targets repeat.
    pub mode_3a: Option<u16>,
    /// Whether the target touches the ground.
    pub on_ground: bool,
}

/// One target for all time.
#[derive(Clone, Debug)]
pub(crate) struct SimulatedTarget {
    pub(crate) kind: TargetKind,
    pub(crate) route: Route,
    pub(crate) address: u32,
    pub(crate) callsign: Callsign,
    pub(crate) mode_3a: Option<u16>,
}

/// Path of a target.
#[derive(Clone, Debug)]
pub(crate) enum Route {
    /// Single target.
    Alone {
        path: ClosedPath,
        /// Time within the lap at time 0, seconds.
        lead_s: f64,
        /// Added to every position of the path, metres.
        offset_m: [f64; 3],
    },
    /// Member of a formation.
    Member { formation: Arc<Formation>, number: u32 },
}

impl Route {
    pub(crate) fn at(&self, time_s: f64) -> Kinematics {
        match self {
            Self::Alone { path, lead_s, offset_m } => {
                let mut state = path.at(lead_s + time_s);
                for (coordinate, offset) in state.position_m.iter_mut().zip(offset_m) {
                    *coordinate += offset;
                }
                state
            }
            Self::Member { formation, number } => {
                let mut state = formation.path.at(formation.lead_s + time_s);
                let (beside_m, sideways_mps) = formation.beside(*number, formation.lead_s + time_s);
                for axis in 0..2 {
                    state.position_m[axis] += beside_m[axis];
                    state.velocity_mps[axis] += sideways_mps[axis];
                }
                state
            }
        }
    }
}
