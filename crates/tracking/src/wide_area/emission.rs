//! Emissions received on board (WA-9), and the list of emissions that a scan may still use.

use observations::Bearing;

use super::report::PLACE_MAX_M;

/// Most emissions kept at a time.
pub const EMISSIONS_KEPT_MAX: usize = 1024;

/// Emission as received.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emission {
    /// Time of receipt, UTC, nanoseconds.
    pub time_ns: i64,
    /// Bearing clockwise from north, radians.
    pub bearing_rad: f64,
    /// Standard deviation of the bearing, radians.
    pub sigma_rad: f64,
    /// Position of the receiver, east and north in the system frame, metres.
    pub platform_m: [f64; 2],
    /// Hertz.
    pub frequency_hz: f64,
    /// Seconds between pulses, if there are any.
    pub pulse_interval_s: Option<f64>,
}

/// Reason why an emission was rejected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EmissionRejection {
    /// No type is described, so the emission could be of none.
    NoTypes,
    /// A value is no number, or cannot be.
    NoNumber,
    /// Received this many nanoseconds before the closed scans: more than allowed.
    TooLate(i64),
    /// No room for another emission.
    Full,
}

impl std::fmt::Display for EmissionRejection {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NoTypes => write!(formatter, "no type of target is described that it could be of"),
            Self::NoNumber => write!(
                formatter,
                "bearing and place must be numbers, standard deviation, frequency and pulse interval greater than 0"
            ),
            Self::TooLate(delay_ns) => write!(
                formatter,
                "it was received {:.1} s before a scan that is closed; allow a longer delay if that is right",
                *delay_ns as f64 / messages::NS_PER_S
            ),
            Self::Full => write!(formatter, "{EMISSIONS_KEPT_MAX} emissions wait for the next scan"),
        }
    }
}

impl std::error::Error for EmissionRejection {}

impl Emission {
    /// Makes an emission of a direction finder's bearing; `None` without a frequency, which is needed to identify a
    /// type.
    pub fn of(bearing: &Bearing) -> Option<Self> {
        let [east, north, _] = bearing.platform_m;
        Some(Self {
            time_ns: bearing.time_of_measurement_ns,
            bearing_rad: bearing.bearing_rad,
            sigma_rad: bearing.sigma_rad,
            platform_m: [east, north],
            frequency_hz: bearing.frequency_hz?,
            pulse_interval_s: bearing.pulse_interval_s,
        })
    }

    fn is_whole(&self) -> bool {
        let positive = |value: f64| value > 0.0 && value.is_finite();
        self.bearing_rad.is_finite()
            && self.platform_m.iter().all(|place| place.abs() <= PLACE_MAX_M)
            && positive(self.sigma_rad)
            && positive(self.frequency_hz)
            && self.pulse_interval_s.is_none_or(positive)
    }
}

/// Emissions still in use, in the order of use by scans.
#[derive(Clone, Debug)]
pub(crate) struct Emissions {
    /// Each with the earliest time of a scan that uses the emission, nanoseconds.
    list: Vec<(i64, Emission)>,
}

impl Emissions {
    /// With room for none, where there are no types.
    pub(crate) fn new(types: usize) -> Self {
        let room = if types == 0 { 0 } else { EMISSIONS_KEPT_MAX };
        Self {
            list: Vec::with_capacity(room),
        }
    }

    /// Stores an emission, and returns the earliest time of a scan that uses the emission. Emissions that no scan after
    /// `closed_ns` uses are removed.
    pub(crate) fn keep(
        &mut self,
        emission: &Emission,
        closed_ns: i64,
        delay_max_ns: i64,
    ) -> Result<i64, EmissionRejection> {
        if self.list.capacity() == 0 {
            return Err(EmissionRejection::NoTypes);
        }
        if !emission.is_whole() {
            return Err(EmissionRejection::NoNumber);
        }
        let delay_ns = closed_ns.saturating_sub(emission.time_ns);
        if delay_ns > delay_max_ns {
            return Err(EmissionRejection::TooLate(delay_ns));
        }
        self.list.retain(|(due_ns, _)| *due_ns > closed_ns);
        if self.list.len() >= EMISSIONS_KEPT_MAX {
            return Err(EmissionRejection::Full);
        }
        let due_ns = emission.time_ns.max(closed_ns.saturating_add(1));
        let order = |due_ns: i64, emission: &Emission| (due_ns, emission.time_ns);
        let place = self
            .list
            .partition_point(|(kept_ns, kept)| order(*kept_ns, kept) <= order(due_ns, emission));
        self.list.insert(place, (due_ns, *emission));
        Ok(due_ns)
    }

    /// Emissions used by a scan at `until_ns` that follows a scan at `after_ns`.
    pub(crate) fn between(&self, after_ns: i64, until_ns: i64) -> impl Iterator<Item = &Emission> {
        let first = self.list.partition_point(|(due_ns, _)| *due_ns <= after_ns);
        let due = self.list[first..].iter();
        due.take_while(move |(due_ns, _)| *due_ns <= until_ns)
            .map(|(_, emission)| emission)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AT_5: Emission = Emission {
        time_ns: 5,
        bearing_rad: 0.0,
        sigma_rad: 0.01,
        platform_m: [0.0; 2],
        frequency_hz: 9.4e9,
        pulse_interval_s: None,
    };

    #[test]
    fn each_is_used_by_the_first_scan_after_it() {
        let mut emissions = Emissions::new(1);
        let late = Emission { time_ns: 2, ..AT_5 };
        assert_eq!(emissions.keep(&AT_5, 3, 10), Ok(5));
        assert_eq!(emissions.keep(&late, 3, 10), Ok(4), "a closed scan cannot use it");
        let times = |after_ns, until_ns| {
            let due = emissions.between(after_ns, until_ns);
            due.map(|emission| emission.time_ns).collect::<Vec<_>>()
        };
        assert_eq!(
            (times(3, 5), times(3, 4), times(4, 9), times(5, 9)),
            (vec![2, 5], vec![2], vec![5], vec![])
        );
    }

    #[test]
    fn what_is_no_emission_is_refused_with_a_reason() {
        let refused = |types, emission: Emission| Emissions::new(types).keep(&emission, 100, 10).unwrap_err();
        let good = Emission { time_ns: 95, ..AT_5 };
        assert_eq!(refused(0, good), EmissionRejection::NoTypes);
        assert_eq!(refused(1, AT_5), EmissionRejection::TooLate(95));
        for wrong in [
            Emission {
                bearing_rad: f64::NAN,
                ..good
            },
            Emission { sigma_rad: 0.0, ..good },
            Emission {
                platform_m: [0.0, 1e12],
                ..good
            },
            Emission {
                frequency_hz: -1.0,
                ..good
            },
            Emission {
                pulse_interval_s: Some(f64::INFINITY),
                ..good
            },
        ] {
            assert_eq!(refused(1, wrong), EmissionRejection::NoNumber, "{wrong:?}");
        }
        let mut full = Emissions::new(1);
        while full.keep(&good, 90, 10).is_ok() {}
        assert_eq!(full.list.len(), EMISSIONS_KEPT_MAX);
        assert_eq!(full.keep(&good, 90, 10), Err(EmissionRejection::Full));
        assert_eq!(full.keep(&good, 100, 10), Ok(101), "closed scans have used the others");
    }
}
