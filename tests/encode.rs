//! `koseki encode` as a user starts it: what `koseki decode` writes, back into the recording it came from.

use std::io::Write as _;
use std::process::Stdio;

use serde_json::{Value, json};
use test_support::recording;

use crate::common::Folder;

/// Bytes of a long recording that are decoded: some thousand records.
const OCTETS_MAX: usize = 200_000;

/// Recordings, the editions to read them by, and whether every record can be written again: some hold texts with codes
/// that are no characters.
const RECORDINGS: [(&str, &str, bool); 12] = [
    ("lebl2016/160510-lebl-220001_SMR_cat10.ast", "", true),
    ("lebl2016/160510-lebl-220001_MLAT_cat10.ast", "", true),
    ("lebl2016/160510-lebl-220001_MLAT_cat20.ast", "", true),
    (
        "lebl2016/160510-lebl-220001_ADSB_cat21_v023.ast",
        "--edition 21=0.23",
        false,
    ),
    ("lebl2020/201002-lebl-080001_MLAT_cat10.ast", "", true),
    ("lebl2020/201002-lebl-080001_SMR_cat10.ast", "", true),
    ("akapetanovic/Jahorina.raw", "", true),
    ("cro/cat048.raw", "", true),
    ("cro/cat062cat065.raw", "", false),
    ("cro/cat21_re.ast", "--edition 21/RE=1.4", true),
    ("cro/cat_034_048.pcap", "", false),
    ("cro/cat_062_065.pcap", "--edition 62/RE=1.2", true),
];

/// The whole blocks at the beginning of a recording of blocks; all of another one.
fn beginning(name: &str, bytes: &[u8]) -> Vec<u8> {
    if name.ends_with(".pcap") || bytes.len() <= OCTETS_MAX {
        return bytes.to_vec();
    }
    let mut end = 0;
    while end < OCTETS_MAX {
        end += usize::from(u16::from_be_bytes([bytes[end + 1], bytes[end + 2]]));
    }
    bytes[..end].to_vec()
}

/// The records of a file, without the time of the recording, which data blocks do not hold.
fn records(folder: &Folder, name: &str) -> Vec<Value> {
    let record = |line: &str| {
        let mut record: Value = serde_json::from_str(line).unwrap();
        record.as_object_mut().unwrap().remove("_ts");
        record
    };
    folder.read(name).lines().map(record).collect()
}

#[test]
fn recordings_decoded_encoded_and_decoded_hold_the_same_records() {
    for (name, editions, is_lossless) in RECORDINGS {
        let Some(bytes) = recording(name) else { continue };
        let extension = name.rsplit('.').next().unwrap();
        let file = format!("recording.{extension}");
        let folder = Folder::with(&[(file.as_str(), beginning(name, &bytes))]);
        folder.succeed(&format!("decode {file} {editions} --out first.jsonl"));
        let (_, said) = folder.succeed(&format!("encode first.jsonl {editions} --out second.ast"));
        folder.succeed(&format!("decode second.ast {editions} --out second.jsonl"));
        let (first, second) = (records(&folder, "first.jsonl"), records(&folder, "second.jsonl"));
        assert!(
            !first.is_empty() && said.starts_with("koseki: second.ast:"),
            "{name}: {said}"
        );
        assert_eq!(said.contains("left out"), !is_lossless, "{name}: {said}");
        if is_lossless {
            assert!(first == second, "{name}");
        } else {
            let undefined = |record: &&Value| !record.to_string().contains('\u{FFFD}');
            assert!(first.iter().filter(undefined).eq(&second), "{name}");
        }
    }
}

#[test]
fn records_come_from_standard_input_and_go_to_standard_output() {
    let folder = Folder::new();
    let mut encode = folder
        .command("encode - --out -")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let lines = [
        json!({"_c": 10, "140": 0.5, "000": 1, "010": {"SIC": 7, "SAC": 0}}),
        json!({"_c": 10, "000": 1, "010": {"SIC": 8, "SAC": 0}, "_ts": 3.5}),
        json!({"_c": 48, "010": {"SAC": 1, "SIC": 2}}),
    ];
    let text: String = lines.iter().map(|line| format!("{line}\n\n")).collect();
    encode.stdin.take().unwrap().write_all(text.as_bytes()).unwrap();
    let output = encode.wait_with_output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{said}");
    assert_eq!(said, "koseki: -: 3 records in 2 blocks\n");
    let first = [0b1101_0000, 0, 7, 1, 0, 0, 64];
    let second = [0b1100_0000, 0, 8, 1];
    let expected = [&[10, 0, 14][..], &first, &second, &[48, 0, 6, 0x80, 1, 2]].concat();
    assert_eq!(output.stdout, expected);
}

#[test]
fn what_cannot_be_written_is_named_with_its_line_place_and_value() {
    let folder = Folder::new();
    let good = r#"{"_c":48,"010":{"SAC":1,"SIC":2}}"#;
    let cases = [
        ("{\"_c\":48", "JSON", "line 2: no JSON object on a line"),
        (r#"{"010":{"SAC":1,"SIC":2}}"#, "_c", "the category is missing: add it"),
        (
            r#"{"_c":250}"#,
            "category 250",
            "there is no table of category 250; there are 1, 2, 4, 8",
        ),
        (
            r#"{"_c":48,"999":1}"#,
            "I048/999",
            "I048/999: the edition defines nothing of this name here (edition 1.31)",
        ),
        (
            r#"{"_c":48,"010":{"SAC":256,"SIC":2}}"#,
            "I048/010",
            "I048/010 SAC: 256 is out of range, the least is 0, the greatest 255",
        ),
        (
            r#"{"_c":48,"010":{"SAC":1}}"#,
            "I048/010",
            "I048/010 SIC: is missing, but its group is always sent completely",
        ),
        (
            r#"{"_c":48,"010":{"SAC":"x","SIC":2}}"#,
            "I048/010",
            "I048/010 SAC: takes a whole number without sign, found a text",
        ),
        (
            r#"{"_c":48,"250":[{"MBDATA":"0","BDS1":4,"BDS2":0}]}"#,
            "I048/250",
            "I048/250 [1]",
        ),
    ];
    for (line, place, expected) in cases {
        folder.write("wrong.jsonl", format!("{good}\n{line}\n{good}\n"));
        let (_, said) = folder.succeed("encode wrong.jsonl --out out.ast");
        assert!(said.starts_with("koseki: out.ast: 2 records in 1 block\n"), "{said}");
        let left_out = format!("1 record left out for {place}, the first: line 2: ");
        assert!(said.contains(&left_out) && said.contains(expected), "{said}");
        std::fs::remove_file(folder.path("out.ast")).unwrap();
        let refused = folder.refusal("encode wrong.jsonl --strict --out out.ast");
        assert!(
            refused.contains("wrong.jsonl: line 2: ") && refused.contains(expected),
            "{refused}"
        );
        assert!(!folder.path("out.ast").exists(), "nothing is written");
    }
    let refused = folder.refusal("encode wrong.jsonl --out wrong.jsonl");
    assert!(refused.contains("is the input itself"), "{refused}");
}
