"use strict";
// Exact arithmetic for the certificate: numbers of a field Q(r), r a real root of a polynomial with integer coefficients,
// and polynomials whose coefficients are such numbers. Nothing is rounded.
// An integer is a BigInt; a number of a field is the array of the integer coefficients of 1, r, r^2, ...; a polynomial is
// an array of numbers, lowest power first; a fraction is [numerator, denominator], of integers or of numbers of a field,
// the denominator positive.

const power = (x, n) => x ** BigInt(n);
const absolute = (x) => (x < 0n ? -x : x);
const signOf = (x) => (x > 0n ? 1 : x < 0n ? -1 : 0);

function greatestDivisor(integers) {
    let found = 0n;
    for (const c of integers) for (let [a, b] = [absolute(c), found]; ; [a, b] = [b, a % b]) if (b === 0n) { found = a; break; }
    return found;
}

// A decimal such as "0.3025" or "1e-3" as a fraction of integers.
function fractionOf(text) {
    const [, sign, whole, digits = "", exponent = "0"] = /^(-?)(\d*)\.?(\d*)(?:e([-+]?\d+))?$/i.exec(text.trim());
    const shift = Number(exponent) - digits.length;
    const number = BigInt(sign + (whole || "0") + digits);
    return shift >= 0 ? [number * power(10n, shift), 1n] : [number, power(10n, -shift)];
}

const plus = (a, b) => Array.from({ length: Math.max(a.length, b.length) }, (_, i) => (a[i] || 0n) + (b[i] || 0n));

// The rational numbers, as a field whose numbers are arrays of one integer. degree: of the polynomial of r.
// cofactor(a): a number whose product with a is an integer other than 0; null where none is found.
const RATIONAL = { degree: 1, times: (a, b) => [a[0] * b[0]], sign: (a) => signOf(a[0]), cofactor: (a) => [1n] };

