//! Keys of gateways, and mistakes in them.

use std::path::Path;

use configuration::ConfigWith;

use crate::settings::{GatewayContent, Keys};

type Config = ConfigWith<Keys>;

const SITE: &str = include_str!("../../../config/live.toml");

fn refused(text: &str) -> String {
    let read = Config::parse(Path::new("test.toml"), text, &[]);
    read.unwrap_err().to_string()
}

#[test]
fn a_gateway_sends_the_fused_picture_by_default() {
    let config = Config::parse(Path::new("live.toml"), SITE, &[]).unwrap();
    let gateway = config.parts.gateway("picture").unwrap();
    assert_eq!(gateway.table().unwrap().number, 62);
    assert!(matches!(gateway.content(&config), Ok(GatewayContent::Fused)));
    let output = &config.services.gateways[0];
    assert_eq!(
        (output.name.as_str(), output.sender.as_ref().unwrap().send_to),
        ("picture", gateway.send_to.unwrap().0)
    );
}

#[test]
fn the_time_to_live_of_a_gateway_reaches_its_sender() {
    let sender = |overrides: &[String]| {
        let config = Config::parse(Path::new("live.toml"), SITE, overrides).unwrap();
        config.services.gateways[0].sender.clone().unwrap()
    };
    assert_eq!(sender(&[]).ttl, None);
    assert_eq!(sender(&["gateway[0].ttl=7".to_owned()]).ttl, Some(7));
    let refused = Config::parse(Path::new("live.toml"), SITE, &["gateway[0].ttl=0".to_owned()]);
    let refused = refused.unwrap_err().to_string();
    assert!(refused.contains("gateway[0].ttl"), "{refused}");
}

#[test]
fn a_gateway_to_another_centre_needs_what_the_sensors_here_know() {
    let read = |overrides: &[&str]| {
        let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
        Config::parse(Path::new("live.toml"), SITE, &overrides).map_err(|error| error.to_string())
    };
    let own = "gateway[0].own=true";
    let config = read(&[own, "fusion.exchange=true"]).unwrap();
    assert!(matches!(
        config.parts.gateways[0].content(&config),
        Ok(GatewayContent::Own)
    ));
    assert!(read(&[own]).unwrap_err().contains("needs fusion.exchange = true"));
    let source = ["gateway[0].source=\"radar-north\"", "gateway[0].category=48"];
    let both = read(&[own, "fusion.exchange=true", source[0], source[1]]).unwrap_err();
    assert!(both.contains("leave one of the two out"), "{both}");
}

#[test]
fn a_gateway_may_send_a_part_of_the_picture() {
    let with = |lines: &str| {
        let text = SITE.replace("refresh_s = 1.0 ", &format!("{lines}\nrefresh_s = 1.0 "));
        Config::parse(Path::new("live.toml"), &text, &[]).map_err(|error| error.to_string())
    };
    let config =
        with("area = { south_deg = 41.0, north_deg = 42.0, west_deg = 179.0, east_deg = -179.0 }\nstatus = [63]");
    let config = config.unwrap();
    let gateway = config.parts.gateway("picture").unwrap();
    let area = gateway.area.unwrap();
    assert_eq!([area.west_deg, area.east_deg], [179.0, -179.0]);
    assert_eq!((gateway.status.as_slice(), gateway.levels), (&[63][..], None));
    for (lines, expected) in [
        ("status = [62]", "62: status messages are of category 65 or 63"),
        ("levels = [200.0, 100.0]", "write the lower level first"),
        (
            "area = { south_deg = 43.0, north_deg = 42.0, west_deg = 1.0, east_deg = 2.0 }",
            "lies north of north_deg",
        ),
        (
            "area = { south_deg = 1.0, north_deg = 2.0, west_deg = 1.0, east_deg = 200.0 }",
            "between -180 and 180",
        ),
    ] {
        let said = with(lines).unwrap_err();
        assert!(said.contains(expected), "{said}");
    }
    let text = SITE.replace("refresh_s = 1.0 ", "levels = [0.0, 100.0]\nrefresh_s = 0.0 ");
    let said = Config::parse(Path::new("live.toml"), &text, &[])
        .unwrap_err()
        .to_string();
    assert!(said.contains("give a period"), "{said}");
}

