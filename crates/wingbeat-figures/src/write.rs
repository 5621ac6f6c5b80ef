//! A figure to its files.

use std::fs;
use std::path::Path;

use kuva::backend::png::PngBackend;
use kuva::backend::svg::SvgBackend;
use kuva::render::render::Scene;

use crate::Error;

/// Pixels of a PNG per pixel of the drawing: 300 per inch at a page's width.
const PNG_SCALE: f32 = 2.5;

/// A figure ready to be written.
pub struct Figure {
    /// Name of its files without extension.
    pub name: &'static str,
    pub(crate) scene: Scene,
}

/// Writes `<name>.svg` and `<name>.png` into `folder`.
pub fn write(folder: &Path, figure: &Figure) -> Result<(), Error> {
    let file = |extension: &str, bytes: &[u8]| {
        let path = folder.join(figure.name).with_extension(extension);
        fs::write(&path, bytes).map_err(|source| Error::File { path, source })
    };
    file("svg", SvgBackend::default().render_scene(&figure.scene).as_bytes())?;
    let png = PngBackend::new().with_scale(PNG_SCALE).render_scene(&figure.scene).map_err(Error::Picture)?;
    file("png", &png)
}
