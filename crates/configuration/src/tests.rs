//! Configurations that must be read, and mistakes that must be named.

use deployment::{Input, ReportOrder};
use reception::Method;

use super::*;

fn barcelona() -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/barcelona.toml")).unwrap()
}

fn refused(text: &str) -> String {
    Config::parse(Path::new("test.toml"), text, &[])
        .unwrap_err()
        .to_string()
}

/// The Barcelona configuration with one line replaced, and the number of that line.
fn with_line(old: &str, new: &str) -> (String, usize) {
    let text = barcelona();
    let at = text.find(old).unwrap_or_else(|| panic!("no {old}"));
    (text.replacen(old, new, 1), text[..at].matches('\n').count() + 1)
}

#[test]
fn the_shipped_configurations_are_sound() {
    let demo = Config::read(Path::new(BUILT_IN_DEMO), &[]).unwrap();
    assert!(demo.sources.len() >= 3 && !demo.is_recorded() && demo.order == ReportOrder::Arrival);
    assert!(demo.world.targets.as_ref().unwrap().targets >= 60);
    let barcelona = Config::parse(Path::new("barcelona.toml"), &barcelona(), &[]).unwrap();
    assert!(barcelona.is_recorded() && barcelona.order == ReportOrder::Time);
    assert_eq!(barcelona.first_day_ns, Some(16_931 * 86_400 * 1_000_000_000));
    assert_eq!(barcelona.source("ads-b").unwrap().number, 2);
}

#[test]
fn a_link_that_others_can_reach_says_who_they_are() {
    let read = |lines: &str| {
        let text = format!("{}\n[[link]]\nname = \"out\"\n{lines}", barcelona());
        Config::parse(Path::new("site/test.toml"), &text, &[]).map_err(|error| error.to_string())
    };
    let local = "listen = [\"tcp/127.0.0.1:7447\"]";
    let tls = "listen = [\"tls/[::]:7447\"]\nauthority = \"a\"\ncertificate = \"b\"\nprivate_key = \"c\"";
    let peer = "[[link.peer]]\nname = \"centre\"";
    let unsent = format!("{tls}\n{peer}\nread = [\"health\"]");
    let receive = "[[link.receive]]\ndeployment = \"west\"\ntopic = \"sensor/a/tracks\"\ninto = \"sensor/a/tracks\"";
    let more = "[[source]]\nname = \"a\"\n[source.external]\n";
    let foreign = format!("{tls}\n{peer}\n{receive}\n{more}");
    let cases = [
        ("", "meets nobody"),
        ("listen = [\"7447\"]", "is no endpoint"),
        ("listen = [\"tcp/0.0.0.0:7447\"]", "can be reached from other machines"),
        (
            "listen = [\"tls/[::]:7447\"]",
            "needs authority, certificate and private_key",
        ),
        (&format!("{local}\nuser = \"me\""), "user and password_file go together"),
        (&format!("{local}\nsend = [\"nonsense\"]"), "is no topic"),
        (
            &format!("{local}\nsend = [\"system/own-tracks\"]"),
            "needs fusion.exchange",
        ),
        (&format!("{local}\n{peer}"), "nobody can be told from others"),
        (&unsent, "\"health\" is not sent"),
        (&foreign, "no [[link.peer]] may give the topics of \"west\""),
    ];
    for (lines, said) in cases {
        let error = read(lines).unwrap_err();
        assert!(error.contains(said), "{lines}: {error}");
    }
    let link = &read(&format!("{tls}\n{peer}")).unwrap().links[0];
    assert_eq!(link.authority.as_deref(), Some("site/a"), "beside the configuration");
    assert_eq!(
        (link.peers[0].name.as_str(), link.peers[0].read(link)),
        ("centre", link.send.as_slice())
    );
    let giver = format!("{tls}\n{peer}\ndeployment = \"west\"\n{receive}\n{more}");
    assert_eq!(read(&giver).unwrap().links[0].peers[0].gives(), "west");
}

