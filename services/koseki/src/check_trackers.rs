//! Tracker processes in the answer of `koseki check`: sensors and platforms, and waits that contradict the sensors.

use deployment::{Input, Platform, PlatformFeed, PlatformInput, Source};
use sources::PlatformReading;
use tracking::cutting::{Boundaries, CutterSettings};

use crate::config::Config;

const NS_PER_S: f64 = messages::NS_PER_S;
/// Default wait of a cutter: this part of a period.
const WAIT_SHARE: f64 = 0.1;

/// Returns the sensors of a tracker process, in words.
pub(crate) fn describe(source: &Source, config: &Config) -> String {
    let sensor = |sensor: &Source| {
        let input = match &sensor.input {
            Input::Live(live) => format!("live, behind receiver {}", live.receiver),
            Input::Recorded(recorded) => recorded.file.display().to_string(),
            _ if sensor.takes_orders => "designated by orders".to_owned(),
            _ => "external".to_owned(),
        };
        format!("{} ({input})", own_name(sensor))
    };
    let sensors: Vec<String> = config.sensors_of(source).iter().map(sensor).collect();
    let wait_s = config
        .tracker(source.number)
        .map_or(0.0, |tracker| tracker.joining.wait_ns as f64 / NS_PER_S);
    format!(
        "a tracker process joins the detections of {}; a scan waits at most {wait_s} s for others",
        sensors.join(", ")
    )
}

/// Returns the input of a platform that carries sensors, in words.
pub(crate) fn describe_platform(platform: &Platform, reading: &PlatformReading) -> String {
    let input = match &platform.input {
        PlatformInput::Live(PlatformFeed::Udp(udp)) => format!("live, datagrams to {}", udp.listen),
        PlatformInput::Live(PlatformFeed::Loopback(_)) => "simulated".to_owned(),
        PlatformInput::Live(PlatformFeed::Tcp(server)) => format!("live, sentences from {server}"),
        PlatformInput::Live(PlatformFeed::Device(device)) => format!("live, sentences from {}", device.display()),
        PlatformInput::Recorded(file) => format!("recorded, {}", file.display()),
        PlatformInput::External => "external, published by a separate process".to_owned(),
    };
    format!(
        "{}: {input}; states at most {} s apart",
        platform.name,
        reading.assumed.max_gap_s.s()
    )
}

/// Sensors with scans that come later than others wait, without an open scan.
pub(crate) fn doubts(config: &Config) -> impl Iterator<Item = String> + '_ {
    config.sources.iter().flat_map(|source| {
        let sensors = config.sensors_of(source);
        let tracker = config.tracker(source.number).filter(|_| sensors.len() > 1);
        let tracker = tracker.filter(|tracker| tracker.settings.capacity.open_scans == 0);
        let wait_s = tracker.map_or(0.0, |tracker| tracker.joining.wait_ns as f64 / NS_PER_S);
        let cutters = tracker.map_or(&[][..], |tracker| &tracker.joining.cutters);
        sensors.iter().zip(cutters).filter_map(move |(sensor, cutter)| {
            let span_s = span_s(cutter).filter(|span_s| *span_s > wait_s)?;
            Some(format!(
                "tracker {}: a scan of {} is complete up to {span_s:.1} s after its first detection, but other scans wait \
                 for wait_s = {wait_s} s only: scans of {} may be refused as late; raise wait_s, or give \
                 settings.capacity.open_scans",
                source.name,
                own_name(sensor),
                own_name(sensor),
            ))
        })
    })
}

/// Longest time from a detection to the completion of its scan, seconds; `None` if not configured.
fn span_s(cutter: &CutterSettings) -> Option<f64> {
    let period_s = cutter.period_ns.filter(|_| cutter.boundaries != Boundaries::Stated)? as f64 / NS_PER_S;
    let wait_s = cutter.wait_ns.map(|wait_ns| wait_ns as f64 / NS_PER_S);
    Some(period_s + wait_s.unwrap_or(WAIT_SHARE * period_s))
}

fn own_name(sensor: &Source) -> &str {
    sensor.name.rsplit('.').next().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    const SITE: &str = "name = \"t\"\n[frame]\nlatitude_deg = 41.0\nlongitude_deg = 2.0\n[[tracker]]\nname = \"ship\"\n\
                        wait_s = 0.3\n[[tracker.sensor]]\nname = \"radar\"\nscans = \"period\"\nperiod_s = 2.5\n\
                        [tracker.sensor.external]\n[[tracker.sensor]]\nname = \"lidar\"\n[tracker.sensor.external]\n";

    #[test]
    fn a_sensor_slower_than_the_wait_is_told_unless_scans_are_open() {
        let said = |text: &str| {
            let config = Config::parse(Path::new("t.toml"), text, &[]).unwrap();
            (
                describe(&config.sources[0], &config),
                doubts(&config).collect::<Vec<_>>(),
            )
        };
        let (what, found) = said(SITE);
        assert_eq!(
            what,
            "a tracker process joins the detections of radar (external), lidar (external); a scan waits at most 0.3 s \
             for others"
        );
        assert_eq!(found.len(), 1);
        assert!(
            found[0].contains("tracker ship: a scan of radar is complete up to 2.8 s"),
            "{found:?}"
        );
        assert_eq!(said(&SITE.replacen("0.3", "3", 1)).1.len(), 0);
        let open = SITE.replacen("wait_s = 0.3", "wait_s = 0.3\nsettings.capacity.open_scans = 8", 1);
        assert_eq!(said(&open).1.len(), 0);
    }
}
