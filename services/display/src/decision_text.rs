//! Sentences of the decisions of fusion.

use messages::{Decision, DecisionKind, NO_SOURCE};
use serde_json::{Value, json};

use crate::world::World;

/// Returns the decisions on a system track, the latest first.
pub(crate) fn list(world: &World, track: u32) -> Vec<Value> {
    let row = |decision: &Decision| {
        let kind = decision.kind()?;
        let text = sentence(world, track, kind, decision);
        Some(json!({"time_s": decision.time_ns as f64 / messages::NS_PER_S, "kind": kind.word(), "text": text}))
    };
    // Fusion decides in the order of arrival; reports of different sources have overtaken each other.
    let mut latest: Vec<&Decision> = world.decisions.of(track).collect();
    latest.sort_by_key(|decision| std::cmp::Reverse(decision.time_ns));
    latest.into_iter().filter_map(row).collect()
}

/// Returns the reason why there are no decisions; `None` if fusion publishes them.
pub(crate) fn missing(world: &World) -> Option<&'static str> {
    match (world.has_decisions, world.recording.is_some()) {
        (true, _) => None,
        (false, true) => Some("The recording has no decisions. To record them, set decisions = true in [fusion]."),
        (false, false) => Some(
            "Fusion publishes no decisions. Give the deployment a display (listen in [display]), or set \
             decisions = true in [fusion].",
        ),
    }
}

/// Returns the sentence of a decision in the view of the system track `track`.
fn sentence(world: &World, track: u32, kind: DecisionKind, decision: &Decision) -> String {
    let name = |source: u16| match source {
        NO_SOURCE => "a source".to_owned(),
        number => world.observed.source_name(number),
    };
    let (source, from) = (name(decision.source), name(decision.other_source));
    let (value, limit) = (decision.value, decision.limit);
    let other = match decision.other_system_track {
        other if other == track => decision.system_track,
        other => other,
    };
    let compared = |what: &str, unit: &str| match (value.is_finite(), limit.is_finite()) {
        (true, true) => format!(" ({what} {value:.1}{unit}, limit {limit:.1}{unit})"),
        (true, false) => format!(" ({what} {value:.1}{unit})"),
        _ => String::new(),
    };
    match kind {
        DecisionKind::Started => format!("Started by {source}: its track fits no other system track."),
        DecisionKind::Joined => format!("{source} joined{}.", compared("squared distance", "")),
        DecisionKind::JoinedByAddress => format!("{source} joined by the target's address."),
        DecisionKind::Duplicate => {
            format!(
                "A second track of {source} shows the same target{}.",
                compared("distance", " m")
            )
        }
        DecisionKind::IdentityConflict => format!("{source} left: its address contradicts the others."),
        DecisionKind::Split => format!(
            "{source} left: it kept missing the others{}.",
            compared("squared distance", "")
        ),
        DecisionKind::Merged if decision.system_track == track => {
            format!("Merged into system track {other}{}.", compared("squared distance", ""))
        }
        DecisionKind::Merged => format!(
            "System track {other} merged into it{}.",
            compared("squared distance", "")
        ),
        DecisionKind::Confirmed => format!("Confirmed{}.", compared("evidence", "")),
        DecisionKind::Withheld => {
            format!(
                "Withheld: its sources no longer detect the target{}.",
                compared("misses", "")
            )
        }
        DecisionKind::Coasted => "Coasted: no source has a fresh report.".to_owned(),
        DecisionKind::Ended => "Ended.".to_owned(),
        DecisionKind::HandOver => match value.is_finite() && limit.is_finite() {
            true => format!("{source} took over from {from}: accuracy value {value:.3} against {limit:.3}."),
            false => format!("{source} took over from {from}: it now has the largest share."),
        },
        DecisionKind::ReferencePoint => format!("The target's reference point is now that of {source}."),
        DecisionKind::Uncrossed => {
            format!(
                "Two tracks of {source} changed places{}.",
                compared("sum of log-likelihood ratios", "")
            )
        }
        DecisionKind::Ordered => format!("Changed by order {value:.0} of an operator."),
        DecisionKind::OrderEnded => {
            format!(
                "An order ended: the tracks are too far apart{}.",
                compared("distance", " σ")
            )
        }
        DecisionKind::Suspended => "Suspended: no longer reported, its number rests.".to_owned(),
        DecisionKind::Resumed => "Resumed: the target came back under its former number.".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_merger_is_told_from_both_sides() {
        let decision = Decision {
            system_track: 7,
            time_ns: 5,
            kind: DecisionKind::Joined as u8,
            ..Decision::default()
        };
        let mut world = World::new("test", Vec::new(), 600, 1_000_000);
        let merged = Decision {
            other_system_track: 8,
            kind: DecisionKind::Merged as u8,
            value: 2.0,
            limit: 9.0,
            ..decision
        };
        world.decisions.keep(&merged);
        world.decisions.keep(&Decision { time_ns: 4, ..decision });
        let text = |track: u32| list(&world, track)[0]["text"].as_str().map(str::to_owned);
        assert_eq!(
            text(7).unwrap(),
            "Merged into system track 8 (squared distance 2.0, limit 9.0)."
        );
        assert_eq!(
            text(8).unwrap(),
            "System track 7 merged into it (squared distance 2.0, limit 9.0)."
        );
    }
}