#[test]
fn mistakes_are_named_with_line_value_and_remedy() {
    let cases = [
        ("\"239.255.62.1:8610\"", "\"everyone\"", "as in \"239.1.2.3:8610\""),
        ("edition = \"1.18\"", "edition = \"0.1\"", "CAT062 ed 1.18"),
        (
            "edition = \"1.18\"",
            "source = \"radar-north\"",
            "category 10, 20, 21 or 48",
        ),
        (
            "edition = \"1.18\"",
            "source = \"radar\"\ncategory = 48",
            "there is no source named \"radar\"",
        ),
        ("edition = \"1.18\"", "category = 48", "give a source"),
        ("block_bytes = 1472", "block_bytes = 10", "must lie between 256 and"),
        (
            "name = \"picture\"",
            "name = \"radars\"",
            "is the name of an adapter process",
        ),
    ];
    for (old, new, expected) in cases {
        assert!(SITE.contains(old), "{old}");
        let message = refused(&SITE.replacen(old, new, 1));
        assert!(message.starts_with("test.toml:"), "{message}");
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn a_cue_outlet_needs_one_way_out_and_a_source_with_cues() {
    let read = |keys: &str| {
        let text = SITE.replace("[source.tracker]", "[source.tracker]\ncues = true");
        let with_tracker = match text.contains("[source.tracker]") {
            true => text,
            false => SITE.replacen(
                "[source.covariance]",
                "[source.tracker]\ncues = true\n[source.covariance]",
                1,
            ),
        };
        let text = format!("{with_tracker}\n[[cue_outlet]]\nname = \"looks\"\n{keys}");
        Config::parse(Path::new("live.toml"), &text, &[]).map_err(|error| error.to_string())
    };
    let source = "source = \"radar-north\"\n";
    let config = read(&format!("{source}listen = \"127.0.0.1:8620\"\n")).unwrap();
    let output = config.services.gateways.last().unwrap();
    assert_eq!((output.name.as_str(), &output.sender), ("looks", &None));
    assert!(config.parts.cue_outlet("looks").is_some() && config.parts.gateway("looks").is_none());
    let config = read(&format!(
        "{source}send_to = \"239.1.2.3:8620\"\ninterface = \"127.0.0.1\"\nttl = 3\n"
    ))
    .unwrap();
    let sender = config.services.gateways.last().unwrap().sender.clone().unwrap();
    assert_eq!(sender.ttl, Some(3));
    for (keys, expected) in [
        (source.to_owned(), "give either send_to (datagrams) or listen"),
        (
            format!("{source}send_to = \"239.1.2.3:1\"\nlisten = \"127.0.0.1:1\"\n"),
            "give either send_to",
        ),
        (
            format!("{source}listen = \"127.0.0.1:8620\"\nttl = 3\n"),
            "cue_outlet[0].ttl",
        ),
        (
            format!("{source}listen = \"0.0.0.0:8620\"\n"),
            "0.0.0.0:8620 can be reached from other machines",
        ),
        (
            "source = \"nobody\"\nlisten = \"127.0.0.1:8620\"\n".to_owned(),
            "there is no source named \"nobody\"",
        ),
        (
            "source = \"radar-south\"\nlisten = \"127.0.0.1:8620\"\n".to_owned(),
            "\"radar-south\" makes no cues",
        ),
    ] {
        let refused = read(&keys).unwrap_err();
        assert!(refused.contains(expected), "{refused}");
    }
}

#[test]
fn cursor_on_target_has_keys_of_its_own() {
    let read = |keys: &[&str]| {
        let site = "name = \"site\"\n[frame]\nlatitude_deg = 1.0\nlongitude_deg = 2.0\n";
        let source = "[[source]]\nname = \"own\"\nperiod_s = 1.0\n[source.external]\n";
        let text = format!("{site}{source}[[gateway]]\nname = \"tak\"\n{}\n", keys.join("\n"));
        Config::parse(Path::new("test.toml"), &text, &[])
    };
    let [cot, to, at] = [
        "format = \"cot\"",
        "send_to = \"127.0.0.1:6969\"",
        "listen = \"127.0.0.1:8087\"",
    ];
    let sender = |keys: &[&str]| read(keys).unwrap().services.gateways[0].sender.is_some();
    assert!(sender(&[cot, to]));
    assert!(!sender(&[cot, at]));
    for address in ["0.0.0.0", "[::]", "192.0.2.7"] {
        let public = format!("listen = \"{address}:8087\"");
        let refused = read(&[cot, &public]).unwrap_err().to_string();
        assert!(refused.contains("permit it by remote = true beside it"), "{refused}");
        assert!(!sender(&[cot, &public, "remote = true"]));
    }
    for (keys, part) in [
        (&[cot][..], "give either send_to"),
        (&[cot, to, at], "give either send_to"),
        (&[cot, at, "ttl = 3"], "ttl: is about datagrams"),
        (&[cot, to, "remote = true"], "remote: is about clients that connect"),
        (&[cot, to, "sac = 1"], "sac: is for ASTERIX"),
        (
            &[cot, to, "target_identification = true"],
            "target_identification: is for ASTERIX",
        ),
        (
            &[cot, to, "refresh_s = 40.0"],
            "stale_s: must be longer than refresh_s, 40",
        ),
        (&[cot, to, "levels = [9.0, 1.0]"], "write the lower level first"),
        (&[at, "sac = 1", "sic = 2"], "listen: is for format = \"cot\""),
        (&[to, "sac = 1"], "sic: must be given for ASTERIX"),
    ] {
        let refused = read(keys).unwrap_err().to_string();
        assert!(refused.contains(part), "{keys:?}: {refused}");
    }
}
