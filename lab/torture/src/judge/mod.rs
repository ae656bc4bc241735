//! The judge: a ledger of every target over the whole run, kept from events alone.
//!
//! The judge does no input or output and reads no clock: the same events give the same verdict, from a live
//! deployment or from a file. The judge trusts no process: addresses identify targets, and positions are compared
//! with the truth of the simulated world. Counters of the launcher and of subscribers excuse nothing.
//! - [`picture`]: the set of tracks at each second, and the errors, against the world and a run without faults;
//! - [`numbers`]: each target keeps a number until the track is terminated, and each track is terminated;
//! - [`times`]: epochs, and the times that states state;
//! - [`outages`]: how long each target is away at a fault;
//! - [`sequence_tally`]: whether every lost sample was announced.
//!
//! Times are times of sending by fusion, so that a delay of the judge itself is no outage. [`limits`] contains the
//! limits, [`allowances`] the inherent effects of a fault.

mod allowances;
pub(crate) mod event;
pub(crate) mod finding;
pub(crate) mod limits;
mod numbers;
mod outages;
mod picture;
mod sequence_tally;
mod times;
pub(crate) mod world;

use serde::Serialize;

use allowances::Allowances;
use event::{Conditions, Event, Life, Part, State, What};
use finding::{Finding, Findings, Found};
use limits::Spread;
use numbers::Numbers;
use outages::{Outages, Window};
use picture::Picture;
use sequence_tally::SequenceTally;
use times::Times;

/// Time between two checks for due events, nanoseconds.
const LOOK_NS: i64 = 250_000_000;
/// A time without any state that is found, seconds.
const SILENCE_S: f64 = 15.0;
/// A time without any state that breaks the picture, nanoseconds.
const BREAK_NS: i64 = 1_000_000_000;
/// A state that claims to be older than this was not sent then, nanoseconds.
const OLD_NS: i64 = 60_000_000_000;

/// See the module's documentation.
#[derive(Clone, Debug)]
pub(crate) struct Judge {
    conditions: Conditions,
    allowances: Allowances,
    picture: Picture,
    times: Times,
    findings: Findings,
    numbers: Numbers,
    outages: Outages,
    sequences: SequenceTally,
    joined_ns: i64,
    epoch: u64,
    epoch_began_ns: i64,
    epochs: usize,
    states: u64,
    lost: u64,
    rebuilds: u64,
    latest_ns: i64,
    looked_ns: i64,
    is_silent: bool,
    begun_ns: Option<i64>,
    faults: usize,
    /// Begin of the latest fault.
    fault_ns: i64,
}

/// Result of a run.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Verdict {
    pub(crate) findings: Vec<Found>,
    pub(crate) figures: Figures,
    targets: Vec<TargetLedger>,
}

/// Figures of a run.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Figures {
    #[serde(skip)]
    pub(crate) faults: usize,
    #[serde(skip)]
    pub(crate) seconds: f64,
    pub(crate) states: u64,
    pub(crate) epochs: usize,
    /// Lost samples, as counted by the subscribers.
    pub(crate) lost: u64,
    /// Times that the deployment replaced the shared memory.
    pub(crate) rebuilds: u64,
    pub(crate) targets: usize,
    /// Outages of targets at faults.
    pub(crate) outages: usize,
    pub(crate) outage_s: Option<Spread>,
    /// Outages of targets where the deployment started again.
    pub(crate) rebuild_outages: usize,
    pub(crate) rebuild_outage_s: Option<Spread>,
    /// Sums over all seconds.
    pub(crate) picture: picture::Counts,
    /// Errors of positions in the plane at all seconds, and errors of the run without faults.
    pub(crate) position_error_m: [Option<Spread>; 2],
    pub(crate) renumbered: u64,
    pub(crate) given_twice: u64,
    pub(crate) never_terminated: u64,
    /// Times that the deployment had to be started again by this command.
    pub(crate) helped: u64,
}

/// Ledger of a target.
#[derive(Clone, Debug, Serialize)]
struct TargetLedger {
    address: String,
    numbers: Vec<u32>,
    longest_absence_s: Option<f64>,
}

impl Verdict {
    /// All that was wrong, in a single line.
    pub(crate) fn wrong(&self) -> String {
        let text = |found: &Found| {
            let examples = found.examples.join("; ");
            format!("{} {} ({examples})", found.count, found.finding.text())
        };
        self.findings.iter().map(text).collect::<Vec<_>>().join("; ")
    }
}

