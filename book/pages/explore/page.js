// What the explorables share: the check of their mathematics, numbers in words, drawings and controls.
// Nothing moves by itself, so there is nothing to stop for readers who prefer less motion.
globalThis.explorePage = (() => {
    const SVG = "http://www.w3.org/2000/svg";
    const { bound, level, sigmas } = reference;

    // Returns the largest difference of the functions in math.js from the library's, relative to its
    // values; below 1 relative to 1, except for p-values, whose smallness matters.
    function largestDifference() {
        let largest = 0;
        let worst = "";
        for (const [name, args, right] of reference.cases) {
            const found = [explore[name](...args)].flat();
            [right].flat().forEach((value, i) => {
                // JSON has no infinity.
                const wanted = value ?? Infinity;
                const scale = name === "chiSquareTail" ? wanted : Math.max(1, Math.abs(wanted));
                const difference = found[i] === wanted ? 0 : Math.abs(found[i] - wanted) / scale;
                if (!(difference <= largest)) [largest, worst] = [difference, `${name}(${JSON.stringify(args)}): ${found[i]}, not ${wanted}`];
            });
        }
        return [largest, worst];
    }

    // Shows in `element` whether the functions agree with the library's; .ci/check-book reads it.
    function check(element) {
        const [largest, worst] = largestDifference();
        const agrees = largest <= bound;
        element.dataset.agrees = agrees;
        element.textContent = agrees
            ? `Checked in your browser: the script's functions agree with the library's in ${reference.cases.length} cases, within ${number(bound)}.`
            : `The script's functions differ from the library's by ${number(largest)}: do not trust this page.`;
        if (!agrees) console.error(`Error: differs from the library in ${worst}`);
    }

    const raised = (n) => [...String(n)].map((c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[c])).join("");

    // Returns a number to about four digits, as a power of ten if it is small or large.
    function number(x) {
        if (x === Infinity || x === 0) return x ? "∞" : "0";
        if (Math.abs(x) >= 1e-3 && Math.abs(x) < 1e5) return x.toFixed(x < 100 ? 3 : 0).replace("-", "−");
        const [mantissa, exponent] = x.toExponential(1).split("e");
        return `${mantissa === "1.0" ? "" : `${mantissa}·`}10${raised(Number(exponent))}`.replace("-", "−");
    }

    // Returns an estimate with its standard error, both with the digits that matter.
    function estimate(mean, error) {
        if (!(error > 0)) return `${number(mean)} ± 0`;
        const digits = Math.min(6, Math.max(0, 1 - Math.floor(Math.log10(error))));
        return `${mean.toFixed(digits)} ± ${error.toFixed(digits)}`;
    }

    // Creates an element of SVG in `parent`.
    function draw(parent, kind, attributes, text = "") {
        const element = document.createElementNS(SVG, kind);
        for (const name in attributes) element.setAttribute(name, attributes[name]);
        element.textContent = text;
        parent.append(element);
        return element;
    }

    // Draws axes in a picture of 400 × 250 and returns the map from values to it. Values beyond the
    // range are at its edge.
    function axes(svg, { x, y, labels }) {
        const box = { left: 52, right: 390, top: 12, bottom: 208 };
        svg.replaceChildren();
        const scale = ({ range, log }, from, to) => {
            const place = (v) => (log ? Math.log10(v) : v);
            const [low, high] = range.map(place);
            return (v) => from + (to - from) * Math.min(1, Math.max(0, (place(v) - low) / (high - low)));
        };
        const [atX, atY] = [scale(x, box.left, box.right), scale(y, box.bottom, box.top)];
        for (const tick of x.ticks) {
            draw(svg, "line", { class: "tick", x1: atX(tick), x2: atX(tick), y1: box.top, y2: box.bottom });
            draw(svg, "text", { x: atX(tick), y: box.bottom + 16, "text-anchor": "middle" }, label(tick));
        }
        for (const tick of y.ticks) {
            draw(svg, "line", { class: "tick", x1: box.left, x2: box.right, y1: atY(tick), y2: atY(tick) });
            draw(svg, "text", { x: box.left - 6, y: atY(tick) + 4, "text-anchor": "end" }, label(tick));
        }
        draw(svg, "text", { x: (box.left + box.right) / 2, y: 244, "text-anchor": "middle" }, labels[0]);
        const middle = (box.top + box.bottom) / 2;
        draw(svg, "text", { x: 14, y: middle, "text-anchor": "middle", transform: `rotate(-90 14 ${middle})` }, labels[1]);
        return (points) => points.map(([a, b], i) => `${i ? "L" : "M"}${atX(a).toFixed(1)} ${atY(b).toFixed(1)}`).join("");
    }

    const label = (tick) =>
        tick >= 1000 || (tick > 0 && tick < 0.1) ? `10${raised(Math.round(Math.log10(tick)))}` : String(Number(tick.toFixed(2)));

    // Fills the rows of a table with cells of text. A row whose last cell begins with "rejected" is marked.
    function rows(table, lines) {
        table.tBodies[0].replaceChildren(
            ...lines.map((cells) => {
                const row = document.createElement("tr");
                for (const cell of cells) {
                    const td = document.createElement("td");
                    td.textContent = cell;
                    row.append(td);
                }
                row.classList.toggle("rejected", cells.at(-1).startsWith("rejected"));
                return row;
            }),
        );
    }

    // Shows an explorable: `update(settings)` now and whenever a control changes, at most once per
    // frame. Settings are the controls' values by name, and `seed`.
    function start(id, update) {
        const root = document.getElementById(id);
        const controls = root.querySelectorAll("select, input");
        let seed = 1;
        let waiting = false;
        const show = () => {
            waiting = false;
            update(root, Object.fromEntries([...controls, { name: "seed", value: seed }].map((c) => [c.name, c.value])));
        };
        const changed = () => {
            if (!waiting) requestAnimationFrame(show);
            waiting = true;
        };
        root.addEventListener("input", changed);
        root.querySelector("button").addEventListener("click", () => {
            seed += 1;
            changed();
        });
        root.hidden = false;
        show();
        check(root.querySelector(".explorable-check"));
    }

    return { axes, draw, estimate, level, number, rows, sigmas, start };
})();
