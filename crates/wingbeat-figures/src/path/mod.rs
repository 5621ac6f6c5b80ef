//! The path through space with the robot drawn at intervals.

mod bird;
pub(crate) mod projection;
mod room;
mod sheet;

use wingbeat::simulate::Record;

use crate::write::Figure;
use crate::{Error, needed};
use bird::birds;
use room::Room;
use sheet::Sheet;

/// A point in world coordinates, m.
type Point = [f64; 3];

/// The path `p_WB_x`, `p_WB_y`, `p_WB_z` (world frame) above its shadow on the ground. Where the record has the
/// wings' points `<line>_<side>_<joint>_x/y/z` (world frame; leading, trailing; left, right; shoulder, elbow, tip),
/// the wings are drawn every quarter second.
pub fn path(record: &Record) -> Result<Figure, Error> {
    let t = needed(record, "t")?;
    let track = points(record, "p_WB")?;
    if track.len() < 2 {
        return Err(Error::Rows { rows: track.len(), needed: 2 });
    }
    let birds = birds(record, t, &track);
    let room = Room::around(&track, &birds);
    let mut sheet = Sheet::new(&room);
    sheet.ground(&room);
    sheet.shadow(&room, &track);
    sheet.track(&track);
    birds.iter().for_each(|bird| sheet.bird(&room, bird));
    sheet.ends(&track, t);
    sheet.note(&birds, room.enlargement);
    Ok(Figure::new("path", sheet.scene))
}

/// The points `<name>_x`, `_y`, `_z` of every row.
fn points(record: &Record, name: &str) -> Result<Vec<Point>, Error> {
    let [x, y, z] = ["x", "y", "z"].map(|axis| needed(record, &format!("{name}_{axis}")));
    let (x, y, z) = (x?, y?, z?);
    Ok((0..x.len()).map(|row| [x[row], y[row], z[row]]).collect())
}
