//! CAT001: target reports of a radar, the format before CAT048: plots and tracks.
//!
//! EUROCONTROL-SPEC-0149-2a, once SUR.ET1.ST05.2000-STD-02a-01, ed 1.2 to 1.4 (August 2022), of one layout.
//!
//! Plots and tracks have separate profiles with the same items up to I001/020; the first bit of I001/020 selects the
//! profile. A station may send I001/010 with the first record of a block only, for all records of the block. The time
//! is modulo 512 s; the receiver must complete it.

use super::{MODE_C, PULSE_QUALITY, RFS, SP};
use crate::categories::{MODE_2, MODE_3A, SOURCE};
use crate::table::*;

items! {
    I010 "010" "Data Source Identifier" (SOURCE)

    I020 "020" "Target Report Descriptor" [
        {
            TYP: 1,    // 0 plot, 1 track: decides between the two profiles
            SIM: 1,    // simulated
            SSRPSR: 2, // 0 no detection, 1 PSR, 2 SSR, 3 both
            ANT: 1,    // 0 antenna 1, 1 antenna 2
            SPI: 1,    // special position identification
            RAB: 1,    // from a field monitor, a fixed transponder
        }
        {
            TST: 1,    // test target
            DS1DS2: 2, // 0 none, 1 code 7500, 2 code 7600, 3 code 7700
            ME: 1,     // military emergency
            MI: 1,     // military identification
            _: 2,
        }
    ]

    // 1 garbled, 2 reflection, 3 side lobe, 4 split plot, 5 second time around, 6 angels, 7 vehicles, …
    I030 "030" "Warning/Error Conditions" (repetitive_fx (7))

    I040 "040" "Measured Position in Polar Co-ordinates" {
        RHO: 16 unsigned(1.0 / pow2(7), "NM"),
        THETA: 16 unsigned(360.0 / pow2(16), "°"),
    }

    I042 "042" "Calculated Position in Cartesian Co-ordinates" {
        X: 16 signed(1.0 / pow2(6), "NM"),
        Y: 16 signed(1.0 / pow2(6), "NM"),
    }

    I050 "050" "Mode-2 Code in Octal Representation" (MODE_2)

    I060 "060" "Mode-2 Code Confidence Indicator" (= Layout::Group(PULSE_QUALITY))

    I070 "070" "Mode-3/A Code in Octal Representation" (MODE_3A)

    I080 "080" "Mode-3/A Code Confidence Indicator" (= Layout::Group(PULSE_QUALITY))

    I090 "090" "Mode-C Code in Binary Representation" {
        V: 1, // 1 not validated
        G: 1, // 1 garbled
        HGT: 14 signed(1.0 / pow2(2), "FL"),
    }

    I100 "100" "Mode-C Code and Code Confidence Indicator" (= Layout::Group(MODE_C))
    I120 "120" "Measured Radial Doppler Speed" (8 signed(1.0 / pow2(8), "NM/s"))

    // plot's run length, power, …: as the station defines
    I130 "130" "Radar Plot Characteristics" (repetitive_fx (7))

    I131 "131" "Received Power" (8 signed(1.0, "dBm"))

    // within the current 512 s
    I141 "141" "Truncated Time of Day" (16 unsigned(1.0 / pow2(7), "s"))

    I150 "150" "Presence of X-Pulse" {
        XA: 1, // in the Mode 3/A reply
        _: 1,
        XC: 1, // in the Mode C reply
        _: 2,
        X2: 1, // in the Mode 2 reply
        _: 2,
    }

    I161 "161" "Track Plot Number" (16) // of the plot or track

    I170 "170" "Track Status" [
        {
            CON: 1,  // 0 confirmed, 1 being initialised
            RAD: 1,  // 0 PSR, 1 SSR or combined
            MAN: 1,  // manoeuvring
            DOU: 1,  // doubtful association of plot to track
            RDPC: 1, // radar data processing: 0 chain 1, 1 chain 2
            _: 1,
            GHO: 1, // ghost
        }
        {
            TRE: 1, // last report of the track
            _: 6,
        }
    ]

    I200 "200" "Calculated Track Velocity in Polar Co-ordinates" {
        GSP: 16 unsigned(1.0 / pow2(14), "NM/s"),
        HDG: 16 unsigned(360.0 / pow2(16), "°"),
    }

    I210 "210" "Track Quality" (repetitive_fx (7)) // as the station defines
}

#[rustfmt::skip]
const PLOT: &[Option<Item>] = &profile![
    I010, I020, I040, I070, I090, I130, I141, // FRN  1 to  7
    I050, I120, I131, I080, I100, I060, I030, //      8 to 14
    I150, _, _, _, _, SP, RFS,                //     15 to 21
];

#[rustfmt::skip]
const TRACK: &[Option<Item>] = &profile![
    I010, I020, I161, I040, I042, I200, I070, // FRN  1 to  7
    I090, I141, I130, I131, I120, I170, I210, //      8 to 14
    I050, I080, I100, I060, I030, SP, RFS,    //     15 to 21
    I150,                                     //           22
];

/// Profiles by the value of TYP.
const PROFILES: &[(u64, Uap)] = &[(0, Uap::new(PLOT)), (1, Uap::new(TRACK))];

const fn edition(minor: u8) -> Category {
    Category {
        number: 1,
        edition: Edition::new(1, minor),
        title: "Transmission of Monoradar Data Target Reports",
        document: "EUROCONTROL-SPEC-0149-2a",
        times: &[], // it has only the last 512 s of it
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
const _: () = crate::registry::assert_registered(CAT001);
