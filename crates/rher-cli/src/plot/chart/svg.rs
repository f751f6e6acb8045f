//! Drawings as SVG, with the letters of whoever shows them.

use super::drawing::Drawing;
use super::marks::{AREA_OPACITY, Anchor, DASH, Ink, LETTER, Mark};
use std::fmt::Write as _;

impl Drawing {
    /// The drawing as an SVG element.
    pub(crate) fn svg(&self) -> String {
        let Self { width, height, marks } = self;
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" \
             width=\"{width:.0}\" height=\"{height:.0}\" font-family=\"sans-serif\" \
             font-size=\"{LETTER}\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
        );
        for mark in marks {
            // A string takes whatever is written.
            let _ = write(mark, &mut svg);
        }
        svg + "</svg>\n"
    }
}

fn write(mark: &Mark, svg: &mut String) -> std::fmt::Result {
    match mark {
        Mark::Stroke { points, ink, width, dashed } => {
            write!(
                svg,
                "<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"{width}\"",
                hex(*ink)
            )?;
            if *dashed {
                let [on, off] = DASH;
                write!(svg, " stroke-dasharray=\"{on} {off}\"")?;
            }
            write!(svg, " stroke-linejoin=\"round\" points=\"")?;
            places(points, svg)
        }
        Mark::Area { points, ink } => {
            write!(
                svg,
                "<polygon fill=\"{}\" fill-opacity=\"{AREA_OPACITY}\" points=\"",
                hex(*ink)
            )?;
            places(points, svg)
        }
        Mark::Words { text, place: [x, y], anchor, ink, bold } => {
            let anchor = match anchor {
                Anchor::Start => "start",
                Anchor::Middle => "middle",
                Anchor::End => "end",
            };
            let weight = if *bold { " font-weight=\"bold\"" } else { "" };
            writeln!(
                svg,
                "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"{}\"{weight}>{}</text>",
                hex(*ink),
                escaped(text)
            )
        }
    }
}

fn places(points: &[[f32; 2]], svg: &mut String) -> std::fmt::Result {
    for (index, [x, y]) in points.iter().enumerate() {
        let space = if index == 0 { "" } else { " " };
        write!(svg, "{space}{x:.1},{y:.1}")?;
    }
    svg.write_str("\"/>\n")
}

fn hex([r, g, b]: Ink) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Text as XML and HTML have it.
pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
