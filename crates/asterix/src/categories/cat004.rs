//! CAT004: messages of safety nets: conflicts, deviations and infringements, and the state of the safety nets.
//!
//! EUROCONTROL-SPEC-0149-17, ed 1.12 and 1.13, with the same order of items. Ed 1.13 uses spare bits of I004/045 for
//! the state of an area and adds a part to I004/060.
//!
//! In I004/120, CC/CPC has another meaning for each type of message and table of definitions (TID): in some cases a
//! code, in others flags. CPC is a number of three bits here.

use super::{RE, SP};
use crate::categories::SOURCE;
use crate::table::*;

items! {
    // 1 alive, 4 MSAW, 5 APW, 6 CLAM, 7 STCA, 8 APM, 9 to 16 RIMCAS, 17 end of conflict, 18 ACAS RA, …
    I000 "000" "Message Type" (8)

    I010 "010" "Data Source Identifier" (SOURCE)

    I015 "015" "SDPS Identifier" (repetitive (SOURCE))
    I020 "020" "Time of Message" (24 unsigned(1.0 / pow2(7), "s"))
    I030 "030" "Track Number 1" (16)
    I035 "035" "Track Number 2" (16)
    I040 "040" "Alert Identifier" (16)

    I045 "045" "Alert Status" {
        _: 4,
        STAT: 3, // as the system defines
        _: 1,
    }

    I045_V1_13 "045" "Area and Alert Status" {
        AREA: { EP: 1, VAL: 3 }, // EP: VAL has a meaning; area: 0 inactive, 1 active, 2 pre-active
        STAT: 3,                 // as the system defines
        _: 1,
    }

    // Functions of the safety net; 1 in use.
    parts I060_PART_1 {
        MRVA: 1,  // minimum radar vectoring altitude
        RAMLD: 1, // route adherence, longitudinal deviation
        RAMHD: 1, // route adherence, heading deviation
        MSAW: 1,  // minimum safe altitude warning
        APW: 1,   // area proximity warning
        CLAM: 1,  // cleared level adherence
        STCA: 1,  // short term conflict alert
    }

    parts I060_PART_2 {
        APM: 1,    // approach path
        RIMCA: 1,  // runway incursion and conflict alert
        ACASRA: 1, // resolution advisories
        NTCA: 1,   // near term conflict alert
        DG: 1,     // system degraded
        OF: 1,     // overflow
        OL: 1,     // overload
    }

    parts I060_PART_3 {
        AIW: 1,  // airspace infringement warning
        PAIW: 1, // predicted airspace infringement warning
        OCAT: 1, // outside controlled airspace
        SAM: 1,  // speed adherence
        VCD: 1,  // vertical conflict detection
        CHAM: 1, // cleared heading adherence
        DSAM: 1, // downlinked selected altitude
    }

    parts I060_PART_4 {
        DBPSMARR: 1, // downlinked barometric pressure setting: arrivals
        DBPSMDEP: 1, // departures
        DBPSMTL: 1,  // above the transition level
        VRAMCRM: 1,  // vertical rate adherence: change of rate
        VRAMVTM: 1,  // tolerance
        VRAMVRM: 1,  // rate
        HAMHD: 1,    // holding adherence: heading deviation
    }

    parts I060_PART_5 {
        HAMRD: 1, // route deviation
        HAMVD: 1, // vertical deviation
        HVI: 1,   // holding volume infringement
        LTW: 1,   // lost track warning
        VPM: 1,   // vertical path
        TTA: 1,   // taxiway traffic alert
        CRA: 1,   // close runway alert
    }

    parts I060_PART_6 {
        ASM: 1,  // aircraft separation
        IAVM: 1, // ILS area violation
        FTD: 1,  // final target distance
        ITD: 1,  // initial target distance
        IIA: 1,  // wake vortex indicator infringement
        SQW: 1,  // sequence warning
        CUW: 1,  // catch-up warning
    }

    parts I060_PART_7 {
        CATC: 1,    // conflicting clearances
        NOCLR: 1,   // no clearance
        NOMOV: 1,   // not moving despite a clearance
        NOH: 1,     // no proper handover
        WRTY: 1,    // wrong type of runway or taxiway
        STOCC: 1,   // stand occupied
        ONGOING: 1, // ongoing alert
    }

    I060 "060" "Safety Net Function and System Status" [
        I060_PART_1 I060_PART_2 I060_PART_3 I060_PART_4 I060_PART_5 I060_PART_6 I060_PART_7
    ]

    I060_V1_13 "060" "Safety Net Function and System Status" [
        I060_PART_1 I060_PART_2 I060_PART_3 I060_PART_4 I060_PART_5 I060_PART_6 I060_PART_7
        {
            NTZ: 1, // non-transgression zone
            _: 6,
        }
    ]

    I070 "070" "Conflict Timing and Separation" (compound [
        TC "Time to Conflict" (24 unsigned(1.0 / pow2(7), "s")),
        TCA "Time to Closest Approach" (24 unsigned(1.0 / pow2(7), "s")),
        CHS "Current Horizontal Separation" (24 unsigned(0.5, "m")),
        MHS "Estimated Minimum Horizontal Separation" (16 unsigned(0.5, "m")),
        CVS "Current Vertical Separation" (16 unsigned(25.0, "ft")),
        MVS "Estimated Minimum Vertical Separation" (16 unsigned(25.0, "ft")),
    ])

    I074 "074" "Longitudinal Deviation" (16 signed(32.0, "m"))
    I075 "075" "Transversal Distance Deviation" (24 signed(0.5, "m"))
    I076 "076" "Vertical Deviation" (16 signed(25.0, "ft"))

    I100 "100" "Area Definition" (compound [
        AN "Area Name" (48 ICAO),
        CAN "Crossing Area Name" (56 ASCII),
        RT1 "Runway/Taxiway Designator 1" (56 ASCII),
        RT2 "Runway/Taxiway Designator 2" (56 ASCII),
        SB "Stop Bar Designator" (56 ASCII),
        G "Gate Designator" (56 ASCII),
    ])

    I110 "110" "FDPS Sector Control Identification" (repetitive {
        CEN: 8, // centre
        POS: 8, // control position
    })

    I120 "120" "Conflict Characteristics" (compound [
        CN "Conflict Nature" [
            {
                MAS: 1,   // predicted in military airspace
                CAS: 1,   // predicted in civil airspace
                FLD: 1,   // fast lateral divergence
                FVD: 1,   // fast vertical divergence
                TYPE: 1,  // separation infringement: 0 minor, 1 major
                CROSS: 1, // aircraft have crossed at the start of the conflict
                DIV: 1,   // aircraft are diverging at the start of the conflict
            }
            {
                RRC: 1,     // runway and runway crossing
                RTC: 1,     // runway and taxiway crossing
                MRVA: 1,    // this and the next ones: function behind the message's type, as in I004/060
                VRAMCRM: 1,
                VRAMVRM: 1,
                VRAMVTM: 1,
                HAMHD: 1,
            }
            {
                HAMRD: 1,
                HAMVD: 1,
                DBPSMARR: 1,
                DBPSMDEP: 1,
                DBPSMTL: 1,
                AIW: 1,
                _: 1,
            }
        ],
        CC "Conflict Classification" {
            TID: 4, // table of definitions
            CPC: 3, // properties, by type of message and TID
            CS: 1,  // severity: 0 low, 1 high
        },
        CP "Conflict Probability" (8 unsigned(0.5, "%")),
        CD "Conflict Duration" (24 unsigned(1.0 / pow2(7), "s")),
    ])

    parts CODE {
        _: 4,
        MODE3A: 12 OCTAL,
    }

    parts GEODETIC {
        LAT: 32 signed(180.0 / pow2(25), "°"),
        LON: 32 signed(180.0 / pow2(25), "°"),
        ALT: 16 signed(25.0, "ft"),
    }

    parts CARTESIAN {
        X: 24 signed(0.5, "m"),
        Y: 24 signed(0.5, "m"),
        Z: 16 signed(25.0, "ft"),
    }

    parts TRAFFIC {
        GATOAT: 2, // 0 unknown, 1 general air traffic, 2 operational air traffic, 3 not applicable
        FR1FR2: 2, // 0 instrument flight rules, 1 visual, 2 not applicable, 3 controlled visual
        RVSM: 2,   // 0 unknown, 1 approved, 2 exempt, 3 not approved
        HPR: 1,    // high priority
    }

    parts MOTION {
        CDM: 2, // 0 maintaining, 1 climbing, 2 descending, 3 invalid
        PRI: 1, // primary target
        GV: 1,  // ground vehicle
        _: 3,
    }

    parts FLIGHT_PLAN {
        _: 5,
        NBR: 27 unsigned(1.0, ""),
    }

    I170 "170" "Aircraft Identification and Characteristics 1" (compound [
        AI1 "Aircraft Identifier" (56 ASCII),
        M31 "Mode 3/A Code" (CODE),
        CPW "Predicted Conflict Position in WGS-84 Coordinates" (GEODETIC),
        CPC "Predicted Conflict Position in Cartesian Coordinates" (CARTESIAN),
        TT1 "Time to Runway Threshold" (24 unsigned(1.0 / pow2(7), "s")),
        DT1 "Distance to Runway Threshold" (16 unsigned(0.5, "m")),
        AC1 "Characteristics" [TRAFFIC MOTION],
        MS1 "Aircraft Identification by Mode S" (48 ICAO),
        FP1 "Number of the Flight Plan" (FLIGHT_PLAN),
        CF1 "Cleared Flight Level" (16 unsigned(0.25, "FL")),
    ])

    I171 "171" "Aircraft Identification and Characteristics 2" (compound [
        AI2 "Aircraft Identifier" (56 ASCII),
        M32 "Mode 3/A Code" (CODE),
        CPW "Predicted Conflict Position in WGS-84 Coordinates" (GEODETIC),
        CPL "Predicted Conflict Position in Cartesian Coordinates" (CARTESIAN),
        TT2 "Time to Runway Threshold" (24 unsigned(1.0 / pow2(7), "s")),
        DT2 "Distance to Runway Threshold" (16 unsigned(0.5, "m")),
        AC2 "Characteristics" [TRAFFIC MOTION],
        MS2 "Aircraft Identification by Mode S" (48 ICAO),
        FP2 "Number of the Flight Plan" (FLIGHT_PLAN),
        CF2 "Cleared Flight Level" (16 unsigned(0.25, "FL")),
    ])
}

/// The items by field reference number; those passed are not the same in all editions.
#[rustfmt::skip]
const fn profile(i045: Item, i060: Item) -> [Option<Item>; 21] {
    profile![
        I010, I000, I015, I020, I040, i045, i060, // FRN  1 to  7
        I030, I170, I120, I070, I076, I074, I075, //      8 to 14
        I100, I035, I171, I110, _, RE, SP,        //     15 to 21
    ]
}

editions! {
    CAT004 4 "Safety Net Messages" "EUROCONTROL-SPEC-0149-17" ["020"]
    CAT004_V1_12 1 12 &profile(I045, I060);
    CAT004_V1_13 1 13 &profile(I045_V1_13, I060_V1_13);
}
