//! Pictures of episodes for `rher play`: a film of all of them, a PNG file of every step.

use super::animation::Animation;
use super::filmed::Filmer;
use super::options::{FilmFile, Format, Look, PictureSize};
use super::video::Video;
use crate::cli::PictureArgs;
use crate::errors::Invisible;
use crate::numbers::{bytes, thousands};
use crate::output;
use crate::printer::Printer;
use rher_core::evaluate::Played;
use rher_core::files::{self, FileError};
use rher_envs::render::Image;
use rher_envs::{Simulated, Task};
use std::path::{Path, PathBuf};

/// Pictures that a film goes on for once the task is solved.
const AFTER_SUCCESS: usize = 10;

/// Draws episodes, one after the other.
pub(crate) struct Pictures<E, const N: usize> {
    filmer: Filmer<E, N>,
    size: PictureSize,
    film: Option<Film>,
    is_trimmed: bool,
    png_dir: Option<PathBuf>,
    /// PNG files.
    files: u64,
}

/// A film that is being made.
struct Film {
    path: PathBuf,
    encoding: Encoding,
    /// Pictures so far.
    count: u64,
}

enum Encoding {
    /// None before the first picture.
    Gif(Option<Animation>),
    Video(Video),
}

impl<E: Simulated<N>, const N: usize> Pictures<E, N> {
    /// For the files that are asked for; a folder is made if it is not there. None if there are none.
    ///
    /// `env` is of `task`; `reach_distance` is the policy's, in meters.
    pub(crate) fn new(
        args: &PictureArgs,
        env: E,
        task: Task,
        reach_distance: f32,
    ) -> anyhow::Result<Option<Self>> {
        let &PictureArgs { ref film, ref png_dir, camera: viewpoint, size, trim } = args;
        if film.is_none() && png_dir.is_none() {
            return Ok(None);
        }
        if env.things().is_empty() {
            return Err(Invisible { task: task.name() }.into());
        }
        if let Some(folder) = png_dir {
            std::fs::create_dir_all(folder).map_err(FileError::write(folder))?;
        }
        Ok(Some(Self {
            filmer: Filmer::new(env, task, reach_distance, Look { viewpoint, size }),
            size,
            film: film.as_ref().map(|file| Film::start(file, size)).transpose()?,
            is_trimmed: trim,
            png_dir: png_dir.clone(),
            files: 0,
        }))
    }

    /// Draws an episode: its beginning and the end of each of its steps.
    pub(crate) fn add(&mut self, number: u64, played: &Played<N>) -> anyhow::Result<()> {
        let footage = self.filmer.film(played)?;
        if let Some(folder) = &self.png_dir {
            for (step, image) in footage.images.iter().enumerate() {
                let name = format!("episode-{number:03}-step-{step:03}.png");
                files::replace(&folder.join(name), &image.png()?)?;
                self.files += 1;
            }
        }
        if let Some(film) = &mut self.film {
            let end = if self.is_trimmed { trimmed(&footage.solved) } else { footage.images.len() };
            film.add(&footage.images[..end])?;
        }
        Ok(())
    }

    /// Writes the film, and prints what was written.
    pub(crate) fn finish(self, printer: Printer) -> anyhow::Result<()> {
        let PictureSize([width, height]) = self.size;
        if let Some(film) = self.film.filter(|film| film.count > 0) {
            let (path, count) = (film.path.clone(), film.count);
            film.finish()?;
            let size = std::fs::metadata(&path).map_err(FileError::read(&path))?.len();
            printer.note(format_args!(
                "film  {} ({width} × {height} pixels, {} pictures, {})",
                path.display(),
                thousands(count),
                bytes(size)
            ));
        }
        if let Some(folder) = self.png_dir {
            let (count, folder) = (thousands(self.files), folder.display());
            printer.note(format_args!(
                "pictures  {folder} ({width} × {height} pixels, {count} files)"
            ));
        }
        Ok(())
    }
}

/// How many pictures of an episode there are up to shortly after the step from which on its task
/// was solved; all if it was not in the end.
fn trimmed(solved: &[bool]) -> usize {
    let last_unsolved = solved.iter().rposition(|is_solved| !is_solved);
    let solved_from = last_unsolved.map_or(0, |step| step + 1);
    solved.len().min(solved_from + 1 + AFTER_SUCCESS)
}

impl Film {
    fn start(FilmFile { path, format }: &FilmFile, size: PictureSize) -> anyhow::Result<Self> {
        let path = &output::target(path)?;
        let encoding = match format {
            Format::Gif => Encoding::Gif(None),
            Format::Video(format) => Encoding::Video(Video::start(path, format, size)?),
        };
        Ok(Self { path: path.clone(), encoding, count: 0 })
    }

    fn add(&mut self, episode: &[Image]) -> anyhow::Result<()> {
        self.count += episode.len() as u64;
        match &mut self.encoding {
            Encoding::Gif(Some(animation)) => animation.add(episode)?,
            Encoding::Gif(animation) => *animation = Animation::of(episode)?,
            Encoding::Video(video) => video.add(episode)?,
        }
        Ok(())
    }

    fn finish(self) -> anyhow::Result<()> {
        match self.encoding {
            Encoding::Gif(None) => Ok(()),
            Encoding::Gif(Some(animation)) => write(&self.path, animation),
            Encoding::Video(video) => video.finish(),
        }
    }
}

fn write(path: &Path, animation: Animation) -> anyhow::Result<()> {
    Ok(files::replace(path, &animation.finish()?)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_film_ends_shortly_after_success() {
        let solved = |from: usize| (0..=50).map(|step| step >= from).collect::<Vec<_>>();
        assert_eq!(trimmed(&solved(20)), 31);
        assert_eq!(trimmed(&solved(0)), 11);
        assert_eq!(trimmed(&solved(45)), 51);
        assert_eq!(trimmed(&solved(51)), 51);
    }
}
