//! CAT062: tracks of a surveillance data processing system.
//!
//! EUROCONTROL-SPEC-0149-9, ed 1.16 to 1.21 (June 2025), with the same order of items. Spare bits in I062/060 and 080
//! got a meaning, the height in I062/340 a sign, and a subitem of I062/380 another name.

mod re;

pub use re::{CAT062_RE_V1_2, CAT062_RE_V1_3};

use crate::categories::{MODE_3A, RE, SOURCE, SP};
use crate::table::*;

items! {
    I010 "010" "Data Source Identifier" (SOURCE)

    I015 "015" "Service Identification" (8) // chosen by the system
    I040 "040" "Track Number" (16)

    I060 "060" "Track Mode 3/A Code" {
        _: 2,
        CH: 1, // changed
        _: 1,
        MODE3A: 12 OCTAL,
    }

    I060_V1_17 "060" "Track Mode 3/A Code" {
        V: 1,  // 1 not validated
        G: 1,  // 1 garbled
        CH: 1, // changed
        _: 1,
        MODE3A: 12 OCTAL,
    }

    I070 "070" "Time Of Track Information" (24 unsigned(1.0 / pow2(7), "s"))

    parts I080_PART_1 {
        MON: 1, // 0 several sensors, 1 one sensor
        SPI: 1, // special position identification in the last report
        MRH: 1, // more reliable height: 0 barometric, 1 geometric
        SRC: 3, // of I062/130: 0 none, 1 GNSS, 2 radar, 3 triangulation, 4 coverage, 5 speed, 6 default, …
        CNF: 1, // 0 confirmed, 1 tentative
    }

    parts I080_PART_2 {
        SIM: 1, // simulated
        TSE: 1, // last message of the track
        TSB: 1, // first message of the track
        FPC: 1, // correlated with a flight plan
        AFF: 1, // ADS-B inconsistent with other surveillance
        STP: 1, // slave track promoted
        KOS: 1, // service: 0 complementary, 1 background
    }

    parts I080_PART_3 {
        AMA: 1, // result of an amalgamation
        MD4: 2, // Mode 4: 0 not interrogated, 1 friend, 2 unknown, 3 no reply
        ME: 1,  // military emergency
        MI: 1,  // military identification
        MD5: 2, // Mode 5, as MD4
    }

    parts I080_PART_4 {
        CST: 1, // coasting; this and the next four: the last update is older than the system's threshold
        PSR: 1,
        SSR: 1,
        MDS: 1,
        ADS: 1,
        SUC: 1, // special code, of interest to the system
        AAC: 1, // assigned Mode A code conflicts with another track
    }

    parts I080_PART_5 {
        SDS: 2,  // surveillance data: 0 combined, 1 co-operative only, 2 non-co-operative only
        EMS: 3,  // emergency: 0 none, 1 general, 2 medical, 3 fuel, 4 radio, 5 unlawful, 6 downed
        PFT: 1,  // possibly a false track
        FPLT: 1, // created or updated with a flight plan
    }

    parts I080_PART_6 {
        DUPT: 1, // duplicate Mode 3/A code
        DUPF: 1, // duplicate flight plan
        DUPM: 1, // duplicate flight plan by manual correlation
        SFC: 1,  // surface target
        IDD: 1,  // duplicate flight identification
        IEC: 1,  // inconsistent emergency code
        MLAT: 1, // last multilateration update too old
    }

    I080 "080" "Track Status" [
        I080_PART_1
        I080_PART_2
        I080_PART_3
        I080_PART_4
        I080_PART_5
        {
            DUPT: 1, // duplicate Mode 3/A code
            DUPF: 1, // duplicate flight plan
            DUPM: 1, // duplicate flight plan by manual correlation
            _: 4,
        }
    ]

    I080_V1_18 "080" "Track Status" [
        I080_PART_1
        I080_PART_2
        I080_PART_3
        I080_PART_4
        I080_PART_5
        {
            DUPT: 1, // duplicate Mode 3/A code
            DUPF: 1, // duplicate flight plan
            DUPM: 1, // duplicate flight plan by manual correlation
            SFC: 1,  // surface target
            IDD: 1,  // duplicate flight identification
            IEC: 1,  // inconsistent emergency code
            _: 1,
        }
    ]

    I080_V1_20 "080" "Track Status" [I080_PART_1 I080_PART_2 I080_PART_3 I080_PART_4 I080_PART_5 I080_PART_6]

    I080_V1_21 "080" "Track Status" [
        I080_PART_1
        I080_PART_2
        I080_PART_3
        I080_PART_4
        I080_PART_5
        I080_PART_6
        {
            M5I: 1, // last Mode 5 interrogation update too old
            _: 6,
        }
    ]

    I100 "100" "Calculated Track Position (Cartesian)" {
        X: 24 signed(0.5, "m"),
        Y: 24 signed(0.5, "m"),
    }

    I105 "105" "Calculated Position In WGS-84 Co-ordinates" {
        LAT: 32 signed(180.0 / pow2(25), "°"),
        LON: 32 signed(180.0 / pow2(25), "°"),
    }

    I110 "110" "Mode 5 Data Reports and Extended Mode 1 Code" (compound [
        SUM "Mode 5 Summary" {
            M5: 1, // Mode 5 interrogated
            ID: 1, // authenticated identification reply
            DA: 1, // authenticated data reply or report
            M1: 1, // this and the next three: the code came in a Mode 5 reply
            M2: 1,
            M3: 1,
            MC: 1,
            X: 1, // X-pulse
        },
        PMN "Mode 5 PIN/ National Origin/Mission Code" {
            _: 2,
            PIN: 14,
            _: 3,
            NAT: 5, // national origin
            _: 2,
            MIS: 6, // mission
        },
        POS "Mode 5 Reported Position" {
            LAT: 24 signed(180.0 / pow2(23), "°"),
            LON: 24 signed(180.0 / pow2(23), "°"),
        },
        GA "Mode 5 GNSS-derived Altitude" {
            _: 1,
            RES: 1, // reported in steps of: 0 100 ft, 1 25 ft
            GA: 14 signed(25.0, "ft"),
        },
        EM1 "Extended Mode 1 Code in Octal Representation" {
            _: 4,
            EM1: 12 OCTAL,
        },
        TOS "Time Offset for POS and GA" (8 signed(1.0 / pow2(7), "s")), // of POS and GA to I062/070
        XP "X Pulse Presence" {
            _: 3,
            X5: 1, // X-pulse in the Mode 5 data reply
            XC: 1, // in the Mode C reply
            X3: 1, // in the Mode 3/A reply
            X2: 1, // in the Mode 2 reply
            X1: 1, // in the Mode 1 reply
        },
    ])

    I120 "120" "Track Mode 2 Code" {
        _: 4,
        MODE2: 12 OCTAL,
    }

    I130 "130" "Calculated Track Geometric Altitude" (16 signed(6.25, "ft"))

    I135 "135" "Calculated Track Barometric Altitude" {
        QNH: 1, // corrected with the local pressure
        CTB: 15 signed(1.0 / pow2(2), "FL"),
    }

    I136 "136" "Measured Flight Level" (16 signed(1.0 / pow2(2), "FL"))

    I185 "185" "Calculated Track Velocity (Cartesian)" {
        VX: 16 signed(1.0 / pow2(2), "m/s"),
        VY: 16 signed(1.0 / pow2(2), "m/s"),
    }

    I200 "200" "Mode of Movement" {
        TRANS: 2, // 0 constant course, 1 right turn, 2 left turn, 3 undetermined
        LONG: 2,  // 0 constant speed, 1 increasing, 2 decreasing, 3 undetermined
        VERT: 2,  // 0 level, 1 climb, 2 descent, 3 undetermined
        ADF: 1,   // altitudes disagree
        _: 1,
    }

    I210 "210" "Calculated Acceleration (Cartesian)" {
        AX: 8 signed(1.0 / pow2(2), "m/s²"),
        AY: 8 signed(1.0 / pow2(2), "m/s²"),
    }

    I220 "220" "Calculated Rate of Climb/Descent" (16 signed(6.25, "ft/min"))

    I245 "245" "Target Identification" {
        STI: 2, // 0 downlinked, 1 call sign not downlinked, 2 registration not downlinked
        _: 6,
        CHR: 48 ICAO,
    }

    I270 "270" "Target Size and Orientation" [
        {
            LENGTH: 7 unsigned(1.0, "m"),
        }
        {
            ORIENTATION: 7 unsigned(360.0 / pow2(7), "°"), // clockwise from geographical north
        }
        {
            WIDTH: 7 unsigned(1.0, "m"),
        }
    ]
}

