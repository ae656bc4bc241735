//! What the reserved expansion field I048/RE holds in editions 1.11 to 1.13 of its coding rules.
//!
//! EUROCONTROL-SPEC-0149-4A. Each edition is an addition to the one before.

use crate::expansion::Expansion;
use crate::table::Layout::{Compound, Element, Extended, Group, Repetitive};
use crate::table::*;

const MD5_SUM: Option<Item> = subitem(
    "SUM",
    "Mode 5 Summary",
    Group(&[
        flag("M5"), // Mode 5 interrogated
        flag("ID"), // authenticated identification reply
        flag("DA"), // authenticated data reply or report
        flag("M1"), // this and the next three: it came in a Mode 5 reply
        flag("M2"),
        flag("M3"),
        flag("MC"),
        spare(1),
    ]),
);

const MD5_PMN: Option<Item> = subitem(
    "PMN",
    "PIN/ National Origin/Mission Code",
    Group(&[
        spare(2),
        element("PIN", 14, RAW),
        spare(2),
        flag("NAV"),            // 1 NAT is invalid
        element("NAT", 5, RAW), // national origin
        spare(2),
        element("MIS", 6, RAW), // mission
    ]),
);

const MD5_POS: Option<Item> = subitem(
    "POS",
    "Mode 5 Reported Position",
    Group(&[
        element("LAT", 24, signed(180.0 / pow2(23), "°")),
        element("LON", 24, signed(180.0 / pow2(23), "°")),
    ]),
);

const MD5_GA: Option<Item> = subitem(
    "GA",
    "Mode 5 GNSS-derived Altitude",
    Group(&[
        spare(1),
        flag("RES"), // reported in steps of: 0 100 ft, 1 25 ft
        element("GA", 14, signed(25.0, "ft")),
    ]),
);

const MD5_EM1: Option<Item> = subitem(
    "EM1",
    "Extended Mode 1 Code in Octal Representation",
    Group(&[
        flag("V"), // 1 validated, other than elsewhere
        flag("G"), // 1 garbled
        flag("L"), // 1 not extracted during the last scan
        spare(1),
        element("EM1", 12, OCTAL),
    ]),
);

const MD5_TOS: Option<Item> = subitem(
    "TOS",
    "Time Offset for POS and GA",
    Element(8, unsigned(1.0 / pow2(7), "s")),
); // from I048/140

const MD5_XP: Option<Item> = subitem(
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
);

const M5N_PMN: Option<Item> = subitem(
    "PMN",
    "PIN/ National Origin/Mission Code",
    Group(&[
        spare(2),
        element("PIN", 14, RAW),
        spare(4),
        flag("NOV"),            // 1 NO is invalid
        element("NO", 11, RAW), // national origin
    ]),
);

const M5N_FOM: Option<Item> = subitem(
    "FOM",
    "Figure of Merit",
    Group(&[
        spare(3),
        element("FOM", 5, RAW), // a category
    ]),
);

const MD5: Option<Item> = subitem(
    "MD5",
    "Mode 5 Reports",
    Compound(&[MD5_SUM, MD5_PMN, MD5_POS, MD5_GA, MD5_EM1, MD5_TOS, MD5_XP]),
);

const M5N: Option<Item> = subitem(
    "M5N",
    "Mode 5 Reports, New Format",
    Compound(&[MD5_SUM, M5N_PMN, MD5_POS, MD5_GA, MD5_EM1, MD5_TOS, MD5_XP, M5N_FOM]),
);

const M4E: Option<Item> = subitem(
    "M4E",
    "Extended Mode 4 Report",
    Extended(&[&[
        spare(5),
        element("FOEFRI", 2, RAW), // Mode 4: 0 not interrogated, 1 possibly, 2 probably and 3 certainly friend
    ]]),
);

const RPC: Option<Item> = subitem(
    "RPC",
    "Radar Plot Characteristics",
    Compound(&[
        subitem("SCO", "Score", Element(8, NUMBER)),
        subitem("SRC", "Signal/Clutter Ratio", Element(16, unsigned(0.1, "dB"))),
        subitem("RW", "Range Width", Element(16, unsigned(1.0 / pow2(8), "NM"))),
        subitem("AR", "Ambiguous Range", Element(16, unsigned(1.0 / pow2(8), "NM"))),
    ]),
);

