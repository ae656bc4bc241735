//! Tables of every sort, read, refused and printed.

use std::collections::BTreeMap;

use super::*;

settings! {
    /// All sorts of keys.
    struct Site with place: Spot {
        check Site::check;
        /// Name. It must be given.
        name: String;
        /// Time between two looks.
        period_s: Seconds = Seconds::of(4.0), in [0.1, 60];
        /// Limit of something, at most `period_s`.
        wait_s: Option<f64> = Some(1.0), in [from 0];
        /// Way of doing it.
        way: Way = Way::Slow;
        /// Two factors.
        factors: [f64; 2] = [1.0, 2.0], in [above 0];
        /// Shares by name.
        shares: BTreeMap<String, f64> = BTreeMap::new(), in [0, 1];
        /// Parts.
        parts as "part": Vec<Part> = Vec::new();
        /// Spare part.
        spare: Option<Part> = None;
    }

    /// A place.
    #[derive(Copy)]
    struct Spot {
        /// Direction.
        bearing_deg: Degrees = Degrees::of(90.0), in [-360, 360];
    }

    /// A part.
    struct Part {
        /// How many.
        count: usize = 1, in [1, 9];
    }
}

words! {
    /// Ways.
    enum Way {
        /// Slowly.
        Slow = "slow",
        /// Quickly.
        Quick = "quick",
    }
}

impl Site {
    fn check(&self) -> Result<(), SettingsError> {
        within("wait_s", self.wait_s.unwrap_or(0.0), 0.0, self.period_s.s())
    }
}

fn read(text: &str, overrides: &[&str]) -> Result<Site, SettingsError> {
    let overrides: Vec<String> = overrides.iter().map(|each| (*each).to_owned()).collect();
    let document = Document::parse(text, &overrides)?;
    document.read()
}

#[test]
fn what_is_given_is_taken_and_the_rest_is_as_usual() {
    let named = Site {
        name: "a".to_owned(),
        ..Site::default()
    };
    assert_eq!(read("name = \"a\"", &[]).unwrap(), named);
    let text = "name = \"b\"\nbearing_deg = 180\nperiod_s = 2\nwait_s = \"off\"\nway = \"quick\"\nfactors = [3, 0.5]\n\
                shares = { x = 1 }\nspare = {}\n[[part]]\ncount = 2\n[[part]]\n";
    let expected = Site {
        place: Spot {
            bearing_deg: Degrees::of(180.0),
        },
        name: "b".to_owned(),
        period_s: Seconds::of(2.0),
        wait_s: None,
        way: Way::Quick,
        factors: [3.0, 0.5],
        shares: [("x".to_owned(), 1.0)].into(),
        parts: vec![Part { count: 2 }, Part { count: 1 }],
        spare: Some(Part { count: 1 }),
    };
    assert_eq!(read(text, &[]).unwrap(), expected);
    let changed = read(text, &["part[1].count=5", "way=slow", "spare.count = 3"]).unwrap();
    assert_eq!((changed.parts[1].count, changed.way), (5, Way::Slow));
    assert_eq!(changed.spare, Some(Part { count: 3 }));
}

