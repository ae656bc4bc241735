//! Areas with scorecards of their own, from a file.

use std::path::Path;

use ::areas::{AreaError, Ground};
use frames::{Geodetic, SystemFrame};
use scoring::{AreaKind, ScoredArea};

use crate::files::InputError;
use crate::host::Host;

/// Reads the areas of a file in the frame with this origin.
///
/// # Errors
/// If the file has no areas, or an area has a kind that no standard knows.
pub(super) fn read(host: &dyn Host, file: &Path, origin: Geodetic) -> Result<Vec<ScoredArea>, InputError> {
    let text = host.text(file)?;
    let ground = Ground::of(SystemFrame::at(origin));
    let areas = ::areas::read(&text, &ground).and_then(|areas| areas.into_iter().map(scored).collect());
    areas.map_err(|fault: AreaError| InputError::new(file, fault.0))
}

fn scored(area: ::areas::Area) -> Result<ScoredArea, AreaError> {
    let of_word = |word: String| {
        AreaKind::from_word(&word).ok_or_else(|| {
            let words = AreaKind::ALL.map(|kind| kind.word).join(", ");
            AreaError(format!(
                "{}: the kind \"{word}\" is unknown; kinds are {words}",
                area.name
            ))
        })
    };
    Ok(ScoredArea {
        kind: area.kind.map(of_word).transpose()?,
        name: area.name.clone(),
        outline: area.outline,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kind_that_no_standard_knows_is_refused_with_all_that_are_known() {
        let ground = Ground::of(SystemFrame::at(Geodetic::from_degrees(41.3, 2.1, 0.0).unwrap()));
        let areas = |kind: &str| {
            let text = format!(
                r#"{{"type": "Feature", "properties": {{"name": "Lake", "kind": "{kind}"}}, "geometry": {{"type":
                "Polygon", "coordinates": [[[2.08, 41.29], [2.11, 41.29], [2.11, 41.31], [2.08, 41.29]]]}}}}"#
            );
            ::areas::read(&text, &ground).unwrap().remove(0)
        };
        assert_eq!(scored(areas("runway")).unwrap().kind, Some(AreaKind::RUNWAY));
        let fault = scored(areas("lake")).unwrap_err().0;
        assert!(
            fault.contains("Lake: the kind \"lake\" is unknown; kinds are manoeuvring, runway"),
            "{fault}"
        );
    }
}
