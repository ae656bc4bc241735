//! Rows of a trace: cells by place, and details now and then.
//!
//! | place | cell |
//! | --- | --- |
//! | 0 | seconds after the time of the trace |
//! | 1, 2 | latitude and longitude, degrees |
//! | 3 | altitude in feet, `ground` or null |
//! | 4, 5 | ground speed in knots, track in degrees (on the ground a heading) |
//! | 6 | bits: 4 vertical rate is geometric, 8 altitude is geometric |
//! | 7 | vertical rate in feet per minute |
//! | 8 | details, an object with the keys of a state, or null |
//! | 9 | type |
//! | 10, 11 | geometric altitude in feet, its rate in feet per minute |
//!
//! Further cells are not used; rows of older programs end behind the details.

use serde::de::DeserializeOwned;
use serde_json::value::RawValue;

use super::aircraft::{AircraftState, Altitude, within};
use super::reason::{Read, ReadsbReason};
use crate::target_message::Refusal;

/// Age of details up to which they serve for a row, seconds: as long as callsigns of [`sbs`](crate::sbs).
pub const DETAIL_AGE_MAX_S: f64 = 60.0;

/// Bit of a geometric vertical rate.
const RATE_IS_GEOMETRIC: u32 = 4;
/// Bit of a geometric altitude.
const ALTITUDE_IS_GEOMETRIC: u32 = 8;
/// Longest time between the first and the last row, seconds: a trace has a day, with some margin.
const SPAN_MAX_S: f64 = 3.0 * 86_400.0;

/// A trace, as far as it has been read.
#[derive(Debug)]
pub(super) struct Trace {
    hex: String,
    /// Time of the latest details, seconds, and the details.
    details: Option<(f64, AircraftState)>,
}

impl Trace {
    pub(super) fn new(hex: String) -> Self {
        Self { hex, details: None }
    }

    /// The state of a row, and its time after that of the trace, seconds.
    pub(super) fn row(&mut self, row: &RawValue) -> Read<(AircraftState, f64)> {
        let cells: Vec<&RawValue> = read(row)?;
        let number = |place: usize| cell::<f64>(&cells, place);
        let after_s = within(ReadsbReason::Time, "seconds", number(0)?, &(0.0..=SPAN_MAX_S))?;
        let after_s = after_s.ok_or_else(|| Refusal::new(ReadsbReason::Time, "row", row.get()))?;
        if let Some(text) = cells.get(8).filter(|text| text.get().starts_with('{')) {
            self.details = Some((after_s, read(text)?));
        }
        let is_recent = |at_s: f64| (after_s - at_s).abs() <= DETAIL_AGE_MAX_S;
        let details = self.details.as_ref().filter(|(at_s, _)| is_recent(*at_s));
        let details = details.map(|(_, state)| state.clone()).unwrap_or_default();
        let bits = cell::<u32>(&cells, 6)?.unwrap_or(0);
        let altitude = cell::<Altitude>(&cells, 3)?;
        let is_airborne = !matches!(altitude, Some(Altitude::Word(_)));
        let mut state = AircraftState {
            hex: Some(self.hex.clone()),
            kind: cell::<String>(&cells, 9)?.or(details.kind),
            mlat: details.mlat,
            tisb: details.tisb,
            lat: number(1)?,
            lon: number(2)?,
            alt_geom: number(10)?,
            gs: number(4)?,
            track: number(5)?.filter(|_| is_airborne),
            geom_rate: number(11)?,
            flight: details.flight,
            squawk: details.squawk,
            emergency: details.emergency,
            nac_p: details.nac_p,
            nac_v: details.nac_v,
            category: details.category,
            nav_altitude_mcp: details.nav_altitude_mcp,
            ..AircraftState::default()
        };
        match altitude {
            Some(Altitude::Feet(feet)) if bits & ALTITUDE_IS_GEOMETRIC != 0 => state.alt_geom = Some(feet),
            altitude => state.alt_baro = altitude,
        }
        match number(7)? {
            Some(rate) if bits & RATE_IS_GEOMETRIC != 0 => state.geom_rate = Some(rate),
            rate => state.baro_rate = rate,
        }
        Ok((state, after_s))
    }
}

/// The value of a JSON text.
fn read<'a, T: serde::Deserialize<'a>>(text: &'a RawValue) -> Read<T> {
    serde_json::from_str(text.get()).map_err(|error| Refusal::new(ReadsbReason::Json, "JSON", error))
}

/// The value of a cell; `None` if it is null, or the row is shorter.
fn cell<T: DeserializeOwned>(cells: &[&RawValue], place: usize) -> Read<Option<T>> {
    cells.get(place).map_or(Ok(None), |text| read(text))
}
