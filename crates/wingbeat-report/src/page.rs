//! The page: one file with its program, its style and its numbers.

use serde_json::{Map, Value, json};

use crate::motion::{self, PointTrack, RunMotion, SurfaceTrack};
use crate::pack::{Pack, PackedColumn};
use crate::panels::{CurveRole, PagePanel};
use crate::run::ShownRun;

const HTML: &str = include_str!("page/page.html");
const STYLE: &str = include_str!("page/page.css");
const PROGRAM: [&str; 9] = [
    include_str!("page/data.js"),
    include_str!("page/scene.js"),
    include_str!("page/draw.js"),
    include_str!("page/plots.js"),
    include_str!("page/text.js"),
    include_str!("page/overlay.js"),
    include_str!("page/stage.js"),
    include_str!("page/controls.js"),
    include_str!("page/main.js"),
];

/// Half of this is the error of a place of the body, m.
const PLACE: f64 = 1e-4;
/// The same of a rib, as a share of the robot's reach.
const RIB: f64 = 5e-4;
/// The same of a membrane, which may be drawn with its camber enlarged.
const CAMBER: f64 = 5e-5;
/// The same of a part of the quaternion.
const TURN: f64 = 1e-4;
/// Parts into which the range of a plotted column is cut, and that of an arrow.
const PLOT: f64 = 1500.0;
const ARROW: f64 = 250.0;
/// Longest document, and longest part of a summary, that is shown, bytes.
const LONGEST: usize = 64 << 10;

/// What of a run is left out.
#[derive(Clone, Copy, Debug, Default)]
pub struct Without {
    /// The wake.
    pub wake: bool,
    /// Forces of strips.
    pub strips: bool,
}

/// The page that shows `runs`.
pub fn page(runs: &[ShownRun], without: Without) -> String {
    PageParts::of(runs, without, None).filled(None)
}

/// Runs of a computation that goes on, in their `version`.
#[derive(Clone, Copy, Debug)]
pub struct Live<'a> {
    /// The runs.
    pub runs: &'a [ShownRun],
    /// How often they have changed.
    pub version: u64,
    /// Whether nothing more comes.
    pub ended: bool,
}

impl Live<'_> {
    /// The page, which asks its server for what has been computed since.
    pub fn page(&self) -> String {
        PageParts::of(self.runs, Without::default(), None).filled(Some(self.version))
    }

    /// What the page is told: all, or what has come since another version and its numbers of rows.
    pub fn data(&self, since: Option<(u64, &[usize])>) -> String {
        let PageParts { data, bytes, .. } =
            PageParts::of(self.runs, Without::default(), since.map(|(_, rows)| rows));
        let mut told = json!({ "version": self.version, "ended": self.ended, "data": data, "bytes": bytes });
        if let Some((after, _)) = since {
            told["after"] = json!(after);
        }
        told.to_string()
    }
}

/// What a page holds of its runs.
struct PageParts {
    title: String,
    /// What is read before any number.
    data: Value,
    /// The numbers.
    bytes: String,
}

impl PageParts {
    /// Of each run all, or what it has from the row on that `rows` gives.
    fn of(runs: &[ShownRun], without: Without, rows: Option<&[usize]>) -> Self {
        let mut pack = Pack::default();
        let names: Vec<&str> = runs.iter().map(|run| run.name.as_str()).collect();
        let told: Vec<Value> = runs.iter().map(told).collect();
        let mut shown = Vec::new();
        for (k, run) in runs.iter().enumerate() {
            pack.begin_at(rows.and_then(|rows| rows.get(k)).copied().unwrap_or(0));
            let mut told = of_run(run, without, &mut pack);
            if rows.is_none() {
                told["settings"] = settings(run).into();
            }
            shown.push(told);
        }
        Self {
            title: escaped(&names.join(", ")),
            data: json!({ "runs": told }),
            bytes: pack.letters(&json!(shown).to_string()),
        }
    }

    /// The page; of a computation that goes on in that version.
    fn filled(&self, live: Option<u64>) -> String {
        // Inside of an element of a script nothing but its end is read as markup.
        let data = self.data.to_string().replace('<', "\\u003c");
        let mut page = String::new();
        for part in HTML.split("%%") {
            match part {
                "TITLE" => page += &self.title,
                "STYLE" => page += STYLE,
                "DATA" => page += &data,
                "BYTES" => page += &self.bytes,
                "PROGRAM" => PROGRAM.iter().for_each(|part| page += &without_margins(part)),
                "LIVE" => page += &live.map_or(String::new(), |version| format!(" data-live=\"{version}\"")),
                "CONNECT" => page += if live.is_some() { "; connect-src 'self'" } else { "" },
                other => page += other,
            }
        }
        page
    }
}

