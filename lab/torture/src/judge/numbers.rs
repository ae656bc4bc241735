//! Track numbers: the targets, and the ends of tracks.
//!
//! Addresses identify targets, independent of tracks. A target keeps a number until the track is terminated with cause:
//! after a time without a report, or by a merge into another track. A suspended track is not shown, but the target
//! keeps the number: the target must come back under this number. A second number beside the first is a *rival* until
//! the two are merged ([`super::picture`] limits the time).

use std::collections::BTreeMap;

use super::event::{Life, State};
use super::finding::{Finding, Findings};
use super::limits::FORGOTTEN_S;

/// Share of the time without a report after which a track may be terminated: reports are stamped at the origin.
const NEARLY: f64 = 0.9;
/// Share of the time with a track picture: an absent fusion process has received no reports at all.
const WITH_PICTURE: f64 = 0.25;
/// Time after which a number shown beside a silent number has replaced it, nanoseconds.
const SETTLED_NS: i64 = 3_000_000_000;
/// A track from which nothing came for so long is not shown, nanoseconds.
const SHOWN_NS: i64 = 5_000_000_000;

/// A fusion that starts sends the ends of tracks again that came so shortly before the start, nanoseconds.
const TOLD_AGAIN_NS: i64 = 10_000_000_000;

/// A track.
#[derive(Clone, Debug, Default)]
struct Track {
    /// First address and present address.
    address: Option<u32>,
    carrier: Option<u32>,
    last_ns: i64,
    last_report_ns: i64,
    is_shown: bool,
    has_ended: bool,
    /// The number rests: the track is shown no more, and not forgotten.
    is_suspended: bool,
    /// The end may have been lost in transit.
    may_have_ended: bool,
    is_given_twice: bool,
}

impl Track {
    /// Whether this track may still be the track of the target of this address.
    fn may_be_of(&self, address: u32) -> bool {
        !self.has_ended && self.carrier.is_none_or(|carrier| carrier == address)
    }

    /// Notes that the number is given twice, once.
    fn given_twice(&mut self, findings: &mut Findings, example: impl FnOnce() -> String) {
        if !std::mem::replace(&mut self.is_given_twice, true) {
            findings.add(Finding::NumberGivenTwice, example);
        }
    }
}

/// A target.
#[derive(Clone, Debug, Default)]
struct Carried {
    number: Option<u32>,
    /// Other numbers, and the time since which each has been shown.
    rivals: BTreeMap<u32, i64>,
    numbers: Vec<u32>,
}

/// Ledger of all tracks and of the numbers of all targets.
#[derive(Clone, Debug, Default)]
pub(crate) struct Numbers {
    tracks: BTreeMap<u32, Track>,
    targets: BTreeMap<u32, Carried>,
    /// The present fault has destroyed every source of the numbers for a fusion.
    pub(crate) are_excused: bool,
    /// Time of a loss in which there may have been the end of a track.
    loss_ns: Option<i64>,
    /// Begin of the newest epoch.
    epoch_ns: i64,
    /// Latest time without a picture, from and to.
    break_ns: (i64, i64),
}

