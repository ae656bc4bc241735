//! Drawing area of a chart (SVG): axes with ticks, and elements in the units of the axes.

use std::fmt::{self, Write as _};
use std::ops::Range;

/// Colours that are distinct with all kinds of sight, and on paper.
pub(super) const INK: &str = "#1c2733";
pub(super) const FAINT: &str = "#d5dbe1";
pub(super) const BLUE: &str = "#1f5fa8";
pub(super) const TEAL: &str = "#0f8b8d";
pub(super) const ORANGE: &str = "#d9822b";
pub(super) const RED: &str = "#b3261e";

/// Margins: left, top, right, bottom, pixels.
const MARGIN: [f64; 4] = [80.0, 14.0, 18.0, 44.0];
/// Approximate number of ticks of a linear axis.
const TICKS: f64 = 6.0;

/// Axis of a chart.
#[derive(Clone, Debug)]
pub(super) struct ChartAxis {
    range: Range<f64>,
    is_logarithmic: bool,
    has_ticks: bool,
    pixels: Range<f64>,
    title: &'static str,
}

impl ChartAxis {
    pub(super) fn linear(range: Range<f64>, title: &'static str) -> Self {
        Self::new(range, title, false)
    }

    /// The range must be positive.
    pub(super) fn logarithmic(range: Range<f64>, title: &'static str) -> Self {
        Self::new(range, title, true)
    }

    fn new(range: Range<f64>, title: &'static str, is_logarithmic: bool) -> Self {
        Self {
            range,
            is_logarithmic,
            has_ticks: true,
            pixels: 0.0..0.0,
            title,
        }
    }

    /// Leaves out ticks, for an axis of names.
    pub(super) fn without_ticks(self) -> Self {
        Self {
            has_ticks: false,
            ..self
        }
    }

    /// Returns the pixel of a value; values beyond the axis are at the axis's ends.
    fn pixel(&self, value: f64) -> f64 {
        self.unlimited(value.clamp(self.range.start, self.range.end))
    }

    fn unlimited(&self, value: f64) -> f64 {
        let at = |value: f64| if self.is_logarithmic { value.ln() } else { value };
        let (low, high) = (at(self.range.start), at(self.range.end));
        self.pixels.start + (at(value) - low) / (high - low) * (self.pixels.end - self.pixels.start)
    }

    /// Returns the values with a tick: on a logarithmic axis 1, 2 and 5 times the powers of ten.
    fn ticks(&self) -> Vec<f64> {
        if !self.has_ticks {
            return Vec::new();
        }
        let Range { start, end } = self.range;
        if self.is_logarithmic {
            let powers = (start.log10().floor() as i32)..=(end.log10().ceil() as i32);
            let all = powers.flat_map(|power| [1.0, 2.0, 5.0].map(|digit| digit * 10f64.powi(power)));
            return all
                .filter(|value| (start * 0.999..=end * 1.001).contains(value))
                .collect();
        }
        let rough = (end - start) / TICKS;
        let power = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|digit| digit * power);
        let step = step.into_iter().find(|step| *step >= rough).unwrap_or(rough);
        let (first, last) = ((start / step).ceil() as i64, (end / step + 1e-9).floor() as i64);
        (first..=last).map(|number| number as f64 * step).collect()
    }
}

/// Chart that grows element by element.
#[derive(Debug)]
pub(super) struct Chart {
    svg: String,
    size: [f64; 2],
    x: ChartAxis,
    y: ChartAxis,
}

impl Chart {
    /// Begins a chart of this size in pixels. `label` is the title for screen readers.
    pub(super) fn new(label: &str, size: [f64; 2], mut x: ChartAxis, mut y: ChartAxis) -> Self {
        let [left, top, right, bottom] = MARGIN;
        x.pixels = left..size[0] - right;
        y.pixels = size[1] - bottom..top;
        let mut chart = Self {
            svg: format!(
                "<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">",
                size[0],
                size[1],
                escaped(label)
            ),
            size,
            x,
            y,
        };
        chart.axes();
        chart
    }

    /// Returns the finished SVG.
    pub(super) fn finish(mut self) -> String {
        self.svg.push_str("</svg>");
        self.svg
    }

    fn axes(&mut self) {
        let (left, right) = (self.x.pixels.start, self.x.pixels.end);
        let (bottom, top) = (self.y.pixels.start, self.y.pixels.end);
        for value in self.x.ticks() {
            let x = self.x.pixel(value);
            self.put(format_args!(
                "<path d=\"M{x:.1} {top:.1}V{bottom:.1}\" stroke=\"{FAINT}\"/><text x=\"{x:.1}\" y=\"{:.1}\" \
                 text-anchor=\"middle\">{}</text>",
                bottom + 16.0,
                tick(value)
            ));
        }
        for value in self.y.ticks() {
            let y = self.y.pixel(value);
            self.put(format_args!(
                "<path d=\"M{left:.1} {y:.1}H{right:.1}\" stroke=\"{FAINT}\"/><text x=\"{:.1}\" y=\"{:.1}\" \
                 text-anchor=\"end\">{}</text>",
                left - 6.0,
                y + 4.0,
                tick(value)
            ));
        }
        let (x_title, y_title, size) = (self.x.title, self.y.title, self.size);
        let middle = 0.5 * (bottom + top);
        self.put(format_args!(
            "<path d=\"M{left:.1} {top:.1}V{bottom:.1}H{right:.1}\" stroke=\"{INK}\" fill=\"none\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{x_title}</text>\
             <text transform=\"translate(14 {middle:.1}) rotate(-90)\" text-anchor=\"middle\">{y_title}</text>",
            0.5 * (left + right),
            size[1] - 8.0,
        ));
    }

