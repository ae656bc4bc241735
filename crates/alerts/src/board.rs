//! Raising, keeping and clearing of alerts.
//!
//! ```text
//!         probability ≥ the rule's             probability < half of it, or the target ended
//!   none ──────────────────────────▶ in force ──────────────────────────────────────────────▶ none
//! ```
//!
//! An alert is identified by its rule, its area and its targets: a pair has one alert, however often it is judged.

use std::collections::{BTreeMap, BTreeSet};

use messages::{AlarmEvent, Alert, alert_value_bits};

/// Most alerts in force: what a slice of the topic holds, less room for those that are cleared at the same time.
pub const IN_FORCE_MAX: usize = 192;
/// Number of an area that is none.
pub(crate) const NO_AREA: u16 = u16::MAX;

/// What identifies an alert.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct AlertKey {
    pub(crate) rule: u16,
    pub(crate) area: u16,
    /// Track numbers, the smaller one of a pair first; the second is 0 for a single target.
    pub(crate) tracks: [u32; 2],
}

/// Result of judging a target or pair.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Finding {
    pub(crate) probability: f64,
    pub(crate) time_to_s: f64,
    pub(crate) distance_m: f64,
    pub(crate) least_distance_m: f64,
    pub(crate) vertical_m: f64,
    pub(crate) least_vertical_m: f64,
    pub(crate) value: f64,
    pub(crate) limit: f64,
    /// Values that are known: `alert_value_bits`.
    pub(crate) valid: u16,
}

/// Alerts in force.
#[derive(Clone, Debug, Default)]
pub(crate) struct Board {
    in_force: BTreeMap<AlertKey, Alert>,
    /// Keys of each target.
    of_target: BTreeSet<(u32, AlertKey)>,
    /// Keys whose alerts end at a time, UTC, nanoseconds.
    ends: BTreeSet<(i64, AlertKey)>,
    /// Number of the last alert.
    last: u64,
    /// Alerts that were not raised for lack of room.
    refused: u64,
}

impl Finding {
    /// Of an event that has happened.
    pub(crate) fn happened() -> Self {
        Self {
            probability: 1.0,
            ..Self::default()
        }
    }

    /// Of a value that has passed its limit.
    pub(crate) fn passed(value: f64, limit: f64) -> Self {
        Self {
            value,
            limit,
            valid: alert_value_bits::VALUE,
            ..Self::happened()
        }
    }

    fn state(&self, alert: &mut Alert) {
        alert.probability = self.probability as f32;
        alert.time_to_s = self.time_to_s as f32;
        alert.distance_m = self.distance_m as f32;
        alert.least_distance_m = self.least_distance_m as f32;
        alert.vertical_m = self.vertical_m as f32;
        alert.least_vertical_m = self.least_vertical_m as f32;
        alert.value = self.value as f32;
        alert.limit = self.limit as f32;
        alert.valid = self.valid | alert.valid & alert_value_bits::ACKNOWLEDGED;
    }
}

impl Board {
    /// Takes a finding at a time; `probability` is the rule's. Returns the alert with its event if it was raised or
    /// cleared; `write` completes an alert that is in force.
    pub(crate) fn find(
        &mut self,
        key: AlertKey,
        finding: &Finding,
        (probability, now_ns): (f64, i64),
        write: impl FnOnce(&mut Alert),
    ) -> Option<Alert> {
        if let Some(alert) = self.in_force.get_mut(&key) {
            if finding.probability < 0.5 * probability {
                return self.clear(key, now_ns);
            }
            alert.time_ns = now_ns;
            alert.event = AlarmEvent::Standing.code();
            finding.state(alert);
            write(alert);
            return None;
        }
        if finding.probability < probability {
            return None;
        }
        if self.in_force.len() >= IN_FORCE_MAX {
            self.refused += 1;
            return None;
        }
        self.last += 1;
        let mut alert = Alert {
            time_ns: now_ns,
            raised_ns: now_ns,
            number: self.last,
            tracks: key.tracks,
            event: AlarmEvent::Raised.code(),
            ..Alert::default()
        };
        finding.state(&mut alert);
        write(&mut alert);
        self.put(key, alert);
        Some(alert)
    }

    /// Lets an alert in force end at a time, UTC, nanoseconds.
    pub(crate) fn end_at(&mut self, key: AlertKey, end_ns: i64) {
        self.ends.insert((end_ns, key));
    }