impl Numbers {
    /// Takes a state sent at `at_ns`. Returns the address of a target with a track terminated with cause.
    pub(crate) fn take(&mut self, at_ns: i64, state: &State, terminate_s: f64, findings: &mut Findings) -> Option<u32> {
        let number = state.number;
        if number == 0 {
            findings.add(Finding::NoNumber, || format!("of {:06X?}", state.address));
        }
        let track = self.tracks.entry(number).or_insert_with(|| Track {
            last_report_ns: at_ns,
            ..Track::default()
        });
        let was_ended = track.has_ended;
        let was_suspended = std::mem::replace(&mut track.is_suspended, state.life == Life::Suspended);
        (track.last_ns, track.may_have_ended) = (at_ns.max(track.last_ns), false);
        if matches!(state.life, Life::Suspended | Life::Terminated) {
            track.has_ended |= state.life == Life::Terminated;
            if was_ended {
                return None;
            }
            let quiet_s = (at_ns - track.last_report_ns) as f64 / 1e9;
            let (gone_ns, resumed_ns) = self.break_ns;
            let without_s = (resumed_ns - gone_ns.max(track.last_report_ns)).max(0) as f64 / 1e9;
            let address = track.address?;
            let cause = Cause {
                merged_into: state.merged_into,
                quiet_s,
                is_enough: quiet_s >= NEARLY * terminate_s && quiet_s - without_s >= WITH_PICTURE * terminate_s,
            };
            if state.life == Life::Suspended {
                return self.suspend(address, number, &cause, findings).then_some(address);
            }
            let ends = self.end(address, number, &cause, findings);
            return (ends && !was_suspended).then_some(address);
        }
        if was_ended {
            track.has_ended = false;
            track.given_twice(findings, || format!("{number} after its end"));
        }
        if state.of_report {
            track.last_report_ns = at_ns;
        }
        if state.life == Life::Tentative {
            return None;
        }
        track.is_shown = true;
        let address = state.address?;
        let first = *track.address.get_or_insert(address);
        track.carrier = Some(address);
        if first != address {
            track.given_twice(findings, || format!("{number}, to {first:06X} and to {address:06X}"));
        }
        self.carry(address, number, at_ns, findings);
        None
    }

    fn carry(&mut self, address: u32, number: u32, at_ns: i64, findings: &mut Findings) {
        let target = self.targets.entry(address).or_default();
        if target.numbers.last() != Some(&number) && !target.rivals.contains_key(&number) {
            target.numbers.push(number);
        }
        match target.number {
            None => target.number = Some(number),
            Some(present) if present == number => {}
            Some(present) if self.tracks.get(&present).is_some_and(|track| !track.may_be_of(address)) => {
                target.number = Some(number);
                target.rivals.remove(&number);
                renumbered(findings, address, present, number);
            }
            Some(_) => {
                target.rivals.entry(number).or_insert(at_ns);
            }
        }
    }

    /// A track with an address ends; whether the target is no longer expected.
    fn end(&mut self, address: u32, number: u32, cause: &Cause, findings: &mut Findings) -> bool {
        let Some(target) = self.targets.get_mut(&address) else {
            return false;
        };
        target.rivals.remove(&number);
        if target.number != Some(number) {
            return false;
        }
        if cause.merged_into != 0 {
            target.rivals.remove(&cause.merged_into);
            target.number = Some(cause.merged_into);
            return false;
        }
        let heir = target.rivals.pop_first().map(|(heir, _)| heir);
        if cause.is_enough || self.are_excused {
            target.number = heir;
            return heir.is_none();
        }
        findings.add(Finding::EndedWithoutCause, || {
            format!(
                "{number} of {address:06X}, {:.1} s after its last report",
                cause.quiet_s
            )
        });
        if let Some(heir) = heir {
            target.number = Some(heir);
            renumbered(findings, address, number, heir);
        }
        false
    }

    /// A track with an address is suspended; whether the target is no longer expected.
    fn suspend(&mut self, address: u32, number: u32, cause: &Cause, findings: &mut Findings) -> bool {
        if self
            .targets
            .get(&address)
            .is_none_or(|target| target.number != Some(number))
        {
            return false;
        }
        if !cause.is_enough && !self.are_excused {
            findings.add(Finding::EndedWithoutCause, || {
                format!(
                    "{number} of {address:06X} suspended {:.1} s after its last report",
                    cause.quiet_s
                )
            });
        }
        cause.is_enough || self.are_excused
    }

    /// The track picture resumes after a break.
    pub(crate) fn resume(&mut self, gone_ns: i64, at_ns: i64) {
        self.break_ns = (gone_ns, at_ns);
    }

