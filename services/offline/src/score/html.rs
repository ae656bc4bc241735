//! The scorecard as a page: a single file with its pictures, without scripts and without sources elsewhere.

use std::fmt::Write as _;

use scoring::{
    AreaCard, CardReference, ErrorSample, ErrorSpread, LineVerdict, MOVEMENT_PHASES, PhaseFigures, Scorecard,
    ScoredArea, StandardCard,
};

use crate::printed::digits;

use super::card::{about, advice, limit_text, meaning, remark};
use super::chart::escaped;
use super::pictures;

const STYLE: &str = "\
:root{color-scheme:light}\
body{font:15px/1.5 system-ui,'DejaVu Sans',sans-serif;color:#1c2733;background:#f6f7f9;margin:0}\
main{max-width:1080px;margin:0 auto;padding:24px 20px 60px}\
h1{font-size:26px;margin:0 0 4px}h2{font-size:20px;margin:36px 0 4px}h3{font-size:15px;margin:22px 0 6px}\
p{margin:4px 0}.quiet{color:#5a6673}\
section{background:#fff;border:1px solid #dfe3e8;border-radius:8px;padding:4px 20px 20px;margin-top:22px}\
.scroll{overflow-x:auto}\
table{border-collapse:collapse;width:100%;font-size:13.5px}\
th{font-weight:600;text-align:right;border-bottom:2px solid #c3cad2;padding:4px 8px;white-space:nowrap}\
td{text-align:right;border-bottom:1px solid #e8ebef;padding:4px 8px;white-space:nowrap;\
font-variant-numeric:tabular-nums}\
th:first-child,td:first-child{text-align:left}td.phase{vertical-align:top}.text{text-align:left;white-space:normal}\
tbody tr:hover{background:#f3f6fa}\
.verdict{display:inline-block;border-radius:10px;padding:0 9px;font-weight:600;font-size:12.5px}\
.pass{background:#dcefe2;color:#14532d}.fail{background:#f8dad7;color:#8c1d18}\
.precision{background:#dde8f6;color:#1c4478}.none{background:#e9ecf0;color:#4a5563}\
.pictures{display:grid;grid-template-columns:repeat(auto-fit,minmax(440px,1fr));gap:20px;margin-top:10px}\
figure{margin:0}figcaption{font-size:13px;color:#3c4855;margin-bottom:2px}\
figure>svg{width:100%;height:auto;display:block;font-size:11px;fill:#1c2733}\
.key{white-space:nowrap;margin-left:10px}\
.key i{display:inline-block;width:11px;height:11px;border-radius:50%;margin-right:4px;vertical-align:-1px}\
";

/// Head of the page.
pub(super) struct PageHead<'a> {
    pub(super) truth: &'a str,
    pub(super) tracks: &'a str,
    /// Settings in words.
    pub(super) settings: &'a str,
}

/// Returns the page.
pub(super) fn page(head: &PageHead<'_>, card: &Scorecard, areas: &[ScoredArea]) -> String {
    let mut page = format!(
        "<!DOCTYPE html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>Scorecard</title>\
         <meta name=\"viewport\" content=\"width=device-width\"><style>{STYLE}</style></head><body><main>\
         <h1>Scorecard</h1><p>Tracks <b>{}</b>, compared with <b>{}</b></p><p><b>{}</b></p>\
         <p class=\"quiet\">{}</p>",
        escaped(head.tracks),
        escaped(head.truth),
        about(card.reference),
        escaped(head.settings),
    );
    let cards = std::iter::once((&card.all, None)).chain(card.areas.iter().zip(areas.iter().map(Some)));
    for (area, outline) in cards {
        let inside = |error: &&ErrorSample| outline.is_none_or(|outline| outline.outline.contains(error.place_m));
        let errors: Vec<&ErrorSample> = card.errors.iter().filter(inside).collect();
        write_card(&mut page, area, &errors, card, areas);
    }
    page.push_str("</main></body></html>\n");
    page
}

fn write_card(page: &mut String, card: &AreaCard, errors: &[&ErrorSample], of: &Scorecard, areas: &[ScoredArea]) {
    let kind = card.kind.map_or_else(String::new, |kind| format!(" ({})", kind.word));
    let name = card.name.as_deref().unwrap_or("Everything");
    // Writing to a string cannot fail.
    let _ = write!(
        page,
        "<section><h2>{}{kind}</h2><p class=\"quiet\">{} targets, {} target-seconds, {} of them with a track</p>",
        escaped(name),
        card.targets,
        card.target_seconds,
        card.phases.0[0].n,
    );
    for advice in advice(card, of.gate_m) {
        let _ = write!(page, "<p><b>{advice}</b></p>");
    }
    for standard in &card.standards {
        write_standard(page, standard, of.reference);
    }
    if errors.is_empty() {
        page.push_str("<p>No target counts here.</p></section>");
        return;
    }
    page.push_str("<div class=\"pictures\">");
    for (caption, svg) in pictures::of_card(card, errors, areas) {
        let _ = write!(page, "<figure><figcaption>{caption}</figcaption>{svg}</figure>");
    }
    page.push_str("</div>");
    write_phases(page, card);
    page.push_str("</section>");
}

