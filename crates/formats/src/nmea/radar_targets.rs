//! Targets that a ship's radar tracks: the sentences TTM and TLL of IEC 61162-1.
//!
//! TTM states a target in relation to own ship: distance, bearing, speed and course, each true or relative. A relative
//! bearing counts from own ship's bow; a relative speed and course are those that own ship sees, its own motion not yet
//! added. TLL states latitude and longitude, as the radar has computed them from own ship's position. Neither states an
//! accuracy, and the time is that of the radar's measurement where it is stated at all.
//!
//! Read is what the sentence states, in units of this project. To relate a target to north and to the ground takes own
//! ship's heading and velocity at the same time, which come in other sentences.

use messages::TrackState;

use super::fields::{Fields, KNOT_MPS};
use super::sentence::{NmeaFault, SENTENCE_OCTETS_MAX, summed};

/// Metres of a nautical mile.
const M_PER_NM: f64 = 1852.0;
/// Metres of a statute mile.
const M_PER_MILE: f64 = 1609.344;
/// Greatest distance that is believed, in any of the units.
const DISTANCE_MAX: f64 = 1000.0;
/// Greatest speed that is believed, in any of the units.
const SPEED_MAX: f64 = 4000.0;

/// What a direction counts from, or a velocity moves against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reference {
    /// North; the ground or the water.
    True,
    /// Own ship's bow; own ship.
    Relative,
}

/// A direction, or a velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Referred<T> {
    /// The value.
    pub value: T,
    /// What it refers to.
    pub reference: Reference,
}

/// Where a radar's target is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RadarPlace {
    /// TTM: distance, metres, and bearing, radians clockwise from the bow or from north.
    Polar(f64, Referred<f64>),
    /// TLL: latitude and longitude, radians.
    Geodetic([f64; 2]),
}

/// A target as a radar states it.
#[derive(Clone, Debug, PartialEq)]
pub struct RadarTarget {
    /// Number of the target at the radar, 0 to 999.
    pub number: u32,
    /// The place; a target that is lost may have none.
    pub place: Option<RadarPlace>,
    /// TTM: speed, metres per second, and course, radians clockwise from the bow or from north.
    pub speed_course: Option<Referred<[f64; 2]>>,
    /// TTM: distance at the closest point of approach, metres, and time until then, seconds; negative if it is past.
    pub closest_approach: Option<[f64; 2]>,
    /// Name that an operator has given.
    pub name: Option<String>,
    /// Confirmed when tracked, tentative during acquisition, terminated when lost.
    pub state: TrackState,
    /// Time of day, UTC, nanoseconds since midnight.
    pub time_of_day_ns: Option<i64>,
}

impl RadarTarget {
    /// Reads a line without its end; `None` of a sentence other than TTM and TLL.
    ///
    /// # Errors
    /// [`NmeaFault`] for a line that is no sentence, a wrong checksum, or a field that cannot be meant.
    pub fn parse(line: &[u8]) -> Result<Option<Self>, NmeaFault> {
        let text = std::str::from_utf8(line).map_err(|_| NmeaFault::NoSentence)?.trim_end();
        let text = text.strip_prefix('$').ok_or(NmeaFault::NoSentence)?;
        if text.len() >= SENTENCE_OCTETS_MAX {
            return Err(NmeaFault::TooLong);
        }
        let (text, behind) = summed(text)?;
        if !behind.is_empty() {
            return Err(NmeaFault::Partial);
        }
        let (name, fields) = text.split_once(',').ok_or(NmeaFault::Field)?;
        let mut fields = Fields::of(fields);
        // Any talker: RA of a radar, II of an integrated system.
        match (name.len(), name.get(2..)) {
            (5, Some("TTM")) => Self::ttm(&mut fields).map(Some),
            (5, Some("TLL")) => Self::tll(&mut fields).map(Some),
            _ => Ok(None),
        }
    }

