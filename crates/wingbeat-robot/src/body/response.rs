//! Structure response: how the commanded displacements become actual ones.

use std::f64::consts::TAU;
use wingbeat_math::Error;
use wingbeat_math::linear::{lu_factor, lu_solve};
use wingbeat_math::range::Range;
use wingbeat_math::require;
use wingbeat_math::{DeclaredQuantity, Jet, Meets, Over, Parameters, Scalar, Walk};

/// [y'; y''] = A [y; y'] + B omega for `n` displacements y and `m` commands omega.
/// The state is [y; y'], 2n numbers.
#[derive(Clone, Debug, PartialEq)]
pub enum Response<P = f64> {
    /// Independent elements, y'' = k (omega - y) - c y' + r omega: each follows its own command.
    Uncoupled(Vec<Element<P>>),
    /// Full matrices.
    Coupled(Coupled<P>),
}

/// Stiffness and damping of one independent element, per unit inertia.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Element<P = f64> {
    /// k = (2 pi f)^2, 1/s2.
    pub stiffness: P,
    /// c = 2 zeta 2 pi f, 1/s.
    pub damping: P,
    /// r: what the acceleration gains per unit of a command to the rate, 1/s; 0 where the command is to y.
    pub rate_gain: P,
}

/// The lower half [K C] of A and B_2 of B, by rows: y'' = K y + C y' + B_2 omega.
#[derive(Clone, Debug, PartialEq)]
pub struct Coupled<P = f64> {
    elements: usize,
    commands: usize,
    state: Vec<P>,
    command: Vec<P>,
}

impl Element {
    /// Natural frequency in Hz and damping ratio.
    ///
    /// # Errors
    /// [`Error::Invalid`] when the frequency is not above zero or the damping negative.
    pub fn new(frequency_hz: f64, damping_ratio: f64) -> Result<Self, Error> {
        require::positive("frequency_hz", frequency_hz)?;
        require::not_negative("damping", damping_ratio)?;
        let w = TAU * frequency_hz;
        Ok(Self { stiffness: w * w, damping: 2.0 * damping_ratio * w, rate_gain: 0.0 })
    }

    /// An element whose rate follows its command, y'' = c (omega - y') with c = 2 pi f, f in Hz.
    ///
    /// Equation: body.rate_response
    /// `y'' = 2 pi f (omega - y')`
    /// Source: first-order lag of the crank's rate, choice.
    /// Test: `the_rate_of_the_crank_follows_its_command`.
    ///
    /// # Errors
    /// [`Error::Invalid`] when the frequency is not above zero.
    pub fn of_rate(frequency_hz: f64) -> Result<Self, Error> {
        require::positive("frequency_hz", frequency_hz)?;
        let w = TAU * frequency_hz;
        Ok(Self { stiffness: 0.0, damping: w, rate_gain: w })
    }
}

impl Default for Element {
    /// 12 Hz, damping ratio 0.8.
    fn default() -> Self {
        let w = TAU * 12.0;
        Self { stiffness: w * w, damping: 1.6 * w, rate_gain: 0.0 }
    }
}

impl Coupled {
    /// From A (2n x 2n) and B (2n x m) by rows, in 1/s, 1/s2 and the units of the elements.
    ///
    /// # Errors
    /// [`Error::Invalid`] when the shapes do not match, a number is not finite, or the
    /// upper half of A is not [0 1] or of B not zero: y' is a state, not an output.
    pub fn new(a: &[Vec<f64>], b: &[Vec<f64>]) -> Result<Self, Error> {
        let (rows, elements) = (a.len(), a.len() / 2);
        let commands = b.first().map_or(0, Vec::len);
        let shape =
            |m: &[Vec<f64>]| format!("{} rows of {:?}", m.len(), m.iter().map(Vec::len).collect::<Vec<_>>());
        if rows == 0 || rows % 2 == 1 || a.iter().any(|r| r.len() != rows) {
            return Err(Error::invalid("a", shape(a), "a square matrix of even order"));
        }
        if b.len() != rows || b.iter().any(|r| r.len() != commands) {
            return Err(Error::invalid("b", shape(b), format!("{rows} rows of one length")));
        }
        for (name, matrix) in [("a", a), ("b", b)] {
            let mut rows = matrix.iter().enumerate();
            rows.try_for_each(|(i, row)| require::finite(&format!("{name}[{i}]"), row))?;
        }
        for i in 0..elements {
            let unit =
                (0..rows).map(|j| (format!("a[{i}][{j}]"), a[i][j], f64::from(u8::from(j == elements + i))));
            let zero = (0..commands).map(|j| (format!("b[{i}][{j}]"), b[i][j], 0.0));
            if let Some((key, given, asked)) = unit.chain(zero).find(|(_, given, asked)| given != asked) {
                let allowed = format!("{asked}: rows [0 1] in A and 0 in B for dy/dt");
                return Err(Error::invalid(key, given, allowed));
            }
        }
        Ok(Self { elements, commands, state: a[elements..].concat(), command: b[elements..].concat() })
    }

