//! CAT065: service messages of a surveillance data processing system.
//!
//! EUROCONTROL-SPEC-0149-15, ed 1.4 to 1.6 (March 2023). Their layouts are the same; later editions added codes.

use super::{RE, SP};
use crate::categories::SOURCE;
use crate::table::*;

items! {
    // 1 system status, 2 end of batch, 3 service status
    I000 "000" "Message Type" (8)

    I010 "010" "Data Source Identifier" (SOURCE)

    I015 "015" "Service Identification" (8) // chosen by the system
    I020 "020" "Batch Number" (8 NUMBER)
    I030 "030" "Time of Message" (24 unsigned(1.0 / pow2(7), "s"))

    I040 "040" "SDPS Configuration and Status" {
        NOGO: 2, // 0 operational, 1 degraded, 2 not connected, 3 unknown
        OVL: 1,  // overload
        TSV: 1,  // time source invalid
        PSS: 2,  // processing system: 1, 2 or 3
        STTN: 1, // flips whenever tracks are numbered anew
        _: 1,
    }

    // 1 degradation, 2 its end, 3 main radar out of service, 4 to 8 interruption and restart, …
    I050 "050" "Service Status Report" (8)
}

/// The items by field reference number.
#[rustfmt::skip]
const PROFILE: &[Option<Item>] = &profile![
    I010, I000, I015, I030, I020, I040, I050, // FRN  1 to  7
    _, _, _, _, _, RE, SP,                    //      8 to 14
];

editions! {
    CAT065 65 "SDPS Service Status Reports" "EUROCONTROL-SPEC-0149-15" ["030"]
    CAT065_V1_4 1 4 PROFILE;
    CAT065_V1_5 1 5 PROFILE;
    CAT065_V1_6 1 6 PROFILE;
}
