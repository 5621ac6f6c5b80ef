//! Class 7: pictures tell the truth; the runs that are looked at are data, `pictures.toml`.

use std::fs;
use std::path::{Path, PathBuf};

use super::case::{CaseOutcome, ScriptedCase};
use super::place::CaseFolder;

/// The cases.
pub fn cases() -> Vec<ScriptedCase> {
    vec![ScriptedCase::new(7, "a_simulated_cell_is_called_simulated", |place| {
        place.write_texts()?;
        place
            .run(&["rig", "simulate", "hold.toml", "--set", "rig.rest_s=0", "--quiet", "--out", "s"])?
            .exits(0)?;
        place.run(&["rig", "process", "s/ho", "--quiet", "--out", "a"])?.exits(0)?;
        looked_at(place, "a")?;
        let said = |path: &PathBuf| fs::read_to_string(path).is_ok_and(|text| text.contains("simulated"));
        match pictures(&place.path("a"), "svg").iter().any(said) {
            true => Ok(()),
            false => Err("no picture says simulated".into()),
        }
    })]
}

/// All pictures of the folder come in pairs, no label says what is no number, and the ticks of an axis differ, ascend
/// along it and lie where their numbers say.
pub fn looked_at(place: &CaseFolder, folder: &str) -> CaseOutcome {
    let (drawn, painted) = (pictures(&place.path(folder), "svg"), pictures(&place.path(folder), "png"));
    let stems =
        |all: &[PathBuf]| -> Vec<PathBuf> { all.iter().map(|path| path.with_extension("")).collect() };
    if drawn.is_empty() || stems(&drawn) != stems(&painted) {
        return Err(format!("{} drawn, {} painted", drawn.len(), painted.len()));
    }
    drawn.iter().try_for_each(|path| {
        let text = fs::read_to_string(path).map_err(|error| error.to_string())?;
        labelled(&text).map_err(|what| format!("{}: {what}", path.display()))
    })
}

fn pictures(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for path in fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()) {
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == ending) {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// A text of a picture: where it stands, from which end it is written, what it says.
struct PictureLabel<'a> {
    x: f64,
    y: f64,
    anchor: &'a str,
    text: &'a str,
}

fn labels_of(picture: &str) -> Vec<PictureLabel<'_>> {
    let read =
        |piece: &'_ str| -> Option<(usize, usize)> { Some((piece.find('>')?, piece.find("</text>")?)) };
    let mut all = Vec::new();
    for piece in picture.split("<text").skip(1) {
        let Some((open, close)) = read(piece) else { continue };
        let attribute = |name: &str| piece[..open].split(&format!(" {name}=\"")).nth(1)?.split('"').next();
        let number = |name: &str| attribute(name).and_then(|text| text.parse().ok()).unwrap_or(f64::NAN);
        let text = piece[open + 1..close].trim();
        all.push(PictureLabel {
            x: number("x"),
            y: number("y"),
            anchor: attribute("text-anchor").unwrap_or(""),
            text,
        });
    }
    all
}

fn labelled(picture: &str) -> CaseOutcome {
    let labels = labels_of(picture);
    if let Some(bad) = labels.iter().find(|l| ["NaN", "inf", "-inf", "−inf"].contains(&l.text)) {
        return Err(format!("a label says {}", bad.text));
    }
    // A panel is a group of its own.
    picture.split("<g>").try_for_each(|panel| ascending(&labels_of(panel)))
}

/// The ticks of one axis follow one another: up a column where they end, or along a row where they are centred.
fn ascending(labels: &[PictureLabel]) -> CaseOutcome {
    let along = |l: &PictureLabel| if l.anchor == "end" { (l.x, -l.y) } else { (l.y, l.x) };
    let same =
        |a: &PictureLabel, b: &PictureLabel| a.anchor == b.anchor && (along(a).0 - along(b).0).abs() < 0.1;
    for axis in labels.chunk_by(same) {
        let ticks: Option<Vec<(f64, f64)>> =
            axis.iter().filter(|l| !l.text.is_empty()).map(|l| Some((along(l).1, number(l.text)?))).collect();
        let Some(ticks) = ticks.filter(|ticks| ticks.len() > 1) else { continue };
        let said = || axis.iter().map(|l| l.text).collect::<Vec<_>>().join(", ");
        let (first, last) = (ticks[0], ticks[ticks.len() - 1]);
        let rate = (last.1 - first.1) / (last.0 - first.0);
        if ticks.windows(2).any(|w| !((w[1].1 - w[0].1) * rate * (w[1].0 - w[0].0) > 0.0)) {
            return Err(format!("ticks do not ascend: {}", said()));
        }
        let off = |t: &(f64, f64)| ((t.1 - first.1) / rate - (t.0 - first.0)).abs();
        if ticks.iter().any(|t| off(t) > 1.5) {
            return Err(format!("ticks do not lie where they say: {}", said()));
        }
    }
    Ok(())
}

fn number(text: &str) -> Option<f64> {
    text.replace('−', "-").parse().ok()
}
