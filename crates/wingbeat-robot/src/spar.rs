//! The numbers of spars as the file gives them. Each stands for those of all springs between the pieces, which keep names of their own.

use super::Robot;
use super::mechanism::JointDrive;
use super::numbers::{SpringNumbers, stands_for};
use super::spec::{LinkSparSpec, LinkSpec};
use std::ops::Range;
use wingbeat_math::Error;
use wingbeat_math::range;
use wingbeat_math::{Declared, DeclaredQuantity, NamedNumber};

/// Stiffness of a spar at its root.
const STIFFNESS: DeclaredQuantity = DeclaredQuantity::within("N m2", range::Range::POSITIVE, 1e-9, 1e6);
/// Damping over stiffness.
const DAMPING: DeclaredQuantity = DeclaredQuantity::within("s", range::Range::NOT_NEGATIVE, 0.0, 1e3);

/// What the name of a number of a spar has between link and key.
const SPAR: &str = ".spar.";

/// What a number of a spar is.
#[derive(Clone, Copy, PartialEq)]
enum SparKey {
    Bending,
    EdgeBending,
    Torsion,
    Damping,
}

impl SparKey {
    const ALL: [Self; 4] = [Self::Bending, Self::EdgeBending, Self::Torsion, Self::Damping];

    fn name(self) -> &'static str {
        match self {
            Self::Bending => "bending_n_m2",
            Self::EdgeBending => "edge_bending_n_m2",
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
    bends: Vec<SparJoint>,
    /// Those that bend in the plane of the wing.
    edges: Vec<SparJoint>,
    /// Those that twist.
    twists: Vec<SparJoint>,
}

/// A joint between two pieces.
#[derive(Clone, Copy, Debug)]
struct SparJoint {
    joint: usize,
    /// Stiffness of its spring over that of the beam at the root, 1/m.
    over_root: f64,
}

/// Relative difference of springs that is rounding.
const ROUNDING: f64 = 1e-9;

fn alike(a: f64, b: f64) -> bool {
    (a - b).abs() <= ROUNDING * a.abs().max(b.abs())
}

impl SparJoints {
    /// That of a link, without joints yet; none of a link without a spar.
    pub fn of(link: &LinkSpec) -> Option<Self> {
        link.spar.map(|_| Self {
            name: link.name.clone(),
            bends: Vec::new(),
            edges: Vec::new(),
            twists: Vec::new(),
        })
    }

    /// Takes the joints at `places` of a piece of the spar `of`, which bend where they turn about x, or z, and twist where about y.
    pub fn take(&mut self, of: &LinkSparSpec, piece: &LinkSpec, places: Range<usize>) {
        let Some(spring) = piece.elastic else { return };
        let [about_x, about_y, _] = piece.axis.map(|along| along != 0.0);
        let (all, root) = match (about_x, about_y) {
            (true, _) => (&mut self.bends, Some(of.bending_n_m2)),
            (_, true) => (&mut self.twists, of.torsion_n_m2),
            _ => (&mut self.edges, of.edge_bending_n_m2),
        };
        let over_root = spring.stiffness / root.unwrap_or(of.bending_n_m2);
        all.extend(places.map(|joint| SparJoint { joint, over_root }));
    }

    /// All of them.
    pub fn joints(&self) -> impl Iterator<Item = usize> {
        self.bends.iter().chain(&self.edges).chain(&self.twists).map(|of| of.joint)
    }
}

/// Whether the number at `key` is the damping of a spar, which follows its stiffness.
pub(super) fn follows(key: &str) -> bool {
    key.split_once(SPAR).is_some_and(|(_, end)| end == SparKey::Damping.name())
}

impl Robot {
    /// The spring of a joint; none where the joint's motion is given.
    fn spring(&self, joint: usize) -> Option<SpringNumbers> {
        match &self.mechanism.drives[joint] {
            JointDrive::Elastic(spring) => Some(spring.numbers),
            _ => None,
        }
    }

    /// A number of a spar; none where it has none, or where its springs are not those of one beam.
    fn spar_number(&self, spar: &SparJoints, key: SparKey) -> Option<f64> {
        let of = |of: &SparJoint| {
            let spring = self.spring(of.joint)?;
            Some(match key {
                SparKey::Damping => spring.damping / spring.stiffness,
                SparKey::Bending | SparKey::EdgeBending | SparKey::Torsion => spring.stiffness / of.over_root,
            })
        };
        let [none, bends, edges, twists]: [&[SparJoint]; 4] = [&[], &spar.bends, &spar.edges, &spar.twists];
        let of_key = match key {
            SparKey::Bending => [bends, none, none],
            SparKey::EdgeBending => [none, edges, none],
            SparKey::Torsion => [none, none, twists],
            SparKey::Damping => [bends, edges, twists],
        };
        let mut all = of_key.into_iter().flatten();
        let first = of(all.next()?)?;
        all.all(|other| of(other).is_some_and(|other| alike(other, first))).then_some(first)
    }

    /// Refuses a number of a spar beside one of a spring for which it stands.
    pub(super) fn check_spar_numbers(&self, keys: &[&str], known: &[NamedNumber]) -> Result<(), Error> {
        for spar in keys.iter().filter(|key| key.contains(SPAR)) {
            let stands = |number: &&NamedNumber| {
                let declared = Declared { name: &number.name, quantity: &number.quantity };
                self.spar_share(spar, declared, number.value).is_some()
            };
            for spring in known.iter().filter(stands) {
                if let Some(key) = keys.iter().find(|key| stands_for(key, &spring.name).is_some()) {
                    let allowed = format!("one of it and {spar:?}, which stands for it");
                    return Err(Error::invalid("numbers", format!("{key:?}"), allowed));
                }
            }
        }
        Ok(())
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
        let (link, end) = key.strip_prefix("links.")?.split_once(SPAR)?;
        let spar = self.mechanism.spars.iter().find(|spar| spar.name == link)?;
        let key = SparKey::ALL.into_iter().find(|key| key.name() == end)?;
        let (piece, of) = number.name.strip_prefix("links.")?.split_once(".elastic.")?;
        let joint = self.tree().find(piece)?;
        let [bends, edges, twists] =
            [&spar.bends, &spar.edges, &spar.twists].map(|all| all.iter().any(|of| of.joint == joint));
        let proportional = || Some(value / self.spar_number(spar, key)?);
        match (key, of) {
            (SparKey::Bending, "stiffness" | "damping") if bends => proportional(),
            (SparKey::EdgeBending, "stiffness" | "damping") if edges => proportional(),
            (SparKey::Torsion, "stiffness" | "damping") if twists => proportional(),
            (SparKey::Damping, "damping") if bends || edges || twists => Some(self.spring(joint)?.stiffness),
            _ => None,
        }
    }
}
