//! Engines that go on from the image of another one.

use messages::FusionRule;
use messages::layout::Sample as _;

use super::*;
use crate::continuity::checkpoint::MemoryRefusal;
use crate::settings::RuleName;

const TARGETS: u32 = 12;
const SOURCES: u16 = 3;
const SCANS: u32 = 30;

/// Report of a target by a source: some of the targets have addresses, some turn, some are not seen in each scan, and
/// one ends; the sources have errors of their own.
fn traffic(scan: u32, source: u16, target: u32) -> Option<SensorTrack> {
    let is_missed = (scan + u32::from(source) + target).is_multiple_of(7) || (target == 3 && scan > SCANS / 2);
    let angle = f64::from(target) + 0.05 * f64::from(target % 3) * f64::from(scan);
    let time_s = f64::from(scan) + 0.3 * f64::from(source) + 0.01 * f64::from(target);
    let noise = 8.0 * f64::from((7919 * (scan + 3 * target + 5 * u32::from(source))) % 17) - 64.0;
    let place = [
        2000.0 * f64::from(target) + 90.0 * time_s * angle.cos() + noise,
        90.0 * time_s * angle.sin() - noise + 30.0 * f64::from(source),
    ];
    let number = 100 * u32::from(source) + target;
    let mut report = report(source, number, time_s, place, [90.0 * angle.cos(), 90.0 * angle.sin()]);
    if target.is_multiple_of(2) {
        let code = 0o1001 + (target % 0o5000) as u16;
        report.identity = Identity::default().with_address(0x40_0000 + target).with_mode_3a(code);
    }
    (!is_missed).then_some(report)
}

fn reports() -> Vec<SensorTrack> {
    let of_scan = |scan| (0..SOURCES).flat_map(move |source| (0..TARGETS).map(move |target| (scan, source, target)));
    (0..SCANS)
        .flat_map(of_scan)
        .filter_map(|(scan, source, target)| traffic(scan, source, target))
        .collect()
}

fn settings(rule: FusionRule) -> Settings {
    let mut settings = test_settings(usize::from(SOURCES));
    settings.rule.name = RuleName(rule);
    settings.registration.enabled = true;
    settings.association.scan_wait = 0.7;
    for source in &mut settings.sources {
        source.learns_period = true;
    }
    settings
}

#[test]
fn whoever_goes_on_from_an_image_gives_the_same_states_to_the_bit() {
    let reports = reports();
    for rule in FusionRule::ALL.into_iter().filter(|rule| *rule != FusionRule::Mosaic) {
        let mut engine = Harness::new(settings(rule));
        let mut others: Vec<(usize, Harness)> = Vec::new();
        for (place, report) in reports.iter().enumerate() {
            if place % 97 == 0 {
                let mut other = Harness::new(settings(rule));
                other.engine.resume_image(&engine.engine.image()).unwrap();
                assert_eq!(other.engine.image().len(), engine.engine.image().len());
                others.push((engine.published.len(), other));
            }
            engine.take(report);
            for (_, other) in &mut others {
                other.take(report);
            }
        }
        engine.advance(1e4);
        assert!(engine.published.len() > 500, "{rule:?}");
        for (before, other) in &mut others {
            other.advance(1e4);
            assert!(
                SystemTrack::octets(&other.published) == SystemTrack::octets(&engine.published[*before..]),
                "{rule:?}, after {before} states"
            );
        }
    }
}

#[test]
fn an_image_of_other_settings_or_a_part_of_one_is_refused() {
    let mut engine = Harness::new(settings(FusionRule::Auto));
    for report in reports().iter().take(200) {
        engine.take(report);
    }
    let image = engine.engine.image();
    let mut others = settings(FusionRule::Auto);
    others.sources.pop();
    let mut other = Harness::new(others);
    assert_eq!(other.engine.resume_image(&image), Err(MemoryRefusal::Foreign));
    let mut same = Harness::new(settings(FusionRule::Auto));
    assert_eq!(
        same.engine.resume_image(&image[..image.len() / 2]),
        Err(MemoryRefusal::Damaged(1))
    );
}
