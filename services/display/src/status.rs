//! Status of the deployment as JSON, with the figures of `koseki top`.
//!
//! - `sources`: `number`, `name`, `kind`, `adapter`, `rate_hz`, `heard_s`, `reports`, `lost`, `rejected` {reason:
//!   count}, `refused` (the latest refusals in words), `registration` {`comparisons`, `offset_m` [2],
//!   `offset_sigma_m` [2], `time_offset_s`, `range_bias_m`, `azimuth_bias_deg`, `removed`}, `depends_on` [[name,
//!   correlation]], `errors` (all that fusion has learned of the source's errors, as a sentence), `inflation`,
//!   `clock_offset_s`
//! - `alarms`: `id`, `code`, `name`, `severity`, `event`, `text`, `remedy`, `raised_s`, `changed_s`, `times`,
//!   `process`, `source`, `acknowledged` {`operator`, `time_s`} or `null`, `shelved` {`operator`, `until_s`} or `null`
//! - `alarm_events`: number of all events of alarms so far; `/api/alarms.json` lists the stored ones
//! - `orders`: see [`orders::list`]
//! - `latency`: `stage`, `count`, `p50_us`, `p99_us`, `p999_us`, `max_us`, `buckets` [[upper bound in µs, count]]:
//!   since the start of the display
//! - `processes`: `kind`, `name`, `state`, `pid`, `restarts`, `heard_s`, `note`, `refused`, `figures` [[name, value]]

use std::collections::BTreeMap;

use messages::{Counter, CounterClass, NO_SOURCE, ProcessKind, registration_bits};
use observed::{LatestHealth, StandingAlarm};
use runtime::Now;
use serde_json::{Value, json};
use telemetry::{BUCKET_BOUNDS_NS, Buckets, Span, Stage};

use crate::alarm_book::AlarmId;
use crate::details::seconds;
use crate::orders;
use crate::reasons;
use crate::world::{SourceFact, World};

/// Connected pages.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Audience {
    /// Number of connected pages.
    pub(crate) clients: u64,
    /// Pictures skipped because their readers were behind.
    pub(crate) skipped: u64,
}

/// Returns the status.
pub(crate) fn status(world: &World, audience: Audience, now: Now) -> Value {
    let fusion = if world.observed.is_fusion_absent(now.mono_ns) {
        "silent"
    } else {
        "running"
    };
    let history = world
        .span_ns()
        .map(|[from_ns, to_ns]| json!({"from_s": seconds(from_ns), "to_s": seconds(to_ns)}));
    let sources: Vec<Value> = world.sources.iter().map(|fact| source(world, fact)).collect();
    let offsets_ns = world.data_offsets_ns(now);
    json!({
        "type": "status",
        "time_s": seconds(world.time_ns(now)),
        "fusion": fusion,
        "data_offset_s": offsets_ns.map(|[offset_ns, _]| seconds(offset_ns)),
        "unexplained_offset_s": offsets_ns.map(|[_, unexplained_ns]| seconds(unexplained_ns)),
        "replay": world.is_replay(),
        "history": history,
        "clients": audience.clients,
        "skipped": audience.skipped,
        "sources": sources,
        "alarms": alarms(world, now),
        "alarm_events": world.alarm_book.count(),
        "orders": orders::list(world),
        "latency": latency(world),
        "processes": processes(world, now),
        "system": system(world, audience),
    })
}

/// Returns the sources alone.
pub(crate) fn sources(world: &World, now: Now) -> Value {
    let sources: Vec<Value> = world.sources.iter().map(|fact| source(world, fact)).collect();
    json!({"time_s": seconds(world.time_ns(now)), "sources": sources})
}

/// Converts a monotonic time to UTC seconds.
fn utc_s(mono_ns: i64, now: Now) -> f64 {
    seconds(now.utc_ns - (now.mono_ns - mono_ns))
}

