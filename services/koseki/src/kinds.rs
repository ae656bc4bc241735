//! Kinds of files that a feed has.

use deployment::FeedFormat;
use formats::foreign::Foreign;

/// Returns the feed that a file of this kind may hold; `None` if no feed has such files.
pub(crate) fn feed_of(kind: Foreign) -> Option<FeedFormat> {
    match kind {
        Foreign::Sbs => Some(FeedFormat::Sbs),
        _ => None,
    }
}
