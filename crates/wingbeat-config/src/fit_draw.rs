//! Numbers of a fit, drawn together as far as it knows them.

use super::sweep_spec::{Draw, SweepSpec};
use nalgebra::DMatrix;
use wingbeat_math::{Error, Random, require};
use wingbeat_robot::FitUncertainty;

/// How far correlations may miss what they must be, by rounding of what is printed. *Choice.*
const ROUNDED: f64 = 1e-6;
/// Fewest degrees of freedom, dimensionless: Student's distribution has a variance from above 2 on.
const FEWEST: f64 = 3.0;
/// Standard errors on both sides at which a number is tried before any run. *Choice*: a normal draw lies beyond in 5 of 100.
pub(super) const TRIED: f64 = 2.0;

/// The numbers of one draw of a fit.
#[derive(Clone, Debug)]
pub(super) struct FitDraw {
    /// Place of the draw in the file.
    pub draw: usize,
    /// Fitted values, each in its unit.
    values: Vec<f64>,
    /// Rows of L, values + L z are drawn; each in the unit of its number.
    root: Vec<Vec<f64>>,
    /// Degrees of freedom of the standard errors, if the fit tells them.
    freedom: Option<f64>,
}

impl FitDraw {
    /// Values of all numbers, each in its unit, from normal numbers z of deviation 1 and chi squared with v degrees of freedom.
    ///
    /// An estimate misses its number by s z, s the true deviation, of which v cycles tell e with v e^2/s^2 a chi squared c independent of
    /// z: the miss is e z sqrt(v/c), Student's t in standard errors. The noise of the same cycles is in the errors of all numbers, so that
    /// one c serves all. That of the calibration's intervals is the same v. Without it sqrt(v/c) is 1, as of many cycles.
    ///
    /// Equation: config.fit_draws
    /// `x = values + diag(e) V sqrt(Lambda) z sqrt(v/c), V Lambda V^T the correlation, e the standard errors, c chi
    /// squared with v degrees of freedom`
    /// Source: multivariate t distribution, Kotz & Nadarajah 2004, ch. 1.
    /// Test: `a_fit_of_few_cycles_is_drawn_by_student_s_distribution`.
    pub fn drawn(&self, random: &mut Random) -> Vec<f64> {
        let z: Vec<f64> = self.values.iter().map(|_| random.normal()).collect();
        let wider = self.freedom.map_or(1.0, |freedom| (freedom / random.chi_squared(freedom)).sqrt());
        let off = |row: &Vec<f64>| wider * row.iter().zip(&z).map(|(by, z)| by * z).sum::<f64>();
        self.values.iter().zip(&self.root).map(|(value, row)| value + off(row)).collect()
    }
}

/// L with L L^T the covariance that `uncertainty` tells, by rows in the units of the numbers.
///
/// # Errors
/// [`Error::Invalid`] for lists of other lengths, errors that are not positive, correlations that no draws have.
fn root(uncertainty: &FitUncertainty) -> Result<Vec<Vec<f64>>, Error> {
    let FitUncertainty { of, standard_error: errors, correlation: rows, degrees_of_freedom } = uncertainty;
    let n = of.len();
    if n == 0 || errors.len() != n || rows.len() != n || rows.iter().any(|row| row.len() != n) {
        let allowed = "names, as many of standard_error, and as many rows and columns of correlation";
        return Err(Error::invalid("of", n, allowed).against(["standard_error", "correlation"]));
    }
    require::all("standard_error", errors, require::positive)?;
    if let Some(freedom) = degrees_of_freedom.filter(|freedom| !(FEWEST..f64::INFINITY).contains(freedom)) {
        let allowed = format!("a number from {FEWEST} on: of fewer the draws have no variance");
        return Err(Error::invalid("degrees_of_freedom", freedom, allowed));
    }
    for (i, j) in (0..n * n).map(|k| (k / n, k % n)) {
        let asked = if i == j { 1.0 } else { rows[j][i] };
        if !((rows[i][j] - asked).abs() < ROUNDED) {
            let allowed = "1 of a number with itself, and of two the same both ways";
            return Err(Error::invalid(format!("correlation[{i}][{j}]"), rows[i][j], allowed));
        }
    }
    let eigen = DMatrix::from_fn(n, n, |i, j| rows[i][j]).symmetric_eigen();
    let least = eigen.eigenvalues.min();
    if !(least > -ROUNDED * n as f64) {
        let allowed = "correlations that numbers can have: no eigenvalue below 0";
        return Err(Error::invalid("correlation", format!("an eigenvalue of {least:.1e}"), allowed));
    }
    let by =
        |i: usize, j: usize| errors[i] * eigen.eigenvectors[(i, j)] * eigen.eigenvalues[j].max(0.0).sqrt();
    Ok((0..n).map(|i| (0..n).map(|j| by(i, j)).collect()).collect())
}