#[test]
fn mistakes_are_named_with_path_line_value_and_remedy() {
    for (text, line, expected) in [
        ("period_s = 1", None, "name: missing; the key is mandatory"),
        ("name = 3", Some(1), "name: 3 is no text; write a text in quotes"),
        (
            "name = \"a\"\nperiod_s = 0",
            Some(2),
            "period_s: 0 is out of range; it must lie between 0.1 and 60",
        ),
        ("name = \"a\"\nperiod_s = nan", Some(2), "period_s: NaN is out of range"),
        (
            "name = \"a\"\nwait_s = -1",
            Some(2),
            "wait_s: -1 is out of range; it must be 0 or greater",
        ),
        (
            "name = \"a\"\nwait_s = \"of\"",
            Some(2),
            "wait_s: \"of\" is no number; write the number alone (the unit, s, is in the name of the key), or \"off\"",
        ),
        (
            "name = \"a\"\nwait_s = 5",
            Some(2),
            "wait_s: 5 is out of range; it must lie between 0 and 4",
        ),
        (
            "name = \"a\"\nway = \"fast\"",
            Some(2),
            "way: \"fast\" is not known; there are: slow, quick",
        ),
        (
            "name = \"a\"\nfactors = [1]",
            Some(2),
            "factors: 1 values; write 2, like [1.0, 2.0]",
        ),
        (
            "name = \"a\"\nfactors = [1, 0]",
            Some(2),
            "factors: 0 is out of range; it must be greater than 0",
        ),
        ("name = \"a\"\n[shares]\ny = 2", Some(3), "shares.y: 2 is out of range"),
        (
            "name = \"a\"\n[[part]]\n[[part]]\ncount = 10",
            Some(4),
            "part[1].count: 10 is out of range",
        ),
        (
            "name = \"a\"\npart = 3",
            Some(2),
            "part: 3 is no list of tables; write each below [[part]]",
        ),
        (
            "name = \"a\"\n[spare]\ncont = 1",
            Some(3),
            "spare.cont: unknown key; there are: count; did you mean count?",
        ),
        (
            "name = \"a\"\nbearing = 1",
            Some(2),
            "bearing: unknown key; there are: name, period_s, ",
        ),
        (
            "name = \"a\"\nname = \"b\"",
            Some(2),
            "name: is given twice; remove one of the two",
        ),
        (
            "name = \"a\"\n[spare]\n[spare]",
            Some(3),
            "spare: is given twice; write all its keys below one [spare]",
        ),
        (
            "name = \"a\"\n[[part]]\n[part]",
            Some(3),
            "part: is given twice; each table of a list stands below [[part]]",
        ),
        (
            "name = \"a\"\nperiod_s = 4 s # four",
            Some(2),
            "period_s: 4 s is no value; write the number alone (the unit, s, is in the name of the key)",
        ),
        (
            "name = \"a\"\nway = slow",
            Some(2),
            "way: slow is no value; write a number, true, false, or a text in quotes",
        ),
        ("name =", Some(1), "name: the value is missing; write it behind the '='"),
        (
            "name = \"a\"\nperiod_s = \"4\"",
            Some(2),
            "period_s: \"4\" is a text; write 4 without quotes",
        ),
        (
            "name = \"a\"\nperiod_s = \"4 s\"",
            Some(2),
            "period_s: \"4 s\" is no number; write the number alone (the unit, s, is in the name of the key)",
        ),
        (
            "name = \"a\"\nfactors = 3",
            Some(2),
            "factors: 3 is no list; write 2 values, like [1.0, 2.0]",
        ),
        (
            "name = \"a\"\nspare = true",
            Some(2),
            "spare: true is no table; write its keys below [spare]",
        ),
        (
            "name = \"a\"\nspare = {count = -1}",
            Some(2),
            "spare.count: -1 is out of range; it must lie between 1 and 9",
        ),
        (
            "name = \"a\"\nspare = {count = 1.5}",
            Some(2),
            "spare.count: 1.5 is no whole number; write one like 3",
        ),
        (
            "name = \"a\"\nshares = [1]",
            Some(2),
            "shares: a list is no table; write names with values below [shares]",
        ),
    ] {
        let error = read(text, &[]).unwrap_err();
        assert!(error.to_string().starts_with(expected), "{text}: {error}");
        assert_eq!(error.line, line, "{text}");
    }
}

#[test]
fn replacements_are_checked_and_named_without_a_line() {
    for (assignment, expected) in [
        (
            "wait_s=-1",
            "wait_s: -1 is out of range; it must be 0 or greater (--set)",
        ),
        ("nonsense=1", "nonsense: unknown key"),
        ("part[3].count=1", "--set part[3].count=1: there is no part[3]"),
        ("name.x=1", "--set name.x=1: name is not a table"),
        ("name", "--set name: write it as key.path=value"),
    ] {
        let error = read("name = \"a\"\npart = [{}]", &[assignment]).unwrap_err();
        assert!(error.to_string().starts_with(expected), "{assignment}: {error}");
        assert_eq!(error.line, None);
    }
}

