//! Bearings of an antenna array from its blocks of snapshots: as accurate as the snapshots allow, and complete whatever
//! is lost, repeated or unfit on the way.

use locating::music::{
    AntennaArray, ArraySettings, Complex, ElementPosition, SimulatedArray, SimulatedWaves, stochastic_bound,
};
use messages::{Counter, Counters};
use observations::SnapshotBlock;
use settings::Degrees;
use sources::{ArrayMeasurement, SnapshotIntake};

const ANTENNAS: usize = 8;
const SNAPSHOTS: usize = 100;
/// Frequency of a wave one metre long.
const FREQUENCY_HZ: f64 = 299_792_458.0;

/// Eight antennas half a wavelength apart, which look forward.
fn settings(paths: usize) -> ArraySettings {
    let antenna = |place: usize| ElementPosition {
        right_m: 0.5 * place as f64,
        forward_m: 0.0,
    };
    ArraySettings {
        antennas: (0..ANTENNAS).map(antenna).collect(),
        frequency_max_hz: FREQUENCY_HZ,
        sector_deg: [-90.0, 90.0].map(Degrees::of),
        paths,
        ..ArraySettings::default()
    }
}

/// Blocks of one measurement, with so many snapshots in each.
fn blocks(samples: &[Complex<f64>], measurement: u32, at_once: usize) -> Vec<SnapshotBlock> {
    let parts = samples.chunks(at_once * ANTENNAS).enumerate();
    let block = |(place, part): (usize, &[Complex<f64>])| SnapshotBlock {
        time_ns: 1_000_000_000 * i64::from(measurement + 1),
        measurement,
        total: (samples.len() / ANTENNAS) as u32,
        first: (place * at_once) as u32,
        antennas: ANTENNAS as u16,
        frequency_hz: FREQUENCY_HZ,
        platform_m: Some([1.0, 2.0, 3.0]),
        heading_rad: Some(0.5),
        samples: part.iter().map(|sample| [sample.re as f32, sample.im as f32]).collect(),
    };
    parts.map(block).collect()
}

fn samples(bearings_rad: &[f64], correlation: f64, run: u64) -> Vec<Complex<f64>> {
    let mut samples = Vec::new();
    simulated(bearings_rad, correlation).run(run, &mut samples);
    samples
}

fn waves(bearings_rad: &[f64], correlation: f64) -> SimulatedWaves {
    SimulatedWaves {
        correlation,
        ..SimulatedWaves::independent(bearings_rad, 10.0, FREQUENCY_HZ, SNAPSHOTS)
    }
}

fn line() -> AntennaArray {
    AntennaArray::line(ANTENNAS, 0.5).unwrap()
}

fn simulated(bearings_rad: &[f64], correlation: f64) -> SimulatedArray {
    SimulatedArray::new(&line(), waves(bearings_rad, correlation), 7).unwrap()
}

fn taken(intake: &mut SnapshotIntake, blocks: &[SnapshotBlock]) -> Vec<ArrayMeasurement> {
    let mut all = Vec::new();
    for block in blocks {
        intake.take(block, 5, false, |measurement| all.push(measurement));
    }
    all
}

fn counted(intake: &SnapshotIntake) -> Counters {
    let mut counters = Counters::default();
    intake.count(&mut counters);
    counters
}

