//! Editions 2.1 to 2.7.

use super::{AIR_SPEED, I110};
use crate::categories::{RE, SOURCE, SP};
use crate::table::*;

items! {
    I008 "008" "Aircraft Operational Status" {
        RA: 1,      // TCAS resolution advisory active
        TC: 2,      // trajectory change reports: 0 none, 1 TC+0, 2 several
        TS: 1,      // capable of target state reports
        ARV: 1,     // capable of air-referenced velocity
        CDTIA: 1,   // cockpit display of traffic information operational
        NOTTCAS: 1, // 1 TCAS not operational
        SA: 1,      // single antenna
    }

    I010 "010" "Data Source Identification" (SOURCE)

    I015 "015" "Service Identification" (8) // chosen by the ground station

    // report period; 0: on every event
    I016 "016" "Service Management" (8 unsigned(0.5, "s"))

    // 0 unknown, 1 light … 5 heavy, 10 rotorcraft, 20 and 21 vehicles
    I020 "020" "Emitter Category" (8)

    parts I040_PART_1 {
        ATP: 3, // address: 0 ICAO, 1 duplicate, 2 surface vehicle, 3 anonymous
        ARC: 2, // altitude in steps of: 0 25 ft, 1 100 ft, 2 unknown
        RC: 1,  // passed the range check, CPR validation pending
        RAB: 1, // from a field monitor, a fixed transponder
    }

    parts I040_PART_2 {
        DCR: 1, // differential correction
        GBS: 1, // ground bit set
        SIM: 1, // simulated
        TST: 1, // test target
        SAA: 1, // 1 not able to provide selected altitude
        CL: 2,  // confidence: 0 valid, 1 suspect, 2 no information
    }

    parts I040_PART_3 {
        _: 1,
        LLC: 1,  // failed the list lookup
        IPC: 1,  // failed the independent position check
        NOGO: 1, // 1 the ground station says not to use it
        CPR: 1,  // failed the CPR validation
        LDPJ: 1, // position jumped in local decoding
        RCF: 1,  // failed the range check
    }

    I040 "040" "Target Report Descriptor" [
        I040_PART_1
        I040_PART_2
        {
            _: 2,
            IPC: 1,  // failed the independent position check
            NOGO: 1, // 1 the ground station says not to use it
            CPR: 1,  // failed the CPR validation
            LDPJ: 1, // position jumped in local decoding
            RCF: 1,  // failed the range check
        }
    ]

    I040_V2_3 "040" "Target Report Descriptor" [I040_PART_1 I040_PART_2 I040_PART_3]

    I040_V2_6 "040" "Target Report Descriptor" [
        I040_PART_1
        I040_PART_2
        I040_PART_3
        {
            TBC: { EP: 1, VAL: 6 NUMBER }, // total bits corrected
        }
        {
            MBC: { EP: 1, VAL: 6 NUMBER }, // most bits corrected in a message
        }
    ]

    I070 "070" "Mode 3/A Code in Octal Representation" {
        _: 4,
        MODE3A: 12 OCTAL,
    }

    // that the position in I021/130 and 131 is valid for
    I071 "071" "Time of Applicability for Position" (24 unsigned(1.0 / pow2(7), "s"))

    I072 "072" "Time of Applicability for Velocity" (24 unsigned(1.0 / pow2(7), "s"))
    I073 "073" "Time of Message Reception for Position" (24 unsigned(1.0 / pow2(7), "s"))

    I074 "074" "Time of Message Reception of Position-High Precision" {
        FSI: 2, // whole seconds of I021/073: 0 as they are, 1 plus one, 2 minus one
        TOMRP: 30 unsigned(1.0 / pow2(30), "s"),
    }

    I075 "075" "Time of Message Reception for Velocity" (24 unsigned(1.0 / pow2(7), "s"))

    I076 "076" "Time of Message Reception of Velocity-High Precision" {
        FSI: 2, // whole seconds of I021/075: 0 as they are, 1 plus one, 2 minus one
        TOMRP: 30 unsigned(1.0 / pow2(30), "s"),
    }

    I077 "077" "Time of ASTERIX Report Transmission" (24 unsigned(1.0 / pow2(7), "s"))
    I080 "080" "Target Address" (24)

    parts I090_PART_1 {
        NUCRNACV: 3, // version 0: uncertainty, later: accuracy category for velocity
        NUCPNIC: 4,  // version 0: uncertainty, later: integrity category for position
    }

    parts I090_PART_2 {
        NICBARO: 1, // barometric altitude cross-checked
        SIL: 2,     // surveillance or source integrity level
        NACP: 4,    // accuracy category for position
    }

    parts I090_PART_3 {
        _: 2,
        SILS: 1, // SIL per: 0 flight hour, 1 sample
        SDA: 2,  // design assurance level
        GVA: 2,  // geometric altitude accuracy
    }

    I090 "090" "Quality Indicators" [
        I090_PART_1
        I090_PART_2
        I090_PART_3
        {
            PIC: 4, // position integrity category
            _: 3,
        }
    ]

    I090_V2_7 "090" "Quality Indicators" [
        I090_PART_1
        I090_PART_2
        I090_PART_3
        {
            PIC: 4, // position integrity category
            SRC: 1, // of PIC: 0 type code and NIC supplements, 1 received as such
            _: 2,
        }
        {
            _: 2,
            VALSTATE: { EP: 1, VAL: 2 }, // 0 not done, 1 undecided, 2 passed, 3 failed
            VD: 1,                       // validation distance follows
            VQ: 1,                       // quality of the validation distance follows
        }
        {
            VALDISTP1: 7 unsigned(128.0, "m"), // the distance is the sum of both
        }
        {
            VALDISTP2: 7 unsigned(1.0, "m"),
        }
        {
            VALDISTQUALP1: 7 unsigned(128.0, "m"),
        }
        {
            VALDISTQUALP2: 7 unsigned(1.0, "m"),
        }
    ]

    I130 "130" "Position in WGS-84 Co-ordinates" {
        LAT: 24 signed(180.0 / pow2(23), "°"),
        LON: 24 signed(180.0 / pow2(23), "°"),
    }

    I131 "131" "High-Resolution Position in WGS-84 Co-ordinates" {
        LAT: 32 signed(180.0 / pow2(30), "°"),
        LON: 32 signed(180.0 / pow2(30), "°"),
    }

    I132 "132" "Message Amplitude" (8 signed(1.0, "dBm"))
    I140 "140" "Geometric Height" (16 signed(6.25, "ft"))
    I145 "145" "Flight Level" (16 signed(1.0 / pow2(2), "FL"))

    I146 "146" "Selected Altitude" {
        SAS: 1, // source given
        S: 2,   // 0 unknown, 1 aircraft altitude, 2 MCP/FCU, 3 FMS
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

    I151 "151" "True Airspeed" {
        RE: 1, // 1 beyond the range
        TAS: 15 unsigned(1.0, "kt"),
    }

    I152 "152" "Magnetic Heading" (16 unsigned(360.0 / pow2(16), "°"))

    I155 "155" "Barometric Vertical Rate" {
        RE: 1, // 1 beyond the range
        BVR: 15 signed(6.25, "ft/min"),
    }

    I157 "157" "Geometric Vertical Rate" {
        RE: 1, // 1 beyond the range
        GVR: 15 signed(6.25, "ft/min"),
    }

    I160 "160" "Airborne Ground Vector" {
        RE: 1, // 1 beyond the range
        GS: 15 unsigned(1.0 / pow2(14), "NM/s"),
        TA: 16 unsigned(360.0 / pow2(16), "°"),
    }

    I161 "161" "Track Number" {
        _: 4,
        TRNUM: 12,
    }

    I165 "165" "Track Angle Rate" {
        _: 6,
        TAR: 10 signed(1.0 / pow2(5), "°/s"),
    }

    I170 "170" "Target Identification" (48 ICAO)

    I200 "200" "Target Status" {
        ICF: 1,  // intent change
        LNAV: 1, // 0 lateral navigation engaged, 1 not
        _: 1,
        PS: 3, // emergency: 0 none, 1 general, 2 medical, 3 fuel, 4 radio, 5 unlawful, 6 downed
        SS: 2, // 0 nothing, 1 permanent alert, 2 temporary alert, 3 special position identification
    }

    I200_V2_2 "200" "Target Status" {
        ICF: 1,  // intent change
        LNAV: 1, // 0 lateral navigation engaged, 1 not
        ME: 1,   // military emergency
        PS: 3,   // emergency: 0 none, 1 general, 2 medical, 3 fuel, 4 radio, 5 unlawful, 6 downed
        SS: 2,   // 0 nothing, 1 permanent alert, 2 temporary alert, 3 special position identification
    }

    I210 "210" "MOPS Version" {
        _: 1,
        VNS: 1, // version not supported by the ground station
        VN: 3,  // 0 DO-260, 1 DO-260A, 2 DO-260B, 3 DO-260C
        LTT: 3, // 0 other, 1 UAT, 2 1090 MHz extended squitter, 3 VDL 4
    }

    I220 "220" "Met Information" (compound [
        WS "Wind Speed" (16 unsigned(1.0, "kt")),
        WD "Wind Direction" (16 unsigned(1.0, "°")),
        TMP "Temperature" (16 signed(1.0 / pow2(2), "°C")),
        TRB "Turbulence" (8 NUMBER), // 0 to 15
    ])

    I230 "230" "Roll Angle" (16 signed(0.01, "°")) // negative: left wing down

    // 56 bits of message, 8 of register number
    I250 "250" "Mode S MB Data" (repetitive (64))

    I260 "260" "ACAS Resolution Advisory Report" {
        TYP: 5,  // 28 in a version 2 squitter
        STYP: 3, // 2 in a version 2 squitter
        ARA: 14, // active resolution advisories
        RAC: 4,  // complements
        RAT: 1,  // terminated
        MTE: 1,  // more than one threat
        TTI: 2,  // what TID holds
        TID: 26, // identity of the threat
    }

    parts I271_PART_1 {
        _: 2,
        POA: 1,   // 1 the position is that of the ADS-B reference point
        CDTIS: 1, // cockpit display of traffic information operational
        B2LOW: 1, // transmits with less than 70 W
        RAS: 1,   // receiving ATC services
        IDENT: 1, // IDENT switch active
    }

    I271 "271" "Surface Capabilities and Characteristics" [
        I271_PART_1
        {
            // The only part of an extended item that has no FX bit.
            _: 4,
            LW: 4, // length and width, as a code
        }
    ]

    I271_V2_2 "271" "Surface Capabilities and Characteristics" [
        I271_PART_1
        {
            LW: 4, // length and width, as a code
            _: 3,
        }
    ]

    I295 "295" "Data Ages" (= Layout::Compound(&ages(age("ISA", "Intermediate State Selected Altitude Age"))))
    I295_V2_6 "295" "Data Ages" (= Layout::Compound(&ages(age("SAL", "Selected Altitude Age"))))
}

const fn ages(selected_altitude: Option<Item>) -> [Option<Item>; 23] {
    [
        age("AOS", "Aircraft Operational Status Age"),
        age("TRD", "Target Report Descriptor Age"),
        age("M3A", "Mode 3/A Age"),
        age("QI", "Quality Indicators Age"),
        age("TI1", "Trajectory Intent Age"),
        age("MAM", "Message Amplitude Age"),
        age("GH", "Geometric Height Age"),
        age("FL", "Flight Level Age"),
        selected_altitude,
        age("FSA", "Final State Selected Altitude Age"),
        age("AS", "Air Speed Age"),
        age("TAS", "True Air Speed Age"),
        age("MH", "Magnetic Heading Age"),
        age("BVR", "Barometric Vertical Rate Age"),
        age("GVR", "Geometric Vertical Rate Age"),
        age("GV", "Ground Vector Age"),
        age("TAR", "Track Angle Rate Age"),
        age("TI2", "Target Identification Age"),
        age("TS", "Target Status Age"),
        age("MET", "Met Information Age"),
        age("ROA", "Roll Angle Age"),
        age("ARA", "ACAS Resolution Advisory Age"),
        age("SCC", "Surface Capabilities and Characteristics Age"),
    ]
}

const fn age(name: &'static str, title: &'static str) -> Option<Item> {
    subitem(name, title, Layout::Element(8, unsigned(0.1, "s")))
}

items! {
    I400 "400" "Receiver ID" (8)
}

/// The items by field reference number; those passed are not the same in all editions.
#[rustfmt::skip]
const fn profile(i040: Item, i090: Item, i200: Item, i271: Item, i295: Item) -> [Option<Item>; 49] {
    profile![
        I010, i040, I161, I015, I071, I130, I131, // FRN  1 to  7
        I072, I150, I151, I080, I073, I074, I075, //      8 to 14
        I076, I140, i090, I210, I070, I230, I145, //     15 to 21
        I152, i200, I155, I157, I160, I165, I077, //     22 to 28
        I170, I020, I220, I146, I148, I110, I016, //     29 to 35
        I008, i271, I132, I250, I260, I400, i295, //     36 to 42
        _, _, _, _, _, RE, SP,                    //     43 to 49
    ]
}

editions! {
    CAT021_V2 21 "ADS-B Target Reports" "EUROCONTROL-SPEC-0149-12" ["077", "073", "071"]
    CAT021_V2_1 2 1 &profile(I040, I090, I200, I271, I295);
    CAT021_V2_2 2 2 &profile(I040, I090, I200_V2_2, I271_V2_2, I295);
    CAT021_V2_3 2 3 &profile(I040_V2_3, I090, I200_V2_2, I271_V2_2, I295);
    CAT021_V2_4 2 4 &profile(I040_V2_3, I090, I200_V2_2, I271_V2_2, I295);
    CAT021_V2_5 2 5 &profile(I040_V2_3, I090, I200_V2_2, I271_V2_2, I295);
    CAT021_V2_6 2 6 &profile(I040_V2_6, I090, I200_V2_2, I271_V2_2, I295_V2_6);
    CAT021_V2_7 2 7 &profile(I040_V2_6, I090_V2_7, I200_V2_2, I271_V2_2, I295_V2_6);
}
