//! Editions 0.23 to 0.26.

use super::{AIR_SPEED, I110};
use crate::categories::{RE, SP};
use crate::table::Layout::{Compound, Element, Extended, Group};
use crate::table::*;

const I010: Item = Item::new(
    "010",
    "Data Source Identification",
    Group(&[
        element("SAC", 8, RAW), // system area code
        element("SIC", 8, RAW), // system identification code
    ]),
);

// 1 light … 5 heavy, 10 rotorcraft, 20 and 21 vehicles
const I020: Item = Item::new("020", "Emitter Category", Element(8, RAW));

// of applicability of the position
const I030: Item = Item::new("030", "Time of Day", Element(24, unsigned(1.0 / pow2(7), "s")));

// largest error of I021/030
const I032: Item = Item::new("032", "Time of Day Accuracy", Element(8, unsigned(1.0 / pow2(8), "s")));

const I040: Item = Item::new(
    "040",
    "Target Report Descriptor",
    Group(&[
        flag("DCR"), // differential correction
        flag("GBS"), // ground bit set
        flag("SIM"), // simulated
        flag("TST"), // test target
        flag("RAB"), // from a field monitor, a fixed transponder
        flag("SAA"), // 1 not able to provide selected altitude
        flag("SPI"), // special position identification
        spare(1),
        element("ATP", 3, RAW), // address: 0 not unique, 1 ICAO, 2 surface vehicle, 3 anonymous
        element("ARC", 2, RAW), // altitude in steps of: 0 unknown, 1 25 ft, 2 100 ft
        spare(3),
    ]),
);

const I070_V0_26: Item = Item::new(
    "070",
    "Mode 3/A Code in Octal Representation",
    Group(&[
        flag("V"), // 1 not validated
        flag("G"), // 1 garbled
        flag("L"), // 1 not extracted during the last update
        spare(1),
        element("MODE3A", 12, OCTAL),
    ]),
);

const I080: Item = Item::new("080", "Target Address", Element(24, RAW));

const I090: Item = Item::new(
    "090",
    "Figure of Merit",
    Group(&[
        element("AC", 2, RAW), // ACAS: 0 unknown, 1 not operational, 2 operational
        element("MN", 2, RAW), // multiple navigation aids: 0 unknown, 1 not operational, 2 operational
        element("DC", 2, RAW), // differential correction: 0 unknown, 1 yes, 2 no
        spare(6),
        // Navigational uncertainty category for position, 0 to 9. The machine-readable definition in wide use has it
        // signed, which would make 8 and 9 negative.
        element("PA", 4, RAW),
    ]),
);

// navigational uncertainty category for velocity
const I095: Item = Item::new("095", "Velocity Accuracy", Element(8, RAW));

const I130: Item = Item::new(
    "130",
    "Position in WGS-84 Co-ordinates",
    Group(&[
        element("LAT", 24, signed(180.0 / pow2(23), "°")),
        element("LON", 24, signed(180.0 / pow2(23), "°")),
    ]),
);

const I130_V0_24: Item = Item::new(
    "130",
    "Position in WGS-84 Co-ordinates",
    Group(&[
        element("LAT", 32, signed(180.0 / pow2(25), "°")),
        element("LON", 32, signed(180.0 / pow2(25), "°")),
    ]),
);

const I131_V0_26: Item = Item::new("131", "Signal Amplitude", Element(8, RAW));

const I140: Item = Item::new("140", "Geometric Altitude", Element(16, signed(6.25, "ft")));

const I145: Item = Item::new("145", "Flight Level", Element(16, signed(1.0 / pow2(2), "FL")));