const fn age(name: &'static str, title: &'static str) -> Option<Item> {
    subitem(name, title, Layout::Element(8, unsigned(1.0 / pow2(2), "s")))
}

items! {
    I290 "290" "System Track Update Ages" (compound [
        (= age("TRK", "Track Age")),
        (= age("PSR", "PSR Age")),
        (= age("SSR", "SSR Age")),
        (= age("MDS", "Mode S Age")),
        ADS "ADS-C Age" (16 unsigned(1.0 / pow2(2), "s")),
        (= age("ES", "ADS-B Extended Squitter Age")),
        (= age("VDL", "ADS-B VDL Mode 4 Age")),
        (= age("UAT", "ADS-B UAT Age")),
        (= age("LOP", "Loop Age")),
        (= age("MLT", "Multilateration Age")),
    ])

    I295 "295" "Track Data Ages" (compound [
        (= age("MFL", "Measured Flight Level Age")),
        (= age("MD1", "Mode 1 Age")),
        (= age("MD2", "Mode 2 Age")),
        (= age("MDA", "Mode 3/A Age")),
        (= age("MD4", "Mode 4 Age")),
        (= age("MD5", "Mode 5 Age")),
        (= age("MHG", "Magnetic Heading Age")),
        (= age("IAS", "Indicated Airspeed / Mach Nb Age")),
        (= age("TAS", "True Airspeed Age")),
        (= age("SAL", "Selected Altitude Age")),
        (= age("FSS", "Final State Selected Altitude Age")),
        (= age("TID", "Trajectory Intent Age")),
        (= age("COM", "Communication/ACAS Capability and Flight Status Age")),
        (= age("SAB", "Status Reported by ADS-B Age")),
        (= age("ACS", "ACAS Resolution Advisory Report Age")),
        (= age("BVR", "Barometric Vertical Rate Age")),
        (= age("GVR", "Geometrical Vertical Rate Age")),
        (= age("RAN", "Roll Angle Age")),
        (= age("TAR", "Track Angle Rate Age")),
        (= age("TAN", "Track Angle Age")),
        (= age("GSP", "Ground Speed Age")),
        (= age("VUN", "Velocity Uncertainty Age")),
        (= age("MET", "Meteorological Data Age")),
        (= age("EMC", "Emitter Category Age")),
        (= age("POS", "Position Age")),
        (= age("GAL", "Geometric Altitude Age")),
        (= age("PUN", "Position Uncertainty Age")),
        (= age("MB", "Mode S MB Data Age")),
        (= age("IAR", "Indicated Airspeed Data Age")),
        (= age("MAC", "Mach Number Data Age")),
        (= age("BPS", "Barometric Pressure Setting Data Age")),
    ])

    // 0 unknown, 3 fire, 16 follow me, …
    I300 "300" "Vehicle Fleet Identification" (8)

    sub I340_SID "SID" "Sensor Identification" (SOURCE)

    sub I340_POS "POS" "Measured Position" {
        RHO: 16 unsigned(1.0 / pow2(8), "NM"),
        THETA: 16 unsigned(360.0 / pow2(16), "°"),
    }

    sub I340_HEIGHT "HEIGHT" "Measured 3-D Height" (16 unsigned(25.0, "ft"))
    sub I340_HEIGHT_V1_19 "HEIGHT" "Measured 3-D Height" (16 signed(25.0, "ft"))

    sub I340_MDC "MDC" "Last Measured Mode C Code" {
        V: 1, // 1 not validated
        G: 1, // 1 garbled
        LMC: 14 signed(1.0 / pow2(2), "FL"),
    }

    sub I340_MDA "MDA" "Last Measured Mode 3/A Code" (MODE_3A)

    sub I340_TYP "TYP" "Report Type" {
        TYP: 3, // as I048/020
        SIM: 1, // simulated
        RAB: 1, // from a field monitor, a fixed transponder
        TST: 1, // test target
        _: 2,
    }
}