impl Judge {
    pub(crate) fn new(conditions: Conditions) -> Self {
        Self {
            allowances: Allowances::default(),
            picture: Picture::new(conditions.begin_ns, conditions.period_s),
            times: Times::new(conditions.begin_ns, conditions.period_s),
            conditions,
            findings: Findings::default(),
            numbers: Numbers::default(),
            outages: Outages::default(),
            sequences: SequenceTally::default(),
            joined_ns: 0,
            epoch: 0,
            epoch_began_ns: 0,
            epochs: 0,
            states: 0,
            lost: 0,
            rebuilds: 0,
            latest_ns: 0,
            looked_ns: 0,
            is_silent: false,
            begun_ns: None,
            faults: 0,
            fault_ns: 0,
        }
    }

    /// The limits in words.
    pub(crate) fn limits(&self) -> String {
        limits::text(self.conditions.period_s)
    }

    /// Takes the next event.
    pub(crate) fn take(&mut self, event: &Event) {
        let at_ns = event.at_ns;
        self.begun_ns.get_or_insert(at_ns);
        match &event.what {
            What::Joined => {
                (self.sequences, self.joined_ns) = (SequenceTally::default(), at_ns);
                // Between two subscribers, events are unseen.
                self.numbers.lost(at_ns);
                self.times.join(at_ns);
                self.allowances.join(at_ns);
            }
            What::State(state) => self.take_state(at_ns, state),
            What::Second(second) => self.picture.know(second),
            What::Passed => {}
            What::Lost { .. } => self.numbers.lost(at_ns),
            What::Left {
                lost,
                lost_at_end,
                whole,
            } => {
                self.allowances.leave(at_ns);
                self.count_losses(*lost, *lost_at_end, *whole);
            }
            What::Rebuilt => {
                self.rebuilds += 1;
                self.outages.rebuilt();
            }
            What::FaultBegins { takes, .. } => self.begin_fault(at_ns, takes),
            What::FaultEnds => {
                self.outages.held(self.fault_ns, at_ns);
                self.allowances.end(at_ns);
            }
            What::Back => self.numbers_are_known(),
            What::NotBack { missing } => self.findings.add(Finding::NotBack, || missing.clone()),
            What::Helped => {
                let since_ns = self.fault_ns;
                self.findings.add(Finding::Helped, || {
                    format!("{:.1} s after the fault", (at_ns - since_ns) as f64 / 1e9)
                });
                // The consequences are the command's doing.
                self.begin_fault(at_ns, &[Part::Memory]);
                self.allowances.end(at_ns);
                self.outages.rebuilt();
            }
            What::Stopped { left_behind } => {
                self.finish(at_ns);
                for what in left_behind {
                    self.findings.add(Finding::LeftBehind, || what.clone());
                }
            }
        }
        if at_ns - self.looked_ns > LOOK_NS && !matches!(event.what, What::Stopped { .. }) {
            self.looked_ns = at_ns;
            self.outages.pass(at_ns);
            self.picture.pass(at_ns, &self.allowances, &mut self.findings);
            self.look_for_silence(at_ns);
            if at_ns - self.latest_ns < BREAK_NS {
                self.numbers
                    .pass(at_ns, self.conditions.terminate_s, &mut self.findings);
            }
        }
    }

    /// Where nothing was shown before, no target is missed; that no state comes at all is found all the same.
    fn look_for_silence(&mut self, at_ns: i64) {
        let since_ns = self.latest_ns.max(self.begun_ns.unwrap_or(at_ns));
        let is_silent = (at_ns - since_ns) as f64 / 1e9 > SILENCE_S;
        if is_silent && !self.is_silent {
            self.findings.add(Finding::NotBack, || {
                format!("no state at all for {SILENCE_S:.0} s and longer")
            });
        }
        self.is_silent = is_silent;
    }

