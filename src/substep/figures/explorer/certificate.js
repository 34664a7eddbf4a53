"use strict";
// Whether a scheme is stable for every Omega > 0, decided in integers: the conditions of Jury on the polynomial of its
// eigenvalues, taken to the left half plane by lambda = (1 + s)/(1 - s), each a polynomial in Omega whose sign is
// decided by Sturm's theorem. As substep_derive.stability.conditions decides it, for up to three eigenvalues.
// A polynomial is an array of integers (BigInt), lowest power first; a fraction is [numerator, denominator].

const power = (x, n) => x ** BigInt(n);
const absolute = (x) => (x < 0n ? -x : x);
const signOf = (x) => (x > 0n ? 1 : x < 0n ? -1 : 0);

// A decimal such as "0.3025" or "1e-3" as a fraction.
function fractionOf(text) {
    const [, sign, whole, digits = "", exponent = "0"] = /^(-?)(\d*)\.?(\d*)(?:e([-+]?\d+))?$/i.exec(text.trim());
    const shift = Number(exponent) - digits.length;
    const number = BigInt(sign + (whole || "0") + digits);
    return shift >= 0 ? [number * power(10n, shift), 1n] : [number, power(10n, -shift)];
}

// Terms [coefficient, powers] at fractions, as a fraction.
function valueOf(terms, fractions) {
    let [top, bottom] = [0n, 1n];
    for (const [coefficient, ...powers] of terms) {
        let [a, b] = [coefficient, 1n];
        powers.forEach((n, k) => ([a, b] = [a * power(fractions[k][0], n), b * power(fractions[k][1], n)]));
        [top, bottom] = [top * b + a * bottom, bottom * b];
    }
    return [top, bottom];
}

function trimmed(p) {
    const found = [...p];
    while (found.length && found[found.length - 1] === 0n) found.pop();
    return found;
}

const sumOf = (p, q) => trimmed(Array.from({ length: Math.max(p.length, q.length) }, (_, i) => (p[i] || 0n) + (q[i] || 0n)));
const scaled = (p, factor) => trimmed(p.map((c) => c * factor));

function productOf(p, q) {
    const found = new Array(Math.max(0, p.length + q.length - 1)).fill(0n);
    p.forEach((a, i) => q.forEach((b, j) => (found[i + j] += a * b)));
    return trimmed(found);
}

const derivative = (p) => trimmed(p.slice(1).map((c, i) => c * BigInt(i + 1)));

// The polynomial over the greatest common divisor of its coefficients.
function primitive(p) {
    let divisor = 0n;
    for (const c of p) for (let [a, b] = [absolute(c), divisor]; ; [a, b] = [b, a % b]) if (b === 0n) { divisor = a; break; }
    return divisor > 1n ? p.map((c) => c / divisor) : p;
}

// A positive multiple of the remainder of p divided by q.
function remainder(p, q) {
    let rest = p;
    const lead = q[q.length - 1];
    while (rest.length >= q.length) {
        const top = rest[rest.length - 1];
        const shifted = new Array(rest.length - q.length).fill(0n).concat(q);
        rest = sumOf(scaled(rest, absolute(lead)), scaled(shifted, lead > 0n ? -top : top));
    }
    return primitive(rest);
}

// The quotient p/q of polynomials that divide without a rest, up to a positive factor.
function quotientOf(p, q) {
    let rest = p;
    let found = [];
    const lead = q[q.length - 1];
    while (rest.length >= q.length) {
        const term = new Array(rest.length - q.length).fill(0n).concat([lead > 0n ? rest[rest.length - 1] : -rest[rest.length - 1]]);
        found = sumOf(scaled(found, absolute(lead)), term);
        rest = sumOf(scaled(rest, absolute(lead)), scaled(productOf(term, q), -1n));
    }
    return primitive(found);
}

function commonDivisor(p, q) {
    while (q.length) [p, q] = [q, remainder(p, q)];
    return primitive(p);
}

// The square-free product of the roots at which a polynomial has to be looked at: all of them, or, not strictly, those
// of odd multiplicity, where its sign changes (Yun's algorithm).
function looked(p, strict) {
    let divisor = commonDivisor(p, derivative(p));
    let rest = quotientOf(p, divisor);
    if (strict) return rest;
    let odd = [1n];
    for (let multiplicity = 1; rest.length > 1; multiplicity++) {
        const next = commonDivisor(rest, divisor);
        if (multiplicity % 2) odd = productOf(odd, quotientOf(rest, next));
        [divisor, rest] = [quotientOf(divisor, next), next];
    }
    return odd;
}

