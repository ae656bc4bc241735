//! Fused tracks as CAT062.
//!
//! | item | from | |
//! | --- | --- | --- |
//! | 010, 015 | the sender | service only if configured |
//! | 040 | `track_number` | shortened to 16 bits |
//! | 070 | `reference_time_ns` | |
//! | 080 | state, alerts, contributions, ground state | see below |
//! | 100, 105 | `position_m` | in the system's own plane, which touches the earth at its origin, and on the ellipsoid |
//! | 130, 135 | height, where a source observes it | both if their difference is known, else see [`HeightReference`] |
//! | 185 | `velocity_mps` | towards east and north at the target, as the document wants |
//! | 200, 210, 220 | motion models of fusion | see `motion.rs` |
//! | 060, 380 ADR and ID | `identity` | |
//! | 290 | contributions | ages of the last update by each kind of source |
//! | 136, 295, 340 | level and code of the transponder, their ages, the last report | see `measured.rs` |
//! | 245 | call sign | only if configured, see below |
//! | 500 | `covariance` | positions in the plane, height, velocity, rate of climb; not APW, the same in degrees |
//!
//! **I062/245** is sent on request only: from ed 1.16 on the document forbids it, because I062/380 has the call sign.
//! Older receivers know no other place. **I062/510** is for systems with shared tracks.
//!
//! # Track status
//!
//! CNF is sent with tentative tracks, TSB with the first message of a track and TSE with the last, CST while the
//! track is coasted. PSR, SSR, MDS, ADS and (from ed 1.20) MLAT are set if the system has such a source and no such
//! source supports the track now. SDS states whether co-operative sources support the track. SPI and EMS come from
//! the alerts; a transponder's alert for a changed code and a resolution advisory have no correct place in CAT062
//! (I062/380 COM and ACS need data unknown to tracks) and are not sent. SFC, from ed 1.18 on, marks a target on the
//! ground; earlier editions have no place for this state. ME and MI are military and remain 0.
//!
//! # Ages
//!
//! A system track lists the sources that support it now. For the ages of coasted tracks, the last time of each kind
//! of source is kept with the track's number. The track's own age, TRK, counts from the first state seen, because
//! states do not contain the time of initiation.

use deployment::Technology;
use frames::SystemFrame;
use frames::time::NS_PER_S;
use messages::{SystemTrack, TrackState, contribution_bits};

use super::identification;
use super::items;
use super::measured::{self, ReportingSensor};
use super::motion;
use super::place::{self, TargetPlace};
use super::quantity;
use super::technology::{KINDS, bit};
use super::track_numbers::TrackNumbers;
use super::{BlockOutbox, HeightReference, OutgoingCounts, OutgoingError, SendBlock, Unsent, check_category};
use asterix::categories::CAT062;
use asterix::field::{Elements, Field, added, elements, field, item, subitem, whole};
use asterix::{Category, Frn, RecordWriter};

const SOURCE: Elements<2> = elements(CAT062, "010", ["SAC", "SIC"]);
const SERVICE: Elements<1> = whole(CAT062, "015");
const TIME: Elements<1> = whole(CAT062, "070");
const GEODETIC_POSITION: Elements<2> = elements(CAT062, "105", ["LAT", "LON"]);
const CARTESIAN_POSITION: Elements<2> = elements(CAT062, "100", ["X", "Y"]);
const VELOCITY: Elements<2> = elements(CAT062, "185", ["VX", "VY"]);
const CODE: Field = field(CAT062, &["060", "MODE3A"]);
const MODE_3A: Frn = item(CAT062, "060");
const TRACK_NUMBER: Elements<1> = whole(CAT062, "040");
const GEOMETRIC_ALTITUDE: Elements<1> = whole(CAT062, "130");
/// Altitude not corrected by the local pressure.
const BAROMETRIC_ALTITUDE: Elements<1> = elements(CAT062, "135", ["CTB"]);
const QNH_ALTITUDE: Elements<2> = elements(CAT062, "135", ["QNH", "CTB"]);

