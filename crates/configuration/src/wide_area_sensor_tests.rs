//! Wide-area sensors, heard and refused.

use std::path::Path;

use super::*;
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
name = "link"
[receiver.udp]
listen = "127.0.0.1:8601"
[[receiver]]
name = "centre-link"
[receiver.udp]
listen = "127.0.0.1:8602"
[[wide_area_sensor]]
name = "remote"
[wide_area_sensor.live]
receiver = "link"
[[wide_area_sensor]]
name = "centre"
[wide_area_sensor.tracks]
receiver = "centre-link"
period_s = 2.0
group_m = 300.0
sac = 1
sic = 9
limits = { range_m = 1e6 }
[[wide_area_sensor]]
name = "own"
[wide_area_sensor.external]
[[source]]
name = "radar"
[source.live]
receiver = "lan"
[source.tracker]
wide_area_sensors = ["centre", "remote"]
"#;

const RECORDED: &str = r#"name = "t"
[frame]
latitude_deg = 41.0
longitude_deg = 2.0
[time]
order = "time"
date = "2026-05-10"
[[wide_area_sensor]]
name = "remote"
[wide_area_sensor.recorded]
file = "remote.csv"
[[source]]
name = "radar"
[source.recorded]
file = "radar.ast"
[source.tracker]
wide_area_sensors = ["remote"]
"#;

fn parse(text: &str) -> Result<Config, String> {
    Config::parse(Path::new("t.toml"), text, &[]).map_err(|error| error.to_string())
}

#[test]
fn every_kind_is_heard_and_trackers_know_theirs() {
    let config = parse(SITE).unwrap();
    let of = |name: &str| config.wide_area_sensor(name).unwrap();
    assert!(matches!(&of("remote").input, WideAreaInput::Live(receiver) if receiver == "link"));
    assert_eq!(
        (of("remote").adapter.as_str(), of("own").adapter.as_str()),
        ("link", "own")
    );
    let WideAreaInput::Tracks(tracks) = &of("centre").input else {
        panic!("{:?}", of("centre"));
    };
    assert_eq!((tracks.period_ns, tracks.group_m), (2_000_000_000, 300.0));
    let model = config.readings.counted[usize::from(of("centre").number)].unwrap();
    assert_eq!((model.sac_sic, model.limits.range_m), (Some((1, 9)), 1e6));
    assert_eq!(tracks.feed, TrackFeed::Receiver("centre-link".to_owned()));
    assert_eq!(of("centre").recording(), None);
    let links = &config.sources[0].links;
    assert_eq!(links.wide_area_sensors, [0, 1], "in the order of their numbers");
    let config = parse(RECORDED).unwrap();
    assert_eq!(
        config.wide_area_sensors[0].recording(),
        Some(&PathBuf::from("remote.csv"))
    );
}

/// A simulated one sends rows of counts to a receiver of its own, and makes the deployment a simulated one.
#[test]
fn simulated_ones_bring_their_receiver_along() {
    let simulated = SITE.replacen(
        "[wide_area_sensor.external]",
        "[wide_area_sensor.simulated]\nperiod_s = 4.0\n[scenario]",
        1,
    );
    let config = parse(&simulated).unwrap();
    assert!(config.is_simulated());
    let sensor = config.wide_area_sensor("own").unwrap();
    let counting = &config.world.counting[..];
    let [(number, settings)] = counting else {
        panic!("{counting:?}")
    };
    assert_eq!(
        (*number, sensor.is_simulated, settings.period_s),
        (sensor.number, true, 4.0)
    );
    assert_eq!((sensor.receiver(), sensor.adapter.as_str()), (Some("own"), "own"));
    let receiver = config.receiver("own").unwrap();
    let is_own = matches!(
        receiver.transport,
        deployment::ReceiverTransport::Loopback { port: 31_003 }
    );
    assert!(is_own, "{:?}", receiver.transport);
    for (old, new, line, expected) in [
        ("\n[scenario]", "", 31, "there is no [scenario] to observe"),
        ("period_s = 4.0", "period_s = 0", 33, "must lie between 0.1 and 600"),
        ("period_s = 4.0", "every_s = 4.0", 33, "simulated.every_s: unknown key"),
        ("name = \"own\"", "name = \"lan\"", 31, "also the name of an adapter"),
    ] {
        let message = parse(&simulated.replacen(old, new, 1)).unwrap_err();
        assert!(message.starts_with(&format!("t.toml:{line}: ")), "{new}: {message}");
        assert!(message.contains(expected) && message.lines().count() == 1, "{message}");
    }
}

#[test]
fn what_cannot_be_is_refused_with_line_and_remedy() {
    let file = "[wide_area_sensor.tracks]\nfile = \"x.ast\"\n";
    for (text, old, new, line, expected) in [
        (
            SITE,
            "name = \"centre\"",
            "name = \"remote\"",
            22,
            "an earlier wide-area sensor",
        ),
        (
            SITE,
            "[\"centre\", \"remote\"]",
            "[\"centre\", \"far\"]",
            38,
            "there are: remote, centre, own",
        ),
        (
            SITE,
            "[\"centre\", \"remote\"]",
            "[\"own\", \"own\"]",
            38,
            "named twice",
        ),
        (
            SITE,
            "receiver = \"link\"",
            "receiver = \"lane\"",
            20,
            "there are: lan, link, centre-link",
        ),
        (
            SITE,
            "receiver = \"link\"",
            "receiver = \"lan\"",
            6,
            "alone behind its receiver",
        ),
        (
            SITE,
            "[wide_area_sensor.external]\n",
            "",
            31,
            "needs exactly one of [wide_area_sensor.live]",
        ),
        (SITE, "sic = 9\n", "", 23, "give both or neither"),
        (SITE, "period_s = 2.0", "period_s = 0.0", 25, "between 0.1 and 600"),
        (
            SITE,
            "receiver = \"centre-link\"\n",
            "",
            23,
            "either receiver (live) or file",
        ),
        (
            SITE,
            "limits = { range_m = 1e6 }",
            "limits = { range_m = 0 }",
            29,
            "range_m: 0 is out of range",
        ),
        (
            SITE,
            "name = \"own\"",
            "name = \"lan\"",
            31,
            "also the name of an adapter",
        ),
        (
            SITE,
            "[wide_area_sensor.external]\n",
            "[wide_area_sensor.external]\nport = 1\n",
            33,
            "external.port: unknown key; there are: none",
        ),
        (
            RECORDED,
            "[wide_area_sensor.recorded]\nfile = \"remote.csv\"\n",
            "[wide_area_sensor.external]\n",
            16,
            "times are of different days",
        ),
        (
            RECORDED,
            "[source.tracker]\n",
            "[[wide_area_sensor]]\nname = \"more\"\n[wide_area_sensor.external]\n[source.tracker]\n",
            17,
            "all sources are recordings",
        ),
        (
            SITE,
            "[wide_area_sensor.external]\n",
            file,
            31,
            "no source is a recording",
        ),
    ] {
        assert!(text.contains(old), "{old}");
        let message = parse(&text.replacen(old, new, 1)).unwrap_err();
        assert!(message.starts_with(&format!("t.toml:{line}: ")), "{new}: {message}");
        assert!(message.contains(expected) && message.lines().count() == 1, "{message}");
    }
}
