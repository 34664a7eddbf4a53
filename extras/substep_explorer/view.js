"use strict";
// The page: controls, charts and tables, all drawn from one state, which the address holds.

let state = initialState();
const charts = {};
const PRINTED = { march: [700, 260] }; // sizes of charts on paper, in CSS pixels; the others' are where they are used
const byId = (id) => document.getElementById(id);
const NAMES = { xi: "Damping ratio ξ", ratio: "Step h/T", periods: "Periods" };

function element(tag, properties = {}, ...children) {
    const found = Object.assign(document.createElement(tag), properties);
    found.append(...children);
    return found;
}

// A number as text; what is below the rounding of eigenvalues about 1 is shown as 0.
const shown = (x, digits = 5) => (Math.abs(x) < 1e-15 ? "0" : Number.isFinite(x) ? Number(x.toPrecision(digits)).toString() : Number.isNaN(x) ? "none" : "infinite");
const labelOf = (letter) => `${letter.toUpperCase()}: ${state[letter].scheme}`;
const grid = (low, high, n) => Array.from({ length: n + 1 }, (_, k) => low + ((high - low) * k) / n);

// Scheme and parameters of both letters; computed once for each drawing.
function looked_at() {
    return Object.fromEntries(LETTERS.map((letter) => {
        const scheme = SCHEMES[state[letter].scheme];
        return [letter, { scheme, ...parametersOf(scheme, state[letter].given) }];
    }));
}

// A text input, and a slider beside it, for one number; changed(text) takes what was entered.
function slider(id, label, { low, high, step, value }, changed) {
    const range = element("input", { type: "range", id: `${id}-range`, min: low, max: high, step, value });
    range.setAttribute("aria-label", `${label}, slider`);
    const box = element("input", { id, inputMode: "decimal", value });
    box.setAttribute("aria-describedby", "message");
    range.addEventListener("input", () => changed(range.value));
    box.addEventListener("change", () => changed(box.value.trim(), box));
    return element("div", { className: "slider" }, element("label", { htmlFor: id, textContent: label }), range, box);
}

function refuse(box, text) {
    if (box) box.setAttribute("aria-invalid", "true");
    byId("message").textContent = text;
}

// Where a slider of a parameter ends: its interval, or twice its default where that has no end.
function reach(p, value) {
    const low = p.low ?? -2 * Math.abs(value);
    const high = p.high ?? Math.max(2 * value, low + 1);
    const step = high - low > 0.3 ? 0.01 : 0.001;
    const open = (end, is_open, sign) => (is_open ? Number((end + sign * step).toFixed(6)) : end);
    return { low: open(low, p.low_open, 1), high: open(high, p.high_open && p.high !== null, -1), step };
}

// Controls of the parameters of one scheme; those of a family come first.
function build_parameters(letter) {
    const { scheme, given } = state[letter];
    const declared = SCHEMES[scheme];
    const defaults = parametersOf(declared, {}).values;
    const set = (name, p, cleared) => (text, box) => {
        if (!isNumber(text) || !inInterval(p, Number(text))) return refuse(box, `${name}: expected a number in ${bounds(p)}, got '${text}'`);
        const others = Object.entries(given).filter(([other]) => !cleared.includes(other));
        const wrong = complaint(declared, Object.fromEntries([...others, [name, text]]));
        if (wrong) return refuse(box, `${name} = ${text}: ${wrong}`);
        for (const other of cleared) delete given[other];
        given[name] = text;
        draw();
    };
    const rows = declared.families.map((family) => {
        const sets = Object.keys(family.quotients);
        return slider(`${letter}.${family.argument}`, `${family.argument} (sets ${sets.join(", ")})`, { ...reach(family, 1), value: given[family.argument] ?? "" }, set(family.argument, family, sets));
    });
    for (const p of declared.parameters) {
        const families = declared.families.filter((family) => p.name in family.quotients).map((family) => family.argument);
        const decided = declared.parameters.filter((other) => other.decided?.by === p.name).map((other) => other.name);
        const cleared = [...families, ...decided, ...(p.decided ? [p.decided.by] : [])];
        rows.push(slider(`${letter}.${p.name}`, p.name, { ...reach(p, defaults[p.name]), value: "" }, set(p.name, p, cleared)));
    }
    byId(`parameters-${letter}`).replaceChildren(...rows);
    const called = declared.synonyms.map((one) => one.replaceAll("_", " ")).join(", ");
    byId(`about-${letter}`).textContent = declared.reference + (called && `. Also called ${called}`);
    byId(`reset-${letter}`).hidden = rows.length === 0;
}

