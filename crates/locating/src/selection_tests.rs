//! Every transition of EL-4 … EL-10, with fixes made by hand.

use super::*;

const LIMIT: f64 = 100.0;
const BELOW: f64 = 50.0;
const ABOVE: f64 = 200.0;

fn settings(select: Select, above: AboveThreshold) -> SelectionSettings {
    SelectionSettings {
        select,
        position_sigma_max_m: LIMIT.sqrt(),
        interval_s: 10.0,
        above_threshold: above,
        minimum_rise: 0.0,
        minimum_gap_s: 0.0,
        settled_minima: 2,
        minimum_wait_s: 30.0,
        steering_s: 10.0,
        ..SelectionSettings::default()
    }
}

fn fix(time_s: f64, [x, y]: [f64; 2], variance_m2: f64) -> Fix {
    Fix {
        time_s,
        position_m: [x, y, 7.0],
        velocity_mps: [0.5, 0.25, 0.0],
        variance_m2,
        direction_rad: None,
    }
}

/// Outputs for fixes (time, place, variance); between two rows the output must move by its own velocity.
fn run(selector: &mut Selector, fixes: &[(f64, [f64; 2], f64)]) -> Vec<Output> {
    let mut outputs: Vec<(f64, Output)> = Vec::new();
    for (time_s, place, variance) in fixes {
        let output = selector.fix(&fix(*time_s, *place, *variance)).unwrap();
        if let Some((before_s, before)) = outputs.last() {
            let is_line = !matches!(before.stage, SelectionStage::Passing | SelectionStage::First);
            for axis in 0..3 {
                let expected = before.position_m[axis] + before.velocity_mps[axis] * (time_s - before_s);
                let jump = (output.position_m[axis] - expected).abs();
                assert!(!is_line || jump < 1e-9, "a jump of {jump} m at {time_s} s");
            }
        }
        outputs.push((*time_s, output));
    }
    outputs.into_iter().map(|(_, output)| output).collect()
}

fn place(output: &Output) -> [f64; 2] {
    [output.position_m[0], output.position_m[1]]
}

fn reason(output: &Output) -> Option<SelectionReason> {
    output.decision.map(|(reason, ..)| reason)
}

/// Selected at t = 10, 20, 30, 40 at (0,0), (10,0), (20,2), (30,3).
const CHECKED: [(f64, [f64; 2], f64); 4] = [
    (10.0, [0.0, 0.0], BELOW),
    (20.0, [10.0, 0.0], BELOW),
    (30.0, [20.0, 2.0], BELOW),
    (40.0, [30.0, 3.0], BELOW),
];

#[test]
fn the_worked_check_holds_exactly() {
    let mut selector = Selector::new(settings(Select::Interval, AboveThreshold::Continue));
    let outputs = run(&mut selector, &CHECKED);
    assert_eq!(place(&outputs[2]), [20.0, 0.0], "P3");
    assert_eq!(place(&outputs[3]), [30.0, 2.0], "P4");
    let outputs = run(
        &mut selector,
        &[(50.0, [99.0, 99.0], ABOVE), (60.0, [50.0, 8.0], BELOW)],
    );
    assert_eq!(place(&outputs[0]), [40.0, 5.0], "P5");
    assert_eq!(reason(&outputs[0]), Some(SelectionReason::HeldAbove));
    assert!(!outputs[0].is_selected);
    assert_eq!(place(&outputs[1]), [50.0, 8.0], "P6");
    assert_eq!(outputs[1].position_m[2], 7.0, "height is carried along");
}

#[test]
fn between_selections_the_output_is_a_line_and_other_fixes_do_not_matter() {
    let mut selector = Selector::new(settings(Select::Interval, AboveThreshold::Continue));
    run(&mut selector, &CHECKED[..2]);
    let outputs = run(
        &mut selector,
        &[(22.5, [-500.0, 70.0], BELOW), (27.5, [800.0, 1.0], ABOVE)],
    );
    assert_eq!([place(&outputs[0]), place(&outputs[1])], [[12.5, 0.0], [17.5, 0.0]]);
    assert_eq!(outputs[0].velocity_mps, [1.0, 0.0, 0.0]);
    assert!(
        outputs
            .iter()
            .all(|output| output.stage == SelectionStage::Interval && reason(output).is_none())
    );
}

