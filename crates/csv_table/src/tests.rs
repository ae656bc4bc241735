use proptest::prelude::*;

use super::*;

/// Returns the numbers of column `b`, or the errors.
fn column_b(text: &[u8]) -> Vec<Result<f64, String>> {
    let mut table = Table::new(text).unwrap();
    let column = table.required("b").unwrap();
    let mut found = Vec::new();
    while let Some(row) = table.next_row() {
        found.push(
            row.and_then(|row| row.number(column))
                .map_err(|error| error.to_string()),
        );
    }
    found
}

#[test]
fn columns_are_found_by_name_whatever_the_line_ends() {
    for text in [
        "a,b\n1,2\n3,4\n",
        " a , b\r\n\r\n1,2\r\n \r\n3, 4",
        "\u{feff}b,c,a\n2,,1\n\n4,,3",
    ] {
        assert_eq!(column_b(text.as_bytes()), [Ok(2.0), Ok(4.0)], "{text:?}");
    }
    assert!(column_b(b"a,b").is_empty());
}

#[test]
fn errors_name_line_column_value_and_remedy_and_reading_goes_on() {
    let text = b"a,b\r\n1,2\r\n\r\n1,x\r\n1\r\n1,inf\r\n1,\r\n1,\xff\r\n1,\"2\"\r\n1,\"2\r\n1,3";
    let expected = [
        Ok(2.0),
        Err("line 4, column b: \"x\" is no number; write one like -12.5"),
        Err("line 5: 1 values, but the header names 2 columns"),
        Err("line 6, column b: \"inf\" is not finite; leave out rows without a value"),
        Err("line 7, column b: \"\" is empty; write a number"),
        Err("line 8, column b: \"\u{fffd}\" is not UTF-8 text"),
        Ok(2.0),
        Err("line 10: a value begins with a quotation mark and none ends it; write both, or none"),
        Ok(3.0),
    ];
    assert_eq!(column_b(text), expected.map(|one| one.map_err(str::to_owned)));
}

#[test]
fn a_header_that_lacks_or_repeats_a_column_is_refused() {
    let fault_of = |octets: &[u8]| Table::new(octets).unwrap().required("b").unwrap_err().to_string();
    let fault = |text: &str| fault_of(text.as_bytes());
    assert_eq!(fault("a,c\n"), "header: column b is missing; the header is \"a,c\"");
    assert_eq!(fault(""), "header: column b is missing; the header is \"\"");
    assert!(fault("b,a,b\n").contains("more than once"));
    assert!(fault("a;b\n1;2\n").contains("by commas, not semicolons"));
    assert!(fault("a\tb\n").contains("by commas, not tabs"));
    assert!(fault_of(b"\xff\xfea\0,\0b\0").contains("save it as UTF-8"));
    assert!(fault("# a table\na,b\n").contains("not a comment"));
}

#[test]
fn a_column_under_another_name_has_the_unit_of_the_reader() {
    let mut table = Table::new(&b"Azimuth (deg),x,x,lat,lat_deg\n180,1,2,nan,3\n"[..]).unwrap();
    let bearing = table.required("bearing_rad").unwrap();
    assert_eq!((bearing.name(), bearing.is_foreign()), ("azimuth_deg", true));
    assert!(table.optional("scan").unwrap().is_none() && !table.states("scan"));
    let fault = |name| table.optional(name).unwrap_err().to_string();
    assert!(fault("x").contains("more than once"));
    assert_eq!(
        fault("latitude"),
        "header: columns lat and lat_deg state one quantity; leave one of them out, or give it a name of your own"
    );
    let own = table.spelled("lat").unwrap().unwrap();
    assert_eq!(table.unread(&[Some(bearing), Some(own)]), ["x", "x", "lat_deg"]);
    let row = table.next_row().unwrap().unwrap();
    assert!((row.number(bearing).unwrap() - std::f64::consts::PI).abs() < 1e-12);
    // Words for an absent value are those of other programs.
    assert!(
        row.number_or_empty(own)
            .unwrap_err()
            .to_string()
            .contains("is not finite")
    );
}