/// Keys that take the numbers of a fit.
const TAKERS: [&str; 3] = ["robot.numbers", "mismatch.numbers", "numbers"];

impl Draw {
    /// The draw of the fit of draw number `draw`, and the draws of its numbers, one each, with the ends at which they are tried.
    ///
    /// # Errors
    /// [`Error::Invalid`] with a key below the draw.
    pub(super) fn of_fit(&self, draw: usize) -> Result<Option<(FitDraw, Vec<Draw>)>, Error> {
        let Some(fit) = &self.fit else { return Ok(None) };
        if !TAKERS.contains(&self.key.as_str()) {
            let allowed = "of a fit robot.numbers, mismatch.numbers or, of a case, numbers";
            return Err(Error::invalid("key", &self.key, allowed).against(["fit"]));
        }
        let Some(uncertainty) = &fit.uncertainty else {
            let allowed = "a file of numbers with `uncertainty`, as wingbeat calibrate writes it";
            return Err(Error::invalid("fit.uncertainty", "none", allowed));
        };
        let root = root(uncertainty).map_err(|e| e.within("fit.uncertainty"))?;
        let (mut values, mut draws) = (Vec::new(), Vec::new());
        for (k, (name, error)) in uncertainty.of.iter().zip(&uncertainty.standard_error).enumerate() {
            let Some(value) = fit.get(name) else {
                let allowed = "names of numbers that the fit gives";
                return Err(Error::invalid(format!("fit.uncertainty.of[{k}]"), name, allowed));
            };
            values.push(*value);
            draws.push(Draw {
                key: format!("{}.\"{name}\"", self.key),
                low: Some(value - TRIED * error),
                high: Some(value + TRIED * error),
                ..Draw::default()
            });
        }
        let freedom = uncertainty.degrees_of_freedom;
        Ok(Some((FitDraw { draw, values, root, freedom }, draws)))
    }

    /// What is set before a fit is drawn: all of its numbers, held ones too.
    pub(super) fn whole_fit(&self) -> Option<String> {
        let mut fit = self.fit.clone()?;
        fit.uncertainty = None;
        let table = toml::Value::try_from(fit).ok()?;
        Some(format!("{}={table}", self.key))
    }
}

/// The numbers of a sweep, one draw for each, with the place in the file of the draw that each is of.
#[derive(Clone, Debug, Default)]
pub(super) struct DrawnNumbers {
    /// Of each number its draw, and the place of what draws it.
    pub draws: Vec<Draw>,
    pub places: Vec<usize>,
    /// Draws of fits.
    pub fits: Vec<FitDraw>,
}

impl DrawnNumbers {
    /// The fit of draw number `draw` of the file.
    pub fn fit(&self, draw: usize) -> Option<&FitDraw> {
        self.fits.iter().find(|fit| fit.draw == draw)
    }

    /// Of a sweep.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key.
    pub fn of(spec: &SweepSpec) -> Result<Self, Error> {
        let mut all = Self::default();
        for (i, draw) in spec.draws.iter().enumerate() {
            let fit = draw.of_fit(i).map_err(|e| e.within(&format!("draws[{i}]")))?;
            let (fit, draws) = fit.map_or((None, vec![draw.clone()]), |(fit, draws)| (Some(fit), draws));
            all.places.extend(draws.iter().map(|_| i));
            all.draws.extend(draws);
            all.fits.extend(fit);
        }
        Ok(all)
    }
}
