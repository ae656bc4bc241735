//! CAT015: target reports of an independent non-cooperative surveillance system (INCS): a radar without transponders,
//! one with the transmitters of others, or optics.
//!
//! EUROCONTROL-SPEC-0149-28, ed 1.0 (July 2019) to 1.2 (May 2024), of one layout. x and y of velocities, accelerations
//! and errors are those of a plane at the target, east and north. Correlations are between −1 and 1. What a range is
//! depends on I015/020: a distance, or for a system of several places the detour by way of the target.
//!
//! The document titles I015/605 as I015/604; its content is the acceleration.

use super::SP;
use crate::categories::SOURCE;
use crate::table::*;

/// Correlations.
const CORRELATION: Content = signed(1.0 / pow2(7), "");
/// Azimuths and other directions.
const DIRECTION: Content = unsigned(360.0 / pow2(16), "°");
/// Elevations and rates.
const ELEVATION: Content = signed(180.0 / pow2(16), "°");
/// Resolutions and standard deviations of angles.
const ANGLE: Content = unsigned(45.0 / pow2(16), "°");

items! {
    I000 "000" "Message Type" {
        MT: 7, // 1 measurement plot, 2 measurement track, 3 sensor centric plot, 4 sensor centric track, 5 track end
        RG: 1, // 0 periodic report, 1 event driven
    }

    I010 "010" "Data Source Identifier" (SOURCE)

    I015 "015" "Service Identification" (8) // chosen by the system

    I020 "020" "Target Report Descriptor" [
        {
            MOMU: 2, // 0 sensor of one place, 1 of several places, 2 other, 3 unknown
            TTAX: 2, // target: 0 actual, 1 reference, 2 synthetic, 3 simulated or replayed
            SCD: 2,  // scanning direction: 0 unknown, 1 forward, 2 backward, 3 static
            _: 1,
        }
    ]

    I030 "030" "Warning/Error Conditions" (repetitive_fx (7))

    I050 "050" "Update Period" {
        _: 2,
        UPD: 14 unsigned(1.0 / pow2(7), "s"),
    }

    I145 "145" "Time of Applicability" (24 unsigned(1.0 / pow2(7), "s"))
    I161 "161" "Track/Plot Number" (16 NUMBER)

    I170 "170" "Track/Plot Status" [
        {
            BIZ: 1, // in a blind zone
            BAZ: 1, // in a blanked zone
            TUR: 1, // ended by the user
            _: 1,
            CSTP: 1, // extrapolated position
            CSTH: 1, // extrapolated height
            CNF: 1,  // 0 confirmed, 1 tentative
        }
    ]

    I270 "270" "Target Size & Orientation" (compound [
        LEN "Target Length" (16 unsigned(0.01, "m")),
        WDT "Target Width" (16 unsigned(0.01, "m")),
        HGT "Target Height" (16 unsigned(0.01, "m")),
        ORT "Target Orientation" (16 DIRECTION),
    ])

    I300 "300" "Object Classification" (repetitive {
        CLS: 9 NUMBER, // class, as the system defines
        PRB: 7 NUMBER, // probability
    })

    I400 "400" "Measurement Identifier" {
        PID: 16 NUMBER, // pair of transmitter and receiver, see I016/300
        ON: 24 NUMBER,  // observation
    }

    I480 "480" "Associations" (repetitive (40)) // measurements behind the report, as in I015/400

    I600 "600" "Horizontal Position Information" (compound [
        P84 "Horizontal Position in WGS-84 Coordinates" {
            LATITUDE: 32 signed(180.0 / pow2(31), "°"),
            LONGITUDE: 32 signed(180.0 / pow2(31), "°"),
        },
        HPR "Horizontal Position Resolution" {
            RSHPX: 16 unsigned(0.5, "m"),
            RSHPY: 16 unsigned(0.5, "m"),
            CORSHPXY: 8 CORRELATION,
        },
        HPP "Horizontal Position Precision" {
            SDHPX: 16 unsigned(0.25, "m"),
            SDHPY: 16 unsigned(0.25, "m"),
            COSDHPXY: 8 CORRELATION,
        },
    ])

    parts XY {
        X: 8 CORRELATION,
        Y: 8 CORRELATION,
    }

    I601 "601" "Geometric Height Information" (compound [
        GH "Geometric Height (WGS-84)" (24 signed(0.01, "m")),
        RSGH "Geometric Height Resolution" (24 unsigned(0.01, "m")),
        SDGH "Geometric Height Precision" (24 unsigned(0.01, "m")),
        CI6 "Confidence Interval for Geometric Height (67%)" {
            UCI6: 12 unsigned(16.0, "m"),
            LCI6: 12 unsigned(16.0, "m"),
        },
        CI9 "Confidence Interval for Geometric Height (95%)" {
            UCI9: 12 unsigned(16.0, "m"),
            LCI9: 12 unsigned(16.0, "m"),
        },
        COGHHP "Correlation of Geometric Height and Horizontal Position" (XY),
        COGHHV "Correlation of Geometric Height and Horizontal Velocity" (XY),
        COGHHA "Correlation of Geometric Height and Horizontal Acceleration" (XY),
    ])

    I602 "602" "Horizontal Velocity Information" (compound [
        HV "Horizontal Velocity Vector" {
            X: 20 signed(0.01, "m/s"),
            Y: 20 signed(0.01, "m/s"),
        },
        RSHV "Horizontal Velocity Resolution" {
            X: 16 unsigned(0.01, "m/s"),
            Y: 16 unsigned(0.01, "m/s"),
            CORSHVXY: 8 CORRELATION,
        },
        SDHV "Horizontal Velocity Precision" {
            X: 16 unsigned(0.01, "m/s"),
            Y: 16 unsigned(0.01, "m/s"),
            COHVXY: 8 CORRELATION,
        },
        COHVHP "Correlation of Horizontal Velocity and Horizontal Position" {
            COHVXHPX: 8 CORRELATION,
            COHVXHPY: 8 CORRELATION,
            COHVYHPX: 8 CORRELATION,
            COHVYHPY: 8 CORRELATION,
        },
    ])

    I603 "603" "Horizontal Acceleration Information" (compound [
        HA "Horizontal Acceleration Vector" {
            X: 12 signed(1.0 / pow2(4), "m/s²"),
            Y: 12 signed(1.0 / pow2(4), "m/s²"),
        },
        SDHA "Horizontal Acceleration Precision" {
            X: 12 unsigned(1.0 / pow2(4), "m/s²"),
            Y: 12 unsigned(1.0 / pow2(4), "m/s²"),
            COHAXY: 8 CORRELATION,
        },
        COHAHP "Correlation of Horizontal Acceleration and Horizontal Position" {
            COHAXHPX: 8 CORRELATION,
            COHAXHPY: 8 CORRELATION,
            COHAYHPX: 8 CORRELATION,
            COAYHPY: 8 CORRELATION,
        },
        COHAHV "Correlation of Horizontal Acceleration and Horizontal Velocity" {
            COHAXHVX: 8 CORRELATION,
            COHAXHVY: 8 CORRELATION,
            COHAYHVX: 8 CORRELATION,
            COHAYHVY: 8 CORRELATION,
        },
    ])

    I604 "604" "Vertical Velocity Information" (compound [
        VV "Vertical Velocity" (24 signed(0.01, "m/s")),
        RSVV "Vertical Velocity Resolution" (16 unsigned(0.01, "m/s")),
        SDVV "Vertical Velocity Precision" {
            SDVV: 16 unsigned(0.01, "m/s"),
            COVVGH: 8 CORRELATION,
        },
        COVVHP "Correlation of Vertical Velocity and Horizontal Position" (XY),
        COVVHV "Correlation of Vertical Velocity and Horizontal Velocity" (XY),
        COVVHA "Correlation of Vertical Velocity and Horizontal Acceleration" (XY),
    ])

    I605 "605" "Vertical Acceleration Information" (compound [
        VA "Vertical Acceleration" (16 signed(0.01, "m/s²")),
        RSVA "Vertical Acceleration Precision" {
            SDVA: 16 unsigned(0.01, "m/s²"),
            COVAGH: 8 CORRELATION,
            COVAVV: 8 CORRELATION,
        },
        COVAHP "Correlation of Vertical Acceleration and Horizontal Position" (XY),
        COVAHV "Correlation of Vertical Acceleration and Horizontal Velocity" (XY),
        COVAHA "Correlation of Vertical Acceleration and Horizontal Acceleration" (XY),
    ])

    I625 "625" "Range Information" (compound [
        R "Range" (24 signed(0.1, "m")),
        RSR "Range Resolution" (24 unsigned(0.1, "m")),
        SDR "Range Precision" (24 unsigned(0.1, "m")),
        RR "Range Rate" (24 signed(0.1, "m/s")), // from ranges; see I015/626 for the measured one
        RSRR "Range Rate Resolution" (24 unsigned(0.1, "m/s")),
        SDRR "Range Rate Precision" {
            SDRR: 24 unsigned(0.1, "m/s"),
            CORRR: 8 CORRELATION,
        },
        RA "Range Acceleration" (16 signed(1.0 / pow2(6), "m/s²")),
        SDRA "Range Acceleration Precision" {
            SDRA: 16 unsigned(1.0 / pow2(7), "m/s²"),
            CORAR: 8 CORRELATION,
            CORARR: 8 CORRELATION,
        },
    ])

    I626 "626" "Doppler Information" (compound [
        DV "Doppler Velocity" (24 signed(0.01, "m/s")),
        SDDV "Precision of Doppler Velocity" (16 unsigned(1.0 / pow2(6), "m/s")),
        DA "Doppler Acceleration" (16 signed(1.0 / pow2(6), "m/s²")),
        SDDA "Precision of Doppler Acceleration" {
            SDDA: 16 unsigned(1.0 / pow2(6), "m/s²"),
            CODADV: 8 CORRELATION,
        },
        CODVR "Correlation of Doppler Velocity and Range" (8 CORRELATION),
        CODVRR "Correlation of Doppler Velocity and Range Rate" (8 CORRELATION),
        CODVRA "Correlation of Doppler Velocity and Range Acceleration" (8 CORRELATION),
        CODAR "Correlation of Doppler Acceleration and Range" (8 CORRELATION),
        CODARR "Correlation of Doppler Acceleration and Range Rate" (8 CORRELATION),
        CODARA "Correlation of Doppler Acceleration and Range Acceleration" (8 CORRELATION),
    ])

    I627 "627" "Azimuth Information" (compound [
        AZ "Azimuth" (16 DIRECTION), // clockwise from geographical north at the sensor
        RSAZ "Azimuth Resolution" (16 ANGLE),
        SDASZ "Standard Deviation of Azimuth" (16 ANGLE),
        AZR "Azimuth Rate" (16 ELEVATION), // per second; the document states no time
        SDAZR "Standard Deviation of Azimuth Rate" {
            SDAZR: 16 ANGLE,
            COAZRAZ: 8 CORRELATION,
        },
        AZEX "Azimuth Extent" {
            S: 16 DIRECTION, // start
            E: 16 DIRECTION, // end, clockwise
        },
    ])

    I628 "628" "Elevation Information" (compound [
        EL "Elevation" (16 ELEVATION),
        RSEL "Elevation Resolution" (16 ANGLE),
        SDEL "Standard Deviation of Elevation" (16 ANGLE),
        ER "Elevation Rate" (16 signed(180.0 / pow2(16), "°/s")),
        SDER "Standard Deviation of Elevation Rate" {
            SDELR: 16 unsigned(45.0 / pow2(16), "°/s"),
            COELREL: 8 CORRELATION,
        },
        ELEX "Elevation Extent" {
            S: 16 ELEVATION,
            E: 16 ELEVATION,
        },
    ])

    I630 "630" "Path Quality" (compound [
        DPP "Direct Path - Power" (8 signed(1.0, "dB")),
        DPS "Direct Path - Signal to Noise Ratio (SNR)" (8 signed(1.0, "dB")),
        RPP "Reflected Path - Power" {
            _: 7,
            RPP: 9 signed(1.0, "dB"),
        },
        RPS "Reflected Path - Signal to Noise Ratio (SNR)" (8 signed(1.0, "dB")),
    ])

    I631 "631" "Contour (Azimuth, Elevation Angle, Range Extent)" (repetitive {
        AZCON: 16 DIRECTION,
        ELCON: 16 ELEVATION,
        RGCONSTOP: 16 unsigned(10_000.0 / pow2(16), "m"),
        RGCONSTART: 16 unsigned(10_000.0 / pow2(16), "m"),
    })
}

#[rustfmt::skip]
const PROFILE: &[Option<Item>] = &profile![
    I010, I000, I015, I020, I030, I145, I161, // FRN  1 to  7
    I170, I050, I270, I300, I400, I600, I601, //      8 to 14
    I602, I603, I604, I605, I480, I625, I626, //     15 to 21
    I627, I628, I630, I631, SP,               //     22 to 26
];

editions! {
    CAT015 15 "Independent Non-Cooperative Surveillance System Target Reports" "EUROCONTROL-SPEC-0149-28" ["145"]
    CAT015_V1_0 1 0 PROFILE;
    CAT015_V1_1 1 1 PROFILE;
    CAT015_V1_2 1 2 PROFILE;
}
