//! Paths and identities of the targets.
//!
//! Turn radii follow from the speed at a bank angle of 25°, typical of aircraft; vehicles turn on tens of metres,
//! ships on hundreds.

use std::sync::Arc;

use messages::Callsign;
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};

use crate::path::{ClosedPath, Waypoint};
use crate::random::{Purpose, stream};
use crate::settings::ScenarioSettings;
use crate::target::{Route, SimulatedTarget, TargetKind};

/// Lateral acceleration at 25° of bank, m/s².
const TURN_ACCELERATION_MPS2: f64 = 4.57;
/// Direction of the runway's take-off run, counter-clockwise from east.
const RUNWAY_RAD: f64 = 0.6;
/// Vertical separation of levels, metres (1,000 feet).
const LEVEL_M: f64 = 304.8;
/// Positions of two stacks of holding patterns, as parts of the half width.
const HOLDING_FIXES: [[f64; 2]; 2] = [[0.3, -0.25], [-0.28, 0.32]];
/// Height of a ship's antennas, metres.
const ANTENNA_HEIGHT_M: f64 = 20.0;
/// Turn radius of ships, metres.
const SHIP_TURN_RADIUS_M: f64 = 600.0;
/// Levels of one stack; further targets follow in the same pattern.
const HOLDING_LEVELS: usize = 8;

/// Returns the targets of a scenario, in the order of numbers.
pub(crate) fn targets(settings: &ScenarioSettings, seed: u64) -> Vec<SimulatedTarget> {
    let count = settings.targets as usize;
    let share = |share: f64| ((share * count as f64).round() as usize).min(count);
    let surface = share(settings.surface_share);
    let holding = share(settings.holding_share).min(count - surface);
    let terminal = share(settings.terminal_share).min(count - surface - holding);
    let ships = share(settings.ship_share).min(count - surface - holding - terminal);
    let en_route = count - surface - holding - terminal - ships;
    // Each pair takes two numbers; pairs come first.
    let crossing = (settings.crossing_share * en_route as f64 / 2.0).round() as usize * 2;

    let mut targets: Vec<SimulatedTarget> = Vec::with_capacity(count);
    for index in 0..count {
        let mut random = stream(seed, Purpose::Target, 0, index as u64, 0);
        let target = if index < en_route {
            if index % 2 == 1 && index < crossing {
                // Uses the partner's stream again, so that both follow the same plan.
                let mut partner = stream(seed, Purpose::Target, 0, index as u64 - 1, 0);
                crossing_target(&mut partner, &mut random, settings.half_width_m)
            } else {
                en_route_target(&mut random, settings.half_width_m)
            }
        } else if index < en_route + terminal {
            let turn = (index - en_route) as f64 / terminal as f64;
            terminal_target(&mut random, turn)
        } else if index < en_route + terminal + holding {
            holding_target(&mut random, index - en_route - terminal, settings.half_width_m)
        } else if index < count - ships {
            surface_target(&mut random)
        } else {
            ship_target(&mut random, settings)
        };
        targets.push(with_identity(target, index, seed));
    }
    for formation in settings.drawn_formations(seed) {
        let formation = Arc::new(formation);
        for number in 0..formation.members {
            let formation = Arc::clone(&formation);
            let member = unnamed(TargetKind::Formation, Route::Member { formation, number });
            targets.push(with_identity(member, targets.len(), seed));
        }
    }
    targets
}

fn en_route_target(random: &mut ChaCha8Rng, half_width_m: f64) -> SimulatedTarget {
    let plan = EnRoutePlan::draw(random, half_width_m);
    let path = ClosedPath::new(&plan.waypoints(0.0, [0.0, 0.0]));
    unnamed(TargetKind::EnRoute, alone(path, plan.lead))
}

/// Returns the plan of another target, rotated about a point of its path: both pass that point at the same time,
/// one level apart and a little beside each other.
fn crossing_target(partner: &mut ChaCha8Rng, random: &mut ChaCha8Rng, half_width_m: f64) -> SimulatedTarget {
    let plan = EnRoutePlan::draw(partner, half_width_m);
    let path = ClosedPath::new(&plan.waypoints(0.0, [0.0, 0.0]));
    let meeting = path.at(random.random_range(0.0..path.lap_s())).position_m;
    let side = if random.random_bool(0.5) { 1.0 } else { -1.0 };
    let turn_rad = side * random.random_range(0.35..1.2);
    let turned = plan.waypoints(turn_rad, [meeting[0], meeting[1]]);
    let path = ClosedPath::new(&turned);
    let mut beside = || 70.0 * normal(random);
    let route = Route::Alone {
        lead_s: plan.lead * path.lap_s(),
        path,
        offset_m: [beside(), beside(), LEVEL_M],
    };
    unnamed(TargetKind::EnRoute, route)
}

/// Closed route of six waypoints: the corners of a rectangle, and a bend in each of its long sides.
struct EnRoutePlan {
    centre_m: [f64; 2],
    direction_rad: f64,
    half_length_m: f64,
    half_breadth_m: f64,
    bends_m: [f64; 2],
    speed_mps: f64,
    heights_m: [f64; 2],
    clockwise: bool,
    /// Part of a lap flown at time 0.
    lead: f64,
}

