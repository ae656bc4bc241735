//! CAT048: target reports of a radar.
//!
//! EUROCONTROL-SPEC-0149-4, ed 1.27 (June 2020) to 1.32 (July 2024), with one order of items. What later editions added
//! are further parts of I048/020, and codes of I048/030. Ed 1.32 says that the flight level in I048/090 is in two's
//! complement; before, the document said nothing of a sign, and these tables have none.

mod re;

pub use re::{CAT048_RE_V1_11, CAT048_RE_V1_12, CAT048_RE_V1_13};

use crate::categories::{MODE_C, PULSE_QUALITY, RE, SP};
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
    element("TYP", 3, RAW), // 0 none, 1 PSR, 2 SSR, 3 both; Mode S: 4 all-call, 5 roll-call, 6 and 7 the same + PSR
    flag("SIM"),            // simulated
    flag("RDP"),            // radar data processing: 0 chain 1, 1 chain 2
    flag("SPI"),            // special position identification
    flag("RAB"),            // from a field monitor, a fixed transponder
];

const I020_PART_2: &[Part] = &[
    flag("TST"),               // test target
    flag("ERR"),               // extended range: I048/040 does not hold it, the reserved expansion field does
    flag("XPP"),               // X-pulse present
    flag("ME"),                // military emergency
    flag("MI"),                // military identification
    element("FOEFRI", 2, RAW), // Mode 4: 0 not interrogated, 1 friend, 2 unknown, 3 no reply
];

const I020_PART_3: &[Part] = &[
    // In these and the next: EP says whether VAL has a meaning.
    group("ADSB", &[flag("EP"), flag("VAL")]), // ADS-B information available on site
    group("SCN", &[flag("EP"), flag("VAL")]),  // surveillance cluster network information available
    group("PAI", &[flag("EP"), flag("VAL")]),  // passive acquisition interface information available
    spare(1),
];

const I020: Item = Item::new("020", "Target Report Descriptor", Extended(&[I020_PART_1, I020_PART_2]));

const I020_V1_31: Item = Item::new(
    "020",
    "Target Report Descriptor",
    Extended(&[I020_PART_1, I020_PART_2, I020_PART_3]),
);

const I020_V1_32: Item = Item::new(
    "020",
    "Target Report Descriptor",
    Extended(&[
        I020_PART_1,
        I020_PART_2,
        I020_PART_3,
        &[
            group("ACASXV", &[flag("EP"), element("VAL", 4, RAW)]), // extended version of ACAS: 0 none, 1 Xa, 2 Xu
            group("POXPR", &[flag("EP"), flag("VAL")]),             // transponder capable of phase overlay
        ],
        &[
            group("POACT", &[flag("EP"), flag("VAL")]), // phase overlay active for this plot
            group("DTFXPR", &[flag("EP"), flag("VAL")]), // transponder capable of basic dataflash
            group("DTFACT", &[flag("EP"), flag("VAL")]), // dataflash active for this plot
            spare(1),
        ],
        &[
            group("IRMXPR", &[flag("EP"), flag("VAL")]), // transponder capable of IRM
            group("IRMACT", &[flag("EP"), flag("VAL")]), // IRM active for this plot
            spare(3),
        ],
    ]),
);

// 1 reflection, 2 side lobe, 3 split plot, 4 second time around, 5 angel, … 16 duplicate or illegal address, …
const I030: Item = Item::new(
    "030",
    "Warning/Error Conditions and Target Classification",
    RepetitiveFx(&Element(7, RAW)),
);

const I040: Item = Item::new(
    "040",
    "Measured Position in Polar Co-ordinates",
    Group(&[
        element("RHO", 16, unsigned(1.0 / pow2(8), "NM")),
        element("THETA", 16, unsigned(360.0 / pow2(16), "°")),
    ]),
);

