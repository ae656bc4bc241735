//! Systematic errors of one source, as estimated by fusion (BF-3).

use std::fmt;

use crate::codes;
use crate::codes::bits;
use crate::layout::sample;

bits! {
    /// Bits of [`Registration::removed`].
    registration_bits: u32 {
        /// The offset east is being removed from the source's reports.
        EAST = 1;
        /// The offset north is.
        NORTH = 1 << 1;
        /// The offset up is.
        UP = 1 << 2;
        /// The time offset is.
        TIME = 1 << 3;
        /// The range bias is.
        RANGE = 1 << 4;
        /// The azimuth bias is.
        AZIMUTH = 1 << 5;
    }
}

codes! {
    /// Kind of bias of a source.
    #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
    pub enum BiasKind: u8 {
        /// Azimuths are too large, clockwise, radians: a north mark that is off.
        Azimuth = 1, "azimuth";
        /// Ranges are too large, metres.
        Range = 2, "range";
        /// The clock is fast, seconds: targets are shown where they were so long before.
        Time = 3, "time";
        /// The place is off, east and north, metres.
        Position = 4, "position";
    }
}

codes! {
    /// Model of a source's systematic error.
    pub enum ErrorModel: u8 {
        /// No model has sufficient evidence.
        Undecided = 0, "undecided";
        /// Constant offset in the system frame.
        Offset = 1, "offset";
        /// Offset fixed to the target's body: a reference point other than that of other sources.
        Body = 2, "body";
        /// Offset that grows with range or azimuth.
        Polar = 3, "polar";
        /// Time offset.
        Time = 4, "time";
    }
}

/// Bias of a source relative to the tracks of another source.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Bias {
    /// Kind.
    pub kind: BiasKind,
    /// Amount, in the unit of the kind: one component; two for a position, east and north.
    pub value: [f64; 2],
    /// Number of the source that reveals the bias.
    pub partner: u16,
    /// Whether the bias certainly belongs to this source rather than to the partner.
    pub is_certain: bool,
    /// Whether the bias is removed from the source's reports.
    pub is_removed: bool,
}

/// Writes kind and amount.
impl fmt::Display for Bias {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [value, north] = self.value;
        match self.kind {
            BiasKind::Azimuth => write!(f, "{:+.2}° in azimuth", value.to_degrees()),
            BiasKind::Range => write!(f, "{value:+.0} m in range"),
            BiasKind::Time => write!(f, "{value:+.1} s in time"),
            BiasKind::Position => write!(f, "{value:+.0} m east and {north:+.0} m north"),
        }
    }
}

sample! {
    /// Systematic errors of one source, as estimated by fusion (BF-3), and the consistency of the source's
    /// covariances (BF-5).
    Registration, size 216 {
        /// Comparisons with other sources that the estimates rest on, after forgetting; 0: nothing is known.
        comparisons: f64,
        /// Estimated offset of the reports from the true positions (east, north, up), metres.
        offset_m: [f64; 3],
        /// Standard deviations of the offset, metres.
        offset_sigma_m: [f64; 3],
        /// Estimated time offset, seconds; positive if the reports show where the target was earlier.
        time_offset_s: f64,
        /// Standard deviation of the time offset, seconds.
        time_offset_sigma_s: f64,
        /// Estimated range bias, metres.
        range_bias_m: f64,
        /// Standard deviation of the range bias, metres.
        range_bias_sigma_m: f64,
        /// Estimated azimuth bias, clockwise, radians.
        azimuth_bias_rad: f64,
        /// Standard deviation of the azimuth bias, radians.
        azimuth_bias_sigma_rad: f64,
        /// Factor of covariance scaling for a source that overstates its accuracy; otherwise 1.
        covariance_inflation: f64 = 1.0,
        /// Which of the errors are being removed from the source's reports: `registration_bits`.
        removed: u32,
        /// Gross bias, 0 for none: its kind in the lowest byte, whether it is certain (1), removed (2) and an error
        /// among joined targets (4) in the next, the source of the comparison in the upper half;
        /// [`Registration::gross_error`], [`Registration::contradiction`].
        gross: u32,
        /// Offset of the source's clock against times of receipt, seconds; 0 with a standard deviation of 0: unknown.
        clock_offset_s: f64,
        /// Standard deviation of the clock offset, seconds; 0: unknown.
        clock_offset_sigma_s: f64,
        /// Amount of the gross error, in the unit of its kind.
        gross_value: [f64; 2],
        /// Standard deviation of the measurements of a smoothed source along the long axis of the error ellipse,
        /// metres; 0: not learned.
        long_sigma_m: f32,
        /// The same along the short axis, metres.
        short_sigma_m: f32,
        /// The same of the height, metres; 0: not learned.
        height_sigma_m: f32,
        /// Standard deviation across the line of sight over that along it, relative to the stated covariances; 0: as
        /// stated.
        shape_ratio: f32,
        /// Share of the source's new tracks that turned out to be targets, in (0, 1]; 0: not learned.
        target_share: f32,
        /// Delay of the reports, exceeded by one report in ten, seconds.
        lateness_s: f32,
        /// Probability that a scan detects a target that the source tracks, in (0, 1]; 0: not learned.
        detection_probability: f32,
        /// Model of the source's error with the best evidence: an `ErrorModel` code.
        error_model: u32,
        /// Sources with errors that depend on the errors of this source, if `dependence` is not 0.
        dependent_sources: [u16; 4],
        /// Correlation of the errors of this source and of `dependent_sources`, in (0, 1]; 0: none.
        dependence: [f32; 4],
        /// Step of which all time stamps of the source are multiples, if it enters the states, seconds; 0: the stamps
        /// are fine.
        stamp_step_s: f32,
        /// Standard deviation of the time offset that the step implies, seconds.
        stamp_sigma_s: f32,
    }
}

