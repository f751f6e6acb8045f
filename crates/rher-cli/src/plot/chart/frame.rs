//! A pair of axes: where a number is in a panel, and the numbers and words around it.

use super::axis::Axis;
use super::marks::{Anchor, BLACK, Dash, GRAY, Ink, LETTER, Mark, PALE, Style, fit};

/// The plotting area of a panel, in pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame<'a> {
    x: &'a Axis,
    y: Option<&'a Axis>,
    pub(super) left: f32,
    pub(super) top: f32,
    pub(super) right: f32,
    pub(super) bottom: f32,
}

/// Room for numbers and words, in pixels: left of an upright axis, above, right, below.
const ROOM: [f32; 4] = [46.0, 26.0, 18.0, 40.0];

/// Room above the highest number, so that a line there is seen whole, in pixels.
const HEADROOM: f32 = 8.0;

/// The least distance of two numbers, in pixels: along, and upright.
const TICKS: [f32; 2] = [60.0, 30.0];

impl<'a> Frame<'a> {
    /// With its upper left corner at a place, in a size, both in pixels.
    pub(super) fn new(
        x: &'a Axis,
        y: Option<&'a Axis>,
        [left, top]: [f32; 2],
        [width, height]: [f32; 2],
    ) -> Self {
        let [room_left, room_above, room_right, room_below] = ROOM;
        let room_left = if y.is_some() { room_left } else { room_right };
        let (right, bottom) = (left + width - room_right, top + height - room_below);
        Self { x, y, left: left + room_left, top: top + room_above, right, bottom }
    }

    pub(super) fn x(&self, value: f64) -> f32 {
        self.left + self.x.place(value) * (self.right - self.left)
    }

    pub(super) fn at(&self, x: f64, y: f64) -> [f32; 2] {
        let place = self.y.map_or(0.0, |axis| axis.place(y));
        [self.x(x), self.bottom - place * (self.bottom - self.top - HEADROOM)]
    }

    /// Draws the axes, a title, and a note beside it.
    pub(super) fn draw(&self, title: &str, note: &[(String, Ink)], marks: &mut Vec<Mark>) {
        let Self { x, y, left, top, right, bottom } = *self;
        let words = |text: String, place, anchor, ink| Mark::Words {
            text,
            place,
            anchor,
            ink,
            style: Style::Plain,
        };
        let thin =
            |points: Vec<[f32; 2]>, ink| Mark::Stroke { points, ink, width: 1.0, dash: Dash::None };

        let mut end = right;
        for (text, ink) in note.iter().rev() {
            marks.push(words(text.clone(), [end, top - 9.0], Anchor::End, *ink));
            end -= super::marks::LETTER_WIDTH * (text.chars().count() + 1) as f32;
        }
        marks.push(Mark::Words {
            text: fit(title, end - left),
            place: [left, top - 9.0],
            anchor: Anchor::Start,
            ink: BLACK,
            style: Style::Bold,
        });
        for tick in y.map_or_else(Vec::new, |y| y.ticks(((bottom - top) / TICKS[1]).into())) {
            let [_, height] = self.at(0.0, tick);
            marks.push(thin(vec![[left, height], [right, height]], PALE));
            let place = [left - 6.0, height + LETTER / 3.0];
            let number = y.map_or_else(String::new, |y| (y.short)(tick));
            marks.push(words(number, place, Anchor::End, GRAY));
        }
        for tick in x.ticks(((right - left) / TICKS[0]).floor().into()) {
            marks.push(thin(vec![[self.x(tick), bottom], [self.x(tick), bottom + 4.0]], GRAY));
            let place = [self.x(tick), bottom + 17.0];
            marks.push(words((x.short)(tick), place, Anchor::Middle, GRAY));
        }
        marks.push(thin(vec![[left, bottom], [right, bottom]], GRAY));
        let middle = [f32::midpoint(left, right), bottom + 33.0];
        marks.push(words(fit(&x.name, right - left + 20.0), middle, Anchor::Middle, GRAY));
    }
}
