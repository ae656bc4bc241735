use configuration::BUILT_IN_DEMO;
use tracking::turn_time::TurnEstimate;

use super::*;

#[test]
fn the_summary_names_every_source_and_the_capacities() {
    let path = Path::new(BUILT_IN_DEMO);
    let config = Config::read(path, &[]).unwrap();
    let text = summary(path, &config, &[], Some(3_000_000_000));
    for source in &config.sources {
        assert!(text.contains(&source.name), "{text}");
    }
    assert!(
        text.contains("2000 system tracks") && text.contains("3.0 GB are free"),
        "{text}"
    );
}

#[test]
fn life_times_that_make_no_sense_are_warned_of() {
    let path = Path::new(BUILT_IN_DEMO);
    let overrides = ["fusion.life.tentative_s=0.5", "source[0].period_s=12"].map(str::to_owned);
    let config = Config::read(path, &overrides).unwrap();
    let text = summary(path, &config, &[], None);
    let warning = "warning      fusion.life.tentative_s: 0.5 s: a new track has ended before";
    assert!(text.contains(warning), "{text}");
    assert_eq!(json(path, &config, &[], None)["warnings"].as_array().unwrap().len(), 1);
    assert!(!summary(path, &Config::read(path, &[]).unwrap(), &[], None).contains("warning"));
}

/// Turns that recordings have shown stand in for a period that is not configured, and contradict one that is wrong.
#[test]
fn the_turn_that_a_recording_shows_is_told() {
    let site = "name = \"t\"\n[frame]\nlatitude_deg = 41.0\nlongitude_deg = 2.0\n[time]\ndate = \"2016-05-10\"\n\
                [[source]]\nname = \"radar\"\nPERIOD[source.recorded]\nfile = \"x.ast\"\n[source.covariance]\n\
                position_sigma_m = 50.0\n[source.tracker]\n";
    let path = Path::new("t.toml");
    let told = |period: &str, turn: Option<TurnEstimate>| {
        let config = Config::parse(path, &site.replace("PERIOD", period), &[]).unwrap();
        let found = RecordingFindings {
            turn,
            ..RecordingFindings::default()
        };
        let text = summary(path, &config, std::slice::from_ref(&found), None);
        (text, json(path, &config, &[found], None))
    };
    let turn = |ns| {
        let basis = Basis::NorthMarks;
        Some(TurnEstimate { ns, basis })
    };
    let (text, found) = told("", turn(7_630_123_456));
    assert!(
        text.contains("radar, every 7.63 s, as its north marks show: "),
        "{text}"
    );
    assert_eq!(found["sources"][0]["period_s"], 7.630_123_456);
    let (text, found) = told("", None);
    assert!(
        text.contains("radar, every antenna turn, with a duration measured by the adapter: "),
        "{text}"
    );
    assert!(found["sources"][0]["period_s"].is_null());
    let (text, found) = told("period_s = 12.0\n", turn(7_630_123_456));
    assert!(text.contains("radar, every 12 s: "), "{text}");
    assert!(
        text.contains("warning      source[0].period_s = 12: a turn of radar takes 7.63 s, as its north marks show"),
        "{text}"
    );
    assert_eq!(found["warnings"].as_array().map(Vec::len), Some(1));
    let (text, _) = told("period_s = 8.0\n", turn(7_630_123_456));
    assert!(!text.contains("warning"), "{text}");
}

#[test]
fn regions_are_counted_and_gaps_between_them_warned_of() {
    let region = |origin: u32, [west, east]: [f64; 2]| {
        format!(
            "[[region]]\nname = \"of-{origin}\"\norigin = {origin}\n\
             corners_deg = [[41.0, {west}], [41.0, {east}], [42.0, {east}], [42.0, {west}]]\n"
        )
    };
    let check = |east_of: f64| {
        let regions = [region(1, [1.0, 2.0]), region(2, [east_of, 3.0])].concat();
        let overrides = ["origin=1", "fusion.exchange=true"].map(str::to_owned);
        let text = format!("{}\n{regions}", configuration::DEMO);
        let path = Path::new("regions.toml");
        let config = Config::parse(path, &text, &overrides).unwrap();
        let warnings = json(path, &config, &[], None)["warnings"].as_array().unwrap().len();
        (summary(path, &config, &[], None), warnings)
    };
    let (text, warnings) = check(2.01);
    let counted = "regions      1 of this deployment, 1 of other centres";
    assert!(text.contains(counted), "{text}");
    assert!(text.contains("region[0] and region[1] leave a gap of 8"), "{text}");
    assert_eq!(warnings, 2);
    assert_eq!(check(2.0).1, 0);
}

