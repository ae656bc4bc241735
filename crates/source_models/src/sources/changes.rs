//! Sources whose systematic errors change.

use crate::sources::Sources;

impl Sources {
    /// Starts the estimates of the sources anew that the others contradict since the last call: their errors have
    /// changed by more than the filters accept.
    pub(crate) fn begin_anew_where_set_aside(&mut self, restarted: &mut impl FnMut(u16)) {
        let set_aside = self.credibility.all_set_aside();
        let changed = set_aside & !std::mem::replace(&mut self.was_set_aside, set_aside);
        for source in 0..self.models.len() as u16 {
            if changed & (1 << source) != 0 && self.registration.begin_anew_if_settled(source) {
                restarted(source);
            }
        }
    }

    /// Ends the contradictions of the sources whose changed errors have been found: they were due to those errors.
    /// `before` are the sources of which an error was removed before, as bits.
    pub(crate) fn trust_found(&mut self, before: u64) {
        let found = self.registration.removing() & !before;
        for source in 0..self.models.len() as u16 {
            let is_found = found & (1 << source) != 0 && self.registration.is_young(source);
            if is_found || self.registration.is_first_solution(source) {
                self.credibility.reset(source);
            }
        }
    }
}
