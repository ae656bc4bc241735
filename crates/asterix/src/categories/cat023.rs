//! CAT023: state and statistics of an ADS-B or multilateration ground station and of its services.
//!
//! EUROCONTROL-SPEC-0149-16, ed 1.2 and 1.3 (September 2021), of one layout.

use super::{RE, SP};
use crate::table::Layout::{Element, Extended, Group, Repetitive};
use crate::table::*;

// 1 ground station status, 2 service status, 3 service statistics
const I000: Item = Item::new("000", "Report Type", Element(8, RAW));

const I010: Item = Item::new(
    "010",
    "Data Source Identifier",
    Group(&[
        element("SAC", 8, RAW), // system area code
        element("SIC", 8, RAW), // system identification code
    ]),
);

const I015: Item = Item::new(
    "015",
    "Service Type and Identification",
    Group(&[
        element("SID", 4, RAW),  // number of the service
        element("STYP", 4, RAW), // ADS-B: 1 VDL 4, 2 1090 MHz, 3 UAT; 4 to 6 TIS-B, 7 FIS-B, 8 GRAS, 9 multilateration
    ]),
);

const I070: Item = Item::new("070", "Time of Day", Element(24, unsigned(1.0 / pow2(7), "s")));

const I100: Item = Item::new(
    "100",
    "Ground Station Status",
    Extended(&[
        &[
            flag("NOGO"), // 1 not to be used operationally
            flag("ODP"),  // data processor overloaded
            flag("OXT"),  // transmission overloaded
            flag("MSC"),  // monitoring system connected
            flag("TSV"),  // time source invalid
            flag("SPO"),  // possible spoofing
            flag("RN"),   // track numbers begin anew
        ],
        &[
            element("GSSP", 7, unsigned(1.0, "s")), // status is reported every so often
        ],
    ]),
);

const I101: Item = Item::new(
    "101",
    "Service Configuration",
    Extended(&[
        &[
            element("RP", 8, unsigned(0.5, "s")), // target reports every so often; 0: on every event
            element("SC", 3, RAW),                // class of service: 0 unknown, 1 non-radar area
            spare(4),
        ],
        &[
            element("SSRP", 7, unsigned(1.0, "s")), // status is reported every so often
        ],
    ]),
);

const I110: Item = Item::new(
    "110",
    "Service Status",
    Extended(&[&[
        spare(4),
        element("STAT", 3, RAW), // 0 unknown, 1 failed, 2 disabled, 3 degraded, 4 normal, 5 initialising
    ]]),
);

const I120: Item = Item::new(
    "120",
    "Service Statistics",
    Repetitive(&Group(&[
        element("TYPE", 8, RAW), // 0 unknown messages, 1 too old, 2 not converted, 3 received, 4 transmitted, …
        flag("REF"),             // counted from: 0 midnight, 1 the last report
        spare(7),
        element("CV", 32, RAW), // count
    ])),
);

const I200: Item = Item::new("200", "Operational Range", Element(8, unsigned(1.0, "NM")));

/// In the document's order.
#[rustfmt::skip]
const ITEMS: &[Item] = &[
    I000, I010, I015, I070, I100, I101, I110, I120,
    I200, RE, SP,
];

#[rustfmt::skip]
const ORDER: &[&str] = &[
    "010", "000", "015", "070", "100", "101", "200", // FRN  1 to  7
    "110", "120", SPARE, SPARE, SPARE, "RE",  "SP",  //      8 to 14
];

const fn edition(minor: u8) -> Category {
    Category {
        number: 23,
        edition: Edition::new(1, minor),
        title: "CNS/ATM Ground Station and Service Status Reports",
        document: "EUROCONTROL-SPEC-0149-16",
        items: ITEMS,
        profile: Profile::Single(Uap::new(ITEMS, ORDER)),
    }
}

/// Ground station and service status, ed 1.2.
pub static CAT023_V1_2: Category = edition(2);

/// Ground station and service status, ed 1.3.
pub static CAT023_V1_3: Category = edition(3);

/// Every edition of the category.
pub static CAT023: &[&Category] = &[&CAT023_V1_2, &CAT023_V1_3];
