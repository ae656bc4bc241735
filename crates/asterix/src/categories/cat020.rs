//! CAT020: target reports of a multilateration system.
//!
//! EUROCONTROL-SPEC-0149-14 (SUR.ET1.ST05.2000-STD-14-02), ed 1.9 (March 2015), 1.10 and 1.11 (July 2025), with one
//! order of items: the later ones add a part to I020/020, use spare bits of I020/230 and rename an element of I020/250.

use super::{MODE_C, RE, SP};
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

const I020_PART_1: &[Part] = &[
    flag("SSR"),  // non-Mode S 1090 MHz multilateration
    flag("MS"),   // Mode S 1090 MHz multilateration
    flag("HF"),   // HF multilateration
    flag("VDL4"), // VDL Mode 4 multilateration
    flag("UAT"),  // UAT multilateration
    flag("DME"),  // DME/TACAN multilateration
    flag("OT"),   // other technology
];

const I020_PART_2: &[Part] = &[
    flag("RAB"), // from a field monitor
    flag("SPI"), // special position identification
    flag("CHN"), // 0 chain 1, 1 chain 2
    flag("GBS"), // transponder's ground bit set
    flag("CRT"), // corrupted replies
    flag("SIM"), // simulated
    flag("TST"), // test target
];

const I020: Item = Item::new("020", "Target Report Descriptor", Extended(&[I020_PART_1, I020_PART_2]));

const I020_V1_10: Item = Item::new(
    "020",
    "Target Report Descriptor",
    Extended(&[
        I020_PART_1,
        I020_PART_2,
        &[
            element("CF", 2, RAW), // address: 0 ICAO, 1 not ICAO, 2 no ADS-B message, 3 unknown
            spare(5),
        ],
    ]),
);

const I030: Item = Item::new("030", "Warning/Error Conditions", RepetitiveFx(&Element(7, RAW)));

const I041: Item = Item::new(
    "041",
    "Position In WGS-84 Coordinates",
    Group(&[
        element("LAT", 32, signed(180.0 / pow2(25), "°")),
        element("LON", 32, signed(180.0 / pow2(25), "°")),
    ]),
);

const I042: Item = Item::new(
    "042",
    "Position in Cartesian Coordinates",
    Group(&[element("X", 24, signed(0.5, "m")), element("Y", 24, signed(0.5, "m"))]),
);

const I050: Item = Item::new(
    "050",
    "Mode-2 Code in Octal Representation",
    Group(&[
        flag("V"), // 1 not validated
        flag("G"), // 1 garbled
        flag("L"), // 1 smoothed by a local tracker
        spare(1),
        element("MODE2", 12, OCTAL),
    ]),
);

const I055: Item = Item::new(
    "055",
    "Mode-1 Code in Octal Representation",
    Group(&[
        flag("V"), // 1 not validated
        flag("G"), // 1 garbled
        flag("L"), // 1 smoothed by a local tracker
        element("MODE1", 5, RAW),
    ]),
);

const I070: Item = Item::new(
    "070",
    "Mode-3/A Code in Octal Representation",
    Group(&[
        flag("V"), // 1 not validated
        flag("G"), // 1 garbled
        flag("L"), // 1 not extracted during the last update period
        spare(1),
        element("MODE3A", 12, OCTAL),
    ]),
);

const I090: Item = Item::new(
    "090",
    "Flight Level in Binary Representation",
    Group(&[
        flag("V"), // 1 not validated
        flag("G"), // 1 garbled
        element("FL", 14, signed(1.0 / pow2(2), "FL")),
    ]),
);

const I100: Item = Item::new("100", "Mode C Code", Group(MODE_C));

const I105: Item = Item::new("105", "Geometric Height (WGS-84)", Element(16, signed(6.25, "ft")));

const I110: Item = Item::new(
    "110",
    "Measured Height (Local Cartesian Coordinates)", // above the system reference point of I019/610
    Element(16, signed(6.25, "ft")),
);

const I140: Item = Item::new("140", "Time of Day", Element(24, unsigned(1.0 / pow2(7), "s")));

const I161: Item = Item::new("161", "Track Number", Group(&[spare(4), element("TRN", 12, RAW)]));

const I170: Item = Item::new(
    "170",
    "Track Status",
    Extended(&[
        &[
            flag("CNF"),            // 0 confirmed, 1 being initialised
            flag("TRE"),            // last report of the track
            flag("CST"),            // extrapolated
            element("CDM", 2, RAW), // 0 maintaining, 1 climbing, 2 descending, 3 invalid
            flag("MAH"),            // horizontal manoeuvre
            flag("STH"),            // 0 measured position, 1 smoothed
        ],
        &[
            flag("GHO"), // ghost
            spare(6),
        ],
    ]),
);

const I202: Item = Item::new(
    "202",
    "Calculated Track Velocity in Cartesian Coordinates",
    Group(&[
        element("VX", 16, signed(1.0 / pow2(2), "m/s")),
        element("VY", 16, signed(1.0 / pow2(2), "m/s")),
    ]),
);

const I210: Item = Item::new(
    "210",
    "Calculated Acceleration",
    Group(&[
        element("AX", 8, signed(1.0 / pow2(2), "m/s²")),
        element("AY", 8, signed(1.0 / pow2(2), "m/s²")),
    ]),
);

const I220: Item = Item::new("220", "Target Address", Element(24, RAW));

const I230: Item = Item::new(
    "230",
    "Communications/ACAS Capability and Flight Status",
    Group(&[
        element("COM", 3, RAW),  // communications capability
        element("STAT", 3, RAW), // alert, special position identification, airborne or on ground
        spare(2),
        flag("MSSC"),           // Mode S specific services
        flag("ARC"),            // altitude reported in steps of: 0 100 ft, 1 25 ft
        flag("AIC"),            // aircraft identification
        flag("B1A"),            // BDS 1,0 bit 16
        element("B1B", 4, RAW), // BDS 1,0 bits 37 to 40
    ]),
);

