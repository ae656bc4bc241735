//! CAT062: tracks of a surveillance data processing system.
//!
//! EUROCONTROL-SPEC-0149-9, ed 1.16 to 1.21 (June 2025), with one order of items: what was spare in I062/060 and 080
//! got a meaning, the height in I062/340 a sign, and one subitem of I062/380 another name.

mod re;

pub use re::{CAT062_RE_V1_2, CAT062_RE_V1_3};

use crate::categories::{RE, SP};
use crate::table::Layout::{Compound, Element, Extended, Group, Repetitive, RepetitiveFx};
use crate::table::*;

const I010: Item = Item::new(
    "010",
    "Data Source Identifier",
    Group(&[
        element("SAC", 8, RAW), // system area code
        element("SIC", 8, RAW), // system identification code
    ]),
);

const I015: Item = Item::new("015", "Service Identification", Element(8, RAW)); // chosen by the system

const I040: Item = Item::new("040", "Track Number", Element(16, RAW));

const I060: Item = Item::new(
    "060",
    "Track Mode 3/A Code",
    Group(&[
        spare(2),
        flag("CH"), // changed
        spare(1),
        element("MODE3A", 12, OCTAL),
    ]),
);

const I060_V1_17: Item = Item::new(
    "060",
    "Track Mode 3/A Code",
    Group(&[
        flag("V"),  // 1 not validated
        flag("G"),  // 1 garbled
        flag("CH"), // changed
        spare(1),
        element("MODE3A", 12, OCTAL),
    ]),
);

const I070: Item = Item::new(
    "070",
    "Time Of Track Information",
    Element(24, unsigned(1.0 / pow2(7), "s")),
);

const I080_PART_1: &[Part] = &[
    flag("MON"),            // 0 several sensors, 1 one sensor
    flag("SPI"),            // special position identification in the last report
    flag("MRH"),            // more reliable height: 0 barometric, 1 geometric
    element("SRC", 3, RAW), // of I062/130: 0 none, 1 GNSS, 2 radar, 3 triangulation, 4 coverage, 5 speed, 6 default, …
    flag("CNF"),            // 0 confirmed, 1 tentative
];

const I080_PART_2: &[Part] = &[
    flag("SIM"), // simulated
    flag("TSE"), // last message of the track
    flag("TSB"), // first message of the track
    flag("FPC"), // correlated with a flight plan
    flag("AFF"), // ADS-B inconsistent with other surveillance
    flag("STP"), // slave track promoted
    flag("KOS"), // service: 0 complementary, 1 background
];

const I080_PART_3: &[Part] = &[
    flag("AMA"),            // result of an amalgamation
    element("MD4", 2, RAW), // Mode 4: 0 not interrogated, 1 friend, 2 unknown, 3 no reply
    flag("ME"),             // military emergency
    flag("MI"),             // military identification
    element("MD5", 2, RAW), // Mode 5, as MD4
];

const I080_PART_4: &[Part] = &[
    flag("CST"), // coasting; this and the next four: the last update is older than the system's threshold
    flag("PSR"),
    flag("SSR"),
    flag("MDS"),
    flag("ADS"),
    flag("SUC"), // special code, of interest to the system
    flag("AAC"), // assigned Mode A code conflicts with another track
];

const I080_PART_5: &[Part] = &[
    element("SDS", 2, RAW), // surveillance data: 0 combined, 1 co-operative only, 2 non-co-operative only
    element("EMS", 3, RAW), // emergency: 0 none, 1 general, 2 medical, 3 fuel, 4 radio, 5 unlawful, 6 downed
    flag("PFT"),            // possibly a false track
    flag("FPLT"),           // created or updated with a flight plan
];

const I080_PART_6: &[Part] = &[
    flag("DUPT"), // duplicate Mode 3/A code
    flag("DUPF"), // duplicate flight plan
    flag("DUPM"), // duplicate flight plan by manual correlation
    flag("SFC"),  // surface target
    flag("IDD"),  // duplicate flight identification
    flag("IEC"),  // inconsistent emergency code
    flag("MLAT"), // last multilateration update too old
];

