"use strict";
// Whether a scheme is stable for every Omega > 0, decided exactly, as substep_derive.stability.certificate decides it:
// lambda = (1 + s)/(1 - s) takes the polynomial of the eigenvalues to h(s), whose roots have to lie in Re s <= 0, those on
// the axis simple. Nothing changes between the real roots of a few polynomials in Omega (Orlando), so that Routh's array
// at one fraction settles each interval between them. Numbers and polynomials are those of numbers.js.

const HIGHEST = 8; // degree of a field of numbers in which a certificate still takes less than a blink

// Coefficients of (1 + s)^j (1 - s)^(n - j), lowest power first, as integers.
function bilinear(j, n) {
    let found = [[1n]];
    for (let k = 0; k < n; k++) found = productOf(RATIONAL, found, [[1n], [k < j ? 1n : -1n]]);
    return found.map(([c]) => c);
}

// The determinant of a matrix of polynomials, expanded along its rows, each minor once.
function determinant(F, rows) {
    const known = new Map();
    const minor = (i, columns) => {
        if (i === rows.length) return [[1n]];
        const key = columns.join();
        if (!known.has(key)) {
            const parts = columns.map((j, k) => {
                const part = rows[i][j].length ? productOf(F, rows[i][j], minor(i + 1, columns.filter((other) => other !== j))) : [];
                return k % 2 ? scaled(F, part, [-1n]) : part;
            });
            known.set(key, parts.reduce((sum, part) => sumOf(F, sum, part), []));
        }
        return known.get(key);
    };
    return minor(0, rows.map((_, j) => j));
}

// The upper left part of Hurwitz's matrix of the coefficients h of a polynomial in s.
const hurwitzRows = (h, count, width) => Array.from({ length: count }, (_, i) => Array.from({ length: width }, (_, j) => h[h.length - 2 - 2 * j + i] || []));

// Hurwitz's determinant of an order; 1 for the order 0 and below.
const hurwitz = (F, h, order) => determinant(F, hurwitzRows(h, Math.max(0, order), Math.max(0, order)));

// In s^2, what the even and the odd terms of h share if these are so many pairs of roots +s, -s (a subresultant).
function sharedPairs(F, h, pairs) {
    const order = h.length - 2 - 2 * pairs;
    if (order < 1) return h.filter((_, i) => i % 2 === (h.length - 1) % 2);
    const rows = hurwitzRows(h, order, order + pairs);
    return Array.from({ length: pairs + 1 }, (_, j) => determinant(F, rows.map((row) => [...row.slice(0, order - 1), row[order - 1 + pairs - j]])));
}

// Whether all eigenvalues lie in the unit disk, those on the circle simple, at a fraction of integers: by Routh's array.
// Where a row vanishes, the row before is a factor of h with pairs of roots +s, -s, and its derivative replaces the zeros.
function stableAt(F, h, x) {
    const width = Math.max(...h.map((p) => p.length));
    const values = h.map((p) => F.times(valueAt(F, p, x), [power(x[1], width - Math.max(p.length, 1))]));
    const kept = values.map((_, i) => i).filter((i) => F.sign(values[i]) !== 0);
    const [first, last] = [kept[0], kept[kept.length - 1]];
    const sign = BigInt(F.sign(values[last]));
    const descending = values.slice(first, last + 1).reverse().map((value) => F.times(value, [sign]));
    let [upper, lower] = [0, 1].map((rest) => descending.filter((_, i) => i % 2 === rest));
    let rowsOfZeros = 0;
    for (let degree = descending.length - 1; degree > 0; degree--) {
        if (lower.every((value) => F.sign(value) === 0)) {
            rowsOfZeros += 1;
            lower = upper.slice(0, (degree + 1) >> 1).map((value, j) => F.times(value, [BigInt(degree - 2 * j)]));
        }
        if (F.sign(lower[0]) <= 0) return false;
        const below = upper.slice(1).map((value, j) => plus(F.times(lower[0], value), F.times(F.times(upper[0], lower[j + 1] || [0n]), [-1n])));
        const divisor = greatestDivisor(below.flat()) || 1n;
        [upper, lower] = [lower, below.map((value) => value.map((c) => c / divisor))];
    }
    return Math.max(first, h.length - 1 - last, rowsOfZeros) < 2;
}

