//! Which numbers an axis has, and how they are written.

use crate::numbers::{percent, thousands};

/// A range of numbers with a name.
#[derive(Clone, Debug)]
pub(crate) struct Axis {
    pub(crate) name: String,
    pub(crate) low: f64,
    pub(crate) high: f64,
    /// How a number is written at the axis.
    pub(crate) short: fn(f64) -> String,
    /// How a number is written where there is room.
    pub(crate) exact: fn(f64) -> String,
}

impl Axis {
    /// From 0 to `high`.
    pub(crate) fn to(name: &str, high: f64, exact: fn(f64) -> String) -> Self {
        let high = if high > 0.0 { high } else { 1.0 };
        Self { name: name.to_owned(), low: 0.0, high, short, exact }
    }

    /// Shares, from 0 to 1.
    pub(crate) fn shares(name: &str) -> Self {
        Self { short: percent, ..Self::to(name, 1.0, exact_percent) }
    }

    /// From 0, or a round number below all of `values`, to a round number above them.
    pub(crate) fn around(name: &str, values: impl Iterator<Item = f64>) -> Self {
        let (low, high) =
            values.fold((0.0, 0.0), |(low, high), value| (value.min(low), value.max(high)));
        let step = if high > low { step(high - low, 4.0) } else { 1.0 };
        let (low, high) = ((low / step).floor() * step, (high / step).ceil() * step);
        let high = if high > low { high } else { 1.0 };
        Self { name: name.to_owned(), low, high, short, exact }
    }

    /// How far along the axis a number is: 0 at its begin, 1 at its end.
    pub(super) fn place(&self, value: f64) -> f32 {
        ((value - self.low) / (self.high - self.low)) as f32
    }

    /// Round numbers on the axis, about `count` of them.
    pub(super) fn ticks(&self, count: f64) -> Vec<f64> {
        let step = step(self.high - self.low, count.max(1.0));
        let first = (self.low / step).ceil();
        let numbers = (0..).map(|index| (first + f64::from(index)) * step);
        numbers.take_while(|tick| *tick <= self.high + 1e-9 * step).collect()
    }
}

/// A round distance between at most `count` numbers, besides the first, in a range.
#[expect(
    clippy::disallowed_methods,
    reason = "a step between numbers on an axis, which is looked at"
)]
fn step(range: f64, count: f64) -> f64 {
    let least = range / count;
    let power = 10_f64.powf(least.log10().floor());
    let round = [1.0, 2.0, 2.5, 5.0, 10.0].map(|factor| factor * power);
    round.into_iter().find(|step| *step >= least * (1.0 - 1e-9)).unwrap_or(least)
}

/// `20k` for 20,000.
fn short(number: f64) -> String {
    match number.abs() {
        1e6.. => plain(number / 1e6) + "M",
        1e3.. => plain(number / 1e3) + "k",
        _ => plain(number),
    }
}

/// Without the digits that rounding leaves behind.
fn plain(number: f64) -> String {
    ((number * 1e6).round() / 1e6).to_string()
}

/// With four digits, or as a whole number.
pub(crate) fn exact(number: f64) -> String {
    if number.abs() >= 1e3 {
        let sign = if number < 0.0 { "-" } else { "" };
        return format!("{sign}{}", thousands(number.abs().round() as u64));
    }
    format!("{number:.3e}").parse::<f64>().map_or_else(|_| number.to_string(), |it| it.to_string())
}

fn exact_percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round_and_not_too_many() {
        for (end, expected) in
            [(1.0, 0.2), (5.0, 1.0), (37_500.0, 10_000.0), (1e6, 2e5), (7.3, 2.0), (11.0, 2.5)]
        {
            assert!((step(end, 5.0) / expected - 1.0).abs() < 1e-9, "{end}: {}", step(end, 5.0));
        }
        assert_eq!(Axis::shares("").ticks(4.0), [0.0, 0.25, 0.5, 0.75, 1.0]);
    }

    #[test]
    fn an_axis_holds_its_values_and_0() {
        let ends = |values: &[f64]| {
            let axis = Axis::around("", values.iter().copied());
            (axis.low, axis.high)
        };
        assert_eq!(ends(&[3.2, 4.9]), (0.0, 6.0));
        assert_eq!(ends(&[-14.5, 2.0]), (-15.0, 5.0));
        assert_eq!(ends(&[0.0]), (0.0, 1.0));
        assert_eq!(ends(&[]), (0.0, 1.0));
    }

    #[test]
    fn numbers_have_few_digits() {
        let numbers = [0.0, 0.123_456, 999.96, -12_345.6, 1e-7].map(exact);
        assert_eq!(numbers, ["0", "0.1235", "1000", "-12,346", "0.0000001"]);
        assert_eq!([20_000.0, -1_500.0, 2.5e6, 0.05].map(short), ["20k", "-1.5k", "2.5M", "0.05"]);
    }
}