const I230_V1_11: Item = Item::new(
    "230",
    "Communications/ACAS Capability and Flight Status",
    Group(&[
        element("COM", 3, RAW),    // communications capability
        element("STAT", 3, RAW),   // alert, special position identification, airborne or on ground
        element("CASEVN", 2, RAW), // extended version of ACAS: 0 none, 1 Xa, 2 Xu
        flag("MSSC"),              // Mode S specific services
        flag("ARC"),               // altitude reported in steps of: 0 100 ft, 1 25 ft
        flag("AIC"),               // aircraft identification
        flag("B1A"),               // BDS 1,0 bit 16
        element("B1B", 4, RAW),    // BDS 1,0 bits 37 to 40
    ]),
);

const I245: Item = Item::new(
    "245",
    "Target Identification",
    Group(&[
        element("STI", 2, RAW), // 0 not downlinked, 1 registration downlinked, 2 call sign downlinked
        spare(6),
        element("CHR", 48, ICAO),
    ]),
);

const I250: Item = Item::new(
    "250",
    "Mode S MB Data",
    Repetitive(&Group(&[
        element("MBDATA", 56, RAW), // Comm-B message
        element("BDS1", 4, RAW),    // register number, first digit
        element("BDS2", 4, RAW),    // second digit
    ])),
);

const I250_V1_10: Item = Item::new(
    "250",
    "BDS Register Data",
    Repetitive(&Group(&[
        element("BDSREGISTER", 56, RAW), // Comm-B message
        element("BDS1", 4, RAW),         // register number, first digit
        element("BDS2", 4, RAW),         // second digit
    ])),
);

const I250_V1_11: Item = Item::new(
    "250",
    "BDS Register Data",
    Repetitive(&Group(&[
        element("BDSDATA", 56, RAW), // Comm-B message
        element("BDS1", 4, RAW),     // register number, first digit
        element("BDS2", 4, RAW),     // second digit
    ])),
);

const I260: Item = Item::new("260", "ACAS Resolution Advisory Report", Element(56, RAW));

// 0 unknown, 3 fire, 16 follow me, …
const I300: Item = Item::new("300", "Vehicle Fleet Identification", Element(8, RAW));

const I310: Item = Item::new(
    "310",
    "Pre-programmed Message",
    Group(&[
        flag("TRB"), // in trouble
        element("MSG", 7, RAW),
    ]),
);

const I400: Item = Item::new(
    "400",
    "Contributing Devices", // devices are numbered from the last bit of the last octet: the last octet has 8 … 1
    Repetitive(&Group(&[
        flag("BIT1"), // element names count from the left
        flag("BIT2"),
        flag("BIT3"),
        flag("BIT4"),
        flag("BIT5"),
        flag("BIT6"),
        flag("BIT7"),
        flag("BIT8"),
    ])),
);

const I500: Item = Item::new(
    "500",
    "Position Accuracy",
    Compound(&[
        subitem(
            "DOP",
            "DOP of Position",
            Group(&[
                element("X", 16, unsigned(1.0 / pow2(2), "")),
                element("Y", 16, unsigned(1.0 / pow2(2), "")),
                element("XY", 16, unsigned(1.0 / pow2(2), "")),
            ]),
        ),
        subitem(
            "SDP",
            "Standard Deviation of Position",
            Group(&[
                element("X", 16, unsigned(1.0 / pow2(2), "m")),
                element("Y", 16, unsigned(1.0 / pow2(2), "m")),
                element("XY", 16, unsigned(1.0 / pow2(2), "")), // correlation; see I020/RE for a usable one
            ]),
        ),
        subitem(
            "SDH",
            "Standard Deviation of Geometric Height (WGS 84)",
            Element(16, unsigned(0.5, "m")),
        ),
    ]),
);

/// The items of an edition; those passed are not the same in all.
#[rustfmt::skip]
const fn items(i020: Item, i230: Item, i250: Item) -> [Item; 28] {
    [
        I010, i020, I030, I041, I042, I050, I055, I070,
        I090, I100, I105, I110, I140, I161, I170, I202,
        I210, I220, i230, I245, i250, I260, I300, I310,
        I400, I500, RE, SP,
    ]
}

#[rustfmt::skip]
const ORDER: &[&str] = &[
    "010", "020", "140", "041", "042", "161", "170", // FRN  1 to  7
    "070", "202", "090", "100", "220", "245", "110", //      8 to 14
    "105", "210", "300", "310", "500", "400", "250", //     15 to 21
    "230", "260", "030", "055", "050", "RE", "SP",   //     22 to 28
];

const fn edition(minor: u8, items: &'static [Item]) -> Category {
    Category {
        number: 20,
        edition: Edition::new(1, minor),
        title: "Multilateration Target Reports",
        document: "EUROCONTROL-SPEC-0149-14",
        items,
        profile: Profile::Single(Uap::new(items, ORDER)),
    }
}

/// Multilateration target reports, ed 1.9.
pub static CAT020_V1_9: Category = edition(9, &items(I020, I230, I250));

/// Multilateration target reports, ed 1.10.
pub static CAT020_V1_10: Category = edition(10, &items(I020_V1_10, I230, I250_V1_10));

/// Multilateration target reports, ed 1.11.
pub static CAT020_V1_11: Category = edition(11, &items(I020_V1_10, I230_V1_11, I250_V1_11));

/// Every edition of the category.
pub static CAT020: &[&Category] = &[&CAT020_V1_9, &CAT020_V1_10, &CAT020_V1_11];
