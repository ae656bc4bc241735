//! Cost of one report in the engine alone: the same reports, no bus, no other process.
//!
//! There are two passes, because a clock reading costs about as much as the uncertainty of the measured time. The
//! first pass times a thousand updates together; the median of these means is the *time per update*, which no
//! single reading dominates. The second pass times each update, for the tail, and subtracts the cost of a reading.
//! Both cover the engine only: the cost of building the reports is measured separately and subtracted from the
//! first.
//!
//! Both run the engine at full speed, with tables in warm caches. At a low rate in its own process, other work evicts
//! these tables between updates. A third pass is therefore *paced*: reports are due at their rate, the thread waits for
//! them as fusion's loop does, and reads other memory before, twice as much as the nearest caches hold. Each update is
//! timed.
//!
//! The memory of the engine is that of this process after the warm-up, less that before the engine was made, and less
//! the templates of the reports.
//!
//! Limits: the code of the engine is evicted as far as reading data evicts it, from the caches for both.

use std::hint::black_box;
use std::sync::atomic::Ordering;

use messages::{SensorTrack, SystemTrack, TrackState};
use runtime::Now;
use runtime::cores::Placement;
use serde::{Deserialize, Serialize};

use crate::drive::{Clock as _, MachineClock};
use crate::figures::{Figures, median, range};
use crate::jitter::reading_ns;
use crate::measure::WarmUp;
use crate::memory::resident_octets;
use crate::pinned;
use crate::product::{Engine, Product};
use crate::progress::say;
use crate::recorder::histogram;
use crate::settings::Settings;
use crate::site::config_text;
use crate::traffic::Traffic;

/// Number of updates timed together.
const CHUNK: u64 = 1000;
/// A warm-up that takes longer than this shows its progress, seconds.
const ANNOUNCED_S: f64 = 5.0;
/// Minimum and maximum number of warm-up rounds.
const WARM_UP_ROUNDS: std::ops::Range<u32> = 5..40;
/// Highest rate of the paced pass, reports per second, and octets of other memory that are read before each report.
const PACED_RATE_MAX: f64 = 5_000.0;
const OTHER_MEMORY: usize = 1 << 20;
/// Length of a line of a cache, octets.
const CACHE_LINE: usize = 64;
/// Interval and length of the rests of a real-time thread, nanoseconds.
const REST_EVERY_NS: i64 = 40_000_000;
const REST_NS: i64 = 4_000_000;

/// Times of the engine, see the module's documentation.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EngineTimes {
    /// Median of the means over a thousand updates, nanoseconds.
    pub ns_per_update: f64,
    /// Smallest and largest of these means.
    pub ns_per_update_range: [f64; 2],
    /// Single updates, less the cost of a clock reading; `lost` counts updates without exactly one state.
    pub single: Figures,
    /// Cost of a clock reading, nanoseconds.
    pub reading_ns: u64,
    /// Cost of building a report, nanoseconds.
    pub report_ns: f64,
    /// Warm-up, excluded from all figures.
    pub warm_up: WarmUp,
    /// Means of a thousand updates.
    pub chunks: usize,
    /// Single updates at a rate, with other work between them, less the cost of a clock reading.
    #[serde(default)]
    pub paced: Figures,
    /// Memory of the engine for each target, octets.
    #[serde(default)]
    pub octets_per_target: f64,
}