#[test]
fn fixes_are_passed_on_before_the_first_selection_and_until_the_second() {
    let mut selector = Selector::new(settings(Select::Interval, AboveThreshold::Continue));
    let outputs = run(
        &mut selector,
        &[
            (0.0, [5.0, 5.0], ABOVE),
            (1.0, [6.0, 5.0], LIMIT),
            (2.0, [7.0, 5.0], BELOW),
            (8.0, [40.0, 5.0], ABOVE),
            (11.0, [41.0, 5.0], BELOW),
            (12.0, [27.0, 5.0], BELOW),
        ],
    );
    let stages = outputs.iter().map(|output| output.stage);
    let expected = [
        SelectionStage::Passing,
        SelectionStage::Passing,
        SelectionStage::First,
        SelectionStage::First,
        SelectionStage::First,
        SelectionStage::Interval,
    ];
    assert!(stages.eq(expected));
    assert_eq!(place(&outputs[3]), [40.0, 5.0]);
    assert_eq!(outputs[3].velocity_mps, [0.5, 0.25, 0.0], "the filter's own velocity");
    assert_eq!(
        [reason(&outputs[2]), reason(&outputs[5])],
        [Some(SelectionReason::FirstBelow), Some(SelectionReason::Second)]
    );
    assert_eq!(outputs[5].velocity_mps[0], 2.0);
    assert_eq!(place(&outputs[5]), [27.0, 5.0]);
}

#[test]
fn a_second_selection_above_the_threshold_waits_for_the_next() {
    let mut selector = Selector::new(settings(Select::Interval, AboveThreshold::Continue));
    let outputs = run(
        &mut selector,
        &[
            (0.0, [0.0, 0.0], BELOW),
            (10.0, [10.0, 0.0], ABOVE),
            (15.0, [15.0, 1.0], BELOW),
            (20.0, [20.0, 2.0], BELOW),
            (30.0, [0.0, 0.0], BELOW),
        ],
    );
    assert_eq!(reason(&outputs[1]), Some(SelectionReason::SecondWaits));
    assert_eq!(place(&outputs[2]), [15.0, 1.0], "passed on");
    assert_eq!(reason(&outputs[3]), Some(SelectionReason::Second));
    // P1 = S1 at 0 s, P2 = S2 at 20 s: the same way and the same time.
    assert_eq!(place(&outputs[4]), [30.0, 3.0]);
}

/// The source's t5 and t6: the variance rises after t4 = 40, and falls after t5 = 50.
const RISES_AND_FALLS: [(f64, [f64; 2], f64); 6] = [
    (44.0, [36.0, 4.4], BELOW),
    (46.0, [90.0, 90.0], ABOVE),
    (50.0, [91.0, 91.0], ABOVE),
    (56.0, [48.0, 7.0], BELOW),
    (60.0, [56.0, 9.0], BELOW),
    (70.0, [70.0, 10.0], BELOW),
];

#[test]
fn above_the_threshold_option_a_goes_on_as_before() {
    let mut selector = Selector::new(settings(Select::Interval, AboveThreshold::Continue));
    run(&mut selector, &CHECKED);
    let outputs = run(&mut selector, &RISES_AND_FALLS);
    assert_eq!(place(&outputs[2]), [40.0, 5.0], "P5");
    assert_eq!(place(&outputs[4]), [50.0, 8.0], "P6 = P5 + (P5 − P4)");
    assert_eq!(reason(&outputs[4]), Some(SelectionReason::IntervalOver));
    // P7 = P6 + (S6 − P5).
    assert_eq!(place(&outputs[5]), [66.0, 12.0]);
}

