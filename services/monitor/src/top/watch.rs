//! Combines the messages of a deployment. Pure: messages and times go in, an overview comes out.

use bus::SubscriberCounts;
use messages::{BatchHeader, Counter, CounterClass, NO_SOURCE, SystemTrack};
use observed::{Deployment, process_title as title};
use runtime::Now;

use crate::display::overview::{CounterRow, Overview};
use crate::display::tracks::LatestStates;

/// Maximum number of system tracks with kept states.
const TRACKS_MAX: usize = 20_000;

/// Watch over a deployment.
#[derive(Debug)]
pub(crate) struct DeploymentWatch {
    instance: String,
    begun: Now,
    pub(crate) observed: Deployment,
    states: LatestStates,
}

impl DeploymentWatch {
    /// Nothing is known yet of the deployment that runs as `instance`.
    pub(crate) fn new(instance: &str, begun: Now) -> Self {
        Self {
            instance: instance.to_owned(),
            begun,
            observed: Deployment::default(),
            states: LatestStates::new(TRACKS_MAX),
        }
    }

    /// Takes a received slice of system tracks.
    pub(crate) fn receive(&mut self, header: &BatchHeader, tracks: &[SystemTrack], received: Now) {
        if self
            .observed
            .take_tracks(header, tracks, received.mono_ns, received.utc_ns)
        {
            self.states.clear();
        }
        tracks.iter().for_each(|track| self.states.keep(track));
    }

    /// Ends the present interval, which took `interval_ns`. `own` is the local count of system tracks.
    pub(crate) fn close_interval(&mut self, now: Now, interval_ns: i64, own: SubscriberCounts) -> Overview {
        self.observed.close_interval();
        let observed = &self.observed;
        let waited = |row: &CounterRow| row.counter == Counter::WaitedForConsumers && row.per_s > 0.0;
        let counters = self.counters();
        let processes = observed.book().processes(&[], now.mono_ns);
        Overview {
            instance: self.instance.clone(),
            utc_ns: now.utc_ns,
            elapsed_ns: now.mono_ns - self.begun.mono_ns,
            interval_ns,
            tracks: self.states.rows(observed.frame(), now.utc_ns),
            queues_are_full: counters.iter().any(waited),
            counters,
            missed: own.lost,
            ..Overview::new(observed, &processes, observed.alarms(now.mono_ns), |_| true)
        }
    }

    fn counters(&self) -> Vec<CounterRow> {
        let mut rows = Vec::new();
        for (kind, source, latest) in self.observed.book().all() {
            let counters = latest.counters();
            let counted = Counter::ALL
                .iter()
                .filter(|counter| counter.class() != CounterClass::Level);
            for counter in counted.filter(|counter| counters[**counter] > 0) {
                rows.push(CounterRow {
                    process: title(kind, latest.name()),
                    source: match source {
                        NO_SOURCE => String::new(),
                        source => self.observed.source_name(source),
                    },
                    counter: *counter,
                    value: counters[*counter],
                    per_s: latest.per_s(*counter).unwrap_or(0.0),
                });
            }
        }
        rows
    }
}

#[cfg(test)]
mod tests {
    use messages::{Health, LifeState, ProcessKind, StageTimes};
    use telemetry::{Span, Stage};

    use super::*;
    use test_support::S;

    const UTC_NS: i64 = 1_700_000_000 * S;

    fn now(s: f64) -> Now {
        let ns = (s * 1e9) as i64;
        Now {
            mono_ns: 100 * S + ns,
            utc_ns: UTC_NS + ns,
        }
    }

    fn said(s: f64, kind: ProcessKind, name: &str, source: u16, counters: &[(Counter, u64)]) -> Health {
        let mut health = Health {
            said_ns: now(s).mono_ns,
            incarnation: 7,
            process_id: 40 + kind as u32,
            source,
            kind: kind as u8,
            life: LifeState::Running as u8,
            ..Health::default()
        };
        for (counter, value) in counters {
            health.counters[*counter] = *value;
        }
        health.with_name(name)
    }

    fn closed(watch: &mut DeploymentWatch, s: f64) -> Overview {
        watch.close_interval(now(s), S, SubscriberCounts::default())
    }

    #[test]
    fn sources_are_put_together_from_what_adapter_fusion_and_monitor_say() {
        let mut watch = DeploymentWatch::new("demo", now(0.0));
        let (adapter, fusion, monitor) = (ProcessKind::Adapter, ProcessKind::Fusion, ProcessKind::Monitor);
        let rejected = [(Counter::RejectedJump, 3), (Counter::RejectedTime, 2)];
        watch
            .observed
            .take_health(&said(0.1, adapter, "antenna", 4, &rejected).with_note("ads-b"));
        let taken = |s, taken| said(s, fusion, "fusion", 4, &[(Counter::Taken, taken), (Counter::Lost, 9)]);
        watch.observed.take_health(&taken(0.1, 1_000));
        watch.observed.take_health(&taken(0.6, 1_100));
        watch
            .observed
            .take_health(&said(0.6, fusion, "fusion", 2, &[(Counter::DroppedQueue, 6)]));
        watch
            .observed
            .take_health(&said(0.6, monitor, "monitor", 4, &[(Counter::StagesLate, 8)]));
        let overview = closed(&mut watch, 1.0);
        let [second, fourth] = &overview.sources[..] else {
            panic!("{overview:?}")
        };
        assert_eq!((second.name.as_str(), second.not_used), ("source 3", 6));
        assert_eq!((fourth.name.as_str(), fourth.taken, fourth.lost), ("ads-b", 1_100, 9));
        assert_eq!((fourth.rejected, fourth.late), (5, 8));
        assert_eq!(fourth.per_s, 200.0, "by fusion's own clock");
        watch.observed.take_health(&taken(1.6, 1_150));
        assert_eq!(closed(&mut watch, 2.0).sources[1].per_s, 50.0);
        assert_eq!(
            closed(&mut watch, 3.0).sources[1].per_s,
            0.0,
            "it has said nothing since"
        );
    }

