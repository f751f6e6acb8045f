//! The curves that the authors of the method published, to compare with.

use super::curves::Curve;

const TEXT: &str = include_str!("../../data/published.txt");

/// Environment steps between evaluations.
const EVERY: f64 = 2500.0;

/// Test episodes in an evaluation.
const EPISODES: f64 = 10.0;

/// One curve for each of the authors' seeds, against environment steps; none where they published
/// nothing.
pub(crate) fn curves(task: &str, method: &str) -> Vec<Curve> {
    let lines = TEXT.lines().filter(|line| !line.starts_with('#'));
    lines
        .filter_map(|line| {
            let mut words = line.split(' ');
            let fits = words.next() == Some(task) && words.next() == Some(method);
            // The seed, then the digits.
            fits.then(|| words.nth(1)).flatten()
        })
        .map(|digits| {
            let successes = digits.chars().filter_map(|digit| digit.to_digit(16));
            let steps = (1..).map(|epoch| EVERY * f64::from(epoch));
            steps.zip(successes.map(|successes| f64::from(successes) / EPISODES)).collect()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_authors_pushed_within_a_million_steps() {
        let rher = curves("push", "rher");
        assert_eq!(rher.len(), 5);
        for curve in &rher {
            assert_eq!((curve.len(), curve[399]), (400, (1_000_000.0, 1.0)));
        }
        assert_eq!(curves("pick", "her").len(), 5);
        assert_eq!(curves("reach", "rher").len(), 0);
    }
}
