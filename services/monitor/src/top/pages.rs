//! An overview as lines of text, for a screen or a pipe.

use telemetry::table::{self, Align, Table, count, latencies};
use telemetry::{Span, Stage};

use super::overview::Overview;
use super::span_word;
use super::view::Page;
use crate::text::{elapsed, several, time_of_day};

/// The lines of one table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Lines {
    pub(crate) heading: String,
    pub(crate) rows: Vec<String>,
    /// Rows that a person should look at.
    pub(crate) alerts: Vec<usize>,
}

impl Lines {
    fn of(table: &Table) -> Self {
        let text = table.to_string();
        let mut lines = text.lines().map(str::to_owned);
        Self {
            heading: lines.next().unwrap_or_default(),
            rows: lines.collect(),
            alerts: Vec::new(),
        }
    }
}

/// Everything, as `--once` prints it.
pub(super) fn everything(overview: &Overview) -> String {
    let mut text = format!("{}\n{}\n", title(overview), tracks(overview));
    for page in Page::ALL {
        let lines = page_lines(overview, page, Span::Total);
        text.push_str(&format!("\n{}\n", lines.heading));
        for row in lines.rows {
            text.push_str(&row);
            text.push('\n');
        }
    }
    if let Some(remark) = remark(overview) {
        text.push_str(&format!("\n{remark}\n"));
    }
    text
}

/// One line per interval.
pub(super) fn line(overview: &Overview) -> String {
    let sum = |of: fn(&super::overview::SourceRow) -> u64| overview.sources.iter().map(of).sum::<u64>();
    let mut parts = vec![format!("{}  {}", time_of_day(overview.utc_ns), overview.instance)];
    parts.push(rate(overview));
    let picture = &overview.picture;
    parts.push(format!(
        "tracks: {} confirmed, {} coasted, {} tentative",
        count(picture.confirmed),
        count(picture.coasted),
        count(picture.tentative)
    ));
    parts.push(format!("{} rejected", count(sum(|source| source.rejected))));
    parts.push(format!("{} lost", count(sum(|source| source.lost))));
    parts.push(format!("{} late", count(sum(|source| source.late))));
    let end_to_end = overview.stage(Stage::EndToEnd, None, Span::Interval);
    if end_to_end.count > 0 {
        let [p50, p99] = [end_to_end.p50_ns, end_to_end.p99_ns].map(|ns| table::duration(ns as f64));
        parts.push(format!("end to end p50 {p50}, p99 {p99}"));
    }
    let restarts = overview
        .processes
        .iter()
        .map(|process| u64::from(process.restarts))
        .sum();
    parts.push(several(restarts, "restart"));
    let troubled = overview.processes.iter().filter(|process| process.state.is_troubled());
    parts.extend(troubled.map(|process| format!("{} {}", process.title, process.state)));
    parts.join(" | ") + "\n"
}

/// Line that says what is looked at.
pub(super) fn title(overview: &Overview) -> String {
    format!(
        "Koseki {}   {} UTC   watched for {}   {}",
        overview.instance,
        time_of_day(overview.utc_ns),
        elapsed(overview.elapsed_ns),
        rate(overview)
    )
}

fn rate(overview: &Overview) -> String {
    let per_s: f64 = overview.sources.iter().map(|source| source.per_s).sum();
    format!("{} reports/s", count(per_s.round() as u64))
}

/// The system tracks by state.
pub(super) fn tracks(overview: &Overview) -> String {
    let picture = &overview.picture;
    format!(
        "system tracks: {} confirmed, {} coasted, {} tentative; so far {} started, {} ended, {} merged, {} split",
        count(picture.confirmed),
        count(picture.coasted),
        count(picture.tentative),
        count(picture.started),
        count(picture.ended),
        count(picture.merged),
        count(picture.split),
    )
}

/// Warning that the figures are less than they seem.
pub(super) fn remark(overview: &Overview) -> Option<String> {
    if overview.queues_are_full {
        let text = "recordings are worked off as fast as possible: latencies are those of full queues";
        return Some(text.to_owned());
    }
    (overview.missed > 0).then(|| {
        let missed = several(overview.missed, "state");
        format!("{missed} missed here: latencies rest on fewer; nothing else is affected")
    })
}

/// The table of a page.
pub(super) fn page_lines(overview: &Overview, page: Page, span: Span) -> Lines {
    match page {
        Page::Sources => sources(overview, span),
        Page::Stages => stages(overview, span),
        Page::Counters => counters(overview),
        Page::Processes => processes(overview),
    }
}

