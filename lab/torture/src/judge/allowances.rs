//! The inherent effects of a fault, and the duration of each: nothing else is excused.

use super::event::Part;
use super::limits::{
    FORGOTTEN_LASTING, FORGOTTEN_MEDIAN, FORGOTTEN_P95, FORGOTTEN_PERIODS, FUSION_S, MEMORY_S, RENEWED_LASTING,
    RENEWED_MEDIAN, RENEWED_P95, RENEWED_PERIODS, SENSORS_PERIODS,
};

/// Times in which a fault explains that states are missing, or that errors grow; monotonic, nanoseconds.
#[derive(Clone, Debug, Default)]
pub(crate) struct Allowances {
    spans: Vec<Span>,
    /// The judge saw nothing since then.
    blind_since_ns: Option<i64>,
}

#[derive(Clone, Copy, Debug)]
struct Span {
    part: Option<Part>,
    from_ns: i64,
    /// End of the fault's cause; `None`: the cause lasts.
    to_ns: Option<i64>,
}

impl Allowances {
    /// A fault begins, which takes these parts away.
    pub(crate) fn begin(&mut self, at_ns: i64, parts: &[Part]) {
        self.spans.extend(parts.iter().map(|part| Span {
            part: Some(*part),
            from_ns: at_ns,
            to_ns: None,
        }));
    }

    /// The cause of the latest fault is over.
    pub(crate) fn end(&mut self, at_ns: i64) {
        for span in self.spans.iter_mut().filter(|span| span.to_ns.is_none()) {
            span.to_ns = Some(at_ns);
        }
    }

    /// The subscriber has left: nothing is seen until the next join.
    pub(crate) fn leave(&mut self, at_ns: i64) {
        self.blind_since_ns.get_or_insert(at_ns);
    }

    /// The subscriber has joined.
    pub(crate) fn join(&mut self, at_ns: i64) {
        if let Some(from_ns) = self.blind_since_ns.take() {
            let to_ns = Some(at_ns);
            self.spans.push(Span {
                part: None,
                from_ns,
                to_ns,
            });
        }
    }

    /// Part of a time in which states of a target of this period may be missing, seconds.
    pub(crate) fn missing_s(&self, from_ns: i64, to_ns: i64, period_s: f64) -> f64 {
        let after_s = |part: Option<Part>| {
            Some(match part {
                None | Some(Part::Numbers) => 0.0,
                Some(Part::Fusion | Part::Adapter) => FUSION_S,
                Some(Part::Memory) => MEMORY_S,
                Some(Part::Sensors) => SENSORS_PERIODS * period_s,
            })
        };
        self.covered_s(from_ns, to_ns, after_s)
    }

    /// Ratios to the run without faults of the median and 95 % of all errors, and of a target's lasting error, while
    /// estimates begin anew after a fault; `None` at other times.
    pub(crate) fn renewal(&self, at_ns: i64, slowest_period_s: f64) -> Option<[f64; 3]> {
        let forgotten_s = |part| (part == Some(Part::Numbers)).then_some(FORGOTTEN_PERIODS * slowest_period_s);
        let renewed_s = |part: Option<Part>| part.map(|_| RENEWED_PERIODS * slowest_period_s);
        if self.covered_s(at_ns - 1, at_ns, forgotten_s) > 0.0 {
            return Some([FORGOTTEN_MEDIAN, FORGOTTEN_P95, FORGOTTEN_LASTING]);
        }
        (self.covered_s(at_ns - 1, at_ns, renewed_s) > 0.0).then_some([RENEWED_MEDIAN, RENEWED_P95, RENEWED_LASTING])
    }

    /// Part of a time that is covered by faults, seconds: each lasts `after_s` longer than the cause, or is left out.
    fn covered_s(&self, from_ns: i64, to_ns: i64, after_s: impl Fn(Option<Part>) -> Option<f64>) -> f64 {
        let blind = self.blind_since_ns.map(|from_ns| Span {
            part: None,
            from_ns,
            to_ns: None,
        });
        let mut covered: Vec<(i64, i64)> = Vec::new();
        for span in self.spans.iter().chain(&blind) {
            let Some(after_s) = after_s(span.part) else {
                continue;
            };
            let end_ns = span.to_ns.map_or(to_ns, |end_ns| end_ns + (after_s * 1e9) as i64);
            let (begin_ns, end_ns) = (span.from_ns.max(from_ns), end_ns.min(to_ns));
            if begin_ns < end_ns {
                covered.push((begin_ns, end_ns));
            }
        }
        covered.sort_unstable();
        let (mut sum_ns, mut until_ns) = (0, from_ns);
        for (begin_ns, end_ns) in covered {
            sum_ns += (end_ns - begin_ns.max(until_ns)).max(0);
            until_ns = until_ns.max(end_ns);
        }
        sum_ns as f64 / 1e9
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: i64 = 1_000_000_000;

    #[test]
    fn faults_that_overlap_are_counted_once() {
        let mut allowances = Allowances::default();
        allowances.begin(10 * S, &[Part::Fusion]);
        assert_eq!(allowances.missing_s(9 * S, 12 * S, 1.0), 2.0, "it lasts");
        allowances.end(12 * S);
        allowances.begin(12 * S, &[Part::Sensors]);
        allowances.end(12 * S);
        assert_eq!(allowances.missing_s(9 * S, 20 * S, 1.0), 6.0, "until 13 and until 16");
        assert_eq!(allowances.missing_s(17 * S, 20 * S, 1.0), 0.0);
        allowances.leave(18 * S);
        assert_eq!(allowances.missing_s(17 * S, 20 * S, 1.0), 2.0, "blind");
        allowances.join(19 * S);
        assert_eq!(allowances.missing_s(17 * S, 20 * S, 1.0), 1.0);
        assert_eq!(
            allowances.renewal(40 * S, 5.0),
            Some([RENEWED_MEDIAN, RENEWED_P95, RENEWED_LASTING])
        );
        assert_eq!(allowances.renewal(43 * S, 5.0), None);
        allowances.begin(45 * S, &[Part::Fusion]);
        let renewed = Some([RENEWED_MEDIAN, RENEWED_P95, RENEWED_LASTING]);
        assert_eq!(
            allowances.renewal(46 * S, 5.0),
            renewed,
            "a cause that lasts is no loss"
        );
        allowances.end(46 * S);
        allowances.begin(50 * S, &[Part::Numbers]);
        allowances.end(50 * S);
        assert_eq!(
            allowances.renewal(105 * S, 5.0),
            Some([FORGOTTEN_MEDIAN, FORGOTTEN_P95, FORGOTTEN_LASTING])
        );
    }
}
