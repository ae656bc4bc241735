//! Checking pressures at sea level.

use std::collections::BTreeSet;

use deployment::check_name;
use frames::SystemFrame;
use fusion_settings::qnh::{QNH_REGIONS_MAX, RegionalQnh};
use fusion_settings::region::Region;
use settings::SettingsError;

use super::check_region::corners;
use super::checked::Checked;
use super::tables::QnhTable;

/// The pressures, with their regions in the system frame.
pub(super) fn check_qnh(raw: &[QnhTable], frame: &SystemFrame) -> Checked<Vec<RegionalQnh>> {
    if raw.len() > QNH_REGIONS_MAX {
        let what = format!("{} are more than {QNH_REGIONS_MAX}", raw.len());
        return Err(SettingsError::new("qnh", what));
    }
    let mut names = BTreeSet::new();
    let one = |(index, each): (usize, &QnhTable)| {
        let key = |part: &str| format!("qnh[{index}].{part}");
        check_name(&key("name"), &each.name)?;
        if !names.insert(each.name.clone()) {
            let what = format!("\"{}\" is the name of an earlier table; give each its own", each.name);
            return Err(SettingsError::new(key("name"), what));
        }
        let region = (!each.corners_deg.is_empty())
            .then(|| corners(&key("corners_deg"), &each.corners_deg, frame))
            .transpose()?
            .map(|corners_m| Region {
                corners_m,
                ..Region::default()
            });
        let mut readings = vec![(i64::MIN, each.hpa)];
        for (place, later) in each.later.iter().enumerate() {
            let key = key(&format!("later[{place}].from"));
            let from: jiff::Timestamp = later.from.parse().map_err(|_| {
                let what = format!(
                    "\"{}\" is not a time: write it as in \"2016-05-10T06:00:00Z\"",
                    later.from
                );
                SettingsError::new(key.clone(), what)
            })?;
            let from_ns = i64::try_from(from.as_nanosecond()).unwrap_or(i64::MAX);
            if readings.last().is_some_and(|(before_ns, _)| *before_ns >= from_ns) {
                return Err(SettingsError::new(
                    key,
                    "is not later than the time before: give them in order",
                ));
            }
            readings.push((from_ns, later.hpa));
        }
        let transition_level = i16::try_from(each.transition_level).unwrap_or(i16::MAX);
        Ok(RegionalQnh::new(each.name.clone(), region, transition_level, readings))
    };
    raw.iter().enumerate().map(one).collect()
}
