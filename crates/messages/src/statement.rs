//! What a target states beside its motion.
//!
//! A report carries position, velocity and identity. Category, size, status and intention change seldom, so they are
//! samples of their own, published when some of it changes, and joined to a report by source and track number.
//!
//! Stations that are no targets have statements only: base stations and aids to navigation, with their places.

use crate::StageTimes;
use crate::codes;
use crate::codes::bits;
use crate::identity::unpadded;
use crate::layout::sample;

codes! {
    /// Category of a target, as the target states it.
    pub enum TargetCategory: u8, default Unknown {
        /// Nothing is stated.
        Unknown = 0, "unknown";
        /// Aircraft below 7,031 kg (15,500 lb).
        Light = 1, "light";
        /// Aircraft from 7,031 kg to 34,019 kg (75,000 lb).
        Small = 2, "small";
        /// Aircraft from 34,019 kg to 136,078 kg (300,000 lb).
        Large = 3, "large";
        /// Aircraft with a strong wake vortex.
        HighVortex = 4, "high-vortex";
        /// Aircraft above 136,078 kg.
        Heavy = 5, "heavy";
        /// Aircraft with an acceleration above 5 g and a speed above 400 knots.
        HighPerformance = 6, "high-performance";
        /// Helicopter or gyroplane.
        Rotorcraft = 7, "rotorcraft";
        /// Glider or sailplane.
        Glider = 8, "glider";
        /// Balloon or airship.
        LighterThanAir = 9, "lighter-than-air";
        /// Parachutist or skydiver.
        Parachutist = 10, "parachutist";
        /// Ultralight, hang glider or paraglider.
        Ultralight = 11, "ultralight";
        /// Unmanned aircraft.
        Unmanned = 12, "unmanned";
        /// Space vehicle.
        Space = 13, "space";
        /// Emergency vehicle on the ground.
        EmergencyVehicle = 20, "emergency-vehicle";
        /// Service vehicle on the ground.
        ServiceVehicle = 21, "service-vehicle";
        /// Obstacle, fixed or moored.
        Obstacle = 22, "obstacle";
        /// Ship of a kind without a word of its own.
        Ship = 30, "ship";
        /// Wing in ground effect.
        WingInGround = 31, "wing-in-ground";
        /// Fishing vessel.
        Fishing = 32, "fishing";
        /// Vessel that tows.
        Towing = 33, "towing";
        /// Vessel engaged in dredging or underwater work.
        Dredging = 34, "dredging";
        /// Vessel engaged in diving.
        Diving = 35, "diving";
        /// Vessel engaged in military operations.
        Military = 36, "military";
        /// Sailing vessel.
        Sailing = 37, "sailing";
        /// Pleasure craft.
        Pleasure = 38, "pleasure";
        /// High-speed craft.
        HighSpeed = 39, "high-speed";
        /// Pilot vessel.
        Pilot = 40, "pilot";
        /// Search and rescue vessel, or aircraft with an MMSI.
        Rescue = 41, "rescue";
        /// Tug.
        Tug = 42, "tug";
        /// Port tender.
        Tender = 43, "tender";
        /// Vessel with anti-pollution facilities.
        AntiPollution = 44, "anti-pollution";
        /// Law enforcement vessel.
        LawEnforcement = 45, "law-enforcement";
        /// Medical transport.
        Medical = 46, "medical";
        /// Passenger ship.
        Passenger = 47, "passenger";
        /// Cargo ship.
        Cargo = 48, "cargo";
        /// Tanker.
        Tanker = 49, "tanker";
        /// Aid to navigation.
        Aid = 60, "aid";
        /// Base station ashore.
        BaseStation = 61, "base-station";
        /// Search and rescue transmitter (AIS-SART, MMSI 970…).
        RescueTransmitter = 62, "rescue-transmitter";
        /// Man overboard device (MMSI 972…).
        ManOverboard = 63, "man-overboard";
        /// Emergency position-indicating radio beacon (MMSI 974…).
        RescueBeacon = 64, "rescue-beacon";
    }
}

codes! {
    /// Navigation status of a ship: the values of recommendation ITU-R M.1371, each plus one.
    pub enum NavigationStatus: u8, default Unknown {
        /// Nothing is stated.
        Unknown = 0, "unknown";
        /// Under way using engine.
        Engine = 1, "engine";
        /// At anchor.
        Anchored = 2, "anchored";
        /// Not under command.
        NotUnderCommand = 3, "not-under-command";
        /// Restricted manoeuvrability.
        Restricted = 4, "restricted";
        /// Constrained by the draught.
        Constrained = 5, "constrained";
        /// Moored.
        Moored = 6, "moored";
        /// Aground.
        Aground = 7, "aground";
        /// Engaged in fishing.
        Fishing = 8, "fishing";
        /// Under way sailing.
        Sailing = 9, "sailing";
        /// Active transmitter of search and rescue: AIS-SART, man overboard or beacon.
        Rescue = 15, "rescue";
    }
}

codes! {
    /// Emergency that a target states.
    pub enum Emergency: u8, default Unknown {
        /// Nothing is stated.
        Unknown = 0, "unknown";
        /// No emergency.
        None = 1, "none";
        /// General emergency.
        General = 2, "general";
        /// Medical emergency.
        Medical = 3, "medical";
        /// Minimum fuel.
        MinimumFuel = 4, "minimum-fuel";
        /// No communication.
        NoCommunication = 5, "no-communication";
        /// Unlawful interference.
        UnlawfulInterference = 6, "unlawful-interference";
        /// Downed aircraft.
        Downed = 7, "downed";
        /// Distress at sea.
        Distress = 8, "distress";
    }
}

