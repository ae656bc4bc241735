//! Observations in degrees or metres: the structs `koseki_detection` and `koseki_track_report` of the header.
//!
//! Both have the same head, a track report with its state in it, and then their numbers in the order of
//! [`Fields::NUMBERS`]. NaN stands for a number that is
//! not stated. The first member is the size in the caller's header, which shows a header of another version.

use std::ffi::{c_char, c_int};
use std::slice;

use koseki_client::by_name::{self, AnyPublisher};
use koseki_client::messages::admission::Fault;
use koseki_client::messages::{IdentityText, TrackState};
use koseki_client::observation::{Fields, callsign_of, fault, numbered};
use koseki_client::{Detection, Error, ErrorKind, TrackReport};

use crate::{KosekiPublisher, OK, code, failed, open};

/// Characters of a callsign, with its zero.
const CALLSIGN: usize = 16;

/// A state that an observation may have: `()` for none, else its code.
pub trait StateCode: Copy {
    /// Not stated.
    const UNKNOWN: Self;
}

impl StateCode for () {
    const UNKNOWN: Self = ();
}

impl StateCode for i64 {
    const UNKNOWN: Self = -1;
}

/// An observation with `N` numbers, and a state `S`.
#[derive(Debug)]
#[repr(C)]
pub struct Stated<const N: usize, S> {
    size: usize,
    /// 0: now.
    time_ns: i64,
    /// Scan or track; -1: not stated.
    ordinal: i64,
    /// Of a track; -1: confirmed.
    state: S,
    /// 0: unknown, like the MMSI.
    address: u32,
    mmsi: u32,
    /// Ends with a zero; empty: unknown.
    callsign: [u8; CALLSIGN],
    numbers: [f64; N],
}

/// `koseki_detection` of the header.
pub type KosekiDetection = Stated<22, ()>;
/// `koseki_track_report` of the header.
pub type KosekiTrackReport = Stated<15, i64>;
const _: () = assert!(Detection::NUMBERS.len() == 22 && TrackReport::NUMBERS.len() == 15);

impl<const N: usize, S: StateCode> Stated<N, S> {
    const UNKNOWN: Self = Self {
        size: size_of::<Self>(),
        time_ns: 0,
        ordinal: -1,
        state: S::UNKNOWN,
        address: 0,
        mmsi: 0,
        callsign: [0; CALLSIGN],
        numbers: [f64::NAN; N],
    };

    /// Returns the observation, but for its state.
    fn observation<O: Fields>(&self, ordinal: &str) -> Result<O, Fault> {
        let mut observation = O::default();
        for (name, value) in O::NUMBERS.iter().zip(self.numbers) {
            if let Some(number) = observation.number_mut(name) {
                *number = (!value.is_nan()).then_some(value);
            }
        }
        *observation.time_mut() = (self.time_ns != 0).then_some(self.time_ns);
        *observation.ordinal_mut() = match self.ordinal {
            -1 => None,
            number => Some(u32::try_from(number).map_err(|_| {
                let limit = "must be a whole number from 0 to 4294967295";
                fault(ordinal, number, limit, "-1: not stated")
            })?),
        };
        let identity = observation.identity_mut();
        for (kind, number) in [(IdentityText::ADDRESS, self.address), (IdentityText::MMSI, self.mmsi)] {
            if number != 0 {
                *identity = numbered(*identity, kind, number)?;
            }
        }
        let length = self.callsign.iter().position(|octet| *octet == 0).unwrap_or(CALLSIGN);
        if length > 0 {
            let text = String::from_utf8_lossy(&self.callsign[..length]);
            *identity = identity.with_callsign(callsign_of(&text)?);
        }
        Ok(observation)
    }
}

fn detection(stated: &KosekiDetection) -> Result<Detection, Fault> {
    stated.observation("scan")
}

fn report(stated: &KosekiTrackReport) -> Result<TrackReport, Fault> {
    let mut report: TrackReport = stated.observation("track")?;
    if stated.state != -1 {
        let state = u8::try_from(stated.state).ok().and_then(TrackState::from_code);
        let wrong = || {
            fault(
                "state",
                stated.state,
                "is no code of a state",
                "use KOSEKI_STATE_…, or -1",
            )
        };
        report.state = Some(state.ok_or_else(wrong)?);
    }
    Ok(report)
}

/// Fills `size` bytes at `place` in as an observation that states nothing.
///
/// # Safety
/// `place` is null or has `size` bytes that can be written to.
unsafe fn begin<const N: usize, S: StateCode>(place: *mut Stated<N, S>, size: usize) {
    if place.is_null() || size < size_of::<usize>() {
        return;
    }
    // SAFETY: guaranteed by the caller, as stated above.
    unsafe {
        if size == size_of::<Stated<N, S>>() {
            place.write(Stated::UNKNOWN);
        } else {
            // Of another header: sending refuses it by its size.
            place.cast::<u8>().write_bytes(0, size);
            place.cast::<usize>().write(size);
        }
    }
}

