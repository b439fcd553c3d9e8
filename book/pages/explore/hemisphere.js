// The explorable of the page on the hemisphere: any sampler against any claimed density.
explorePage.start("explore-hemisphere", (root, { directions, density, samples, seed }) => {
    const { draw, estimate, level, number, rows, sigmas } = explorePage;
    const count = [1000, 2000, 5000, 10_000, 20_000, 50_000, 100_000][samples];
    root.querySelector("output").textContent = count.toLocaleString("en");
    const found = explore.hemisphere(directions, density, seed, count);

    drawDisc(root.querySelector("svg"), found);

    const { chiSquare, degrees, p, furnaces } = found;
    const line = (name, value, right, rejects, distance) => [name, value, right, rejects ? `rejected, ${distance}` : distance];
    const names = { white: "white furnace", zenith: "radiance cos θ", side: "radiance 1 + y" };
    const lines = Object.entries(furnaces).map(([key, { mean, error }]) => {
        const right = explore.environments[key].reflected;
        const distance = mean === right ? 0 : Math.abs(mean - right) / error;
        return line(names[key], estimate(mean, error), number(right), distance > sigmas, `${distance.toFixed(1)} σ`);
    });
    const tail = p > 0 ? `p = ${number(p)}` : "p < 10⁻³⁰⁰";
    lines.unshift(line("chi-square", number(chiSquare), `≈ ${degrees}`, p < level, tail));
    rows(root.querySelector("table"), lines);

    const seen = lines.filter((line) => line[3].startsWith("rejected")).map((line) => line[0]);
    const summary = seen.length
        ? `Rejected by: ${seen.join("; ")}.`
        : `No test rejects this pair at the trials' level of ${number(level)}, ${sigmas.toFixed(1)} σ.`;
    const blind = "In the white furnace every sample is worth exactly 1, wherever it lies: this test cannot see directions.";
    root.querySelector(".explorable-said").textContent = furnaces.white.squares === 0 ? `${summary} ${blind}` : summary;

    // Draws the hemisphere from above: cells of equal claimed probability, coloured by their
    // residuals, and up to 3000 of the directions.
    function drawDisc(svg, { samples, counts, expected }) {
        svg.replaceChildren();
        // Inclinations with the shares k/5 of the density below: 1 − cos θ or sin² θ.
        const radius = (share) => (density === "uniform" ? Math.sqrt(share * (2 - share)) : Math.sqrt(share));
        const [rings, sectors] = explore.CELLS;
        const scale = Math.max(4, Math.sqrt(expected));
        counts.forEach((n, i) => {
            const residual = (n - expected) / Math.sqrt(expected);
            const ring = Math.floor(i / sectors);
            const corner = (r, k) => {
                const phi = (2 * Math.PI * k) / sectors;
                // SVG counts y downwards.
                return `${(radius(r / rings) * Math.cos(phi)).toFixed(4)} ${(-radius(r / rings) * Math.sin(phi)).toFixed(4)}`;
            };
            const arc = (r, sweep, k) => `A${radius(r / rings)} ${radius(r / rings)} 0 0 ${sweep} ${corner(r, k)}`;
            const k = i % sectors;
            const path = draw(svg, "path", {
                class: residual < 0 ? "few" : "many",
                d: `M${corner(ring, k)}L${corner(ring + 1, k)}${arc(ring + 1, 0, k + 1)}L${corner(ring, k + 1)}${arc(ring, 1, k)}Z`,
                "fill-opacity": Math.min(0.7, (0.7 * Math.abs(residual)) / scale).toFixed(3),
            });
            draw(path, "title", {}, `${n} of ${expected.toFixed(0)} expected: ${number(residual)} σ`);
        });
        const dots = samples.slice(0, 3000).map(([x, y]) => `M${x.toFixed(3)} ${(-y).toFixed(3)}h0`);
        draw(svg, "path", { class: "dots", d: dots.join("") });
        draw(svg, "circle", { class: "horizon", r: 1 });
    }
});
