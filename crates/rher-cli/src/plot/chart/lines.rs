//! A panel of lines with their bands.

use super::axis::Axis;
use super::frame::Frame;
use super::marks::{Dash, GRAY, Ink, Mark};
use crate::plot::curves::{Curve, value_at};

/// Lines over common axes.
#[derive(Clone, Debug)]
pub(crate) struct LinePanel {
    pub(crate) title: String,
    pub(crate) x: Axis,
    pub(crate) y: Axis,
    pub(crate) lines: Vec<Line>,
}

/// A curve, and what it may really be.
#[derive(Clone, Debug)]
pub(crate) struct Line {
    pub(crate) look: Look,
    /// How many runs it is of.
    pub(crate) runs: usize,
    pub(crate) points: Curve,
    /// Lower and upper end at every point.
    pub(crate) band: Option<Vec<[f64; 2]>>,
}

/// What a line is called, and how it is drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Look {
    pub(crate) name: String,
    pub(crate) ink: Ink,
    pub(crate) dash: Dash,
}

/// The least width of what shows values to the pointer, in pixels.
const STRIP: f32 = 4.0;

impl Look {
    pub(super) fn stroke(&self, points: Vec<[f32; 2]>) -> Mark {
        let width = if self.dash == Dash::Short { 1.5 } else { 2.0 };
        Mark::Stroke { points, ink: self.ink, width, dash: self.dash }
    }
}

impl LinePanel {
    /// Draws it in a frame, perhaps with the number of runs of each line.
    pub(super) fn draw(
        &self,
        corner: [f32; 2],
        size: [f32; 2],
        counts: bool,
        marks: &mut Vec<Mark>,
    ) {
        let frame = Frame::new(&self.x, Some(&self.y), corner, size);
        frame.draw(&self.title, &if counts { self.counts() } else { Vec::new() }, marks);
        for line in &self.lines {
            if let Some(band) = &line.band {
                let times = line.points.iter().map(|(time, _)| *time);
                let low = times.clone().zip(band).map(|(time, [low, _])| frame.at(time, *low));
                let high = times.zip(band).map(|(time, [_, high])| frame.at(time, *high));
                let points = high.chain(low.rev()).collect();
                marks.push(Mark::Area { points, ink: line.look.ink });
            }
        }
        for line in &self.lines {
            let points = line.points.iter().map(|(time, value)| frame.at(*time, *value)).collect();
            marks.push(line.look.stroke(points));
        }
        self.draw_hints(&frame, marks);
    }

    /// "n = 5, 3": the numbers of runs, in the colors of their lines.
    fn counts(&self) -> Vec<(String, Ink)> {
        let mut counts: Vec<(String, Ink)> = Vec::new();
        let first = self.lines.first().map(|line| line.runs);
        if self.lines.iter().all(|line| Some(line.runs) == first) {
            counts.extend(first.map(|runs| (format!("n = {runs}"), GRAY)));
            return counts;
        }
        counts.push(("n =".to_owned(), GRAY));
        counts.extend(self.lines.iter().map(|line| (line.runs.to_string(), line.look.ink)));
        counts
    }

    /// For every time of a line, or every few of them, the values of all lines.
    fn draw_hints(&self, frame: &Frame<'_>, marks: &mut Vec<Mark>) {
        let mut times: Vec<f64> =
            self.lines.iter().flat_map(|line| &line.points).map(|point| point.0).collect();
        // From the end, so that the last of several close times is kept.
        times.sort_by(|a, b| b.total_cmp(a));
        times.dedup_by(|earlier, later| frame.x(*later) - frame.x(*earlier) < STRIP);
        times.reverse();
        for (index, time) in times.iter().enumerate() {
            let between = |other: Option<&f64>, end: f32| {
                other.map_or(end, |other| f32::midpoint(frame.x(*other), frame.x(*time)))
            };
            let before = index.checked_sub(1).and_then(|before| times.get(before));
            let left = between(before, frame.left);
            let right = between(times.get(index + 1), frame.right);
            marks.push(Mark::Hint {
                corner: [left, frame.top],
                size: [right - left, frame.bottom - frame.top],
                text: self.hint(*time),
            });
        }
    }

    fn hint(&self, time: f64) -> String {
        let mut text = vec![(self.x.exact)(time)];
        let exact = self.y.exact;
        for Line { look, points, band, .. } in &self.lines {
            let [Some(first), Some(last)] = [points.first(), points.last()] else { continue };
            if !(first.0..=last.0).contains(&time) {
                continue;
            }
            let bound = |band: &Vec<[f64; 2]>, side: usize| {
                let bounds = points.iter().zip(band).map(|(point, band)| (point.0, band[side]));
                exact(value_at(&bounds.collect(), time))
            };
            let band = band.as_ref().map_or_else(String::new, |band| {
                format!(" [{}, {}]", bound(band, 0), bound(band, 1))
            });
            text.push(format!("{}: {}{band}", look.name, exact(value_at(points, time))));
        }
        text.join("\n")
    }
}
