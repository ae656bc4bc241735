//! Observations as a user states them: places in degrees or metres, angles in degrees, standard deviations.
//!
//! A sample in shared memory has metres of the system frame, radians, bits and codes. A program that fills samples in
//! converts frames itself, and a flat conversion is 0.8 km too high at 100 km from the origin. A [`Detection`] or a
//! [`TrackReport`] has named fields instead, and [`Publisher::send`](crate::Publisher::send) converts them
//! ([`frames::SystemFrame`]). `koseki feed`, C and Python have the same fields under the same names.
//!
//! A field that is not stated is unknown. A missing, contradictory or impossible value is a [`Fault`] that names field,
//! value, limit and remedy.

mod detection;
mod identity;
mod place;
mod scans;
mod track_report;

use frames::SystemFrame;
use messages::admission::{Admission, Fault};
use messages::{Identity, NS_PER_S, Outgoing};

pub use detection::Detection;
pub use identity::{callsign_of, name_of, numbered};
pub use scans::Scans;
pub use track_report::TrackReport;

/// Largest standard deviation, in the value's unit.
const SIGMA_MAX: f64 = 1e7;

/// Fields of an observation by their names: what other languages and lines of text fill in.
pub trait Fields: Copy + Default {
    /// Names of the fields that are numbers.
    const NUMBERS: &'static [&'static str];

    /// Returns the field called `name`, if it is a number.
    fn number_mut(&mut self, name: &str) -> Option<&mut Option<f64>>;

    /// Returns the time of measurement, UTC, nanoseconds since 1970.
    fn time_mut(&mut self) -> &mut Option<i64>;

    /// Returns the identity of the target.
    fn identity_mut(&mut self) -> &mut Identity;

    /// Returns the number of the scan, or of the track.
    fn ordinal_mut(&mut self) -> &mut Option<u32>;
}

/// An observation that becomes a sample.
pub trait Observation: Fields {
    /// What is published.
    type Sample: Outgoing + Admission;

    /// Returns the sample. An observation without a time is of `now_ns` (UTC, nanoseconds since 1970).
    ///
    /// # Errors
    /// The fault of a missing, contradictory or impossible value.
    fn sample(&self, frame: &SystemFrame, now_ns: i64) -> Result<Self::Sample, Fault>;

    /// Numbers the sample among those before it; without effect on samples that have no scans.
    fn count(&self, _sample: &mut Self::Sample, _scans: &mut Scans) {}
}

/// Declares an observation: fields that are numbers, each with a setter of the same name, then the others.
macro_rules! observation {
    (
        $(#[doc = $of_type:literal])+
        pub struct $name:ident by $ordinal:ident {
            numbers { $( $(#[doc = $doc:literal])+ $number:ident, )+ }
            $( $(#[doc = $of_other:literal])+ $other:ident: $kind:ty, )+
        }
    ) => {
        $(#[doc = $of_type])+
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct $name {
            $( $(#[doc = $doc])+ pub $number: Option<f64>, )+
            $( $(#[doc = $of_other])+ pub $other: $kind, )+
        }

        impl $crate::observation::Fields for $name {
            const NUMBERS: &'static [&'static str] = &[$(stringify!($number)),+];

            fn number_mut(&mut self, name: &str) -> Option<&mut Option<f64>> {
                $( if name == stringify!($number) {
                    return Some(&mut self.$number);
                } )+
                None
            }

            fn time_mut(&mut self) -> &mut Option<i64> {
                &mut self.time_ns
            }

            fn identity_mut(&mut self) -> &mut Identity {
                &mut self.identity
            }

            fn ordinal_mut(&mut self) -> &mut Option<u32> {
                &mut self.$ordinal
            }
        }

        impl $name {
            $(
                $(#[doc = $doc])+
                #[must_use]
                pub const fn $number(mut self, value: f64) -> Self {
                    self.$number = Some(value);
                    self
                }
            )+
        }
    };
}
use observation;

/// Returns a fault by its parts.
pub fn fault(field: &str, value: impl ToString, limit: &str, remedy: impl Into<String>) -> Fault {
    Fault {
        field: field.to_owned(),
        value: value.to_string(),
        limit: limit.to_owned(),
        remedy: remedy.into(),
    }
}

/// Returns the fault of a field that is needed and was not stated.
pub fn missing(field: &str, remedy: &str) -> Fault {
    fault(field, "missing", "the field is needed", remedy)
}

/// Returns seconds of UTC since 1970 as nanoseconds.
///
/// # Errors
/// The fault of a number that is none of seconds.
pub fn time_ns_of(seconds: f64) -> Result<i64, Fault> {
    if !(-4e9..=4e9).contains(&seconds) {
        let remedy = "give the seconds of UTC since 1970, or nanoseconds as time_ns";
        return Err(fault("time_s", seconds, "must be seconds of UTC since 1970", remedy));
    }
    // In two parts: a number of nanoseconds has more digits than a floating-point number.
    let whole = seconds.floor();
    Ok(whole as i64 * 1_000_000_000 + ((seconds - whole) * NS_PER_S).round() as i64)
}

/// Passes a standard deviation on if it is above 0.
fn sigma(name: &str, sigma: Option<f64>) -> Result<Option<f64>, Fault> {
    match sigma {
        Some(value) if !(value > 0.0 && value <= SIGMA_MAX) => {
            let remedy = "state the standard deviation of the sensor's error";
            Err(fault(name, value, "must be above 0 and at most 1e7", remedy))
        }
        sigma => Ok(sigma),
    }
}

/// Passes a standard deviation on; one of 0 means that its value is unknown.
fn sigma_or_unknown(name: &str, stated: Option<f64>) -> Result<Option<f64>, Fault> {
    match stated {
        Some(0.0) => Ok(stated),
        _ => sigma(name, stated),
    }
}

/// Passes an angle in degrees on, as radians.
fn angle(name: &str, degrees: Option<f64>) -> Result<Option<f64>, Fault> {
    match degrees {
        // Written so that NaN fails too.
        Some(value) if !(-360.0..=360.0).contains(&value) => {
            Err(fault(name, value, "must be from -360 to 360 degrees", "give degrees"))
        }
        degrees => Ok(degrees.map(f64::to_radians)),
    }
}

#[cfg(test)]
mod tests;
