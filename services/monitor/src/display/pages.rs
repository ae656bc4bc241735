//! An overview as lines of text, for a screen or a pipe.

use messages::CounterClass;
use observed::StandingAlarm;
use telemetry::table::{self, Align, count};
use telemetry::{Span, Stage};

use super::columns::{FittedTable, TableLines, Tone};
use super::overview::{Overview, SourceRow};
use super::view::Page;
use crate::text::{elapsed, several, time_of_day};

/// Knots in a metre per second.
const KNOTS: f64 = 3600.0 / 1852.0;

/// The whole overview, as printed by `--once`.
pub(crate) fn everything(overview: &Overview) -> String {
    let mut text = format!("{}\n", title(overview));
    if let Some(page) = page(overview) {
        text.push_str(&format!("{page}\n"));
    }
    text.push_str(&format!("{}\n", picture(overview).join("\n")));
    for page in Page::ALL {
        let lines = page_lines(overview, page, Span::Total, usize::MAX);
        text.push_str(&format!("\n{}\n", lines.heading));
        for (_, row) in lines.rows {
            text.push_str(&row);
            text.push('\n');
        }
    }
    if let Some(remark) = remark(overview) {
        text.push_str(&format!("\n{remark}\n"));
    }
    text
}

/// A line per interval.
pub(crate) fn line(overview: &Overview) -> String {
    let sum = |of: fn(&SourceRow) -> u64| overview.sources.iter().map(of).sum::<u64>();
    let mut parts = vec![format!("{}  {}", time_of_day(overview.utc_ns), overview.instance)];
    parts.push(elapsed(overview.elapsed_ns));
    parts.extend(recording(overview));
    parts.push(rate(overview));
    let picture = &overview.picture;
    parts.push(format!(
        "tracks: {} confirmed, {} coasted, {} tentative",
        count(picture.confirmed),
        count(picture.coasted),
        count(picture.tentative)
    ));
    parts.push(format!("{} rejected", count(sum(|source| source.rejected))));
    let not_used = sum(|source| source.not_used);
    if not_used > 0 {
        parts.push(format!("{} not used", count(not_used)));
    }
    parts.push(format!("{} lost", count(sum(|source| source.lost))));
    parts.push(format!("{} late", count(sum(|source| source.late))));
    let end_to_end = overview.stage(Stage::EndToEnd, None, Span::Interval);
    if end_to_end.count > 0 {
        let [p50, p99] = [end_to_end.p50_ns, end_to_end.p99_ns].map(|ns| table::duration(ns as f64));
        parts.push(format!("end to end p50 {p50}, p99 {p99}"));
    }
    parts.push(several(restarts(overview), "restart"));
    let troubled = overview.processes.iter().filter(|process| process.state.is_troubled());
    parts.extend(troubled.map(|process| format!("{} {}", process.title, process.state)));
    if !overview.alarms.is_empty() {
        let words: Vec<&str> = overview.alarms.iter().map(|alarm| alarm.alarm).collect();
        parts.push(format!("alarms: {}", words.join(", ")));
    }
    parts.join(" | ") + "\n"
}

/// Title line: the observed deployment.
pub(crate) fn title(overview: &Overview) -> String {
    let mut parts = vec![
        format!("Koseki {}", overview.instance),
        format!("{} UTC", time_of_day(overview.utc_ns)),
        format!("for {}", elapsed(overview.elapsed_ns)),
        rate(overview),
    ];
    parts.extend(recording(overview));
    parts.join("   ")
}

/// Line with the address of the picture, if there is a display.
pub(crate) fn page(overview: &Overview) -> Option<String> {
    let page = overview.page.as_ref()?;
    Some(format!("the picture is at {page}"))
}

fn recording(overview: &Overview) -> Option<String> {
    let reached_ns = overview.recording_ns?;
    Some(format!("recording at {}", time_of_day(reached_ns)))
}

fn rate(overview: &Overview) -> String {
    let per_s: f64 = overview.sources.iter().map(|source| source.per_s).sum();
    format!("{} reports/s", count(per_s.round() as u64))
}

fn restarts(overview: &Overview) -> u64 {
    let restarts = overview.processes.iter().map(|process| u64::from(process.restarts));
    restarts.sum()
}