function sturm(p) {
    const chain = [p, derivative(p)];
    while (chain[chain.length - 1].length) chain.push(scaled(remainder(chain[chain.length - 2], chain[chain.length - 1]), -1n));
    return chain.slice(0, -1);
}

// Sign of a polynomial at a fraction, or at infinity for null.
function signAt(p, x) {
    if (!p.length) return 0;
    if (x === null) return signOf(p[p.length - 1]);
    return signOf(p.reduceRight((value, c, i) => value * x[0] + c * power(x[1], p.length - 1 - i), 0n));
}

function variations(chain, x) {
    const signs = chain.map((p) => signAt(p, x)).filter((sign) => sign !== 0);
    return signs.filter((sign, i) => i && sign !== signs[i - 1]).length;
}

// The smallest Omega > 0 at which p >= 0, or p > 0 if strict, begins to fail: 0 if at once, Infinity if it holds.
function failsFrom(p, strict) {
    if (!p.length) return strict ? 0 : Infinity;
    const shifted = p.slice(p.findIndex((c) => c !== 0n));
    if (shifted[0] < 0n) return 0;
    const part = looked(shifted, strict);
    if (part.length < 2) return Infinity;
    const chain = sturm(part);
    const before = variations(chain, [0n, 1n]);
    const roots = (x) => before - variations(chain, x);
    if (roots(null) === 0) return Infinity;
    let [low, high, shared] = [0n, 1n, 1n]; // low/shared and high/shared enclose the root
    while (roots([high, 1n]) === 0) [low, high] = [high, 2n * high];
    for (let k = 0; k < 60; k++) {
        [low, high, shared] = [2n * low, 2n * high, 2n * shared];
        const middle = (low + high) / 2n;
        if (roots([middle, shared]) > 0) high = middle;
        else low = middle;
    }
    return Number((high * power(10n, 17)) / shared) / 1e17;
}

// Coefficients of (1 + s)^j (1 - s)^(n - j), lowest power first.
function bilinear(j, n) {
    let found = [1n];
    for (let k = 0; k < n; k++) found = productOf(found, [1n, k < j ? 1n : -1n]);
    return found;
}

// { decided, stableUpTo, reason } at exact values: fractions of xi and of the parameters in their order, null where one
// is irrational. stableUpTo: Infinity where stable for every Omega > 0, else the Omega at which stability is first lost.
function certified(scheme, xi, fractions) {
    const undecided = (reason) => ({ decided: false, reason });
    if (!scheme.exact || fractions.some((x) => x === null)) return undecided("a number is irrational");
    let c = exactCoefficients(scheme.exact, [xi, ...fractions]);
    while (c.length && !c[0].length) c = c.slice(1);
    const lead = c[c.length - 1].find((x) => x !== 0n);
    if (lead < 0n) c = c.map((p) => scaled(p, -1n));
    const n = c.length - 1;
    if (n > 3) return undecided(`the scheme has ${n} eigenvalues that are not always 0`);
    const h = Array.from({ length: n + 1 }, () => []);
    c.forEach((p, j) => bilinear(j, n).forEach((factor, i) => (h[i] = sumOf(h[i], scaled(p, factor)))));
    const needed = h.map((p) => [p, false]);
    if (n === 3) needed.push([sumOf(productOf(h[1], h[2]), scaled(productOf(h[0], h[3]), -1n)), false]);
    needed.push([sumOf(h[0], h[1] || []), true], [sumOf(h[n], h[n - 1] || []), true]);
    return { decided: true, stableUpTo: Math.min(...needed.map(([p, strict]) => failsFrom(p, strict))) };
}

// Polynomials in Omega with a common factor taken out, from terms in Omega, xi and the parameters.
function exactCoefficients(rows, fractions) {
    const degrees = fractions.map((_, k) => Math.max(0, ...rows.flat().map((term) => term[k + 2])));
    return rows.map((row) => {
        const found = [];
        for (const [coefficient, inOmega, ...powers] of row) {
            let value = coefficient;
            powers.forEach((e, k) => (value *= power(fractions[k][0], e) * power(fractions[k][1], degrees[k] - e)));
            while (found.length <= inOmega) found.push(0n);
            found[inOmega] += value;
        }
        return trimmed(found);
    });
}
