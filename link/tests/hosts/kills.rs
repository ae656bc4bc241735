//! Links that are killed: the local picture goes on, and the other side hears again.
//!
//! A short form runs with all tests. The campaign kills as often as `KOSEKI_KILLS` says, at intervals, and prints what
//! it measured: `KOSEKI_KILLS=50 cargo test --release --manifest-path link/Cargo.toml kills -- --nocapture`.

use std::process::Command;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use koseki_client::messages::{Health, ProcessKind, SensorTrack, health, sensor_tracks};
use koseki_client::{Root, Subscription};

use crate::centres::{Centres, NAMES, TARGETS};
use crate::host::PATIENCE;

/// Time between two reports of a sensor.
const PERIOD: Duration = Duration::from_millis(50);
/// Pause between two looks.
const LOOK: Duration = Duration::from_millis(2);
/// Time between two kills of a campaign: either side's link has run for ten seconds then, and is started again at once.
const BETWEEN: Duration = Duration::from_millis(5_500);
/// Time within which both sides must hear each other again.
const BACK: Duration = Duration::from_secs(2);
/// Time for which a local picture may stand still.
const STILL: Duration = Duration::from_secs(1);

/// What is watched of a centre.
struct Watched {
    /// What comes from the other one.
    from_other: Subscription<SensorTrack>,
    health: Subscription<Health>,
    /// Process number of its link; 0: not heard yet.
    link: u32,
    /// Newest measurement of the other centre's that has come.
    newest_ns: i64,
    /// When its picture was told last, and the longest time that it was not.
    told: Instant,
    still: Duration,
}

impl Watched {
    fn of(centres: &Centres, number: usize) -> Self {
        let root = Root::in_base(centres.hosts[number].shared(), NAMES[number]).unwrap();
        Self {
            from_other: Subscription::at(&root, &sensor_tracks(NAMES[1 - number])).unwrap(),
            health: Subscription::at(&root, &health()).unwrap(),
            link: 0,
            newest_ns: i64::MIN,
            told: Instant::now(),
            still: Duration::ZERO,
        }
    }

    fn look(&mut self) {
        while let Some(slice) = self.from_other.next(Duration::ZERO).unwrap() {
            let newest_ns = slice.iter().map(|report| report.time_of_measurement_ns).max();
            self.newest_ns = self.newest_ns.max(newest_ns.unwrap_or(i64::MIN));
        }
        while let Some(slice) = self.health.next(Duration::ZERO).unwrap() {
            let mut links = slice.iter().filter(|said| said.kind() == Some(ProcessKind::Link));
            self.link = links.next().map_or(self.link, |said| said.process_id);
        }
    }
}

/// Reports and looks until `done`.
fn until(centres: &mut Centres, watched: &mut [Watched; 2], mut done: impl FnMut(&[Watched; 2]) -> bool) {
    let begun = Instant::now();
    let mut reported = begun - PERIOD;
    while !done(watched) {
        assert!(begun.elapsed() < PATIENCE, "{}", centres.status());
        if reported.elapsed() >= PERIOD {
            reported = Instant::now();
            centres.report(2);
        }
        for (reader, watched) in centres.readers.iter_mut().zip(&mut *watched) {
            watched.look();
            if reader.read() {
                watched.still = watched.still.max(watched.told.elapsed());
                watched.told = Instant::now();
            }
        }
        std::thread::sleep(LOOK);
    }
}

fn utc_ns() -> i64 {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_nanos() as i64
}

#[test]
fn kills_of_links_leave_the_local_picture_as_it_is_and_both_sides_hear_again() {
    let often = std::env::var("KOSEKI_KILLS").ok().and_then(|times| times.parse().ok());
    let Some(mut centres) = Centres::up() else { return };
    centres.report_until_seen(2);
    let numbers: [Vec<u32>; 2] = [0, 1].map(|number| centres.readers[number].numbers());
    let mut watched = [0, 1].map(|number| Watched::of(&centres, number));
    let mut back = Vec::new();
    for kill in 0..often.unwrap_or(2) {
        let begun = Instant::now();
        let pause = if often.is_some() { BETWEEN } else { PERIOD };
        until(&mut centres, &mut watched, |watched| {
            begun.elapsed() >= pause && watched.iter().all(|each| each.link != 0)
        });
        let pid = std::mem::take(&mut watched[kill % 2].link);
        assert!(
            Command::new("kill")
                .args(["-KILL", &pid.to_string()])
                .status()
                .unwrap()
                .success()
        );
        let (killed, killed_ns) = (Instant::now(), utc_ns());
        // What was measured after the kill comes by the next link.
        until(&mut centres, &mut watched, |watched| {
            watched.iter().all(|each| each.newest_ns > killed_ns)
        });
        back.push(killed.elapsed());
        until(&mut centres, &mut watched, |watched| {
            watched[kill % 2].link != 0 && watched[kill % 2].link != pid
        });
    }
    back.sort();
    let at = |share: f64| back[(share * (back.len() - 1) as f64) as usize].as_secs_f64();
    let still = watched.iter().map(|each| each.still).max().unwrap();
    println!(
        "{} links killed: both sides heard again after {:.2} s in the median, 90 %: {:.2} s, at most {:.2} s; no local \
         picture stood still for more than {:.3} s",
        back.len(),
        at(0.5),
        at(0.9),
        at(1.0),
        still.as_secs_f64()
    );
    for (reader, numbers) in centres.readers.iter().zip(numbers) {
        assert_eq!(numbers.len(), TARGETS as usize);
        assert_eq!(reader.numbers(), numbers, "no number has changed");
    }
    assert!(
        often.is_none() || (at(1.0) <= BACK.as_secs_f64() && still <= STILL),
        "{back:?} {still:?}"
    );
}