impl EnRoutePlan {
    fn draw(random: &mut ChaCha8Rng, half_width_m: f64) -> Self {
        let speed_mps = random.random_range(180.0..250.0);
        // The bends make corners of up to 96 degrees, whose arcs begin 1.11 radii before the corner.
        let smallest_m = 1.15 * turn_radius_m(speed_mps);
        let half_breadth_m = smallest_m.max(random.random_range(0.12..0.3) * half_width_m);
        let half_length_m = (2.0 * smallest_m).max(random.random_range(0.35..0.65) * half_width_m);
        let level = f64::from(random.random_range(23..38));
        let climb = [0.0, 0.0, 1.0, 2.0][random.random_range(0..4)];
        Self {
            centre_m: [0; 2].map(|_| random.random_range(-0.5..0.5) * half_width_m),
            direction_rad: random.random_range(0.0..std::f64::consts::TAU),
            half_length_m,
            half_breadth_m,
            bends_m: [0; 2].map(|_| random.random_range(-0.1..0.1) * half_length_m),
            speed_mps,
            heights_m: [level * LEVEL_M, (level - climb) * LEVEL_M],
            clockwise: random.random_bool(0.5),
            lead: random.random_range(0.0..1.0),
        }
    }

    /// Returns the waypoints, rotated by `turn_rad` about `about_m`.
    fn waypoints(&self, turn_rad: f64, about_m: [f64; 2]) -> [Waypoint; 6] {
        let (a, b) = (self.half_length_m, self.half_breadth_m);
        let [low, high] = self.heights_m;
        let mut corners = [
            ([-a, -b], low),
            ([0.0, -b + self.bends_m[0]], low),
            ([a, -b], high),
            ([a, b], high),
            ([0.0, b + self.bends_m[1]], high),
            ([-a, b], low),
        ];
        if self.clockwise {
            corners.reverse();
        }
        corners.map(|(place, height_m)| {
            let turned = rotated(place, self.direction_rad);
            let placed = [turned[0] + self.centre_m[0], turned[1] + self.centre_m[1]];
            let from_pivot = [placed[0] - about_m[0], placed[1] - about_m[1]];
            let [x, y] = rotated(from_pivot, turn_rad);
            Waypoint {
                position_m: [x + about_m[0], y + about_m[1]],
                height_m,
                speed_mps: self.speed_mps,
                turn_radius_m: turn_radius_m(self.speed_mps),
                stop_s: 0.0,
            }
        })
    }
}

/// Returns a target that takes off, climbs, flies a wide circuit to one side, descends, lands on the same runway,
/// and takes off again.
fn terminal_target(random: &mut ChaCha8Rng, lead: f64) -> SimulatedTarget {
    let out = random.random_range(15_000.0..25_000.0);
    let back = -random.random_range(30_000.0..45_000.0);
    let side = if random.random_bool(0.5) { 1.0 } else { -1.0 };
    let aside: f64 = side * random.random_range(22_000.0..40_000.0);
    // Highest point reachable on the way at a usual rate of climb.
    let top = 1300.0 + 0.05 * aside.abs();
    let point = |along: f64, across: f64, height_m: f64, speed_mps: f64| Waypoint {
        position_m: rotated([along, across], RUNWAY_RAD),
        height_m,
        speed_mps,
        turn_radius_m: turn_radius_m(speed_mps),
        stop_s: 0.0,
    };
    let waypoints = [
        point(0.0, 0.0, 0.0, 70.0),
        point(2500.0, 0.0, 0.0, 80.0),
        point(out, 0.0, 1300.0, 130.0),
        point(out, aside, top, 170.0),
        point(back, aside, 2500.0, 140.0),
        point(back, 0.0, 1200.0, 110.0),
        point(-15_000.0, 0.0, 850.0, 90.0),
    ];
    unnamed(TargetKind::Terminal, alone(ClosedPath::new(&waypoints), lead))
}

/// Returns a target with minute-long legs joined by half circles; targets of one stack differ by a level.
fn holding_target(random: &mut ChaCha8Rng, place: usize, half_width_m: f64) -> SimulatedTarget {
    let fix = HOLDING_FIXES[place % HOLDING_FIXES.len()].map(|part| part * half_width_m);
    let level = (place / HOLDING_FIXES.len()) % HOLDING_LEVELS;
    let speed_mps = random.random_range(105.0..125.0);
    let radius = turn_radius_m(speed_mps);
    let length = speed_mps * 60.0;
    let waypoints = [
        [-radius, 0.0],
        [length + radius, 0.0],
        [length + radius, 2.0 * radius],
        [-radius, 2.0 * radius],
    ]
    .map(|place| Waypoint {
        position_m: std::array::from_fn(|axis| fix[axis] + place[axis]),
        height_m: (8 + level) as f64 * LEVEL_M,
        speed_mps,
        turn_radius_m: radius,
        stop_s: 0.0,
    });
    let lead = random.random_range(0.0..1.0);
    unnamed(TargetKind::Holding, alone(ClosedPath::new(&waypoints), lead))
}