const I080: Item = Item::new(
    "080",
    "Track Status",
    Extended(&[
        I080_PART_1,
        I080_PART_2,
        I080_PART_3,
        I080_PART_4,
        I080_PART_5,
        &[
            flag("DUPT"), // duplicate Mode 3/A code
            flag("DUPF"), // duplicate flight plan
            flag("DUPM"), // duplicate flight plan by manual correlation
            spare(4),
        ],
    ]),
);

const I080_V1_18: Item = Item::new(
    "080",
    "Track Status",
    Extended(&[
        I080_PART_1,
        I080_PART_2,
        I080_PART_3,
        I080_PART_4,
        I080_PART_5,
        &[
            flag("DUPT"), // duplicate Mode 3/A code
            flag("DUPF"), // duplicate flight plan
            flag("DUPM"), // duplicate flight plan by manual correlation
            flag("SFC"),  // surface target
            flag("IDD"),  // duplicate flight identification
            flag("IEC"),  // inconsistent emergency code
            spare(1),
        ],
    ]),
);

const I080_V1_20: Item = Item::new(
    "080",
    "Track Status",
    Extended(&[
        I080_PART_1,
        I080_PART_2,
        I080_PART_3,
        I080_PART_4,
        I080_PART_5,
        I080_PART_6,
    ]),
);

const I080_V1_21: Item = Item::new(
    "080",
    "Track Status",
    Extended(&[
        I080_PART_1,
        I080_PART_2,
        I080_PART_3,
        I080_PART_4,
        I080_PART_5,
        I080_PART_6,
        &[
            flag("M5I"), // last Mode 5 interrogation update too old
            spare(6),
        ],
    ]),
);

const I100: Item = Item::new(
    "100",
    "Calculated Track Position (Cartesian)",
    Group(&[element("X", 24, signed(0.5, "m")), element("Y", 24, signed(0.5, "m"))]),
);

const I105: Item = Item::new(
    "105",
    "Calculated Position In WGS-84 Co-ordinates",
    Group(&[
        element("LAT", 32, signed(180.0 / pow2(25), "°")),
        element("LON", 32, signed(180.0 / pow2(25), "°")),
    ]),
);

const I110: Item = Item::new(
    "110",
    "Mode 5 Data Reports and Extended Mode 1 Code",
    Compound(&[
        subitem(
            "SUM",
            "Mode 5 Summary",
            Group(&[
                flag("M5"), // Mode 5 interrogated
                flag("ID"), // authenticated identification reply
                flag("DA"), // authenticated data reply or report
                flag("M1"), // this and the next three: the code came in a Mode 5 reply
                flag("M2"),
                flag("M3"),
                flag("MC"),
                flag("X"), // X-pulse
            ]),
        ),
        subitem(
            "PMN",
            "Mode 5 PIN/ National Origin/Mission Code",
            Group(&[
                spare(2),
                element("PIN", 14, RAW),
                spare(3),
                element("NAT", 5, RAW), // national origin
                spare(2),
                element("MIS", 6, RAW), // mission
            ]),
        ),
        subitem(
            "POS",
            "Mode 5 Reported Position",
            Group(&[
                element("LAT", 24, signed(180.0 / pow2(23), "°")),
                element("LON", 24, signed(180.0 / pow2(23), "°")),
            ]),
        ),
        subitem(
            "GA",
            "Mode 5 GNSS-derived Altitude",
            Group(&[
                spare(1),
                flag("RES"), // reported in steps of: 0 100 ft, 1 25 ft
                element("GA", 14, signed(25.0, "ft")),
            ]),
        ),
        subitem(
            "EM1",
            "Extended Mode 1 Code in Octal Representation",
            Group(&[spare(4), element("EM1", 12, OCTAL)]),
        ),
        subitem(
            "TOS",
            "Time Offset for POS and GA",
            Element(8, signed(1.0 / pow2(7), "s")),
        ), // of POS and GA to I062/070
        subitem(
            "XP",
            "X Pulse Presence",
            Group(&[
                spare(3),
                flag("X5"), // X-pulse in the Mode 5 data reply
                flag("XC"), // in the Mode C reply
                flag("X3"), // in the Mode 3/A reply
                flag("X2"), // in the Mode 2 reply
                flag("X1"), // in the Mode 1 reply
            ]),
        ),
    ]),
);

