//! `koseki locate` on recordings of direction finders in ASTERIX (category 205): containers, dates, options, refusals.

use formats::containers::{DatagramRoute, begin_capture, capture};
use test_support::{MIDNIGHT_S, since_1970};

use crate::common::Home;
use crate::finder_reports::{NINE_S, SECONDS, block, refused, rows, succeed};

/// Writes a recording with a report of each second, by one finder after the other; returns the blocks.
fn write_blocks(home: &Home) -> Vec<Vec<u8>> {
    let second = |second: u32| {
        let (passed_s, time_ns) = (f64::from(second), (NINE_S as i64 + i64::from(second)) * 1_000_000_000);
        block(second as usize % 2, time_ns, passed_s)
    };
    let blocks: Vec<Vec<u8>> = (0..SECONDS).map(second).collect();
    home.write("finders.ast", blocks.concat());
    blocks
}

#[test]
fn containers_and_dates_do_not_change_the_fixes() {
    let home = Home::new();
    let blocks = write_blocks(&home);
    let said = succeed(&home, "locate --bearings finders.ast --out fixes.csv");
    assert!(said.contains("the first position of finders.ast (record 1)"), "{said}");
    assert!(
        said.contains("standard deviation of 2°") && said.contains("240 bearings of 1 emitters"),
        "{said}"
    );
    let fixes = home.read("fixes.csv");
    let hexadecimal: Vec<String> = blocks
        .iter()
        .map(|block| block.iter().map(|octet| format!("{octet:02X}")).collect::<String>() + "\n")
        .collect();
    home.write("finders.hex", hexadecimal.concat());
    let frames: Vec<Vec<u8>> = blocks
        .iter()
        .map(|block| [&(block.len() as u16 + 12).to_be_bytes()[..], &[0; 6], block, &[0xA5; 4]].concat())
        .collect();
    home.write("finders.ff", frames.concat());
    let mut pcapng = begin_capture();
    for (block, second) in blocks.iter().zip(0..) {
        let route = DatagramRoute {
            from: "192.0.2.1:8600".parse().unwrap(),
            to: "192.0.2.2:8600".parse().unwrap(),
            received_utc_ns: (MIDNIGHT_S + NINE_S as i64 + second) * 1_000_000_000 + 70_000_000,
        };
        capture(&route, block, &mut pcapng).unwrap();
    }
    home.write("finders.pcapng", pcapng);
    for (arguments, is_dated) in [
        ("finders.hex", false),
        ("finders.ff", false),
        ("finders.pcapng --date 1970-01-01", false),
        ("finders.pcapng", true),
        ("finders.ast --date 2024-10-04", true),
    ] {
        succeed(&home, &format!("locate {arguments} --out again.csv"));
        let expected = if is_dated {
            since_1970(&fixes, &["time_s"])
        } else {
            fixes.clone()
        };
        assert!(home.read("again.csv") == expected, "{arguments}");
    }
}

#[test]
fn what_a_recording_does_not_state_is_stated_by_options() {
    let home = Home::new();
    let blocks = write_blocks(&home);
    // One sender cannot be located at rest; the reports of the other are counted.
    let said = succeed(&home, "locate finders.ast --sac 25 --sic 10 --out fixes.csv");
    assert!(said.contains("left out: 120 rows, 120 for another sender"), "{said}");
    // Bearings that are half as accurate have fixes of twice the standard deviation.
    let variance_m2 = |sigma: &str| -> f64 {
        succeed(
            &home,
            &format!("locate finders.ast --filter fixed{sigma} --select none --out fixes.csv"),
        );
        rows(&home.read("fixes.csv"))[0][8].parse().unwrap()
    };
    let ratio = variance_m2(" --bearing-sigma-deg 4") / variance_m2("");
    assert!((3.0..5.0).contains(&ratio), "{ratio}");
    home.write("locate.toml", "[locating]\nbearing_sigma_deg = 4.0\n");
    let configured = variance_m2(" --config locate.toml") / variance_m2(" --bearing-sigma-deg 4");
    assert!((configured - 1.0).abs() < 1e-12, "{configured}");
    // The last block is cut.
    home.write("cut.ast", [&blocks.concat()[..], &blocks[0][..9]].concat());
    let said = succeed(&home, "locate cut.ast --out fixes.csv");
    let at = blocks.concat().len();
    let expected = format!("cut.ast: record 241: in the data block at byte {at}, byte 0: block of category 205");
    assert!(
        said.contains("1 for a damaged block") && said.contains(&expected),
        "{said}"
    );
}

