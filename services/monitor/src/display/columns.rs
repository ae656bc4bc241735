//! Tables that leave out columns to fit.

use telemetry::table::{Align, TextTable};

/// Blanks between two columns.
const GAP: usize = 2;

/// Reader's judgement of a line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Tone {
    /// Normal.
    #[default]
    Plain,
    /// Worth a look.
    Warning,
    /// Something is wrong.
    Alarm,
}

/// Lines of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct TableLines {
    pub(crate) heading: String,
    pub(crate) rows: Vec<(Tone, String)>,
}

/// Table of text that must fit into a width.
#[derive(Clone, Debug)]
pub(crate) struct FittedTable {
    columns: Vec<ScreenColumn>,
    tones: Vec<Tone>,
}

#[derive(Clone, Debug)]
struct ScreenColumn {
    heading: String,
    align: Align,
    /// Rank by which columns are left out, largest first; 0: never.
    rank: u8,
    cells: Vec<String>,
}

impl FittedTable {
    /// A table without rows. Each column has a heading, an alignment, and a rank. Where there is too little room,
    /// columns are left out by rank, largest first; a column of rank 0 stays.
    pub(crate) fn new(columns: &[(&str, Align, u8)]) -> Self {
        let column = |(heading, align, rank): &(&str, Align, u8)| ScreenColumn {
            heading: (*heading).to_owned(),
            align: *align,
            rank: *rank,
            cells: Vec::new(),
        };
        Self {
            columns: columns.iter().map(column).collect(),
            tones: Vec::new(),
        }
    }

    /// Adds a row with a cell for each column.
    pub(crate) fn row<const N: usize>(&mut self, tone: Tone, cells: [String; N]) {
        debug_assert_eq!(self.columns.len(), N);
        self.tones.push(tone);
        for (column, cell) in self.columns.iter_mut().zip(cells) {
            column.cells.push(cell);
        }
    }

    /// The lines, at most `width` characters long unless the columns that always stay need more.
    pub(crate) fn lines(mut self, width: usize) -> TableLines {
        while self.width() > width {
            let least = self.columns.iter().map(|column| column.rank).max().unwrap_or(0);
            if least == 0 {
                break;
            }
            self.columns.retain(|column| column.rank != least);
        }
        let headings: Vec<(&str, Align)> = self
            .columns
            .iter()
            .map(|column| (column.heading.as_str(), column.align))
            .collect();
        let mut table = TextTable::new(&headings);
        for row in 0..self.tones.len() {
            table.row(self.columns.iter().map(|column| column.cells[row].as_str()));
        }
        let text = table.to_string();
        let mut lines = text.lines().map(str::to_owned);
        TableLines {
            heading: lines.next().unwrap_or_default(),
            rows: self.tones.into_iter().zip(lines).collect(),
        }
    }

    fn width(&self) -> usize {
        let widest = |column: &ScreenColumn| {
            let cells = column.cells.iter().chain([&column.heading]);
            cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
        };
        let columns: usize = self.columns.iter().map(widest).sum();
        columns + GAP * self.columns.len().saturating_sub(1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> FittedTable {
        let mut table = FittedTable::new(&[
            ("name", Align::Left, 0),
            ("seldom", Align::Right, 2),
            ("often", Align::Right, 1),
        ]);
        table.row(Tone::Plain, ["one", "1", "123456"].map(str::to_owned));
        table.row(Tone::Alarm, ["µµµµµ", "", "2"].map(str::to_owned));
        table
    }

    #[test]
    fn columns_are_left_out_by_their_rank() {
        let heading = |width| table().lines(width).heading;
        assert_eq!(heading(usize::MAX), "name   seldom   often");
        assert_eq!(heading(21), "name   seldom   often");
        assert_eq!(heading(20), "name    often");
        assert_eq!(heading(12), "name");
        assert_eq!(heading(0), "name");
        let rows = table().lines(13).rows;
        let expected = [(Tone::Plain, "one    123456"), (Tone::Alarm, "µµµµµ       2")];
        assert_eq!(rows, expected.map(|(tone, row)| (tone, row.to_owned())));
    }
}
