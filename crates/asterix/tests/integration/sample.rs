//! An invented category with an item of every kind, and blocks of it.

pub(crate) use crate::any_bytes::block;
use asterix::table::Layout::{Compound, Element, Explicit, Extended, Group, RandomSequence, Repetitive, RepetitiveFx};
use asterix::table::*;
use asterix::{Block, EncodeError, Error, Mode, NamedRecord, Record, Value, blocks};

const ITEMS: &[Option<Item>] = &[
    Some(Item::new(
        "010",
        "Group",
        Group(&[flag("F"), spare(3), element("HIGH", 8, RAW), element("LOW", 4, RAW)]),
    )),
    Some(Item::new("020", "Unsigned quantity", Element(16, unsigned(0.5, "m")))),
    Some(Item::new("030", "Signed quantity", Element(16, signed(0.25, "m")))),
    Some(Item::new(
        "040",
        "Integers",
        Group(&[
            element("U", 4, NUMBER),
            element("S", 4, Content::Integer { signed: true }),
        ]),
    )),
    Some(Item::new(
        "050",
        "Texts",
        Group(&[element("A", 16, ASCII), element("I", 12, ICAO), element("O", 12, OCTAL)]),
    )),
    Some(Item::new(
        "060",
        "Extended",
        Extended(&[
            &[element("A", 7, RAW)],
            &[element("B", 15, signed(1.0, ""))],
            &[spare(6), flag("C")],
        ]),
    )),
    Some(Item::new("070", "Repetitive", Repetitive(&Element(16, NUMBER)))),
    Some(Item::new("080", "Repetitive by FX", RepetitiveFx(&Element(7, RAW)))),
    Some(Item::new(
        "090",
        "Groups by FX",
        RepetitiveFx(&Group(&[element("UNIT", 8, RAW), element("TRACK", 15, RAW)])),
    )),
    Some(Item::new(
        "100",
        "Compound",
        Compound(&[
            Some(Item::new("ONE", "Element", Element(8, RAW))),
            None,
            Some(Item::new("THREE", "Extended", Extended(&[&[element("T", 7, RAW)]]))),
            None,
            None,
            None,
            None,
            Some(Item::new("EIGHT", "Repetitive", Repetitive(&Element(8, RAW)))),
        ]),
    )),
    Some(Item::new(
        "110",
        "Depends on a flag",
        Group(&[
            flag("IM"),
            element(
                "SPEED",
                15,
                Content::Depends {
                    on: "IM",
                    cases: SPEED_CASES,
                    otherwise: &RAW,
                },
            ),
        ]),
    )),
    Some(Item::new(
        "120",
        "Group in an extended item",
        Extended(&[&[
            flag("A"),
            Part::Group("B", &[flag("EP"), element("VAL", 2, RAW)]),
            spare(3),
        ]]),
    )),
    None,
    Some(Item::new("RE", "Reserved Expansion Field", Explicit)),
    Some(Item::new(
        "130",
        "Extended, the last part without FX bit",
        Extended(&[&[element("A", 7, RAW)], &[element("B", 8, RAW)]]),
    )),
    Some(Item::new("RFS", "Random Field Sequencing", RandomSequence)),
];

const SPEED_CASES: &[(u64, Content)] = &[(0, unsigned(0.5, "m/s")), (1, unsigned(0.001, "Mach"))];

/// Every kind of item.
pub(crate) static SAMPLE: Category = Category {
    number: 250,
    edition: Edition::new(1, 0),
    title: "Sample",
    document: "none",
    times: &[],
    profile: Profile::Single(Uap::new(ITEMS)),
};

const SOURCE: Option<Item> = Some(Item::new("010", "Source", Element(16, RAW)));
const DESCRIPTOR: Option<Item> = Some(Item::new(
    "020",
    "Descriptor",
    Extended(&[&[element("TYP", 2, RAW), spare(5)]]),
));
const PLOT_POSITION: Option<Item> = Some(Item::new("040", "Plot position", Element(16, unsigned(1.0, "m"))));
const TRACK_NUMBER: Option<Item> = Some(Item::new("161", "Track number", Element(24, RAW)));

/// Two profiles, chosen by I251/020 TYP: 0 for plots, 1 for tracks.
pub(crate) static PLOT_OR_TRACK: Category = Category {
    number: 251,
    edition: Edition::new(1, 0),
    title: "Plots and tracks",
    document: "none",
    times: &[],
    profile: Profile::Depends {
        item: "020",
        element: "TYP",
        cases: &[
            (0, Uap::new(&[SOURCE, DESCRIPTOR, PLOT_POSITION])),
            (1, Uap::new(&[SOURCE, DESCRIPTOR, TRACK_NUMBER, PLOT_POSITION])),
        ],
    },
};

/// Reads the only block in `bytes`.
pub(crate) fn only_block(bytes: &[u8]) -> Block<'_> {
    let mut all = blocks(bytes);
    let block = all.next().expect("a block").expect("a possible length");
    assert_eq!(all.next(), None);
    block
}

/// The first record of a body, or what is wrong with it.
pub(crate) fn read(table: &'static Category, mode: Mode, body: &[u8], check: impl FnOnce(Result<Record<'_>, Error>)) {
    let bytes = block(table.number, body);
    check(only_block(&bytes).records(table, mode).next().expect("a record"));
}

/// Item of the sample category, decoded. Its bytes are the whole body behind the FSPEC.
pub(crate) fn item(name: &str, octets: &[u8]) -> Value {
    let mut named = None;
    read(&SAMPLE, Mode::Lenient, &[&fspec(name), octets].concat(), |record| {
        let record = record.expect("a good record");
        assert_eq!(record.item_named(name), Some(octets));
        named = NamedRecord::new(&record).items.pop();
    });
    named.expect("an item").1
}

/// The error in a record of the sample category with this item.
pub(crate) fn error(mode: Mode, name: &str, octets: &[u8]) -> Error {
    let mut error = None;
    let body = [&fspec(name), octets].concat();
    read(&SAMPLE, mode, &body, |record| error = record.err());
    error.expect("an error")
}

/// The FSPEC that announces one item of the sample category.
fn fspec(name: &str) -> Vec<u8> {
    let position = SAMPLE
        .uap()
        .names()
        .position(|candidate| candidate == name)
        .expect("a name");
    let mut octets = vec![0x01; position / 7];
    octets.push(0x80 >> (position % 7));
    octets
}

/// The bytes of one item of the sample category, or what is wrong with its value.
pub(crate) fn encode_item(name: &'static str, value: Value) -> Result<Vec<u8>, EncodeError> {
    let mut octets = vec![];
    let encoded = NamedRecord::of(SAMPLE.number, [(name, value)]).encode(&SAMPLE, &mut octets);
    encoded.map(|()| octets.split_off(fspec(name).len()))
}
