//! Worked checks of the state of a deployment.

use messages::{AlarmEvent, OrderStatus, StageTimes};
use test_support::S;

use super::*;

fn health(kind: ProcessKind, name: &str, source: u16, said_s: i64, counters: &[(Counter, u64)]) -> Health {
    let mut health = Health {
        kind: kind as u8,
        incarnation: 1,
        said_ns: said_s * S,
        source,
        life: LifeState::Running as u8,
        ..Health::default()
    };
    for (counter, value) in counters {
        health.counters[*counter] = *value;
    }
    health.with_name(name)
}

fn source(number: u16, name: &str, is_external: bool) -> SourceFacts {
    SourceFacts {
        number,
        name: name.to_owned(),
        adapter: name.to_owned(),
        sensor_of: None,
        is_external,
        silent_after_ns: Some(20 * S),
        period_ns: 4 * S,
        north_offset_rad: None,
    }
}

const FUSION: ProcessKind = ProcessKind::Fusion;
const ADAPTER: ProcessKind = ProcessKind::Adapter;

/// A tracker with two sensors, which its process publishes.
fn joined() -> Deployment {
    let sensor = |number, name| SourceFacts {
        adapter: "sea".to_owned(),
        sensor_of: Some(0),
        ..source(number, name, false)
    };
    Deployment::new(vec![
        source(0, "sea", false),
        sensor(1, "sea.radar"),
        sensor(2, "sea.camera"),
    ])
}

#[test]
fn counts_of_a_tracker_are_not_those_of_its_sensors() {
    let mut observed = joined();
    let counters = [(Counter::Detections, 700), (Counter::Published, 9)];
    observed.take_health(&health(ADAPTER, "sea", NO_SOURCE, 1, &counters));
    assert_eq!(
        observed.source(0).adapter[Counter::Detections],
        700,
        "the only source so far"
    );
    observed.take_health(&health(ADAPTER, "sea", 0, 1, &counters));
    let detections = |number| observed.source(number).adapter[Counter::Detections];
    assert_eq!([0, 1, 2].map(detections), [700, 0, 0]);
    let facts = observed.configured_sources();
    assert_eq!(
        [0, 1, 2].map(|place| observed.is_counted_with_tracker(&facts[place])),
        [false, true, true]
    );
    observed.take_health(&health(ADAPTER, "sea", 2, 1, &[(Counter::Detections, 300)]));
    assert_eq!(observed.source(2).adapter[Counter::Detections], 300);
    assert!(!observed.is_counted_with_tracker(&observed.configured_sources()[2]));
}

#[test]
fn data_are_behind_by_more_than_the_sources_rhythm() {
    let unexplained = |mut observed: Deployment, offset_s: i64| {
        let track = SystemTrack {
            reference_time_ns: (1000 + offset_s) * S,
            ..SystemTrack::default()
        };
        observed.take_tracks(&BatchHeader::default(), &[track], 10 * S, 1000 * S);
        assert_eq!(observed.data_offset_ns(10 * S), Some(offset_s * S));
        observed.unexplained_offset_ns(10 * S).map(|offset_ns| offset_ns / S)
    };
    let plain = || Deployment::new(vec![source(0, "radar", false)]);
    for (offset_s, of_plain, of_tracker) in [(3, 3, 3), (0, 0, 0), (-4, 0, 0), (-7, -3, 0), (-9, -5, -1)] {
        assert_eq!(unexplained(plain(), offset_s), Some(of_plain), "{offset_s}");
        assert_eq!(unexplained(joined(), offset_s), Some(of_tracker), "{offset_s}");
    }
    assert_eq!(plain().unexplained_offset_ns(0), None);
    // A fast source that sends nothing does not make the data of a slow one late.
    let fast = SourceFacts {
        period_ns: S,
        ..source(1, "ads-b", false)
    };
    let mut two = Deployment::new(vec![source(0, "radar", false), fast]);
    two.take_health(&health(ADAPTER, "radar", 0, 9, &[(Counter::Published, 5)]));
    assert_eq!(unexplained(two.clone(), -4), Some(0));
    two.take_health(&health(ADAPTER, "ads-b", 1, 9, &[(Counter::Published, 5)]));
    assert_eq!(unexplained(two, -4), Some(-3));
}

