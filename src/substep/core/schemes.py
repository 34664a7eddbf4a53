"""Schemes: the names of the catalogue, and handles whose parameters are checked once.

The description of a scheme comes from the generated index; its compiled module, and with it numba, is imported on
first use.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal

from numpy.typing import ArrayLike

from ..derived import modules
from . import coefficients as march_coefficients
from . import stability as stability_functions
from .arrays import Array, Values, by_value
from .entries import SchemeInfo
from .error_estimate import LocalError, local_error
from .errors import called_as, warn
from .facts import Facts, Term, facts_at, facts_at_defaults, other_sign_meant, rho_inf_forms
from .scheme_names import SCHEMES, found, named
from .scheme_parameters import completed
from .scheme_record import SchemeRecord

if TYPE_CHECKING:
    from ..derived.modules import Declaration

Kind = Literal["explicit", "one solve a step", "several steps", "sub-steps"]


@called_as('schemes(order=4, A_stable=True, search="gauss")')
def schemes(
    *,
    order: int | None = None,
    solves: int | None = None,
    A_stable: bool | None = None,
    L_stable: bool | None = None,
    explicit: bool | None = None,
    search: str = "",
) -> tuple[str, ...]:
    """Names of all schemes, members of families included, or of those that are as asked at their defaults.

    order: of u and v, the lower of the two. solves: balances of a step. explicit: whether no step needs the force's
    tangent. search: a text in the name, a synonym or the reference, in small or capital letters. Raises ValueError for
    an order or a number of solves that is not whole, and for anything but True or False where one is asked for.

    >>> ss.schemes()[:3]
    ('forward_euler', 'central_difference_lagged', 'rk2')
    >>> ss.schemes(order=4, A_stable=True, solves=2)
    ('gauss2', 'lobatto_iiia3')
    >>> ss.schemes(explicit=True, search="Bathe")
    ('noh_bathe',)
    """
    asked = {"order": order, "solves": solves, "A_stable": A_stable, "L_stable": L_stable, "explicit": explicit}
    given = {name: x for name, x in asked.items() if x is not None}
    for name, x in given.items():
        if type(x) is not (int if name in ("order", "solves") else bool):
            text = "a whole number" if name in ("order", "solves") else "True or False"
            raise ValueError(f"expected {name} as {text}, got {x!r}; give one, or leave it out")

    def is_asked(s: Scheme) -> bool:
        has = min((s.order or (0,))[:2]), s.balances, s.A_stable, s.L_stable, s.kind == "explicit"
        return given.items() <= dict(zip(asked, has, strict=True)).items()

    names = [name for name in SCHEMES if not search or found(name, search)]
    return tuple(name for name in names if not given or is_asked(scheme(name)))


@called_as('scheme("newmark", beta=0.25, gamma=0.5)')
def scheme(name: str | Scheme | Declaration, **parameters: ArrayLike) -> Scheme:
    """A handle of the scheme; parameters not given take the default of the declaration.

    name: of the catalogue, or a declaration of your own (`substep_derive.Scheme`), which is derived and
    compiled on first use and kept in the user's cache; a handle stands for itself. A family's argument (`rho_inf` of
    generalized-alpha, ...) stands for the parameters it sets. Parameters may be arrays, and then
    broadcast with Omega and xi. Raises ValueError for an unknown scheme or parameter, for one that a
    family also sets, and for a value that is not finite or lies outside the declared interval. A parameter that another
    given one decides, such as rho_inf where gamma alone makes the step, takes the value that follows from it, which has
    to lie in its interval too.

    >>> s = ss.scheme("generalized_alpha", rho_inf=0.5)
    >>> {name: round(float(x), 3) for name, x in s.parameters.items()}
    {'alpha_m': 0.0, 'alpha_f': 0.333, 'beta': 0.444, 'gamma': 0.833}
    >>> s.order, s.rho_inf
    ((2, 2, 1), 0.5)
    """
    if isinstance(name, Scheme):
        if parameters:
            raise ValueError(f"expected a name with parameters, got {name}; write scheme('{name.name}', ...)")
        return name
    info = scheme_info(name)
    complete, given = completed(info, parameters)
    if said := other_sign_meant(info, given):
        warn(said)
    return Scheme(info, MappingProxyType(complete), MappingProxyType(given))


def scheme_info(name: str | Declaration) -> SchemeInfo:
    """Description of a scheme of the catalogue, or of the user's own, which is derived if it is not in the cache.

    Raises ValueError for an unknown name, DeclarationError for a declaration that does not define one step.
    """
    if isinstance(name, str):
        first, colon, given = name.partition(":")
        if colon and first in SCHEMES:
            raise ValueError(f"expected a scheme's name, got '{name}'; write scheme('{first}', {given}) in Python")
        return _in_catalogue(named(name))
    if not hasattr(name, "takes_damping"):
        raise ValueError(
            f"expected a scheme by name, handle or declaration, got {name!r}; substep.schemes() lists the names"
        )
    module = modules.scheme_module(name)
    return SchemeInfo.of(name.name, module.ENTRY, module, name)


@cache
def _in_catalogue(name: str) -> SchemeInfo:
    return SchemeInfo.of(name, SCHEMES[name])


@dataclass(frozen=True, eq=False, repr=False)
class Scheme(SchemeRecord):
    """A time integration scheme with its parameters; make one with `substep.scheme`.

    All stability functions take Omega = omega*h >= 0 and the damping ratio xi >= 0, which broadcast
    with each other and with the parameters. Two are equal if they are the same scheme with the same parameters,
    arrays by shape and value; a scheme of the user's own is the same if everything declared about it is.
    """

    @property
    def state(self) -> tuple[str, ...]:
        """What the scheme carries from step to step, in the order of the amplification matrix."""
        return self.info.state

    @property
    def history(self) -> tuple[tuple[int, int], ...]:
        """Of each entry of the state: 0 for u, 1 for h*v, 2 for h^2*a, and how many steps before t_n it stands."""
        return self.info.history

    @property
    def reference(self) -> str:
        """Where the scheme was published."""
        return self.info.reference

    @property
    def balances(self) -> int:
        """How many balances (implicit solves or force evaluations) a step has."""
        return self.info.balances

    @property
    def kind(self) -> Kind | None:
        """Of its step: "explicit" where it needs no tangent of the force, else how often, or from how many steps back.

        None at other parameters than the defaults.
        """
        if (iterated := self.facts.iterated) is None:
            return None
        if iterated != 1:
            return "sub-steps" if iterated else "explicit"
        return "several steps" if any(lag for _, lag in self.history) else "one solve a step"

    @cached_property
    def facts(self) -> Facts:
        """What derivation has found about the scheme at its parameters, None for what is not known without SymPy."""
        if self.info.declaration is not None:
            return Facts()
        at_defaults = self._values == scheme(self.name)._values
        return facts_at_defaults(self.name) if at_defaults else facts_at(self.info, self.parameters)

    @property
    def order(self) -> tuple[int, int, int] | None:
        """Order of accuracy of u, v and a, free and forced, damped or not; None if not known: `substep_derive.derive`.

        At other parameters than the defaults it is at least that. This and all facts below are None for a scheme of
        your own, which `derive` and `certify` decide.
        """
        return self.facts.order

    @property
    def rho_inf(self) -> float | Array | None:
        """Spectral radius as Omega -> oo, undamped; inf for an explicit scheme; None if not known.

        NaN where the closed form in generated/ does not hold at these parameters; `rho_inf_forms` has it as text.
        """
        return self.facts.rho_inf

    @property
    def rho_inf_forms(self) -> tuple[str, str]:
        """rho_inf in the parameters, undamped, as text and in LaTeX.

        Empty where it has no closed form, for a scheme without parameters, whose `rho_inf` is a number, and for one of
        your own: `substep_derive.derive(...).rho_inf`.
        """
        return rho_inf_forms(self.info)

    @property
    def critical_Omega(self) -> float | None:
        """The Omega up to which the scheme is stable, undamped; inf where it is for every Omega, 0 where for none.

        None where it is not known without SymPy, which is not to say that there is no limit: so it is where the scheme
        is not stable throughout, at parameters which are neither the defaults nor those of a member such as
        linear_acceleration. `substep_derive.certify`, and `substep show newmark:gamma=2/5`, give it.

        >>> print(f"{ss.scheme('newmark', beta=1 / 6, gamma=0.5).critical_Omega:.3f}")  # linear acceleration
        3.464
        """
        return self.facts.critical_Omega

    @property
    def A_stable(self) -> bool | None:
        """Whether it is stable for every Omega and damping ratio; None if not known: `substep_derive.certify`.

        The handle says so where parameters that were given take it away from a scheme which has it by default.

        >>> ss.scheme("newmark", gamma=0.4)  # below 1/2, numerical damping is negative
        Scheme(newmark, beta=0.25, gamma=0.4, not A-stable)
        """
        return self.facts.A_stable

    @property
    def L_stable(self) -> bool | None:
        """Whether it is A-stable with rho_inf = 0; None if not known: `substep_derive.certify`."""
        return self.facts.L_stable

    @property
    def overshoot(self) -> str | None:
        """Such as U0-V1: powers of Omega with which u and v/omega grow in the first step.

        None at other parameters than the defaults, where `substep show newmark:gamma=3/5` derives it.
        """
        return self.facts.overshoot

    @property
    def first_errors(self) -> tuple[Term | None, Term | None]:
        """First terms of numerical damping and period error, undamped, as (power of Omega, coefficient) each.

        None at other parameters than the defaults, where `substep_derive.derive(...).series` has them.
        """
        return self.facts.damping, self.facts.period

    @cached_property
    def starter(self) -> Scheme | None:
        """The scheme that marches the first steps; None for one that starts by itself."""
        if self.info.starter is None:
            return None
        name, parameters = self.info.starter
        declared: Any = self.info.declaration  # a starter without a name is declared with the scheme
        return scheme(name, **parameters) if name else scheme(declared.start_scheme)

    @cached_property
    def starting_steps(self) -> int:
        """How many steps the starter marches before the scheme itself goes on; 0 for one that starts by itself."""
        return 0 if self.starter is None else max(lag for _, lag in self.history)

    def local_error(self, damped: bool) -> LocalError:
        """How a step with these numbers for parameters estimates its local error; damped: on a scene with damping.

        Raises ValueError if it cannot.
        """
        return local_error(self, tuple(sorted(self.given)), damped)

    def lane(self, j: int) -> Scheme:
        """The scheme with the parameters of lane j, where they are arrays (P,); itself where none are."""
        if not any(x.ndim for x in self.parameters.values()):
            return self
        parameters, given = ({k: x[j] if x.ndim else x for k, x in d.items()} for d in (self.parameters, self.given))
        return replace(self, parameters=parameters, given=given)

    def amplification(self, Omega: ArrayLike, xi: ArrayLike = 0.0) -> Array:
        """Amplification matrix, (..., m, m), of the undriven oscillator, in the order of `state`."""
        return stability_functions.amplification(self, Omega, xi)

    def spectral_radius(self, Omega: ArrayLike, xi: ArrayLike = 0.0, *, out: Any = None) -> Array:
        """Largest modulus of the eigenvalues of the amplification matrix (thesis (4.17)).

        out: of arrays on a GPU, the array there that the radii are stored in.
        """
        return stability_functions.spectral_radius(self, Omega, xi, out)

    def stability(self, Omega: ArrayLike, xi: ArrayLike = 0.0) -> tuple[Array, Array, Array]:
        """Spectral radius, numerical damping and period error in one pass, equal to the methods of these names.

        Raises ValueError where one of them does.

        >>> radius, damping, period = ss.scheme("bathe").stability(2 * np.pi / 20)  # twenty steps a period
        >>> print(f"{radius:.6f} {damping:.6f} {period:.6f}")
        0.999967 0.000106 0.004095
        """
        return stability_functions.radius_damping_period(self, Omega, xi)

    def numerical_damping(self, Omega: ArrayLike, xi: ArrayLike = 0.0) -> Array:
        """-ln|lambda_1|/phi - xi/sqrt(1 - xi^2), the damping ratio the scheme adds (thesis (4.3)).

        lambda_1 is the complex pair of largest modulus, phi its argument. NaN where all eigenvalues
        are real or xi >= 1; 0, its limit, at Omega = 0. Raises ValueError at an Omega so large that rounding
        hides whether a pair is complex.
        """
        return self.stability(Omega, xi)[1]

    def amplitude_error(self, Omega: ArrayLike, xi: ArrayLike = 0.0) -> Array:
        """1 - exp(-2 pi numerical_damping) (thesis (4.4)); NaN or refused where numerical_damping is."""
        return stability_functions.amplitude_error(self.numerical_damping(Omega, xi))

    def period_error(self, Omega: ArrayLike, xi: ArrayLike = 0.0) -> Array:
        """Omega*sqrt(1 - xi^2)/phi - 1 (thesis (4.6)); NaN or refused where numerical_damping is, 0 at Omega = 0."""
        return self.stability(Omega, xi)[2]

    def power_norm(self, Omega: ArrayLike, xi: ArrayLike = 0.0, n: int = 1000) -> Array:
        """The largest of ||A||, ||A^2||, ..., ||A^n|| in the energy norm of (omega*u, v, a/omega), n >= 1.

        Bounded in n for a stable scheme; it grows with n where an eigenvalue on the circle is multiple; inf where a
        power overflows. Raises ValueError for Omega = 0, where the energy does not depend on u.
        """
        return stability_functions.power_norm(self, Omega, xi, n)

    def stencil(self) -> Array:
        """Instants at which a step takes the load, in steps after t_n: (..., K), read-only."""
        return self._stencil

    @cached_property
    def loaded_within(self) -> bool:
        """Whether a step takes the load only at instants within it, at all values of the parameters."""
        return march_coefficients.loaded_within(self._stencil)

    @cached_property
    def _stencil(self) -> Array:
        return march_coefficients.stencil(self)

    def coefficients(self, Omega: ArrayLike, xi: ArrayLike = 0.0) -> tuple[Array, Array, Array, Array]:
        """D (n, m, m), B (n, m, K), O (n, R, m), P (n, R, K) of x1 = x0 + D x0 + B h^2 f and y1 = O x0 + P h^2 f.

        x are the entries of the state that the linear march carries, y those of u, h*v, h^2*a that are not among them,
        f the loads at the stencil's instants; see `substep.core.coefficients`. D is rounded once.
        """
        return march_coefficients.coefficients(self, Omega, xi)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Scheme) and (self.info, self._values) == (other.info, other._values)

    def __hash__(self) -> int:
        return hash((self.info, self._values))

    @cached_property
    def _values(self) -> Values:
        return by_value(self.parameters)

    def __reduce__(self) -> tuple[Any, ...]:
        return partial(scheme, self.info.source, **self.given), ()

    def __repr__(self) -> str:
        values = [f"{name}={_written(value)}" for name, value in self.parameters.items()]
        lost = self.A_stable is False and facts_at_defaults(self.name).A_stable
        return f"Scheme({', '.join([self.name, *values, *['not A-stable'] * bool(lost)])})"


def _written(value: Array) -> str:
    few = value.size <= 4
    return str(value.tolist()) if few else f"{value.shape} from {value.min():.6g} to {value.max():.6g}"
