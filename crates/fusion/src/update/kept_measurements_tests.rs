//! Tests of the measurements that are kept for late reports.

use estimation::Gaussian;
use messages::{AXES, Covariance, NS_PER_S};
use proptest::prelude::*;
use source_models::{Correction, Sources};
use test_support::{Random, S};

use super::*;

const WINDOW_NS: i64 = 10 * S;
const SYSTEM: SystemSlot = 1;

fn start() -> TargetFilter {
    let covariance = Covariance::diagonal([40.0, 40.0, 20.0], [15.0, 15.0, 5.0]);
    TargetFilter::new(0, Gaussian::new([0.0; 3], [150.0, 0.0, 0.0], &covariance), false)
}

/// The measurement number `number` of a target that turns hard after 12 s, one every 0.4 s or so; some have a height,
/// some are blunders, some are not used.
fn measurement(seed: u64, number: u32) -> KeptMeasurement {
    let mut random = Random::new(seed ^ (u64::from(number) << 20));
    let time_s = 0.4 * f64::from(number + 1) + random.between(-0.15, 0.15);
    let angle = 0.2 * (time_s - 12.0).max(0.0);
    let straight_s = time_s.min(12.0);
    let noise = if random.unit() < 0.05 { 900.0 } else { 60.0 };
    let mut around = |value: f64| value + random.between(-noise, noise);
    let position_m = [
        around(150.0 * straight_s + 750.0 * angle.sin()),
        around(750.0 * (1.0 - angle.cos())),
        3000.0,
    ];
    let has_height = number % 3 == 1;
    KeptMeasurement {
        time_ns: (time_s * NS_PER_S) as i64,
        track: ((number % 3) as u16, 7),
        measurement: Measurement {
            position_m,
            covariance_m2: [1500.0, 200.0, 0.0, 1200.0, 0.0, 400.0],
            axes: if has_height { AXES } else { 2 },
            has_waited: false,
        },
        is_used: number % 11 != 5,
        has_height,
        correction: Correction::NONE,
        state: Gaussian::new([0.0; AXES], [0.0; AXES], &Covariance::default()),
        point_m: [0.0; 2],
        point_m2: 0.0,
    }
}

/// A system track's filter beside the measurements that are kept.
struct Late {
    filter: TargetFilter,
    kept: KeptMeasurements,
    models: Sources,
    carried: u32,
}

impl Late {
    fn new(window_ns: i64, capacity: usize) -> Self {
        Self {
            filter: start(),
            kept: KeptMeasurements::new(window_ns, capacity, 3),
            models: crate::testing::models(1.0),
            carried: 0,
        }
    }

    fn take(&mut self, measurement: &KeptMeasurement) -> Option<FilterInnovation> {
        let Self {
            filter,
            kept,
            models,
            carried,
        } = self;
        let motion_of = |filter: &TargetFilter| models.motion(filter.estimate.velocity_mps());
        match kept.lateness(SYSTEM, filter.time_ns, measurement.time_ns) {
            Lateness::Kept => {
                if let Some(innovation) = kept.insert(SYSTEM, filter, (measurement, None), motion_of) {
                    return Some(innovation);
                }
                *carried += 1;
            }
            Lateness::InTime => {}
            Lateness::BeyondWindow | Lateness::BeforeChain => *carried += 1,
        }
        kept.begin(SYSTEM, filter);
        measurement.use_in(filter, motion_of);
        kept.append_kept(SYSTEM, filter, measurement);
        None
    }
}

/// The measurements with the time of their arrival: each is late with a probability, by up to `late_s`.
fn arriving(seed: u64, count: u32, late_s: f64) -> Vec<KeptMeasurement> {
    let mut random = Random::new(seed);
    let mut arriving: Vec<(i64, KeptMeasurement)> = (0..count)
        .map(|number| {
            let measurement = measurement(seed, number);
            let is_late = random.unit() < 0.5;
            let delay_s = if is_late { random.between(0.0, late_s) } else { 0.0 };
            (measurement.time_ns + (delay_s * NS_PER_S) as i64, measurement)
        })
        .collect();
    arriving.sort_by_key(|(arrival_ns, _)| *arrival_ns);
    arriving.into_iter().map(|(_, measurement)| measurement).collect()
}

fn octets(filter: &TargetFilter) -> Vec<u8> {
    postcard::to_stdvec(filter).unwrap()
}

