//! The screen and the keys.
//!
//! The terminal is restored at every end: by a key, a signal, an error, the end of the deployment (the guard is
//! dropped) or a panic (a hook restores the terminal before the message is printed).

use std::fs::File;
use std::io::{self, IsTerminal as _};
use std::os::fd::{AsFd as _, OwnedFd};
use std::time::Duration;

use anyhow::Context as _;
use bus::SharedMemory;
use ratatui::DefaultTerminal;
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEvent, KeyModifiers};
use runtime::Now;
use runtime::signals::Stop;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;

use super::attached::{Attached, Look};
use super::{EndReason, LOOK_EVERY};
use crate::display::draw::{self, ScreenStyle};
use crate::display::overview::Overview;
use crate::display::view::{Page, View, ViewKey};

/// Rows that a page key moves.
const PAGE_ROWS: isize = 10;
/// Keys handled before the next look at the deployment: a key held down must not delay the deployment's data.
const KEYS_PER_LOOK: usize = 16;

/// Shows the deployment until its end or the user's.
///
/// # Errors
/// If the terminal cannot be used, or shared memory fails.
pub(super) fn show(mut attached: Attached<SharedMemory>, stop: &Stop) -> anyhow::Result<EndReason> {
    let instance = attached.instance().to_owned();
    let mut screen = TerminalScreen::open()?;
    let mut view = View::default();
    let mut overview: Option<Box<Overview>> = None;
    screen.draw(&instance, None, &view)?;
    while !stop.requested() {
        let mut changed = false;
        match attached.look(Now::read())? {
            Look::Ended => return Ok(EndReason::OfInstance),
            Look::Interval(latest) if !view.paused || overview.is_none() => {
                overview = Some(latest);
                changed = true;
            }
            // While paused, arrivals are taken, so that nothing is missed, and not shown.
            Look::Interval(_) | Look::Nothing => {}
        }
        let mut patience = LOOK_EVERY;
        for _ in 0..KEYS_PER_LOOK {
            match screen.event(patience)? {
                None => break,
                Some(TerminalEvent::Key(key)) => {
                    if !view.press(key, draw::rows(overview.as_deref(), &view)) {
                        return Ok(EndReason::OfInterest);
                    }
                }
                Some(TerminalEvent::Resized) => {}
                Some(TerminalEvent::Gone) => return Ok(EndReason::OfInterest),
            }
            changed = true;
            patience = Duration::ZERO;
        }
        if changed {
            screen.draw(&instance, overview.as_deref(), &view)?;
        }
    }
    Ok(EndReason::OfInterest)
}

/// A terminal in our hands.
struct TerminalScreen {
    terminal: DefaultTerminal,
    /// Keys come from here.
    keys: OwnedFd,
    looks: ScreenStyle,
}

/// Event of the terminal.
enum TerminalEvent {
    Key(ViewKey),
    Resized,
    /// The terminal has gone.
    Gone,
}

impl TerminalScreen {
    fn open() -> anyhow::Result<Self> {
        let keys = keys().context("finding the terminal")?;
        match ratatui::try_init() {
            Ok(terminal) => Ok(Self {
                terminal,
                keys,
                looks: ScreenStyle::of_environment(),
            }),
            Err(error) => {
                // The terminal may have been prepared in part.
                let _ = ratatui::try_restore();
                Err(error).context("preparing the terminal; without one, `koseki top --once` prints everything")
            }
        }
    }

    fn draw(&mut self, instance: &str, overview: Option<&Overview>, view: &View) -> anyhow::Result<()> {
        let looks = self.looks;
        let drawn = self
            .terminal
            .draw(|frame| draw::draw(frame.buffer_mut(), instance, overview, view, looks));
        drawn.context("drawing").map(drop)
    }

    /// The next meaningful event, if any comes within `patience`.
    fn event(&self, patience: Duration) -> anyhow::Result<Option<TerminalEvent>> {
        // The library reads from a vanished terminal for ever: the terminal's end is checked before.
        if is_gone(&self.keys, patience).context("waiting for a key")? {
            return Ok(Some(TerminalEvent::Gone));
        }
        if !event::poll(Duration::ZERO).context("waiting for a key")? {
            return Ok(None);
        }
        Ok(match event::read().context("reading a key")? {
            Event::Key(event) if event.is_press() => meaning(event).map(TerminalEvent::Key),
            Event::Resize(..) => Some(TerminalEvent::Resized),
            _ => None,
        })
    }
}

impl Drop for TerminalScreen {
    fn drop(&mut self) {
        // A terminal that has gone cannot be restored.
        let _ = ratatui::try_restore();
        let _ = self.terminal.show_cursor();
    }
}

/// Terminal that keys come from: standard input, or the controlling terminal of this process.
fn keys() -> io::Result<OwnedFd> {
    let input = io::stdin();
    match input.is_terminal() {
        true => input.as_fd().try_clone_to_owned(),
        false => File::open("/dev/tty").map(OwnedFd::from),
    }
}

/// Waits for a key or a signal, no longer than `patience`. Whether the terminal has gone.
fn is_gone(keys: &OwnedFd, patience: Duration) -> io::Result<bool> {
    let mut keys = [PollFd::new(keys, PollFlags::IN)];
    let patience = Timespec::try_from(patience).map_err(io::Error::other)?;
    match poll(&mut keys, Some(&patience)) {
        Ok(_) => {
            let gone = PollFlags::HUP | PollFlags::ERR | PollFlags::NVAL;
            Ok(keys[0].revents().intersects(gone))
        }
        // A signal: the size of the terminal, or the end.
        Err(Errno::INTR) => Ok(false),
        Err(error) => Err(error.into()),
    }
}

/// Meaning of a key; `None` for a key without meaning.
fn meaning(event: KeyEvent) -> Option<ViewKey> {
    let control = event.modifiers.contains(KeyModifiers::CONTROL);
    Some(match event.code {
        KeyCode::Char('c') if control => ViewKey::Quit,
        KeyCode::Char('q') | KeyCode::Esc => ViewKey::Quit,
        KeyCode::Tab | KeyCode::Right => ViewKey::NextPage,
        KeyCode::BackTab | KeyCode::Left => ViewKey::PreviousPage,
        KeyCode::Char(digit @ '1'..='9') => {
            let number = digit.to_digit(10)? as usize;
            ViewKey::Page(*Page::ALL.get(number - 1)?)
        }
        KeyCode::Down => ViewKey::Move(1),
        KeyCode::Up => ViewKey::Move(-1),
        KeyCode::PageDown => ViewKey::Move(PAGE_ROWS),
        KeyCode::PageUp => ViewKey::Move(-PAGE_ROWS),
        KeyCode::Home => ViewKey::Move(isize::MIN),
        KeyCode::End => ViewKey::Move(isize::MAX),
        KeyCode::Char('i') => ViewKey::Span,
        KeyCode::Char('p') => ViewKey::Pause,
        KeyCode::Char('h' | '?') | KeyCode::F(1) => ViewKey::Help,
        _ => return None,
    })
}