#[test]
fn regions_lie_in_the_system_frame_and_mistakes_in_them_are_named() {
    let region = |name: &str, origin: u32, east: [f64; 2]| {
        let [west, east] = east;
        format!(
            "[[region]]\nname = \"{name}\"\norigin = {origin}\n\
             corners_deg = [[41.0, {west}], [41.0, {east}], [42.0, {east}], [42.0, {west}]]\n"
        )
    };
    let read = |regions: &str, overrides: &[&str]| {
        let text = format!("{}\n{regions}", barcelona());
        let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
        Config::parse(Path::new("barcelona.toml"), &text, &overrides).map_err(|error| error.to_string())
    };
    let exchange = ["origin=1", "fusion.exchange=true"];
    let (west, east) = (region("west", 1, [1.0, 2.0]), region("east", 2, [2.0, 3.0]));
    let found = read(&format!("{west}{east}"), &exchange).unwrap();
    let regions = &found.engine.border.regions;
    assert_eq!([regions[0].is_own, regions[1].is_own], [true, false]);
    // The airport lies near 2.08 degrees east.
    assert!(regions[1].contains([0.0, 0.0]) && !regions[0].contains([0.0, 0.0]));
    assert!((regions[0].distance_m([0.0, 0.0]) - 6_600.0).abs() < 600.0);
    let cases = [
        (format!("{west}{east}"), &exchange[..1], "needs fusion.exchange = true"),
        (
            format!("{west}{}", region("east", 2, [1.9, 3.0])),
            &exchange,
            "overlaps \"west\"",
        ),
        (
            format!("{west}{}", region("west", 2, [2.0, 3.0])),
            &exchange,
            "earlier region",
        ),
        (east, &exchange, "would own no target"),
        (west.replace("[41.0, 1], [41.0, 2], ", ""), &exchange, "2 corners"),
        (west.replace("42.0", "142.0"), &exchange, "not between -90"),
    ];
    for (regions, overrides, said) in cases {
        let error = read(&regions, overrides).unwrap_err();
        assert!(error.contains(said), "{regions}: {error}");
    }
}

#[test]
fn pressures_have_regions_and_times_and_mistakes_in_them_are_named() {
    let read = |table: &str| {
        let text = format!("{}\n[[qnh]]\nname = \"port\"\n{table}", barcelona());
        Config::parse(Path::new("barcelona.toml"), &text, &[]).map_err(|error| error.to_string())
    };
    let corners = "corners_deg = [[41.0, 2.0], [41.0, 3.0], [42.0, 3.0], [42.0, 2.0]]";
    let later = "later = [{ from = \"2016-05-10T06:00:00Z\", hpa = 1009.0 }]";
    let found = read(&format!("hpa = 1005.5\n{corners}\n{later}\ntransition_level = 70")).unwrap();
    let regional = &found.engine.qnh[0];
    assert!(regional.region.as_ref().unwrap().contains([0.0, 0.0]));
    assert_eq!(regional.transition_level, 70);
    assert_eq!(
        regional.readings,
        [(i64::MIN, 1005.5), (1_462_860_000_000_000_000, 1009.0)]
    );
    let twice =
        "later = [{ from = \"2016-05-10T06:00:00Z\", hpa = 1e3 }, { from = \"2016-05-10T06:00:00Z\", hpa = 1e3 }]";
    for (table, said) in [
        ("hpa = 29.92", "qnh[0].hpa"),
        ("hpa = 1000\ntransition_level = 6000", "qnh[0].transition_level"),
        ("hpa = 1000\ncorners_deg = [[41.0, 2.0]]", "1 corners"),
        (
            "hpa = 1000\nlater = [{ from = \"6:00\", hpa = 1000 }]",
            "\"6:00\" is not a time",
        ),
        (&format!("hpa = 1000\n{twice}"), "not later than the time before"),
        ("hpa = 1000\n[[qnh]]\nname = \"port\"\nhpa = 1000", "earlier table"),
    ] {
        let error = read(table).unwrap_err();
        assert!(error.contains(said), "{table}: {error}");
    }
}

