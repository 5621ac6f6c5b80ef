//! The numbers of spars as the file gives them. Each stands for those of all springs between the pieces, which keep names of their own.

use super::Robot;
use super::mechanism::JointDrive;
use super::numbers::SpringNumbers;
use super::spec::LinkSpec;
use std::ops::Range;
use wingbeat_math::range;
use wingbeat_math::{Declared, DeclaredQuantity, NamedNumber};

/// Stiffness of a spar at its root.
const STIFFNESS: DeclaredQuantity = DeclaredQuantity::within("N m2", range::Range::POSITIVE, 1e-9, 1e6);
/// Damping over stiffness.
const DAMPING: DeclaredQuantity = DeclaredQuantity::within("s", range::Range::NOT_NEGATIVE, 0.0, 1e3);

/// What a number of a spar is.
#[derive(Clone, Copy, PartialEq)]
enum SparKey {
    Bending,
    Torsion,
    Damping,
}

impl SparKey {
    const ALL: [Self; 3] = [Self::Bending, Self::Torsion, Self::Damping];

    fn name(self) -> &'static str {
        match self {
            Self::Bending => "bending_n_m2",
            Self::Torsion => "torsion_n_m2",
            Self::Damping => "damping_s",
        }
    }
}

/// The joints between the pieces of a spar, of both sides where it has its image.
#[derive(Clone, Debug)]
pub(super) struct SparJoints {
    /// What the file calls its link.
    pub name: String,
    /// Those that bend, from the root on.
    pub bends: Vec<usize>,
    /// Those that twist.
    pub twists: Vec<usize>,
    /// Stiffness of the first spring over that of the beam at the root, 1/m.
    over_root: f64,
}

impl SparJoints {
    /// That of a link, without joints yet; none of a link without a spar.
    pub fn of(link: &LinkSpec) -> Option<Self> {
        let over_root = link.spar?.spring(1, 1.0).stiffness;
        Some(Self { name: link.name.clone(), bends: Vec::new(), twists: Vec::new(), over_root })
    }

    /// Takes the joints at `places` of a piece, which bend where they turn about x.
    pub fn take(&mut self, piece: &LinkSpec, places: Range<usize>) {
        if piece.axis[0] == 0.0 { &mut self.twists } else { &mut self.bends }.extend(places);
    }
}

/// Whether the number at `key` is the damping of a spar, which follows its stiffness.
pub(super) fn follows(key: &str) -> bool {
    key.split_once(".spar.").is_some_and(|(_, end)| end == SparKey::Damping.name())
}

impl Robot {
    /// The spring of a joint; none where the joint's motion is given.
    fn spring(&self, joint: usize) -> Option<SpringNumbers> {
        match &self.mechanism.drives[joint] {
            JointDrive::Elastic(spring) => Some(spring.numbers),
            _ => None,
        }
    }

    /// A number of a spar as its first spring has it; none where it has none.
    fn spar_number(&self, spar: &SparJoints, key: SparKey) -> Option<f64> {
        let first = |joints: &[usize]| self.spring(*joints.first()?);
        match key {
            SparKey::Bending => Some(first(&spar.bends)?.stiffness / spar.over_root),
            SparKey::Torsion => Some(first(&spar.twists)?.stiffness / spar.over_root),
            SparKey::Damping => first(&spar.bends).map(|spring| spring.damping / spring.stiffness),
        }
    }

    /// The numbers of the spars with what is declared of them.
    pub(super) fn spar_parameters<'a>(&'a self) -> impl Iterator<Item = NamedNumber> {
        let of = move |spar: &'a SparJoints| {
            SparKey::ALL.into_iter().filter_map(move |key| {
                let quantity = if key == SparKey::Damping { DAMPING } else { STIFFNESS };
                let name = format!("links.{}.spar.{}", spar.name, key.name());
                let value = self.spar_number(spar, key).filter(|value| value.is_finite())?;
                Some(NamedNumber { name, quantity, value })
            })
        };
        self.mechanism.spars.iter().flat_map(of)
    }

    /// What of the number of a spar at `key` the number of a spring takes, which is `value` now; none of others.
    ///
    /// Equation: robot.spar_number
    /// `k_j = (k_j/E I) E I, d_j = t k_j`
    /// Source: `robot.spar`; damping over stiffness is t everywhere.
    /// Test: `a_number_of_a_spar_is_that_of_all_its_springs`.
    pub(super) fn spar_share(&self, key: &str, number: Declared, value: f64) -> Option<f64> {
        let (link, end) = key.strip_prefix("links.")?.split_once(".spar.")?;
        let spar = self.mechanism.spars.iter().find(|spar| spar.name == link)?;
        let key = SparKey::ALL.into_iter().find(|key| key.name() == end)?;
        let (piece, of) = number.name.strip_prefix("links.")?.split_once(".elastic.")?;
        let joint = self.tree().find(piece)?;
        let [bends, twists] = [&spar.bends, &spar.twists].map(|joints| joints.contains(&joint));
        let proportional = || Some(value / self.spar_number(spar, key)?);
        match (key, of) {
            (SparKey::Bending, "stiffness" | "damping") if bends => proportional(),
            (SparKey::Torsion, "stiffness" | "damping") if twists => proportional(),
            (SparKey::Damping, "damping") if bends || twists => Some(self.spring(joint)?.stiffness),
            _ => None,
        }
    }
}
