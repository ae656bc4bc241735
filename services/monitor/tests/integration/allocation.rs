//! A turn of the monitor allocates nothing for the states and the health messages that it takes.

use crate::watched::Bench;
use assert_no_alloc::{AllocDisabler, assert_no_alloc};
use messages::{Counter, ProcessKind};

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

#[test]
fn the_steady_state_allocates_nothing() {
    for wait in ["monitor.wait=event", "monitor.wait=poll"] {
        let mut bench = Bench::new(&[wait, "monitor.interval_s=3600.0"]);
        let publish = |bench: &mut Bench, unit_ns: i64| {
            for source in 0..4 {
                bench.fuse(source, 50, unit_ns);
                bench.say(ProcessKind::Fusion, "fusion", source, &[(Counter::Taken, 5)]);
            }
            bench.pass(1_000_000);
        };
        // All sources, processes and tracks have been seen, and the longest latencies.
        publish(&mut bench, 900_000);
        bench.turn();
        for round in 0..100 {
            publish(&mut bench, 1_000 + 7_919 * round);
            let now = bench.clock.get();
            assert_no_alloc(|| bench.monitor_turn(now));
        }
        assert_eq!(bench.own_health().counters[Counter::Taken], 101 * 200);
    }
}
