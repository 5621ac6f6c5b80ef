//! What a calibration is worth in flight: truth and model under the same inputs, before and after it.

use super::fitted::{Calibrated, TRUTH, calibrated, median};
use super::no_answer;
use super::stroke::TruthTurn;
use crate::{ComparisonRow, Error};
use wingbeat::robot::ResidualSpec;

/// Parts of the turn: when their first stroke begins, s; where; what ids end with. *Choice.*
const PARTS: [(f64, &str, &str); 3] =
    [(1.5, "level", ".level"), (2.0, "entering the turn", ".entering"), (3.5, "in the turn", ".turning")];
/// What may be left where the truth follows itself: deg, m/s. *Choice.*
const ITSELF: [f64; 2] = [0.1, 0.01];
/// What may be left of the difference before. *Choice.*
const ASKED: f64 = 1.0 / 3.0;
/// Models that are fitted, none of them the truth: preset and law. The first is the paper's.
const STRUCTURES: [[&str; 2]; 4] =
    [["paper", "linear"], ["paper", "stall"], ["paper", "lev"], ["full", "stall"]];
/// What flies and follows.
const SOURCE: &str = "own truth (full, lev) and another model under its inputs, one stroke from four phases";

/// The larger of each; no number where there is none.
fn worse(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|i| if a[i].is_nan() || b[i].is_nan() { f64::NAN } else { a[i].max(b[i]) })
}

/// Medians over the draws of what is left of attitude and velocity, and of what there was before; what is left: rad, m/s.
struct RemainingError {
    ratio: [f64; 2],
    before: [f64; 2],
    after: [f64; 2],
}

/// By how much a model is off the truth after the strokes of each part with each of the numbers before the fit.
type Before = Vec<Vec<[f64; 2]>>;

fn before(model: &Calibrated, turn: &TruthTurn) -> Result<Before, Error> {
    let drawn = model.drawn();
    let one = |(begin, ..): (f64, &str, &str)| {
        let off = |_, numbers: &Vec<(String, f64)>| turn.off(begin, model.structure, numbers, None);
        wingbeat::parallel::map(&drawn, off).into_iter().collect()
    };
    PARTS.into_iter().map(one).collect()
}

/// What a calibrated model leaves in each part, its learned wrench beside it or not.
fn left(
    model: &Calibrated,
    turn: &TruthTurn,
    before: &Before,
    residual: Option<&ResidualSpec>,
) -> Result<Vec<RemainingError>, Error> {
    let one = |((begin, ..), before): (&(f64, &str, &str), &Vec<[f64; 2]>)| {
        let after = turn.off(*begin, model.structure, &model.numbers(), residual)?;
        let middle = |of: &dyn Fn(&[f64; 2]) -> f64| median(before.iter().map(of).collect());
        let ratio = [0, 1].map(|i| middle(&|before| after[i] / before[i]));
        Ok(RemainingError { ratio, before: [0, 1].map(|i| middle(&|before| before[i])), after })
    };
    PARTS.iter().zip(before).map(one).collect()
}

/// The worst of the parts.
fn worst(all: &[RemainingError]) -> [f64; 2] {
    all.iter().map(|left| left.ratio).fold([0.0; 2], worse)
}

/// Two judged rows: attitude and velocity.
fn judged(id: &str, source: &str, metric: &str, value: [f64; 2]) -> [ComparisonRow; 2] {
    [("", "attitude", value[0]), (".velocity", "velocity", value[1])].map(|(end, what, value)| {
        ComparisonRow::judged(&format!("{id}{end}"), source, &format!("{what}, {metric}"), value, ASKED, "")
    })
}

