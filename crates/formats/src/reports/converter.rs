//! An observation into a sensor track of the pipeline, checked.

use frames::time::DayUnroller;
use frames::{Geodetic, SensorFrame, SystemFrame, polar_covariance};
use messages::{COUNTERS_MAX, Counter, Covariance, SensorTrack, StageTimes, TrackState, sensor_track_bits as bits};
use rustc_hash::FxHashMap;

use super::observation::{Observation, Position, Quality};
use super::plausibility::{TimeCheck, TrackMemory};
use super::{CovarianceFrom, CovarianceModel, Limits, PoorQuality, PositionForm};

/// Ratio of the radius that holds 95 % of a circular normal distribution to its standard deviation per axis.
const RADIUS95_SIGMAS: f64 = 2.447_746_8;
/// Standard deviation given to a position of unknown accuracy, metres.
const UNKNOWN_POSITION_SIGMA_M: f64 = 500.0;
/// Standard deviation given to a velocity that is not known, metres per second.
const UNKNOWN_VELOCITY_SIGMA_MPS: f64 = 100.0;
/// Standard deviation given to a height that is not known, metres.
const UNKNOWN_HEIGHT_SIGMA_M: f64 = 5000.0;
/// A derived velocity is this much less accurate than a delivered one.
const DERIVED_VELOCITY_FACTOR: f64 = 2.0;
/// Tracks silent for this long are forgotten when room is needed, nanoseconds.
const FORGET_NS: i64 = 120_000_000_000;

/// What the converter must know of a source.
#[derive(Clone, Copy, Debug)]
pub struct SourceModel {
    /// Its number.
    pub number: u16,
    /// Only reports of this SAC/SIC are taken, where given.
    pub sac_sic: Option<(u8, u8)>,
    /// Which of several position items is used.
    pub positions: PositionForm,
    /// The frame it measures in.
    pub frame: SensorFrame,
    /// The system frame.
    pub system: SystemFrame,
    /// Height of the sensor above the ellipsoid, metres.
    pub height_m: f64,
    /// What its reports may contain.
    pub limits: Limits,
    /// How accurate they are.
    pub covariance: CovarianceModel,
}

/// What is known of a report beyond its position.
#[derive(Clone, Copy, Debug)]
struct Known {
    /// Its own horizontal covariance.
    own: Option<[f64; 3]>,
    height: bool,
    velocity: Option<Velocity>,
}

/// Where a velocity comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Velocity {
    Delivered,
    Derived,
}

/// Turns one source's observations into sensor tracks, and counts what it refuses.
#[derive(Debug)]
pub struct Converter {
    model: SourceModel,
    day: Option<DayUnroller>,
    first_day_ns: i64,
    /// Time of receipt of what is converted now, UTC, nanoseconds; `None` for recordings.
    received_ns: Option<i64>,
    time_check: TimeCheck,
    tracks: FxHashMap<u32, TrackMemory>,
    counters: [u64; COUNTERS_MAX],
}

impl Converter {
    /// A converter for a source whose first report is of the day that begins at `first_day_ns` (UTC, nanoseconds).
    pub fn new(model: SourceModel, first_day_ns: i64) -> Self {
        Self {
            model,
            day: None,
            first_day_ns,
            received_ns: None,
            time_check: TimeCheck::new(),
            tracks: FxHashMap::default(),
            counters: [0; COUNTERS_MAX],
        }
    }

    /// What follows was received at `received_ns` (UTC, nanoseconds). From now on that is what times of day are compared
    /// with: they are of the day that brings them nearest to it, and refused if they are farther from it than the limit
    /// on time steps. A recording has no such time; there the source's running time takes its place.
    pub fn received(&mut self, received_ns: i64) {
        self.received_ns = Some(received_ns);
    }

    /// What has been counted, indexed by [`Counter`].
    pub fn counters(&self) -> &[u64; COUNTERS_MAX] {
        &self.counters
    }

    /// The source's running time, UTC, nanoseconds; `None` before its first stamp.
    pub fn running_ns(&self) -> Option<i64> {
        self.day.as_ref().map(DayUnroller::running_ns)
    }