/// Returns a target on a round along taxiways beside the runway, with a stop.
fn surface_target(random: &mut ChaCha8Rng) -> SimulatedTarget {
    let begin = random.random_range(0.0..1200.0);
    let length = random.random_range(500.0..1300.0);
    let near = random.random_range(180.0..300.0);
    let depth = random.random_range(150.0..600.0);
    let fast = random.random_range(8.0..15.0);
    let corner_speed = random.random_range(3.0..7.0);
    let point = |along: f64, across: f64, speed_mps: f64| Waypoint {
        position_m: rotated([along, across], RUNWAY_RAD),
        speed_mps,
        turn_radius_m: 25.0,
        ..Waypoint::default()
    };
    let mut stop = point(begin + 0.5 * length, near + depth, 0.0);
    stop.stop_s = random.random_range(20.0..60.0);
    let waypoints = [
        point(begin, near, corner_speed),
        point(begin + 0.5 * length, near, fast),
        point(begin + length, near, corner_speed),
        point(begin + length, near + depth, corner_speed),
        stop,
        point(begin, near + depth, corner_speed),
    ];
    let lead = random.random_range(0.0..1.0);
    unnamed(TargetKind::Surface, alone(ClosedPath::new(&waypoints), lead))
}

/// Returns a ship on a round trip of hours between four places at sea, at constant speed.
fn ship_target(random: &mut ChaCha8Rng, settings: &ScenarioSettings) -> SimulatedTarget {
    let half_width_m = settings.half_width_m;
    let speed_mps = random.random_range(1.0 / 3.0..1.0) * settings.ship_speed_max_mps;
    let centre_m = [0; 2].map(|_| random.random_range(-0.5..0.5) * half_width_m);
    let direction_rad = random.random_range(0.0..std::f64::consts::TAU);
    let half_length_m = random.random_range(0.1..0.3) * half_width_m;
    let half_breadth_m = random.random_range(0.05..0.2) * half_width_m;
    let waypoints = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[along, across]| {
        let [x, y] = rotated([along * half_length_m, across * half_breadth_m], direction_rad);
        Waypoint {
            position_m: [x + centre_m[0], y + centre_m[1]],
            height_m: ANTENNA_HEIGHT_M,
            speed_mps,
            turn_radius_m: SHIP_TURN_RADIUS_M,
            stop_s: 0.0,
        }
    });
    let lead = random.random_range(0.0..1.0);
    unnamed(TargetKind::Ship, alone(ClosedPath::new(&waypoints), lead))
}

/// Returns the route along `path`, starting at the fraction `lead` of a lap at time 0.
fn alone(path: ClosedPath, lead: f64) -> Route {
    Route::Alone {
        lead_s: lead * path.lap_s(),
        path,
        offset_m: [0.0; 3],
    }
}

fn unnamed(kind: TargetKind, route: Route) -> SimulatedTarget {
    SimulatedTarget {
        kind,
        route,
        address: 0,
        callsign: *b"        ",
        mode_3a: None,
    }
}

/// Assigns identities. Multiplication by a number prime to the modulus visits every residue once, so identities are
/// unique.
fn with_identity(target: SimulatedTarget, index: usize, seed: u64) -> SimulatedTarget {
    const ADDRESSES_FROM: u32 = 0x84_0000;
    const ADDRESSES: u64 = 1 << 18;
    // Codes above 7400 (octal) include the emergency codes.
    const CODES: u64 = 0o7400;
    let index = index as u64;
    let base = stream(seed, Purpose::Target, 0, u64::MAX, 0).random_range(0..ADDRESSES);
    let kind = target.kind;
    let without_transponder = matches!(kind, TargetKind::Surface | TargetKind::Ship);
    SimulatedTarget {
        address: ADDRESSES_FROM + ((index * 7919 + base) % ADDRESSES) as u32,
        mode_3a: (!without_transponder).then(|| 1 + ((index * 1009 + base) % CODES) as u16),
        callsign: callsign(index, kind),
        ..target
    }
}

fn callsign(index: u64, kind: TargetKind) -> Callsign {
    const OPERATORS: [&str; 6] = ["KSK", "AOI", "HYB", "MZK", "TNB", "YKG"];
    let operator = match kind {
        TargetKind::Surface => "VEH",
        TargetKind::Ship => "SEA",
        _ => OPERATORS[(index % 6) as usize],
    };
    let text = format!("{:<8}", format!("{operator}{:03}", index + 1));
    let mut callsign = *b"        ";
    callsign.copy_from_slice(&text.as_bytes()[..8]);
    callsign
}

fn turn_radius_m(speed_mps: f64) -> f64 {
    speed_mps * speed_mps / TURN_ACCELERATION_MPS2
}

fn rotated([x, y]: [f64; 2], angle_rad: f64) -> [f64; 2] {
    let (sin, cos) = angle_rad.sin_cos();
    [cos * x - sin * y, sin * x + cos * y]
}

fn normal(random: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(random)
}
