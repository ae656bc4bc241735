//! Sources that are other centres.

use messages::{Contribution, contribution_bits};

use super::*;

/// Flags of each contribution, the first source's first, after one report a second of each source that speaks: the
/// second is another centre, and silent from 20 s on.
fn listed(until_s: u32) -> Vec<u16> {
    let mut settings = test_settings(2);
    settings.sources[1].is_centre = true;
    let mut harness = Harness::new(settings);
    let mut last = None;
    for second in 0..=until_s {
        let time_s = f64::from(second);
        if second < 20 {
            harness.take(&report(1, 7, time_s, [0.0; 2], [50.0, 0.0]));
        }
        last = harness.take(&report(0, 1, time_s + 0.5, [0.0; 2], [50.0, 0.0]));
    }
    let track = last.unwrap();
    let mut parts = track.listed().to_vec();
    parts.sort_by_key(|part| part.source);
    let is_fresh = |part: &&Contribution| part.flags & contribution_bits::FRESH != 0;
    assert_eq!(usize::from(track.source_count), parts.iter().filter(is_fresh).count());
    assert!(
        parts.iter().all(|part| part.weight == 0.0 || is_fresh(&part)),
        "{parts:?}"
    );
    parts
        .iter()
        .map(|part| part.flags & !contribution_bits::SCORED)
        .collect()
}

#[test]
fn contributions_of_other_centres_say_so_and_are_listed_for_a_while_when_they_are_silent() {
    let (fresh, centre) = (contribution_bits::FRESH, contribution_bits::CENTRE);
    assert_eq!(listed(15), [fresh, fresh | centre]);
    assert_eq!(listed(24), [fresh, centre]);
    assert_eq!(listed(90), [fresh]);
}
