//! The lines of the standards.

use super::areas::AreaKind;
use super::measures::LineMeasure::{self, *};
use super::standards::LineLimit::{self, Above, AtLeast, AtMost};
use super::standards::{StandardLine, SurveillanceStandard};

/// Registry of the standards.
pub const SURVEILLANCE_STANDARDS: [SurveillanceStandard; 5] = [
    SurveillanceStandard {
        word: "ed-87",
        title: "EUROCAE ED-87: guidance and control of movements on an airport's surface (A-SMGCS)",
        lines: &ED_87,
    },
    SurveillanceStandard {
        word: "ed-116",
        title: "EUROCAE ED-116: surface movement radar",
        lines: &ED_116,
    },
    SurveillanceStandard {
        word: "ed-117",
        title: "EUROCAE ED-117: multilateration on an airport's surface",
        lines: &ED_117,
    },
    SurveillanceStandard {
        word: "ed-142",
        title: "EUROCAE ED-142: wide-area multilateration",
        lines: &ED_142,
    },
    SurveillanceStandard {
        word: "esassp",
        title: "EUROCONTROL-SPEC-0147 (ESASSP): separation by 5 and 3 nautical miles",
        lines: &ESASSP,
    },
];

const ED_87E: &str = "ED-87E, as an open evaluation tool has it";
const ED_87C: &str = "ED-87C, table 3.1, as an open evaluation tool has it";
const OF_ED_116: &str = "ED-116, sections 3.4.2 and 3.4.12, as an open evaluation tool has them";
const OF_ED_117: &str = "ED-117, section 3.3, as an open evaluation tool has it";
const ED_117A: &str = "ED-117A, table 3-1, as an open evaluation tool has it";
const OF_ED_142: &str = "ED-142, as an open evaluation tool has it";
const OF_ESASSP: &str = "ESASSP edition 1.3, annex D, as a review of the published text quotes it";
const NONE: &str = "";

const MANOEUVRING: Option<AreaKind> = Some(AreaKind::MANOEUVRING);
const RUNWAY: Option<AreaKind> = Some(AreaKind::RUNWAY);
const TAXIWAY: Option<AreaKind> = Some(AreaKind::TAXIWAY);
const APRON: Option<AreaKind> = Some(AreaKind::APRON);
const STAND: Option<AreaKind> = Some(AreaKind::STAND);
const APPROACH: Option<AreaKind> = Some(AreaKind::APPROACH);
const OUTER_APPROACH: Option<AreaKind> = Some(AreaKind::OUTER_APPROACH);
const TERMINAL: Option<AreaKind> = Some(AreaKind::TERMINAL);
const EN_ROUTE: Option<AreaKind> = Some(AreaKind::EN_ROUTE);

const LONG: i64 = i64::MAX;
const P95: LineMeasure = PositionQuantile(0.95);
const P95_TEXT: &str = "position error that 95 % do not exceed";
const UPDATE_TEXT: &str = "share of seconds with a report";
const UPDATE_5_TEXT: &str = "share of intervals of 5 s with a report";
const RIGHT_TEXT: &str = "share of reports with the target's address";
const WRONG_TEXT: &str = "share of reported addresses that are another target's";
const SPEED_TEXT: &str = "share of speeds within 5 m/s or 10 %";
const COURSE_TEXT: &str = "error of the course that 90 % do not exceed, above 3 m/s";
const LONGEST_TEXT: &str = "longest gap between reports";
const FALSE_TRACKS_TEXT: &str = "tracks without a target of the reference, per hour";
const HEIGHT_TEXT: &str = "height error that 95 % do not exceed";
const RMS_TEXT: &str = "position error, root mean square";

