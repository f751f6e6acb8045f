//! Drawings as files.

use super::chart::Drawing;
use crate::output;
use anyhow::Context as _;
use std::path::Path;

impl Drawing {
    /// Writes it as pixels or as SVG, by the end of the name of the file; `label` says what it shows.
    pub(crate) fn write(&self, out: &Path, label: &str) -> anyhow::Result<()> {
        let file = if out.extension().is_some_and(|extension| extension == "png") {
            let image =
                self.image().context("too many panels for one picture: expected fewer runs")?;
            image.png()?
        } else {
            self.svg(label).into_bytes()
        };
        Ok(output::write(out, &file)?)
    }
}
