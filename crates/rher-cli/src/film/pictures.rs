//! Pictures of episodes for `rher play`: a GIF file of all of them, a PNG file of every step.

use super::animation::Animation;
use super::filmed::SIZE;
use rher_core::files::{self, FileError};
use rher_envs::render::{Camera, Image, Renderer};
use rher_envs::thing::{Role, Thing};
use std::path::PathBuf;

/// Draws episodes, one after the other.
pub(crate) struct Pictures {
    gif: Option<PathBuf>,
    png_dir: Option<PathBuf>,
    renderer: Renderer,
    animation: Option<Animation>,
}

impl Pictures {
    /// For these files; the folder is made if it is not there. None if neither is asked for.
    pub(crate) fn new(
        gif: Option<&PathBuf>,
        png_dir: Option<&PathBuf>,
    ) -> Result<Option<Self>, FileError> {
        if let Some(folder) = png_dir {
            std::fs::create_dir_all(folder).map_err(FileError::write(folder))?;
        }
        let is_asked_for = gif.is_some() || png_dir.is_some();
        Ok(is_asked_for.then(|| Self {
            gif: gif.cloned(),
            png_dir: png_dir.cloned(),
            renderer: Renderer::new(SIZE),
            animation: None,
        }))
    }

    /// Draws an episode: what there was to see at its beginning and after each of its steps.
    ///
    /// Of all marks only the goals of the task are drawn.
    pub(crate) fn add(&mut self, number: u64, seen: &[Vec<Thing>]) -> anyhow::Result<()> {
        let is_shown = |thing: &&Thing| thing.role != Role::Mark || thing.name.starts_with("goal_");
        let mut images: Vec<Image> = Vec::with_capacity(seen.len());
        for things in seen {
            let things: Vec<Thing> = things.iter().filter(is_shown).cloned().collect();
            images.push(self.renderer.draw(&Camera::above_table(&things), &things));
        }
        if let Some(folder) = &self.png_dir {
            for (step, image) in images.iter().enumerate() {
                let name = format!("episode-{number:03}-step-{step:03}.png");
                files::replace(&folder.join(name), &image.png()?)?;
            }
        }
        if self.gif.is_some() {
            match &mut self.animation {
                Some(animation) => animation.add(&images)?,
                None => self.animation = Animation::of(&images)?,
            }
        }
        Ok(())
    }

    /// Writes the moving picture; files of single steps are there already.
    pub(crate) fn finish(self) -> anyhow::Result<()> {
        if let (Some(path), Some(animation)) = (self.gif, self.animation) {
            files::replace(&path, &animation.finish()?)?;
        }
        Ok(())
    }
}
