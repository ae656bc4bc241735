//! A source whose reports are copies of another one's.

use super::*;

/// Twenty seconds of six targets that three sources see, the second of which repeats the first, and from 10 s on of a
/// false track that the first and so the second has: whether that is ever confirmed, and whether at the end a target
/// has contributions of both.
fn run(settings: Settings) -> (bool, bool) {
    let mut noise = random(7);
    let mut harness = Harness::new(settings);
    let false_place = [50e3, 50e3];
    let mut is_believed = false;
    for step in 0..20 {
        let time_s = f64::from(step);
        for target in 0..6 {
            let mut place = || [5e3 * f64::from(target) + 6.0 * noise(), 6.0 * noise()];
            let original = report(0, target, time_s, place(), [50.0, 0.0]);
            let other = report(2, target, time_s + 0.3, place(), [50.0, 0.0]);
            harness.take(&original);
            harness.take(&SensorTrack { source: 1, ..original });
            harness.take(&other);
        }
        if (10..15).contains(&step) {
            for source in [0, 1] {
                let published = harness.take(&report(source, 99, time_s, false_place, [50.0, 0.0]));
                is_believed |= published.is_some_and(|track| track.state == TrackState::Confirmed as u8);
            }
        }
    }
    let last = harness
        .published
        .iter()
        .rev()
        .find(|track| track.contribution_count > 1);
    let both = last.is_some_and(|track| {
        let sources = sources_of(track);
        sources.contains(&0) && sources.contains(&1)
    });
    (is_believed, both)
}

#[test]
fn a_copy_confirms_nothing_and_contributes_nothing() {
    let mut settings = test_settings(3);
    settings.rule.name.0 = messages::FusionRule::Auto;
    // The third source would have seen the target.
    assert_eq!(run(settings.clone()), (false, false));
    settings.sources[1].independent_of = vec![0.into()];
    assert_eq!(run(settings), (true, true));
}
