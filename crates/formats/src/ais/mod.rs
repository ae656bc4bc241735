//! Lines of receivers of ships' automatic identification (AIS).
//!
//! Ships, rescue aircraft, base stations and aids to navigation send their positions on two VHF channels. Receivers
//! pass the messages on in sentences of NMEA 0183, a line each, with the bits of a message in six-bit characters:
//!
//! ```text
//! !AIVDM,1,1,,B,177KQJ5000G?tO`K>RA1wUbN0TKH,0*5C
//! ```
//!
//! The crate `aivdm` reads sentences and messages. Added here are times and stations around the sentences, messages in
//! several sentences of mixed streams, copies of other receivers, and the meaning: [`AisReader`] gives
//! [`Observation`]s of positions and [`Statement`]s of names, kinds, sizes and distress.
//!
//! | types | meaning | given as |
//! | --- | --- | --- |
//! | 1, 2, 3; 18; 27 | position of a ship: class A; class B; coarse, for satellites | observation, statement |
//! | 9 | position of a rescue aircraft | observation, statement |
//! | 19 | position and static data of a ship of class B | observation, statement |
//! | 5; 24 | static data: class A; class B | statement; name and call sign in later observations |
//! | 4; 21 | base station; aid to navigation | statement with the place; no target |
//! | 14 | text: announces tests of distress devices | counted |
//! | others | binary data, management of the channels | counted |
//!
//! Positions are those of the antenna. If static data state where the antenna is, and a heading or a course is known,
//! the observation has the position of the hull's centre instead. Otherwise the position may be half a ship away from
//! it.
//!
//! VDO sentences are reports of own ship, and are given apart. Distress devices (numbers 970, 972 and 974) state an
//! emergency if they are active; under test their observations are marked as tests.
//!
//! Positions that jump or do not change are left to reception, which has the same task for ADS-B. A wrong setting, such
//! as a foreign number or a wrong type of ship, looks like a right one.
//!
//! Sources: recommendation ITU-R M.1371-5; IEC 61162-1 and 61162-450 (sentences, tag blocks); E. S. Raymond,
//! "AIVDM/AIVDO protocol decoding", for what transponders do in fact.

mod accuracy;
mod assembler;
mod codes;
mod counters;
mod fixed;
mod line;
mod repeats;
mod report;
mod static_data;
mod writer;

use aivdm::AisMessage;
use aivdm::error::{AisError as MessageFault, MessageError};
use aivdm::message::SafetyRelatedBroadcast;
use observations::{Observation, Statement};

use assembler::{Assembler, PAYLOAD_MAX, Whole};
use line::AisLine;
use repeats::Repeats;
use report::Report;
use static_data::{StaticData, Stations};

pub use counters::{AisCounters, AisError, AisRejection};
pub use writer::{AisClass, AisPosition, AisStaticData};

/// Bits of messages of type 5 that some transponders cut. The destination ends there; nothing that is used is missing.
const SHORT_STATIC_BITS: std::ops::Range<usize> = 420..424;

/// How to read the lines of receivers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AisSettings {
    /// Most stations whose static data are remembered.
    pub stations_max: usize,
}

impl Default for AisSettings {
    /// More stations than a busy strait has.
    fn default() -> Self {
        Self { stations_max: 8192 }
    }
}

/// What a line gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AisOutput {
    /// The position of a target; its track number is the MMSI.
    Target(Observation),
    /// The position of the ship that carries the receiver.
    OwnShip(Observation),
    /// Statement of a target beside its motion, or of a fixed station.
    Statement(Statement),
}

/// Reader of the lines of one or several receivers.
#[derive(Debug)]
pub struct AisReader {
    assembler: Assembler,
    repeats: Repeats,
    stations: Stations,
    counters: AisCounters,
}

impl AisReader {
    /// Returns a reader with allocated tables.
    pub fn new(settings: AisSettings) -> Self {
        Self {
            assembler: Assembler::new(),
            repeats: Repeats::new(),
            stations: Stations::new(settings.stations_max),
            counters: AisCounters::default(),
        }
    }

    /// Counts so far.
    pub fn counters(&self) -> &AisCounters {
        &self.counters
    }

