//! The pictures that `wingbeat wake` leaves as VTK files, read back.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::Error;

/// Largest file that is read, and the most of all, bytes.
const LARGEST: u64 = 64 << 20;
/// Most files that are read: `wingbeat wake` writes four a stretch.
const MOST: usize = 64;

/// Wings and wakes at an instant.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shot {
    /// Name of its file.
    pub name: String,
    /// Time, s.
    pub time: f64,
    /// Corners of the panels, four after four, m.
    pub corners: [Vec<f64>; 3],
    /// Circulation of each panel, m2/s.
    pub circulation: Vec<f64>,
    /// How many panels are of wings; those of wakes follow.
    pub wings: usize,
}

/// The shots of the VTK files in `folder`, by time.
pub fn shots(folder: &Path) -> Result<Vec<Shot>, Error> {
    let entries = std::fs::read_dir(folder).map_err(|source| Error::file(folder, source))?;
    let files = entries.filter_map(|entry| Some(entry.ok()?.path()));
    let files = files.filter(|file| file.extension().is_some_and(|extension| extension == "vtk"));
    let files: Vec<_> = files.collect();
    let size: u64 = files.iter().map(|file| file.metadata().map_or(0, |data| data.len())).sum();
    if files.len() > MOST || size > LARGEST {
        let what =
            format!("{} .vtk files of {size} bytes; read are at most {MOST} of {LARGEST}", files.len());
        return Err(Error::run(folder, what));
    }
    in_order(files.iter().map(|file| shot(file)))
}

/// Pictures by time.
pub fn in_order(shots: impl Iterator<Item = Result<Shot, Error>>) -> Result<Vec<Shot>, Error> {
    let mut shots = shots.collect::<Result<Vec<_>, _>>()?;
    sort(&mut shots);
    Ok(shots)
}

#[inline(never)]
fn sort(shots: &mut [Shot]) {
    shots.sort_by(|a, b| a.time.total_cmp(&b.time).then_with(|| a.name.cmp(&b.name)));
}

fn shot(path: &Path) -> Result<Shot, Error> {
    let mut text = String::new();
    let file = File::open(path).map_err(|source| Error::file(path, source))?;
    file.take(LARGEST).read_to_string(&mut text).map_err(|source| Error::file(path, source))?;
    read(path, &text)
}

/// The picture of a text, called after its file.
pub fn read(path: &Path, text: &str) -> Result<Shot, Error> {
    let name = path.file_stem().unwrap_or_default().to_string_lossy().replace('_', " ");
    parse(text).map(|shot| Shot { name, ..shot }).ok_or_else(|| {
        Error::run(path, "damaged: not the polygons with circulation that `wingbeat wake` writes")
    })
}

/// A picture as `wake` writes it.
fn parse(text: &str) -> Option<Shot> {
    let mut lines = text.lines();
    let title = lines.nth(1)?;
    let time = title.split("t = ").nth(1)?.trim_end_matches(" s").parse().ok()?;
    let mut shot = Shot { time, ..Shot::default() };
    let count: usize = lines.nth(2)?.strip_prefix("POINTS ")?.split(' ').next()?.parse().ok()?;
    for line in lines.by_ref().take(count) {
        let mut numbers = line.split(' ').map(str::parse::<f64>);
        for column in &mut shot.corners {
            column.push(numbers.next()?.ok().filter(|number| number.is_finite())?);
        }
    }
    let panels = count / 4;
    let mut numbers = lines.skip_while(|line| !line.starts_with("LOOKUP_TABLE")).skip(1);
    for _ in 0..panels {
        shot.circulation.push(numbers.next()?.parse().ok()?);
    }
    shot.wings = numbers.filter(|line| *line == "0").count();
    (shot.corners[2].len() == count && count == 4 * panels && shot.wings <= panels).then_some(shot)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_comes_back_and_a_damaged_one_does_not() {
        let text = "# vtk DataFile Version 3.0\nwings and wakes at t = 0.5 s\nASCII\nDATASET POLYDATA\nPOINTS 8 double\n\
                    0 1 2\n0 1 2\n0 1 2\n0 1 2\n3 1 2\n3 1 2\n3 1 2\n3 1 2\nPOLYGONS 2 10\n4 0 1 2 3\n4 4 5 6 7\n\
                    CELL_DATA 2\nSCALARS circulation_m2_s double 1\nLOOKUP_TABLE default\n0.25\n-1\n\
                    SCALARS part int 1\nLOOKUP_TABLE default\n0\n1\n";
        let shot = parse(text).unwrap();
        assert_eq!((shot.time, shot.wings, shot.circulation), (0.5, 1, vec![0.25, -1.0]));
        assert_eq!(shot.corners[0], [0.0, 0.0, 0.0, 0.0, 3.0, 3.0, 3.0, 3.0]);
        for cut in [0, 40, 100, 150, text.len() - 60] {
            assert!(parse(&text[..cut]).is_none(), "{cut}");
        }
    }
}
