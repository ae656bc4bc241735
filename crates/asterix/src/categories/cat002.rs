//! CAT002: service messages of a radar, the format before CAT034.
//!
//! EUROCONTROL-SPEC-0149-2b, once SUR.ET1.ST05.2000-STD-02b-01, ed 1.0 (November 1997) to 1.2 (March 2024), of one
//! layout.

use super::{RFS, SP};
use crate::table::Layout::{Element, Group, Repetitive, RepetitiveFx};
use crate::table::*;

// 1 north marker, 2 sector crossing, 3 south marker, 8 and 9 blind zone filter begins and ends
const I000: Item = Item::new("000", "Message Type", Element(8, RAW));

const I010: Item = Item::new(
    "010",
    "Data Source Identifier",
    Group(&[
        element("SAC", 8, RAW), // system area code
        element("SIC", 8, RAW), // system identification code
    ]),
);

// azimuth of its begin; 0 is north
const I020: Item = Item::new("020", "Sector Number", Element(8, unsigned(360.0 / pow2(8), "°")));

const I030: Item = Item::new("030", "Time of Day", Element(24, unsigned(1.0 / pow2(7), "s")));

// time of one rotation
const I041: Item = Item::new(
    "041",
    "Antenna Rotation Speed",
    Element(16, unsigned(1.0 / pow2(7), "s")),
);

// as the station defines
const I050: Item = Item::new("050", "Station Configuration Status", RepetitiveFx(&Element(7, RAW)));

// as the station defines
const I060: Item = Item::new("060", "Station Processing Mode", RepetitiveFx(&Element(7, RAW)));

const I070: Item = Item::new(
    "070",
    "Plot Count Values",
    Repetitive(&Group(&[
        flag("A"),                // 0 antenna 1, 1 antenna 2
        element("IDENT", 5, RAW), // 1 PSR plots, 2 SSR plots, 3 combined plots
        element("COUNTER", 10, NUMBER),
    ])),
);

// as the station defines
const I080: Item = Item::new("080", "Warning/Error Conditions", RepetitiveFx(&Element(7, RAW)));

const I090: Item = Item::new(
    "090",
    "Collimation Error",
    Group(&[
        element("RE", 8, signed(1.0 / pow2(7), "NM")),   // of range
        element("AE", 8, signed(360.0 / pow2(14), "°")), // of azimuth
    ]),
);

const I100: Item = Item::new(
    "100",
    "Dynamic Window Type 1",
    Group(&[
        element("RS", 16, unsigned(1.0 / pow2(7), "NM")),   // range from …
        element("RE", 16, unsigned(1.0 / pow2(7), "NM")),   // … to
        element("TS", 16, unsigned(360.0 / pow2(16), "°")), // azimuth from …
        element("TE", 16, unsigned(360.0 / pow2(16), "°")), // … to
    ]),
);

/// In the document's order.
#[rustfmt::skip]
const ITEMS: &[Item] = &[
    I000, I010, I020, I030, I041, I050, I060, I070,
    I080, I090, I100, SP, RFS,
];

#[rustfmt::skip]
const ORDER: &[&str] = &[
    "010", "000", "020", "030", "041", "050", "060", // FRN  1 to  7
    "070", "100", "090", "080", SPARE, "SP",  "RFS", //      8 to 14
];

const fn edition(minor: u8) -> Category {
    Category {
        number: 2,
        edition: Edition::new(1, minor),
        title: "Transmission of Monoradar Service Messages",
        document: "EUROCONTROL-SPEC-0149-2b",
        items: ITEMS,
        profile: Profile::Single(Uap::new(ITEMS, ORDER)),
    }
}

/// Radar service messages, ed 1.0.
pub static CAT002_V1_0: Category = edition(0);

/// Radar service messages, ed 1.1.
pub static CAT002_V1_1: Category = edition(1);

/// Radar service messages, ed 1.2.
pub static CAT002_V1_2: Category = edition(2);

/// Every edition of the category.
pub static CAT002: &[&Category] = &[&CAT002_V1_0, &CAT002_V1_1, &CAT002_V1_2];
