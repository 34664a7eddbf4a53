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

// Carries out a plan on the given vectors: { out, report }. Every vector is x = c + s*z in the unknown z of the next
// system. Throws an Error where Newton's iteration fails.
function carriedOut(plan, rows, given, problem) {
    const n = given[0].length;
    const vectors = {};
    plan.given.forEach((name, k) => (vectors[name] = { c: [...given[k]], s: 0 }));
    const at = (row) => {
        const found = { c: new Array(n).fill(0), s: 0 };
        for (const [name, factor] of Object.entries(row)) {
            addTo(found.c, factor, vectors[name].c);
            found.s += factor * vectors[name].s;
        }
        return found;
    };
    const begin = (k) => {
        const next = rows.operations.slice(k).find(([kind]) => kind === "solve");
        if (next) vectors[next[1]] = { c: new Array(n).fill(0), s: 1 };
    };
    let last = given[0];
    begin(0);
    rows.operations.forEach(([kind, name, body], k) => {
        if (kind === "combine") {
            vectors[name] = at(body);
            return;
        }
        const displaced = [...(body.N || []), ...(body.N_discrete || [])].flatMap((term) => Object.keys(term[term.length - 1]));
        const moved = vectors[displaced.find((one) => vectors[one].s !== 0)];
        const z = solvedBalance(body, at, moved, last, problem);
        for (const vector of Object.values(vectors)) {
            if (vector.s !== 0) addTo(vector.c, vector.s, z);
            vector.s = 0;
        }
        if (moved) last = [...moved.c];
        begin(k + 1);
    });
    return { out: rows.out.map((row) => at(row).c), report: rows.report.map((row) => at(row).c) };
}

// The unknown z of a system, by Newton's iteration from the displacement `last`, until its correction of the moved
// displacement is 1e-12 of the scene's length.
function solvedBalance(body, at, moved, last, problem) {
    const n = problem.M.length;
    const known = new Array(n).fill(0);
    const slope = problem.M.map((row) => row.map(() => 0));
    for (const name of ["M", "C", "K0"]) {
        if (!body[name]) continue;
        const { c, s } = at(body[name]);
        addTo(known, 1, times(problem[name], c));
        slope.forEach((row, i) => addTo(row, s, problem[name][i]));
    }
    const displaced = (row, z) => {
        const { c, s } = at(row);
        addTo(c, s, z);
        return { u: c, s };
    };
    let z = new Array(n).fill(0);
    if (moved) z = last.map((u, i) => (u - moved.c[i]) / moved.s);
    for (let iteration = 0; iteration < 50; iteration++) {
        const residual = [...known];
        const jacobian = slope.map((row) => [...row]);
        addTo(residual, 1, times(slope, z));
        for (const [w, row] of body.N || []) {
            const { u, s } = displaced(row, z);
            addTo(residual, w, problem.force(u));
            if (s !== 0) problem.tangent(u).forEach((entries, i) => addTo(jacobian[i], w * s, entries));
        }
        for (const [w, before, row] of body.N_discrete || []) {
            const [old, { u, s }] = [displaced(before, z).u, displaced(row, z)];
            addTo(residual, w, problem.gradient(old, u));
            problem.gradientSlope(old, u).forEach((entries, i) => addTo(jacobian[i], w * s, entries));
        }
        const change = solvedSystem(jacobian, residual).map((x) => -x);
        addTo(z, 1, change);
        if (!z.every(Number.isFinite)) break;
        if (Math.max(...change.map(Math.abs)) * Math.abs(moved ? moved.s : 0) <= 1e-12 * problem.length) return z;
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