impl Registration {
    /// Sets the offset of the clock and its standard deviation, seconds; `None`: unknown.
    pub fn set_clock_offset(&mut self, known: Option<(f64, f64)>) {
        let (offset_s, sigma_s) = known.unwrap_or_default();
        self.clock_offset_s = offset_s;
        // 0 means unknown, and no clock has this accuracy.
        self.clock_offset_sigma_s = if known.is_some() { sigma_s.max(1e-9) } else { 0.0 };
    }

    /// Sets the bias of unassociated tracks, or else the [contradiction](Self::contradiction); `None`: there is none.
    pub fn set_gross_error(&mut self, gross: Option<Bias>, contradiction: Option<Bias>) {
        let error = gross.or(contradiction);
        self.gross_value = error.map_or([0.0; 2], |error| error.value);
        self.gross = error.map_or(0, |error| {
            let is_joined = gross.is_none();
            let says = u8::from(error.is_certain) | u8::from(error.is_removed) << 1 | u8::from(is_joined) << 2;
            let [low, high] = error.partner.to_le_bytes();
            u32::from_le_bytes([error.kind.code(), says, low, high])
        });
    }

    /// Returns the bias that unassociated tracks reveal; `None` if there is none, or if its kind is of a later version.
    pub fn gross_error(&self) -> Option<Bias> {
        self.bias(false)
    }

    /// Returns the bias among joined targets, beside sources that agree or relative to one that the source contradicts;
    /// likewise.
    pub fn contradiction(&self) -> Option<Bias> {
        self.bias(true)
    }

    fn bias(&self, joined: bool) -> Option<Bias> {
        let [kind, says, low, high] = self.gross.to_le_bytes();
        Some(Bias {
            kind: BiasKind::from_code(kind)?,
            value: self.gross_value,
            partner: u16::from_le_bytes([low, high]),
            is_certain: says & 1 != 0,
            is_removed: says & 2 != 0,
        })
        .filter(|_| (says & 4 != 0) == joined)
    }

    /// Whether all errors in `bits` are being removed from the source's reports.
    pub fn removes(&self, bits: u32) -> bool {
        self.removed & bits == bits
    }
}

impl Registration {
    /// Writes what was learned of the source beside its biases.
    fn write_learned(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.long_sigma_m > 0.0 {
            let (long, short) = (self.long_sigma_m, self.short_sigma_m);
            write!(f, ", smoothed: measurements ± {long:.0} and {short:.0} m")?;
            if self.height_sigma_m > 0.0 {
                write!(f, ", heights ± {:.0} m", self.height_sigma_m)?;
            }
        }
        if self.shape_ratio > 0.0 {
            write!(f, ", errors across the line of sight × {:.1}", self.shape_ratio)?;
        }
        if self.target_share > 0.0 && self.target_share < 0.95 {
            write!(f, ", {:.0} % of new tracks are targets", 100.0 * self.target_share)?;
        }
        if self.lateness_s > 0.5 {
            write!(f, ", up to {:.1} s late", self.lateness_s)?;
        }
        if self.stamp_step_s > 0.0 {
            let (step_s, sigma_s) = (self.stamp_step_s, self.stamp_sigma_s);
            write!(f, ", stamps are multiples of {step_s} s (± {sigma_s:.2} s)")?;
        }
        let dependent = self.dependent_sources.iter().zip(self.dependence);
        for (source, correlation) in dependent.filter(|(_, correlation)| *correlation > 0.0) {
            write!(f, ", depends on source {} ({correlation:.1})", source + 1)?;
        }
        Ok(())
    }
}

