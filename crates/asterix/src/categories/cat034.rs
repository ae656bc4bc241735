//! CAT034: service messages of a radar: north marker, sector crossings, state.
//!
//! EUROCONTROL-SPEC-0149-2b, ed 1.27 (May 2007) to 1.29 (March 2021). Their layouts are the same; later editions added
//! message types.

use super::{RE, SP};
use crate::table::Layout::{Compound, Element, Group, Repetitive};
use crate::table::*;

// 1 north marker, 2 sector crossing, 3 geographical filter, 4 jamming, 5 solar storm, 6 SSR and 7 Mode S jamming
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

const I041: Item = Item::new(
    "041",
    "Antenna Rotation Speed",
    Element(16, unsigned(1.0 / pow2(7), "s")),
);

const I050: Item = Item::new(
    "050",
    "System Configuration and Status",
    Compound(&[
        subitem(
            "COM",
            "Common Part",
            Group(&[
                flag("NOGO"),   // 1 not to be used operationally
                flag("RDPC"),   // radar data processor chain: 0 first, 1 second
                flag("RDPR"),   // 1 reset: expect new track numbers
                flag("OVLRDP"), // radar data processor overloaded
                flag("OVLXMT"), // transmission overloaded
                flag("MSC"),    // monitoring system disconnected
                flag("TSV"),    // time source invalid
                spare(1),
            ]),
        ),
        None,
        None,
        subitem(
            "PSR",
            "Specific Status Information for a PSR Sensor",
            Group(&[
                flag("ANT"),             // 0 antenna 1, 1 antenna 2
                element("CHAB", 2, RAW), // channel: 0 none, 1 A, 2 B, 3 both (diversity)
                flag("OVL"),             // overload
                flag("MSC"),             // monitoring system disconnected
                spare(3),
            ]),
        ),
        subitem(
            "SSR",
            "Specific Status Information for a SSR Sensor",
            Group(&[
                flag("ANT"),
                element("CHAB", 2, RAW), // channel: 0 none, 1 A, 2 B, 3 invalid
                flag("OVL"),
                flag("MSC"),
                spare(3),
            ]),
        ),
        subitem(
            "MDS",
            "Specific Status Information for a Mode S Sensor",
            Group(&[
                flag("ANT"),
                element("CHAB", 2, RAW), // channel: 0 none, 1 A, 2 B, 3 invalid
                flag("OVLSUR"),          // overload
                flag("MSC"),
                flag("SCF"),    // surveillance co-ordination function: 0 channel A, 1 channel B
                flag("DLF"),    // data link function: 0 channel A, 1 channel B
                flag("OVLSCF"), // surveillance co-ordination overloaded
                flag("OVLDLF"), // data link overloaded
                spare(7),
            ]),
        ),
    ]),
);

const I060: Item = Item::new(
    "060",
    "System Processing Mode",
    Compound(&[
        subitem(
            "COM",
            "Common Part",
            Group(&[
                spare(1),
                element("REDRDP", 3, RAW), // steps of load reduction, radar data processor; 0 none
                element("REDXMT", 3, RAW), // the same, transmission
                spare(1),
            ]),
        ),
        None,
        None,
        subitem(
            "PSR",
            "Specific Processing Mode Information for a PSR Sensor",
            Group(&[
                flag("POL"),               // polarisation: 0 linear, 1 circular
                element("REDRAD", 3, RAW), // steps of load reduction; 0 none
                element("STC", 2, RAW),    // sensitivity time control map, counted from 0
                spare(2),
            ]),
        ),
        subitem(
            "SSR",
            "Specific Processing Mode Information for a SSR Sensor",
            Group(&[
                element("REDRAD", 3, RAW), // steps of load reduction; 0 none
                spare(5),
            ]),
        ),
        subitem(
            "MDS",
            "Specific Processing Mode Information for a Mode S Sensor",
            Group(&[
                element("REDRAD", 3, RAW), // steps of load reduction; 0 none
                flag("CLU"),               // cluster: 0 autonomous, 1 not autonomous
                spare(4),
            ]),
        ),
    ]),
);

const I070: Item = Item::new(
    "070",
    "Message Count Values",
    Repetitive(&Group(&[
        element("TYP", 5, RAW), // 0 no detection, 1 PSR, 2 SSR, 3 both, 4 all-call, 5 roll-call, 6 and 7 with PSR, …
        element("COUNT", 11, NUMBER),
    ])),
);

const I090: Item = Item::new(
    "090",
    "Collimation Error",
    Group(&[
        element("RNG", 8, signed(1.0 / pow2(7), "NM")),
        element("AZM", 8, signed(360.0 / pow2(14), "°")),
    ]),
);

const I100: Item = Item::new(
    "100",
    "Generic Polar Window",
    Group(&[
        element("RHOST", 16, unsigned(1.0 / pow2(8), "NM")),
        element("RHOEND", 16, unsigned(1.0 / pow2(8), "NM")),
        element("THETAST", 16, unsigned(360.0 / pow2(16), "°")),
        element("THETAEND", 16, unsigned(360.0 / pow2(16), "°")),
    ]),
);

// what is filtered out: 1 weather, 2 jamming strobes, 3 PSR, 4 SSR and Mode S, 5 both, …
const I110: Item = Item::new("110", "Data Filter", Element(8, RAW));

const I120: Item = Item::new(
    "120",
    "3D-Position Of Data Source",
    Group(&[
        element("HGT", 16, signed(1.0, "m")),
        element("LAT", 24, signed(180.0 / pow2(23), "°")),
        element("LON", 24, signed(180.0 / pow2(23), "°")),
    ]),
);

/// In the document's order.
#[rustfmt::skip]
const ITEMS: &[Item] = &[
    I000, I010, I020, I030, I041, I050, I060, I070,
    I090, I100, I110, I120, RE, SP,
];

#[rustfmt::skip]
const ORDER: &[&str] = &[
    "010", "000", "030", "020", "041", "050", "060", // FRN  1 to  7
    "070", "100", "110", "120", "090", "RE",  "SP",  //      8 to 14
];

const fn edition(minor: u8) -> Category {
    Category {
        number: 34,
        edition: Edition::new(1, minor),
        title: "Transmission of Monoradar Service Messages",
        document: "EUROCONTROL-SPEC-0149-2b",
        items: ITEMS,
        profile: Profile::Single(Uap::new(ITEMS, ORDER)),
    }
}

/// Monoradar service messages, ed 1.27.
pub static CAT034_V1_27: Category = edition(27);

/// Monoradar service messages, ed 1.28.
pub static CAT034_V1_28: Category = edition(28);

/// Monoradar service messages, ed 1.29.
pub static CAT034_V1_29: Category = edition(29);

/// Every edition of the category.
pub static CAT034: &[&Category] = &[&CAT034_V1_27, &CAT034_V1_28, &CAT034_V1_29];
