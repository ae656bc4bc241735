//! Draws an overview. A pure function of the overview and the view; text beyond the margin is cut.

use ratatui::buffer::Buffer;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Style, Stylize as _};
use ratatui::text::{Line, Span as Piece};
use ratatui::widgets::{Paragraph, Widget as _, Wrap};

use super::columns::{TableLines, Tone};
use super::overview::Overview;
use super::pages;
use super::view::{Page, View};

const HELP_LINE: &str = "q quit  h help  1-6 Tab page  ↑↓ row  i interval/total  p pause";
const HELP: &[&str] = &[
    "q  Esc  Ctrl-C   quit",
    "1 to 6           sources, tracks, stages, counters, processes, alarms",
    "Tab  → ←         next page, previous page",
    "↑ ↓  PgUp PgDn   select a row; Home and End go to the first and the last one",
    "i                latencies of the last interval, or since `koseki top` began",
    "p                pause: what comes is counted, and not shown",
    "h  ?             this page; any key closes it",
    "",
    "rejected   reports that the adapter did not pass on, for what they say",
    "lost       reports that fusion missed because it fell behind",
    "unused     reports that fusion took and did not use",
    "late       stages of reports that took longer than their deadlines",
    "age        from measurement to publication of the fused state, median",
    "FL, knots  height in hundreds of feet, speed over the ground",
    "2@ (3@)    source 2 is another centre; 3 was one too, and has fallen silent",
    "",
    "Red: something is wrong. Yellow: worth a look. Narrow: columns are left out.",
];

/// Lines on alarms beside the sources.
const ALARMS_MAX: usize = 3;

/// Looks of a screen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ScreenStyle {
    /// Whether colours may be used.
    pub(crate) colours: bool,
}

impl ScreenStyle {
    /// Looks that the user's environment asks for: without colours if `NO_COLOR` is set and not empty
    /// (<https://no-color.org>).
    pub(crate) fn of_environment() -> Self {
        Self {
            colours: std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty()),
        }
    }

    fn style(self, tone: Tone) -> Style {
        match tone {
            Tone::Plain => Style::new(),
            Tone::Warning if self.colours => Style::new().fg(Color::Yellow),
            Tone::Alarm if self.colours => Style::new().fg(Color::Red).bold(),
            Tone::Warning => Style::new(),
            Tone::Alarm => Style::new().bold(),
        }
    }

    fn title(self) -> Style {
        match self.colours {
            true => Style::new().fg(Color::Cyan).bold(),
            false => Style::new().bold(),
        }
    }
}

/// Rows on the page: among so many can be selected.
pub(crate) fn rows(overview: Option<&Overview>, view: &View) -> usize {
    overview.map_or(0, |overview| {
        pages::page_lines(overview, view.page, view.span, usize::MAX).rows.len()
    })
}

/// Draws a screen of `koseki top`; before the first interval is over, there is no overview yet.
pub(crate) fn draw(buffer: &mut Buffer, instance: &str, overview: Option<&Overview>, view: &View, looks: ScreenStyle) {
    let [title, tabs, body, help] = Layout::vertical([
        Constraint::Length(1),
        Constraint::Length(2),
        Constraint::Fill(1),
        Constraint::Length(1),
    ])
    .areas(buffer.area);
    Line::from(HELP_LINE).dim().render(help, buffer);
    tab_line(view, looks).render(tabs, buffer);
    let text = overview.map_or_else(|| format!("Koseki {instance}   listening …"), pages::title);
    Line::from(text).style(looks.title()).render(title, buffer);
    // Below the tabs.
    let [_, address] = Layout::vertical([Constraint::Length(1), Constraint::Length(1)]).areas(tabs);
    draw_page(buffer, address, overview);
    if view.help {
        for (place, line) in body.rows().zip(HELP) {
            Line::from(*line).render(place, buffer);
        }
        return;
    }
    let Some(overview) = overview else { return };
    let lines = pages::page_lines(overview, view.page, view.span, usize::from(body.width));
    let selected = Some(view.selected(lines.rows.len()));
    match view.page {
        Page::Sources => draw_sources(buffer, body, overview, view, selected, looks),
        Page::Alarms => {
            // Sentences are long: the selected alarm's sentence and remedy stand below in full.
            let [table, sentences] = Layout::vertical([Constraint::Fill(1), Constraint::Length(6)]).areas(body);
            draw_lines(buffer, table, &lines, selected, looks);
            if let Some(alarm) = selected.and_then(|row| overview.alarms.get(row)) {
                let text = format!("{}\n{}", alarm.text, alarm.remedy);
                Paragraph::new(text).wrap(Wrap { trim: true }).render(sentences, buffer);
            }
        }
        Page::Counters => {
            // There is hardly ever room for every sentence.
            let [table, sentence] = Layout::vertical([Constraint::Fill(1), Constraint::Length(1)]).areas(body);
            draw_lines(buffer, table, &lines, selected, looks);
            if let Some(row) = selected.and_then(|row| overview.counters.get(row)) {
                Line::from(row.counter.sentence()).dim().render(sentence, buffer);
            }
        }
        _ => draw_lines(buffer, body, &lines, selected, looks),
    }
}

