//! Cross-sections: stiffness and inertia.

use nalgebra::{DMatrix, Matrix6};
use wingbeat_math::{Error, Mat3, Vec3, require};

/// A strain of a section. The beam runs along the section's x axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Strain {
    /// Twist per length about x, rad/m.
    Twist,
    /// Curvature about y, rad/m.
    BendY,
    /// Curvature about z, rad/m.
    BendZ,
    /// Extension along x.
    Extension,
    /// Shear towards y.
    ShearY,
    /// Shear towards z.
    ShearZ,
}

impl Strain {
    /// All six.
    pub const ALL: &'static [Self] =
        &[Self::Twist, Self::BendY, Self::BendZ, Self::Extension, Self::ShearY, Self::ShearZ];
    /// Twist and both curvatures.
    pub const INEXTENSIBLE: &'static [Self] = &[Self::Twist, Self::BendY, Self::BendZ];
}

/// A cross-section, in its own axes: x along the beam, from the reference line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrossSection {
    /// Moments and forces by strains in the order of [`Strain::ALL`], symmetric: N m2, N m, N.
    pub stiffness: [[f64; 6]; 6],
    /// Mass per length, kg/m.
    pub mass: f64,
    /// Centre of mass from the reference line, m.
    pub centre: Vec3,
    /// Inertia per length about the centre of mass, kg m.
    pub inertia: Mat3,
}

/// A section at an arc coordinate. Between stations stiffness and inertia are linear; two at one arc are a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SectionStation {
    /// Distance from the root along the beam, m.
    pub arc_m: f64,
    /// Section there.
    pub section: CrossSection,
}

impl CrossSection {
    /// A section without couplings and mass: `axial` stiffness E A (N), and G J, E I about y, E I about z (N m2). Shear is taken
    /// as stiff as extension.
    pub fn isotropic(axial: f64, [torsion, about_y, about_z]: [f64; 3]) -> Self {
        let diagonal = [torsion, about_y, about_z, axial, axial, axial];
        let mut stiffness = [[0.0; 6]; 6];
        diagonal.iter().enumerate().for_each(|(k, value)| stiffness[k][k] = *value);
        Self { stiffness, mass: 0.0, centre: Vec3::ZERO, inertia: Mat3([[0.0; 3]; 3]) }
    }

    /// The same with mass per length (kg/m), centre of mass (m) and inertia per length about it (kg m).
    pub fn with_mass(self, mass: f64, centre: Vec3, inertia: Mat3) -> Self {
        Self { mass, centre, inertia, ..self }
    }

    /// Whether the stiffness is symmetric and positive definite.
    pub fn is_stiff(&self) -> bool {
        let k = Matrix6::from_fn(|i, j| self.stiffness[i][j]);
        let scale = k.diagonal().map(|x| x.max(0.0).sqrt());
        let alike = |(i, j): (usize, usize)| (k[(i, j)] - k[(j, i)]).abs() <= 1e-9 * scale[i] * scale[j];
        let symmetric = (0..36).all(|at| alike((at / 6, at % 6)));
        k.iter().all(|x| x.is_finite()) && symmetric && k.cholesky().is_some()
    }

    /// Refuses what no section can be.
    pub(crate) fn check(&self) -> Result<(), Error> {
        if !self.is_stiff() {
            return Err(Error::invalid(
                "stiffness",
                format!("{:?}", self.stiffness),
                "a symmetric positive definite matrix",
            ));
        }
        require::not_negative("mass", self.mass)?;
        let ends = [self.centre.norm(), self.inertia.0.iter().flatten().map(|x| x.abs()).sum()];
        match ends.iter().all(|x| x.is_finite()) {
            true => Ok(()),
            false => Err(Error::invalid("centre", format!("{:?}", self.centre), "finite numbers")),
        }
    }

    /// The section the share `x` of the way to another.
    pub(crate) fn mixed(&self, other: &Self, x: f64) -> Self {
        let mix = |a: f64, b: f64| a + (b - a) * x;
        let pair = |a: [[f64; 3]; 3], b: [[f64; 3]; 3]| {
            std::array::from_fn(|i| std::array::from_fn(|j| mix(a[i][j], b[i][j])))
        };
        Self {
            stiffness: std::array::from_fn(|i| {
                std::array::from_fn(|j| mix(self.stiffness[i][j], other.stiffness[i][j]))
            }),
            mass: mix(self.mass, other.mass),
            centre: self.centre + (other.centre - self.centre) * x,
            inertia: Mat3(pair(self.inertia.0, other.inertia.0)),
        }
    }

    /// Stiffness by the strains `kept` where the others bear no force: the rest is condensed.
    pub(crate) fn condensed(&self, kept: &[Strain]) -> DMatrix<f64> {
        let (mine, rest): (Vec<usize>, Vec<usize>) = (0..6).partition(|k| kept.contains(&Strain::ALL[*k]));
        let part = |rows: &[usize], columns: &[usize]| {
            DMatrix::from_fn(rows.len(), columns.len(), |i, j| self.stiffness[rows[i]][columns[j]])
        };
        let own = part(&mine, &mine);
        match part(&rest, &rest).cholesky() {
            Some(factors) if !rest.is_empty() => {
                own - part(&mine, &rest) * factors.solve(&part(&rest, &mine))
            }
            _ => own,
        }
    }
}
