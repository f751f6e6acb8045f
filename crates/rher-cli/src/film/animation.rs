//! Moving pictures: GIF files of episodes.

use gif::{DisposalMethod, Encoder, EncodingError, Frame, Repeat};
use rher_envs::render::Image;

/// Hundredths of a second for each frame: an environment step.
const DELAY: u16 = 4;

/// The same for the last frame of an episode.
const LAST_DELAY: u16 = 100;

/// Colors; one more says that a pixel is as it was.
const COLORS: usize = 255;
const AS_IT_WAS: u8 = COLORS as u8;

/// Colors for what is rare and unlike all else, such as colored letters.
const RARE: usize = 24;

/// Kinds of colors that are told apart.
const BINS: usize = 1 << 18;

/// A GIF file that is being made, which repeats when it is shown.
pub(crate) struct Animation {
    encoder: Encoder<Vec<u8>>,
    palette: Palette,
    /// In pixels.
    width: usize,
    /// What a viewer sees now, in colors of the palette.
    shown: Vec<u8>,
}

impl Animation {
    /// A file that begins with the pictures of one episode, all of one size, and has its colors;
    /// none if there are no pictures.
    pub(crate) fn of(episode: &[Image]) -> Result<Option<Self>, EncodingError> {
        let Some(Image { width, height, .. }) = episode.first() else { return Ok(None) };
        let palette = Palette::of(episode);
        let mut encoder = Encoder::new(Vec::new(), *width as u16, *height as u16, &palette.rgb)?;
        encoder.set_repeat(Repeat::Infinite)?;
        let mut animation = Self { encoder, palette, width: *width, shown: Vec::new() };
        animation.add(episode)?;
        Ok(Some(animation))
    }

    /// Adds the pictures of another episode, of the same size.
    pub(crate) fn add(&mut self, episode: &[Image]) -> Result<(), EncodingError> {
        for (index, image) in episode.iter().enumerate() {
            let delay = if index + 1 == episode.len() { LAST_DELAY } else { DELAY };
            self.show(image, delay)?;
        }
        Ok(())
    }

    /// The whole file.
    pub(crate) fn finish(self) -> Result<Vec<u8>, EncodingError> {
        self.encoder.into_inner()
    }

    /// Adds what changes with a picture.
    fn show(&mut self, image: &Image, delay: u16) -> Result<(), EncodingError> {
        let colors = self.palette.indices(image);
        let [left, top, right, bottom] = changed(&self.shown, &colors, self.width);
        let mut buffer = Vec::with_capacity((right - left) * (bottom - top));
        for row in top..bottom {
            let range = row * self.width + left..row * self.width + right;
            let old = self.shown.get(range.clone()).unwrap_or(&[]).iter().map(Some);
            let old = old.chain(std::iter::repeat(None));
            let new = colors[range].iter();
            buffer.extend(new.zip(old).map(
                |(new, old)| {
                    if Some(new) == old { AS_IT_WAS } else { *new }
                },
            ));
        }
        self.encoder.write_frame(&Frame {
            delay,
            dispose: DisposalMethod::Keep,
            transparent: Some(AS_IT_WAS),
            left: left as u16,
            top: top as u16,
            width: (right - left) as u16,
            height: (bottom - top) as u16,
            buffer: buffer.into(),
            ..Frame::default()
        })?;
        self.shown = colors;
        Ok(())
    }
}

/// The smallest box around the pixels that differ: left, top, and what is just not in it; never
/// empty.
fn changed(old: &[u8], new: &[u8], width: usize) -> [usize; 4] {
    if old.is_empty() {
        return [0, 0, width, new.len() / width];
    }
    let mut corners = [usize::MAX, usize::MAX, 0, 0];
    for (index, _) in old.iter().zip(new).enumerate().filter(|(_, (old, new))| old != new) {
        let (x, y) = (index % width, index / width);
        let [left, top, right, bottom] = corners;
        corners = [left.min(x), top.min(y), right.max(x + 1), bottom.max(y + 1)];
    }
    if corners[2] == 0 { [0, 0, 1, 1] } else { corners }
}

/// The colors of a file.
struct Palette {
    rgb: Vec<u8>,
    /// The nearest color, by [`bin`].
    known: Vec<Option<u8>>,
}