    fn ttm(fields: &mut Fields<'_>) -> Result<Self, NmeaFault> {
        let number = target_number(fields)?;
        let distance = fields.number(0.0, DISTANCE_MAX)?;
        let bearing_rad = fields.angle(0.0, 360.0)?;
        let bearing_reference = reference(fields.text())?;
        let speed = fields.number(0.0, SPEED_MAX)?;
        let course_rad = fields.angle(0.0, 360.0)?;
        let course_reference = reference(fields.text())?;
        let closest = fields.number(0.0, DISTANCE_MAX)?;
        let closest_min = fields.number(-1e4, 1e4)?;
        let [unit_m, unit_mps] = match fields.text() {
            "K" => [1000.0, 1.0 / 3.6],
            "N" => [M_PER_NM, KNOT_MPS],
            "S" => [M_PER_MILE, M_PER_MILE / 3600.0],
            "" if distance.or(speed).or(closest).is_none() => [0.0; 2],
            _ => return Err(NmeaFault::Field),
        };
        let name = name(fields);
        let state = state(fields.text())?;
        let _is_reference_target = fields.text();
        if bearing_rad.is_some() && bearing_reference.is_none() {
            return Err(NmeaFault::Field);
        }
        let place = distance
            .zip(bearing_rad)
            .zip(bearing_reference)
            .map(|((distance, value), reference)| RadarPlace::Polar(distance * unit_m, Referred { value, reference }));
        let speed_course = speed.zip(course_rad).zip(course_reference);
        Ok(Self {
            number,
            place,
            speed_course: speed_course.map(|((speed, course_rad), reference)| Referred {
                value: [speed * unit_mps, course_rad],
                reference,
            }),
            closest_approach: closest
                .zip(closest_min)
                .map(|(closest, minutes)| [closest * unit_m, minutes * 60.0]),
            name,
            state,
            time_of_day_ns: fields.time_of_day_ns()?,
        })
    }

    fn tll(fields: &mut Fields<'_>) -> Result<Self, NmeaFault> {
        let number = target_number(fields)?;
        let latitude = fields.coordinate(2, ["N", "S"])?;
        let longitude = fields.coordinate(3, ["E", "W"])?;
        let name = name(fields);
        let time_of_day_ns = fields.time_of_day_ns()?;
        let state = state(fields.text())?;
        let place = match latitude.zip(longitude) {
            Some((latitude, longitude)) if latitude.abs() <= 90.0 && longitude.abs() <= 180.0 => {
                Some(RadarPlace::Geodetic([latitude.to_radians(), longitude.to_radians()]))
            }
            None => None,
            Some(_) => return Err(NmeaFault::Field),
        };
        Ok(Self {
            number,
            place,
            speed_course: None,
            closest_approach: None,
            name,
            state,
            time_of_day_ns,
        })
    }
}

fn target_number(fields: &mut Fields<'_>) -> Result<u32, NmeaFault> {
    let text = fields.text();
    let is_number = text.len() <= 3 && text.bytes().all(|octet| octet.is_ascii_digit());
    text.parse().ok().filter(|_| is_number).ok_or(NmeaFault::Field)
}

fn name(fields: &mut Fields<'_>) -> Option<String> {
    Some(fields.text()).filter(|text| !text.is_empty()).map(str::to_owned)
}

fn reference(text: &str) -> Result<Option<Reference>, NmeaFault> {
    match text {
        "" => Ok(None),
        "T" => Ok(Some(Reference::True)),
        "R" => Ok(Some(Reference::Relative)),
        _ => Err(NmeaFault::Field),
    }
}

