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
use crate::categories::{MODE_3A, SOURCE};
use crate::table::*;

items! {
    I000 "000" "Message Type" (8) // 1 target report, 2 update cycle, 3 and 4 status

    I010 "010" "Data Source Identifier" (SOURCE)

    I020 "020" "Target Report Descriptor" [
        {
            TYP: 3, // 0 SSR mlat, 1 Mode S mlat, 2 ADS-B, 3 PSR, 4 loop, 5 HF mlat, 7 other
            DCR: 1, // differential correction (ADS-B)
            CHN: 1, // 0 chain 1, 1 chain 2
            GBS: 1, // transponder's ground bit set
            CRT: 1, // corrupted replies in multilateration
        }
        {
            SIM: 1, // simulated
            TST: 1, // test target
            RAB: 1, // from a field monitor, a fixed transponder
            LOP: 2, // 0 undetermined, 1 loop start, 2 loop finish
            TOT: 2, // 0 undetermined, 1 aircraft, 2 ground vehicle, 3 helicopter
        }
        {
            SPI: 1, // special position identification
            _: 6,
        }
    ]

    I040 "040" "Measured Position in Polar Co-ordinates" {
        RHO: 16 unsigned(1.0, "m"),
        TH: 16 unsigned(360.0 / pow2(16), "°"),
    }

    I041 "041" "Position in WGS-84 Co-ordinates" {
        LAT: 32 signed(180.0 / pow2(31), "°"),
        LON: 32 signed(180.0 / pow2(31), "°"),
    }

    I042 "042" "Position in Cartesian Co-ordinates" {
        X: 16 signed(1.0, "m"),
        Y: 16 signed(1.0, "m"),
    }

    I060 "060" "Mode-3/A Code in Octal Representation" (MODE_3A)

    I090 "090" "Flight Level in Binary Representation" {
        V: 1, // 1 not validated
        G: 1, // 1 garbled
        FL: 14 signed(1.0 / pow2(2), "FL"),
    }

    I091 "091" "Measured Height" (16 signed(6.25, "ft"))
    I131 "131" "Amplitude of Primary Plot" (8) // 0 is the least detectable
    I140 "140" "Time of Day" (24 unsigned(1.0 / pow2(7), "s"))

    I161 "161" "Track Number" {
        _: 4,
        TRK: 12,
    }

    I170 "170" "Track Status" [
        {
            CNF: 1, // 0 confirmed, 1 being initialised
            TRE: 1, // last report of the track
            CST: 2, // extrapolated: 0 no, 1 between scans, 2 in masked area, 3 unpredictable
            MAH: 1, // horizontal manoeuvre
            TCC: 1, // 0 sensor plane, 1 slant range corrected and projected
            STH: 1, // 0 measured position, 1 smoothed
        }
        {
            TOM: 2, // movement: 0 unknown, 1 taking off, 2 landing, 3 other
            DOU: 3, // doubt, 0 none
            MRS: 2, // 0 undetermined, 1 merged by and 2 not by association to plot, 3 split
        }
        {
            GHO: 1, // ghost
            _: 6,
        }
    ]

    I200 "200" "Calculated Track Velocity in Polar Co-ordinates" {
        GSP: 16 unsigned(1.0 / pow2(14), "NM/s"),
        TRA: 16 unsigned(360.0 / pow2(16), "°"),
    }

    I202 "202" "Calculated Track Velocity in Cartesian Co-ordinates" {
        VX: 16 signed(1.0 / pow2(2), "m/s"), // not 2^-4, see above
        VY: 16 signed(1.0 / pow2(2), "m/s"),
    }

    I210 "210" "Calculated Acceleration" {
        AX: 8 signed(1.0 / pow2(2), "m/s²"), // not 2^-4, see above
        AY: 8 signed(1.0 / pow2(2), "m/s²"),
    }

    I220 "220" "Target Address" (24)

    I245 "245" "Target Identification" {
        // 0 call sign or registration downlinked, 1 call sign not downlinked, 2 registration not downlinked.
        // Beware: CAT020 numbers them otherwise, and systems that send both categories may use one numbering.
        STI: 2,
        _: 6,
        CHR: 48 ICAO,
    }

    I250 "250" "Mode S MB Data" (repetitive {
        MBDATA: 56, // Comm-B message
        BDS1: 4,    // register number, first digit
        BDS2: 4,    // second digit
    })

    I270 "270" "Target Size and Orientation" [
        {
            LENGTH: 7 unsigned(1.0, "m"),
        }
        {
            ORIENTATION: 7 unsigned(360.0 / pow2(7), "°"),
        } // of the nose, from geographical north
        {
            WIDTH: 7 unsigned(1.0, "m"),
        }
    ]

    I280 "280" "Presence" (repetitive {
        DRHO: 8 signed(1.0, "m"), // from the centre of the plot
        DTHETA: 8 signed(0.15, "°"),
    })

    // 0 unknown, 3 fire, 16 follow me, …
    I300 "300" "Vehicle Fleet Identification" (8)

    I310 "310" "Pre-programmed Message" {
        TRB: 1, // in trouble
        MSG: 7,
    }

    I500 "500" "Standard Deviation of Position" {
        DEVX: 8 unsigned(1.0 / pow2(2), "m"),
        DEVY: 8 unsigned(1.0 / pow2(2), "m"),
        COVXY: 16 signed(1.0 / pow2(2), "m²"),
    }

    I550 "550" "System Status" {
        NOGO: 2, // 0 operational, 1 degraded, 2 do not use
        OVL: 1,  // overload
        TSV: 1,  // time source invalid
        DIV: 1,  // diversity degraded
        TTF: 1,  // test target failure
        _: 2,
    }
}

/// The items by field reference number.
#[rustfmt::skip]
const PROFILE: &[Option<Item>] = &profile![
    I010, I000, I020, I140, I041, I040, I042, // FRN  1 to  7
    I200, I202, I161, I170, I060, I220, I245, //      8 to 14
    I250, I300, I090, I091, I270, I550, I310, //     15 to 21
    I500, I280, I131, I210, _, SP, RE,        //     22 to 28
];

editions! {
    CAT010 10 "Transmission of Monosensor Surface Movement Data" "EUROCONTROL-SPEC-0149-7" ["140"]
    CAT010_V1_1 1 1 PROFILE;
}
