//! Phases of a target's movement, from the truth alone.
//!
//! The mean error of a whole flight hides what users see: a track that lags at the begin of a turn, or a climb rate
//! that is wrong for a quarter of a minute. The seconds of each target are therefore divided into phases.
//!
//! A target accelerates at a second if its velocity changes by more than a limit in the second before or behind it,
//! and by more than a tenth of the limit in the other one. A single noisy velocity changes both of its neighbours,
//! so the second condition costs nothing, but it excludes the last second before a turn. The first seconds of an
//! acceleration are its *entry*, the rest is the *turn*. The seconds behind it are its *exit* and then *after*: a
//! filter needs this time to forget the acceleration. The same division of the rate of climb gives the phases of
//! the vertical, beside *level* and *climb*.

/// Length of the entry of a manoeuvre, seconds.
const ENTRY_S: f64 = 6.0;
/// Time since the manoeuvre at the end of its exit, and at the end of the phase behind, seconds.
const EXIT_S: f64 = 15.0;
const AFTER_S: f64 = 30.0;
/// Interruption that does not end a manoeuvre, seconds.
const PAUSE_S: f64 = 1.0;
/// Share of the limit that the smaller of two neighbouring changes exceeds.
const NEIGHBOUR: f64 = 0.1;
/// Least rate of a climb or descent, m/s.
const CLIMB_MPS: f64 = 2.0;

/// Stage of a manoeuvre.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stage {
    /// No manoeuvre within the last 30 s.
    Steady,
    /// The first 6 s of a manoeuvre.
    Entry,
    /// The rest of the manoeuvre.
    Within,
    /// Up to 15 s since the manoeuvre.
    Exit,
    /// Up to 30 s since the manoeuvre.
    After,
}

/// Phase of movement; a second has several.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MovementPhase {
    /// Key of the phase in JSON.
    pub name: &'static str,
    /// Meaning in a few words.
    pub meaning: &'static str,
}

/// The phases in the order of output: everything, five of the plane, two of the vertical, five of changes of the climb
/// rate.
pub const MOVEMENT_PHASES: [MovementPhase; 13] = [
    phase("all", "all seconds"),
    phase(
        "straight",
        "straight flight at constant speed, 30 s since the last manoeuvre",
    ),
    phase("entry", "the first 6 s of a turn or of a change of speed"),
    phase("turn", "the rest of the turn or of the change of speed"),
    phase("exit", "the 15 s behind it"),
    phase("after", "15 to 30 s behind it"),
    phase("level", "less than 2 m/s up or down"),
    phase("climb", "at least 2 m/s up or down"),
    phase("rate_steady", "constant climb rate, 30 s since its last change"),
    phase("rate_entry", "the first 6 s of a change of the climb rate"),
    phase("rate_change", "the rest of the change"),
    phase("rate_exit", "the 15 s behind it"),
    phase("rate_after", "15 to 30 s behind it"),
];

const fn phase(name: &'static str, meaning: &'static str) -> MovementPhase {
    MovementPhase { name, meaning }
}

/// Set of phases: a bit for each of [`MOVEMENT_PHASES`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PhaseSet(u16);

impl PhaseSet {
    /// The set of a second of which no movement is known.
    pub(crate) const ALL_ALONE: Self = Self(1);

    /// Whether the set has the phase at this place of [`MOVEMENT_PHASES`].
    pub fn has(self, phase: usize) -> bool {
        self.0 >> phase & 1 == 1
    }

    fn new(plane: Stage, rate: Stage, climbs: bool) -> Self {
        let vertical = if climbs { 7 } else { 6 };
        Self(1 | 1 << (1 + plane as u16) | 1 << vertical | 1 << (8 + rate as u16))
    }
}

/// Limits of accelerations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseLimits {
    /// Acceleration in the plane above which a target turns or changes its speed, m/s² (0.5).
    pub turning_mps2: f64,
    /// Vertical acceleration above which a target changes its climb rate, m/s² (0.3).
    pub climbing_mps2: f64,
}

/// Returns the phases of the seconds of one target, which are in the order of time.
pub(crate) fn phases_of(seconds: &[i64], velocities_mps: &[[f64; 3]], limits: &PhaseLimits) -> Vec<PhaseSet> {
    let plane: Vec<[f64; 2]> = velocities_mps.iter().map(|[vx, vy, _]| [*vx, *vy]).collect();
    let rate: Vec<[f64; 1]> = velocities_mps.iter().map(|[_, _, vz]| [*vz]).collect();
    let plane = stages(seconds, &plane, limits.turning_mps2);
    let rate = stages(seconds, &rate, limits.climbing_mps2);
    let climbs = velocities_mps.iter().map(|[_, _, vz]| vz.abs() > CLIMB_MPS);
    let both = plane.into_iter().zip(rate).zip(climbs);
    both.map(|((plane, rate), climbs)| PhaseSet::new(plane, rate, climbs))
        .collect()
}

