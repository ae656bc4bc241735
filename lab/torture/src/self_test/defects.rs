//! Defects that are planted in a sound record, each with the findings of which at least one must follow.

use super::record::{FOREIGN, LENGTH, Place, Record, SECOND};
use crate::judge::event::{Life, State, What};
use crate::judge::finding::Finding;
use crate::judge::world::moved;

/// A defect.
pub(super) struct Defect {
    pub(super) name: &'static str,
    pub(super) findings: &'static [Finding],
    /// Inserts the defect into the record: for the first of [`Place::targets`], or more.
    pub(super) plant: fn(&mut Record, &Place),
}

const fn defect(name: &'static str, findings: &'static [Finding], plant: fn(&mut Record, &Place)) -> Defect {
    Defect { name, findings, plant }
}

/// Far off, metres.
const FAR_M: f64 = 20_000.0;

/// Every defect there is.
#[rustfmt::skip]
pub(super) const DEFECTS: [Defect; 43] = [
    defect("one target goes on under another number", &[Finding::Renumbered], |record, place| {
        record.change(place.target(), place.from_ns, |state| state.number = state.number.wrapping_add(FOREIGN));
    }),
    defect("all targets go on under other numbers", &[Finding::Renumbered], |record, place| {
        record.change_all(place.from_ns, |_, state| state.number = state.number.wrapping_add(FOREIGN));
    }),
    defect("a target is away for four seconds and comes back under another number", &[Finding::Renumbered], |record, place| {
        remove(record, place, place.target(), 4 * SECOND);
        record.change(place.target(), place.from_ns, |state| state.number = state.number.wrapping_add(FOREIGN));
    }),
    defect("a number is given to a second target", &[Finding::NumberGivenTwice], |record, place| {
        let number = record.latest(place.target(), place.from_ns).number;
        record.change(place.targets[1], place.from_ns, |state| state.number = number);
    }),
    defect("a number is given again after the end of its track", &[Finding::NumberGivenTwice], |record, place| {
        let lives = [Life::Confirmed, Life::Terminated, Life::Confirmed, Life::Terminated];
        let states = lives.into_iter().zip(1..).map(|(life, second)| stranger(record, place, second, life));
        record.add(states.collect());
    }),
    defect("a target has the number 0", &[Finding::NoNumber], |record, place| {
        record.change(place.target(), place.from_ns, |state| state.number = 0);
    }),
    defect("the addresses of two targets are exchanged", &[Finding::NumberGivenTwice, Finding::Position], |record, place| {
        let (one, other) = (place.target(), place.targets[1]);
        record.change_all(place.from_ns, |_, state| {
            state.address = state.address.map(|address| match address {
                address if address == one => other,
                address if address == other => one,
                address => address,
            });
        });
    }),
    defect("a target loses its address", &[Finding::Lacks], |record, place| {
        record.change(place.target(), place.from_ns, |state| state.address = None);
    }),
    defect("a target loses its height", &[Finding::Lacks], |record, place| {
        record.change(place.target(), place.from_ns, |state| state.has_height = false);
    }),
    defect("a target loses its velocity", &[Finding::Lacks], |record, place| {
        record.change(place.target(), place.from_ns, |state| state.velocity_mps = None);
    }),
    defect("one target is never shown", &[Finding::Missing], |record, place| {
        let gone = place.target();
        record.keep(|_, state| state.address != Some(gone));
    }),
    defect("half of all targets are never shown", &[Finding::Missing], |record, place| {
        let gone: Vec<u32> = place.targets.iter().copied().step_by(2).collect();
        record.keep(|_, state| state.address.is_none_or(|address| !gone.contains(&address)));
    }),
    defect("one target is away for twelve seconds", &[Finding::Missing], |record, place| {
        remove(record, place, place.target(), LENGTH);
    }),
    defect("all targets are away for eight seconds", &[Finding::Missing], |record, place| {
        let (from_ns, to_ns) = (place.from_ns, place.from_ns + 8 * SECOND);
        record.keep(|at_ns, _| !(from_ns..to_ns).contains(&at_ns));
    }),
    defect("no target is shown any more at the end", &[Finding::Missing], |record, _| {
        let end_ns = record.events.last().map_or(0, |event| event.at_ns);
        record.keep(|at_ns, _| at_ns < end_ns - LENGTH);
    }),
    defect("a target is only tentative", &[Finding::Missing], |record, place| {
        record.change(place.target(), place.from_ns, |state| state.life = Life::Tentative);
    }),
    defect("a target is suspended for good", &[Finding::EndedWithoutCause, Finding::Missing], |record, place| {
        record.change(place.target(), place.from_ns, |state| state.life = Life::Suspended);
    }),
    defect("a track ends while its target is reported", &[Finding::EndedWithoutCause], |record, place| {
        let mut end = record.latest(place.target(), place.from_ns);
        (end.life, end.of_report, end.sent_ns) = (Life::Terminated, false, place.from_ns);
        record.change(place.target(), place.from_ns, |state| state.number = state.number.wrapping_add(FOREIGN));
        record.add(vec![(place.from_ns, end)]);
    }),
    defect("a track ends in that of another target", &[Finding::Renumbered, Finding::Missing], |record, place| {
        let mut end = record.latest(place.target(), place.from_ns);
        end.merged_into = record.latest(place.targets[1], place.from_ns).number;
        (end.life, end.of_report, end.sent_ns) = (Life::Terminated, false, place.from_ns);
        remove(record, place, place.target(), i64::MAX / 2);
        record.add(vec![(place.from_ns, end)]);
    }),
    defect("a target has two tracks", &[Finding::Double], |record, place| {
        let copies = record.copies(place, place.target(), FOREIGN);
        record.add(copies);
    }),
    defect("a target has a second track without an address, 80 m beside", &[Finding::Double], |record, place| {
        let copies = record.copies(place, place.target(), FOREIGN).into_iter();
        let beside = copies.map(|(at_ns, mut state)| {
            state.address = None;
            shift(&mut state, 80.0);
            (at_ns, state)
        });
        record.add(beside.collect());
    }),
    defect("a track is where no target is", &[Finding::Ghost], |record, place| {
        let copies = record.copies(place, place.target(), FOREIGN).into_iter();
        let far = copies.map(|(at_ns, mut state)| {
            state.address = None;
            shift(&mut state, 10.0 * FAR_M);
            (at_ns, state)
        });
        record.add(far.collect());
    }),
    defect("a track has the address of no target", &[Finding::Ghost], |record, place| {
        let copies = record.copies(place, place.target(), FOREIGN).into_iter();
        let named = copies.map(|(at_ns, state)| (at_ns, State { address: Some(1), ..state }));
        record.add(named.collect());
    }),
    defect("a track is never terminated", &[Finding::NeverTerminated, Finding::Ghost], |record, place| {
        let states = (0..8).map(|second| stranger(record, place, second, Life::Confirmed));
        record.add(states.collect());
    }),
    defect("all positions are 250 m off", &[Finding::Position, Finding::Whole], |record, place| {
        record.change_all(place.from_ns, |_, state| shift(state, 250.0));
    }),
    defect("one target is shown 150 m off", &[Finding::Position], |record, place| {
        record.change(place.target(), place.from_ns, |state| shift(state, 150.0));
    }),
    defect("every second state is far off", &[Finding::Position], |record, place| {
        let mut count = 0;
        record.change_all(place.from_ns, |_, state| {
            count += 1;
            shift(state, f64::from(count % 2) * FAR_M);
        });
    }),
    defect("a state of a coasting track is far off", &[Finding::Position], |record, place| {
        let mut is_first = true;
        record.change(place.target(), place.from_ns, |state| {
            if std::mem::take(&mut is_first) {
                (state.life, state.of_report) = (Life::Coasted, false);
                shift(state, FAR_M);
            }
        });
    }),
    defect("two targets are shown at one place", &[Finding::Position], |record, place| {
        let other = record.latest(place.targets[1], place.from_ns);
        let mut position_m = other.position_m;
        let (one, other) = (place.target(), place.targets[1]);
        record.change_all(place.from_ns, |_, state| {
            if state.address == Some(other) {
                position_m = state.position_m;
            } else if state.address == Some(one) {
                state.position_m = position_m;
            }
        });
    }),
    defect("the position of one target stands still", &[Finding::Position], |record, place| {
        let position_m = record.latest(place.target(), place.from_ns).position_m;
        record.change(place.target(), place.from_ns, |state| state.position_m = position_m);
    }),
    defect("a value is not finite", &[Finding::NotFinite], |record, place| {
        let mut is_first = true;
        record.change(place.target(), place.from_ns, |state| {
            if std::mem::take(&mut is_first) {
                state.position_m = None;
            }
        });
    }),
    defect("one target is shown 500 m too high", &[Finding::Height], |record, place| {
        record.change(place.target(), place.from_ns, |state| {
            state.position_m = state.position_m.map(|[east_m, north_m, up_m]| [east_m, north_m, up_m + 500.0]);
        });
    }),
    defect("the velocity of one target is reversed", &[Finding::Velocity], |record, place| {
        record.change(place.target(), place.from_ns, |state| {
            state.velocity_mps = state.velocity_mps.map(|velocity| velocity.map(|speed_mps| -speed_mps));
        });
    }),
    defect("half of the states are missing", &[Finding::Rate, Finding::Missing], |record, _| {
        let mut count = 0;
        record.keep(|_, _| {
            count += 1;
            count % 2 == 0
        });
    }),
    defect("every state comes twice", &[Finding::Repeated, Finding::Rate], |record, place| {
        let again = record.states().filter(|(at_ns, _)| place.has(*at_ns));
        let again = again.map(|(at_ns, state)| (at_ns, state.clone())).collect();
        record.add(again);
    }),
    defect("all states are of four seconds before", &[Finding::Late, Finding::Missing], |record, place| {
        let mut before = std::collections::BTreeMap::new();
        record.change_all(place.from_ns - 5 * SECOND, |at_ns, state| {
            let own: &mut std::collections::VecDeque<State> = before.entry(state.number).or_default();
            own.push_back(state.clone());
            while own.len() > 1 && own[1].sent_ns < state.sent_ns - 4 * SECOND {
                own.pop_front();
            }
            if at_ns >= place.from_ns {
                let old = own[0].clone();
                (state.time_ns, state.position_m, state.velocity_mps) = (old.time_ns, old.position_m, old.velocity_mps);
            }
        });
    }),
    defect("states state times ahead", &[Finding::Times], |record, place| {
        record.change(place.target(), place.from_ns, |state| {
            let seconds = 3.0;
            state.time_ns += (seconds * 1e9) as i64;
            state.position_m = state.position_m.zip(state.velocity_mps).map(|(from_m, mps)| moved(from_m, mps, seconds));
        });
    }),
    defect("states were sent at the time 0", &[Finding::Times], |record, place| {
        record.change(place.target(), place.from_ns, |state| state.sent_ns = 0);
    }),
    defect("a state of an older epoch comes after one of a newer", &[Finding::OlderEpoch], |record, place| {
        let mut state = record.latest(place.target(), place.from_ns);
        (state.epoch, state.incarnation) = (state.epoch - 1, state.incarnation - 1);
        state.sent_ns = place.from_ns + 4 * SECOND;
        record.add(vec![(state.sent_ns, state)]);
    }),
    defect("a new epoch begins each second", &[Finding::Epoch], |record, place| {
        record.change_all(place.from_ns, |at_ns, state| {
            state.epoch += ((at_ns - place.from_ns) / SECOND) as u64;
        });
    }),
    defect("an epoch is far in the future", &[Finding::Epoch], |record, place| {
        record.change_all(place.from_ns, |_, state| state.epoch += 3_000_000_000 * SECOND as u64);
    }),
    defect("samples are lost without being counted", &[Finding::UncountedLoss], |record, place| {
        let last = record.states().last().map(|(_, state)| state.incarnation);
        record.change_all(place.from_ns, |_, state| {
            state.sequence += 7 * u64::from(Some(state.incarnation) == last);
        });
    }),
    defect("the deployment had to be started again, and left a file behind", &[Finding::LeftBehind], |record, _| {
        for event in &mut record.events {
            if let What::Stopped { left_behind } = &mut event.what {
                left_behind.push("torture.lock".to_owned());
            }
        }
    }),
];

/// Removes the states of a target for a time.
fn remove(record: &mut Record, place: &Place, address: u32, length_ns: i64) {
    let (from_ns, to_ns) = (place.from_ns, place.from_ns.saturating_add(length_ns));
    record.keep(|at_ns, state| state.address != Some(address) || !(from_ns..to_ns).contains(&at_ns));
}

/// Shifts a state to the east.
fn shift(state: &mut State, east_m: f64) {
    if let Some([x_m, ..]) = &mut state.position_m {
        *x_m += east_m;
    }
}

/// A state of an unrelated track without an address, so many seconds after the begin of a place.
fn stranger(record: &Record, place: &Place, second: i64, life: Life) -> (i64, State) {
    let sent_ns = place.from_ns + second * SECOND;
    let now = record.states().take_while(|(came_ns, _)| *came_ns <= sent_ns).last();
    let mut state = now.expect("a state before the place").1.clone();
    (state.number, state.address, state.life) = (FOREIGN, None, life);
    (state.sent_ns, state.of_report) = (sent_ns, life == Life::Confirmed);
    shift(&mut state, 10.0 * FAR_M);
    (sent_ns, state)
}
