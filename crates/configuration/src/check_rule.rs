//! Checking `[fusion.rule]`: how sources are scored, weighed and handed over.
//!
//! The engine checks ranges itself; here names become numbers.

use fusion::settings as engine;
use messages::FusionRule;

use super::check::{Checked, problem, source_called};
use super::raw::{RawDropOut, RawHandOver, RawIntersection, RawMosaic, RawResidual, RawRule, RawTie};

/// The rule and its options.
pub(super) fn check_rule(raw: &RawRule, sources: &[engine::SourceSettings]) -> Checked<engine::RuleSettings> {
    let rule = FusionRule::from_word(&raw.name).ok_or_else(|| {
        let known = FusionRule::ALL.map(FusionRule::word);
        problem(
            "fusion.rule.name",
            format!("\"{}\" is no fusion rule; there are: {}", raw.name, known.join(", ")),
        )
    })?;
    let reference_source = raw.reference_source.as_deref();
    let reference_source = reference_source.map(|name| source_called("fusion.rule.reference_source", name, sources));
    Ok(engine::RuleSettings {
        rule,
        residual: match raw.residual {
            RawResidual::Position => engine::Residual::Position,
            RawResidual::Velocity => engine::Residual::Velocity,
            RawResidual::PerAxis => engine::Residual::PerAxis,
            RawResidual::Innovation => engine::Residual::Innovation,
        },
        recency: raw.recency,
        reference_source: reference_source.transpose()?,
        tie: match raw.tie {
            RawTie::LastThenPriority => engine::Tie::LastThenPriority,
            RawTie::Priority => engine::Tie::Priority,
        },
        overdue_periods: raw.overdue_periods,
        quality_scans: raw.quality_scans,
        hand_over: check_hand_over(&raw.hand_over, sources)?,
        hysteresis: raw.hysteresis,
        hold_refreshes: raw.hold_refreshes,
        mosaic: check_mosaic(&raw.mosaic, sources)?,
        intersection: match raw.intersection {
            RawIntersection::Determinant => engine::Intersection::Determinant,
            RawIntersection::Trace => engine::Intersection::Trace,
        },
        common_noise_m2ps3: raw.common_noise_m2ps3,
    })
}

fn check_hand_over(raw: &RawHandOver, sources: &[engine::SourceSettings]) -> Checked<engine::HandOverSettings> {
    let mut pairs: Vec<engine::PairRamp> = Vec::new();
    for (index, pair) in raw.pairs.iter().enumerate() {
        let key = |part: &str| format!("fusion.rule.hand_over.pair[{index}].{part}");
        let from = source_called(&key("from"), &pair.from, sources)?;
        let to = source_called(&key("to"), &pair.to, sources)?;
        if pairs.iter().any(|earlier| (earlier.from, earlier.to) == (from, to)) {
            let what = format!("from \"{}\" to \"{}\" has been given before", pair.from, pair.to);
            return Err(problem(key("from"), what));
        }
        pairs.push(engine::PairRamp {
            from,
            to,
            ramp: pair.ramp.clone(),
        });
    }
    Ok(engine::HandOverSettings {
        ramp: raw.ramp.clone(),
        pairs,
        by_traces: raw.by_traces,
        drop_out: match raw.drop_out {
            RawDropOut::Switch => engine::DropOut::Switch,
            RawDropOut::Blend => engine::DropOut::Blend,
        },
    })
}

fn check_mosaic(raw: &RawMosaic, sources: &[engine::SourceSettings]) -> Checked<engine::MosaicSettings> {
    let mut cells: Vec<engine::MosaicCell> = Vec::new();
    for (index, cell) in raw.cells.iter().enumerate() {
        let key = |part: &str| format!("fusion.rule.mosaic.cell[{index}].{part}");
        let place = (cell.east, cell.north);
        let Err(at) = cells.binary_search_by_key(&place, |earlier| (earlier.east, earlier.north)) else {
            let what = format!("cell {} east, {} north has been given before", cell.east, cell.north);
            return Err(problem(key("east"), what));
        };
        let cell = engine::MosaicCell {
            east: cell.east,
            north: cell.north,
            sources: sources_called(&key("sources"), &cell.sources, sources)?,
        };
        cells.insert(at, cell);
    }
    Ok(engine::MosaicSettings {
        cell_m: raw.cell_m,
        default: sources_called("fusion.rule.mosaic.default", &raw.default, sources)?,
        cells,
    })
}

fn sources_called(key: &str, names: &[String], sources: &[engine::SourceSettings]) -> Checked<Vec<u16>> {
    names.iter().map(|name| source_called(key, name, sources)).collect()
}
