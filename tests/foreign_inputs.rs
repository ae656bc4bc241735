//! Inputs as other people and programs write them: spreadsheets, scripts, receivers. Each is read, or refused in one
//! line that names the place, the value, the limit and the remedy.

use std::io::Write as _;
use std::process::Stdio;

use crate::common::{Folder, Home, PLACE, S, utc_ns};

/// Columns of sensor tracks, and of ships' tracks.
const HEADER: &str = "time_s,sensor_id,sensor_track_id,x,y,z,vx,vy,vz,trace,state,mmsi";

/// Three reports of a ship, the second with its time and its MMSI in place of those given.
fn ship([time, mmsi]: [&str; 2]) -> String {
    format!(
        "{HEADER}\n10,1,7,0,0,0,5,0,0,200,confirmed,\n{time},1,7,5,0,0,5,0,0,200,confirmed,{mmsi}\n\
         12,1,7,10,0,0,5,0,0,200,confirmed,\n"
    )
}

/// A table with quotation marks around every value, and the line ends and the mark of another system.
fn quoted(table: &str) -> String {
    let lines = table
        .lines()
        .map(|line| format!("\"{}\"\r\n", line.replace(',', "\",\"")));
    format!("\u{feff}{}", lines.collect::<String>())
}

/// Tables of sensor tracks: what they have, the text, the reports that are used, and words of the summary.
fn read_tables() -> Vec<(&'static str, String, usize, &'static [&'static str])> {
    let plain = ship(["11", ""]);
    let since_1970 = plain.replace("\n1", "\n17958803");
    vec![
        ("plain", plain.clone(), 3, &[]),
        ("quotes, a byte order mark, CR LF", quoted(&plain), 3, &[]),
        (
            "a blank before a quote",
            plain.replace(",confirmed", ", \"confirmed\" "),
            3,
            &[],
        ),
        (
            "times with 12 decimals",
            plain.replace(",1,7,", ".123456789012,1,7,"),
            3,
            &[],
        ),
        ("times since 1970", since_1970.clone(), 3, &[]),
        (
            "times since 1970 with 12 decimals",
            since_1970.replace(",1,7,", ".123456789012,1,7,"),
            3,
            &[],
        ),
        (
            "one time since 1970",
            ship(["1795880311", ""]),
            2,
            &[
                "line 3, column time_s: \"1795880311\"",
                "count all times from midnight or all from 1970",
            ],
        ),
        (
            "a time of ISO 8601",
            ship(["2026-11-28T15:38:31Z", ""]),
            2,
            &[
                "line 3, column time_s: \"2026-11-28T15:38:31Z\"",
                "is no number; count seconds from midnight",
            ],
        ),
        (
            "milliseconds",
            ship(["1795880311000", ""]),
            2,
            &["line 3, column time_s: \"1795880311000\" is no time", "or from 1970"],
        ),
        (
            "a stray quotation mark",
            plain.replacen(",confirmed", ",\"confirmed", 1),
            2,
            &[
                "left out: 1 rows",
                "line 2: a value begins with a quotation mark and none ends it; write both, or none",
            ],
        ),
        (
            "an MMSI of a coast station without its zeros",
            ship(["11", "2275400"]),
            3,
            &[],
        ),
        ("an MMSI in quotes", ship(["11", "\"002275400\""]), 3, &[]),
        // An external program may have published it, and the recorder has written it.
        ("seven digits that are no MMSI", ship(["11", "1193046"]), 3, &[]),
    ]
}

/// Tables of sensor tracks that are refused as a whole, and words of the refusal.
fn refused_tables() -> Vec<(&'static str, Vec<u8>, &'static [&'static str])> {
    let plain = ship(["11", ""]);
    let utf16 = plain.encode_utf16().flat_map(u16::to_le_bytes);
    vec![
        (
            "semicolons",
            plain.replace(',', ";").into(),
            &["column time_s is missing", "by commas, not semicolons"],
        ),
        (
            "UTF-16",
            [0xff, 0xfe].into_iter().chain(utf16).collect(),
            &["is UTF-16; save it as UTF-8"],
        ),
        (
            "a column given twice",
            plain.replace(",trace,", ",x,").into(),
            &["column x stands there more than once"],
        ),
        (
            "a header whose quotes have no end",
            format!("\"{plain}").into(),
            &["line 1: a value begins with a quotation"],
        ),
        (
            "only stray quotes",
            plain.replace(",confirmed", ",\"confirmed").into(),
            &["no row can be used", "line 2: "],
        ),
    ]
}

#[test]
fn tables_are_read_however_they_are_written() {
    for (what, text, used, words) in read_tables() {
        let folder = Folder::with(&[("tracks.csv", text)]);
        let (_, said) = folder.succeed("fuse --tracks tracks.csv --out fused.csv");
        let reports = said.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(reports.contains(&format!("sensor 1 {used} reports")), "{what}: {said}");
        assert_eq!(reports.contains("left out"), used < 3, "{what}: {said}");
        for words in words {
            assert!(reports.contains(words), "{what}: {words} is missing in {said}");
        }
        let fused = folder.read("fused.csv");
        if what.contains("12 decimals") {
            assert!(fused.contains(".123456789,"), "{what}: {fused}");
        }
    }
    for (what, text, words) in refused_tables() {
        let folder = Folder::with(&[("tracks.csv", text)]);
        let said = folder.refusal("fuse --tracks tracks.csv --out fused.csv");
        for words in words {
            assert!(said.contains(words), "{what}: {words} is missing in {said}");
        }
    }
}

/// Lines of JSON for `koseki encode`: the text, the records that are written, and words of the notes.
const RECORDS: [(&str, usize, &[&str]); 3] = [
    (
        "\u{feff}{\"_c\":10,\"010\":{\"SAC\":0,\"SIC\":7},\"000\":1,\"140\":43200.5}\n",
        1,
        &[],
    ),
    (
        "{\"_c\":10,\"000\":1,\"140\":5}\n{\"_c\":10,\"000\":1,\"140\":43200.5,\"140\":5}\n",
        1,
        &[
            "a key that is given twice",
            "line 2: \"140\" is given twice: leave out one",
        ],
    ),
    (
        "{\"_c\":10,\"000\":1,\"140\":5}\n{\"_c\":10,\"010\":{\"SAC\":0,\"SIC\":7,\"SIC\":8}}\n",
        1,
        &["line 2: \"SIC\" is given twice: leave out one"],
    ),
];

#[test]
fn records_are_encoded_unless_a_key_has_two_values() {
    for (text, written, words) in RECORDS {
        let folder = Folder::with(&[("records.jsonl", text)]);
        let (_, said) = folder.succeed("encode records.jsonl --out blocks.ast");
        assert!(
            said.contains(&format!("blocks.ast: {written} record")),
            "{text}: {said}"
        );
        assert_eq!(said.contains("left out"), !words.is_empty(), "{text}: {said}");
        for words in words {
            assert!(said.contains(words), "{text}: {words} is missing in {said}");
        }
        if !words.is_empty() {
            let said = folder.refusal("encode records.jsonl --strict --out strict.ast");
            assert!(said.contains("line 2: ") && said.contains("is given twice"), "{said}");
        }
    }
}

/// Fields of lines for `koseki feed` beside a place, and words of the answer to a refused line, of which the first is
/// its field. `NOW` stands for the present time to the second, `SECONDS` for the same since 1970.
const LINES: [(&str, &[&str]); 14] = [
    ("", &[]),
    ("\u{feff}", &[]),
    ("\"time\": \"NOW.123456789012Z\"", &[]),
    ("\"time_s\": SECONDS.123456789012", &[]),
    ("\"mmsi\": \"211234560\"", &[]),
    ("\"mmsi\": \"002275400\"", &[]),
    ("\"mmsi\": 2275400", &[]),
    (
        "\"mmsi\": 1193046",
        &["mmsi", "1193046", "an MMSI of nine digits", "211234560"],
    ),
    (
        "\"mmsi\": \"1193046\"",
        &["mmsi", "1193046", "an MMSI of nine digits", "211234560"],
    ),
    (
        "\"latitude\": 41.5",
        &["latitude", "41.5", "must be given once", "leave out all values but one"],
    ),
    ("\"height_m\": 5, \"height_m\": 5", &["height_m", "must be given once"]),
    (
        "\"time\": \"28.11.2026 15:38\"",
        &["time", "must be a text of UTC", "2026-05-01T10:00:00.5Z"],
    ),
    (
        "\"time_ns\": SECONDS",
        &["time_of_measurement_ns", "within 600 s", "multiply it by 1000000000"],
    ),
    (
        "\"sigma\": 5",
        &["sigma", "is no field of such a source", "did you mean"],
    ),
];

#[test]
fn lines_are_fed_however_they_are_written() {
    let home = Home::new();
    let [latitude, longitude] = PLACE;
    home.write(
        "site.toml",
        format!(
            "name = \"test\"\nframe = {{ latitude_deg = {latitude}, longitude_deg = {longitude} }}\n\
             recorder = {{ enabled = false }}\ndisplay = {{ listen = \"off\" }}\n[[source]]\nname = \"own\"\n\
             [source.external]\ninput = \"detections\"\n"
        ),
    );
    let running = home.start(&["up", "site.toml", "--instance", "test", "--out", "out"]);
    running.until_said("instance test runs");
    let mut feed = home.command(&["feed", "--instance", "test", "--source", "own", "--json"]);
    let mut feed = feed.stdin(Stdio::piped()).spawn().unwrap();
    let mut input = feed.stdin.take().unwrap();
    let now_ns = utc_ns();
    let now = formats::rows::Utc(now_ns / S * S).to_string();
    for (fields, _) in LINES {
        let fields = fields.replace("NOW", now.trim_end_matches('Z'));
        let fields = fields.replace("SECONDS", &(now_ns / S).to_string());
        let (mark, fields) = match fields.strip_prefix('\u{feff}') {
            Some(fields) => ("\u{feff}", fields),
            None => ("", fields.as_str()),
        };
        let comma = if fields.is_empty() { "" } else { ", " };
        writeln!(
            input,
            "{mark}{{\"latitude\": 41.4, \"longitude\": 2.1, \"sigma_m\": 10{comma}{fields}}}"
        )
        .unwrap();
    }
    drop(input);
    let output = feed.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let text = String::from_utf8(output.stdout).unwrap();
    let mut answers: Vec<serde_json::Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let summary = answers.pop().unwrap();
    let refused = (1..).zip(LINES).filter(|(_, (_, words))| !words.is_empty());
    for ((line, (fields, words)), answer) in refused.clone().zip(&answers) {
        assert_eq!(answer["line"], line, "{fields}: {text}");
        assert_eq!(answer["field"], words[0], "{fields}: {text}");
        for words in words {
            assert!(
                answer.to_string().contains(words),
                "{fields}: {words} is missing in {answer}"
            );
        }
    }
    assert_eq!(answers.len(), refused.count(), "{text}");
    assert_eq!(summary["published"], LINES.len() - answers.len(), "{text}");
    running.stop();
    home.assert_nothing_is_left("test");
}