proptest! {
    #[test]
    fn late_measurements_give_the_state_of_those_in_time_to_the_bit(seed in 0u64..1 << 40, late_s in 0.5f64..9.9) {
        let arrived = arriving(seed, 100, late_s);
        let mut late = Late::new(WINDOW_NS, 200);
        for measurement in &arrived {
            late.take(measurement);
        }
        let mut in_time = Late::new(0, 0).filter;
        let mut ordered = arrived.clone();
        ordered.sort_by_key(|measurement| measurement.time_ns);
        for measurement in &ordered {
            measurement.use_in(&mut in_time, |filter| late.models.motion(filter.estimate.velocity_mps()));
        }
        prop_assert_eq!(late.carried, 0);
        prop_assert!(octets(&late.filter) == octets(&in_time));
        late.kept.forget(SYSTEM);
        prop_assert_eq!(late.kept.len(), 0);
    }

    #[test]
    fn with_little_room_what_is_lost_is_carried_forward_and_nothing_leaks(seed in 0u64..1 << 40, capacity in 1usize..12) {
        let arrived = arriving(seed, 100, 9.9);
        let mut late = Late::new(WINDOW_NS, capacity);
        for measurement in &arrived {
            late.take(measurement);
            prop_assert!(late.kept.len() <= capacity && late.filter.is_sound());
            prop_assert_eq!(late.kept.len(), late.kept.chains[SYSTEM as usize].length as usize);
        }
        prop_assert!(late.carried > 0);
        late.kept.forget(SYSTEM);
        prop_assert_eq!(late.kept.len(), 0);
        let next = |place: &Place| late.kept.next.get(*place as usize).copied();
        let mut free: Vec<Place> = std::iter::successors(Some(late.kept.free), next).collect();
        free.sort_unstable();
        let used = late.kept.links.len();
        prop_assert!(used <= capacity && free.into_iter().eq((0..used as Place).chain([NOWHERE])));
        prop_assert!(late.kept.filters.len() <= BASES_MAX);
    }
}

#[test]
fn memory_is_used_as_far_as_measurements_are_kept() {
    let mut late = Late::new(WINDOW_NS, 1000);
    let (links, bases) = (late.kept.links.capacity(), late.kept.filters.capacity());
    assert_eq!((late.kept.links.len(), late.kept.filters.len()), (0, 0));
    for measurement in &arriving(7, 30, 0.0) {
        late.take(measurement);
    }
    assert_eq!(late.kept.links.len(), 30);
    assert!((2..=BASES_MAX).contains(&late.kept.filters.len()));
    assert_eq!(
        (late.kept.links.capacity(), late.kept.filters.capacity()),
        (links, bases)
    );
}

#[test]
fn the_window_has_sharp_edges_and_the_chain_a_beginning() {
    let mut late = Late::new(WINDOW_NS, 200);
    for number in 20..75 {
        late.take(&measurement(3, number));
    }
    let now_ns = late.filter.time_ns;
    let lateness = |kept: &KeptMeasurements, time_ns| kept.lateness(SYSTEM, now_ns, time_ns);
    assert_eq!(lateness(&late.kept, now_ns), Lateness::InTime);
    assert_eq!(lateness(&late.kept, now_ns - 1), Lateness::Kept);
    assert_eq!(lateness(&late.kept, now_ns - WINDOW_NS), Lateness::Kept);
    assert_eq!(lateness(&late.kept, now_ns - WINDOW_NS - 1), Lateness::BeyondWindow);
    late.kept.forget(SYSTEM);
    assert_eq!(lateness(&late.kept, now_ns - 1), Lateness::BeforeChain);
    let filter = late.filter;
    late.kept.begin(SYSTEM, &filter);
    assert_eq!(lateness(&late.kept, now_ns - 1), Lateness::BeforeChain);
    let off = KeptMeasurements::new(0, 200, 3);
    assert!(off.links.is_empty() && off.chains.is_empty());
    assert_eq!(lateness(&off, now_ns - 1), Lateness::InTime, "carried forward");
}

#[test]
fn what_was_carried_forward_stays_so_when_the_filter_goes_back_further() {
    let steps: Vec<_> = (0..60).map(|number| measurement(5, number)).collect();
    let mut late = Late::new(WINDOW_NS, 200);
    // Number 30 comes too late for the chain, which begins after number 40; then number 50 comes late.
    steps[40].use_in(&mut late.filter, |filter| {
        late.models.motion(filter.estimate.velocity_mps())
    });
    for number in (41..50).chain([30]).chain(51..60).chain([50]) {
        late.take(&steps[number]);
    }
    assert_eq!(late.carried, 1);
    let mut expected = start();
    for number in (40..50).chain([30]).chain(50..60) {
        steps[number].use_in(&mut expected, |filter| {
            late.models.motion(filter.estimate.velocity_mps())
        });
    }
    assert!(octets(&late.filter) == octets(&expected));
}

#[test]
fn a_late_measurement_has_the_weight_that_the_later_ones_leave_to_it() {
    let mut late = Late::new(WINDOW_NS, 200);
    for number in (0..20).filter(|number| *number != 15) {
        late.take(&measurement(9, number));
    }
    let mut in_time = Late::new(WINDOW_NS, 200);
    (0..15).for_each(|number| {
        in_time.take(&measurement(9, number));
    });
    let motion = in_time.models.motion([150.0, 0.0, 0.0]);
    let at_once = measurement(9, 15).use_in(&mut in_time.filter, |_| motion).unwrap();
    let late_one = late.take(&measurement(9, 15)).unwrap();
    assert!(
        late_one.gain > 0.0 && late_one.gain < 0.6 * at_once.gain,
        "{late_one:?}"
    );
    let last = late.filter.time_ns + S;
    let newest = KeptMeasurement {
        time_ns: last,
        ..measurement(9, 21)
    };
    assert!(late.take(&newest).is_none(), "in time");
}

