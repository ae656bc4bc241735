//! Content of the reserved expansion field I048/RE in editions 1.11 to 1.13 of its coding rules.
//!
//! EUROCONTROL-SPEC-0149-4A. Each edition is an addition to the one before.

use crate::expansion::Expansion;
use crate::table::*;

items! {
    sub MD5_SUM "SUM" "Mode 5 Summary" {
        M5: 1, // Mode 5 interrogated
        ID: 1, // authenticated identification reply
        DA: 1, // authenticated data reply or report
        M1: 1, // this and the next three: it came in a Mode 5 reply
        M2: 1,
        M3: 1,
        MC: 1,
        _: 1,
    }

    sub MD5_PMN "PMN" "PIN/ National Origin/Mission Code" {
        _: 2,
        PIN: 14,
        _: 2,
        NAV: 1, // 1 NAT is invalid
        NAT: 5, // national origin
        _: 2,
        MIS: 6, // mission
    }

    sub MD5_POS "POS" "Mode 5 Reported Position" {
        LAT: 24 signed(180.0 / pow2(23), "°"),
        LON: 24 signed(180.0 / pow2(23), "°"),
    }

    sub MD5_GA "GA" "Mode 5 GNSS-derived Altitude" {
        _: 1,
        RES: 1, // reported in steps of: 0 100 ft, 1 25 ft
        GA: 14 signed(25.0, "ft"),
    }

    sub MD5_EM1 "EM1" "Extended Mode 1 Code in Octal Representation" {
        V: 1, // 1 validated, other than elsewhere
        G: 1, // 1 garbled
        L: 1, // 1 not extracted during the last scan
        _: 1,
        EM1: 12 OCTAL,
    }

    sub MD5_TOS "TOS" "Time Offset for POS and GA" (8 unsigned(1.0 / pow2(7), "s")) // from I048/140

    sub MD5_XP "XP" "X Pulse Presence" {
        _: 2,
        XP: 1, // X-pulse in the Mode 5 PIN reply
        X5: 1, // in the Mode 5 data reply
        XC: 1, // in the Mode C reply
        X3: 1, // in the Mode 3/A reply
        X2: 1, // in the Mode 2 reply
        X1: 1, // in the Mode 1 reply
    }

    sub M5N_PMN "PMN" "PIN/ National Origin/Mission Code" {
        _: 2,
        PIN: 14,
        _: 4,
        NOV: 1, // 1 NO is invalid
        NO: 11, // national origin
    }

    sub M5N_FOM "FOM" "Figure of Merit" {
        _: 3,
        FOM: 5, // a category
    }

    sub MD5 "MD5" "Mode 5 Reports" (compound [
        MD5_SUM, MD5_PMN, MD5_POS, MD5_GA, MD5_EM1, MD5_TOS,
        MD5_XP,
    ])

    sub M5N "M5N" "Mode 5 Reports, New Format" (compound [
        MD5_SUM, M5N_PMN, MD5_POS, MD5_GA, MD5_EM1, MD5_TOS,
        MD5_XP, M5N_FOM,
    ])

    sub M4E "M4E" "Extended Mode 4 Report" [{
        _: 5,
        FOEFRI: 2, // Mode 4: 0 not interrogated, 1 possibly, 2 probably and 3 certainly friend
    }]

    sub RPC "RPC" "Radar Plot Characteristics" (compound [
        SCO "Score" (8 NUMBER),
        SRC "Signal/Clutter Ratio" (16 unsigned(0.1, "dB")),
        RW "Range Width" (16 unsigned(1.0 / pow2(8), "NM")),
        AR "Ambiguous Range" (16 unsigned(1.0 / pow2(8), "NM")),
    ])

    sub ERR "ERR" "Extended Range Report" (24 unsigned(1.0 / pow2(8), "NM"))

    sub RTC "RTC" "Radar Track Characteristics" (compound [
        PTL "Plot/Track Link" {
            _: 3,
            SCN: 1, // associated with a plot of the surveillance cluster network
            RC: 1,  // this and the next three: the plot has such a component
            AC: 1,
            SSR: 1,
            PSR: 1,
            PLOTNR: 16, // as CPC/PNB
        },
        ATL "ADS-B/Track Link" (repetitive (16)),
        TRN "Turn State" (8 unsigned(1.0, "%")),
        NPP "Next Predicted Position" {
            PREDRHO: 16 unsigned(1.0 / pow2(7), "NM"),
            PREDTHETA: 16 unsigned(360.0 / pow2(16), "°"),
            EVOLRHOSTART: 16 unsigned(1.0 / pow2(7), "NM"),
            EVOLRHOEND: 16 unsigned(1.0 / pow2(7), "NM"),
            EVOLTHETASTART: 16 unsigned(360.0 / pow2(16), "°"),
            EVOLTHETAEND: 16 unsigned(360.0 / pow2(16), "°"),
            NOISERHOSTART: 16 unsigned(1.0 / pow2(7), "NM"),
            NOISERHOEND: 16 unsigned(1.0 / pow2(7), "NM"),
            NOISETHETASTART: 16 unsigned(360.0 / pow2(16), "°"),
            NOISETHETAEND: 16 unsigned(360.0 / pow2(16), "°"),
            PREDTIME: 16 unsigned(1.0 / pow2(7), "s"),
        },
        DLK "Data Link Characteristics" (repetitive {
            TYPE: 4,   // of the data link task
            ORIGIN: 2, // 0 previous scan, 1 this scan, 2 requested by the transponder
            STATE: 2,  // 0 in progress, 1 completed, 2 cancelled
        }),
        LCK "Lockout Characteristics" {
            LS: 1,                          // locked out by this radar
            LOCTIM: 15 unsigned(1.0, "ms"), // since when
        },
        TC "Transition Code" {
            _: 7,
            TCOUNT1: 4 NUMBER,
            TCODE1: 5, // Mode 1
            TCOUNT2: 4 NUMBER,
            TCODE2: 12 OCTAL, // Mode 2
            TCOUNT3: 4 NUMBER,
            TCODE3: 12 OCTAL, // Mode 3/A
        },
        TLC "Track Life Cycle" {
            ACQI: 2,                            // 0 tentative of one plot, 1 of more, 2 pre-confirmed, 3 confirmed
            TRKUPDCTR: 14 NUMBER,               // updates
            LASTTRKUPD: 16 unsigned(1.0, "ms"), // since the last update
        },
        ASI "Adjacent Sensor Information" (repetitive {
            SACADJS: 8,
            SICADJS: 8,
            TIMEOFDAYSCN: 16 unsigned(1.0 / pow2(7), "s"), // within the current 512 s
            DATAUSE: 7,                                    // by the tracker: 0 used, 1 not used
            DRNA: 1,                                       // 1 DRN is valid
            DRN: 16,
        }),
        // 0 radar tracker, 1 ADS-B on site, 2 ADS-B from elsewhere, 3 cluster network
        TES "Track Extrapolation Source" (8),
        IR "Identity Requested" {
            IR: 1,                     // identity requested
            M3A: 7 unsigned(1.0, "s"), // age of I048/070
        },
    ])

    sub CPC "CPC" "Common and Plot Characteristics" (compound [
        PNB "Plot Number" (16),
        RPL "Replies/Plot Link" (repetitive {
            TYPE: 8, // 0 PSR, 1 SSR, 2 all-call, 3 roll-call
            REPLYNBR: 16,
        }),
        SNB "Scan Number" (8 NUMBER),
        DATE "Common and Plot Characteristics Date" {
            Y1: 4 NUMBER,
            Y2: 4 NUMBER,
            Y3: 4 NUMBER,
            Y4: 4 NUMBER,
            M1: 4 NUMBER,
            M2: 4 NUMBER,
            D1: 4 NUMBER,
            D2: 4 NUMBER,
        },
    ])

    sub GEN48_ALTM2 "ALTM2" "Alternative Mode 2 Code" {
        V: 1, // 1 not validated
        G: 1, // 1 garbled
        L: 1, // 1 smoothed by a local tracker
        _: 1,
        ALTM2: 12 OCTAL,
    }

    sub GEN48_ALTM3 "ALTM3" "Alternative Mode 3/A" {
        V: 1, // 1 not validated
        G: 1, // 1 garbled
        L: 1, // 1 smoothed by a local tracker
        _: 1,
        ALTM3: 12 OCTAL,
    }

    sub GEN48_ALTFL "ALTFL" "Alternative Flight Level" {
        V: 1, // 1 not validated
        G: 1, // 1 garbled
        ALTFL: 14 signed(1.0 / pow2(2), "FL"),
    }

    sub GEN48_RCSDB "RCSDB" "Radar Cross Section" {
        _: 2,
        RCSDB: 14 signed(0.01, "dBm²"),
    }

    sub GEN48_RCSM "RCSM" "Radar Cross Section" {
        _: 2,
        RCSM: 30 unsigned(0.000_001, "m²"),
    }

    sub GEN48 "GEN48" "Generic Category 048 Data" (compound [GEN48_ALTM2, GEN48_ALTM3, GEN48_ALTFL])

    sub GEN48_V1_13 "GEN48" "Generic Category 048 Data" (compound [
        GEN48_ALTM2, GEN48_ALTM3, GEN48_ALTFL, GEN48_RCSDB, GEN48_RCSM,
    ])
}

const fn edition(minor: u8, items: &'static [Option<Item>]) -> Expansion {
    Expansion::new(48, Edition::new(1, minor), "EUROCONTROL-SPEC-0149-4A", items)
}

/// I048/RE, ed 1.11.
pub static CAT048_RE_V1_11: Expansion = edition(11, &[MD5, M5N, M4E, RPC, ERR, RTC, CPC]);

/// I048/RE, ed 1.12.
pub static CAT048_RE_V1_12: Expansion = edition(12, &[MD5, M5N, M4E, RPC, ERR, RTC, CPC, GEN48]);

/// I048/RE, ed 1.13.
pub static CAT048_RE_V1_13: Expansion = edition(13, &[MD5, M5N, M4E, RPC, ERR, RTC, CPC, GEN48_V1_13]);
