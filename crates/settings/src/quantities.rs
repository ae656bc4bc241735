//! Quantities that files have in one unit and algorithms in another.

use crate::spelt_as;

/// Nanoseconds in a second.
const NS_PER_S: f64 = 1e9;

/// A time that files have in seconds, rounded to whole nanoseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Seconds {
    ns: i64,
}

impl Seconds {
    /// So many seconds.
    pub fn of(seconds: f64) -> Self {
        Self {
            ns: (seconds * NS_PER_S).round() as i64,
        }
    }

    /// So many nanoseconds.
    pub const fn of_ns(ns: i64) -> Self {
        Self { ns }
    }

    /// Nanoseconds.
    pub const fn ns(self) -> i64 {
        self.ns
    }

    /// Seconds.
    pub fn s(self) -> f64 {
        self.ns as f64 / NS_PER_S
    }
}

/// An angle that files have in degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct Degrees {
    rad: f64,
}

impl Degrees {
    /// So many degrees.
    pub const fn of(degrees: f64) -> Self {
        Self {
            rad: degrees.to_radians(),
        }
    }

    /// So many radians.
    pub const fn of_rad(rad: f64) -> Self {
        Self { rad }
    }

    /// Radians.
    pub const fn rad(self) -> f64 {
        self.rad
    }

    /// Degrees, rounded to a billionth: the way to radians and back is not exact.
    pub fn deg(self) -> f64 {
        (self.rad.to_degrees() * 1e9).round() / 1e9
    }
}

/// A quantity is a number, also where a key has no range.
fn finite<T>(number: f64, of: fn(f64) -> T) -> Result<T, String> {
    match number.is_finite() {
        true => Ok(of(number)),
        false => Err(format!("{number} is no quantity; write a number")),
    }
}

spelt_as!(Seconds, f64, "number", |seconds| finite(seconds, Self::of), |time| time
    .s());
spelt_as!(Degrees, f64, "number", |degrees| finite(degrees, Self::of), |angle| {
    angle.deg()
});