// { field, r }: the field of the only root of a polynomial, an array of integers, in an interval of two fractions, and
// the root itself as a fraction; null where the interval holds no root or several. lead*r is a root of a polynomial whose
// first coefficient is 1, so that products of its powers stay integers.
function fieldOf(polynomial, [low, high]) {
    if (polynomial[polynomial.length - 1] < 0n) polynomial = polynomial.map((c) => -c);
    const degree = polynomial.length - 1;
    const lead = polynomial[degree];
    const monic = polynomial.map((c, k) => (k === degree ? 1n : c * power(lead, degree - 1 - k)));
    const chain = sturm(RATIONAL, monic.map((c) => [c]));
    const between = (a, b) => variations(RATIONAL, chain, a) - variations(RATIONAL, chain, b);
    let shared = low[1] * high[1];
    let [bottom, top] = [lead * low[0] * high[1], lead * high[0] * low[1]]; // bottom/shared and top/shared enclose it
    if (signAt(RATIONAL, monic.map((c) => [c]), [bottom, shared]) === 0) bottom -= 1n; // a closed interval's end
    if (between([bottom, shared], [top, shared]) !== 1) return null;
    const refine = (times) => {
        for (let k = 0; k < times; k++) {
            [bottom, top, shared] = [2n * bottom, 2n * top, 2n * shared];
            const middle = (bottom + top) / 2n;
            if (between([bottom, shared], [middle, shared]) === 1) top = middle;
            else bottom = middle;
        }
    };
    while (top - bottom > shared) refine(1);
    refine(128);
    for (const whole of [bottom / shared, top / shared]) { // a rational root of a monic polynomial is an integer
        const inside = whole * shared > bottom && whole * shared <= top;
        if (inside && signAt(RATIONAL, monic.map((c) => [c]), [whole, 1n]) === 0) return { field: RATIONAL, r: [[whole], [lead]] };
    }
    const reduced = (a) => {
        const found = [...a];
        while (found.length > degree) {
            const c = found.pop();
            for (let k = 0; k < degree; k++) found[found.length - degree + k] -= c * monic[k];
        }
        return found;
    };
    const times = (a, b) => {
        const found = new Array(a.length + b.length - 1).fill(0n);
        a.forEach((x, i) => b.forEach((y, j) => (found[i + j] += x * y)));
        return reduced(found);
    };
    const vanishes = (a) => {
        const common = commonDivisor(RATIONAL, monic.map((c) => [c]), trimmed(RATIONAL, a.map((c) => [c])));
        const own = sturm(RATIONAL, common);
        return variations(RATIONAL, own, [bottom, shared]) > variations(RATIONAL, own, [top, shared]);
    };
    const sign = (a) => {
        if (a.slice(1).every((c) => c === 0n)) return signOf(a[0]);
        for (let first = true; ; first = false) {
            let [least, most, scale] = [0n, 0n, 1n]; // an enclosure of the number, times a power of shared
            for (const c of [...a].reverse()) {
                const corners = [least * bottom, least * top, most * bottom, most * top];
                scale *= shared;
                least = corners.reduce((x, y) => (x < y ? x : y)) + c * scale;
                most = corners.reduce((x, y) => (x > y ? x : y)) + c * scale;
            }
            if (least > 0n || most < 0n) return signOf(least);
            if (first && vanishes(a)) return 0;
            refine(128);
        }
    };
    const cofactor = (a) => { // by Gauss's elimination without fractions: the columns are a, a*r, a*r^2, ...
        const columns = Array.from({ length: degree }, (_, j) => times(a, [...new Array(j).fill(0n), 1n]));
        const rows = Array.from({ length: degree }, (_, i) => [...columns.map((c) => c[i] || 0n), i ? 0n : 1n]);
        let previous = 1n;
        for (let k = 0; k < degree; k++) {
            const at = rows.findIndex((row, i) => i >= k && row[k] !== 0n);
            if (at < 0) return null;
            [rows[k], rows[at]] = [rows[at], rows[k]];
            const pivot = rows[k];
            rows.forEach((row, i) => {
                if (i !== k) rows[i] = row.map((x, j) => (x * pivot[k] - row[k] * pivot[j]) / previous);
            });
            previous = pivot[k];
        }
        return rows.map((row) => row[degree]);
    };
    return { field: { degree, times, sign, cofactor }, r: [[0n, 1n], [lead]] };
}

const raised = (F, a, n) => Array.from({ length: n }).reduce((found) => F.times(found, a), [1n]);

// Terms [coefficient, powers] at fractions of numbers, as a fraction.
function valueOf(F, terms, fractions) {
    let [top, bottom] = [[0n], [1n]];
    for (const [coefficient, ...powers] of terms) {
        let [a, b] = [[coefficient], [1n]];
        powers.forEach((n, k) => n && ([a, b] = [F.times(a, raised(F, fractions[k][0], n)), F.times(b, raised(F, fractions[k][1], n))]));
        [top, bottom] = [plus(F.times(top, b), F.times(a, bottom)), F.times(bottom, b)];
    }
    return [top, bottom];
}

// The quotient of two fractions of numbers; null for a division by 0.
function dividedBy(F, a, b) {
    const sign = BigInt(F.sign(b[0]));
    return sign ? [F.times(F.times(a[0], b[1]), [sign]), F.times(F.times(a[1], b[0]), [sign])] : null;
}

// --- polynomials -------------------------------------------------------------------------------------

function trimmed(F, p) {
    const found = [...p];
    while (found.length && F.sign(found[found.length - 1]) === 0) found.pop();
    return found;
}

const leading = (p) => p[p.length - 1];
const sumOf = (F, p, q) => trimmed(F, Array.from({ length: Math.max(p.length, q.length) }, (_, i) => plus(p[i] || [0n], q[i] || [0n])));
const scaled = (F, p, factor) => trimmed(F, p.map((c) => F.times(c, factor)));

function productOf(F, p, q) {
    const found = Array.from({ length: Math.max(0, p.length + q.length - 1) }, () => [0n]);
    p.forEach((a, i) => q.forEach((b, j) => (found[i + j] = plus(found[i + j], F.times(a, b)))));
    return trimmed(F, found);
}

