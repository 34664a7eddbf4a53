// The explorer in a real browser: moves every slider, looks at the charts and reads what the page says, as JSON.
// Run by tests/test_explorer_browser.py with the folder of playwright-core, the browser, the page, folders for pictures and
// for the browser, and a file of requests.
const fs = require("fs");
const path = require("path");
const computed = require("./explorer_computed.js");
const [library, executablePath, page_file, folder, profile, requests] = process.argv.slice(2);
const { chromium } = require(path.resolve(library));
const quiet = [
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync",
];

(async () => {
    const context = await chromium.launchPersistentContext(profile, { executablePath, headless: true, args: quiet, viewport: { width: 1300, height: 1000 } });
    const page = await context.newPage();
    const said = [];
    const asked = [];
    page.on("console", (message) => said.push(message.text()));
    page.on("pageerror", (error) => said.push(String(error)));
    page.on("request", (request) => asked.push(request.url().slice(0, 60)));
    const url = `file://${page_file}`;
    await page.goto(url);
    const found = { schemes: {}, scenes: {} };
    const drawn = () => page.evaluate(() => Object.fromEntries(Object.entries(charts).map(([id, chart]) => [id, chart.data.datasets.map((set) => set.data.filter((point) => Number.isFinite(point.y)).length)])));

    // what the scripts compute in this browser
    const defined = "{ SCHEMES, SCENES, march, certified, fractionOf, parametersOf, stabilityAt }";
    found.results = await page.evaluate(`${fs.readFileSync(requests, "utf8")}.map((request) => (${computed})(${defined}, request))`);

    // every scheme as A, every slider of it moved to both ends and back
    for (const name of await page.evaluate(() => Object.keys(SCHEMES))) {
        await page.selectOption("#a", name);
        const { moved, messages } = await page.evaluate(() => {
            let moved = 0;
            const messages = new Set();
            for (const range of document.querySelectorAll("#parameters-a input[type=range]")) {
                for (const end of [range.min, range.max, String(0.5 * (Number(range.min) + Number(range.max)))]) {
                    range.value = end;
                    range.dispatchEvent(new Event("input"));
                    messages.add(document.getElementById("message").textContent);
                }
                moved += 1;
            }
            return { moved, messages: [...messages] };
        });
        if (moved) await page.click("#reset-a");
        found.schemes[name] = { moved, messages, values: await page.textContent("#values table tbody tr:first-child td"), stable: await page.textContent("#values table tbody tr:last-child td"), drawn: await drawn() };
    }
    // by name, synonym and part of a reference, and by what no scheme has
    found.sought = {};
    for (const text of ["Crank\u2013Nicolson", "leapfrog", "symplectic Euler", "Gauss", "no such scheme"]) {
        await page.fill("#find-a", text);
        await page.keyboard.press("Enter");
        found.sought[text] = await page.evaluate(() => [byId("a").value, state.a.given, byId("message").textContent, byId("about-a").textContent]);
    }
    found.names = await page.evaluate(() => byId("names").children.length);
    // by the keyboard alone: what Tab reaches, in the order of the page, and sliders of the second scheme and of the oscillator
    await page.selectOption("#b", "newmark");
    const stops = () => [...document.querySelectorAll("input, select, button, summary, [tabindex]")].filter((one) => one.checkVisibility()).map((one) => one.id || one.textContent);
    found.stops = await page.evaluate(stops);
    found.reached = [];
    await page.focus("#find-a");
    for (const _ of found.stops) {
        found.reached.push(await page.evaluate(() => document.activeElement.id || document.activeElement.textContent));
        await page.keyboard.press("Tab");
    }
    for (const id of ["b.beta-range", "xi-range", "ratio-range"]) {
        await page.focus(`[id="${id}"]`);
        for (let k = 0; k < 5; k++) await page.keyboard.press("ArrowRight");
    }
    found.keyboard = await page.evaluate(() => [state.xi, state.ratio, location.hash]);
    // every motion and quantity
    for (const scene of await page.evaluate(() => Object.keys(SCENES))) {
        await page.selectOption("#scene", scene);
        const said_of = {};
        for (const quantity of await page.evaluate(() => [...document.querySelectorAll("#quantity option")].map((option) => option.value))) {
            await page.selectOption("#quantity", quantity);
            said_of[quantity] = await page.textContent("#march-says");
        }
        found.scenes[scene] = said_of;
    }
    // wrong input is named, and changes nothing
    await page.fill("#ratio", "abc");
    await page.keyboard.press("Tab");
    found.wrong = await page.evaluate(() => [document.getElementById("message").textContent, document.getElementById("ratio").getAttribute("aria-invalid"), state.ratio]);
    // a view is cited by its address
    await page.goto("about:blank");
    await page.goto(`${url}#a=newmark&a.beta=0.3&a.gamma=0.6&b=park&xi=0.02&ratio=0.05&scene=elastic_pendulum&scene.EA=1e6&quantity=energy`);
    found.cited = await page.evaluate(() => ({ rows: [...document.querySelectorAll("#values tbody tr")].map((row) => [...row.cells].map((cell) => cell.textContent)), hash: location.hash, radius: charts.radius.data.datasets[0].data.map(({ x, y }) => [x, y]) }));
    for (const summary of await page.$$("summary")) await summary.press("Enter"); // a click would miss what a table moves
    await page.waitForTimeout(300); // tables are written afterwards
    found.tables = await page.evaluate(() => [...document.querySelectorAll(".table table")].length);
    found.unnamed = await page.evaluate(() => [...document.querySelectorAll("input, select, button, canvas, [role=region]")].filter((one) => !one.labels?.length && !one.getAttribute("aria-label") && !one.getAttribute("aria-labelledby") && !one.textContent.trim()).map((one) => one.id));
    await page.screenshot({ path: path.join(folder, "light.png"), fullPage: true });
    await page.emulateMedia({ colorScheme: "dark" });
    await page.waitForFunction(() => charts.radius.options.scales.x.ticks.color === "#ddd", null, { timeout: 5000 }).catch(() => {}); // drawn later
    found.dark = await page.evaluate(() => [getComputedStyle(document.body).backgroundColor, charts.radius.options.scales.x.ticks.color]);
    await page.screenshot({ path: path.join(folder, "dark.png"), fullPage: true });
    // on paper, from a dark browser: light, without controls, no chart wider than its column
    await page.emulateMedia({ media: "print", colorScheme: "dark" });
    await page.setViewportSize({ width: 700, height: 1000 });
    await page.waitForTimeout(300);
    found.paper = await page.evaluate(() => ({
        background: getComputedStyle(document.body).backgroundColor,
        controls: [...document.querySelectorAll("button, summary, input[type=range]")].filter((one) => one.offsetParent !== null).length,
        wider: Math.max(...[...document.querySelectorAll("canvas")].map((one) => one.offsetWidth - one.closest("figure").clientWidth)),
        address: document.getElementById("address").offsetParent !== null && document.getElementById("address").textContent === `This view: ${location.hash}`,
    }));
    await page.pdf({ path: path.join(folder, "print.pdf") });
    await page.setViewportSize({ width: 360, height: 800 });
    await page.emulateMedia({ media: "screen" });
    const overflow = () => document.documentElement.scrollWidth - document.documentElement.clientWidth;
    await page.waitForFunction(`(${overflow})() <= 0`, null, { timeout: 5000 }).catch(() => {}); // charts follow the width later
    found.overflow = await page.evaluate(overflow);
    await page.screenshot({ path: path.join(folder, "narrow.png"), fullPage: true });
    await context.close();
    console.log(JSON.stringify({ ...found, said, asked }));
})();