const I120: Item = Item::new(
    "120",
    "Track Mode 2 Code",
    Group(&[spare(4), element("MODE2", 12, OCTAL)]),
);

const I130: Item = Item::new(
    "130",
    "Calculated Track Geometric Altitude",
    Element(16, signed(6.25, "ft")),
);

const I135: Item = Item::new(
    "135",
    "Calculated Track Barometric Altitude",
    Group(&[
        flag("QNH"), // corrected with the local pressure
        element("CTB", 15, signed(1.0 / pow2(2), "FL")),
    ]),
);

const I136: Item = Item::new("136", "Measured Flight Level", Element(16, signed(1.0 / pow2(2), "FL")));

const I185: Item = Item::new(
    "185",
    "Calculated Track Velocity (Cartesian)",
    Group(&[
        element("VX", 16, signed(1.0 / pow2(2), "m/s")),
        element("VY", 16, signed(1.0 / pow2(2), "m/s")),
    ]),
);

const I200: Item = Item::new(
    "200",
    "Mode of Movement",
    Group(&[
        element("TRANS", 2, RAW), // 0 constant course, 1 right turn, 2 left turn, 3 undetermined
        element("LONG", 2, RAW),  // 0 constant speed, 1 increasing, 2 decreasing, 3 undetermined
        element("VERT", 2, RAW),  // 0 level, 1 climb, 2 descent, 3 undetermined
        flag("ADF"),              // altitudes disagree
        spare(1),
    ]),
);

const I210: Item = Item::new(
    "210",
    "Calculated Acceleration (Cartesian)",
    Group(&[
        element("AX", 8, signed(1.0 / pow2(2), "m/s²")),
        element("AY", 8, signed(1.0 / pow2(2), "m/s²")),
    ]),
);

const I220: Item = Item::new(
    "220",
    "Calculated Rate of Climb/Descent",
    Element(16, signed(6.25, "ft/min")),
);

const I245: Item = Item::new(
    "245",
    "Target Identification",
    Group(&[
        element("STI", 2, RAW), // 0 downlinked, 1 call sign not downlinked, 2 registration not downlinked
        spare(6),
        element("CHR", 48, ICAO),
    ]),
);

const I270: Item = Item::new(
    "270",
    "Target Size and Orientation",
    Extended(&[
        &[element("LENGTH", 7, unsigned(1.0, "m"))],
        &[
            element("ORIENTATION", 7, unsigned(360.0 / pow2(7), "°")), // clockwise from geographical north
        ],
        &[element("WIDTH", 7, unsigned(1.0, "m"))],
    ]),
);

const fn age(name: &'static str, title: &'static str) -> Option<Item> {
    subitem(name, title, Element(8, unsigned(1.0 / pow2(2), "s")))
}

const I290: Item = Item::new(
    "290",
    "System Track Update Ages",
    Compound(&[
        age("TRK", "Track Age"),
        age("PSR", "PSR Age"),
        age("SSR", "SSR Age"),
        age("MDS", "Mode S Age"),
        subitem("ADS", "ADS-C Age", Element(16, unsigned(1.0 / pow2(2), "s"))),
        age("ES", "ADS-B Extended Squitter Age"),
        age("VDL", "ADS-B VDL Mode 4 Age"),
        age("UAT", "ADS-B UAT Age"),
        age("LOP", "Loop Age"),
        age("MLT", "Multilateration Age"),
    ]),
);