#[test]
fn sensors_and_deployments_have_an_identity() {
    let named = Config::parse(Path::new("barcelona.toml"), &barcelona(), &[]).unwrap();
    let radar = named.source("radar").unwrap();
    assert_eq!((radar.uid, named.origin), (messages::sensor_uid("radar"), 0));
    let overrides = ["source[0].uid=77".to_owned(), "origin=3".to_owned()];
    let numbered = Config::parse(Path::new("barcelona.toml"), &barcelona(), &overrides).unwrap();
    let weighed = &numbered.engine.sources[0];
    assert_eq!(
        (numbered.sources[0].uid, weighed.sensor_uid, numbered.origin),
        (77, 77, 3)
    );
}

#[test]
fn mistakes_are_named_with_file_line_value_and_remedy() {
    let cases = [
        ("sensor_tracks = 4000", "sensor_tracks = 0", "must lie between 1 and"),
        ("priority = 3", "uid = 0", "uid: 0 is out of range"),
        ("priority = 3", "prioritty = 3", "priority"),
        (
            "name = \"ads-b\"",
            "name = \"radar\"",
            "is the name of an earlier source",
        ),
        (
            "latitude_deg = 41.295618",
            "latitude_deg = 141.0",
            "not between -90° and 90°",
        ),
        ("wait = \"event\"", "wait = \"sleep\"", "there are: event, spin, hybrid"),
        (
            "name = \"auto\"",
            "name = \"beste-quelle\"",
            "there are: auto, system-filter, best-source",
        ),
        (
            "\"21\" = \"0.23\"",
            "\"21\" = \"9.9\"",
            "there are: CAT021 ed 2.4, CAT021 ed 2.1, ",
        ),
        (
            "\"21\" = \"0.23\"",
            "\"22\" = \"1.0\"",
            "there are: CAT001 ed 1.4, CAT002 ed 1.2, ",
        ),
        (
            "period_s = 1.0",
            "period_s = \"1 s\"",
            "\"1 s\" is no number; write the number alone",
        ),
        (
            "reorder_s = 0.5",
            "truncated = \"yes\"",
            "\"yes\" is not known; there are: refuse, accept",
        ),
        ("date = \"2016-05-10\"", "date = \"10.5.2016\"", "year-month-day"),
        ("sic = 7", "", "give both or neither"),
        ("speed_mps = 120.0", "speed_mps = nan", "must lie between"),
    ];
    for (old, new, expected) in cases {
        let (text, line) = with_line(old, new);
        let message = refused(&text);
        assert!(message.contains(expected), "{new}: {message}");
        assert!(message.starts_with("test.toml:"), "{new}: {message}");
        assert_eq!(message.lines().count(), 1, "one line: {message}");
        if !new.is_empty() {
            assert!(
                message.starts_with(&format!("test.toml:{line}: ")),
                "line {line}: {message}"
            );
        }
    }
}

