"""Methods that papers, books and manuals name and the catalogue does not have, each with one sentence that says why.

The table "Named elsewhere, and not declared" of docs/findings.md holds the same sentences.
"""

from collections.abc import Mapping
from types import MappingProxyType

_TABLE = "it is a Runge-Kutta table: substep_derive.tableau declares it in a line, as docs/adding_a_scheme.md shows"
_EXPONENTIAL = (
    "its coefficients are exponentials or trigonometric functions of the structure's matrices, where a scheme's are "
    "rational in the step"
)
_UNREAD = "its formulas were found in no open text and no program"
WHY: Mapping[str, str] = {
    "discontinuous_galerkin_p2_p1 tdg_p2_p1 p2_p1": (
        "A-stable and of third order, it does not damp high frequencies, as discontinuous_galerkin_p1 does, and with "
        "Radau's sums for its integrals it is radau_iia2 on linear structures; a declaration of your own takes it"
    ),
    "fung complex_time_step": (
        "of order 2n - 1 with n unknowns and the spectral radius mu at infinity, of order 2n at mu = 1: with two its "
        "spectrum is that of weighted_residual_p2 at rho_inf = mu, with three that of radau_iia3 at mu = 0 and of "
        "gauss3 at mu = 1; how it takes loads was not read"
    ),
    "differential_quadrature": (
        "with Gauss's instants it is gauss2 or gauss3, with Radau's radau_iia2 or radau_iia3; substep_derive.tableau "
        "declares others"
    ),
    "mssth mssth2 mssth_2": "with two sub-steps it is rho_inf_bathe; those of more are mssth3 to mssth5",
    "mssth3 mssth_3": (
        "its spectrum is that of three_substep_third_order, of the same order with the same number of solves"
    ),
    "mssth4 mssth_4": (
        "its spectrum is that of four_substep, which keeps the fourth order with loads and damping, where it "
        "has the third"
    ),
    "mssth5 mssth_5": "its order is 5 in free linear motion alone, else 3; a declaration of your own takes it",
    "wat2 wang_adams_tamma": (
        "at its default, without damping, it is kim_two_stage, where no estimate sees the error of u; a "
        "declaration of your own takes it"
    ),
    "nystrom nystrom4": (
        "substep_derive.nystrom declares his table of fourth order; where a force sets in suddenly, steps by tol= "
        "miss it by more than those of the catalogue's schemes"
    ),
    "explicit_hht hht_explicit miranda_ferencz_hughes": (
        "it is of first order with damping, whose force it takes at a predicted velocity, with the old force where the "
        "step begins or at its own predictor, and its estimate of the local error is not exact without; a declaration "
        "of your own takes both"
    ),
    "pefrl omelyan": (
        "a declaration of your own takes it, of fourth order, symmetric and symplectic; its estimate of the "
        "local error falls by another power of the step than steps by tol= count on"
    ),
    "edmc armero_romero energy_decaying edmc1 edmc2": (
        "its dissipation takes norms of the velocities, so that it has no amplification matrix; without "
        "dissipation it is energy_momentum"
    ),
    "bottasso_borri bauchau_theron ed_alpha": (
        "its formulas were found in no open text; if its linear form is of third order with two unknowns, as "
        "Galerkin's discontinuous in time is, its spectrum is that of discontinuous_galerkin_p1, or of "
        "weighted_residual_p2 where it has a rho_inf"
    ),
    "soares adaptive_alpha": (
        "its parameter is chosen anew by element and step from the motion, where a scheme's are fixed"
    ),
    "higher_order_generalized_alpha behnoudfar deng_calo": (
        "its further unknowns are terms of Taylor's series from the differentiated equation of motion, which "
        "a balance does not take (arXiv 1902.05253, 1906.06081)"
    ),
    "li_yu sesdirk s_sub_step": (
        "on linear systems its members of three and four sub-steps are three_substep_third_order and "
        "four_substep; the paper's times of sub-steps were not read (arXiv 2209.13820)"
    ),
    (
        "zhou_zhou liang sinusoidal_acceleration bazzi_anderheggen rho_method hoff_pahl theta_1 sse csse "
        "ustedm cq_2x kim_lee argyris_mlejnek rezaiee_pajand trujillo gellert"
    ): _UNREAD,
    "n_ihoa ihoa alamatian": (
        "the weights of its least errors were not found; those of interpolation through the last "
        "accelerations are adams_moulton3 and adams_moulton4"
    ),
    "dong": "its form holds park and bdf3; the parameters that the paper chooses were not found",
    "sdm sdm1 sdm2 tang_lou rst tang_qin": (
        "it depends on the structure, as chang and chen_ricles do; its formulas were not read"
    ),
    "kim_2019 kim_fourth_order": "its tables were not read; of its kind is kim_two_stage",
    "crank_nicolson_leapfrog cnlf": (
        "with damping as its Crank-Nicolson part it is two interleaved motions, each of central_difference "
        "with twice its step"
    ),
    "position_verlet drift_kick_drift": "it is central_difference seen from the middle of its steps",
    "beta_m katona_zienkiewicz sspj": (
        "with m = 2 it is newmark at beta = beta_0/2 and gamma = beta_1; others differentiate the equation of "
        "motion, which a balance does not take"
    ),
    "ginssss gssss_family": "its members are gssss_u0 and gssss_v0",
    "lobatto_iiib lobatto_iiia_iiib": (
        "with two stages the pair with Lobatto IIIA is central_difference; with three, substep_derive.nystrom "
        "declares it"
    ),
    "adams_bashforth adams_bashforth_moulton abm ab2 shampine_gordon": (
        "it is for first-order equations, u and v apart; a declaration of your own takes it with fixed steps, "
        "as bdf2 is one"
    ),
    "heun ralston kutta_3_8 fehlberg rkf45 cash_karp tsit5 verner kvaerno cash rosenbrock_wanner": _TABLE,
    "rosenbrock ros2 ode23s rosenbrock23": (
        "of second order, with the Jacobian of the start, it is lsrt2; with that of each step it would take "
        "the tangent stiffness where a scheme takes forces"
    ),
    (
        "precise_integration pim duhamel piecewise_exact nigam_jennings state_space exponential gautschi "
        "deuflhard etd magnus"
    ): _EXPONENTIAL,
    "mclachlan blanes_moan": "it is a composition: substep_derive.composition declares it from its weights",
    "dynamic_relaxation": "it is central_difference with damping that is chosen from the motion, a way to rest",
    "lax_wendroff taylor_galerkin": (
        "it is for equations of the first order in space and time, which M, C and K are not"
    ),
}
"""Names, in small letters with words joined by _ -> why the catalogue does not have the method, in one sentence."""

ELSEWHERE: Mapping[str, str] = MappingProxyType({name: why for names, why in WHY.items() for name in names.split()})
"""The same by each name."""
