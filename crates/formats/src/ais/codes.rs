//! Numbers of stations, and codes of ships: what each stands for.
//!
//! Sources: recommendations ITU-R M.585-9 (numbers) and M.1371-5 (navigation status, types of ships and cargo).

use observations::{NavigationStatus, TargetCategory};

/// Least number of a station: a coast station, 00 and the least country code, 201.
const MMSI_MIN: u32 = 2_010_000;
/// Greatest number of nine digits.
const MMSI_MAX: u32 = 999_999_999;
/// Numbers that makers and testers set, so that many stations share them.
const PLACEHOLDERS: [u32; 3] = [111_111_111, 123_456_789, 999_999_999];

/// Whether a station may have the number. The default of many transponders, 1193046 (hexadecimal 123456), is too small.
pub(super) fn is_station(mmsi: u32) -> bool {
    (MMSI_MIN..=MMSI_MAX).contains(&mmsi) && !PLACEHOLDERS.contains(&mmsi)
}

/// Category that a number states by its first digits; `Unknown` of a ship's.
pub(super) fn category_of_number(mmsi: u32) -> TargetCategory {
    match mmsi {
        0..=9_999_999 => TargetCategory::BaseStation,
        111_000_000..=111_999_999 => TargetCategory::Rescue,
        970_000_000..=970_999_999 => TargetCategory::RescueTransmitter,
        972_000_000..=972_999_999 => TargetCategory::ManOverboard,
        974_000_000..=974_999_999 => TargetCategory::RescueBeacon,
        990_000_000..=999_999_999 => TargetCategory::Aid,
        _ => TargetCategory::Unknown,
    }
}

/// Whether a station of the category transmits only in distress or under test.
pub(super) fn is_distress_device(category: TargetCategory) -> bool {
    use TargetCategory::{ManOverboard, RescueBeacon, RescueTransmitter};
    matches!(category, RescueTransmitter | ManOverboard | RescueBeacon)
}

/// Whether the number is of a craft associated with a parent ship: 98MIDxxxx.
pub(super) fn is_auxiliary_craft(mmsi: u32) -> bool {
    mmsi / 10_000_000 == 98
}

/// Category of a type of ship and cargo, 0 to 255. Types without a meaning of their own are unknown.
pub(super) fn category_of_type(ship_type: u8) -> TargetCategory {
    match ship_type {
        20..=29 => TargetCategory::WingInGround,
        30 => TargetCategory::Fishing,
        31 | 32 => TargetCategory::Towing,
        33 => TargetCategory::Dredging,
        34 => TargetCategory::Diving,
        35 => TargetCategory::Military,
        36 => TargetCategory::Sailing,
        37 => TargetCategory::Pleasure,
        40..=49 => TargetCategory::HighSpeed,
        50 => TargetCategory::Pilot,
        51 => TargetCategory::Rescue,
        52 => TargetCategory::Tug,
        53 => TargetCategory::Tender,
        54 => TargetCategory::AntiPollution,
        55 => TargetCategory::LawEnforcement,
        58 => TargetCategory::Medical,
        60..=69 => TargetCategory::Passenger,
        70..=79 => TargetCategory::Cargo,
        80..=89 => TargetCategory::Tanker,
        // Local vessels, ships of states that are no parties to a conflict, other ships.
        56 | 57 | 59 | 90..=99 => TargetCategory::Ship,
        _ => TargetCategory::Unknown,
    }
}

/// Navigation status of the code 0 to 15. Reserved codes, which some regions use, are unknown.
pub(super) fn navigation_status(code: u8) -> NavigationStatus {
    match code {
        0..=8 | 14 => NavigationStatus::from_code(code + 1).unwrap_or_default(),
        _ => NavigationStatus::Unknown,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_of_stations_or_of_none() {
        for (mmsi, category) in [
            (2_010_000, TargetCategory::BaseStation),
            (111_232_506, TargetCategory::Rescue),
            (211_234_560, TargetCategory::Unknown),
            (970_010_001, TargetCategory::RescueTransmitter),
            (971_000_000, TargetCategory::Unknown),
            (972_000_001, TargetCategory::ManOverboard),
            (974_000_001, TargetCategory::RescueBeacon),
            (982_111_234, TargetCategory::Unknown),
            (992_111_840, TargetCategory::Aid),
        ] {
            assert!(is_station(mmsi), "{mmsi}");
            assert_eq!(category_of_number(mmsi), category, "{mmsi}");
        }
        for mmsi in [
            0,
            1,
            1_193_046,
            2_009_999,
            123_456_789,
            999_999_999,
            1_000_000_000,
            (1 << 30) - 1,
        ] {
            assert!(!is_station(mmsi), "{mmsi}");
        }
        assert!(is_auxiliary_craft(982_111_234) && !is_auxiliary_craft(992_111_840));
    }

    #[test]
    fn codes_have_the_words_of_the_recommendation() {
        assert_eq!(navigation_status(0), NavigationStatus::Engine);
        assert_eq!(navigation_status(5), NavigationStatus::Moored);
        assert_eq!(navigation_status(8), NavigationStatus::Sailing);
        assert_eq!(navigation_status(14), NavigationStatus::Rescue);
        for code in [9, 10, 11, 12, 13, 15] {
            assert_eq!(navigation_status(code), NavigationStatus::Unknown);
        }
        assert_eq!(category_of_type(36), TargetCategory::Sailing);
        assert_eq!(category_of_type(70), TargetCategory::Cargo);
        for ship_type in [0, 19, 38, 39, 100, 199, 255] {
            assert_eq!(category_of_type(ship_type), TargetCategory::Unknown);
        }
    }
}