#[test]
fn above_the_threshold_option_b_uses_the_motion_up_to_and_from_the_crossings() {
    let mut selector = Selector::new(settings(Select::Interval, AboveThreshold::UseCrossings));
    run(&mut selector, &CHECKED);
    let outputs = run(&mut selector, &RISES_AND_FALLS);
    assert_eq!(reason(&outputs[2]), Some(SelectionReason::UpCrossing));
    assert!(!outputs[2].is_selected);
    // P6 = P5 + (X_up − P4)·T/(t_up − t4) = (40, 5) + ((36, 4.4) − (30, 2))·10/4.
    let [x, y] = place(&outputs[4]);
    assert!((x - 55.0).abs() < 1e-9 && (y - 11.0).abs() < 1e-9, "P6 = {x}, {y}");
    assert_eq!(reason(&outputs[4]), Some(SelectionReason::DownCrossing));
    // P7 = P6 + (S6 − X_down)·T/(t6 − t_down) = P6 + ((56, 9) − (48, 7))·10/4.
    let [x, y] = place(&outputs[5]);
    assert!((x - 75.0).abs() < 1e-9 && (y - 16.0).abs() < 1e-9, "P7 = {x}, {y}");
    assert_eq!(reason(&outputs[5]), Some(SelectionReason::IntervalOver));
}

#[test]
fn option_b_falls_back_to_option_a_and_to_the_plain_rule() {
    let mut selector = Selector::new(settings(Select::Interval, AboveThreshold::UseCrossings));
    run(&mut selector, &CHECKED);
    let outputs = run(
        &mut selector,
        &[
            // The last fix below is the selected one: t_up = t4.
            (45.0, [1.0, 1.0], ABOVE),
            (50.0, [1.0, 1.0], ABOVE),
            // Still above at a further selection time, whatever happened in between.
            (52.0, [41.0, 5.0], BELOW),
            (53.0, [42.0, 5.0], BELOW),
            (55.0, [1.0, 1.0], ABOVE),
            (60.0, [1.0, 1.0], ABOVE),
            // The first fix below is the one of the selection time: t_down = t7.
            (70.0, [66.0, 20.0], BELOW),
            (80.0, [0.0, 0.0], BELOW),
        ],
    );
    let held = [&outputs[1], &outputs[5]].map(reason);
    assert_eq!(held, [Some(SelectionReason::HeldAbove); 2]);
    assert_eq!([place(&outputs[5]), place(&outputs[6])], [[50.0, 8.0], [60.0, 11.0]]);
    assert_eq!(reason(&outputs[6]), Some(SelectionReason::IntervalOver));
    // P8 = P7 + (S7 − P6).
    assert_eq!(place(&outputs[7]), [76.0, 23.0]);
}

#[test]
fn minima_are_selected_with_the_output_of_their_time() {
    let mut selector = Selector::new(settings(Select::Minimum, AboveThreshold::Continue));
    let outputs = run(
        &mut selector,
        &[
            (0.0, [0.0, 0.0], 90.0),
            (1.0, [1.0, 9.0], 40.0),
            (2.0, [2.0, 0.0], 60.0), // the first minimum was at 1
            (5.0, [9.0, 9.0], 30.0),
            (6.0, [6.0, 5.0], 50.0), // the second at 5: (9 − 1, 0)/4 from here on
            (9.0, [30.0, 0.0], 20.0),
            (10.0, [0.0, 0.0], 45.0), // the third at 9, where the output was (12, 5)
            (11.0, [0.0, 0.0], 44.0),
        ],
    );
    let stages = outputs.iter().map(|output| output.stage);
    let expected = [
        SelectionStage::Passing,
        SelectionStage::Passing,
        SelectionStage::First,
        SelectionStage::First,
        SelectionStage::Minimum,
        SelectionStage::Minimum,
        SelectionStage::Minimum,
        SelectionStage::Minimum,
    ];
    assert!(stages.eq(expected));
    let reasons = [&outputs[2], &outputs[4], &outputs[6]].map(reason);
    assert_eq!(
        reasons,
        [
            SelectionReason::FirstMinimum,
            SelectionReason::Second,
            SelectionReason::AtMinimum
        ]
        .map(Some)
    );
    assert_eq!(place(&outputs[4]), [6.0, 5.0], "passed on until the line begins");
    assert_eq!(outputs[4].velocity_mps, [2.0, 0.0, 0.0]);
    assert_eq!(place(&outputs[5]), [12.0, 5.0]);
    // V = (S3 − P2)/(t3 − t2), with P2 the output at the second minimum, which was the fix.
    assert_eq!(outputs[6].velocity_mps, [(30.0 - 9.0) / 4.0, (0.0 - 9.0) / 4.0, 0.0]);
}

