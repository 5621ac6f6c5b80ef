//! The path through space with the robot drawn at intervals.

mod bird;
mod room;
mod sheet;

use wingbeat::scenario::PaperResults;
use wingbeat::simulate::Record;

use crate::space::WorldPoint;
use crate::write::Figure;
use crate::{Error, needed};
use bird::{birds, interval};
use room::SceneBox;
use sheet::PathSheet;

/// The path `p_WB_x`, `p_WB_y`, `p_WB_z` (world frame) above its shadow on the floor of the axes. Where the record has the ends of
/// the surfaces' panels, `<line>_[<surface>_][<side>_]<end>_x/y/z` (world frame; leading, trailing; left, right), the surfaces
/// are drawn every few tenths of a second. Where `paper` says where the flight ends, that place is marked at the height of
/// the own end. So is the place of a perch, `perch_x`, `perch_y`, `perch_z`.
pub fn path(record: &Record, paper: Option<&PaperResults>) -> Result<Figure, Error> {
    let t = needed(record, "t")?;
    let track = points(record, "p_WB")?;
    if track.len() < 2 {
        return Err(Error::Rows { rows: track.len(), needed: 2 });
    }
    let birds = birds(record, t, &track);
    // The turn of a positive roll is to the right, towards negative y.
    let published = paper.map(|paper| {
        let end = track[track.len() - 1];
        [track[0][0] + paper.distance_x_m, track[0][1] - paper.roll_deg.signum() * paper.distance_y_m, end[2]]
    });
    let perch = points(record, "perch").ok().and_then(|perch| perch.first().copied());
    let seen: Vec<WorldPoint> = track.iter().copied().chain(published).chain(perch).collect();
    let room = SceneBox::around(&seen, &birds);
    let mut sheet = PathSheet::new(&room);
    sheet.ground(&room);
    sheet.shadow(&room, &track);
    sheet.track(&track);
    let (apart, every) = bird::apart(birds, room.enlargement);
    let every = every.map(|every| every as f64 * interval(t));
    apart.iter().for_each(|bird| sheet.bird(&room, bird));
    sheet.ends(&track, t);
    published.into_iter().for_each(|point| sheet.published(&room, point));
    perch.into_iter().for_each(|place| sheet.perch(&room, place));
    sheet.note(&apart, every, room.enlargement);
    Ok(Figure::new("path", sheet.scene))
}

/// The points `<name>_x`, `_y`, `_z` of every row.
fn points(record: &Record, name: &str) -> Result<Vec<WorldPoint>, Error> {
    let [x, y, z] = ["x", "y", "z"].map(|axis| needed(record, &format!("{name}_{axis}")));
    let (x, y, z) = (x?, y?, z?);
    Ok((0..x.len()).map(|row| [x[row], y[row], z[row]]).collect())
}
