//! Drawings as pixels, two for each of theirs, with letters that the program brings along.

use super::marks::{AREA_OPACITY, Anchor, DOT, Dash, Ink, Mark, Style};
use super::sheet::Drawing;
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};
use rher_envs::render::Image;
use tiny_skia::{
    Color, FillRule, LineJoin, Paint, PathBuilder, Pixmap, PixmapMut, Stroke, StrokeDash, Transform,
};

/// Pixels for each pixel of a drawing.
const SCALE: f32 = 2.0;

/// Letters, twice as large as in a drawing.
const fn letters(style: Style) -> (FontWeight, RasterHeight) {
    match style {
        Style::Plain => (FontWeight::Regular, RasterHeight::Size24),
        Style::Bold => (FontWeight::Bold, RasterHeight::Size24),
        Style::Title => (FontWeight::Bold, RasterHeight::Size32),
    }
}

/// From the upper edge of a letter's box to its base line, as a share of its height.
const BASE_LINE: f32 = 0.78;

impl Drawing {
    /// The drawing as a picture; `None` if it is too large for one.
    pub(crate) fn image(&self) -> Option<Image> {
        let size = [self.width, self.height].map(|pixels| (pixels * SCALE).ceil() as u32);
        let mut pixmap = Pixmap::new(size[0], size[1])?;
        pixmap.fill(Color::WHITE);
        for mark in &self.marks {
            draw(mark, &mut pixmap.as_mut());
        }
        let rgb =
            pixmap.pixels().iter().flat_map(|pixel| [pixel.red(), pixel.green(), pixel.blue()]);
        let [width, height] = size.map(|pixels| pixels as usize);
        Some(Image { width, height, rgb: rgb.collect() })
    }
}

fn draw(mark: &Mark, pixmap: &mut PixmapMut<'_>) {
    match mark {
        Mark::Stroke { points, ink, width, dash } => {
            let dash = (*dash != Dash::None).then(|| dash.lengths().to_vec());
            let dash = dash.and_then(|lengths| StrokeDash::new(lengths, 0.0));
            let stroke =
                Stroke { width: *width, line_join: LineJoin::Round, dash, ..Stroke::default() };
            if let Some(path) = path(points, false) {
                pixmap.stroke_path(&path, &paint(*ink, 1.0), &stroke, scale(), None);
            }
        }
        Mark::Area { points, ink } => {
            if let Some(path) = path(points, true) {
                let paint = paint(*ink, AREA_OPACITY);
                pixmap.fill_path(&path, &paint, FillRule::Winding, scale(), None);
            }
        }
        Mark::Dot { center: [x, y], ink } => {
            if let Some(path) = PathBuilder::from_circle(*x, *y, DOT) {
                pixmap.fill_path(&path, &paint(*ink, 1.0), FillRule::Winding, scale(), None);
            }
        }
        Mark::Words { text, place: [x, y], anchor, ink, style } => {
            let (weight, height) = letters(*style);
            let letter = get_raster_width(weight, height);
            let width = (letter * text.chars().count()) as f32;
            let left = match anchor {
                Anchor::Start => 0.0,
                Anchor::Middle => width / 2.0,
                Anchor::End => width,
            };
            let left = x * SCALE - left;
            let top = (y * SCALE - BASE_LINE * height.val() as f32).round() as i32;
            for (index, letter_of_text) in text.chars().enumerate() {
                let left = (left + (letter * index) as f32).round() as i32;
                put(letter_of_text, (weight, height), [left, top], *ink, pixmap);
            }
        }
        // A file of pixels has nothing that a pointer could find.
        Mark::Hint { .. } => {}
    }
}

/// Puts a letter with its upper left corner at a pixel.
fn put(
    letter: char,
    (weight, height): (FontWeight, RasterHeight),
    [left, top]: [i32; 2],
    ink: Ink,
    pixmap: &mut PixmapMut<'_>,
) {
    let Some(letter) =
        get_raster(letter, weight, height).or_else(|| get_raster('?', weight, height))
    else {
        return;
    };
    let [width, height] = [pixmap.width(), pixmap.height()].map(u32::cast_signed);
    let pixels = pixmap.data_mut();
    for (y, row) in (top..).zip(letter.rows()) {
        for (x, coverage) in (left..).zip(row) {
            if (0..width).contains(&x) && (0..height).contains(&y) {
                let start = 4 * (y * width + x) as usize;
                for (old, new) in pixels[start..start + 3].iter_mut().zip(ink) {
                    let share = f32::from(*coverage) / 255.0;
                    *old = (f32::from(*old) * (1.0 - share) + f32::from(new) * share).round() as u8;
                }
            }
        }
    }
}

fn path(points: &[[f32; 2]], closed: bool) -> Option<tiny_skia::Path> {
    let mut path = PathBuilder::new();
    let ([first_x, first_y], rest) = points.split_first()?;
    path.move_to(*first_x, *first_y);
    for [x, y] in rest {
        path.line_to(*x, *y);
    }
    if closed {
        path.close();
    }
    path.finish()
}

fn paint(ink: Ink, opacity: f32) -> Paint<'static> {
    let [r, g, b] = ink;
    let mut paint = Paint { anti_alias: true, ..Paint::default() };
    paint.set_color_rgba8(r, g, b, (255.0 * opacity).round() as u8);
    paint
}

fn scale() -> Transform {
    Transform::from_scale(SCALE, SCALE)
}
