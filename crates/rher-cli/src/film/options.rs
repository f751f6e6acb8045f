//! What can be asked of pictures.

use clap::builder::{PathBufValueParser, PossibleValuesParser, TypedValueParser};
use rher_envs::render::Viewpoint;
use std::num::NonZeroU16;
use std::path::PathBuf;

/// From where pictures are taken, and how large they are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Look {
    pub(crate) viewpoint: Viewpoint,
    pub(crate) size: PictureSize,
}

/// Width and height of pictures, in pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PictureSize(pub(crate) [NonZeroU16; 2]);

impl PictureSize {
    /// Unless another one is asked for.
    pub(crate) const DEFAULT: Self = Self([pixels(400), pixels(300)]);

    const SMALLEST: u16 = 64;
    const LARGEST: u16 = 3840;
}

const fn pixels(count: u16) -> NonZeroU16 {
    NonZeroU16::new(count).expect("pictures have pixels")
}

/// A file for moving pictures.
#[derive(Clone, Debug)]
pub(crate) struct FilmFile {
    pub(crate) path: PathBuf,
    pub(crate) format: Format,
}

/// What a film is written as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    Gif,
    /// By `ffmpeg`, as what it calls so.
    Video(&'static str),
}

/// Names of films, whose format their end says.
pub(crate) fn film() -> impl TypedValueParser<Value = FilmFile> {
    PathBufValueParser::new().try_map(|path| {
        let extension = path.extension().and_then(|extension| extension.to_str());
        let format = match extension {
            Some("gif") => Format::Gif,
            Some("mp4") => Format::Video("mp4"),
            Some("webm") => Format::Video("webm"),
            _ => return Err("expected a name that ends in `.gif`, `.mp4` or `.webm`"),
        };
        Ok(FilmFile { path, format })
    })
}

/// Names of cameras.
pub(crate) fn camera() -> impl TypedValueParser<Value = Viewpoint> {
    let names = PossibleValuesParser::new(Viewpoint::ALL.map(Viewpoint::name));
    names.try_map(|name| Viewpoint::named(&name).ok_or("no camera is called so"))
}

/// Sizes such as `400x300`.
pub(crate) fn size(text: &str) -> Result<PictureSize, String> {
    let (least, most) = (PictureSize::SMALLEST, PictureSize::LARGEST);
    let length = |text: &str| {
        let length: NonZeroU16 = text.parse().ok()?;
        (least..=most).contains(&length.get()).then_some(length)
    };
    let sides = text.split_once('x');
    let size = sides.and_then(|(width, height)| Some([length(width)?, length(height)?]));
    size.map(PictureSize).ok_or_else(|| {
        format!("expected width and height in pixels, each from {least} to {most}, as in `400x300`")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_size_is_two_lengths() {
        assert_eq!(size("64x3840").unwrap().0.map(NonZeroU16::get), [64, 3840]);
        for wrong in ["", "400", "63x300", "400x3841", "400×300", "400x300x2", "-64x64"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }
}