const STATUS: Frn = item(CAT062, "080");
const MON: Field = field(CAT062, &["080", "MON"]);
const SPI: Field = field(CAT062, &["080", "SPI"]);
const MRH: Field = field(CAT062, &["080", "MRH"]);
const CNF: Field = field(CAT062, &["080", "CNF"]);
const SIM: Field = field(CAT062, &["080", "SIM"]);
const TSE: Field = field(CAT062, &["080", "TSE"]);
const TSB: Field = field(CAT062, &["080", "TSB"]);
const CST: Field = field(CAT062, &["080", "CST"]);
const PSR: Field = field(CAT062, &["080", "PSR"]);
const SSR: Field = field(CAT062, &["080", "SSR"]);
const MDS: Field = field(CAT062, &["080", "MDS"]);
const ADS: Field = field(CAT062, &["080", "ADS"]);
const SDS: Field = field(CAT062, &["080", "SDS"]);
const EMS: Field = field(CAT062, &["080", "EMS"]);
const SFC: Field = added(CAT062, &["080", "SFC"]);
const MLAT: Field = added(CAT062, &["080", "MLAT"]);

/// Ages of the last update by each kind of source, in the order of [`Technology`].
const AGES: Frn = item(CAT062, "290");
const AGES_BY_KIND: [(usize, Field); KINDS] = [age("PSR"), age("SSR"), age("MDS"), age("ES"), age("MLT")];

const ACCURACIES: Frn = item(CAT062, "500");
const APC: usize = subitem(CAT062, "500", "APC");
const SIGMA_X: Field = field(CAT062, &["500", "APC", "X"]);
const SIGMA_Y: Field = field(CAT062, &["500", "APC", "Y"]);
const COV: usize = subitem(CAT062, "500", "COV");
const ROOT_OF_COVARIANCE: Field = field(CAT062, &["500", "COV"]);
const AGA: usize = subitem(CAT062, "500", "AGA");
const SIGMA_HEIGHT: Field = field(CAT062, &["500", "AGA"]);
const ABA: usize = subitem(CAT062, "500", "ABA");
const SIGMA_LEVEL: Field = field(CAT062, &["500", "ABA"]);
const ATV: usize = subitem(CAT062, "500", "ATV");
const SIGMA_VX: Field = field(CAT062, &["500", "ATV", "X"]);
const SIGMA_VY: Field = field(CAT062, &["500", "ATV", "Y"]);
const ARC: usize = subitem(CAT062, "500", "ARC");
const SIGMA_CLIMB: Field = field(CAT062, &["500", "ARC"]);

const fn age(name: &str) -> (usize, Field) {
    (subitem(CAT062, "290", name), field(CAT062, &["290", name]))
}

/// Default number of tracks with a kept number, including terminated tracks.
const TRACKS_MAX: usize = 16_384;

/// Source of the system, as needed by the sender.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SystemSource {
    /// Number, as in [`Contribution::source`](messages::Contribution::source).
    pub number: u16,
    /// Technology of observation.
    pub technology: Technology,
    /// System area code and system identification code, if known.
    pub code: Option<[u8; 2]>,
}

/// Memory of a track between its states.
#[derive(Clone, Copy, Debug)]
struct SystemTrackMemory {
    /// Time of the last update by each kind of source, nanoseconds; `i64::MIN` for never.
    last_ns: [i64; KINDS],
    /// Kinds that supported it when last any source did.
    kinds: u8,
    /// True if one of the sources then was of no kind.
    other: bool,
    /// Number of sources then.
    sources: u16,
}

impl Default for SystemTrackMemory {
    fn default() -> Self {
        Self {
            last_ns: [i64::MIN; KINDS],
            kinds: 0,
            other: false,
            sources: 0,
        }
    }
}