const I295: Item = Item::new(
    "295",
    "Track Data Ages",
    Compound(&[
        age("MFL", "Measured Flight Level Age"),
        age("MD1", "Mode 1 Age"),
        age("MD2", "Mode 2 Age"),
        age("MDA", "Mode 3/A Age"),
        age("MD4", "Mode 4 Age"),
        age("MD5", "Mode 5 Age"),
        age("MHG", "Magnetic Heading Age"),
        age("IAS", "Indicated Airspeed / Mach Nb Age"),
        age("TAS", "True Airspeed Age"),
        age("SAL", "Selected Altitude Age"),
        age("FSS", "Final State Selected Altitude Age"),
        age("TID", "Trajectory Intent Age"),
        age("COM", "Communication/ACAS Capability and Flight Status Age"),
        age("SAB", "Status Reported by ADS-B Age"),
        age("ACS", "ACAS Resolution Advisory Report Age"),
        age("BVR", "Barometric Vertical Rate Age"),
        age("GVR", "Geometrical Vertical Rate Age"),
        age("RAN", "Roll Angle Age"),
        age("TAR", "Track Angle Rate Age"),
        age("TAN", "Track Angle Age"),
        age("GSP", "Ground Speed Age"),
        age("VUN", "Velocity Uncertainty Age"),
        age("MET", "Meteorological Data Age"),
        age("EMC", "Emitter Category Age"),
        age("POS", "Position Age"),
        age("GAL", "Geometric Altitude Age"),
        age("PUN", "Position Uncertainty Age"),
        age("MB", "Mode S MB Data Age"),
        age("IAR", "Indicated Airspeed Data Age"),
        age("MAC", "Mach Number Data Age"),
        age("BPS", "Barometric Pressure Setting Data Age"),
    ]),
);

// 0 unknown, 3 fire, 16 follow me, …
const I300: Item = Item::new("300", "Vehicle Fleet Identification", Element(8, RAW));

const I340_SID: Option<Item> = subitem(
    "SID",
    "Sensor Identification",
    Group(&[
        element("SAC", 8, RAW), // system area code
        element("SIC", 8, RAW), // system identification code
    ]),
);

const I340_POS: Option<Item> = subitem(
    "POS",
    "Measured Position",
    Group(&[
        element("RHO", 16, unsigned(1.0 / pow2(8), "NM")),
        element("THETA", 16, unsigned(360.0 / pow2(16), "°")),
    ]),
);

const I340_HEIGHT: Option<Item> = subitem("HEIGHT", "Measured 3-D Height", Element(16, unsigned(25.0, "ft")));

const I340_HEIGHT_V1_19: Option<Item> = subitem("HEIGHT", "Measured 3-D Height", Element(16, signed(25.0, "ft")));

const I340_MDC: Option<Item> = subitem(
    "MDC",
    "Last Measured Mode C Code",
    Group(&[
        flag("V"), // 1 not validated
        flag("G"), // 1 garbled
        element("LMC", 14, signed(1.0 / pow2(2), "FL")),
    ]),
);

const I340_MDA: Option<Item> = subitem(
    "MDA",
    "Last Measured Mode 3/A Code",
    Group(&[
        flag("V"), // 1 not validated
        flag("G"), // 1 garbled
        flag("L"), // 1 from a local tracker of the sensor
        spare(1),
        element("MODE3A", 12, OCTAL),
    ]),
);

const I340_TYP: Option<Item> = subitem(
    "TYP",
    "Report Type",
    Group(&[
        element("TYP", 3, RAW), // as I048/020
        flag("SIM"),            // simulated
        flag("RAB"),            // from a field monitor, a fixed transponder
        flag("TST"),            // test target
        spare(2),
    ]),
);

#[rustfmt::skip]
const I340: Item = Item::new(
    "340",
    "Measured Information",
    Compound(&[
        I340_SID, I340_POS, I340_HEIGHT, I340_MDC, I340_MDA, I340_TYP,
    ]),
);

#[rustfmt::skip]
const I340_V1_19: Item = Item::new(
    "340",
    "Measured Information",
    Compound(&[
        I340_SID, I340_POS, I340_HEIGHT_V1_19, I340_MDC, I340_MDA, I340_TYP,
    ]),
);

/// Of which the flag before it says whether it is an indicated air speed or a Mach number.
const AIR_SPEED: Content = Content::Depends {
    on: "IM",
    cases: &[(0, unsigned(1.0 / pow2(14), "NM/s")), (1, unsigned(0.001, "Mach"))],
    otherwise: &RAW,
};

const I380_ADR: Option<Item> = subitem("ADR", "Target Address", Element(24, RAW));

const I380_ID: Option<Item> = subitem("ID", "Target Identification", Element(48, ICAO));

const I380_MHG: Option<Item> = subitem("MHG", "Magnetic Heading", Element(16, unsigned(360.0 / pow2(16), "°")));

