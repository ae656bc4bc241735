//! Where text goes: a terminal, redrawn in place, or a log, line by line.

use std::io::{IsTerminal as _, Write};

use crate::live::Live;
use crate::report::Report;

/// Erases the whole screen.
const ERASE_ALL: &str = "\x1b[2J";
/// Moves the cursor to the upper left corner.
const HOME: &str = "\x1b[H";
/// Erases from the cursor to the end of the line.
const ERASE_LINE: &str = "\x1b[K";
/// Erases from the cursor to the end of the screen.
const ERASE_BELOW: &str = "\x1b[J";

/// Screen of the monitor.
pub struct Screen {
    out: Box<dyn Write>,
    terminal: bool,
    drawn: bool,
    /// Whoever read has gone (`| head`). That is no reason to stop watching.
    gone: bool,
}

impl Screen {
    /// The process's standard output.
    pub fn standard_output() -> Self {
        let out = std::io::stdout();
        let terminal = out.is_terminal();
        Self::new(Box::new(out), terminal)
    }

    /// Text goes to `out`, which can move its cursor if it is a `terminal`.
    pub fn new(out: Box<dyn Write>, terminal: bool) -> Self {
        Self {
            out,
            terminal,
            drawn: false,
            gone: false,
        }
    }

    /// Shows what is known now: the table on a terminal, else one line.
    pub(crate) fn show(&mut self, live: &Live) {
        if !self.terminal {
            self.write(&live.line());
            return;
        }
        // Overwriting line by line does not flicker; erasing first would.
        let mut text = String::from(if self.drawn { HOME } else { ERASE_ALL });
        if !self.drawn {
            text.push_str(HOME);
        }
        for line in live.table().lines() {
            text.push_str(line);
            text.push_str(ERASE_LINE);
            text.push('\n');
        }
        text.push_str(ERASE_BELOW);
        self.drawn = true;
        self.write(&text);
    }

    /// Shows the final report, in place of the table.
    pub(crate) fn end(&mut self, report: &Report) {
        if self.drawn {
            self.write(&format!("{HOME}{ERASE_BELOW}"));
        }
        self.write(&report.text());
    }

    fn write(&mut self, text: &str) {
        if !self.gone {
            let written = self.out.write_all(text.as_bytes()).and_then(|()| self.out.flush());
            self.gone = written.is_err();
        }
    }
}