    /// Time passes: rivals that go on alone, and tracks that should have been terminated.
    pub(crate) fn pass(&mut self, now_ns: i64, terminate_s: f64, findings: &mut Findings) {
        if let Some(loss_ns) = self.loss_ns.take_if(|loss_ns| now_ns - *loss_ns > TOLD_AGAIN_NS) {
            self.excuse_ends_before(loss_ns);
        }
        let two_tracks_ns = SETTLED_NS;
        for (address, target) in &mut self.targets {
            let Some(present) = target.number else { continue };
            let own = |number: u32| self.tracks.get(&number).filter(|track| track.may_be_of(*address));
            let heard_ns = |number: u32| own(number).map_or(0, |track| track.last_ns);
            let old = |rival: &(&u32, &i64)| now_ns - *rival.1 > two_tracks_ns;
            let Some(rival) = target.rivals.iter().find(old).map(|(rival, _)| *rival) else {
                continue;
            };
            if now_ns - heard_ns(rival) > SHOWN_NS {
                continue;
            }
            if now_ns - heard_ns(present) > two_tracks_ns {
                target.rivals.remove(&rival);
                target.number = Some(rival);
                renumbered(findings, *address, present, rival);
            }
        }
        let (silent_ns, since_ns) = (((terminate_s + FORGOTTEN_S) * 1e9) as i64, self.break_ns.1);
        for (number, track) in &mut self.tracks {
            let is_live = track.is_shown && !track.has_ended && !track.is_suspended && !track.may_have_ended;
            if is_live && now_ns - track.last_ns.max(since_ns) > silent_ns {
                // Once is enough.
                track.may_have_ended = true;
                findings.add(Finding::NeverTerminated, || {
                    let silent_s = (now_ns - track.last_ns) as f64 / 1e9;
                    format!("{number}, silent for {silent_s:.1} s")
                });
            }
        }
    }

    /// Decides on every rival: the run ends, or another fault begins.
    pub(crate) fn settle(&mut self, now_ns: i64, findings: &mut Findings) {
        for (address, target) in &mut self.targets {
            let Some(present) = target.number else { continue };
            let last_ns = self.tracks.get(&present).map_or(i64::MIN, |track| track.last_ns);
            let heir = |(_, since_ns): &(&u32, &i64)| last_ns < **since_ns && now_ns - **since_ns > SETTLED_NS;
            if let Some(heir) = target.rivals.iter().find(heir).map(|(heir, _)| *heir) {
                target.rivals.remove(&heir);
                target.number = Some(heir);
                renumbered(findings, *address, present, heir);
            }
        }
    }

    /// Events were lost or unseen: perhaps the end of a track.
    pub(crate) fn lost(&mut self, at_ns: i64) {
        if at_ns - self.epoch_ns > TOLD_AGAIN_NS {
            self.loss_ns = Some(at_ns);
        }
    }

    /// A newer epoch of fusion begins; `whole` if all events of the epoch are received.
    pub(crate) fn begin_epoch(&mut self, at_ns: i64, whole: bool) {
        if whole {
            (self.loss_ns, self.epoch_ns) = (None, at_ns);
        } else {
            self.loss_ns = Some(at_ns);
        }
    }

    /// Tracks that have been silent since before this time may have ended.
    fn excuse_ends_before(&mut self, at_ns: i64) {
        let silent = self.tracks.values_mut().filter(|track| track.last_ns <= at_ns);
        silent.for_each(|track| track.may_have_ended = true);
    }

    /// Removes the assignment of numbers to targets after a fault that excuses changes. Used numbers remain known.
    pub(crate) fn forget_carriers(&mut self) {
        for target in self.targets.values_mut() {
            target.number = None;
            target.rivals.clear();
        }
        self.excuse_ends_before(i64::MAX);
    }

    /// Numbers that a target has had, in order.
    pub(crate) fn of(&self, address: u32) -> &[u32] {
        self.targets.get(&address).map_or(&[], |target| &target.numbers)
    }

    /// Addresses of all targets that were shown.
    pub(crate) fn addresses(&self) -> impl Iterator<Item = u32> + '_ {
        self.targets.keys().copied()
    }
}

/// Reason for the end of a track.
struct Cause {
    merged_into: u32,
    quiet_s: f64,
    is_enough: bool,
}

fn renumbered(findings: &mut Findings, address: u32, before: u32, now: u32) {
    findings.add(Finding::Renumbered, || format!("{address:06X} from {before} to {now}"));
}
