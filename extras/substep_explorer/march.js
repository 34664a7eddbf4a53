"use strict";
// Marches of any scheme on any scene: the plan of a step, interpreted on vectors as substep.structures does it.

// The solution of matrix*x = right by elimination with pivoting; matrix has as many rows as the scene has coordinates.
function solvedSystem(matrix, right) {
    const rows = matrix.map((row, i) => [...row, right[i]]);
    const n = rows.length;
    for (let k = 0; k < n; k++) {
        let best = k;
        for (let i = k + 1; i < n; i++) if (Math.abs(rows[i][k]) > Math.abs(rows[best][k])) best = i;
        [rows[k], rows[best]] = [rows[best], rows[k]];
        for (let i = k + 1; i < n; i++) {
            const factor = rows[i][k] / rows[k][k];
            for (let j = k; j <= n; j++) rows[i][j] -= factor * rows[k][j];
        }
    }
    const x = new Array(n).fill(0);
    for (let k = n - 1; k >= 0; k--) {
        let rest = rows[k][n];
        for (let j = k + 1; j < n; j++) rest -= rows[k][j] * x[j];
        x[k] = rest / rows[k][k];
    }
    return x;
}

const addTo = (sum, factor, x) => sum.forEach((_, i) => (sum[i] += factor * x[i]));
const times = (matrix, x) => matrix.map((row) => row.reduce((sum, entry, j) => sum + entry * x[j], 0));

// A scene with numbers for its parameters, as plans take it: matrices, forces, and what they are at the start.
function prepared(scene, p) {
    const start = scene.start(p);
    const problem = {
        M: scene.mass(p),
        C: scene.damping(p),
        K0: scene.tangent(start.u, p),
        length: Math.abs(scene.length(p)),
        force: (u) => scene.force(u, p),
        tangent: (u) => scene.tangent(u, p),
        gradient: (old, u) => scene.gradient(old, u, p),
        gradientSlope: (old, u) => scene.gradient_slope(old, u, p),
    };
    problem.acceleration = (u, v) => {
        const rest = problem.force(u).map((force) => -force);
        addTo(rest, -1, times(problem.C, v));
        return solvedSystem(problem.M, rest);
    };
    problem.first = [start.u, start.v, start.a || problem.acceleration(start.u, start.v)];
    return problem;
}

// Carries out a plan on the given vectors: { out, report }. Every vector is x = c + sum of s[j]*z[j] in the unknowns z of
// the next systems, which are solved together. Throws an Error where Newton's iteration fails.
function carriedOut(plan, rows, given, problem) {
    const n = given[0].length;
    const vectors = {};
    plan.given.forEach((name, k) => (vectors[name] = { c: [...given[k]], s: [] }));
    const at = (row) => {
        const found = { c: new Array(n).fill(0), s: [] };
        for (const [name, factor] of Object.entries(row)) {
            addTo(found.c, factor, vectors[name].c);
            vectors[name].s.forEach((slope, j) => (found.s[j] = (found.s[j] || 0) + factor * slope));
        }
        return found;
    };
    const waiting = []; // combinations of an unknown of a system after the next one
    const combine = (name, row) => {
        if (Object.keys(row).every((one) => one in vectors)) vectors[name] = at(row);
        else waiting.push([name, row]);
    };
    const begin = (k) => {
        const next = rows.operations.slice(k).find(([kind]) => kind === "solve");
        if (next) next[1].forEach((name, j) => (vectors[name] = { c: new Array(n).fill(0), s: next[1].map((_, i) => Number(i === j)) }));
        waiting.splice(0).forEach(([name, row]) => combine(name, row));
    };
    let last = given[0];
    begin(0);
    rows.operations.forEach(([kind, names, body], k) => {
        if (kind === "combine") {
            combine(names, body);
            return;
        }
        const displaced = body.flatMap((one) => [...(one.N || []), ...(one.N_discrete || [])]).flatMap((term) => Object.keys(term[term.length - 1]));
        const moved = [...new Set(displaced)].map((one) => vectors[one]).filter(({ s }) => s.some((slope) => slope !== 0));
        const z = solvedBalances(body, at, moved, last, problem);
        for (const vector of Object.values(vectors)) {
            vector.s.forEach((slope, j) => addTo(vector.c, slope, z[j]));
            vector.s = [];
        }
        if (moved.length) last = [...moved[moved.length - 1].c];
        begin(k + 1);
    });
    return { out: rows.out.map((row) => at(row).c), report: rows.report.map((row) => at(row).c) };
}

