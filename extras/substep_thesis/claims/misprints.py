"""Formulas as the thesis prints them: a claim's text is the printed formula, "false" that derivation refutes it."""

from .judgement import Claim

CLAIMS = (
    Claim(
        "M2.2",
        "The remainder of the central difference of u' is h^2/3 times the third derivative.",
        "substep claims",
    ),
    Claim(
        "M2.9",
        "The last stage of RK4 is taken at t + h/2.",
        "substep claims",
    ),
    Claim(
        "M2.20",
        "Wilson's relations hold u_(n+theta) + u_n and 6/theta v_n.",
        "substep claims",
    ),
    Claim(
        "M2.23",
        "HHT's balance holds - K u_n, and the load at t_(n+alpha).",
        "substep claims",
    ),
    Claim(
        "M2.26",
        "HHT with alpha = 0 has beta = 1/2.",
        "substep show hht_alpha --part relations",
    ),
    Claim(
        "M2.54",
        "Gholampour's velocity holds delta h^3/6 times the second difference quotient of a.",
        "substep claims",
    ),
    Claim(
        "Mp15",
        "The second sub-step ends at t_(n+1) = t_n + (1 - gamma_t) h.",
        "substep show silva_bezerra --part relations",
    ),
    Claim(
        "M3.9",
        "Effective stiffness and residual (3.7)-(3.9), (3.19)-(3.21) hold no damping.",
        "substep show newmark_bdf2 --part stiffness",
    ),
)
