//! What the reserved expansion field I021/RE holds in editions 1.4 and 1.5 of its coding rules.
//!
//! EUROCONTROL-SPEC-0149-12A. Ed 1.5 is for ADS-B version 3.

use crate::expansion::Expansion;
use crate::table::Layout::{Compound, Element, Extended, Group};
use crate::table::*;

const BPS: Option<Item> = subitem(
    "BPS",
    "Barometric Pressure Setting",
    Group(&[
        spare(4),
        element("BPS", 12, unsigned(0.1, "hPa")), // above 800 hPa
    ]),
);

const SH: Option<Item> = subitem(
    "SH",
    "Selected Heading",
    Group(&[
        spare(4),
        flag("HDR"),  // 0 true, 1 magnetic north
        flag("STAT"), // 1 available and valid
        element("SH", 10, unsigned(360.0 / pow2(9), "°")),
    ]),
);

const NAV: Option<Item> = subitem(
    "NAV",
    "Navigation Mode",
    Group(&[
        flag("AP"), // autopilot engaged
        flag("VN"), // vertical navigation active
        flag("AH"), // altitude hold engaged
        flag("AM"), // approach mode active
        spare(4),
    ]),
);

const NAV_V1_5: Option<Item> = subitem(
    "NAV",
    "Navigation Mode",
    Group(&[
        flag("AP"),                               // autopilot engaged
        flag("VN"),                               // vertical navigation active
        flag("AH"),                               // altitude hold engaged
        flag("AM"),                               // approach mode active
        group("MFM", &[flag("EP"), flag("VAL")]), // 1 the mode bits above were filled in on board
        spare(2),
    ]),
);

// of the antenna from the longitudinal axis and the nose, as a code
const GAO: Option<Item> = subitem("GAO", "GPS Antenna Offset", Element(8, RAW));

const SGV: Option<Item> = subitem(
    "SGV",
    "Surface Ground Vector",
    Extended(&[
        &[
            flag("STP"), // stopped
            flag("HTS"), // 1 HGT is valid
            flag("HTT"), // HGT is: 0 the heading, 1 the ground track
            flag("HRD"), // 0 true, 1 magnetic north
            element("GSS", 11, unsigned(1.0 / pow2(3), "kt")),
        ],
        &[element("HGT", 7, unsigned(360.0 / pow2(7), "°"))],
    ]),
);

const STA: Option<Item> = subitem(
    "STA",
    "Aircraft Status",
    Extended(&[&[
        flag("ES"),  // receives 1090 MHz extended squitter
        flag("UAT"), // receives UAT
        spare(5),
    ]]),
);

const STA_V1_5: Option<Item> = subitem(
    "STA",
    "Aircraft Status",
    Extended(&[
        // In these and the next groups: EP says whether VAL has a meaning.
        &[
            flag("ES"),                                          // receives 1090 MHz extended squitter
            flag("UAT"),                                         // receives UAT
            group("RCE", &[flag("EP"), element("VAL", 2, RAW)]), // reduced capability equipment: 1 TABS, 3 other
            group("RRL", &[flag("EP"), flag("VAL")]),            // reply rate limiting active
        ],
        &[
            group("PS3", &[flag("EP"), element("VAL", 3, RAW)]), // emergency: 0 none, 2 lost link, 3 fuel, 4 radio, …
            group("TPW", &[flag("EP"), element("VAL", 2, RAW)]), // transmit power in W: 1 70, 2 125, 3 200
        ],
        &[
            group("TSI", &[flag("EP"), element("VAL", 2, RAW)]), // transponder: 0 unknown, 1 left, 2 right, 3 backup
            group("MUO", &[flag("EP"), flag("VAL")]),            // unmanned
            group("RWC", &[flag("EP"), flag("VAL")]),            // remain well clear alert active
        ],
        &[
            group("DAA", &[flag("EP"), element("VAL", 2, RAW)]), // detect and avoid: 1 RWC, RA, OCM, 2 RWC, OCM
            group("DF17CA", &[flag("EP"), element("VAL", 3, RAW)]), // transponder capability
        ],
        &[
            group("SVH", &[flag("EP"), element("VAL", 2, RAW)]), // avoids: 0 vertically, 1 horizontally, 2 both
            group("CATC", &[flag("EP"), element("VAL", 3, RAW)]), // kind of collision avoidance
        ],
        &[
            group("TAO", &[flag("EP"), element("VAL", 5, RAW)]), // offset of the antenna, as a code
            spare(1),
        ],
    ]),
);

const TNH: Option<Item> = subitem(
    "TNH",
    "True North Heading",
    Element(16, unsigned(360.0 / pow2(16), "°")),
);

const MES: Option<Item> = subitem(
    "MES",
    "Military Extended Squitter",
    Compound(&[
        subitem(
            "SUM",
            "Mode 5 Summary",
            Group(&[
                flag("M5"), // Mode 5 interrogated
                flag("ID"), // authenticated identification reply
                flag("DA"), // authenticated data reply or report
                flag("M1"), // this and the next four: it came in a Mode 5 reply
                flag("M2"),
                flag("M3"),
                flag("MC"),
                flag("PO"),
            ]),
        ),
        subitem(
            "PNO",
            "Mode 5 PIN / National Origin",
            Group(&[
                spare(2),
                element("PIN", 14, RAW),
                spare(5),
                element("NO", 11, RAW), // national origin
            ]),
        ),
        subitem(
            "EM1",
            "Extended Mode 1 Code in Octal Representation",
            Group(&[
                flag("V"), // 1 not validated
                spare(1),
                flag("L"), // 1 smoothed by a local tracker
                spare(1),
                element("EM1", 12, OCTAL),
            ]),
        ),
        subitem(
            "XP",
            "X Pulse Presence",
            Group(&[
                spare(2),
                flag("XP"), // X-pulse in the Mode 5 PIN reply
                flag("X5"), // in the Mode 5 data reply
                flag("XC"), // in the Mode C reply
                flag("X3"), // in the Mode 3/A reply
                flag("X2"), // in the Mode 2 reply
                flag("X1"), // in the Mode 1 reply
            ]),
        ),
        subitem(
            "FOM",
            "Figure of Merit",
            Group(&[
                spare(3),
                element("FOM", 5, RAW), // a category
            ]),
        ),
        subitem(
            "M2",
            "Mode 2 Code in Octal Representation",
            Group(&[
                flag("V"), // 1 not validated
                spare(1),
                flag("L"), // 1 smoothed by a local tracker
                spare(1),
                element("MODE2", 12, OCTAL),
            ]),
        ),
    ]),
);

const fn edition(minor: u8, items: &'static [Option<Item>]) -> Expansion {
    Expansion::new(21, Edition::new(1, minor), "EUROCONTROL-SPEC-0149-12A", items)
}

/// I021/RE, ed 1.4.
pub static CAT021_RE_V1_4: Expansion = edition(4, &[BPS, SH, NAV, GAO, SGV, STA, TNH, MES]);

/// I021/RE, ed 1.5.
pub static CAT021_RE_V1_5: Expansion = edition(5, &[BPS, SH, NAV_V1_5, GAO, SGV, STA_V1_5, TNH, MES]);