#[test]
fn a_source_is_silent_after_its_longest_usual_silence_and_absent_without_its_adapter() {
    let mut observed = Deployment::new(vec![source(0, "radar", false)]);
    let state = |observed: &Deployment, now_s: i64| {
        let now_ns = now_s * S;
        (
            observed.is_source_absent(0, now_ns),
            observed.is_source_silent(0, now_ns),
        )
    };
    assert_eq!(state(&observed, 100), (true, true));
    let published = |said_s, count| health(ADAPTER, "radar", NO_SOURCE, said_s, &[(Counter::Published, count)]);
    observed.take_health(&published(100, 0));
    assert_eq!(state(&observed, 100), (false, true), "nothing yet");
    for said_s in 101..=125 {
        observed.take_health(&published(said_s, 5));
    }
    assert_eq!(state(&observed, 121), (false, false), "20 s after 101 s");
    assert_eq!(state(&observed, 122), (false, true));
    assert_eq!(state(&observed, 127), (false, true));
    assert_eq!(state(&observed, 128), (true, true), "three seconds without a message");
    let restarted = Health {
        incarnation: 2,
        ..published(130, 0)
    };
    observed.take_health(&restarted);
    assert_eq!(state(&observed, 130), (false, true), "a restart delivers nothing");
    assert_eq!(observed.delivered(0), 5);
}

#[test]
fn a_source_without_an_adapter_is_observed_by_fusion() {
    let mut observed = Deployment::new(vec![source(0, "of-others", true)]);
    assert!(observed.is_source_absent(0, 10 * S) && observed.is_source_silent(0, 10 * S));
    observed.take_health(&health(FUSION, "fusion", NO_SOURCE, 10, &[]));
    observed.take_health(&health(FUSION, "fusion", 0, 10, &[(Counter::Taken, 3)]));
    assert!(!observed.is_source_absent(0, 11 * S) && !observed.is_source_silent(0, 11 * S));
    assert!(observed.is_source_absent(0, 13 * S), "fusion is absent");
}

#[test]
fn only_the_leading_fusion_and_published_tracks_are_signs_of_life() {
    let mut observed = Deployment::default();
    assert!(observed.is_fusion_absent(0));
    observed.take_health(&health(FUSION, "standby", NO_SOURCE, 10, &[]));
    assert!(observed.is_fusion_absent(10 * S));
    observed.take_health(&health(FUSION, "fusion", NO_SOURCE, 10, &[]));
    assert!(!observed.is_fusion_absent(12 * S) && observed.is_fusion_absent(13 * S));
    let of = |incarnation| BatchHeader {
        incarnation,
        ..BatchHeader::default()
    };
    let mut publishers = [5, 5, 3, 3].into_iter();
    let changes = [20, 21, 22, 23].map(|at_s| {
        let header = of(publishers.next().unwrap());
        observed.take_tracks(&header, &[], at_s * S, at_s * S)
    });
    assert_eq!(changes, [true, false, true, false]);
    assert!(!observed.is_fusion_absent(25 * S) && observed.is_fusion_absent(26 * S));
}

#[test]
fn sources_have_names_with_and_without_the_configuration() {
    let of_adapter = health(ADAPTER, "antenna", 4, 1, &[(Counter::RejectedJump, 3)]).with_note("ads-b");
    let of_fusion = health(FUSION, "fusion", 2, 1, &[(Counter::Taken, 7), (Counter::Lost, 1)]);
    let mut guest = Deployment::default();
    for health in [&of_adapter, &of_fusion] {
        guest.take_health(health);
    }
    let states = guest.sources();
    let shown: Vec<_> = states.iter().map(|state| (state.number, state.name.as_str())).collect();
    assert_eq!(shown, [(2, "source 3"), (4, "ads-b")]);
    assert_eq!((states[0].taken(), states[0].lost(), states[1].rejected()), (7, 1, 3));
    let mut configured = Deployment::new(vec![source(0, "radar", false), source(1, "ads-b", false)]);
    configured.take_health(&health(FUSION, "fusion", 1, 1, &[(Counter::Taken, 7)]));
    let names: Vec<String> = configured.sources().into_iter().map(|state| state.name).collect();
    assert_eq!(names, ["radar", "ads-b"]);
    assert_eq!(
        [1, 8, NO_SOURCE].map(|number| configured.source_name(number)),
        ["ads-b", "source 9", "others"]
    );
}

#[test]
fn an_origin_that_is_no_place_changes_nothing() {
    let mut observed = Deployment::default();
    let origin = |latitude_deg| FrameOrigin {
        latitude_deg,
        longitude_deg: 2.0,
        height_m: 0.0,
    };
    assert!(!observed.take_origin(&origin(f64::NAN)) && observed.frame().is_none());
    assert!(observed.take_origin(&origin(41.0)));
    assert!(!observed.take_origin(&origin(41.0)), "the same");
    assert!(!observed.take_origin(&origin(91.0)));
    assert_eq!(observed.origin(), Some(&origin(41.0)));
    let emptied = observed.emptied();
    assert!(emptied.frame().is_some() && emptied.origin() == Some(&origin(41.0)));
}

