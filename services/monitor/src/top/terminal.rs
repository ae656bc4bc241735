//! The screen and the keys.
//!
//! However it ends, the terminal is as it was before: by a key, a signal, an error, the end of the deployment (the
//! guard is dropped) or a panic (a hook restores it before the message is printed).

use std::time::Duration;

use anyhow::Context as _;
use bus::SharedMemory;
use ratatui::DefaultTerminal;
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEvent, KeyModifiers};
use runtime::Now;
use runtime::signals::Stop;

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
    looks: Looks,
}

/// Event of the terminal.
enum Input {
    Key(Key),
    Resized,
}

impl Screen {
    fn open() -> anyhow::Result<Self> {
        match ratatui::try_init() {
            Ok(terminal) => Ok(Self {
                terminal,
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
        if !event::poll(patience).context("waiting for a key")? {
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
