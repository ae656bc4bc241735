//! Pictures of a scorecard.

use std::collections::BTreeMap;

use scoring::surveillance_standard;
use scoring::{AreaCard, ErrorSample, LineLimit, LineMeasure, MOVEMENT_PHASES, PhaseFigures, ScoredArea};

use super::chart::{BLUE, Chart, ChartAxis, FAINT, INK, ORANGE, RED, TEAL};

const SIZE: [f64; 2] = [520.0, 320.0];
const MAP_SIZE: [f64; 2] = [520.0, 470.0];
/// Pixels of the map without margins.
const MAP_PLOT: [f64; 2] = [422.0, 412.0];
/// Most dots and most steps of a line in a picture; more would not be visible.
const DOTS_MAX: usize = 4_000;
const STEPS_MAX: usize = 300;
/// Number of intervals of the picture over time.
const TIME_BINS: i64 = 60;
/// Shares of the errors shown by phase, with colours.
const SHARES: [(&str, &str); 4] = [("50 %", TEAL), ("90 %", BLUE), ("95 %", ORANGE), ("99 %", RED)];

/// Returns the pictures of a card with captions (HTML).
pub(super) fn of_card(card: &AreaCard, errors: &[&ErrorSample], areas: &[ScoredArea]) -> Vec<(String, String)> {
    let mut sizes: Vec<f64> = errors.iter().map(|error| error.position_m).collect();
    sizes.sort_unstable_by(f64::total_cmp);
    let shares: String = SHARES.iter().map(|(share, colour)| key(colour, share)).collect();
    let groups: String = GROUPS.iter().map(|(name, colour, _)| key(colour, name)).collect();
    let (low, high) = bounds(&sizes);
    let mut pictures = vec![(
        format!("Position error by phase: size that a share of the errors does not exceed.{shares}"),
        by_phase(card),
    )];
    if card.phases.0[0].consistency.position.n > 0 {
        pictures.push((
            format!("NEES by phase: 1 is honest, to the right too confident.{groups}"),
            consistency(card),
        ));
    }
    let limit = key(ORANGE, "limit of a line: met where the curve runs above its mark");
    pictures.push((
        format!("Share of position errors up to a size.{limit}"),
        distribution(card, &sizes),
    ));
    pictures.push((
        format!("Position error over time.{}{}", key(TEAL, "50 %"), key(ORANGE, "95 %")),
        over_time(errors),
    ));
    pictures.push((
        format!(
            "Places of the targets by position error.{}{}{}",
            key(TEAL, &format!("up to {low:.0} m")),
            key(ORANGE, &format!("to {high:.0} m (95 %)")),
            key(RED, "above")
        ),
        map(errors, areas, (low, high)),
    ));
    pictures
}

fn key(colour: &str, text: &str) -> String {
    format!(" <span class=\"key\"><i style=\"background:{colour}\"></i>{text}</span>")
}

/// Returns the median and 95 %, for colours.
fn bounds(sorted: &[f64]) -> (f64, f64) {
    let at = |share: f64| {
        sorted
            .get((share * (sorted.len().saturating_sub(1)) as f64) as usize)
            .copied()
            .unwrap_or(0.0)
    };
    (at(0.5), at(0.95))
}

fn shown_phases(card: &AreaCard) -> Vec<(&'static str, &PhaseFigures)> {
    let all = MOVEMENT_PHASES.iter().map(|phase| phase.name).zip(&card.phases.0);
    all.filter(|(_, figures)| figures.n > 0).collect()
}

/// An axis with a row for each phase, from the top; the names are written by the caller.
fn rows(number: usize) -> ChartAxis {
    ChartAxis::linear(-(number as f64) + 0.5..0.5, "").without_ticks()
}

fn by_phase(card: &AreaCard) -> String {
    let phases = shown_phases(card);
    let largest = phases
        .iter()
        .filter_map(|(_, figures)| figures.position.p99)
        .fold(1e-3, f64::max);
    let axis = ChartAxis::linear(0.0..largest * 1.05, "position error, m");
    let mut chart = Chart::new("Position error by phase", SIZE, axis, rows(phases.len()));
    for (row, (name, figures)) in phases.iter().enumerate() {
        let y = -(row as f64);
        let spread = &figures.position;
        let marks = [spread.p50, spread.p90, spread.p95, spread.p99];
        chart.text([0.0, y], [-6.0, 4.0], "end", name);
        chart.line(
            [[0.0, y], [spread.p99.unwrap_or(0.0), y]].into_iter(),
            &format!("stroke=\"{FAINT}\" stroke-width=\"6\""),
        );
        for (mark, (share, colour)) in marks.into_iter().zip(SHARES) {
            if let Some(mark) = mark {
                chart.dot(
                    [mark, y],
                    4.5,
                    colour,
                    &format!("{name}: {share} of {} up to {mark:.1} m", figures.n),
                );
            }
        }
    }
    chart.finish()
}

