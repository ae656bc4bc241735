//! Reference page of alarms, generated from the registry.

use std::fmt::Write as _;

use crate::registry::AlarmKind;

const HEAD: &str = "# Alarms

An alarm tells that somebody should look at something, what it is, and what to do. The monitor raises and clears them; they
are on the topic `system/alarms`, in `koseki status` and `koseki top`, in the final report, on standard error (one line
each, at most one a second after the first few), in the recorder's `alarms.csv`, and as `koseki_alarm` among the metrics.
In CAT063 a sensor with an alarm is degraded, one that is silent has NPW set, and one whose clock is off TSV; in CAT065 a
critical one degrades the system, and losses or a table that is full set OVL.

Every slice of the topic holds all alarms that stand, and those that have just been cleared; it replaces the one before.
One comes at least twice a second, so whoever joins late, or misses one, soon knows what stands. A monitor that was
restarted finds out anew what stands.

An alarm is raised when its condition has held for the first of the two times below, and cleared when it has not held for
the second; while a value lies between the limit for raising and that for clearing, nothing changes. Words in braces are
filled in.

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
