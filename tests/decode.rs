//! `koseki decode` as a user starts it: files in, lines, tables and sentences out.

use std::fs;
use std::process::Stdio;

use serde_json::{Value, json};

use crate::common::Folder;

/// Folders with a recording, which tests decode.
impl Folder {
    fn with_recording(name: &str, bytes: &[u8]) -> Self {
        Self::with(&[(name, bytes)])
    }

    fn decode(&self, arguments: &str) -> (String, String) {
        self.succeed(&format!("decode {arguments}"))
    }

    fn json_lines(&self, name: &str) -> Vec<Value> {
        let text = self.read(name);
        text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    }
}

/// A CAT010 block with one report of source 0/7 at a time of day in s.
fn report(time_s: f64) -> Vec<u8> {
    let time = ((time_s * 128.0) as u32).to_be_bytes();
    vec![10, 0, 10, 0b1101_0000, 0, 7, 1, time[1], time[2], time[3]]
}

/// A CAT021 block of ed 0.23, which does not fit the default edition: source, descriptor, time of day.
fn early_report() -> Vec<u8> {
    vec![21, 0, 11, 0b1110_0000, 0, 107, 0, 0, 0x9A, 0xB0, 0]
}

/// A frame of the final format.
fn frame(hundredths: u32, payload: &[u8]) -> Vec<u8> {
    let mut bytes = (payload.len() as u16 + 12).to_be_bytes().to_vec();
    bytes.extend([0; 2]);
    bytes.extend(hundredths.to_be_bytes());
    bytes.extend(payload);
    bytes.extend([0xA5; 4]);
    bytes
}

#[test]
fn records_become_lines_with_the_time_of_the_recording() {
    let bytes = [frame(150, &report(1.0)), frame(250, &report(2.5))].concat();
    let folder = Folder::with_recording("night.ff", &bytes);
    let (printed, said) = folder.decode("night.ff --out night.jsonl");
    assert_eq!(printed, "");
    assert_eq!(said, "koseki: night.ff: 2 records of 2 blocks in 2 datagrams (final)\n");
    let expected =
        |time: f64, stamp: f64| json!({"010": {"SAC": 0, "SIC": 7}, "000": 1, "140": time, "_c": 10, "_ts": stamp});
    assert_eq!(
        folder.json_lines("night.jsonl"),
        [expected(1.0, 1.5), expected(2.5, 2.5)]
    );
    // Standard output has the same, and nothing else.
    let (printed, _) = folder.decode("night.ff --out -");
    assert_eq!(printed, folder.read("night.jsonl"));
}

#[test]
fn what_cannot_be_decoded_is_summed_up_and_no_failure() {
    let mut cut = report(0.0)[..8].to_vec();
    cut[2] = 8;
    let bytes = [
        report(1.0),
        cut.repeat(2),
        report(2.0),
        report(3.0),
        early_report(),
        vec![250, 0, 4, 0],
        vec![9, 0],
    ]
    .concat();
    let folder = Folder::with_recording("mixed.ast", &bytes);
    let (_, said) = folder.decode("mixed.ast --out mixed.jsonl");
    assert_eq!(folder.json_lines("mixed.jsonl").len(), 3);
    let expected = [
        "mixed.ast: 3 records of 7 blocks in 1 datagram (raw)",
        "category 010: 2 of 5 blocks do not fit edition 1.1: they are left out",
        "category 021: 1 of 1 block does not fit edition 2.4: none of its records is given, because blocks may \
         fit by accident; edition 0.23 fits 1 of them (so do 0.24, 0.25, 0.26): try --edition 21=0.23",
        "left out, since there is no table of the category: 250 (1 block)",
        "2 x item cut in I010/140 (16 octets), the first: byte 17: I010/140 takes at least 3 octets, 1 left",
        "1 x block header cut (2 octets), the first: byte 61: a block header takes 3 octets, 2 left",
    ];
    for line in expected {
        assert!(said.contains(&format!("koseki: {line}")), "{line}\n{said}");
    }
    let (_, said) = folder.decode("mixed.ast --edition 21=0.23 --out mixed.jsonl");
    assert_eq!(folder.json_lines("mixed.jsonl").len(), 4);
    assert!(!said.contains("category 021"), "{said}");
}