function build_scene() {
    const p = { ...SCENES[state.scene].parameters, ...MARCHES[state.scene].given };
    const inputs = Object.keys(p).filter((name) => !(state.scene === "linear_oscillator" && name === "xi")).map((name) => {
        const box = element("input", { id: `scene.${name}`, inputMode: "decimal" });
        box.setAttribute("aria-describedby", "message");
        box.addEventListener("change", () => {
            if (!isNumber(box.value)) return refuse(box, `${name}: expected a number, got '${box.value}'`);
            state.given[name] = box.value.trim();
            draw();
        });
        return element("label", { textContent: `${name} ` }, box);
    });
    byId("scene-parameters").replaceChildren(...inputs);
    byId("quantity").replaceChildren(...quantitiesOf(state.scene).map((name) => element("option", { value: name, textContent: name.replaceAll("_", " ") })));
    byId("about-scene").textContent = SCENES[state.scene].reference;
}

// Shows what is meant by a name, the first of several, and says what else has it.
function find(letter) {
    const box = byId(`find-${letter}`);
    if (!box.value.trim()) return;
    const { named, others } = schemesFound(box.value);
    const [first, ...more] = named.length ? named : others;
    if (!first) return refuse(box, `Find: expected a scheme's name or a part of one, got '${box.value}', which no scheme has`);
    state[letter] = first;
    build();
    if (more.length) byId("message").textContent = `'${box.value}' may be ${[first, ...more].map(({ scheme }) => scheme).join(", ")}; the first is shown`;
}

// Every control shows the state.
function fill() {
    for (const letter of LETTERS) {
        const { values } = parametersOf(SCHEMES[state[letter].scheme], state[letter].given);
        byId(letter).value = state[letter].scheme;
        for (const box of byId(`parameters-${letter}`).querySelectorAll("input:not([type=range])")) {
            const name = box.id.slice(2);
            const text = state[letter].given[name] ?? (name in values ? String(values[name]) : "");
            box.value = text;
            byId(`${box.id}-range`).value = text;
        }
    }
    for (const key of ["xi", "ratio", "periods", "scene", "quantity"]) byId(key).value = state[key];
    byId("xi-range").value = state.xi;
    byId("ratio-range").value = Math.log10(Number(state.ratio));
    const p = sceneParametersOf(state);
    for (const box of byId("scene-parameters").querySelectorAll("input")) box.value = state.given[box.id.slice(6)] ?? p[box.id.slice(6)];
    for (const box of document.querySelectorAll("[aria-invalid]")) box.removeAttribute("aria-invalid");
}

function build() {
    for (const letter of LETTERS) build_parameters(letter);
    build_scene();
    draw();
}

function table_of(head, rows) {
    const cells = (tag, row) => row.map((text, k) => {
        const cell = element(k ? tag : "th", { textContent: text });
        if (tag === "th" || k === 0) cell.scope = tag === "th" ? "col" : "row";
        return cell;
    });
    return element("table", {}, element("thead", {}, element("tr", {}, ...cells("th", head))), element("tbody", {}, ...rows.map((row) => element("tr", {}, ...cells("td", row)))));
}

function listed(eigenvalues, digits) {
    const imaginary = (y) => (Math.abs(y) > 1e-12 ? ` ${y < 0 ? "−" : "+"} ${shown(Math.abs(y), digits)}i` : "");
    return eigenvalues.map(([x, y]) => shown(x, digits) + imaginary(y)).join("; ") || "none";
}

const known_verdicts = new Map(); // kept, since most of what moves in the page does not change them