fn distribution(card: &AreaCard, sorted: &[f64]) -> String {
    let limits = limits(card);
    let last = sorted.last().copied().unwrap_or(1.0);
    let first = sorted.get(sorted.len() / 100).copied().unwrap_or(0.1);
    let high = limits.iter().map(|(limit_m, _)| *limit_m).fold(last, f64::max).max(1.0) * 1.1;
    let axis = ChartAxis::logarithmic(first.clamp(0.05, high / 10.0)..high, "position error, m (logarithmic)");
    let mut chart = Chart::new(
        "Distribution of position errors",
        SIZE,
        axis,
        ChartAxis::linear(0.0..100.0, "share, %"),
    );
    let step = (sorted.len() / STEPS_MAX).max(1);
    let places = (0..sorted.len()).filter(|place| place % step == 0 || place + 1 == sorted.len());
    let points = places.map(|place| [sorted[place], 100.0 * (place + 1) as f64 / sorted.len() as f64]);
    chart.line(points, &format!("stroke=\"{BLUE}\" stroke-width=\"2\""));
    for (row, (limit_m, share)) in limits.iter().enumerate() {
        let y = 100.0 * share;
        chart.dot([*limit_m, y], 5.0, ORANGE, &format!("{y:.0} % up to {limit_m} m"));
        let is_new = row == 0 || limits[row - 1].0 != *limit_m;
        if is_new {
            let below = 15.0 + 12.0 * (row % 4) as f64;
            chart.text([*limit_m, y], [5.0, below], "start", &format!("{limit_m} m"));
        }
    }
    chart.finish()
}

/// Returns the limits of position errors that lines of the card's standards set, with shares.
fn limits(card: &AreaCard) -> Vec<(f64, f64)> {
    let mut found: Vec<(f64, f64)> = Vec::new();
    let results = card.standards.iter().flat_map(|standard| {
        let lines = surveillance_standard(standard.standard).map_or(&[][..], |known| known.lines);
        let shown = |name: &str| standard.lines.iter().any(|line| line.name == name);
        lines.iter().filter(move |line| shown(line.name))
    });
    for line in results {
        if let (LineMeasure::PositionQuantile(share), Some(LineLimit::AtMost(limit_m))) = (line.measure, line.limit)
            && !found.contains(&(limit_m, share))
        {
            found.push((limit_m, share));
        }
    }
    found.sort_by(|one, other| one.0.total_cmp(&other.0));
    found
}

fn map(errors: &[&ErrorSample], areas: &[ScoredArea], (low, high): (f64, f64)) -> String {
    let places = || errors.iter().map(|error| error.place_m.map(|metres| metres / 1000.0));
    let middle_and_half = |axis: usize| {
        let (first, last) = places().fold((f64::INFINITY, f64::NEG_INFINITY), |(first, last), place| {
            (first.min(place[axis]), last.max(place[axis]))
        });
        (0.5 * (first + last), (0.5 * (last - first)).max(0.05))
    };
    let [(east, half_east), (north, half_north)] = [0, 1].map(middle_and_half);
    let scale = 1.06 * (half_east / MAP_PLOT[0]).max(half_north / MAP_PLOT[1]);
    let range = |middle: f64, pixels: f64| middle - scale * pixels..middle + scale * pixels;
    let (x, y) = (range(east, MAP_PLOT[0]), range(north, MAP_PLOT[1]));
    let (x, y) = (ChartAxis::linear(x, "east, km"), ChartAxis::linear(y, "north, km"));
    let mut chart = Chart::new("Places of the targets", MAP_SIZE, x, y);
    for area in areas {
        for rings in area.outline.polygons() {
            let rings: Vec<Vec<[f64; 2]>> = rings
                .iter()
                .map(|ring| ring.iter().map(|place| place.map(|metres| metres / 1000.0)).collect())
                .collect();
            chart.outline(
                &rings,
                &format!("fill=\"{FAINT}\" fill-opacity=\"0.4\" stroke=\"{INK}\" stroke-width=\"0.7\""),
            );
        }
    }
    // The largest errors are drawn last, so that no other dot hides a large error.
    let step = errors.len().div_ceil(DOTS_MAX);
    let is_large = |error: &ErrorSample| error.position_m > high;
    let mut drawn: Vec<&ErrorSample> = errors
        .iter()
        .step_by(step)
        .filter(|error| !is_large(error))
        .copied()
        .collect();
    let large: Vec<&ErrorSample> = errors.iter().filter(|error| is_large(error)).copied().collect();
    drawn.extend(large.iter().step_by(large.len().div_ceil(DOTS_MAX).max(1)));
    for error in drawn {
        let (radius, colour) = match error.position_m {
            size if size <= low => (1.1, TEAL),
            size if size <= high => (1.4, ORANGE),
            _ => (1.8, RED),
        };
        chart.dot(error.place_m.map(|metres| metres / 1000.0), radius, colour, "");
    }
    chart.finish()
}

