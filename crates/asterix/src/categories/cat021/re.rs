//! Content of the reserved expansion field I021/RE in editions 1.4 and 1.5 of its coding rules.
//!
//! EUROCONTROL-SPEC-0149-12A. Ed 1.5 is for ADS-B version 3.

use crate::expansion::Expansion;
use crate::table::*;

items! {
    sub BPS "BPS" "Barometric Pressure Setting" {
        _: 4,
        BPS: 12 unsigned(0.1, "hPa"), // above 800 hPa
    }

    sub SH "SH" "Selected Heading" {
        _: 4,
        HDR: 1,  // 0 true, 1 magnetic north
        STAT: 1, // 1 available and valid
        SH: 10 unsigned(360.0 / pow2(9), "°"),
    }

    sub NAV "NAV" "Navigation Mode" {
        AP: 1, // autopilot engaged
        VN: 1, // vertical navigation active
        AH: 1, // altitude hold engaged
        AM: 1, // approach mode active
        _: 4,
    }

    sub NAV_V1_5 "NAV" "Navigation Mode" {
        AP: 1,                  // autopilot engaged
        VN: 1,                  // vertical navigation active
        AH: 1,                  // altitude hold engaged
        AM: 1,                  // approach mode active
        MFM: { EP: 1, VAL: 1 }, // 1 the mode bits above were filled in on board
        _: 2,
    }

    // of the antenna from the longitudinal axis and the nose, as a code
    sub GAO "GAO" "GPS Antenna Offset" (8)

    sub SGV "SGV" "Surface Ground Vector" [
        {
            STP: 1, // stopped
            HTS: 1, // 1 HGT is valid
            HTT: 1, // HGT is: 0 the heading, 1 the ground track
            HRD: 1, // 0 true, 1 magnetic north
            GSS: 11 unsigned(1.0 / pow2(3), "kt"),
        }
        {
            HGT: 7 unsigned(360.0 / pow2(7), "°"),
        }
    ]

    sub STA "STA" "Aircraft Status" [{
        ES: 1,  // receives 1090 MHz extended squitter
        UAT: 1, // receives UAT
        _: 5,
    }]

    sub STA_V1_5 "STA" "Aircraft Status" [
        // In this and the next groups, EP states whether VAL has a meaning.
        {
            ES: 1,                  // receives 1090 MHz extended squitter
            UAT: 1,                 // receives UAT
            RCE: { EP: 1, VAL: 2 }, // reduced capability equipment: 1 TABS, 3 other
            RRL: { EP: 1, VAL: 1 }, // reply rate limiting active
        }
        {
            PS3: { EP: 1, VAL: 3 }, // emergency: 0 none, 2 lost link, 3 fuel, 4 radio, …
            TPW: { EP: 1, VAL: 2 }, // transmit power in W: 1 70, 2 125, 3 200
        }
        {
            TSI: { EP: 1, VAL: 2 }, // transponder: 0 unknown, 1 left, 2 right, 3 backup
            MUO: { EP: 1, VAL: 1 }, // unmanned
            RWC: { EP: 1, VAL: 1 }, // remain well clear alert active
        }
        {
            DAA: { EP: 1, VAL: 2 },    // detect and avoid: 1 RWC, RA, OCM, 2 RWC, OCM
            DF17CA: { EP: 1, VAL: 3 }, // transponder capability
        }
        {
            SVH: { EP: 1, VAL: 2 },  // avoids: 0 vertically, 1 horizontally, 2 both
            CATC: { EP: 1, VAL: 3 }, // kind of collision avoidance
        }
        {
            TAO: { EP: 1, VAL: 5 }, // offset of the antenna, as a code
            _: 1,
        }
    ]

    sub TNH "TNH" "True North Heading" (16 unsigned(360.0 / pow2(16), "°"))

    sub MES "MES" "Military Extended Squitter" (compound [
        SUM "Mode 5 Summary" {
            M5: 1, // Mode 5 interrogated
            ID: 1, // authenticated identification reply
            DA: 1, // authenticated data reply or report
            M1: 1, // this and the next four: it came in a Mode 5 reply
            M2: 1,
            M3: 1,
            MC: 1,
            PO: 1,
        },
        PNO "Mode 5 PIN / National Origin" {
            _: 2,
            PIN: 14,
            _: 5,
            NO: 11, // national origin
        },
        EM1 "Extended Mode 1 Code in Octal Representation" {
            V: 1, // 1 not validated
            _: 1,
            L: 1, // 1 smoothed by a local tracker
            _: 1,
            EM1: 12 OCTAL,
        },
        XP "X Pulse Presence" {
            _: 2,
            XP: 1, // X-pulse in the Mode 5 PIN reply
            X5: 1, // in the Mode 5 data reply
            XC: 1, // in the Mode C reply
            X3: 1, // in the Mode 3/A reply
            X2: 1, // in the Mode 2 reply
            X1: 1, // in the Mode 1 reply
        },
        FOM "Figure of Merit" {
            _: 3,
            FOM: 5, // a category
        },
        M2 "Mode 2 Code in Octal Representation" {
            V: 1, // 1 not validated
            _: 1,
            L: 1, // 1 smoothed by a local tracker
            _: 1,
            MODE2: 12 OCTAL,
        },
    ])
}

const fn edition(minor: u8, items: &'static [Option<Item>]) -> Expansion {
    Expansion::new(21, Edition::new(1, minor), "EUROCONTROL-SPEC-0149-12A", items)
}

/// I021/RE, ed 1.4.
pub static CAT021_RE_V1_4: Expansion = edition(4, &[BPS, SH, NAV, GAO, SGV, STA, TNH, MES]);

/// I021/RE, ed 1.5.
pub static CAT021_RE_V1_5: Expansion = edition(5, &[BPS, SH, NAV_V1_5, GAO, SGV, STA_V1_5, TNH, MES]);
