//! Reference page of alarms, generated from the registry.

use std::fmt::Write as _;

use crate::registry::AlarmKind;

const HEAD: &str = "# Alarms

An alarm reports a condition that needs attention, its cause, and the remedy. The monitor raises and clears alarms.
They appear on the topic `system/alarms`, in `koseki status` and `koseki top`, in the final report, in the recorder's
`alarms.csv`, as `koseki_alarm` among the metrics, and on standard error (a line each, at most one line a second after the
first few).
CAT063 reports a sensor with an alarm as degraded, sets NPW for a silent sensor, and TSV for a sensor with a wrong clock.
In CAT065 a critical alarm degrades the system; losses and full tables set OVL.

Every slice of the topic contains all present alarms and the alarms cleared just before; a slice replaces the previous
slice. The monitor publishes at least twice a second. A late or interrupted reader is therefore soon up to date. A
restarted monitor detects the present alarms again.

An alarm is raised when its condition has held for the first time below, and cleared when its condition has been absent
for the second time. Between the limit for raising and the limit for clearing, nothing changes. The monitor replaces the
words in braces.

This page is written by `UPDATE_GOLDEN=1 cargo test -p alarms reference`.
";

/// Returns the page, in Markdown.
pub fn reference() -> String {
    let mut page = HEAD.to_owned();
    page.push_str("\n| code | alarm | severity | raised after | cleared after |\n| --- | --- | --- | --- | --- |\n");
    for kind in AlarmKind::ALL {
        let after = [kind.raise_after_ns(), kind.clear_after_ns()].map(|ns| match ns / 1_000_000_000 {
            0 => "at once".to_owned(),
            seconds => format!("{seconds} s"),
        });
        let (code, word, severity) = (kind.code(), kind.word(), kind.severity().word());
        let _ = writeln!(
            page,
            "| {code} | [{word}](#{word}) | {severity} | {} | {} |",
            after[0], after[1]
        );
    }
    for kind in AlarmKind::ALL {
        let _ = write!(
            page,
            "\n## {}\n\n> {}\n\n{}\n",
            kind.word(),
            kind.sentence(),
            kind.remedy()
        );
    }
    page
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn the_page_is_fresh() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/alarms.md");
        test_support::assert_golden(&path, &reference());
    }
}
