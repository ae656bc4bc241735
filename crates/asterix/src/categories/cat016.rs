//! CAT016: configuration of an independent non-cooperative surveillance system: reference point, transmitters,
//! receivers and their pairs.
//!
//! EUROCONTROL-SPEC-0149, category 016, ed 1.0. Target reports of such systems are those of category 015.

use super::SP;
use crate::categories::SOURCE;
use crate::table::*;

items! {
    I000 "000" "Message Type" (8) // 1 system configuration, 2 transmitter and receiver configuration

    I010 "010" "Data Source Identifier" (SOURCE)

    I015 "015" "Service Identification" (8) // chosen by the system
    I140 "140" "Time of Day" (24 unsigned(1.0 / pow2(7), "s"))
    I200 "200" "System Configuration Reporting Period" (8 unsigned(1.0, "s"))

    I300 "300" "Pair Identification" (repetitive {
        PID: 16, // pair
        TID: 16, // transmitter
        RID: 16, // receiver
    })

    I400 "400" "Position of the System Reference Point" {
        LAT: 32 signed(180.0 / pow2(31), "°"),
        LON: 32 signed(180.0 / pow2(31), "°"),
    }

    I405 "405" "Height of System Reference Point" (16 signed(0.25, "m"))

    I410 "410" "Transmitter Properties" (repetitive {
        TID: 16,
        LAT: 32 signed(180.0 / pow2(31), "°"),
        LON: 32 signed(180.0 / pow2(31), "°"),
        ALT: 16 signed(0.25, "m"),
        TTO: 32 signed(2.0, "ns"), // transmission time offset
        _: 4,
        ATO: 20 unsigned(1.0, "ns"), // accuracy of the offset
        PCI: 16 NUMBER,              // index of parallel transmitters
    })

    I420 "420" "Receiver Properties" (repetitive {
        RID: 16,
        LAT: 32 signed(180.0 / pow2(31), "°"),
        LON: 32 signed(180.0 / pow2(31), "°"),
        ALT: 16 signed(0.25, "m"),
    })
}

#[rustfmt::skip]
const PROFILE: &[Option<Item>] = &profile![
    I010, I015, I000, I140, I200, I300, I400, // FRN  1 to  7
    I405, I410, I420, SP,                     //      8 to 11
];

editions! {
    CAT016 16 "Independent Non-Cooperative Surveillance System Configuration Reports" "EUROCONTROL-SPEC-0149" ["140"]
    CAT016_V1_0 1 0 PROFILE;
}
