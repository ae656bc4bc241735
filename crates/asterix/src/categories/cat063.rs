//! CAT063: what a surveillance data processing system says of its sensors: their state and biases.
//!
//! EUROCONTROL-SPEC-0149-10, ed 1.6 and 1.7 (June 2025), which adds a part to I063/060.

use super::{RE, SP};
use crate::table::Layout::{Element, Extended, Group};
use crate::table::*;

const I010: Item = Item::new(
    "010",
    "Data Source Identifier",
    Group(&[
        element("SAC", 8, RAW), // system area code
        element("SIC", 8, RAW), // system identification code
    ]),
);

const I015: Item = Item::new("015", "Service Identification", Element(8, RAW)); // chosen by the system

const I030: Item = Item::new("030", "Time of Message", Element(24, unsigned(1.0 / pow2(7), "s")));

const I050: Item = Item::new(
    "050",
    "Sensor Identifier",
    Group(&[
        element("SAC", 8, RAW), // system area code
        element("SIC", 8, RAW), // system identification code
    ]),
);

const I060_PART_1: &[Part] = &[
    element("CON", 2, RAW), // 0 operational, 1 degraded, 2 initialising, 3 not connected
    flag("PSR"),            // this and the next four: 1 not operational
    flag("SSR"),
    flag("MDS"),
    flag("ADS"),
    flag("MLT"),
];

const I060_PART_2: &[Part] = &[
    flag("OPS"), // 1 not to be used operationally
    flag("ODP"), // data processor overloaded
    flag("OXT"), // transmission overloaded
    flag("MSC"), // monitoring system disconnected
    flag("TSV"), // time source invalid
    flag("NPW"), // no plots being received
    spare(1),
];

const I060: Item = Item::new(
    "060",
    "Sensor Configuration and Status",
    Extended(&[I060_PART_1, I060_PART_2]),
);

const I060_V1_7: Item = Item::new(
    "060",
    "Sensor Configuration and Status",
    Extended(&[
        I060_PART_1,
        I060_PART_2,
        &[
            group("TTF", &[flag("EP"), flag("VAL")]), // test target failure
            group("SPO", &[flag("EP"), flag("VAL")]), // possible spoofing
            spare(3),
        ],
    ]),
);

const I070: Item = Item::new("070", "Time Stamping Bias", Element(16, signed(1.0, "ms")));

const I080: Item = Item::new(
    "080",
    "SSR / Mode S Range Gain and Bias",
    Group(&[
        element("SRG", 16, signed(0.000_01, "")),
        element("SRB", 16, signed(1.0 / pow2(7), "NM")),
    ]),
);

const I081: Item = Item::new(
    "081",
    "SSR Mode S Azimuth Bias",
    Element(16, signed(360.0 / pow2(16), "°")),
);

const I090: Item = Item::new(
    "090",
    "PSR Range Gain and Bias",
    Group(&[
        element("PRG", 16, signed(0.000_01, "")),
        element("PRB", 16, signed(1.0 / pow2(7), "NM")),
    ]),
);

const I091: Item = Item::new("091", "PSR Azimuth Bias", Element(16, signed(360.0 / pow2(16), "°")));

const I092: Item = Item::new("092", "PSR Elevation Bias", Element(16, signed(360.0 / pow2(16), "°")));

/// The items of an edition, in the document's order; those passed are not the same in all.
#[rustfmt::skip]
const fn items(i060: Item) -> [Item; 13] {
    [
        I010, I015, I030, I050, i060, I070, I080, I081,
        I090, I091, I092, RE, SP,
    ]
}

#[rustfmt::skip]
const ORDER: &[&str] = &[
    "010", "015", "030", "050", "060", "070", "080", // FRN  1 to  7
    "081", "090", "091", "092", SPARE, "RE",  "SP",  //      8 to 14
];

const fn edition(minor: u8, items: &'static [Item]) -> Category {
    Category {
        number: 63,
        edition: Edition::new(1, minor),
        title: "Sensor Status Reports",
        document: "EUROCONTROL-SPEC-0149-10",
        items,
        profile: Profile::Single(Uap::new(items, ORDER)),
    }
}

/// Sensor status reports, ed 1.6.
pub static CAT063_V1_6: Category = edition(6, &items(I060));

/// Sensor status reports, ed 1.7.
pub static CAT063_V1_7: Category = edition(7, &items(I060_V1_7));

/// Every edition of the category.
pub static CAT063: &[&Category] = &[&CAT063_V1_6, &CAT063_V1_7];
