//! Tables of direction finders: arrays and mountings.

use std::path::Path;

use deployment::Input;
use scenario::Instrument;

use super::super::Config;

const FRAME: &str = "name = \"x\"\n[frame]\nlatitude_deg = 1.0\nlongitude_deg = 2.0\n";
const RECEIVER: &str = "[[receiver]]\nname = \"lan\"\n[receiver.udp]\nlisten = \"127.0.0.1:8700\"\n";
const LIVE: &str = "[[source]]\nname = \"a\"\n[source.live]\nreceiver = \"lan\"\n";
const LOCATOR: &str = "[source.locator]\n";
const ARRAY: &str = "[source.array]\nfrequency_max_hz = 1e9\n[[source.array.antenna]]\nright_m = 0\nforward_m = 0\n\
                     [[source.array.antenna]]\nright_m = 0.15\nforward_m = 0\n";
const PLATFORM: &str = "[[platform]]\nname = \"ship\"\n[platform.external]\n";
const ON_BOARD: &str = "[source.on_board]\nplatform = \"ship\"\nmounting_deg = [90, 0, 0]\n";

fn read(text: &str) -> Result<Config, String> {
    Config::parse(Path::new("test.toml"), text, &[]).map_err(|error| error.to_string())
}

fn refused_with(tables: &[&str], expected: &str) {
    let error = read(&tables.concat()).map(|_| ()).unwrap_err();
    assert!(error.contains(expected) && error.lines().count() == 1, "{error}");
}

#[test]
fn an_array_measures_the_bearings_of_a_live_finder() {
    let config = read(&[FRAME, RECEIVER, LIVE, LOCATOR, ARRAY].concat()).unwrap();
    assert!(config.sources[0].has_array() && config.sources[0].has_bearings());
    assert_eq!(config.sources[0].on_board, None);
    let plain = read(&[FRAME, RECEIVER, LIVE, LOCATOR].concat()).unwrap();
    assert!(!plain.sources[0].has_array() && plain.sources[0].has_bearings());
}

#[test]
fn an_array_that_cannot_be_is_refused_with_key_value_and_remedy() {
    refused_with(
        &[FRAME, RECEIVER, LIVE, ARRAY],
        "source[0].array: measures bearings for a locator, which is missing; add [source.locator]",
    );
    let finder = "[[source]]\nname = \"b\"\n[source.simulated_direction_finder]\n";
    let scenario = "[scenario]\n";
    let simulated = read(&[FRAME, scenario, finder, LOCATOR, ARRAY].concat()).unwrap();
    assert!(simulated.sources[0].has_array() && !simulated.sources[0].has_emitter_rows());
    assert!(matches!(simulated.sources[0].input, Input::Simulated(_)));
    let Some(Instrument::DirectionFinder { array: Some(array), .. }) = simulated.world.instrument(0) else {
        panic!("with an array")
    };
    assert_eq!(array.antennas_m, [[0.0, 0.0], [0.15, 0.0]]);
    let with = |from: &str, to: &str| ARRAY.replace(from, to);
    for (array, expected) in [
        (
            with("1e9", "-1"),
            "source[0].array.frequency_max_hz: -1 is out of range",
        ),
        (with("1e9", "1e15"), "source[0].array: the array is"),
        (with("0.15", "0"), "source[0].array: "),
        (
            with("frequency_max_hz = 1e9", "frequency_max_hz = 1e9\npaths = 9"),
            "source[0].array.paths: 9 is out of range; it must lie between 1 and 4",
        ),
        (
            with("[[source.array.antenna]]\nright_m = 0.15\nforward_m = 0\n", ""),
            "two at least are needed",
        ),
        (
            with("frequency_max_hz", "frequency_hz"),
            "source[0].array.frequency_hz: unknown key",
        ),
    ] {
        refused_with(&[FRAME, RECEIVER, LIVE, LOCATOR, &array], expected);
    }
}

#[test]
fn a_finder_is_mounted_on_a_platform_that_there_is() {
    let config = read(&[FRAME, RECEIVER, PLATFORM, LIVE, LOCATOR, ARRAY, ON_BOARD].concat()).unwrap();
    let on_board = config.sources[0].on_board.unwrap();
    assert_eq!(on_board.platform, Some(0));
    let mount = config.reading(&config.sources[0]).mount.unwrap();
    assert!((mount.mounting_deg[0].rad() - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    refused_with(
        &[FRAME, RECEIVER, LIVE, LOCATOR, ON_BOARD],
        "source[0].on_board.platform: \"ship\": there is no [[platform]]",
    );
    let other = PLATFORM.replace("ship", "boat");
    refused_with(
        &[FRAME, RECEIVER, &other, LIVE, LOCATOR, ON_BOARD],
        "\"ship\" is no [[platform]]; there are: boat",
    );
    refused_with(
        &[FRAME, RECEIVER, PLATFORM, LIVE, ON_BOARD],
        "source[0].on_board: mounts a live direction finder",
    );
    let place = "[source.place]\nlatitude_deg = 1\nlongitude_deg = 2\n";
    refused_with(
        &[FRAME, RECEIVER, PLATFORM, LIVE, LOCATOR, ON_BOARD, place],
        "source[0].place: the platform's states give the place: leave it out",
    );
    let recorded = PLATFORM.replace("[platform.external]", "[platform.recorded]\nfile = \"ship.csv\"");
    refused_with(
        &[FRAME, RECEIVER, &recorded, LIVE, LOCATOR, ON_BOARD],
        "\"ship\" is recorded, and the direction finder is live",
    );
}
