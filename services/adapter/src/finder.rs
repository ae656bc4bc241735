//! The direction finder of a source, as its locator takes the reports.

use deployment::Source;
use formats::observation::{DirectionFinder, FinderRefusal, FinderReports};
use sources::SourceReading;

/// The reports of the finder of a source with a locator; `None` of another source.
pub(crate) fn finder_reports(source: &Source, reading: &SourceReading) -> Option<FinderReports> {
    let (model, locator) = (&reading.model, reading.processing.locator()?);
    let place = model.system.to_geodetic(model.frame.cartesian([0.0; 3]));
    let finder = DirectionFinder::new(&model.system, place, locator.bearing_sigma_deg.rad())?;
    let is_placed = source.stated_place_deg.is_some();
    Some(FinderReports::new(finder, is_placed, model.sac_sic))
}

/// A refusal in words, with the remedy in the configuration.
pub(crate) fn in_words(refusal: FinderRefusal) -> String {
    match refusal {
        FinderRefusal::Position => format!("{refusal}; state [source.place]"),
        _ => refusal.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_place_has_a_remedy() {
        assert!(in_words(FinderRefusal::Position).ends_with("are missing; state [source.place]"));
        assert!(!in_words(FinderRefusal::Time).contains("source.place"));
    }
}