fn write_standard(page: &mut String, standard: &StandardCard, reference: CardReference) {
    let count = |verdict: LineVerdict| standard.lines.iter().filter(|line| line.verdict == verdict).count();
    let summary = match reference {
        CardReference::Smoothed => format!("{} lines with a limit, none judged", count(LineVerdict::PrecisionOnly)),
        _ => format!("{} pass, {} fail", count(LineVerdict::Pass), count(LineVerdict::Fail)),
    };
    let _ = write!(
        page,
        "<h3>{} — {summary}</h3><div class=\"scroll\"><table><thead><tr><th>line</th><th>figure</th><th>limit</th>\
         <th>cases</th><th>verdict</th><th class=\"text\">meaning, and source of the limit</th></tr></thead><tbody>",
        standard.title
    );
    for line in &standard.lines {
        let class = match line.verdict {
            LineVerdict::Pass => "pass",
            LineVerdict::Fail => "fail",
            LineVerdict::PrecisionOnly => "precision",
            LineVerdict::NoLimitKnown | LineVerdict::NotMeasured => "none",
        };
        let figure = line.figure.map_or_else(|| "–".to_owned(), digits);
        let limit = line
            .limit
            .map_or_else(|| "–".to_owned(), |limit| escaped(&limit_text(limit)));
        let mut text = escaped(&meaning(line));
        if let Some(remark) = remark(line) {
            let _ = write!(text, "; <b>{remark}</b>");
        }
        if !line.source.is_empty() {
            let _ = write!(text, "<br><span class=\"quiet\">{}</span>", escaped(line.source));
        }
        let _ = write!(
            page,
            "<tr><td>{}</td><td>{figure} {}</td><td>{limit}</td><td>{}</td><td><span class=\"verdict {class}\">{}</span>\
             </td><td class=\"text\">{text}</td></tr>",
            line.name,
            line.unit,
            line.samples,
            line.verdict.word(),
        );
    }
    page.push_str("</tbody></table></div>");
}

/// Quantities of the table of phases: name with unit, and the spread.
type Quantity = (&'static str, fn(&PhaseFigures) -> &ErrorSpread);

const QUANTITIES: [Quantity; 8] = [
    ("position, m", |figures| &figures.position),
    ("along the course, m", |figures| &figures.along),
    ("across, m", |figures| &figures.across),
    ("height, m", |figures| &figures.height),
    ("heading, deg", |figures| &figures.heading_deg),
    ("speed, m/s", |figures| &figures.speed),
    ("velocity, m/s", |figures| &figures.velocity),
    ("climb rate, m/s", |figures| &figures.climb),
];

fn write_phases(page: &mut String, card: &AreaCard) {
    page.push_str(
        "<h3>Errors by phase</h3><div class=\"scroll\"><table><thead><tr><th>phase</th><th class=\"text\">error</th><th>cases</th>\
         <th>mean</th><th>RMS</th><th>50 %</th><th>90 %</th><th>95 %</th><th>99 %</th></tr></thead><tbody>",
    );
    let shown = || {
        MOVEMENT_PHASES
            .iter()
            .zip(&card.phases.0)
            .filter(|(_, figures)| figures.n > 0)
    };
    for (phase, figures) in shown() {
        for (row, (quantity, spread)) in QUANTITIES.iter().enumerate() {
            let spread = spread(figures);
            let first = match row {
                0 => format!(
                    "<td class=\"phase\" rowspan=\"{}\"><b>{}</b><br><span class=\"quiet\">{}</span></td>",
                    QUANTITIES.len(),
                    phase.name,
                    wrapped(phase.meaning)
                ),
                _ => String::new(),
            };
            let cells = [spread.mean, spread.rms, spread.p50, spread.p90, spread.p95, spread.p99];
            let cells: String = cells.into_iter().map(cell).collect();
            let _ = write!(
                page,
                "<tr>{first}<td class=\"text\">{quantity}</td><td>{}</td>{cells}</tr>",
                spread.n
            );
        }
    }
    page.push_str(
        "</tbody></table></div><h3>Consistency of the covariances by phase</h3><p class=\"quiet\">NEES: mean squared \
         error over the stated variance, per degree of freedom. 1 is honest, above 1 too confident, below 1 too timid. \
         In brackets: share of the errors inside the 95 % region. The likeliest case of a track is straight flight, or a \
         constant climb rate, unless a manoeuvre is more probable.</p><div class=\"scroll\"><table><thead><tr>\
         <th>phase</th><th>cases</th><th>position</th><th>velocity</th><th>height</th><th>climb rate</th><th>velocity, likeliest</th><th>climb rate, likeliest</th></tr></thead>\
         <tbody>",
    );
    for (phase, figures) in shown() {
        let groups = &figures.consistency;
        let all = [
            groups.position,
            groups.velocity,
            groups.height,
            groups.climb,
            groups.likeliest_velocity,
            groups.likeliest_climb,
        ];
        let group = |nees: Option<f64>, in95: Option<f64>| match nees.zip(in95) {
            Some((nees, in95)) => format!("<td>{nees:.2} ({:.1} %)</td>", in95 * 100.0),
            None => "<td>–</td>".to_owned(),
        };
        let cells: String = all.iter().map(|of| group(of.nees, of.in95)).collect();
        let _ = write!(
            page,
            "<tr><td>{}</td><td>{}</td>{cells}</tr>",
            phase.name, groups.position.n
        );
    }
    page.push_str("</tbody></table></div>");
}

fn cell(value: Option<f64>) -> String {
    format!(
        "<td>{}</td>",
        value.map_or_else(|| "–".to_owned(), |value| format!("{value:.1}"))
    )
}

/// Breaks a text after some words, for a narrow column.
fn wrapped(text: &str) -> String {
    let mut lines = String::new();
    let mut width = 0;
    for word in text.split(' ') {
        if width + word.len() > 26 {
            lines.push_str("<br>");
            width = 0;
        } else if width > 0 {
            lines.push(' ');
        }
        width += word.len() + 1;
        lines.push_str(word);
    }
    lines
}