const ERR: Option<Item> = subitem(
    "ERR",
    "Extended Range Report",
    Element(24, unsigned(1.0 / pow2(8), "NM")),
);

const RTC: Option<Item> = subitem(
    "RTC",
    "Radar Track Characteristics",
    Compound(&[
        subitem(
            "PTL",
            "Plot/Track Link",
            Group(&[
                spare(3),
                flag("SCN"), // associated with a plot of the surveillance cluster network
                flag("RC"),  // this and the next three: the plot has such a component
                flag("AC"),
                flag("SSR"),
                flag("PSR"),
                element("PLOTNR", 16, RAW), // as CPC/PNB
            ]),
        ),
        subitem("ATL", "ADS-B/Track Link", Repetitive(&Element(16, RAW))),
        subitem("TRN", "Turn State", Element(8, unsigned(1.0, "%"))),
        subitem(
            "NPP",
            "Next Predicted Position",
            Group(&[
                element("PREDRHO", 16, unsigned(1.0 / pow2(7), "NM")),
                element("PREDTHETA", 16, unsigned(360.0 / pow2(16), "°")),
                element("EVOLRHOSTART", 16, unsigned(1.0 / pow2(7), "NM")),
                element("EVOLRHOEND", 16, unsigned(1.0 / pow2(7), "NM")),
                element("EVOLTHETASTART", 16, unsigned(360.0 / pow2(16), "°")),
                element("EVOLTHETAEND", 16, unsigned(360.0 / pow2(16), "°")),
                element("NOISERHOSTART", 16, unsigned(1.0 / pow2(7), "NM")),
                element("NOISERHOEND", 16, unsigned(1.0 / pow2(7), "NM")),
                element("NOISETHETASTART", 16, unsigned(360.0 / pow2(16), "°")),
                element("NOISETHETAEND", 16, unsigned(360.0 / pow2(16), "°")),
                element("PREDTIME", 16, unsigned(1.0 / pow2(7), "s")),
            ]),
        ),
        subitem(
            "DLK",
            "Data Link Characteristics",
            Repetitive(&Group(&[
                element("TYPE", 4, RAW),   // of the data link task
                element("ORIGIN", 2, RAW), // 0 previous scan, 1 this scan, 2 requested by the transponder
                element("STATE", 2, RAW),  // 0 in progress, 1 completed, 2 cancelled
            ])),
        ),
        subitem(
            "LCK",
            "Lockout Characteristics",
            Group(&[
                flag("LS"),                                 // locked out by this radar
                element("LOCTIM", 15, unsigned(1.0, "ms")), // since when
            ]),
        ),
        subitem(
            "TC",
            "Transition Code",
            Group(&[
                spare(7),
                element("TCOUNT1", 4, NUMBER),
                element("TCODE1", 5, RAW), // Mode 1
                element("TCOUNT2", 4, NUMBER),
                element("TCODE2", 12, OCTAL), // Mode 2
                element("TCOUNT3", 4, NUMBER),
                element("TCODE3", 12, OCTAL), // Mode 3/A
            ]),
        ),
        subitem(
            "TLC",
            "Track Life Cycle",
            Group(&[
                element("ACQI", 2, RAW), // 0 tentative of one plot, 1 of more, 2 pre-confirmed, 3 confirmed
                element("TRKUPDCTR", 14, NUMBER), // updates
                element("LASTTRKUPD", 16, unsigned(1.0, "ms")), // since the last update
            ]),
        ),
        subitem(
            "ASI",
            "Adjacent Sensor Information",
            Repetitive(&Group(&[
                element("SACADJS", 8, RAW),
                element("SICADJS", 8, RAW),
                element("TIMEOFDAYSCN", 16, unsigned(1.0 / pow2(7), "s")), // within the current 512 s
                element("DATAUSE", 7, RAW),                                // by the tracker: 0 used, 1 not used
                flag("DRNA"),                                              // 1 DRN is valid
                element("DRN", 16, RAW),
            ])),
        ),
        // 0 radar tracker, 1 ADS-B on site, 2 ADS-B from elsewhere, 3 cluster network
        subitem("TES", "Track Extrapolation Source", Element(8, RAW)),
        subitem(
            "IR",
            "Identity Requested",
            Group(&[
                flag("IR"),                            // identity requested
                element("M3A", 7, unsigned(1.0, "s")), // age of I048/070
            ]),
        ),
    ]),
);

