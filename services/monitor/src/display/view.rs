//! View that the keys have chosen.

use telemetry::Span;

/// A page of the screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Page {
    /// Sources, and the stages of the selected source.
    Sources,
    /// Every system track.
    Tracks,
    /// Every stage of every source.
    Stages,
    /// Everything that was counted.
    Counters,
    /// How the processes are.
    Processes,
    /// Alarms that stand.
    Alarms,
}

impl Page {
    /// In the order of the keys.
    pub(crate) const ALL: [Self; 6] = [
        Self::Sources,
        Self::Tracks,
        Self::Stages,
        Self::Counters,
        Self::Processes,
        Self::Alarms,
    ];

    /// Name of the page.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::Sources => "sources",
            Self::Tracks => "tracks",
            Self::Stages => "stages",
            Self::Counters => "counters",
            Self::Processes => "processes",
            Self::Alarms => "alarms",
        }
    }
}

/// A key that means something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ViewKey {
    Quit,
    NextPage,
    PreviousPage,
    Page(Page),
    /// So many rows further down, or up.
    Move(isize),
    Span,
    Pause,
    Help,
}

/// View of the screen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    pub(crate) page: Page,
    pub(crate) span: Span,
    /// Whether new overviews are kept back.
    pub(crate) paused: bool,
    /// Whether the keys are explained instead.
    pub(crate) help: bool,
    /// The selected row of each page.
    selected: [usize; Page::ALL.len()],
}

impl Default for View {
    fn default() -> Self {
        Self {
            page: Page::Sources,
            span: Span::Interval,
            paused: false,
            help: false,
            selected: [0; Page::ALL.len()],
        }
    }
}

impl View {
    /// The selected row of the page, of `rows` that there are.
    pub(crate) fn selected(&self, rows: usize) -> usize {
        self.selected[self.page as usize].min(rows.saturating_sub(1))
    }

    /// Applies a key, on a page of `rows` rows. Returns `false` for the key that ends the display.
    pub(crate) fn press(&mut self, key: ViewKey, rows: usize) -> bool {
        let pages = Page::ALL.len();
        if std::mem::take(&mut self.help) {
            // Any key closes the explanation.
            return true;
        }
        match key {
            ViewKey::Quit => return false,
            ViewKey::NextPage => self.page = Page::ALL[(self.page as usize + 1) % pages],
            ViewKey::PreviousPage => self.page = Page::ALL[(self.page as usize + pages - 1) % pages],
            ViewKey::Page(page) => self.page = page,
            ViewKey::Move(by) => {
                let moved = self.selected(rows).saturating_add_signed(by);
                self.selected[self.page as usize] = moved.min(rows.saturating_sub(1));
            }
            ViewKey::Span => {
                self.span = match self.span {
                    Span::Interval => Span::Total,
                    Span::Total => Span::Interval,
                }
            }
            ViewKey::Pause => self.paused = !self.paused,
            ViewKey::Help => self.help = true,
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_turn_pages_move_and_end() {
        let mut view = View::default();
        for key in [
            ViewKey::Page(Page::Stages),
            ViewKey::NextPage,
            ViewKey::Move(2),
            ViewKey::Move(100),
        ] {
            assert!(view.press(key, 5));
        }
        assert_eq!((view.page, view.selected(5)), (Page::Counters, 4));
        assert_eq!(view.selected(2), 1, "there are fewer rows now");
        view.press(ViewKey::Move(-100), 5);
        assert_eq!(view.selected(5), 0);
        view.press(ViewKey::Move(1), 0);
        assert_eq!(view.selected(0), 0);
        view.press(ViewKey::Page(Page::Sources), 5);
        view.press(ViewKey::PreviousPage, 5);
        assert_eq!(view.page, Page::Alarms);
        view.press(ViewKey::NextPage, 5);
        assert_eq!(view.page, Page::Sources);
        view.press(ViewKey::Span, 5);
        view.press(ViewKey::Pause, 5);
        assert_eq!((view.span, view.paused), (Span::Total, true));
        view.press(ViewKey::Help, 5);
        assert!(view.help);
        assert!(view.press(ViewKey::Quit, 5), "the first key closes the help");
        assert!(!view.help);
        assert!(!view.press(ViewKey::Quit, 5));
    }
}