#[test]
fn every_option_of_weighing_can_be_set_and_its_mistakes_are_named() {
    let options = "name = \"best-source\"\nhysteresis = 0.8\nhold_refreshes = 2\noverdue_periods = 2.0\n\
                   quality_scans = 6\nintersection = \"trace\"\ncommon_noise_m2ps3 = 4.0\n\
                   [fusion.rule.hand_over]\nramp = [0.2, 0.6]\nby_traces = true\ndrop_out = \"blend\"\n\
                   [[fusion.rule.hand_over.pair]]\nfrom = \"radar\"\nto = \"ads-b\"\nramp = [0.45]\n\
                   [fusion.rule.mosaic]\ncell_m = 2000.0\ndefault = [\"ads-b\", \"radar\"]\n\
                   [[fusion.rule.mosaic.cell]]\neast = 1\nnorth = -1\nsources = [\"radar\"]\n\
                   [[fusion.rule.mosaic.cell]]\neast = 0\nnorth = 0\nsources = [\"multilateration\"]";
    let (text, first_line) = with_line("name = \"auto\"", options);
    let rule = Config::parse(Path::new("test.toml"), &text, &[]).unwrap().engine.rule;
    assert_eq!((rule.hysteresis, rule.hold_refreshes), (0.8, 2));
    assert_eq!((rule.overdue_periods, rule.quality_scans), (2.0, 6));
    assert_eq!(rule.intersection, fusion_settings::Intersection::Trace);
    assert_eq!(rule.common_noise_m2ps3, Some(4.0));
    let hand_over = &rule.hand_over;
    assert_eq!((&hand_over.ramp[..], hand_over.by_traces), (&[0.2, 0.6][..], true));
    assert_eq!(hand_over.drop_out, fusion_settings::DropOut::Blend);
    assert_eq!((hand_over.pairs[0].from.number, hand_over.pairs[0].to.number), (0, 2));
    let default: Vec<u16> = rule.mosaic.default.iter().map(|source| source.number).collect();
    assert_eq!((rule.mosaic.cell_m, &default[..]), (2000.0, &[2, 0][..]));
    let cells: Vec<_> = rule
        .mosaic
        .cells
        .iter()
        .map(|cell| (cell.east, cell.sources[0].number))
        .collect();
    assert_eq!(cells, [(0, 1), (1, 0)], "sorted");

    for (old, new, expected) in [
        (
            "to = \"ads-b\"",
            "to = \"adsb\"",
            "there are: radar, multilateration, ads-b",
        ),
        (
            "default = [\"ads-b\", \"radar\"]",
            "default = [\"lidar\"]",
            "no source named \"lidar\"",
        ),
        (
            "sources = [\"radar\"]",
            "sources = [\"sonar\"]",
            "no source named \"sonar\"",
        ),
        ("east = 0\nnorth = 0", "east = 1\nnorth = -1", "has been given before"),
        ("ramp = [0.2, 0.6]", "ramp = [0.6, 0.2]", "a ramp must rise"),
        ("ramp = [0.45]", "ramp = [1.5]", "must lie between 0 and 1"),
        ("hysteresis = 0.8", "hysteresis = 1.8", "must lie between"),
        ("quality_scans = 6", "quality_scans = 1", "must lie between 2 and 64"),
        (
            "drop_out = \"blend\"",
            "drop_out = \"mix\"",
            "\"mix\" is not known; there are: switch, blend",
        ),
        (
            "intersection = \"trace\"",
            "intersektion = \"trace\"",
            "fusion.rule.intersektion: unknown key",
        ),
    ] {
        assert!(text.contains(old), "{old}");
        let message = refused(&text.replacen(old, new, 1));
        assert!(message.contains(expected), "{new}: {message}");
        let line = text[..text.find(old).unwrap()].matches('\n').count() + 1;
        assert!(
            line > first_line && message.starts_with(&format!("test.toml:{line}: ")),
            "line {line}: {message}"
        );
    }
}

#[test]
fn what_is_missing_is_named() {
    assert!(refused("name = \"x\"\n").contains("frame: missing; the key is mandatory"));
    let frame = "name = \"x\"\n[frame]\nlatitude_deg = 1.0\nlongitude_deg = 2.0\n";
    assert!(refused(frame).contains("at least one"));
    let bare = format!("{frame}[[source]]\nname = \"a\"\n");
    assert!(refused(&bare).contains("exactly one of"));
    let unobserved = format!("{bare}[source.simulated]\nkind = \"radar\"\n");
    assert!(refused(&unobserved).contains("no [scenario]"));
}

