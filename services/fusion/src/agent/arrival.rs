//! Order `arrival`: reports in the rounds of arrival.

use bus::{Look, Transport};
use fusion::ReportNumber;
use fusion::suspects::SuspectTreatment;
use runtime::Now;
use runtime::clock::mono_ns;

use super::{FusionAgent, REPORTS_PER_TURN};
use crate::inputs::{InputReport, SourceInput};
use crate::source_time::SourceTime;

/// Number of sources whose next slices are taken before a round. Taking a slice costs some hundred
/// nanoseconds, for which the first report of the round waits.
const SLICES_PER_ROUND: usize = 2;
/// Maximum number of states published together while a slice of several reports is processed.
const SENT_TOGETHER: usize = 16;

impl<S: Transport> FusionAgent<S> {
    /// Order `arrival`: processes reports on arrival, in rounds. A round takes a single report of each source with
    /// waiting reports; the source with the earliest sent slice comes first. A flood of a source therefore costs each
    /// other source the time of a single report, and the rest of the flood waits in the flooding source's queue.
    pub(super) fn work_on_arrival(&mut self, now: Now) -> anyhow::Result<bool> {
        let machine = now;
        let now = self.clocks.engine_time(machine);
        self.output.begin_turn(machine.mono_ns);
        if self.reached.is_none() && self.clocks.is_due(machine) {
            self.look_at_clocks(machine);
        }
        if machine.mono_ns >= self.full_look_ns {
            self.look_fully(machine.mono_ns)?;
        }
        let mut worked = 0;
        // Recordings wait for the smoothing thread.
        let waits = self.reached.is_some() && !self.output.can_smooth();
        let mut goes_on = !waits;
        while goes_on && worked < REPORTS_PER_TURN {
            // Later arrivals, and the rest of a flood of unusable slices, are left to the next turn.
            goes_on = !self.begin_round()? && !self.round.is_empty();
            worked += self.round.len();
            for place in 0..self.round.len() {
                goes_on |= self.work_off_one(self.round[place], now)?;
            }
        }
        self.output.begin_report(0);
        self.driver.advance(self.passed_ns(now), &mut self.output);
        self.output.send(self.progress_ns, false)?;
        if self.are_recordings_over() && !self.end_sent && self.output.has_room()? {
            self.driver.advance(i64::MAX, &mut self.output);
            self.output.send(i64::MAX, true)?;
            self.end_sent = true;
        }
        Ok(worked > 0)
    }

    /// Whether every source is a recording and has announced its end, and all its reports are processed.
    fn are_recordings_over(&self) -> bool {
        let is_over = |input: &SourceInput<S>| input.has_ended && !input.has_reports();
        self.reached.is_some() && !self.inputs.is_empty() && self.inputs.iter().all(is_over)
    }

    /// Order `arrival`: returns the time up to which time has passed; `now` contains the engine's time.
    fn passed_ns(&self, now: Now) -> i64 {
        if self.reached.is_none() {
            return now.utc_ns;
        }
        // In a replay: the progress of the slowest source with data.
        let running = self.inputs.iter().filter(|input| !input.has_ended);
        let reached = running.map(|input| match input.time {
            SourceTime::Unpaced => input.progress_ns,
            _ => input.time.paced_ns(now).unwrap_or(i64::MIN),
        });
        reached.min().unwrap_or(i64::MIN)
    }

    /// Lists the sources with waiting reports. Returns whether all sources were searched. On the way, the next slices
    /// of at most [`SLICES_PER_ROUND`] sources are taken, beginning with a source that has waited longest.
    fn begin_round(&mut self) -> anyhow::Result<bool> {
        self.round.clear();
        let (mut taken, mut index, sources) = (0, self.look_at, self.inputs.len());
        for _ in 0..sources {
            let input = &mut self.inputs[index];
            let this = index;
            index += 1;
            if index == sources {
                index = 0;
            }
            if !input.has_reports() {
                if !input.may_have_slices() || taken == SLICES_PER_ROUND {
                    continue;
                }
                input.reach(mono_ns, Look::Glance)?;
                taken += 1;
                self.look_at = index;
                if !input.has_reports() {
                    continue;
                }
            }
            self.round.push(this);
        }
        if self.round.len() > 1 {
            self.sort_round();
        }
        Ok(taken < SLICES_PER_ROUND)
    }

    #[inline(never)]
    fn sort_round(&mut self) {
        let inputs = &self.inputs;
        // By number for equal times of sending: the order must not depend on the start of the search.
        self.round
            .sort_unstable_by_key(|index| (inputs[*index].sent_ns(), *index));
    }

    /// Looks at all sources, whether or not a publisher has given a hint.
    #[cold]
    fn look_fully(&mut self, now_ns: i64) -> anyhow::Result<()> {
        self.full_look_ns = now_ns.saturating_add(self.full_look_every_ns);
        self.output.settle();
        for input in &mut self.inputs {
            input.reach(mono_ns, Look::Full)?;
        }
        Ok(())
    }

    /// Processes the next report of a source. Returns whether the source has a further report.
    fn work_off_one(&mut self, index: usize, now: Now) -> anyhow::Result<bool> {
        let input = &mut self.inputs[index];
        let source = input.source;
        let Some(InputReport { number, last }) = input.next_report(&mut self.report, now, self.common) else {
            return Ok(false);
        };
        self.progress_ns = self.progress_ns.max(input.progress_ns);
        let passed_ns = self.passed_ns(now);
        let keeping = self.keeping.as_ref();
        let verdict = keeping.map_or(SuspectTreatment::Sound, |keeping| keeping.begin_report(source, number));
        if verdict != SuspectTreatment::Quarantine {
            self.output.begin_report(self.report.stages.taken_ns);
            self.driver
                .report(&mut self.report, number, passed_ns, &mut self.output);
        }
        if verdict != SuspectTreatment::Sound {
            self.pass_suspect(number, verdict);
        }
        if last || self.output.waiting() >= SENT_TOGETHER {
            self.output.send(self.progress_ns, false)?;
        }
        // A source with further reports keeps the place in the rounds.
        Ok(!last || self.inputs[index].reach(mono_ns, Look::Glance)?)
    }

    /// Skips a report in which fusion has died. A report in quarantine has no effect except for a count, and is
    /// stored.
    #[cold]
    fn pass_suspect(&mut self, number: ReportNumber, verdict: SuspectTreatment) {
        let report = &mut self.report;
        if verdict == SuspectTreatment::Quarantine {
            self.driver.quarantine(report, number);
            // Further such reports are counted, and not stored.
            let _ = self.queues.quarantined.push(*report);
        }
        if let Some(keeping) = &mut self.keeping {
            keeping.clear(self.driver.engine_mut(), report.source, number);
        }
    }
}
