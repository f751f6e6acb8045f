//! Panels and a legend, laid out as marks.

use super::marks::{Anchor, BLACK, LETTER, LETTER_WIDTH, Mark};
use super::panel::Panel;

/// A flat picture; places are in pixels from the upper left.
#[derive(Clone, Debug)]
pub(crate) struct Drawing {
    pub(crate) width: f32,
    pub(crate) height: f32,
    pub(super) marks: Vec<Mark>,
}

/// Around and between panels, in pixels.
const MARGIN: f32 = 12.0;

/// Height of a line of the legend, in pixels.
const LEGEND: f32 = 22.0;

impl Drawing {
    /// Rows of panels, of these widths and this height in pixels, over a legend of every line.
    pub(crate) fn of(rows: &[Vec<Panel>], widths: &[f32], height: f32) -> Self {
        let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
        let width = MARGIN + widths[..columns].iter().map(|width| width + MARGIN).sum::<f32>();
        let mut drawing = Self { width, height: MARGIN, marks: Vec::new() };
        for row in rows {
            let mut left = MARGIN;
            for (panel, width) in row.iter().zip(widths) {
                panel.draw([left, drawing.height], [*width, height], &mut drawing.marks);
                left += width + MARGIN;
            }
            drawing.height += height + MARGIN;
        }
        drawing.add_legend(rows);
        drawing
    }

    fn add_legend(&mut self, rows: &[Vec<Panel>]) {
        const SAMPLE: f32 = 26.0;
        let mut known: Vec<&str> = Vec::new();
        let mut left = 2.0 * MARGIN;
        for line in rows.iter().flatten().flat_map(|panel| &panel.lines) {
            if known.contains(&line.name.as_str()) {
                continue;
            }
            known.push(&line.name);
            let wide = SAMPLE + LETTER_WIDTH * (line.name.chars().count() + 4) as f32;
            if left + wide > self.width && left > 2.0 * MARGIN {
                left = 2.0 * MARGIN;
                self.height += LEGEND;
            }
            let middle = self.height + LEGEND / 2.0;
            self.marks.push(line.stroke(vec![[left, middle], [left + SAMPLE, middle]]));
            self.marks.push(Mark::Words {
                text: line.name.clone(),
                place: [left + SAMPLE + 6.0, middle + LETTER / 3.0],
                anchor: Anchor::Start,
                ink: BLACK,
                bold: false,
            });
            left += wide;
        }
        self.height += LEGEND + MARGIN;
    }
}
