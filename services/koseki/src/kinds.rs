//! Kinds of files that a feed has.

use deployment::FeedFormat;
use formats::foreign::Foreign;

/// Returns the feed that a file of this kind may hold; `None` if no feed has such files.
pub(crate) fn feed_of(kind: Foreign) -> Option<FeedFormat> {
    match kind {
        Foreign::Sbs => Some(FeedFormat::Sbs),
        Foreign::Beast | Foreign::ModeS => Some(FeedFormat::ModeS),
        Foreign::Ais => Some(FeedFormat::Ais),
        Foreign::Nmea => Some(FeedFormat::RadarTargets),
        Foreign::Json => Some(FeedFormat::Readsb),
        _ => None,
    }
}