    #[test]
    fn a_restarted_fusion_counts_on() {
        let mut watch = DeploymentWatch::new("demo", now(0.0));
        let fusion = |s, incarnation, taken| Health {
            incarnation,
            ..said(s, ProcessKind::Fusion, "fusion", 0, &[(Counter::Taken, taken)])
        };
        watch.observed.take_health(&fusion(0.2, 1, 500));
        closed(&mut watch, 1.0);
        watch.observed.take_health(&fusion(1.2, 9, 100));
        let overview = closed(&mut watch, 2.0);
        assert_eq!((overview.sources[0].taken, overview.sources[0].per_s), (600, 100.0));
        assert_eq!(overview.processes[0].restarts, 1);
    }

    #[test]
    fn latencies_end_where_fusion_has_published() {
        let mut watch = DeploymentWatch::new("demo", now(0.0));
        let received = now(0.5);
        let header = BatchHeader {
            incarnation: 1,
            ..BatchHeader::default()
        };
        let track = SystemTrack {
            trigger_source: 0,
            time_of_measurement_ns: received.utc_ns - S,
            stages: StageTimes {
                ingested_ns: received.mono_ns - 5_000,
                published_ns: received.mono_ns - 4_000,
                taken_ns: received.mono_ns - 3_000,
                fused_ns: received.mono_ns - 1_000,
            },
            ..SystemTrack::default()
        };
        watch
            .observed
            .take_health(&said(0.1, ProcessKind::Fusion, "fusion", 0, &[]));
        watch.receive(&header, &[track; 3], received);
        let overview = closed(&mut watch, 1.0);
        let end_to_end = overview.stage(Stage::EndToEnd, Some(0), Span::Total);
        assert_eq!((end_to_end.count, end_to_end.max_ns / 10), (3, 400));
        assert!(overview.stages.iter().all(|row| row.stage != Stage::FusedToReceived));
        let later = closed(&mut watch, 2.0);
        let counts = [Span::Interval, Span::Total].map(|span| later.stage(Stage::EndToEnd, None, span).count);
        assert_eq!(counts, [0, 3]);
    }

    #[test]
    fn the_launchers_last_word_is_the_end_and_its_children_are_listed() {
        let mut watch = DeploymentWatch::new("demo", now(0.0));
        let launcher = ProcessKind::Launcher;
        watch
            .observed
            .take_health(&said(0.1, launcher, "launcher", NO_SOURCE, &[]));
        let of_child = Health {
            restarts: 2,
            ..said(0.1, launcher, "radar", 0, &[])
        };
        watch.observed.take_health(&of_child.with_note("was killed by SIGKILL"));
        assert!(!watch.observed.has_ended());
        let overview = closed(&mut watch, 1.0);
        let rows: Vec<(&str, Option<u32>, u32)> = overview
            .processes
            .iter()
            .map(|process| (process.title.as_str(), process.pid, process.restarts))
            .collect();
        assert_eq!(rows, [("launcher", Some(44), 0), ("radar", Some(44), 2)]);
        assert_eq!(
            overview.processes[1].note,
            "the last one was killed by SIGKILL; no health message"
        );
        let finished = Health {
            life: LifeState::Finished as u8,
            ..said(1.1, launcher, "launcher", NO_SOURCE, &[])
        };
        watch.observed.take_health(&finished);
        assert!(watch.observed.has_ended());
    }

    #[test]
    fn every_counter_that_is_not_zero_is_listed_with_its_rate() {
        let mut watch = DeploymentWatch::new("demo", now(0.0));
        let counters: Vec<(Counter, u64)> = Counter::ALL.iter().map(|counter| (*counter, 5)).collect();
        watch
            .observed
            .take_health(&said(0.1, ProcessKind::Adapter, "radar", 0, &[]));
        watch
            .observed
            .take_health(&said(0.6, ProcessKind::Adapter, "radar", 0, &counters).with_note("radar-west"));
        let overview = closed(&mut watch, 1.0);
        assert_eq!(
            overview.counters.len(),
            Counter::ALL.len() - Counter::of(CounterClass::Level).count()
        );
        let row = &overview.counters[0];
        assert_eq!(
            (row.process.as_str(), row.source.as_str()),
            ("adapter radar", "radar-west")
        );
        assert_eq!((row.value, row.per_s), (5, 10.0));
        assert!(overview.queues_are_full, "somebody waits for consumers");
    }
}