#[test]
fn programs_are_told_the_same() {
    let path = Path::new(BUILT_IN_DEMO);
    let config = Config::read(path, &[]).unwrap();
    let summary = json(path, &config, &[], None);
    assert_eq!(summary["sources"].as_array().unwrap().len(), config.sources.len());
    assert_eq!(summary["capacity"]["system_tracks"], 2000);
    assert_eq!(summary["monitor"]["deadline_us"]["taken_to_fused"], 1000.0);
    assert_eq!(
        (&summary["sound"], &summary["shared_memory"]["free_bytes"]),
        (&true.into(), &Value::Null)
    );
}

#[test]
fn the_summary_says_what_counts_and_who_listens() {
    let text = include_str!("../../../../config/demo.toml");
    let listening = "detection_probability = 0.95\nwide_area_sensors = [\"own\"]\ncues = true\noutput_period_s = 0.5\n";
    let sensors = "\n[[wide_area_sensor]]\nname = \"own\"\n[wide_area_sensor.external]\n\
                   [[wide_area_sensor]]\nname = \"other\"\n[wide_area_sensor.external]\n";
    let text = text.replacen("detection_probability = 0.95\n", listening, 1) + sensors;
    let path = Path::new("demo.toml");
    let summary = summary(path, &Config::parse(path, &text, &[]).unwrap(), &[], None);
    assert!(
        summary.contains(
            "wide area 0  own: counts, external, published by a separate process; the tracker of radar-south"
        ),
        "{summary}"
    );
    assert!(summary.contains("; no tracker listens to it"), "{summary}");
    assert!(
        summary.contains(", given out every 0.5 s; it says where to look next\n"),
        "{summary}"
    );
}

#[test]
fn the_summary_says_how_the_monitor_watches() {
    let path = Path::new(BUILT_IN_DEMO);
    let summary = |overrides: &[&str]| {
        let overrides: Vec<String> = overrides.iter().map(|each| (*each).to_owned()).collect();
        summary(path, &Config::read(path, &overrides).unwrap(), &[], None)
    };
    let text = summary(&[]);
    assert!(text.contains("woken for each slice"), "{text}");
    assert!(text.contains("deadline: fusion 1.00 ms\n"), "{text}");
    assert!(!text.contains("metrics"), "{text}");
    let text = summary(&[
        "fusion.wait=spin",
        "monitor.poll_ms=2.5",
        "monitor.deadline_us.end_to_end=500",
        "monitor.prometheus=\"127.0.0.1:9464\"",
    ]);
    assert!(text.contains("looks every 2.5 ms"), "{text}");
    assert!(text.contains("fusion 1.00 ms, end to end 500 µs\n"), "{text}");
    assert!(text.contains("at http://127.0.0.1:9464/metrics\n"), "{text}");
}

#[test]
fn figures_have_units_and_times_two_digits() {
    assert_eq!(size(2_600_384), "2.6 MB");
    assert_eq!(size(999), "1.0 kB");
    assert_eq!(time_of_day(Some(79_201 * NS)), "22:00:01");
    assert_eq!(time_of_day(None), "?");
}

#[test]
fn a_coarse_clock_of_a_recording_is_named_with_its_rounding() {
    let site = "name = \"t\"\n[frame]\nlatitude_deg = 41.0\nlongitude_deg = 2.0\n[time]\ndate = \"2016-05-10\"\n\
                [[source]]\nname = \"radar\"\nSTAMPS[source.recorded]\nfile = \"x.csv\"\nformat = \"sensor-tracks\"\n";
    let path = Path::new("t.toml");
    let told = |stated: &str, step_ns: i64| {
        let config = Config::parse(path, &site.replace("STAMPS", stated), &[]).unwrap();
        let mut found = RecordingFindings::default();
        (0..20).for_each(|look| found.stamps.learn(NS + look * step_ns));
        summary(path, &config, &[found], None)
    };
    let whole = told("", NS);
    assert!(
        whole.contains("; its stamps are multiples of 1 s, rounding unknown"),
        "{whole}"
    );
    assert!(told("stamps = \"down\"\n", NS / 2).contains("multiples of 0.5 s, rounding down"));
    let fine = told("", 1_234_567_890);
    assert!(!fine.contains("stamps"), "{fine}");
    assert!(told("stamps = \"down\"\n", 1_234_567_890).contains("; of coarse stamps the rounding is down"));
}
