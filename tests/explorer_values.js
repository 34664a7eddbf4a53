// What the explorer's scripts compute, as JSON: run by tests/test_explorer.py with the file of the scripts and requests.
const fs = require("fs");
const [file, requests] = process.argv.slice(2);
const page = new Function(`${fs.readFileSync(file, "utf8")}; return { SCHEMES, SCENES, march, certified, fractionOf, parametersOf, stabilityAt, stateOf, addressOf, initialState, failsFrom };`)();
const results = JSON.parse(fs.readFileSync(requests, "utf8")).map(({ name, given, Omega, xi, damping_ratio, marches }) => {
    const scheme = page.SCHEMES[name];
    const { values, fractions } = page.parametersOf(scheme, given);
    const found = page.certified(scheme, page.fractionOf(damping_ratio), fractions);
    return {
        name, values,
        certificate: found.decided ? String(found.stableUpTo) : found.reason,
        points: Omega.flatMap((x) => xi.map((damping) => {
            const { radius, damping: numerical, period } = page.stabilityAt(scheme, values, damping, x / (2 * Math.PI));
            return { matrix: page.SCHEMES[name].amplification(x, damping, values), numbers: [radius, numerical, period].map(String) };
        })),
        marches: marches.map(({ scene, parameters, h, n }) => {
            try {
                return page.march(scheme, values, page.SCENES[scene], parameters, h, n);
            } catch (error) {
                return { failed: error.message };
            }
        }),
    };
});
// where polynomials, lowest power first, begin to be negative, or not positive: (2 - x)^2, (2 - x)^3 (1 + x)^2, -x, 0
const polynomials = [[4n, -4n, 1n], [8n, 4n, -10n, -1n, 4n, -1n], [0n, -1n], []];
const fails = polynomials.map((p) => [false, true].map((strict) => String(page.failsFrom(p, strict))));
const address = "#a=newmark&a.beta=0.3&b=generalized_alpha&b.rho_inf=0.5&xi=0.05&ratio=0.2&periods=3&scene=elastic_pendulum&quantity=strain&scene.EA=1e6";
const read = page.stateOf(address);
const wrong = page.stateOf("#a=nosuch&a.beta=9&b=newmark&b.beta=-1&xi=-1&ratio=x&scene=nosuch&scene.EA=1&quantity=mood&what=1");
console.log(JSON.stringify({ results, fails, again: `#${page.addressOf(read.state)}` === address, refused: read.refused, wrong: wrong.refused, initial: JSON.stringify(wrong.state.a) === JSON.stringify(page.initialState().a) }));
