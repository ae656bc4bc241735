//! Records of each category, worked out by hand from the documents.
//!
//! The system's origin and the sensor are at 45° N, 11.25° E: a quarter and a sixteenth of half a turn, whose numbers
//! are powers of two.

use asterix::Category;
use asterix::categories::*;
use deployment::Technology;
use messages::{
    Contribution, Covariance, Identity, IdentityAges, SensorTrack, SystemTrack, TrackState, alert_bits,
    contribution_bits, sensor_track_bits as bits,
};
use outgoing::{Condition, SensorReports, SensorStatus, StatusReports, SystemReports, SystemSource, SystemStatus};

use crate::model::World;

/// Two seconds after a midnight: 256 ticks.
const TIME_NS: i64 = 20_000 * 86_400_000_000_000 + 2_000_000_000;

fn world() -> World {
    World::simple(45.0, 11.25)
}

/// The only block of what `send` sends.
fn block(send: impl FnOnce(&mut dyn FnMut(&[u8]))) -> Vec<u8> {
    let mut sent = vec![];
    send(&mut |block| sent.push(block.to_vec()));
    assert_eq!(sent.len(), 1);
    sent.remove(0)
}

fn sensor(table: &'static Category) -> SensorReports {
    let world = world();
    SensorReports::new(table, 7, 9, world.sensor, world.system, 1400).unwrap()
}

fn sensor_block(table: &'static Category, track: &SensorTrack) -> Vec<u8> {
    let mut sender = sensor(table);
    block(|send| {
        sender.report(track, send);
        sender.flush(send);
    })
}

#[test]
fn cat062() {
    let mut track = SystemTrack {
        reference_time_ns: TIME_NS,
        track_number: 17,
        identity: Identity::default().with_address(0x4CA7B3).with_mode_3a(0o7421),
        velocity_mps: [10.0, -20.0, 0.0],
        velocity_valid: 1,
        state: TrackState::Confirmed as u8,
        source_count: 1,
        contribution_count: 1,
        // Half a second old: a report with a level, after another one with the code.
        trigger_source: 1,
        time_of_measurement_ns: TIME_NS - 500_000_000,
        level: 1400,
        level_valid: 1,
        level_age_ms: 500,
        identity_ages: IdentityAges {
            mode_3a_ms: 1000,
            ..IdentityAges::default()
        },
        ..SystemTrack::default()
    };
    track.contributions[0] = Contribution {
        time_of_measurement_ns: TIME_NS - 1_000_000_000,
        source: 1,
        flags: contribution_bits::FRESH,
        ..Contribution::default()
    };
    let sources = [SystemSource {
        number: 1,
        technology: Technology::ModeS,
        code: Some([0x14, 0x01]),
    }];
    let mut sender = SystemReports::new(&CAT062_V1_18, 0x14, 0x2A, world().system, &sources, 1400).unwrap();
    let sent = block(|send| {
        sender.report(&track, send);
        sender.flush(send);
    });
    assert_lines(
        &sent,
        "3E 00 37                  category 062, 55 octets
         9F 5F 61 02               010 070 105 100 185, 060 380 040 080 290, 295 136, 340
         14 2A                     010
         00 01 00                  070: 2 s
         00 80 00 00 00 20 00 00   105: 2^23 and 2^21 times 180/2^25 degrees
         00 00 00 00 00 00         100
         00 28 FF B0               185: 40 and -80 quarters
         0F 11                     060: 7421
         80 4C A7 B3               380: ADR
         00 11                     040
         81 21 01 01 40            080: MON; TSB; none; none; SDS 1
         10 04                     290: MDS, 4 quarters
         90 02 04                  295: MFL, 2 quarters; MDA, 4
         05 78                     136: 1400 quarters
         90 14 01 05 78            340: SID; MDC, 1400 quarters",
    );
}

