//! Links of a source's tracker: inputs besides its own sensor, and outputs besides tracks after scans.
//!
//! Found when all sources and sensors of a file are known, as trackers name them:
//!
//! ```toml
//! [source.tracker]
//! wide_area_sensors = ["remote"]   # their counts support hypotheses (WA-2)
//! emissions = ["patrol"]           # direction finders on board: what they hear identifies tracks (WA-9)
//! cues = true                      # after each scan it says where the sensor should look next (WA-12)
//! output_period_s = 1.0            # tracks at even times instead of after each scan (WA-11)
//! ```

use settings::SettingsError;

use super::checked::{Checked, CheckedSource};
use super::tables::{SourceTable, WideAreaSensorTable};

/// Lets the trackers know what they are linked with.
pub(super) fn check_links(
    sources: &mut [CheckedSource],
    raw: &[SourceTable],
    sensors: &[WideAreaSensorTable],
) -> Checked<()> {
    let hears = |source: &&CheckedSource| source.publishes_bearings();
    let finders: Vec<(String, u16)> = sources
        .iter()
        .filter(hears)
        .map(|finder| (finder.name.clone(), finder.number))
        .collect();
    let finders: Vec<(&str, u16)> = finders.iter().map(|(name, number)| (name.as_str(), *number)).collect();
    let sensors: Vec<(&str, u16)> = (0..)
        .zip(sensors)
        .map(|(number, sensor)| (sensor.name.as_str(), number))
        .collect();
    for (CheckedSource { source, .. }, raw) in sources.iter_mut().zip(raw) {
        let Some(raw) = &raw.tracker else { continue };
        let key = |part: &str| format!("source[{}].tracker.{part}", source.number);
        let named = &raw.wide_area_sensors;
        source.links.wide_area_sensors =
            numbers_of(&key("wide_area_sensors"), named, "[[wide_area_sensor]]", &sensors)?;
        let kind = "direction finder among the sources";
        source.links.emissions = numbers_of(&key("emissions"), &raw.emissions, kind, &finders)?;
        if !source.input.is_recorded() {
            continue;
        }
        if !source.links.emissions.is_empty() {
            let what = "direction finders are live, but the source is a recording: leave it out";
            return Err(SettingsError::new(key("emissions"), what));
        }
        if raw.cues {
            return Err(SettingsError::new(
                key("cues"),
                "the sensor of a recording looks nowhere: leave it out",
            ));
        }
    }
    Ok(())
}

/// The numbers of these names, ascending, so that the order in which they are named does not matter. `known` are the
/// names of a kind of thing with their numbers.
pub(super) fn numbers_of(key: &str, names: &[String], kind: &str, known: &[(&str, u16)]) -> Checked<Vec<u16>> {
    let mut numbers = Vec::new();
    for name in names {
        let Some((_, number)) = known.iter().find(|(other, _)| other == name) else {
            let names: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
            let names = if names.is_empty() {
                "none".to_owned()
            } else {
                names.join(", ")
            };
            let what = format!("there is no {kind} named \"{name}\"; there are: {names}");
            return Err(SettingsError::new(key, what));
        };
        if numbers.contains(number) {
            return Err(SettingsError::new(
                key,
                format!("\"{name}\" is named twice; name it once"),
            ));
        }
        numbers.push(*number);
    }
    numbers.sort_unstable();
    Ok(numbers)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::Config;

    const SITE: &str = r#"name = "t"
[frame]
latitude_deg = 41.0
longitude_deg = 2.0
[[receiver]]
name = "lan"
[receiver.udp]
listen = "127.0.0.1:8600"
[[receiver]]
name = "ears"
[receiver.udp]
listen = "127.0.0.1:8601"
[[source]]
name = "radar"
[source.live]
receiver = "lan"
[source.tracker]
emissions = ["finder"]
cues = true
output_period_s = 0.5
[[source.tracker.wide_area.type]]
name = "patrol"
[[source]]
name = "finder"
[source.live]
receiver = "ears"
[source.locator]
"#;

    #[test]
    fn links_are_heard_and_what_cannot_be_is_refused() {
        let parse = |text: &str| Config::parse(Path::new("t.toml"), text, &[]).map_err(|error| error.to_string());
        let config = parse(SITE).unwrap();
        let outputs = config.tracker(0).unwrap().outputs;
        assert_eq!((&config.sources[0].links.emissions[..], outputs.cues), (&[1][..], true));
        assert_eq!(outputs.period_ns, Some(500_000_000));
        for (old, new, line, expected) in [
            ("[\"finder\"]", "[\"radar\"]", 18, "there are: finder"),
            ("[\"finder\"]", "[\"finder\", \"finder\"]", 18, "named twice"),
            (
                "[[source.tracker.wide_area.type]]\nname = \"patrol\"\n",
                "",
                18,
                "no type is described",
            ),
            (
                "output_period_s = 0.5",
                "output_period_s = 0.0",
                20,
                "between 0.01 and 3600",
            ),
        ] {
            let message = parse(&SITE.replacen(old, new, 1)).unwrap_err();
            assert!(message.starts_with(&format!("t.toml:{line}: ")), "{new}: {message}");
            assert!(message.contains(expected) && message.lines().count() == 1, "{message}");
        }
        let recorded =
            SITE.replacen(
                "[source.live]\nreceiver = \"lan\"",
                "[source.recorded]\nfile = \"x.ast\"",
                1,
            )
            .replacen(
                "[[receiver]]\nname = \"lan\"\n[receiver.udp]\nlisten = \"127.0.0.1:8600\"\n",
                "",
                1,
            ) + "[time]\ndate = \"2026-05-10\"\n";
        let message = parse(&recorded).unwrap_err();
        assert!(message.contains("direction finders are live"), "{message}");
        let message = parse(&recorded.replacen("emissions = [\"finder\"]\n", "", 1)).unwrap_err();
        assert!(message.contains("looks nowhere"), "{message}");
    }
}