/// All sources together, then each.
fn sources(overview: &Overview, span: Span) -> Lines {
    let mut rows = Table::new(&[
        ("source", Align::Left),
        ("reports", Align::Right),
        ("per second", Align::Right),
        ("rejected", Align::Right),
        ("lost", Align::Right),
        ("not used", Align::Right),
        ("late", Align::Right),
        ("age of data", Align::Right),
        ("end to end", Align::Right),
    ]);
    let median = |stage, source| {
        let summary = overview.stage(stage, source, span);
        match summary.count {
            0 => "-".to_owned(),
            _ => table::duration(summary.p50_ns as f64),
        }
    };
    let mut row = |name: &str, counts: [u64; 5], per_s: f64, source| {
        let [taken, rejected, lost, not_used, late] = counts.map(count);
        rows.row([
            name.to_owned(),
            taken,
            format!("{per_s:.1}"),
            rejected,
            lost,
            not_used,
            late,
            median(Stage::Age, source),
            median(Stage::EndToEnd, source),
        ]);
    };
    let counts = |source: &super::overview::SourceRow| {
        [source.taken, source.rejected, source.lost, source.not_used, source.late]
    };
    let sum = overview.sources.iter().map(counts).fold([0; 5], |sum: [u64; 5], each| {
        std::array::from_fn(|index| sum[index] + each[index])
    });
    let per_s = overview.sources.iter().map(|source| source.per_s).sum();
    row("all sources", sum, per_s, None);
    for source in &overview.sources {
        row(&source.name, counts(source), source.per_s, Some(source.number));
    }
    Lines::of(&rows)
}

/// Every stage of all sources, then of each.
fn stages(overview: &Overview, span: Span) -> Lines {
    let rows = overview
        .stages
        .iter()
        .filter(|row| row.source.is_none() || row.total.count > 0);
    let rows = rows.map(|row| {
        let of = row.source.map_or("all sources", |number| overview.source_name(number));
        (format!("{of}: {}", row.stage.label()), row.summary(span))
    });
    Lines::of(&latencies(&heading(overview, "stage", span), rows))
}

/// The stages of one source, or of all.
pub(super) fn stages_of(overview: &Overview, source: Option<u16>, span: Span) -> Lines {
    let rows = overview.stages.iter().filter(|row| row.source == source);
    let rows = rows.map(|row| (row.stage.label(), row.summary(span)));
    let of = source.map_or("all sources", |number| overview.source_name(number));
    Lines::of(&latencies(&heading(overview, of, span), rows))
}

fn heading(overview: &Overview, of: &str, span: Span) -> String {
    match span {
        Span::Interval => format!("{of}, last {:.1} s", overview.interval_ns as f64 / 1e9),
        Span::Total => format!("{of}, {}", span_word(span)),
    }
}

fn counters(overview: &Overview) -> Lines {
    let mut rows = Table::new(&[
        ("by", Align::Left),
        ("of", Align::Left),
        ("counter", Align::Left),
        ("count", Align::Right),
        ("per second", Align::Right),
        ("what", Align::Left),
    ]);
    for row in &overview.counters {
        rows.row([
            row.process.clone(),
            row.source.clone(),
            row.counter.label().to_owned(),
            count(row.value),
            format!("{:.1}", row.per_s),
            row.counter.sentence().to_owned(),
        ]);
    }
    Lines::of(&rows)
}

fn processes(overview: &Overview) -> Lines {
    let mut rows = Table::new(&[
        ("process", Align::Left),
        ("state", Align::Left),
        ("pid", Align::Right),
        ("restarts", Align::Right),
        ("note", Align::Left),
    ]);
    for process in &overview.processes {
        rows.row([
            process.title.clone(),
            process.state.to_string(),
            process.pid.map_or_else(|| "-".to_owned(), |pid| pid.to_string()),
            count(process.restarts.into()),
            process.note.clone(),
        ]);
    }
    let troubled = overview.processes.iter().enumerate();
    let troubled = troubled.filter(|(_, process)| process.state.is_troubled());
    Lines {
        alerts: troubled.map(|(index, _)| index).collect(),
        ..Lines::of(&rows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::golden;
    use crate::top::sample::overview;

    #[test]
    fn once() {
        golden::assert("top_once.txt", &everything(&overview()));
    }

    #[test]
    fn lines() {
        assert_eq!(
            line(&overview()),
            "22:13:20  demo | 926 reports/s | tracks: 78 confirmed, 2 coasted, 1 tentative | 6 rejected | 7 lost | \
             3 late | end to end p50 41.2 µs, p99 412 µs | 1 restart | adapter ads-b silent for 1.5 s\n"
        );
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
