//! What the reserved expansion field I062/RE holds in editions 1.2 and 1.3 of its coding rules.
//!
//! EUROCONTROL-SPEC-0149-9A. Ed 1.3 adds what ADS-B version 3 says of an aircraft.

use crate::expansion::Expansion;
use crate::table::Layout::{Compound, Extended, Group, Repetitive};
use crate::table::*;

const CST: Option<Item> = subitem(
    "CST",
    "Contributing Sensors With Local Tracknumbers",
    Repetitive(&Group(&[
        element("SAC", 8, RAW), // system area code
        element("SIC", 8, RAW), // system identification code
        spare(4),
        element("TYP", 4, RAW), // as I048/020, 8 ADS-B, 9 wide area multilateration
        element("LTN", 16, RAW),
    ])),
);

const CSN: Option<Item> = subitem(
    "CSN",
    "Contributing Sensors No Local Tracknumbers",
    Repetitive(&Group(&[
        element("SAC", 8, RAW), // system area code
        element("SIC", 8, RAW), // system identification code
        spare(4),
        element("TYP", 4, RAW), // as I048/020, 8 ADS-B, 9 wide area multilateration
    ])),
);

const TVS: Option<Item> = subitem(
    "TVS",
    "Calculated Track Velocity Relative to System Reference Point",
    Group(&[
        element("VX", 16, signed(1.0 / pow2(2), "m/s")),
        element("VY", 16, signed(1.0 / pow2(2), "m/s")),
    ]),
);

const STS: Option<Item> = subitem(
    "STS",
    "Supplementary Track Status",
    Extended(&[&[
        flag("FDR"), // flight plan data kept from a system no longer active
        spare(6),
    ]]),
);

const STS_V1_3: Option<Item> = subitem(
    "STS",
    "Supplementary Track Status",
    Extended(&[&[
        flag("FDR"),                               // flight plan data kept from a system no longer active
        group("LNAV", &[flag("EP"), flag("VAL")]), // 0 lateral navigation engaged, 1 not
        spare(4),
    ]]),
);

const V3: Option<Item> = subitem(
    "V3",
    "ADS-B Version 3 Data",
    Compound(&[
        subitem(
            "PS3",
            "Priority Status for Version 3 ADS-B Systems",
            Group(&[
                flag("EP"),             // populated: VAL has a meaning, as in the next groups
                element("VAL", 3, RAW), // emergency: 0 none, 2 lost link, 3 fuel, 4 radio, …
                spare(4),
            ]),
        ),
        subitem(
            "AS",
            "Aircraft Status",
            Group(&[
                group("RCE", &[flag("EP"), element("VAL", 2, RAW)]), // reduced capability equipment: 1 TABS, 3 other
                group("RRL", &[flag("EP"), flag("VAL")]),            // reply rate limiting active
                group("TPW", &[flag("EP"), element("VAL", 2, RAW)]), // transmit power in W: 1 70, 2 125, 3 200
                group("TSI", &[flag("EP"), element("VAL", 2, RAW)]), // transponder: 1 left, 2 right, 3 backup
                group(
                    "TAO",
                    &[
                        flag("EP"),
                        flag("RE"),             // 1 beyond the range
                        element("VAL", 6, RAW), // offset of the antenna
                    ],
                ),
                spare(5),
            ]),
        ),
        subitem(
            "UAS",
            "UAS/RPAS Status",
            Group(&[
                group("MUO", &[flag("EP"), flag("VAL")]),            // unmanned
                group("DAA", &[flag("EP"), element("VAL", 2, RAW)]), // detect and avoid: 1 RWC, RA, OCM, 2 RWC, OCM
                group("RWC", &[flag("EP"), flag("VAL")]),            // remain well clear alert active
                spare(1),
            ]),
        ),
        subitem(
            "CASS",
            "Collision Avoidance System Status",
            Group(&[
                group("SVH", &[flag("EP"), element("VAL", 2, RAW)]), // avoids: 0 vertically, 1 horizontally, 2 both
                group("CATC", &[flag("EP"), element("VAL", 3, RAW)]), // kind of collision avoidance
                spare(1),
            ]),
        ),
    ]),
);

const fn edition(minor: u8, items: &'static [Option<Item>]) -> Expansion {
    Expansion::new(62, Edition::new(1, minor), "EUROCONTROL-SPEC-0149-9A", items)
}

/// I062/RE, ed 1.2.
pub static CAT062_RE_V1_2: Expansion = edition(2, &[CST, CSN, TVS, STS]);

/// I062/RE, ed 1.3.
pub static CAT062_RE_V1_3: Expansion = edition(3, &[CST, CSN, TVS, STS_V1_3, V3]);
