//! Statistics of rows that are seen once, in memory that does not grow with their number.

use serde_json::{Value, json};

/// Rows that quantiles are taken from.
const SAMPLE: usize = 9 * 1024;

/// Rows that are left of so many when there are too many.
const THINNING: usize = 3;

/// What LeRobot keeps of a column of vectors.
///
/// Quantiles are exact up to 9,216 rows; beyond that they are those of every third row, every ninth
/// row, and so on.
#[derive(Debug)]
pub(super) struct Stats {
    rows: usize,
    columns: Vec<Moments>,
    /// `[sampled, width]`, row by row.
    sample: Vec<f64>,
    /// One row of so many is sampled.
    stride: usize,
}

#[derive(Clone, Debug)]
struct Moments {
    min: f64,
    max: f64,
    mean: f64,
    /// Sum of the squared distances from the mean.
    squares: f64,
}

impl Stats {
    pub(super) fn new(width: usize) -> Self {
        let none = Moments { min: f64::INFINITY, max: f64::NEG_INFINITY, mean: 0.0, squares: 0.0 };
        Self { rows: 0, columns: vec![none; width], sample: Vec::new(), stride: 1 }
    }

    /// Adds rows, one after the other.
    pub(super) fn add(&mut self, values: &[f64]) {
        let width = self.columns.len();
        for row in values.chunks_exact(width) {
            if self.rows.is_multiple_of(self.stride) {
                if self.sample.len() == SAMPLE * width {
                    self.thin();
                }
                if self.rows.is_multiple_of(self.stride) {
                    self.sample.extend(row);
                }
            }
            self.rows += 1;
            for (column, &value) in self.columns.iter_mut().zip(row) {
                column.min = column.min.min(value);
                column.max = column.max.max(value);
                let from_old = value - column.mean;
                column.mean += from_old / self.rows as f64;
                column.squares += from_old * (value - column.mean);
            }
        }
    }

    fn thin(&mut self) {
        let width = self.columns.len();
        let kept = self.sample.chunks_exact(width).step_by(THINNING);
        self.sample = kept.flatten().copied().collect();
        self.stride *= THINNING;
    }

    pub(super) fn to_json(&self) -> Value {
        let width = self.columns.len();
        let of = |number: &dyn Fn(&Moments) -> f64| -> Vec<f64> {
            self.columns.iter().map(number).collect()
        };
        let sorted: Vec<Vec<f64>> = (0..width)
            .map(|column| {
                let mut values: Vec<f64> =
                    self.sample.iter().skip(column).step_by(width).copied().collect();
                values.sort_by(f64::total_cmp);
                values
            })
            .collect();
        let quantiles = |share: f64| -> Vec<f64> {
            let quantile = |values: &Vec<f64>| {
                let place = share * (values.len() - 1) as f64;
                let (low, part) = (values[place as usize], place.fract());
                low + part * (values[place.ceil() as usize] - low)
            };
            sorted.iter().map(quantile).collect()
        };
        json!({
            "min": of(&|column| column.min),
            "max": of(&|column| column.max),
            "mean": of(&|column| column.mean),
            "std": of(&|column| (column.squares / self.rows as f64).sqrt()),
            "count": [self.rows],
            "q01": quantiles(0.01),
            "q10": quantiles(0.1),
            "q50": quantiles(0.5),
            "q90": quantiles(0.9),
            "q99": quantiles(0.99),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_rows_are_described_exactly() {
        let mut stats = Stats::new(2);
        stats.add(&[1.0, -1.0, 2.0, -2.0]);
        stats.add(&[3.0, -3.0, 6.0, -6.0]);
        let found = stats.to_json();
        assert_eq!(found["min"], json!([1.0, -6.0]));
        assert_eq!(found["max"], json!([6.0, -1.0]));
        assert_eq!(found["mean"], json!([3.0, -3.0]));
        assert_eq!(found["std"], json!([3.5_f64.sqrt(), 3.5_f64.sqrt()]));
        assert_eq!(found["count"], json!([4]));
        assert_eq!(found["q50"], json!([2.5, -2.5]));
    }

    #[test]
    fn many_rows_take_no_more_memory_and_have_the_same_quantiles() {
        let mut stats = Stats::new(1);
        let rows = 1_000_000_usize;
        for row in 0..rows {
            // Every residue once, in another order.
            stats.add(&[(row * 7919 % rows) as f64]);
        }
        assert!(stats.sample.len() <= SAMPLE && stats.sample.len() > SAMPLE / 4);
        let found = stats.to_json();
        let near = |name: &str, expected: f64| {
            let found = found[name][0].as_f64().unwrap() / rows as f64;
            assert!((found - expected).abs() < 0.01, "{name}: {found}, expected {expected}");
        };
        near("min", 0.0);
        near("q10", 0.1);
        near("q50", 0.5);
        near("mean", 0.5);
        near("std", 1.0 / 12.0_f64.sqrt());
        near("q99", 0.99);
    }
}