fn source(world: &World, fact: &SourceFact) -> Value {
    let number = fact.source.number;
    let state = world.observed.source(number);
    let refused = Counter::of(CounterClass::Rejection).map(|counter| (counter, state.adapter[counter]));
    let not_used = Counter::of(CounterClass::FusionRejection).map(|counter| (counter, state.fusion[counter]));
    let rejected: BTreeMap<String, u64> = refused
        .chain(not_used)
        .filter(|(_, count)| *count > 0)
        .map(|(counter, count)| (counter.label().trim_start_matches("rejected_").replace('_', " "), count))
        .collect();
    let heard = world
        .sensor_tracks
        .range((number, 0)..=(number, u32::MAX))
        .map(|(_, heard)| heard.time_ns)
        .max();
    let known = &state.registration;
    let horizontal = registration_bits::EAST | registration_bits::NORTH;
    let registration = (known.comparisons > 0.0).then(|| {
        json!({
            "comparisons": known.comparisons,
            "offset_m": known.offset_m[..2],
            "offset_sigma_m": known.offset_sigma_m[..2],
            "time_offset_s": known.time_offset_s,
            "range_bias_m": known.range_bias_m,
            "azimuth_bias_deg": known.azimuth_bias_rad.to_degrees(),
            "removed": known.removes(horizontal) || known.removes(registration_bits::RANGE | registration_bits::AZIMUTH),
        })
    });
    json!({
        "number": number,
        "name": state.name,
        "kind": fact.kind,
        "adapter": fact.source.adapter,
        "rate_hz": state.taken_per_s,
        "heard_s": heard.map(seconds),
        "reports": state.taken(),
        "lost": state.lost(),
        "rejected": rejected,
        "refused": refused_of(world, &state.name),
        "registration": registration,
        "errors": known.to_string(),
        "depends_on": reasons::dependent(known)
            .map(|(number, correlation)| (world.observed.source_name(number), correlation))
            .collect::<Vec<_>>(),
        "inflation": known.covariance_inflation,
        "clock_offset_s": (known.clock_offset_sigma_s > 0.0).then_some(known.clock_offset_s),
    })
}

/// The latest refusals of a source or process, in words; empty if nothing was refused.
fn refused_of(world: &World, name: &str) -> String {
    let refused = world.observed.refused_input().into_iter();
    refused
        .filter(|refused| refused.of == name)
        .map(|refused| refused.text)
        .collect()
}

fn alarms(world: &World, now: Now) -> Vec<Value> {
    let standing = world.observed.alarms(now.mono_ns).iter();
    let rows = standing.filter_map(|alarm| {
        let row = StandingAlarm::from(alarm);
        let treatment = world.alarm_book.treatment(alarm, now.utc_ns);
        let by = |act: Option<(String, i64)>, key: &str| {
            act.map(|(operator, time_ns)| json!({"operator": operator, key: seconds(time_ns)}))
        };
        Some(json!({
            "id": AlarmId::from(alarm).to_string(),
            "acknowledged": by(treatment.acknowledged, "time_s"),
            "shelved": by(treatment.shelved, "until_s"),
            "code": alarm.code,
            "name": row.alarm,
            "severity": row.severity,
            "event": alarm.event()?.word(),
            "text": row.text,
            "remedy": row.remedy,
            "raised_s": seconds(row.raised_ns),
            "changed_s": seconds(alarm.time_ns),
            "times": alarm.times,
            "process": alarm.process(),
            "source": Some(alarm.source).filter(|source| *source != NO_SOURCE),
        }))
    });
    rows.collect()
}

