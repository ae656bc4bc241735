//! CAT020 ed 1.9: target reports of a multilateration system.
//!
//! EUROCONTROL-SPEC-0149-14 (SUR.ET1.ST05.2000-STD-14-02), March 2015.

use crate::asterix::table::Layout::{Compound, Element, Explicit, Extended, Group, Repetitive, RepetitiveFx};
use crate::asterix::table::*;

const ITEMS: &[Item] = &[
    Item::new(
        "010",
        "Data Source Identifier",
        Group(&[
            element("SAC", 8, RAW), // system area code
            element("SIC", 8, RAW), // system identification code
        ]),
    ),
    Item::new(
        "020",
        "Target Report Descriptor",
        Extended(&[
            &[
                flag("SSR"),  // non-Mode S 1090 MHz multilateration
                flag("MS"),   // Mode S 1090 MHz multilateration
                flag("HF"),   // HF multilateration
                flag("VDL4"), // VDL Mode 4 multilateration
                flag("UAT"),  // UAT multilateration
                flag("DME"),  // DME/TACAN multilateration
                flag("OT"),   // other technology
            ],
            &[
                flag("RAB"), // from a field monitor
                flag("SPI"), // special position identification
                flag("CHN"), // 0 chain 1, 1 chain 2
                flag("GBS"), // transponder's ground bit set
                flag("CRT"), // corrupted replies
                flag("SIM"), // simulated
                flag("TST"), // test target
            ],
        ]),
    ),
    Item::new("030", "Warning/Error Conditions", RepetitiveFx(&Element(7, RAW))),
    Item::new(
        "041",
        "Position In WGS-84 Coordinates",
        Group(&[
            element("LAT", 32, signed(180.0 / pow2(25), "°")),
            element("LON", 32, signed(180.0 / pow2(25), "°")),
        ]),
    ),
    Item::new(
        "042",
        "Position in Cartesian Coordinates",
        Group(&[element("X", 24, signed(0.5, "m")), element("Y", 24, signed(0.5, "m"))]),
    ),
    Item::new(
        "050",
        "Mode-2 Code in Octal Representation",
        Group(&[
            flag("V"), // 1 not validated
            flag("G"), // 1 garbled
            flag("L"), // 1 smoothed by a local tracker
            spare(1),
            element("MODE2", 12, OCTAL),
        ]),
    ),
    Item::new(
        "055",
        "Mode-1 Code in Octal Representation",
        Group(&[
            flag("V"), // 1 not validated
            flag("G"), // 1 garbled
            flag("L"), // 1 smoothed by a local tracker
            element("MODE1", 5, RAW),
        ]),
    ),
    Item::new(
        "070",
        "Mode-3/A Code in Octal Representation",
        Group(&[
            flag("V"), // 1 not validated
            flag("G"), // 1 garbled
            flag("L"), // 1 not extracted during the last update period
            spare(1),
            element("MODE3A", 12, OCTAL),
        ]),
    ),
    Item::new(
        "090",
        "Flight Level in Binary Representation",
        Group(&[
            flag("V"), // 1 not validated
            flag("G"), // 1 garbled
            element("FL", 14, signed(1.0 / pow2(2), "FL")),
        ]),
    ),
    Item::new(
        "100",
        "Mode C Code",
        Group(&[
            flag("V"), // 1 not validated
            flag("G"), // 1 garbled
            spare(2),
            element("MODEC", 12, RAW), // Gray code
            spare(4),
            flag("QC1"), // this and the following: 1 for a low quality pulse
            flag("QA1"),
            flag("QC2"),
            flag("QA2"),
            flag("QC4"),
            flag("QA4"),
            flag("QB1"),
            flag("QD1"),
            flag("QB2"),
            flag("QD2"),
            flag("QB4"),
            flag("QD4"),
        ]),
    ),
    Item::new("105", "Geometric Height (WGS-84)", Element(16, signed(6.25, "ft"))),
    Item::new(
        "110",
        "Measured Height (Local Cartesian Coordinates)", // above the system reference point of I019/610
        Element(16, signed(6.25, "ft")),
    ),
    Item::new("140", "Time of Day", Element(24, unsigned(1.0 / pow2(7), "s"))),
    Item::new("161", "Track Number", Group(&[spare(4), element("TRN", 12, RAW)])),
    Item::new(
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
    ),
    Item::new(
        "202",
        "Calculated Track Velocity in Cartesian Coordinates",
        Group(&[
            element("VX", 16, signed(1.0 / pow2(2), "m/s")),
            element("VY", 16, signed(1.0 / pow2(2), "m/s")),
        ]),
    ),
    Item::new(
        "210",
        "Calculated Acceleration",
        Group(&[
            element("AX", 8, signed(1.0 / pow2(2), "m/s²")),
            element("AY", 8, signed(1.0 / pow2(2), "m/s²")),
        ]),
    ),
    Item::new("220", "Target Address", Element(24, RAW)),
    Item::new(
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
    ),
    Item::new(
        "245",
        "Target Identification",
        Group(&[
            element("STI", 2, RAW), // 0 not downlinked, 1 registration downlinked, 2 call sign downlinked
            spare(6),
            element("CHR", 48, ICAO),
        ]),
    ),
    Item::new(
        "250",
        "Mode S MB Data",
        Repetitive(&Group(&[
            element("MBDATA", 56, RAW), // Comm-B message
            element("BDS1", 4, RAW),    // register number, first digit
            element("BDS2", 4, RAW),    // second digit
        ])),
    ),
    Item::new("260", "ACAS Resolution Advisory Report", Element(56, RAW)),
    Item::new("300", "Vehicle Fleet Identification", Element(8, RAW)), // 0 unknown, 3 fire, 16 follow me, …
    Item::new(
        "310",
        "Pre-programmed Message",
        Group(&[
            flag("TRB"), // in trouble
            element("MSG", 7, RAW),
        ]),
    ),
    Item::new(
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
    ),
    Item::new(
        "500",
        "Position Accuracy",
        Compound(&[
            Some(Item::new(
                "DOP",
                "DOP of Position",
                Group(&[
                    element("X", 16, unsigned(1.0 / pow2(2), "")),
                    element("Y", 16, unsigned(1.0 / pow2(2), "")),
                    element("XY", 16, unsigned(1.0 / pow2(2), "")),
                ]),
            )),
            Some(Item::new(
                "SDP",
                "Standard Deviation of Position",
                Group(&[
                    element("X", 16, unsigned(1.0 / pow2(2), "m")),
                    element("Y", 16, unsigned(1.0 / pow2(2), "m")),
                    element("XY", 16, unsigned(1.0 / pow2(2), "")), // correlation; see I020/RE for a usable one
                ]),
            )),
            Some(Item::new(
                "SDH",
                "Standard Deviation of Geometric Height (WGS 84)",
                Element(16, unsigned(0.5, "m")),
            )),
        ]),
    ),
    Item::new("RE", "Reserved Expansion Field", Explicit),
    Item::new("SP", "Special Purpose Field", Explicit),
];

#[rustfmt::skip]
const ORDER: &[&str] = &[
    "010", "020", "140", "041", "042", "161", "170", // FRN  1 to  7
    "070", "202", "090", "100", "220", "245", "110", //      8 to 14
    "105", "210", "300", "310", "500", "400", "250", //     15 to 21
    "230", "260", "030", "055", "050", "RE", "SP",   //     22 to 28
];

pub(crate) const UAP: Uap = Uap::new(ITEMS, ORDER);

/// Multilateration target reports, ed 1.9.
pub static CAT020_V1_9: Category = Category {
    number: 20,
    edition: Edition::new(1, 9),
    title: "Multilateration Target Reports",
    document: "EUROCONTROL-SPEC-0149-14",
    items: ITEMS,
    profile: Profile::Single(UAP),
};