    /// Independent elements of which regulators move several, by the placement P (n x m) of their commands, in the unit of the
    /// element over that of the command.
    pub fn of_elements(elements: &[Element], placement: &[Vec<f64>]) -> Self {
        let n = elements.len();
        let mut state = vec![0.0; 2 * n * n];
        for (i, e) in elements.iter().enumerate() {
            state[i * 2 * n + i] = -e.stiffness;
            state[i * 2 * n + n + i] = -e.damping;
        }
        let row = |(e, row): (&Element, &Vec<f64>)| {
            row.iter().map(|p| (e.stiffness + e.rate_gain) * p).collect::<Vec<_>>()
        };
        let command = elements.iter().zip(placement).flat_map(row).collect();
        Self { elements: n, commands: placement.first().map_or(0, Vec::len), state, command }
    }

    /// Equation: body.structure_parts
    /// `y'' = K (P omega - y) - C y', A = [0 1; -K -C], B = [0; K P]`
    /// Source: choice: placement P of m actuators on n elements.
    /// Test: `placement_parts_and_matrices_are_one_structure`.
    ///
    /// From stiffness K (n x n, 1/s2) and damping C (n x n, 1/s) per unit inertia and the placement P
    /// (n x m) of the commands, by rows: y'' = K (P omega - y) - C y', so that held commands displace
    /// by P omega; A = [0 1; -K -C], B = [0; K P].
    ///
    /// # Errors
    /// [`Error::Invalid`] when a shape does not match or a number is not finite.
    pub fn placed(
        stiffness: &[Vec<f64>],
        damping: &[Vec<f64>],
        placement: &[Vec<f64>],
    ) -> Result<Self, Error> {
        let (elements, commands) = (placement.len(), placement.first().map_or(0, Vec::len));
        let parts = [
            ("stiffness_per_s2", stiffness, elements),
            ("damping_per_s", damping, elements),
            ("placement", placement, commands),
        ];
        for (key, matrix, columns) in parts {
            if matrix.len() != elements || matrix.iter().any(|row| row.len() != columns) {
                let shape = format!("rows of {:?}", matrix.iter().map(Vec::len).collect::<Vec<_>>());
                return Err(Error::invalid(key, shape, format!("{elements} rows of {columns}")));
            }
            require::finite(key, &matrix.concat())?;
        }
        let state = |(k, c): (&Vec<f64>, &Vec<f64>)| k.iter().chain(c).map(|x| -x).collect::<Vec<_>>();
        let gain = |k: &Vec<f64>, j: usize| k.iter().zip(placement).map(|(k, row)| k * row[j]).sum::<f64>();
        Ok(Self {
            elements,
            commands,
            state: stiffness.iter().zip(damping).flat_map(state).collect(),
            command: stiffness.iter().flat_map(|k| (0..commands).map(move |j| gain(k, j))).collect(),
        })
    }
}

impl<P: Scalar> Response<P> {
    /// Number n of displacements.
    pub fn elements(&self) -> usize {
        match self {
            Self::Uncoupled(elements) => elements.len(),
            Self::Coupled(c) => c.elements,
        }
    }

    /// Number m of commands.
    pub fn commands(&self) -> usize {
        match self {
            Self::Uncoupled(elements) => elements.len(),
            Self::Coupled(c) => c.commands,
        }
    }

    /// What the acceleration of element `i` gains by the state `j`, in the unit of the element per s2 over that of the state:
    /// an entry of the lower rows of A.
    pub fn state_gain(&self, i: usize, j: usize) -> P {
        match self {
            Self::Uncoupled(e) if j == i => -e[i].stiffness,
            Self::Uncoupled(e) if j == e.len() + i => -e[i].damping,
            Self::Uncoupled(_) => P::ZERO,
            Self::Coupled(c) => c.state[i * 2 * c.elements + j],
        }
    }

    /// What the acceleration of element `i` gains by the command `j`, in the unit of the element per s2 over that of the
    /// command: an entry of the lower rows of B.
    pub fn command_gain(&self, i: usize, j: usize) -> P {
        match self {
            Self::Uncoupled(e) if j == i => e[i].stiffness + e[i].rate_gain,
            Self::Uncoupled(_) => P::ZERO,
            Self::Coupled(c) => c.command[i * c.commands + j],
        }
    }

