//! Latency of every stage per source, as distributions.
//!
//! A mean hides the rare late report, which matters most to an operator. Each stage's latencies are therefore stored
//! as a high-dynamic-range histogram. Such a histogram gives any percentile to three significant digits at a fixed
//! cost, and histograms can be added (averages of percentiles mean nothing; the percentile of a sum of histograms is
//! exact). See G. Tene, *How NOT to Measure Latency*, and <https://hdrhistogram.github.io/HdrHistogram/>.
//!
//! - [`Stages`] records the stages of each system track that arrives (PL-8, PL-9);
//! - [`IntervalLog`] writes them, interval by interval, in the standard HdrHistogram log format;
//! - [`write_percentiles`] writes one distribution in the standard percentile format;
//! - [`Buckets`] is the form for collectors of metrics;
//! - [`Summary`] is the form for tables and JSON files;
//! - [`table`] formats figures for people;
//! - [`DataOffset`] is the offset of the newest states from the machine's clock.
//!
//! Architecture invariant: this crate reads no clock and opens no file; stamps and writers are arguments.

#![forbid(unsafe_code)]

mod buckets;
mod data_offset;
mod deadlines;
mod interval_log;
mod percentiles;
mod stage;
mod stages;
mod summary;
pub mod table;

pub use buckets::{BUCKET_BOUNDS_NS, Buckets};
pub use data_offset::DataOffset;
pub use deadlines::Deadlines;
pub use interval_log::IntervalLog;
pub use percentiles::write_percentiles;
pub use stage::{JourneyEnd, Stage};
pub use stages::{Irregularities, Journey, OTHER_SOURCES, SOURCES_MAX, Span, Stages, VALUE_MAX_NS};
pub use summary::Summary;

/// Distribution of latencies, nanoseconds.
pub type Histogram = hdrhistogram::Histogram<u64>;
