//! CAT247: editions of the categories that a system sends.
//!
//! EUROCONTROL-SPEC-0149-20, ed 1.2 (February 2008) and 1.3, of one layout.

use super::{RE, SP};
use crate::categories::SOURCE;
use crate::table::*;

items! {
    I010 "010" "Data Source Identifier" (SOURCE)

    I015 "015" "Service Identification" (8) // chosen by the system
    I140 "140" "Time of Day" (24 unsigned(1.0 / pow2(7), "s"))

    I550 "550" "Category Version Number Report" (repetitive {
        CAT: 8 NUMBER,
        MAIN: 8 NUMBER, // the edition before the point
        SUB: 8 NUMBER,  // behind the point
    })
}

const PROFILE: &[Option<Item>] = &profile![I010, I015, I140, I550, _, SP, RE];

editions! {
    CAT247 247 "Version Number Exchange" "EUROCONTROL-SPEC-0149-20" ["140"]
    CAT247_V1_2 1 2 PROFILE;
    CAT247_V1_3 1 3 PROFILE;
}