/// Measures the engine of `product` at a rate of reports, for some seconds; polls `stop` for a request to end.
pub(crate) fn measure(
    product: &dyn Product,
    settings: &Settings,
    (rate_per_s, seconds): (f64, f64),
    watch: impl FnMut() -> anyhow::Result<()>,
) -> anyhow::Result<(EngineTimes, hdrhistogram::Histogram<u64>)> {
    let place = Placement {
        core: Some(settings.fusion_core),
        ..settings.bench_place()
    };
    let config = config_text(settings, rate_per_s);
    pinned::run(place, watch, |abort| {
        let before = resident_octets()?;
        let mut run = EngineRun::new(product.engine(&config)?, settings, rate_per_s);
        let ended = || {
            anyhow::ensure!(!abort.load(Ordering::Relaxed), "ended early");
            Ok(())
        };
        let warm_up = run.warm_up(ended)?;
        let templates = size_of::<SensorTrack>() as f64 * f64::from(settings.targets);
        let grown = resident_octets()? - before - templates;
        let clock = MachineClock;
        let reading_ns = reading_ns(&clock);
        let report_ns = run.report_ns();

        let mut chunks = Vec::new();
        let part_ns = (seconds * 1e9 / 3.0) as i64;
        let mut rest = PeriodicRest::new(settings.realtime_priority.is_some());
        let end_ns = clock.now_ns() + part_ns;
        while chunks.is_empty() || clock.now_ns() < end_ns {
            let start_ns = clock.now_ns();
            for _ in 0..CHUNK {
                run.update();
            }
            let mean = (clock.now_ns() - start_ns) as f64 / CHUNK as f64;
            chunks.push((mean - report_ns).max(0.0));
            rest.now_and_then();
            ended()?;
        }

        let mut single = histogram();
        let odd_before = run.odd;
        let end_ns = clock.now_ns() + part_ns;
        while single.is_empty() || clock.now_ns() < end_ns {
            for _ in 0..CHUNK {
                let report = run.next_report();
                let start_ns = clock.now_ns();
                run.take(&report);
                let took_ns = clock.now_ns() - start_ns;
                single.saturating_record((took_ns - reading_ns as i64).max(1) as u64);
            }
            rest.now_and_then();
            ended()?;
        }
        let paced = run.paced((rate_per_s.min(PACED_RATE_MAX), part_ns), reading_ns, &mut rest, ended)?;
        let (low, high) = range(&chunks);
        let times = EngineTimes {
            ns_per_update: median(&chunks),
            ns_per_update_range: [low, high],
            single: Figures::of(&single, run.odd - odd_before),
            reading_ns,
            report_ns,
            warm_up,
            chunks: chunks.len(),
            paced,
            octets_per_target: grown / f64::from(settings.targets),
        };
        Ok((times, single))
    })
}

struct EngineRun {
    engine: Box<dyn Engine>,
    traffic: Traffic,
    interval_ns: f64,
    start_ns: i64,
    next: u64,
    batch: u64,
    /// Reports without exactly one confirmed state.
    odd: u64,
}

impl EngineRun {
    fn new(engine: Box<dyn Engine>, settings: &Settings, rate_per_s: f64) -> Self {
        let now = Now::read();
        Self {
            engine,
            traffic: Traffic::new(
                settings.targets,
                settings.sources,
                settings.batch,
                now.mono_ns,
                now.utc_ns - now.mono_ns,
            ),
            interval_ns: 1e9 / rate_per_s,
            start_ns: now.mono_ns,
            next: 0,
            batch: settings.batch as u64,
            odd: 0,
        }
    }

    fn report_at(&self, number: u64) -> messages::SensorTrack {
        let (batch, index) = (number / self.batch, number % self.batch);
        // All reports of a batch are due at once; their times must differ from round to round only.
        let due_ns = self.start_ns + (batch as f64 * self.batch as f64 * self.interval_ns) as i64;
        self.traffic
            .report(self.traffic.source(batch), batch, index as usize, due_ns)
    }

    fn next_report(&mut self) -> messages::SensorTrack {
        let report = self.report_at(self.next);
        self.next += 1;
        report
    }

    fn take(&mut self, report: &messages::SensorTrack) {
        let (mut states, mut unconfirmed) = (0u64, 0u64);
        self.engine.take(report, &mut |track: &SystemTrack| {
            states += 1;
            unconfirmed += u64::from(track.state != TrackState::Confirmed as u8);
            black_box(track);
        });
        self.odd += u64::from(states != 1 || unconfirmed != 0);
    }

    fn update(&mut self) {
        let report = self.next_report();
        self.take(&report);
    }