const CPC: Option<Item> = subitem(
    "CPC",
    "Common and Plot Characteristics",
    Compound(&[
        subitem("PNB", "Plot Number", Element(16, RAW)),
        subitem(
            "RPL",
            "Replies/Plot Link",
            Repetitive(&Group(&[
                element("TYPE", 8, RAW), // 0 PSR, 1 SSR, 2 all-call, 3 roll-call
                element("REPLYNBR", 16, RAW),
            ])),
        ),
        subitem("SNB", "Scan Number", Element(8, NUMBER)),
        subitem(
            "DATE",
            "Common and Plot Characteristics Date",
            Group(&[
                element("Y1", 4, NUMBER),
                element("Y2", 4, NUMBER),
                element("Y3", 4, NUMBER),
                element("Y4", 4, NUMBER),
                element("M1", 4, NUMBER),
                element("M2", 4, NUMBER),
                element("D1", 4, NUMBER),
                element("D2", 4, NUMBER),
            ]),
        ),
    ]),
);

const GEN48_ALTM2: Option<Item> = subitem(
    "ALTM2",
    "Alternative Mode 2 Code",
    Group(&[
        flag("V"), // 1 not validated
        flag("G"), // 1 garbled
        flag("L"), // 1 smoothed by a local tracker
        spare(1),
        element("ALTM2", 12, OCTAL),
    ]),
);

const GEN48_ALTM3: Option<Item> = subitem(
    "ALTM3",
    "Alternative Mode 3/A",
    Group(&[
        flag("V"), // 1 not validated
        flag("G"), // 1 garbled
        flag("L"), // 1 smoothed by a local tracker
        spare(1),
        element("ALTM3", 12, OCTAL),
    ]),
);

const GEN48_ALTFL: Option<Item> = subitem(
    "ALTFL",
    "Alternative Flight Level",
    Group(&[
        flag("V"), // 1 not validated
        flag("G"), // 1 garbled
        element("ALTFL", 14, signed(1.0 / pow2(2), "FL")),
    ]),
);

const GEN48_RCSDB: Option<Item> = subitem(
    "RCSDB",
    "Radar Cross Section",
    Group(&[spare(2), element("RCSDB", 14, signed(0.01, "dBm²"))]),
);

const GEN48_RCSM: Option<Item> = subitem(
    "RCSM",
    "Radar Cross Section",
    Group(&[spare(2), element("RCSM", 30, unsigned(0.000_001, "m²"))]),
);

const GEN48: Option<Item> = subitem(
    "GEN48",
    "Generic Category 048 Data",
    Compound(&[GEN48_ALTM2, GEN48_ALTM3, GEN48_ALTFL]),
);

const GEN48_V1_13: Option<Item> = subitem(
    "GEN48",
    "Generic Category 048 Data",
    Compound(&[GEN48_ALTM2, GEN48_ALTM3, GEN48_ALTFL, GEN48_RCSDB, GEN48_RCSM]),
);

const fn edition(minor: u8, items: &'static [Option<Item>]) -> Expansion {
    Expansion::new(48, Edition::new(1, minor), "EUROCONTROL-SPEC-0149-4A", items)
}

/// I048/RE, ed 1.11.
pub static CAT048_RE_V1_11: Expansion = edition(11, &[MD5, M5N, M4E, RPC, ERR, RTC, CPC]);

/// I048/RE, ed 1.12.
pub static CAT048_RE_V1_12: Expansion = edition(12, &[MD5, M5N, M4E, RPC, ERR, RTC, CPC, GEN48]);

/// I048/RE, ed 1.13.
pub static CAT048_RE_V1_13: Expansion = edition(13, &[MD5, M5N, M4E, RPC, ERR, RTC, CPC, GEN48_V1_13]);
