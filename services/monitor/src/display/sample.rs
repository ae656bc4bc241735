//! An overview for tests of the display.

use messages::{Counter, LifeState};
use observed::{ProcessState, StandingAlarm, TrackCounts};
use telemetry::{Stage, Summary};

use super::overview::{CounterRow, Overview, ProcessRow, SourceRow, StageRow};
use super::tracks::TrackRow;

pub(crate) fn overview() -> Overview {
    let source = |number: u16, name: &str, taken: u64| SourceRow {
        number,
        name: name.to_owned(),
        taken,
        per_s: taken as f64 / 12.0,
        rejected: 3,
        not_used: 11,
        ..SourceRow::default()
    };
    let summary = |count: u64| Summary {
        count,
        p50_ns: 41_200,
        p90_ns: 98_000,
        p99_ns: 412_000,
        p999_ns: 900_000,
        max_ns: 1_230_000,
        mean_ns: 50_000.0,
    };
    let stages = |source: Option<u16>, scale: u64| {
        let measured = Stage::ALL.into_iter().filter(|stage| *stage != Stage::FusedToReceived);
        measured.map(move |stage| StageRow {
            stage,
            source,
            interval: summary(100 * scale),
            total: summary(1_200 * scale),
        })
    };
    let counter = |process: &str, source: &str, counter, value| CounterRow {
        process: process.to_owned(),
        source: source.to_owned(),
        counter,
        value,
        per_s: value as f64 / 12.0,
    };
    let process = |title: &str, state, restarts, note: &str| ProcessRow {
        title: title.to_owned(),
        state,
        pid: Some(4_711),
        restarts,
        note: note.to_owned(),
    };
    let running = ProcessState::Life(LifeState::Running);
    Overview {
        instance: "demo".to_owned(),
        page: Some("http://127.0.0.1:8900/".to_owned()),
        utc_ns: 1_700_000_000_000_000_000,
        elapsed_ns: 12_000_000_000,
        interval_ns: 1_000_200_000,
        recording_ns: None,
        sources: vec![
            source(0, "radar-west", 1_234),
            SourceRow {
                lost: 7,
                late: 3,
                ..source(3, "ads-b", 9_876)
            },
        ],
        picture: TrackCounts {
            confirmed: 78,
            coasted: 2,
            tentative: 1,
            started: 85,
            ended: 4,
            merged: 3,
            split: 1,
            hand_overs: 12_345,
            ..TrackCounts::default()
        },
        tracks: vec![
            TrackRow {
                number: 12,
                identity: "VLG20M".to_owned(),
                state: "confirmed",
                latitude_deg: Some(41.297_063),
                longitude_deg: Some(2.078_447),
                flight_level: Some(87.4),
                speed_mps: Some(128.6),
                sources: vec![1, 4],
                centres: vec![4],
                silent_centres: vec![5],
                age_s: Some(0.34),
            },
            TrackRow {
                number: 4_711,
                state: "coasted",
                latitude_deg: Some(-0.5),
                longitude_deg: Some(-170.25),
                speed_mps: Some(5.0),
                ..TrackRow::default()
            },
        ],
        stages: stages(None, 3)
            .chain(stages(Some(0), 1))
            .chain(stages(Some(3), 2))
            .collect(),
        counters: vec![
            counter("adapter ads-b", "ads-b", Counter::Records, 9_900),
            counter("adapter ads-b", "ads-b", Counter::RejectedJump, 3),
            counter("adapter ads-b", "", Counter::DatagramsDropped, 17),
            counter("fusion", "ads-b", Counter::Lost, 7),
            counter("fusion", "ads-b", Counter::DroppedQueue, 6),
            counter("fusion", "", Counter::DeadlineMisses, 4),
        ],
        processes: vec![
            process("launcher", running, 0, ""),
            process("adapter ads-b", ProcessState::Silent { for_ns: 1_500_000_000 }, 0, ""),
            process("fusion", running, 1, "the last one was killed by SIGKILL"),
        ],
        alarms: vec![StandingAlarm {
            severity: "major",
            alarm: "source-silent",
            raised_ns: 1_699_999_990_000_000_000,
            text: "radar-west has sent nothing for 24 s, 6 of its periods.".to_owned(),
            remedy: "Look whether the sensor transmits.",
        }],
        queues_are_full: false,
        missed: 0,
    }
}
