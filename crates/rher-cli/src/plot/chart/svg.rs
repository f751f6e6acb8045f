//! Drawings as SVG, with the letters of whoever shows them.

use super::lines::Look;
use super::marks::{AREA_OPACITY, Anchor, DOT, Dash, Ink, LETTER, Mark, Style};
use super::sheet::Drawing;
use std::fmt::Write as _;

impl Drawing {
    /// The drawing as an SVG element, which says what it shows.
    pub(crate) fn svg(&self, label: &str) -> String {
        let Self { width, height, marks } = self;
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" \
             width=\"{width:.0}\" height=\"{height:.0}\" font-family=\"sans-serif\" \
             font-size=\"{LETTER}\" role=\"img\" aria-label=\"{}\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
            escaped(label)
        );
        for mark in marks {
            // A string takes whatever is written.
            let _ = write(mark, &mut svg);
        }
        svg + "</svg>\n"
    }
}

/// A sample of a line as an SVG element, for legends.
pub(crate) fn sample(look: &Look) -> String {
    const SIZE: [f32; 2] = [26.0, 8.0];
    let [width, height] = SIZE;
    let mut svg = format!("<svg width=\"{width}\" height=\"{height}\" aria-hidden=\"true\">");
    let line = look.stroke(vec![[0.0, height / 2.0], [width, height / 2.0]]);
    // A string takes whatever is written.
    let _ = write(&line, &mut svg);
    svg + "</svg>"
}

fn write(mark: &Mark, svg: &mut String) -> std::fmt::Result {
    match mark {
        Mark::Stroke { points, ink, width, dash } => {
            write!(
                svg,
                "<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"{width}\"",
                hex(*ink)
            )?;
            if *dash != Dash::None {
                let lengths: Vec<String> = dash.lengths().iter().map(f32::to_string).collect();
                write!(svg, " stroke-dasharray=\"{}\"", lengths.join(" "))?;
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
        Mark::Dot { center: [x, y], ink } => {
            writeln!(
                svg,
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{DOT}\" fill=\"{}\"/>",
                hex(*ink)
            )
        }
        Mark::Words { text, place: [x, y], anchor, ink, style } => {
            let anchor = match anchor {
                Anchor::Start => "start",
                Anchor::Middle => "middle",
                Anchor::End => "end",
            };
            let style = match style {
                Style::Plain => String::new(),
                Style::Bold => " font-weight=\"bold\"".to_owned(),
                Style::Title => {
                    format!(" font-weight=\"bold\" font-size=\"{}\"", Style::Title.size())
                }
            };
            writeln!(
                svg,
                "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"{}\"{style}>{}</text>",
                hex(*ink),
                escaped(text)
            )
        }
        Mark::Hint { corner: [x, y], size: [width, height], text } => writeln!(
            svg,
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" \
             fill=\"gray\" fill-opacity=\"0\"><title>{}</title></rect>",
            escaped(text)
        ),
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
