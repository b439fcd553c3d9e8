// Drives a report of `compare` by keys and clicks as a reader would, after its own script. Leaves on the page whether all
// went as it should, and what did not.
(() => {
    const failures = [];
    const expect = (what, holds) => { if (!holds) failures.push(what); };
    const byId = (id) => document.getElementById(id);
    const [viewer, stage, canvas] = ["viewer", "stage", "canvas"].map(byId);
    const { size, step, tile, channels } = JSON.parse(byId("layout").textContent);
    const floats = new DataView(Uint8Array.from(atob(byId("values").textContent), (c) => c.charCodeAt(0)).buffer);
    const columns = Math.ceil(size[0] / step);
    const count = columns * Math.ceil(size[1] / step);
    const value = (side, channel, [x, y]) => {
        const i = Math.floor(y / step) * columns + Math.floor(x / step);
        return floats.getFloat32(4 * ((side * channels.length + channel) * count + i), true);
    };

    const key = (target, name) =>
        target.dispatchEvent(new KeyboardEvent("keydown", { key: name, bubbles: true, cancelable: true }));
    // Sends an event of the pointer at the middle of a pixel of the image.
    const point = (kind, [x, y]) => {
        const box = canvas.getBoundingClientRect();
        const at = { clientX: box.left + (x + 0.5) / size[0] * box.width, clientY: box.top + (y + 0.5) / size[1] * box.height };
        canvas.dispatchEvent(new PointerEvent(kind, { ...at, bubbles: true, pointerType: "mouse" }));
    };
    const pixels = () => canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.join();
    const brightness = () => canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.reduce((a, b) => a + b);

    expect("the viewer takes the place of the means", !viewer.hidden && byId("means").hidden);
    expect("A is shown first", viewer.dataset.shown === "A");
    const first = pixels();
    key(document.body, "f");
    expect("F shows B", viewer.dataset.shown === "B" && pixels() !== first);
    expect("the caption names B and its channels", /^B.*channels /.test(byId("caption").textContent));
    key(document.body, "F");
    expect("F shows A again", viewer.dataset.shown === "A" && pixels() === first);
    byId("show-b").click();
    expect("a button shows B", viewer.dataset.shown === "B");
    byId("show-a").click();

    const before = brightness();
    key(document.body, "+");
    expect("+ is brighter", brightness() > before);
    key(document.body, "-");
    expect("- undoes it", pixels() === first);

    const middle = size.map((side) => side >> 1);
    expect("A and B differ in the middle", value(0, 0, middle) !== value(1, 0, middle));
    for (const at of [[0, 0], middle, size.map((side) => side - 1)]) {
        point("pointermove", at);
        expect(`the pointer is at ${at}`, byId("where").textContent.endsWith(`(${at.join(", ")})`));
        channels.forEach((_, c) => [0, 1].forEach((side) => {
            const shown = Number(byId(`reading-${c}`).cells[side + 1].textContent.replace("−", "-"));
            const right = value(side, c, at);
            expect(`value ${c} of side ${side} at ${at}`, Math.abs(shown - right) <= 1e-3 * Math.abs(right));
        }));
    }
    key(stage, "ArrowLeft");
    expect("an arrow moves the pointer", !byId("where").textContent.endsWith(`(${size.map((side) => side - 1).join(", ")})`));

    // From each of two tiles to its row and back.
    for (const at of [[size[0] - 1, size[1] - 1], [size[0] >> 1, 0]]) {
        point("click", at);
        const row = document.querySelector("tr.found");
        const area = row?.dataset.area.split(" ").map(Number) ?? [];
        const [x0, y0, x1, y1] = area;
        expect(`a click at ${at} finds the row of its tile`, x0 <= at[0] && at[0] < x1 && y0 <= at[1] && at[1] < y1
            && x1 - x0 <= tile && row.id.startsWith("tile-"));
        expect("the row can be seen", byId("tiles").open && row.getBoundingClientRect().height > 0);
        expect("the row has the keys", row.contains(document.activeElement));
        document.activeElement.click();
        const box = byId("mark").getBoundingClientRect();
        const whole = canvas.getBoundingClientRect();
        const left = (box.left - whole.left) / whole.width * size[0];
        expect("the row leads back", document.activeElement === stage && !byId("mark").hidden && Math.abs(left - x0) < 1);
        key(stage, "Enter");
        expect("Enter goes to the row", row.contains(document.activeElement));
    }
    document.body.dataset.driven = String(failures.length === 0);
    for (const failure of failures) console.error(`Error: ${failure}`);
})();
