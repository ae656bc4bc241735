//! The configuration of wide-area support, heard and refused.

use std::collections::BTreeMap;
use std::path::Path;

use settings::{Degrees, Seconds};
use tracking::selection::Selection;
use tracking::settings::{Confirmation, Deletion, Settings};
use tracking::wide_area::correction::Rule;
use tracking::wide_area::distribution::Sharing;
use tracking::wide_area::group::Groups;
use tracking::wide_area::matching::Matching;
use tracking::wide_area::prior::{self, Circle, EmissionBand, Knowledge, Prior, Sector};
use tracking::wide_area::settings::{EarlyConfirmation, EarlyDeletion, SupportSettings};

use crate::{Config, SeenDetections, Tracking};

fn settings(text: &str) -> Result<Settings, String> {
    let seen = SeenDetections {
        sensor_ids: [1, 7].into(),
        scan_max: 10,
    };
    let parsed = Tracking::parse(Path::new("track.toml"), text);
    parsed
        .map(|config| config.settings(&seen))
        .map_err(|error| error.to_string())
}

const ALL: &str = "[wide_area]\ncorrection = { factor = 4 }\ncorrects_confirmed_only = false\nheld = { share = 0.2 }\nrange_m = 3000\nmatching = \"nearest\"\ntracks_min = 0\nothers_count = false\n\
    groups = { probability_min = 0.7 }\nvalid_s = 20\ndelay_max_s = 0\n\
    [wide_area.sharing]\nwhole = false\nby_tracks = true\nexcess = 1.2\ngroup_m = 400\n\
    [wide_area.confirmation]\nnew_target_share = 0.5\nbeside_confirmed_only = false\nreliability_min = 0.8\n\
    detections_min = 3\nlog_likelihood_ratio_min = 2\ncompany_min = 0.25\n\
    [wide_area.deletion]\nexistence_min = 0.02\nsilent_s = 12.5\ncoverage = { centre_m = [10, -20], radius_m = 9e4 }\n\
    [[wide_area.type]]\nname = \"patrol 7\"\n\
    emissions = [{ frequency_hz = [9e9, 9.5e9], pulse_interval_s = [1e-3, 1e-3] }, { frequency_hz = [2e9, 3e9] }]\n\
    [[wide_area.type]]\nname = \"twelve-chars\"\n\
    [[wide_area.prior]]\nsector = { from_m = [1000, 0], bearings_deg = [-30, 45] }\n\
    types = { \"twelve-chars\" = 0.25, \"patrol 7\" = 0.75 }\nformations = { 4 = 0.8, 2 = 0.1 }\nformation_probability_min = 0.6\n\
    [[wide_area.prior]]\ncircle = { centre_m = [5e4, 5e4], radius_m = 1e4 }\n\
    [selection]\nage_max_s = 5\nsigma_max_m = 300\nsame_time_s = 0.2\nkept_weight = 0.01\n";

fn named(probabilities: &[(&str, f64)]) -> BTreeMap<String, f64> {
    probabilities
        .iter()
        .map(|(name, share)| (name.to_string(), *share))
        .collect()
}

