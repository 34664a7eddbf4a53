// What the explorer's scripts compute, as JSON: run by tests/test_explorer.py with the file of the scripts and requests.
const fs = require("fs");
const computed = require("./explorer_computed.js");
const [file, requests, asked] = process.argv.slice(2);
const page = new Function(`${fs.readFileSync(file, "utf8")}; return { SCHEMES, SCENES, march, certified, fractionOf, parametersOf, stabilityAt, stateOf, addressOf, initialState, schemesFound, RATIONAL, fieldOf, squareFree, positiveRoots, nearer, bilinear, sumOf, scaled, productOf, firstLost };`)();
const results = JSON.parse(fs.readFileSync(requests, "utf8")).map((request) => computed(page, request));
// signs in Q(r), r = sqrt(2): of r^2 - 2 where r is given by (x^2 - 2)(x - 3), and of numbers near 0; 3 r by 2 r + r
const root = page.fieldOf([-2n, 0n, 1n], [[1n, 1n], [2n, 1n]]).field;
const given_by_more = page.fieldOf([6n, -2n, -3n, 1n], [[1n, 1n], [2n, 1n]]).field;
const signs = [given_by_more.sign([-2n, 0n, 1n]), root.sign([-665857n, 470832n]), root.sign([-470832n * 2n, 665857n]), root.sign([0n])];
// the field of a rational root, of none and of two in the interval
const fields = [page.fieldOf([-3n, 5n, 2n], [[0n, 1n], [2n, 1n]]), page.fieldOf([-2n, 0n, 1n], [[2n, 1n], [3n, 1n]]), page.fieldOf([2n, -4n, 1n], [[0n, 1n], [4n, 1n]])];
const rational = [fields[0].field === page.RATIONAL, fields[0].r.map(String), fields[1], fields[2]];
// positive roots of (x - r)^2 (x^2 - 3) x (x + 1), lowest power first, each once
const product = [[0n], [-6n], [-6n, 6n], [-1n, 6n], [-1n, -2n], [1n, -2n], [1n]];
const free = page.squareFree(root, product);
const roots = page.positiveRoots(root, free).map((one) => Number(page.nearer(root, free, one).low[0]) / Number(page.nearer(root, free, one).low[1]));
// where stability is lost if h(s) is the product of polynomials in s, whose coefficients are those of polynomials in W
const lost = [
    [[[0, 1], [], [1]], [[1], [2, -1], [1]]], // (s^2 + W)(s^2 + (2 - W) s + 1)
    [[[0, 1], [], [1]], [[1], [1, -2, 1], [1]]], // (s^2 + W)(s^2 + (1 - W)^2 s + 1)
    [[[0, 1], [], [1]], [[9], [1, -2, 1], [1]]], // the same with a 9: two pairs on the circle at W = 1, which do not meet
    [[[0, 1], [], [1]], [[2], [], [1]], [[1], [1]]], // (s^2 + W)(s^2 + 2)(s + 1): a pair is double at W = 2
].map((factors) => {
    const F = page.RATIONAL;
    const exact = factors.map((p) => p.map((q) => q.map((x) => [BigInt(x)])));
    let h = [[[1n]]];
    for (const factor of exact) {
        const product = Array.from({ length: h.length + factor.length - 1 }, () => []);
        h.forEach((p, i) => factor.forEach((q, j) => (product[i + j] = page.sumOf(F, product[i + j], page.productOf(F, p, q)))));
        h = product;
    }
    const n = h.length - 1;
    const c = h.map(() => []); // of lambda, for which s = (lambda - 1)/(lambda + 1)
    h.forEach((p, i) => page.bilinear(n - i, n).forEach((factor, k) => (c[k] = page.sumOf(F, c[k], page.scaled(F, p, [i % 2 ? -factor : factor])))));
    const { low, doubtful } = page.firstLost(F, c);
    const number = (x) => String(x && Number(x[0]) / Number(x[1]));
    return doubtful ? `in doubt at ${number(doubtful.low)}` : number(low);
});
const address = "#a=newmark&a.beta=0.3&b=generalized_alpha&b.rho_inf=0.5&xi=0.05&ratio=0.2&periods=3&scene=elastic_pendulum&quantity=strain&scene.EA=1000000.00000012345678";
const read = page.stateOf(address);
const wrong = page.stateOf("#a=nosuch&a.beta=9&b=newmark&b.beta=-1&xi=-1&ratio=x&scene=nosuch&scene.EA=1&quantity=mood&what=1");
const impossible = ["a=hht_alpha&a.rho_inf=0.25", "b=four_substep&b.gamma=0.41&b.rho_inf=0.5", "b=four_substep&b.gamma=0.39"].map((text) => page.stateOf(`#${text}`).refused);
const found = JSON.parse(fs.readFileSync(asked, "utf8")).map(page.schemesFound);
const found_in = ["19", "no such", "\u2013"].map(page.schemesFound);
console.log(JSON.stringify({ results, found, found_in, signs, rational, roots, lost, again: `#${page.addressOf(read.state)}` === address, refused: read.refused, wrong: wrong.refused, impossible, initial: JSON.stringify(wrong.state.a) === JSON.stringify(page.initialState().a) }));
