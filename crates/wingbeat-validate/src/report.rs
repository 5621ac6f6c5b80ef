//! The rows as a table for people and as JSON.

use serde::Serialize;

use crate::ComparisonRow;

/// One line of the JSON list.
#[derive(Debug, Serialize)]
pub struct ReportLine<'a> {
    id: &'a str,
    source: &'a str,
    metric: String,
    value: f64,
    limit: Option<f64>,
    pass: bool,
}

/// The rows as a JSON list of {id, source, metric, value, limit, pass}.
///
/// `limit` is null for a number without judgement, `value` for one that could not be computed.
pub fn to_json(rows: &[ComparisonRow]) -> Vec<ReportLine<'_>> {
    rows.iter()
        .map(|row| ReportLine {
            id: &row.id,
            source: &row.source,
            metric: metric(row),
            value: row.value,
            limit: row.limit,
            pass: row.passes(),
        })
        .collect()
}

/// The rows as aligned text: id, source, metric, value, limit, verdict.
pub fn table(rows: &[ComparisonRow]) -> String {
    let mut lines = vec![["id", "source", "metric", "value", "limit", "verdict"].map(String::from)];
    lines.extend(rows.iter().map(cells));
    let widths: Vec<usize> =
        (0..6).map(|i| lines.iter().map(|line| line[i].chars().count()).max().unwrap_or(0)).collect();
    let mut text = String::new();
    for (row, line) in lines.iter().enumerate() {
        let padded: Vec<String> =
            line.iter().zip(&widths).enumerate().map(|(i, (cell, &w))| pad(i, cell, w)).collect();
        text += padded.join("  ").trim_end();
        text.push('\n');
        if row == 0 {
            text += &widths.iter().map(|&w| "-".repeat(w)).collect::<Vec<_>>().join("  ");
            text.push('\n');
        }
    }
    text
}

fn cells(row: &ComparisonRow) -> [String; 6] {
    let verdict = match (row.limit, row.passes()) {
        (None, _) => "shown",
        (_, true) => "pass",
        (_, false) => "FAIL",
    };
    [
        row.id.clone(),
        row.source.clone(),
        metric(row),
        number(row.value),
        row.limit.map_or("-".into(), number),
        verdict.into(),
    ]
}

pub(crate) fn metric(row: &ComparisonRow) -> String {
    if row.unit.is_empty() { row.metric.clone() } else { format!("{} [{}]", row.metric, row.unit) }
}

/// Numbers of any size in at most nine characters.
fn number(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-3..1e5).contains(&size) { format!("{value:.4}") } else { format!("{value:.2e}") }
}

fn pad(column: usize, cell: &str, width: usize) -> String {
    let numeric = column == 3 || column == 4;
    if numeric { format!("{cell:>width$}") } else { format!("{cell:<width$}") }
}
