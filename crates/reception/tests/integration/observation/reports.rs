//! Records of any table with any content, all the way into sensor tracks: nothing panics, and what comes out can be
//! used.

use asterix::{Decoder, Mode, registry};
use formats::observation::{Reading, read};
use frames::{Geodetic, SensorFrame, SystemFrame};
use messages::{Covariance, SensorTrack};
use proptest::collection::vec;
use proptest::prelude::*;
use reception::{
    ConversionModel, Converter, CovarianceFrom, CovarianceModel, PlausibilityLimits, PoorQuality, PositionForm,
};

use super::block;
use crate::generator::Entropy;

/// A source that takes almost anything.
fn model(polar: bool, form: PositionForm) -> ConversionModel {
    let system = SystemFrame::at(Geodetic::from_degrees(46.0, 11.0, 0.0).unwrap());
    let place = Geodetic::from_degrees(45.0, 10.0, 500.0).unwrap();
    ConversionModel {
        is_on_board: false,
        number: 3,
        sac_sic: None,
        method: Default::default(),
        positions: form,
        frame: SensorFrame::new(&system, place, 0.1),
        system,
        height_m: place.height_m(),
        assumed_height_m: 5000.0,
        qnh_hpa: messages::STANDARD_PRESSURE_HPA,
        limits: PlausibilityLimits {
            range_m: 1e7,
            height_min_m: -1e4,
            height_max_m: 1e5,
            speed_mps: 1e4,
            jump_m: 1e6,
            time_step_s: Some(settings::Seconds::of_ns(1_000_000_000)),
            tracks: 10,
        },
        covariance: CovarianceModel {
            from: CovarianceFrom::Report,
            position_sigma_m: 10.0,
            velocity_sigma_mps: 1.0,
            unstated_position_sigma_m: None,
            unstated_velocity_sigma_mps: None,
            height_sigma_m: 30.0,
            range_sigma_m: polar.then_some(50.0),
            azimuth_sigma_deg: polar.then_some(settings::Degrees::of_rad(0.001)),
            doppler_sigma_mps: None,
            doppler_towards: false,
            poor_quality: PoorQuality::Use,
        },
    }
}

fn check(track: &SensorTrack) {
    let numbers = [track.position_m, track.velocity_mps, track.measured_m].concat();
    assert!(numbers.iter().all(|number| number.is_finite()), "{track:?}");
    for first in [0, 3] {
        assert!(is_positive(&track.covariance, first), "{track:?}");
    }
    assert!(
        track.covariance.get(2, 2) > 0.0 && track.covariance.get(5, 5) > 0.0,
        "{track:?}"
    );
}

/// Whether the two horizontal components from `first` on have a covariance that can be one.
fn is_positive(covariance: &Covariance, first: usize) -> bool {
    let get = |row: usize, column: usize| covariance.get(first + row, first + column);
    let (xx, xy, yy) = (get(0, 0), get(0, 1), get(1, 1));
    xx > 0.0 && yy > 0.0 && xx * yy > xy * xy && (xx * yy).is_finite()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]
    #[test]
    fn any_record_becomes_a_sound_track_or_a_counted_refusal(
        octets in vec(any::<u8>(), 1..300), polar in any::<bool>(), form in 0..3,
    ) {
        let form = [PositionForm::Any, PositionForm::Cartesian, PositionForm::Polar][form as usize];
        for table in registry::REGISTRY {
            let bytes = block(table.number, &Entropy::new(&octets).record(table).0);
            let mut converter = Converter::new(model(polar, form), 0);
            converter.service(Some(43_200_000_000_000));
            for record in Decoder::new(Mode::Lenient).with_table(table).records(&bytes) {
                let record = record.unwrap();
                let Reading::Target(mut observation) = read(&record) else { continue };
                // Left as they are, these would have most records refused before anything is converted.
                observation.time_of_day_ns = Some(43_200_000_000_000);
                observation.track_number = Some(1);
                observation.geodetic = observation.geodetic.map(|place| place.map(f64::sin));
                (observation.test, observation.field_monitor) = (false, false);
                for _ in 0..2 {
                    let before: u64 = converter.counters().values.iter().sum();
                    match converter.convert(&observation, 0) {
                        Some(track) => check(&track),
                        None => prop_assert!(converter.counters().values.iter().sum::<u64>() > before),
                    }
                }
            }
        }
    }
}