#[rustfmt::skip]
items! {
    I340 "340" "Measured Information" (compound [
        I340_SID, I340_POS, I340_HEIGHT, I340_MDC, I340_MDA, I340_TYP,
    ])
}

#[rustfmt::skip]
items! {
    I340_V1_19 "340" "Measured Information" (compound [
        I340_SID, I340_POS, I340_HEIGHT_V1_19, I340_MDC, I340_MDA, I340_TYP,
    ])
}

/// Air speed: indicated, or a Mach number, depending on the flag before the value.
const AIR_SPEED: Content = Content::Depends {
    on: "IM",
    cases: &[(0, unsigned(1.0 / pow2(14), "NM/s")), (1, unsigned(0.001, "Mach"))],
    otherwise: &RAW,
};

items! {
    sub I380_ADR "ADR" "Target Address" (24)
    sub I380_ID "ID" "Target Identification" (48 ICAO)
    sub I380_MHG "MHG" "Magnetic Heading" (16 unsigned(360.0 / pow2(16), "°"))

    sub I380_IAS "IAS" "Indicated Airspeed/Mach No" {
        IM: 1, // 0 indicated air speed, 1 Mach number
        IAS: 15 AIR_SPEED,
    }

    sub I380_TAS "TAS" "True Airspeed" (16 unsigned(1.0, "kt"))

    sub I380_SAL "SAL" "Selected Altitude" {
        SAS: 1, // source given
        SRC: 2, // 0 unknown, 1 aircraft altitude, 2 MCP/FCU, 3 FMS
        ALT: 13 signed(25.0, "ft"),
    }

    sub I380_FSS "FSS" "Final State Selected Altitude" {
        MV: 1, // manage vertical mode active
        AH: 1, // altitude hold mode active
        AM: 1, // approach mode active
        ALT: 13 signed(25.0, "ft"),
    }

    sub I380_TIS "TIS" "Trajectory Intent Status" [{
        NAV: 1, // 1 not available
        NVB: 1, // 1 not valid
        _: 5,
    }]

    sub I380_TID "TID" "Trajectory Intent Data" (repetitive {
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
    })

    sub I380_COM "COM" "Communications/ACAS Capability and Flight Status" {
        COM: 3,  // communications capability
        STAT: 3, // alert, special position identification, airborne or on ground
        _: 2,
        SSC: 1, // specific services
        ARC: 1, // altitude reported in steps of: 0 100 ft, 1 25 ft
        AIC: 1, // aircraft identification
        B1A: 1, // BDS 1,0 bit 16
        B1B: 4, // BDS 1,0 bits 37 to 40
    }

    sub I380_SAB "SAB" "Status Reported by ADS-B" {
        AC: 2,  // ACAS: 0 unknown, 1 not operational, 2 operational
        MN: 2,  // multiple navigation aids: 0 unknown, 1 not operating, 2 operating
        DC: 2,  // differential correction: 0 unknown, 1 yes, 2 no
        GBS: 1, // ground bit set
        _: 6,
        STAT: 3, // emergency: 0 none, 1 general, 2 medical, 3 fuel, 4 radio, 5 unlawful, 6 downed
    }

    sub I380_ACS "ACS" "ACAS Resolution Advisory Report" (56)
    sub I380_BVR "BVR" "Barometric Vertical Rate" (16 signed(6.25, "ft/min"))
    sub I380_GVR "GVR" "Geometric Vertical Rate" (16 signed(6.25, "ft/min"))
    sub I380_RAN "RAN" "Roll Angle" (16 signed(0.01, "°")) // negative: left wing down

    sub I380_TAR "TAR" "Track Angle Rate" {
        TI: 2, // 0 not available, 1 left, 2 right, 3 straight
        _: 6,
        ROT: 7 signed(1.0 / pow2(2), "°/s"), // positive to the right
        _: 1,
    }

    sub I380_TAN "TAN" "Track Angle" (16 unsigned(360.0 / pow2(16), "°"))
    sub I380_GS "GS" "Ground Speed" (16 signed(1.0 / pow2(14), "NM/s"))

    // a category, of the least accurate component
    sub I380_VUN "VUN" "Velocity Uncertainty" (8)

    sub I380_MET "MET" "Meteorological Data" {
        WS: 1,  // 1 the speed below is valid
        WD: 1,  // 1 the direction is valid
        TMP: 1, // 1 the temperature is valid
        TRB: 1, // 1 the turbulence is valid
        _: 4,
        WSD: 16 unsigned(1.0, "kt"),
        WDD: 16 unsigned(1.0, "°"),
        TMPD: 16 signed(1.0 / pow2(2), "°C"),
        TRBD: 8 NUMBER, // 0 to 15
    }

    // 1 light, 3 medium, 5 heavy, 10 rotorcraft, 20 and 21 vehicles
    sub I380_EMC "EMC" "Emitter Category" (8)

    sub I380_POS "POS" "Position" {
        LAT: 24 signed(180.0 / pow2(23), "°"),
        LON: 24 signed(180.0 / pow2(23), "°"),
    }

    sub I380_GAL "GAL" "Geometric Altitude" (16 signed(6.25, "ft"))

    sub I380_PUN "PUN" "Position Uncertainty" {
        _: 4,
        PUN: 4, // a category
    }

    // 56 bits of message, 8 of register number
    sub I380_MB "MB" "MODE S MB DATA" (repetitive (64))

    // 56 bits of message, 8 of register number
    sub I380_BDSDATA "BDSDATA" "BDS Register DATA" (repetitive (64))

    sub I380_IAR "IAR" "Indicated Airspeed" (16 unsigned(1.0, "kt"))
    sub I380_MAC "MAC" "Mach Number" (16 unsigned(0.008, "Mach"))

    sub I380_BPS "BPS" "Barometric Pressure Setting" {
        _: 4,
        BPS: 12 unsigned(0.1, "mb"), // above 800 mb
    }
}

