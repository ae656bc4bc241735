//! CAT032: extracts of flight plans for a surveillance data processing system.
//!
//! EUROCONTROL-SPEC-0149-29, ed 1.1 (December 2020) and 1.2, of one layout; ed 1.2 adds a family of messages.

use super::RE;
use crate::categories::SOURCE;
use crate::table::*;

items! {
    I010 "010" "Server Identification Tag" (SOURCE)

    I015 "015" "User Number" (16 NUMBER)

    I018 "018" "Data Source Identification Tag" (SOURCE)

    I020 "020" "Time of ASTERIX Report Generation" (24 unsigned(1.0 / pow2(7), "s"))

    I035 "035" "Type of Message" {
        FAMILY: 4, // 1 flight plan processing, 2 SUC (ed 1.2)
        NATURE: 4, // of family 1: 1 initial correlation, 2 update, 3 end, 4 cancellation, 5 retained; …
    }

    I040 "040" "Track Number" (16 NUMBER)

    I050 "050" "Composed Track Number" [
        {
            SUI: 8 NUMBER,  // system unit
            STN: 15 NUMBER, // track
        }
    ]

    I060 "060" "Track Mode 3/A" {
        _: 4,
        MODE3A: 12 OCTAL,
    }

    I400 "400" "Callsign" (56 ASCII)
    I410 "410" "Plan Number" (16 NUMBER)

    I420 "420" "Flight Category" {
        GATOAT: 2, // 0 unknown, 1 general air traffic, 2 operational air traffic, 3 not applicable
        FR1FR2: 2, // 0 instrument flight rules, 1 visual, 2 not applicable, 3 controlled visual
        SP3: 1,    // this and the next two: as the system defines
        SP2: 1,
        SP1: 1,
        _: 1,
    }

    I430 "430" "Type of Aircraft" (32 ASCII)
    I435 "435" "Wake Turbulence Category" (8) // L, M, H or J
    I440 "440" "Departure Aerodrome" (32 ASCII)
    I450 "450" "Destination Aerodrome" (32 ASCII)

    I460 "460" "Allocated SSR Codes" (repetitive {
        _: 4,
        OCT1: 3, // digits
        OCT2: 3,
        OCT3: 3,
        OCT4: 3,
    })

    I480 "480" "Current Cleared Flight Level" (16 unsigned(0.25, "FL"))

    I490 "490" "Current Control Position" {
        CEN: 8, // centre
        POS: 8, // position
    }

    I500 "500" "Supplementary Flight Data" (compound [
        IFI "IFPS FLIGHT ID" {
            TYP: 2, // 0 plan number, 1 to 3 internal number of a unit
            _: 3,
            NBR: 27 NUMBER,
        },
        RVP "RVSM & Flight Priority" {
            _: 5,
            RVSM: 2, // 0 unknown, 1 approved, 2 exempt, 3 not approved
            HPR: 1,  // high priority
        },
        RDS "Runway Designation" {
            NU1: 8 ASCII, // digits
            NU2: 8 ASCII,
            LTR: 8 ASCII,
        },
        TOD "Time of Departure / Arrival" (repetitive {
            TYP: 5, // 0 scheduled off-block, 1 estimated off-block, 2 estimated take-off, …
            DAY: 2, // 0 today, 1 yesterday, 2 tomorrow, 3 invalid
            _: 4,
            HOR: 5 NUMBER,
            _: 2,
            MIN: 6 NUMBER,
            AVS: 1, // seconds: 0 available, 1 not
            _: 1,
            SEC: 6 NUMBER,
        }),
        AST "Aircraft Stand" (48 ASCII),
        STS "Stand Status" {
            EMP: 2, // 0 empty, 1 occupied, 2 unknown, 3 invalid
            AVL: 2, // 0 available, 1 not available, 2 unknown, 3 invalid
            _: 4,
        },
        SID "Standard Instrument Departure" (56 ASCII),
        STAR "Standard Instrument Arrival" (56 ASCII),
    ])
}

#[rustfmt::skip]
const PROFILE: &[Option<Item>] = &profile![
    I010, I015, I018, I035, I020, I040, I050, // FRN  1 to  7
    I060, I400, I410, I420, I440, I450, I480, //      8 to 14
    I490, I430, I435, I460, I500, _, RE,      //     15 to 21
];

editions! {
    CAT032 32 "Miniplan Reports to an SDPS" "EUROCONTROL-SPEC-0149-29" ["020"]
    CAT032_V1_1 1 1 PROFILE;
    CAT032_V1_2 1 2 PROFILE;
}
