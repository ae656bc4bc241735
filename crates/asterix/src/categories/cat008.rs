//! CAT008: weather of a radar, as vectors and contours.
//!
//! EUROCONTROL-SPEC-0149-3, ed 1.2 and 1.3, of one layout. A scaling factor in I008/100 is the exponent of two by which
//! the coordinates of the other records of a picture are multiplied; elements here are the numbers as sent.

use super::{RFS, SP};
use crate::categories::SOURCE;
use crate::table::*;

items! {
    // 1 polar vectors, 2 Cartesian vectors with lengths, 3 contour, 4 Cartesian vectors, 254 and 255 a picture's ends
    I000 "000" "Message Type" (8)

    I010 "010" "Data Source Identifier" (SOURCE)

    I020 "020" "Vector Qualifier" [
        {
            ORG: 1,      // coordinates: 0 local, 1 of the system
            I: 3 NUMBER, // intensity
            S: 3,        // orientation of the shading, 22.5° each from north
        }
        {
            _: 5,
            TST: 1, // test vector
            ER: 1,  // error
        }
    ]

    I034 "034" "Sequence of Polar Vectors in SPF Notation" (repetitive {
        STR: 8 NUMBER,  // range of the start
        ENDR: 8 NUMBER, // range of the end
        AZ: 16 unsigned(360.0 / pow2(16), "°"),
    })

    I036 "036" "Sequence of Cartesian Vectors in SPF Notation" (repetitive {
        X: 8 SIGNED_NUMBER,
        Y: 8 SIGNED_NUMBER,
        LENGTH: 8 NUMBER,
    })

    I038 "038" "Sequence of Weather Vectors in SPF Notation" (repetitive {
        X1: 8 SIGNED_NUMBER,
        Y1: 8 SIGNED_NUMBER,
        X2: 8 SIGNED_NUMBER,
        Y2: 8 SIGNED_NUMBER,
    })

    I040 "040" "Contour Identifier" {
        ORG: 1, // coordinates: 0 local, 1 of the system
        I: 3,   // intensity
        _: 2,
        FSTLST: 2, // record of a contour: 0 in between, 1 last, 2 first, 3 the only one
        CSN: 8,    // serial number
    }

    I050 "050" "Sequence of Contour Points in SPF Notation" (repetitive {
        X1: 8 SIGNED_NUMBER,
        Y1: 8 SIGNED_NUMBER,
    })

    I090 "090" "Time of Day" (24 unsigned(1.0 / pow2(7), "s"))

    I100 "100" "Processing Status" [
        {
            F: 5 SIGNED_NUMBER, // scaling factor
            R: 3,               // stage of reduction
            Q: 15,              // processing parameters
        }
    ]

    I110 "110" "Station Configuration Status" (repetitive_fx (7)) // as the station defines
    I120 "120" "Total Number of Items Constituting One Weather Picture" (16 NUMBER)
}

#[rustfmt::skip]
const PROFILE: &[Option<Item>] = &profile![
    I010, I000, I020, I036, I034, I040, I050, // FRN  1 to  7
    I090, I100, I110, I120, I038, SP, RFS,    //      8 to 14
];

editions! {
    CAT008 8 "Monoradar Derived Weather Information" "EUROCONTROL-SPEC-0149-3" ["090"]
    CAT008_V1_2 1 2 PROFILE;
    CAT008_V1_3 1 3 PROFILE;
}
