//! A panel of estimates, one below the other: a dot, and its interval as a line.

use super::axis::Axis;
use super::frame::Frame;
use super::marks::{Anchor, BLACK, Dash, GRAY, Ink, Mark, PALE, Style, fit};

/// Estimates over a common axis.
#[derive(Clone, Debug)]
pub(crate) struct Intervals {
    pub(crate) title: String,
    pub(crate) x: Axis,
    /// A number that estimates are compared with.
    pub(crate) reference: f64,
    pub(crate) rows: Vec<Row>,
}

/// An estimate, and what it may really be.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    pub(crate) name: String,
    pub(crate) ink: Ink,
    pub(crate) value: f64,
    pub(crate) interval: Option<[f64; 2]>,
}

/// Height of a row with its name, in pixels.
const ROW: f32 = 40.0;

/// Above and below the rows, in pixels.
const AROUND: f32 = 72.0;

impl Intervals {
    /// In pixels.
    pub(super) fn height(&self) -> f32 {
        AROUND + ROW * self.rows.len() as f32
    }

    pub(super) fn draw(&self, corner: [f32; 2], size: [f32; 2], marks: &mut Vec<Mark>) {
        let size = [size[0], self.height().min(size[1])];
        let frame = Frame::new(&self.x, None, corner, size);
        frame.draw(&self.title, &[], marks);
        for (index, row) in self.rows.iter().enumerate() {
            self.draw_row(row, &frame, frame.top + ROW * index as f32, marks);
        }
    }

    /// Draws a row with its upper edge at a height: the name, and below it the estimate.
    fn draw_row(&self, row: &Row, frame: &Frame<'_>, top: f32, marks: &mut Vec<Mark>) {
        let Row { name, ink, value, interval } = row;
        let (line, middle) = (top + 14.0, top + 28.0);
        let width = frame.right - frame.left;
        marks.push(Mark::Words {
            text: fit(name, width),
            place: [frame.left, line],
            anchor: Anchor::Start,
            ink: BLACK,
            style: Style::Plain,
        });
        let upright = |value: f64, ink, dash| {
            let points = vec![[frame.x(value), middle - 8.0], [frame.x(value), middle + 8.0]];
            Mark::Stroke { points, ink, width: 1.0, dash }
        };
        marks.extend(self.x.ticks(4.0).into_iter().map(|tick| upright(tick, PALE, Dash::None)));
        marks.push(upright(self.reference, GRAY, Dash::Short));
        if let Some(interval) = interval {
            let points = interval.map(|end| [frame.x(end), middle]).into();
            marks.push(Mark::Stroke { points, ink: *ink, width: 3.0, dash: Dash::None });
        }
        marks.push(Mark::Dot { center: [frame.x(*value), middle], ink: *ink });
        let show = self.x.exact;
        let interval = interval
            .map_or_else(String::new, |[low, high]| format!(" [{}, {}]", show(low), show(high)));
        marks.push(Mark::Hint {
            corner: [frame.left, top],
            size: [width, ROW],
            text: format!("{name}: {}{interval}", show(*value)),
        });
    }
}