#[test]
fn every_key_is_heard() {
    let sensors = "[[sensor]]\nid = 7\npriority = 2\n[[sensor]]\nid = 1\n";
    let found = settings(&format!("{ALL}{sensors}")).unwrap();
    let bands = |frequency_hz, pulse_interval_s| EmissionBand {
        frequency_hz,
        pulse_interval_s,
    };
    let expected = SupportSettings {
        correction: Some(Rule::Factor(4.0)),
        corrects_confirmed_only: false,
        held: Some(Rule::Share(0.2)),
        range_m: 3000.0,
        matching: Matching::Nearest,
        tracks_min: 0.0,
        others_count: false,
        sharing: Some(Sharing {
            whole: false,
            by_tracks: true,
            excess: 1.2,
            group_m: Some(400.0),
        }),
        confirmation: Some(EarlyConfirmation {
            new_target_share: 0.5,
            beside_confirmed_only: false,
            confirmation: Confirmation {
                reliability_min: 0.8,
                detections_min: 3,
                log_likelihood_ratio_min: Some(2.0),
                ..Confirmation::default()
            },
            company_min: 0.25,
        }),
        deletion: Some(EarlyDeletion {
            deletion: Deletion {
                existence_min: 0.02,
                silent_s: Seconds::of(12.5),
            },
            coverage: Some(Circle {
                centre_m: [10.0, -20.0],
                radius_m: 9e4,
            }),
        }),
        groups: Some(Groups { probability_min: 0.7 }),
        knowledge: Knowledge {
            types: vec![
                prior::TargetType {
                    name: "patrol 7".to_owned(),
                    emissions: vec![bands([9e9, 9.5e9], Some([1e-3, 1e-3])), bands([2e9, 3e9], None)],
                },
                prior::TargetType {
                    name: "twelve-chars".to_owned(),
                    emissions: Vec::new(),
                },
            ],
            priors: vec![
                Prior {
                    sector: Some(Sector {
                        from_m: [1000.0, 0.0],
                        bearings_deg: [-30.0, 45.0].map(Degrees::of),
                    }),
                    types: named(&[("patrol 7", 0.75), ("twelve-chars", 0.25)]),
                    formations: named(&[("2", 0.1), ("4", 0.8)]),
                    formation_probability_min: 0.6,
                    ..Prior::default()
                },
                Prior {
                    circle: Some(Circle {
                        centre_m: [5e4, 5e4],
                        radius_m: 1e4,
                    }),
                    ..Prior::default()
                },
            ],
        },
        valid_s: Seconds::of(20.0),
        delay_max_s: Seconds::of(0.0),
    };
    assert_eq!(found.wide_area, expected);
    let selection = Selection {
        age_max_s: Some(Seconds::of(5.0)),
        sigma_max_m: Some(300.0),
        same_time_s: Seconds::of(0.2),
        kept_weight: Some(0.01),
    };
    assert_eq!(found.selection, selection);
    let priorities: Vec<_> = found
        .sensors
        .iter()
        .map(|sensor| (sensor.sensor_id, sensor.priority))
        .collect();
    assert_eq!(priorities, [(1, 0), (7, 2)]);
}

#[test]
fn each_part_can_be_off_and_has_defaults_when_it_is_on() {
    let off = settings("[wide_area]\ncorrection = \"off\"\nheld = \"off\"\nconfirmation = \"off\"\nsharing = \"off\"")
        .unwrap();
    let expected = SupportSettings {
        correction: None,
        held: None,
        confirmation: None,
        ..SupportSettings::default()
    };
    assert_eq!(off.wide_area, expected);
    let on = settings("[wide_area]\nsharing = {}\nconfirmation = {}\ndeletion = {}\ngroups = {}").unwrap();
    let usual = Settings::default();
    assert_eq!(on.wide_area.sharing, Some(Sharing::default()));
    assert_eq!(on.wide_area.confirmation, usual.wide_area.confirmation);
    assert_eq!(on.wide_area.groups, Some(Groups { probability_min: 0.5 }));
    let early = on.wide_area.deletion.unwrap();
    assert!(early.deletion.existence_min > usual.deletion.limits.existence_min);
    assert_eq!(early.deletion.silent_s, usual.deletion.limits.silent_s);
    let share = settings("[wide_area]\ncorrection = { share = 0.75 }").unwrap();
    assert_eq!(share.wide_area.correction, Some(Rule::Share(0.75)));
}

#[test]
fn a_source_has_the_same_tables() {
    let tables = ALL
        .replace("[wide_area]", "[source.tracker.wide_area]")
        .replace("[wide_area.", "[source.tracker.wide_area.")
        .replace("[[wide_area.", "[[source.tracker.wide_area.")
        .replace("[selection]", "[source.tracker.selection]");
    let text = |tables: &str| {
        format!(
            "name = \"x\"\n[frame]\nlatitude_deg = 50.0\nlongitude_deg = 8.0\n[[receiver]]\nname = \"lan\"\n\
             [receiver.udp]\nlisten = \"127.0.0.1:8600\"\n\
             [[source]]\nname = \"radar\"\nperiod_s = 4.0\n[source.live]\nreceiver = \"lan\"\n\
             [source.tracker]\n{tables}"
        )
    };
    let read = |tables: &str| Config::parse(Path::new("x.toml"), &text(tables), &[]).map_err(|error| error.to_string());
    let live = read(&tables).unwrap().tracker(0).unwrap().settings.clone();
    let offline = settings(ALL).unwrap();
    assert_eq!((live.wide_area, live.selection), (offline.wide_area, offline.selection));
    let refused = read("[source.tracker.wide_area]\nvalid_s = -1").unwrap_err();
    assert!(
        refused.starts_with("x.toml:16: source[0].tracker.wide_area.valid_s: -1 is out of range; it must lie between"),
        "{refused}"
    );
}