#[test]
fn cat048() {
    // Five nautical miles north of the radar, flying north at a tenth of one in a second.
    let track = SensorTrack {
        time_of_measurement_ns: TIME_NS,
        track_number: 5,
        identity: Identity::default().with_mode_3a(0o1234),
        position_m: [0.0, 9260.0, 0.0],
        velocity_mps: [0.0, 185.2, 0.0],
        valid: bits::VELOCITY,
        state: TrackState::Confirmed as u8,
        ..SensorTrack::default()
    };
    assert_lines(
        &sensor_block(&CAT048_V1_31, &track),
        "30 00 1C      category 048, 28 octets
         F9 1E         010 140 020 040 070, 161 042 200 170
         07 09         010
         00 01 00      140
         40            020: TYP 2
         05 00 00 00   040: 5 x 256, 0
         02 9C         070: 1234
         00 05         161
         00 00 02 80   042: 0, 5 x 128
         06 66 00 00   200: 0.1 x 2^14 = 1638, 0
         46            170: RAD 2, CDM 3",
    );
    let end = SensorTrack {
        state: TrackState::Terminated as u8,
        ..track
    };
    let mut sender = sensor(&CAT048_V1_31);
    sender.report(&track, &mut |_| ());
    sender.flush(&mut |_| ());
    let sent = block(|send| {
        sender.report(&end, send);
        sender.flush(send);
    });
    assert_lines(
        &sent,
        "30 00 11      category 048, 17 octets
         E9 12         010 140 020 070, 161 170
         07 09         010
         00 01 00      140
         00            020: TYP 0
         22 9C         070: L, 1234
         00 05         161
         47 80         170: RAD 2, CDM 3; TRE",
    );
}

#[test]
fn cat034() {
    let mut sender = sensor(&CAT048_V1_31);
    let north = block(|send| sender.status(TIME_NS, send));
    assert_lines(&north, "22 00 0A E0 07 09 01 00 01 00");
    let east = block(|send| sender.sector(TIME_NS, std::f64::consts::FRAC_PI_2, send));
    assert_lines(&east, "22 00 0B F0 07 09 02 00 01 00 40");
}

#[test]
fn cat020_and_019() {
    let track = SensorTrack {
        time_of_measurement_ns: TIME_NS,
        track_number: 300,
        identity: Identity::default().with_address(0x3C65AC),
        velocity_mps: [-5.0, 2.5, 0.0],
        valid: bits::HEIGHT | bits::VELOCITY | bits::ON_GROUND,
        state: TrackState::Confirmed as u8,
        ..SensorTrack::default()
    };
    let items = "07 09                     010
         @
         00 01 00                  140
         00 80 00 00 00 20 00 00   041
         00 00 00 00 00 00         042
         01 2C                     161
         1A                        170: CDM 3, STH
         FF EC 00 0A               202: -20 and 10 quarters
         3C 65 AC                  220
         00 00                     105";
    let first = "14 00 27      category 020, 39 octets
         FF 49 80      010 020 140 041 042 161 170, 202 220, 105\n";
    let record = items.replace('@', "41 10   020: MS; GBS");
    assert_lines(&sensor_block(&CAT020_V1_9, &track), &(first.to_owned() + &record));
    let first = first.replace("27", "28");
    let record = items.replace('@', "41 11 C0   020: MS; GBS; CF 3");
    assert_lines(&sensor_block(&CAT020_V1_10, &track), &(first + &record));
    let status = block(|send| sensor(&CAT020_V1_9).status(TIME_NS, send));
    assert_lines(
        &status,
        "13 00 14                  category 019, 20 octets
         F1 80                     010 000 140 550, 600
         07 09 02 00 01 00 00      010, 000: 2, 140, 550
         10 00 00 00 04 00 00 00   600: 2^28 and 2^26 times 180/2^30 degrees",
    );
}

fn adsb_track() -> SensorTrack {
    SensorTrack {
        time_of_measurement_ns: TIME_NS,
        track_number: 1,
        identity: Identity::default().with_address(0x400001).with_callsign(*b"KSK1    "),
        covariance: Covariance::diagonal([4.0, 4.0, 10.0], [1.0; 3]),
        valid: bits::HEIGHT,
        alerts: alert_bits::UNLAWFUL_INTERFERENCE,
        state: TrackState::Confirmed as u8,
        ..SensorTrack::default()
    }
}

#[test]
fn cat021_and_023() {
    assert_lines(
        &sensor_block(&CAT021_V2_4, &adsb_track()),
        "15 00 2B                  category 021, 43 octets
         EB 19 71 41 80            010 040 161 071 131, 080 073, 140 090 210, 200, 170
         07 09                     010
         10                        040: ARC 2
         00 01                     161
         00 01 00                  071
         10 00 00 00 04 00 00 00   131
         40 00 01                  080
         00 01 00                  073
         00 00                     140
         01 15 04                  090: none; NACp 10 (9.8 m); GVA 2 (19.6 m)
         12                        210: VN 2, LTT 2
         55                        200: LNAV 1, PS 5, SS 1
         2D 32 F1 82 08 20         170: 0B 13 0B 31 20 20 20 20 in six bits each",
    );
    let status = block(|send| sensor(&CAT021_V2_4).status(TIME_NS, send));
    assert_lines(&status, "17 00 0B D8 07 09 01 00 01 00 00");
}

