//! The screen and the keys.
//!
//! However it ends, the terminal is as it was before: by a key, a signal, an error, the end of the deployment (the
//! guard is dropped) or a panic (a hook restores it before the message is printed).

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
use super::{End, LOOK_EVERY};
use crate::display::draw::{self, Looks};
use crate::display::overview::Overview;
use crate::display::view::{Key, Page, View};

/// Rows that a page key moves.
const PAGE_ROWS: isize = 10;
/// Keys worked off before the next look at the deployment: a key that is held down must not keep it waiting.
const KEYS_PER_LOOK: usize = 16;

/// Shows the deployment until it ends or the user has seen enough.
///
/// # Errors
/// If the terminal cannot be used, or shared memory fails.
pub(super) fn show(mut attached: Attached<SharedMemory>, stop: &Stop) -> anyhow::Result<End> {
    let instance = attached.instance().to_owned();
    let mut screen = Screen::open()?;
    let mut view = View::default();
    let mut overview: Option<Box<Overview>> = None;
    screen.draw(&instance, None, &view)?;
    while !stop.requested() {
        let mut changed = false;
        match attached.look(Now::read())? {
            Look::Ended => return Ok(End::OfInstance),
            Look::Interval(latest) if !view.paused || overview.is_none() => {
                overview = Some(latest);
                changed = true;
            }
            // While paused, what comes is taken, so that nothing is missed, and not shown.
            Look::Interval(_) | Look::Nothing => {}
        }
        let mut patience = LOOK_EVERY;
        for _ in 0..KEYS_PER_LOOK {
            match screen.event(patience)? {
                None => break,
                Some(Input::Key(key)) => {
                    if !view.press(key, draw::rows(overview.as_deref(), &view)) {
                        return Ok(End::OfInterest);
                    }
                }
                Some(Input::Resized) => {}
                Some(Input::Gone) => return Ok(End::OfInterest),
            }
            changed = true;
            patience = Duration::ZERO;
        }
        if changed {
            screen.draw(&instance, overview.as_deref(), &view)?;
        }
    }
    Ok(End::OfInterest)
}

/// A terminal in our hands.
struct Screen {
    terminal: DefaultTerminal,
    /// Keys come from here.
    keys: OwnedFd,
    looks: Looks,
}

/// Event of the terminal.
enum Input {
    Key(Key),
    Resized,
    /// The terminal has gone.
    Gone,
}

impl Screen {
    fn open() -> anyhow::Result<Self> {
        let keys = keys().context("finding the terminal")?;
        match ratatui::try_init() {
            Ok(terminal) => Ok(Self {
                terminal,
                keys,
                looks: Looks::of_environment(),
            }),
            Err(error) => {
                // It may have been prepared in part.
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

    /// The next thing that means something, if it comes within `patience`.
    fn event(&self, patience: Duration) -> anyhow::Result<Option<Input>> {
        // The library reads a terminal that has gone for ever: its end is looked for before.
        if is_gone(&self.keys, patience).context("waiting for a key")? {
            return Ok(Some(Input::Gone));
        }
        if !event::poll(Duration::ZERO).context("waiting for a key")? {
            return Ok(None);
        }
        Ok(match event::read().context("reading a key")? {
            Event::Key(event) if event.is_press() => meaning(event).map(Input::Key),
            Event::Resize(..) => Some(Input::Resized),
            _ => None,
        })
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        // A terminal that has gone cannot be restored.
        let _ = ratatui::try_restore();
        let _ = self.terminal.show_cursor();
    }
}

/// Terminal from which keys come: standard input, or the one that controls this process.
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

/// Meaning of a key; `None` if it has none.
fn meaning(event: KeyEvent) -> Option<Key> {
    let control = event.modifiers.contains(KeyModifiers::CONTROL);
    Some(match event.code {
        KeyCode::Char('c') if control => Key::Quit,
        KeyCode::Char('q') | KeyCode::Esc => Key::Quit,
        KeyCode::Tab | KeyCode::Right => Key::NextPage,
        KeyCode::BackTab | KeyCode::Left => Key::PreviousPage,
        KeyCode::Char(digit @ '1'..='9') => {
            let number = digit.to_digit(10)? as usize;
            Key::Page(*Page::ALL.get(number - 1)?)
        }
        KeyCode::Down => Key::Move(1),
        KeyCode::Up => Key::Move(-1),
        KeyCode::PageDown => Key::Move(PAGE_ROWS),
        KeyCode::PageUp => Key::Move(-PAGE_ROWS),
        KeyCode::Home => Key::Move(isize::MIN),
        KeyCode::End => Key::Move(isize::MAX),
        KeyCode::Char('i') => Key::Span,
        KeyCode::Char('p') => Key::Pause,
        KeyCode::Char('h' | '?') | KeyCode::F(1) => Key::Help,
        _ => return None,
    })
}