/// Draws the screen of a monitor, without key input.
pub(crate) fn draw_unattended(buffer: &mut Buffer, overview: &Overview, looks: ScreenStyle) {
    let [title, address, body] =
        Layout::vertical([Constraint::Length(1), Constraint::Length(1), Constraint::Fill(1)]).areas(buffer.area);
    Line::from(pages::title(overview))
        .style(looks.title())
        .render(title, buffer);
    draw_page(buffer, address, Some(overview));
    draw_sources(buffer, body, overview, &View::default(), None, looks);
}

/// Draws the address of the picture, which the redrawn screen would hide otherwise.
fn draw_page(buffer: &mut Buffer, place: Rect, overview: Option<&Overview>) {
    if let Some(page) = overview.and_then(pages::page) {
        Line::from(page).render(place, buffer);
    }
}

fn tab_line(view: &View, looks: ScreenStyle) -> Line<'static> {
    let mut pieces = Vec::new();
    for (index, page) in Page::ALL.into_iter().enumerate() {
        let tab = Piece::from(format!(" {} {} ", index + 1, page.word()));
        pieces.push(if page == view.page { tab.reversed() } else { tab });
    }
    if view.paused {
        pieces.push(Piece::from("  paused").style(looks.style(Tone::Warning).bold()));
    }
    pieces.push(Piece::from(format!("  {}", pages::span_word(view.span))).dim());
    Line::from(pieces)
}

/// Sources above; below, the system tracks, the processes, and the stages of the selected source.
fn draw_sources(
    buffer: &mut Buffer,
    body: Rect,
    overview: &Overview,
    view: &View,
    selected: Option<usize>,
    looks: ScreenStyle,
) {
    let width = usize::from(body.width);
    let sources = pages::page_lines(overview, Page::Sources, view.span, width);
    // The first row is that of all sources together.
    let source = selected
        .and_then(|row| row.checked_sub(1))
        .and_then(|index| overview.sources.get(index));
    let stages = pages::stages_of(overview, source.map(|source| source.number), view.span, width);
    let picture = pages::picture(overview);
    let remark = pages::remark(overview);
    let alarms = pages::worst_alarms(overview, ALARMS_MAX);
    let [above, _, tracks, processes, alarmed, _, table, last] = Layout::vertical([
        // All rows, or the room that the others leave.
        Constraint::Max(1 + sources.rows.len() as u16),
        Constraint::Length(1),
        Constraint::Length(picture.len() as u16),
        Constraint::Length(1),
        Constraint::Length(alarms.len() as u16),
        Constraint::Length(1),
        Constraint::Length(1 + stages.rows.len() as u16),
        Constraint::Length(u16::from(remark.is_some())),
    ])
    .areas(body);
    draw_lines(buffer, above, &sources, selected, looks);
    for (place, line) in tracks.rows().zip(picture) {
        Line::from(line).render(place, buffer);
    }
    let (tone, health) = pages::health(overview);
    Line::from(health).style(looks.style(tone)).render(processes, buffer);
    for (place, (tone, line)) in alarmed.rows().zip(alarms) {
        Line::from(line).style(looks.style(tone)).render(place, buffer);
    }
    draw_lines(buffer, table, &stages, None, looks);
    if let Some(remark) = remark {
        Line::from(remark)
            .style(looks.style(Tone::Warning))
            .render(last, buffer);
    }
}

