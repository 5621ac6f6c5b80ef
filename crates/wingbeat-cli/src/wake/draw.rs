//! The figures of a wake.

use wingbeat::math::Vec3;
use wingbeat_figures::{PlaneCut, WakeSheet, around, frontal_planes, wake, wake_phases};
use wingbeat_lattice::course::{CourseWatch, LatticeShot, PHASES};

use crate::error::Error;
use crate::run_folder::RunFolder;

/// Distance of the frontal plane behind the rearmost trailing edge, chords. *Choice.*
const BEHIND: f64 = 0.5;
/// Radius of the spots that stand for vortices, chords. *Choice.*
const SPREAD: f64 = 0.1;
/// The phase at which the whole wake is drawn: the middle of the downstroke.
const DRAWN: usize = 1;

/// Draws what can be drawn; what cannot is said and left out.
pub fn draw(folder: &RunFolder, watches: &[CourseWatch<'_>]) -> Result<(), Error> {
    let figures = folder.folder("figures")?;
    let shots: Vec<Vec<&LatticeShot>> = watches.iter().map(in_order).collect();
    let whole = watches.iter().zip(&shots);
    let sheets: Vec<WakeSheet> = whole
        .clone()
        .filter_map(|(watch, shots)| shots.get(DRAWN).or(shots.first()).map(|shot| sheet(shot, watch)))
        .collect();
    // Phase by phase, the courses beside each other.
    let most = shots.iter().map(Vec::len).max().unwrap_or(0);
    let cuts = (0..most).flat_map(|phase| {
        whole.clone().filter_map(move |(watch, shots)| shots.get(phase).map(|shot| cut(shot, watch)))
    });
    let cuts: Vec<PlaneCut> = cuts.collect();
    let chord = watches.first().map_or(1.0, |watch| watch.course.chord);
    let notes = notes(watches);
    let in_space = phases(watches);
    let in_space = (!in_space.is_empty()).then(|| wake_phases(&in_space, &notes, false));
    let drawn = (!sheets.is_empty()).then(|| wake(&sheets));
    let planes = (!cuts.is_empty()).then(|| frontal_planes(&cuts, &notes, SPREAD * chord));
    for figure in drawn.into_iter().chain(in_space).chain(planes) {
        let outcome = figure.and_then(|figure| wingbeat_figures::write(&figures, &figure));
        crate::fly::left_out(outcome)?;
    }
    Ok(())
}

/// Every shot of all courses with the strongest ring of its wake told.
pub fn phases(watches: &[CourseWatch<'_>]) -> Vec<WakeSheet> {
    let of = |watch: &CourseWatch<'_>| {
        in_order(watch).into_iter().map(|shot| phase(shot, watch)).collect::<Vec<_>>()
    };
    watches.iter().flat_map(of).collect()
}

/// What must be known to read figures of several phases.
pub fn notes(watches: &[CourseWatch<'_>]) -> Vec<String> {
    let told = |watch: &CourseWatch<'_>| format!("{}: {}", watch.course.title, watch.course.assumed());
    let mut notes: Vec<String> = match watches {
        [only] => vec![only.course.assumed()],
        _ => watches.iter().map(told).collect(),
    };
    notes.extend(watches.iter().find_map(|watch| watch.course.crossing()).map(Into::into));
    notes
}

/// The shots in the order of the phases.
fn in_order<'a>(watch: &'a CourseWatch<'_>) -> Vec<&'a LatticeShot> {
    let mut shots: Vec<&LatticeShot> = watch.shots.iter().collect();
    shots.sort_by_key(|shot| PHASES.iter().position(|name| *name == shot.name).unwrap_or(0));
    shots
}

/// A shot with the strongest ring of its wake told.
fn phase(shot: &LatticeShot, watch: &CourseWatch<'_>) -> WakeSheet {
    let whole = sheet(shot, watch);
    let title = match watch.course.name.as_str() {
        "" => shot.name.clone(),
        _ => format!("{}: {}", watch.course.title, shot.name),
    };
    let note = watch.strongest(shot).map_or_else(String::new, |strongest| {
        let stroke = if strongest.in_downstroke { "downstroke" } else { "upstroke" };
        let (circulation, cycles) = (strongest.circulation_m2_s, strongest.shed_before_cycles);
        format!("strongest: {circulation:.3} m2/s, {cycles:.2} cycles old, of a {stroke}")
    });
    WakeSheet { title, note, ..whole }
}

/// Wing and wake from the body's origin, along flight, left and up.
fn sheet(shot: &LatticeShot, watch: &CourseWatch<'_>) -> WakeSheet {
    let course = watch.course;
    let at = |p: Vec3| course.axes.of(p - shot.origin).0;
    let corners = |quad: &wingbeat_lattice::Quad| quad.corners.map(at);
    let begin = course.flown.as_ref().map_or(0.0, |flown| flown.from_s);
    WakeSheet {
        title: format!("{}, {}, t = {:.3} s", course.title, shot.name, begin + shot.picture.time),
        note: course.note(),
        wing: shot.picture.wing.iter().map(corners).collect(),
        wake: shot.picture.wake.iter().map(|quad| (corners(quad), quad.circulation)).collect(),
        outline: shot.edges.chunks_exact(2).map(|pair| outline(&pair[0], &pair[1], at)).collect(),
    }
}

/// The outline of a surface between its leading and trailing edge.
fn outline(leading: &[Vec3], trailing: &[Vec3], at: impl Fn(Vec3) -> [f64; 3]) -> Vec<[f64; 3]> {
    let [leading, trailing] = [leading, trailing].map(|edge| edge.iter().map(|p| at(*p)).collect::<Vec<_>>());
    around(&leading, &trailing)
}

/// What crosses the plane across the flight behind the wing.
fn cut(shot: &LatticeShot, watch: &CourseWatch<'_>) -> PlaneCut {
    let (course, axes) = (watch.course, watch.course.axes);
    let rearmost = shot.edges.iter().flatten().map(|p| p.dot(axes.flight)).fold(f64::INFINITY, f64::min);
    let plane = axes.flight * (rearmost - BEHIND * course.chord);
    let in_plane = |p: Vec3| {
        let place = axes.of(p - shot.origin);
        [place[1], place[2]]
    };
    let crossings = shot.picture.crossings(plane, axes.flight);
    let title = match course.name.as_str() {
        "" => format!("{}, phase {:.2}", shot.name, shot.phase),
        _ => format!("{}: {}", course.title, shot.name),
    };
    PlaneCut {
        title,
        vortices: crossings.into_iter().map(|(place, circulation)| (in_plane(place), circulation)).collect(),
        outline: shot.edges.iter().map(|edge| edge.iter().map(|p| in_plane(*p)).collect()).collect(),
    }
}