#[test]
fn a_minimum_above_the_threshold_changes_nothing() {
    let mut selector = Selector::new(settings(Select::Minimum, AboveThreshold::Continue));
    let begin = [
        (0.0, [0.0, 0.0], 90.0),
        (1.0, [0.0, 0.0], 40.0),
        (2.0, [0.0, 0.0], 250.0),
        (3.0, [0.0, 0.0], 150.0),
        (4.0, [0.0, 0.0], 250.0), // above: the second waits
        (5.0, [8.0, 4.0], 40.0),
        (6.0, [8.0, 4.0], 250.0),
    ];
    let outputs = run(&mut selector, &begin);
    assert_eq!(
        [4, 6].map(|row| reason(&outputs[row])),
        [SelectionReason::SecondWaits, SelectionReason::Second].map(Some)
    );
    let outputs = run(
        &mut selector,
        &[
            (8.0, [500.0, 0.0], 150.0),
            (9.0, [0.0, 0.0], 250.0),
            (10.0, [0.0, 0.0], 260.0),
        ],
    );
    assert_eq!(reason(&outputs[1]), Some(SelectionReason::HeldAbove));
    assert!(outputs.iter().all(|output| output.velocity_mps == [2.0, 1.0, 0.0]));
}

#[test]
fn small_ripples_and_early_minima_do_not_count_if_so_configured() {
    let mut valley = Valley::default();
    let nowhere = Point {
        time_s: 0.0,
        position_m: [0.0; 3],
    };
    let found: Vec<_> = [100.0, 50.0, 52.0, 49.0, 53.0, 60.0, 58.0, 62.0, 40.0, 45.0]
        .into_iter()
        .filter_map(|variance| valley.next(0.1, variance, nowhere, nowhere))
        .map(|minimum| minimum.variance_m2)
        .collect();
    assert_eq!(found, [49.0, 40.0]);

    let mut selector = Selector::new(SelectionSettings {
        minimum_gap_s: 4.0,
        ..settings(Select::Minimum, AboveThreshold::Continue)
    });
    let rows: Vec<_> = [90.0, 40.0, 60.0, 30.0, 50.0, 20.0, 50.0]
        .into_iter()
        .zip(0u32..)
        .map(|(variance, time)| (f64::from(time), [0.0; 2], variance))
        .collect();
    let outputs = run(&mut selector, &rows);
    assert_eq!(
        outputs[6].stage,
        SelectionStage::First,
        "minima at 1, 3 and 5 s; 4 s are not enough"
    );
}

