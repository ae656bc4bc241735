//! CAT023: state and statistics of an ADS-B or multilateration ground station and of its services.
//!
//! EUROCONTROL-SPEC-0149-16, ed 1.2 and 1.3 (September 2021), of one layout.

use super::{RE, SP};
use crate::categories::SOURCE;
use crate::table::*;

items! {
    // 1 ground station status, 2 service status, 3 service statistics
    I000 "000" "Report Type" (8)

    I010 "010" "Data Source Identifier" (SOURCE)

    I015 "015" "Service Type and Identification" {
        SID: 4,  // number of the service
        STYP: 4, // ADS-B: 1 VDL 4, 2 1090 MHz, 3 UAT; 4 to 6 TIS-B, 7 FIS-B, 8 GRAS, 9 multilateration
    }

    I070 "070" "Time of Day" (24 unsigned(1.0 / pow2(7), "s"))

    I100 "100" "Ground Station Status" [
        {
            NOGO: 1, // 1 not to be used operationally
            ODP: 1,  // data processor overloaded
            OXT: 1,  // transmission overloaded
            MSC: 1,  // monitoring system connected
            TSV: 1,  // time source invalid
            SPO: 1,  // possible spoofing
            RN: 1,   // track numbers begin anew
        }
        {
            GSSP: 7 unsigned(1.0, "s"), // status is reported every so often
        }
    ]

    I101 "101" "Service Configuration" [
        {
            RP: 8 unsigned(0.5, "s"), // target reports every so often; 0: on every event
            SC: 3,                    // class of service: 0 unknown, 1 non-radar area
            _: 4,
        }
        {
            SSRP: 7 unsigned(1.0, "s"), // status is reported every so often
        }
    ]

    I110 "110" "Service Status" [{
        _: 4,
        STAT: 3, // 0 unknown, 1 failed, 2 disabled, 3 degraded, 4 normal, 5 initialising
    }]

    I120 "120" "Service Statistics" (repetitive {
        TYPE: 8, // 0 unknown messages, 1 too old, 2 not converted, 3 received, 4 transmitted, …
        REF: 1,  // counted from: 0 midnight, 1 the last report
        _: 7,
        CV: 32, // count
    })

    I200 "200" "Operational Range" (8 unsigned(1.0, "NM"))
}

/// The items by field reference number.
#[rustfmt::skip]
const PROFILE: &[Option<Item>] = &profile![
    I010, I000, I015, I070, I100, I101, I200, // FRN  1 to  7
    I110, I120, _, _, _, RE, SP,              //      8 to 14
];

editions! {
    CAT023 23 "CNS/ATM Ground Station and Service Status Reports" "EUROCONTROL-SPEC-0149-16" ["070"]
    CAT023_V1_2 1 2 PROFILE;
    CAT023_V1_3 1 3 PROFILE;
}
