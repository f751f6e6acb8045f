//! Films in the formats of video players: `ffmpeg` encodes what is piped into it.

use super::options::PictureSize;
use crate::host::own_group;
use rher_core::files::FileError;
use rher_envs::render::Image;
use std::fs::File;
use std::io::{self, Read as _, Seek as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use tempfile::NamedTempFile;

/// Pictures for each second: one for each environment step.
const RATE: u32 = 25;

/// How often the last picture of an episode is shown.
const LAST: usize = RATE as usize;

/// A film that is being encoded, beside the place where it will be.
pub(crate) struct Video {
    path: PathBuf,
    part: NamedTempFile,
    encoder: Encoder,
    /// What the encoder says on standard error.
    said: File,
}

/// A film could not be encoded.
#[derive(Debug, thiserror::Error)]
pub(crate) enum VideoError {
    #[error("cannot write `{}`: `ffmpeg`, which makes such files, is not on PATH", path.display())]
    NoEncoder { path: PathBuf },
    #[error("cannot write `{}`: `ffmpeg` failed: {said}", path.display())]
    Encoder { path: PathBuf, said: String },
}

/// A temporary file that is readable by whom the user's mask allows, as other files are.
fn new_file() -> tempfile::Builder<'static, 'static> {
    #[cfg_attr(not(unix), expect(unused_mut, reason = "other systems have no such modes"))]
    let mut new = tempfile::Builder::new();
    #[cfg(unix)]
    new.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    new
}

/// A process that ends with its owner.
struct Encoder(Child);

impl Drop for Encoder {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Video {
    /// Starts a film that will have this path, of a format that `ffmpeg` knows.
    pub(crate) fn start(
        path: &Path,
        format: &str,
        PictureSize([width, height]): PictureSize,
    ) -> anyhow::Result<Self> {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        let part = new_file()
            .prefix(".rher-")
            .suffix(".new")
            .tempfile_in(folder.unwrap_or(Path::new(".")))
            .map_err(FileError::write(path))?;
        let said = tempfile::tempfile().map_err(FileError::write(path))?;
        let mut command = Command::new("ffmpeg");
        command
            .args(["-hide_banner", "-loglevel", "error", "-y"])
            .args(["-f", "rawvideo", "-pixel_format", "rgb24"])
            .args(["-video_size", &format!("{width}x{height}")])
            .args(["-framerate", &RATE.to_string(), "-i", "pipe:0"])
            // What every player shows: half as many colors, in pictures of even width and height.
            .args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p"])
            .args(["-f", format])
            .arg(part.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(said.try_clone().map_err(FileError::write(path))?);
        // Ctrl-C asks for the end of the episode, and not for that of the encoder.
        own_group(&mut command);
        let path = path.to_owned();
        let encoder = match command.spawn() {
            Ok(child) => Encoder(child),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                return Err(VideoError::NoEncoder { path }.into());
            }
            Err(error) => {
                return Err(VideoError::Encoder { path, said: error.to_string() }.into());
            }
        };
        Ok(Self { path, part, encoder, said })
    }

    /// Adds the pictures of an episode.
    pub(crate) fn add(&mut self, episode: &[Image]) -> Result<(), VideoError> {
        let held = episode.last().into_iter().cycle().take(LAST - 1);
        for image in episode.iter().chain(held) {
            let input = self.encoder.0.stdin.as_mut();
            if input.is_none_or(|input| input.write_all(&image.rgb).is_err()) {
                return Err(self.failed());
            }
        }
        Ok(())
    }

    /// Puts the whole film in its place.
    pub(crate) fn finish(mut self) -> anyhow::Result<()> {
        drop(self.encoder.0.stdin.take());
        let is_well = self.encoder.0.wait().is_ok_and(|status| status.success());
        // On a full disk some versions end well, with an error among what they say.
        let is_silent = self.said.metadata().is_ok_and(|said| said.len() == 0);
        let is_there = self.part.as_file().metadata().is_ok_and(|film| film.len() > 0);
        if !(is_well && is_silent && is_there) {
            return Err(self.failed().into());
        }
        let written = self.part.as_file().sync_all().map_err(FileError::write(&self.path));
        written?;
        self.part.persist(&self.path).map_err(|error| FileError::write(&self.path)(error.error))?;
        Ok(())
    }

    /// Why the encoder did not take a picture, or ended badly.
    fn failed(&mut self) -> VideoError {
        // It has closed its input, and ends; what it has said is read as far as it can be.
        let _ = self.encoder.0.wait();
        let mut said = Vec::new();
        let _ = self.said.rewind().and_then(|()| self.said.read_to_end(&mut said));
        let said = String::from_utf8_lossy(&said);
        let last = said.lines().rfind(|line| !line.trim().is_empty());
        let said = last.unwrap_or("it does not say why").trim().to_owned();
        VideoError::Encoder { path: self.path.clone(), said }
    }
}
