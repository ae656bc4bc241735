//! CAT020: target reports of a multilateration system.
//!
//! EUROCONTROL-SPEC-0149-14 (SUR.ET1.ST05.2000-STD-14-02), ed 1.9 (March 2015), 1.10 and 1.11 (July 2025), with one
//! order of items: the later ones add a part to I020/020, use spare bits of I020/230 and rename an element of I020/250.

use super::{MODE_C, RE, SP};
use crate::categories::{MODE_1, MODE_2, MODE_3A, SOURCE};
use crate::table::*;

items! {
    I010 "010" "Data Source Identifier" (SOURCE)

    parts I020_PART_1 {
        SSR: 1,  // non-Mode S 1090 MHz multilateration
        MS: 1,   // Mode S 1090 MHz multilateration
        HF: 1,   // HF multilateration
        VDL4: 1, // VDL Mode 4 multilateration
        UAT: 1,  // UAT multilateration
        DME: 1,  // DME/TACAN multilateration
        OT: 1,   // other technology
    }

    parts I020_PART_2 {
        RAB: 1, // from a field monitor
        SPI: 1, // special position identification
        CHN: 1, // 0 chain 1, 1 chain 2
        GBS: 1, // transponder's ground bit set
        CRT: 1, // corrupted replies
        SIM: 1, // simulated
        TST: 1, // test target
    }

    I020 "020" "Target Report Descriptor" [I020_PART_1 I020_PART_2]

    I020_V1_10 "020" "Target Report Descriptor" [
        I020_PART_1
        I020_PART_2
        {
            CF: 2, // address: 0 ICAO, 1 not ICAO, 2 no ADS-B message, 3 unknown
            _: 5,
        }
    ]

    I030 "030" "Warning/Error Conditions" (repetitive_fx (7))

    I041 "041" "Position In WGS-84 Coordinates" {
        LAT: 32 signed(180.0 / pow2(25), "°"),
        LON: 32 signed(180.0 / pow2(25), "°"),
    }

    I042 "042" "Position in Cartesian Coordinates" {
        X: 24 signed(0.5, "m"),
        Y: 24 signed(0.5, "m"),
    }

    I050 "050" "Mode-2 Code in Octal Representation" (MODE_2)

    I055 "055" "Mode-1 Code in Octal Representation" (MODE_1)

    I070 "070" "Mode-3/A Code in Octal Representation" (MODE_3A)

    I090 "090" "Flight Level in Binary Representation" {
        V: 1, // 1 not validated
        G: 1, // 1 garbled
        FL: 14 signed(1.0 / pow2(2), "FL"),
    }

    I100 "100" "Mode C Code" (= Layout::Group(MODE_C))
    I105 "105" "Geometric Height (WGS-84)" (16 signed(6.25, "ft"))
    I110 "110" "Measured Height (Local Cartesian Coordinates)" (16 signed(6.25, "ft"))
    I140 "140" "Time of Day" (24 unsigned(1.0 / pow2(7), "s"))

    I161 "161" "Track Number" {
        _: 4,
        TRN: 12,
    }

    I170 "170" "Track Status" [
        {
            CNF: 1, // 0 confirmed, 1 being initialised
            TRE: 1, // last report of the track
            CST: 1, // extrapolated
            CDM: 2, // 0 maintaining, 1 climbing, 2 descending, 3 invalid
            MAH: 1, // horizontal manoeuvre
            STH: 1, // 0 measured position, 1 smoothed
        }
        {
            GHO: 1, // ghost
            _: 6,
        }
    ]

    I202 "202" "Calculated Track Velocity in Cartesian Coordinates" {
        VX: 16 signed(1.0 / pow2(2), "m/s"),
        VY: 16 signed(1.0 / pow2(2), "m/s"),
    }

    I210 "210" "Calculated Acceleration" {
        AX: 8 signed(1.0 / pow2(2), "m/s²"),
        AY: 8 signed(1.0 / pow2(2), "m/s²"),
    }

    I220 "220" "Target Address" (24)

    I230 "230" "Communications/ACAS Capability and Flight Status" {
        COM: 3,  // communications capability
        STAT: 3, // alert, special position identification, airborne or on ground
        _: 2,
        MSSC: 1, // Mode S specific services
        ARC: 1,  // altitude reported in steps of: 0 100 ft, 1 25 ft
        AIC: 1,  // aircraft identification
        B1A: 1,  // BDS 1,0 bit 16
        B1B: 4,  // BDS 1,0 bits 37 to 40
    }

    I230_V1_11 "230" "Communications/ACAS Capability and Flight Status" {
        COM: 3,    // communications capability
        STAT: 3,   // alert, special position identification, airborne or on ground
        CASEVN: 2, // extended version of ACAS: 0 none, 1 Xa, 2 Xu
        MSSC: 1,   // Mode S specific services
        ARC: 1,    // altitude reported in steps of: 0 100 ft, 1 25 ft
        AIC: 1,    // aircraft identification
        B1A: 1,    // BDS 1,0 bit 16
        B1B: 4,    // BDS 1,0 bits 37 to 40
    }

    I245 "245" "Target Identification" {
        STI: 2, // 0 not downlinked, 1 registration downlinked, 2 call sign downlinked
        _: 6,
        CHR: 48 ICAO,
    }

    I250 "250" "Mode S MB Data" (repetitive {
        MBDATA: 56, // Comm-B message
        BDS1: 4,    // register number, first digit
        BDS2: 4,    // second digit
    })

    I250_V1_10 "250" "BDS Register Data" (repetitive {
        BDSREGISTER: 56, // Comm-B message
        BDS1: 4,         // register number, first digit
        BDS2: 4,         // second digit
    })

    I250_V1_11 "250" "BDS Register Data" (repetitive {
        BDSDATA: 56, // Comm-B message
        BDS1: 4,     // register number, first digit
        BDS2: 4,     // second digit
    })

    I260 "260" "ACAS Resolution Advisory Report" (56)

    // 0 unknown, 3 fire, 16 follow me, …
    I300 "300" "Vehicle Fleet Identification" (8)

    I310 "310" "Pre-programmed Message" {
        TRB: 1, // in trouble
        MSG: 7,
    }

    I400 "400" "Contributing Devices" (repetitive {
        BIT1: 1, // element names count from the left
        BIT2: 1,
        BIT3: 1,
        BIT4: 1,
        BIT5: 1,
        BIT6: 1,
        BIT7: 1,
        BIT8: 1,
    })

    I500 "500" "Position Accuracy" (compound [
        DOP "DOP of Position" {
            X: 16 unsigned(1.0 / pow2(2), ""),
            Y: 16 unsigned(1.0 / pow2(2), ""),
            XY: 16 unsigned(1.0 / pow2(2), ""),
        },
        SDP "Standard Deviation of Position" {
            X: 16 unsigned(1.0 / pow2(2), "m"),
            Y: 16 unsigned(1.0 / pow2(2), "m"),
            XY: 16 unsigned(1.0 / pow2(2), ""), // correlation; see I020/RE for a usable one
        },
        SDH "Standard Deviation of Geometric Height (WGS 84)" (16 unsigned(0.5, "m")),
    ])
}

/// The items by field reference number; those passed are not the same in all editions.
#[rustfmt::skip]
const fn profile(i020: Item, i230: Item, i250: Item) -> [Option<Item>; 28] {
    profile![
        I010, i020, I140, I041, I042, I161, I170, // FRN  1 to  7
        I070, I202, I090, I100, I220, I245, I110, //      8 to 14
        I105, I210, I300, I310, I500, I400, i250, //     15 to 21
        i230, I260, I030, I055, I050, RE, SP,     //     22 to 28
    ]
}

editions! {
    CAT020 20 "Multilateration Target Reports" "EUROCONTROL-SPEC-0149-14" ["140"]
    CAT020_V1_9 1 9 &profile(I020, I230, I250);
    CAT020_V1_10 1 10 &profile(I020_V1_10, I230, I250_V1_10);
    CAT020_V1_11 1 11 &profile(I020_V1_10, I230_V1_11, I250_V1_11);
}