const I380_IAS: Option<Item> = subitem(
    "IAS",
    "Indicated Airspeed/Mach No",
    Group(&[
        flag("IM"), // 0 indicated air speed, 1 Mach number
        element("IAS", 15, AIR_SPEED),
    ]),
);

const I380_TAS: Option<Item> = subitem("TAS", "True Airspeed", Element(16, unsigned(1.0, "kt")));

const I380_SAL: Option<Item> = subitem(
    "SAL",
    "Selected Altitude",
    Group(&[
        flag("SAS"),            // source given
        element("SRC", 2, RAW), // 0 unknown, 1 aircraft altitude, 2 MCP/FCU, 3 FMS
        element("ALT", 13, signed(25.0, "ft")),
    ]),
);

const I380_FSS: Option<Item> = subitem(
    "FSS",
    "Final State Selected Altitude",
    Group(&[
        flag("MV"), // manage vertical mode active
        flag("AH"), // altitude hold mode active
        flag("AM"), // approach mode active
        element("ALT", 13, signed(25.0, "ft")),
    ]),
);

const I380_TIS: Option<Item> = subitem(
    "TIS",
    "Trajectory Intent Status",
    Extended(&[&[
        flag("NAV"), // 1 not available
        flag("NVB"), // 1 not valid
        spare(5),
    ]]),
);

const I380_TID: Option<Item> = subitem(
    "TID",
    "Trajectory Intent Data",
    Repetitive(&Group(&[
        flag("TCA"),             // 1 number of the change point not available
        flag("NC"),              // 1 the aircraft will not fly this path
        element("TCPN", 6, RAW), // number of the change point
        element("ALT", 16, signed(10.0, "ft")),
        element("LAT", 24, signed(180.0 / pow2(23), "°")),
        element("LON", 24, signed(180.0 / pow2(23), "°")),
        element("PT", 4, RAW), // kind of point: 1 fly by, 2 fly over, … 7 top of climb, …
        element("TD", 2, RAW), // turn: 1 right, 2 left, 3 none
        flag("TRA"),           // turn radius available
        flag("TOA"),           // 1 time over point not available
        element("TOV", 24, unsigned(1.0, "s")), // time over point, since midnight
        element("TTR", 16, unsigned(0.01, "NM")), // turn radius
    ])),
);

const I380_COM: Option<Item> = subitem(
    "COM",
    "Communications/ACAS Capability and Flight Status",
    Group(&[
        element("COM", 3, RAW),  // communications capability
        element("STAT", 3, RAW), // alert, special position identification, airborne or on ground
        spare(2),
        flag("SSC"),            // specific services
        flag("ARC"),            // altitude reported in steps of: 0 100 ft, 1 25 ft
        flag("AIC"),            // aircraft identification
        flag("B1A"),            // BDS 1,0 bit 16
        element("B1B", 4, RAW), // BDS 1,0 bits 37 to 40
    ]),
);

const I380_SAB: Option<Item> = subitem(
    "SAB",
    "Status Reported by ADS-B",
    Group(&[
        element("AC", 2, RAW), // ACAS: 0 unknown, 1 not operational, 2 operational
        element("MN", 2, RAW), // multiple navigation aids: 0 unknown, 1 not operating, 2 operating
        element("DC", 2, RAW), // differential correction: 0 unknown, 1 yes, 2 no
        flag("GBS"),           // ground bit set
        spare(6),
        element("STAT", 3, RAW), // emergency: 0 none, 1 general, 2 medical, 3 fuel, 4 radio, 5 unlawful, 6 downed
    ]),
);

const I380_ACS: Option<Item> = subitem("ACS", "ACAS Resolution Advisory Report", Element(56, RAW));

const I380_BVR: Option<Item> = subitem("BVR", "Barometric Vertical Rate", Element(16, signed(6.25, "ft/min")));

const I380_GVR: Option<Item> = subitem("GVR", "Geometric Vertical Rate", Element(16, signed(6.25, "ft/min")));

const I380_RAN: Option<Item> = subitem("RAN", "Roll Angle", Element(16, signed(0.01, "°"))); // negative: left wing down

