//! What the columns of the records mean.

/// A column, or columns of one kind.
pub struct ColumnMeaning {
    /// Its name, with `<what>` where names and numbers of the run stand.
    pub name: &'static str,
    /// The records that have it.
    pub records: &'static [&'static str],
    /// Its unit; several where it depends on the run.
    pub units: &'static [&'static str],
    /// Its frame.
    pub frame: &'static str,
    /// What it is, with sign and point of reference.
    pub meaning: &'static str,
}

pub const FLIGHT: &str = "record.parquet of fly and of a planned roll-in";
pub const GAIT: &str = "record.parquet of a planned gait";
pub const STRIPS: &str = "strips.parquet";
pub const LOADS: &str = "loads.csv of tether";
pub const SWEEP: &str = "flights.csv and record.parquet of sweep";
pub const RUNS: &str = "runs.csv and record.parquet of a sweep of a case";
pub const RIG: &str = "record.parquet of rig simulate";
pub const BOX: &str = "record.parquet of rig record";
pub const AVERAGE: &str = "NAME.parquet of rig process";
pub const ENVELOPE: &str = "envelope.parquet of rig process";
pub const CALIBRATED: &str = "record.parquet of calibrate";
pub const MODES: &str = "multipliers.parquet of trim";
pub const ORBITS: &str = "family.parquet of trim";
pub const CANDIDATES: &str = "candidates.csv and record.parquet of a sweep with [search]";
pub const STARTS: &str = "starts.csv and starts.parquet of trim";
pub const NODES: &str = "plan.parquet of plan";

/// Frame of a column that has that of what it belongs to.
pub const OWN_FRAME: &str = "its own";
/// Unit of a column that has that of what it belongs to.
pub const OWN_UNIT: &str = "its own";
/// Unit of a multiplier.
pub const PER_UNIT: &str = "objective per unit";

/// The records with what a row of each is.
pub const RECORDS: [(&str, &str); 16] = [
    (FLIGHT, "One row per instant, `flight.record_every_s` apart."),
    (
        GAIT,
        "One row per instant of one cycle on a stand, its first and last row the same instant of the cycle.",
    ),
    (
        NODES,
        "One row per point of a plan whose state is an unknown: every node, and of order 6 the points between. The objective is in s \
      for a roll-in and in W for a gait. plan.json has what has one value: times, parameters and constraints on the ends.",
    ),
    (
        STRIPS,
        "One row per strip and instant, of fly where `flight.record_strips_every_s` asks for it and of tether.",
    ),
    (
        LOADS,
        "One row per step. Sums count the half of the wing that `wing.side` names. means.csv has mean, least and \
      most of each over the last cycle.",
    ),
    (SWEEP, "One row per flight."),
    (CANDIDATES, "One row per candidate of a search, in columns of their own names the values of its draws."),
    (RUNS, "One row per run."),
    (RIG, "One row per sample of the cell."),
    (BOX, "One row per sample of the box; what was booked as missing has no row."),
    (AVERAGE, "One row per phase of the cycle, `process.bins` of them."),
    (ENVELOPE, "One row per phase over several cycles, of all runs processed together."),
    (MODES, "One row per Floquet multiplier of the orbit, the largest first."),
    (
        ORBITS,
        "One row per orbit of `trim.family`, whose key, where it is none of the course, has a column of its name; record.parquet of trim, one cycle, has the columns of a flight.",
    ),
    (STARTS, "One row per start of `trim.search`: the gait that it came to."),
    (CALIBRATED, "One row per run and phase of the cycle, 200 of them."),
];

/// What the frames are.
pub const FRAMES: &str = "\
Units, frames and limits are also in the files: in the metadata of each column of a Parquet file, and of all in the
file's own (`df.attrs[\"units\"][\"roll\"]` and `df.attrs[\"frames\"]` after `pandas.read_parquet`). CSV files begin
with the names.

| frame | axes |
|---|---|
| W | the world: z up, x where a heading of zero points, y to its left; origin where the flight begins |
| B | the body: x forward, y left, z up; origin that of the robot's file |
| WB | from the body to the world: R_WB turns what is resolved in B into W |
| C | the sensing frame of the load cell, as mounted |
| WT | from the tool of the arm to the world |
| wind | along the wind, to its left, up across it |

A moment about y is positive nose *down*, about x right wing down, about z nose to the left. `CM` alone is nose up.
";

const S: &[&str] = &["s"];
const M: &[&str] = &["m"];
const N: &[&str] = &["N"];
const NM: &[&str] = &["N m"];
const RAD: &[&str] = &["rad"];
const DEG: &[&str] = &["deg"];
const W: &[&str] = &["W"];
const ONE: &[&str] = &[""];

const fn column(
    name: &'static str,
    records: &'static [&'static str],
    units: &'static [&'static str],
    frame: &'static str,
    meaning: &'static str,
) -> ColumnMeaning {
    ColumnMeaning { name, records, units, frame, meaning }
}