// Where stability is first lost, for the coefficients of the polynomial of the eigenvalues, polynomials in a variable that
// grows with Omega: { low, high }, two fractions that enclose it, both 0 if it is lost at once, both null if never;
// points: whether it is lost at single points alone, where 1 or -1 is an eigenvalue twice.
// { doubtful }: the same of a point with two pairs of eigenvalues on the circle, which may be one pair twice: that
// is left to `certify`.
function firstLost(F, c) {
    const n = c.length - 1;
    const h = Array.from({ length: n + 1 }, () => []);
    c.forEach((p, j) => bilinear(j, n).forEach((factor, i) => (h[i] = sumOf(F, h[i], scaled(F, p, [factor])))));
    const kept = h.map((_, i) => i).filter((i) => h[i].length);
    const [first, last] = [kept[0], n - kept[kept.length - 1]]; // eigenvalues 1 and -1 whatever Omega
    const inner = h.slice(first, n + 1 - last);
    const degree = inner.length - 1;
    let pairs = 0; // of roots +s, -s whatever Omega: eigenvalues on the circle, or one inside and one outside
    while (!hurwitz(F, inner, degree - 1 - 2 * pairs).length) pairs += 1;
    const circle = pairs ? sharedPairs(F, inner, pairs).flatMap((p, j) => (j ? [scaled(F, p, [BigInt(2 * j)]), p] : [p])) : [[[1n]]];
    const ofCircle = [circle[0], leading(circle), hurwitz(F, circle, circle.length - 2)];
    const boundaries = [inner[0], inner[degree], hurwitz(F, inner, degree - 1 - 2 * pairs), ...ofCircle];
    const changing = boundaries.filter((p) => p.some((one) => F.sign(one) !== F.sign(leading(p)))).map((p) => squareFree(F, p));
    let all = [[1n]];
    for (const part of changing.filter((p) => positiveRoots(F, p).length))
        all = productOf(F, all, divided(F, part, commonDivisor(F, all, part))[0]);
    const roots = positiveRoots(F, all);
    if (!stableAt(F, h, roots.length ? roots[0][0] : [1n, 1n])) return { low: [0n, 1n], high: [0n, 1n] };
    let lost = { low: null, high: null };
    for (const [low, high] of roots) {
        // whether polynomials vanish together here; whether 1 or -1, whose coefficients in h are `ends`, is an eigenvalue twice
        const vanish = (...polynomials) => {
            const chain = sturm(F, polynomials.reduce((p, q) => commonDivisor(F, p, q), all));
            return variations(F, chain, low) > variations(F, chain, high);
        };
        const twice = (ends, already) => (already ? vanish(ends[0]) : vanish(ends[0], ends[1] || []));
        const ends = !stableAt(F, h, high);
        if (lost.low === null && (ends || twice(inner, first) || twice([...inner].reverse(), last))) lost = nearer(F, all, [low, high]);
        if (lost.low !== null) lost.points = !ends;
        if (ends) return lost;
        // several pairs on the circle: the even and the odd terms of h share a factor of degree two in s^2
        const met = pairs < 2 ? vanish(hurwitz(F, inner, degree - 1), hurwitz(F, inner, degree - 3)) : boundaries.some((p) => vanish(p));
        if (degree > 3 && met) return lost.low === null ? { doubtful: nearer(F, all, [low, high]) } : { ...lost, points: false };
    }
    return lost;
}

// An interval with one root made so narrow that both ends are the same to more digits than a double holds.
function nearer(F, p, interval) {
    let [low, high] = interval;
    const side = signAt(F, p, low);
    while (power(2n, 60) * (high[0] * low[1] - low[0] * high[1]) > high[0] * low[1]) {
        const [left, right] = halves(F, p, [low, high]);
        [low, high] = signAt(F, p, left[1]) === side ? right : left;
    }
    return { low, high };
}

// { decided, stableUpTo, points, reason } at exact values: a fraction of xi, and those of the constant and of the parameters of the
// scheme in their order with their field, as parametersOf gives them. stableUpTo: Infinity where stable for every
// Omega > 0, else the Omega at which stability is first lost, and `points` as firstLost has it. reason: why it is not decided.
function certified(scheme, xi, { field, fractions }) {
    const undecided = (reason) => ({ decided: false, reason });
    if (fractions.some((x) => x === null)) return undecided("its numbers are not all in the field of one root");
    if (field.degree > HIGHEST) return undecided(`its numbers are of degree ${field.degree}, which takes seconds`);
    let c = exactCoefficients(field, scheme.exact, [xi.map((x) => [x]), ...fractions]);
    while (!c[0].length) c = c.slice(1);
    const square = c.every((p) => p.every((value, k) => k % 2 === 0 || field.sign(value) === 0));
    if (square) c = c.map((p) => p.filter((_, k) => k % 2 === 0));
    const { low, doubtful, points } = firstLost(field, c);
    const number = ([top, bottom]) => (square ? Math.sqrt(Number(top) / Number(bottom)) : Number(top) / Number(bottom));
    if (doubtful) return undecided(`two pairs of eigenvalues may meet on the unit circle at Ω = ${number(doubtful.low)}`);
    return { decided: true, stableUpTo: low === null ? Infinity : number(low), points: points === true };
}

// Polynomials in Omega with a common factor taken out, from terms in Omega, xi, the constant and the parameters.
function exactCoefficients(F, rows, fractions) {
    const degrees = fractions.map((_, k) => Math.max(0, ...rows.flat().map((term) => term[k + 2])));
    return rows.map((row) => {
        const found = [];
        for (const [coefficient, inOmega, ...powers] of row) {
            let value = [coefficient];
            powers.forEach((e, k) => {
                const [top, bottom] = fractions[k];
                value = F.times(value, F.times(raised(F, top, e), raised(F, bottom, degrees[k] - e)));
            });
            while (found.length <= inOmega) found.push([0n]);
            found[inOmega] = plus(found[inOmega], value);
        }
        return trimmed(F, found);
    });
}
