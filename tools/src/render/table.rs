//! Tables for people: they fit 80 columns and are readable without colour.

use comfy_table::{Cell, CellAlignment, ColumnConstraint, ContentArrangement, Row, Table, presets};

/// Columns of the terminal that a table may take.
pub(crate) const WIDTH: u16 = 80;

/// A table under construction.
#[derive(Debug)]
pub struct Columns {
    table: Table,
    right: Vec<usize>,
}

impl Columns {
    /// A table with these headings; without headings it is a list of names and values.
    #[must_use]
    pub fn new(headings: &[&str]) -> Self {
        let mut table = Table::new();
        table
            .load_preset(presets::NOTHING)
            .set_content_arrangement(ContentArrangement::Dynamic)
            .set_width(WIDTH);
        if !headings.is_empty() {
            table.set_header(headings.iter().map(|heading| heading.to_uppercase()));
        }
        Self { table, right: Vec::new() }
    }

    /// Aligns these columns to the right, for figures.
    #[must_use]
    pub fn figures(mut self, columns: &[usize]) -> Self {
        self.right = columns.to_vec();
        self
    }

    /// Adds a row.
    pub fn row<T: Into<String>>(&mut self, cells: impl IntoIterator<Item = T>) {
        let cells = cells.into_iter().enumerate().map(|(at, text)| {
            let aligned = if self.right.contains(&at) { CellAlignment::Right } else { CellAlignment::Left };
            Cell::new(text.into()).set_alignment(aligned)
        });
        let cells: Vec<_> = cells.collect();
        self.table.add_row(Row::from(cells));
    }

    /// Adds a name with its value.
    pub fn fact(&mut self, name: &str, value: impl Into<String>) {
        self.row([name.to_owned(), value.into()]);
    }

    /// The text, ending in a line break. `whole` columns are never wrapped.
    #[must_use]
    pub fn text(mut self, whole: &[usize]) -> String {
        for (at, column) in self.table.column_iter_mut().enumerate() {
            column.set_padding((0, 2));
            if self.right.contains(&at) {
                column.set_cell_alignment(CellAlignment::Right);
            }
            if whole.contains(&at) {
                column.set_constraint(ColumnConstraint::ContentWidth);
            }
        }
        let lines = self.table.lines().map(|line| line.trim_end().to_owned()).collect::<Vec<_>>();
        lines.join("\n") + "\n"
    }
}