/// All columns, the more special before the more general.
#[rustfmt::skip]
pub const COLUMNS: &[ColumnMeaning] = &[
    column("t", &[FLIGHT, GAIT, STRIPS, LOADS, RIG, ENVELOPE], S, "", "Time from the start of the run."),
    column("t", &[NODES], S, "", "Time: of a roll-in from the start of the flight, of a gait from the start of the cycle."),
    column("interval", &[NODES], ONE, "", "Number of the interval that ends at the row or holds it, from 0; 0 in the first row too."),
    column("defect_<of>", &[NODES], &[PER_UNIT], "", "Multiplier of the defect of this state between the start of the interval and the row: the objective rises by its negative where the state is moved up by one in between. 0 in the first row."),
    column("limit_<of>", &[NODES], &[PER_UNIT], "", "Multiplier of the limits of this state or input, positive at the upper one. Of a state that is given, what holding it costs."),
    column("path_<of>", &[NODES], &[PER_UNIT], "", "Multiplier of a constraint along the way, as clearance; of a finer mesh each is smaller."),
    column("t", &[BOX], S, "", "Time of the sample by the box's count and rate, from the first sample."),
    column("t_kernel", &[BOX], S, "", "Arrival of its datagram by the kernel's clock, from the first."),
    column("t_host", &[BOX], S, "", "Arrival of its datagram by the program's clock, from the first."),
    column("rdt_sequence", &[BOX], ONE, "", "The box's number of the record in the stream."),
    column("ft_sequence", &[BOX], ONE, "", "The box's own count of its samples."),
    column("status", &[BOX], ONE, "", "The box's status word; 0 is good."),
    column("phase", &[FLIGHT, GAIT], RAD, "", "Phase of the gait: 2 pi a cycle, not wrapped."),
    column("phase", &[RIG], RAD, "", "What the encoder shows, 2 pi a cycle, not wrapped: 0 where the wings are at `gait.phase_rad`."),
    column("phase", &[STRIPS], &["rad", "cycles"], "", "Phase as the run counts it: of a flight in rad, of a case in cycles."),
    column("phase", &[LOADS], &["cycles"], "", "Cycles from the start."),
    column("run", &[CALIBRATED], ONE, "", "Number of the run in the calibration, from 0."),
    column("measured_<channel>", &[CALIBRATED], &["N", "N m"], "B", "Mean of the measured cycles by their harmonics, tared."),
    column("before_<channel>", &[CALIBRATED], &["N", "N m"], "B", "The model with the values that the fit began with, as the cell would show it."),
    column("after_<channel>", &[CALIBRATED], &["N", "N m"], "B", "The model as fitted."),
    column("low_<channel>", &[CALIBRATED], &["N", "N m"], "B", "Low end of the band that is to hold 95 % of the measured cycles."),
    column("high_<channel>", &[CALIBRATED], &["N", "N m"], "B", "High end of that band."),
    column("cycle", &[AVERAGE, CALIBRATED], ONE, "", "Phase as a share of the cycle, 0 to 1."),
    column("roll", &[FLIGHT], RAD, "WB", "Roll, positive right wing down; the last of yaw, pitch, roll."),
    column("pitch", &[FLIGHT], RAD, "WB", "Pitch, positive nose down."),
    column("yaw", &[FLIGHT], RAD, "WB", "Heading, positive nose to the left, seen from above."),
    column("roll_reference", &[FLIGHT], RAD, "WB", "Roll that the manoeuvre asks."),
    column("pitch_reference", &[FLIGHT], RAD, "WB", "Pitch that the manoeuvre asks."),
    column("plan_<angle>_<n>", &[FLIGHT], RAD, "WB", "Angle that the newest plan of the controller ends with, at node n; signs as roll, pitch, yaw."),
    column("horizon", &[FLIGHT], &["s"], "", "Length of the horizon, where the controller chooses it: `horizon_between_cycles`."),
    column("plan_missed_attitude", &[FLIGHT], RAD, "", "Angle between the attitude that the newest update found and that which it was prepared for (`controller.prepared`)."),
    column("plan_missed_attitude_largest", &[FLIGHT], RAD, "", "Largest of these so far."),
    column("solver_<measure>", &[FLIGHT], ONE, "", "Of the newest update of the controller: iterations, qp_changes (changes of the set of active limits), active_limits, stationarity, defect."),
    column("torque_<joint>", &[FLIGHT, GAIT], &["N m", "N"], "", "Effort that the joint needs along its coordinate: what drive, spring or stop gives."),
    column("pin_<pin>_<side>", &[FLIGHT, RIG], RAD, "", "Angle of a pin of the linkage that has a spring: of the second body that it joins against the first."),
    column("pin_power", &[FLIGHT, RIG], W, "", "Power that drive and actuators give to springs and dampers on pins of the linkage."),
    column("joint_power", &[FLIGHT, GAIT], W, "", "Mechanical power into the driven joints: drive and actuators."),
    column("separate_power", &[FLIGHT], W, "", "Sum of the positive powers of the driven joints, each by itself."),
    column("drive_power", &[FLIGHT], W, "", "Part of it that turns the crank of the gait."),
    column("drive_power", &[GAIT], W, "", "Power of the drive: what `plan.least_power.storage` does not store of a joint's negative power is lost."),
    column("regulator_power", &[FLIGHT], W, "", "Part of the joints' power that displaces the structure."),
    column("power_to_air", &[GAIT], W, "", "Power that surfaces and body give to the air."),
    column("crank_rate", &[RIG], &["rad/s"], "", "Rate of the crank under a motor."),
    column("motor_torque", &[FLIGHT, RIG], NM, "", "Torque on the motor's shaft."),
    column("motor_power", &[FLIGHT, RIG], W, "", "Mechanical power of the shaft."),
    column("electrical_power", &[FLIGHT, RIG], W, "", "Power that the motor takes from its supply."),
    column("force_up", &[GAIT], N, "W", "Force of the air upward, drag of the body included."),
    column("force_forward", &[GAIT], N, "W", "Force of the air along the horizontal heading, drag included."),
    column("trim_moment", &[GAIT], NM, "B", "Moment of the air about the centre of mass, positive nose *up*."),
    column("stalled_share", &[GAIT], ONE, "", "Share of the strips whose angle of attack is past their stall angle."),
    column("own_<column>", &[GAIT], &["rad", "W", "N"], "", "The same of the robot's own gait, at the same share of the cycle."),
    column("force_wind_<axis>", &[LOADS], N, "wind", "Force: drag along the wind, side to its left, lift up across it."),
    column("moment_wind_<axis>", &[LOADS], NM, "wind", "Moment about the body's origin, about the axes of drag, side and lift."),
    column("CL", &[LOADS], ONE, "", "Lift over dynamic pressure and area (`reference`)."),
    column("CD", &[LOADS], ONE, "", "Drag, likewise."),
    column("CY", &[LOADS], ONE, "", "Side force to the left, likewise."),
    column("CM", &[LOADS], ONE, "", "Moment about the body's y axis through its origin, over `reference.chord_m` too, positive nose *up*."),
    column("surge", &[LOADS], M, "W", "The body's motion forward."),
    column("heave", &[LOADS], M, "W", "The body's motion upward."),
    column("nose_up", &[LOADS], RAD, "W", "The body's pitch, positive nose *up*."),
    column("roll", &[LOADS], RAD, "W", "The body's roll, positive right wing down."),
    column("hinge_<hinge>", &[LOADS], RAD, "", "Angle of the hinge; `wing.hinges` says which way is positive."),
    column("thrust", &[LOADS], N, "wind", "Force against the wind: minus the drag."),
    column("power", &[LOADS], W, "", "Power that the motion gives to the air, sum over the strips: minus force times velocity, less moment times rate, relative to still ground. What moves forward pays for its drag; the wind's own power is not in it."),
    column("power_body", &[LOADS], W, "", "Part of it that the motion of the body gives; with those of the hinges it sums to `power`."),
    column("torque_<hinge>_<side>", &[LOADS], NM, "", "Torque of the air about the hinge's axis on what lies outboard of it on that side, positive where it turns the hinge its positive way; the drive gives minus this, and inertia. About a twist that grows, the share of each strip."),
    column("power_<hinge>_<side>", &[LOADS], W, "", "Minus that torque times the hinge's rate: what the hinge gives to the air."),
    column("tip_up", &[LOADS], M, "root", "Displacement of the left tip by the bent spar, along the normal of the root; of a wing with `[spar]`."),
    column("tip_ahead", &[LOADS], M, "root", "The same, forward."),
    column("tip_nose_up", &[LOADS], RAD, "root", "Twist of the left tip by the spar, positive nose *up*."),
    column("spar_force_<axis>", &[LOADS], N, "root", "Force that holds the left spar at its root."),
    column("spar_moment_<axis>", &[LOADS], NM, "root", "Moment that holds it there."),
    column("spar_strain_<number>", &[LOADS], &["1/m"], "", "Coordinates of the spar, which the drawing of the bent wing is made from: of each element the Legendre coefficients of twist, then of the two curvatures."),
    column("force_<source>_<axis>", &[FLIGHT, GAIT, LOADS], N, "B", "Force by source: circulatory, induced_drag, added_mass, profile_drag; of a robot also body_drag, gravity and inertia (minus the rate of momentum, with which all and the `thrust` of thrusters sum to zero)."),
    column("moment_<source>_<axis>", &[FLIGHT, GAIT, LOADS], NM, "B", "Moment by source about the body's origin."),
    column("force_<axis>", &[LOADS], N, "B", "Force of the air, sum over the sources."),
    column("moment_<axis>", &[LOADS], NM, "B", "Moment of the air about the body's origin, sum over the sources."),
    column("strip", &[STRIPS], ONE, "", "Number of the strip on its surface, from the left tip."),
    column("surface", &[STRIPS], ONE, "", "Number of the surface, in the robot's order."),
    column("separated", &[STRIPS], ONE, "", "Share of the strip's flow that is separated; 0 under law `linear`."),
    column("suction_lost", &[STRIPS], ONE, "", "Share of the linear leading-edge suction that the edge does not hold, under law `lev`."),
    column("camber", &[STRIPS], ONE, "", "Height of a membrane above mid chord over the chord; where a surface has one."),
    column("flap", &[STRIPS], &["rad"], "", "Angle of a flap, trailing edge down; where a surface has one."),
    column("camber_forward", &[STRIPS], ONE, "", "Height over the chord h of the shape h sin^2 t cos t, x = c (1 - cos t)/2, that moves the bulge of a membrane forward."),
    column("arc", &[STRIPS], M, "", "Arc of the control section from the middle, left positive."),
    column("width", &[STRIPS], M, "", "Width of the strip along the arc."),
    column("circulation", &[STRIPS], &["m2/s"], "", "Bound circulation; positive lifts."),
    column("circulation_lag_sum", &[STRIPS], &["m2/s"], "", "Sum of the lags that stands for the circulation with three lags; no bound circulation."),
    column("wash", &[STRIPS], &["m/s"], "", "Wind normal to the section's zero-lift line at 3/4 chord, wash of the wake included."),
    column("incidence", &[STRIPS], RAD, "", "Angle of attack of that wind against the zero-lift line, positive from below."),
    column("chord", &[STRIPS], M, "", "Chord of the control section; of tether."),
    column("velocity_<axis>", &[STRIPS], &["m/s"], "B", "Velocity of the point at 1/4 chord relative to still ground; of tether."),
    column("power", &[STRIPS], W, "", "Power that the strip gives to the air; of tether."),
    column("quarter_chord_<axis>", &[STRIPS], M, "B", "Point at 1/4 chord of the control section from the body's origin."),
    column("force_<source>_<axis>", &[STRIPS], N, "B", "Force on the strip by source: circulatory, induced_drag, added_mass, profile_drag."),
    column("force_<part>_<axis>", &[STRIPS, LOADS], N, "B", "Parts of sources. `suction`, `vortex`: of the leading edge, in circulatory. `separated`: what `cd90` gives, in profile_drag."),
    column("force_<axis>", &[STRIPS], N, "B", "Force on the strip, sum over the sources."),
    column("moment_<axis>", &[STRIPS], NM, "B", "Moment on the strip about its point at 1/4 chord, sum over the sources."),
    column("weight_<part>", &[FLIGHT], ONE, "W", "Upward force over the weight by part: attached (normal force of the attached flow), suction and vortex of the leading edge, separated (what `cd90` gives), friction (`cd0`), wash (turn of the lift by the downwash), added_mass, body_drag, residual (`robot.residual`), thrust. Their sum is the upward force of air and thrusters."),
    column("com_<axis>", &[FLIGHT], M, "W", "Centre of mass of the whole robot."),
    column("angular_momentum_<axis>", &[FLIGHT], &["kg m2/s"], "W", "In a vacuum: angular momentum of body and links about the centre of mass."),
    column("hinge_<end>_<axis>", &[FLIGHT], M, "W", "Point of the hinge line at the end of a panel."),
    column("leading_<end>_<axis>", &[FLIGHT], M, "W", "Point of the leading edge there."),
    column("trailing_<end>_<axis>", &[FLIGHT], M, "W", "Point of the trailing edge there."),
    column("clearance_<parts>", &[FLIGHT, GAIT], M, "B", "Least distance of two parts; negative where they overlap."),
    column("command_<regulator>", &[FLIGHT, GAIT], &["rad", "m", "rad/s", "", "N"], "", "Command to the actuator or thruster, a share where it scales a series, a rate where it paces the crank; its limits are those of the column."),
    column("p_WB_<axis>", &[FLIGHT], M, "W", "The body's origin."),
    column("quat_<axis>", &[FLIGHT], ONE, "WB", "Attitude as a unit quaternion w, x, y, z of R_WB."),
    column("v_WB_W_<axis>", &[FLIGHT], &["m/s"], "W", "Velocity of the body's origin, resolved in W."),
    column("w_WB_B_<axis>", &[FLIGHT], &["rad/s"], "B", "Angular rate of the body, resolved in B."),
    column("displacement_<element>", &[FLIGHT, GAIT], &["rad", "m", "", "N"], "", "Displacement of a structure element about the gait, a share where it scales a series; the thrust of a thruster."),
    column("rate_<element>", &[FLIGHT, GAIT], &["rad/s", "m/s", "1/s", "N/s"], "", "Its rate."),
    column("orbit_legs", &[FLIGHT], ONE, "", "Legs begun before and the share of the present one that is done, under `[controller.orbit]`: 1.25 is a quarter of the second."),
    column("orbit_dive", &[FLIGHT], ONE, "", "Share of the dive of `controller.orbit.dive` that is done."),
    column("orbit_dive_saved", &[FLIGHT], ONE, "", "Share of its cost that the last iteration of the dive's plan saved."),
    column("orbit_landing", &[FLIGHT], ONE, "", "Share of the landing of `controller.orbit.landing` that is done."),
    column("orbit_landing_ahead", &[FLIGHT], M, "", "How far the robot is ahead of the plan of the landing along its way; what it began ahead is made up until the end."),
    column("orbit_landing_other_laws", &[FLIGHT], ONE, "", "How far `laws` of `controller.orbit.landing` are taken to hold in place of the law that the controller knows."),
    column("orbit_landing_saved", &[FLIGHT], ONE, "", "Share of its cost that the last iteration of the landing's plan saved."),
    column("orbit_landing_speed", &[FLIGHT], &["m/s"], "", "Speed of the claw at the end of the landing's plan."),
    column("orbit_landing_pitch", &[FLIGHT], RAD, "", "Pitch off half a turn at the end of the landing's plan."),
    column("perch_<axis>", &[FLIGHT], M, "W", "Place of `[perch]`."),
    column("perch_distance", &[FLIGHT], M, "", "Distance of the claw from where it could hold, 0 where they touch."),
    column("perch_speed", &[FLIGHT], &["m/s"], "", "Speed of the claw."),
    column("perch_attitude", &[FLIGHT], &["rad"], "", "Angle between the back of the robot and straight down; 0 hangs heel above head."),
    column("perch_force", &[FLIGHT], &["N"], "", "Force between claw and perch."),
    column("perch_clearance", &[FLIGHT], M, "", "Least distance of the surfaces and capsules from the perch (`robot.perch_clearance`)."),
    column("orbit_height_error", &[FLIGHT], M, "W", "Height above that of the reference at the last update, as measured, under `[controller.orbit]`."),
    column("orbit_crank_added", &[FLIGHT], &["rad/s"], "", "Rate of the crank that `controller.orbit.adapt` adds to that of the reference."),
    column("orbit_missed_acceleration_<axis>", &[FLIGHT], &["m/s2"], "H", "Mean over a cycle of the acceleration along heading axes that `controller.orbit.adapt` has learned the model to miss."),
    column("orbit_missed_turning_<axis>", &[FLIGHT], &["rad/s2"], "B", "The same of the angular acceleration, in body axes."),
    column("orbit_governed", &[FLIGHT], &[""], "", "Largest change of a command by `controller.orbit.clearance_m` at the last update, as a share of its upper limit."),
    column("orbit_clearance_asked", &[FLIGHT], M, "", "The clearance `controller.orbit.clearance_m`."),
    column("orbit_not_kept", &[FLIGHT], ONE, "", "Updates so far with no commands that keep this over a cycle."),
    column("orbit_plan_error", &[FLIGHT], &[""], "", "What a plan without the structure missed at the last update: root mean square over height, velocity, roll, pitch and rates, each over the deviation that costs a full command."),
    column("orbit_roll_error", &[FLIGHT], RAD, "WB", "Roll less that of the reference at the same phase, at the last update, as measured, under `[controller.orbit]`."),
    column("orbit_pitch_error", &[FLIGHT], RAD, "WB", "Pitch, likewise."),
    column("orbit_height_asked", &[FLIGHT], M, "W", "Height of the reference at the last update, under `[controller.orbit]`."),
    column("orbit_roll_asked", &[FLIGHT], RAD, "WB", "Its roll."),
    column("orbit_pitch_asked", &[FLIGHT], RAD, "WB", "Its pitch."),
    column("orbit_speed_asked", &[FLIGHT], &["m/s"], "H", "Its velocity along the heading; in a landing, of which no speed is asked, that of the robot."),
    column("thrust_moment_<axis>", &[FLIGHT], NM, "B", "Moment of the thrusters about the body's origin."),
    column("thrust_<axis>", &[FLIGHT], N, "B", "Force of the thrusters on the body."),
    column("wind_<axis>", &[FLIGHT], &["m/s"], "W", "Velocity of the air, gusts and turbulence included, where it changes."),
    column("hover_error_<axis>", &[FLIGHT], M, "W", "Place less that asked at the last update, as measured, under `[controller.hover]`."),
    column("hover_force_<axis>", &[FLIGHT], N, "W", "Mean force of the air as its observer has it: what pushes the robot beside thrusters and gravity."),
    column("hover_asked_<axis>", &[FLIGHT], M, "W", "The place asked."),
    column("path_arc", &[FLIGHT], M, "", "Arc of the path at its point nearest to the robot at the last update, horizontal, from the start, under `[controller.orbit.tracking]`."),
    column("path_cross", &[FLIGHT], M, "", "Distance of the robot from that point, positive to the left of the path."),
    column("path_along", &[FLIGHT], M, "", "That arc less the one that time and speed ask; negative behind."),
    column("path_bank", &[FLIGHT], RAD, "", "Bank asked of the controller, positive right wing down."),
    column("path_nearest_<axis>", &[FLIGHT], M, "W", "That point."),
    column("reading_<sensor>", &[FLIGHT], &[OWN_UNIT], OWN_FRAME, "Newest reading that has arrived of a sensor of `[sensors]`, noise and offset included, of the inertial unit by part and axis (`reading_imu_rate_x`); before the first arrives, that one. Without instruments of each state that has noise or comes late (`reading_p_WB_z`): as the controller last received it."),
    column("estimate_t", &[FLIGHT], S, "", "Time of the newest estimate, under `[controller.orbit.estimator]`, as all of the estimate."),
    column("estimate_height", &[FLIGHT], M, "W", "Height as it is estimated."),
    column("estimate_forward", &[FLIGHT], &["m/s"], "", "Ground velocity along the heading, likewise."),
    column("estimate_leftward", &[FLIGHT], &["m/s"], "", "Velocity to the left of the heading, likewise."),
    column("estimate_upward", &[FLIGHT], &["m/s"], "W", "Climb, likewise."),
    column("estimate_roll", &[FLIGHT], RAD, "WB", "Roll, likewise."),
    column("estimate_pitch", &[FLIGHT], RAD, "WB", "Pitch, likewise."),
    column("estimate_w_WB_B_<axis>", &[FLIGHT], &["rad/s"], "B", "Angular rate, likewise."),
    column("estimate_deviation_height", &[FLIGHT], M, "W", "Standard deviation of its error, as the filter has it."),
    column("estimate_deviation_forward", &[FLIGHT], &["m/s"], "", "The same of that velocity."),
    column("estimate_deviation_leftward", &[FLIGHT], &["m/s"], "", "The same of that velocity."),
    column("estimate_deviation_upward", &[FLIGHT], &["m/s"], "W", "The same of the climb."),
    column("estimate_deviation_roll", &[FLIGHT], RAD, "WB", "The same of the roll."),
    column("estimate_deviation_pitch", &[FLIGHT], RAD, "WB", "The same of the pitch."),
    column("estimate_deviation_w_WB_B_<axis>", &[FLIGHT], &["rad/s"], "B", "The same of the angular rate."),
    column("estimate_bias_<reading>", &[FLIGHT], &[OWN_UNIT], OWN_FRAME, "Constant offset of an instrument as it is estimated: of the rates, forces, height and airspeed, in the unit and frame of the reading."),
    column("estimate_missed_turning_<axis>", &[FLIGHT], &["rad/s2"], "B", "Angular acceleration that the filter's model misses, as it is estimated."),
    column("estimate_missed_<axis>", &[FLIGHT], &["m/s2"], "B", "Acceleration that the filter's model misses, likewise."),
    column("estimate_innovation_<reading>", &[FLIGHT], ONE, "", "Square of the newest innovation of rates, forces, height or airspeed over its variance, mean over the axes."),
    column("coordinate_rate_<joint>", &[FLIGHT, GAIT], &["rad/s", "m/s"], "", "Rate of an elastic or free joint."),
    column("coordinate_<joint>", &[FLIGHT, GAIT, RIG], &["rad", "m"], "", "Coordinate of an elastic or free joint, a state."),
    column("crank_angle", &[FLIGHT, GAIT], RAD, "", "Angle of the crank that the motor turns: the phase of the gait."),
    column("crank_rate", &[FLIGHT, GAIT], &["rad/s"], "", "Its rate."),
    column("<surface>_from_<surface>_image_lag<k>_<n>", &[FLIGHT, GAIT], &["m2/s"], "", "Delayed circulation of strip n of the mirror image of a surface at `air.ground_m`, on its way to a surface."),
    column("<surface>_from_<surface>_lag<k>_<n>", &[FLIGHT, GAIT], &["m2/s"], "", "Delayed circulation of strip n of one surface on its way to another."),
    column("incidence_<n>", &[FLIGHT], RAD, "", "Angle of attack of strip n of the first surface, counted from the left tip, wash included, positive from below."),
    column("<surface>_incidence_<n>", &[FLIGHT], RAD, "", "The same of another surface."),
    column("circulation_<n>", &[FLIGHT, GAIT], &["m2/s"], "", "State of preset `paper`: circulation at node n, from the left tip."),
    column("<surface>_circulation_<n>", &[FLIGHT, GAIT], &["m2/s"], "", "The same of another surface."),
    column("series_<n>", &[FLIGHT, GAIT], ONE, "", "State of preset `as_printed`: sum of a_n sin(n theta) at node n, from the left tip."),
    column("<surface>_series_<n>", &[FLIGHT, GAIT], ONE, "", "The same of another surface."),
    column("wash_lag<k>_<n>", &[FLIGHT, GAIT], &["m/s"], "", "State of preset `full`: lag k of the wash on strip n, from the left tip."),
    column("<surface>_wash_lag<k>_<n>", &[FLIGHT, GAIT], &["m/s"], "", "The same of another surface."),
    column("wake_lag<k>_<n>", &[FLIGHT, GAIT], &["m2/s"], "", "State of preset `full`: lag k of the wake of strip n."),
    column("<surface>_wake_lag<k>_<n>", &[FLIGHT, GAIT], &["m2/s"], "", "The same of another surface."),
    column("vortex_<n>", &[FLIGHT, GAIT], &["m2/s2"], "", "State of laws `lev` and `lev3d`: strength of the leading-edge vortex of strip n."),
    column("<surface>_vortex_<n>", &[FLIGHT, GAIT], &["m2/s2"], "", "The same of another surface."),
    column("camber_<n>", &[FLIGHT, RIG], ONE, "", "State of a membrane: height above mid chord over the chord of strip n."),
    column("flap_<n>", &[FLIGHT, RIG], &["rad"], "", "State of a flap: angle on strip n, trailing edge down."),
    column("flap_momentum_<n>", &[FLIGHT], &["N m s"], "", "State of a flap: momentum of the hinge of strip n, by its own rate and by the motion of the chord."),
    column("camber_forward_<n>", &[FLIGHT, RIG], ONE, "", "State of a membrane: height over the chord of the shape of strip n that moves the bulge forward."),
    column("camber_momentum_<n>", &[FLIGHT], &["N s"], "", "State of a membrane: momentum of the air on strip n that the camber feels, as it is followed."),
    column("camber_rate_<n>", &[FLIGHT], &["m/s"], "", "State of a membrane: rate of the height of its first shape on strip n, as it is followed."),
    column("separated_<n>", &[FLIGHT, GAIT], ONE, "", "State of law `lev`: separated share of the flow of strip n."),
    column("<surface>_separated_<n>", &[FLIGHT, GAIT], ONE, "", "The same of another surface."),
    column("lag<k>_<n>", &[FLIGHT, GAIT], &["m/s"], "", "State of presets `paper` and `as_printed`: lag k of the wash at node n."),
    column("<surface>_lag<k>_<n>", &[FLIGHT, GAIT], &["m/s"], "", "The same of another surface."),
    column("<joint>", &[FLIGHT, GAIT], &["rad", "m"], "", "Coordinate of the joint, by its name; of a wing: shoulder and elbow positive raise what lies outboard, in both wings alike."),
    column("<state>", &[NODES], &[OWN_UNIT], OWN_FRAME, "A state or an input by its name, as in the record of the flight or of the gait; its limits are those of the column. Of a roll-in the attitude is `rotation_<axis>`, the rotation vector from the attitude at its begin. Of a gait the states are those of one wing, then running means of the drive power and the forces of the air, in W, mN and mN m."),
    column("q<n>", &[RIG], RAD, "", "Position of joint n of the arm."),
    column("dq<n>", &[RIG], &["rad/s"], "", "Its rate."),
    column("ddq<n>", &[RIG], &["rad/s2"], "", "Its acceleration."),
    column("quat_<axis>", &[RIG], ONE, "WT", "Attitude of the tool on a stand as a unit quaternion w, x, y, z; without an arm's motion."),
    column("true_<channel>", &[RIG], &["N", "N m"], "C", "Wrench on the cell without its noise, drift, filter and resonance."),
    column("air_<channel>", &[RIG], &["N", "N m"], "B", "Part of the air in it, about the body's origin."),
    column("inertia_<channel>", &[RIG], &["N", "N m"], "B", "Part of the inertia of the robot in it, about the body's origin."),
    column("counts_<channel>", &[BOX], ONE, "C", "Counts as the box sent them."),
    column("low_<channel>", &[AVERAGE, ENVELOPE], &["N", "N m"], "B", "Least over the cycles; of an envelope over the runs, cycle after cycle; in C where `process.steps.body_frame` is off."),
    column("high_<channel>", &[AVERAGE, ENVELOPE], &["N", "N m"], "B", "Most, likewise."),
    column("truth_<channel>", &[AVERAGE], &["N", "N m"], "B", "Average of the wrench without noise, of a simulated run."),
    column("model_<channel>", &[AVERAGE], &["N", "N m"], "B", "Average of the model on the measured motion."),
    column("still_<channel>", &[AVERAGE], &["N", "N m"], "B", "Average in still air that was taken away from the others."),
    column("simulation_<channel>", &[ENVELOPE], &["N", "N m"], "B", "The model on the measured motion of the reference run."),
    column("<channel>", &[RIG, BOX], &["N", "N m"], "C", "Fx, Fy, Fz, Tx, Ty, Tz: what the robot and its mount put on the cell, about the cell's origin."),
    column("<channel>", &[AVERAGE], &["N", "N m"], "B", "Fx, Fy, Fz, Tx, Ty, Tz averaged over the cycles, about the body's origin; in C where `process.steps.body_frame` is off."),
    column("multiplier_re", &[MODES], ONE, "", "Real part of the multiplier: by what the mode grows over a cycle."),
    column("multiplier_im", &[MODES], ONE, "", "Its imaginary part."),
    column("lateral", &[MODES], ONE, "", "1 where left and right differ in the mode, or the orbit turns; 0 in flight in the plane of symmetry."),
    column("growth_per_s", &[MODES], &["1/s"], "", "Rate of growth: ln of the multiplier's size over the cycle's duration."),
    column("frequency_hz", &[MODES], &["Hz"], "", "Frequency of the mode's oscillation, at most half of that of the gait."),
    column("share_<coordinate>", &[MODES], ONE, "", "Share of a coordinate in the mode, the largest 1, in the scales of the orbit: its speed, 1 rad, the crank's rate; 0 for the heading's own mode."),
    column("speed_m_s", &[ORBITS, STARTS], &["m/s"], "", "Mean horizontal speed along the path."),
    column("climb_m_s", &[ORBITS], &["m/s"], "", "Mean climb."),
    column("bank_deg", &[ORBITS], DEG, "", "Bank that the rate of turn asks for, which the mean roll is too; positive right wing down."),
    column("frequency_hz", &[ORBITS, STARTS], &["Hz"], "", "Frequency of the gait."),
    column("power_w_kg", &[ORBITS, STARTS], &["W/kg"], "", "Mean of the positive part of the total power of the driven joints over the mass."),
    column("pitch_mean_deg", &[ORBITS], DEG, "", "Mean pitch, positive nose down."),
    column("stall_fraction_<limit>", &[ORBITS, STARTS], ONE, "", "Share of U^2 c dy dt beyond an angle of attack of 12 or 20 deg."),
    column("least_clearance_m", &[ORBITS, STARTS], M, "", "Least of all clearances over the cycle; of a search with all its numbers of strips."),
    column("largest_multiplier", &[ORBITS, STARTS], ONE, "", "Largest |multiplier| without the heading's; of a search with all its numbers of strips, where a limit asks for it."),
    column("lift_over_weight", &[ORBITS], ONE, "", "Mean upward force of the air over the weight."),
    column("command_<regulator>", &[ORBITS], &["rad", "m", "rad/s", ""], "", "Held command to the actuator."),
    column("start", &[STARTS], ONE, "", "Number of the start, from 0, the robot's own gait."),
    column("ended", &[STARTS], ONE, "", "How it ended: 0 converged, 1 no shorter step gains, 2 iteration limit, 3 no gait beside the last one."),
    column("kept", &[STARTS], ONE, "", "1 where the gait keeps to the limits."),
    column("iterations", &[STARTS], ONE, "", "Steps tried, also those refused."),
    column("violation", &[STARTS], ONE, "", "The worst limit missed, in its scale: 10 mm of clearance, .1 of a share or a multiplier, .025 of the range of a command, the frequency, the power."),
    column("objective", &[STARTS], ONE, "", "What is to be least over that of the robot's own gait; of a payload the mass, negative."),
    column("mass_kg", &[STARTS], &["kg"], "", "Mass of the robot."),
    column("run", &[RUNS], ONE, "", "Number of the run, from 0; of a grid the last draw varies fastest."),
    column("completed", &[RUNS], ONE, "", "1 where the run ended without a fault; else nothing else is said of it."),
    column("mean_lift", &[RUNS], N, "", "Mean of `force_wind_lift` over the last cycle."),
    column("mean_thrust", &[RUNS], N, "", "Mean of `thrust`."),
    column("peak_lift", &[RUNS], N, "", "Most of `force_wind_lift`."),
    column("mean_power", &[RUNS], W, "", "Mean of `power`."),
    column("peak_power", &[RUNS], W, "", "Most of `power`."),
    column("propulsive_efficiency", &[RUNS], ONE, "", "Mean thrust times wind speed over mean power; negative where the wing drags."),
    column("stall_fraction", &[RUNS], ONE, "", "Share of strips past the stall angle."),
    column("periodicity", &[RUNS], ONE, "", "How far the last cycle is from the one before, as in the summary of `tether`."),
    column("run", &[SWEEP], ONE, "", "Number of the flight, from 0; it flies with the sweep's seed plus this number."),
    column("run", &[CANDIDATES], ONE, "", "Number of the candidate, from 0."),
    column("flight_<number>_status", &[CANDIDATES], ONE, "", "Verdict of that flight, as its place in the list of `status` of a sweep; not a number where the scenario refuses the values."),
    column("flight_<number>_<key>", &[CANDIDATES], ONE, "", "The number `key` of the summary of this flight of the candidate; not a number where it was not flown whole or is not resolved."),
    column("ends_apart", &[CANDIDATES], &["m"], "", "Largest distance between the end points (x and y) of its flights."),
    column("cost", &[CANDIDATES], ONE, "", "Sum of the squares of all misses over their `per`, 1e6 or more where a flight broke down or is not resolved; 0 meets all goals."),
    column("status", &[SWEEP, RUNS], ONE, "", "Verdict of the run, as its place in the list ok, not_judged, off_target, outside, suspect_data, not_periodic, not_resolved, not_found, failed, interrupted, from 0."),
    column("warnings", &[SWEEP, RUNS], ONE, "", "Number of warnings that the run itself would print."),
    column("held", &[SWEEP], ONE, "", "1 where the flight was flown whole and is resolved, and the errors stayed within `hold`; on a landing, where it latched and no limit was missed; no number where one record or none is left to judge."),
    column("completed", &[SWEEP], ONE, "", "1 where it was flown whole; else nothing else is said of it."),
    column("clear", &[SWEEP], ONE, "", "1 where it was flown whole and no clearance fell below `hold.clearance_m`, or the robot has none."),
    column("roll_max_error", &[SWEEP], DEG, "", "Largest |roll - reference| from the settling time on."),
    column("pitch_max_error", &[SWEEP], DEG, "", "Largest |pitch - reference| from the settling time on."),
    column("roll_mean", &[SWEEP], DEG, "", "Mean roll from the settling time on, positive right wing down."),
    column("pitch_mean", &[SWEEP], DEG, "", "Mean pitch from the settling time on, positive nose down."),
    column("distance_x", &[SWEEP], M, "", "Way along W's x from start to end."),
    column("distance_y", &[SWEEP], M, "", "Way along W's y from start to end, positive to the left."),
    column("altitude_change", &[SWEEP], M, "", "Altitude at the end less that at the start."),
    column("height_max_error", &[SWEEP], M, "", "Largest |height - reference| from the settling time on, under `[controller.orbit]`."),
    column("cross_rms", &[SWEEP], M, "", "Root mean square of the distance across the path from the settling time on."),
    column("least_clearance", &[SWEEP], M, "", "Least of all clearances over the flight."),
    column("positive_power", &[SWEEP], &["W/kg"], "", "Mean of the positive part of the total power of the driven joints over the mass."),
    column("controller_failures", &[SWEEP], ONE, "", "Updates for which the controller found no plan."),
    column("perch_caught", &[SWEEP], ONE, "", "1 where the claw latched onto `[perch]`, even if a limit was missed."),
    column("perch_clearance", &[SWEEP], M, "", "Least distance of the surfaces and capsules from the perch over the flight."),
    column("<key>", &[SWEEP, RUNS, STARTS, CANDIDATES], &[OWN_UNIT], "", "What was drawn, or found by a search, for a key of the scenario or case, in the unit that ends the key."),
];