    fn warm_up(&mut self, ended: impl Fn() -> anyhow::Result<()>) -> anyhow::Result<WarmUp> {
        let start_ns = MachineClock.now_ns();
        let mut settled = false;
        for round in 0..WARM_UP_ROUNDS.end {
            let odd = self.odd;
            let mut left = self.traffic.round() * self.batch;
            while left > 0 {
                let some = left.min(CHUNK);
                for _ in 0..some {
                    self.update();
                }
                left -= some;
                ended()?;
            }
            let seconds = (MachineClock.now_ns() - start_ns) as f64 * 1e-9;
            if seconds > ANNOUNCED_S {
                say(&format!("warm-up, round {} after {seconds:.0} s", round + 1));
            }
            settled = self.odd == odd;
            if settled && round >= WARM_UP_ROUNDS.start {
                break;
            }
        }
        Ok(WarmUp {
            reports: self.next,
            seconds: (MachineClock.now_ns() - start_ns) as f64 * 1e-9,
            settled,
        })
    }

    /// Times single updates of reports that are due at a rate, for a duration in nanoseconds, with cold caches.
    fn paced(
        &mut self,
        (rate_per_s, duration_ns): (f64, i64),
        reading_ns: u64,
        rest: &mut PeriodicRest,
        ended: impl Fn() -> anyhow::Result<()>,
    ) -> anyhow::Result<Figures> {
        let (clock, mut single, odd_before) = (MachineClock, histogram(), self.odd);
        let mut other = vec![1u8; OTHER_MEMORY];
        let start_ns = clock.now_ns();
        while single.is_empty() || clock.now_ns() - start_ns < duration_ns {
            let report = self.next_report();
            for octet in other.iter_mut().step_by(CACHE_LINE) {
                *octet = black_box(octet.wrapping_add(1));
            }
            // After a rest or a stall the next due time counts.
            let due_ns = next_due_ns(clock.now_ns() - start_ns, rate_per_s) + start_ns;
            while clock.now_ns() < due_ns {
                std::hint::spin_loop();
            }
            let began_ns = clock.now_ns();
            self.take(&report);
            let took_ns = clock.now_ns() - began_ns;
            single.saturating_record((took_ns - reading_ns as i64).max(1) as u64);
            rest.now_and_then();
            ended()?;
        }
        Ok(Figures::of(&single, self.odd - odd_before))
    }

    /// Returns the cost of building a report, nanoseconds.
    fn report_ns(&self) -> f64 {
        let means = (0..51).map(|_| {
            let start_ns = MachineClock.now_ns();
            for number in 0..CHUNK {
                black_box(self.report_at(self.next + number));
            }
            (MachineClock.now_ns() - start_ns) as f64 / CHUNK as f64
        });
        median(&means.collect::<Vec<_>>())
    }
}

/// Returns the first due time after `passed_ns` at a rate, both from the start.
fn next_due_ns(passed_ns: i64, rate_per_s: f64) -> i64 {
    let interval_ns = (1e9 / rate_per_s) as i64;
    (passed_ns / interval_ns + 1) * interval_ns
}

/// Regular rests that release the core to other threads, needed at real-time priority.
struct PeriodicRest {
    needed: bool,
    last_ns: i64,
}

impl PeriodicRest {
    fn new(needed: bool) -> Self {
        Self {
            needed,
            last_ns: MachineClock.now_ns(),
        }
    }

    fn now_and_then(&mut self) {
        if self.needed && MachineClock.now_ns() - self.last_ns > REST_EVERY_NS {
            MachineClock.sleep(REST_NS);
            self.last_ns = MachineClock.now_ns();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_paced_reports_are_due_at_whole_intervals() {
        let due = [0, 1, 199_999, 200_000, 1_000_001].map(|passed_ns| next_due_ns(passed_ns, 5_000.0));
        assert_eq!(due, [200_000, 200_000, 200_000, 400_000, 1_200_000]);
    }
}
