//! CAT019 ed 1.3: status messages of a multilateration system.
//!
//! EUROCONTROL-SPEC-0149-18 (SUR.ET1.ST05.2000-STD-18-01), December 2010.

use super::{RE, SP};
use crate::categories::SOURCE;
use crate::table::*;

items! {
    // 1 start of update cycle, 2 periodic status, 3 event status
    I000 "000" "Message Type" (8)

    I010 "010" "Data Source Identifier" (SOURCE)

    I140 "140" "Time of Day" (24 unsigned(1.0 / pow2(7), "s"))

    I550 "550" "System Status" {
        NOGO: 2, // 0 operational, 1 degraded, 2 do not use, 3 undefined
        OVL: 1,  // overload
        TSV: 1,  // time source invalid
        TTF: 1,  // test target failure
        _: 3,
    }

    I551 "551" "Tracking Processor Detailed Status" {
        TP1A: 1, // processor 1: 0 standby, 1 executing
        TP1B: 1, // processor 1: 0 faulted, 1 good; both bits zero: not used
        TP2A: 1,
        TP2B: 1,
        TP3A: 1,
        TP3B: 1,
        TP4A: 1,
        TP4B: 1,
    }

    I552 "552" "Remote Sensor Detailed Status" (repetitive {
        RSI: 8, // number of the remote sensor
        _: 1,
        RS1090: 1, // receiver 1090 MHz present
        TX1030: 1, // transmitter 1030 MHz present
        TX1090: 1, // transmitter 1090 MHz present
        RSS: 1,    // 0 faulted, 1 good
        RSO: 1,    // 0 offline, 1 online
        _: 2,
    })

    I553 "553" "Reference Transponder Detailed Status" [
        {
            REFTR1: 2, // 1 warning, 2 faulted, 3 good
            _: 2,
            REFTR2: 2,
            _: 1,
        }
        {
            REFTR3: 2,
            _: 2,
            REFTR4: 2,
            _: 1,
        }
    ]

    I600 "600" "Position of the MLT System Reference Point" {
        LAT: 32 signed(180.0 / pow2(30), "°"),
        LON: 32 signed(180.0 / pow2(30), "°"),
    }

    I610 "610" "Height of the MLT System Reference Point" (16 signed(1.0 / pow2(2), "m"))
    I620 "620" "WGS-84 Undulation" (8 signed(1.0, "m"))
}

/// The items by field reference number.
#[rustfmt::skip]
const PROFILE: &[Option<Item>] = &profile![
    I010, I000, I140, I550, I551, I552, I553, // FRN 1 to  7
    I600, I610, I620, _, _, RE, SP,           //      8 to 14
];

editions! {
    CAT019 19 "Multilateration System Status Messages" "EUROCONTROL-SPEC-0149-18" ["140"]
    CAT019_V1_3 1 3 PROFILE;
}