#[test]
fn a_file_that_is_no_asterix_is_named_and_refused() {
    let files: [(&str, &[u8], &str); 7] = [
        ("passwd", b"root:x:0:0:root:/root:/bin/sh\n", "it is text"),
        (
            "a.ais",
            b"!AIVDM,1,1,,A,13u?etPv2;0n:dDPwUM1U1Cb069D,0*24\n",
            "it is a log of AIS",
        ),
        (
            "a.sbs",
            b"MSG,3,1,1,4CA2D6,1,2020/01/01,12:00:00.000\n",
            "it is an SBS log",
        ),
        (
            "a.avr",
            b"*8D4840D6202CC371C32CE0576098;\n",
            "it is a log of Mode S frames",
        ),
        ("a.hex", b"0a000ad00007\n01000080\n", "it is hexadecimal text"),
        ("a.jsonl", b"{\"_c\": 10}\n", "it is JSON"),
        ("a.ast", &[250, 0, 4, 0], "no record of ASTERIX can be read\n"),
    ];
    for (name, bytes, kind) in files {
        let folder = Folder::with_recording(name, bytes);
        for what in ["--out x.jsonl", "--statistics"] {
            let output = folder.run(&format!("decode {name} {what}"));
            let said = String::from_utf8(output.stderr).unwrap();
            assert_eq!(output.status.code(), Some(2), "{name}: {said}");
            assert!(
                said.contains(kind) && said.contains(&format!("koseki: {name}: no record")),
                "{said}"
            );
        }
    }
}

#[test]
fn gps_recordings_and_hexadecimal_lines_have_times() {
    let mut gps = vec![0xee; 2_200];
    let of_128_s = [0, 0, 0, 0, 0, 0, 0, 1, 64, 0];
    (0..4).for_each(|second| gps.extend([&report(f64::from(second))[..], &of_128_s].concat()));
    let line = "1620114891.8 0a 00 0a d0 00 07 01 00 00 80\n";
    for (name, bytes, records, kind, time) in [
        ("a.gps", &gps[..], "4 records of 4 blocks in 4 datagrams", "gps", 2.5),
        (
            "a.hex",
            line.as_bytes(),
            "1 record of 1 block in 1 datagram",
            "hex",
            1_620_114_891.8,
        ),
    ] {
        let folder = Folder::with_recording(name, bytes);
        let (_, said) = folder.decode(&format!("{name} --out x.jsonl"));
        assert_eq!(said, format!("koseki: {name}: {records} ({kind})\n"));
        assert_eq!(folder.json_lines("x.jsonl")[0]["_ts"], time);
        let refused = folder.run(&format!("decode {name} --out x.jsonl --container raw"));
        let said = String::from_utf8(refused.stderr).unwrap();
        assert!(
            refused.status.code() == Some(2) && said.contains(&format!("the container {kind}")),
            "{said}"
        );
    }
}

#[test]
fn categories_without_a_table_are_named_and_no_failure() {
    let folder = Folder::with_recording("video.ast", &[240, 0, 6, 0xC0, 0, 7, 129, 0, 4, 0]);
    for what in ["--out x.jsonl", "--statistics"] {
        let (_, said) = folder.decode(&format!("video.ast {what}"));
        for line in [
            "category 240: radar video; no table here (1 block)",
            "category 129: identification and reports of unmanned aircraft; no table here (1 block)",
        ] {
            assert!(said.contains(&format!("koseki: {line}\n")), "{line}\n{said}");
        }
    }
    assert_eq!(folder.read("x.jsonl"), "");
}

#[test]
fn statistics_are_a_table_and_a_file() {
    let times = [10.0, 11.0, 11.5, 12.0, 13.0];
    let reports: Vec<u8> = times.iter().flat_map(|time_s| report(*time_s)).collect();
    let folder = Folder::with_recording("s.ast", &[reports, vec![10, 0, 4, 0]].concat());
    let (printed, said) = folder.decode("s.ast --statistics --json s.json");
    let rows: Vec<Vec<&str>> = printed.lines().map(|line| line.split_whitespace().collect()).collect();
    let has = |row: &[&str]| assert!(rows.iter().any(|found| found == row), "{row:?}\n{printed}");
    has(&["category", "edition", "blocks", "refused", "records"]);
    has(&["010", "1.1", "6", "1", "5"]);
    has(&[
        "category", "source", "records", "first", "last", "min/s", "median/s", "max/s",
    ]);
    has(&["010", "0/7", "5", "00:00:10.000", "00:00:13.000", "1", "1", "2"]);
    assert!(printed.contains("record without items"), "{printed}");
    assert_eq!(said.lines().count(), 2, "reasons stand in the table: {said}");
    let found: Value = serde_json::from_slice(&fs::read(folder.path("s.json")).unwrap()).unwrap();
    let sender = json!({
        "category": 10, "source": [0, 7], "records": 5, "first_s": 10.0, "last_s": 13.0,
        "rate": {"min": 1, "median": 1, "max": 2},
    });
    assert_eq!(found["senders"], json!([sender]));
    assert_eq!(found["refusals"][0]["first_offset"], 53);
    assert_eq!(found["categories"][0]["blocks_refused"], 1);
    // The same where nothing is asked for, and where only the file is.
    assert_eq!(folder.decode("s.ast"), (printed.clone(), said.clone()));
    assert_eq!(folder.decode("s.ast --json again.json"), (printed, said));
    assert_eq!(folder.read("again.json"), folder.read("s.json"));
}

