//! Tables as aligned Markdown, which is also readable in a terminal, and as HTML.
//!
//! Measure: none; cells are text.
//! Range: rows have as many cells as the header; a vertical bar within a cell is escaped, and a line break becomes a
//! space.
//! Source: GitHub Flavored Markdown, "Tables". Tested below.

use maud::{Markup, html};
use std::fmt::Write;

/// The alignment of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Alignment {
    /// Left-aligned words.
    Left,
    /// Right-aligned numbers.
    Right,
}

impl Alignment {
    /// Returns the CSS class of the cells.
    fn class(self) -> Option<&'static str> {
        (self == Self::Right).then_some("number")
    }
}

/// A table with its title and caption.
#[derive(Debug, Clone)]
pub struct Table {
    /// The title.
    pub title: String,
    /// The caption: what is shown, whether lower or higher is better, and the unit.
    pub caption: String,
    /// The names of the columns.
    pub head: Vec<(String, Alignment)>,
    /// The cells, row by row.
    pub rows: Vec<Vec<String>>,
}

/// Returns the header of a column of words.
pub fn words(name: impl Into<String>) -> (String, Alignment) {
    (name.into(), Alignment::Left)
}

/// Returns the header of a column of numbers.
pub fn numbers(name: impl Into<String>) -> (String, Alignment) {
    (name.into(), Alignment::Right)
}

impl Table {
    /// Returns the table as Markdown below a heading of a given level, such as 2 for `##`.
    pub fn markdown(&self, level: usize) -> String {
        let mut text = format!(
            "{} {}\n\n{}\n\n",
            "#".repeat(level),
            self.title,
            self.caption
        );
        if self.rows.is_empty() {
            return text;
        }
        let head: Vec<String> = self.head.iter().map(|(name, _)| one_line(name)).collect();
        let rows: Vec<Vec<String>> = self
            .rows
            .iter()
            .map(|row| row.iter().map(|cell| one_line(cell)).collect())
            .collect();
        let widths: Vec<usize> = (0..head.len())
            .map(|column| {
                let cells = rows.iter().chain([&head]).map(|row| &row[column]);
                cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
            })
            .collect();
        self.push_row(&mut text, &head, &widths);
        for ((_, side), width) in self.head.iter().zip(&widths) {
            // The width of a cell with its two spaces.
            match side {
                Alignment::Left => text += &format!("|{}", "-".repeat(width + 2)),
                Alignment::Right => text += &format!("|{}:", "-".repeat(width + 1)),
            }
        }
        text += "|\n";
        for row in &rows {
            self.push_row(&mut text, row, &widths);
        }
        text.push('\n');
        text
    }

    fn push_row(&self, text: &mut String, cells: &[String], widths: &[usize]) {
        for ((cell, width), (_, side)) in cells.iter().zip(widths).zip(&self.head) {
            match side {
                Alignment::Left => write!(text, "| {cell:<width$} "),
                Alignment::Right => write!(text, "| {cell:>width$} "),
            }
            .expect("writing to a string cannot fail");
        }
        text.push_str("|\n");
    }

    /// Returns the table for a terminal: columns two spaces apart, without title and caption.
    pub fn grid(&self) -> String {
        let head: Vec<String> = self.head.iter().map(|(name, _)| name.clone()).collect();
        let rows: Vec<Vec<String>> = [head]
            .into_iter()
            .chain(self.rows.iter().cloned())
            .collect();
        let width = |column: usize| {
            let cells = rows.iter().map(|row| row[column].chars().count());
            cells.max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..self.head.len()).map(width).collect();
        let line = |row: &Vec<String>| {
            let cells = row.iter().zip(&widths).zip(&self.head);
            let cells = cells.map(|((cell, &width), (_, side))| match side {
                Alignment::Left => format!("{cell:<width$}"),
                Alignment::Right => format!("{cell:>width$}"),
            });
            let line = cells.collect::<Vec<String>>().join("  ");
            line.trim_end().to_owned() + "\n"
        };
        rows.iter().map(line).collect()
    }

    /// Returns the table as HTML, without its title and caption.
    pub fn html(&self) -> Markup {
        html! {
            div.table {
                table {
                    thead { tr {
                        @for (name, side) in &self.head { th class=[side.class()] { (name) } }
                    } }
                    tbody { @for row in &self.rows { tr {
                        @for (cell, (_, side)) in row.iter().zip(&self.head) {
                            td class=[side.class()] { (cell) }
                        }
                    } } }
                }
            }
        }
    }
}

/// Breaks a text at spaces into lines of at most `width` characters, each with a line end. Longer words stay whole.
pub fn wrapped(text: &str, width: usize) -> String {
    let (mut all, mut length) = (String::new(), 0);
    for word in text.split(' ') {
        let count = word.chars().count();
        if length > 0 && length + 1 + count > width {
            all.push('\n');
            length = 0;
        }
        if length > 0 {
            all.push(' ');
            length += 1;
        }
        all += word;
        length += count;
    }
    all + "\n"
}

fn one_line(cell: &str) -> String {
    cell.replace(['\n', '\r'], " ").replace('|', "\\|")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        Table {
            title: "Speeds".to_owned(),
            caption: "Lower is better.".to_owned(),
            head: vec![words("who"), numbers("ns")],
            rows: vec![
                vec!["a|b\nc".to_owned(), "7".to_owned()],
                vec!["<d>".to_owned(), "1234".to_owned()],
            ],
        }
    }

    #[test]
    fn markdown_columns_are_aligned_and_cells_escaped() {
        let expected = "## Speeds\n\nLower is better.\n\n\
                        | who    |   ns |\n\
                        |--------|-----:|\n\
                        | a\\|b c |    7 |\n\
                        | <d>    | 1234 |\n\n";
        assert_eq!(table().markdown(2), expected);
    }

    #[test]
    fn grid_aligns_columns_and_text_wraps_at_width() {
        let grid = Table {
            rows: vec![
                vec!["a".to_owned(), "7".to_owned()],
                vec!["bcde".to_owned(), "12".to_owned()],
            ],
            ..table()
        }
        .grid();
        assert_eq!(grid, "who   ns\na      7\nbcde  12\n");
        assert_eq!(wrapped("one two three four", 9), "one two\nthree\nfour\n");
        assert_eq!(wrapped("extraordinary it is", 8), "extraordinary\nit is\n");
    }

    #[test]
    fn html_table_cells_are_escaped() {
        let html = table().html().into_string();
        assert!(html.contains("<td>&lt;d&gt;</td><td class=\"number\">1234</td>"));
    }

    #[test]
    fn empty_table_prints_title_and_caption_only() {
        let empty = Table {
            rows: Vec::new(),
            ..table()
        };
        assert_eq!(empty.markdown(3), "### Speeds\n\nLower is better.\n\n");
    }
}
