//! Class 7: pictures tell the truth, whatever the size of what they show.

use std::fs;
use std::path::{Path, PathBuf};

use super::case::{Case, Judged};
use super::place::Place;
use super::runs::{GLIDE, HOLD, SWEEP};

/// Runs whose pictures are looked at: name, words of the command. They come to lie in `a`.
const RUNS: [(&str, &[&str]); 29] = [
    ("step", &["tether", "{root}/cases/step.toml"]),
    ("plunge", &["tether", "{root}/cases/plunge.toml"]),
    ("pitch", &["tether", "{root}/cases/pitch.toml"]),
    ("flap", &["tether", "{root}/cases/flap_f1.toml"]),
    ("fold", &["tether", "{root}/cases/flap_fold.toml", "--set", "time.cycles=2"]),
    ("paper", &["tether", "{root}/cases/plunge.toml", "--set", "aero.preset=paper"]),
    ("stall", &["tether", "{root}/cases/plunge.toml", "--set", "aero.law=stall"]),
    ("lev", &["tether", "{root}/cases/plunge.toml", "--set", "aero.law=lev"]),
    ("slow", &["tether", "{root}/cases/step.toml", "--set", "wind.speed_m_s=0.01"]),
    ("fast", &["tether", "{root}/cases/step.toml", "--set", "wind.speed_m_s=30"]),
    ("thin_air", &["tether", "{root}/cases/step.toml", "--set", "wind.density_kg_m3=1e-9"]),
    ("thick_air", &["tether", "{root}/cases/step.toml", "--set", "wind.density_kg_m3=1e4"]),
    (
        "paper_lev",
        &["tether", "{root}/cases/plunge.toml", "--set", "aero.preset=paper", "--set", "aero.law=lev"],
    ),
    ("many_strips", &["tether", "{root}/cases/step.toml", "--set", "aero.full.strips=32"]),
    ("one_strip", &["tether", "{root}/cases/step.toml", "--set", "aero.full.strips=1"]),
    ("long_flight", &["fly", "glide.toml", "--set", "flight.duration_s=1"]),
    ("one_cycle", &["tether", "{root}/cases/flap_f1.toml", "--set", "time.cycles=1"]),
    ("glide", &["fly", "glide.toml"]),
    ("one_sample", &["fly", "glide.toml", "--set", "flight.duration_s=1e-3"]),
    ("strips", &["fly", "glide.toml", "--set", "flight.record_strips_every_s=1e-3"]),
    ("turn", &["fly", "{root}/scenarios/banking_turn.toml", "--set", "flight.duration_s=0.2"]),
    (
        "turn_full",
        &[
            "fly",
            "{root}/scenarios/banking_turn.toml",
            "--set",
            "flight.duration_s=0.05",
            "--set",
            "aero.preset=full",
        ],
    ),
    ("elastic", &["fly", "{root}/scenarios/aerobat_elastic.toml", "--set", "flight.duration_s=0.1"]),
    ("four_wings", &["fly", "{root}/scenarios/four_wings.toml", "--set", "flight.duration_s=0.1"]),
    ("motor", &["fly", "{root}/scenarios/motor_flapper.toml", "--set", "flight.duration_s=0.1"]),
    ("tail", &["fly", "{root}/scenarios/glider.toml", "--set", "flight.duration_s=0.1"]),
    ("wake", &["wake", "{root}/cases/step.toml", "--chordwise", "1", "--spanwise", "4", "--steps", "8"]),
    ("converge", &["tether", "{root}/cases/step.toml", "--converge", "--set", "time.cycles=1"]),
    ("no_wind_to_speak_of", &["tether", "{root}/cases/step.toml", "--set", "wind.speed_m_s=1e-6"]),
];

/// The cases.
pub fn cases() -> Vec<Case> {
    let drawn = |(name, words): &(&str, &'static [&'static str])| {
        let words = *words;
        Case::new(7, *name, move |place| {
            write(place)?;
            let arguments: Vec<&str> = words.iter().copied().chain(["--quiet", "--out", "a"]).collect();
            let ended = place.run(&arguments)?;
            match ended.code {
                Some(0 | 3) => looked_at(place, "a"),
                code => Err(format!("exit {code:?}: {}", ended.stderr.trim())),
            }
        })
    };
    let mut all: Vec<Case> = RUNS.iter().map(drawn).collect();
    all.extend(said());
    all
}

