//! Editions 2.1 to 2.7.

use super::{AIR_SPEED, I110};
use crate::categories::{RE, SP};
use crate::table::Layout::{Compound, Element, Extended, Group, Repetitive};
use crate::table::*;

const I008: Item = Item::new(
    "008",
    "Aircraft Operational Status",
    Group(&[
        flag("RA"),            // TCAS resolution advisory active
        element("TC", 2, RAW), // trajectory change reports: 0 none, 1 TC+0, 2 several
        flag("TS"),            // capable of target state reports
        flag("ARV"),           // capable of air-referenced velocity
        flag("CDTIA"),         // cockpit display of traffic information operational
        flag("NOTTCAS"),       // 1 TCAS not operational
        flag("SA"),            // single antenna
    ]),
);

const I010: Item = Item::new(
    "010",
    "Data Source Identification",
    Group(&[
        element("SAC", 8, RAW), // system area code
        element("SIC", 8, RAW), // system identification code
    ]),
);

const I015: Item = Item::new("015", "Service Identification", Element(8, RAW)); // chosen by the ground station

// report period; 0: on every event
const I016: Item = Item::new("016", "Service Management", Element(8, unsigned(0.5, "s")));

// 0 unknown, 1 light … 5 heavy, 10 rotorcraft, 20 and 21 vehicles
const I020: Item = Item::new("020", "Emitter Category", Element(8, RAW));

const I040_PART_1: &[Part] = &[
    element("ATP", 3, RAW), // address: 0 ICAO, 1 duplicate, 2 surface vehicle, 3 anonymous
    element("ARC", 2, RAW), // altitude in steps of: 0 25 ft, 1 100 ft, 2 unknown
    flag("RC"),             // passed the range check, CPR validation pending
    flag("RAB"),            // from a field monitor, a fixed transponder
];

const I040_PART_2: &[Part] = &[
    flag("DCR"),           // differential correction
    flag("GBS"),           // ground bit set
    flag("SIM"),           // simulated
    flag("TST"),           // test target
    flag("SAA"),           // 1 not able to provide selected altitude
    element("CL", 2, RAW), // confidence: 0 valid, 1 suspect, 2 no information
];

const I040_PART_3: &[Part] = &[
    spare(1),
    flag("LLC"),  // failed the list lookup
    flag("IPC"),  // failed the independent position check
    flag("NOGO"), // 1 the ground station says not to use it
    flag("CPR"),  // failed the CPR validation
    flag("LDPJ"), // position jumped in local decoding
    flag("RCF"),  // failed the range check
];

const I040: Item = Item::new(
    "040",
    "Target Report Descriptor",
    Extended(&[
        I040_PART_1,
        I040_PART_2,
        &[
            spare(2),
            flag("IPC"),  // failed the independent position check
            flag("NOGO"), // 1 the ground station says not to use it
            flag("CPR"),  // failed the CPR validation
            flag("LDPJ"), // position jumped in local decoding
            flag("RCF"),  // failed the range check
        ],
    ]),
);

const I040_V2_3: Item = Item::new(
    "040",
    "Target Report Descriptor",
    Extended(&[I040_PART_1, I040_PART_2, I040_PART_3]),
);

const I040_V2_6: Item = Item::new(
    "040",
    "Target Report Descriptor",
    Extended(&[
        I040_PART_1,
        I040_PART_2,
        I040_PART_3,
        &[
            group("TBC", &[flag("EP"), element("VAL", 6, NUMBER)]), // total bits corrected
        ],
        &[
            group("MBC", &[flag("EP"), element("VAL", 6, NUMBER)]), // most bits corrected in a message
        ],
    ]),
);

const I070: Item = Item::new(
    "070",
    "Mode 3/A Code in Octal Representation",
    Group(&[spare(4), element("MODE3A", 12, OCTAL)]),
);

// that the position in I021/130 and 131 is valid for
const I071: Item = Item::new(
    "071",
    "Time of Applicability for Position",
    Element(24, unsigned(1.0 / pow2(7), "s")),
);

const I072: Item = Item::new(
    "072",
    "Time of Applicability for Velocity",
    Element(24, unsigned(1.0 / pow2(7), "s")),
);

const I073: Item = Item::new(
    "073",
    "Time of Message Reception for Position",
    Element(24, unsigned(1.0 / pow2(7), "s")),
);

const I074: Item = Item::new(
    "074",
    "Time of Message Reception of Position-High Precision",
    Group(&[
        element("FSI", 2, RAW), // whole seconds of I021/073: 0 as they are, 1 plus one, 2 minus one
        element("TOMRP", 30, unsigned(1.0 / pow2(30), "s")),
    ]),
);