#[test]
fn mistakes_are_named_with_line_key_value_and_remedy() {
    let of_type = "[[wide_area.type]]\nname = \"A\"\n";
    let of_place = "[[wide_area.prior]]\ncircle = { centre_m = [0, 0], radius_m = 10 }\n";
    for (text, expected) in [
        (
            "[wide_area]\nrang_m = 5",
            "2: wide_area.rang_m: unknown key; there are: correction, ",
        ),
        (
            "[wide_area]\ncorrection = 0.6",
            "2: wide_area.correction: 0.6 is no table; write its keys below [wide_area.correction]",
        ),
        (
            "[wide_area]\ncorrection = \"on\"",
            "2: wide_area.correction: \"on\" is no table; write its keys below [wide_area.correction], or \"off\"",
        ),
        (
            "[wide_area]\ncorrection = { shar = 0.6 }",
            "2: wide_area.correction.shar: unknown key; there are: share, factor",
        ),
        (
            "[wide_area]\ncorrection = { share = 0.6, factor = 2 }",
            "2: wide_area.correction: needs exactly one of share and factor",
        ),
        (
            "[wide_area]\ncorrection = { share = 1.0 }",
            "2: wide_area.correction.share: 1 is out of range",
        ),
        (
            "[wide_area]\ncorrection = { factor = 0.5 }",
            "2: wide_area.correction.factor: 0.5 is out of range; it must lie between 1",
        ),
        (
            "[wide_area]\nheld = { share = -0.1 }",
            "2: wide_area.held.share: -0.1 is out of range",
        ),
        (
            "[wide_area]\nmatching = \"one_to_one\"\n[wide_area.sharing]\nwhole = true",
            "2: wide_area.matching: \"one_to_one\" gives each report to one cluster, and sharing to several",
        ),
        (
            "[wide_area]\nrange_m = nan",
            "2: wide_area.range_m: NaN is out of range",
        ),
        (
            "[wide_area]\ntracks_min = -1",
            "2: wide_area.tracks_min: -1 is out of range; it must lie between 0 and 256",
        ),
        (
            "[wide_area]\nsharing = { excess = 0.9 }",
            "2: wide_area.sharing.excess: 0.9 is out of range",
        ),
        (
            "[wide_area.sharing]\ngroup_m = 0",
            "2: wide_area.sharing.group_m: 0 is out of range",
        ),
        (
            "[wide_area.confirmation]\nreliability_min = 0.5",
            "2: wide_area.confirmation.reliability_min: 0.5 is out of range",
        ),
        (
            "[wide_area.confirmation]\ncompany_min = 1.5",
            "2: wide_area.confirmation.company_min: 1.5 is out of range",
        ),
        (
            "[wide_area.deletion]\nsilent_s = -3",
            "2: wide_area.deletion.silent_s: -3 is out of range",
        ),
        (
            "[wide_area.deletion]\ncoverage = { centre_m = [0, 1e8], radius_m = 5 }",
            "2: wide_area.deletion.coverage.centre_m: 100000000 is out of range",
        ),
        (
            "[wide_area]\ngroups = { probability_min = 0 }",
            "2: wide_area.groups.probability_min: 0 is out of range",
        ),
        ("[wide_area]\nvalid_s = 0", "2: wide_area.valid_s: 0 is out of range"),
        (
            "[wide_area]\ndelay_max_s = -0.5",
            "2: wide_area.delay_max_s: -0.5 is out of range",
        ),
        (
            "[[wide_area.type]]\nname = \"thirteen char\"",
            "2: wide_area.type[0].name: \"thirteen char\" cannot be a name: use 1 to 12 printable",
        ),
        (
            "[[wide_area.type]]\nname = \"a,b\"",
            "2: wide_area.type[0].name: \"a,b\" cannot be a name",
        ),
        (
            "[[wide_area.type]]\nname = \" a\"",
            "2: wide_area.type[0].name: \" a\" cannot be a name",
        ),
        (
            &format!("{of_type}{of_type}"),
            "4: wide_area.type[1].name: \"A\" is the name of an earlier type",
        ),
        (
            &format!("{of_type}emissions = [{{ frequency_hz = [9e9, 8e9] }}]"),
            "3: wide_area.type[0].emissions[0].frequency_hz: [9000000000, 8000000000]: write the lowest and the highest",
        ),
        (
            &format!("{of_type}emissions = [{{ frequency_hz = [1, 2], pulse_interval_s = [-1, 2] }}]"),
            "3: wide_area.type[0].emissions[0].pulse_interval_s: [-1, 2]: write",
        ),
        (
            &format!("{of_type}emissions = [{{ frequency = [9e9, 8e9] }}]"),
            "3: wide_area.type[0].emissions[0].frequency: unknown key",
        ),
        (
            "[[wide_area.prior]]\ntypes = {}",
            "1: wide_area.prior[0]: needs exactly one of sector and circle",
        ),
        (
            "[[wide_area.prior]]\nsector = { from_m = [0, 0], bearings_deg = [10, 370] }",
            "2: wide_area.prior[0].sector.bearings_deg: 370 is out of range",
        ),
        (
            "[[wide_area.prior]]\nsector = { from_m = [0, 0], bearings_deg = [0, 360] }",
            "2: wide_area.prior[0].sector.bearings_deg: [0, 360]: write two different bearings",
        ),
        (
            "[[wide_area.prior]]\ncircle = { centre_m = [0, 0], radius_m = -1 }",
            "2: wide_area.prior[0].circle.radius_m: -1 is out of range",
        ),
        (
            &format!("{of_type}{of_place}types = {{ B = 0.5 }}"),
            "5: wide_area.prior[0].types.B: no [[wide_area.type]] is named \"B\"; describe it there",
        ),
        (
            &format!("{of_type}{of_place}types = {{ A = 1.5 }}"),
            "5: wide_area.prior[0].types.A: 1.5 is out of range",
        ),
        (
            &format!("{of_type}{of_place}types = {{ A = 0.5, A = 0.4 }}"),
            "5: A: is given twice; remove one of the two",
        ),
        (
            &format!("{of_type}[[wide_area.type]]\nname = \"B\"\n{of_place}types = {{ A = 0.7, B = 0.5 }}"),
            "7: wide_area.prior[0].types: the probabilities sum to 1.200000; lower them",
        ),
        (
            &format!("{of_place}formations = {{ 0 = 0.5 }}"),
            "3: wide_area.prior[0].formations.0: \"0\" is no number of members; it must lie between 1 and 256",
        ),
        (
            &format!("{of_place}formations = {{ 10000 = 0.5 }}"),
            "3: wide_area.prior[0].formations.10000: \"10000\" is no number of members",
        ),
        (
            &format!("{of_place}formations = {{ 4 = 0.5, 04 = 0.2 }}"),
            "3: wide_area.prior[0].formations.4: formations of 4 are stated twice",
        ),
        (
            &format!("{of_place}formations = {{ 4 = nan }}"),
            "3: wide_area.prior[0].formations.4: NaN is out of range",
        ),
        (
            &format!("{of_place}formations = {{ 4 = 0.6, 2 = 0.6 }}"),
            "3: wide_area.prior[0].formations: the probabilities sum to 1.200000",
        ),
        (
            &format!("{of_place}formation_probability_min = 0"),
            "3: wide_area.prior[0].formation_probability_min: 0 is out of range",
        ),
        (
            &format!("{of_place}{of_place}"),
            "3: wide_area.prior[1]: priors 1 and 2 overlap; separate or join them",
        ),
        (
            "[[wide_area.prior]]\nsector = { from_m = [0, 0], bearings_deg = [350, 20] }\n[[wide_area.prior]]\n\
             sector = { from_m = [0, 0], bearings_deg = [10, 30] }",
            "3: wide_area.prior[1]: priors 1 and 2 overlap",
        ),
        (
            "[selection]\nage_s = 5",
            "2: selection.age_s: unknown key; there are: age_max_s",
        ),
        (
            "[selection]\nage_max_s = -5",
            "2: selection.age_max_s: -5 is out of range",
        ),
        (
            "[selection]\nsame_time_s = -1",
            "2: selection.same_time_s: -1 is out of range",
        ),
        (
            "[selection]\nsigma_max_m = 0",
            "2: selection.sigma_max_m: 0 is out of range",
        ),
        (
            "[selection]\nkept_weight = 1",
            "2: selection.kept_weight: 1 is out of range",
        ),
    ] {
        let message = settings(text).unwrap_err();
        assert!(
            message.starts_with(&format!("track.toml:{expected}")),
            "{text}\n{message}\n{expected}"
        );
        assert_eq!(message.lines().count(), 1, "{message}");
    }
}

#[test]
fn the_guides_example_is_sound() {
    let guide = include_str!("../../../docs/wide-area.md");
    let (_, after) = guide.split_once("```toml\n").unwrap();
    let (example, _) = after.split_once("```").unwrap();
    let found = settings(example).unwrap().wide_area;
    assert_eq!((found.knowledge.types.len(), found.knowledge.priors.len()), (2, 2));
}
