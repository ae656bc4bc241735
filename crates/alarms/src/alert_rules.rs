//! Rules of Prometheus that forward alarms, generated from the registry.

use std::fmt::Write as _;

use messages::AlarmSeverity;

use crate::registry::AlarmKind;

const HEAD: &str = "\
# Alerting rules of Prometheus: a rule per alarm of the registry, and a rule for a deployment that does not answer.
groups:
  - name: koseki
    rules:
      - alert: KosekiUnreachable
        expr: up{job=\"koseki\"} == 0
        for: 30s
        labels: {severity: critical}
        annotations:
          summary: The monitor at {{ $labels.instance }} does not answer.
          description: Check that the deployment runs (`koseki status`), and `monitor.prometheus` in its configuration.
";

/// Returns the rules, a YAML file. The monitor applies the delays before it raises an alarm, so no rule waits
/// again.
pub fn alert_rules() -> String {
    let mut text = HEAD.to_owned();
    for kind in AlarmKind::ALL {
        let severity = match kind.severity() {
            AlarmSeverity::Warning => "info",
            AlarmSeverity::Major => "warning",
            AlarmSeverity::Critical => "critical",
        };
        let word = kind.word();
        let name: String = word.split('-').map(capitalised).collect();
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "      - alert: Koseki{name}
        expr: koseki_alarm{{alarm=\"{word}\"}} == 1
        labels: {{severity: {severity}}}
        annotations:
          summary: '{word}: {{{{ $labels.source }}}} {{{{ $labels.partner }}}} {{{{ $labels.process }}}}'
          description: '{}'
",
            kind.remedy().replace('\'', "''")
        );
    }
    text
}

fn capitalised(word: &str) -> String {
    let (first, rest) = word.split_at(1);
    first.to_uppercase() + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_alarm_has_a_rule_of_its_own() {
        let rules = alert_rules();
        for kind in AlarmKind::ALL {
            let expression = format!("expr: koseki_alarm{{alarm=\"{}\"}} == 1\n", kind.word());
            assert_eq!(rules.matches(&expression).count(), 1, "{kind:?}");
        }
        assert!(rules.contains("- alert: KosekiSourceSilent\n"));
        assert!(rules.contains("summary: 'clock-off: {{ $labels.source }}"));
        assert_eq!(rules.matches("- alert: ").count(), 1 + AlarmKind::ALL.len());
    }
}
