//! Draws an overview. A pure function of what is known and what is chosen to be seen; whatever does not fit is cut.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Style, Stylize as _};
use ratatui::text::{Line, Span as Piece};

use super::overview::Overview;
use super::pages::{self, Lines};
use super::span_word;
use super::view::{Page, View};

const HELP: &str = "q quit  Tab 1-4 page  ↑↓ select  i interval/total  p pause";

/// Rows on the page: among so many can be selected.
pub(super) fn rows(overview: Option<&Overview>, view: &View) -> usize {
    overview.map_or(0, |overview| {
        pages::page_lines(overview, view.page, view.span).rows.len()
    })
}

/// Draws one screen; before the first interval is over, there is no overview yet.
pub(super) fn draw(frame: &mut Frame<'_>, instance: &str, overview: Option<&Overview>, view: &View) {
    let [title, tabs, body, help] = Layout::vertical([
        Constraint::Length(1),
        Constraint::Length(2),
        Constraint::Fill(1),
        Constraint::Length(1),
    ])
    .areas(frame.area());
    frame.render_widget(Line::from(HELP).dim(), help);
    frame.render_widget(tab_line(view), tabs);
    let Some(overview) = overview else {
        frame.render_widget(Line::from(format!("Koseki {instance}   listening …")).bold(), title);
        return;
    };
    frame.render_widget(Line::from(pages::title(overview)).bold(), title);
    let lines = pages::page_lines(overview, view.page, view.span);
    match view.page {
        Page::Sources => draw_sources(frame, body, overview, view, &lines),
        _ => draw_lines(frame, body, &lines, view.selected(lines.rows.len())),
    }
}

fn tab_line(view: &View) -> Line<'static> {
    let mut pieces = Vec::new();
    for (index, page) in Page::ALL.into_iter().enumerate() {
        let tab = Piece::from(format!(" {} {} ", index + 1, page.word()));
        pieces.push(if page == view.page { tab.reversed() } else { tab });
    }
    pieces.push(Piece::from(format!("   latencies: {}", span_word(view.span))));
    if view.paused {
        pieces.push(Piece::from("   paused").style(Style::new().fg(Color::Yellow).bold()));
    }
    Line::from(pieces)
}

/// Sources above; below, the system tracks, and the stages of the selected source.
fn draw_sources(frame: &mut Frame<'_>, body: Rect, overview: &Overview, view: &View, lines: &Lines) {
    let selected = view.selected(lines.rows.len());
    // The first row is that of all sources together.
    let source = selected.checked_sub(1).and_then(|index| overview.sources.get(index));
    let stages = pages::stages_of(overview, source.map(|source| source.number), view.span);
    let remark = pages::remark(overview);
    let below = [1, 1, 1 + stages.rows.len() as u16, u16::from(remark.is_some())];
    let [above, _, tracks, _, table, last] = Layout::vertical([
        Constraint::Min(2),
        Constraint::Length(1),
        Constraint::Length(below[0]),
        Constraint::Length(below[1]),
        Constraint::Length(below[2]),
        Constraint::Length(below[3]),
    ])
    .areas(body);
    draw_lines(frame, above, lines, selected);
    frame.render_widget(Line::from(pages::tracks(overview)), tracks);
    // Nothing can be selected there.
    draw_lines(frame, table, &stages, usize::MAX);
    if let Some(remark) = remark {
        frame.render_widget(Line::from(remark).style(Style::new().fg(Color::Yellow)), last);
    }
}

/// The heading, and as many rows as fit, so that the `selected` one is among them.
fn draw_lines(frame: &mut Frame<'_>, area: Rect, lines: &Lines, selected: usize) {
    let [heading, body] = Layout::vertical([Constraint::Length(1), Constraint::Fill(1)]).areas(area);
    frame.render_widget(Line::from(lines.heading.as_str()).bold(), heading);
    let height = usize::from(body.height);
    let first = match selected {
        usize::MAX => 0,
        selected => (selected + 1).saturating_sub(height),
    };
    let shown = lines.rows.iter().enumerate().skip(first).take(height);
    for (place, (index, row)) in body.rows().zip(shown) {
        let mut line = Line::from(row.as_str());
        if lines.alerts.contains(&index) {
            line = line.style(Style::new().fg(Color::Red));
        }
        if index == selected {
            line = line.reversed();
        }
        frame.render_widget(line, place);
    }
}

#[cfg(test)]
mod tests {
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;

    use super::*;
    use crate::golden;
    use crate::top::sample::overview;
    use crate::top::view::Key;

    /// The screen as text, and which of its lines are set off.
    fn screen(width: u16, height: u16, overview: Option<&Overview>, keys: &[Key]) -> (String, Vec<usize>) {
        let mut view = View::default();
        for key in keys {
            assert!(view.press(*key, rows(overview, &view)));
        }
        let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
        terminal.draw(|frame| draw(frame, "demo", overview, &view)).unwrap();
        let buffer = terminal.backend().buffer();
        let mut text = String::new();
        let mut selected = Vec::new();
        for (index, line) in buffer.content.chunks(usize::from(width)).enumerate() {
            let symbols: String = line.iter().map(|cell| cell.symbol()).collect();
            text.push_str(symbols.trim_end());
            text.push('\n');
            let modifier = ratatui::style::Modifier::REVERSED;
            if line[0].modifier.contains(modifier) && index > 1 {
                selected.push(index);
            }
        }
        (text, selected)
    }

    #[test]
    fn the_sources_and_the_stages_of_the_selected_one() {
        let overview = overview();
        let (text, selected) = screen(100, 24, Some(&overview), &[]);
        golden::assert("top_sources.txt", &text);
        assert_eq!(selected, [4], "all sources");
        let (text, selected) = screen(100, 24, Some(&overview), &[Key::Move(1), Key::Move(1), Key::Span]);
        golden::assert("top_source_total.txt", &text);
        assert_eq!(selected, [6], "ads-b");
    }

    #[test]
    fn the_other_pages() {
        let overview = overview();
        for (page, file) in [
            (Page::Stages, "top_stages.txt"),
            (Page::Counters, "top_counters.txt"),
            (Page::Processes, "top_processes.txt"),
        ] {
            let (text, _) = screen(120, 20, Some(&overview), &[Key::Page(page), Key::Pause]);
            golden::assert(file, &text);
        }
    }

    #[test]
    fn a_small_terminal_shows_the_selected_row_and_no_terminal_is_too_small() {
        let overview = overview();
        let keys = [Key::Page(Page::Counters), Key::Move(100)];
        let (text, selected) = screen(40, 7, Some(&overview), &keys);
        golden::assert("top_small.txt", &text);
        assert_eq!(selected, [5]);
        for page in Page::ALL {
            for (width, height) in [(1, 1), (3, 2), (80, 3), (10, 60)] {
                screen(width, height, Some(&overview), &[Key::Page(page), Key::Move(3)]);
            }
        }
    }

    #[test]
    fn before_anything_was_heard() {
        let (text, _) = screen(60, 5, None, &[Key::Move(1)]);
        assert!(text.starts_with("Koseki demo   listening …\n"), "{text}");
        assert!(text.ends_with(&format!("{HELP}\n")), "{text}");
    }
}