function verdict(letter, { scheme, ...exact }) {
    if (!scheme.damped && Number(state.xi) > 0) return "takes no damping";
    const key = JSON.stringify([state[letter], state.xi]);
    if (!known_verdicts.has(key)) known_verdicts.set(key, certified(scheme, fractionOf(state.xi), exact));
    const found = known_verdicts.get(key);
    if (!found.decided) return `not decided in the page: ${found.reason}; substep certify ${scheme.name} decides it`;
    if (found.stableUpTo === Infinity) return "for every Ω > 0, proved";
    if (found.points) return `for every Ω > 0 but single ones, from ${shown(found.stableUpTo, 8)} on, where an eigenvalue on the circle is double, proved`;
    return found.stableUpTo === 0 ? "unstable for small Ω, proved" : `for 0 < Ω < ${shown(found.stableUpTo, 8)}, then lost, proved`;
}

function draw_values(both) {
    const xi = Number(state.xi);
    const at = Object.fromEntries(LETTERS.map((letter) => [letter, stabilityAt(both[letter].scheme, both[letter].values, xi, Number(state.ratio))]));
    const rows = [
        ["Spectral radius ρ", ...LETTERS.map((k) => shown(at[k].radius, 8))],
        ["Numerical damping", ...LETTERS.map((k) => shown(at[k].damping, 6))],
        ["Period error", ...LETTERS.map((k) => shown(at[k].period, 6))],
        ["Eigenvalues", ...LETTERS.map((k) => listed(at[k].eigenvalues, 8))],
        ["Stable", ...LETTERS.map((k) => verdict(k, both[k]))],
    ];
    byId("values").replaceChildren(table_of([`h/T = ${state.ratio}, ξ = ${state.xi}`, ...LETTERS.map(labelOf)], rows));
    return at;
}

// One chart: lines of points [x, y], and marks at the current step; table: its head and rows, by default those points.
function draw_chart(id, lines, marks, { x, y, logarithmic = false, square = false, table = () => table_of_lines(lines, x, y) }) {
    const style = getComputedStyle(document.documentElement);
    const color = (name) => style.getPropertyValue(`--${name}`).trim();
    const points = (list) => list.map(([px, py]) => ({ x: px, y: Number.isFinite(py) ? py : null }));
    const datasets = [
        ...LETTERS.filter((letter) => lines[letter]).map((letter) => ({
            label: labelOf(letter), data: points(lines[letter]), borderColor: color(letter), backgroundColor: color(letter),
            borderDash: letter === "b" ? [7, 4] : [], borderWidth: 2, pointRadius: square ? 1 : 0, showLine: !square,
        })),
        ...LETTERS.filter((letter) => marks[letter]).map((letter) => ({
            label: `${labelOf(letter)}, at this step`, data: points(marks[letter]), borderColor: color(letter), backgroundColor: color(letter),
            pointRadius: 6, pointStyle: letter === "a" ? "circle" : "rectRot", showLine: false,
        })),
    ];
    if (square) datasets.push({ label: "unit circle", data: points(grid(0, 2 * Math.PI, 180).map((t) => [Math.cos(t), Math.sin(t)])), borderColor: color("quiet"), borderWidth: 1, pointRadius: 0, showLine: true });
    const axis = (title, type = "linear") => ({ type, title: { display: true, text: title, color: color("ink") }, ticks: { color: color("ink") }, grid: { color: color("line") } });
    const printed = matchMedia("print").matches;
    const dashed = (item, chart) => ({ ...item, lineDash: chart.data.datasets[item.datasetIndex].borderDash, lineWidth: 2 });
    const generateLabels = (chart) => Chart.defaults.plugins.legend.labels.generateLabels(chart).map((item) => dashed(item, chart));
    const options = {
        devicePixelRatio: printed ? 3 : undefined,
        animation: false, responsive: true, maintainAspectRatio: square, aspectRatio: square ? 1.3 : undefined, parsing: false, normalized: true,
        scales: { x: axis(x, logarithmic ? "logarithmic" : "linear"), y: axis(y) },
        plugins: { legend: { labels: { generateLabels, color: color("ink"), usePointStyle: true, pointStyle: "line", pointStyleWidth: 40, filter: (item) => !item.text.includes("at this step") && !(printed && item.text === "unit circle") } } },
    };
    if (logarithmic) options.scales.x.ticks.callback = (value) => (Number.isInteger(Math.round(1e9 * Math.log10(value)) / 1e9) ? String(value) : ""), Object.assign(options.scales.x.ticks, { autoSkip: false, maxRotation: 0 });
    const wide = printed ? 2 : 1.6; // so that a circle is round beside what axes and legend take
    if (square) Object.assign(options.scales.x, { min: -wide, max: wide }), Object.assign(options.scales.y, { min: -1.23, max: 1.23 });
    if (id === "radius") options.scales.y.suggestedMin = 0, options.scales.y.suggestedMax = 1.2, options.scales.y.max = largest_shown(lines);
    if (charts[id]) Object.assign(charts[id], { options }), (charts[id].data = { datasets }), charts[id].update("none");
    else charts[id] = new Chart(byId(id), { type: "scatter", data: { datasets }, options });
    charts[id].resize(...(printed ? PRINTED[id] || [340, 195] : []));
    const details = byId(`${id}-table`).parentElement;
    details.ontoggle = () => details.open && byId(`${id}-table`).replaceChildren(table());
    details.ontoggle();
}

