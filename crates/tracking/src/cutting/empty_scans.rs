//! Scans without detections that are known before the next detection comes.

use super::{Boundaries, CutScan, Cutter, OpenScan, Rhythm};

impl<T> Cutter<T> {
    /// Takes note of a complete scan without detections. Later scans have greater numbers, and detections earlier than
    /// the following scan are too late.
    pub fn empty_scan(&mut self, scan: CutScan) {
        let Some(Rhythm { period_ns, .. }) = self.rhythm else {
            return;
        };
        let by_period = self.settings.boundaries == Boundaries::Period;
        let next_ns = scan.time_ns.saturating_add(period_ns);
        self.scan = Some(OpenScan {
            number: scan.number.saturating_add(1),
            begin_ns: match by_period {
                true => next_ns.div_euclid(period_ns).saturating_mul(period_ns),
                false => next_ns,
            },
            at_boundary: by_period,
        });
    }
}

#[cfg(test)]
mod tests {
    use crate::cutting::{CutterSettings, DetectionTreatment};
    use crate::testing::{S, position};

    use super::*;

    #[test]
    fn what_follows_an_empty_scan_has_a_greater_number() {
        for (boundaries, begin_s) in [(Boundaries::Turn, 10), (Boundaries::Period, 8)] {
            let mut cutter = Cutter::new(CutterSettings {
                boundaries,
                period_ns: Some(4 * S),
                wait_ns: Some(0),
                waiting_max: 8,
                epoch_ns: 0,
            });
            cutter.take(position(2 * S, 0.0, 0.0), ());
            let before = cutter.last_scan().unwrap();
            let empty = CutScan {
                number: before.number + 1,
                time_ns: 6 * S,
            };
            cutter.empty_scan(empty);
            assert_eq!(cutter.earliest_ns(), begin_s * S);
            let late = cutter.take(position(begin_s * S - 1, 0.0, 0.0), ());
            assert_eq!(late, DetectionTreatment::TooLate);
            cutter.take(position(begin_s * S, 0.0, 0.0), ());
            assert_eq!(cutter.last_scan().map(|scan| scan.number), Some(empty.number + 1));
        }
    }
}