// The unknowns z of balances by Newton's iteration from the displacement `last`, where the displacements that move can
// all be there, until its corrections of these are 1e-12 of the scene's length.
function solvedBalances(bodies, at, moved, last, problem) {
    const [n, m] = [problem.M.length, bodies.length];
    const zeros = () => Array.from({ length: m }, () => new Array(n).fill(0));
    const shifted = ({ c, s }, z) => {
        const found = [...c];
        s.forEach((slope, j) => addTo(found, slope, z[j]));
        return found;
    };
    // adds factor*matrix to the blocks of a row of systems, each times its slope
    const spread = (rows, factor, slopes, matrix) => slopes.forEach((slope, j) => slope !== 0 && rows.forEach((row, i) => matrix[i].forEach((entry, k) => (row[j * n + k] += factor * slope * entry))));
    const linear = bodies.map((body) => {
        const known = new Array(n).fill(0);
        const slope = known.map(() => new Array(m * n).fill(0));
        for (const name of ["M", "C", "K0"].filter((one) => body[one])) {
            const { c, s } = at(body[name]);
            addTo(known, 1, times(problem[name], c));
            spread(slope, 1, s, problem[name]);
        }
        return { known, slope };
    });
    let z = zeros();
    if (moved.length >= m) {
        const by = moved.slice(0, m).map(({ s }) => z.map((_, j) => s[j] || 0));
        last.forEach((u, i) => solvedSystem(by, moved.slice(0, m).map(({ c }) => u - c[i])).forEach((x, j) => (z[j][i] = x)));
        if (!z.flat().every(Number.isFinite)) z = zeros();
    }
    for (let iteration = 0; iteration < 50; iteration++) {
        const residual = [];
        const jacobian = [];
        bodies.forEach((body, b) => {
            const wrong = [...linear[b].known];
            const rows = linear[b].slope.map((row) => [...row]);
            addTo(wrong, 1, times(rows, z.flat()));
            for (const [w, row] of body.N || []) {
                const place = at(row);
                const u = shifted(place, z);
                addTo(wrong, w, problem.force(u));
                if (place.s.some((slope) => slope !== 0)) spread(rows, w, place.s, problem.tangent(u));
            }
            for (const [w, before, row] of body.N_discrete || []) {
                const [old, place] = [shifted(at(before), z), at(row)];
                const u = shifted(place, z);
                addTo(wrong, w, problem.gradient(old, u));
                spread(rows, w, place.s, problem.gradientSlope(old, u));
            }
            residual.push(...wrong);
            jacobian.push(...rows);
        });
        const change = solvedSystem(jacobian, residual).map((x) => -x);
        z.forEach((part, j) => addTo(part, 1, change.slice(j * n, (j + 1) * n)));
        if (!z.flat().every(Number.isFinite)) break;
        const far = Math.max(0, ...moved.map(({ s }) => s.reduce((sum, slope) => sum + Math.abs(slope), 0)));
        if (Math.max(...change.map(Math.abs)) * far <= 1e-12 * problem.length) return z;
    }
    throw new Error("Newton's iteration failed");
}

// March n steps of h: { rows, failed }, rows of [u, v, a] at 0, h, ..., vectors each. failed: what ended the run early,
// "" where nothing did. Throws RangeError for a scheme without damping on a scene with damping.
function march(scheme, values, scene, p, h, n) {
    const problem = prepared(scene, p);
    if (!scheme.damped && problem.C.flat().some((entry) => entry !== 0))
        throw new RangeError(`${scheme.name} is for u'' = g(t, u): expected a motion without damping`);
    let rows = [problem.first];
    let state;
    if (scheme.starter) {
        rows = march(SCHEMES[scheme.starter], SCHEMES[scheme.starter].DEFAULTS, scene, p, h, Math.min(scheme.lag, n)).rows;
        if (rows.length <= scheme.lag) return { rows, failed: rows.length <= n ? "Newton's iteration failed" : "" };
        state = scheme.state.map(([kind, back]) => rows[scheme.lag - back][kind]);
    } else if (scheme.start) {
        state = carriedOut(scheme.start, scheme.start.rows(h, values), problem.first, problem).out;
    } else {
        state = scheme.state.map(([kind]) => problem.first[kind]);
    }
    const plan = scheme.step.rows(h, values);
    while (rows.length <= n) {
        let after;
        try {
            after = carriedOut(scheme.step, plan, state, problem);
        } catch (error) {
            return { rows, failed: error.message };
        }
        const [u, v, a] = after.report;
        const row = [u, v, a || problem.acceleration(u, v)];
        if (!row.flat().every(Number.isFinite)) return { rows, failed: "the numbers overflow" };
        state = after.out;
        rows.push(row);
    }
    return { rows, failed: "" };
}