/// The system tracks by state, and the ends of tracks.
pub(crate) fn picture(overview: &Overview) -> [String; 2] {
    let picture = &overview.picture;
    [
        format!(
            "tracks now   {} confirmed, {} coasted, {} tentative, {} suspended",
            count(picture.confirmed),
            count(picture.coasted),
            count(picture.tentative),
            count(picture.suspended)
        ),
        format!(
            "so far       {} started, {} ended, {} merged, {} split, {}",
            count(picture.started),
            count(picture.ended),
            count(picture.merged),
            count(picture.split),
            several(picture.hand_overs, "hand-over")
        ),
    ]
}

/// Line on the processes: the number of sound processes, and the faults of the others.
pub(crate) fn health(overview: &Overview) -> (Tone, String) {
    let processes = &overview.processes;
    let troubled: Vec<_> = processes.iter().filter(|process| process.state.is_troubled()).collect();
    let well = processes.len() - troubled.len();
    let restarts = restarts(overview);
    let mut text = format!(
        "processes    {well} of {} well, {}",
        processes.len(),
        several(restarts, "restart")
    );
    for process in &troubled {
        text.push_str(&format!("; {} {}", process.title, process.state));
    }
    for process in processes
        .iter()
        .filter(|process| process.restarts > 0 && !process.note.is_empty())
    {
        text.push_str(&format!("; {}: {}", process.title, process.note));
    }
    let tone = match (troubled.is_empty(), restarts) {
        (false, _) => Tone::Alarm,
        (true, 0) => Tone::Plain,
        (true, _) => Tone::Warning,
    };
    (tone, text)
}

/// Warning about figures with less meaning than apparent.
pub(crate) fn remark(overview: &Overview) -> Option<String> {
    if overview.queues_are_full {
        let text = "recordings are worked off as fast as possible: latencies are those of full queues";
        return Some(text.to_owned());
    }
    (overview.missed > 0).then(|| {
        let missed = several(overview.missed, "state");
        format!("{missed} missed here: latencies rest on fewer; nothing else is affected")
    })
}

/// The table of a page, in lines that are no longer than `width` where the columns allow that.
pub(crate) fn page_lines(overview: &Overview, page: Page, span: Span, width: usize) -> TableLines {
    match page {
        Page::Sources => sources(overview, span, width),
        Page::Tracks => tracks(overview, width),
        Page::Stages => stages(overview, span, width),
        Page::Counters => counters(overview, width),
        Page::Processes => processes(overview, width),
        Page::Alarms => alarms(overview, width),
    }
}

/// Alarms that stand.
fn alarms(overview: &Overview, width: usize) -> TableLines {
    let mut rows = FittedTable::new(&[
        ("since", Align::Left, 0),
        ("severity", Align::Left, 2),
        ("alarm", Align::Left, 1),
        ("what", Align::Left, 0),
    ]);
    for alarm in &overview.alarms {
        let cells = [alarm.severity, alarm.alarm, &alarm.text].map(str::to_owned);
        let [severity, kind, text] = cells;
        rows.row(tone(alarm), [time_of_day(alarm.raised_ns), severity, kind, text]);
    }
    rows.lines(width)
}

fn tone(alarm: &StandingAlarm) -> Tone {
    match alarm.severity {
        "warning" => Tone::Warning,
        _ => Tone::Alarm,
    }
}

/// Lines on the worst alarms, at most `most`; the last line summarizes the others.
pub(crate) fn worst_alarms(overview: &Overview, most: usize) -> Vec<(Tone, String)> {
    let alarms = &overview.alarms;
    let shown = if alarms.len() > most { most - 1 } else { alarms.len() };
    let lines = alarms[..shown]
        .iter()
        .map(|alarm| (tone(alarm), format!("alarm        {}", alarm.text)));
    let others = (alarms.len() > shown).then(|| {
        let others = several((alarms.len() - shown) as u64, "more alarm");
        (tone(&alarms[shown]), format!("             … and {others}"))
    });
    lines.chain(others).collect()
}

