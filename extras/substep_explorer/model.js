"use strict";
// What is looked at, as text that an address can hold; and the numbers that follow from it.

const LETTERS = ["a", "b"];
// period: to which the step is relative, in the scene's parameters; shown: what the page offers to draw.
const MARCHES = {
    linear_oscillator: { title: "Free vibration", given: { omega: "6.283185307179586", xi: "0" }, period: (p) => (2 * Math.PI) / p.omega },
    simple_pendulum: { title: "Pendulum under gravity", given: {}, period: (p) => (2 * Math.PI) / Math.sqrt(p.g_over_L) },
    elastic_pendulum: { title: "Elastic pendulum without gravity", given: { EA: "10000" }, period: (p) => (2 * Math.PI * p.L) / Math.abs(p.v0) },
};
const LIMITS = { xi: [0, 2], ratio: [1e-4, 1e4], periods: [1, 50] };

function initialState() {
    return {
        a: { scheme: "bathe", given: {} },
        b: { scheme: "average_acceleration", given: {} },
        xi: "0", ratio: "0.1", periods: "10", scene: "linear_oscillator", quantity: "displacement", given: {},
    };
}

const isNumber = (text) => /^-?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$/i.test(text.trim());
const within = (text, [low, high]) => isNumber(text) && Number(text) >= low && Number(text) <= high;

function inInterval(p, value) {
    const above = p.low === null || (p.low_open ? value > p.low : value >= p.low);
    return above && (p.high === null || (p.high_open ? value < p.high : value <= p.high));
}

// The state as the part of an address after #: only what differs from the declarations' defaults.
function addressOf(state) {
    const entries = [];
    for (const letter of LETTERS) {
        entries.push([letter, state[letter].scheme]);
        for (const [name, text] of Object.entries(state[letter].given)) entries.push([`${letter}.${name}`, text]);
    }
    for (const key of ["xi", "ratio", "periods", "scene", "quantity"]) entries.push([key, state[key]]);
    for (const [name, text] of Object.entries(state.given)) entries.push([`scene.${name}`, text]);
    return new URLSearchParams(entries).toString();
}

