//! A picture, and the colors of screens.

use nalgebra::Vector3;
use std::sync::LazyLock;

/// A picture of 8-bit colors, as screens have them (sRGB).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// In pixels.
    pub width: usize,
    /// In pixels.
    pub height: usize,
    /// `[height, width, 3]`, from the upper left, row by row.
    pub rgb: Vec<u8>,
}

/// A picture could not be encoded.
#[derive(Debug, thiserror::Error)]
#[error("cannot encode a picture of {width} by {height} pixels as PNG")]
pub struct PngError {
    /// In pixels.
    pub width: usize,
    /// In pixels.
    pub height: usize,
    /// What the encoder said.
    pub source: png::EncodingError,
}

impl Image {
    /// The picture as a PNG file.
    pub fn png(&self) -> Result<Vec<u8>, PngError> {
        let Self { width, height, ref rgb } = *self;
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, width as u32, height as u32);
        encoder.set_color(png::ColorType::Rgb);
        let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(rgb));
        match written {
            Ok(()) => Ok(file),
            Err(source) => Err(PngError { width, height, source }),
        }
    }
}

/// From a number as screens have it to one in proportion to light.
#[expect(
    clippy::disallowed_methods,
    reason = "what is drawn is looked at, and nothing is computed from it"
)]
pub(super) fn linear(srgb: f32) -> f32 {
    if srgb <= 0.04045 { srgb / 12.92 } else { ((srgb + 0.055) / 1.055).powf(2.4) }
}

/// The other way round, in 8 bits.
#[expect(
    clippy::disallowed_methods,
    reason = "what is drawn is looked at, and nothing is computed from it"
)]
pub(super) fn encode(linear: &Vector3<f32>) -> [u8; 3] {
    const STEPS: u16 = 4095;
    static TABLE: LazyLock<Vec<u8>> = LazyLock::new(|| {
        let encoded = |step: u16| {
            let light = f32::from(step) / f32::from(STEPS);
            let srgb = if light <= 0.003_130_8 {
                12.92 * light
            } else {
                1.055 * light.powf(1.0 / 2.4) - 0.055
            };
            (255.0 * srgb).round() as u8
        };
        (0..=STEPS).map(encoded).collect()
    });
    let table: &[u8] = &TABLE;
    [linear.x, linear.y, linear.z]
        .map(|light| table[(light.clamp(0.0, 1.0) * f32::from(STEPS) + 0.5) as usize])
}