const I075: Item = Item::new(
    "075",
    "Time of Message Reception for Velocity",
    Element(24, unsigned(1.0 / pow2(7), "s")),
);

const I076: Item = Item::new(
    "076",
    "Time of Message Reception of Velocity-High Precision",
    Group(&[
        element("FSI", 2, RAW), // whole seconds of I021/075: 0 as they are, 1 plus one, 2 minus one
        element("TOMRP", 30, unsigned(1.0 / pow2(30), "s")),
    ]),
);

const I077: Item = Item::new(
    "077",
    "Time of ASTERIX Report Transmission",
    Element(24, unsigned(1.0 / pow2(7), "s")),
);

const I080: Item = Item::new("080", "Target Address", Element(24, RAW));

const I090_PART_1: &[Part] = &[
    element("NUCRNACV", 3, RAW), // version 0: uncertainty, later: accuracy category for velocity
    element("NUCPNIC", 4, RAW),  // version 0: uncertainty, later: integrity category for position
];

const I090_PART_2: &[Part] = &[
    flag("NICBARO"),         // barometric altitude cross-checked
    element("SIL", 2, RAW),  // surveillance or source integrity level
    element("NACP", 4, RAW), // accuracy category for position
];

const I090_PART_3: &[Part] = &[
    spare(2),
    flag("SILS"),           // SIL per: 0 flight hour, 1 sample
    element("SDA", 2, RAW), // design assurance level
    element("GVA", 2, RAW), // geometric altitude accuracy
];

const I090: Item = Item::new(
    "090",
    "Quality Indicators",
    Extended(&[
        I090_PART_1,
        I090_PART_2,
        I090_PART_3,
        &[
            element("PIC", 4, RAW), // position integrity category
            spare(3),
        ],
    ]),
);

const I090_V2_7: Item = Item::new(
    "090",
    "Quality Indicators",
    Extended(&[
        I090_PART_1,
        I090_PART_2,
        I090_PART_3,
        &[
            element("PIC", 4, RAW), // position integrity category
            flag("SRC"),            // of PIC: 0 type code and NIC supplements, 1 received as such
            spare(2),
        ],
        &[
            spare(2),
            group("VALSTATE", &[flag("EP"), element("VAL", 2, RAW)]), // 0 not done, 1 undecided, 2 passed, 3 failed
            flag("VD"),                                               // validation distance follows
            flag("VQ"),                                               // quality of the validation distance follows
        ],
        &[
            element("VALDISTP1", 7, unsigned(128.0, "m")), // the distance is the sum of both
        ],
        &[element("VALDISTP2", 7, unsigned(1.0, "m"))],
        &[element("VALDISTQUALP1", 7, unsigned(128.0, "m"))],
        &[element("VALDISTQUALP2", 7, unsigned(1.0, "m"))],
    ]),
);

const I130: Item = Item::new(
    "130",
    "Position in WGS-84 Co-ordinates",
    Group(&[
        element("LAT", 24, signed(180.0 / pow2(23), "°")),
        element("LON", 24, signed(180.0 / pow2(23), "°")),
    ]),
);

const I131: Item = Item::new(
    "131",
    "High-Resolution Position in WGS-84 Co-ordinates",
    Group(&[
        element("LAT", 32, signed(180.0 / pow2(30), "°")),
        element("LON", 32, signed(180.0 / pow2(30), "°")),
    ]),
);

const I132: Item = Item::new("132", "Message Amplitude", Element(8, signed(1.0, "dBm")));

const I140: Item = Item::new("140", "Geometric Height", Element(16, signed(6.25, "ft")));

const I145: Item = Item::new("145", "Flight Level", Element(16, signed(1.0 / pow2(2), "FL")));

const I146: Item = Item::new(
    "146",
    "Selected Altitude",
    Group(&[
        flag("SAS"),          // source given
        element("S", 2, RAW), // 0 unknown, 1 aircraft altitude, 2 MCP/FCU, 3 FMS
        element("ALT", 13, signed(25.0, "ft")),
    ]),
);

const I148: Item = Item::new(
    "148",
    "Final State Selected Altitude",
    Group(&[
        flag("MV"), // manage vertical mode active
        flag("AH"), // altitude hold mode active
        flag("AM"), // approach mode active
        element("ALT", 13, signed(25.0, "ft")),
    ]),
);

