//! Verdicts on the performance targets.
//!
//! The pipeline is compared with the parts, measured in the same session: the bare relay and the engine alone.
//! Limits are sums of these, so the limits apply on any machine; the machine's noise is in both sides.

use serde::{Deserialize, Serialize};

use crate::figures::Figures;
use crate::settings::Wait;
use telemetry::table::duration;

/// Time that the pipeline may add to relay and engine in `spin` mode, nanoseconds.
const OWN_NS: f64 = 700.0;
/// Permitted ratio of the pipeline's tail to their tails.
const TAIL_FACTOR: f64 = 3.0;
/// Permitted latency in `event` mode relative to the relay: median and tail.
const EVENT_MIDDLE_FACTOR: f64 = 1.3;
const EVENT_TAIL_FACTOR: f64 = 1.5;

/// Comparison of one figure with its limit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FigureVerdict {
    /// Description of the figure.
    pub what: String,
    /// The figure, nanoseconds.
    pub value_ns: f64,
    /// Limit, nanoseconds.
    pub limit_ns: f64,
    /// Whether the figure is within the limit.
    pub holds: bool,
}

impl FigureVerdict {
    fn new(what: String, value_ns: f64, limit_ns: f64) -> Self {
        Self {
            holds: value_ns <= limit_ns,
            what,
            value_ns,
            limit_ns,
        }
    }

    /// Returns a line for people.
    pub fn line(&self) -> String {
        let sign = if self.holds { "<=" } else { "> " };
        let word = if self.holds { "holds" } else { "does NOT hold" };
        let (value, limit) = (duration(self.value_ns), duration(self.limit_ns));
        format!("{:<13} {}: {value} {sign} {limit}", word, self.what)
    }
}

/// Returns the verdicts on one rate. In batches of several reports (`batch` above 1), reports wait for each other,
/// and the median is not judged.
pub(crate) fn verdicts(
    wait: Wait,
    batch: usize,
    floor: &Figures,
    pipeline: &Figures,
    engine_ns: f64,
    engine: &Figures,
) -> Vec<FigureVerdict> {
    let of = |ns: u64| ns as f64;
    match wait {
        Wait::Event => vec![
            FigureVerdict::new(
                format!("p50 of the pipeline within {EVENT_MIDDLE_FACTOR} x relay"),
                of(pipeline.p50_ns),
                EVENT_MIDDLE_FACTOR * of(floor.p50_ns),
            ),
            FigureVerdict::new(
                format!("p99.9 of the pipeline within {EVENT_TAIL_FACTOR} x relay"),
                of(pipeline.p999_ns),
                EVENT_TAIL_FACTOR * of(floor.p999_ns),
            ),
        ],
        Wait::Spin | Wait::Hybrid => {
            let middle = (batch == 1).then(|| {
                FigureVerdict::new(
                    format!(
                        "p50 of the pipeline within relay {} + engine {} + {}",
                        duration(of(floor.p50_ns)),
                        duration(engine_ns),
                        duration(OWN_NS)
                    ),
                    of(pipeline.p50_ns),
                    of(floor.p50_ns) + engine_ns + OWN_NS,
                )
            });
            let tail = FigureVerdict::new(
                format!(
                    "p99 of the pipeline within {TAIL_FACTOR} x (relay {} + engine {})",
                    duration(of(floor.p99_ns)),
                    duration(of(engine.p99_ns))
                ),
                of(pipeline.p99_ns),
                TAIL_FACTOR * (of(floor.p99_ns) + of(engine.p99_ns)),
            );
            middle.into_iter().chain([tail]).collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_sides_are_shown() {
        let figures = |p50_ns, p99_ns, p999_ns| Figures {
            p50_ns,
            p99_ns,
            p999_ns,
            ..Figures::default()
        };
        let (floor, engine) = (figures(500, 1_000, 20_000), figures(2_000, 4_000, 9_000));
        let spin = verdicts(Wait::Spin, 1, &floor, &figures(3_200, 16_000, 0), 2_000.0, &engine);
        assert_eq!(spin.iter().map(|v| v.holds).collect::<Vec<_>>(), [true, false]);
        assert_eq!(
            spin[1].line(),
            "does NOT hold p99 of the pipeline within 3 x (relay 1.00 µs + engine 4.00 µs): 16.0 µs >  15.0 µs"
        );
        let event = verdicts(Wait::Event, 1, &floor, &figures(600, 0, 31_000), 2_000.0, &engine);
        assert_eq!(
            verdicts(Wait::Spin, 64, &floor, &floor, 2_000.0, &engine).len(),
            1,
            "the tail alone"
        );
        assert_eq!(event.iter().map(|v| v.holds).collect::<Vec<_>>(), [true, false]);
    }
}