/// Text for an element.
pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A program without the blanks before its lines and beside its signs, and without the lines that only explain. Texts stay: those in a
/// template may go over several lines, and none holds another one.
fn without_margins(program: &str) -> String {
    // Signs beside which a blank says nothing; two of + - / side by side would become another sign.
    let sign = |letter: char| "=,:?;{}()<>|&*[]".contains(letter);
    let mut short = String::with_capacity(program.len());
    let mut quote = None;
    for line in program.lines() {
        let line = if quote.is_none() { line.trim_start() } else { line };
        if quote.is_none() && line.starts_with("//") {
            continue;
        }
        let mut letters = line.chars().peekable();
        while let Some(letter) = letters.next() {
            match (quote, letter) {
                (Some(_), '\\') => {
                    short.push(letter);
                    short.extend(letters.next());
                    continue;
                }
                (Some(open), _) if letter == open => quote = None,
                (None, '\'' | '"' | '`') => quote = Some(letter),
                (None, ' ') if short.ends_with(sign) || letters.peek().is_some_and(|next| sign(*next)) => {
                    continue;
                }
                _ => {}
            }
            short.push(letter);
        }
        short.push('\n');
    }
    short
}

/// What is read of a run before any number.
fn told(run: &ShownRun) -> Value {
    let (mut summary, mut notes) = (run.summary.clone(), run.notes.clone());
    if let Some(parts) = summary.as_object_mut() {
        let whole = parts.len();
        parts.retain(|_, part| part.to_string().len() <= LONGEST);
        if parts.len() < whole {
            notes.push(format!("parts of summary.json of more than {LONGEST} bytes are left out"));
        }
    }
    json!({
        "name": run.name, "kind": run.kind, "summary": summary, "notes": notes,
    })
}

/// The document of a run, of a long one its begin.
fn settings(run: &ShownRun) -> String {
    let mut settings = run.settings.clone();
    if settings.len() > LONGEST {
        let end = (0..=LONGEST).rev().find(|end| settings.is_char_boundary(*end)).unwrap_or(0);
        settings.truncate(end);
        settings += "\n# ... the rest is in the run folder";
    }
    settings
}

fn of_run(run: &ShownRun, without: Without, pack: &mut Pack) -> Value {
    let panels: Vec<Value> = run.panels.iter().map(|panel| of_panel(panel, pack)).collect();
    json!({
        "axis": { "label": run.axis.label, "unit": run.axis.unit, "joined": run.axis.joined,
                  "values": axis(&run.axis.values, pack) },
        "motion": run.motion.as_ref().map(|motion| of_motion(motion, without, pack)),
        "shots": run.shots.iter().map(|shot| json!({
            "name": shot.name, "time": shot.time, "wings": shot.wings,
            "corners": shot.corners.each_ref().map(|column| pack.add(column, PLACE)),
            "circulation": pack.add_parts(&shot.circulation, ARROW),
        })).collect::<Vec<_>>(),
        "panels": panels,
    })
}

/// Times and phases to a millionth of their range.
fn axis(values: &[f64], pack: &mut Pack) -> PackedColumn {
    pack.add_parts(values, 1e6)
}

fn of_panel(panel: &PagePanel, pack: &mut Pack) -> Value {
    let curve = |curve: &crate::panels::PageCurve| {
        let role = match curve.role {
            CurveRole::Own(n) => json!(["own", n]),
            CurveRole::Side(n) => json!(["side", n]),
            CurveRole::Pale(n) => json!(["pale", n]),
            CurveRole::Reference => json!(["reference", 0]),
            CurveRole::Total => json!(["total", 0]),
        };
        json!({ "label": curve.label, "role": role, "values": pack.add_parts(&curve.values, PLOT) })
    };
    let curves: Vec<Value> = panel.curves.iter().map(curve).collect();
    json!({ "title": panel.title, "unit": panel.unit, "limits": panel.limits, "curves": curves })
}

fn track(track: &PointTrack, step: f64, pack: &mut Pack) -> [PackedColumn; 3] {
    track.each_ref().map(|column| pack.add(column, step))
}

fn arrow(track: &PointTrack, pack: &mut Pack) -> [PackedColumn; 3] {
    let size = track.iter().flatten().filter(|v| v.is_finite()).fold(0.0_f64, |m, v| m.max(v.abs()));
    track.each_ref().map(|column| pack.add(column, 2.0 * size / ARROW))
}

