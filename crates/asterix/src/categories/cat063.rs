//! CAT063: state and biases of the sensors of a surveillance data processing system.
//!
//! EUROCONTROL-SPEC-0149-10, ed 1.6 and 1.7 (June 2025), which adds a part to I063/060.

use super::{RE, SP};
use crate::categories::SOURCE;
use crate::table::*;

items! {
    I010 "010" "Data Source Identifier" (SOURCE)

    I015 "015" "Service Identification" (8) // chosen by the system
    I030 "030" "Time of Message" (24 unsigned(1.0 / pow2(7), "s"))

    I050 "050" "Sensor Identifier" (SOURCE)

    parts I060_PART_1 {
        CON: 2, // 0 operational, 1 degraded, 2 initialising, 3 not connected
        PSR: 1, // this and the next four: 1 not operational
        SSR: 1,
        MDS: 1,
        ADS: 1,
        MLT: 1,
    }

    parts I060_PART_2 {
        OPS: 1, // 1 not to be used operationally
        ODP: 1, // data processor overloaded
        OXT: 1, // transmission overloaded
        MSC: 1, // monitoring system disconnected
        TSV: 1, // time source invalid
        NPW: 1, // no plots being received
        _: 1,
    }

    I060 "060" "Sensor Configuration and Status" [I060_PART_1 I060_PART_2]

    I060_V1_7 "060" "Sensor Configuration and Status" [
        I060_PART_1
        I060_PART_2
        {
            TTF: { EP: 1, VAL: 1 }, // test target failure
            SPO: { EP: 1, VAL: 1 }, // possible spoofing
            _: 3,
        }
    ]

    I070 "070" "Time Stamping Bias" (16 signed(1.0, "ms"))

    I080 "080" "SSR / Mode S Range Gain and Bias" {
        SRG: 16 signed(0.000_01, ""),
        SRB: 16 signed(1.0 / pow2(7), "NM"),
    }

    I081 "081" "SSR Mode S Azimuth Bias" (16 signed(360.0 / pow2(16), "°"))

    I090 "090" "PSR Range Gain and Bias" {
        PRG: 16 signed(0.000_01, ""),
        PRB: 16 signed(1.0 / pow2(7), "NM"),
    }

    I091 "091" "PSR Azimuth Bias" (16 signed(360.0 / pow2(16), "°"))
    I092 "092" "PSR Elevation Bias" (16 signed(360.0 / pow2(16), "°"))
}

/// The items by field reference number; those passed are not the same in all editions.
#[rustfmt::skip]
const fn profile(i060: Item) -> [Option<Item>; 14] {
    profile![
        I010, I015, I030, I050, i060, I070, I080, // FRN  1 to  7
        I081, I090, I091, I092, _, RE, SP,        //      8 to 14
    ]
}

editions! {
    CAT063 63 "Sensor Status Reports" "EUROCONTROL-SPEC-0149-10" ["030"]
    CAT063_V1_6 1 6 &profile(I060);
    CAT063_V1_7 1 7 &profile(I060_V1_7);
}
