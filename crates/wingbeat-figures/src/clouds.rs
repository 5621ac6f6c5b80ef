//! Clouds of points in one panel, each with its name beside it.

use crate::canvas::{Canvas, TextAnchor};
use crate::plot_frame::{FrameAxis, MarkShape, PlotFrame, mark};
use crate::style;
use crate::write::Figure;

/// Room to the left of the frame, above and below it, px.
const LEFT: f64 = 72.0;
const HEAD: f64 = 14.0;
const FOOT: f64 = 46.0;
/// From the frame to the marks of the legend, from these to their names, and from name to name, px.
const BESIDE: f64 = 18.0;
const NAMES: f64 = 12.0;
const LINE: f64 = 20.0;
/// Width of a letter of the legend, px: that of the widest lines of names.
const LETTER: f64 = 7.2;
/// Room around the figure, px.
const PADDING: f64 = 6.0;

/// Points of one kind.
pub struct PointCloud {
    /// Name in the legend; none when empty.
    pub name: String,
    /// (x, y) in the units of the axes.
    pub points: Vec<(f64, f64)>,
    /// How they are marked.
    pub shape: MarkShape,
    /// Radius of a mark, px.
    pub size: f64,
    /// CSS colour.
    pub colour: String,
    /// Opacity of a mark (dimensionless).
    pub opacity: f64,
}

/// The clouds, the first below, in a figure of `height` (dimensionless) times its width, after what `beneath` draws in it; the
/// legend to the right.
pub fn clouds(
    name: &'static str,
    clouds: &[PointCloud],
    (x, y): (FrameAxis, FrameAxis),
    height: f64,
    beneath: impl FnOnce(&mut PlotFrame),
) -> Figure {
    let named: Vec<&PointCloud> = clouds.iter().filter(|cloud| !cloud.name.is_empty()).collect();
    let longest = named.iter().map(|cloud| cloud.name.chars().count()).max().unwrap_or(0) as f64;
    let legend = if named.is_empty() { PADDING } else { BESIDE + NAMES + LETTER * longest };
    let mut scene = Canvas::new(style::WIDTH, height * style::WIDTH);
    let panel = [PADDING, PADDING, style::WIDTH - 2.0 * PADDING, scene.height - 2.0 * PADDING];
    let mut frame = PlotFrame::new(panel, [LEFT, legend, HEAD, FOOT], x, y);
    beneath(&mut frame);
    for cloud in clouds {
        frame.marks(&cloud.points, cloud.shape, cloud.size, &cloud.colour, cloud.opacity);
    }
    frame.draw(&mut scene);
    let left = style::WIDTH - PADDING - legend + BESIDE;
    for (row, cloud) in named.into_iter().enumerate() {
        let y = PADDING + HEAD + LINE * (row as f64 + 0.5);
        scene.elements.extend(mark(
            (left, y),
            cloud.shape,
            cloud.size.max(3.2),
            &cloud.colour,
            cloud.opacity,
        ));
        scene.elements.push(style::words(left + NAMES, y + 4.5, &cloud.name, TextAnchor::Start, false));
    }
    Figure::new(name, scene)
}