    fn take_state(&mut self, at_ns: i64, state: &State) {
        let joined_ns = self.joined_ns as u64;
        if !self.sequences.take(state.incarnation, state.sequence, joined_ns) {
            self.findings.add(Finding::Repeated, || {
                format!("sample {} of {}", state.sequence, state.incarnation)
            });
        }
        if state.epoch < self.epoch {
            if state.sent_ns > self.epoch_began_ns {
                self.findings.add(Finding::OlderEpoch, || {
                    format!("{} of epoch {} after {}", state.number, state.epoch, self.epoch)
                });
            }
            return;
        }
        let sent_ns = if (at_ns - OLD_NS..=at_ns).contains(&state.sent_ns) {
            state.sent_ns
        } else {
            at_ns
        };
        if state.epoch > self.epoch {
            (self.epoch, self.epoch_began_ns) = (state.epoch, state.sent_ns);
            self.epochs += 1;
            let whole = state.incarnation >= self.joined_ns as u64;
            self.numbers.begin_epoch(sent_ns, whole);
            self.times.epoch(at_ns, state, &mut self.findings);
            if !state.continues {
                self.picture.begin_anew();
            }
        }
        self.states += 1;
        if sent_ns - self.latest_ns > BREAK_NS {
            self.numbers.resume(self.latest_ns, sent_ns);
        }
        self.latest_ns = self.latest_ns.max(sent_ns);
        let terminate_s = self.conditions.terminate_s;
        if let Some(ended) = self.numbers.take(sent_ns, state, terminate_s, &mut self.findings) {
            self.outages.ended(ended);
        }
        if state.position_m.is_none() {
            self.findings
                .add(Finding::NotFinite, || format!("a state of {}", state.number));
        }
        if matches!(state.life, Life::Confirmed | Life::Coasted) {
            self.times.take(at_ns, state, &self.allowances, &mut self.findings);
        }
        self.picture.take(state, &mut self.findings);
        if let (Some(address), Life::Confirmed | Life::Coasted) = (state.address, state.life) {
            self.outages.shown(address, sent_ns, state.life == Life::Coasted);
        }
    }

    fn begin_fault(&mut self, at_ns: i64, takes: &[Part]) {
        self.faults += 1;
        self.fault_ns = at_ns;
        self.numbers.settle(at_ns, &mut self.findings);
        self.numbers.are_excused = takes.contains(&Part::Numbers);
        self.times.fault(takes);
        self.allowances.begin(at_ns, takes);
        let window = match takes.contains(&Part::Memory) {
            true => Window::Rebuild,
            false => Window::Fault,
        };
        self.outages.begin(window, at_ns);
    }

    /// From now on every target must keep a single number again.
    fn numbers_are_known(&mut self) {
        if std::mem::take(&mut self.numbers.are_excused) {
            self.numbers.forget_carriers();
        }
    }

    /// A subscriber leaves: compares the subscriber's count of losses with the sequence numbers.
    fn count_losses(&mut self, lost: u64, lost_at_end: u64, whole: bool) {
        self.lost += lost;
        let (counted, missing) = (lost.saturating_sub(lost_at_end), self.sequences.lost());
        // Samples missing at the end of a publisher are only in the publisher's line; others are missing in both
        // counts.
        if whole && counted != missing && lost != missing {
            self.findings.add(Finding::UncountedLoss, || {
                format!("{counted} samples counted as lost, {missing} by their numbers")
            });
        }
    }

    /// The run is over.
    fn finish(&mut self, at_ns: i64) {
        self.numbers.settle(at_ns, &mut self.findings);
        self.outages.begin(Window::Quiet, at_ns);
        self.picture.pass(at_ns, &self.allowances, &mut self.findings);
    }

    /// Time at which the latest state was sent; monotonic, nanoseconds.
    pub(crate) fn latest_ns(&self) -> i64 {
        self.latest_ns
    }

    /// How many of everything were found wrong so far.
    pub(crate) fn findings(&self) -> &Findings {
        &self.findings
    }

    /// Result of the run so far.
    pub(crate) fn verdict(&self) -> Verdict {
        let [(outages, outage_s), (rebuild_outages, rebuild_outage_s)] = self.outages.spreads();
        let targets: Vec<TargetLedger> = self
            .numbers
            .addresses()
            .map(|address| TargetLedger {
                address: format!("{address:06X}"),
                numbers: self.numbers.of(address).to_vec(),
                longest_absence_s: self.outages.worst_s(address),
            })
            .collect();
        Verdict {
            findings: self.findings.list(),
            figures: Figures {
                faults: self.faults,
                seconds: (self.looked_ns - self.begun_ns.unwrap_or_default()) as f64 / 1e9,
                states: self.states,
                epochs: self.epochs,
                lost: self.lost,
                rebuilds: self.rebuilds,
                targets: targets.len(),
                outages,
                outage_s,
                rebuild_outages,
                rebuild_outage_s,
                picture: self.picture.counts,
                position_error_m: self.picture.spreads(),
                renumbered: self.findings.count(Finding::Renumbered),
                given_twice: self.findings.count(Finding::NumberGivenTwice),
                never_terminated: self.findings.count(Finding::NeverTerminated),
                helped: self.findings.count(Finding::Helped),
            },
            targets,
        }
    }
}
