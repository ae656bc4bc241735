//! CAT019 ed 1.3: status messages of a multilateration system.
//!
//! EUROCONTROL-SPEC-0149-18 (SUR.ET1.ST05.2000-STD-18-01), December 2010.

use super::{RE, SP};
use crate::table::Layout::{Element, Extended, Group, Repetitive};
use crate::table::*;

// 1 start of update cycle, 2 periodic status, 3 event status
const I000: Item = Item::new("000", "Message Type", Element(8, RAW));

const I010: Item = Item::new(
    "010",
    "Data Source Identifier",
    Group(&[
        element("SAC", 8, RAW), // system area code
        element("SIC", 8, RAW), // system identification code
    ]),
);

const I140: Item = Item::new("140", "Time of Day", Element(24, unsigned(1.0 / pow2(7), "s")));

const I550: Item = Item::new(
    "550",
    "System Status",
    Group(&[
        element("NOGO", 2, RAW), // 0 operational, 1 degraded, 2 do not use, 3 undefined
        flag("OVL"),             // overload
        flag("TSV"),             // time source invalid
        flag("TTF"),             // test target failure
        spare(3),
    ]),
);

const I551: Item = Item::new(
    "551",
    "Tracking Processor Detailed Status",
    Group(&[
        flag("TP1A"), // processor 1: 0 standby, 1 executing
        flag("TP1B"), // processor 1: 0 faulted, 1 good; both bits zero: not used
        flag("TP2A"),
        flag("TP2B"),
        flag("TP3A"),
        flag("TP3B"),
        flag("TP4A"),
        flag("TP4B"),
    ]),
);

const I552: Item = Item::new(
    "552",
    "Remote Sensor Detailed Status",
    Repetitive(&Group(&[
        element("RSI", 8, RAW), // number of the remote sensor
        spare(1),
        flag("RS1090"), // receiver 1090 MHz present
        flag("TX1030"), // transmitter 1030 MHz present
        flag("TX1090"), // transmitter 1090 MHz present
        flag("RSS"),    // 0 faulted, 1 good
        flag("RSO"),    // 0 offline, 1 online
        spare(2),
    ])),
);

const I553: Item = Item::new(
    "553",
    "Reference Transponder Detailed Status",
    Extended(&[
        &[
            element("REFTR1", 2, RAW), // 1 warning, 2 faulted, 3 good
            spare(2),
            element("REFTR2", 2, RAW),
            spare(1),
        ],
        &[element("REFTR3", 2, RAW), spare(2), element("REFTR4", 2, RAW), spare(1)],
    ]),
);

const I600: Item = Item::new(
    "600",
    "Position of the MLT System Reference Point",
    Group(&[
        element("LAT", 32, signed(180.0 / pow2(30), "°")),
        element("LON", 32, signed(180.0 / pow2(30), "°")),
    ]),
);

const I610: Item = Item::new(
    "610",
    "Height of the MLT System Reference Point", // above mean sea level
    Element(16, signed(1.0 / pow2(2), "m")),
);

const I620: Item = Item::new("620", "WGS-84 Undulation", Element(8, signed(1.0, "m")));

/// In the document's order.
#[rustfmt::skip]
const ITEMS: &[Item] = &[
    I000, I010, I140, I550, I551, I552, I553, I600,
    I610, I620, RE, SP,
];

#[rustfmt::skip]
const ORDER: &[&str] = &[
    "010", "000", "140", "550", "551", "552", "553", // FRN 1 to  7
    "600", "610", "620", SPARE, SPARE, "RE", "SP",   //     8 to 14
];

/// Multilateration system status, ed 1.3.
pub static CAT019_V1_3: Category = Category {
    number: 19,
    edition: Edition::new(1, 3),
    title: "Multilateration System Status Messages",
    document: "EUROCONTROL-SPEC-0149-18",
    items: ITEMS,
    profile: Profile::Single(Uap::new(ITEMS, ORDER)),
};

/// Every edition of the category.
pub static CAT019: &[&Category] = &[&CAT019_V1_3];
