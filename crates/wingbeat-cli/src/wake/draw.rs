//! The figures of a wake.

use wingbeat::math::Vec3;
use wingbeat_figures::{Cut, WakeSheet, frontal_planes, wake};

use super::watch::{Shot, Watch};
use crate::error::Error;
use crate::run_folder::RunFolder;
use crate::say;

/// Distance of the frontal plane behind the rearmost trailing edge, chords. *Choice.*
const BEHIND: f64 = 0.5;
/// Radius of the spots that stand for vortices, chords. *Choice.*
const SPREAD: f64 = 0.1;
/// The phase at which the whole wake is drawn: the middle of the downstroke.
const DRAWN: usize = 1;

/// Draws what can be drawn; what cannot is said and left out.
pub fn draw(folder: &RunFolder, watch: &Watch) -> Result<(), Error> {
    let figures = folder.folder("figures")?;
    let mut shots: Vec<&Shot> = watch.shots.iter().collect();
    shots.sort_by_key(|shot| order(shot));
    let drawn = shots.get(DRAWN).or(shots.first()).map(|shot| wake(&sheet(shot)));
    let cuts: Vec<Cut> = shots.iter().map(|shot| cut(shot, watch)).collect();
    let planes = (!cuts.is_empty()).then(|| frontal_planes(&cuts, SPREAD * watch.chord));
    for figure in drawn.into_iter().chain(planes) {
        let outcome = figure.and_then(|figure| wingbeat_figures::write(&figures, &figure));
        if let Err(error) = outcome {
            say::note(&format!("a figure is left out: {error}"));
        }
    }
    Ok(())
}

/// Place of a phase among the four.
fn order(shot: &Shot) -> usize {
    super::stroke::NAMES.iter().position(|name| *name == shot.name).unwrap_or(0)
}

fn sheet(shot: &Shot) -> WakeSheet {
    let corners = |quad: &wingbeat_lattice::Quad| quad.corners.map(|corner| corner.0);
    WakeSheet {
        title: format!("wing and wake, {}, t = {:.3} s; attached flow assumed", shot.name, shot.picture.time),
        wing: shot.picture.wing.iter().map(corners).collect(),
        wake: shot.picture.wake.iter().map(|quad| (corners(quad), quad.circulation)).collect(),
    }
}

/// What crosses the plane across the wind behind the wing.
fn cut(shot: &Shot, watch: &Watch) -> Cut {
    let axes = watch.axes;
    let rearmost = shot.edges.iter().flatten().map(|p| p.dot(axes.flight)).fold(f64::INFINITY, f64::min);
    let origin = axes.flight * (rearmost - BEHIND * watch.chord);
    let in_plane = |p: Vec3| [p.dot(axes.left), p.dot(axes.up)];
    let crossings = shot.picture.crossings(origin, axes.flight);
    Cut {
        title: format!("{}, phase {:.2}", shot.name, shot.phase),
        vortices: crossings.into_iter().map(|(place, circulation)| (in_plane(place), circulation)).collect(),
        outline: shot.edges.iter().map(|edge| edge.iter().map(|p| in_plane(*p)).collect()).collect(),
    }
}
