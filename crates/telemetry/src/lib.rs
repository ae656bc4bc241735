//! Where the time goes: latency of every stage, per source, as distributions.
//!
//! A mean hides what an operator fears: the report in a thousand that comes late. So each stage's latencies are kept as
//! a high-dynamic-range histogram, which tells any percentile to three significant digits at a fixed cost, and which
//! can be added to others (averages of percentiles mean nothing; the percentile of a sum of histograms is exact). See
//! G. Tene, *How NOT to Measure Latency*, and <https://hdrhistogram.github.io/HdrHistogram/>.
//!
//! - [`Stages`] records the stages of each system track that arrives (PL-8, PL-9);
//! - [`IntervalLog`] writes them, interval by interval, in the standard HdrHistogram log format;
//! - [`write_percentiles`] writes one distribution in the standard percentile format;
//! - [`Buckets`] is what a collector of metrics stores of one;
//! - [`Summary`] is what a table or a JSON file says of one;
//! - [`table`] sets figures out for people;
//! - [`DataOffset`] is how far the newest states are from the machine's clock;
//! - [`HealthBook`] knows what every process counts and how it is.
//!
//! Nothing here reads a clock or opens a file: stamps and writers are arguments.

#![forbid(unsafe_code)]

mod buckets;
mod data_offset;
mod deadlines;
mod health_book;
mod interval_log;
mod percentiles;
mod process;
mod stage;
mod stages;
mod summary;
pub mod table;

pub use buckets::{BUCKET_BOUNDS_NS, Buckets};
pub use data_offset::DataOffset;
pub use deadlines::Deadlines;
pub use health_book::{ChildState, HealthBook, Latest};
pub use interval_log::IntervalLog;
pub use percentiles::write_percentiles;
pub use process::{Process, State, process_title};
pub use stage::{JourneyEnd, Stage};
pub use stages::{Irregularities, Journey, OTHER_SOURCES, SOURCES_MAX, Span, Stages, VALUE_MAX_NS};
pub use summary::Summary;

/// A distribution of latencies, nanoseconds.
pub type Histogram = hdrhistogram::Histogram<u64>;
