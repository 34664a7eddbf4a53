"""Published numbers, copied with their sources; tests compare against them."""

# Forets, Freire Caporale & Perez Zerpa, Comput. Struct. 259 (2022) 106699, accuracy figure (theory)
RATIOS = (0.01, 0.05, 0.1, 0.15, 0.2)  # dt/T
PERIOD_ERROR_PERCENT = {
    "average_acceleration": (0.03289003, 0.81712426, 3.20749106, 7.00851389, 12.0033086),
    "bathe": (0.01644655, 0.40950157, 1.61793744, 3.56996879, 6.1870455),
}
AMPLITUDE_ERROR_PERCENT = {"bathe": (0.00054088, 0.06675348, 0.51306297, 1.62171475, 3.52024317)}

# spradius (Python package), committed baseline: Newmark (.3025, .6) at dt/T = logspace(-3, 3, 10)
SPRADIUS_NEWMARK = (
    *(0.99999803, 0.99995748, 0.99908842, 0.98220834, 0.8728952),
    *(0.82175398, 0.81835082, 0.81818967, 0.81818218, 0.81818184),
)

# Chopra, Dynamics of Structures: m = 0.2533, k = 10, xi = 0.05, p = 10 sin(pi t/0.6) for t <= 0.6, dt = 0.1
CHOPRA = {
    # Example 5.3, average acceleration: (beta, gamma), u at 0.1, 0.2, ...
    "5.3": ((1 / 4, 1 / 2), (0.0437, 0.2326, 0.6121, 1.0825, 1.4309, 1.4231, 0.9622, 0.1908, -0.6044, -1.1442)),
    # Example 5.4, linear acceleration
    "5.4": ((1 / 6, 1 / 2), (0.03, 0.2193, 0.6166, 1.113, 1.4782, 1.4625, 0.9514, 0.1273, -0.6954, -1.2208)),
}

# Exudyn's documentation, implicit trapezoidal-rule based solvers: 1 - rho of generalized-alpha at dt/T = 0.01
GENERALIZED_ALPHA_LOSS = {0.9: 1.13e-09, 0.6: 1.22e-07}
