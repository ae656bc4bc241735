//! The keys under which links meet: `koseki/<schema>/<deployment>/<topic>`.

use messages::layout::Sample;

/// Key of a topic's messages. A reader that was built with another layout does not meet them.
pub(crate) fn topic<T: Sample>(deployment: &str, topic: &str) -> String {
    format!("koseki/{:016x}/{deployment}/{topic}", T::SCHEMA)
}

/// Key of a topic's messages of any layout.
pub(crate) fn topic_of_any_layout(deployment: &str, topic: &str) -> String {
    format!("koseki/*/{deployment}/{topic}")
}

/// Key at which what was sent to a topic's `key` lately can be had again.
pub(crate) fn again(key: &str) -> String {
    format!("{key}/again")
}

/// Key at which the picture of a deployment as it is now can be had.
pub(crate) fn picture<T: Sample>(deployment: &str) -> String {
    format!("koseki/{:016x}/{deployment}/picture", T::SCHEMA)
}

/// Key at which a link tells its clocks, and which lives as long as it does.
pub(crate) fn clock(deployment: &str, link: &str) -> String {
    format!("koseki-clock/{deployment}/{link}")
}

/// Keys of all links' clocks.
pub(crate) const CLOCKS: &str = "koseki-clock/*/*";

/// Deployment and link whose clock is at `key`.
pub(crate) fn of_clock(key: &str) -> Option<(&str, &str)> {
    key.strip_prefix("koseki-clock/")?.split_once('/')
}