const derivative = (F, p) => trimmed(F, p.slice(1).map((c, i) => F.times(c, [BigInt(i + 1)])));

// A positive multiple of a polynomial, small: its first coefficient is an integer, and integers common to all are left out.
function primitive(F, p) {
    if (!p.length) return p;
    const factor = F.cofactor(leading(p));
    const found = factor ? p.map((c) => F.times(c, factor.map((x) => x * BigInt(F.sign(factor))))) : p;
    const divisor = greatestDivisor(found.flat());
    return found.map((c) => c.map((x) => x / divisor));
}

// [quotient, remainder] of p divided by q, each up to a positive factor of its own.
function divided(F, p, q) {
    let [rest, found] = [p, []];
    const size = F.times(leading(q), [BigInt(F.sign(leading(q)))]);
    while (rest.length >= q.length) {
        const term = [...Array.from({ length: rest.length - q.length }, () => [0n]), F.times(leading(rest), [BigInt(F.sign(leading(q)))])];
        found = sumOf(F, scaled(F, found, size), term);
        const minus = productOf(F, term, q).map((c) => c.map((x) => -x));
        rest = sumOf(F, scaled(F, rest, size), minus).slice(0, rest.length - 1);
        rest = trimmed(F, rest);
    }
    return [primitive(F, found), primitive(F, rest)];
}

function commonDivisor(F, p, q) {
    while (q.length) [p, q] = [q, divided(F, p, q)[1]];
    return primitive(F, p);
}

// The polynomial with the same roots, each once.
const squareFree = (F, p) => divided(F, p, commonDivisor(F, p, derivative(F, p)))[0];

function sturm(F, p) {
    const chain = [primitive(F, p), primitive(F, derivative(F, p))];
    while (leading(chain).length) chain.push(divided(F, ...chain.slice(-2))[1].map((c) => c.map((x) => -x)));
    return chain.slice(0, -1);
}

// The value of a polynomial at a fraction of integers, times a power of the denominator.
const valueAt = (F, p, [top, bottom]) => p.reduceRight((value, c, i) => plus(F.times(value, [top]), F.times(c, [power(bottom, p.length - 1 - i)])), [0n]);

// The sign of a polynomial at a fraction of integers with a positive denominator, or at infinity for null.
const signAt = (F, p, x) => (p.length ? F.sign(x === null ? leading(p) : valueAt(F, p, x)) : 0);

function variations(F, chain, x) {
    const signs = chain.map((p) => signAt(F, p, x)).filter((sign) => sign !== 0);
    return signs.filter((sign, i) => i && sign !== signs[i - 1]).length;
}

// Intervals [low, high] of fractions with low > 0, in ascending order, that hold one positive root each of a polynomial
// without multiple roots; no end is a root.
function positiveRoots(F, p) {
    const own = p.slice(p.findIndex((c) => F.sign(c) !== 0));
    const chain = sturm(F, own);
    const roots = ([a, b]) => variations(F, chain, a) - variations(F, chain, b);
    let high = [1n, 1n];
    const all = roots([[0n, 1n], null]);
    while (roots([[0n, 1n], high]) < all || signAt(F, own, high) === 0) high = [2n * high[0], 1n];
    const found = [];
    const look = (interval, count) => {
        if (count === 1 && interval[0][0] > 0n) found.push(interval);
        else if (count) for (const half of halves(F, own, interval)) look(half, roots(half));
    };
    look([[0n, 1n], high], all);
    return found;
}

// The two parts of an interval about its middle, or about a point beside that where the polynomial vanishes there.
function halves(F, p, [low, high]) {
    for (let k = 1n; ; k++) {
        const middle = [k * low[0] * high[1] + high[0] * low[1], (k + 1n) * low[1] * high[1]];
        const divisor = greatestDivisor(middle);
        const at = middle.map((x) => x / divisor);
        if (signAt(F, p, at) !== 0) return [[low, at], [at, high]];
    }
}