const fn line(
    name: &'static str,
    area: Option<AreaKind>,
    (measure, unit, meaning): (LineMeasure, &'static str, &'static str),
    (limit, source): (Option<LineLimit>, &'static str),
) -> StandardLine {
    StandardLine {
        name,
        area,
        unit,
        meaning,
        measure,
        limit,
        source,
    }
}

const fn by(limit: LineLimit, source: &'static str) -> (Option<LineLimit>, &'static str) {
    (Some(limit), source)
}

/// No source for a limit.
const UNKNOWN: (Option<LineLimit>, &str) = (None, NONE);

const FALSE_60: (LineMeasure, &str, &str) = (
    FalseReports(60.0),
    "",
    "share of reports more than 60 m off, or (against a truth) of no target",
);
const FALSE_50: (LineMeasure, &str, &str) = (
    FalseReports(50.0),
    "",
    "share of reports more than 50 m off, or (against a truth) of no target",
);
const GAPS_3_5: (LineMeasure, &str, &str) = (Gaps(3, 5), "", "gaps of 3 to 5 s, per report");
const GAPS_3: (LineMeasure, &str, &str) = (Gaps(3, LONG), "", "gaps of 3 s or more, per report");
const GAPS_6: (LineMeasure, &str, &str) = (Gaps(6, LONG), "", "gaps of more than 5 s, per report");
const SPEED: (LineMeasure, &str, &str) = (SpeedWithin(5.0, 0.1), "", SPEED_TEXT);
const COURSE: (LineMeasure, &str, &str) = (CourseQuantile(0.9), "deg", COURSE_TEXT);
const LONGEST: (LineMeasure, &str, &str) = (LongestGap, "s", LONGEST_TEXT);
const FALSE_TRACKS: (LineMeasure, &str, &str) = (FalseTracksPerHour, "", FALSE_TRACKS_TEXT);
const RIGHT: (LineMeasure, &str, &str) = (AddressRight, "", RIGHT_TEXT);
const WRONG: (LineMeasure, &str, &str) = (AddressWrong, "", WRONG_TEXT);
const HEIGHT: (LineMeasure, &str, &str) = (HeightQuantile(0.95), "m", HEIGHT_TEXT);
const POSITION: (LineMeasure, &str, &str) = (P95, "m", P95_TEXT);
const RMS: (LineMeasure, &str, &str) = (PositionRms, "m", RMS_TEXT);
const UPDATE_1: (LineMeasure, &str, &str) = (Update(1), "", UPDATE_TEXT);
const UPDATE_2: (LineMeasure, &str, &str) = (Update(2), "", "share of intervals of 2 s with a report");
const UPDATE_5: (LineMeasure, &str, &str) = (Update(5), "", UPDATE_5_TEXT);
const UPDATE_8: (LineMeasure, &str, &str) = (Update(8), "", "share of intervals of 8 s with a report");
const P99: (LineMeasure, &str, &str) = (PositionQuantile(0.99), "m", "position error that 99 % do not exceed");

const ED_87: [StandardLine; 16] = [
    line("update_1s", MANOEUVRING, UPDATE_1, by(AtLeast(0.99), ED_87E)),
    line("position_p95", MANOEUVRING, POSITION, by(AtMost(12.0), ED_87E)),
    line("gaps_3_to_5s", MANOEUVRING, GAPS_3_5, by(AtMost(1e-3), ED_87E)),
    line("gaps_over_5s", MANOEUVRING, GAPS_6, by(AtMost(1e-6), ED_87C)),
    line("longest_gap", None, LONGEST, UNKNOWN),
    line("address_right", MANOEUVRING, RIGHT, by(AtLeast(0.999), ED_87E)),
    line("address_wrong", None, WRONG, by(AtMost(1e-4), ED_87C)),
    line("false_reports", MANOEUVRING, FALSE_60, by(AtMost(1e-4), ED_87E)),
    line("false_tracks", None, FALSE_TRACKS, UNKNOWN),
    line("speed", MANOEUVRING, SPEED, by(AtLeast(0.9), ED_87E)),
    line("course_p90", MANOEUVRING, COURSE, by(AtMost(15.0), ED_87E)),
    line("apron_update_1s", APRON, UPDATE_1, by(AtLeast(0.9), ED_87C)),
    line("apron_position_p95", APRON, POSITION, by(AtMost(20.0), ED_87C)),
    line("stand_update_5s", STAND, UPDATE_5, by(AtLeast(0.95), ED_87C)),
    line("stand_position_p95", STAND, POSITION, by(AtMost(25.0), ED_87C)),
    line("stand_address_right", STAND, RIGHT, by(AtLeast(0.98), ED_87C)),
];

const ED_116: [StandardLine; 7] = [
    line("position_p95", None, POSITION, by(AtMost(7.5), OF_ED_116)),
    line("update_1s", None, UPDATE_1, by(AtLeast(0.9), OF_ED_116)),
    line("longest_gap", None, LONGEST, UNKNOWN),
    line("false_reports", None, FALSE_60, UNKNOWN),
    line("false_tracks", None, FALSE_TRACKS, UNKNOWN),
    line("speed", None, SPEED, UNKNOWN),
    line("course_p90", None, COURSE, UNKNOWN),
];

const ED_117: [StandardLine; 16] = [
    line("position_p95", MANOEUVRING, POSITION, by(AtMost(7.5), OF_ED_117)),
    line("position_p99", MANOEUVRING, P99, by(AtMost(12.0), OF_ED_117)),
    line("update_1s", MANOEUVRING, UPDATE_1, by(AtLeast(0.95), OF_ED_117)),
    line("runway_update_2s", RUNWAY, UPDATE_2, by(AtLeast(0.999), OF_ED_117)),
    line("taxiway_update_2s", TAXIWAY, UPDATE_2, by(AtLeast(0.999), OF_ED_117)),
    line("gaps_3s", MANOEUVRING, GAPS_3, by(AtMost(1e-3), ED_117A)),
    line("longest_gap", None, LONGEST, UNKNOWN),
    line("address_right", None, RIGHT, by(AtLeast(0.999), OF_ED_117)),
    line("address_wrong", None, WRONG, by(AtMost(1e-4), ED_117A)),
    line("false_reports", None, FALSE_50, by(AtMost(1e-4), OF_ED_117)),
    line("apron_update_1s", APRON, UPDATE_1, by(AtLeast(0.7), OF_ED_117)),
    line("stand_update_1s", STAND, UPDATE_1, by(AtLeast(0.5), OF_ED_117)),
    line("stand_update_5s", STAND, UPDATE_5, by(AtLeast(0.999), OF_ED_117)),
    line("approach_update_1s", APPROACH, UPDATE_1, by(AtLeast(0.95), OF_ED_117)),
    line("approach_position_p95", APPROACH, POSITION, by(AtMost(20.0), OF_ED_117)),
    line(
        "outer_position_p95",
        OUTER_APPROACH,
        POSITION,
        by(AtMost(40.0), OF_ED_117),
    ),
];

const ED_142: [StandardLine; 8] = [
    line("terminal_position_rms", TERMINAL, RMS, by(AtMost(150.0), OF_ED_142)),
    line("en_route_position_rms", EN_ROUTE, RMS, by(AtMost(350.0), OF_ED_142)),
    line("update_5s", TERMINAL, UPDATE_5, UNKNOWN),
    line("update_8s", EN_ROUTE, UPDATE_8, UNKNOWN),
    line("longest_gap", None, LONGEST, UNKNOWN),
    line("address_right", None, RIGHT, UNKNOWN),
    line("address_wrong", None, WRONG, UNKNOWN),
    line("false_tracks", None, FALSE_TRACKS, UNKNOWN),
];

const ESASSP: [StandardLine; 12] = [
    line("5N_N-R2", EN_ROUTE, UPDATE_8, by(Above(0.9), OF_ESASSP)),
    line("5N_N-R3", EN_ROUTE, RMS, by(AtMost(500.0), OF_ESASSP)),
    line("3N_N-R2", TERMINAL, UPDATE_5, by(Above(0.9), OF_ESASSP)),
    line("3N_N-R3", TERMINAL, RMS, by(AtMost(300.0), OF_ESASSP)),
    line("longest_gap", None, LONGEST, UNKNOWN),
    line("height_p95", None, HEIGHT, UNKNOWN),
    line("velocity_rms_straight", None, VELOCITY_STRAIGHT, UNKNOWN),
    line("velocity_rms_turn", None, VELOCITY_TURN, UNKNOWN),
    line("course_p90", None, COURSE, UNKNOWN),
    line("address_right", None, RIGHT, UNKNOWN),
    line("address_wrong", None, WRONG, UNKNOWN),
    line("false_tracks", None, FALSE_TRACKS, UNKNOWN),
];

const VELOCITY_STRAIGHT: (LineMeasure, &str, &str) = (
    VelocityRms("straight"),
    "m/s",
    "error of the velocity in straight flight, root mean square",
);
const VELOCITY_TURN: (LineMeasure, &str, &str) = (
    VelocityRms("turn"),
    "m/s",
    "error of the velocity in turns, root mean square",
);

/// Returns the standard with this name.
pub fn surveillance_standard(word: &str) -> Option<&'static SurveillanceStandard> {
    SURVEILLANCE_STANDARDS.iter().find(|standard| standard.word == word)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limits_are_those_of_the_sources() {
        let limits: Vec<String> = SURVEILLANCE_STANDARDS
            .iter()
            .flat_map(|standard| {
                let with_limit = standard.lines.iter().filter_map(|line| Some((line, line.limit?)));
                with_limit
                    .map(|(line, limit)| format!("{} {} {} {}", standard.word, line.name, limit.sign(), limit.value()))
            })
            .collect();
        let expected = "\
ed-87 update_1s >= 0.99
ed-87 position_p95 <= 12
ed-87 gaps_3_to_5s <= 0.001
ed-87 gaps_over_5s <= 0.000001
ed-87 address_right >= 0.999
ed-87 address_wrong <= 0.0001
ed-87 false_reports <= 0.0001
ed-87 speed >= 0.9
ed-87 course_p90 <= 15
ed-87 apron_update_1s >= 0.9
ed-87 apron_position_p95 <= 20
ed-87 stand_update_5s >= 0.95
ed-87 stand_position_p95 <= 25
ed-87 stand_address_right >= 0.98
ed-116 position_p95 <= 7.5
ed-116 update_1s >= 0.9
ed-117 position_p95 <= 7.5
ed-117 position_p99 <= 12
ed-117 update_1s >= 0.95
ed-117 runway_update_2s >= 0.999
ed-117 taxiway_update_2s >= 0.999
ed-117 gaps_3s <= 0.001
ed-117 address_right >= 0.999
ed-117 address_wrong <= 0.0001
ed-117 false_reports <= 0.0001
ed-117 apron_update_1s >= 0.7
ed-117 stand_update_1s >= 0.5
ed-117 stand_update_5s >= 0.999
ed-117 approach_update_1s >= 0.95
ed-117 approach_position_p95 <= 20
ed-117 outer_position_p95 <= 40
ed-142 terminal_position_rms <= 150
ed-142 en_route_position_rms <= 350
esassp 5N_N-R2 > 0.9
esassp 5N_N-R3 <= 500
esassp 3N_N-R2 > 0.9
esassp 3N_N-R3 <= 300";
        assert_eq!(limits.join("\n"), expected);
    }

    #[test]
    fn a_limit_has_a_source_and_each_line_a_name_of_its_own() {
        for standard in &SURVEILLANCE_STANDARDS {
            assert_eq!(surveillance_standard(standard.word), Some(standard));
            let mut names: Vec<&str> = standard.lines.iter().map(|line| line.name).collect();
            names.sort_unstable();
            names.dedup();
            assert_eq!(names.len(), standard.lines.len(), "{}", standard.word);
            for line in standard.lines {
                assert_eq!(line.limit.is_some(), !line.source.is_empty(), "{}", line.name);
            }
        }
    }
}
