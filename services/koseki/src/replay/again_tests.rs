//! Steps of the event log, one after the other.

use std::path::Path;

use deployment::ReportOrder;
use messages::{Covariance, SensorTrack, StepKind, TrackState, WorkStep};

use super::again::{Again, Plan, RunOutcome};

use crate::config::Config;

const PUBLISHER: u64 = 77;

fn again() -> Again {
    let text = "name = \"t\"\n[frame]\nlatitude_deg = 0.0\nlongitude_deg = 0.0\n[time]\norder = \"arrival\"\n\
                [[source]]\nname = \"a\"\n[source.external]\n[fusion.association]\nscan_wait = 0.0\n";
    let config = Config::parse(Path::new("t.toml"), text, &[]).unwrap();
    Again::new(Plan {
        settings: config.engine,
        order: ReportOrder::Arrival,
        origin: 0,
        sources: vec![Some(0)],
        conditions: Vec::new(),
        tolerates: false,
        restores: true,
    })
}

fn report(number: u64) -> SensorTrack {
    SensorTrack {
        time_of_measurement_ns: 1_000_000_000 * number as i64,
        sequence: number,
        track_number: number as u32,
        position_m: [1e4 * number as f64, 0.0, 0.0],
        covariance: Covariance::diagonal([10.0; 3], [2.0; 3]),
        state: TrackState::Confirmed as u8,
        ..SensorTrack::default()
    }
}

fn step(kind: StepKind, sequence: u32, time_ns: i64) -> WorkStep {
    WorkStep {
        time_ns,
        sequence,
        source: 0,
        kind: kind as u8,
        flags: 0,
    }
}

#[test]
fn a_report_in_quarantine_has_no_effect_and_breaks_nothing_off() {
    let mut again = again();
    (0..3).for_each(|number| again.report(0, PUBLISHER, number, &report(number)));
    let steps = [
        step(StepKind::Begin, 0, 5),
        step(StepKind::Publisher, 0, PUBLISHER as i64),
        step(StepKind::Report, 0, 0),
        step(StepKind::Quarantine, 1, 1_000_000_000),
        step(StepKind::Report, 2, 2_000_000_000),
    ];
    for (number, step) in (0..).zip(steps) {
        again.step(1, number, step, 0);
    }
    let mut places = Vec::new();
    let mut take = |outcome: RunOutcome<'_>| match outcome {
        RunOutcome::Input(_) | RunOutcome::Worked(_) => {}
        RunOutcome::State(state) => places.push((state.position_m[0] / 1e4).round() as i32),
        RunOutcome::Began(..) => {}
        RunOutcome::Broke(epoch) => panic!("broken off: {epoch}"),
    };
    again.work(u64::MAX, &mut take).unwrap();
    assert_eq!(places, [0, 2]);
    assert_eq!((again.worked, again.missing), (2, 0));
}
