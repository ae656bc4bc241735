use std::path::Path;

use deployment::{Input, PlotFormat, SampleDelivery};
use tracking::cutting::Boundaries;

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
name = "rows"
[receiver.udp]
listen = "127.0.0.1:8601"
[[source]]
name = "other"
[source.external]
[[tracker]]
name = "ship"
wait_s = 0.3
[[tracker.sensor]]
name = "radar"
period_s = 2.5
sac = 1
[tracker.sensor.live]
receiver = "lan"
sac = 1
sic = 2
[[tracker.sensor]]
name = "lidar"
[tracker.sensor.live]
receiver = "rows"
format = "rows"
sensor_id = 1
[[tracker.sensor]]
name = "camera"
detection_probability = 0.4
sigmas = [0.05]
[tracker.sensor.live]
receiver = "rows"
format = "rows"
sensor_id = 2
[[tracker.sensor]]
name = "sonar"
[tracker.sensor.external]
"#;

fn site() -> String {
    SITE.replacen("sac = 1\n[tracker", "[tracker", 1)
}

fn parse(text: &str) -> Result<Config, String> {
    Config::parse(Path::new("t.toml"), text, &[]).map_err(|error| error.to_string())
}

#[test]
fn a_tracker_is_a_source_behind_the_others_and_its_sensors_follow() {
    let config = parse(&site()).unwrap();
    let names: Vec<&str> = config.sources.iter().map(|source| source.name.as_str()).collect();
    assert_eq!(names, ["other", "ship"]);
    assert_eq!(config.adapters(), ["ship", "lan", "rows"]);
    let ship = &config.sources[1];
    let sensors = config.sensors_of(ship);
    let names: Vec<(u16, &str)> = sensors
        .iter()
        .map(|sensor| (sensor.number, sensor.name.as_str()))
        .collect();
    assert_eq!(
        names,
        [
            (2, "ship.radar"),
            (3, "ship.lidar"),
            (4, "ship.camera"),
            (5, "ship.sonar")
        ]
    );
    let rows = SampleDelivery::Plots {
        format: PlotFormat::Rows,
        sensor_id: Some(2),
    };
    assert_eq!(sensors[2].delivers, rows);
    assert!(ship.has_detections() && ship.has_tracks() && !sensors[0].has_tracks());
    assert!(matches!(sensors[3].input, Input::External));
    let tracker = config.tracker(1).unwrap();
    assert_eq!(tracker.sensor_ids(), [3, 4, 5, 6]);
    assert_eq!(tracker.joining.wait_ns, 300_000_000);
    let boundaries = tracker.joining.cutters.iter().map(|cutter| cutter.boundaries);
    let expected = [
        Boundaries::Turn,
        Boundaries::Stated,
        Boundaries::Stated,
        Boundaries::Stated,
    ];
    assert_eq!(boundaries.collect::<Vec<_>>(), expected);
    let camera = &tracker.settings.sensors[2];
    assert_eq!(
        (camera.model.detection_probability, &camera.sigmas),
        (Some(0.4), &Some(vec![0.05]))
    );
    assert_eq!(config.engine.sources.len(), 2);
}

#[test]
fn what_cannot_be_is_refused_with_line_key_and_remedy() {
    let site = site();
    for (old, new, line, expected) in [
        (
            "name = \"ship\"",
            "name = \"other\"",
            17,
            "tracker[0].name: \"other\" is also the name",
        ),
        (
            "receiver = \"lan\"",
            "receiver = \"wan\"",
            23,
            "tracker[0].sensor[0].live.receiver: there is no [[receiver]]",
        ),
        ("name = \"lidar\"", "name = \"radar\"", 20, "is the name of two sensors"),
        ("sensor_id = 2", "sensor_id = 1", 10, "give each a sensor_id of its own"),
        (
            "sac = 1\nsic = 2",
            "sensor_id = 4",
            24,
            "name a sensor of ASTERIX by sac and sic",
        ),
        (
            "format = \"rows\"\nsensor_id = 1",
            "format = \"autoferry\"",
            30,
            "is a format of files",
        ),
        ("[tracker.sensor.external]", "", 41, "needs exactly one of"),
        ("period_s = 2.5", "scans = \"stated\"", 21, "which ASTERIX has not"),
        (
            "receiver = \"rows\"",
            "receiver = \"lan\"",
            6,
            "rows and ASTERIX come to \"lan\"",
        ),
        ("wait_s = 0.3", "wait_s = -1", 18, "must lie between 0 and 3600"),
        (
            "wait_s = 0.3",
            "cues = true\nemissions = [\"other\"]",
            19,
            "no type is described",
        ),
        (
            "[tracker.sensor.external]",
            "[tracker.sensor.recorded]\nfile = \"x\"",
            17,
            "some sensors are recordings",
        ),
    ] {
        let message = parse(&site.replacen(old, new, 1)).unwrap_err();
        assert!(message.contains(expected), "{new}: {message}");
        assert!(message.lines().count() == 1, "{message}");
        let found = message.strip_prefix("t.toml:").and_then(|rest| rest.split(':').next());
        assert_eq!(found.and_then(|line| line.parse().ok()), Some(line), "{new}: {message}");
    }
}

#[test]
fn a_deployment_may_have_a_tracker_only_and_recorded_sensors() {
    let text = r#"name = "t"
[frame]
latitude_deg = 41.0
longitude_deg = 2.0
[time]
order = "time"
date = "2026-05-10"
[[tracker]]
name = "ferry"
[[tracker.sensor]]
name = "lidar"
[tracker.sensor.recorded]
file = "x.json"
format = "autoferry"
sensor_id = 1
"#;
    let config = parse(text).unwrap();
    assert!(config.is_recorded() && config.sources[0].input.is_recorded());
    assert_eq!(config.adapters(), ["ferry"]);
    assert!(
        parse(&text.replacen("date = \"2026-05-10\"\n", "", 1))
            .unwrap_err()
            .contains("time.date")
    );
}