    /// Equation: body.structure_response
    /// `[y'; y''] = A [y; y'] + B omega`
    /// Source: Paper eq. (mimic_dynamics).
    /// Test: `uncoupled_elements_equal_their_full_matrices`.
    ///
    /// Displacements with rate and acceleration from the state [y; y'] and the commands, in the units of the elements; `out`
    /// has n entries. Paper eq. (mimic_dynamics).
    pub fn displacements<S: Scalar + Meets<P>>(&self, state: &[S], command: &[S], out: &mut [Jet<S>]) {
        let n = self.elements();
        let (out, y, rates) = (&mut out[..n], &state[..n], &state[n..2 * n]);
        match self {
            Self::Uncoupled(elements) => {
                let (elements, command) = (&elements[..n], &command[..n]);
                for i in 0..n {
                    let (element, own) = (&elements[i], rates[i] * elements[i].damping);
                    let driven = match element.rate_gain.is_zero() {
                        true => (command[i] - y[i]) * element.stiffness,
                        false => command[i] * element.rate_gain - y[i] * element.stiffness,
                    };
                    out[i] = Jet::new(y[i], rates[i], driven - own);
                }
            }
            Self::Coupled(c) => {
                let (width, m) = (2 * n, c.commands);
                for i in 0..n {
                    let own = product(&c.state[i * width..(i + 1) * width], state);
                    let driven = product(&c.command[i * m..(i + 1) * m], command);
                    out[i] = Jet::new(y[i], rates[i], own + driven);
                }
            }
        }
    }

    /// Rates [y'; y''] of the state, in the units of the elements per s and per s2, from the displacements of the same instant.
    pub fn rates<G: Scalar, S: Over<G>>(&self, displacements: &[Jet<G>], rates: &mut [S]) {
        let n = self.elements();
        for i in 0..n {
            rates[i] = S::from(displacements[i].d);
            rates[n + i] = S::from(displacements[i].dd);
        }
    }
}

/// Stiffness per unit inertia.
const STIFFNESS: DeclaredQuantity = DeclaredQuantity::within("1/s2", Range::NOT_NEGATIVE, 0.0, 1e6);
/// Damping per unit inertia, or what an acceleration gains per unit of a commanded rate.
const DAMPING: DeclaredQuantity = DeclaredQuantity::within("1/s", Range::NOT_NEGATIVE, 0.0, 1e6);

impl<P: Scalar> Parameters<P> for Element<P> {
    type In<Q: Scalar> = Element<Q>;

    fn walk<Q: Scalar>(&self, at: &mut Walk<'_, P, Q>) -> Element<Q> {
        Element {
            stiffness: at.number("stiffness_per_s2", &STIFFNESS, self.stiffness),
            damping: at.number("damping_per_s", &DAMPING, self.damping),
            rate_gain: match self.rate_gain.is_zero() {
                true => at.fixed(self.rate_gain),
                false => at.number("rate_gain_per_s", &DAMPING, self.rate_gain),
            },
        }
    }
}

/// Entries of A are called by the states, those of B by state and regulator: `a.rate_left.displacement_left`.
impl<P: Scalar> Parameters<P> for Coupled<P> {
    type In<Q: Scalar> = Coupled<Q>;

    fn walk<Q: Scalar>(&self, at: &mut Walk<'_, P, Q>) -> Coupled<Q> {
        let n = self.elements;
        let mut entries = |key: &str,
                           matrix: &[P],
                           (columns, width): (&str, usize),
                           unit: fn(usize, usize) -> &'static str| {
            let entry = |(k, value): (usize, &P)| {
                let (row, column) = (k / width, k % width);
                let quantity = DeclaredQuantity::free(unit(column, n));
                at.item(key, "states", n + row, |at| {
                    at.item("", columns, column, |at| at.here(&quantity, *value))
                })
            };
            matrix.iter().enumerate().map(entry).collect()
        };
        let of_state = |column, elements| if column < elements { "1/s2" } else { "1/s" };
        Coupled {
            elements: n,
            commands: self.commands,
            state: entries("a", &self.state, ("states", 2 * n), of_state),
            command: entries("b", &self.command, ("regulators", self.commands), |_, _| "1/s2"),
        }
    }
}

impl<P: Scalar> Parameters<P> for Response<P> {
    type In<Q: Scalar> = Response<Q>;

    fn walk<Q: Scalar>(&self, at: &mut Walk<'_, P, Q>) -> Response<Q> {
        match self {
            Self::Uncoupled(elements) => {
                Response::Uncoupled(
                    at.list(("elements", "elements"), elements, |at, element| element.walk(at)),
                )
            }
            Self::Coupled(coupled) => Response::Coupled(coupled.walk(at)),
        }
    }
}

