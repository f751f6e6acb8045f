//! Numbers as people read them.

use std::time::Duration;

/// `1234567` as `1,234,567`.
pub(crate) fn thousands(number: u64) -> String {
    let digits = number.to_string();
    let groups: Vec<&[u8]> = digits.as_bytes().rchunks(3).rev().collect();
    String::from_utf8_lossy(&groups.join(&b',')).into_owned()
}

/// Numbers of steps in increasing order, as `12,500 steps` or `10,000 to 12,500 steps`.
pub(crate) fn range_of_steps(sorted: &[u64]) -> String {
    match sorted {
        [] => "no steps".to_owned(),
        [least, .., most] if least != most => {
            format!("{} to {} steps", thousands(*least), thousands(*most))
        }
        [least, ..] => format!("{} steps", thousands(*least)),
    }
}

/// A share as `95 %`.
pub(crate) fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}

/// A size as `512 B`, `3.4 kB` or `1.2 GB`.
pub(crate) fn bytes(size: u64) -> String {
    let units = [(1e9, "GB"), (1e6, "MB"), (1e3, "kB")];
    let unit = units.into_iter().find(|(unit, _)| size as f64 >= *unit);
    let in_unit = |(unit, name)| format!("{:.1} {name}", size as f64 / unit);
    unit.map_or_else(|| format!("{size} B"), in_unit)
}

/// Seconds as `42 s`, `3 min 05 s` or `2 h 07 min`.
pub(crate) fn duration(seconds: f64) -> String {
    let seconds = Duration::try_from_secs_f64(seconds).map_or(u64::MAX, |time| time.as_secs());
    match seconds {
        0..60 => format!("{seconds} s"),
        60..3600 => format!("{} min {:02} s", seconds / 60, seconds % 60),
        _ => format!("{} h {:02} min", seconds / 3600, seconds / 60 % 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        assert_eq!([0, 999, 1_000, 1_234_567].map(thousands), ["0", "999", "1,000", "1,234,567"]);
        assert_eq!([0.4, 65.0, 7_620.0].map(duration), ["0 s", "1 min 05 s", "2 h 07 min"]);
        assert_eq!(range_of_steps(&[1_000]), "1,000 steps");
        assert_eq!(range_of_steps(&[1_000, 1_000]), "1,000 steps");
        assert_eq!(range_of_steps(&[1_000, 1_500, 2_000]), "1,000 to 2,000 steps");
        assert_eq!(percent(0.954), "95 %");
        assert_eq!([999, 3_400, 1_200_000_000].map(bytes), ["999 B", "3.4 kB", "1.2 GB"]);
    }
}
