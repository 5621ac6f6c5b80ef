//! The numbers of a tethered wing and its air by the names that a robot gives those of its wing.

use wingbeat_aero::{Aero, SurfaceNumbers};
use wingbeat_math::{Parameters, Scalar, Walk};

/// Numbers of section and air; outline and hinges are the case's own and have no names.
#[derive(Clone, Debug, PartialEq)]
pub struct WingNumbers<P: Scalar = f64>(pub SurfaceNumbers<P>);

impl WingNumbers {
    /// Those of a model.
    pub fn of(aero: &Aero) -> Self {
        Self(aero.numbers().clone())
    }
}

impl<P: Scalar> Parameters<P> for WingNumbers<P> {
    type In<Q: Scalar> = WingNumbers<Q>;

    fn walk<Q: Scalar>(&self, at: &mut Walk<'_, P, Q>) -> WingNumbers<Q> {
        let section = SurfaceNumbers { outline: None, hinges: Vec::new(), ..self.0.clone() };
        let section = at.within("surfaces.wing", |at| section.walk(at));
        WingNumbers(SurfaceNumbers {
            outline: self.0.outline.as_ref().map(|outline| outline.map(|x| at.fixed(x))),
            hinges: self.0.hinges.iter().map(|x| at.fixed(*x)).collect(),
            ..section
        })
    }
}
