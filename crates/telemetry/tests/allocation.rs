//! Recording a state allocates nothing once its source is known and its histograms are long enough.

use assert_no_alloc::{AllocDisabler, assert_no_alloc};
use messages::{StageTimes, SystemTrack};
use telemetry::{Deadlines, Journey, Span, Stage, Stages};

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

const NOW_NS: i64 = 10_000_000_000;
const UTC_NS: i64 = 1_700_000_000_000_000_000;

fn track(source: u16, unit_ns: i64) -> SystemTrack {
    SystemTrack {
        trigger_source: source,
        time_of_measurement_ns: UTC_NS - 100 * unit_ns,
        stages: StageTimes {
            ingested_ns: NOW_NS - 4 * unit_ns,
            published_ns: NOW_NS - 3 * unit_ns,
            taken_ns: NOW_NS - 2 * unit_ns,
            fused_ns: NOW_NS - unit_ns,
        },
        ..SystemTrack::default()
    }
}

#[test]
fn the_steady_state_allocates_nothing() {
    let mut stages = Stages::new(Journey {
        deadlines: Deadlines::default().with(Stage::EndToEnd, Some(1_000)),
        ..Journey::default()
    });
    // The longest latencies first, in both of the histograms that take turns, and in the totals.
    for _ in 0..2 {
        for source in 0..8 {
            stages.record(&track(source, 1_000_000), NOW_NS, UTC_NS);
        }
        stages.close_interval();
    }
    assert_no_alloc(|| {
        for interval in 0..3 {
            for report in 0..10_000 {
                let unit_ns = 1 + (report * 97 + interval) % 1_000_000;
                stages.record(&track((report % 8) as u16, unit_ns), NOW_NS, UTC_NS);
            }
            stages.close_interval();
        }
    });
    assert_eq!(stages.summary(Stage::EndToEnd, None, Span::Total).count, 30_016);
}
