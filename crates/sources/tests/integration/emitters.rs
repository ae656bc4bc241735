//! Sources that measure emitters by arrival times or fixes, as their adapters process them.

use locating::Settings;
use messages::Counter;
use observations::{Arrival, ArrivalTime, EmitterMeasurement, ReadyFix, Receiver, ReceiverName, Sampled as _};
use reception::PlausibilityLimits;
use sources::{BearingLocator, FinderSettings, Samples};

const S: i64 = 1_000_000_000;
const C: f64 = 299_792_458.0;

fn arrival(second: i64, number: usize, at: [f64; 2], emitter: [f64; 2]) -> EmitterMeasurement {
    let way_m = (at[0] - emitter[0]).hypot(at[1] - emitter[1]);
    let receiver = Receiver {
        name: ReceiverName::new(&number.to_string()).unwrap(),
        position_m: [at[0], at[1], 0.0],
    };
    EmitterMeasurement::Arrival(Arrival {
        time_of_measurement_ns: second * S,
        emitter_id: 3,
        time: ArrivalTime::At {
            receiver,
            t_s: second as f64 + way_m / C,
        },
        sigma_s: 1e-7,
        reference_m: None,
    })
}

fn locator() -> BearingLocator {
    let settings = FinderSettings {
        locator: Settings::default(),
        array: None,
        dropped: Vec::new(),
    };
    BearingLocator::new(5, PlausibilityLimits::default(), &settings).unwrap()
}

#[test]
fn a_transmission_waits_for_its_receivers_but_not_for_ever() {
    let mut locator = locator();
    let mut samples = Samples::default();
    let corners = [[-10e3, -10e3], [10e3, -10e3], [10e3, 10e3], [-10e3, 10e3]];
    for second in 0..3 {
        locator.received(second * S);
        for (number, at) in corners.into_iter().enumerate() {
            locator.take(&arrival(second, number, at, [1e3, 2e3]), 0, &mut samples);
        }
        assert_eq!(
            samples.tracks.len() as i64,
            second,
            "the next row completes a transmission"
        );
    }
    locator.elapsed(2 * S + S / 4, 0, &mut samples);
    assert_eq!(samples.tracks.len(), 2);
    locator.elapsed(3 * S, 0, &mut samples);
    assert_eq!(samples.tracks.len(), 3);
    let track = samples.tracks[2];
    assert_eq!(
        (track.track_number, track.source, track.time_of_measurement_ns),
        (3, 5, 2 * S)
    );
    // The topic has every arrival, in the order in which the locator has taken them.
    let published = samples
        .arrivals
        .iter()
        .map(|sample| Arrival::of_sample(sample).unwrap());
    let taken = (0..3).flat_map(|second| {
        let at = corners.into_iter().enumerate();
        at.map(move |(number, at)| arrival(second, number, at, [1e3, 2e3]))
    });
    assert!(published.map(EmitterMeasurement::Arrival).eq(taken));
    let off_m = (track.position_m[0] - 1e3).hypot(track.position_m[1] - 2e3);
    assert!(off_m < 1.0, "{off_m} m off");
    assert!(samples.bearings.is_empty() && samples.platforms.is_empty());
}

#[test]
fn fixes_become_tracks_and_refused_measurements_are_counted() {
    let mut locator = locator();
    let mut samples = Samples::default();
    let fix = |second: i64, variance_m2: f64| {
        EmitterMeasurement::Fix(ReadyFix {
            time_of_measurement_ns: second * S,
            emitter_id: 3,
            position_m: [4e3, 5e3, 0.0],
            covariance_m2: [variance_m2, 0.0, variance_m2],
        })
    };
    locator.take(&fix(1, 100.0), 0, &mut samples);
    locator.take(&fix(2, -1.0), 0, &mut samples);
    locator.take(&arrival(3, 1, [0.0, 0.0], [1e3, 2e3]), 0, &mut samples);
    locator.received(9 * S);
    locator.take(&fix(9, 100.0), 0, &mut samples);
    assert_eq!(samples.tracks.len(), 2);
    let published: Vec<i64> = samples.fixes.iter().map(|fix| fix.time_of_measurement_ns / S).collect();
    assert_eq!(published, [1, 9], "the fixes that were taken");
    let mut counters = messages::Counters::default();
    locator.count(&mut counters);
    // A fix without a covariance, and a transmission at one receiver.
    assert_eq!(
        (counters[Counter::Detections], counters[Counter::DetectionsRejected]),
        (3, 2)
    );
}

/// The arrival that shows that the transmission before it has one receiver only begins a transmission of its own.
#[test]
fn an_arrival_after_a_lonely_one_is_published_and_waits_by_the_clock() {
    let mut locator = locator();
    let mut samples = Samples::default();
    let rejected = |locator: &BearingLocator| {
        let mut counters = messages::Counters::default();
        locator.count(&mut counters);
        counters[Counter::DetectionsRejected]
    };
    let lonely = arrival(1, 0, [-10e3, -10e3], [1e3, 2e3]);
    locator.take(&lonely, 0, &mut samples);
    locator.received(S);
    locator.take(&lonely, 0, &mut samples);
    assert_eq!((samples.arrivals.len(), rejected(&locator)), (2, 1));
    locator.elapsed(2 * S, 0, &mut samples);
    assert_eq!(rejected(&locator), 2);
    let EmitterMeasurement::Arrival(mut unusable) = lonely else {
        panic!("an arrival")
    };
    unusable.sigma_s = -1.0;
    locator.take(&EmitterMeasurement::Arrival(unusable), 0, &mut samples);
    assert_eq!((samples.arrivals.len(), rejected(&locator)), (2, 3));
}