    /// A record that is no target report, with its time of day.
    pub fn service(&mut self, time_of_day_ns: Option<i64>) {
        self.count(Counter::ServiceMessages);
        if let Some(time_of_day_ns) = time_of_day_ns {
            let _ = self.utc(time_of_day_ns);
        }
    }

    /// The sensor track that `observation` reports; `None` if it was refused.
    pub fn convert(&mut self, observation: &Observation, ingested_ns: i64) -> Option<SensorTrack> {
        match self.try_convert(observation, ingested_ns) {
            Ok(track) => {
                self.count(if track.state == TrackState::Terminated as u8 {
                    Counter::TracksEnded
                } else {
                    Counter::Reports
                });
                Some(track)
            }
            Err(reason) => {
                self.count(reason);
                None
            }
        }
    }

    fn count(&mut self, counter: Counter) {
        self.counters[counter as usize] += 1;
    }

    fn try_convert(&mut self, observation: &Observation, ingested_ns: i64) -> Result<SensorTrack, Counter> {
        if self.model.sac_sic.is_some() && observation.sac_sic != self.model.sac_sic {
            return Err(Counter::RejectedSource);
        }
        let time_ns = self.utc(observation.time_of_day_ns.ok_or(Counter::RejectedTime)?)?;
        if observation.field_monitor {
            return Err(Counter::RejectedFieldMonitor);
        }
        if observation.test {
            return Err(Counter::RejectedTestTarget);
        }
        let number = observation.track_number.ok_or(Counter::RejectedNoTrackNumber)?;
        let height_m = self.height(observation);
        let position_m = match self.position(observation, height_m)? {
            Some(position) => position,
            None if observation.state == TrackState::Terminated => return self.end(number, time_ns, ingested_ns),
            None => return Err(Counter::RejectedNoPosition),
        };
        let delivered = observation.velocity.map(|velocity| self.model.frame.velocity(velocity));
        let speeds = 0.0..=self.model.limits.speed_mps;
        if delivered.is_some_and(|[vx, vy]| !speeds.contains(&vx.hypot(vy))) {
            return Err(Counter::RejectedSpeed);
        }
        let quality = self.quality(observation)?;
        self.make_room(number, time_ns)?;
        let memory = self.tracks.entry(number).or_default();
        if !memory.accepts(&self.model.limits, time_ns, [position_m[0], position_m[1]]) {
            return Err(Counter::RejectedJump);
        }
        memory.last_position_m = position_m;
        let derived = memory.positions.velocity().filter(|_| delivered.is_none());
        let known = Known {
            own: quality,
            height: height_m.is_some(),
            velocity: delivered
                .map(|_| Velocity::Delivered)
                .or(derived.map(|_| Velocity::Derived)),
        };
        let mut track = self.blank(number, time_ns, ingested_ns);
        track.identity = observation.identity;
        track.position_m = position_m;
        track.state = observation.state as u8;
        track.covariance = self.covariance(position_m, known);
        let mut set = |condition: bool, bit: u16| track.valid |= if condition { bit } else { 0 };
        set(known.height, bits::HEIGHT);
        set(known.velocity.is_some(), bits::VELOCITY);
        set(known.velocity == Some(Velocity::Derived), bits::DERIVED_VELOCITY);
        set(observation.vertical_rate_mps.is_some(), bits::VERTICAL_RATE);
        set(observation.on_ground, bits::ON_GROUND);
        set(
            self.model.covariance.from == CovarianceFrom::Report && quality.is_some(),
            bits::OWN_COVARIANCE,
        );
        let [vx, vy] = delivered.or(derived).unwrap_or_default();
        track.velocity_mps = [vx, vy, observation.vertical_rate_mps.unwrap_or_default()];
        Ok(track)
    }

