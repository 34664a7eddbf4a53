// What the explorer's scripts compute for one request, from what they define: run by Node, and as text in the browser.
module.exports = ({ SCHEMES, SCENES, march, certified, fractionOf, parametersOf, stabilityAt }, { name, given, Omega, xi, damping_ratio, marches }) => {
    const scheme = SCHEMES[name];
    const { values, ...exact } = parametersOf(scheme, given);
    const found = certified(scheme, fractionOf(damping_ratio), exact);
    return {
        name, values,
        certificate: found.decided ? String(found.stableUpTo) : found.reason,
        only_at_points: found.points === true,
        points: Omega.flatMap((x) => xi.map((damping) => {
            const { radius, damping: numerical, period } = stabilityAt(scheme, values, damping, x / (2 * Math.PI));
            return { matrix: scheme.amplification(x, damping, values), numbers: [radius, numerical, period].map(String) };
        })),
        marches: marches.map(({ scene, parameters, h, n }) => {
            try {
                return march(scheme, values, SCENES[scene], parameters, h, n);
            } catch (error) {
                return { failed: error.message };
            }
        }),
    };
};