/// Returns the stage of manoeuvres at each second.
fn stages<const D: usize>(seconds: &[i64], velocities: &[[f64; D]], limit: f64) -> Vec<Stage> {
    let change = |place: usize| {
        let squares = (0..D).map(|axis| (velocities[place + 1][axis] - velocities[place][axis]).powi(2));
        squares.sum::<f64>().sqrt() / (seconds[place + 1] - seconds[place]) as f64
    };
    let changes: Vec<f64> = (0..seconds.len().saturating_sub(1)).map(change).collect();
    let (Some(first), Some(last)) = (changes.first(), changes.last()) else {
        return vec![Stage::Steady; seconds.len()];
    };
    let (mut began_s, mut ended_s): (Option<f64>, Option<f64>) = (None, None);
    let stage = |place: usize| {
        let before = if place == 0 { first } else { &changes[place - 1] };
        let behind = changes.get(place).unwrap_or(last);
        let now_s = seconds[place] as f64;
        if before.max(*behind) > limit && before.min(*behind) > limit * NEIGHBOUR {
            let began_s = *began_s.get_or_insert(now_s);
            ended_s = Some(now_s);
            return if now_s - began_s < ENTRY_S {
                Stage::Entry
            } else {
                Stage::Within
            };
        }
        let Some(since_s) = ended_s.map(|ended_s| now_s - ended_s) else {
            return Stage::Steady;
        };
        if since_s > PAUSE_S {
            began_s = None;
        }
        match since_s {
            since_s if since_s <= EXIT_S => Stage::Exit,
            since_s if since_s <= AFTER_S => Stage::After,
            _ => Stage::Steady,
        }
    };
    (0..seconds.len()).map(stage).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: PhaseLimits = PhaseLimits {
        turning_mps2: 0.5,
        climbing_mps2: 0.3,
    };

    /// Straight until 10 s, then 3 m/s² northward until 20 s, then straight again; seconds 0 to 69.
    fn turn() -> (Vec<i64>, Vec<[f64; 3]>) {
        let seconds: Vec<i64> = (0..70).collect();
        let velocity = |second: &i64| [100.0, 3.0 * (second - 10).clamp(0, 10) as f64, 0.0];
        let velocities = seconds.iter().map(velocity).collect();
        (seconds, velocities)
    }

    #[test]
    fn a_turn_has_entry_exit_and_the_time_behind() {
        let (seconds, velocities) = turn();
        let found = phases_of(&seconds, &velocities, &LIMITS);
        // The velocity changes in the seconds behind 10 to 19; both neighbours of 11 to 19 change.
        let expected = |second: i64| match second {
            11..17 => 2,
            17..20 => 3,
            20..35 => 4,
            35..50 => 5,
            _ => 1,
        };
        for (second, phases) in seconds.iter().zip(&found) {
            let of_plane: Vec<usize> = (1..6).filter(|phase| phases.has(*phase)).collect();
            assert_eq!(of_plane, [expected(*second)], "{second}");
            assert!(phases.has(0) && phases.has(6) && !phases.has(7) && phases.has(8));
        }
    }

    #[test]
    fn a_change_of_the_climb_rate_does_not_touch_the_plane() {
        let seconds: Vec<i64> = (0..40).collect();
        let rate = |second: &i64| [100.0, 0.0, (second - 10).clamp(0, 5) as f64];
        let velocities: Vec<_> = seconds.iter().map(rate).collect();
        let found = phases_of(&seconds, &velocities, &LIMITS);
        assert!(found.iter().all(|phases| phases.has(1)));
        let with = |phase: usize| found.iter().position(|phases| phases.has(phase));
        // 2 m/s is level, 3 m/s is a climb.
        assert_eq!(
            [with(9), with(7), with(11), with(12)],
            [Some(11), Some(13), Some(15), Some(30)]
        );
        assert_eq!(with(10), None, "shorter than an entry");
    }

    #[test]
    fn a_pause_of_a_second_does_not_end_a_turn_and_gaps_count_by_their_length() {
        let stages_of = |speeds: &[(i64, f64)]| {
            let (seconds, speeds): (Vec<i64>, Vec<[f64; 1]>) =
                speeds.iter().map(|(second, speed)| (*second, [*speed])).unzip();
            stages(&seconds, &speeds, 0.5)
        };
        // The change of 1 m/s a second pauses for two seconds: with 0.4 m/s, a single second is quiet, with 0 two are.
        let with_pause = |pause: f64| {
            let change = |second: i64| if (7..9).contains(&second) { pause } else { 1.0 };
            let speed = |second: i64| (0..second).map(change).sum::<f64>();
            stages_of(&(0..12).map(|second| (second, speed(second))).collect::<Vec<_>>())
        };
        use Stage::{Entry, Exit, Within};
        assert_eq!(with_pause(0.4)[6..11], [Within, Within, Exit, Within, Within]);
        assert_eq!(with_pause(0.0)[6..11], [Within, Exit, Exit, Exit, Entry]);
        assert_eq!(
            stages_of(&[(0, 0.0), (10, 4.0), (20, 8.0)]),
            [Stage::Steady; 3],
            "0.4 m/s²"
        );
        assert_eq!(stages_of(&[(0, 0.0)]), [Stage::Steady]);
        assert_eq!(stages_of(&[]), []);
    }
}
