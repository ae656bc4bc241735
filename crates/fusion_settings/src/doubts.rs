//! Stated life times that make no sense.

use settings::{Seconds, SettingsError};

use crate::Settings;

/// Periods within which a source that sees a target has surely reported it again: no antenna turns quite evenly.
const SURELY_AGAIN: f64 = 1.1;

impl Settings {
    /// The stated life times that make no sense beside the sources' periods, each with key, value and remedy. They hold
    /// all the same.
    pub fn doubtful_lifetimes(&self) -> Vec<SettingsError> {
        let stated_s = |time: Option<Seconds>| time.map_or(f64::INFINITY, Seconds::s);
        let (tentative_s, terminate_s) = (stated_s(self.life.tentative_s), stated_s(self.life.terminate_s));
        let mut doubts = Vec::new();
        let mut doubt = |key: &str, what: String| doubts.push(SettingsError::new(format!("fusion.life.{key}"), what));
        if let Some(slowest) = self.sources.iter().max_by_key(|source| source.fresh_ns) {
            let [period_s, fresh_s] = [slowest.period_ns, slowest.fresh_ns].map(|ns| Seconds::of_ns(ns).s());
            let name = &slowest.name;
            if tentative_s < SURELY_AGAIN * period_s {
                doubt(
                    "tentative_s",
                    format!(
                        "{tentative_s} s: a new track has ended before {name}, every {period_s} s, reports it again, \
                         and is started anew each time; leave it out, or make it {fresh_s} or more"
                    ),
                );
            }
            if terminate_s < fresh_s {
                doubt(
                    "terminate_s",
                    format!(
                        "{terminate_s} s: a track ends while the latest report of {name} still counts, {fresh_s} s; \
                         leave it out, or make it more than that"
                    ),
                );
            }
        }
        if tentative_s.is_finite() && tentative_s > terminate_s {
            doubt(
                "tentative_s",
                format!(
                    "{tentative_s} s: a track that nobody believes in outlives a confirmed one, which ends after \
                     {terminate_s} s; make it less than that"
                ),
            );
        }
        doubts
    }
}
