//! Entries of a sparse matrix as runs along its rows, so that products with
//! dense blocks are products of slices.

/// Consecutive entries of one row, in consecutive columns.
#[derive(Clone, Copy, Debug)]
pub(super) struct EntryRun {
    pub row: usize,
    pub column: usize,
    /// First entry, and number of entries.
    pub entry: usize,
    pub length: usize,
}

impl EntryRun {
    /// The entries of the run among `values`.
    #[inline]
    pub fn of<'v>(&self, values: &'v [f64]) -> &'v [f64] {
        &values[self.entry..self.entry + self.length]
    }

    #[inline]
    pub fn columns(&self) -> std::ops::Range<usize> {
        self.column..self.column + self.length
    }
}

/// The runs of `entries` (row, column), in order.
pub(super) fn runs(entries: &[(usize, usize)]) -> Vec<EntryRun> {
    let mut runs: Vec<EntryRun> = Vec::new();
    for (entry, &(row, column)) in entries.iter().enumerate() {
        match runs.last_mut() {
            Some(run) if run.row == row && run.column + run.length == column => run.length += 1,
            _ => runs.push(EntryRun { row, column, entry, length: 1 }),
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_hold_the_entries_in_order() {
        let entries = [(0, 0), (0, 1), (0, 3), (1, 4), (1, 5), (1, 5)];
        let found = runs(&entries);
        let back: Vec<(usize, usize)> =
            found.iter().flat_map(|run| run.columns().map(|c| (run.row, c))).collect();
        assert_eq!(back, entries);
        assert_eq!(found.len(), 4);
    }
}