#[test]
fn recordings_that_cannot_be_located_are_refused_with_the_remedy() {
    let home = Home::new();
    let blocks = write_blocks(&home);
    home.write("radar.ast", [48, 0, 6, 0x80, 25, 9].repeat(3));
    home.write("logo.png", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x01".repeat(9));
    home.write(
        "flight.csv",
        "time_s,emitter_id,bearing_rad,sigma_rad,px,py,pz\n32400,1,1,0.02,0,0,0\n",
    );
    home.write(
        "places.csv",
        "time_s,emitter_id,bearing_rad,sigma_rad,lat,lon\n32400,1,1,0.02,54,10\n",
    );
    // Without I205/050.
    let unplaced = |block: &Vec<u8>| {
        let [head @ .., _, _, _, _, _, _, _, _, high, low] = &block[..] else {
            panic!("{block:?}")
        };
        let mut block = [head, &[*high, *low]].concat();
        (block[2], block[3]) = (block[2] - 8, block[3] & !0x02);
        block
    };
    home.write("unplaced.ast", blocks.iter().flat_map(unplaced).collect::<Vec<u8>>());
    for (arguments, expected) in [
        (
            "radar.ast",
            "radar.ast: none of 3 records of ASTERIX is a report of a direction finder (category 205); `koseki decode`",
        ),
        (
            "finders.ast --sac 1 --sic 2",
            "(category 205) of SAC 1, SIC 2; `koseki decode`",
        ),
        (
            "logo.png",
            "logo.png: no record of ASTERIX can be read; bearings are tables (CSV), or",
        ),
        (
            "unplaced.ast",
            "unplaced.ast: states no latitude and longitude (I205/050); give the finder's place, --place",
        ),
        (
            "unplaced.ast --origin 54.0,10.0",
            "unplaced.ast: no record can be used: unplaced.ast: record 1: I205/050 and I205/060, the positions, are \
             missing; give the finder's place, --place",
        ),
        (
            "--fixes finders.ast",
            "finders.ast: is no table; name a recording with --bearings",
        ),
        (
            "finders.ast --platform flight.csv",
            "--platform flight.csv is for bearings from the nose",
        ),
        (
            "--bearings flight.csv --date 2024-10-04",
            "--date is for recordings of direction finders",
        ),
        (
            "finders.ast --date 2024-13-04",
            "\"2024-13-04\" is not a date: write year-month-day",
        ),
        (
            "finders.ast --bearing-sigma-deg 90",
            "bearing_sigma_deg: 90 is out of range; it must lie between 0.001 and 57",
        ),
        (
            "--bearings flight.csv --bearings finders.ast",
            "finders.ast: has places in degrees, files before in metres; give --origin",
        ),
        (
            "finders.ast --date 2024-10-04 --bearings places.csv",
            "places.csv: times count from a midnight, but those of finders.ast from 1970; count both from one of them; \
             --date YYYY-MM-DD gives recordings their first day",
        ),
    ] {
        let said = refused(&home, &format!("locate {arguments} --out no.csv"));
        assert!(said.contains(expected), "{arguments}: {said}");
    }
    assert!(!home.path("no.csv").exists());
    // Tables and recordings together.
    succeed(&home, "locate finders.ast --bearings places.csv --out fixes.csv");
    let said = succeed(&home, "locate unplaced.ast --place 54.0,10.0 --out fixes.csv");
    assert!(said.contains("origin of the plane: the place of --place"), "{said}");
}