/// All sources together, then each.
fn sources(overview: &Overview, span: Span, width: usize) -> TableLines {
    let mut rows = FittedTable::new(&[
        ("source", Align::Left, 0),
        ("reports", Align::Right, 0),
        ("per s", Align::Right, 0),
        ("rejected", Align::Right, 1),
        ("lost", Align::Right, 0),
        ("unused", Align::Right, 5),
        ("late", Align::Right, 2),
        ("age", Align::Right, 3),
        ("end to end", Align::Right, 4),
    ]);
    let median = |stage, source| {
        let summary = overview.stage(stage, source, span);
        match summary.count {
            0 => "-".to_owned(),
            _ => table::duration(summary.p50_ns as f64),
        }
    };
    let mut row = |name: &str, counts: [u64; 5], per_s: f64, source| {
        let [taken, _, lost, _, late] = counts;
        let tone = if lost > 0 {
            Tone::Alarm
        } else if late > 0 || taken > 0 && per_s == 0.0 {
            Tone::Warning
        } else {
            Tone::Plain
        };
        let [taken, rejected, lost, not_used, late] = counts.map(count);
        rows.row(
            tone,
            [
                name.to_owned(),
                taken,
                format!("{per_s:.1}"),
                rejected,
                lost,
                not_used,
                late,
                median(Stage::Age, source),
                median(Stage::EndToEnd, source),
            ],
        );
    };
    let counts = |source: &SourceRow| [source.taken, source.rejected, source.lost, source.not_used, source.late];
    let sum = overview.sources.iter().map(counts).fold([0; 5], |sum: [u64; 5], each| {
        std::array::from_fn(|index| sum[index] + each[index])
    });
    let per_s = overview.sources.iter().map(|source| source.per_s).sum();
    row("all sources", sum, per_s, None);
    for source in &overview.sources {
        row(&source.name, counts(source), source.per_s, Some(source.number));
    }
    rows.lines(width)
}

/// Every system track, with its position.
fn tracks(overview: &Overview, width: usize) -> TableLines {
    let mut rows = FittedTable::new(&[
        ("track", Align::Right, 0),
        ("identity", Align::Left, 0),
        ("state", Align::Left, 3),
        ("latitude", Align::Right, 0),
        ("longitude", Align::Right, 0),
        ("FL", Align::Right, 0),
        ("knots", Align::Right, 1),
        ("sources", Align::Left, 2),
        ("age", Align::Right, 0),
    ]);
    let dash = || "-".to_owned();
    for track in &overview.tracks {
        let tone = match track.state {
            "coasted" => Tone::Warning,
            _ => Tone::Plain,
        };
        let degrees = |value: Option<f64>, [positive, negative]: [char; 2], digits: usize| {
            value.map_or_else(dash, |value| {
                let letter = if value < 0.0 { negative } else { positive };
                format!("{:0width$.5}{letter}", value.abs(), width = digits + 6)
            })
        };
        let mark = |number: &u32| if track.centres.contains(number) { "@" } else { "" };
        let sources = track.sources.iter().map(|number| format!("{number}{}", mark(number)));
        let silent = track.silent_centres.iter().map(|number| format!("({number}@)"));
        let sources: Vec<String> = sources.chain(silent).collect();
        rows.row(
            tone,
            [
                track.number.to_string(),
                if track.identity.is_empty() {
                    dash()
                } else {
                    track.identity.clone()
                },
                track.state.to_owned(),
                degrees(track.latitude_deg, ['N', 'S'], 2),
                degrees(track.longitude_deg, ['E', 'W'], 3),
                track
                    .flight_level
                    .map_or_else(dash, |level| format!("{:03}", level.round() as i64)),
                track
                    .speed_mps
                    .map_or_else(dash, |speed_mps| format!("{:.0}", KNOTS * speed_mps)),
                sources.join(" "),
                track.age_s.map_or_else(dash, |age_s| format!("{age_s:.1} s")),
            ],
        );
    }
    rows.lines(width)
}

/// Every stage of all sources, then of each.
fn stages(overview: &Overview, span: Span, width: usize) -> TableLines {
    let rows = overview
        .stages
        .iter()
        .filter(|row| row.source.is_none() || row.total.count > 0);
    let rows = rows.map(|row| {
        let of = row.source.map_or("all sources", |number| overview.source_name(number));
        (format!("{of}: {}", row.stage.label()), row.summary(span))
    });
    latencies(&heading(overview, "stage", span), rows, width)
}

/// The stages of a source, or of all.
pub(crate) fn stages_of(overview: &Overview, source: Option<u16>, span: Span, width: usize) -> TableLines {
    let rows = overview.stages.iter().filter(|row| row.source == source);
    let rows = rows.map(|row| (row.stage.label().to_owned(), row.summary(span)));
    let of = source.map_or("all sources", |number| overview.source_name(number));
    latencies(&heading(overview, of, span), rows, width)
}

