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
