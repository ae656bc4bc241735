//! CAT021: ADS-B target reports.
//!
//! EUROCONTROL-SPEC-0149-12, formerly SUR.ET1.ST05.2000-STD-12-01, in two layouts with little in common: editions
//! 0.23 (November 2003) to 0.26, of which many ground stations still send the first, and editions 2.1 to 2.7 (July
//! 2025), each an extension of the previous edition. A block does not contain its edition: the receiver must know the
//! sender's edition.

mod re;
mod v0;
mod v2;

use crate::table::*;

pub use re::{CAT021_RE_V1_4, CAT021_RE_V1_5};
pub use v0::{CAT021_V0, CAT021_V0_23, CAT021_V0_24, CAT021_V0_25, CAT021_V0_26};
pub use v2::{CAT021_V2, CAT021_V2_1, CAT021_V2_2, CAT021_V2_3, CAT021_V2_4, CAT021_V2_5, CAT021_V2_6, CAT021_V2_7};

items! {
    // The same in all editions.
    I110 "110" "Trajectory Intent" (compound [
        TIS "Trajectory Intent Status" [{
            NAV: 1, // 1 not available
            NVB: 1, // 1 not valid
            _: 5,
        }],
        TID "Trajectory Intent Data" (repetitive {
            TCA: 1,  // 1 number of the change point not available
            NC: 1,   // 1 the aircraft will not fly this path
            TCPN: 6, // number of the change point
            ALT: 16 signed(10.0, "ft"),
            LAT: 24 signed(180.0 / pow2(23), "°"),
            LON: 24 signed(180.0 / pow2(23), "°"),
            PT: 4,                        // kind of point: 1 fly by, 2 fly over, … 7 top of climb, …
            TD: 2,                        // turn: 1 right, 2 left, 3 none
            TRA: 1,                       // turn radius available
            TOA: 1,                       // 1 time over point not available
            TOV: 24 unsigned(1.0, "s"),   // time over point, since midnight
            TTR: 16 unsigned(0.01, "NM"), // turn radius
        }),
    ])
}

/// Air speed: indicated, or a Mach number, depending on the flag before the value.
const AIR_SPEED: Content = Content::Depends {
    on: "IM",
    cases: &[(0, unsigned(1.0 / pow2(14), "NM/s")), (1, unsigned(0.001, "Mach"))],
    otherwise: &RAW,
};
