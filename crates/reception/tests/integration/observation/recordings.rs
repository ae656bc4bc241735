//! Whole recordings of an airport's sensors and of an en-route radar, and single messages of other systems: known
//! totals and worked examples.

use std::collections::BTreeSet;

use asterix::categories::CAT021_V0_23;
use asterix::{Category, Decoder, DecoderCounts, Mode, NamedRecord, Record, Value};
use formats::observation::{Reading, read};
use observations::{Observation, Plane, ServiceMessage};

use crate::files::recording;

const BARCELONA: &str = "lebl2016/160510-lebl-220001";

/// A recording's records, and what they mean.
#[derive(Default)]
struct Recorded {
    targets: Vec<Observation>,
    services: Vec<ServiceMessage>,
    counts: DecoderCounts,
}

fn recorded_with(bytes: &[u8], tables: &[&'static Category], mut see: impl FnMut(&Record<'_>)) -> Recorded {
    let decoder = Decoder::new(Mode::Lenient);
    let mut decoder = tables.iter().fold(decoder, |decoder, table| decoder.with_table(table));
    let mut recorded = Recorded::default();
    for record in decoder.records(bytes) {
        let record = record.unwrap();
        see(&record);
        match read(&record) {
            Reading::Target(target) => recorded.targets.push(target),
            Reading::Service(service) => recorded.services.push(service),
            Reading::Other => panic!("{record:?}"),
        }
    }
    recorded.counts = *decoder.counts();
    recorded
}

fn recorded(bytes: &[u8]) -> Recorded {
    recorded_with(bytes, &[], |_| ())
}

impl Recorded {
    /// Messages that begin a turn or an update cycle, and others.
    fn turns_and_others(&self) -> (usize, usize) {
        let turns = self.services.iter().filter(|service| service.turn_begins).count();
        (turns, self.services.len() - turns)
    }

    /// The different addresses of field monitors, or of all others.
    fn addresses(&self, of_monitors: bool) -> BTreeSet<u32> {
        let targets = self.targets.iter().filter(|target| target.field_monitor == of_monitors);
        targets.filter_map(|target| target.identity.address()).collect()
    }

    fn monitors(&self) -> usize {
        self.targets.iter().filter(|target| target.field_monitor).count()
    }
}

fn counts(records: u64) -> DecoderCounts {
    DecoderCounts {
        blocks: records,
        records,
        ..DecoderCounts::default()
    }
}

#[test]
fn surface_movement_radar() {
    let Some(bytes) = recording(&format!("{BARCELONA}_SMR_cat10.ast")) else {
        return;
    };
    let radar = recorded(&bytes);
    assert_eq!(radar.counts, counts(77_345));
    assert_eq!((radar.targets.len(), radar.turns_and_others()), (62_819, (7263, 7263)));
    let tracks: BTreeSet<_> = radar.targets.iter().filter_map(|target| target.track_number).collect();
    assert_eq!(tracks.len(), 730);
    for target in &radar.targets {
        let ended = target.state == messages::TrackState::Terminated;
        assert_eq!(target.polar.is_none(), ended, "a last report has no position");
    }
}

#[test]
fn multilateration_as_category_010() {
    let Some(bytes) = recording(&format!("{BARCELONA}_MLAT_cat10.ast")) else {
        return;
    };
    let system = recorded(&bytes);
    assert_eq!(system.counts, counts(84_453));
    assert_eq!(
        (system.targets.len(), system.monitors(), system.services.len()),
        (69_933, 41_548, 14_520)
    );
    assert_eq!((system.addresses(false).len(), system.addresses(true).len()), (31, 6));
}

#[test]
fn multilateration_as_category_020() {
    let Some(bytes) = recording(&format!("{BARCELONA}_MLAT_cat20.ast")) else {
        return;
    };
    let mut states = 0;
    let system = recorded_with(&bytes, &[], |record| {
        let named = NamedRecord::new(record);
        if named.category == 19 && named.get(&["000"]) == Some(&Value::Unsigned(2)) {
            states += 1;
            check_system_state(&named);
        }
    });
    // 121 status messages go on in I019/553 where ed 1.3 ends: three octets for the six transponders of this system.
    let expected = DecoderCounts {
        records_extended: 121,
        unknown_extension_octets: 121,
        ..counts(77_314)
    };
    assert_eq!(system.counts, expected);
    assert_eq!(
        (system.targets.len(), system.monitors(), system.turns_and_others()),
        (69_933, 41_548, (7260, 121))
    );
    assert_eq!(states, 121);
    assert_eq!((system.addresses(false).len(), system.addresses(true).len()), (31, 6));
}

fn check_system_state(named: &NamedRecord) {
    let number = |path: &[&str]| named.get(path).and_then(Value::as_f64).unwrap();
    assert_eq!(number(&["550", "NOGO"]), 0.0, "in operation");
    assert!((number(&["600", "LAT"]) - 41.297_079).abs() < 1e-6);
    assert!((number(&["600", "LON"]) - 2.078_463).abs() < 1e-6);
    assert_eq!((number(&["610"]), number(&["620"])), (51.0, 0.0));
    let beyond = named.get(&["553", asterix::named::UNKNOWN_EXTENSION]);
    assert_eq!(beyond, Some(&Value::Bytes(vec![0xCC])));
}