/// Sends system tracks as CAT062.
#[derive(Debug)]
pub struct SystemReports {
    outbox: BlockOutbox,
    record: RecordWriter,
    numbers: TrackNumbers<SystemTrackMemory>,
    form: RecordForm,
    with_tentative: bool,
}

/// Settings that are the same for all records.
#[derive(Debug)]
struct RecordForm {
    source: [u8; 2],
    service: Option<u8>,
    frame: SystemFrame,
    /// Technologies by source number.
    technologies: Vec<Technology>,
    /// Codes (SAC, SIC) by source number.
    codes: Vec<Option<[u8; 2]>>,
    with_target_identification: bool,
    /// The kinds of sources the system has.
    kinds: u8,
    height: HeightReference,
    simulated: bool,
    /// True if I062/080 has a flag for a target on the ground.
    has_surface_flag: bool,
    /// True if I062/080 has a flag for multilateration without support of a track.
    has_multilateration_flag: bool,
}

/// Report of a track, with the values needed by its record.
struct SystemReport<'t> {
    track: &'t SystemTrack,
    place: TargetPlace,
    number: u16,
    is_first: bool,
    is_last: bool,
    support: SystemTrackMemory,
    /// Kinds of sources that support it now.
    fresh: u8,
}

impl SystemReports {
    /// A sender of CAT062 in the given edition, from a system with these codes (SAC, SIC), frame and sources, in blocks
    /// of at most `block_octets_max` bytes.
    ///
    /// # Errors
    /// If the table is not one of CAT062, or the block size is not between
    /// [`BLOCK_OCTETS_LEAST`](super::BLOCK_OCTETS_LEAST) and [`BLOCK_OCTETS_MOST`](super::BLOCK_OCTETS_MOST).
    pub fn new(
        table: &'static Category,
        sac: u8,
        sic: u8,
        system: SystemFrame,
        sources: &[SystemSource],
        block_octets_max: usize,
    ) -> Result<Self, OutgoingError> {
        check_category(table, CAT062, "CAT062")?;
        let numbered = sources.iter().map(|source| usize::from(source.number) + 1).max();
        let mut technologies = vec![Technology::Other; numbered.unwrap_or(0)];
        let mut codes = vec![None; technologies.len()];
        for source in sources {
            technologies[usize::from(source.number)] = source.technology;
            codes[usize::from(source.number)] = source.code;
        }
        Ok(Self {
            outbox: BlockOutbox::new(table.number, block_octets_max)?,
            record: RecordWriter::new(table),
            numbers: TrackNumbers::new(u16::MAX, TRACKS_MAX),
            form: RecordForm {
                source: [sac, sic],
                service: None,
                frame: system,
                kinds: sources.iter().fold(0, |kinds, source| kinds | bit(source.technology)),
                technologies,
                codes,
                with_target_identification: false,
                height: HeightReference::default(),
                simulated: false,
                has_surface_flag: table.edition >= SFC.since,
                has_multilateration_flag: table.edition >= MLAT.since,
            },
            with_tentative: false,
        })
    }

    /// For a system of up to `tracks` tracks at a time, beside which ended ones rest. No more have numbers than the
    /// category has.
    #[must_use]
    pub fn with_tracks(self, tracks: usize) -> Self {
        Self {
            numbers: TrackNumbers::new(u16::MAX, TRACKS_MAX.max(2 * tracks)),
            ..self
        }
    }

    /// Sends this service identification (I062/015).
    #[must_use]
    pub fn with_service(mut self, service: u8) -> Self {
        self.form.service = Some(service);
        self
    }

    /// Sends the call sign as target identification (I062/245), too.
    #[must_use]
    pub fn with_target_identification(mut self) -> Self {
        self.form.with_target_identification = true;
        self
    }

    /// Sends heights of this kind; without this call they are geometric.
    #[must_use]
    pub fn with_height(mut self, height: HeightReference) -> Self {
        self.form.height = height;
        self
    }