#[test]
fn overrides_replace_values_and_are_checked_too() {
    let read = |overrides: &[&str]| {
        let overrides: Vec<String> = overrides.iter().map(|each| (*each).to_owned()).collect();
        Config::parse(Path::new("test.toml"), &barcelona(), &overrides)
    };
    assert!(read(&[]).unwrap().engine.association.use_identity);
    let hidden = read(&["fusion.association.use_identity=false", "source[1].fresh_s=5"]).unwrap();
    assert!(!hidden.engine.association.use_identity);
    assert_eq!(hidden.engine.sources[1].fresh_ns, 5_000_000_000);
    assert!(
        read(&["fusion.nonsense=1"])
            .unwrap_err()
            .to_string()
            .contains("fusion.nonsense: unknown key")
    );
    assert!(
        read(&["source[9].name=x"])
            .unwrap_err()
            .to_string()
            .contains("there is no source[9]")
    );
    assert!(
        read(&["no assignment"])
            .unwrap_err()
            .to_string()
            .contains("key.path=value")
    );
}

#[test]
fn heights_that_a_radar_needs_have_defaults_and_limits() {
    let model = |text: &str| {
        Config::parse(Path::new("test.toml"), text, &[])
            .unwrap()
            .readings
            .sources[0]
            .model
    };
    let default = model(&barcelona());
    assert_eq!((default.assumed_height_m, default.qnh_hpa), (5000.0, 1013.25));
    let (given, _) = with_line(
        "priority = 3",
        "priority = 3\nassumed_height_m = 800.0\nqnh_hpa = 1021.0",
    );
    assert_eq!((model(&given).assumed_height_m, model(&given).qnh_hpa), (800.0, 1021.0));
    let (inches, _) = with_line("priority = 3", "qnh_hpa = 29.92");
    assert!(
        refused(&inches).contains("must lie between 850 and 1100"),
        "{}",
        refused(&inches)
    );
}

fn live() -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/live.toml")).unwrap()
}

#[test]
fn sensors_behind_one_socket_share_an_adapter() {
    let config = Config::parse(Path::new("live.toml"), &live(), &[]).unwrap();
    assert_eq!(config.adapters(), ["radars", "surface", "transponders"]);
    assert!(!config.is_recorded() && !config.is_simulated());
    let demo = Config::read(Path::new(BUILT_IN_DEMO), &[]).unwrap();
    assert_eq!(demo.adapters().len(), demo.sources.len());
    assert_eq!(
        demo.receivers.len(),
        demo.sources.len(),
        "each simulated sensor has a socket"
    );
}

#[test]
fn an_external_source_has_a_topic_and_no_adapter() {
    let text = "name = \"site\"\n[frame]\nlatitude_deg = 0.0\nlongitude_deg = 0.0\n\
                [[source]]\nname = \"radar\"\n[source.external]\n";
    let parsed = |text: &str| Config::parse(Path::new("site.toml"), text, &[]);
    let config = parsed(text).unwrap();
    assert!(matches!(config.sources[0].input, Input::External));
    assert_eq!(config.adapters(), [""; 0]);
    assert!(!config.is_recorded() && !config.is_simulated());
    let ordered = format!("{text}[time]\norder = \"time\"\n");
    assert!(parsed(&ordered).unwrap_err().to_string().contains("time.order"));
    let both = format!("{text}[source.simulated]\nkind = \"radar\"\n");
    assert!(parsed(&both).is_err());
}