const I380_TAR: Option<Item> = subitem(
    "TAR",
    "Track Angle Rate",
    Group(&[
        element("TI", 2, RAW), // 0 not available, 1 left, 2 right, 3 straight
        spare(6),
        element("ROT", 7, signed(1.0 / pow2(2), "°/s")), // positive to the right
        spare(1),
    ]),
);

const I380_TAN: Option<Item> = subitem("TAN", "Track Angle", Element(16, unsigned(360.0 / pow2(16), "°")));

const I380_GS: Option<Item> = subitem("GS", "Ground Speed", Element(16, signed(1.0 / pow2(14), "NM/s")));

// a category, of the least accurate component
const I380_VUN: Option<Item> = subitem("VUN", "Velocity Uncertainty", Element(8, RAW));

const I380_MET: Option<Item> = subitem(
    "MET",
    "Meteorological Data",
    Group(&[
        flag("WS"),  // 1 the speed below is valid
        flag("WD"),  // 1 the direction is valid
        flag("TMP"), // 1 the temperature is valid
        flag("TRB"), // 1 the turbulence is valid
        spare(4),
        element("WSD", 16, unsigned(1.0, "kt")),
        element("WDD", 16, unsigned(1.0, "°")),
        element("TMPD", 16, signed(1.0 / pow2(2), "°C")),
        element("TRBD", 8, NUMBER), // 0 to 15
    ]),
);

// 1 light, 3 medium, 5 heavy, 10 rotorcraft, 20 and 21 vehicles
const I380_EMC: Option<Item> = subitem("EMC", "Emitter Category", Element(8, RAW));

const I380_POS: Option<Item> = subitem(
    "POS",
    "Position",
    Group(&[
        element("LAT", 24, signed(180.0 / pow2(23), "°")),
        element("LON", 24, signed(180.0 / pow2(23), "°")),
    ]),
);

const I380_GAL: Option<Item> = subitem("GAL", "Geometric Altitude", Element(16, signed(6.25, "ft")));

const I380_PUN: Option<Item> = subitem(
    "PUN",
    "Position Uncertainty",
    Group(&[
        spare(4),
        element("PUN", 4, RAW), // a category
    ]),
);

// 56 bits of message, 8 of register number
const I380_MB: Option<Item> = subitem("MB", "MODE S MB DATA", Repetitive(&Element(64, RAW)));

// 56 bits of message, 8 of register number
const I380_BDSDATA: Option<Item> = subitem("BDSDATA", "BDS Register DATA", Repetitive(&Element(64, RAW)));

const I380_IAR: Option<Item> = subitem("IAR", "Indicated Airspeed", Element(16, unsigned(1.0, "kt")));

const I380_MAC: Option<Item> = subitem("MAC", "Mach Number", Element(16, unsigned(0.008, "Mach")));

const I380_BPS: Option<Item> = subitem(
    "BPS",
    "Barometric Pressure Setting",
    Group(&[
        spare(4),
        element("BPS", 12, unsigned(0.1, "mb")), // above 800 mb
    ]),
);

#[rustfmt::skip]
const I380: Item = Item::new(
    "380",
    "Aircraft Derived Data",
    Compound(&[
        I380_ADR, I380_ID, I380_MHG, I380_IAS, I380_TAS, I380_SAL, I380_FSS,
        I380_TIS, I380_TID, I380_COM, I380_SAB, I380_ACS, I380_BVR, I380_GVR,
        I380_RAN, I380_TAR, I380_TAN, I380_GS, I380_VUN, I380_MET, I380_EMC,
        I380_POS, I380_GAL, I380_PUN, I380_MB, I380_IAR, I380_MAC, I380_BPS,
    ]),
);

#[rustfmt::skip]
const I380_V1_20: Item = Item::new(
    "380",
    "Aircraft Derived Data",
    Compound(&[
        I380_ADR, I380_ID, I380_MHG, I380_IAS, I380_TAS, I380_SAL, I380_FSS,
        I380_TIS, I380_TID, I380_COM, I380_SAB, I380_ACS, I380_BVR, I380_GVR,
        I380_RAN, I380_TAR, I380_TAN, I380_GS, I380_VUN, I380_MET, I380_EMC,
        I380_POS, I380_GAL, I380_PUN, I380_BDSDATA, I380_IAR, I380_MAC, I380_BPS,
    ]),
);

