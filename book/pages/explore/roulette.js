// The explorable of the page on Russian roulette: walks in the closed furnace against closed forms.
explorePage.start("explore-roulette", (root, { albedo, survival, samples, seed }) => {
    const { axes, draw, estimate, number, rows } = explorePage;
    const [a, q] = [albedo, survival].map(Number);
    const count = [100, 200, 500, 1000, 2000, 5000, 10_000, 20_000][samples];
    const [albedoText, survivalText, samplesText] = root.querySelectorAll("output");
    albedoText.textContent = a.toFixed(2);
    survivalText.textContent = q.toFixed(2);
    samplesText.textContent = `${count.toLocaleString("en")} walks`;

    // Five runs, as five renders: the running mean of each, and all walks together.
    const exact = explore.mean(a);
    const [values, squares, lengths] = [0, 1, 2].map(() => new explore.Moments());
    const runs = [0, 1, 2, 3, 4].map((index) => {
        const random = explore.stream(seed, 0, index);
        const run = new explore.Moments();
        const line = [];
        for (let n = 1, next = 1; n <= count; n++) {
            const [value, vertices] = explore.walk(random, a, q);
            run.push(value);
            values.push(value);
            squares.push((value - exact) ** 2);
            lengths.push(vertices);
            if (n < next && n < count) continue;
            line.push([n, run.mean]);
            next = n * 1.03;
        }
        return line;
    });

    const variance = explore.variance(a, q);
    const [varianceChart, meanChart] = root.querySelectorAll("svg");

    let place = axes(varianceChart, {
        x: { range: [0, 1], ticks: [0, 0.25, 0.5, 0.75, 1] },
        y: { range: [1e-3, 1e4], ticks: [1e-3, 1e-2, 0.1, 1, 10, 100, 1000, 1e4], log: true },
        labels: ["survival probability q", "variance of a walk"],
    });
    draw(varianceChart, "path", { class: "infinite", d: `${place([[0, 1e4], [a * a, 1e4], [a * a, 1e-3], [0, 1e-3]])}Z` });
    const curve = Array.from({ length: 200 }, (_, i) => a * a + (1 - a * a) * ((i + 1) / 200) ** 2);
    draw(varianceChart, "path", { class: "exact", d: place(curve.map((x) => [x, explore.variance(a, x)])) });
    draw(varianceChart, "path", { class: "found", d: `${place([[q, squares.mean]])}h0` });

    place = axes(meanChart, {
        x: { range: [1, count], ticks: [1, 10, 100, 1000, 1e4].filter((n) => n <= count), log: true },
        y: { range: [0, 2 * exact], ticks: [0, exact / 2, exact, 1.5 * exact, 2 * exact] },
        labels: ["walks", "mean of the walks so far"],
    });
    for (const line of runs) draw(meanChart, "path", { class: "run", d: place(line) });
    draw(meanChart, "path", { class: "exact", d: place([[1, exact], [count, exact]]) });

    // The squares have a variance, and so a standard error that means something, if E X⁴ is finite:
    // q (a/q)⁴ < 1.
    const fourth = a ** 4 < q ** 3;
    const shown = fourth ? estimate(squares.mean, squares.error) : number(squares.mean);
    const vertices = explore.vertices(q);
    rows(root.querySelector("table"), [
        ["mean", Number.isFinite(variance) ? estimate(values.mean, values.error) : number(values.mean), number(exact)],
        ["variance", shown, number(variance)],
        ["vertices per walk", estimate(lengths.mean, lengths.error), number(vertices)],
        ["efficiency", number(1 / (squares.mean * lengths.mean)), number(1 / (variance * vertices))],
    ]);
    const off = ({ mean, error }, right) => (Math.abs(mean - right) / error).toFixed(1);
    const said = !Number.isFinite(variance)
        ? `The survival probability is at most the squared albedo, ${number(a * a)}: the variance is infinite. The runs stay low and jump when a rare long walk arrives. The sample variance is finite, and says nothing.`
        : !fourth
          ? `The variance is finite, but its estimate has infinite variance, because the survival probability is at most the power 4/3 of the albedo, ${number(a ** (4 / 3))}. The point is mostly too low, and stated standard errors with it.`
          : `The mean is ${off(values, exact)} standard errors from its closed form, the variance ${off(squares, variance)}.`;
    root.querySelector(".explorable-said").textContent = said;
});
