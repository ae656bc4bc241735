//! Where text goes: a terminal, redrawn in place, or a log, line by line.

use std::io::{self, IsTerminal as _, Write};

use ratatui::backend::{Backend as _, CrosstermBackend};
use ratatui::buffer::Buffer;
use ratatui::crossterm::terminal;
use ratatui::layout::{Position, Rect};

use crate::display::draw::{ScreenStyle, draw_unattended};
use crate::display::overview::Overview;
use crate::display::pages;
use crate::report::Report;

/// Columns and rows of a terminal of unknown size.
const USUAL_SIZE: (u16, u16) = (80, 24);
/// Longest line of prose where there is room, characters.
const PROSE_WIDTH: u16 = 110;
/// Moves the cursor to the upper left corner, and erases from there.
const CLEAR: &str = "\x1b[H\x1b[J";

/// Screen of the monitor.
pub struct Screen {
    out: CrosstermBackend<Box<dyn Write>>,
    terminal: bool,
    /// Size at which something was drawn.
    drawn: Option<(u16, u16)>,
    looks: ScreenStyle,
    errors: Box<dyn Write>,
    /// The reader has gone (`| head`, a closed terminal). That is no reason to stop watching.
    gone: bool,
    /// Other failure to write text: a full disk, for example.
    failure: Option<io::Error>,
}

impl Screen {
    /// The process's standard output.
    pub fn standard_output() -> Self {
        let out = io::stdout();
        let terminal = out.is_terminal();
        Self::new(Box::new(out), terminal)
    }

    /// Text goes to `out`, with a movable cursor if `out` is a `terminal`.
    pub fn new(out: Box<dyn Write>, terminal: bool) -> Self {
        Self {
            out: CrosstermBackend::new(out),
            terminal,
            drawn: None,
            looks: ScreenStyle::of_environment(),
            errors: Box::new(std::io::stderr()),
            gone: false,
            failure: None,
        }
    }

    /// This screen, with another place for the lines of standard error.
    #[must_use]
    pub fn with_errors(self, errors: Box<dyn Write>) -> Self {
        Self { errors, ..self }
    }

    /// Writes a line to standard error.
    pub(crate) fn say(&mut self, line: &str) {
        // A failed write (no reader) is no reason to stop watching.
        let _ = writeln!(self.errors, "koseki: {line}");
    }

    /// Shows the overview: tables on a terminal, else a line.
    pub(crate) fn show(&mut self, overview: &Overview) {
        if self.terminal {
            self.attempt(|screen| screen.draw(overview, size()));
        } else {
            self.write(&pages::line(overview));
        }
    }

    /// Every cell is written, so that text of other writers on the terminal disappears; erasing first would flicker.
    fn draw(&mut self, overview: &Overview, size: (u16, u16)) -> io::Result<()> {
        let (width, height) = size;
        // The last line is left for other writers on standard error.
        let mut buffer = Buffer::empty(Rect::new(0, 0, width, height.saturating_sub(1)));
        draw_unattended(&mut buffer, overview, self.looks);
        if self.drawn.replace(size) != Some(size) {
            self.out.clear()?;
        }
        let cells = buffer.content.iter().enumerate();
        self.out.draw(cells.map(|(index, cell)| {
            let (x, y) = buffer.pos_of(index);
            (x, y, cell)
        }))?;
        self.out
            .set_cursor_position(Position::new(0, height.saturating_sub(1)))?;
        Write::flush(&mut self.out)
    }

    /// Shows the final report, in place of the tables.
    pub(crate) fn end(&mut self, report: &Report) {
        if self.drawn.is_some() {
            self.write(CLEAR);
        }
        let width = if self.terminal {
            size().0.min(PROSE_WIDTH)
        } else {
            PROSE_WIDTH
        };
        self.write(&report.text(usize::from(width)));
    }

    /// Reason of unwritten text, except for the absence of a reader.
    pub(crate) fn failure(&mut self) -> Option<io::Error> {
        self.failure.take()
    }

    fn write(&mut self, text: &str) {
        self.attempt(|screen| {
            screen.out.write_all(text.as_bytes())?;
            Write::flush(&mut screen.out)
        });
    }

    fn attempt(&mut self, write: impl FnOnce(&mut Self) -> io::Result<()>) {
        if self.gone {
            return;
        }
        if let Err(error) = write(self) {
            self.gone = true;
            let is_failure = !self.terminal && error.kind() != io::ErrorKind::BrokenPipe;
            self.failure = Some(error).filter(|_| is_failure);
        }
    }
}

/// Columns and rows of the terminal.
fn size() -> (u16, u16) {
    match terminal::size() {
        Ok((width @ 1.., height @ 1..)) => (width, height),
        _ => USUAL_SIZE,
    }
}
