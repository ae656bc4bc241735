//! Files of the page, embedded in the executable.

/// A file of the page: name, media type, content.
pub(crate) type Asset = (&'static str, &'static str, &'static [u8]);

macro_rules! assets {
    ($($name:literal)*) => {
        &[$( ($name, media_type($name), include_bytes!(concat!("../page/", $name))) ),*]
    };
}

/// Embedded files, all from one folder.
pub(crate) const ASSETS: &[Asset] = assets! {
    "alarms.js"
    "app.js"
    "coast.bin"
    "colours.js"
    "connection.js"
    "controls.css"
    "controls.js"
    "coverage.js"
    "display.css"
    "dom.js"
    "fans.js"
    "favicon.svg"
    "filter.js"
    "geodesy.js"
    "ground.js"
    "header.js"
    "index.html"
    "kept.js"
    "labels.js"
    "layers.js"
    "lettering.js"
    "lines.js"
    "main.js"
    "maps.js"
    "measuring.js"
    "nudge.js"
    "occupancy.js"
    "operator.js"
    "orders.js"
    "painter.js"
    "panels.js"
    "picture.js"
    "placement.js"
    "plots.js"
    "search.js"
    "settings.js"
    "side.js"
    "stations.js"
    "surround.js"
    "table.js"
    "tabs.js"
    "trails.js"
    "view.js"
    "why.js"
    "window.js"
    "wire.js"
};

/// Returns the media type for the extension of `name`.
const fn media_type(name: &str) -> &'static str {
    match name.as_bytes() {
        [.., b'.', b'j', b's'] => "text/javascript; charset=utf-8",
        [.., b'.', b'c', b's', b's'] => "text/css; charset=utf-8",
        [.., b'.', b'h', b't', b'm', b'l'] => "text/html; charset=utf-8",
        [.., b'.', b's', b'v', b'g'] => "image/svg+xml",
        _ => "application/octet-stream",
    }
}

/// Returns the file `name`.
pub(crate) fn asset(name: &str) -> Option<&'static Asset> {
    ASSETS.iter().find(|(known, ..)| *known == name)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn folder() -> std::path::PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("page")
    }

    #[test]
    fn every_file_of_the_page_is_served() {
        for entry in std::fs::read_dir(folder()).unwrap() {
            let name = entry.unwrap().file_name().into_string().unwrap();
            assert!(asset(&name).is_some(), "{name} is not listed in assets.rs");
        }
    }

    #[test]
    fn the_reader_of_pictures_is_that_of_the_tables() {
        test_support::assert_golden(&folder().join("wire.js"), &messages::picture::javascript_module());
    }
}
