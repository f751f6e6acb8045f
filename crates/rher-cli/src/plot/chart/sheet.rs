//! A picture of several panels, with a title, a legend and a caption.

use super::intervals::Intervals;
use super::lines::{Line, LinePanel, Look};
use super::marks::{Anchor, BLACK, Dash, GRAY, Ink, LETTER, LETTER_WIDTH, Mark, Style};

/// A flat picture; places are in pixels from the upper left.
#[derive(Clone, Debug)]
pub(crate) struct Drawing {
    pub(crate) width: f32,
    pub(crate) height: f32,
    pub(super) marks: Vec<Mark>,
}

/// A pair of axes, and what is in it.
#[derive(Clone, Debug)]
pub(crate) enum Panel {
    Lines(LinePanel),
    Intervals(Intervals),
}

/// What a picture shows.
#[derive(Clone, Debug)]
pub(crate) struct Sheet {
    pub(crate) title: Option<String>,
    /// At least one panel.
    pub(crate) rows: Vec<Vec<Panel>>,
    pub(crate) caption: String,
}

/// Around and between panels, in pixels.
const MARGIN: f32 = 12.0;

/// Width that panels of a row share, in pixels, and how narrow and wide each may be.
const WIDTH: f32 = 960.0;
const NARROWEST: f32 = 250.0;
const WIDEST: f32 = 600.0;

/// Height of a panel by its width, and its limits in pixels.
const HEIGHT: f32 = 0.62;
const LOWEST: f32 = 190.0;
const HIGHEST: f32 = 320.0;

/// Height of a line of the legend, and of the caption, in pixels.
const LEGEND: f32 = 22.0;
const CAPTION: f32 = 17.0;

/// Length of a line's sample in the legend, in pixels.
const SAMPLE: f32 = 26.0;

impl Panel {
    /// The lines in it.
    pub(crate) fn lines(&self) -> &[Line] {
        match self {
            Self::Lines(panel) => &panel.lines,
            Self::Intervals(_) => &[],
        }
    }

    pub(crate) fn title(&self) -> &str {
        match self {
            Self::Lines(panel) => &panel.title,
            Self::Intervals(panel) => &panel.title,
        }
    }

    /// The panel alone, with a width and, where its rows do not decide it, a height in pixels.
    pub(crate) fn drawing(&self, [width, height]: [f32; 2]) -> Drawing {
        let mut marks = Vec::new();
        let height = match self {
            Self::Lines(_) => height,
            Self::Intervals(panel) => panel.height(),
        };
        self.draw([0.0, 0.0], [width, height], false, &mut marks);
        Drawing { width, height, marks }
    }

    fn height(&self, width: f32) -> f32 {
        match self {
            Self::Lines(_) => (HEIGHT * width).clamp(LOWEST, HIGHEST),
            Self::Intervals(panel) => panel.height(),
        }
    }

    fn draw(&self, corner: [f32; 2], size: [f32; 2], counts: bool, marks: &mut Vec<Mark>) {
        match self {
            Self::Lines(panel) => panel.draw(corner, size, counts, marks),
            Self::Intervals(panel) => panel.draw(corner, size, marks),
        }
    }
}

impl Sheet {
    pub(crate) fn draw(&self) -> Drawing {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(1);
        let panel = (WIDTH / columns as f32).clamp(NARROWEST, WIDEST);
        let width = MARGIN + (panel + MARGIN) * columns as f32;
        let mut drawing = Drawing { width, height: MARGIN, marks: Vec::new() };
        if let Some(title) = &self.title {
            let text = super::marks::fit(title, (width - 2.0 * MARGIN) * LETTER / 16.0);
            drawing.words(text, [width / 2.0, MARGIN + 14.0], Anchor::Middle, BLACK, Style::Title);
            drawing.height += 26.0;
        }
        let entries = self.legend();
        let counts = entries.iter().any(|entry| entry.fewest != entry.most);
        for row in &self.rows {
            let height = row.iter().map(|it| it.height(panel)).fold(0.0, f32::max);
            let mut left = MARGIN;
            for it in row {
                it.draw([left, drawing.height], [panel, height], counts, &mut drawing.marks);
                left += panel + MARGIN;
            }
            drawing.height += height + MARGIN;
        }
        drawing.add_legend(&entries);
        drawing.add_caption(&self.caption);
        drawing
    }

    /// Every line once, and lines that look the same together; published ones come last.
    fn legend(&self) -> Vec<Entry> {
        let mut entries: Vec<Entry> = Vec::new();
        for Line { look, runs, .. } in self.rows.iter().flatten().flat_map(Panel::lines) {
            let same =
                |entry: &&mut Entry| (entry.look.ink, entry.look.dash) == (look.ink, look.dash);
            let Some(entry) = entries.iter_mut().find(same) else {
                let names = vec![look.name.clone()];
                entries.push(Entry { look: look.clone(), names, fewest: *runs, most: *runs });
                continue;
            };
            entry.fewest = entry.fewest.min(*runs);
            entry.most = entry.most.max(*runs);
            if !entry.names.contains(&look.name) {
                entry.names.push(look.name.clone());
            }
        }
        entries.sort_by_key(|entry| entry.look.dash == Dash::Short);
        entries
    }
}

/// A look, what is drawn with it, and of how many runs.
struct Entry {
    look: Look,
    names: Vec<String>,
    fewest: usize,
    most: usize,
}

impl Entry {
    fn text(&self) -> String {
        let names = self.names.join(", ");
        if self.fewest == self.most { format!("{names} (n = {})", self.most) } else { names }
    }
}

impl Drawing {
    fn words(&mut self, text: String, place: [f32; 2], anchor: Anchor, ink: Ink, style: Style) {
        self.marks.push(Mark::Words { text, place, anchor, ink, style });
    }

    fn add_legend(&mut self, entries: &[Entry]) {
        if entries.is_empty() {
            return;
        }
        let mut left = 2.0 * MARGIN;
        for entry in entries {
            let text = entry.text();
            let wide = SAMPLE + LETTER_WIDTH * (text.chars().count() + 3) as f32;
            if left + wide > self.width && left > 2.0 * MARGIN {
                left = 2.0 * MARGIN;
                self.height += LEGEND;
            }
            let middle = self.height + LEGEND / 2.0;
            self.marks.push(entry.look.stroke(vec![[left, middle], [left + SAMPLE, middle]]));
            let place = [left + SAMPLE + 6.0, middle + LETTER / 3.0];
            self.words(text, place, Anchor::Start, BLACK, Style::Plain);
            left += wide;
        }
        self.height += LEGEND + MARGIN / 2.0;
    }

    fn add_caption(&mut self, caption: &str) {
        let most = ((self.width - 4.0 * MARGIN) / LETTER_WIDTH) as usize;
        let mut lines: Vec<String> = Vec::new();
        for word in caption.split_whitespace() {
            match lines.last_mut() {
                Some(line) if line.chars().count() + 1 + word.chars().count() <= most => {
                    line.push(' ');
                    line.push_str(word);
                }
                _ => lines.push(word.to_owned()),
            }
        }
        for line in lines {
            let place = [2.0 * MARGIN, self.height + LETTER];
            self.words(line, place, Anchor::Start, GRAY, Style::Plain);
            self.height += CAPTION;
        }
        self.height += MARGIN;
    }
}
