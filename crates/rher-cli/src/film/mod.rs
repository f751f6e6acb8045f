//! Episodes as pictures.

mod animation;
mod caption;
mod filmed;
mod options;
mod pictures;
mod solved;
mod video;

pub(crate) use animation::Animation;
pub(crate) use filmed::Film;
pub(crate) use options::{FilmFile, PictureSize, camera, film, size};
pub(crate) use pictures::Pictures;
pub(crate) use solved::solved;
pub(crate) use video::VideoError;
