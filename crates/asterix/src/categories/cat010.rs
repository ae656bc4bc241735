//! CAT010 ed 1.1: target reports and service messages of surface movement radars and other sensors of an airport.
//!
//! EUROCONTROL-SPEC-0149-7 (SUR.ET1.ST05.2000-STD-07-01), March 2007.
//!
//! # Two LSBs that differ from the machine-readable definition
//!
//! The machine-readable definition in wide use gives I010/202 an LSB of 2^-4 m/s and I010/210 one of 2^-4 m/s², and
//! with them ranges (±8192 m/s, ±31 m/s²) that their widths can only reach with 2^-2. CAT020 gives 2^-2 for both of
//! its corresponding items. Recordings decide: in 39,000 reports of moving targets from a surface radar and a
//! multilateration system, the speed from I010/202 at 2^-4 is a quarter of the ground speed in I010/200 (ratios
//! 4.02 and 4.00) and of the displacement between reports (4.00 and 3.98), and the radar's change of velocity is
//! 3.7 times I010/210 at 2^-4 (correlation 0.89). This table has 2^-2 for both.

use super::{RE, SP};
use crate::table::Layout::{Element, Extended, Group, Repetitive};
use crate::table::*;

const I000: Item = Item::new("000", "Message Type", Element(8, RAW)); // 1 target report, 2 update cycle, 3 and 4 status

const I010: Item = Item::new(
    "010",
    "Data Source Identifier",
    Group(&[
        element("SAC", 8, RAW), // system area code, 0 for data local to an airport
        element("SIC", 8, RAW), // system identification code
    ]),
);

const I020: Item = Item::new(
    "020",
    "Target Report Descriptor",
    Extended(&[
        &[
            element("TYP", 3, RAW), // 0 SSR mlat, 1 Mode S mlat, 2 ADS-B, 3 PSR, 4 loop, 5 HF mlat, 7 other
            flag("DCR"),            // differential correction (ADS-B)
            flag("CHN"),            // 0 chain 1, 1 chain 2
            flag("GBS"),            // transponder's ground bit set
            flag("CRT"),            // corrupted replies in multilateration
        ],
        &[
            flag("SIM"),            // simulated
            flag("TST"),            // test target
            flag("RAB"),            // from a field monitor, a fixed transponder
            element("LOP", 2, RAW), // 0 undetermined, 1 loop start, 2 loop finish
            element("TOT", 2, RAW), // 0 undetermined, 1 aircraft, 2 ground vehicle, 3 helicopter
        ],
        &[
            flag("SPI"), // special position identification
            spare(6),
        ],
    ]),
);

const I040: Item = Item::new(
    "040",
    "Measured Position in Polar Co-ordinates",
    Group(&[
        element("RHO", 16, unsigned(1.0, "m")),
        element("TH", 16, unsigned(360.0 / pow2(16), "°")),
    ]),
);

const I041: Item = Item::new(
    "041",
    "Position in WGS-84 Co-ordinates",
    Group(&[
        element("LAT", 32, signed(180.0 / pow2(31), "°")),
        element("LON", 32, signed(180.0 / pow2(31), "°")),
    ]),
);

const I042: Item = Item::new(
    "042",
    "Position in Cartesian Co-ordinates",
    Group(&[element("X", 16, signed(1.0, "m")), element("Y", 16, signed(1.0, "m"))]),
);