// Up to where radii are drawn: those of an unstable scheme beyond 3 are cut off.
const largest_shown = (lines) => (LETTERS.some((k) => lines[k].some(([, y]) => y > 3)) ? 3 : undefined);

// Every so many points of the lines of both schemes, which share x.
function table_of_lines(lines, x, y) {
    const longer = lines.a.length >= lines.b.length ? lines.a : lines.b;
    const every = Math.max(1, Math.ceil(longer.length / 40));
    const at = (letter, k) => shown(lines[letter][k]?.[1] ?? NaN, 8);
    const rows = longer.map(([px], k) => [shown(px, 6), at("a", k), at("b", k)]).filter((_, k) => k % every === 0);
    return table_of([x, `${y} of ${labelOf("a")}`, `${y} of ${labelOf("b")}`], rows);
}

function draw_functions(both, at) {
    const xi = Number(state.xi);
    const ratio = Number(state.ratio);
    const lines = (ratios, key) => Object.fromEntries(LETTERS.map((letter) => [letter, ratios.map((r) => [r, stabilityAt(both[letter].scheme, both[letter].values, xi, r)[key]])]));
    const marks = (key) => Object.fromEntries(LETTERS.map((letter) => [letter, [[ratio, at[letter][key]]]]));
    const wide = grid(-2, 2, 320).map((e) => 10 ** e);
    const narrow = grid(0.0025, 0.5, 199);
    draw_chart("radius", lines(wide, "radius"), marks("radius"), { x: "h/T", y: "ρ", logarithmic: true });
    const inside = (key) => (ratio <= 0.5 ? marks(key) : {});
    draw_chart("damping", lines(narrow, "damping"), inside("damping"), { x: "h/T", y: "numerical damping" });
    draw_chart("period", lines(narrow, "period"), inside("period"), { x: "h/T", y: "period error" });
    const eigenvalues = lines(wide, "eigenvalues");
    const loci = Object.fromEntries(LETTERS.map((letter) => [letter, eigenvalues[letter].flatMap(([, own]) => own)]));
    const rows = () => wide.map((r, k) => [shown(r, 4), ...LETTERS.map((letter) => listed(eigenvalues[letter][k][1], 6))]).filter((_, k) => k % 8 === 0);
    const table = () => table_of(["h/T", ...LETTERS.map((letter) => `eigenvalues of ${labelOf(letter)}`)], rows());
    draw_chart("plane", loci, Object.fromEntries(LETTERS.map((letter) => [letter, at[letter].eigenvalues])), { x: "real part", y: "imaginary part", square: true, table });
    for (const [id, key, word] of [["radius", "radius", "Spectral radius"], ["damping", "damping", "Numerical damping"], ["period", "period", "Period error"]])
        byId(`${id}-says`).textContent = `${word} at h/T = ${state.ratio}: ${LETTERS.map((k) => `${labelOf(k)} ${shown(at[k][key], 6)}`).join("; ")}.`;
    byId("plane-says").textContent = "Dots: eigenvalues for h/T from 0.01 to 100; large marks: at this step. Stable inside the unit circle.";
}