impl Response {
    /// Multiplies the natural frequencies of the first `elements` elements, their damping ratios kept; of matrices all.
    pub fn scale_frequency(&mut self, factor: f64, elements: usize) {
        let square = factor * factor;
        match self {
            Self::Uncoupled(all) => {
                for element in all.iter_mut().take(elements) {
                    element.stiffness *= square;
                    element.damping *= factor;
                    element.rate_gain *= factor;
                }
            }
            Self::Coupled(Coupled { elements: n, commands, state, command }) => {
                for (state, command) in
                    state.chunks_exact_mut(2 * *n).zip(command.chunks_exact_mut(*commands))
                {
                    let (stiffness, damping) = state.split_at_mut(*n);
                    // Without stiffness the rate follows its command.
                    let gain = if stiffness.iter().all(|k| *k == 0.0) { factor } else { square };
                    stiffness.iter_mut().for_each(|k| *k *= square);
                    damping.iter_mut().for_each(|c| *c *= factor);
                    command.iter_mut().for_each(|b| *b *= gain);
                }
            }
        }
    }

    /// Displacements at rest by the held commands, in the units of elements over those of commands, n rows of m: y = K^-1 B_2
    /// omega. Zero for elements that no stiffness brings to rest, and for all where K is singular beyond them.
    pub fn rest(&self) -> Vec<f64> {
        let (n, m) = (self.elements(), self.commands());
        let mut stiffness: Vec<f64> = (0..n * n).map(|k| -self.state_gain(k / n, k % n)).collect();
        let mut gains: Vec<f64> = (0..n * m).map(|k| self.command_gain(k / m, k % m)).collect();
        for (i, row) in stiffness.chunks_exact_mut(n.max(1)).enumerate() {
            if row.iter().all(|k| *k == 0.0) {
                row[i] = 1.0;
                gains[i * m..(i + 1) * m].fill(0.0);
            }
        }
        let mut pivots = vec![0; n];
        if !lu_factor(&mut stiffness, n, &mut pivots) {
            return vec![0.0; n * m];
        }
        lu_solve(&stiffness, n, &pivots, &mut gains, m);
        gains
    }
}

fn product<P: Scalar, S: Scalar + Meets<P>>(row: &[P], x: &[S]) -> S {
    row.iter().zip(x).fold(S::ZERO, |sum, (a, x)| sum + *x * *a)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn accelerations(response: &Response, state: &[f64], command: &[f64]) -> Vec<f64> {
        let mut y = vec![Jet::default(); response.elements()];
        response.displacements(state, command, &mut y);
        let mut rates = vec![0.0; state.len()];
        response.rates(&y, &mut rates);
        assert_eq!(rates[..y.len()], state[y.len()..]);
        rates.split_off(y.len())
    }

    #[test]
    fn uncoupled_elements_equal_their_full_matrices() {
        let elements = [Element::new(12.0, 0.8).unwrap(), Element::new(9.0, 0.3).unwrap()];
        assert_eq!(elements[0], Element::default());
        let [p, q] = elements;
        let a = [
            vec![0.0, 0.0, 1.0, 0.0],
            vec![0.0, 0.0, 0.0, 1.0],
            vec![-p.stiffness, 0.0, -p.damping, 0.0],
            vec![0.0, -q.stiffness, 0.0, -q.damping],
        ];
        let b = [vec![0.0; 2], vec![0.0; 2], vec![p.stiffness, 0.0], vec![0.0, q.stiffness]];
        let full = Response::Coupled(Coupled::new(&a, &b).unwrap());
        let (state, command) = ([0.1, -0.2, 3.0, 1.0], [0.3, 0.05]);
        let one = accelerations(&Response::Uncoupled(elements.to_vec()), &state, &command);
        let other = accelerations(&full, &state, &command);
        for (a, b) in one.iter().zip(&other) {
            assert!((a - b).abs() < 1e-12 * a.abs(), "{a} {b}");
        }
    }

    #[test]
    fn a_held_command_is_reached() {
        let response = Response::Uncoupled(vec![Element::default()]);
        assert_eq!(accelerations(&response, &[0.3, 0.0], &[0.3]), [0.0]);
    }

    #[test]
    fn wrong_matrices_are_refused_by_name() {
        let square = [vec![0.0, 1.0], vec![-1.0, -1.0]];
        let message = |a: &[Vec<f64>], b: &[Vec<f64>]| Coupled::new(a, b).unwrap_err().to_string();
        assert!(message(&square[..1], &[vec![0.0]]).starts_with("a = "));
        assert!(message(&square, &[vec![0.0]]).starts_with("b = "));
        assert!(message(&[vec![0.0, 2.0], vec![-1.0, -1.0]], &[vec![0.0], vec![1.0]]).contains("dy/dt"));
        assert!(Element::new(0.0, 0.8).unwrap_err().to_string().starts_with("frequency_hz = 0"));
    }
}