#[test]
fn mistakes_in_networks_are_named_with_line_value_and_remedy() {
    let cases = [
        (
            "\"239.255.48.1:8600\"",
            "\"radar:8600\"",
            "write the multicast group or this machine's address",
        ),
        ("\"239.255.48.1:8600\"", "\"239.255.48.1:0\"", "port 0 is no port"),
        ("interface = \"127.0.0.1\"\nsenders", "senders", "name the interface"),
        ("\"127.0.0.0/8\"", "\"127.0.0.0/88\"", "127.0.0.0/88"),
        (
            "buffer_bytes = 4194304",
            "buffer_bytes = 1",
            "buffer_bytes: 1 is out of range",
        ),
        (
            "receiver = \"radars\"",
            "receiver = \"radar\"",
            "radars, surface, transponders",
        ),
        ("sic = 2\n", "sic = 1\n", "could not be told apart"),
        ("sic = 2\n", "", "sac and sic go together"),
        ("\"48\" = \"1.31\"", "\"48\" = \"9.9\"", "CAT048 ed 1.31"),
        (
            "name = \"transponders\"",
            "name = \"surface\"",
            "is the name of an earlier receiver",
        ),
        (
            "receiver = \"transponders\"",
            "receiver = \"surface\"",
            "no source has [source.live]",
        ),
    ];
    for (old, new, expected) in cases {
        let text = live();
        assert!(text.contains(old), "{old}");
        let message = refused(&text.replacen(old, new, 1));
        assert!(message.starts_with("test.toml:"), "{message}");
        assert!(message.contains(expected), "{message}");
    }
    // One sensor is two sources where each takes other reports of it.
    let north = |method: &str| live().replacen("sic = 2\n", &format!("sic = 1\nmethod = \"{method}\"\n"), 1);
    assert!(refused(&north("primary")).contains("could not be told apart"));
    let both = north("primary").replacen("sic = 1\n", "sic = 1\nmethod = \"secondary\"\n", 1);
    let config = Config::parse(Path::new("test.toml"), &both, &[]).unwrap();
    let methods = |method| {
        config
            .readings
            .sources
            .iter()
            .filter(|reading| reading.model.method == method)
            .count()
    };
    assert_eq!([Method::Primary, Method::Secondary].map(methods), [1, 1]);
    let timed = format!("{}\n[time]\norder = \"time\"\n", live());
    assert!(refused(&timed).contains("use \"arrival\""));
}

#[test]
fn bearings_come_from_a_socket_or_a_simulated_finder() {
    let frame = "name = \"x\"\n[frame]\nlatitude_deg = 1.0\nlongitude_deg = 2.0\n[scenario]\n";
    let receiver = "[[receiver]]\nname = \"lan\"\n[receiver.udp]\nlisten = \"127.0.0.1:8700\"\n";
    let live = "[[source]]\nname = \"a\"\n[source.live]\nreceiver = \"lan\"\n";
    let finder = "[[source]]\nname = \"b\"\n[source.simulated_direction_finder]\n";
    let locator = "[source.locator]\n[source.locator.motion]\nfilter = \"fixed\"\n";
    let text = format!("{frame}{receiver}{live}{locator}{finder}");
    let config = Config::parse(Path::new("test.toml"), &text, &[]).unwrap();
    let filters = [0, 1].map(|source| config.locator(source).map(|locator| locator.motion.filter));
    use ::locating::settings::FilterChoice;
    assert_eq!(filters, [Some(FilterChoice::Fixed), Some(FilterChoice::Auto)]);
    assert!(config.is_simulated());
    let probability = |source: usize| config.engine.sources[source].coverage.as_ref().unwrap().probability;
    assert_eq!([0, 1].map(probability), [0.0; 2], "silence says nothing");
    for (text, expected) in [
        (format!("{frame}{finder}speed_mps = 1.0\n"), "speed_mps"),
        (
            format!("{frame}{finder}{locator}speed_sigma_mps = -1.0\n"),
            "source[0].locator.motion.speed_sigma_mps",
        ),
        (
            format!("{frame}{receiver}{live}{locator}[source.tracker]\n"),
            "leave one of locator and tracker out",
        ),
        (
            format!("{frame}[[source]]\nname = \"a\"\n[source.external]\n{locator}"),
            "[source.simulated_direction_finder]",
        ),
        (
            format!("{frame}{receiver}{live}{locator}{}", live.replace("\"a\"", "\"c\"")),
            "tables of bearings are of one source, but 2",
        ),
    ] {
        let message = refused(&text);
        assert!(message.contains(expected) && message.lines().count() == 1, "{message}");
    }
}