/// The heading, and as many rows as fit: so that the `selected` row is among the drawn rows, or with a remark on the
/// others.
fn draw_lines(buffer: &mut Buffer, area: Rect, lines: &TableLines, selected: Option<usize>, looks: ScreenStyle) {
    let [heading, body] = Layout::vertical([Constraint::Length(1), Constraint::Fill(1)]).areas(area);
    Line::from(lines.heading.as_str()).bold().render(heading, buffer);
    let height = usize::from(body.height);
    let hidden = lines.rows.len().saturating_sub(height);
    let first = selected.map_or(0, |selected| (selected + 1).saturating_sub(height));
    let shown = lines.rows.iter().enumerate().skip(first).take(height);
    for (place, (index, (tone, row))) in body.rows().zip(shown) {
        let mut line = Line::from(row.as_str()).style(looks.style(*tone));
        if Some(index) == selected {
            line = line.reversed();
        }
        line.render(place, buffer);
    }
    if let Some(last) = body.rows().next_back().filter(|_| hidden > 0 && selected.is_none()) {
        let more = format!("… and {} more", hidden + 1);
        Line::from(format!("{more:<width$}", width = usize::from(last.width)))
            .dim()
            .render(last, buffer);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::display::overview::SourceRow;
    use crate::display::sample::overview;
    use crate::display::view::ViewKey;
    use crate::golden;

    const SIZES: [(u16, u16); 2] = [(80, 24), (200, 50)];
    const COLOURS: ScreenStyle = ScreenStyle { colours: true };

    fn empty(width: u16, height: u16) -> Buffer {
        Buffer::empty(Rect::new(0, 0, width, height))
    }

    fn text(buffer: &Buffer) -> String {
        let lines = buffer.content.chunks(usize::from(buffer.area.width));
        let line = |cells: &[ratatui::buffer::Cell]| cells.iter().map(|cell| cell.symbol()).collect::<String>();
        lines.map(|cells| line(cells).trim_end().to_owned() + "\n").collect()
    }

    /// The screen as text, and the highlighted lines.
    fn screen(width: u16, height: u16, overview: Option<&Overview>, keys: &[ViewKey]) -> (String, Vec<usize>) {
        let mut view = View::default();
        for key in keys {
            assert!(view.press(*key, rows(overview, &view)));
        }
        let mut buffer = empty(width, height);
        draw(&mut buffer, "demo", overview, &view, COLOURS);
        let lines = buffer.content.chunks(usize::from(width)).enumerate();
        let is_set_off = |cell: &ratatui::buffer::Cell| cell.modifier.contains(ratatui::style::Modifier::REVERSED);
        let selected = lines.filter(|(index, cells)| *index > 1 && is_set_off(&cells[0]));
        (text(&buffer), selected.map(|(index, _)| index).collect())
    }

    #[test]
    fn the_sources_and_the_stages_of_the_selected_one() {
        let overview = overview();
        let (text, selected) = screen(80, 24, Some(&overview), &[]);
        golden::assert("top_sources.txt", &text);
        assert_eq!(selected, [4], "all sources");
        let (text, selected) = screen(
            200,
            50,
            Some(&overview),
            &[ViewKey::Move(1), ViewKey::Move(1), ViewKey::Span],
        );
        golden::assert("top_source_total.txt", &text);
        assert_eq!(selected, [6], "ads-b");
    }

    #[test]
    fn the_other_pages() {
        let overview = overview();
        for (page, file) in [
            (Page::Tracks, "top_tracks.txt"),
            (Page::Stages, "top_stages.txt"),
            (Page::Counters, "top_counters.txt"),
            (Page::Processes, "top_processes.txt"),
            (Page::Alarms, "top_alarms.txt"),
        ] {
            let (text, _) = screen(80, 24, Some(&overview), &[ViewKey::Page(page), ViewKey::Pause]);
            golden::assert(file, &text);
        }
    }

    #[test]
    fn a_small_terminal_shows_the_selected_row_and_no_terminal_is_too_small() {
        let overview = overview();
        let keys = [ViewKey::Page(Page::Counters), ViewKey::Move(100)];
        let (text, selected) = screen(40, 7, Some(&overview), &keys);
        golden::assert("top_small.txt", &text);
        assert_eq!(selected, [4]);
        for page in Page::ALL {
            for (width, height) in [(1, 1), (3, 2), (80, 3), (10, 60)] {
                screen(width, height, Some(&overview), &[ViewKey::Page(page), ViewKey::Move(3)]);
            }
        }
    }

    #[test]
    fn before_anything_was_heard_and_the_help() {
        let (text, _) = screen(80, 24, None, &[ViewKey::Move(1)]);
        assert!(text.starts_with("Koseki demo   listening …\n"), "{text}");
        assert!(text.ends_with(&format!("{HELP_LINE}\n")), "{text}");
        let (text, _) = screen(80, 24, Some(&overview()), &[ViewKey::Help]);
        for line in HELP {
            assert!(text.contains(line), "{line} is cut: {text}");
        }
    }

    #[test]
    fn a_monitor_shows_the_same_without_keys_and_says_what_it_has_no_room_for() {
        let mut overview = overview();
        for (width, height) in SIZES {
            let mut buffer = empty(width, height - 1);
            draw_unattended(&mut buffer, &overview, COLOURS);
            golden::assert(&format!("unattended_{width}.txt"), &text(&buffer));
        }
        overview.sources = vec![SourceRow::default(); 64];
        let mut buffer = empty(80, 23);
        draw_unattended(&mut buffer, &overview, COLOURS);
        let text = text(&buffer);
        assert!(text.contains("more\n") && text.contains("end to end"), "{text}");
    }

    #[test]
    fn what_is_wrong_has_a_colour_unless_none_is_wanted() {
        let colours = |looks| {
            let mut buffer = empty(80, 23);
            draw_unattended(&mut buffer, &overview(), looks);
            let found: std::collections::BTreeSet<String> =
                buffer.content.iter().map(|cell| cell.fg.to_string()).collect();
            found.into_iter().collect::<Vec<_>>().join(" ")
        };
        assert_eq!(colours(COLOURS), "Cyan Red Reset");
        assert_eq!(colours(ScreenStyle { colours: false }), "Reset");
    }
}