const ON_BOARD: &str = "name = \"t\"\n[frame]\nlatitude_deg = 41.0\nlongitude_deg = 2.0\n\
    [[receiver]]\nname = \"rows\"\n[receiver.tcp]\nconnect = \"127.0.0.1:8601\"\n\
    [[platform]]\nname = \"ship\"\nwait_s = 1.5\n[platform.live]\nudp = { listen = \"127.0.0.1:10110\" }\n\
    [[platform]]\nname = \"boat\"\n[platform.recorded]\nfile = \"states.csv\"\n\
    [[tracker]]\nname = \"sea\"\n[[tracker.sensor]]\nname = \"radar\"\n\
    live = { receiver = \"rows\", format = \"rows\" }\n\
    [tracker.sensor.on_board]\nplatform = \"ship\"\nlever_arm_m = [20.0, 2.0, 15.0]\nbearings = \"north\"\n";

#[test]
fn a_sensor_on_board_names_its_platform() {
    let config = parse(ON_BOARD).unwrap();
    let sensor = &config.tracker_sensors[0];
    assert_eq!(sensor.on_board.unwrap().platform, Some(0));
    let reading = config.reading(sensor);
    let mount = reading.mount.unwrap();
    assert_eq!(mount.lever_arm_m, [20.0, 2.0, 15.0]);
    assert_eq!(mount.bearings, platform::Bearings::North);
    assert!(reading.model.is_on_board);
    assert_eq!(config.platforms[0].wait_ns, 1_500_000_000);
    let without = ON_BOARD.replace("platform = \"ship\"\n", "");
    assert_eq!(
        parse(&without).unwrap().tracker_sensors[0].on_board.unwrap().platform,
        None
    );
    let site = parse(&site()).unwrap();
    let at_rest = &site.tracker_sensors[0];
    assert!(at_rest.on_board.is_none() && !site.reading(at_rest).model.is_on_board);
    let ashore = &ON_BOARD[..ON_BOARD.find("[tracker.sensor.on_board]").unwrap()];
    let line = ON_BOARD.replace(
        "live = { receiver = \"rows\", format = \"rows\" }\n",
        "[tracker.sensor.simulated]\n",
    );
    let ship = line.replace(
        "live]\nudp = { listen = \"127.0.0.1:10110\" }",
        "simulated]\nroll_deg = 5.0",
    );
    let ship = ship.replace(
        "[[receiver]]\nname = \"rows\"\n[receiver.tcp]\nconnect = \"127.0.0.1:8601\"\n",
        "",
    );
    let simulated = parse(&ship).unwrap();
    assert!(simulated.is_simulated());
    assert_eq!(simulated.platforms[0].radar.as_deref(), Some("sea.radar"));
    for (text, from, to, expected) in [
        (
            ON_BOARD,
            "\"ship\"\nlever",
            "\"shop\"\nlever",
            "on_board.platform: \"shop\" is no [[platform]]; there are: ship, boat",
        ),
        (
            ON_BOARD,
            "\"ship\"\nlever",
            "\"boat\"\nlever",
            "a recorded platform carries recorded sensors",
        ),
        (
            ON_BOARD,
            ", format = \"rows\"",
            "",
            "needs range_sigma_m and azimuth_sigma_deg for a radar on board",
        ),
        (
            ashore,
            ", format = \"rows\"",
            "",
            "\"rows\" takes rows of detections only",
        ),
        (ON_BOARD, "lever_arm_m", "leaver_arm_m", "unknown key"),
        (
            &line,
            "127.0.0.1:8601",
            "127.0.0.1:8602",
            "is the radar of a simulated platform",
        ),
        (
            &ship,
            "platform = \"ship\"\n",
            "",
            "is the radar of a simulated platform",
        ),
    ] {
        let refusal = parse(&text.replace(from, to)).map(|_| ()).unwrap_err();
        assert!(refusal.contains(expected), "{expected}: {refusal}");
    }
}

#[test]
fn one_sensor_of_a_tracker_may_take_orders() {
    let with = |more: &str| parse(&(site() + more));
    let orders = "[[tracker.sensor]]\nname = \"operator\"\ndesignates = true\n[tracker.sensor.orders]\n";
    let config = with(orders).unwrap();
    let takes: Vec<bool> = config
        .tracker_sensors
        .iter()
        .map(|sensor| sensor.takes_orders)
        .collect();
    assert_eq!(takes, [false, false, false, false, true]);
    let ordered: Vec<bool> = config
        .engine
        .sources
        .iter()
        .map(|source| source.designates_round.is_some())
        .collect();
    assert_eq!(ordered, [false, true]);
    let refused = |more: &str, key: &str| {
        let said = with(more).unwrap_err();
        assert!(said.contains(key), "{said}");
    };
    let only = |text: &str| parse(&text.replacen("wait_s = 0.3", "wait_s = 0.3\nsettings.starts = \"designated\"", 1));
    assert!(only(&(site() + orders)).is_ok());
    assert!(only(&site()).unwrap_err().contains("starts"));
    refused(&orders.replacen("true", "false", 1), "designates");
    refused(&orders.replacen("true", "true\nscans = \"turn\"", 1), "scans");
    refused(
        &(orders.to_owned() + &orders.replacen("operator", "other", 1)),
        "orders",
    );
}
