//! CAT009: weather composed from several radars, as vectors.
//!
//! EUROCONTROL-SPEC-0149, category 009, ed 2.1.

use crate::categories::SOURCE;
use crate::table::*;

items! {
    I000 "000" "Message Type" (8) // 2 Cartesian vectors, 253 step of an update, 254 and 255 a picture's ends

    I010 "010" "Data Source Identifier" (SOURCE)

    I020 "020" "Vector Qualifier" [
        {
            ORG: 1,      // coordinates: 0 local, 1 of the system
            I: 3 NUMBER, // intensity
            S: 3,        // orientation of the shading, 22.5° each from north
        }
    ]

    I030 "030" "Sequence of Cartesian Vectors" (repetitive {
        X: 16 SIGNED_NUMBER,
        Y: 16 SIGNED_NUMBER,
        L: 16 NUMBER,
    })

    I060 "060" "Synchronisation/Control Signal" [
        {
            SN: 6 NUMBER, // step
            _: 1,
        }
    ]

    I070 "070" "Time of Day" (24 unsigned(1.0 / pow2(7), "s"))

    I080 "080" "Processing Status" [
        {
            F: 5 SIGNED_NUMBER, // scaling factor
            R: 3,               // stage of reduction
            Q: 15,              // processing parameters
        }
    ]

    I090 "090" "Radar Configuration and Status" (repetitive {
        SAC: 8,
        SIC: 8,
        _: 3,
        CP: 1, // circular polarisation
        WO: 1, // weather channel overload
        R: 3,  // stage of reduction in the radar
    })

    I100 "100" "Vector Count" (16 NUMBER)
}

#[rustfmt::skip]
const PROFILE: &[Option<Item>] = &profile![
    I010, I000, I020, I030, I060, I070, I080, // FRN 1 to 7
    I090, I100,                               //     8 and 9
];

editions! {
    CAT009 9 "Composite Weather Reports" "EUROCONTROL-SPEC-0149" ["070"]
    CAT009_V2_1 2 1 PROFILE;
}
