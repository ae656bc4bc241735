//! Keys of a display, and mistakes in them.

use std::path::Path;

use configuration::ConfigWith;

use crate::settings::Keys;

type Config = ConfigWith<Keys>;

/// A deployment without a display.
fn site() -> &'static str {
    let text = include_str!("../../../config/barcelona.toml");
    text.split_once("\n[display]").unwrap().0
}

#[test]
fn a_display_that_others_can_reach_must_be_asked_for_and_has_a_token() {
    let read = |lines: &str| {
        let text = format!("{}\n[display]\n{lines}", site());
        Config::parse(Path::new("test.toml"), &text, &[]).map_err(|error| error.to_string())
    };
    let token = "token = \"0123456789abcdef\"";
    let cases = [
        (
            "listen = \"8900\"",
            "display.listen: \"8900\" is no address with a port",
        ),
        (
            "listen = \"0.0.0.0:8900\"",
            "display.listen: 0.0.0.0:8900 can be reached from other machines",
        ),
        (&format!("listen = \"[::]:8900\"\n{token}"), "nothing is encrypted"),
        (
            "listen = \"192.0.2.1:8900\"\ninsecure = true",
            "display.token: 192.0.2.1:8900 can be reached",
        ),
        (
            "listen = \"127.0.0.1:8900\"\ntoken = \"0123456789abcde\"",
            "display.token: needs 16",
        ),
        (
            "listen = \"127.0.0.1:8900\"\ntoken = \"0123456789abcd;f\"",
            "display.token: needs 16",
        ),
        (
            "listen = \"127.0.0.1:8900\"\nfoxglove_sites = [\"https://app.example/\"]",
            "display.foxglove_sites: \"https://app.example/\" is no site",
        ),
        (
            "labels = { lines = [] }",
            "display.labels.lines: has 0 lines; a label has 1 to 3",
        ),
        (
            "labels = { lines = [[\"name\"], []] }",
            "display.labels.lines: line 2 has 0 fields",
        ),
        (
            "labels = { lines = [[\"nam\"]] }",
            "\"nam\" is not known; there are: name, callsign",
        ),
        (
            "listen = \"127.0.0.1:8900\"\nhosts = [\"a b\"]",
            "display.hosts: \"a b\" is no name",
        ),
    ];
    for (lines, said) in cases {
        let error = read(lines).unwrap_err();
        assert!(error.contains(said), "{lines}: {error}");
    }
    for lines in [
        "listen = \"127.0.0.1:8900\"",
        "listen = \"[::1]:8900\"",
        "listen = \"[::1]:8900\"\nfoxglove_sites = [\"https://app.example\", \"file://\"]",
        &format!("listen = \"0.0.0.0:8900\"\ninsecure = true\n{token}"),
    ] {
        assert!(read(lines).unwrap().services.display, "{lines}");
    }
}

#[test]
fn recordings_do_not_get_the_tokens() {
    let text = format!(
        "{}\n[display]\nlisten = \"127.0.0.1:1\"\ntoken = \"0123456789abcdef\"\noperator_token = \"fedcba9876543210\"\n",
        site()
    );
    let config = Config::parse(Path::new("test.toml"), &text, &[]).unwrap();
    let recorded = config.text_without_secrets();
    assert!(!recorded.contains("0123456789abcdef") && !recorded.contains("fedcba9876543210"));
    assert!(
        Config::parse(Path::new("test.toml"), &recorded, &[]).is_ok(),
        "{recorded}"
    );
}

#[test]
fn every_shipped_configuration_has_a_display_whose_start_view_is_an_address() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config");
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let config = Config::parse(&path, &std::fs::read_to_string(&path).unwrap(), &[]).unwrap();
        assert!(config.services.display, "{}", path.display());
    }
}

#[test]
fn decisions_are_published_for_a_display_and_recorded_on_request_alone() {
    let streams = |lines: &str| {
        let text = format!("{}\n{lines}", site());
        let config = Config::parse(Path::new("test.toml"), &text, &[]).unwrap();
        let has = |mut streams: Box<dyn Iterator<Item = (messages::StreamId, &str)> + '_>| {
            streams.any(|(id, _)| id == messages::StreamId::DECISIONS)
        };
        [
            has(Box::new(config.streams())),
            has(Box::new(config.recorded_streams())),
        ]
    };
    assert_eq!(streams(""), [false, false]);
    assert_eq!(streams("[display]\nlisten = \"127.0.0.1:8900\""), [true, false]);
}

#[test]
fn a_display_without_configuration_serves_this_machine_alone() {
    let usual = crate::settings::Settings::unconfigured(None).unwrap();
    assert_eq!(
        (usual.address().unwrap().to_string().as_str(), usual.more_ports),
        ("127.0.0.1:8900", 100)
    );
    let given = crate::settings::Settings::unconfigured(Some("127.0.0.1:9000")).unwrap();
    assert_eq!(given.more_ports, 0, "the address that was asked for");
    for wrong in ["8900", "0.0.0.0:8900", "192.0.2.1:80"] {
        assert!(crate::settings::Settings::unconfigured(Some(wrong)).is_err(), "{wrong}");
    }
}

#[test]
fn a_recording_looks_like_its_configuration_and_has_maps_on_request_alone() {
    let text = format!(
        "{}\n[display]\nlisten = \"127.0.0.1:1\"\ntoken = \"0123456789abcdef\"\noverlays = [\"a.geojson\"]\ndeclination_deg = 2.0\n\
         labels.lines = [[\"code\"]]\nviews.start = \"theme=day\"\nviews.file = \"views.json\"\n",
        site()
    );
    let keys = Config::parse(Path::new("test.toml"), &text, &[]).unwrap();
    let usual = crate::settings::Settings::unconfigured(None).unwrap();
    let other = &keys.parts.display;
    let alike = usual.clone().looking_like(other);
    assert_eq!(
        (&alike.labels, alike.declination_deg, alike.views.start.as_str()),
        (&other.labels, Some(2.0), "theme=day")
    );
    assert_eq!((&alike.listen, &alike.token), (&usual.listen, &None), "its own address");
    assert!(alike.views.file.is_none() && alike.overlays.is_empty());
    let mapped = alike.with_maps(other, Path::new("/data"));
    assert_eq!(mapped.overlays, ["/data/a.geojson"]);
}
