//! A figure to its files.

use std::fs;
use std::path::Path;

use png::Compression;

use crate::canvas::Canvas;
use crate::{Error, raster, strokes, style};

/// Pixels of a PNG per pixel of the drawing: 180 per inch at a page's width. *Choice*: the SVG beside it is for print.
const SCREEN: f64 = 1.5;
/// Pixels of the width of a slide.
const SLIDE: f64 = 1920.0;

/// A figure ready to be written.
pub struct Figure {
    /// Name of its files without extension.
    pub name: &'static str,
    pub(crate) scene: Canvas,
}

impl Figure {
    pub(crate) fn new(name: &'static str, scene: Canvas) -> Self {
        Self { name, scene: strokes::cut(scene) }
    }

    /// The same figure under another name.
    pub fn named(self, name: &'static str) -> Self {
        Self { name, ..self }
    }

    /// The figure in the middle of a page of 16 to 9 that just holds it.
    fn slide(self) -> Self {
        let (width, height) = (self.scene.width, self.scene.height);
        let page = (width.max(height * 16.0 / 9.0), height.max(width * 9.0 / 16.0));
        let mut scene = Canvas::new(page.0, page.1);
        scene.elements = style::moved(self.scene, 0.5 * (page.0 - width), 0.5 * (page.1 - height));
        Self { scene, ..self }
    }

    /// The figure as PNG, for a page on a screen.
    ///
    /// # Errors
    /// A figure that cannot be drawn.
    pub fn png(&self) -> Result<Vec<u8>, Error> {
        rendered(self, SCREEN, Compression::Fast)
    }

    /// The figure as SVG.
    pub fn svg(&self) -> String {
        self.scene.svg(self.name)
    }
}

/// Reads the letters of all figures on a thread of its own, so that they are there when the first is drawn.
pub fn prepare() {
    // Without a thread the first figure reads them.
    drop(std::thread::Builder::new().spawn(raster::prepare));
}

/// Writes `<name>.svg` and `<name>.png` of 180 pixels per inch into `folder`.
pub fn write(folder: &Path, figure: &Figure) -> Result<(), Error> {
    write_both(folder, figure, &rendered(figure, SCREEN, Compression::Fast)?)
}

/// The same with a small PNG for a page on a screen.
pub fn write_for_screen(folder: &Path, figure: &Figure) -> Result<(), Error> {
    write_both(folder, figure, &rendered(figure, SCREEN, Compression::High)?)
}

/// Writes the figure in the middle of a page of 16 to 9, `<name>.svg` and a `<name>.png` of 1920 by 1080 pixels, into `folder`.
pub fn write_slide(folder: &Path, figure: Figure) -> Result<(), Error> {
    let slide = figure.slide();
    // A quarter of a pixel less, so that rounding up gives no pixel more.
    let scale = (SLIDE - 0.25) / slide.scene.width;
    write_both(folder, &slide, &rendered(&slide, scale, Compression::Fast)?)
}

fn rendered(figure: &Figure, scale: f64, compression: Compression) -> Result<Vec<u8>, Error> {
    let bitmap = raster::bitmap(&figure.scene, scale).map_err(Error::Picture)?;
    bitmap.png(compression).map_err(|error| Error::Picture(error.to_string()))
}

fn write_both(folder: &Path, figure: &Figure, png: &[u8]) -> Result<(), Error> {
    let file = |extension: &str, bytes: &[u8]| {
        let path = folder.join(figure.name).with_extension(extension);
        fs::write(&path, bytes).map_err(|source| Error::File { path, source })
    };
    file("svg", figure.svg().as_bytes())?;
    file("png", png)
}
