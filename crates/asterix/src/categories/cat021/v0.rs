//! Editions 0.23 to 0.26.

use super::{AIR_SPEED, I110};
use crate::categories::{MODE_3A, RE, SOURCE, SP};
use crate::table::*;

items! {
    I010 "010" "Data Source Identification" (SOURCE)

    // 1 light … 5 heavy, 10 rotorcraft, 20 and 21 vehicles
    I020 "020" "Emitter Category" (8)

    // of applicability of the position
    I030 "030" "Time of Day" (24 unsigned(1.0 / pow2(7), "s"))

    // largest error of I021/030
    I032 "032" "Time of Day Accuracy" (8 unsigned(1.0 / pow2(8), "s"))

    I040 "040" "Target Report Descriptor" {
        DCR: 1, // differential correction
        GBS: 1, // ground bit set
        SIM: 1, // simulated
        TST: 1, // test target
        RAB: 1, // from a field monitor, a fixed transponder
        SAA: 1, // 1 not able to provide selected altitude
        SPI: 1, // special position identification
        _: 1,
        ATP: 3, // address: 0 not unique, 1 ICAO, 2 surface vehicle, 3 anonymous
        ARC: 2, // altitude in steps of: 0 unknown, 1 25 ft, 2 100 ft
        _: 3,
    }

    I070_V0_26 "070" "Mode 3/A Code in Octal Representation" (MODE_3A)

    I080 "080" "Target Address" (24)

    I090 "090" "Figure of Merit" {
        AC: 2, // ACAS: 0 unknown, 1 not operational, 2 operational
        MN: 2, // multiple navigation aids: 0 unknown, 1 not operational, 2 operational
        DC: 2, // differential correction: 0 unknown, 1 yes, 2 no
        _: 6,
        // Navigational uncertainty category for position, 0 to 9. The machine-readable definition in wide use has it
        // signed, which would make 8 and 9 negative.
        PA: 4,
    }

    // navigational uncertainty category for velocity
    I095 "095" "Velocity Accuracy" (8)

    I130 "130" "Position in WGS-84 Co-ordinates" {
        LAT: 24 signed(180.0 / pow2(23), "°"),
        LON: 24 signed(180.0 / pow2(23), "°"),
    }

    I130_V0_24 "130" "Position in WGS-84 Co-ordinates" {
        LAT: 32 signed(180.0 / pow2(25), "°"),
        LON: 32 signed(180.0 / pow2(25), "°"),
    }

    I131_V0_26 "131" "Signal Amplitude" (8)
    I140 "140" "Geometric Altitude" (16 signed(6.25, "ft"))
    I145 "145" "Flight Level" (16 signed(1.0 / pow2(2), "FL"))

    I146 "146" "Intermediate State Selected Altitude" {
        SAS: 1, // source given
        SRC: 2, // 0 unknown, 1 aircraft altitude, 2 MCP/FCU, 3 FMS
        ALT: 13 signed(25.0, "ft"),
    }

    I148 "148" "Final State Selected Altitude" {
        MV: 1, // manage vertical mode active
        AH: 1, // altitude hold mode active
        AM: 1, // approach mode active
        ALT: 13 signed(25.0, "ft"),
    }

    I150 "150" "Air Speed" {
        IM: 1, // 0 indicated air speed, 1 Mach number
        AS: 15 AIR_SPEED,
    }

    I151 "151" "True Airspeed" (16 unsigned(1.0, "kt"))
    I152 "152" "Magnetic Heading" (16 unsigned(360.0 / pow2(16), "°"))
    I155 "155" "Barometric Vertical Rate" (16 signed(6.25, "ft/min"))
    I157 "157" "Geometric Vertical Rate" (16 signed(6.25, "ft/min"))

    I160 "160" "Ground Vector" {
        GS: 16 signed(1.0 / pow2(14), "NM/s"),
        TA: 16 unsigned(360.0 / pow2(16), "°"),
    }

    I165 "165" "Rate Of Turn" [
        {
            TI: 2, // 0 not available, 1 left, 2 right, 3 straight
            _: 5,
        }
        {
            ROT: 7 signed(1.0 / pow2(2), "°/s"),
        } // positive to the right
    ]

    I170 "170" "Target Identification" (48 ICAO)
    I200 "200" "Target Status" (8) // 0 no emergency, 5 unlawful interference

    I210 "210" "Link Technology Indicator" {
        _: 3,
        DTI: 1, // cockpit display of traffic information
        MDS: 1, // Mode S extended squitter
        UAT: 1,
        VDL: 1, // VDL Mode 4
        OTR: 1, // other
    }

    I220 "220" "Met Information" (compound [
        WS "Wind Speed" (16 unsigned(1.0, "kt")),
        WD "Wind Direction" (16 unsigned(1.0, "°")),
        TMP "Temperature" (16 signed(1.0 / pow2(2), "°C")),
        TRB "Turbulence" (8 NUMBER), // 0 to 15
    ])

    I230 "230" "Roll Angle" (16 signed(0.01, "°")) // negative: left wing down
}

/// The items by field reference number; those passed are not the same in all editions.
#[rustfmt::skip]
const fn profile(i130: Item) -> [Option<Item>; 35] {
    profile![
        I010, I040, I030, i130, I080, I140, I090, // FRN  1 to  7
        I210, I230, I145, I150, I151, I152, I155, //      8 to 14
        I157, I160, I165, I170, I095, I032, I200, //     15 to 21
        I020, I220, I146, I148, I110, _, _,       //     22 to 28
        _, _, _, _, _, RE, SP,                    //     29 to 35
    ]
}

#[rustfmt::skip]
const PROFILE_V0_26: &[Option<Item>] = &profile![
    I010, I040, I030, I130_V0_24, I080, I140, I090,       // FRN  1 to  7
    I210, I230, I145, I150, I151, I152, I155,             //      8 to 14
    I157, I160, I165, I170, I095, I032, I200,             //     15 to 21
    I020, I220, I146, I148, I110, I070_V0_26, I131_V0_26, //     22 to 28
    _, _, _, _, _, RE, SP,                                //     29 to 35
];

editions! {
    CAT021_V0 21 "ADS-B Target Reports" "EUROCONTROL SUR.ET1.ST05.2000-STD-12-01" ["030"]
    CAT021_V0_23 0 23 &profile(I130);
    CAT021_V0_24 0 24 &profile(I130_V0_24);
    // of the layout of ed 0.24
    CAT021_V0_25 0 25 &profile(I130_V0_24);
    CAT021_V0_26 0 26 PROFILE_V0_26;
}
