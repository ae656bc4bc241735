//! CAT001: target reports of a radar, the format before CAT048: plots and tracks.
//!
//! EUROCONTROL-SPEC-0149-2a, once SUR.ET1.ST05.2000-STD-02a-01, ed 1.2 to 1.4 (August 2022), of one layout.
//!
//! Plots and tracks have profiles of their own, which agree up to I001/020, whose first bit says which it is. A station
//! may send I001/010 with the first record of a block only: it then holds for all of them. The time is cut off at 512 s
//! and has to be completed by the receiver.

use super::{MODE_C, PULSE_QUALITY, RFS, SP};
use crate::table::Layout::{Element, Extended, Group, RepetitiveFx};
use crate::table::*;

const I010: Item = Item::new(
    "010",
    "Data Source Identifier",
    Group(&[
        element("SAC", 8, RAW), // system area code
        element("SIC", 8, RAW), // system identification code
    ]),
);

const I020: Item = Item::new(
    "020",
    "Target Report Descriptor",
    Extended(&[
        &[
            flag("TYP"),               // 0 plot, 1 track: decides between the two profiles
            flag("SIM"),               // simulated
            element("SSRPSR", 2, RAW), // 0 no detection, 1 PSR, 2 SSR, 3 both
            flag("ANT"),               // 0 antenna 1, 1 antenna 2
            flag("SPI"),               // special position identification
            flag("RAB"),               // from a field monitor, a fixed transponder
        ],
        &[
            flag("TST"),               // test target
            element("DS1DS2", 2, RAW), // 0 none, 1 code 7500, 2 code 7600, 3 code 7700
            flag("ME"),                // military emergency
            flag("MI"),                // military identification
            spare(2),
        ],
    ]),
);

// 1 garbled, 2 reflection, 3 side lobe, 4 split plot, 5 second time around, 6 angels, 7 vehicles, …
const I030: Item = Item::new("030", "Warning/Error Conditions", RepetitiveFx(&Element(7, RAW)));

const I040: Item = Item::new(
    "040",
    "Measured Position in Polar Co-ordinates",
    Group(&[
        element("RHO", 16, unsigned(1.0 / pow2(7), "NM")),
        element("THETA", 16, unsigned(360.0 / pow2(16), "°")),
    ]),
);

const I042: Item = Item::new(
    "042",
    "Calculated Position in Cartesian Co-ordinates",
    Group(&[
        element("X", 16, signed(1.0 / pow2(6), "NM")),
        element("Y", 16, signed(1.0 / pow2(6), "NM")),
    ]),
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

const I060: Item = Item::new("060", "Mode-2 Code Confidence Indicator", Group(PULSE_QUALITY));

const I070: Item = Item::new(
    "070",
    "Mode-3/A Code in Octal Representation",
    Group(&[
        flag("V"), // 1 not validated
        flag("G"), // 1 garbled
        flag("L"), // 1 smoothed by a local tracker
        spare(1),
        element("MODE3A", 12, OCTAL),
    ]),
);

const I080: Item = Item::new("080", "Mode-3/A Code Confidence Indicator", Group(PULSE_QUALITY));

const I090: Item = Item::new(
    "090",
    "Mode-C Code in Binary Representation",
    Group(&[
        flag("V"), // 1 not validated
        flag("G"), // 1 garbled
        element("HGT", 14, signed(1.0 / pow2(2), "FL")),
    ]),
);

const I100: Item = Item::new("100", "Mode-C Code and Code Confidence Indicator", Group(MODE_C));

const I120: Item = Item::new(
    "120",
    "Measured Radial Doppler Speed",
    Element(8, signed(1.0 / pow2(8), "NM/s")),
);

// plot's run length, power, …: as the station defines
const I130: Item = Item::new("130", "Radar Plot Characteristics", RepetitiveFx(&Element(7, RAW)));

const I131: Item = Item::new("131", "Received Power", Element(8, signed(1.0, "dBm")));

// within the current 512 s
const I141: Item = Item::new(
    "141",
    "Truncated Time of Day",
    Element(16, unsigned(1.0 / pow2(7), "s")),
);

const I150: Item = Item::new(
    "150",
    "Presence of X-Pulse",
    Group(&[
        flag("XA"), // in the Mode 3/A reply
        spare(1),
        flag("XC"), // in the Mode C reply
        spare(2),
        flag("X2"), // in the Mode 2 reply
        spare(2),
    ]),
);

const I161: Item = Item::new("161", "Track Plot Number", Element(16, RAW)); // of the plot or track

const I170: Item = Item::new(
    "170",
    "Track Status",
    Extended(&[
        &[
            flag("CON"),  // 0 confirmed, 1 being initialised
            flag("RAD"),  // 0 PSR, 1 SSR or combined
            flag("MAN"),  // manoeuvring
            flag("DOU"),  // doubtful association of plot to track
            flag("RDPC"), // radar data processing: 0 chain 1, 1 chain 2
            spare(1),
            flag("GHO"), // ghost
        ],
        &[
            flag("TRE"), // last report of the track
            spare(6),
        ],
    ]),
);

const I200: Item = Item::new(
    "200",
    "Calculated Track Velocity in Polar Co-ordinates",
    Group(&[
        element("GSP", 16, unsigned(1.0 / pow2(14), "NM/s")),
        element("HDG", 16, unsigned(360.0 / pow2(16), "°")),
    ]),
);

const I210: Item = Item::new("210", "Track Quality", RepetitiveFx(&Element(7, RAW))); // as the station defines

/// In the document's order.
#[rustfmt::skip]
const ITEMS: &[Item] = &[
    I010, I020, I030, I040, I042, I050, I060, I070,
    I080, I090, I100, I120, I130, I131, I141, I150,
    I161, I170, I200, I210, SP, RFS,
];

#[rustfmt::skip]
const PLOT_ORDER: &[&str] = &[
    "010", "020", "040", "070", "090", "130", "141", // FRN  1 to  7
    "050", "120", "131", "080", "100", "060", "030", //      8 to 14
    "150", SPARE, SPARE, SPARE, SPARE, "SP",  "RFS", //     15 to 21
];

#[rustfmt::skip]
const TRACK_ORDER: &[&str] = &[
    "010", "020", "161", "040", "042", "200", "070", // FRN  1 to  7
    "090", "141", "130", "131", "120", "170", "210", //      8 to 14
    "050", "080", "100", "060", "030", "SP",  "RFS", //     15 to 21
    "150",                                           //     22
];

/// For each value of TYP.
const PROFILES: &[(u64, Uap)] = &[(0, Uap::new(ITEMS, PLOT_ORDER)), (1, Uap::new(ITEMS, TRACK_ORDER))];

const fn edition(minor: u8) -> Category {
    Category {
        number: 1,
        edition: Edition::new(1, minor),
        title: "Transmission of Monoradar Data Target Reports",
        document: "EUROCONTROL-SPEC-0149-2a",
        items: ITEMS,
        profile: Profile::Depends {
            item: "020",
            element: "TYP",
            cases: PROFILES,
        },
    }
}

/// Radar plots and tracks, ed 1.2.
pub static CAT001_V1_2: Category = edition(2);

/// Radar plots and tracks, ed 1.3.
pub static CAT001_V1_3: Category = edition(3);

/// Radar plots and tracks, ed 1.4.
pub static CAT001_V1_4: Category = edition(4);

/// Every edition of the category.
pub static CAT001: &[&Category] = &[&CAT001_V1_2, &CAT001_V1_3, &CAT001_V1_4];