    /// Sends tentative tracks, too, marked as such.
    #[must_use]
    pub fn with_tentative(mut self) -> Self {
        self.with_tentative = true;
        self
    }

    /// Marks every track as simulated.
    #[must_use]
    pub fn marked_simulated(mut self) -> Self {
        self.form.simulated = true;
        self
    }

    /// Sends a state, with the block it completes.
    pub fn report(&mut self, track: &SystemTrack, send: &mut SendBlock<'_>) {
        if let Err(reason) = self.write(track) {
            self.outbox.count(reason);
            return;
        }
        self.outbox.push(self.record.finish(), send);
    }

    /// Hands over the block that is being filled.
    pub fn flush(&mut self, send: &mut SendBlock<'_>) {
        self.outbox.flush(send);
    }

    /// Returns the counts of sent and rejected records.
    pub fn counts(&self) -> OutgoingCounts {
        self.outbox.counts
    }

    fn write(&mut self, track: &SystemTrack) -> Result<(), Unsent> {
        let state = TrackState::from_code(track.state).ok_or(Unsent::Withheld)?;
        if state == TrackState::Tentative && !self.with_tentative {
            return Err(Unsent::Withheld);
        }
        let place = TargetPlace::new(&self.form.frame, track.position_m).ok_or(Unsent::Position)?;
        let is_last = TrackState::is_off(track.state);
        let entry = if is_last {
            let entry = self.numbers.end(track.track_number, track.reference_time_ns);
            *entry.ok_or(Unsent::Withheld)?
        } else {
            let entry = self.numbers.report(track.track_number, track.reference_time_ns);
            let entry = entry.ok_or(Unsent::Number)?;
            self.form.remember(&mut entry.memory, track);
            *entry
        };
        self.form.write(
            &SystemReport {
                track,
                place,
                number: entry.number,
                is_first: entry.is_first,
                is_last,
                support: entry.memory,
                fresh: self.form.fresh(track),
            },
            &mut self.record,
        );
        Ok(())
    }
}

impl RecordForm {
    fn technology(&self, source: u16) -> Technology {
        let known = self.technologies.get(usize::from(source));
        known.copied().unwrap_or(Technology::Other)
    }

    /// Returns the sensor of the report that caused the state, if its codes are known.
    fn reporting_sensor(&self, track: &SystemTrack) -> Option<ReportingSensor> {
        let code = self.codes.get(usize::from(track.trigger_source)).copied().flatten()?;
        Some(ReportingSensor {
            technology: self.technology(track.trigger_source),
            code,
            is_simulated: self.simulated,
        })
    }

    /// Stores the present support of a track.
    fn remember(&self, support: &mut SystemTrackMemory, track: &SystemTrack) {
        let contributions = track.contributions();
        if contributions.is_empty() {
            return;
        }
        (support.kinds, support.other, support.sources) = (0, false, track.source_count);
        for contribution in contributions {
            let technology = self.technology(contribution.source);
            support.kinds |= bit(technology);
            match support.last_ns.get_mut(technology as usize) {
                Some(last_ns) => *last_ns = contribution.time_of_measurement_ns.max(*last_ns),
                None => support.other = true,
            }
        }
    }

    /// Returns the kinds of sources with a latest report within the expected period.
    fn fresh(&self, track: &SystemTrack) -> u8 {
        let fresh = |flags: u16| flags & contribution_bits::FRESH != 0;
        let contributions = track.contributions().iter();
        contributions
            .filter(|contribution| fresh(contribution.flags))
            .fold(0, |kinds, contribution| {
                kinds | bit(self.technology(contribution.source))
            })
    }

