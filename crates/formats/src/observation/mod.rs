//! ASTERIX target reports into observations.
//!
//! A file per category describes the meaning of the category's items. Reports of radio direction finders (CAT205) are
//! no targets; [`FinderReports`] makes bearings and fixes of them.

mod cat001;
mod cat010;
mod cat015;
mod cat020;
mod cat021_v0;
mod cat021_v2;
mod cat048;
mod cat062;
mod cat205;
mod finder_reports;
pub(crate) mod items;
pub(crate) mod navigation;
mod services;
mod transmissions;

pub use cat205::{DirectionFinder, FinderRefusal, FinderReport, FinderReportKind, finder_report};
pub use finder_reports::FinderReports;

use asterix::field::{Elements, Field, elements, field, item, whole};
use asterix::{Frn, Record};
use messages::{TrackState, alert_bits};
use observations::{Alerts, Axes, Observation, Plane, Quality, ServiceMessage};

use items::{
    Reply, alerts_of_advisory, alerts_of_emergency, alerts_of_surveillance_status, callsign, components, covariance,
    flight_status, identity, nanoseconds, secondary, service, state, time_of_day_ns,
};

/// Meaning of a record to the pipeline.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "it is taken apart at once, and must not allocate"
)]
pub enum Reading {
    /// A target report.
    Target(Observation),
    /// A record about the sensor itself.
    Service(ServiceMessage),
    /// A record of a category that reports no targets in any form known here.
    Other,
}

/// Reads an ASTERIX record of any category that reports targets.
pub fn read(record: &Record<'_>) -> Reading {
    let reading = match record.table().number {
        1 => cat001::read(record),
        10 => cat010::read(record),
        15 => cat015::read(record),
        20 => cat020::read(record),
        21 => cat021_v2::read(record).or_else(|| cat021_v0::read(record)),
        48 => cat048::read(record),
        62 => cat062::read(record),
        _ => services::read(record),
    };
    reading.unwrap_or(Reading::Other)
}

#[cfg(test)]
mod tests;
#[cfg(test)]
mod tests_015;
#[cfg(test)]
mod tests_205;
