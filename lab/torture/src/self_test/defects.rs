//! Defects that are planted in a sound record, each with the finding that it must lead to.

use super::record::{FOREIGN, Record, SECOND};
use crate::judge::event::{Event, Life, State, What};
use crate::judge::finding::Finding;

/// A defect.
pub(super) struct Defect {
    pub(super) name: &'static str,
    pub(super) finding: Finding,
    /// Inserts the defect into the record: for the first of `Place::targets`, or more.
    pub(super) plant: fn(&mut Record, &Place),
}

/// Place of a defect: a fault after which a newer fusion spoke.
pub(super) struct Place {
    pub(super) kill_ns: i64,
    /// Targets that were shown there.
    pub(super) targets: Vec<u32>,
    /// Begin of the longest time in which nothing excuses that the end of a track does not come.
    pub(super) unexcused_ns: i64,
}

impl Place {
    fn target(&self) -> u32 {
        self.targets[0]
    }
}

/// Every defect there is.
pub(super) const DEFECTS: [Defect; 22] = [
    Defect {
        name: "one target is renumbered at a kill",
        finding: Finding::Renumbered,
        plant: |record, place| renumber(record, place.target(), place.kill_ns),
    },
    Defect {
        name: "a target reported four seconds after the others is renumbered",
        finding: Finding::Renumbered,
        plant: |record, place| {
            record.remove(place.target(), place.kill_ns, place.kill_ns + 4 * SECOND);
            renumber(record, place.target(), place.kill_ns);
        },
    },
    Defect {
        name: "one target is renumbered after an absence longer than the checkpoint's greatest age",
        finding: Finding::Renumbered,
        plant: |record, place| {
            record.remove(place.target(), place.kill_ns, place.kill_ns + 12 * SECOND);
            renumber(record, place.target(), place.kill_ns);
        },
    },
    Defect {
        name: "a target comes back under another number than that which rests",
        finding: Finding::Renumbered,
        plant: |record, _| {
            let suspended = record.states().find(|(_, state)| state.life == Life::Suspended);
            let found = suspended.and_then(|(at_ns, state)| Some((state.address?, at_ns + 1)));
            if let Some((address, from_ns)) = found {
                renumber(record, address, from_ns);
            }
        },
    },
    Defect {
        name: "a number is given to a second target",
        finding: Finding::NumberGivenTwice,
        plant: |record, place| {
            let (one, other) = (place.target(), place.targets[1]);
            let number = latest(record, one, place.kill_ns).number;
            record.change(other, place.kill_ns, |state| state.number = number);
        },
    },
    Defect {
        name: "a number is given again after the end of its track",
        finding: Finding::NumberGivenTwice,
        plant: |record, place| {
            let at_ns = place.kill_ns + 2 * SECOND;
            stranger(record, place, at_ns, Life::Confirmed);
            stranger(record, place, at_ns + SECOND, Life::Terminated);
            stranger(record, place, at_ns + 3 * SECOND, Life::Confirmed);
            stranger(record, place, at_ns + 4 * SECOND, Life::Terminated);
        },
    },
    Defect {
        name: "a state of an older epoch comes after one of a newer",
        finding: Finding::OlderEpoch,
        plant: |record, place| {
            let mut state = latest(record, place.target(), place.kill_ns);
            let at_ns = place.kill_ns + 4 * SECOND;
            (state.sent_ns, state.sequence) = (at_ns, state.sequence + 1);
            record.insert(Event {
                at_ns,
                what: What::State(state),
            });
        },
    },
    Defect {
        name: "a target does not come back",
        finding: Finding::NotBack,
        plant: |record, place| record.remove(place.target(), place.kill_ns, i64::MAX),
    },
    Defect {
        name: "the outage of one target is above the limit of the worst",
        finding: Finding::OutageWorst,
        plant: |record, place| {
            let limit_ns = (record.conditions.limits.outage_s.worst * 1e9) as i64;
            let back_ns = place.kill_ns + limit_ns + 2 * SECOND;
            record.remove(place.target(), place.kill_ns, back_ns);
        },
    },
    Defect {
        name: "no target is shown for so long that every track ends",
        finding: Finding::OutageWorst,
        plant: |record, place| {
            let terminate_ns = (record.conditions.terminate_s * 1e9) as i64;
            for address in &place.targets {
                let mut end = latest(record, *address, place.kill_ns);
                let back_ns = place.kill_ns + terminate_ns + 10 * SECOND;
                (end.life, end.of_report, end.sent_ns) = (Life::Terminated, false, back_ns);
                record.remove(*address, place.kill_ns, back_ns);
                renumber(record, *address, place.kill_ns);
                record.insert(Event {
                    at_ns: back_ns - 1,
                    what: What::State(end),
                });
            }
        },
    },
    Defect {
        name: "one outage in twenty is between the limits of 99 % and of the worst",
        finding: Finding::Outage99,
        plant: |record, place| {
            let limits = record.conditions.limits.outage_s;
            let away_ns = ((limits.p99 + limits.worst) / 2.0 * 1e9) as i64;
            let each = (place.targets.len() / 20).max(1);
            let mut targets = place.targets.iter().cycle();
            for at_ns in record.faults() {
                for target in targets.by_ref().take(each) {
                    record.remove(*target, at_ns, at_ns + away_ns);
                }
            }
        },
    },
    Defect {
        name: "every outage is a little above the limit of the median",
        finding: Finding::OutageMedian,
        plant: |record, _| {
            let apart_ns = (record.conditions.limits.outage_s.median * 1e9) as i64 + SECOND / 2;
            let mut latest = std::collections::BTreeMap::new();
            record.events.retain(|event| {
                let What::State(State {
                    address: Some(address),
                    life: Life::Confirmed,
                    ..
                }) = event.what
                else {
                    return true;
                };
                let last_ns = latest.entry(address).or_insert(i64::MIN);
                let stays = event.at_ns.saturating_sub(*last_ns) > apart_ns;
                if stays {
                    *last_ns = event.at_ns;
                }
                stays
            });
        },
    },
    Defect {
        name: "half of the targets coast without detections",
        finding: Finding::Blind,
        plant: |record, place| {
            let gone: Vec<u32> = place.targets.iter().copied().step_by(2).collect();
            for address in gone {
                let mut coasting = latest(record, address, place.kill_ns);
                let at_ns = place.kill_ns - 1;
                (coasting.life, coasting.of_report, coasting.sent_ns) = (Life::Coasted, false, at_ns);
                record.remove(address, place.kill_ns, i64::MAX);
                record.insert(Event {
                    at_ns,
                    what: What::State(coasting),
                });
            }
        },
    },
    Defect {
        name: "a track is never terminated",
        finding: Finding::NeverTerminated,
        plant: |record, place| stranger(record, place, place.unexcused_ns + SECOND / 2, Life::Confirmed),
    },
    Defect {
        name: "a track ends while its target is reported",
        finding: Finding::EndedWithoutCause,
        plant: |record, place| {
            let mut end = latest(record, place.target(), place.kill_ns);
            (end.life, end.of_report, end.sent_ns) = (Life::Terminated, false, place.kill_ns - 1);
            renumber(record, place.target(), place.kill_ns);
            record.insert(Event {
                at_ns: place.kill_ns - 1,
                what: What::State(end),
            });
        },
    },
    Defect {
        name: "one target has two tracks for too long",
        finding: Finding::TwoTracks,
        plant: |record, place| {
            let second: Vec<Event> = record
                .events
                .iter()
                .filter_map(|event| match &event.what {
                    What::State(state) if state.address == Some(place.target()) && event.at_ns > place.kill_ns => {
                        let mut state = state.clone();
                        state.number = state.number.wrapping_add(FOREIGN);
                        let what = What::State(state);
                        Some(Event { what, ..*event })
                    }
                    _ => None,
                })
                .collect();
            second.into_iter().for_each(|event| record.insert(event));
        },
    },
    Defect {
        name: "one target is shown a kilometre off",
        finding: Finding::Position,
        plant: |record, place| {
            record.change(place.target(), place.kill_ns, |state| {
                if let Some([x, _]) = &mut state.position_m {
                    *x += 1000.0;
                }
            });
        },
    },
    Defect {
        name: "the position of one target stands still",
        finding: Finding::Frozen,
        plant: |record, place| {
            let position_m = latest(record, place.target(), place.kill_ns).position_m;
            record.change(place.target(), place.kill_ns, |state| state.position_m = position_m);
        },
    },
    Defect {
        name: "a state has a value that is not finite",
        finding: Finding::NotFinite,
        plant: |record, place| {
            let mut is_first = true;
            record.change(place.target(), place.kill_ns, |state| {
                if std::mem::take(&mut is_first) {
                    state.position_m = None;
                }
            });
        },
    },
    Defect {
        name: "samples are lost without being counted",
        finding: Finding::UncountedLoss,
        plant: |record, place| {
            for event in record
                .events
                .iter_mut()
                .filter(|event| event.at_ns > place.kill_ns + 3 * SECOND)
            {
                if let What::State(state) = &mut event.what {
                    state.sequence += 7;
                }
            }
        },
    },
    Defect {
        name: "the deployment had to be started again",
        finding: Finding::Helped,
        plant: |record, place| {
            record.insert(Event {
                at_ns: place.kill_ns + 2 * SECOND,
                what: What::Helped,
            });
        },
    },
    Defect {
        name: "a file is left behind",
        finding: Finding::LeftBehind,
        plant: |record, _| {
            for event in &mut record.events {
                if let What::Stopped { left_behind } = &mut event.what {
                    left_behind.push("torture.lock".to_owned());
                }
            }
        },
    },
];

