//! Epochs of fusion, and the times that states state.

use super::allowances::Allowances;
use super::event::{Part, State};
use super::finding::{Finding, Findings};
use super::limits::{ARRIVAL_S, CLOCK_S, EPOCH_ALONE_S, EPOCHS};

/// See the module's documentation.
#[derive(Clone, Debug)]
pub(crate) struct Times {
    /// Begin of the world, monotonic and UTC, nanoseconds.
    begin_ns: [i64; 2],
    period_s: f64,
    /// Epochs that the faults so far may still lead to.
    permitted: u32,
    /// Time of the latest epoch without a fault.
    alone_ns: Option<i64>,
    joined_ns: i64,
}

impl Times {
    pub(crate) fn new(begin_ns: [i64; 2], period_s: f64) -> Self {
        Self {
            begin_ns,
            period_s,
            permitted: EPOCHS,
            alone_ns: None,
            joined_ns: i64::MIN,
        }
    }

    /// A subscriber joins: older states may come then.
    pub(crate) fn join(&mut self, at_ns: i64) {
        self.joined_ns = at_ns;
    }

    /// A fault takes these parts away.
    pub(crate) fn fault(&mut self, parts: &[Part]) {
        if parts.iter().any(|part| matches!(part, Part::Fusion | Part::Memory)) {
            self.permitted = EPOCHS;
        }
    }

    /// A newer epoch begins.
    pub(crate) fn epoch(&mut self, at_ns: i64, state: &State, findings: &mut Findings) {
        let latest_ns = self.utc_ns(at_ns) + (CLOCK_S * 1e9) as i64;
        let is_time = |epoch: i64| (self.begin_ns[1]..=latest_ns).contains(&epoch);
        if !i64::try_from(state.epoch).is_ok_and(is_time) {
            findings.add(Finding::Epoch, || format!("{} is no time of this run", state.epoch));
        }
        if self.permitted > 0 {
            self.permitted -= 1;
            return;
        }
        // A loaded machine may let a fusion stand still for so long that another takes over.
        let before_ns = self.alone_ns.replace(at_ns);
        if before_ns.is_some_and(|before_ns| ((at_ns - before_ns) as f64) < EPOCH_ALONE_S * 1e9) {
            findings.add(Finding::Epoch, || format!("{} without a fault", state.epoch));
        }
    }

    /// Judges the times of a state.
    pub(crate) fn take(&self, at_ns: i64, state: &State, allowances: &Allowances, findings: &mut Findings) {
        let State {
            number,
            sent_ns,
            time_ns,
            ..
        } = *state;
        let on_its_way_s = (at_ns - sent_ns) as f64 / 1e9;
        if on_its_way_s < 0.0 || (on_its_way_s > ARRIVAL_S && sent_ns > self.joined_ns) || sent_ns < self.begin_ns[0] {
            return findings.add(Finding::Times, || format!("{number} was sent {on_its_way_s:.1} s ago"));
        }
        let age_s = (self.utc_ns(sent_ns) - time_ns) as f64 / 1e9;
        if age_s < -CLOCK_S {
            return findings.add(Finding::Times, || {
                format!("{number} is of a time {:.1} s ahead", -age_s)
            });
        }
        let missing_s = allowances.missing_s(sent_ns - (age_s * 1e9) as i64, sent_ns, self.period_s);
        if state.of_report && age_s > self.period_s + missing_s {
            findings.add(Finding::Late, || format!("a state of {number} by {age_s:.1} s"));
        }
    }

    fn utc_ns(&self, mono_ns: i64) -> i64 {
        self.begin_ns[1].saturating_add(mono_ns.saturating_sub(self.begin_ns[0]))
    }
}
