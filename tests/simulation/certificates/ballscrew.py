"""The setting of the tests: a ball screw of 5 mm lead, with every friction model on it that has pre-sliding."""

from bristle import friction

UM = 2e-6 * 3.141592653589793 / 5e-3  # [rad] that move the table by a micrometre
F_C, F_S, V_S, STIFFNESS = 0.100, 0.130, 0.3, 100.0  # [N*m], [N*m], [rad/s], [N*m/rad]
F_P = 1.2 * F_S
RIPPLE = (0.040, 0.080)

SLIDING = {"kind": "rotational", "F_C": F_C, "F_S": F_S, "v_S": V_S}
DAMPING = {"sigma_1": 0.1, "sigma_2": 2e-3}


def lugre(**values):
    return friction.lugre(**(SLIDING | DAMPING | {"sigma_0": STIFFNESS} | values))


def composite(transition="elastoplastic", *, validate=True, **values):
    chosen = SLIDING | DAMPING | {"s": STIFFNESS, "f_p": F_P, "transition": transition} | values
    return friction.preisach_lugre(**chosen, validate=validate)


def maxwell_slip():
    return friction.maxwell_slip(
        kind="rotational",
        F_C=F_S,
        k_i=[20.0, 30.0, 30.0, 20.0],
        nu_i=[0.1, 0.2, 0.3, 0.4],
        sigma_2=2e-3,
    )


def gms():
    return friction.gms(
        **SLIDING, C=10.0, k_i=[20.0, 30.0, 30.0, 20.0], nu_i=[0.1, 0.2, 0.3, 0.4], sigma_2=2e-3
    )
