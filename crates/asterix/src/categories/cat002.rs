//! CAT002: service messages of a radar, the format before CAT034.
//!
//! EUROCONTROL-SPEC-0149-2b, once SUR.ET1.ST05.2000-STD-02b-01, ed 1.0 (November 1997) to 1.2 (March 2024), of one
//! layout.

use super::{RFS, SP};
use crate::categories::SOURCE;
use crate::table::*;

items! {
    // 1 north marker, 2 sector crossing, 3 south marker, 8 and 9 blind zone filter begins and ends
    I000 "000" "Message Type" (8)

    I010 "010" "Data Source Identifier" (SOURCE)

    // azimuth of its begin; 0 is north
    I020 "020" "Sector Number" (8 unsigned(360.0 / pow2(8), "°"))

    I030 "030" "Time of Day" (24 unsigned(1.0 / pow2(7), "s"))

    // time of one rotation
    I041 "041" "Antenna Rotation Speed" (16 unsigned(1.0 / pow2(7), "s"))

    // as the station defines
    I050 "050" "Station Configuration Status" (repetitive_fx (7))

    // as the station defines
    I060 "060" "Station Processing Mode" (repetitive_fx (7))

    I070 "070" "Plot Count Values" (repetitive {
        A: 1,     // 0 antenna 1, 1 antenna 2
        IDENT: 5, // 1 PSR plots, 2 SSR plots, 3 combined plots
        COUNTER: 10 NUMBER,
    })

    // as the station defines
    I080 "080" "Warning/Error Conditions" (repetitive_fx (7))

    I090 "090" "Collimation Error" {
        RE: 8 signed(1.0 / pow2(7), "NM"),   // of range
        AE: 8 signed(360.0 / pow2(14), "°"), // of azimuth
    }

    I100 "100" "Dynamic Window Type 1" {
        RS: 16 unsigned(1.0 / pow2(7), "NM"),   // range from …
        RE: 16 unsigned(1.0 / pow2(7), "NM"),   // … to
        TS: 16 unsigned(360.0 / pow2(16), "°"), // azimuth from …
        TE: 16 unsigned(360.0 / pow2(16), "°"), // … to
    }
}

/// The items by field reference number.
#[rustfmt::skip]
const PROFILE: &[Option<Item>] = &profile![
    I010, I000, I020, I030, I041, I050, I060, // FRN  1 to  7
    I070, I100, I090, I080, _, SP, RFS,       //      8 to 14
];

editions! {
    CAT002 2 "Transmission of Monoradar Service Messages" "EUROCONTROL-SPEC-0149-2b" ["030"]
    CAT002_V1_0 1 0 PROFILE;
    CAT002_V1_1 1 1 PROFILE;
    CAT002_V1_2 1 2 PROFILE;
}
