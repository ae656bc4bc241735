//! CAT205: reports of a radio direction finder: bearings of radio transmissions, and positions of the transmitters.
//!
//! EUROCONTROL-SPEC-0149-31, ed 1.0 (March 2020). The document's summary of least significant bits has 0.1° for the
//! bearings of I205/070 and 080, the items' own definitions have 0.01°, which also fills the 16 bits.

use super::SP;
use crate::categories::SOURCE;
use crate::table::*;

items! {
    // 1 system position, 2 system bearing, 3 position of a conflicting transmission, 4 end of detection, 5 sensor data
    I000 "000" "Message Type" (8)

    I010 "010" "Data Source Identifier" (SOURCE)

    I015 "015" "Service Identification" (8) // chosen by the system
    I030 "030" "Time of Day" (24 unsigned(1.0 / pow2(7), "s"))
    I040 "040" "Report Number" (8) // cyclic; a new number for each new position or bearing

    parts GEODETIC {
        LAT: 32 signed(180.0 / pow2(25), "°"),
        LON: 32 signed(180.0 / pow2(25), "°"),
    }

    parts CARTESIAN {
        X: 24 signed(0.5, "m"), // about the system reference point
        Y: 24 signed(0.5, "m"),
    }

    // Of the transmitter; in a system bearing, of the direction finder.
    I050 "050" "Position in WGS-84 Coordinates" (GEODETIC)
    I060 "060" "Position in Cartesian Coordinates" (CARTESIAN)

    I070 "070" "Local Bearing" (16 unsigned(0.01, "°")) // from I205/050, clockwise from geographical north there
    I080 "080" "System Bearing" (16 unsigned(0.01, "°")) // from I205/060, in the plane of the reference point
    I090 "090" "Radio Channel Name" (56 ASCII) // such as 121.100; a channel's name is not always its frequency
    I100 "100" "Quality of Measurement" (8) // as the system defines
    I110 "110" "Estimated Uncertainty" (8 unsigned(100.0, "m")) // radius around the position
    I120 "120" "Contributing Sensors" (repetitive (8)) // as the system defines

    // Of a second transmitter on the same frequency at the same time.
    I130 "130" "Conflicting Transmitter Position in WGS-84 Coordinates" (GEODETIC)
    I140 "140" "Conflicting Transmitter Position in Cartesian Coordinates" (CARTESIAN)
    I150 "150" "Conflicting Transmitter Estimated Uncertainty" (8 unsigned(100.0, "m"))

    I160 "160" "Track Number" (16)
    I170 "170" "Sensor Identification" (8) // as the system defines
    I180 "180" "Signal Level" (16 signed(0.01, "dBµV"))
    I190 "190" "Signal Quality" (8) // 0 worst, 255 best
    I200 "200" "Signal Elevation" (16 signed(0.01, "°"))
}

#[rustfmt::skip]
const PROFILE: &[Option<Item>] = &profile![
    I010, I015, I000, I030, I040, I090, I050, // FRN  1 to  7
    I060, I070, I080, I100, I110, I120, I130, //      8 to 14
    I140, I150, I160, I170, I180, I190, I200, //     15 to 21
    SP,                                       //           22
];

editions! {
    CAT205 205 "Radio Direction Finder Reports" "EUROCONTROL-SPEC-0149-31" ["030"]
    CAT205_V1_0 1 0 PROFILE;
}
