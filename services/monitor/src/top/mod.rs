//! `koseki top`: looks on at a running deployment, from any terminal.
//!
//! This reader joins like any other, without a configuration, and can leave at any time. The display has three sources:
//! the health messages (every process's counts, the names of the sources), the stamps of the system tracks (latencies),
//! and the launcher's messages (restarts, process numbers). The reader waits for no notification and looks every ten
//! milliseconds instead, at no cost to fusion. Latencies are therefore taken to the moment at which fusion published,
//! as by a monitor that polls.
//!
//! | module | purpose |
//! |---|---|
//! | `watch` | combines the messages: an overview per interval |
//! | `attached` | joins the deployment, and detects the deployment's end |
//! | `terminal` | the screen and the keys, and the restored terminal |
//!
//! Where standard output is no terminal there is a line per interval instead. With `once`, all tables are printed after
//! one interval.
//!
//! Limits: counts and messages begin with the joining, and earlier incarnations of a process are included only as far
//! as received here. Deadlines are the monitor's; the monitor's count of late stages is shown.

mod attached;
mod terminal;
mod watch;

use std::io::{self, IsTerminal as _, Write as _};
use std::time::Duration;

use bus::Root;
use runtime::Now;
use runtime::signals::Stop;

use attached::{Attached, Look};

use crate::display::overview::Overview;
use crate::display::pages;

/// Time between two looks. The queue holds the data of thirty such times, at the highest rate measured with fusion.
const LOOK_EVERY: Duration = Duration::from_millis(10);

/// How to look on.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Time between two tables or lines.
    pub interval: Duration,
    /// Print everything after one interval in this form, and end.
    pub once: Option<Form>,
}

/// Form in which everything is printed once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Tables.
    Text,
    /// A JSON object.
    Json,
}

/// Shows the deployment that runs under `root` until the deployment ends, the user leaves, or a signal comes.
///
/// # Errors
/// If the deployment does not run, the terminal cannot be used, or shared memory fails.
pub fn run(root: &Root, settings: Settings) -> anyhow::Result<()> {
    let stop = Stop::on_signals()?;
    let attached = Attached::join(root, settings.interval, Now::read)?;
    let end = if let Some(form) = settings.once {
        watch(attached, &stop, |overview| {
            print(&match form {
                Form::Text => pages::everything(overview),
                Form::Json => serde_json::to_string_pretty(overview)? + "\n",
            })?;
            Ok(ReaderPresence::Enough)
        })?
    } else if io::stdout().is_terminal() {
        terminal::show(attached, &stop)?
    } else {
        watch(attached, &stop, |overview| print(&pages::line(overview)))?
    };
    if end == EndReason::OfInstance {
        print(&format!("instance {} has ended\n", root.instance()))?;
    }
    Ok(())
}

/// Why looking on has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum EndReason {
    /// The deployment has.
    OfInstance,
    /// The reader has seen enough.
    OfInterest,
}

/// Whether the reader still reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ReaderPresence {
    More,
    Enough,
}

/// Shows every interval's overview.
fn watch(
    mut attached: Attached<bus::SharedMemory>,
    stop: &Stop,
    mut show: impl FnMut(&Overview) -> anyhow::Result<ReaderPresence>,
) -> anyhow::Result<EndReason> {
    while !stop.requested() {
        match attached.look(Now::read())? {
            Look::Ended => return Ok(EndReason::OfInstance),
            Look::Interval(overview) => {
                if show(&overview)? == ReaderPresence::Enough {
                    break;
                }
            }
            Look::Nothing => std::thread::sleep(LOOK_EVERY),
        }
    }
    Ok(EndReason::OfInterest)
}

/// Prints; a reader that has gone (`| head`) has seen enough.
fn print(text: &str) -> anyhow::Result<ReaderPresence> {
    let mut out = io::stdout();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Ok(()) => Ok(ReaderPresence::More),
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(ReaderPresence::Enough),
        Err(error) => Err(error.into()),
    }
}