/// Rows of a structure in each part.
fn shown(model: &Calibrated, all: &[RemainingError], (kind, with): (&str, &str)) -> Vec<ComparisonRow> {
    let [preset, law] = model.structure;
    let each = PARTS.iter().zip(all).flat_map(|((_, when, suffix), left)| {
        let id = format!("calibrate.flight.{preset}_{law}{kind}{suffix}");
        let attitude = format!(
            "attitude {when}, {preset}, {law} (left out {:.1} %, stands {:.1} %), {with}: median after over before; {:.2} deg \
             before, {:.2} after",
            100.0 * model.left_out,
            100.0 * model.on_stands[0],
            left.before[0].to_degrees(),
            left.after[0].to_degrees()
        );
        let velocity = format!("velocity: the same; {:.3} m/s before, {:.3} after", left.before[1], left.after[1]);
        [
            ComparisonRow::shown(&id, SOURCE, &attitude, left.ratio[0], ""),
            ComparisonRow::shown(&format!("{id}.velocity"), SOURCE, &velocity, left.ratio[1], ""),
        ]
    });
    each.collect()
}

/// The truth that follows itself, its air found again.
fn itself(turn: &TruthTurn) -> Result<Vec<ComparisonRow>, Error> {
    let source =
        "own truth (full, lev), its air found again, under its own inputs, one stroke from four phases";
    let mut rows = Vec::new();
    for (begin, when, suffix) in PARTS {
        let own = turn.off(begin, TRUTH, &[], None)?;
        let id = format!("calibrate.flight.itself{suffix}");
        let (attitude, velocity) = (format!("attitude {when}, the truth itself"), "velocity: the same");
        rows.push(ComparisonRow::judged(&id, source, &attitude, own[0].to_degrees(), ITSELF[0], "deg"));
        rows.push(ComparisonRow::judged(
            &format!("{id}.velocity"),
            source,
            velocity,
            own[1],
            ITSELF[1],
            "m/s",
        ));
    }
    Ok(rows)
}

/// Medians over twenty draws of what is left after the calibration, in parts of before, in three parts of a turn that carries its weight.
/// Judged is, by the worst part, what was calibrated of the structure whose numbers alone predict the runs on the stand best, none of
/// which they are fitted to: those numbers and the wrench that they leave there. The wrench knows steady winds: what the motion of the body
/// does is the model's.
pub fn rows() -> Result<Vec<ComparisonRow>, Error> {
    let turn = TruthTurn::new()?;
    let mut rows = itself(&turn)?;
    let metric = "median after over before, 20 draws +-20 %, the worst of three parts";
    for model in calibrated(&[TRUTH])? {
        let all = left(&model, &turn, &before(&model, &turn)?, None)?;
        let source = "own truth (full, lev) and the same model fitted from numbers 15 % beside, one stroke from four phases";
        rows.extend(judged("calibrate.flight.right_model", source, metric, worst(&all)));
    }
    let all = calibrated(&STRUCTURES)?;
    let chosen = all.iter().min_by(|a, b| a.on_stands[0].total_cmp(&b.on_stands[0]));
    let chosen = chosen.ok_or_else(|| no_answer("no structure"))?.structure;
    for model in &all {
        let before = before(model, &turn)?;
        let numbers = left(model, &turn, &before, None)?;
        let with_wrench = left(model, &turn, &before, Some(&model.residual.spec))?;
        if model.structure == chosen {
            let [preset, law] = chosen;
            let metric = format!("{preset}, {law}, numbers and learned wrench: {metric}");
            rows.extend(judged("calibrate.flight", SOURCE, &metric, worst(&with_wrench)));
            let alone = worst(&numbers);
            for (end, what, value) in [("", "attitude", alone[0]), (".velocity", "velocity", alone[1])] {
                let metric = format!("{what}, {preset}, {law}, the numbers alone: the worst of three parts");
                rows.push(ComparisonRow::shown(
                    &format!("calibrate.flight.numbers{end}"),
                    SOURCE,
                    &metric,
                    value,
                    "",
                ));
            }
        }
        rows.extend(shown(model, &numbers, ("", "numbers of the seven runs")));
        let with = format!(
            "numbers of the seven runs and a wrench learned on nine stands, {:.1} % off in one left out",
            100.0 * model.on_stands[1]
        );
        rows.extend(shown(model, &with_wrench, (".learned", &with)));
    }
    Ok(rows)
}