const I150: Item = Item::new(
    "150",
    "Air Speed",
    Group(&[
        flag("IM"), // 0 indicated air speed, 1 Mach number
        element("AS", 15, AIR_SPEED),
    ]),
);

const I151: Item = Item::new(
    "151",
    "True Airspeed",
    Group(&[
        flag("RE"), // 1 beyond the range
        element("TAS", 15, unsigned(1.0, "kt")),
    ]),
);

const I152: Item = Item::new("152", "Magnetic Heading", Element(16, unsigned(360.0 / pow2(16), "°")));

const I155: Item = Item::new(
    "155",
    "Barometric Vertical Rate",
    Group(&[
        flag("RE"), // 1 beyond the range
        element("BVR", 15, signed(6.25, "ft/min")),
    ]),
);

const I157: Item = Item::new(
    "157",
    "Geometric Vertical Rate",
    Group(&[
        flag("RE"), // 1 beyond the range
        element("GVR", 15, signed(6.25, "ft/min")),
    ]),
);

const I160: Item = Item::new(
    "160",
    "Airborne Ground Vector",
    Group(&[
        flag("RE"), // 1 beyond the range
        element("GS", 15, unsigned(1.0 / pow2(14), "NM/s")),
        element("TA", 16, unsigned(360.0 / pow2(16), "°")),
    ]),
);

const I161: Item = Item::new("161", "Track Number", Group(&[spare(4), element("TRNUM", 12, RAW)]));

const I165: Item = Item::new(
    "165",
    "Track Angle Rate",
    Group(&[spare(6), element("TAR", 10, signed(1.0 / pow2(5), "°/s"))]),
);

const I170: Item = Item::new("170", "Target Identification", Element(48, ICAO));

const I200: Item = Item::new(
    "200",
    "Target Status",
    Group(&[
        flag("ICF"),  // intent change
        flag("LNAV"), // 0 lateral navigation engaged, 1 not
        spare(1),
        element("PS", 3, RAW), // emergency: 0 none, 1 general, 2 medical, 3 fuel, 4 radio, 5 unlawful, 6 downed
        element("SS", 2, RAW), // 0 nothing, 1 permanent alert, 2 temporary alert, 3 special position identification
    ]),
);

const I200_V2_2: Item = Item::new(
    "200",
    "Target Status",
    Group(&[
        flag("ICF"),           // intent change
        flag("LNAV"),          // 0 lateral navigation engaged, 1 not
        flag("ME"),            // military emergency
        element("PS", 3, RAW), // emergency: 0 none, 1 general, 2 medical, 3 fuel, 4 radio, 5 unlawful, 6 downed
        element("SS", 2, RAW), // 0 nothing, 1 permanent alert, 2 temporary alert, 3 special position identification
    ]),
);

const I210: Item = Item::new(
    "210",
    "MOPS Version",
    Group(&[
        spare(1),
        flag("VNS"),            // version not supported by the ground station
        element("VN", 3, RAW),  // 0 DO-260, 1 DO-260A, 2 DO-260B, 3 DO-260C
        element("LTT", 3, RAW), // 0 other, 1 UAT, 2 1090 MHz extended squitter, 3 VDL 4
    ]),
);

const I220: Item = Item::new(
    "220",
    "Met Information",
    Compound(&[
        subitem("WS", "Wind Speed", Element(16, unsigned(1.0, "kt"))),
        subitem("WD", "Wind Direction", Element(16, unsigned(1.0, "°"))),
        subitem("TMP", "Temperature", Element(16, signed(1.0 / pow2(2), "°C"))),
        subitem("TRB", "Turbulence", Element(8, NUMBER)), // 0 to 15
    ]),
);

const I230: Item = Item::new("230", "Roll Angle", Element(16, signed(0.01, "°"))); // negative: left wing down

// 56 bits of message, 8 of register number
const I250: Item = Item::new("250", "Mode S MB Data", Repetitive(&Element(64, RAW)));

const I260: Item = Item::new(
    "260",
    "ACAS Resolution Advisory Report",
    Group(&[
        element("TYP", 5, RAW),  // 28 in a version 2 squitter
        element("STYP", 3, RAW), // 2 in a version 2 squitter
        element("ARA", 14, RAW), // active resolution advisories
        element("RAC", 4, RAW),  // complements
        flag("RAT"),             // terminated
        flag("MTE"),             // more than one threat
        element("TTI", 2, RAW),  // what TID holds
        element("TID", 26, RAW), // identity of the threat
    ]),
);

