//! Distribution in the standard percentile format (`.hgrm`), which HdrHistogram's plotter reads.

use std::io::{self, Write};

use hdrhistogram::Histogram;

/// Lines per halving of the distance to 100 %, as by default in the format's tools.
const TICKS_PER_HALF_DISTANCE: u32 = 5;

/// Writes `histogram` with its values divided by `divisor` (1,000: microseconds).
///
/// # Errors
/// Errors of the writer.
pub fn write_percentiles(mut writer: impl Write, histogram: &Histogram<u64>, divisor: f64) -> io::Result<()> {
    writeln!(
        writer,
        "{:>12} {:>14} {:>10} {:>14}\n",
        "Value", "Percentile", "TotalCount", "1/(1-Percentile)"
    )?;
    let mut count = 0;
    for step in histogram.iter_quantiles(TICKS_PER_HALF_DISTANCE) {
        count += step.count_since_last_iteration();
        let value = step.value_iterated_to() as f64 / divisor;
        let quantile = step.quantile_iterated_to();
        write!(writer, "{value:12.3} {quantile:1.12} {count:10}")?;
        if quantile < 1.0 {
            write!(writer, " {:14.2}", 1.0 / (1.0 - quantile))?;
        }
        writeln!(writer)?;
    }
    writeln!(
        writer,
        "#[Mean    = {:12.3}, StdDeviation   = {:12.3}]",
        histogram.mean() / divisor,
        histogram.stdev() / divisor
    )?;
    writeln!(
        writer,
        "#[Max     = {:12.3}, Total count    = {:12}]",
        histogram.max() as f64 / divisor,
        histogram.len()
    )?;
    // Sub-buckets hold two values to the last of the significant digits, as the format counts them.
    let sub_buckets = (2 * 10u64.pow(u32::from(histogram.sigfig()))).next_power_of_two();
    writeln!(
        writer,
        "#[Buckets = {:12}, SubBuckets     = {:12}]",
        histogram.buckets(),
        sub_buckets
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn written_as_the_format_has_it() {
        let mut histogram = Histogram::new(3).expect("possible");
        for value in 1..=1000u64 {
            histogram.record(value * 1000).expect("grows");
        }
        let mut bytes = Vec::new();
        write_percentiles(&mut bytes, &histogram, 1000.0).expect("in memory");
        let text = String::from_utf8(bytes).expect("text");
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "       Value     Percentile TotalCount 1/(1-Percentile)");
        assert_eq!(lines[1], "");
        assert_eq!(lines[2], "       1.000 0.000000000000          1           1.00");
        let median = lines
            .iter()
            .find(|line| line.contains(" 0.500000000000 "))
            .expect("the median has a line");
        assert_eq!(*median, "     500.223 0.500000000000        500           2.00");
        let end = lines.len() - 4;
        assert_eq!(lines[end], "    1000.447 1.000000000000       1000");
        assert_eq!(
            lines[end + 1],
            "#[Mean    =      500.505, StdDeviation   =      288.676]"
        );
        assert_eq!(
            lines[end + 2],
            "#[Max     =     1000.447, Total count    =         1000]"
        );
        assert_eq!(
            lines[end + 3],
            "#[Buckets =           10, SubBuckets     =         2048]"
        );
    }

    #[test]
    fn nothing_recorded() {
        let histogram = Histogram::new(3).expect("possible");
        let mut bytes = Vec::new();
        write_percentiles(&mut bytes, &histogram, 1.0).expect("in memory");
        let text = String::from_utf8(bytes).expect("text");
        assert!(text.contains("Total count    =            0"), "{text}");
    }
}
