//! CAT065: service messages of a surveillance data processing system.
//!
//! EUROCONTROL-SPEC-0149-15, ed 1.4 to 1.6 (March 2023). Their layouts are the same; later editions added codes.

use super::{RE, SP};
use crate::table::Layout::{Element, Group};
use crate::table::*;

// 1 system status, 2 end of batch, 3 service status
const I000: Item = Item::new("000", "Message Type", Element(8, RAW));

const I010: Item = Item::new(
    "010",
    "Data Source Identifier",
    Group(&[
        element("SAC", 8, RAW), // system area code
        element("SIC", 8, RAW), // system identification code
    ]),
);

const I015: Item = Item::new("015", "Service Identification", Element(8, RAW)); // chosen by the system

const I020: Item = Item::new("020", "Batch Number", Element(8, NUMBER));

const I030: Item = Item::new("030", "Time of Message", Element(24, unsigned(1.0 / pow2(7), "s")));

const I040: Item = Item::new(
    "040",
    "SDPS Configuration and Status",
    Group(&[
        element("NOGO", 2, RAW), // 0 operational, 1 degraded, 2 not connected, 3 unknown
        flag("OVL"),             // overload
        flag("TSV"),             // time source invalid
        element("PSS", 2, RAW),  // processing system: 1, 2 or 3
        flag("STTN"),            // flips whenever tracks are numbered anew
        spare(1),
    ]),
);

// 1 degradation, 2 its end, 3 main radar out of service, 4 to 8 interruption and restart, …
const I050: Item = Item::new("050", "Service Status Report", Element(8, RAW));

/// In the document's order.
#[rustfmt::skip]
const ITEMS: &[Item] = &[
    I000, I010, I015, I020, I030, I040, I050, RE,
    SP,
];

#[rustfmt::skip]
const ORDER: &[&str] = &[
    "010", "000", "015", "030", "020", "040", "050", // FRN  1 to  7
    SPARE, SPARE, SPARE, SPARE, SPARE, "RE",  "SP",  //      8 to 14
];

const fn edition(minor: u8) -> Category {
    Category {
        number: 65,
        edition: Edition::new(1, minor),
        title: "SDPS Service Status Reports",
        document: "EUROCONTROL-SPEC-0149-15",
        items: ITEMS,
        profile: Profile::Single(Uap::new(ITEMS, ORDER)),
    }
}

/// System service status reports, ed 1.4.
pub static CAT065_V1_4: Category = edition(4);

/// System service status reports, ed 1.5.
pub static CAT065_V1_5: Category = edition(5);

/// System service status reports, ed 1.6.
pub static CAT065_V1_6: Category = edition(6);

/// Every edition of the category.
pub static CAT065: &[&Category] = &[&CAT065_V1_4, &CAT065_V1_5, &CAT065_V1_6];
