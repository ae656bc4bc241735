//! Lines of simulated receivers of AIS, as a logger would keep them.

use std::io::Write as _;
use std::path::Path;

use anyhow::Context as _;
use frames::SystemFrame;
use observations::sensor_id;
use scenario::{SimulatedAis, Truth};
use simulator::AisFeed;

use crate::host::Host;

/// Time of the scenario's start in lines of AIS, seconds since 1970: 2020-01-01. In lines, numbers below those of 1973
/// stand for something else.
const AIS_MIDNIGHT_S: i64 = 1_577_836_800;

/// Writes the lines of receivers of AIS up to `end_s`; returns the number of messages. The scenario's start is the
/// midnight [`AIS_MIDNIGHT_S`].
pub(super) fn write_ais(
    host: &dyn Host,
    folder: &Path,
    source: u16,
    (receivers, frame): (SimulatedAis, SystemFrame),
    truth: &Truth,
    end_s: f64,
) -> anyhow::Result<u64> {
    let path = folder.join(format!("ais_{}.nmea", sensor_id(source)));
    let (mut out, mut feed) = (host.begin(&path)?, AisFeed::new(receivers, frame));
    let mut written = Ok(());
    while feed.due_s() <= end_s {
        host.progress(feed.due_s() as u64, end_s as u64)?;
        feed.deliver(truth, AIS_MIDNIGHT_S, &mut |lines| {
            if written.is_ok() {
                written = out.write_all(lines.as_bytes());
            }
        });
    }
    written.with_context(|| format!("{} cannot be written", path.display()))?;
    out.finish()?;
    Ok(feed.messages())
}