/// Returns the standing alarms and the stored events of alarms, the latest first: `alarms`, `events` [{`time_s`,
/// `event`, `operator`, `name`, `severity`, `text`, `process`}].
pub(crate) fn alarms_and_past(world: &World, now: Now) -> Value {
    let events = world.alarm_book.events().map(|past| {
        let row = StandingAlarm::from(&past.alarm);
        json!({
            "time_s": seconds(past.time_ns),
            "event": past.word,
            "operator": past.operator,
            "name": row.alarm,
            "severity": row.severity,
            "text": row.text,
            "process": past.alarm.process(),
        })
    });
    json!({"alarms": alarms(world, now), "events": events.collect::<Vec<_>>()})
}

fn latency(world: &World) -> Vec<Value> {
    let stages = world.observed.stages();
    let measured = Stage::ALL
        .into_iter()
        .filter(|stage| stage.is_measured(stages.journey().end));
    let rows = measured.filter_map(|stage| {
        let histogram = stages.histogram(stage, None, Span::Total)?;
        let summary = stages.summary(stage, None, Span::Total);
        let us = |ns: u64| ns as f64 / 1e3;
        let counts = Buckets::from(histogram).counts;
        let bounds = BUCKET_BOUNDS_NS.iter().map(|bound_ns| us(*bound_ns)).zip(counts);
        let buckets: Vec<(f64, u64)> = bounds.filter(|(_, count)| *count > 0).collect();
        Some(json!({
            "stage": stage.key(),
            "count": summary.count,
            "p50_us": us(summary.p50_ns),
            "p99_us": us(summary.p99_ns),
            "p999_us": us(summary.p999_ns),
            "max_us": us(summary.max_ns),
            "buckets": buckets,
        }))
    });
    rows.collect()
}

fn processes(world: &World, now: Now) -> Vec<Value> {
    let book = world.observed.book();
    let figures = |latest: &LatestHealth<'_>| -> Vec<(String, String)> {
        let counters = latest.counters();
        let figures = [
            Counter::Published,
            Counter::Taken,
            Counter::Lost,
            Counter::RowsWritten,
            Counter::DatagramsSent,
            Counter::PicturesSent,
            Counter::PicturesSkipped,
            Counter::RequestsRejected,
        ];
        let shown = figures.into_iter().filter(|counter| counters[*counter] > 0);
        shown
            .map(|counter| (counter.label().replace('_', " "), counters[counter].to_string()))
            .collect()
    };
    let processes = world.observed.processes(&[], now.mono_ns).into_iter().map(|process| {
        let latest = process.kind.and_then(|kind| book.whole(kind, &process.name));
        json!({
            "kind": process.kind.map_or("", ProcessKind::word),
            "name": process.name,
            "state": process.state,
            "pid": process.pid,
            "restarts": process.restarts,
            "heard_s": latest.map(|latest| utc_s(latest.time_ns(), now)),
            "note": process.remark(),
            "refused": refused_of(world, &process.title()),
            "figures": latest.as_ref().map(figures).unwrap_or_default(),
        })
    });
    processes.collect()
}

fn system(world: &World, audience: Audience) -> Vec<(&'static str, String)> {
    let fusion = world.observed.book().service(ProcessKind::Fusion, NO_SOURCE);
    let figures = [
        ("tracks", Counter::LiveTracks),
        ("coasted", Counter::CoastedTracks),
        ("tentative", Counter::TentativeTracks),
        ("suspended", Counter::SuspendedTracks),
        ("started", Counter::TracksStarted),
        ("ended", Counter::TracksTerminated),
        ("resumed", Counter::NumbersResumed),
        ("merged", Counter::TracksMerged),
        ("split", Counter::ContributionsSplit),
        ("hand-overs", Counter::HandOvers),
        ("dropped, table full", Counter::DroppedTable),
    ];
    let epoch = world.tracks.values().next().map_or(0, |live| live.track.epoch);
    let mut system = vec![("instance", world.instance.clone()), ("epoch", epoch.to_string())];
    system.extend(figures.map(|(name, counter)| (name, fusion[counter].to_string())));
    system.push(("pages", audience.clients.to_string()));
    system.push(("pictures skipped", audience.skipped.to_string()));
    system
}