fn over_time(errors: &[&ErrorSample]) -> String {
    let (first, last) = (errors[0].second, errors[errors.len() - 1].second);
    let width = ((last - first) / TIME_BINS + 1).max(1);
    let mut bins: BTreeMap<i64, Vec<f64>> = BTreeMap::new();
    for error in errors {
        bins.entry((error.second - first) / width)
            .or_default()
            .push(error.position_m);
    }
    let figures: Vec<(i64, [f64; 2])> = bins
        .into_iter()
        .map(|(bin, mut sizes)| {
            sizes.sort_unstable_by(f64::total_cmp);
            let (p50, p95) = bounds(&sizes);
            (bin, [p50, p95])
        })
        .collect();
    let largest = figures.iter().map(|(_, [_, p95])| *p95).fold(1e-3, f64::max);
    let x = ChartAxis::linear(first as f64..(last + 1) as f64, "time, s");
    let y = ChartAxis::linear(0.0..largest * 1.08, "position error, m");
    let mut chart = Chart::new("Position error over time", SIZE, x, y);
    for (share, colour) in [(1, ORANGE), (0, TEAL)] {
        // Time without targets interrupts the line.
        for part in figures.chunk_by(|(one, _), (next, _)| next - one == 1) {
            let middle = |bin: i64| first as f64 + (bin as f64 + 0.5) * width as f64;
            let points = part.iter().map(|(bin, sizes)| [middle(*bin), sizes[share]]);
            chart.line(points.clone(), &format!("stroke=\"{colour}\" stroke-width=\"1.8\""));
            points.for_each(|point| chart.dot(point, 1.8, colour, ""));
        }
    }
    chart.finish()
}

/// Groups of the covariance: name, colour, mean normalised square.
type Group = (&'static str, &'static str, fn(&PhaseFigures) -> Option<f64>);

const GROUPS: [Group; 4] = [
    ("position", BLUE, |figures| figures.consistency.position.nees),
    ("velocity", ORANGE, |figures| figures.consistency.velocity.nees),
    ("height", TEAL, |figures| figures.consistency.height.nees),
    ("climb rate", RED, |figures| figures.consistency.climb.nees),
];

fn consistency(card: &AreaCard) -> String {
    let phases = shown_phases(card);
    let all = phases
        .iter()
        .flat_map(|(_, figures)| GROUPS.iter().filter_map(|(_, _, nees)| nees(figures)));
    let (low, high) = all.fold((0.5f64, 2.0f64), |(low, high), nees| (low.min(nees), high.max(nees)));
    let axis = ChartAxis::logarithmic(
        low.max(1e-3) / 1.2..high * 1.2,
        "NEES per degree of freedom (logarithmic)",
    );
    let mut chart = Chart::new("Consistency by phase", SIZE, axis, rows(phases.len()));
    let bottom = -(phases.len() as f64) + 0.5;
    chart.line(
        [[1.0, bottom], [1.0, 0.5]].into_iter(),
        &format!("stroke=\"{INK}\" stroke-width=\"1.2\""),
    );
    for (row, (name, figures)) in phases.iter().enumerate() {
        let y = -(row as f64);
        chart.text([1e-9, y], [-6.0, 4.0], "end", name);
        for (group, colour, nees) in GROUPS {
            if let Some(nees) = nees(figures) {
                chart.dot([nees, y], 4.5, colour, &format!("{name}, {group}: {nees:.2}"));
            }
        }
    }
    chart.finish()
}