#[test]
fn cat021_of_the_first_editions() {
    let record = "07 09                     010
         04 20                     040: SAA; ATP 1
         00 01 00                  030
         @
         40 00 01                  080
         00 00                     140
         00 08                     090: NUCp 8
         08                        210: MDS
         2D 32 F1 82 08 20         170
         05                        200";
    let fspec = "FF 81 12   010 040 030 130 080 140 090, 210, 170 200\n";
    let coarse = record.replace('@', "20 00 00 08 00 00   130: 2^21 and 2^19 times 180/2^23 degrees");
    let sent = sensor_block(&CAT021_V0_23, &adsb_track());
    assert_lines(&sent, &format!("15 00 22\n{fspec}{coarse}"));
    let fine = record.replace(
        '@',
        "00 80 00 00 00 20 00 00   130: 2^23 and 2^21 times 180/2^25 degrees",
    );
    let sent = sensor_block(&CAT021_V0_24, &adsb_track());
    assert_lines(&sent, &format!("15 00 24\n{fspec}{fine}"));
}

#[test]
fn cat010() {
    let track = SensorTrack {
        time_of_measurement_ns: TIME_NS,
        track_number: 1,
        measured_m: [30.0, 40.0, 0.0],
        valid: bits::MEASURED,
        state: TrackState::Coasted as u8,
        ..SensorTrack::default()
    };
    let measured = SensorTrack {
        state: TrackState::Confirmed as u8,
        ..track
    };
    assert_lines(
        &sensor_block(&CAT010_V1_1, &measured),
        "0A 00 1F                  category 010, 31 octets
         FF 30                     010 000 020 140 041 040 042, 161 170
         07 09 01                  010, 000: 1
         60                        020: TYP 3
         00 01 00                  140
         20 00 00 00 08 00 00 00   041: 2^29 and 2^27 times 180/2^31 degrees
         00 32 1A 38               040: 50 m, 36.87 degrees = 6712
         00 00 00 00               042
         00 01                     161
         06                        170: TCC, STH",
    );
    assert_lines(
        &sensor_block(&CAT010_V1_1, &track),
        "0A 00 1B                  category 010, 27 octets
         FB 30                     010 000 020 140 041 042, 161 170
         07 09 01 60 00 01 00      010, 000, 020, 140
         20 00 00 00 08 00 00 00   041
         00 00 00 00               042
         00 01                     161
         36                        170: CST 3, TCC, STH",
    );
    let status = block(|send| sensor(&CAT010_V1_1).status(TIME_NS, send));
    assert_lines(&status, "0A 00 0D D1 01 04 07 09 03 00 01 00 00");
}

#[test]
fn cat065_and_063() {
    let sender = StatusReports::new(&CAT065_V1_5, &CAT063_V1_6, 0x14, 0x2A, 1400).unwrap();
    let mut sender = sender.with_service(5);
    let status = SystemStatus {
        time_source_invalid: true,
        processing_system: 1,
        renumbered: true,
        ..SystemStatus::default()
    };
    let sent = block(|send| sender.system(TIME_NS, status, send));
    assert_lines(&sent, "41 00 0C F4 14 2A 01 05 00 01 00 16");
    let sensor = SensorStatus {
        sac: 7,
        sic: 9,
        condition: Condition::NotConnected,
        silent: true,
        time_source_invalid: false,
        ..SensorStatus::default()
    };
    let sent = block(|send| sender.sensors(TIME_NS, &[sensor], send));
    assert_lines(
        &sent,
        "3F 00 0E F8 14 2A 05 00 01 00 07 09
         C1 04         060: CON 3; NPW",
    );
}

/// Compares a block with lines of bytes in hexadecimal, each with words behind them.
#[track_caller]
fn assert_lines(sent: &[u8], lines: &str) {
    let is_octet = |word: &&str| word.len() == 2 && word.bytes().all(|byte| byte.is_ascii_hexdigit());
    let octets = lines
        .lines()
        .flat_map(|line| line.split_whitespace().take_while(is_octet));
    let sent: Vec<String> = sent.iter().map(|octet| format!("{octet:02X}")).collect();
    assert_eq!(sent.join(" "), octets.collect::<Vec<_>>().join(" "));
}
