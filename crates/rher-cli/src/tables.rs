//! Tables as text.

use comfy_table::Table;
use comfy_table::presets::NOTHING;

/// An empty table without lines, as `awk` likes it.
pub(crate) fn table() -> Table {
    let mut table = Table::new();
    table.load_style(NOTHING);
    table
}

/// A table as text, without blanks around its lines.
pub(crate) fn text(table: &Table) -> String {
    table.lines().map(|line| line.trim().to_owned() + "\n").collect()
}