#[rustfmt::skip]
items! {
    I380 "380" "Aircraft Derived Data" (compound [
        I380_ADR, I380_ID, I380_MHG, I380_IAS, I380_TAS, I380_SAL,
        I380_FSS, I380_TIS, I380_TID, I380_COM, I380_SAB, I380_ACS,
        I380_BVR, I380_GVR, I380_RAN, I380_TAR, I380_TAN, I380_GS,
        I380_VUN, I380_MET, I380_EMC, I380_POS, I380_GAL, I380_PUN,
        I380_MB, I380_IAR, I380_MAC, I380_BPS,
    ])
}

#[rustfmt::skip]
items! {
    I380_V1_20 "380" "Aircraft Derived Data" (compound [
        I380_ADR, I380_ID, I380_MHG, I380_IAS, I380_TAS, I380_SAL,
        I380_FSS, I380_TIS, I380_TID, I380_COM, I380_SAB, I380_ACS,
        I380_BVR, I380_GVR, I380_RAN, I380_TAR, I380_TAN, I380_GS,
        I380_VUN, I380_MET, I380_EMC, I380_POS, I380_GAL, I380_PUN,
        I380_BDSDATA, I380_IAR, I380_MAC, I380_BPS,
    ])

    I390 "390" "Flight Plan Related Data" (compound [
        TAG "FPPS Identification Tag" {
            SAC: 8, // system area code
            SIC: 8, // system identification code
        },
        CS "Callsign" (56 ASCII),
        IFI "IFPS_FLIGHT_ID" {
            TYP: 2, // number of: 0 the plan, 1 to 3 unit 1 to 3
            _: 3,
            NBR: 27 NUMBER,
        },
        FCT "Flight Category" {
            GATOAT: 2, // 0 unknown, 1 general air traffic, 2 operational air traffic
            FR1FR2: 2, // 0 instrument, 1 visual, 3 controlled visual flight rules
            RVSM: 2,   // 0 unknown, 1 approved, 2 exempt, 3 not approved
            HPR: 1,    // high priority
            _: 1,
        },
        TAC "Type of Aircraft" (32 ASCII),
        WTC "Wake Turbulence Category" (8 ASCII), // L, M, H, J
        DEP "Departure Airport" (32 ASCII),
        DST "Destination Airport" (32 ASCII),
        RDS "Runway Designation" {
            NU1: 8 ASCII,
            NU2: 8 ASCII,
            LTR: 8 ASCII,
        },
        CFL "Current Cleared Flight Level" (16 unsigned(1.0 / pow2(2), "FL")),
        CTL "Current Control Position" {
            CENTRE: 8,   // centre
            POSITION: 8, // its control position
        },
        TOD "Time of Departure / Arrival" (repetitive {
            TYP: 5, // 0 scheduled, 1 estimated off-block, 2 estimated take-off, … 8 arrival, …
            DAY: 2, // 0 today, 1 yesterday, 2 tomorrow
            _: 4,
            HOR: 5 NUMBER,
            _: 2,
            MIN: 6 NUMBER,
            AVS: 1, // 1 seconds not available
            _: 1,
            SEC: 6 NUMBER,
        }),
        AST "Aircraft Stand" (48 ASCII),
        STS "Stand Status" {
            EMP: 2, // 0 empty, 1 occupied, 2 unknown
            AVL: 2, // 0 available, 1 not available, 2 unknown
            _: 4,
        },
        STD "Standard Instrument Departure" (56 ASCII),
        STA "Standard Instrument Arrival" (56 ASCII),
        PEM "Pre-Emergency Mode 3/A" {
            _: 3,
            VA: 1, // 1 the code is valid
            MODE3A: 12 OCTAL,
        },
        PEC "Pre-Emergency Callsign" (56 ASCII),
    ])

    I500 "500" "Estimated Accuracies" (compound [
        APC "Estimated Accuracy Of Track Position (Cartesian)" {
            X: 16 unsigned(0.5, "m"), // standard deviations
            Y: 16 unsigned(0.5, "m"),
        },
        // sign, and the root of the covariance's size
        COV "XY Covariance Component" (16 signed(0.5, "m")),
        APW "Estimated Accuracy Of Track Position (WGS-84)" {
            LAT: 16 unsigned(180.0 / pow2(25), "°"),
            LON: 16 unsigned(180.0 / pow2(25), "°"),
        },
        AGA "Estimated Accuracy Of Calculated Track Geometric Altitude" (8 unsigned(6.25, "ft")),
        ABA "Estimated Accuracy Of Calculated Track Barometric Altitude" (8 unsigned(1.0 / pow2(2), "FL")),
        ATV "Estimated Accuracy Of Track Velocity (Cartesian)" {
            X: 8 unsigned(1.0 / pow2(2), "m/s"),
            Y: 8 unsigned(1.0 / pow2(2), "m/s"),
        },
        AA "Estimated Accuracy Of Acceleration (Cartesian)" {
            X: 8 unsigned(1.0 / pow2(2), "m/s²"),
            Y: 8 unsigned(1.0 / pow2(2), "m/s²"),
        },
        ARC "Estimated Accuracy Of Rate Of Climb/Descent" (8 unsigned(6.25, "ft/min")),
    ])

    I510 "510" "Composed Track Number" (repetitive_fx {
        IDENT: 8,  // system unit
        TRACK: 15, // its track number
    })
}