fn write(place: &Place) -> Judged {
    place.write("glide.toml", GLIDE)?;
    place.write("sweep.toml", SWEEP)?;
    place.write("hold.toml", HOLD)
}

/// What a picture must say.
fn said() -> Vec<Case> {
    let says = |name: &str, words: &'static [&'static str], figure: &'static str, part: &'static str| {
        Case::new(7, name, move |place| {
            write(place)?;
            let arguments: Vec<&str> = words.iter().copied().chain(["--quiet", "--out", "a"]).collect();
            place.run(&arguments)?;
            let text = place.read(&format!("a/figures/{figure}.svg"))?;
            if text.contains(part) { Ok(()) } else { Err(format!("{figure}.svg does not say {part:?}")) }
        })
    };
    let turn = &["fly", "{root}/scenarios/banking_turn.toml", "--set", "flight.duration_s=0.05"];
    vec![
        says("loads_per_span_in_newtons_per_metre", &["tether", "{root}/cases/step.toml"], "span", "[N/m]"),
        says("references_are_drawn", turn, "states", "references"),
        says("forces_have_units", turn, "forces", "[N"),
        Case::new(7, "a_simulated_cell_is_called_simulated", |place| {
            write(place)?;
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
        }),
        Case::new(7, "numbers_of_the_paper_stand_beside_its_own_case_alone", |place| {
            let turn = "{root}/scenarios/banking_turn.toml";
            let flown = |place: &Place, out: &str, set: &str| {
                place.run(&[
                    "fly",
                    turn,
                    "--quiet",
                    "--out",
                    out,
                    "--set",
                    "flight.duration_s=0.01",
                    "--set",
                    set,
                ])?;
                place.read(&format!("{out}/scenario.toml"))
            };
            flown(place, "b", "controller.weights.roll=1.5")?;
            let other = place.read("b/summary.json")?;
            if other.contains("distance_x_m\": 4.1") {
                Err("the paper's end point in another case".into())
            } else {
                Ok(())
            }
        }),
    ]
}

/// All pictures of the folder come in pairs, no label says what is no number, and the ticks of an axis differ, ascend
/// along it and lie where their numbers say.
fn looked_at(place: &Place, folder: &str) -> Judged {
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
struct Label<'a> {
    x: f64,
    y: f64,
    anchor: &'a str,
    text: &'a str,
}

fn labels(picture: &str) -> Vec<Label<'_>> {
    let read =
        |piece: &'_ str| -> Option<(usize, usize)> { Some((piece.find('>')?, piece.find("</text>")?)) };
    let mut all = Vec::new();
    for piece in picture.split("<text").skip(1) {
        let Some((open, close)) = read(piece) else { continue };
        let attribute = |name: &str| piece[..open].split(&format!(" {name}=\"")).nth(1)?.split('"').next();
        let number = |name: &str| attribute(name).and_then(|text| text.parse().ok()).unwrap_or(f64::NAN);
        let text = piece[open + 1..close].trim();
        all.push(Label {
            x: number("x"),
            y: number("y"),
            anchor: attribute("text-anchor").unwrap_or(""),
            text,
        });
    }
    all
}

fn labelled(picture: &str) -> Judged {
    let labels = labels(picture);
    if let Some(bad) = labels.iter().find(|l| ["NaN", "inf", "-inf", "−inf"].contains(&l.text)) {
        return Err(format!("a label says {}", bad.text));
    }
    // Ticks of one axis follow one another: down a column where they end, or along a row where they are centred.
    let along = |l: &Label| if l.anchor == "end" { (l.x, -l.y) } else { (l.y, l.x) };
    let same = |a: &Label, b: &Label| a.anchor == b.anchor && (along(a).0 - along(b).0).abs() < 0.1;
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