/// Of 500 runs, how many have as many bearings as waves, RMSE over the bound of those, and mean squared error over the
/// stated variance.
fn accuracy(bearings_deg: &[f64], correlation: f64, paths: usize) -> (usize, f64, f64) {
    let truth: Vec<f64> = bearings_deg.iter().map(|deg| deg.to_radians()).collect();
    let bound = stochastic_bound(&line(), &waves(&truth, correlation)).unwrap();
    let simulated = simulated(&truth, correlation);
    let mut intake = SnapshotIntake::new(&settings(paths)).unwrap();
    let (mut resolved, mut squares, mut normalised, mut samples) = (0, 0.0, 0.0, Vec::new());
    const RUNS: usize = 500;
    for run in 0..RUNS {
        simulated.run(run as u64, &mut samples);
        let measured = taken(&mut intake, &blocks(&samples, run as u32, 21));
        let mut found: Vec<_> = measured[0]
            .bearings
            .iter()
            .map(|found| (found.bearing_rad, found.sigma_rad))
            .collect();
        if found.len() != truth.len() {
            continue;
        }
        resolved += 1;
        let signed = |bearing_rad: f64| bearing_rad.sin().atan2(bearing_rad.cos());
        found.sort_by(|a, b| signed(a.0).total_cmp(&signed(b.0)));
        for ((bearing_rad, sigma_rad), (truth, bound)) in found.iter().zip(truth.iter().zip(&bound)) {
            let error = signed(bearing_rad - truth);
            squares += (error / bound).powi(2);
            normalised += (error / sigma_rad).powi(2);
        }
    }
    let count = (resolved * truth.len()) as f64;
    let (ratio, normalised) = ((squares / count).sqrt(), normalised / count);
    println!(
        "{bearings_deg:?} degrees, correlation {correlation}: {resolved} of {RUNS} resolved, RMSE / bound {ratio:.3}, \
         squared error / variance {normalised:.2}"
    );
    (resolved, ratio, normalised)
}

/// Eight antennas, 100 snapshots, 10 dB, up to 60 degrees off broadside: the figures of docs/bearing-measurement.md.
#[test]
fn one_wave_reaches_the_bound() {
    for off_deg in [-60.0, -40.0, -20.0, 0.0, 10.0, 30.0, 50.0, 60.0] {
        let (resolved, ratio, normalised) = accuracy(&[off_deg], 0.0, 1);
        assert!(resolved >= 498, "{resolved}");
        assert!(ratio < 1.1, "{ratio}");
        assert!((0.8..1.2).contains(&normalised), "{normalised}");
    }
}

/// One transmitter over two paths, at least a beam's width apart.
#[test]
fn a_coherent_pair_nearly_reaches_the_bound() {
    for pair in [
        [-6.4, 6.4],
        [10.0, 25.0],
        [-30.0, 20.0],
        [35.0, 58.0],
        [-60.0, -35.0],
        [-60.0, 60.0],
    ] {
        let (resolved, ratio, normalised) = accuracy(&pair, 1.0, 2);
        assert!(resolved >= 495, "{resolved}");
        assert!(ratio < 1.5, "{ratio}");
        assert!((0.7..1.5).contains(&normalised), "{normalised}");
    }
    let (resolved, ..) = accuracy(&[-6.4, 6.4], 1.0, 1);
    assert!(resolved < 5, "without paths, two waves were found in {resolved} runs");
}

/// Two waves do not explain three: the search goes on to the third.
#[test]
fn three_coherent_waves_are_found_as_three() {
    let (resolved, ratio, _) = accuracy(&[-40.0, 0.0, 35.0], 1.0, 3);
    assert!(resolved >= 490 && ratio < 1.5, "{resolved}, {ratio}");
}

/// Waves that are independent are found by MUSIC alone, with the same bearings whether or not paths are searched.
#[test]
fn paths_change_nothing_where_waves_are_resolved() {
    let of = |paths: usize| {
        let mut intake = SnapshotIntake::new(&settings(paths)).unwrap();
        let measured = taken(&mut intake, &blocks(&samples(&[-0.3, 0.4], 0.0, 3), 0, 100));
        measured[0].bearings.clone()
    };
    assert_eq!(of(1).len(), 2);
    assert_eq!(of(1), of(3));
}