    /// UTC of a time of day, checked against the source's running time.
    fn utc(&mut self, time_of_day_ns: i64) -> Result<i64, Counter> {
        if !(0..=frames::time::NS_PER_DAY).contains(&time_of_day_ns) {
            return Err(Counter::RejectedTime);
        }
        if let Some(received_ns) = self.received_ns {
            let utc_ns = DayUnroller::near(received_ns).utc_ns(time_of_day_ns);
            if (utc_ns - received_ns).abs() > self.model.limits.time_step_ns {
                return Err(Counter::RejectedTime);
            }
            self.day
                .get_or_insert_with(|| DayUnroller::near(utc_ns))
                .advance(utc_ns);
            return Ok(utc_ns);
        }
        let first_ns = self.first_day_ns + time_of_day_ns;
        let day = self.day.get_or_insert_with(|| DayUnroller::near(first_ns));
        let utc_ns = day.utc_ns(time_of_day_ns);
        self.time_check.check(&self.model.limits, day.running_ns(), utc_ns)?;
        day.advance(utc_ns);
        Ok(utc_ns)
    }

    /// The height, if it is known and possible.
    fn height(&mut self, observation: &Observation) -> Option<f64> {
        let height = observation.height_m?;
        let limits = &self.model.limits;
        if (limits.height_min_m..=limits.height_max_m).contains(&height) {
            return Some(height);
        }
        self.count(Counter::RejectedHeight);
        None
    }

    /// System position; `None` if the report has none in a form that may be used.
    fn position(&self, observation: &Observation, height_m: Option<f64>) -> Result<Option<[f64; 3]>, Counter> {
        let model = &self.model;
        let any = model.positions == PositionForm::Any;
        let cartesian = observation
            .cartesian
            .filter(|_| any || model.positions == PositionForm::Cartesian);
        let polar = observation
            .polar
            .filter(|_| any || model.positions == PositionForm::Polar);
        let geodetic = observation.geodetic.filter(|_| any);
        let found = cartesian
            .map(Position::Cartesian)
            .or(polar.map(Position::Polar))
            .or(geodetic.map(Position::Geodetic));
        let Some(found) = found else { return Ok(None) };
        let up_m = height_m.map_or(0.0, |height| height - model.height_m);
        let position_m = match found {
            Position::Cartesian([x, y]) => model.frame.cartesian([x, y, up_m]),
            Position::Polar([range, azimuth]) => model.frame.polar(range, azimuth, up_m),
            Position::Geodetic([latitude, longitude]) => {
                let height = height_m.unwrap_or(model.height_m);
                let place = Geodetic::from_degrees(latitude.to_degrees(), longitude.to_degrees(), height);
                model.system.to_local(place.map_err(|_| Counter::RejectedPosition)?)
            }
        };
        let [x0, y0] = model.frame.place();
        // Written so that NaN is refused.
        if (position_m[0] - x0).hypot(position_m[1] - y0) <= model.limits.range_m {
            Ok(Some(position_m))
        } else {
            Err(Counter::RejectedPosition)
        }
    }

    /// The report's own horizontal covariance, where it states one and the configuration wants it.
    fn quality(&self, observation: &Observation) -> Result<Option<[f64; 3]>, Counter> {
        let model = &self.model.covariance;
        if observation.quality == Quality::Unknown && model.poor_quality == PoorQuality::Reject {
            return Err(Counter::RejectedQuality);
        }
        let floor = model.position_sigma_m;
        let circular = |sigma: f64| Some([sigma.max(floor).powi(2), 0.0, sigma.max(floor).powi(2)]);
        Ok(match (model.from, observation.quality) {
            (CovarianceFrom::Configuration, _) | (_, Quality::Unstated) => None,
            (_, Quality::Covariance([xx, xy, yy])) => Some([xx.max(floor * floor), xy, yy.max(floor * floor)]),
            (_, Quality::Dilution(dilution)) => circular(dilution * floor),
            (_, Quality::Radius95(radius)) => circular(radius / RADIUS95_SIGMAS),
            (_, Quality::Unknown) => circular(UNKNOWN_POSITION_SIGMA_M),
        })
    }

