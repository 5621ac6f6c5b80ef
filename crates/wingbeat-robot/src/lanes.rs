//! Several robots of one make as one, each in a lane.

use super::{Numbers, Robot};
use std::cell::{Cell, RefCell};
use wingbeat_math::Error;
use wingbeat_math::{Lanes, Parameters};

impl Robot {
    /// Whether the numbers of a robot of the same specification but for its [`Numbers`] can stand beside these in lanes:
    /// those that decide where strips lie and how a linkage closes are the same, and none is zero that is not zero here.
    pub fn fits_beside(&self, other: &Self) -> bool {
        let [a, b] = [self.numbers(), other.numbers()];
        let [zeros, others] =
            [&a, &b].map(|numbers| flat(numbers).iter().map(|x| *x == 0.0).collect::<Vec<_>>());
        let mut laid = a.surfaces.iter().zip(&b.surfaces);
        zeros == others
            && a.places == b.places
            && a.linkage == b.linkage
            && a.placements == b.placements
            && laid.all(|(a, b)| a.outline == b.outline && a.hinges == b.hinges && a.webs == b.webs)
            && self.wind.fits_beside(&other.wind)
            && self.residual == other.residual
            && self.ground == other.ground
            && self.perch == other.perch
    }

    /// Robots that [fit](Self::fits_beside) side by side, each in a lane; the lanes that are left over repeat the last.
    ///
    /// # Errors
    /// [`Error::Invalid`] when strips or nodes do not fit an outline.
    ///
    /// # Panics
    /// When there is none.
    pub fn side_by_side<S: Lanes>(robots: &[&Self]) -> Result<Robot<S>, Error> {
        let last = robots.len() - 1;
        let all: Vec<Vec<f64>> = robots.iter().map(|robot| flat(&robot.numbers())).collect();
        let place = Cell::new(0);
        let next = |_: f64| {
            let place = place.replace(place.get() + 1);
            S::of(|lane| all[lane.min(last)][place])
        };
        let numbers: Numbers<S> = robots[0].numbers().map(next);
        let winds: Vec<_> = robots.iter().map(|robot| &robot.wind).collect();
        Ok(Robot { wind: super::Wind::side_by_side(&winds), ..robots[0].with(&numbers)? })
    }
}

/// All numbers in the order in which they are mapped.
fn flat(numbers: &Numbers) -> Vec<f64> {
    let all = RefCell::new(Vec::new());
    numbers.map(|number| {
        all.borrow_mut().push(number);
        number
    });
    all.into_inner()
}