const I042: Item = Item::new(
    "042",
    "Calculated Position in Cartesian Co-ordinates",
    Group(&[
        element("X", 16, signed(1.0 / pow2(7), "NM")),
        element("Y", 16, signed(1.0 / pow2(7), "NM")),
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

const I060: Item = Item::new("060", "Mode-2 Code Confidence Indicator", Group(PULSE_QUALITY));

const I065: Item = Item::new(
    "065",
    "Mode-1 Code Confidence Indicator",
    Group(&[
        spare(3),
        flag("QA4"),
        flag("QA2"),
        flag("QA1"),
        flag("QB2"),
        flag("QB1"),
    ]),
);

const I070: Item = Item::new(
    "070",
    "Mode-3/A Code in Octal Representation",
    Group(&[
        flag("V"), // 1 not validated
        flag("G"), // 1 garbled
        flag("L"), // 1 not extracted during the last scan
        spare(1),
        element("MODE3A", 12, OCTAL),
    ]),
);

const I080: Item = Item::new("080", "Mode-3/A Code Confidence Indicator", Group(PULSE_QUALITY));

const I090: Item = Item::new(
    "090",
    "Flight Level in Binary Representation",
    Group(&[
        flag("V"), // 1 not validated
        flag("G"), // 1 garbled
        element("FL", 14, unsigned(1.0 / pow2(2), "FL")),
    ]),
);

const I090_V1_32: Item = Item::new(
    "090",
    "Flight Level in Binary Representation",
    Group(&[
        flag("V"), // 1 not validated
        flag("G"), // 1 garbled
        element("FL", 14, signed(1.0 / pow2(2), "FL")),
    ]),
);

const I100: Item = Item::new("100", "Mode-C Code and Code Confidence Indicator", Group(MODE_C));

const I110: Item = Item::new(
    "110",
    "Height Measured by a 3D Radar",
    Group(&[spare(2), element("3DH", 14, signed(25.0, "ft"))]),
);

const I120: Item = Item::new(
    "120",
    "Radial Doppler Speed",
    Compound(&[
        subitem(
            "CAL",
            "Calculated Doppler Speed",
            Group(&[
                flag("D"), // 1 doubtful
                spare(5),
                element("CAL", 10, signed(1.0, "m/s")),
            ]),
        ),
        subitem(
            "RDS",
            "Raw Doppler Speed",
            Repetitive(&Group(&[
                element("DOP", 16, unsigned(1.0, "m/s")),
                element("AMB", 16, unsigned(1.0, "m/s")), // range of the ambiguity
                element("FRQ", 16, unsigned(1.0, "MHz")), // transmitter frequency
            ])),
        ),
    ]),
);

const I130: Item = Item::new(
    "130",
    "Radar Plot Characteristics",
    Compound(&[
        subitem("SRL", "SSR Plot Runlength", Element(8, unsigned(360.0 / pow2(13), "°"))),
        subitem("SRR", "Number of Received Replies for (M)SSR", Element(8, NUMBER)),
        subitem("SAM", "Amplitude of (M)SSR Reply", Element(8, signed(1.0, "dBm"))),
        subitem(
            "PRL",
            "Primary Plot Runlength",
            Element(8, unsigned(360.0 / pow2(13), "°")),
        ),
        subitem("PAM", "Amplitude of Primary Plot", Element(8, signed(1.0, "dBm"))),
        subitem(
            "RPD",
            "Difference in Range Between PSR and SSR Plot",
            Element(8, signed(1.0 / pow2(8), "NM")),
        ),
        subitem(
            "APD",
            "Difference in Azimuth Between PSR and SSR Plot",
            Element(8, signed(360.0 / pow2(14), "°")),
        ),
    ]),
);

const I140: Item = Item::new("140", "Time of Day", Element(24, unsigned(1.0 / pow2(7), "s")));

const I161: Item = Item::new("161", "Track Number", Group(&[spare(4), element("TRN", 12, RAW)]));

const I170: Item = Item::new(
    "170",
    "Track Status",
    Extended(&[
        &[
            flag("CNF"),            // 0 confirmed, 1 tentative
            element("RAD", 2, RAW), // maintained by: 0 both, 1 PSR, 2 SSR or Mode S, 3 invalid
            flag("DOU"),            // low confidence in the association of plot to track
            flag("MAH"),            // horizontal manoeuvre
            element("CDM", 2, RAW), // 0 maintaining, 1 climbing, 2 descending, 3 unknown
        ],
        &[
            flag("TRE"), // last report of the track
            flag("GHO"), // ghost
            flag("SUP"), // maintained with track information from a neighbouring node
            flag("TCC"), // 0 radar plane, 1 slant range corrected and projected
            spare(3),
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

const I210: Item = Item::new(
    "210",
    "Track Quality",
    Group(&[
        element("SIGX", 8, unsigned(1.0 / pow2(7), "NM")), // standard deviations
        element("SIGY", 8, unsigned(1.0 / pow2(7), "NM")),
        element("SIGV", 8, unsigned(1.0 / pow2(14), "NM/s")), // of ground speed
        element("SIGH", 8, unsigned(360.0 / pow2(12), "°")),  // of heading
    ]),
);

const I220: Item = Item::new("220", "Aircraft Address", Element(24, RAW));

const I230: Item = Item::new(
    "230",
    "Communications/ACAS Capability and Flight Status",
    Group(&[
        element("COM", 3, RAW),  // communications capability
        element("STAT", 3, RAW), // alert, special position identification, airborne or on ground
        flag("SI"),              // 1 has II codes only, 0 SI codes
        spare(1),
        flag("MSSC"),           // Mode S specific services
        flag("ARC"),            // altitude reported in steps of: 0 100 ft, 1 25 ft
        flag("AIC"),            // aircraft identification
        flag("B1A"),            // BDS 1,0 bit 16
        element("B1B", 4, RAW), // BDS 1,0 bits 37 to 40
    ]),
);

const I240: Item = Item::new("240", "Aircraft Identification", Element(48, ICAO));

const I250: Item = Item::new(
    "250",
    "Mode S MB Data",
    Repetitive(&Group(&[
        element("MBDATA", 56, RAW), // Comm-B message
        element("BDS1", 4, RAW),    // register number, first digit
        element("BDS2", 4, RAW),    // second digit
    ])),
);

const I260: Item = Item::new("260", "ACAS Resolution Advisory Report", Element(56, RAW));

/// The items of an edition, in the document's order; those passed are not the same in all.
#[rustfmt::skip]
const fn items(i020: Item, i090: Item) -> [Item; 28] {
    [
        I010, i020, I030, I040, I042, I050, I055, I060,
        I065, I070, I080, i090, I100, I110, I120, I130,
        I140, I161, I170, I200, I210, I220, I230, I240,
        I250, I260, RE, SP,
    ]
}

#[rustfmt::skip]
const ORDER: &[&str] = &[
    "010", "140", "020", "040", "070", "090", "130", // FRN  1 to  7
    "220", "240", "250", "161", "042", "200", "170", //      8 to 14
    "210", "030", "080", "100", "110", "120", "230", //     15 to 21
    "260", "055", "050", "065", "060", "SP",  "RE",  //     22 to 28
];

const fn edition(minor: u8, items: &'static [Item]) -> Category {
    Category {
        number: 48,
        edition: Edition::new(1, minor),
        title: "Monoradar Target Reports",
        document: "EUROCONTROL-SPEC-0149-4",
        items,
        profile: Profile::Single(Uap::new(items, ORDER)),
    }
}

/// Monoradar target reports, ed 1.27.
pub static CAT048_V1_27: Category = edition(27, &items(I020, I090));

/// Monoradar target reports, ed 1.28.
pub static CAT048_V1_28: Category = edition(28, &items(I020, I090));

/// Monoradar target reports, ed 1.29.
pub static CAT048_V1_29: Category = edition(29, &items(I020, I090));

/// Monoradar target reports, ed 1.30.
pub static CAT048_V1_30: Category = edition(30, &items(I020, I090));

/// Monoradar target reports, ed 1.31.
pub static CAT048_V1_31: Category = edition(31, &items(I020_V1_31, I090));

/// Monoradar target reports, ed 1.32.
pub static CAT048_V1_32: Category = edition(32, &items(I020_V1_32, I090_V1_32));

/// Every edition of the category.
pub static CAT048: &[&Category] = &[
    &CAT048_V1_27,
    &CAT048_V1_28,
    &CAT048_V1_29,
    &CAT048_V1_30,
    &CAT048_V1_31,
    &CAT048_V1_32,
];