impl Palette {
    /// The most frequent colors of an episode, and those that are least like any of them.
    fn of(episode: &[Image]) -> Self {
        // How many pixels, and the sums of their red, green and blue.
        let mut bins = vec![[0_u64; 4]; BINS];
        for pixel in episode.iter().flat_map(|image| image.rgb.as_chunks::<3>().0) {
            let [r, g, b] = pixel.map(u64::from);
            let sums = &mut bins[bin(*pixel)];
            *sums = [sums[0] + 1, sums[1] + r, sums[2] + g, sums[3] + b];
        }
        bins.retain(|[count, ..]| *count > 0);
        bins.sort_by_key(|[count, ..]| std::cmp::Reverse(*count));
        let mean = |[count, sums @ ..]: [u64; 4]| sums.map(|sum| (sum / count) as u8);
        let mut colors: Vec<[u8; 3]> = bins.into_iter().map(mean).collect();
        let rare = colors.split_off(colors.len().min(COLORS - RARE));
        let least = |color: &[u8; 3]| colors.iter().map(|other| distance(*other, *color)).min();
        let mut rare: Vec<_> = rare.into_iter().map(|color| (least(&color), color)).collect();
        while colors.len() < COLORS
            && let Some(&(_, next)) = rare.iter().max()
        {
            colors.push(next);
            for (least, color) in &mut rare {
                *least = (*least).min(Some(distance(next, *color)));
            }
        }
        let mut rgb: Vec<u8> = colors.into_flattened();
        rgb.resize(3 * (COLORS + 1), 0);
        Self { rgb, known: vec![None; BINS] }
    }

    fn indices(&mut self, image: &Image) -> Vec<u8> {
        let Self { rgb, known } = self;
        let pixels = image.rgb.as_chunks::<3>().0.iter();
        pixels
            .map(|pixel| *known[bin(*pixel)].get_or_insert_with(|| nearest(rgb, *pixel)))
            .collect()
    }
}

/// Where a pixel is counted: by the upper six bits of each of its numbers.
fn bin(pixel: [u8; 3]) -> usize {
    pixel.into_iter().fold(0, |bin, number| bin << 6 | usize::from(number >> 2))
}

/// Index of the color that differs least.
fn nearest(rgb: &[u8], pixel: [u8; 3]) -> u8 {
    let colors = rgb.as_chunks::<3>().0.iter().take(COLORS).enumerate();
    colors.min_by_key(|(_, color)| distance(**color, pixel)).map_or(0, |(index, _)| index as u8)
}

/// The square of how far two colors are from each other.
fn distance(a: [u8; 3], b: [u8; 3]) -> u32 {
    a.iter().zip(b).map(|(a, b)| u32::from(a.abs_diff(b)).pow(2)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 64;
    const HEIGHT: usize = 48;

    /// A red square of 8 pixels on blue, with its upper left corner at a place.
    fn picture([left, top]: [usize; 2]) -> Image {
        let is_red = |index: usize| {
            let (x, y) = (index % WIDTH, index / WIDTH);
            (left..left + 8).contains(&x) && (top..top + 8).contains(&y)
        };
        let pixels = (0..WIDTH * HEIGHT)
            .flat_map(|index| if is_red(index) { [255, 0, 0] } else { [0, 0, 255] });
        Image { width: WIDTH, height: HEIGHT, rgb: pixels.collect() }
    }

    #[test]
    fn a_rare_color_is_kept() {
        let rare = [10, 200, 10];
        let common = |index: u32| [(index % 64 * 4) as u8, 0, (index / 64 % 64 * 4) as u8];
        let pixels = (0..2 * 64 * 64).flat_map(common).chain(rare);
        let rgb: Vec<u8> = pixels.collect();
        let palette = Palette::of(&[Image { width: rgb.len() / 3, height: 1, rgb }]);
        assert!(palette.rgb.as_chunks::<3>().0.contains(&rare));
    }

    #[test]
    fn a_reader_sees_the_pictures_again() {
        let places = [[3, 3], [3, 3], [9, 5], [56, 40]];
        let pictures = places.map(picture);
        let mut animation = Animation::of(&pictures[..3]).unwrap().unwrap();
        animation.add(&pictures[3..]).unwrap();
        let file = animation.finish().unwrap();
        let mut options = gif::DecodeOptions::new();
        options.set_color_output(gif::ColorOutput::RGBA);
        let mut reader = options.read_info(file.as_slice()).unwrap();
        let mut canvas = vec![[0_u8; 4]; WIDTH * HEIGHT];
        for place in places {
            let frame = reader.read_next_frame().unwrap().unwrap();
            for (index, pixel) in frame.buffer.as_chunks::<4>().0.iter().enumerate() {
                let (x, y) = (index % usize::from(frame.width), index / usize::from(frame.width));
                let (x, y) = (x + usize::from(frame.left), y + usize::from(frame.top));
                if pixel[3] > 0 {
                    canvas[y * WIDTH + x] = *pixel;
                }
            }
            let expected = picture(place);
            for (seen, drawn) in canvas.iter().zip(expected.rgb.as_chunks::<3>().0) {
                assert!(seen.iter().zip(drawn).all(|(a, b)| a.abs_diff(*b) < 16), "{seen:?}");
            }
        }
        assert!(reader.read_next_frame().unwrap().is_none());
    }
}
