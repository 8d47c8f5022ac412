//! A table of results: printed as Markdown, written as JSON.

/// Rows of text under named columns.
pub struct Table {
    /// What the table shows, with the paper's name for it.
    pub title: String,
    /// Column heads.
    pub columns: Vec<String>,
    /// Cells, each row as long as `columns`.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// An empty table.
    pub fn new(title: impl Into<String>, columns: &[&str]) -> Self {
        let columns = columns.iter().map(|column| (*column).to_owned()).collect();
        Self { title: title.into(), columns, rows: Vec::new() }
    }

    /// Adds a row; panics if it has another number of cells than there are columns.
    pub fn row(&mut self, cells: Vec<String>) {
        assert_eq!(cells.len(), self.columns.len(), "a row of «{}»", self.title);
        self.rows.push(cells);
    }

    /// A GitHub-flavoured Markdown table under its title, cells padded to line up.
    pub fn to_markdown(&self) -> String {
        let widths: Vec<usize> = (0..self.columns.len())
            .map(|c| {
                self.rows.iter().map(|row| &row[c]).chain([&self.columns[c]]).map(|s| s.chars().count()).max()
            })
            .map(|width| width.unwrap_or(0).max(3))
            .collect();
        let line = |cells: &[String]| {
            let padded = cells.iter().zip(&widths).map(|(cell, &width)| format!(" {cell:>width$} "));
            format!("|{}|\n", padded.collect::<Vec<_>>().join("|"))
        };
        let rule: String = widths.iter().map(|width| format!("|{}:", "-".repeat(width + 1))).collect();
        let rows: String = self.rows.iter().map(|row| line(row)).collect();
        format!("**{}**\n\n{}{rule}|\n{rows}", self.title, line(&self.columns))
    }

    /// `{"title", "columns", "rows"}`.
    pub fn to_json(&self) -> serde_json::Value {
        serde_json::json!({ "title": self.title, "columns": self.columns, "rows": self.rows })
    }
}