fn of_motion(motion: &RunMotion, without: Without, pack: &mut Pack) -> Value {
    let reach = motion.reach();
    let mut value = Map::new();
    let mut put = |key: &str, what: Value| value.insert(key.into(), what);
    put("position", json!(track(&motion.position, PLACE, pack)));
    put("attitude", json!(motion.attitude.each_ref().map(|column| pack.add(column, TURN))));
    put("com", json!(track(&motion.com, RIB * reach, pack)));
    put("reach", json!(reach));
    put("spindle", json!({ "size": motion::SPINDLE_SIZE, "rings": motion::SPINDLE }));
    put("wind", json!(motion.wind));
    put("free", json!(motion.free));
    put("bare", json!(motion.bare));
    put("ground", json!(motion.ground));
    put("repeats", json!(motion.repeats));
    put("circulation", json!(motion.circulation.filter(|_| !without.wake)));
    put("table", json!(motion.table));
    let surfaces: Vec<Value> =
        motion.surfaces.iter().map(|surface| of_surface(surface, reach, without, pack)).collect();
    put("surfaces", json!(surfaces));
    let sources: Vec<Value> = motion
        .sources
        .iter()
        .map(|source| {
            json!({ "name": source.name, "place": source.place, "force": arrow(&source.force, pack) })
        })
        .collect();
    put("sources", json!(sources));
    let line = |line: &crate::motion::LineTrack| {
        let points: Vec<_> = line.points.iter().map(|point| track(point, PLACE, pack)).collect();
        json!({ "name": line.name, "weight": line.weight, "points": points })
    };
    let lines: Vec<Value> = motion.lines.iter().map(line).collect();
    put("lines", json!(lines));
    put("path", json!(motion.path.as_ref().map(|path| track(path, 1e-3, pack))));
    Value::Object(value)
}

fn of_surface(surface: &SurfaceTrack, reach: f64, without: Without, pack: &mut Pack) -> Value {
    let ribs: Vec<_> =
        surface.ribs.iter().map(|rib| rib.each_ref().map(|edge| track(edge, RIB * reach, pack))).collect();
    let strip = |strip: &crate::motion::StripTrack| {
        let force = (!without.strips).then(|| arrow(&strip.force, pack));
        let circulation = (!without.wake).then(|| pack.add_parts(&strip.circulation, ARROW));
        json!({ "rib": strip.rib, "force": force, "circulation": circulation })
    };
    let strips: Vec<Value> = surface.strips.iter().map(strip).collect();
    let mut value = json!({ "name": surface.name, "covered": surface.covered, "side": surface.side, "ribs": ribs, "strips": strips });
    if !surface.raised.is_empty() {
        let mut raised = Vec::new();
        for points in &surface.raised {
            raised.push(points.each_ref().map(|point| track(point, CAMBER * reach, pack)));
        }
        value["raised"] = json!(raised);
        if let Some(hinge) = surface.hinge {
            value["hinge"] = json!(hinge + 1);
        }
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::panels::PageCurve;
    use crate::run::PlotAxis;

    fn run(name: &str, t: Vec<f64>, values: Vec<f64>) -> ShownRun {
        let curve = PageCurve { label: "</script>".into(), role: CurveRole::Own(0), values };
        let panel = PagePanel {
            title: "<b>".into(),
            unit: "m",
            curves: vec![curve],
            limits: Some((f64::NAN, 1e300)),
        };
        ShownRun {
            name: name.into(),
            kind: "flight",
            summary: json!({ "status": "ok", "reason": "</script><script>window.pwned = 1</script>" }),
            settings: "# </script><img src=x onerror='window.pwned = 1'>\u{2028}%%BYTES%%".repeat(2000),
            notes: vec!["<i>".into()],
            axis: PlotAxis { label: "time", unit: "s", values: t, joined: true },
            motion: None,
            shots: Vec::new(),
            panels: vec![panel],
        }
    }

    #[test]
    fn a_program_loses_its_margins_and_no_text() {
        let program = "  // why\n  const a = (b, c) => b ? 'x = y' : c + -1; // z\n  s(`in vec2 e;\n  a , b`, \"it's\", 'a\\' = b');\n";
        let short = "const a=(b,c)=>b?'x = y':c + -1;// z\ns(`in vec2 e;\n  a , b`,\"it's\",'a\\' = b');\n";
        assert_eq!(without_margins(program), short);
    }

    #[test]
    fn texts_of_a_run_are_no_markup_and_odd_numbers_make_a_page() {
        let odd = vec![f64::NAN, 1e300, -1e300, f64::INFINITY];
        let t = vec![0.0, 1.0, 2.0, 3.0];
        let whole = page(&[run("</script><b>&\"", t, odd)], Without::default());
        let plain = page(&[run("x", Vec::new(), Vec::new())], Without::default());
        for page in [&whole, &plain] {
            assert_eq!(page.matches("</script").count(), 3, "each script ends once");
            assert!(!page.contains("<img") && !page.contains("<script>window.pwned"));
            assert!(page.len() < 300_000, "{}", page.len());
        }
        assert!(whole.contains("<title>&lt;/script&gt;&lt;b&gt;&amp;&quot;</title>"));
    }
}
