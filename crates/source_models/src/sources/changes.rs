//! Sources with changing systematic errors.

use crate::settings::SourceSet;
use crate::sources::Sources;

impl Sources {
    /// Restarts the estimates of the sources set aside since the last call: the errors of these sources have changed by
    /// more than the filters accept.
    pub(crate) fn begin_anew_where_set_aside(&mut self, restarted: &mut impl FnMut(u16)) {
        let set_aside = self.credibility.all_set_aside();
        let changed = set_aside.without(std::mem::replace(&mut self.was_set_aside, set_aside));
        for source in changed.iter() {
            if self.registration.begin_anew_if_settled(source) {
                restarted(source);
            }
        }
    }

    /// Ends the contradictions of the sources with newly found errors: the contradictions came from these errors.
    /// `before` are the sources with an error removed before.
    pub(crate) fn trust_found(&mut self, before: SourceSet) {
        let found = self.registration.removing().without(before);
        for source in 0..self.models.len() as u16 {
            let is_found = found.contains(source) && self.registration.is_young(source);
            if is_found || self.registration.is_first_solution(source) {
                self.credibility.reset(source);
            }
        }
    }
}
