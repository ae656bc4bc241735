//! CAT034: service messages of a radar: north marker, sector crossings, state.
//!
//! EUROCONTROL-SPEC-0149-2b, ed 1.27 (May 2007) to 1.29 (March 2021). Their layouts are the same; later editions added
//! message types.

use super::{RE, SP};
use crate::categories::SOURCE;
use crate::table::*;

items! {
    // 1 north marker, 2 sector crossing, 3 geographical filter, 4 jamming, 5 solar storm, 6 SSR and 7 Mode S jamming
    I000 "000" "Message Type" (8)

    I010 "010" "Data Source Identifier" (SOURCE)

    // azimuth of its begin; 0 is north
    I020 "020" "Sector Number" (8 unsigned(360.0 / pow2(8), "°"))

    I030 "030" "Time of Day" (24 unsigned(1.0 / pow2(7), "s"))
    I041 "041" "Antenna Rotation Speed" (16 unsigned(1.0 / pow2(7), "s"))

    I050 "050" "System Configuration and Status" (compound [
        COM "Common Part" {
            NOGO: 1,   // 1 not to be used operationally
            RDPC: 1,   // radar data processor chain: 0 first, 1 second
            RDPR: 1,   // 1 reset: expect new track numbers
            OVLRDP: 1, // radar data processor overloaded
            OVLXMT: 1, // transmission overloaded
            MSC: 1,    // monitoring system disconnected
            TSV: 1,    // time source invalid
            _: 1,
        },
        _,
        _,
        PSR "Specific Status Information for a PSR Sensor" {
            ANT: 1,  // 0 antenna 1, 1 antenna 2
            CHAB: 2, // channel: 0 none, 1 A, 2 B, 3 both (diversity)
            OVL: 1,  // overload
            MSC: 1,  // monitoring system disconnected
            _: 3,
        },
        SSR "Specific Status Information for a SSR Sensor" {
            ANT: 1,
            CHAB: 2, // channel: 0 none, 1 A, 2 B, 3 invalid
            OVL: 1,
            MSC: 1,
            _: 3,
        },
        MDS "Specific Status Information for a Mode S Sensor" {
            ANT: 1,
            CHAB: 2,   // channel: 0 none, 1 A, 2 B, 3 invalid
            OVLSUR: 1, // overload
            MSC: 1,
            SCF: 1,    // surveillance co-ordination function: 0 channel A, 1 channel B
            DLF: 1,    // data link function: 0 channel A, 1 channel B
            OVLSCF: 1, // surveillance co-ordination overloaded
            OVLDLF: 1, // data link overloaded
            _: 7,
        },
    ])

    I060 "060" "System Processing Mode" (compound [
        COM "Common Part" {
            _: 1,
            REDRDP: 3, // steps of load reduction, radar data processor; 0 none
            REDXMT: 3, // the same, transmission
            _: 1,
        },
        _,
        _,
        PSR "Specific Processing Mode Information for a PSR Sensor" {
            POL: 1,    // polarisation: 0 linear, 1 circular
            REDRAD: 3, // steps of load reduction; 0 none
            STC: 2,    // sensitivity time control map, counted from 0
            _: 2,
        },
        SSR "Specific Processing Mode Information for a SSR Sensor" {
            REDRAD: 3, // steps of load reduction; 0 none
            _: 5,
        },
        MDS "Specific Processing Mode Information for a Mode S Sensor" {
            REDRAD: 3, // steps of load reduction; 0 none
            CLU: 1,    // cluster: 0 autonomous, 1 not autonomous
            _: 4,
        },
    ])

    I070 "070" "Message Count Values" (repetitive {
        TYP: 5, // 0 no detection, 1 PSR, 2 SSR, 3 both, 4 all-call, 5 roll-call, 6 and 7 with PSR, …
        COUNT: 11 NUMBER,
    })

    I090 "090" "Collimation Error" {
        RNG: 8 signed(1.0 / pow2(7), "NM"),
        AZM: 8 signed(360.0 / pow2(14), "°"),
    }

    I100 "100" "Generic Polar Window" {
        RHOST: 16 unsigned(1.0 / pow2(8), "NM"),
        RHOEND: 16 unsigned(1.0 / pow2(8), "NM"),
        THETAST: 16 unsigned(360.0 / pow2(16), "°"),
        THETAEND: 16 unsigned(360.0 / pow2(16), "°"),
    }

    // filtered data: 1 weather, 2 jamming strobes, 3 PSR, 4 SSR and Mode S, 5 both, …
    I110 "110" "Data Filter" (8)

    I120 "120" "3D-Position Of Data Source" {
        HGT: 16 signed(1.0, "m"),
        LAT: 24 signed(180.0 / pow2(23), "°"),
        LON: 24 signed(180.0 / pow2(23), "°"),
    }
}

/// The items by field reference number.
#[rustfmt::skip]
const PROFILE: &[Option<Item>] = &profile![
    I010, I000, I030, I020, I041, I050, I060, // FRN  1 to  7
    I070, I100, I110, I120, I090, RE, SP,     //      8 to 14
];

editions! {
    CAT034 34 "Transmission of Monoradar Service Messages" "EUROCONTROL-SPEC-0149-2b" ["030"]
    CAT034_V1_27 1 27 PROFILE;
    CAT034_V1_28 1 28 PROFILE;
    CAT034_V1_29 1 29 PROFILE;
}