    fn covariance(&self, position_m: [f64; 3], known: Known) -> Covariance {
        let model = &self.model.covariance;
        let velocity = match known.velocity {
            Some(Velocity::Delivered) => model.velocity_sigma_mps,
            Some(Velocity::Derived) => DERIVED_VELOCITY_FACTOR * model.velocity_sigma_mps,
            None => UNKNOWN_VELOCITY_SIGMA_MPS,
        };
        let height = if known.height {
            model.height_sigma_m
        } else {
            UNKNOWN_HEIGHT_SIGMA_M
        };
        let plane = model.position_sigma_m;
        let mut covariance = Covariance::diagonal([plane, plane, height], [velocity; 3]);
        let [x0, y0] = self.model.frame.place();
        let polar = model
            .polar
            .map(|sigma| polar_covariance([position_m[0] - x0, position_m[1] - y0], sigma));
        if let Some([xx, xy, yy]) = known.own.or(polar) {
            covariance.set(0, 0, xx);
            covariance.set(0, 1, xy);
            covariance.set(1, 1, yy);
        }
        covariance
    }

    /// Sees to it that the track `number` can be remembered.
    fn make_room(&mut self, number: u32, time_ns: i64) -> Result<(), Counter> {
        if self.tracks.len() < self.model.limits.tracks || self.tracks.contains_key(&number) {
            return Ok(());
        }
        let recent = |memory: &TrackMemory| {
            memory
                .positions
                .newest()
                .is_some_and(|(last_ns, _)| time_ns - last_ns < FORGET_NS)
        };
        self.tracks.retain(|_, memory| recent(memory));
        if self.tracks.len() < self.model.limits.tracks {
            Ok(())
        } else {
            Err(Counter::RefusedTracks)
        }
    }

    /// The source says that a track has ended, without saying where.
    fn end(&mut self, number: u32, time_ns: i64, ingested_ns: i64) -> Result<SensorTrack, Counter> {
        let memory = self.tracks.remove(&number).ok_or(Counter::RejectedNoPosition)?;
        let mut track = self.blank(number, time_ns, ingested_ns);
        track.position_m = memory.last_position_m;
        track.state = TrackState::Terminated as u8;
        track.covariance = Covariance::diagonal([UNKNOWN_POSITION_SIGMA_M; 3], [UNKNOWN_VELOCITY_SIGMA_MPS; 3]);
        Ok(track)
    }

