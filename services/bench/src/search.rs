//! Search for the highest sustainable rate.

/// Result of a search.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Highest {
    /// Highest held rate; 0 if there is none.
    pub(crate) held: f64,
    /// Lowest rate not held; `None` if the limit of the search was held.
    pub(crate) not_held: Option<f64>,
}

/// Doubles the rate from `start` until `holds` returns false or `limit` is passed, then bisects until the result is
/// known to `tolerance` (1.03: to three percent).
///
/// On a shared machine, a sustainable rate fails occasionally, while an unsustainable rate never succeeds. A
/// failure therefore counts only after `tries` failures in a row.
pub(crate) fn highest(
    start: f64,
    limit: f64,
    tolerance: f64,
    tries: usize,
    mut holds: impl FnMut(f64) -> anyhow::Result<bool>,
) -> anyhow::Result<Highest> {
    let mut try_rate = |rate: f64| -> anyhow::Result<bool> {
        for _ in 0..tries {
            if holds(rate)? {
                return Ok(true);
            }
        }
        Ok(false)
    };
    let mut found = Highest::default();
    let mut rate = start;
    while rate <= limit {
        if !try_rate(rate)? {
            found.not_held = Some(rate);
            break;
        }
        found.held = rate;
        rate *= 2.0;
    }
    let Some(mut high) = found.not_held else {
        return Ok(found);
    };
    // Below the start, no rate is known to hold. The search continues downwards to a limit.
    let floor = start / 64.0;
    while high > floor && (found.held == 0.0 || high > tolerance * found.held) {
        let middle = if found.held == 0.0 {
            high / 2.0
        } else {
            (high * found.held).sqrt()
        };
        if try_rate(middle)? {
            found.held = middle;
        } else {
            high = middle;
        }
        found.not_held = Some(high);
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_known_knee_is_found() {
        for knee in [300.0, 999.0, 40_000.0, 777_777.0] {
            let mut probes = 0;
            let found = highest(1_000.0, 10e6, 1.02, 1, |rate| {
                probes += 1;
                Ok(rate <= knee)
            })
            .unwrap();
            assert!(found.held <= knee && found.held > knee / 1.02, "{knee}: {found:?}");
            assert!(found.not_held.unwrap() > knee);
            assert!(probes < 25, "{probes}");
        }
    }

    #[test]
    fn a_failure_must_repeat_itself() {
        let mut probes = 0;
        let found = highest(1_000.0, 10e6, 1.05, 2, |rate| {
            probes += 1;
            // Every third probe fails by chance.
            Ok(rate <= 50_000.0 && probes % 3 != 0)
        })
        .unwrap();
        assert!(found.held > 47_000.0 && found.held <= 50_000.0, "{found:?}");
    }

    #[test]
    fn ends_without_a_knee_and_without_a_hold() {
        let all = highest(1_000.0, 64_000.0, 1.05, 1, |_| Ok(true)).unwrap();
        assert_eq!((all.held, all.not_held), (64_000.0, None));
        let none = highest(1_000.0, 64_000.0, 1.05, 1, |_| Ok(false)).unwrap();
        assert_eq!(none.held, 0.0);
        assert!(none.not_held.unwrap() <= 1_000.0 / 64.0);
        assert!(highest(1.0, 2.0, 1.1, 1, |_| anyhow::bail!("no")).is_err());
    }
}