#[test]
fn staged_selection_goes_to_minima_and_back() {
    let mut selector = Selector::new(settings(Select::Staged, AboveThreshold::Continue));
    // A minimum every 8 s, of a target that moves east at 2 m/s.
    let rows: Vec<_> = (0..60)
        .map(|time| {
            (
                f64::from(time),
                [2.0 * f64::from(time), 0.0],
                40.0 + f64::from((time + 4) % 8),
            )
        })
        .collect();
    let outputs = run(&mut selector, &rows);
    let stage_at = |time: usize| outputs[time].stage;
    assert_eq!([stage_at(0), stage_at(5)], [SelectionStage::First; 2]);
    assert_eq!(stage_at(10), SelectionStage::Interval);
    let settled = outputs
        .iter()
        .position(|output| reason(output) == Some(SelectionReason::Settled))
        .unwrap();
    assert!(settled > 10 && settled < 40, "at {settled}");
    assert_eq!(stage_at(59), SelectionStage::Minimum);
    // Then the variance only falls.
    let rows: Vec<_> = (60..140)
        .map(|time| {
            (
                f64::from(time),
                [2.0 * f64::from(time), 0.0],
                40.0 - 0.1 * f64::from(time - 60),
            )
        })
        .collect();
    let outputs = run(&mut selector, &rows);
    let rare = outputs
        .iter()
        .position(|output| reason(output) == Some(SelectionReason::MinimaRare))
        .unwrap();
    assert_eq!(outputs[rare].stage, SelectionStage::Interval);
    let Some((_, silent_s, limit_s)) = outputs[rare].decision else {
        panic!()
    };
    assert!(silent_s > 30.0 && limit_s == 30.0);
    assert_eq!(outputs.last().unwrap().stage, SelectionStage::Interval);
    assert!(
        outputs[rare + 1..]
            .iter()
            .any(|output| reason(output) == Some(SelectionReason::IntervalOver))
    );
    assert!((outputs.last().unwrap().position_m[0] - 278.0).abs() < 1e-9);
}

#[test]
fn steering_meets_the_filter_without_a_jump() {
    let mut selector = Selector::new(settings(Select::Auto, AboveThreshold::Continue));
    // While the variance falls fast, fixes are passed on.
    let first = [
        (0.0, [0.0, 0.0], ABOVE),
        (1.0, [3.0, 4.0], BELOW),
        (1.5, [3.0, 4.0], 0.9 * BELOW),
    ];
    let outputs = run(&mut selector, &first);
    assert_eq!(
        [outputs[0].stage, outputs[1].stage, outputs[2].stage],
        [
            SelectionStage::Passing,
            SelectionStage::Passing,
            SelectionStage::Steered
        ]
    );
    assert_eq!(reason(&outputs[2]), Some(SelectionReason::FirstBelow));
    // The filter says 0.5 and 0.25 m/s, and jumps by 10 m.
    let rows: Vec<_> = (2..200)
        .map(|time| {
            let at = f64::from(time);
            (at, [13.0 + 0.5 * at, 4.0 + 0.25 * at], BELOW)
        })
        .collect();
    let outputs = run(&mut selector, &rows);
    let [x, y] = place(outputs.last().unwrap());
    assert!((x - (13.0 + 0.5 * 199.0)).abs() < 0.01 && (y - (4.0 + 0.25 * 199.0)).abs() < 0.01);
    assert!(outputs.iter().all(|output| output.is_selected));
}

#[test]
fn the_output_follows_fixes_that_have_left_it() {
    let mut selector = Selector::new(settings(Select::Auto, AboveThreshold::Continue));
    let rows = |jumped, times: std::ops::Range<u32>| {
        times
            .map(move |time| (f64::from(time), [jumped, 0.0], BELOW))
            .collect::<Vec<_>>()
    };
    run(&mut selector, &rows(0.0, 0..5));
    // Three standard deviations are 21 m. A single fix farther away may be wrong.
    for (time, jumped, stage, expected) in [
        (5.0, 25.0, SelectionStage::Steered, None),
        (6.0, 0.0, SelectionStage::Steered, None),
        (7.0, 40.0, SelectionStage::Steered, None),
        (8.0, 40.0, SelectionStage::Passing, Some(SelectionReason::Departed)),
        (9.0, 40.0, SelectionStage::Steered, Some(SelectionReason::FirstBelow)),
    ] {
        let output = selector.fix(&fix(time, [jumped, 0.0], BELOW)).unwrap();
        assert_eq!(
            (output.stage, output.decision.map(|(reason, ..)| reason)),
            (stage, expected),
            "{time}"
        );
        assert_eq!(output.position_m[0] == 40.0, time > 7.0, "{time}");
    }
}

