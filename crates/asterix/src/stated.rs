//! The tables by which somebody's records are read, as a configuration states them.

use super::decoder::Decoder;
use super::mode::Mode;
use super::registry;
use super::table::{Category, Edition};

/// Tables of stated editions; other categories are read by their default editions.
#[derive(Clone, Debug)]
pub struct StatedTables {
    tables: Vec<&'static Category>,
    mode: Mode,
}

impl StatedTables {
    /// Tables of these categories, each with the numbers before and behind the edition's point. Editions without table
    /// are left out; [`stated`] refuses them. With `is_strict`, records must follow their edition closely.
    pub fn new(editions: &[(u8, [u8; 2])], is_strict: bool) -> Self {
        let table = |(number, [major, minor]): &(u8, [u8; 2])| registry::find(*number, Edition::new(*major, *minor));
        Self {
            tables: editions.iter().filter_map(table).collect(),
            mode: if is_strict { Mode::Strict } else { Mode::Lenient },
        }
    }

    /// The tables of stated editions.
    pub fn tables(&self) -> &[&'static Category] {
        &self.tables
    }

    /// How closely records must follow their edition.
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// Table that a category is read by; `None` if there is none.
    pub fn table(&self, category: u8) -> Option<&'static Category> {
        let stated = self.tables.iter().find(|table| table.number == category).copied();
        stated.or_else(|| registry::default_edition(category))
    }

    /// A decoder that reads so.
    pub fn decoder(&self) -> Decoder {
        let decoder = Decoder::new(self.mode);
        self.tables
            .iter()
            .fold(decoder, |decoder, table| decoder.with_table(table))
    }
}

/// Returns the table of a category's edition, or of its default edition.
///
/// # Errors
/// If there is none: a sentence with the editions that there are.
pub fn stated(number: u8, edition: Option<&str>) -> Result<&'static Category, String> {
    let Some(edition) = edition else {
        return registry::default_edition(number).ok_or_else(|| format!("category {number} is not known"));
    };
    let table = edition
        .parse::<Edition>()
        .ok()
        .and_then(|edition| registry::find(number, edition));
    table.ok_or_else(|| {
        let mut known: Vec<String> = registry::editions(number).map(ToString::to_string).collect();
        if known.is_empty() {
            known = registry::defaults().map(ToString::to_string).collect();
        }
        format!(
            "category {number} edition \"{edition}\" is not known; there are: {}",
            known.join(", ")
        )
    })
}
