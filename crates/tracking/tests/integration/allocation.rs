//! After its construction the tracker allocates nothing, whatever it is given.

use assert_no_alloc::{AllocDisabler, assert_no_alloc};
use messages::Identity;
use observations::{Detection, DetectionKind, DetectionPlatform, TransponderReply};
use settings::Degrees;
use test_support::S;
use tracking::settings::{Limit, SensorFacts, SensorModel, TrackerCapacity};
use tracking::wide_area::distribution::Sharing;
use tracking::wide_area::group::Groups;
use tracking::wide_area::prior::{Circle, EmissionBand, Prior, TargetType};
use tracking::wide_area::settings::{EarlyConfirmation, EarlyDeletion};
use tracking::wide_area::{Emission, WideAreaReport};
use tracking::{FieldOfView, Settings, Tracker};

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

fn random(state: &mut u64) -> f64 {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    (*state >> 11) as f64 / (1u64 << 53) as f64
}

/// Crowds that come and go, in too little room for all of them.
fn scan(second: i64, state: &mut u64) -> Vec<Detection> {
    let crowd = (40.0 + 200.0 * random(state)) as usize;
    let spread = if second % 10 == 0 { 30.0 } else { 1500.0 };
    let mut detection = |kind| {
        let place = [spread * random(state), spread * random(state), random(state)];
        Detection {
            time_of_measurement_ns: second * S,
            sensor_id: 1,
            scan: second as u32,
            detection_id: 0,
            kind,
            values: if kind == DetectionKind::Bearing {
                [place[2], 0.0, 0.0]
            } else {
                place
            },
            range_rate_mps: None,
            sigmas: Some(
                [10.0, 0.01, 0.01, 1.0].map(|sigma| if kind == DetectionKind::Position2 { 10.0 } else { sigma }),
            ),
            platform_m: [-500.0, -500.0, 0.0],
            platform: DetectionPlatform::default(),
            height: None,
            velocity: None,
            reply: TransponderReply::default(),
            truth: None,
        }
    };
    (0..crowd)
        .map(|number| {
            let kind = if number % 20 == 19 {
                DetectionKind::Bearing
            } else {
                DetectionKind::Position2
            };
            // A third of them reply; a few have the same address and code.
            let mut identity = Identity::default();
            if number % 3 == 0 {
                identity = identity
                    .with_address(1 + number as u32 / 6)
                    .with_mode_3a(number as u16 / 9);
            }
            Detection {
                height: None,
                velocity: None,
                reply: TransponderReply {
                    identity,
                    ..TransponderReply::default()
                },
                ..detection(kind)
            }
        })
        .collect()
}

#[test]
fn scans_allocate_nothing() {
    let mut settings = Settings {
        sensors: vec![SensorFacts {
            sensor_id: 1,
            model: SensorModel {
                resolution_m: Some(2.0),
                field_of_view: Some(FieldOfView {
                    range_m: [0.0, 2500.0],
                    sector_deg: Some([Degrees::of_rad(0.0), Degrees::of_rad(1.5)]),
                    position_m: None,
                }),
                ..SensorModel::default()
            },
            ..SensorFacts::default()
        }],
        capacity: TrackerCapacity {
            tracks: Some(120),
            detections: Some(200),
            open_scans: 2,
        },
        ..Settings::default()
    };
    settings.initiation.speed_sigma_mps = 20.0;
    settings.splitting.start_in_confirmed_gates = true;
    settings.splitting.tentative_tracks = Limit::Computed;
    settings.splitting.company_min = Some(0.3);
    settings.wide_area.tracks_min = 0.0;
    settings.wide_area.sharing = Some(Sharing::default());
    settings.wide_area.groups = Some(Groups { probability_min: 0.3 });
    settings.wide_area.confirmation = Some(EarlyConfirmation {
        new_target_share: 1.0,
        beside_confirmed_only: false,
        confirmation: settings.confirmation,
        company_min: 0.0,
    });
    settings.wide_area.deletion = Some(EarlyDeletion {
        deletion: settings.deletion.limits,
        coverage: None,
    });
    settings.wide_area.knowledge.types = vec![TargetType {
        name: "boat".to_owned(),
        emissions: vec![EmissionBand {
            frequency_hz: [9e9, 1e10],
            pulse_interval_s: None,
        }],
    }];
    settings.wide_area.knowledge.priors = vec![Prior {
        circle: Some(Circle {
            centre_m: [700.0, 700.0],
            radius_m: 1e4,
        }),
        types: [("boat".to_owned(), 0.9)].into(),
        ..Prior::default()
    }];
    let mut tracker = Tracker::new(settings).unwrap();
    let mut state = 12345;
    for second in 0..60 {
        let scan = scan(second, &mut state);
        // Every seventh comes late.
        let time_ns = if second % 7 == 6 {
            (second - 2) * S + 1
        } else {
            second * S
        };
        let report = WideAreaReport {
            time_ns: time_ns - S,
            arrival_ns: time_ns,
            position_m: [700.0 * random(&mut state), 700.0, 0.0],
            velocity_mps: [0.0; 3],
            targets: second as u32 % 9,
            origin_m: None,
        };
        let taken = assert_no_alloc(|| tracker.wide_area(&report));
        assert!(taken.is_ok());
        for nth in 0..30 {
            let emission = Emission {
                time_ns: time_ns - S / 2,
                bearing_rad: 0.05 * f64::from(nth),
                sigma_rad: 0.002,
                platform_m: [-500.0; 2],
                frequency_hz: 9.5e9,
                pulse_interval_s: None,
            };
            let heard = assert_no_alloc(|| tracker.emission(&emission));
            assert!(heard.is_ok());
        }
        let result = assert_no_alloc(|| tracker.scan(1, time_ns, &scan));
        assert!(result.is_ok());
    }
    let counts = tracker.counts();
    assert!(
        counts.dropped_tracks > 0 && counts.late_scans > 0 && counts.confirmed > 0 && counts.wide_area_corrections > 0,
        "{counts:?}"
    );
    assert!(counts.emissions_used > counts.emissions_unclear, "{counts:?}");
}