#[test]
fn an_error_is_located_once() {
    let overrides = ["wait_s=-1".to_owned()];
    let document = Document::parse("name = \"a\"", &overrides).unwrap();
    let error = document.read::<Site>().unwrap_err();
    assert_eq!(document.located(error.clone()), error);
}

#[test]
fn values_that_no_file_gave_are_checked_alike() {
    let mut site = Site::default();
    assert_eq!(check(&site), Ok(()));
    site.parts = vec![Part::default(), Part { count: 0 }];
    assert_eq!(check(&site).unwrap_err().key, "part[1].count");
    site.parts.clear();
    site.place.bearing_deg = Degrees::of(400.0);
    assert_eq!(check(&site).unwrap_err().key, "bearing_deg");
}

#[test]
fn keys_are_printed_for_people() {
    let site = Site::default();
    let document = reference(&[("Site", "What a site is.", &site)]);
    for expected in [
        "## Site\n\nWhat a site is.\n",
        "| `name` | text |  |  | *must be given* | Name. It must be given. |",
        "| `period_s` | number | s | 0.1 … 60 | `4.0` | Time between two looks. |",
        "| `wait_s` | number, or \"off\" | s | ≥ 0 | `1.0` |",
        "| `bearing_deg` | number | ° | -360 … 360 | `90.0` | Direction. |",
        "### `[[part]]`\n\nA part.\n",
        "### `[spare]`\n\nA part.\n\nThe keys of `[[part]]` (*Site*) stand here, too.\n",
    ] {
        assert!(document.contains(expected), "{expected}\n{document}");
    }
    let text = help(&site, "  ");
    for expected in [
        "  name [must be given]           # Name\n",
        "  [spare]                        # Spare part; off unless given\n",
    ] {
        assert!(text.contains(expected), "{expected}\n{text}");
    }
}

mod shared {
    use crate::{Document, KeyTable as _, Shared, Unread};

    crate::settings! {
        /// A file.
        struct File {
            /// Name of the whole.
            name: String;
            /// Table of another crate.
            other: Unread = Unread;
            /// Size of the whole.
            size: u32 = 1;
        }

        /// The part of another crate.
        struct Part {
            /// Table.
            other: Other = Other::default();
        }

        /// Table of a part.
        struct Other {
            /// Count.
            count: u32 = 0, in [0, 9];
        }
    }

    fn read(text: &str) -> Result<(File, Part), String> {
        let (mut file, mut part) = (File::default(), Part::default());
        let document = Document::parse(text, &[]).unwrap();
        let read = document.read_into(&mut Shared::new(&mut file, vec![&mut part]));
        read.map(|()| (file, part)).map_err(|error| error.to_string())
    }

    #[test]
    fn a_table_is_read_where_its_crate_is_there_and_ignored_elsewhere() {
        let text = "name = \"a\"\n[other]\ncount = 3\n";
        let (file, part) = read(text).unwrap();
        assert_eq!((file.name.as_str(), part.other.count), ("a", 3));
        let error = read(&text.replace('3', "10")).unwrap_err();
        assert!(error.starts_with("other.count: 10 is out of range"), "{error}");
        let alone: File = Document::parse(&text.replace("count", "cuont"), &[])
            .unwrap()
            .read()
            .unwrap();
        assert_eq!(alone.name, "a");
    }

    #[test]
    fn a_shared_table_keeps_the_order_of_the_file_and_refuses_unknown_keys() {
        let (mut file, mut part) = (File::default(), Part::default());
        let shared = Shared::new(&mut file, vec![&mut part]);
        let names: Vec<&str> = shared.keys().iter().map(|key| key.name).collect();
        assert_eq!(names, ["name", "other", "size"]);
        assert_eq!(shared.values()[1].kind(), "table");
        let error = read("name = \"a\"\nothre = 1\n").unwrap_err();
        assert!(
            error.contains("there are: name, other, size; did you mean other?"),
            "{error}"
        );
    }
}
