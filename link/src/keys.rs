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

/// Returns the key at which recent messages of a topic's `key` can be requested again.
pub(crate) fn again(key: &str) -> String {
    format!("{key}/again")
}

/// Key at which the picture of a deployment as it is now can be had.
pub(crate) fn picture<T: Sample>(deployment: &str) -> String {
    format!("koseki/{:016x}/{deployment}/picture", T::SCHEMA)
}

/// Returns the key at which a link publishes its clocks; the key exists as long as the link.
pub(crate) fn clock(deployment: &str, link: &str) -> String {
    format!("koseki-clock/{deployment}/{link}")
}

/// Keys of all links' clocks.
pub(crate) const CLOCKS: &str = "koseki-clock/*/*";

/// Returns deployment and link of the clock at `key`.
pub(crate) fn of_clock(key: &str) -> Option<(&str, &str)> {
    key.strip_prefix("koseki-clock/")?.split_once('/')
}
