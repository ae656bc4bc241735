//! Properties of any bytes whatever, read with any table in any mode.
//!
//! Used by the property tests, by the mutated recordings and by the fuzz target: whoever has bytes calls [`check`].

use asterix::encode_error::EncodeFault;
use asterix::text::UNDEFINED;
use asterix::{Category, Decoder, DecoderCounts, Error, JsonLines, Mode, NamedRecord, Record, Value, registry};

/// No byte makes more values than this: eight flags, and the groups around them.
const VALUES_PER_OCTET_MAX: usize = 16;

/// Records and errors that were read.
#[derive(Debug, PartialEq)]
pub(crate) struct Reading {
    /// The records, and where they begin.
    pub(crate) records: Vec<(usize, NamedRecord)>,
    /// The errors, in their order.
    pub(crate) errors: Vec<Error>,
    /// Counts of the decoder.
    pub(crate) counts: DecoderCounts,
}

/// Reads the bytes in all ways, and gives what was read.
///
/// # Panics
/// If a byte is not accounted for, if a record makes more values than its bytes explain, if its values can not be
/// written or do not come back, or if reading again gives anything else.
pub(crate) fn check(table: &'static Category, mode: Mode, bytes: &[u8]) -> Reading {
    let mut octets_in_records = 0;
    let reading = read(table, mode, bytes, |record, named| {
        octets_in_records += record.bytes().len();
        check_record(record, named, mode, bytes);
    });
    for error in &reading.errors {
        assert!(error.offset() <= bytes.len(), "{error}");
        assert!(error.to_string().starts_with(&format!("byte {}: ", error.offset())));
    }
    let counts = &reading.counts;
    assert_eq!(counts.records as usize, reading.records.len());
    assert_eq!(
        octets_in_records + 3 * counts.blocks as usize + counts.octets_skipped as usize,
        bytes.len(),
        "{counts:?}"
    );
    assert_eq!(read(table, mode, bytes, |_, _| ()), reading, "read again");
    reading
}

fn read(table: &'static Category, mode: Mode, bytes: &[u8], mut see: impl FnMut(&Record<'_>, &NamedRecord)) -> Reading {
    let mut decoder = Decoder::new(mode).with_table(table);
    let (mut records, mut errors) = (Vec::new(), Vec::new());
    for record in decoder.records(bytes) {
        match record {
            Ok(record) => {
                let named = NamedRecord::new(&record);
                see(&record, &named);
                records.push((record.offset(), named));
            }
            Err(error) => errors.push(error),
        }
    }
    Reading {
        records,
        errors,
        counts: *decoder.counts(),
    }
}

fn check_record(record: &Record<'_>, named: &NamedRecord, mode: Mode, bytes: &[u8]) {
    let octets = record.bytes();
    assert_eq!(&bytes[record.offset()..][..octets.len()], octets, "where it says it is");
    let values: usize = named.items.iter().map(|(_, value)| count(value)).sum();
    assert!(
        values <= VALUES_PER_OCTET_MAX * octets.len(),
        "{values} values out of {octets:02x?}"
    );
    let (mut line, mut stamped) = (Vec::new(), named.clone());
    stamped.time_stamp_s = Some(1.5);
    stamped.write_json(&mut line);
    assert!(!line.contains(&b'\n'), "one line");
    assert_eq!(written(record, None), String::from_utf8_lossy(&line), "{octets:02x?}");
    for expansion in registry::EXPANSIONS {
        if let Ok(Some(content)) = expansion.read(record) {
            check_expanded(record, &stamped, &content);
            assert!(count(&content) <= VALUES_PER_OCTET_MAX * octets.len(), "{content:?}");
        }
    }
    check_encoding(record, named, mode);
}

/// The record's JSON without a tree.
fn written(record: &Record<'_>, expanded: Option<&Value>) -> String {
    let mut lines = JsonLines::default();
    lines.write(record, Some(1.5), expanded);
    let line = lines.text().strip_suffix(b"\n").expect("a line");
    String::from_utf8(line.to_vec()).expect("UTF-8")
}

/// Checks that the content of an expansion field takes the place of its bytes.
fn check_expanded(record: &Record<'_>, named: &NamedRecord, content: &Value) {
    let mut named = named.clone();
    let fields = named.items.iter_mut().filter(|(name, _)| *name == "RE");
    fields.for_each(|(_, value)| *value = content.clone());
    let mut line = Vec::new();
    named.write_json(&mut line);
    assert_eq!(written(record, Some(content)), String::from_utf8_lossy(&line));
}

fn count(value: &Value) -> usize {
    1 + match value {
        Value::Text(text) => text.chars().count(),
        Value::Bytes(octets) => octets.len(),
        Value::Group(members) => members.iter().map(|(_, value)| count(value)).sum(),
        Value::List(values) => values.iter().map(count).sum(),
        Value::Unsigned(_) | Value::Signed(_) | Value::Quantity(_) => 0,
    }
}

/// Checks that what was read can be written, and is read again as the same values.
fn check_encoding(record: &Record<'_>, named: &NamedRecord, mode: Mode) {
    let mut octets = Vec::new();
    if let Err(error) = named.encode(record.table(), &mut octets) {
        let undefined = matches!(
            error.fault,
            EncodeFault::Character {
                character: UNDEFINED,
                ..
            }
        );
        assert!(undefined, "{error} in {named:?}");
        return;
    }
    assert!(octets.len() <= record.bytes().len(), "never longer than what was read");
    if mode == Mode::Strict && octets.len() == record.bytes().len() {
        assert_eq!(octets, record.bytes(), "nothing is set but what is shown");
    }
    let bytes = block(record.table().number, &octets);
    let mut decoder = Decoder::new(mode).with_table(record.table());
    let mut again = decoder.records(&bytes);
    let decoded = again.next().expect("a record").expect("a good record");
    assert_eq!(&NamedRecord::new(&decoded), named, "{octets:02x?}");
    assert_eq!(decoded.bytes(), octets, "nothing is left over");
}

/// A block with this body.
pub(crate) fn block(category: u8, body: &[u8]) -> Vec<u8> {
    let [high, low] = (body.len() as u16 + 3).to_be_bytes();
    [&[category, high, low], body].concat()
}