#[test]
fn a_word_for_an_absent_value_is_unknown_under_another_name() {
    let mut table = Table::new(&b"lat,time\nnan,None\n"[..]).unwrap();
    let [latitude, time] = ["latitude", "time_s"].map(|name| table.required(name).unwrap());
    let row = table.next_row().unwrap().unwrap();
    assert_eq!(
        (row.number_or_empty(latitude).unwrap(), row.stated(time).unwrap()),
        (None, None)
    );
    assert!(
        row.number(latitude)
            .unwrap_err()
            .to_string()
            .contains("line 2, column lat: \"nan\" is not finite")
    );
}

#[test]
fn times_are_exact_to_the_nanosecond() {
    let time = |text: &str| {
        let text = format!("b\n{text}\n");
        let mut table = Table::new(text.as_bytes()).unwrap();
        let column = table.required("b").unwrap();
        table
            .next_row()
            .unwrap()
            .unwrap()
            .utc_ns(column, 0)
            .map_err(|error| error.to_string())
    };
    assert_eq!(time("3999999.999999999"), Ok(3_999_999_999_999_999));
    assert_eq!(time("-0.000000001"), Ok(-1));
    assert_eq!(time("1620114891.123456789"), Ok(1_620_114_891_123_456_789));
    assert!(time("4000001").unwrap_err().contains("from midnight"));
}

#[test]
fn times_count_from_a_midnight_or_from_1970() {
    const DAY_NS: i64 = 86_400_000_000_000;
    let time = |text: &str| {
        let text = format!("b\n{text}\n");
        let mut table = Table::new(text.as_bytes()).unwrap();
        let column = table.required("b").unwrap();
        let row = table.next_row().unwrap().unwrap();
        row.utc_ns(column, DAY_NS).map_err(|error| error.to_string())
    };
    assert_eq!(time("1.5"), Ok(DAY_NS + 1_500_000_000));
    assert_eq!(time("-3999999.999999999"), Ok(DAY_NS - 3_999_999_999_999_999));
    for (text, ns) in [
        ("1795880310", 1_795_880_310_000_000_000),
        ("1795880310.123456789", 1_795_880_310_123_456_789),
        (" \"1795880310.1234567891\" ", 1_795_880_310_123_456_789),
        ("1.5e9", 1_500_000_000_000_000_000),
    ] {
        assert_eq!(time(text), Ok(ns), "{text}");
    }
    assert!(
        time("2026-11-28T15:38:31Z")
            .unwrap_err()
            .contains("count seconds from midnight")
    );
    // Milliseconds, a date as digits, and a time of no clock.
    for text in ["1795880310123", "20261128", "-5e8"] {
        assert!(time(text).unwrap_err().contains("or from 1970"), "{text}");
    }
}

#[test]
fn an_input_that_fails_ends_the_table() {
    struct Failing(&'static [u8]);
    impl Read for Failing {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            match self.0.read(buffer)? {
                0 => Err(io::Error::other("unplugged")),
                count => Ok(count),
            }
        }
    }
    let mut table = Table::new(Failing(b"b\n1\n2\n")).unwrap();
    assert!(table.next_row().unwrap().is_ok() && table.next_row().unwrap().is_ok());
    assert!(table.next_row().unwrap().unwrap_err().to_string().contains("unplugged"));
    assert!(table.next_row().is_none());
}

proptest! {
    #[test]
    fn any_octets_are_a_table_or_an_error(octets in prop::collection::vec(any::<u8>(), 0..200)) {
        let mut text = b"a,b\n".to_vec();
        text.extend(octets);
        let rows = column_b(&text).len();
        prop_assert!(rows <= text.iter().filter(|octet| **octet == b'\n').count());
    }
}