    /// Returns the next alert that ends until a time.
    pub(crate) fn ended(&mut self, now_ns: i64) -> Option<Alert> {
        while let Some((end_ns, key)) = self.ends.first().copied().filter(|(end_ns, _)| *end_ns <= now_ns) {
            self.ends.remove(&(end_ns, key));
            if let Some(cleared) = self.clear(key, now_ns) {
                return Some(cleared);
            }
        }
        None
    }

    /// Clears an alert; `None` if it is not in force.
    pub(crate) fn clear(&mut self, key: AlertKey, now_ns: i64) -> Option<Alert> {
        let mut alert = self.in_force.remove(&key)?;
        for track in key.tracks {
            self.of_target.remove(&(track, key));
        }
        alert.time_ns = now_ns;
        alert.event = AlarmEvent::Cleared.code();
        Some(alert)
    }

    /// Keys of the alerts in force about a target.
    pub(crate) fn of_target(&self, track: u32) -> impl Iterator<Item = AlertKey> + '_ {
        let first = AlertKey {
            rule: 0,
            area: 0,
            tracks: [0; 2],
        };
        let from = self.of_target.range((track, first)..);
        from.take_while(move |(of, _)| *of == track).map(|(_, key)| *key)
    }

    /// Whether an alert is in force.
    pub(crate) fn has(&self, key: AlertKey) -> bool {
        self.in_force.contains_key(&key)
    }

    /// Alerts in force, with their keys.
    pub(crate) fn in_force(&self) -> impl Iterator<Item = (AlertKey, &Alert)> {
        self.in_force.iter().map(|(key, alert)| (*key, alert))
    }

    /// Number of the last alert that was raised.
    pub(crate) fn last(&self) -> u64 {
        self.last
    }

    /// Goes on with numbers after `last`.
    pub(crate) fn number_after(&mut self, last: u64) {
        self.last = self.last.max(last);
    }

    /// Number of alerts that were not raised for lack of room.
    pub(crate) fn refused(&self) -> u64 {
        self.refused
    }

    /// Puts an alert in force, as it was when another board ended.
    pub(crate) fn put(&mut self, key: AlertKey, alert: Alert) {
        self.last = self.last.max(alert.number);
        self.in_force.insert(key, alert);
        self.of_target.extend(
            key.tracks
                .into_iter()
                .filter(|track| *track != 0)
                .map(|track| (track, key)),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KEY: AlertKey = AlertKey {
        rule: 0,
        area: NO_AREA,
        tracks: [3, 7],
    };

    fn found(probability: f64) -> Finding {
        Finding {
            probability,
            ..Finding::default()
        }
    }

    #[test]
    fn a_probability_near_the_limit_raises_once() {
        let mut board = Board::default();
        let events: Vec<Option<u8>> = [0.4, 0.55, 0.45, 0.55, 0.26, 0.24, 0.45, 0.6]
            .iter()
            .enumerate()
            .map(|(time, probability)| {
                let changed = board.find(KEY, &found(*probability), (0.5, time as i64), |_| {});
                changed.map(|alert| alert.event)
            })
            .collect();
        let (raised, cleared) = (Some(AlarmEvent::Raised.code()), Some(AlarmEvent::Cleared.code()));
        assert_eq!(events, [None, raised, None, None, None, cleared, None, raised]);
        let numbers: Vec<u64> = board.in_force().map(|(_, alert)| alert.number).collect();
        assert_eq!(numbers, [2], "a new alert has a new number");
        assert_eq!(
            board.of_target(3).chain(board.of_target(7)).collect::<Vec<_>>(),
            [KEY, KEY]
        );
        assert_eq!(board.of_target(5).count(), 0);
    }

    #[test]
    fn a_full_board_counts_what_it_refuses() {
        let mut board = Board::default();
        for track in 0..IN_FORCE_MAX as u32 + 3 {
            let key = AlertKey {
                tracks: [track + 1, 0],
                ..KEY
            };
            let raised = board.find(key, &found(1.0), (0.5, 0), |_| {});
            assert_eq!(raised.is_some(), (track as usize) < IN_FORCE_MAX);
        }
        assert_eq!(board.refused(), 3);
    }

    #[test]
    fn an_alert_ends_at_its_time() {
        let mut board = Board::default();
        board.find(KEY, &found(1.0), (0.5, 0), |_| {});
        board.end_at(KEY, 10);
        assert!(board.ended(9).is_none());
        assert_eq!(board.ended(10).map(|alert| alert.number), Some(1));
        assert!(board.ended(10).is_none());
    }
}
