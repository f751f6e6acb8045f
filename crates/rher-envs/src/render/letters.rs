//! Letters in pictures.

use super::image::Image;
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

/// Pictures of at least this height have large letters, in pixels.
const LARGE: usize = 480;

/// What is left of the colors behind a caption.
const DIMMED: f32 = 0.25;

impl Image {
    /// Writes words, each with its color, in a dark strip at the upper edge; what does not fit is cut
    /// off. Letters that are not ASCII become `?`.
    pub fn caption(&mut self, words: &[(&str, [u8; 3])]) {
        let letters = if self.height < LARGE { RasterHeight::Size16 } else { RasterHeight::Size24 };
        let edge = letters.val() / 4;
        let strip = 3 * self.width * (letters.val() + edge).min(self.height);
        for level in &mut self.rgb[..strip] {
            *level = (f32::from(*level) * DIMMED) as u8;
        }
        let step = get_raster_width(FontWeight::Regular, letters);
        let mut left = edge;
        for (word, ink) in words {
            for letter in word.chars() {
                self.put(letter, letters, [left, edge / 2], *ink);
                left += step;
            }
            left += step;
        }
    }

    /// Puts a letter with its upper left corner at a pixel.
    fn put(&mut self, letter: char, height: RasterHeight, [left, top]: [usize; 2], ink: [u8; 3]) {
        let weight = FontWeight::Regular;
        let raster = get_raster(letter, weight, height).or_else(|| get_raster('?', weight, height));
        let Some(raster) = raster else { return };
        for (y, row) in (top..self.height).zip(raster.rows()) {
            for (x, coverage) in (left..self.width).zip(row) {
                let start = 3 * (y * self.width + x);
                let share = f32::from(*coverage) / 255.0;
                for (old, new) in self.rgb[start..start + 3].iter_mut().zip(ink) {
                    *old = (f32::from(*old) * (1.0 - share) + f32::from(new) * share).round() as u8;
                }
            }
        }
    }
}