    fn blank(&self, number: u32, time_ns: i64, ingested_ns: i64) -> SensorTrack {
        SensorTrack {
            time_of_measurement_ns: time_ns,
            stages: StageTimes {
                ingested_ns,
                ..StageTimes::default()
            },
            track_number: number,
            source: self.model.number,
            ..SensorTrack::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reports::observation::Quality;

    const S: i64 = 1_000_000_000;
    const DAY: i64 = 16_931 * 86_400 * S;

    fn converter() -> Converter {
        let place = Geodetic::from_degrees(41.297063, 2.078447, 0.0).unwrap();
        let system = SystemFrame::at(place);
        let model = SourceModel {
            number: 1,
            sac_sic: Some((0, 107)),
            positions: PositionForm::Any,
            frame: SensorFrame::new(&system, place, 0.0),
            system,
            height_m: 0.0,
            limits: Limits {
                range_m: 50e3,
                height_min_m: -500.0,
                height_max_m: 20e3,
                speed_mps: 350.0,
                jump_m: 100.0,
                time_step_ns: 60 * S,
                tracks: 2,
            },
            covariance: CovarianceModel {
                from: CovarianceFrom::Report,
                position_sigma_m: 5.0,
                velocity_sigma_mps: 2.0,
                height_sigma_m: 30.0,
                polar: None,
                poor_quality: PoorQuality::Use,
            },
        };
        Converter::new(model, DAY)
    }

    fn observation(time_s: f64) -> Observation {
        Observation {
            sac_sic: Some((0, 107)),
            time_of_day_ns: Some((time_s * S as f64) as i64),
            track_number: Some(7),
            cartesian: Some([1000.0, -500.0]),
            velocity: Some([30.0, 0.0]),
            height_m: Some(120.0),
            state: TrackState::Confirmed,
            ..Observation::default()
        }
    }

    fn refused(observation: Observation) -> Counter {
        let mut converter = converter();
        assert_eq!(converter.convert(&observation, 0), None);
        let counted: Vec<_> = Counter::ALL
            .iter()
            .filter(|counter| converter.counters()[**counter as usize] == 1)
            .collect();
        assert_eq!(counted.len(), 1, "one reason each");
        *counted[0]
    }

    #[test]
    fn a_sound_report_becomes_a_sensor_track() {
        let track = converter().convert(&observation(86_399.5), 42).unwrap();
        assert_eq!(track.time_of_measurement_ns, DAY + 86_399_500_000_000);
        assert!((track.position_m[0] - 1000.0).abs() < 1e-6 && (track.position_m[2] - 120.0).abs() < 1e-6);
        assert_eq!((track.track_number, track.source, track.stages.ingested_ns), (7, 1, 42));
        assert!(track.has(bits::HEIGHT | bits::VELOCITY));
        assert!(!track.has(bits::OWN_COVARIANCE));
        assert_eq!(track.covariance.get(0, 0), 25.0);
    }

    #[test]
    fn live_stamps_are_judged_by_the_time_of_receipt() {
        let mut converter = converter();
        let midnight = DAY + 5 * 86_400 * S;
        converter.received(midnight + S / 2);
        let before = converter.convert(&observation(86_399.5), 0).unwrap();
        assert_eq!(
            before.time_of_measurement_ns,
            midnight - S / 2,
            "late, of the day before"
        );
        let early = converter.convert(&observation(1.0), 0).unwrap();
        assert_eq!(early.time_of_measurement_ns, midnight + S, "its clock is ahead");
        let count = |converter: &Converter| converter.counters()[Counter::RejectedTime as usize];
        for (refused, time_s) in [(1, 61.0), (2, 62.0), (3, 43_000.0)] {
            assert_eq!(
                converter.convert(&observation(time_s), 0),
                None,
                "however often it insists"
            );
            assert_eq!(count(&converter), refused);
        }
        converter.received(midnight + 61 * S);
        assert!(converter.convert(&observation(61.0), 0).is_some());
    }

    #[test]
    fn what_cannot_be_is_refused_by_reason() {
        let good = observation(100.0);
        assert_eq!(
            refused(Observation {
                sac_sic: Some((0, 7)),
                ..good
            }),
            Counter::RejectedSource
        );
        assert_eq!(
            refused(Observation {
                time_of_day_ns: None,
                ..good
            }),
            Counter::RejectedTime
        );
        assert_eq!(
            refused(Observation {
                time_of_day_ns: Some(90_000 * S),
                ..good
            }),
            Counter::RejectedTime
        );
        assert_eq!(
            refused(Observation {
                field_monitor: true,
                ..good
            }),
            Counter::RejectedFieldMonitor
        );
        assert_eq!(refused(Observation { test: true, ..good }), Counter::RejectedTestTarget);
        assert_eq!(
            refused(Observation {
                track_number: None,
                ..good
            }),
            Counter::RejectedNoTrackNumber
        );
        assert_eq!(
            refused(Observation {
                cartesian: None,
                ..good
            }),
            Counter::RejectedNoPosition
        );
        assert_eq!(
            refused(Observation {
                cartesian: Some([60e3, 0.0]),
                ..good
            }),
            Counter::RejectedPosition
        );
        assert_eq!(
            refused(Observation {
                cartesian: Some([f64::NAN, 0.0]),
                ..good
            }),
            Counter::RejectedPosition
        );
        assert_eq!(
            refused(Observation {
                velocity: Some([400.0, 0.0]),
                ..good
            }),
            Counter::RejectedSpeed
        );
        let antarctic = Observation {
            cartesian: None,
            geodetic: Some([-71f64.to_radians(), 0.0]),
            ..good
        };
        assert_eq!(refused(antarctic), Counter::RejectedPosition);
    }

    #[test]
    fn an_impossible_height_costs_the_height_only() {
        let mut converter = converter();
        let track = converter
            .convert(
                &Observation {
                    height_m: Some(40e3),
                    ..observation(1.0)
                },
                0,
            )
            .unwrap();
        assert!(!track.has(bits::HEIGHT));
        assert!(track.covariance.get(2, 2) > 1e6);
        assert_eq!(converter.counters()[Counter::RejectedHeight as usize], 1);
    }

    #[test]
    fn a_missing_velocity_is_derived_once_it_can_be() {
        let mut converter = converter();
        let mut last = None;
        for second in 0..4 {
            let x = 1000.0 + 20.0 * f64::from(second);
            let report = Observation {
                velocity: None,
                cartesian: Some([x, 0.0]),
                ..observation(f64::from(second))
            };
            last = converter.convert(&report, 0);
            assert_eq!(last.unwrap().has(bits::DERIVED_VELOCITY), second > 0);
        }
        assert!((last.unwrap().velocity_mps[0] - 20.0).abs() < 1e-6);
    }

    #[test]
    fn own_quality_is_believed_down_to_the_floor() {
        let variance = |quality: Quality| {
            converter()
                .convert(
                    &Observation {
                        quality,
                        ..observation(1.0)
                    },
                    0,
                )
                .unwrap()
                .covariance
                .get(0, 0)
        };
        assert_eq!(variance(Quality::Covariance([400.0, 0.0, 100.0])), 400.0);
        assert_eq!(variance(Quality::Covariance([1.0, 0.0, 1.0])), 25.0);
        assert_eq!(variance(Quality::Dilution(3.0)), 225.0);
        assert!((variance(Quality::Radius95(92.6)).sqrt() - 37.83).abs() < 0.01);
        assert_eq!(variance(Quality::Unknown).sqrt(), UNKNOWN_POSITION_SIGMA_M);
    }

    #[test]
    fn polar_and_cartesian_forms_of_one_plot_are_the_same_place() {
        // A plot of the Barcelona surface radar carries both.
        let both = Observation {
            cartesian: Some([-673.0, -823.0]),
            polar: Some([1063.0, 219.309_082_031_25f64.to_radians()]),
            ..observation(1.0)
        };
        let place = |form: PositionForm| {
            let mut converter = converter();
            converter.model.positions = form;
            converter.convert(&both, 0).unwrap().position_m
        };
        let (cartesian, polar) = (place(PositionForm::Cartesian), place(PositionForm::Polar));
        assert_eq!(place(PositionForm::Any), cartesian);
        assert_ne!(polar, cartesian, "each form is really used");
        assert!((polar[0] - cartesian[0]).hypot(polar[1] - cartesian[1]) < 1.0);
        let mut converter = converter();
        converter.model.positions = PositionForm::Polar;
        assert_eq!(
            converter.convert(&Observation { polar: None, ..both }, 0),
            None,
            "the other form is not wanted"
        );
    }

    #[test]
    fn an_end_without_position_ends_where_the_track_was() {
        let mut converter = converter();
        converter.convert(&observation(1.0), 0).unwrap();
        let end = Observation {
            cartesian: None,
            state: TrackState::Terminated,
            ..observation(2.0)
        };
        let ended = converter.convert(&end, 0).unwrap();
        assert_eq!(ended.state, TrackState::Terminated as u8);
        assert!((ended.position_m[0] - 1000.0).abs() < 1e-6);
        assert_eq!(converter.convert(&end, 0), None, "a track that nobody knows");
    }

    #[test]
    fn a_full_table_refuses_new_tracks_and_forgets_old_ones() {
        let mut converter = converter();
        for number in 0..2 {
            assert!(
                converter
                    .convert(
                        &Observation {
                            track_number: Some(number),
                            ..observation(1.0)
                        },
                        0
                    )
                    .is_some()
            );
        }
        let third = |time| Observation {
            track_number: Some(9),
            ..observation(time)
        };
        assert_eq!(converter.convert(&third(2.0), 0), None);
        assert_eq!(converter.counters()[Counter::RefusedTracks as usize], 1);
        for second in 0..4 {
            converter.service(Some(second * 50 * S));
        }
        assert!(converter.convert(&third(160.0), 0).is_some());
    }
}