#[test]
fn steering_does_not_overshoot_when_fixes_are_rare() {
    let mut selector = Selector::new(settings(Select::Auto, AboveThreshold::Continue));
    let rows: Vec<_> = (0..40u32)
        .map(|k| {
            let at = 60.0 * f64::from(k);
            let jumped = if k > 3 { 100.0 } else { 0.0 };
            (at, [jumped + 0.5 * at, 0.25 * at], BELOW)
        })
        .collect();
    let outputs = run(&mut selector, &rows);
    for (output, (at, ..)) in outputs.iter().zip(&rows) {
        let ahead = output.position_m[0] - 0.5 * at;
        assert!((-1e-9..=100.0 + 1e-9).contains(&ahead), "{ahead} m at {at} s");
    }
}

#[test]
fn none_passes_everything_on() {
    let mut selector = Selector::new(settings(Select::None, AboveThreshold::Continue));
    let outputs = run(&mut selector, &CHECKED);
    assert!(outputs.iter().zip(&CHECKED).all(|(output, row)| place(output) == row.1));
    assert!(
        outputs
            .iter()
            .all(|output| !output.is_selected && output.stage == SelectionStage::Passing)
    );
}

#[test]
fn late_and_impossible_fixes_change_nothing_and_gaps_are_bridged() {
    let mut selector = Selector::new(settings(Select::Interval, AboveThreshold::Continue));
    run(&mut selector, &CHECKED);
    for bad in [
        fix(39.0, [0.0, 0.0], BELOW),
        fix(f64::NAN, [0.0, 0.0], BELOW),
        fix(41.0, [f64::INFINITY, 0.0], BELOW),
        fix(41.0, [0.0, 0.0], f64::NAN),
    ] {
        assert_eq!(selector.fix(&bad), None);
    }
    // Two intervals without a fix; then the way and the time since the last selection count.
    let outputs = run(
        &mut selector,
        &[
            (73.0, [63.0, 10.0], BELOW),
            (79.0, [0.0; 2], BELOW),
            (80.0, [0.0; 2], BELOW),
        ],
    );
    assert_eq!(reason(&outputs[0]), Some(SelectionReason::IntervalOver));
    assert_eq!(
        outputs[0].velocity_mps,
        [(63.0 - 30.0) / 33.0, (10.0 - 2.0) / 33.0, 0.0]
    );
    assert_eq!(
        [reason(&outputs[1]), reason(&outputs[2])],
        [None, Some(SelectionReason::IntervalOver)]
    );
    // The same time twice is no error.
    assert!(selector.fix(&fix(80.0, [0.0; 2], BELOW)).is_some());
}

/// Selections by the change of direction: each 29.9 degrees, whatever the time; without directions, each interval.
#[test]
fn geometry_selects_after_equal_changes_of_direction() {
    let geometric = SelectionSettings {
        interval: SelectionInterval::Geometry,
        interval_deg: Degrees::of(29.9),
        ..settings(Select::Interval, AboveThreshold::Continue)
    };
    let selected_at = |direction_deg: fn(f64) -> Option<f64>| {
        let mut selector = Selector::new(geometric);
        let mut selected = Vec::new();
        for step in 0..80 {
            let time_s = f64::from(step);
            let fix = Fix {
                direction_rad: direction_deg(time_s).map(f64::to_radians),
                ..fix(time_s, [0.0; 2], BELOW)
            };
            if selector.fix(&fix).unwrap().is_selected {
                selected.push(step);
            }
        }
        selected
    };
    // Two degrees a second through north; then nothing changes any more.
    let turning = |time_s: f64| Some((330.0 + 2.0 * time_s.min(50.0)).rem_euclid(360.0));
    assert_eq!(selected_at(turning), [0, 15, 30, 45]);
    let back = |time_s: f64| Some(330.0 - 2.0 * time_s.min(31.0));
    assert_eq!(selected_at(back), [0, 15, 30]);
    assert_eq!(selected_at(|_| None), [0, 10, 20, 30, 40, 50, 60, 70]);
}
