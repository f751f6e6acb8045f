//! One pair of axes and the lines in it.

use super::marks::{Anchor, BLACK, GRAY, Ink, LETTER, Mark, PALE};

/// Lines over a common axis; upright is a share, from 0 to 1.
#[derive(Clone, Debug)]
pub(crate) struct Panel {
    pub(crate) title: String,
    pub(crate) axis: Axis,
    pub(crate) lines: Vec<Line>,
}

/// From 0 to the right.
#[derive(Clone, Debug)]
pub(crate) struct Axis {
    pub(crate) name: &'static str,
    pub(crate) end: f64,
    /// How a number on it is written.
    pub(crate) show: fn(f64) -> String,
}

/// A curve, and what it may really be.
#[derive(Clone, Debug)]
pub(crate) struct Line {
    pub(crate) name: String,
    pub(crate) ink: Ink,
    pub(crate) dashed: bool,
    pub(crate) points: Vec<(f64, f64)>,
    /// Lower and upper end at every point.
    pub(crate) band: Option<Vec<[f64; 2]>>,
}

/// Room for the numbers of the axes and for words, in pixels: left, above, right, below.
const ROOM: [f32; 4] = [46.0, 24.0, 10.0, 40.0];

/// The least distance of two numbers on an axis, in pixels.
const TICK: f32 = 60.0;

impl Line {
    pub(super) fn stroke(&self, points: Vec<[f32; 2]>) -> Mark {
        let width = if self.dashed { 1.5 } else { 2.0 };
        Mark::Stroke { points, ink: self.ink, width, dashed: self.dashed }
    }
}

impl Panel {
    /// Draws it with its upper left corner at a place, in a size, both in pixels.
    pub(super) fn draw(&self, corner: [f32; 2], size: [f32; 2], marks: &mut Vec<Mark>) {
        let [room_left, room_above, room_right, room_below] = ROOM;
        let (left, top) = (corner[0] + room_left, corner[1] + room_above);
        let (right, bottom) = (corner[0] + size[0] - room_right, corner[1] + size[1] - room_below);
        let end = if self.axis.end > 0.0 { self.axis.end } else { 1.0 };
        let x = |value: f64| left + (value / end) as f32 * (right - left);
        let y = |share: f64| bottom - share as f32 * (bottom - top);
        let words =
            |text: String, place, anchor, ink, bold| Mark::Words { text, place, anchor, ink, bold };
        let thin =
            |points: Vec<[f32; 2]>, ink| Mark::Stroke { points, ink, width: 1.0, dashed: false };

        marks.push(words(self.title.clone(), [left, top - 9.0], Anchor::Start, BLACK, true));
        for quarter in 0..=4 {
            let share = f64::from(quarter) / 4.0;
            marks.push(thin(vec![[left, y(share)], [right, y(share)]], PALE));
            let place = [left - 6.0, y(share) + LETTER / 3.0];
            marks.push(words(format!("{:.0}%", 100.0 * share), place, Anchor::End, GRAY, false));
        }
        let step = step(end, ((right - left) / TICK).floor().max(1.0).into());
        for tick in (0..).map(|tick| f64::from(tick) * step).take_while(|tick| *tick <= end) {
            marks.push(thin(vec![[x(tick), bottom], [x(tick), bottom + 4.0]], GRAY));
            let place = [x(tick), bottom + 17.0];
            marks.push(words((self.axis.show)(tick), place, Anchor::Middle, GRAY, false));
        }
        marks.push(thin(vec![[left, bottom], [right, bottom]], GRAY));
        let middle = [f32::midpoint(left, right), bottom + 33.0];
        marks.push(words(self.axis.name.to_owned(), middle, Anchor::Middle, GRAY, false));

        let at = |time: f64, share: f64| [x(time), y(share)];
        for line in &self.lines {
            if let Some(band) = &line.band {
                let times = line.points.iter().map(|(time, _)| *time);
                let low = times.clone().zip(band).map(|(time, [low, _])| at(time, *low));
                let high = times.zip(band).map(|(time, [_, high])| at(time, *high));
                let points = high.chain(low.rev()).collect();
                marks.push(Mark::Area { points, ink: line.ink });
            }
        }
        for line in &self.lines {
            marks.push(
                line.stroke(line.points.iter().map(|(time, share)| at(*time, *share)).collect()),
            );
        }
    }
}

/// A round distance between at most `count` numbers, besides 0, on an axis that ends at `end`.
#[expect(
    clippy::disallowed_methods,
    reason = "a step between numbers on an axis, which is looked at"
)]
fn step(end: f64, count: f64) -> f64 {
    let least = end / count;
    let power = 10_f64.powf(least.log10().floor());
    let round = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power);
    round.into_iter().find(|step| *step >= least * (1.0 - 1e-9)).unwrap_or(least)
}

#[cfg(test)]
mod tests {
    use super::step;

    #[test]
    fn steps_are_round_and_not_too_many() {
        for (end, expected) in
            [(1.0, 0.2), (5.0, 1.0), (37_500.0, 10_000.0), (1e6, 2e5), (7.3, 2.0)]
        {
            assert!((step(end, 5.0) / expected - 1.0).abs() < 1e-9, "{end}: {}", step(end, 5.0));
        }
    }
}