const I271_PART_1: &[Part] = &[
    spare(2),
    flag("POA"),   // 1 the position is that of the ADS-B reference point
    flag("CDTIS"), // cockpit display of traffic information operational
    flag("B2LOW"), // transmits with less than 70 W
    flag("RAS"),   // receiving ATC services
    flag("IDENT"), // IDENT switch active
];

const I271: Item = Item::new(
    "271",
    "Surface Capabilities and Characteristics",
    Extended(&[
        I271_PART_1,
        &[
            // The only part of an extended item that has no FX bit.
            spare(4),
            element("LW", 4, RAW), // length and width, as a code
        ],
    ]),
);

const I271_V2_2: Item = Item::new(
    "271",
    "Surface Capabilities and Characteristics",
    Extended(&[
        I271_PART_1,
        &[
            element("LW", 4, RAW), // length and width, as a code
            spare(3),
        ],
    ]),
);

const I295: Item = Item::new(
    "295",
    "Data Ages",
    Compound(&ages(age("ISA", "Intermediate State Selected Altitude Age"))),
);

const I295_V2_6: Item = Item::new("295", "Data Ages", Compound(&ages(age("SAL", "Selected Altitude Age"))));

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
    subitem(name, title, Element(8, unsigned(0.1, "s")))
}

const I400: Item = Item::new("400", "Receiver ID", Element(8, RAW));

/// The items of an edition, in the document's order; those passed are not the same in all.
#[rustfmt::skip]
const fn items(i040: Item, i090: Item, i200: Item, i271: Item, i295: Item) -> [Item; 44] {
    [
        I008, I010, I015, I016, I020, i040, I070, I071,
        I072, I073, I074, I075, I076, I077, I080, i090,
        I110, I130, I131, I132, I140, I145, I146, I148,
        I150, I151, I152, I155, I157, I160, I161, I165,
        I170, i200, I210, I220, I230, I250, I260, i271,
        i295, I400, RE, SP,
    ]
}

#[rustfmt::skip]
const ORDER: &[&str] = &[
    "010", "040", "161", "015", "071", "130", "131", // FRN  1 to  7
    "072", "150", "151", "080", "073", "074", "075", //      8 to 14
    "076", "140", "090", "210", "070", "230", "145", //     15 to 21
    "152", "200", "155", "157", "160", "165", "077", //     22 to 28
    "170", "020", "220", "146", "148", "110", "016", //     29 to 35
    "008", "271", "132", "250", "260", "400", "295", //     36 to 42
    SPARE, SPARE, SPARE, SPARE, SPARE, "RE",  "SP",  //     43 to 49
];

const fn edition(minor: u8, items: &'static [Item]) -> Category {
    Category {
        number: 21,
        edition: Edition::new(2, minor),
        title: "ADS-B Target Reports",
        document: "EUROCONTROL-SPEC-0149-12",
        items,
        profile: Profile::Single(Uap::new(items, ORDER)),
    }
}

/// ADS-B target reports, ed 2.1.
pub static CAT021_V2_1: Category = edition(1, &items(I040, I090, I200, I271, I295));

/// ADS-B target reports, ed 2.2.
pub static CAT021_V2_2: Category = edition(2, &items(I040, I090, I200_V2_2, I271_V2_2, I295));

/// ADS-B target reports, ed 2.3.
pub static CAT021_V2_3: Category = edition(3, &items(I040_V2_3, I090, I200_V2_2, I271_V2_2, I295));

/// ADS-B target reports, ed 2.4.
pub static CAT021_V2_4: Category = edition(4, &items(I040_V2_3, I090, I200_V2_2, I271_V2_2, I295));

/// ADS-B target reports, ed 2.5.
pub static CAT021_V2_5: Category = edition(5, &items(I040_V2_3, I090, I200_V2_2, I271_V2_2, I295));

/// ADS-B target reports, ed 2.6.
pub static CAT021_V2_6: Category = edition(6, &items(I040_V2_6, I090, I200_V2_2, I271_V2_2, I295_V2_6));

/// ADS-B target reports, ed 2.7.
pub static CAT021_V2_7: Category = edition(7, &items(I040_V2_6, I090_V2_7, I200_V2_2, I271_V2_2, I295_V2_6));

/// Every edition from the second on.
pub static CAT021_V2: &[&Category] = &[
    &CAT021_V2_1,
    &CAT021_V2_2,
    &CAT021_V2_3,
    &CAT021_V2_4,
    &CAT021_V2_5,
    &CAT021_V2_6,
    &CAT021_V2_7,
];