/// Gives a target other numbers from a time on.
fn renumber(record: &mut Record, address: u32, from_ns: i64) {
    record.change(address, from_ns, |state| {
        state.number = state.number.wrapping_add(FOREIGN)
    });
}

/// Latest state of a target before a time.
fn latest(record: &Record, address: u32, before_ns: i64) -> State {
    let mut states = record.states().filter(|(at_ns, _)| *at_ns < before_ns);
    let found = std::iter::from_fn(|| states.next()).filter(|(_, state)| state.address == Some(address));
    let found = found.last().map(|(_, state)| state.clone());
    found.expect("places have only targets that were shown before")
}

/// Adds a state of an unrelated track without an address.
fn stranger(record: &mut Record, place: &Place, at_ns: i64, life: Life) {
    let mut state = latest(record, place.target(), place.kill_ns);
    let now = record.states().take_while(|(came_ns, _)| *came_ns <= at_ns).last();
    if let Some((_, now)) = now {
        (state.epoch, state.incarnation, state.sequence) = (now.epoch, now.incarnation, now.sequence);
    }
    (state.number, state.address, state.truth_m) = (FOREIGN, None, None);
    (state.life, state.sent_ns, state.of_report) = (life, at_ns, life == Life::Confirmed);
    record.insert(Event {
        at_ns,
        what: What::State(state),
    });
}
