//! Content of the reserved expansion field I062/RE in editions 1.2 and 1.3 of its coding rules.
//!
//! EUROCONTROL-SPEC-0149-9A. Ed 1.3 adds data of ADS-B version 3.

use crate::expansion::Expansion;
use crate::table::*;

items! {
    sub CST "CST" "Contributing Sensors With Local Tracknumbers" (repetitive {
        SAC: 8, // system area code
        SIC: 8, // system identification code
        _: 4,
        TYP: 4, // as I048/020, 8 ADS-B, 9 wide area multilateration
        LTN: 16,
    })

    sub CSN "CSN" "Contributing Sensors No Local Tracknumbers" (repetitive {
        SAC: 8, // system area code
        SIC: 8, // system identification code
        _: 4,
        TYP: 4, // as I048/020, 8 ADS-B, 9 wide area multilateration
    })

    sub TVS "TVS" "Calculated Track Velocity Relative to System Reference Point" {
        VX: 16 signed(1.0 / pow2(2), "m/s"),
        VY: 16 signed(1.0 / pow2(2), "m/s"),
    }

    sub STS "STS" "Supplementary Track Status" [{
        FDR: 1, // flight plan data kept from a system no longer active
        _: 6,
    }]

    sub STS_V1_3 "STS" "Supplementary Track Status" [{
        FDR: 1,                  // flight plan data kept from a system no longer active
        LNAV: { EP: 1, VAL: 1 }, // 0 lateral navigation engaged, 1 not
        _: 4,
    }]

    sub V3 "V3" "ADS-B Version 3 Data" (compound [
        PS3 "Priority Status for Version 3 ADS-B Systems" {
            EP: 1,  // populated: VAL has a meaning, as in the next groups
            VAL: 3, // emergency: 0 none, 2 lost link, 3 fuel, 4 radio, …
            _: 4,
        },
        AS "Aircraft Status" {
            RCE: { EP: 1, VAL: 2 }, // reduced capability equipment: 1 TABS, 3 other
            RRL: { EP: 1, VAL: 1 }, // reply rate limiting active
            TPW: { EP: 1, VAL: 2 }, // transmit power in W: 1 70, 2 125, 3 200
            TSI: { EP: 1, VAL: 2 }, // transponder: 1 left, 2 right, 3 backup
            TAO: {
                EP: 1,
                RE: 1,  // 1 beyond the range
                VAL: 6, // offset of the antenna
            },
            _: 5,
        },
        UAS "UAS/RPAS Status" {
            MUO: { EP: 1, VAL: 1 }, // unmanned
            DAA: { EP: 1, VAL: 2 }, // detect and avoid: 1 RWC, RA, OCM, 2 RWC, OCM
            RWC: { EP: 1, VAL: 1 }, // remain well clear alert active
            _: 1,
        },
        CASS "Collision Avoidance System Status" {
            SVH: { EP: 1, VAL: 2 },  // avoids: 0 vertically, 1 horizontally, 2 both
            CATC: { EP: 1, VAL: 3 }, // kind of collision avoidance
            _: 1,
        },
    ])
}

const fn edition(minor: u8, items: &'static [Option<Item>]) -> Expansion {
    Expansion::new(62, Edition::new(1, minor), "EUROCONTROL-SPEC-0149-9A", items)
}

/// I062/RE, ed 1.2.
pub static CAT062_RE_V1_2: Expansion = edition(2, &[CST, CSN, TVS, STS]);

/// I062/RE, ed 1.3.
pub static CAT062_RE_V1_3: Expansion = edition(3, &[CST, CSN, TVS, STS_V1_3, V3]);
