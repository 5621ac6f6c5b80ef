//! One flapping cycle of a free tree without air.

use crate::Error;
use wingbeat::body::{BaseAcceleration, FourierSeries, LinkMotion, MAX_LINKS, Momentum, Tree, joint_power};
use wingbeat::math::linear::solve_symmetric;
use wingbeat::math::{Jet, Mat3, Quat, RK4, Vec3, Workspace, Wrench};
use wingbeat::plant::Fault;

/// Flapping frequency, Hz.
const FREQUENCY: f64 = 3.5;
/// Runge-Kutta steps in the cycle.
const STEPS: usize = 4000;
/// p_WB, quat_wxyz, v_WB_B, w_WB_B, work of the joints.
const STATES: usize = 14;

/// Momentum in W about the world origin, and energy.
#[derive(Debug)]
pub struct Totals {
    /// Linear momentum, N s.
    pub linear: Vec3,
    /// Angular momentum, N m s.
    pub angular: Vec3,
    /// Kinetic and potential energy, J.
    pub energy: f64,
}

/// What one cycle did.
#[derive(Debug)]
pub struct VacuumCycle {
    /// At the start.
    pub before: Totals,
    /// At the end.
    pub after: Totals,
    /// Work of the joint torques, J.
    pub work: f64,
    /// Largest work done on the way, J.
    pub peak_work: f64,
}

/// A tree of two wings (shoulder, elbow, shoulder, elbow) whose joints follow the gait.
struct WingTree {
    tree: Tree,
    shoulder: FourierSeries,
    elbow: FourierSeries,
    gravity: Vec3,
}

/// Attitude and motion of base and links at one instant.
struct Snapshot {
    attitude: Mat3,
    v_b: Vec3,
    w_b: Vec3,
    joints: [Jet; 4],
    motions: [LinkMotion; MAX_LINKS],
}

impl VacuumCycle {
    /// Flies one cycle of the published gait from a moving start; `gravity` in W, m/s2.
    pub fn one_cycle(tree: Tree, gravity: Vec3) -> Result<Self, Error> {
        let shoulder = FourierSeries::single(0.1, 0.95, 0.0);
        let elbow = FourierSeries::single(-0.65, -0.65, 1.25 * std::f64::consts::PI);
        let model = WingTree { tree, shoulder, elbow, gravity };
        let period = 1.0 / FREQUENCY;
        let (h, mut workspace) = (period / STEPS as f64, Workspace::new(STATES, 4));
        let mut x = [0.0; STATES];
        Quat::from_roll_pitch_yaw(0.1, -0.3, 0.5).store_wxyz(&mut x[3..]);
        Vec3([1.5, 0.1, -0.2]).store(&mut x[7..]);
        Vec3([0.5, -1.0, 0.3]).store(&mut x[10..]);
        let before = model.totals(0.0, &x)?;
        let mut peak_work: f64 = 0.0;
        for k in 0..STEPS {
            RK4.step(|t, x, dx| model.rates(t, x, dx), k as f64 * h, h, &mut x, &mut workspace)?;
            peak_work = peak_work.max(x[13].abs());
        }
        Ok(Self { before, after: model.totals(period, &x)?, work: x[13], peak_work })
    }
}

impl WingTree {
    fn snapshot(&self, t: f64, x: &[f64]) -> Result<Snapshot, Fault> {
        let rate = std::f64::consts::TAU * FREQUENCY;
        let phase = Jet::new(rate * t, rate, 0.0);
        let (v_b, w_b) = (Vec3::from_slice(&x[7..]), Vec3::from_slice(&x[10..]));
        let joints = [0, 1, 2, 3].map(|i| match self.tree.parent(i) {
            None => self.shoulder.angle(phase),
            Some(_) => self.elbow.angle(phase),
        });
        let mut motions = [LinkMotion::default(); MAX_LINKS];
        self.tree.motions(&joints, v_b, w_b, &mut motions);
        let attitude = Quat::from_wxyz(&x[3..]).normalized().matrix();
        Ok(Snapshot { attitude, v_b, w_b, joints, motions })
    }

    fn rates(&self, t: f64, x: &[f64], dx: &mut [f64]) -> Result<(), Fault> {
        let s = self.snapshot(t, x)?;
        let g_b = s.attitude.transpose_mul(self.gravity);
        let (mass, bias) = self.tree.inertia_and_bias(s.w_b, &s.motions);
        let load = self.tree.gravity(g_b, &s.motions) + -bias;
        let ([fx, fy, fz], [tx, ty, tz]) = (load.force.0, load.moment.0);
        let base = solve_symmetric(mass, [fx, fy, fz, tx, ty, tz]).ok_or(Fault::MassMatrix { time: t })?;
        let base = BaseAcceleration::from_slice(&base);
        let mut torques = [0.0; MAX_LINKS];
        self.tree.joint_torques(&s.motions, base, g_b, &[Wrench::ZERO; MAX_LINKS], &mut torques);
        (s.attitude * s.v_b).store(dx);
        Quat::from_wxyz(&x[3..]).rate(s.w_b).store_wxyz(&mut dx[3..]);
        (base.origin - s.w_b.cross(s.v_b)).store(&mut dx[7..]);
        base.angular.store(&mut dx[10..]);
        dx[13] = joint_power(&torques, &s.joints);
        Ok(())
    }

    fn totals(&self, t: f64, x: &[f64]) -> Result<Totals, Fault> {
        let s = self.snapshot(t, x)?;
        let origin = -s.attitude.transpose_mul(Vec3::from_slice(x));
        let Momentum { linear, angular } = self.tree.momentum(s.v_b, s.w_b, &s.motions, origin);
        let g_b = s.attitude.transpose_mul(self.gravity);
        let energy = self.tree.kinetic_energy(s.v_b, s.w_b, &s.motions)
            + self.tree.potential_energy(g_b, &s.motions, origin);
        Ok(Totals { linear: s.attitude * linear, angular: s.attitude * angular, energy })
    }
}