#[test]
fn a_measurement_is_complete_with_its_last_snapshot_or_the_next_measurement() {
    let mut intake = SnapshotIntake::new(&settings(1)).unwrap();
    let [first, second, third] = [0, 1, 2].map(|run| blocks(&samples(&[0.2], 0.0, u64::from(run)), run, 21));
    let whole = taken(&mut SnapshotIntake::new(&settings(1)).unwrap(), &first);
    // Out of order within a measurement, a block comes too late.
    let order = [&first[0], &first[2], &first[1], &first[3]].map(SnapshotBlock::clone);
    assert!(taken(&mut intake, &order).is_empty());
    let ended = taken(&mut intake, &second[..1]);
    assert_eq!(ended.len(), 1, "a later measurement ends the present one");
    let (a, b) = (&ended[0].bearings[0], &whole[0].bearings[0]);
    assert!(
        (a.bearing_rad - b.bearing_rad).abs() < 0.02 && a.sigma_rad > 1.1 * b.sigma_rad,
        "{a:?} {b:?}"
    );
    assert_eq!((a.platform_m, a.heading_rad), ([1.0, 2.0, 3.0], Some(0.5)));
    // The last block alone ends the second one; whatever comes of it again, and all of the first, is too old.
    assert_eq!(taken(&mut intake, &second[4..]).len(), 1);
    assert!(taken(&mut intake, &[&second[..], &first[..]].concat()).is_empty());
    assert_eq!(taken(&mut intake, &third).len(), 1);
    let counters = counted(&intake);
    assert_eq!(counters[Counter::SnapshotsRepeated], 1 + 5 + 5);
    assert_eq!(counters[Counter::SnapshotsMissing], (100 - 63) + (100 - 21 - 16));
    assert_eq!(counters[Counter::Records], 4 + 1 + 1 + 10 + 5);
}

#[test]
fn what_does_not_fit_is_counted_by_reason() {
    let mut intake = SnapshotIntake::new(&settings(1)).unwrap();
    let sound = blocks(&samples(&[0.2], 0.0, 0), 0, 50);
    let mut other = sound[0].clone();
    (other.antennas, other.total) = (4, 200);
    let mut conflicting = sound[1].clone();
    conflicting.heading_rad = None;
    let mut silent = blocks(&samples(&[0.2], 0.0, 0), 1, 100);
    silent[0].samples.fill([0.0; 2]);
    let few = blocks(&samples(&[0.2], 0.0, 0)[..ANTENNAS * 3], 2, 3);
    let measured = taken(
        &mut intake,
        &[&[other], &sound[..1], &[conflicting], &sound[1..], &silent, &few].concat(),
    );
    let bearings: Vec<usize> = measured.iter().map(|measurement| measurement.bearings.len()).collect();
    assert_eq!(bearings, [1, 0, 0]);
    let counters = counted(&intake);
    for (counter, expected) in [
        (Counter::SnapshotsAntennas, 1),
        (Counter::SnapshotsValue, 1),
        (Counter::MeasurementsUnusable, 2),
        (Counter::BearingsOutsideSector, 1),
    ] {
        assert_eq!(counters[counter], expected, "{counter:?}");
    }
}

/// The spectrum shows the wave and its image behind the line, and nothing elsewhere; without a request there is none.
#[test]
fn a_spectrum_is_computed_on_request_only() {
    let measured = |with_spectrum: bool| {
        let mut intake = SnapshotIntake::new(&settings(1)).unwrap();
        let mut spectrum = None;
        for block in blocks(&samples(&[0.2], 0.0, 0), 0, 100) {
            intake.take(&block, 5, with_spectrum, |measurement| spectrum = measurement.spectrum);
        }
        spectrum
    };
    assert_eq!(measured(false), None);
    let spectrum = measured(true).unwrap();
    let degrees = |deg: f64| spectrum.spectrum_db[deg.rem_euclid(360.0) as usize];
    let bearing_deg = 0.2_f64.to_degrees();
    assert!(
        degrees(bearing_deg) > 25.0 && degrees(180.0 - bearing_deg) > 25.0,
        "{spectrum:?}"
    );
    for far in [-70.0, -30.0, 60.0, 240.0] {
        assert!((0.0..6.0).contains(&degrees(far)), "{far} {}", degrees(far));
    }
    assert_eq!(
        (spectrum.snapshots, spectrum.transmitters, spectrum.forward_rad),
        (100, 1, 0.5)
    );
    assert!(
        (0.9..1.1).contains(&spectrum.noise_variance),
        "{}",
        spectrum.noise_variance
    );
}
