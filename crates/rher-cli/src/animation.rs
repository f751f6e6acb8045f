//! Moving pictures: GIF files of episodes.

use color_quant::NeuQuant;
use gif::{DisposalMethod, Encoder, EncodingError, Frame, Repeat};
use rher_envs::render::Image;

/// Hundredths of a second for each frame: an environment step.
const DELAY: u16 = 4;

/// The same for the last frame of an episode.
const LAST_DELAY: u16 = 100;

/// Colours; one more says that a pixel is as it was.
const COLOURS: usize = 255;
const AS_IT_WAS: u8 = COLOURS as u8;

/// From 1, the best colours, to 30, the fastest search for them.
const HASTE: i32 = 10;

/// A GIF file that is being made, which repeats when it is shown.
pub(crate) struct Animation {
    encoder: Encoder<Vec<u8>>,
    palette: Palette,
    /// In pixels.
    width: usize,
    /// What a viewer sees now, in colours of the palette.
    shown: Vec<u8>,
}

impl Animation {
    /// A file that begins with the pictures of one episode, all of one size, and has its colours;
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
        let colours = self.palette.indices(image);
        let [left, top, right, bottom] = changed(&self.shown, &colours, self.width);
        let mut buffer = Vec::with_capacity((right - left) * (bottom - top));
        for row in top..bottom {
            let range = row * self.width + left..row * self.width + right;
            let old = self.shown.get(range.clone()).unwrap_or(&[]).iter().map(Some);
            let old = old.chain(std::iter::repeat(None));
            let new = colours[range].iter();
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
        self.shown = colours;
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

/// The colours of a file.
struct Palette {
    rgb: Vec<u8>,
    quantiser: NeuQuant,
    /// By the upper five, six and five bits of red, green and blue.
    known: Vec<Option<u8>>,
}

impl Palette {
    /// Those of the first and the last picture.
    fn of(episode: &[Image]) -> Self {
        let ends = [episode.first(), episode.last()];
        let rgb = ends.into_iter().flatten().flat_map(|image| image.rgb.as_chunks::<3>().0);
        let rgba: Vec<u8> = rgb.flat_map(|[r, g, b]| [*r, *g, *b, 255]).collect();
        let quantiser = NeuQuant::new(HASTE, COLOURS, &rgba);
        Self { rgb: quantiser.color_map_rgb(), quantiser, known: vec![None; 1 << 16] }
    }

    fn indices(&mut self, image: &Image) -> Vec<u8> {
        let pixels = image.rgb.as_chunks::<3>().0.iter();
        pixels
            .map(|[r, g, b]| {
                let key =
                    usize::from(r >> 3) << 11 | usize::from(g >> 2) << 5 | usize::from(b >> 3);
                let find = || self.quantiser.index_of(&[*r, *g, *b, 255]) as u8;
                *self.known[key].get_or_insert_with(find)
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(red_at: usize) -> Image {
        let pixels =
            (0..8 * 4).flat_map(|index| if index == red_at { [255, 0, 0] } else { [0, 0, 255] });
        Image { width: 8, height: 4, rgb: pixels.collect() }
    }

    #[test]
    fn a_reader_sees_the_pictures_again() {
        let places = [3, 3, 12, 31];
        let pictures = places.map(picture);
        let mut animation = Animation::of(&pictures[..3]).unwrap().unwrap();
        animation.add(&pictures[3..]).unwrap();
        let file = animation.finish().unwrap();
        let mut options = gif::DecodeOptions::new();
        options.set_color_output(gif::ColorOutput::RGBA);
        let mut reader = options.read_info(file.as_slice()).unwrap();
        let mut canvas = [[0_u8; 4]; 8 * 4];
        for place in places {
            let frame = reader.read_next_frame().unwrap().unwrap();
            for (index, pixel) in frame.buffer.as_chunks::<4>().0.iter().enumerate() {
                let (x, y) = (index % usize::from(frame.width), index / usize::from(frame.width));
                if pixel[3] > 0 {
                    canvas[(y + usize::from(frame.top)) * 8 + x + usize::from(frame.left)] = *pixel;
                }
            }
            let red: Vec<usize> = (0..8 * 4).filter(|index| canvas[*index][0] > 128).collect();
            assert_eq!(red, [place]);
        }
        assert!(reader.read_next_frame().unwrap().is_none());
    }
}