#[test]
fn both_categories_of_the_multilateration_give_the_same_reports() {
    let (Some(cat10), Some(cat20)) = (
        recording(&format!("{BARCELONA}_MLAT_cat10.ast")),
        recording(&format!("{BARCELONA}_MLAT_cat20.ast")),
    ) else {
        return;
    };
    let (mut pairs, mut saturated) = (0, 0);
    for (ours, theirs) in recorded(&cat10).targets.iter().zip(&recorded(&cat20).targets) {
        assert_eq!(
            (ours.time_of_day_ns, ours.identity),
            (theirs.time_of_day_ns, theirs.identity)
        );
        assert_eq!(
            ours.velocity.unwrap(),
            theirs.velocity.unwrap(),
            "I010/202 has the LSB of I020/202"
        );
        let (at_10, at_20) = (ours.cartesian.unwrap(), theirs.cartesian.unwrap());
        // I010/042 has 16 bits of 1 m, I020/042 24 bits of 0.5 m: rounded, and beyond 32,767 m saturated.
        for axis in 0..2 {
            assert!((at_10[axis] - at_20[axis].clamp(-32_768.0, 32_767.0)).abs() <= 0.5);
        }
        saturated += usize::from(at_20[0] > 32_767.0);
        pairs += 1;
    }
    assert_eq!((pairs, saturated), (69_933, 13));
}

#[test]
fn ads_b() {
    let Some(bytes) = recording(&format!("{BARCELONA}_ADSB_cat21_v023.ast")) else {
        return;
    };
    let mut sent = 0;
    let station = recorded_with(&bytes, &[&CAT021_V0_23], |record| {
        sent += usize::from(record.item_named("170").is_some());
    });
    assert_eq!(station.counts, counts(49_330));
    let with_callsign = station
        .targets
        .iter()
        .filter(|target| target.identity.callsign().is_some())
        .count();
    assert_eq!(
        (station.addresses(false).len(), sent - with_callsign),
        (47, 5891),
        "the others hold no character"
    );
    assert!(
        station
            .targets
            .iter()
            .any(|target| target.identity.callsign() == Some("IBK3ZR"))
    );
}

#[test]
fn en_route_radar() {
    let Some(bytes) = recording("akapetanovic/Jahorina.raw") else {
        return;
    };
    let mut registers = 0;
    let radar = recorded_with(&bytes, &[], |record| {
        let named = NamedRecord::new(record);
        if let Some(Value::List(read)) = named.get(&["250"]) {
            registers += read.len();
        }
        if named.category == 34 {
            assert_eq!(named.get(&["041"]), Some(&Value::Quantity(5.007_812_5)));
        }
    });
    let expected = DecoderCounts {
        blocks: 642,
        ..counts(2119)
    };
    assert_eq!(radar.counts, expected);
    assert_eq!((radar.targets.len(), radar.turns_and_others()), (2099, (20, 0)));
    assert_eq!(radar.addresses(false).len(), 106);
    assert!(registers > 1000, "{registers}");
    for target in &radar.targets {
        assert_eq!(target.sac_sic, Some((23, 2)));
        let [range_m, _] = target.slant_polar.unwrap();
        assert!((5.0..200.0).contains(&(range_m / 1852.0)), "{range_m} m");
    }
    let times = radar.targets.iter().map(|target| target.time_of_day_ns);
    let times = times.chain(radar.services.iter().map(|service| service.time_of_day_ns));
    let times: BTreeSet<i64> = times.map(Option::unwrap).collect();
    assert_eq!(
        (times.first(), times.last()),
        (Some(&33_932_195_312_500), Some(&34_012_578_125_000))
    );
}

#[test]
fn single_messages_of_other_systems() {
    let Some(radar) = recording("cro/cat048.raw") else {
        return;
    };
    let [report] = recorded(&radar).targets[..] else {
        panic!("one report");
    };
    assert_eq!(
        (report.track_number, report.identity.address()),
        (Some(3563), Some(3_958_284))
    );
    assert!((report.slant_polar.unwrap()[0] - 197.683_593_75 * 1852.0).abs() < 1e-6);
    assert_eq!(report.plane, Plane::Slant);

    let Some(system) = recording("cro/cat062cat065.raw") else {
        return;
    };
    let system = recorded(&system);
    let numbers: Vec<_> = system.targets.iter().map(|track| track.track_number).collect();
    assert_eq!(numbers, [Some(4980), Some(7977)]);
    let identity = system.targets[1].identity;
    assert_eq!(
        (identity.address(), identity.callsign()),
        (Some(3_934_805), Some("SXD4723"))
    );
    assert_eq!(system.targets[0].vertical_rate_mps, Some(-443.75 * 0.3048 / 60.0));
    assert_eq!(system.services.len(), 1);

    let Some(ads_b) = recording("cro/cat21_re.ast") else {
        return;
    };
    let station = recorded(&ads_b);
    assert!(station.targets.iter().all(|target| target.on_ground));
    for (target, fraction_ns) in station.targets.iter().zip([919_600_000, 160_666_000]) {
        let found_ns = target.time_of_day_ns.unwrap() % 1_000_000_000;
        assert!((found_ns - fraction_ns).abs() < 1000, "{found_ns}");
    }
}