    /// Takes a line of the connection numbered `connection`, received at `received_utc_ns` (UTC, nanoseconds since
    /// 1970), and gives its content to `each`, with the time of receipt: the position first. A time in the line
    /// replaces the time of receipt.
    ///
    /// # Errors
    /// [`AisError`] if the line was refused. The refusal is already counted; a caller with published counters needs no
    /// further action.
    pub fn take<'a>(
        &mut self,
        connection: u32,
        line: &'a [u8],
        received_utc_ns: i64,
        each: impl FnMut(i64, AisOutput),
    ) -> Result<(), AisError<'a>> {
        self.take_line(connection, line, received_utc_ns, each)
            .map_err(|rejection| {
                self.counters.rejected[rejection as usize] += 1;
                AisError { rejection, line }
            })
    }

    /// The lines have ended, or their connections: messages that wait for parts are given up.
    pub fn end(&mut self) {
        self.counters.unfinished += self.assembler.end();
    }

    fn take_line(
        &mut self,
        connection: u32,
        line: &[u8],
        received_utc_ns: i64,
        mut each: impl FnMut(i64, AisOutput),
    ) -> Result<(), AisRejection> {
        let Some(line) = AisLine::parse(line)? else {
            self.counters.others += 1;
            return Ok(());
        };
        self.counters.wrong_tags += u64::from(line.has_wrong_tag);
        let now_ns = line.received_ns.unwrap_or(received_utc_ns);
        let unfinished = &mut self.counters.unfinished;
        let Some(whole) = self.assembler.take(connection, &line, now_ns, unfinished)? else {
            self.counters.parts += 1;
            return Ok(());
        };
        let message = message(&whole)?;
        if !codes::is_station(message.mmsi().raw()) {
            return Err(AisRejection::Mmsi);
        }
        let is_own_ship = line.sentence.is_own_ship;
        // The last part of a message need not repeat the time of the first.
        let stated_ns = line.received_ns.or(whole.received_ns);
        let now_ns = stated_ns.unwrap_or(received_utc_ns);
        if self.repeats.is_repeat(whole.payload(), is_own_ship, now_ns) {
            self.counters.repeats += 1;
            return Ok(());
        }
        self.counters.messages += 1;
        self.counters.timed += u64::from(stated_ns.is_some());
        self.counters.first_stated_ns = self.counters.first_stated_ns.or(stated_ns);
        self.counters.types[usize::from(message.message_type())] += 1;
        self.give(&message, is_own_ship, now_ns, |output| each(now_ns, output));
        Ok(())
    }

    fn give(&mut self, message: &AisMessage, is_own_ship: bool, now_ns: i64, mut each: impl FnMut(AisOutput)) {
        match message {
            AisMessage::BaseStationReport(of) if of.message_type == 4 => {
                self.give_fixed(fixed::base(of), &mut each);
            }
            AisMessage::AidToNavigationReport(of) => self.give_fixed(fixed::aid(of), &mut each),
            AisMessage::SafetyRelatedBroadcast(of) => self.take_text(of, now_ns),
            _ => {}
        }
        let data = StaticData::of(message);
        let has_room = data.is_none_or(|data| self.stations.take(&data, now_ns));
        self.counters.refused_stations += u64::from(!has_room);
        if let Some(report) = Report::of(message) {
            let sender = self.stations.sender(report.mmsi, now_ns);
            let observation = report.observation(&sender, now_ns);
            self.count_position(observation.is_some());
            let target = if is_own_ship {
                AisOutput::OwnShip
            } else {
                AisOutput::Target
            };
            observation
                .into_iter()
                .for_each(|observation| each(target(observation)));
            let statement = report.statement(&sender);
            statement
                .into_iter()
                .for_each(|statement| each(AisOutput::Statement(statement)));
        }
        let statement = data.and_then(|data| data.statement());
        statement
            .into_iter()
            .for_each(|statement| each(AisOutput::Statement(statement)));
    }

    fn give_fixed(&mut self, stated: Option<Statement>, each: impl FnMut(AisOutput)) {
        self.count_position(stated.is_some());
        stated.map(AisOutput::Statement).into_iter().for_each(each);
    }

    fn count_position(&mut self, is_known: bool) {
        self.counters.positions += u64::from(is_known);
        self.counters.without_position += u64::from(!is_known);
    }

    /// Devices for distress announce a test in a text like `SART TEST`, an emergency in one like `SART ACTIVE`.
    fn take_text(&mut self, text: &SafetyRelatedBroadcast, now_ns: i64) {
        let mmsi = text.mmsi.raw();
        if codes::is_distress_device(codes::category_of_number(mmsi)) {
            let has_room = self
                .stations
                .take_test(mmsi, text.text.as_str().contains("TEST"), now_ns);
            self.counters.refused_stations += u64::from(!has_room);
        }
    }
}

/// The message of a payload.
fn message(whole: &Whole) -> Result<AisMessage, AisRejection> {
    let payload = whole.payload();
    let bits = (6 * payload.len()).saturating_sub(usize::from(whole.fill_bits));
    let is_short = payload.first() == Some(&b'5') && SHORT_STATIC_BITS.contains(&bits);
    let decoded = match is_short {
        true => {
            let mut padded = [b'0'; PAYLOAD_MAX + 1];
            padded[..payload.len()].copy_from_slice(payload);
            aivdm::decode_payload(&padded[..=payload.len()], 0)
        }
        false => aivdm::decode_payload(payload, whole.fill_bits),
    };
    decoded.map_err(|fault| match fault {
        MessageFault::Message(MessageError::UnknownMessageType(_) | MessageError::InvalidEnumValue { .. }) => {
            AisRejection::Type
        }
        _ => AisRejection::Length,
    })
}
