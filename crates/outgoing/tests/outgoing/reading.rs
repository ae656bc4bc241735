//! Sent blocks, read back by the tables.

use asterix::{Category, Mode, NamedRecord, Value, blocks};

/// The records of a sent block, which must be perfect.
pub(crate) fn records(table: &'static Category, block: &[u8]) -> Vec<NamedRecord> {
    let mut found = vec![];
    for block in blocks(block) {
        let block = block.expect("a block");
        assert_eq!(block.category, table.number);
        for record in block.records(table, Mode::Strict) {
            found.push(NamedRecord::new(
                &record.unwrap_or_else(|error| panic!("{table}: {error}")),
            ));
        }
    }
    found
}

/// A record with the names of its table's items for its messages.
pub(crate) struct Sent<'r> {
    pub(crate) record: &'r NamedRecord,
    pub(crate) table: &'static Category,
}

impl Sent<'_> {
    /// True if it has an item or subitem.
    pub(crate) fn has(&self, path: &[&str]) -> bool {
        self.record.get(path).is_some()
    }

    /// A code or number; 0 where it is in a part of an extended item that was not sent.
    pub(crate) fn number(&self, path: &[&str]) -> u64 {
        match self.record.get(path) {
            None => 0,
            Some(Value::Unsigned(number)) => *number,
            Some(other) => panic!("{}: {path:?} is {other:?}", self.table),
        }
    }

    pub(crate) fn quantity(&self, path: &[&str]) -> f64 {
        match self.record.get(path) {
            Some(Value::Quantity(value)) => *value,
            other => panic!("{}: {path:?} is {other:?}", self.table),
        }
    }

    pub(crate) fn text(&self, path: &[&str]) -> Option<&str> {
        match self.record.get(path) {
            None => None,
            Some(Value::Text(text)) => Some(text),
            Some(other) => panic!("{}: {path:?} is {other:?}", self.table),
        }
    }

    /// The number is the expected one.
    pub(crate) fn is(&self, path: &[&str], expected: impl Into<u64>) {
        assert_eq!(self.number(path), expected.into(), "{}: {path:?}", self.table);
    }

    /// The quantity is within half an LSB of the expected one (and of what calculating it twice may differ by).
    pub(crate) fn near(&self, path: &[&str], expected: f64, lsb: f64) {
        let sent = self.quantity(path);
        let off = (sent - expected).abs();
        assert!(
            off <= lsb * (0.5 + 1e-3),
            "{}: {path:?} is {sent}, expected {expected}, off by {} LSB",
            self.table,
            off / lsb
        );
    }

    /// The quantity is there and near, or there is none and none was expected.
    pub(crate) fn near_if(&self, path: &[&str], expected: Option<f64>, lsb: f64) {
        match expected {
            Some(expected) => self.near(path, expected, lsb),
            None => assert!(!self.has(path), "{}: {path:?} was sent", self.table),
        }
    }

    /// Compares as [`near`](Self::near) does, on a circle of 360 degrees.
    pub(crate) fn near_turn(&self, path: &[&str], expected_deg: f64, lsb: f64) {
        let sent = self.quantity(path);
        let off = (sent - expected_deg + 180.0).rem_euclid(360.0) - 180.0;
        assert!(
            off.abs() <= lsb * (0.5 + 1e-3),
            "{}: {path:?} is {sent}°, expected {expected_deg}°",
            self.table
        );
    }

    /// A standard deviation: near, but at least one LSB, and at most the greatest number of the bits where it is
    /// capped.
    pub(crate) fn near_sigma(&self, path: &[&str], sigma: f64, lsb: f64, greatest: u64) {
        self.near(path, sigma.clamp(lsb, greatest as f64 * lsb), lsb);
    }

    /// Latitude and longitude of a group.
    pub(crate) fn near_place(&self, item: &str, place: frames::Geodetic, lsb_deg: f64) {
        self.near(&[item, "LAT"], place.latitude_deg(), lsb_deg);
        self.near_turn(&[item, "LON"], place.longitude_deg(), lsb_deg);
        let longitude = self.quantity(&[item, "LON"]);
        assert!(
            (-180.0..180.0).contains(&longitude),
            "{}: longitude {longitude}",
            self.table
        );
    }

    /// Time of day, s.
    pub(crate) fn near_time(&self, path: &[&str], utc_ns: i64) {
        const DAY_S: f64 = 86_400.0;
        let sent = self.quantity(path);
        assert!((0.0..DAY_S).contains(&sent), "{}: time of day {sent} s", self.table);
        let expected = utc_ns.rem_euclid(86_400_000_000_000) as f64 / 1e9;
        let off = (sent - expected + DAY_S / 2.0).rem_euclid(DAY_S) - DAY_S / 2.0;
        assert!(
            off.abs() <= 1.0 / 256.0 + 1e-9,
            "{}: {path:?} off by {off} s",
            self.table
        );
    }
}
