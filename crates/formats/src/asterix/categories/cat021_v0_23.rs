//! CAT021 ed 0.23: ADS-B target reports, the edition of November 2003 that many ground stations still send.
//!
//! EUROCONTROL SUR.ET1.ST05.2000-STD-12-01 (today EUROCONTROL-SPEC-0149-12), ed 0.23. Its items are in another
//! order than those of edition 1 and later, and nothing in a block tells the two apart: the receiver must know its
//! sender.

use crate::asterix::table::Layout::{Compound, Element, Explicit, Extended, Group, Repetitive};
use crate::asterix::table::*;

const ITEMS: &[Item] = &[
    Item::new(
        "010",
        "Data Source Identification",
        Group(&[
            element("SAC", 8, RAW), // system area code
            element("SIC", 8, RAW), // system identification code
        ]),
    ),
    Item::new("020", "Emitter Category", Element(8, RAW)), // 1 light … 5 heavy, 10 rotorcraft, 20 and 21 vehicles
    Item::new("030", "Time of Day", Element(24, unsigned(1.0 / pow2(7), "s"))), // of applicability of the position
    Item::new("032", "Time of Day Accuracy", Element(8, unsigned(1.0 / pow2(8), "s"))), // largest error of I021/030
    Item::new(
        "040",
        "Target Report Descriptor",
        Group(&[
            flag("DCR"), // differential correction
            flag("GBS"), // ground bit set
            flag("SIM"), // simulated
            flag("TST"), // test target
            flag("RAB"), // from a field monitor, a fixed transponder
            flag("SAA"), // 1 not able to provide selected altitude
            flag("SPI"), // special position identification
            spare(1),
            element("ATP", 3, RAW), // address: 0 not unique, 1 ICAO, 2 surface vehicle, 3 anonymous
            element("ARC", 2, RAW), // altitude in steps of: 0 unknown, 1 25 ft, 2 100 ft
            spare(3),
        ]),
    ),
    Item::new("080", "Target Address", Element(24, RAW)),
    Item::new(
        "090",
        "Figure of Merit",
        Group(&[
            element("AC", 2, RAW), // ACAS: 0 unknown, 1 not operational, 2 operational
            element("MN", 2, RAW), // multiple navigation aids: 0 unknown, 1 not operational, 2 operational
            element("DC", 2, RAW), // differential correction: 0 unknown, 1 yes, 2 no
            spare(6),
            // Navigational uncertainty category for position, 0 to 9. The machine-readable definition in wide use has it
            // signed, which would make 8 and 9 negative.
            element("PA", 4, RAW),
        ]),
    ),
    Item::new("095", "Velocity Accuracy", Element(8, RAW)), // navigational uncertainty category for velocity
    Item::new(
        "110",
        "Trajectory Intent",
        Compound(&[
            Some(Item::new(
                "TIS",
                "Trajectory Intent Status",
                Extended(&[&[
                    flag("NAV"), // 1 not available
                    flag("NVB"), // 1 not valid
                    spare(5),
                ]]),
            )),
            Some(Item::new(
                "TID",
                "Trajectory Intent Data",
                Repetitive(&Group(&[
                    flag("TCA"),             // 1 number of the change point not available
                    flag("NC"),              // 1 the aircraft will not fly this path
                    element("TCPN", 6, RAW), // number of the change point
                    element("ALT", 16, signed(10.0, "ft")),
                    element("LAT", 24, signed(180.0 / pow2(23), "°")),
                    element("LON", 24, signed(180.0 / pow2(23), "°")),
                    element("PT", 4, RAW), // kind of point: 1 fly by, 2 fly over, … 7 top of climb, …
                    element("TD", 2, RAW), // turn: 1 right, 2 left, 3 none
                    flag("TRA"),           // turn radius available
                    flag("TOA"),           // 1 time over point not available
                    element("TOV", 24, unsigned(1.0, "s")), // time over point, since midnight
                    element("TTR", 16, unsigned(0.01, "NM")), // turn radius
                ])),
            )),
        ]),
    ),
    Item::new(
        "130",
        "Position in WGS-84 Co-ordinates",
        Group(&[
            element("LAT", 24, signed(180.0 / pow2(23), "°")),
            element("LON", 24, signed(180.0 / pow2(23), "°")),
        ]),
    ),
    Item::new("140", "Geometric Altitude", Element(16, signed(6.25, "ft"))),
    Item::new("145", "Flight Level", Element(16, signed(1.0 / pow2(2), "FL"))),
    Item::new(
        "146",
        "Intermediate State Selected Altitude",
        Group(&[
            flag("SAS"),            // source given
            element("SRC", 2, RAW), // 0 unknown, 1 aircraft altitude, 2 MCP/FCU, 3 FMS
            element("ALT", 13, signed(25.0, "ft")),
        ]),
    ),
    Item::new(
        "148",
        "Final State Selected Altitude",
        Group(&[
            flag("MV"), // manage vertical mode active
            flag("AH"), // altitude hold mode active
            flag("AM"), // approach mode active
            element("ALT", 13, signed(25.0, "ft")),
        ]),
    ),
    Item::new(
        "150",
        "Air Speed",
        Group(&[
            flag("IM"), // 0 indicated air speed, 1 Mach number
            element(
                "AS",
                15,
                Content::Depends {
                    on: "IM",
                    cases: &[(0, unsigned(1.0 / pow2(14), "NM/s")), (1, unsigned(0.001, "Mach"))],
                    otherwise: &RAW,
                },
            ),
        ]),
    ),
    Item::new("151", "True Airspeed", Element(16, unsigned(1.0, "kt"))),
    Item::new("152", "Magnetic Heading", Element(16, unsigned(360.0 / pow2(16), "°"))),
    Item::new("155", "Barometric Vertical Rate", Element(16, signed(6.25, "ft/min"))),
    Item::new("157", "Geometric Vertical Rate", Element(16, signed(6.25, "ft/min"))),
    Item::new(
        "160",
        "Ground Vector",
        Group(&[
            element("GS", 16, signed(1.0 / pow2(14), "NM/s")),
            element("TA", 16, unsigned(360.0 / pow2(16), "°")),
        ]),
    ),
    Item::new(
        "165",
        "Rate Of Turn",
        Extended(&[
            &[
                element("TI", 2, RAW), // 0 not available, 1 left, 2 right, 3 straight
                spare(5),
            ],
            &[element("ROT", 7, signed(1.0 / pow2(2), "°/s"))], // positive to the right
        ]),
    ),
    Item::new("170", "Target Identification", Element(48, ICAO)),
    Item::new("200", "Target Status", Element(8, RAW)), // 0 no emergency, 5 unlawful interference
    Item::new(
        "210",
        "Link Technology Indicator",
        Group(&[
            spare(3),
            flag("DTI"), // cockpit display of traffic information
            flag("MDS"), // Mode S extended squitter
            flag("UAT"),
            flag("VDL"), // VDL Mode 4
            flag("OTR"), // other
        ]),
    ),
    Item::new(
        "220",
        "Met Information",
        Compound(&[
            Some(Item::new("WS", "Wind Speed", Element(16, unsigned(1.0, "kt")))),
            Some(Item::new("WD", "Wind Direction", Element(16, unsigned(1.0, "°")))),
            Some(Item::new(
                "TMP",
                "Temperature",
                Element(16, signed(1.0 / pow2(2), "°C")),
            )),
            Some(Item::new("TRB", "Turbulence", Element(8, NUMBER))), // 0 to 15
        ]),
    ),
    Item::new("230", "Roll Angle", Element(16, signed(0.01, "°"))), // negative: left wing down
    Item::new("RE", "Reserved Expansion Field", Explicit),
    Item::new("SP", "Special Purpose Field", Explicit),
];

#[rustfmt::skip]
const ORDER: &[&str] = &[
    "010", "040", "030", "130", "080", "140", "090", // FRN  1 to  7
    "210", "230", "145", "150", "151", "152", "155", //      8 to 14
    "157", "160", "165", "170", "095", "032", "200", //     15 to 21
    "020", "220", "146", "148", "110", SPARE, SPARE, //     22 to 28
    SPARE, SPARE, SPARE, SPARE, SPARE, "RE", "SP",   //     29 to 35
];

pub(crate) const UAP: Uap = Uap::new(ITEMS, ORDER);

/// ADS-B target reports, ed 0.23.
pub static CAT021_V0_23: Category = Category {
    number: 21,
    edition: Edition::new(0, 23),
    title: "ADS-B Target Reports",
    document: "EUROCONTROL SUR.ET1.ST05.2000-STD-12-01",
    items: ITEMS,
    profile: Profile::Single(UAP),
};