const I390: Item = Item::new(
    "390",
    "Flight Plan Related Data",
    Compound(&[
        subitem(
            "TAG",
            "FPPS Identification Tag",
            Group(&[
                element("SAC", 8, RAW), // system area code
                element("SIC", 8, RAW), // system identification code
            ]),
        ),
        subitem("CS", "Callsign", Element(56, ASCII)),
        subitem(
            "IFI",
            "IFPS_FLIGHT_ID",
            Group(&[
                element("TYP", 2, RAW), // number of: 0 the plan, 1 to 3 unit 1 to 3
                spare(3),
                element("NBR", 27, NUMBER),
            ]),
        ),
        subitem(
            "FCT",
            "Flight Category",
            Group(&[
                element("GATOAT", 2, RAW), // 0 unknown, 1 general air traffic, 2 operational air traffic
                element("FR1FR2", 2, RAW), // 0 instrument, 1 visual, 3 controlled visual flight rules
                element("RVSM", 2, RAW),   // 0 unknown, 1 approved, 2 exempt, 3 not approved
                flag("HPR"),               // high priority
                spare(1),
            ]),
        ),
        subitem("TAC", "Type of Aircraft", Element(32, ASCII)),
        subitem("WTC", "Wake Turbulence Category", Element(8, ASCII)), // L, M, H, J
        subitem("DEP", "Departure Airport", Element(32, ASCII)),
        subitem("DST", "Destination Airport", Element(32, ASCII)),
        subitem(
            "RDS",
            "Runway Designation",
            Group(&[
                element("NU1", 8, ASCII),
                element("NU2", 8, ASCII),
                element("LTR", 8, ASCII),
            ]),
        ),
        subitem(
            "CFL",
            "Current Cleared Flight Level",
            Element(16, unsigned(1.0 / pow2(2), "FL")),
        ),
        subitem(
            "CTL",
            "Current Control Position",
            Group(&[
                element("CENTRE", 8, RAW),   // centre
                element("POSITION", 8, RAW), // its control position
            ]),
        ),
        subitem(
            "TOD",
            "Time of Departure / Arrival",
            Repetitive(&Group(&[
                element("TYP", 5, RAW), // 0 scheduled, 1 estimated off-block, 2 estimated take-off, … 8 arrival, …
                element("DAY", 2, RAW), // 0 today, 1 yesterday, 2 tomorrow
                spare(4),
                element("HOR", 5, NUMBER),
                spare(2),
                element("MIN", 6, NUMBER),
                flag("AVS"), // 1 seconds not available
                spare(1),
                element("SEC", 6, NUMBER),
            ])),
        ),
        subitem("AST", "Aircraft Stand", Element(48, ASCII)),
        subitem(
            "STS",
            "Stand Status",
            Group(&[
                element("EMP", 2, RAW), // 0 empty, 1 occupied, 2 unknown
                element("AVL", 2, RAW), // 0 available, 1 not available, 2 unknown
                spare(4),
            ]),
        ),
        subitem("STD", "Standard Instrument Departure", Element(56, ASCII)),
        subitem("STA", "Standard Instrument Arrival", Element(56, ASCII)),
        subitem(
            "PEM",
            "Pre-Emergency Mode 3/A",
            Group(&[
                spare(3),
                flag("VA"), // 1 the code is valid
                element("MODE3A", 12, OCTAL),
            ]),
        ),
        subitem("PEC", "Pre-Emergency Callsign", Element(56, ASCII)),
    ]),
);

