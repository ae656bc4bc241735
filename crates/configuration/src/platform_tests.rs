//! Keys of platforms.

use std::net::Ipv4Addr;
use std::path::Path;

use super::*;
use crate::Config;

const HEAD: &str = r#"name = "t"
[frame]
latitude_deg = 41.0
longitude_deg = 2.0
[[receiver]]
name = "lan"
udp = { listen = "127.0.0.1:8600" }
[[source]]
name = "radar"
live = { receiver = "lan" }
"#;

fn parse(platforms: &str) -> Result<Config, String> {
    Config::parse(Path::new("t.toml"), &format!("{HEAD}{platforms}"), &[]).map_err(|error| error.to_string())
}

#[test]
fn each_kind_of_input_is_read() {
    let config = parse(
        "[[platform]]\nname = \"ship\"\nheading_sigma_deg = 0.3\nlive = { udp = { listen = \"127.0.0.1:10110\" } }\n\
         [[platform]]\nname = \"boat\"\nlive = { tcp = \"127.0.0.1:4000\" }\n\
         [[platform]]\nname = \"van\"\nlive = { device = \"/dev/ttyUSB0\" }\n\
         [[platform]]\nname = \"own\"\n[platform.external]\n",
    )
    .unwrap();
    let inputs: Vec<&PlatformInput> = config.platforms.iter().map(|platform| &platform.input).collect();
    match &inputs[..] {
        [
            PlatformInput::Live(PlatformFeed::Udp(udp)),
            PlatformInput::Live(PlatformFeed::Tcp(tcp)),
            PlatformInput::Live(PlatformFeed::Device(device)),
            PlatformInput::External,
        ] => {
            assert_eq!(udp.listen, (Ipv4Addr::LOCALHOST, 10110).into());
            assert_eq!(tcp.port(), 4000);
            assert_eq!(device.as_path(), Path::new("/dev/ttyUSB0"));
        }
        other => panic!("{other:?}"),
    }
    assert_eq!(config.readings.platforms[0].assumed.heading_sigma_deg.deg(), 0.3);
    // Only those with an input of their own are processes.
    assert_eq!(config.adapters(), ["lan", "ship", "boat", "van"]);
}

#[test]
fn what_cannot_be_meant_is_refused_with_key_and_remedy() {
    for (platforms, expected) in [
        (
            "[[platform]]\nname = \"ship\"\n",
            "exactly one of [platform.live], [platform.recorded], [platform.external] and [platform.simulated]",
        ),
        (
            "[[platform]]\nname = \"ship\"\nexternal = {}\nlive = { tcp = \"127.0.0.1:4000\" }\n",
            "platform[0].name: \"ship\" needs exactly one of",
        ),
        ("[[platform]]\nname = \"ship\"\nlive = {}\n", "give exactly one of udp"),
        (
            "[[platform]]\nname = \"ship\"\nlive = { udp = { listen = \"here\" } }\n",
            "platform[0].live.udp.listen: \"here\" is no address and port",
        ),
        (
            "[[platform]]\nname = \"lan\"\nlive = { tcp = \"127.0.0.1:4000\" }\n",
            "platform[0].name: \"lan\" is also the name of an adapter process",
        ),
        (
            "[[platform]]\nname = \"a\"\nexternal = {}\n[[platform]]\nname = \"a\"\nexternal = {}\n",
            "platform[1].name: \"a\" is the name of an earlier platform",
        ),
        (
            "[[platform]]\nname = \"a\"\nexternal = {}\nmax_gap_s = 0\n",
            "platform[0].max_gap_s: 0 is out of range",
        ),
    ] {
        let error = parse(platforms).map(|_| ()).unwrap_err();
        assert!(error.contains(expected), "{error}");
    }
}
