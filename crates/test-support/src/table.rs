//! Tables as commands write them: a header, and values apart by commas.

/// Places of the columns of these names in a header.
///
/// # Panics
/// If there is none of a name.
pub fn places<const N: usize>(header: &str, names: [&str; N]) -> [usize; N] {
    names.map(|name| {
        let place = header.split(',').position(|found| found == name);
        place.unwrap_or_else(|| panic!("no column {name} in {header}"))
    })
}

/// The values of the columns of these names, row by row.
///
/// # Panics
/// If there is no column of a name.
pub fn rows<const N: usize>(text: &str, names: [&str; N]) -> Vec<[String; N]> {
    let mut lines = text.lines();
    let places = places(lines.next().unwrap_or_default(), names);
    let row = |line: &str| {
        let values: Vec<&str> = line.split(',').collect();
        places.map(|place| values[place].to_owned())
    };
    lines.map(row).collect()
}

/// The values of the column of this name.
///
/// # Panics
/// If there is none.
pub fn column(text: &str, name: &str) -> Vec<String> {
    rows(text, [name]).into_iter().flatten().collect()
}

/// The values of a column of numbers.
///
/// # Panics
/// If there is no such column, or something else in it.
pub fn numbers(text: &str, name: &str) -> Vec<f64> {
    let values = column(text, name).into_iter();
    values.map(|value| value.parse().expect("a number")).collect()
}

/// Seconds from 1970 to the midnight to which [`since_1970`] moves times.
pub const MIDNIGHT_S: i64 = 20_000 * 86_400;

/// The table with the times of these columns, whole seconds of which count from a midnight, counted from 1970.
///
/// # Panics
/// If a value begins with no whole number.
pub fn since_1970(text: &str, columns: &[&str]) -> String {
    let (header, rows) = text.split_once('\n').expect("a header line");
    let is_time: Vec<bool> = header.split(',').map(|name| columns.contains(&name)).collect();
    let moved = |(value, is_time): (&str, &bool)| match value.split_once('.').unwrap_or((value, "")) {
        _ if !is_time || value.is_empty() => value.to_owned(),
        (whole, decimals) => {
            let whole: i64 = whole.parse().expect("a whole number of seconds");
            let point = if decimals.is_empty() { "" } else { "." };
            format!("{}{point}{decimals}", MIDNIGHT_S + whole)
        }
    };
    let row = |row: &str| -> String { row.split(',').zip(&is_time).map(moved).collect::<Vec<_>>().join(",") + "\n" };
    format!("{header}\n{}", rows.lines().map(row).collect::<String>())
}
