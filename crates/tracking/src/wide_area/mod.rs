//! Support by a wide-area sensor that knows how many targets there are (WA).
//!
//! On-board sensors are accurate and fast, but see targets that fly close together as one. A remote sensor has watched
//! the same targets since they were apart. Its detections would not help: they are coarse, rare and late. The obvious
//! way, to feed them to the tracker like any others, makes tracks worse and work more. But that sensor knows how *many*
//! there are, and that is just what the on-board detections cannot tell. So only the number is used, and it touches
//! nothing but reliabilities: not a detection, gate or interpretation is added.
//!
//! A report ([`WideAreaReport`]) arrives late; what it says is of its time of observation. The clusters' tracks are
//! moved there along their velocities, and the cluster meant is found ([`choice`]) or the number is shared among
//! several ([`distribution`]). In the first scan after its arrival the hypotheses of that cluster, and then the
//! children of each of them, are corrected ([`correction`]). For as long as a report is valid, hypotheses with enough
//! tracks are held at a small share, so that they are still there when the next one comes; the report also helps new
//! tracks to be confirmed, and its silence about a place that it covers helps clusters to be given up ([`settings`]).
//!
//! Everything is derived anew in each scan from the reports and the population before the scan. So scans that are
//! worked off again after a late one see the same reports in the same places, and the same input gives the same bits.
//!
//! What goes with it and is used by others: where the tracks of another system become counts ([`counting`]), where
//! reports wait until their time has come ([`arrivals`]), whether targets are followed as a group ([`group`]), who they
//! are (`identification`, from each [`Emission`] and where the targets came from), what is known beforehand
//! ([`prior`]), and where sensors should look next ([`cue`]); and when pictures are given out ([`schedule`]).
//!
//! Source: patent JP4702010B2.

pub mod arrivals;
pub(crate) mod carried;
pub(crate) mod children;
pub mod choice;
pub mod correction;
pub mod counting;
pub mod cue;
pub(crate) mod description;
pub mod distribution;
pub mod emission;
pub(crate) mod expectation;
pub mod group;
pub(crate) mod identification;
pub mod prior;
pub(crate) mod report;
pub mod schedule;
pub mod settings;
pub(crate) mod support;

pub use emission::{Emission, EmissionRejection};
pub use observations::WideAreaReport;
pub use report::{ReportRejection, TARGETS_MAX, fault_in};
pub use settings::WideArea;
