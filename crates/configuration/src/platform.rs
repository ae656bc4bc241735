//! Platforms that carry sensors (EL-11, HT-12).
//!
//! ```toml
//! [[platform]]
//! name = "ship"                    # its states are at platform/ship/state
//! heading_sigma_deg = 0.3          # of sentences that state none
//! [platform.live]                  # exactly one of udp, tcp and device
//! udp = { listen = "0.0.0.0:10110" }
//! ```

use std::collections::BTreeSet;
use std::path::PathBuf;

use deployment::{Deployment, Platform, PlatformFeed, PlatformInput, check_name};
use settings::SettingsError;
use sources::PlatformReading;

use super::check_network::{check_udp, server};
use super::checked::{Checked, CheckedSource};
use super::tables::{DeploymentTable, PlatformLiveTable, PlatformTable};

/// Most platforms of a deployment.
const PLATFORMS_MAX: usize = 16;
/// Port of the first simulated platform on the deployment's loopback address; the others follow.
const FIRST_SIMULATED_PORT: u16 = 32_001;

/// The platforms of a file, and how their states are read.
pub(super) fn check_platforms(raw: &[PlatformTable]) -> Checked<(Vec<Platform>, Vec<PlatformReading>)> {
    if raw.len() > PLATFORMS_MAX {
        let what = format!("there are {}; at most {PLATFORMS_MAX} can be", raw.len());
        return Err(SettingsError::new("platform", what));
    }
    let mut names = BTreeSet::new();
    let mut platforms = Vec::new();
    for (index, each) in raw.iter().enumerate() {
        let key = format!("platform[{index}].name");
        check_name(&key, &each.name)?;
        if !names.insert(&each.name) {
            let what = format!(
                "\"{}\" is the name of an earlier platform; give each its own",
                each.name
            );
            return Err(SettingsError::new(key, what));
        }
        let input = match (&each.live, &each.recorded) {
            _ if each.simulated.is_some() => {
                PlatformInput::Live(PlatformFeed::Loopback(FIRST_SIMULATED_PORT + index as u16))
            }
            (Some(live), _) => PlatformInput::Live(feed(&format!("platform[{index}].live"), live)?),
            (_, Some(recorded)) => PlatformInput::Recorded(PathBuf::from(&recorded.file)),
            _ => PlatformInput::External,
        };
        platforms.push(Platform {
            number: index as u16,
            name: each.name.clone(),
            input,
            is_simulated: each.simulated.is_some(),
            radar: None,
            range_m: each.range_m,
            receipt_sigma_s: each.receipt_sigma_s,
            silent_after_ns: each.silent_s.ns(),
            wait_ns: each.wait_s.ns(),
        });
    }
    let reading = |each: &PlatformTable| PlatformReading {
        assumed: each.assumed,
        jumps: each.jumps,
    };
    Ok((platforms, raw.iter().map(reading).collect()))
}

fn feed(key: &str, raw: &PlatformLiveTable) -> Checked<PlatformFeed> {
    Ok(match (&raw.udp, &raw.tcp, &raw.device) {
        (Some(udp), ..) => PlatformFeed::Udp(check_udp(&format!("{key}.udp"), udp)?),
        (_, Some(tcp), _) => PlatformFeed::Tcp(server(&format!("{key}.tcp"), tcp)?),
        (.., device) => PlatformFeed::Device(PathBuf::from(device.as_deref().unwrap_or_default())),
    })
}

/// Finds the sensors that are the radars of simulated platforms.
pub(super) fn find_radars(platforms: &mut [Platform], raw: &DeploymentTable, sensors: &[CheckedSource]) -> Checked<()> {
    let tables = raw.trackers.iter().flat_map(|tracker| &tracker.sensors);
    for (sensor, _) in sensors
        .iter()
        .zip(tables)
        .filter(|(_, table)| table.simulated.is_some())
    {
        let number = sensor.on_board.and_then(|on_board| on_board.platform);
        let Some(platform) = number.and_then(|number| platforms.get_mut(usize::from(number))) else {
            continue;
        };
        if platform.radar.replace(sensor.adapter.clone()).is_some() {
            let what = format!(
                "platform \"{}\" has one radar, which is another sensor's",
                platform.name
            );
            return Err(SettingsError::new(format!("source[{}].simulated", sensor.number), what));
        }
    }
    Ok(())
}

/// No two processes have one name.
pub(super) fn check_platform_names(deployment: &Deployment) -> Checked<()> {
    let adapters = deployment.sources.iter().map(|source| &source.adapter);
    let adapters = adapters.chain(deployment.wide_area_sensors.iter().map(|sensor| &sensor.adapter));
    let adapters: BTreeSet<&String> = adapters
        .chain(deployment.receivers.iter().map(|receiver| &receiver.name))
        .collect();
    let taken = deployment.platforms.iter().find(|platform| {
        let has_process = platform.has_process();
        has_process && adapters.contains(&platform.name)
    });
    taken.map_or(Ok(()), |platform| {
        let what = format!(
            "\"{}\" is also the name of an adapter process, that of a source, sensor or receiver; give the platform another",
            platform.name
        );
        Err(SettingsError::new(format!("platform[{}].name", platform.number), what))
    })
}

#[cfg(test)]
#[path = "platform_tests.rs"]
mod tests;