// { state, refused }: the state of an address, and what of it was left out because it says nothing.
function stateOf(address) {
    const state = initialState();
    const refused = [];
    const entries = [...new URLSearchParams(address.replace(/^#/, ""))];
    const keep = (good, key, text, set) => (good ? set() : refused.push(`${key} = ${text}`));
    for (const [key, text] of entries) {
        if (LETTERS.includes(key)) keep(Object.hasOwn(SCHEMES, text), key, text, () => (state[key] = { scheme: text, given: {} }));
        if (key === "scene") keep(Object.hasOwn(SCENES, text), key, text, () => (state.scene = text));
    }
    for (const [key, text] of entries) {
        const [owner, name] = key.split(".");
        if (name === undefined) {
            if (key in LIMITS) keep(within(text, LIMITS[key]), key, text, () => (state[key] = text));
            else if (key === "quantity") keep(quantitiesOf(state.scene).includes(text), key, text, () => (state.quantity = text));
            else if (key !== "scene" && !LETTERS.includes(key)) refused.push(`${key} = ${text}`);
        } else if (owner === "scene") {
            keep(Object.hasOwn(SCENES[state.scene].parameters, name) && isNumber(text), key, text, () => (state.given[name] = text));
        } else {
            const entry = state[owner];
            const scheme = entry && SCHEMES[entry.scheme];
            const p = scheme && scheme.parameters.find((one) => one.name === name);
            const family = scheme && scheme.families.find((one) => one.argument === name);
            const good = isNumber(text) && (p || family) && inInterval(p || family, Number(text));
            keep(good, key, text, () => (entry.given[name] = text));
        }
    }
    for (const letter of LETTERS) {
        const wrong = complaint(SCHEMES[state[letter].scheme], state[letter].given);
        if (wrong) refused.push(`parameters of ${letter}, since ${wrong}`), (state[letter].given = {});
    }
    if (!quantitiesOf(state.scene).includes(state.quantity)) state.quantity = "displacement";
    return { state, refused };
}

// The only root in its interval of a polynomial, lowest power first, by bisection.
function rootIn(p, coefficients) {
    const value = (x) => coefficients.reduceRight((sum, c) => sum * x + c, 0);
    let [low, high] = [p.low, p.high];
    const rising = value(high) > 0;
    for (let k = 0; k < 200; k++) {
        const middle = 0.5 * (low + high);
        if (middle <= low || middle >= high) break;
        if (value(middle) > 0 === rising) high = middle;
        else low = middle;
    }
    return Math.abs(value(low)) < Math.abs(value(high)) ? low : high;
}

// { values, field, fractions }: every parameter as a number; and the constant and every parameter exactly, as fractions
// of numbers of the field of the one root that an irrational one is, null for what is none. given: name -> text, of
// parameters and of the arguments of families; what is not given follows from the declaration.
function parametersOf(scheme, given) {
    const values = {};
    const exact = { field: RATIONAL, fractions: [] };
    const add = (polynomial, interval) => {
        const found = exact.field === RATIONAL ? fieldOf(polynomial, interval) : null;
        if (found) exact.field = found.field;
        exact.fractions.push(found && found.r);
    };
    const rational = ([top, bottom]) => [[top], [bottom]];
    const quotientOf = (quotient, at) => quotient && dividedBy(exact.field, ...quotient.map((terms) => valueOf(exact.field, terms, at)));
    if (scheme.constant) add(scheme.constant.polynomial, scheme.constant.interval);
    for (const p of scheme.parameters) {
        const family = scheme.families.find((one) => one.argument in given && p.name in one.quotients);
        if (p.decided && p.decided.by in given) {
            const found = quotientOf(p.decided.quotient, [rational(fractionOf(given[p.decided.by]))]);
            values[p.name] = Number(found[0][0]) / Number(found[1][0]);
            exact.fractions.push(found);
        } else if (p.name in given) {
            values[p.name] = Number(given[p.name]);
            exact.fractions.push(rational(fractionOf(given[p.name])));
        } else if (family) {
            values[p.name] = family.of(Number(given[family.argument]))[p.name];
            exact.fractions.push(quotientOf(family.quotients[p.name], [rational(fractionOf(given[family.argument]))]));
        } else {
            values[p.name] = p.default ? p.default(values) : rootIn(p, p.polynomial(values));
            const known = exact.fractions.slice(scheme.constant ? 1 : 0);
            if (known.includes(null)) exact.fractions.push(null);
            else if (p.root) add(integersOf(p.root.map((terms) => valueOf(exact.field, terms, known))), [p.low, p.high].map((end) => fractionOf(String(end))));
            else exact.fractions.push(quotientOf(p.quotient, known));
        }
    }
    return { values, ...exact };
}

// A name as substep.core.scheme_names writes it: in small letters with words joined by _, with and without a last word
// such as method; then the same of GeneralizedAlpha in two words.
function writtenForms(name) {
    const apart = name.replace(/(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])/g, "_");
    return [name, apart].flatMap((text) => {
        const dashed = text.toLowerCase().replace(/['\u2019]s?/g, "").replace(/[\u2010-\u2015]/g, "-");
        const plain = dashed.normalize("NFKD").replace(/[^\x20-\x7e]/g, "").replace(/[\W_]+/g, "_").replace(/^_+|_+$/g, "");
        return [plain, plain.replace(/_(method|scheme|algorithm)$/, "")];
    });
}

// What is meant by a name, best first: { named, others }, lists of { scheme, given }. named: schemes of that name, or with
// that synonym, which may stand for parameters; others: those with the text in their name, a synonym or their reference.
function schemesFound(text) {
    const all = Object.values(SCHEMES);
    for (const asked of writtenForms(text)) {
        if (Object.hasOwn(SCHEMES, asked)) return { named: [{ scheme: asked, given: {} }], others: [] };
        const named = all.flatMap(({ name, synonyms }) => synonyms.map((one) => one.split(": ")).filter(([known]) => known === asked).map(([, values]) => ({ scheme: name, given: values ? Object.fromEntries(values.split(", ").map((one) => one.split("="))) : {} })));
        if (named.length) return { named, others: [] };
    }
    const [asked] = writtenForms(text);
    const within = ({ name, synonyms, reference }) => [name, ...synonyms, reference].some((one) => writtenForms(one)[0].includes(asked));
    return { named: [], others: asked ? all.filter(within).map(({ name }) => ({ scheme: name, given: {} })) : [] };
}

// What is wrong with given numbers, each in its interval, all together; empty where nothing is.
function complaint(scheme, given) {
    for (const p of scheme.parameters)
        if (p.decided && p.decided.by in given && p.name in given) return `${p.decided.by} decides ${p.name}: give one of the two`;
    const { values } = parametersOf(scheme, given);
    const outside = scheme.parameters.find((p) => !inInterval(p, values[p.name]));
    return outside ? `${outside.name} would be ${values[outside.name]}, which is not in ${bounds(outside)}` : "";
}

const bounds = (p) => `${p.low_open ? "(" : "["}${p.low ?? "−∞"}, ${p.high ?? "∞"}${p.high_open ? ")" : "]"}`;

// Fractions of rational numbers times a positive number that makes them integers; the last is not 0.
function integersOf(fractions) {
    const shared = fractions.reduce((product, [, [bottom]]) => product * bottom, 1n);
    return trimmed(RATIONAL, fractions.map(([[top], [bottom]]) => [(top * shared) / bottom])).map(([c]) => c);
}

// Numbers of a scene's parameters, from what is given, the page's own, and the declaration's defaults.
function sceneParametersOf(state) {
    const p = { ...SCENES[state.scene].parameters, ...MARCHES[state.scene].given };
    if (state.scene === "linear_oscillator") p.xi = state.xi;
    for (const [name, text] of Object.entries({ ...p, ...state.given })) p[name] = Number(text);
    return p;
}

function quantitiesOf(scene) {
    return ["displacement", "velocity", "acceleration", ...Object.keys(SCENES[scene].outputs)];
}

// What is drawn of a march: [t/T, value] of each row. Energy and angular momentum are relative to their start, minus 1.
function drawnOf(state, rows, p) {
    const h = Number(state.ratio);
    const kind = ["displacement", "velocity", "acceleration"].indexOf(state.quantity);
    if (kind >= 0) return rows.map((row, i) => [i * h, row[kind][0]]);
    const output = SCENES[state.scene].outputs[state.quantity];
    const found = rows.map(([u, v]) => output(u, v, p));
    const relative = found[0] !== 0;
    return found.map((x, i) => [i * h, relative ? x / found[0] - 1 : x]);
}

// Stability functions of a scheme at h/T and xi; eigenvalues as [re, im].
function stabilityAt(scheme, values, xi, ratio) {
    if (!scheme.damped && xi > 0) return { eigenvalues: [], radius: NaN, damping: NaN, period: NaN };
    const Omega = 2 * Math.PI * ratio;
    const z = roots(scheme.polynomial(Omega, xi, values));
    return { eigenvalues: z.map(([x, y]) => [1 + x, y]), ...spectrum(z, Omega, xi) };
}
