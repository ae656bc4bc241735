//! Moments of a recording: each window of the page has its own.
//!
//! A deployment has one world, and all pages look at it. A recording has a world for each window, so that each has its
//! own moment and speed. A window names itself in its requests (`?window=…`). Its world begins with its connection and
//! ends with it. At most [`OWN_MAX`] windows have a world of their own; scripts and further windows share the common
//! one, and these windows are told so in the greeting.
//!
//! A thread for each world inserts what the recording has up to the wanted moment. A jump fills another world, which
//! then takes the place of the shown one: the lock is not held while files are read, and no other page waits.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::Duration;

use web::axum::extract::{FromRef, FromRequestParts};
use web::axum::http::request::Parts;

use crate::shared::SharedState;
use crate::tape::Tape;

/// Maximum number of windows with a world of their own.
pub(crate) const OWN_MAX: usize = 7;
/// Maximum length of the name of a window, characters.
const NAME_MAX: usize = 32;
/// Time between two updates of a world's moment.
pub(crate) const LOOK_EVERY: Duration = Duration::from_millis(20);

/// Worlds that pages look at, see the module's documentation.
#[derive(Clone)]
pub(crate) struct Moments {
    common: Arc<SharedState>,
    recorded: Option<Arc<Recorded>>,
}

/// Recording, and the worlds of the windows.
struct Recorded {
    tape: Mutex<Tape>,
    own: Mutex<BTreeMap<String, Weak<SharedState>>>,
}

impl Moments {
    /// Returns the only world of a deployment.
    pub(crate) fn of_deployment(common: Arc<SharedState>) -> Self {
        Self { common, recorded: None }
    }

    /// Returns the worlds of the recording on `tape`. The caller moves `common` through time.
    pub(crate) fn of_recording(common: Arc<SharedState>, tape: Tape) -> Self {
        let recorded = Recorded {
            tape: Mutex::new(tape),
            own: Mutex::default(),
        };
        Self {
            common,
            recorded: Some(Arc::new(recorded)),
        }
    }

    /// Returns the world of a window that connects. The world lives as long as somebody holds it.
    pub(crate) fn enter(&self, window: Option<&str>) -> Arc<SharedState> {
        let (Some(recorded), Some(window)) = (&self.recorded, window) else {
            return Arc::clone(&self.common);
        };
        let mut own = recorded.own.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = own.get(window).and_then(Weak::upgrade) {
            return known;
        }
        own.retain(|_, world| world.strong_count() > 0);
        if own.len() >= OWN_MAX {
            return Arc::clone(&self.common);
        }
        match self.begin(recorded) {
            Ok(shared) => {
                own.insert(window.to_owned(), Arc::downgrade(&shared));
                shared
            }
            Err(error) => {
                runtime::notice(format_args!("koseki: a window shares the common moment: {error:#}"));
                Arc::clone(&self.common)
            }
        }
    }

    /// Returns the world of a connected window; the common one for all others.
    fn of(&self, window: Option<&str>) -> Arc<SharedState> {
        let own = self.recorded.as_ref().zip(window).and_then(|(recorded, window)| {
            let own = recorded.own.lock().unwrap_or_else(PoisonError::into_inner);
            own.get(window)?.upgrade()
        });
        own.unwrap_or_else(|| Arc::clone(&self.common))
    }

    /// Whether `shared` is the common world of a recording's windows.
    pub(crate) fn is_common(&self, shared: &SharedState) -> bool {
        self.recorded.is_some() && std::ptr::eq(shared, &*self.common)
    }

    /// Begins a world at the begin of the recording, and its thread.
    fn begin(&self, recorded: &Recorded) -> anyhow::Result<Arc<SharedState>> {
        let mut tape = recorded.tape.lock().unwrap_or_else(PoisonError::into_inner).again()?;
        let shared = self
            .common
            .beside(self.common.world().at_the_begin((self.common.clock)()));
        let world = Arc::downgrade(&shared);
        std::thread::Builder::new().name("moment".to_owned()).spawn(move || {
            while let Some(shared) = world.upgrade() {
                if let Err(error) = advance(&mut tape, &shared) {
                    runtime::notice(format_args!("koseki: a window stands still: {error:#}"));
                    break;
                }
                drop(shared);
                std::thread::sleep(LOOK_EVERY);
            }
        })?;
        Ok(shared)
    }
}

/// Brings the world of `shared` to its wanted moment.
///
/// # Errors
/// If the recording can no longer be read.
pub(crate) fn advance(tape: &mut Tape, shared: &SharedState) -> anyhow::Result<()> {
    let mono_ns = (shared.clock)().mono_ns;
    let mut shown = shared.world();
    let Some(recording) = &shown.recording else {
        return Ok(());
    };
    let (wanted_ns, edition) = (recording.wanted_ns(mono_ns), recording.edition);
    if !tape.leaps(wanted_ns) {
        tape.go_to(&mut shown, wanted_ns)?;
    } else {
        let mut next = shown.emptied();
        drop(shown);
        tape.go_to(&mut next, wanted_ns)?;
        shown = shared.world();
        // Another moment may be wanted meanwhile.
        if let (Some(next), Some(recording)) = (&mut next.recording, &shown.recording) {
            (next.wanted, next.since_ns, next.edition) = (recording.wanted, recording.since_ns, recording.edition);
        }
        *shown = next;
    }
    if let Some(recording) = &mut shown.recording {
        recording.reached = edition;
    }
    Ok(())
}