/// The items by field reference number; those passed are not the same in all editions.
#[rustfmt::skip]
const fn profile(i060: Item, i080: Item, i340: Item, i380: Item) -> [Option<Item>; 35] {
    profile![
        I010, _, I015, I070, I105, I100, I185,    // FRN  1 to  7
        I210, i060, I245, i380, I040, i080, I290, //      8 to 14
        I200, I295, I136, I130, I135, I220, I390, //     15 to 21
        I270, I300, I110, I120, I510, I500, i340, //     22 to 28
        _, _, _, _, _, RE, SP,                    //     29 to 35
    ]
}

editions! {
    CAT062 62 "SDPS Track Messages" "EUROCONTROL-SPEC-0149-9" ["070"]
    CAT062_V1_16 1 16 &profile(I060, I080, I340, I380);
    CAT062_V1_17 1 17 &profile(I060_V1_17, I080, I340, I380);
    CAT062_V1_18 1 18 &profile(I060_V1_17, I080_V1_18, I340, I380);
    CAT062_V1_19 1 19 &profile(I060_V1_17, I080_V1_18, I340_V1_19, I380);
    CAT062_V1_20 1 20 &profile(I060_V1_17, I080_V1_20, I340_V1_19, I380_V1_20);
    CAT062_V1_21 1 21 &profile(I060_V1_17, I080_V1_21, I340_V1_19, I380_V1_20);
}