const I060: Item = Item::new(
    "060",
    "Mode-3/A Code in Octal Representation",
    Group(&[
        flag("V"), // 1 not validated
        flag("G"), // 1 garbled
        flag("L"), // 1 not extracted during the last scan
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

const I091: Item = Item::new("091", "Measured Height", Element(16, signed(6.25, "ft")));

const I131: Item = Item::new("131", "Amplitude of Primary Plot", Element(8, RAW)); // 0 is the least detectable

const I140: Item = Item::new("140", "Time of Day", Element(24, unsigned(1.0 / pow2(7), "s")));

const I161: Item = Item::new("161", "Track Number", Group(&[spare(4), element("TRK", 12, RAW)]));

const I170: Item = Item::new(
    "170",
    "Track Status",
    Extended(&[
        &[
            flag("CNF"),            // 0 confirmed, 1 being initialised
            flag("TRE"),            // last report of the track
            element("CST", 2, RAW), // extrapolated: 0 no, 1 between scans, 2 in masked area, 3 unpredictable
            flag("MAH"),            // horizontal manoeuvre
            flag("TCC"),            // 0 sensor plane, 1 slant range corrected and projected
            flag("STH"),            // 0 measured position, 1 smoothed
        ],
        &[
            element("TOM", 2, RAW), // movement: 0 unknown, 1 taking off, 2 landing, 3 other
            element("DOU", 3, RAW), // doubt, 0 none
            element("MRS", 2, RAW), // 0 undetermined, 1 merged by and 2 not by association to plot, 3 split
        ],
        &[
            flag("GHO"), // ghost
            spare(6),
        ],
    ]),
);

const I200: Item = Item::new(
    "200",
    "Calculated Track Velocity in Polar Co-ordinates",
    Group(&[
        element("GSP", 16, unsigned(1.0 / pow2(14), "NM/s")),
        element("TRA", 16, unsigned(360.0 / pow2(16), "°")),
    ]),
);

const I202: Item = Item::new(
    "202",
    "Calculated Track Velocity in Cartesian Co-ordinates",
    Group(&[
        element("VX", 16, signed(1.0 / pow2(2), "m/s")), // not 2^-4, see above
        element("VY", 16, signed(1.0 / pow2(2), "m/s")),
    ]),
);

const I210: Item = Item::new(
    "210",
    "Calculated Acceleration",
    Group(&[
        element("AX", 8, signed(1.0 / pow2(2), "m/s²")), // not 2^-4, see above
        element("AY", 8, signed(1.0 / pow2(2), "m/s²")),
    ]),
);

const I220: Item = Item::new("220", "Target Address", Element(24, RAW));

const I245: Item = Item::new(
    "245",
    "Target Identification",
    Group(&[
        // 0 call sign or registration downlinked, 1 call sign not downlinked, 2 registration not downlinked.
        // Beware: CAT020 numbers them otherwise, and systems that send both categories may use one numbering.
        element("STI", 2, RAW),
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

const I270: Item = Item::new(
    "270",
    "Target Size and Orientation",
    Extended(&[
        &[element("LENGTH", 7, unsigned(1.0, "m"))],
        &[element("ORIENTATION", 7, unsigned(360.0 / pow2(7), "°"))], // of the nose, from geographical north
        &[element("WIDTH", 7, unsigned(1.0, "m"))],
    ]),
);

const I280: Item = Item::new(
    "280",
    "Presence",
    Repetitive(&Group(&[
        element("DRHO", 8, signed(1.0, "m")), // from the centre of the plot
        element("DTHETA", 8, signed(0.15, "°")),
    ])),
);

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

const I500: Item = Item::new(
    "500",
    "Standard Deviation of Position",
    Group(&[
        element("DEVX", 8, unsigned(1.0 / pow2(2), "m")),
        element("DEVY", 8, unsigned(1.0 / pow2(2), "m")),
        element("COVXY", 16, signed(1.0 / pow2(2), "m²")),
    ]),
);

const I550: Item = Item::new(
    "550",
    "System Status",
    Group(&[
        element("NOGO", 2, RAW), // 0 operational, 1 degraded, 2 do not use
        flag("OVL"),             // overload
        flag("TSV"),             // time source invalid
        flag("DIV"),             // diversity degraded
        flag("TTF"),             // test target failure
        spare(2),
    ]),
);

/// In the document's order.
#[rustfmt::skip]
const ITEMS: &[Item] = &[
    I000, I010, I020, I040, I041, I042, I060, I090,
    I091, I131, I140, I161, I170, I200, I202, I210,
    I220, I245, I250, I270, I280, I300, I310, I500,
    I550, RE, SP,
];

#[rustfmt::skip]
const ORDER: &[&str] = &[
    "010", "000", "020", "140", "041", "040", "042", // FRN  1 to  7
    "200", "202", "161", "170", "060", "220", "245", //      8 to 14
    "250", "300", "090", "091", "270", "550", "310", //     15 to 21
    "500", "280", "131", "210", SPARE, "SP", "RE",   //     22 to 28
];

/// Surface movement data, ed 1.1.
pub static CAT010_V1_1: Category = Category {
    number: 10,
    edition: Edition::new(1, 1),
    title: "Transmission of Monosensor Surface Movement Data",
    document: "EUROCONTROL-SPEC-0149-7",
    items: ITEMS,
    profile: Profile::Single(Uap::new(ITEMS, ORDER)),
};

/// Every edition of the category.
pub static CAT010: &[&Category] = &[&CAT010_V1_1];