    fn write(&self, report: &SystemReport<'_>, record: &mut RecordWriter) {
        let track = report.track;
        items::source(record, &SOURCE, self.source);
        items::number(record, &SERVICE, self.service.map(i64::from));
        items::time_of_day(record, &TIME, track.reference_time_ns);
        items::geodetic(record, &GEODETIC_POSITION, &report.place.geodetic);
        let [x, y, _] = track.position_m;
        items::quantities(record, &CARTESIAN_POSITION, [x, y]);
        let has_height = track.height_valid != 0;
        let [east, north] = report.place.horizontal(has_height);
        if track.velocity_valid != 0 {
            let velocity = [east, north].map(|axis| place::along(axis, track.velocity_mps));
            items::quantities(record, &VELOCITY, velocity);
        }
        motion::acceleration(track, [east, north], record);
        if let Some(code) = track.identity.mode_3a() {
            record.item(MODE_3A).put(CODE, code & 0o7777);
        }
        identification::write(&track.identity, self.with_target_identification, record);
        record.write(&TRACK_NUMBER, [i64::from(report.number)]);
        self.status(report, record);
        ages(report, record);
        motion::modes(&track.movement, record);
        measured::values(track, record);
        if has_height {
            self.vertical(report, record);
        }
        self.accuracies(report, record);
        if let Some(sensor) = self.reporting_sensor(track) {
            measured::last_report(track, sensor, record);
        }
    }

    /// Writes I062/080.
    fn status(&self, report: &SystemReport<'_>, record: &mut RecordWriter) {
        let track = report.track;
        let state = TrackState::from_code(track.state);
        let geometric = track.height_valid != 0 && self.height == HeightReference::Geometric;
        let stale = |technology: Technology| self.kinds & !report.fresh & bit(technology) != 0;
        record
            .item(STATUS)
            .put(MON, report.support.sources == 1)
            .put(SPI, items::special_identification(track.alerts))
            .put(MRH, geometric)
            .put(CNF, state == Some(TrackState::Tentative))
            .put(SIM, self.simulated)
            .put(TSE, report.is_last)
            .put(TSB, report.is_first)
            .put(CST, state == Some(TrackState::Coasted))
            .put(PSR, stale(Technology::Primary))
            .put(SSR, stale(Technology::Secondary))
            .put(MDS, stale(Technology::ModeS))
            .put(ADS, stale(Technology::AdsB))
            .put(SDS, report.support.data_source())
            .put(EMS, items::emergency(track.alerts))
            .put(SFC, track.on_ground != 0 && self.has_surface_flag)
            .put(
                MLAT,
                stale(Technology::Multilateration) && self.has_multilateration_flag,
            );
    }

    fn vertical(&self, report: &SystemReport<'_>, record: &mut RecordWriter) {
        let height_m = report.place.geodetic.height_m();
        let offset_m = report.track.pressure_offset();
        let geometric_m = offset_m.map(|offset_m| height_m - offset_m);
        match self.height {
            HeightReference::Geometric => {
                items::height(record, &GEOMETRIC_ALTITUDE, geometric_m.or(Some(height_m)));
            }
            HeightReference::Barometric => {
                items::height(record, &GEOMETRIC_ALTITUDE, geometric_m);
                match report.track.altitude() {
                    Some(altitude_m) => items::altitude(record, &QNH_ALTITUDE, altitude_m),
                    None => items::level(record, &BAROMETRIC_ALTITUDE, Some(height_m)),
                }
            }
        }
        motion::climb(report.track, report.place.up(), record);
    }