function draw_march(both) {
    const p = sceneParametersOf(state);
    const ratio = Number(state.ratio);
    const h = ratio * MARCHES[state.scene].period(p);
    const steps = Math.max(1, Math.min(4000, Math.round(Number(state.periods) / ratio)));
    const said = [];
    const lines = {};
    for (const letter of LETTERS) {
        lines[letter] = [];
        try {
            const { rows, failed } = march(both[letter].scheme, both[letter].values, SCENES[state.scene], p, h, steps);
            lines[letter] = drawnOf(state, rows, p);
            const [, value] = lines[letter][lines[letter].length - 1];
            said.push(`${labelOf(letter)}: ${failed ? `${failed} in step ${rows.length}` : `${steps} steps`}, ends at ${shown(value, 8)}`);
        } catch (error) {
            said.push(`${labelOf(letter)}: ${error.message}`);
        }
    }
    const relative = state.quantity === "energy" || state.quantity === "angular_momentum";
    const name = state.quantity.replaceAll("_", " ");
    draw_chart("march", lines, {}, { x: "t/T", y: relative ? `${name}, relative change` : name });
    byId("march-says").textContent = `h = ${shown(h)} s. ${said.join(". ")}.`;
}

// Draw everything, and put the state into the address.
function draw() {
    byId("message").textContent = "";
    fill();
    const both = looked_at();
    draw_functions(both, draw_values(both));
    draw_march(both);
    history.replaceState(null, "", `#${addressOf(state)}`);
    byId("address").textContent = `This view: #${addressOf(state)}`;
}

function from_address() {
    const read = stateOf(location.hash);
    state = read.state;
    build();
    if (read.refused.length) refuse(null, `The address holds what says nothing here, and was left out: ${read.refused.join(", ")}`);
}

function begin() {
    for (const letter of LETTERS) {
        byId(letter).append(...Object.keys(SCHEMES).map((name) => element("option", { value: name, textContent: name })));
        byId(letter).addEventListener("change", () => ((state[letter] = { scheme: byId(letter).value, given: {} }), build()));
        byId(`find-${letter}`).addEventListener("change", () => find(letter));
        byId(`reset-${letter}`).addEventListener("click", () => ((state[letter].given = {}), draw()));
    }
    const names = Object.values(SCHEMES).flatMap(({ name, synonyms }) => [name, ...synonyms].map((one) => [one.split(": ")[0].replaceAll("_", " "), name]));
    byId("names").append(...names.map(([value, label]) => element("option", { value, label })));
    byId("scene").append(...Object.entries(MARCHES).map(([name, { title }]) => element("option", { value: name, textContent: title })));
    byId("scene").addEventListener("change", () => {
        Object.assign(state, { scene: byId("scene").value, given: {} });
        if (!quantitiesOf(state.scene).includes(state.quantity)) state.quantity = "displacement";
        build();
    });
    byId("quantity").addEventListener("change", () => ((state.quantity = byId("quantity").value), draw()));
    for (const key of Object.keys(LIMITS)) {
        byId(key).addEventListener("change", () => {
            const text = byId(key).value.trim();
            if (!within(text, LIMITS[key])) return refuse(byId(key), `${NAMES[key]}: expected a number from ${LIMITS[key].join(" to ")}, got '${text}'`);
            state[key] = text;
            draw();
        });
    }
    byId("xi-range").addEventListener("input", () => ((state.xi = byId("xi-range").value), draw()));
    byId("ratio-range").addEventListener("input", () => ((state.ratio = String(Number((10 ** Number(byId("ratio-range").value)).toPrecision(3)))), draw()));
    for (const form of document.forms) form.addEventListener("submit", (event) => event.preventDefault());
    addEventListener("hashchange", from_address);
    for (const query of ["(prefers-color-scheme: dark)", "print"]) matchMedia(query).addEventListener("change", draw);
    from_address();
}

begin();