/// Converts `count` observations and sends them.
///
/// # Safety
/// `publisher` is null or an open handle, used by one thread at a time; `stated` is null or has `count` structs.
unsafe fn send<const N: usize, S, O>(
    publisher: *mut KosekiPublisher,
    stated: *const Stated<N, S>,
    count: usize,
    convert: fn(&Stated<N, S>) -> Result<O, Fault>,
    send: fn(&mut dyn AnyPublisher, &[O]) -> Result<(), Error>,
) -> c_int {
    // SAFETY: guaranteed by the caller, as stated above.
    let (Some(publisher), false) = (unsafe { publisher.as_mut() }, stated.is_null() && count > 0) else {
        return failed(ErrorKind::Argument, "publisher or observations are null".to_owned());
    };
    if count == 0 {
        return OK;
    }
    // SAFETY: the first member of the first struct, of which there is one.
    let size = unsafe { stated.cast::<usize>().read() };
    if size != size_of::<Stated<N, S>>() {
        let text = format!(
            "the observation has {size} bytes, and {} in this library: make it with the functions of koseki.h, and \
             compile with the library's own koseki.h",
            size_of::<Stated<N, S>>()
        );
        return failed(ErrorKind::Schema, text);
    }
    // SAFETY: guaranteed by the caller; the structs have the size of this library's.
    let stated = unsafe { slice::from_raw_parts(stated, count) };
    let converted = stated.iter().enumerate().map(|(index, stated)| {
        convert(stated).map_err(|fault| Error::Observation {
            index,
            fault: Box::new(fault),
        })
    });
    let sent = converted.collect::<Result<Vec<O>, Error>>();
    code(
        sent.and_then(|observations| send(&mut *publisher.0, &observations))
            .map(|()| OK),
    )
}

/// See the header.
///
/// # Safety
/// As documented in the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn koseki_feed(
    instance: *const c_char,
    source: *const c_char,
    handle: *mut *mut KosekiPublisher,
) -> c_int {
    // SAFETY: the contract of the header.
    unsafe {
        open(instance, source, handle, by_name::feed, |opened| {
            Ok(KosekiPublisher(opened))
        })
    }
}

/// See the header.
///
/// # Safety
/// As documented in the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn koseki_begin_detection(detection: *mut KosekiDetection, size: usize) {
    // SAFETY: the contract of the header.
    unsafe { begin(detection, size) }
}

/// See the header.
///
/// # Safety
/// As documented in the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn koseki_begin_track_report(report: *mut KosekiTrackReport, size: usize) {
    // SAFETY: the contract of the header.
    unsafe { begin(report, size) }
}

/// See the header.
///
/// # Safety
/// As documented in the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn koseki_send_detections(
    publisher: *mut KosekiPublisher,
    detections: *const KosekiDetection,
    count: usize,
) -> c_int {
    // SAFETY: the contract of the header.
    unsafe {
        send(publisher, detections, count, detection, |publisher, all| {
            publisher.send_detections(all)
        })
    }
}

/// See the header.
///
/// # Safety
/// As documented in the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn koseki_send_track_reports(
    publisher: *mut KosekiPublisher,
    reports: *const KosekiTrackReport,
    count: usize,
) -> c_int {
    // SAFETY: the contract of the header.
    unsafe {
        send(publisher, reports, count, report, |publisher, all| {
            publisher.send_tracks(all)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_header_has_the_numbers_in_their_order() {
        let header = include_str!("../include/koseki.h");
        for (names, name) in [
            (Detection::NUMBERS, "} koseki_detection;"),
            (TrackReport::NUMBERS, "} koseki_track_report;"),
        ] {
            let end = header.find(name).unwrap();
            let begin = header[..end].rfind("typedef struct").unwrap();
            let doubles = header[begin..end]
                .lines()
                .filter_map(|line| line.trim().strip_prefix("double "));
            let stated: Vec<&str> = doubles.filter_map(|line| Some(line.split_once(';')?.0)).collect();
            assert_eq!(stated, names);
        }
    }

    #[test]
    fn what_is_not_stated_stays_unknown() {
        let mut stated = KosekiDetection::UNKNOWN;
        stated.numbers[0] = 41.5;
        stated.callsign[..4].copy_from_slice(b"DLH1");
        let found = detection(&stated).unwrap();
        let expected = Detection {
            latitude: Some(41.5),
            identity: found.identity,
            ..Detection::default()
        };
        assert_eq!((found, found.identity.callsign()), (expected, Some("DLH1")));
        stated.ordinal = -2;
        assert_eq!(detection(&stated).unwrap_err().field, "scan");
        let wrong = KosekiTrackReport {
            state: 99,
            ..KosekiTrackReport::UNKNOWN
        };
        assert_eq!(report(&wrong).unwrap_err().field, "state");
    }
}
