//! `koseki top`: looks on at a running deployment, from any terminal.
//!
//! It is a reader like any other, joins without a configuration, and can leave at any time. What it shows it has from
//! three places: the health messages (what every process counts, and what sources are called), the stamps of the system
//! tracks (latencies), and the launcher's words (restarts, process numbers). It listens to nobody and looks every ten
//! milliseconds instead, so fusion does not notice it; latencies are therefore taken to the moment at which fusion
//! published, as by a monitor that polls.
//!
//! | module | purpose |
//! |---|---|
//! | `watch` | puts together what is heard: an overview per interval |
//! | `attached` | joins the deployment, and notices its end |
//! | `terminal` | the screen and the keys, and the restored terminal |
//!
//! Where standard output is no terminal there is one line per interval instead. With `once`, all tables are printed
//! after one interval.
//!
//! Limits: it knows what was counted and said since it joined, and of earlier incarnations of a process only what it
//! has heard itself. Deadlines are the monitor's; what it counted as late is shown.

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

/// Time between two looks: the queue holds what comes in thirty at the highest rate that fusion has been measured with.
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

/// Looks on at the deployment that runs under `root` until it ends, the user has seen enough, or a signal comes.
///
/// # Errors
/// If it does not run, the terminal cannot be used, or shared memory fails.
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
    /// Whoever looked has seen enough.
    OfInterest,
}

/// Whether there is somebody who reads on.
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