fn state(text: &str) -> Result<TrackState, NmeaFault> {
    match text {
        "L" => Ok(TrackState::Terminated),
        "Q" => Ok(TrackState::Tentative),
        "T" => Ok(TrackState::Confirmed),
        _ => Err(NmeaFault::Field),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn parsed(text: &str) -> Result<Option<RadarTarget>, NmeaFault> {
        let sum = text.bytes().fold(0, |sum, octet| sum ^ octet);
        RadarTarget::parse(format!("${text}*{sum:02X}\r\n").as_bytes())
    }

    fn target(text: &str) -> RadarTarget {
        parsed(text).unwrap().unwrap()
    }

    #[test]
    fn a_tracked_target_has_its_values_in_si_units() {
        let found = target("RATTM,11,11.4,13.6,T,7.0,20.0,T,0.5,-36,N,FERRY,T,,100021.50,A");
        let Referred { value, reference } = found.speed_course.unwrap();
        assert!((value[0] - 7.0 * 1852.0 / 3600.0).abs() < 1e-12 && reference == Reference::True);
        assert_eq!(value[1], 20f64.to_radians());
        let bearing = Referred {
            value: 13.6f64.to_radians(),
            reference: Reference::True,
        };
        assert_eq!(
            (found.number, found.place),
            (11, Some(RadarPlace::Polar(11.4 * 1852.0, bearing)))
        );
        assert_eq!(found.closest_approach, Some([926.0, -2160.0]));
        assert_eq!(
            (found.name.as_deref(), found.state),
            (Some("FERRY"), TrackState::Confirmed)
        );
        assert_eq!(found.time_of_day_ns, Some(36_021_500_000_000));
    }

    #[test]
    fn relative_values_and_other_units_are_read_as_stated() {
        let found = target("RATTM,03,2.0,359.9,R,36.0,180.0,R,,,K,,Q,R,,M");
        let Some(RadarPlace::Polar(distance_m, bearing)) = found.place else {
            panic!()
        };
        assert_eq!((distance_m, bearing.reference), (2000.0, Reference::Relative));
        let speed_course = found.speed_course.unwrap();
        assert_eq!(speed_course.reference, Reference::Relative);
        assert!((speed_course.value[0] - 10.0).abs() < 1e-12);
        assert_eq!(
            (found.closest_approach, found.name, found.time_of_day_ns),
            (None, None, None)
        );
        assert_eq!(found.state, TrackState::Tentative);
        let found = target("IITTM,999,1,90,T,,,,,,S,,L,,,A");
        assert_eq!((found.speed_course, found.state), (None, TrackState::Terminated));
        assert!(matches!(found.place, Some(RadarPlace::Polar(m, _)) if m == 1609.344));
    }

    #[test]
    fn a_target_with_latitude_and_longitude() {
        let found = target("RATLL,01,3647.422,N,01432.592,W,UTENTE,163200.86,T,");
        let Some(RadarPlace::Geodetic([latitude, longitude])) = found.place else {
            panic!()
        };
        assert!((latitude.to_degrees() - 36.790_366_67).abs() < 1e-8);
        assert!((longitude.to_degrees() + 14.543_2).abs() < 1e-8);
        assert_eq!((found.number, found.name.as_deref()), (1, Some("UTENTE")));
        assert_eq!(
            (found.time_of_day_ns, found.state),
            (Some(59_520_860_000_000), TrackState::Confirmed)
        );
        assert_eq!(
            target("RATLL,01,3647.422,N,01432.592,W,,,L,").state,
            TrackState::Terminated
        );
    }

    #[test]
    fn what_cannot_be_meant_is_refused() {
        for (text, fault) in [
            ("RATTM,1000,1,2,T,3,4,T,5,6,N,,T,,,A", NmeaFault::Field),
            ("RATTM,+1,1,2,T,3,4,T,5,6,N,,T,,,A", NmeaFault::Field),
            ("RATTM,1,1,361,T,3,4,T,5,6,N,,T,,,A", NmeaFault::Field),
            ("RATTM,1,1,2,X,3,4,T,5,6,N,,T,,,A", NmeaFault::Field),
            ("RATTM,1,1,2,,3,4,T,5,6,N,,T,,,A", NmeaFault::Field),
            ("RATTM,1,1,2,T,3,4,T,5,6,,,T,,,A", NmeaFault::Field),
            ("RATTM,1,1,2,T,3,4,T,5,6,N,,X,,,A", NmeaFault::Field),
            ("RATLL,1,9100.0,N,01432.592,W,,,T,", NmeaFault::Field),
            ("RATLL,1,3647.422,W,01432.592,N,,,T,", NmeaFault::Field),
        ] {
            assert_eq!(parsed(text), Err(fault), "{text}");
        }
        for lost in [
            "RATTM,1,,,T,,,T,,,N,,L,,,A",
            "RATTM,1,,,,,,,,,,,L,,,",
            "RATLL,1,,,,,,,L,",
        ] {
            let found = target(lost);
            assert_eq!((found.place, found.state), (None, TrackState::Terminated), "{lost}");
        }
        assert_eq!(parsed("RAOSD,1,2"), Ok(None));
        assert_eq!(RadarTarget::parse(b"$RATTM,1*00"), Err(NmeaFault::Checksum));
        assert_eq!(RadarTarget::parse(b"$RATTM,1"), Err(NmeaFault::Partial));
        assert_eq!(RadarTarget::parse(b"RATTM,1*00"), Err(NmeaFault::NoSentence));
    }

    proptest! {
        #[test]
        fn any_octets_are_taken(octets in prop::collection::vec(any::<u8>(), 0..120), fields in "[0-9A-Z.,-]{0,90}") {
            let _ = RadarTarget::parse(&octets);
            for name in ["RATTM", "RATLL"] {
                if let Ok(Some(found)) = parsed(&format!("{name},{fields}")) {
                    prop_assert!(found.number <= 999);
                }
            }
        }
    }
}