/// Writes one line for people: the horizontal offset always, other removed errors, and the covariance scaling if
/// any.
impl fmt::Display for Registration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(error) = self.gross_error() {
            let removed = if error.is_removed { "" } else { "not " };
            write!(f, "grossly off, {error} ({removed}removed); besides ")?;
        }
        if self.comparisons <= 0.0 {
            f.write_str("not compared with another source yet")?;
            return self.write_learned(f);
        }
        let [east, north, up] = self.offset_m;
        let [east_sigma, north_sigma, up_sigma] = self.offset_sigma_m;
        let horizontal = registration_bits::EAST | registration_bits::NORTH;
        let removed = if self.removes(horizontal) { "" } else { "not " };
        let sigma = east_sigma.max(north_sigma);
        write!(
            f,
            "{east:+.1} m east, {north:+.1} m north ± {sigma:.1} ({removed}removed)"
        )?;
        for (bit, what, value, sigma, unit) in [
            (registration_bits::UP, "up", up, up_sigma, "m"),
            (
                registration_bits::TIME,
                "late",
                self.time_offset_s,
                self.time_offset_sigma_s,
                "s",
            ),
            (
                registration_bits::RANGE,
                "range",
                self.range_bias_m,
                self.range_bias_sigma_m,
                "m",
            ),
            (
                registration_bits::AZIMUTH,
                "azimuth",
                self.azimuth_bias_rad.to_degrees(),
                self.azimuth_bias_sigma_rad.to_degrees(),
                "°",
            ),
        ] {
            if self.removes(bit) {
                write!(f, ", {what} {value:+.3} {unit} ± {sigma:.3} (removed)")?;
            }
        }
        if self.covariance_inflation > 1.0 {
            write!(f, ", covariances × {:.1}", self.covariance_inflation)?;
        }
        self.write_learned(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gross_error_comes_back_as_it_was() {
        let error = Bias {
            kind: BiasKind::Azimuth,
            value: [-0.00925, 0.0],
            partner: 513,
            is_certain: true,
            is_removed: false,
        };
        let mut known = Registration::default();
        assert_eq!(known.gross_error(), None);
        known.set_gross_error(Some(error), None);
        assert_eq!((known.gross_error(), known.contradiction()), (Some(error), None));
        assert!(
            known
                .to_string()
                .starts_with("grossly off, -0.53° in azimuth (not removed); besides not compared")
        );
        known.set_gross_error(None, Some(error));
        assert_eq!((known.gross_error(), known.contradiction()), (None, Some(error)));
        known.set_gross_error(None, None);
        assert_eq!(known, Registration::default());
    }

    #[test]
    fn people_read_what_is_removed() {
        let known = Registration {
            comparisons: 900.0,
            offset_m: [-1.5, -6.8, 3.0],
            offset_sigma_m: [0.2, 0.3, 9.0],
            covariance_inflation: 2.0,
            removed: registration_bits::EAST | registration_bits::NORTH,
            ..Registration::default()
        };
        let line = "-1.5 m east, -6.8 m north ± 0.3 (removed), covariances × 2.0";
        assert_eq!(known.to_string(), line);
        let learned = Registration {
            long_sigma_m: 310.0,
            short_sigma_m: 48.0,
            shape_ratio: 5.0,
            target_share: 0.625,
            lateness_s: 3.04,
            stamp_step_s: 0.5,
            stamp_sigma_s: 0.28868,
            dependent_sources: [1, 0, 0, 0],
            dependence: [0.93, 0.0, 0.0, 0.0],
            ..known
        };
        let more = ", smoothed: measurements ± 310 and 48 m, errors across the line of sight × 5.0, 62 % of new tracks are \
                    targets, up to 3.0 s late, stamps are multiples of 0.5 s (± 0.29 s), depends on source 2 (0.9)";
        assert_eq!(learned.to_string(), format!("{line}{more}"));
        let late = Registration {
            time_offset_s: 0.25,
            removed: registration_bits::TIME,
            ..known
        };
        assert!(late.to_string().contains("(not removed), late +0.250 s"), "{late}");
        assert!(Registration::default().to_string().contains("not compared"));
    }
}