const I500: Item = Item::new(
    "500",
    "Estimated Accuracies",
    Compound(&[
        subitem(
            "APC",
            "Estimated Accuracy Of Track Position (Cartesian)",
            Group(&[
                element("X", 16, unsigned(0.5, "m")), // standard deviations
                element("Y", 16, unsigned(0.5, "m")),
            ]),
        ),
        // sign, and the root of the covariance's size
        subitem("COV", "XY Covariance Component", Element(16, signed(0.5, "m"))),
        subitem(
            "APW",
            "Estimated Accuracy Of Track Position (WGS-84)",
            Group(&[
                element("LAT", 16, unsigned(180.0 / pow2(25), "°")),
                element("LON", 16, unsigned(180.0 / pow2(25), "°")),
            ]),
        ),
        subitem(
            "AGA",
            "Estimated Accuracy Of Calculated Track Geometric Altitude",
            Element(8, unsigned(6.25, "ft")),
        ),
        subitem(
            "ABA",
            "Estimated Accuracy Of Calculated Track Barometric Altitude",
            Element(8, unsigned(1.0 / pow2(2), "FL")),
        ),
        subitem(
            "ATV",
            "Estimated Accuracy Of Track Velocity (Cartesian)",
            Group(&[
                element("X", 8, unsigned(1.0 / pow2(2), "m/s")),
                element("Y", 8, unsigned(1.0 / pow2(2), "m/s")),
            ]),
        ),
        subitem(
            "AA",
            "Estimated Accuracy Of Acceleration (Cartesian)",
            Group(&[
                element("X", 8, unsigned(1.0 / pow2(2), "m/s²")),
                element("Y", 8, unsigned(1.0 / pow2(2), "m/s²")),
            ]),
        ),
        subitem(
            "ARC",
            "Estimated Accuracy Of Rate Of Climb/Descent",
            Element(8, unsigned(6.25, "ft/min")),
        ),
    ]),
);

const I510: Item = Item::new(
    "510",
    "Composed Track Number",
    RepetitiveFx(&Group(&[
        element("IDENT", 8, RAW),  // system unit
        element("TRACK", 15, RAW), // its track number
    ])),
);

/// The items of an edition, in the document's order; those passed are not the same in all.
#[rustfmt::skip]
const fn items(i060: Item, i080: Item, i340: Item, i380: Item) -> [Item; 29] {
    [
        I010, I015, I040, i060, I070, i080, I100, I105,
        I110, I120, I130, I135, I136, I185, I200, I210,
        I220, I245, I270, I290, I295, I300, i340, i380,
        I390, I500, I510, RE, SP,
    ]
}

#[rustfmt::skip]
const ORDER: &[&str] = &[
    "010", SPARE, "015", "070", "105", "100", "185", // FRN  1 to  7
    "210", "060", "245", "380", "040", "080", "290", //      8 to 14
    "200", "295", "136", "130", "135", "220", "390", //     15 to 21
    "270", "300", "110", "120", "510", "500", "340", //     22 to 28
    SPARE, SPARE, SPARE, SPARE, SPARE, "RE",  "SP",  //     29 to 35
];

const fn edition(minor: u8, items: &'static [Item]) -> Category {
    Category {
        number: 62,
        edition: Edition::new(1, minor),
        title: "SDPS Track Messages",
        document: "EUROCONTROL-SPEC-0149-9",
        items,
        profile: Profile::Single(Uap::new(items, ORDER)),
    }
}

/// System tracks, ed 1.16.
pub static CAT062_V1_16: Category = edition(16, &items(I060, I080, I340, I380));

/// System tracks, ed 1.17.
pub static CAT062_V1_17: Category = edition(17, &items(I060_V1_17, I080, I340, I380));

/// System tracks, ed 1.18.
pub static CAT062_V1_18: Category = edition(18, &items(I060_V1_17, I080_V1_18, I340, I380));

/// System tracks, ed 1.19.
pub static CAT062_V1_19: Category = edition(19, &items(I060_V1_17, I080_V1_18, I340_V1_19, I380));

/// System tracks, ed 1.20.
pub static CAT062_V1_20: Category = edition(20, &items(I060_V1_17, I080_V1_20, I340_V1_19, I380_V1_20));

/// System tracks, ed 1.21.
pub static CAT062_V1_21: Category = edition(21, &items(I060_V1_17, I080_V1_21, I340_V1_19, I380_V1_20));

/// Every edition of the category.
pub static CAT062: &[&Category] = &[
    &CAT062_V1_16,
    &CAT062_V1_17,
    &CAT062_V1_18,
    &CAT062_V1_19,
    &CAT062_V1_20,
    &CAT062_V1_21,
];