const I146: Item = Item::new(
    "146",
    "Intermediate State Selected Altitude",
    Group(&[
        flag("SAS"),            // source given
        element("SRC", 2, RAW), // 0 unknown, 1 aircraft altitude, 2 MCP/FCU, 3 FMS
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

const I151: Item = Item::new("151", "True Airspeed", Element(16, unsigned(1.0, "kt")));

const I152: Item = Item::new("152", "Magnetic Heading", Element(16, unsigned(360.0 / pow2(16), "°")));

const I155: Item = Item::new("155", "Barometric Vertical Rate", Element(16, signed(6.25, "ft/min")));

const I157: Item = Item::new("157", "Geometric Vertical Rate", Element(16, signed(6.25, "ft/min")));

const I160: Item = Item::new(
    "160",
    "Ground Vector",
    Group(&[
        element("GS", 16, signed(1.0 / pow2(14), "NM/s")),
        element("TA", 16, unsigned(360.0 / pow2(16), "°")),
    ]),
);

const I165: Item = Item::new(
    "165",
    "Rate Of Turn",
    Extended(&[
        &[
            element("TI", 2, RAW), // 0 not available, 1 left, 2 right, 3 straight
            spare(5),
        ],
        &[element("ROT", 7, signed(1.0 / pow2(2), "°/s"))], // positive to the right
    ]),
);

const I170: Item = Item::new("170", "Target Identification", Element(48, ICAO));

const I200: Item = Item::new("200", "Target Status", Element(8, RAW)); // 0 no emergency, 5 unlawful interference

const I210: Item = Item::new(
    "210",
    "Link Technology Indicator",
    Group(&[
        spare(3),
        flag("DTI"), // cockpit display of traffic information
        flag("MDS"), // Mode S extended squitter
        flag("UAT"),
        flag("VDL"), // VDL Mode 4
        flag("OTR"), // other
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

/// The items of editions 0.23 to 0.25, of which the position became finer.
#[rustfmt::skip]
const fn items(i130: Item) -> [Item; 28] {
    [
        I010, I020, I030, I032, I040, I080, I090, I095,
        I110, i130, I140, I145, I146, I148, I150, I151,
        I152, I155, I157, I160, I165, I170, I200, I210,
        I220, I230, RE, SP,
    ]
}

#[rustfmt::skip]
const ORDER: &[&str] = &[
    "010", "040", "030", "130", "080", "140", "090", // FRN  1 to  7
    "210", "230", "145", "150", "151", "152", "155", //      8 to 14
    "157", "160", "165", "170", "095", "032", "200", //     15 to 21
    "020", "220", "146", "148", "110", SPARE, SPARE, //     22 to 28
    SPARE, SPARE, SPARE, SPARE, SPARE, "RE", "SP",   //     29 to 35
];

#[rustfmt::skip]
const ITEMS_V0_26: &[Item] = &[
    I010, I020, I030, I032, I040, I070_V0_26, I080, I090, I095,
    I110, I130_V0_24, I131_V0_26, I140, I145, I146, I148, I150, I151,
    I152, I155, I157, I160, I165, I170, I200, I210,
    I220, I230, RE, SP,
];

#[rustfmt::skip]
const ORDER_V0_26: &[&str] = &[
    "010", "040", "030", "130", "080", "140", "090", // FRN  1 to  7
    "210", "230", "145", "150", "151", "152", "155", //      8 to 14
    "157", "160", "165", "170", "095", "032", "200", //     15 to 21
    "020", "220", "146", "148", "110", "070", "131", //     22 to 28
    SPARE, SPARE, SPARE, SPARE, SPARE, "RE", "SP",   //     29 to 35
];

const fn edition(minor: u8, items: &'static [Item], order: &'static [&'static str]) -> Category {
    Category {
        number: 21,
        edition: Edition::new(0, minor),
        title: "ADS-B Target Reports",
        document: "EUROCONTROL SUR.ET1.ST05.2000-STD-12-01",
        items,
        profile: Profile::Single(Uap::new(items, order)),
    }
}

/// ADS-B target reports, ed 0.23.
pub static CAT021_V0_23: Category = edition(23, &items(I130), ORDER);

/// ADS-B target reports, ed 0.24.
pub static CAT021_V0_24: Category = edition(24, &items(I130_V0_24), ORDER);

/// ADS-B target reports, ed 0.25. Its layout is that of ed 0.24.
pub static CAT021_V0_25: Category = edition(25, &items(I130_V0_24), ORDER);

/// ADS-B target reports, ed 0.26.
pub static CAT021_V0_26: Category = edition(26, ITEMS_V0_26, ORDER_V0_26);

/// Every edition before the first.
pub static CAT021_V0: &[&Category] = &[&CAT021_V0_23, &CAT021_V0_24, &CAT021_V0_25, &CAT021_V0_26];