fn latencies(heading: &str, stages: impl Iterator<Item = (String, telemetry::Summary)>, width: usize) -> TableLines {
    let mut rows = FittedTable::new(&[
        (heading, Align::Left, 0),
        ("count", Align::Right, 3),
        ("p50", Align::Right, 0),
        ("p90", Align::Right, 2),
        ("p99", Align::Right, 0),
        ("p99.9", Align::Right, 4),
        ("max", Align::Right, 0),
        ("mean", Align::Right, 5),
    ]);
    for (name, summary) in stages {
        let shown = |value: f64| match summary.count {
            0 => "-".to_owned(),
            _ => table::duration(value),
        };
        let [p50, p90, p99, p999, max] = [
            summary.p50_ns,
            summary.p90_ns,
            summary.p99_ns,
            summary.p999_ns,
            summary.max_ns,
        ]
        .map(|value| shown(value as f64));
        let mean = shown(summary.mean_ns);
        rows.row(
            Tone::Plain,
            [name, count(summary.count), p50, p90, p99, p999, max, mean],
        );
    }
    rows.lines(width)
}

fn heading(overview: &Overview, of: &str, span: Span) -> String {
    match span {
        Span::Interval => format!("{of}, last {:.1} s", overview.interval_ns as f64 / 1e9),
        Span::Total => format!("{of}, {}", span_word(span)),
    }
}

/// A span in words.
pub(crate) fn span_word(span: Span) -> &'static str {
    match span {
        Span::Interval => "interval",
        Span::Total => "total",
    }
}

fn counters(overview: &Overview, width: usize) -> TableLines {
    let mut rows = FittedTable::new(&[
        ("by", Align::Left, 0),
        ("of", Align::Left, 0),
        ("counter", Align::Left, 0),
        ("count", Align::Right, 0),
        ("per s", Align::Right, 1),
        ("what", Align::Left, 2),
    ]);
    for row in &overview.counters {
        let tone = match row.counter.class() {
            CounterClass::NetworkTrouble => Tone::Warning,
            _ => Tone::Plain,
        };
        rows.row(
            tone,
            [
                row.process.clone(),
                row.source.clone(),
                row.counter.label().to_owned(),
                count(row.value),
                format!("{:.1}", row.per_s),
                row.counter.sentence().to_owned(),
            ],
        );
    }
    rows.lines(width)
}

fn processes(overview: &Overview, width: usize) -> TableLines {
    let mut rows = FittedTable::new(&[
        ("process", Align::Left, 0),
        ("state", Align::Left, 0),
        ("pid", Align::Right, 1),
        ("restarts", Align::Right, 0),
        ("note", Align::Left, 0),
    ]);
    for process in &overview.processes {
        let tone = match process.restarts {
            _ if process.state.is_troubled() => Tone::Alarm,
            0 => Tone::Plain,
            _ => Tone::Warning,
        };
        rows.row(
            tone,
            [
                process.title.clone(),
                process.state.to_string(),
                process.pid.map_or_else(|| "-".to_owned(), |pid| pid.to_string()),
                count(process.restarts.into()),
                process.note.clone(),
            ],
        );
    }
    rows.lines(width)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::display::sample::overview;
    use crate::golden;

    #[test]
    fn once() {
        golden::assert("top_once.txt", &everything(&overview()));
    }

    #[test]
    fn lines() {
        assert_eq!(
            line(&overview()),
            "22:13:20  demo | 12 s | 926 reports/s | tracks: 78 confirmed, 2 coasted, 1 tentative | 6 rejected | \
             22 not used | 7 lost | 3 late | end to end p50 41.2 µs, p99 412 µs | 1 restart | adapter ads-b silent for 1.5 s | alarms: source-silent\n"
        );
    }

    #[test]
    fn a_recording_says_how_far_it_is() {
        let recorded = Overview {
            recording_ns: Some(1_462_917_600_000_000_000),
            stages: Vec::new(),
            ..overview()
        };
        assert!(title(&recorded).ends_with("926 reports/s   recording at 22:00:00"));
        let line = line(&recorded);
        assert!(
            line.contains("| 12 s | recording at 22:00:00 | 926 reports/s |"),
            "{line}"
        );
        assert!(!line.contains("end to end"), "{line}");
    }

    #[test]
    fn what_makes_figures_less_than_they_seem_is_said() {
        let mut overview = overview();
        assert_eq!(remark(&overview), None);
        overview.missed = 1;
        assert!(remark(&overview).unwrap().starts_with("1 state missed here"));
        overview.queues_are_full = true;
        assert!(remark(&overview).unwrap().contains("full queues"));
    }
}
