//! Support by a wide-area sensor that reports the number of targets (WA).
//!
//! On-board sensors are accurate and fast, but see targets that fly close together as a single target. A remote sensor
//! has observed the same targets since a time when all were apart. The detections of this sensor would not help:
//! coarse, rare and late detections as ordinary tracker input degrade tracks and increase the load. But that sensor
//! reports the *number* of targets, which on-board detections cannot show. So only the number is used, and only to
//! change reliabilities: no detection, gate or interpretation is added.
//!
//! A report ([`WideAreaReport`]) arrives late; the content refers to the time of observation. The clusters' tracks are
//! moved to that time along the velocities, and the matching cluster is found ([`choice`]), or the number is shared
//! among several clusters ([`distribution`]). In the first scan after the arrival, the hypotheses of that cluster and
//! then the children are corrected ([`correction`]). While a report is valid, hypotheses with enough tracks keep a
//! small share, and so still exist at the next report. The report also eases the confirmation of new tracks, and the
//! absence of targets in a covered place accelerates deletion ([`settings`]).
//!
//! Everything is derived anew in each scan from the reports and the population before the scan. So scans that are
//! processed again after a late scan use the same reports in the same places, and the same input gives the same bits.
//!
//! Further modules: counts from the tracks of another system ([`counting`]), the queue of reports ([`arrivals`]),
//! groups ([`group`]), identification (`identification`, from each [`Emission`] and the origin of the targets),
//! prior knowledge ([`prior`]), search regions for sensors ([`cue`]), and the times of publication ([`schedule`]).
//!
//! Source: patent JP4702010B2.

pub mod arrivals;
pub(crate) mod carried;
pub(crate) mod children;
pub mod choice;
pub(crate) mod confirmation;
pub mod correction;
pub mod counting;
pub mod cue;
pub(crate) mod description;
pub mod distribution;
pub mod emission;
pub(crate) mod expectation;
pub mod group;
pub(crate) mod identification;
pub mod matching;
pub mod prior;
pub(crate) mod report;
pub mod schedule;
pub mod settings;
pub(crate) mod support;

pub use emission::{Emission, EmissionRejection};
pub use observations::WideAreaReport;
pub use report::{ReportRejection, TARGETS_MAX, fault_in};
pub use settings::SupportSettings;