#[test]
fn latencies_count_in_the_time_of_the_sources() {
    let mut observed = Deployment::default();
    let counters = [(Counter::LiveTracks, 3), (Counter::LiveTracksMax, 9)];
    let mut fusion = health(FUSION, "fusion", NO_SOURCE, 1, &counters);
    fusion.registration.clock_offset_s = 3.0;
    observed.take_health(&fusion);
    let utc_ns = 1_700_000_000 * S;
    let track = SystemTrack {
        trigger_source: 0,
        // The sources' clocks are three seconds ahead of the machine's.
        time_of_measurement_ns: utc_ns + 2 * S,
        stages: StageTimes {
            fused_ns: 2 * S,
            ..StageTimes::default()
        },
        ..SystemTrack::default()
    };
    observed.take_tracks(&BatchHeader::default(), &[track], 2 * S, utc_ns);
    observed.close_interval();
    let age = observed
        .stages()
        .summary(telemetry::Stage::Age, Some(0), telemetry::Span::Total);
    assert_eq!(
        (age.count, age.max_ns.abs_diff(S as u64) < 1_000_000),
        (1, true),
        "{age:?}"
    );
    // A restarted fusion begins again.
    let counters = [(Counter::LiveTracks, 4), (Counter::LiveTracksMax, 5)];
    observed.take_health(&health(FUSION, "fusion", NO_SOURCE, 2, &counters));
    let counts = observed.track_counts();
    assert_eq!((counts.confirmed, counts.live_max), (4, 9));
}

#[test]
fn alarms_and_orders_are_those_of_the_latest_slices() {
    let mut observed = Deployment::default();
    let header = BatchHeader {
        sent_ns: 10 * S,
        ..BatchHeader::default()
    };
    let alarm = |event: AlarmEvent| Alarm {
        event: event.code(),
        ..Alarm::default()
    };
    observed.take_alarms(&header, &[alarm(AlarmEvent::Raised), alarm(AlarmEvent::Cleared)]);
    assert_eq!((observed.alarms(11 * S).len(), observed.alarms(14 * S).len()), (1, 0));
    let order = |number, status: OrderStatus| OrderState {
        number,
        status: status as u8,
        ..OrderState::default()
    };
    observed.take_orders(&[order(1, OrderStatus::InForce)]);
    observed.take_orders(&[order(1, OrderStatus::Refused), order(2, OrderStatus::InForce)]);
    let in_force: Vec<u32> = observed.orders_in_force().map(|state| state.number).collect();
    assert_eq!((observed.orders().len(), in_force), (2, vec![2]));
}

#[test]
fn the_launcher_announces_the_end() {
    let mut observed = Deployment::default();
    let launcher = |life: LifeState, stopping| Health {
        life: life as u8,
        ..health(
            ProcessKind::Launcher,
            "launcher",
            NO_SOURCE,
            1,
            &[(Counter::Stopping, stopping)],
        )
    };
    observed.take_health(&launcher(LifeState::Running, 0));
    assert!(!observed.is_stopping() && !observed.has_ended());
    observed.take_health(&launcher(LifeState::Running, 1));
    assert!(observed.is_stopping() && !observed.has_ended());
    observed.take_health(&launcher(LifeState::Finished, 1));
    assert!(observed.has_ended());
}

#[test]
fn the_value_to_write_against_a_bias_of_azimuth() {
    let bias = |kind, value: f64| messages::Bias {
        kind,
        value: [value, 0.0],
        partner: 1,
        is_certain: true,
        is_removed: false,
    };
    let azimuth = |degrees: f64| bias(messages::BiasKind::Azimuth, degrees.to_radians());
    let turned = |degrees: f64| SourceFacts {
        north_offset_rad: Some(degrees.to_radians()),
        ..source(0, "radar", false)
    };
    assert_eq!(turned(0.0).north_offset_against(&azimuth(0.54)), Some(-0.54));
    assert_eq!(turned(0.2).north_offset_against(&azimuth(-0.5)), Some(0.7));
    let written = turned(0.3).north_offset_against(&azimuth(0.3)).unwrap();
    assert_eq!(format!("{written:.2}"), "0.00");
    assert_eq!(
        turned(0.2).north_offset_against(&bias(messages::BiasKind::Range, 300.0)),
        None
    );
    assert_eq!(source(0, "radar", true).north_offset_against(&azimuth(0.54)), None);
}