/// A CAT048 record of nothing but a source and a reserved expansion field.
#[test]
fn expansion_fields_are_octets_unless_their_rules_are_named() {
    // FSPEC of four bytes: FRN 1, and FRN 28.
    let record = |content: &[u8]| {
        let mut bytes = vec![0x81, 0x01, 0x01, 0x02, 25, 11, content.len() as u8 + 1];
        bytes.extend(content);
        let mut block = vec![48, 0, bytes.len() as u8 + 3];
        block.extend(bytes);
        block
    };
    // Rules ed 1.13: the first subitem, MD5, is compound; here with its first part. No subitem has the eighth flag.
    let folder = Folder::with_recording("x.ast", &[record(&[0x80, 0x80, 0x01]), record(&[0x01])].concat());
    let (_, said) = folder.decode("x.ast --out octets");
    assert_eq!(said.lines().count(), 1, "{said}");
    let octets = folder.json_lines("octets");
    assert_eq!((&octets[0]["RE"], &octets[1]["RE"]), (&json!("808001"), &json!("01")));
    let (_, said) = folder.decode("x.ast --edition 48/RE=1.13 --out decoded");
    let decoded = folder.json_lines("decoded");
    assert_eq!(decoded[1], octets[1]);
    assert!(decoded[0]["RE"]["MD5"]["SUM"].is_object(), "{}", decoded[0]);
    let expected = "I048/RE: 1 field does not follow the coding rules ed 1.13 (left as octets), the first: byte 24: ";
    assert!(said.contains(expected), "{said}");
}

#[test]
fn strictness_and_kind_can_be_asked_for() {
    // I010/161 with a spare bit set.
    let spare = [10, 0, 9, 0b1000_0001, 0b0010_0000, 0, 7, 0x80, 1];
    let folder = Folder::with_recording("x.ast", &spare);
    assert_eq!(folder.decode("x.ast --out -").0.lines().count(), 1);
    for (arguments, expected) in [
        ("--strict", "spare bit set in I010/161"),
        ("--container pcap", "byte 0: this is no pcap recording"),
    ] {
        let nothing_read = folder.run(&format!("decode x.ast {arguments} --out -"));
        let said = String::from_utf8(nothing_read.stderr).unwrap();
        assert_eq!(
            (nothing_read.status.code(), nothing_read.stdout.len()),
            (Some(2), 0),
            "{said}"
        );
        assert!(said.contains(expected), "{said}");
    }
}

#[test]
fn wrong_usage_is_one_line_and_changes_nothing() {
    let folder = Folder::with_recording("x.ast", &report(0.0));
    let cases: [(&str, &[&str]); 7] = [
        ("x.ast --out x.ast", &["x.ast is the recording itself"]),
        ("x.ast --statistics --json ./x.ast", &["x.ast is the recording itself"]),
        ("x.ast --out - --statistics", &["would mix on standard output"]),
        ("x.ast --out - --json z", &["would mix on standard output"]),
        ("x.ast --out y --edition 21=7.7", &["category 021", "2.4", "0.23"]),
        (
            "x.ast --out y --edition 21=2.1 --edition 21=0.23",
            &["two editions of category 021"],
        ),
        (
            "x.ast --out y --container zip",
            &["raw, pcap, pcapng, final, gps and hex"],
        ),
    ];
    for (arguments, expected) in cases {
        let line = folder.refusal(&format!("decode {arguments}"));
        for part in expected.iter().chain(&["koseki decode --help"]) {
            assert!(line.contains(part), "{part}: {line}");
        }
    }
    assert_eq!(fs::read(folder.path("x.ast")).unwrap(), report(0.0));
    assert!(!folder.path("y").exists());
}

/// As in `koseki decode FILE --out - | head`.
#[test]
fn a_reader_who_has_seen_enough_is_no_failure() {
    let folder = Folder::with_recording("x.ast", &report(0.0).repeat(20_000));
    let mut child = folder
        .command("decode x.ast --out -")
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    assert_eq!(child.wait().unwrap().code(), Some(0));
}