/// Returns the name of a window in the query of a request.
pub(crate) fn window_in(query: Option<&str>) -> Option<&str> {
    let name = query?.split('&').find_map(|pair| pair.strip_prefix("window="))?;
    let is_name = (1..=NAME_MAX).contains(&name.len()) && name.bytes().all(|letter| letter.is_ascii_alphanumeric());
    is_name.then_some(name)
}

/// The world that a request is about.
pub(crate) struct Seen(pub(crate) Arc<SharedState>);

impl FromRequestParts<Moments> for Seen {
    type Rejection = std::convert::Infallible;

    async fn from_request_parts(parts: &mut Parts, moments: &Moments) -> Result<Self, Self::Rejection> {
        Ok(Self(moments.of(window_in(parts.uri.query()))))
    }
}

impl FromRef<Moments> for Arc<SharedState> {
    fn from_ref(moments: &Moments) -> Self {
        Self::clone(&moments.common)
    }
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use runtime::Now;
    use test_support::S;

    use super::*;
    use crate::pages::tests::LONG;
    use crate::settings::MapFiles;
    use crate::tape::tests::{recorded_tape, world_of};
    use crate::wire::Past;

    /// Moments of a recording of 2,000 s, and the time of its begin.
    fn moments(folder: &std::path::Path) -> (Moments, i64) {
        let tape = recorded_tape(folder);
        let begin_ns = tape.span_ns()[0];
        let common = SharedState::new(world_of(&tape), MapFiles::default(), Now::read);
        (Moments::of_recording(common, tape), begin_ns)
    }

    /// Waits until the window shows `second` of the recording, paused, with `tracks`.
    fn goes_to(window: &SharedState, begin_ns: i64, second: i64, tracks: &[u32]) {
        let past = Past {
            time_s: frames::time::seconds(begin_ns + second * S),
            speed: 0.0,
        };
        window
            .world()
            .recording
            .as_mut()
            .unwrap()
            .want(past, Now::read().mono_ns);
        let end = Instant::now() + LONG;
        while !window.world().recording.as_ref().unwrap().is_reached() {
            assert!(Instant::now() < end, "{second} s is not reached");
            std::thread::sleep(LOOK_EVERY);
        }
        shows(window, begin_ns, second, tracks);
    }

    fn shows(window: &SharedState, begin_ns: i64, second: i64, tracks: &[u32]) {
        let world = window.world();
        let numbers: Vec<u32> = world.tracks.keys().copied().collect();
        assert_eq!(numbers, tracks, "{second} s");
        assert_eq!(world.recording.as_ref().unwrap().at_ns, begin_ns + second * S);
    }

    #[test]
    fn each_window_of_a_recording_has_its_own_moment() {
        let folder = tempfile::tempdir().unwrap();
        let (moments, begin_ns) = moments(folder.path());
        let (left, right) = (moments.enter(Some("left")), moments.enter(Some("right")));
        goes_to(&left, begin_ns, 700, &[1, 2]);
        goes_to(&right, begin_ns, 1_800, &[1]);
        shows(&left, begin_ns, 700, &[1, 2]);
        assert!(Arc::ptr_eq(&moments.of(Some("left")), &left));
        assert!(Arc::ptr_eq(&moments.enter(Some("right")), &right), "it connects again");
        assert!(moments.is_common(&moments.of(None)) && moments.is_common(&moments.of(Some("other"))));
        assert!(!moments.is_common(&left));
        assert!(
            Arc::ptr_eq(&left.traffic, &moments.common.traffic),
            "all pages are counted together"
        );
    }

    #[test]
    fn windows_with_a_world_are_bounded_and_a_closed_window_makes_room() {
        let folder = tempfile::tempdir().unwrap();
        let (moments, _) = moments(folder.path());
        let windows: Vec<_> = (0..OWN_MAX)
            .map(|number| moments.enter(Some(&format!("w{number}"))))
            .collect();
        assert!(windows.iter().all(|window| !moments.is_common(window)));
        assert!(moments.is_common(&moments.enter(Some("more"))));
        drop(windows);
        // A thread may hold its world for a moment yet.
        let end = Instant::now() + LONG;
        while moments.is_common(&moments.enter(Some("more"))) {
            assert!(Instant::now() < end, "no world has ended");
            std::thread::sleep(LOOK_EVERY);
        }
    }

    #[test]
    fn a_window_is_named_by_letters_and_digits_alone() {
        for (query, name) in [
            ("window=a7", Some("a7")),
            ("until_s=3&window=b", Some("b")),
            ("window=", None),
            ("window=a-b", None),
            ("windows=a", None),
        ] {
            assert_eq!(window_in(Some(query)), name, "{query}");
        }
        assert_eq!(window_in(Some(&format!("window={}", "x".repeat(NAME_MAX + 1)))), None);
        assert_eq!(window_in(None), None);
    }
}
