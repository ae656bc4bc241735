//! Sources whose reports are copies of another one's, to the bit or with something done to them.

use super::*;

/// How the second source makes its reports from the first one's.
#[derive(Clone, Copy, Debug)]
enum Copied {
    Exactly,
    /// With noise of so many standard deviations, so many seconds later.
    Noisily(f64, f64),
    /// With positions in multiples of so many metres.
    Rounded(f64),
    /// With the present position under a later stamp.
    Late(f64),
    /// Not at all: it measures by itself.
    Never,
}

/// Standard deviation of the test's positions, metres: that of reports of [`report`].
const SIGMA_M: f64 = 10.0;

/// A normally distributed number from evenly distributed ones.
fn normal(random: &mut impl FnMut() -> f64) -> f64 {
    (0..12).map(|_| random()).sum()
}

impl Copied {
    fn report(self, original: &SensorTrack, random: &mut impl FnMut() -> f64) -> SensorTrack {
        let mut copy = SensorTrack { source: 1, ..*original };
        let later_s = match self {
            Self::Noisily(_, later_s) | Self::Late(later_s) => later_s,
            _ => 0.0,
        };
        copy.time_of_measurement_ns += (later_s * S as f64) as i64;
        for axis in 0..2 {
            let position = &mut copy.position_m[axis];
            match self {
                Self::Exactly | Self::Late(_) => {}
                Self::Noisily(sigmas, _) => {
                    *position += sigmas * SIGMA_M * normal(random) + later_s * original.velocity_mps[axis];
                }
                Self::Rounded(step_m) => *position = (*position / step_m).round() * step_m,
                Self::Never => {
                    let true_m = original.velocity_mps[axis] * original.time_of_measurement_ns as f64 / S as f64;
                    let start_m = if axis == 0 {
                        5e3 * f64::from(original.track_number)
                    } else {
                        0.0
                    };
                    *position = start_m + true_m + SIGMA_M * normal(random);
                }
            }
        }
        copy
    }
}

/// Three minutes of six targets that three sources see, the second of which repeats the first, and from 170 s on of a
/// false track that the first and so the second has: whether that is ever confirmed, and whether at the end a target
/// has contributions of both.
fn run(settings: Settings, copied: Copied) -> (bool, bool) {
    let mut noise = random(7);
    let mut harness = Harness::new(settings);
    let false_place = [50e3, 50e3];
    let mut is_believed = false;
    for step in 0..180 {
        let time_s = f64::from(step);
        for target in 0..6 {
            let mut place = || [0, 1].map(|axis| 5e3 * f64::from(target * (1 - axis)) + SIGMA_M * normal(&mut noise));
            let original = report(0, target as u32, time_s, place(), [50.0, 0.0]);
            let other = report(2, target as u32, time_s + 0.3, place(), [50.0, 0.0]);
            harness.take(&original);
            harness.take(&copied.report(&original, &mut noise));
            harness.take(&other);
        }
        if (170..175).contains(&step) {
            let original = report(0, 99, time_s, false_place, [50.0, 0.0]);
            for report in [original, SensorTrack { source: 1, ..original }] {
                let published = harness.take(&report);
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
    assert_eq!(
        harness.engine.sources().counts_with(1),
        if both { None } else { Some(0) },
        "{copied:?}"
    );
    assert_eq!(
        [0, 2, 3].map(|source| harness.engine.sources().counts_with(source)),
        [None; 3]
    );
    let learned = |source| harness.engine.sources().learned(source).unwrap().dependent;
    let named = [(0, 1), (1, 0)].map(|(source, other)| learned(source)[0].1 > 0.5 && learned(source)[0].0 == other);
    assert_eq!(named, [!both; 2], "{copied:?}: {:?}", learned(0));
    assert_eq!(learned(2), [(0, 0.0); 4]);
    assert_eq!(harness.engine.sources().learned(9), None);
    (is_believed, both)
}

#[test]
fn a_copy_confirms_nothing_and_contributes_nothing_whatever_was_done_to_it() {
    let mut settings = test_settings(3);
    settings.rule.name.0 = messages::FusionRule::Auto;
    let copies = [
        Copied::Exactly,
        Copied::Noisily(0.3, 0.2),
        Copied::Rounded(8.0),
        Copied::Late(0.1),
    ];
    for copied in copies {
        // The third source would have seen the target.
        assert_eq!(run(settings.clone(), copied), (false, false), "{copied:?}");
    }
    assert_eq!(run(settings.clone(), Copied::Never), (true, true));
    settings.sources[1].independent_of = vec![0.into()];
    for copied in copies {
        assert_eq!(run(settings.clone(), copied), (true, true), "{copied:?}");
    }
}
