//! Declaration of the columns of a table: each column once, in the order of the header.
//!
//! [`columns!`] makes of one list the header line, the values of a row, and for tables that are read the places of
//! the columns in a header.

use std::io::{self, Read, Write};

use csv_table::{Column, CsvError, Table};

use crate::cells::Cell;
use crate::rows::Reference;

/// Names of one column or of successive columns.
pub(crate) trait ColumnNames {
    /// Returns the names, separated by commas.
    fn header(self) -> String;
}

/// Names of columns with the values `V`.
pub(crate) trait Named<V>: ColumnNames {
    /// Writes the values, separated by commas.
    ///
    /// # Errors
    /// If `out` fails.
    fn write(self, values: V, out: &mut impl Write, reference: &Reference) -> io::Result<()>;
}

impl ColumnNames for &'static str {
    fn header(self) -> String {
        self.to_owned()
    }
}

impl<const N: usize> ColumnNames for [&'static str; N] {
    fn header(self) -> String {
        self.join(",")
    }
}

impl<C: Cell> Named<C> for &'static str {
    fn write(self, cell: C, out: &mut impl Write, reference: &Reference) -> io::Result<()> {
        cell.write(out, reference)
    }
}

impl<C: Cell, const N: usize> Named<[C; N]> for [&'static str; N] {
    fn write(self, cells: [C; N], out: &mut impl Write, reference: &Reference) -> io::Result<()> {
        for (index, cell) in cells.into_iter().enumerate() {
            if index > 0 {
                out.write_all(b",")?;
            }
            cell.write(out, reference)?;
        }
        Ok(())
    }
}

/// Place of a column, or of successive columns, in a header.
pub(crate) trait ColumnPlace<N>: Sized {
    /// Finds the columns of these names.
    ///
    /// # Errors
    /// If a required column is missing, or the header names a column more than once.
    fn find<R: Read>(table: &Table<R>, names: N) -> Result<Self, CsvError>;
}

impl ColumnPlace<&'static str> for Column {
    fn find<R: Read>(table: &Table<R>, name: &'static str) -> Result<Self, CsvError> {
        table.required(name)
    }
}

impl ColumnPlace<&'static str> for Option<Column> {
    fn find<R: Read>(table: &Table<R>, name: &'static str) -> Result<Self, CsvError> {
        table.optional(name)
    }
}

impl<const N: usize> ColumnPlace<[&'static str; N]> for [Column; N] {
    fn find<R: Read>(table: &Table<R>, names: [&'static str; N]) -> Result<Self, CsvError> {
        table.all(names)
    }
}

impl<const N: usize> ColumnPlace<[&'static str; N]> for [Option<Column>; N] {
    fn find<R: Read>(table: &Table<R>, names: [&'static str; N]) -> Result<Self, CsvError> {
        let mut found = [None; N];
        for (place, name) in found.iter_mut().zip(names) {
            *place = table.optional(name)?;
        }
        Ok(found)
    }
}

impl<const N: usize> ColumnPlace<[&'static str; N]> for Option<[Column; N]> {
    fn find<R: Read>(table: &Table<R>, names: [&'static str; N]) -> Result<Self, CsvError> {
        match table.optional(names[0])? {
            Some(_) => table.all(names).map(Some),
            None => Ok(None),
        }
    }
}

/// Declares the columns of a table: `name => value`, in the order of the header. An array of names has an array of
/// values. `with Base = row` places the columns of another table first. For a table that is read, each column
/// also has a field, whose type states whether the column is required (`Column`) or optional (`Option<Column>`).
macro_rules! columns {
    ($row:ty: |$value:ident| with $base:ty = $inner:expr; $($name:expr => $cell:expr,)+) => {
        impl $crate::rows::Row for $row {
            fn columns() -> String {
                let mut header = <$base as $crate::rows::Row>::columns();
                $(
                    header.push(',');
                    header.push_str(&$crate::columns::ColumnNames::header($name));
                )+
                header
            }

            fn write(
                &self,
                out: &mut impl std::io::Write,
                reference: &$crate::rows::Reference,
            ) -> std::io::Result<()> {
                let $value = self;
                <$base as $crate::rows::Row>::write(&$inner, out, reference)?;
                $(
                    out.write_all(b",")?;
                    $crate::columns::Named::write($name, $cell, out, reference)?;
                )+
                Ok(())
            }
        }
    };
    ($row:ty: |$value:ident| $first:expr => $first_cell:expr, $($name:expr => $cell:expr,)*) => {
        impl $crate::rows::Row for $row {
            fn columns() -> String {
                [$crate::columns::ColumnNames::header($first), $($crate::columns::ColumnNames::header($name),)*].join(",")
            }

            fn write(
                &self,
                out: &mut impl std::io::Write,
                reference: &$crate::rows::Reference,
            ) -> std::io::Result<()> {
                let $value = self;
                $crate::columns::Named::write($first, $first_cell, out, reference)?;
                $(
                    out.write_all(b",")?;
                    $crate::columns::Named::write($name, $cell, out, reference)?;
                )*
                Ok(())
            }
        }
    };
    (
        $(#[doc = $doc:literal])+
        $places:ident of $row:ty: |$value:ident|
        $($field:ident: $found:ty = $name:expr => $cell:expr,)+
    ) => {
        $(#[doc = $doc])+
        #[derive(Clone, Copy, Debug)]
        pub(crate) struct $places {
            $( pub(crate) $field: $found, )+
        }

        impl $places {
            /// Finds the columns in the header of a table.
            ///
            /// # Errors
            /// If a required column is missing, or the header names a column more than once.
            pub(crate) fn find<R: std::io::Read>(
                table: &csv_table::Table<R>,
            ) -> Result<Self, csv_table::CsvError> {
                Ok(Self { $( $field: $crate::columns::ColumnPlace::find(table, $name)?, )+ })
            }
        }

        $crate::columns::columns! { $row: |$value| $($name => $cell,)+ }
    };
}
pub(crate) use columns;