    /// Writes I062/500, where the greatest numbers mean "or more".
    fn accuracies(&self, report: &SystemReport<'_>, record: &mut RecordWriter) {
        let StandardDeviations {
            position,
            height,
            velocity,
            climb,
        } = StandardDeviations::new(report);
        if let Some([x, y, root]) = position {
            record
                .subitem(ACCURACIES, APC)
                .put(SIGMA_X, quantity::capped_deviation(SIGMA_X, x))
                .put(SIGMA_Y, quantity::capped_deviation(SIGMA_Y, y));
            let greatest_m = ROOT_OF_COVARIANCE.greatest() as f64 * ROOT_OF_COVARIANCE.lsb;
            let root = ROOT_OF_COVARIANCE.nearest(root.clamp(-greatest_m, greatest_m));
            record
                .subitem(ACCURACIES, COV)
                .put(ROOT_OF_COVARIANCE, root.unwrap_or(0));
        }
        let (position, field) = match self.height {
            HeightReference::Geometric => (AGA, SIGMA_HEIGHT),
            HeightReference::Barometric => (ABA, SIGMA_LEVEL),
        };
        if let Some(height) = height {
            record
                .subitem(ACCURACIES, position)
                .put(field, quantity::capped_deviation(field, height));
        }
        if let Some([x, y]) = velocity {
            record
                .subitem(ACCURACIES, ATV)
                .put(SIGMA_VX, quantity::capped_deviation(SIGMA_VX, x))
                .put(SIGMA_VY, quantity::capped_deviation(SIGMA_VY, y));
        }
        if let Some(climb) = climb {
            record
                .subitem(ACCURACIES, ARC)
                .put(SIGMA_CLIMB, quantity::capped_deviation(SIGMA_CLIMB, climb));
        }
    }
}

/// Standard deviations of a track, if its covariance is valid.
struct StandardDeviations {
    /// Deviations of x and y in the system's plane, and the signed root of their covariance, metres.
    position: Option<[f64; 3]>,
    /// Deviation of height, metres.
    height: Option<f64>,
    /// Deviations of velocity towards east and north at the target, metres per second.
    velocity: Option<[f64; 2]>,
    /// Deviation of the rate of climb, metres per second.
    climb: Option<f64>,
}

impl StandardDeviations {
    fn new(report: &SystemReport<'_>) -> Self {
        let covariance = &report.track.covariance;
        let has_height = report.track.height_valid != 0;
        let [east, north] = report.place.horizontal(has_height);
        let up = report.place.up();
        let of_position = |a, b| place::position_covariance(covariance, a, b);
        let of_velocity = |a, b| place::velocity_covariance(covariance, a, b);
        let both = |x: f64, y: f64| quantity::sigma(x).zip(quantity::sigma(y));
        let position = both(covariance.get(0, 0), covariance.get(1, 1));
        let xy = covariance.get(0, 1);
        Self {
            position: position
                .filter(|_| xy.is_finite())
                .map(|(x, y)| [x, y, xy.abs().sqrt().copysign(xy)]),
            height: quantity::sigma(of_position(up, up)).filter(|_| has_height),
            velocity: both(of_velocity(east, east), of_velocity(north, north))
                .filter(|_| report.track.velocity_valid != 0)
                .map(Into::into),
            climb: quantity::sigma(motion::climb_variance(report.track, of_velocity(up, up)))
                .filter(|_| has_height && motion::has_climb(report.track)),
        }
    }
}

impl SystemTrackMemory {
    /// SDS: 0 co-operative and primary, 1 co-operative, 2 primary, 3 not known.
    fn data_source(&self) -> u8 {
        let primary = self.kinds & bit(Technology::Primary) != 0;
        let co_operative = self.kinds & !bit(Technology::Primary) != 0;
        match (primary, co_operative, self.other) {
            (true, true, _) => 0,
            (false, true, false) => 1,
            (true, false, false) => 2,
            _ => 3,
        }
    }
}

/// Writes I062/290: how long ago each kind of source last updated the track.
fn ages(report: &SystemReport<'_>, record: &mut RecordWriter) {
    for (last_ns, (position, field)) in report.support.last_ns.iter().zip(AGES_BY_KIND) {
        if *last_ns != i64::MIN {
            let age_ns = report.track.reference_time_ns.saturating_sub(*last_ns);
            let lsb_ns = field.lsb * NS_PER_S as f64;
            let age = ((age_ns as f64 / lsb_ns).round().max(0.0) as i64).min(field.greatest());
            record.subitem(AGES, position).put(field, age);
        }
    }
}
