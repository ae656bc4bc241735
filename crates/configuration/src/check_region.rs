//! Checking regions of centres.

use std::collections::BTreeSet;

use deployment::check_name;
use frames::{Geodetic, SystemFrame};
use fusion_settings::region::{CORNERS_MAX, REGIONS_MAX, Region};
use settings::SettingsError;

use super::checked::Checked;
use super::tables::RegionTable;

/// The regions in the system frame, of which those of `origin` are the own.
pub(super) fn check_regions(
    raw: &[RegionTable],
    (origin, exchange): (u32, bool),
    frame: &SystemFrame,
) -> Checked<Vec<Region>> {
    if raw.is_empty() {
        return Ok(Vec::new());
    }
    let refused = |key: String, what: String| Err(SettingsError::new(key, what));
    if origin == 0 || !exchange {
        let what = "needs fusion.exchange = true, and an origin other than 0";
        return refused("region".to_owned(), what.to_owned());
    }
    if raw.len() > REGIONS_MAX {
        return refused(
            "region".to_owned(),
            format!("{} are more than {REGIONS_MAX}", raw.len()),
        );
    }
    let mut names = BTreeSet::new();
    let mut regions: Vec<Region> = Vec::new();
    for (index, each) in raw.iter().enumerate() {
        let key = |part: &str| format!("region[{index}].{part}");
        check_name(&key("name"), &each.name)?;
        if !names.insert(&each.name) {
            let what = format!("\"{}\" is the name of an earlier region; give each its own", each.name);
            return refused(key("name"), what);
        }
        let region = Region {
            origin: each.origin,
            is_own: each.origin == origin,
            corners_m: corners(&key("corners_deg"), &each.corners_deg, frame)?,
        };
        let overlapped = (0..regions.len()).find(|other| regions[*other].overlaps(&region));
        if let Some(other) = overlapped.filter(|other| regions[*other].origin != each.origin) {
            let what = format!(
                "\"{}\" overlaps \"{}\" of another centre: a target there would have two owners; let them meet at a line",
                each.name, raw[other].name
            );
            return refused(key("corners_deg"), what);
        }
        regions.push(region);
    }
    if !regions.iter().any(|region| region.is_own) {
        let what = format!("none is of this deployment, whose origin is {origin}: it would own no target");
        return refused("region".to_owned(), what);
    }
    Ok(regions)
}

pub(super) fn corners(key: &str, raw: &[[f64; 2]], frame: &SystemFrame) -> Checked<Vec<[f64; 2]>> {
    if !(3..=CORNERS_MAX).contains(&raw.len()) {
        let what = format!("{} corners; a region has 3 to {CORNERS_MAX}", raw.len());
        return Err(SettingsError::new(key, what));
    }
    let local = |[latitude_deg, longitude_deg]: &[f64; 2]| {
        let place = Geodetic::from_degrees(*latitude_deg, *longitude_deg, 0.0)
            .map_err(|error| SettingsError::new(key, error.to_string()))?;
        let [east, north, _] = frame.to_local(place);
        Ok([east, north])
    };
    raw.iter().map(local).collect()
}
