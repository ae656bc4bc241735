//! CAT048: target reports of a radar.
//!
//! EUROCONTROL-SPEC-0149-4, ed 1.27 (June 2020) to 1.32 (July 2024), with the same order of items. Later editions
//! added parts of I048/020, and codes of I048/030. Ed 1.32 defines the flight level in I048/090 in two's complement;
//! earlier editions state no sign. Their tables have one nevertheless: the words of the document changed, not what
//! radars send. Without the sign, an aircraft a little below sea level pressure would fly at FL 4086.

mod re;

pub use re::{CAT048_RE_V1_11, CAT048_RE_V1_12, CAT048_RE_V1_13};

use crate::categories::{MODE_1, MODE_2, MODE_3A, MODE_C, PULSE_QUALITY, RE, SOURCE, SP};
use crate::table::*;

items! {
    I010 "010" "Data Source Identifier" (SOURCE)

    parts I020_PART_1 {
        TYP: 3, // 0 none, 1 PSR, 2 SSR, 3 both; Mode S: 4 all-call, 5 roll-call, 6 and 7 the same + PSR
        SIM: 1, // simulated
        RDP: 1, // radar data processing: 0 chain 1, 1 chain 2
        SPI: 1, // special position identification
        RAB: 1, // from a field monitor, a fixed transponder
    }

    parts I020_PART_2 {
        TST: 1,    // test target
        ERR: 1,    // extended range: I048/040 does not hold it, the reserved expansion field does
        XPP: 1,    // X-pulse present
        ME: 1,     // military emergency
        MI: 1,     // military identification
        FOEFRI: 2, // Mode 4: 0 not interrogated, 1 friend, 2 unknown, 3 no reply
    }

    parts I020_PART_3 {
        // In this and the next groups, EP states whether VAL has a meaning.
        ADSB: { EP: 1, VAL: 1 }, // ADS-B information available on site
        SCN: { EP: 1, VAL: 1 },  // surveillance cluster network information available
        PAI: { EP: 1, VAL: 1 },  // passive acquisition interface information available
        _: 1,
    }

    I020 "020" "Target Report Descriptor" [I020_PART_1 I020_PART_2]
    I020_V1_31 "020" "Target Report Descriptor" [I020_PART_1 I020_PART_2 I020_PART_3]

    I020_V1_32 "020" "Target Report Descriptor" [
        I020_PART_1
        I020_PART_2
        I020_PART_3
        {
            ACASXV: { EP: 1, VAL: 4 }, // extended version of ACAS: 0 none, 1 Xa, 2 Xu
            POXPR: { EP: 1, VAL: 1 },  // transponder capable of phase overlay
        }
        {
            POACT: { EP: 1, VAL: 1 },  // phase overlay active for this plot
            DTFXPR: { EP: 1, VAL: 1 }, // transponder capable of basic dataflash
            DTFACT: { EP: 1, VAL: 1 }, // dataflash active for this plot
            _: 1,
        }
        {
            IRMXPR: { EP: 1, VAL: 1 }, // transponder capable of IRM
            IRMACT: { EP: 1, VAL: 1 }, // IRM active for this plot
            _: 3,
        }
    ]

    // 1 reflection, 2 side lobe, 3 split plot, 4 second time around, 5 angel, … 16 duplicate or illegal address, …
    I030 "030" "Warning/Error Conditions and Target Classification" (repetitive_fx (7))

    I040 "040" "Measured Position in Polar Co-ordinates" {
        RHO: 16 unsigned(1.0 / pow2(8), "NM"),
        THETA: 16 unsigned(360.0 / pow2(16), "°"),
    }

    I042 "042" "Calculated Position in Cartesian Co-ordinates" {
        X: 16 signed(1.0 / pow2(7), "NM"),
        Y: 16 signed(1.0 / pow2(7), "NM"),
    }

    I050 "050" "Mode-2 Code in Octal Representation" (MODE_2)

    I055 "055" "Mode-1 Code in Octal Representation" (MODE_1)

    I060 "060" "Mode-2 Code Confidence Indicator" (= Layout::Group(PULSE_QUALITY))

    I065 "065" "Mode-1 Code Confidence Indicator" {
        _: 3,
        QA4: 1,
        QA2: 1,
        QA1: 1,
        QB2: 1,
        QB1: 1,
    }

    I070 "070" "Mode-3/A Code in Octal Representation" (MODE_3A)

    I080 "080" "Mode-3/A Code Confidence Indicator" (= Layout::Group(PULSE_QUALITY))

    I090 "090" "Flight Level in Binary Representation" {
        V: 1, // 1 not validated
        G: 1, // 1 garbled
        FL: 14 signed(1.0 / pow2(2), "FL"),
    }

    I100 "100" "Mode-C Code and Code Confidence Indicator" (= Layout::Group(MODE_C))

    I110 "110" "Height Measured by a 3D Radar" {
        _: 2,
        "3DH": 14 signed(25.0, "ft"),
    }

    I120 "120" "Radial Doppler Speed" (compound [
        CAL "Calculated Doppler Speed" {
            D: 1, // 1 doubtful
            _: 5,
            CAL: 10 signed(1.0, "m/s"),
        },
        RDS "Raw Doppler Speed" (repetitive {
            DOP: 16 unsigned(1.0, "m/s"),
            AMB: 16 unsigned(1.0, "m/s"), // range of the ambiguity
            FRQ: 16 unsigned(1.0, "MHz"), // transmitter frequency
        }),
    ])

    I130 "130" "Radar Plot Characteristics" (compound [
        SRL "SSR Plot Runlength" (8 unsigned(360.0 / pow2(13), "°")),
        SRR "Number of Received Replies for (M)SSR" (8 NUMBER),
        SAM "Amplitude of (M)SSR Reply" (8 signed(1.0, "dBm")),
        PRL "Primary Plot Runlength" (8 unsigned(360.0 / pow2(13), "°")),
        PAM "Amplitude of Primary Plot" (8 signed(1.0, "dBm")),
        RPD "Difference in Range Between PSR and SSR Plot" (8 signed(1.0 / pow2(8), "NM")),
        APD "Difference in Azimuth Between PSR and SSR Plot" (8 signed(360.0 / pow2(14), "°")),
    ])

    I140 "140" "Time of Day" (24 unsigned(1.0 / pow2(7), "s"))

    I161 "161" "Track Number" {
        _: 4,
        TRN: 12,
    }

    I170 "170" "Track Status" [
        {
            CNF: 1, // 0 confirmed, 1 tentative
            RAD: 2, // maintained by: 0 both, 1 PSR, 2 SSR or Mode S, 3 invalid
            DOU: 1, // low confidence in the association of plot to track
            MAH: 1, // horizontal manoeuvre
            CDM: 2, // 0 maintaining, 1 climbing, 2 descending, 3 unknown
        }
        {
            TRE: 1, // last report of the track
            GHO: 1, // ghost
            SUP: 1, // maintained with track information from a neighbouring node
            TCC: 1, // 0 radar plane, 1 slant range corrected and projected
            _: 3,
        }
    ]

    I200 "200" "Calculated Track Velocity in Polar Co-ordinates" {
        GSP: 16 unsigned(1.0 / pow2(14), "NM/s"),
        HDG: 16 unsigned(360.0 / pow2(16), "°"),
    }

    I210 "210" "Track Quality" {
        SIGX: 8 unsigned(1.0 / pow2(7), "NM"), // standard deviations
        SIGY: 8 unsigned(1.0 / pow2(7), "NM"),
        SIGV: 8 unsigned(1.0 / pow2(14), "NM/s"), // of ground speed
        SIGH: 8 unsigned(360.0 / pow2(12), "°"),  // of heading
    }

    I220 "220" "Aircraft Address" (24)

    I230 "230" "Communications/ACAS Capability and Flight Status" {
        COM: 3,  // communications capability
        STAT: 3, // alert, special position identification, airborne or on ground
        SI: 1,   // 1 has II codes only, 0 SI codes
        _: 1,
        MSSC: 1, // Mode S specific services
        ARC: 1,  // altitude reported in steps of: 0 100 ft, 1 25 ft
        AIC: 1,  // aircraft identification
        B1A: 1,  // BDS 1,0 bit 16
        B1B: 4,  // BDS 1,0 bits 37 to 40
    }

    I240 "240" "Aircraft Identification" (48 ICAO)

    I250 "250" "Mode S MB Data" (repetitive {
        MBDATA: 56, // Comm-B message
        BDS1: 4,    // register number, first digit
        BDS2: 4,    // second digit
    })

    I260 "260" "ACAS Resolution Advisory Report" (56)
}

/// The items by field reference number; the item passed is not the same in all editions.
#[rustfmt::skip]
const fn profile(i020: Item) -> [Option<Item>; 28] {
    profile![
        I010, I140, i020, I040, I070, I090, I130, // FRN  1 to  7
        I220, I240, I250, I161, I042, I200, I170, //      8 to 14
        I210, I030, I080, I100, I110, I120, I230, //     15 to 21
        I260, I055, I050, I065, I060, SP, RE,     //     22 to 28
    ]
}

editions! {
    CAT048 48 "Monoradar Target Reports" "EUROCONTROL-SPEC-0149-4" ["140"]
    CAT048_V1_27 1 27 &profile(I020);
    CAT048_V1_28 1 28 &profile(I020);
    CAT048_V1_29 1 29 &profile(I020);
    CAT048_V1_30 1 30 &profile(I020);
    CAT048_V1_31 1 31 &profile(I020_V1_31);
    CAT048_V1_32 1 32 &profile(I020_V1_32);
}