#[test]
fn a_chain_goes_with_its_filter_and_follows_its_point() {
    let mut late = Late::new(WINDOW_NS, 200);
    for number in (0..20).filter(|number| *number != 15) {
        late.take(&measurement(9, number));
    }
    let length = late.kept.len();
    late.kept.take_over(SYSTEM, 0);
    assert_eq!(
        late.kept.lateness(SYSTEM, late.filter.time_ns, S),
        Lateness::BeforeChain
    );
    late.kept.take_over(0, SYSTEM);
    assert_eq!(late.kept.len(), length);
    let (by_m, mut shifted) = ([30.0, -50.0], measurement(9, 15));
    late.filter.shift(by_m);
    late.kept.shift(SYSTEM, by_m);
    shifted.measurement.refer(by_m.map(|by| -by), 0.0);
    late.take(&shifted).unwrap();
    let mut expected = start();
    for number in 0..20 {
        measurement(9, number).use_in(&mut expected, |filter| {
            late.models.motion(filter.estimate.velocity_mps())
        });
    }
    expected.shift(by_m);
    let [found, expected] = [&late.filter, &expected].map(|filter| filter.estimate.mean);
    assert!(
        found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6),
        "{found:?}"
    );
}

#[test]
fn bases_reach_back_over_the_window_and_are_dense_where_most_reports_come() {
    let mut late = Late::new(WINDOW_NS, 500);
    for number in 0..200 {
        late.take(&measurement(2, number));
        let bases = late.kept.bases(SYSTEM);
        let count = bases.len();
        assert!(bases.is_sorted_by_key(|base| base.time_ns) && count <= BASES_MAX);
        let lengths: u32 = bases.iter().map(|base| base.length).sum();
        assert_eq!(lengths as usize, late.kept.len());
        let [oldest_ns, newest_ns] = [0, count - 1].map(|index| bases[index].time_ns);
        assert!(late.filter.time_ns - newest_ns < BASE_EVERY_NS + S);
        assert!(oldest_ns == 0 || late.filter.time_ns - oldest_ns >= WINDOW_NS);
    }
    assert!(late.kept.len() < 60, "{} measurements in 10 s", late.kept.len());
}

#[test]
fn a_stored_measurement_takes_240_octets_and_gives_back_what_was_kept() {
    assert_eq!(size_of::<Link>(), 240);
    let mut random = Random::new(5);
    let mut some = |scale: f64| random.between(-scale, scale);
    let kept = KeptMeasurement {
        state: Gaussian::new(
            [some(3e5), some(3e5), some(1e4)],
            [some(300.0), some(300.0), some(20.0)],
            &Covariance::diagonal([40.0, 50.0, 20.0], [15.0, 16.0, 5.0]),
        ),
        correction: Correction {
            shift_m: [some(900.0), some(900.0), some(90.0)],
            covariance_scale: 1.7,
            ..Correction::NONE
        },
        point_m: [some(200.0), some(200.0)],
        point_m2: 12.5,
        ..measurement(7, 4)
    };
    let mut stored = StoredMeasurement::NONE;
    stored.write_kept(&kept);
    let back = stored.kept();
    assert_eq!(
        (back.time_ns, back.track, back.is_used),
        (kept.time_ns, kept.track, kept.is_used)
    );
    assert_eq!(back.measurement.position_m, kept.measurement.position_m);
    assert_eq!(
        (back.measurement.axes, back.has_height),
        (kept.measurement.axes, kept.has_height)
    );
    assert_eq!(back.state.position_m(), kept.state.position_m());
    let near = |found: f64, kept: f64, what: &str| assert!((found - kept).abs() <= 1e-7 * kept.abs(), "{what}");
    for axis in 0..AXES {
        near(
            back.state.velocity_mps()[axis],
            kept.state.velocity_mps()[axis],
            "velocity",
        );
        near(back.correction.shift_m[axis], kept.correction.shift_m[axis], "shift");
    }
    for (found, kept) in back.state.covariance.upper.into_iter().zip(kept.state.covariance.upper) {
        near(found, kept, "covariance");
    }
    for (found, kept) in back
        .measurement
        .covariance_m2
        .into_iter()
        .zip(kept.measurement.covariance_m2)
    {
        near(found, kept, "measured covariance");
    }
    near(back.correction.covariance_scale, 1.7, "scale");
    near(back.point_m[1], kept.point_m[1], "point");
    assert_eq!(back.point_m2, 12.5);
}