    /// Draws a line through points.
    pub(super) fn line(&mut self, points: impl Iterator<Item = [f64; 2]>, style: &str) {
        let path: Vec<String> = points
            .map(|[x, y]| format!("{:.1} {:.1}", self.x.pixel(x), self.y.pixel(y)))
            .collect();
        if path.len() > 1 {
            self.put(format_args!("<path d=\"M{}\" fill=\"none\" {style}/>", path.join("L")));
        }
    }

    /// Fills a closed line, except for the holes; parts beyond the axes are cut off.
    pub(super) fn outline(&mut self, rings: &[Vec<[f64; 2]>], style: &str) {
        let (left, top) = (self.x.pixels.start, self.y.pixels.end);
        let (width, height) = (self.x.pixels.end - left, self.y.pixels.start - top);
        let ring = |ring: &Vec<[f64; 2]>| {
            let pixels = |[x, y]: &[f64; 2]| [self.x.unlimited(*x) - left, self.y.unlimited(*y) - top];
            let points = ring.iter().map(pixels).map(|[x, y]| format!("{x:.1} {y:.1}"));
            format!("M{}Z", points.collect::<Vec<_>>().join("L"))
        };
        let path: String = rings.iter().map(ring).collect();
        self.put(format_args!(
            "<svg x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"{height:.1}\">\
             <path d=\"{path}\" fill-rule=\"evenodd\" {style}/></svg>"
        ));
    }

    /// Draws a dot, with a text that a pointer shows.
    pub(super) fn dot(&mut self, [x, y]: [f64; 2], radius: f64, colour: &str, shown: &str) {
        let (x, y) = (self.x.pixel(x), self.y.pixel(y));
        let title = match shown {
            "" => String::new(),
            shown => format!("<title>{}</title>", escaped(shown)),
        };
        self.put(format_args!(
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\" fill=\"{colour}\">{title}</circle>"
        ));
    }

    /// Writes text beside a point, `shift` pixels off.
    pub(super) fn text(&mut self, [x, y]: [f64; 2], shift: [f64; 2], anchor: &str, text: &str) {
        let (x, y) = (self.x.pixel(x) + shift[0], self.y.pixel(y) + shift[1]);
        self.put(format_args!(
            "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{}</text>",
            escaped(text)
        ));
    }

    fn put(&mut self, element: fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = self.svg.write_fmt(element);
    }
}

/// Returns a text for HTML.
pub(super) fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            letter => escaped.push(letter),
        }
    }
    escaped
}

fn tick(value: f64) -> String {
    // A sum of steps may be almost zero.
    let value = if value.abs() < 1e-9 { 0.0 } else { value };
    crate::printed::digits(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers_within_the_range() {
        assert_eq!(ChartAxis::linear(0.0..47.0, "").ticks(), [0.0, 10.0, 20.0, 30.0, 40.0]);
        assert_eq!(ChartAxis::linear(-1.0..1.0, "").ticks(), [-1.0, -0.5, 0.0, 0.5, 1.0]);
        assert_eq!(
            ChartAxis::logarithmic(0.5..30.0, "").ticks(),
            [0.5, 1.0, 2.0, 5.0, 10.0, 20.0]
        );
    }

    #[test]
    fn names_cannot_end_an_element() {
        assert_eq!(escaped("a<b> & \"c\""), "a&lt;b&gt; &amp; &quot;c&quot;");
        let axis = || ChartAxis::linear(0.0..10.0, "x, m");
        let mut chart = Chart::new("\"><script>", [300.0, 200.0], axis(), axis());
        chart.text([0.0, 10.0], [0.0, 0.0], "start", "</svg>");
        chart.dot([5.0, 20.0], 3.0, BLUE, "<5");
        let far = || vec![[-90.0, 0.0], [90.0, 0.0], [0.0, 90.0]];
        chart.outline(&[far()], "");
        let svg = chart.finish();
        assert!(!svg.contains("<script>") && svg.matches("</svg>").count() == 2, "{svg}");
        // Beyond the axis at the axis's end, 14 pixels below the top.
        assert!(
            svg.contains("cy=\"14.0\"") && svg.contains("<title>&lt;5</title>"),
            "{svg}"
        );
    }
}
