"""Times of PteraSoftware's vortex lattice with prescribed and with free wake on the flapping wing of cases/flap_f2.toml.

Prints `name<TAB>seconds`, of processor time per simulated second. Compiling is left out by a
short run before each.
"""

import time

import pterasoftware as ps

FREQUENCY = 3.5
STEPS_PER_CYCLE = 48
CYCLES = 3


def half(mirrored):
    """One half of the wing: 4 x 10 panels, semi-span 0.2 m, chord 0.08 m."""

    def section(panels, span):
        return ps.geometry.wing_cross_section.WingCrossSection(
            airfoil=ps.geometry.airfoil.Airfoil(name="naca0012"),
            num_spanwise_panels=panels,
            chord=0.08,
            Lp_Wcsp_Lpp=(0.0, span, 0.0),
            spanwise_spacing="uniform" if panels else None,
        )

    # The plane lies a micrometre off the root: a wing must not leave a plane that it starts in.
    plane = {"symmetryNormal_G": (0.0, 1.0, 0.0), "symmetryPoint_G_Cg": (0.0, -1e-6, 0.0)} if mirrored else {}
    return ps.geometry.wing.Wing(
        wing_cross_sections=[section(10, 0.0), section(None, 0.2)],
        mirror_only=mirrored,
        num_chordwise_panels=4,
        chordwise_spacing="uniform",
        **plane,
    )


def flapping(wing):
    """35 deg about the body x axis."""
    sections = [
        ps.movements.wing_cross_section_movement.WingCrossSectionMovement(base_wing_cross_section=section)
        for section in wing.wing_cross_sections
    ]
    return ps.movements.wing_movement.WingMovement(
        base_wing=wing,
        wing_cross_section_movements=sections,
        ampAngles_Gs_to_Wn_ixyz=(35.0, 0.0, 0.0),
        periodAngles_Gs_to_Wn_ixyz=(1.0 / FREQUENCY, 0.0, 0.0),
    )


def run(steps, prescribed):
    airplane = ps.geometry.airplane.Airplane(wings=[half(False), half(True)])
    moving = ps.movements.airplane_movement.AirplaneMovement(
        base_airplane=airplane, wing_movements=[flapping(wing) for wing in airplane.wings]
    )
    wind = ps.operating_point.OperatingPoint(rho=1.225, vCg__E=1.5, alpha=5.0, nu=1.506e-5)
    movement = ps.movements.movement.Movement(
        airplane_movements=[moving],
        operating_point_movement=ps.movements.operating_point_movement.OperatingPointMovement(wind),
        delta_time=1.0 / (FREQUENCY * STEPS_PER_CYCLE),
        num_steps=steps,
    )
    problem = ps.problems.UnsteadyProblem(movement=movement)
    solver = ps.unsteady_ring_vortex_lattice_method.UnsteadyRingVortexLatticeMethodSolver(problem)
    start = time.process_time()
    solver.run(prescribed_wake=prescribed, calculate_streamlines=False, show_progress=False)
    return time.process_time() - start


simulated = CYCLES / FREQUENCY
for name, prescribed in [("flap_f2", True), ("flap_f2_free", False)]:
    run(3, prescribed)
    print(f"{name}\t{run(CYCLES * STEPS_PER_CYCLE, prescribed) / simulated}")