codes! {
    /// Kind of an aid to navigation: the numbers of recommendation ITU-R M.1371.
    pub enum AidKind: u8, default Unknown {
        /// Nothing is stated.
        Unknown = 0, "unknown";
        /// Reference point.
        ReferencePoint = 1, "reference-point";
        /// Radar beacon.
        Racon = 2, "racon";
        /// Fixed structure off shore: oil platform, wind farm.
        Structure = 3, "structure";
        /// Emergency wreck marking buoy.
        Wreck = 4, "wreck";
        /// Light without sectors.
        Light = 5, "light";
        /// Light with sectors.
        SectorLight = 6, "sector-light";
        /// Front leading light.
        FrontLight = 7, "front-light";
        /// Rear leading light.
        RearLight = 8, "rear-light";
        /// Beacon, cardinal north.
        NorthBeacon = 9, "north-beacon";
        /// Beacon, cardinal east.
        EastBeacon = 10, "east-beacon";
        /// Beacon, cardinal south.
        SouthBeacon = 11, "south-beacon";
        /// Beacon, cardinal west.
        WestBeacon = 12, "west-beacon";
        /// Beacon, port hand.
        PortBeacon = 13, "port-beacon";
        /// Beacon, starboard hand.
        StarboardBeacon = 14, "starboard-beacon";
        /// Beacon, preferred channel port hand.
        PreferredPortBeacon = 15, "preferred-port-beacon";
        /// Beacon, preferred channel starboard hand.
        PreferredStarboardBeacon = 16, "preferred-starboard-beacon";
        /// Beacon, isolated danger.
        DangerBeacon = 17, "danger-beacon";
        /// Beacon, safe water.
        SafeWaterBeacon = 18, "safe-water-beacon";
        /// Beacon, special mark.
        SpecialBeacon = 19, "special-beacon";
        /// Floating mark, cardinal north.
        NorthMark = 20, "north-mark";
        /// Floating mark, cardinal east.
        EastMark = 21, "east-mark";
        /// Floating mark, cardinal south.
        SouthMark = 22, "south-mark";
        /// Floating mark, cardinal west.
        WestMark = 23, "west-mark";
        /// Floating mark, port hand.
        PortMark = 24, "port-mark";
        /// Floating mark, starboard hand.
        StarboardMark = 25, "starboard-mark";
        /// Floating mark, preferred channel port hand.
        PreferredPortMark = 26, "preferred-port-mark";
        /// Floating mark, preferred channel starboard hand.
        PreferredStarboardMark = 27, "preferred-starboard-mark";
        /// Floating mark, isolated danger.
        DangerMark = 28, "danger-mark";
        /// Floating mark, safe water.
        SafeWaterMark = 29, "safe-water-mark";
        /// Floating mark, special.
        SpecialMark = 30, "special-mark";
        /// Light vessel, large navigational buoy, or rig.
        LightVessel = 31, "light-vessel";
    }
}

bits! {
    /// Bits of [`TargetStatement::valid`].
    target_statement_bits: u8 {
        /// `length_m` and `width_m` hold a size.
        SIZE = 1;
        /// `selected_altitude_m` holds an altitude.
        SELECTED_ALTITUDE = 1 << 1;
        /// `place_deg` holds the place of the operator of an unmanned aircraft.
        OPERATOR = 1 << 2;
        /// The sample is of a station that is no target: `place_deg` holds its own place, `name` its name.
        STATION = 1 << 3;
        /// The aid to navigation is not there: a station ashore sends for it.
        VIRTUAL = 1 << 4;
        /// The aid to navigation, which floats, is off its position.
        OFF_POSITION = 1 << 5;
    }
}

sample! {
    /// What a target, or a station that is none, has stated beside motion: all that is known at the publication.
    TargetStatement, size 112 {
        /// Time of the target's latest transmission, UTC, nanoseconds since 1970.
        time_ns: i64,
        /// The sample's sequence number at its publisher.
        sequence: u64,
        /// Stages passed so far.
        stages: StageTimes,
        /// Latitude and longitude (WGS-84), degrees: of the operator of an unmanned aircraft, or of a station itself.
        place_deg: [f64; 2],
        /// Length, metres.
        length_m: f32,
        /// Width, metres.
        width_m: f32,
        /// Altitude selected in the autopilot, metres of the standard atmosphere.
        selected_altitude_m: f32,
        /// Number of the target's track at its source; of a station, the number of its transponder.
        track_number: u32,
        /// Source: its number in the configuration (TI-2).
        source: u16,
        /// Category: a `TargetCategory` code.
        category: u8,
        /// Navigation status: a `NavigationStatus` code.
        navigation: u8,
        /// Emergency: an `Emergency` code.
        emergency: u8,
        /// Fields that hold something, and flags: see `target_statement_bits`.
        valid: u8,
        /// Kind of the aid to navigation: an `AidKind` code.
        aid: u8,
        /// Name of a station in ASCII, padded with blanks; blank: none is known.
        name: [u8; 20],
        /// Reserved, 0.
        reserved: [u8; 5],
    }
}

impl TargetStatement {
    /// Returns whether the sample is of a station that is no target.
    pub fn is_station(&self) -> bool {
        self.valid & target_statement_bits::STATION != 0
    }

    /// Returns the name of a station without padding, if known.
    pub fn station_name(&self) -> Option<&str> {
        unpadded(&self.name).filter(|name| self.is_station() && !name.is_empty())
    }
}
