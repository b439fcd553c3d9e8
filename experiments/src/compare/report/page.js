// The viewer of a report: A and B in one place, with exposure, values under the pointer, and ways between a tile and
// its row. Without this script the page shows both images side by side and all tables.
(() => {
    const byId = (id) => document.getElementById(id);
    const { size, step, tile, channels, exposure, captions } = JSON.parse(byId("layout").textContent);
    // Width and height of the values, each the mean of a block of step × step pixels.
    const [width, height] = size.map((side) => Math.ceil(side / step));
    const bytes = Uint8Array.from(atob(byId("values").textContent), (c) => c.charCodeAt(0));
    const values = new Float32Array(bytes.buffer);
    const [viewer, stage, canvas, mark, reading, slider] =
        ["viewer", "stage", "canvas", "mark", "reading", "exposure"].map(byId);
    const count = width * height;
    const value = (side, channel, i) => values[(side * channels.length + channel) * count + i];

    // The 8-bit sRGB value of a linear one, from 0 to 1 in steps of 1/4095.
    const encoded = Uint8Array.from({ length: 4096 }, (_, i) => {
        const linear = i / 4095;
        return Math.round(255 * (linear <= 0.0031308 ? 12.92 * linear : 1.055 * linear ** (1 / 2.4) - 0.055));
    });
    const context = canvas.getContext("2d");
    let shown = 0;

    function paint() {
        const factor = 4095 * 2 ** slider.value;
        const image = context.createImageData(width, height);
        for (let i = 0; i < count; i += 1) {
            for (let c = 0; c < 3; c += 1) {
                const linear = factor * value(shown, Math.min(c, channels.length - 1), i);
                image.data[4 * i + c] = encoded[Math.round(Math.min(4095, Math.max(0, linear)))];
            }
            image.data[4 * i + 3] = 255;
        }
        context.putImageData(image, 0, 0);
        for (const [side, button] of ["show-a", "show-b"].map(byId).entries()) {
            button.setAttribute("aria-pressed", String(side === shown));
        }
        viewer.dataset.shown = "AB"[shown];
        byId("caption").textContent = captions[shown];
        const stops = Number(slider.value);
        byId("stops").textContent = `${stops > 0 ? "+" : ""}${String(stops).replace("-", "−")} stops`;
    }

    function show(side) {
        shown = side;
        paint();
    }

    function expose(stops) {
        slider.value = stops;
        paint();
    }

    const short = (x) => (x === 0 ? "0" : Number(x.toPrecision(4)).toString().replace("-", "−"));
    const percent = (a, b) => {
        if (a === b) return "0 %";
        const difference = (100 * (a - b)) / Math.abs(b);
        return Number.isFinite(difference) ? `${difference > 0 ? "+" : ""}${short(difference)} %` : "–";
    };

    let at = [size[0] >> 1, size[1] >> 1];

    // Moves the pointer to a pixel and shows the values of both sides there.
    function read([x, y]) {
        at = [Math.min(size[0] - 1, Math.max(0, x)), Math.min(size[1] - 1, Math.max(0, y))];
        const i = Math.floor(at[1] / step) * width + Math.floor(at[0] / step);
        const where = step === 1 ? "pixel" : `mean of ${step} × ${step} pixels around`;
        byId("where").textContent = `${where} (${at.join(", ")})`;
        channels.forEach((_, c) => {
            const [a, b] = [0, 1].map((side) => value(side, c, i));
            const cells = byId(`reading-${c}`).cells;
            [short(a), short(b), percent(a, b)].forEach((text, k) => { cells[k + 1].textContent = text; });
        });
        byId("to-row").href = `#${row(at).id}`;
    }

    // Outlines a part of the images: left, top, and the first column and row outside.
    function outline([x0, y0, x1, y1]) {
        const share = (pixels, side) => `${(100 * pixels) / size[side]}%`;
        Object.assign(mark.style, {
            left: share(x0, 0), top: share(y0, 1), width: share(x1 - x0, 0), height: share(y1 - y0, 1),
        });
        mark.hidden = false;
    }

    const area = (of) => of.dataset.area.split(" ").map(Number);
    const across = Math.ceil(size[0] / tile);
    const row = ([x, y]) => byId(`tile-${Math.floor(y / tile) * across + Math.floor(x / tile)}`);

    // Goes from a pixel to the row of its tile.
    function toRow(pixel) {
        const found = row(pixel);
        byId("tiles").open = true;
        document.querySelectorAll("tr.found").forEach((other) => other.classList.remove("found"));
        found.classList.add("found");
        outline(area(found));
        found.scrollIntoView({ block: "center" });
        found.querySelector("a").focus({ preventScroll: true });
    }

    // Goes from a row to its place in the images.
    function toPlace(found) {
        const [x0, y0, x1, y1] = area(found);
        outline([x0, y0, x1, y1]);
        read([Math.floor((x0 + x1) / 2), Math.floor((y0 + y1) / 2)]);
        viewer.scrollIntoView({ block: "start" });
        stage.focus({ preventScroll: true });
    }

    // Returns the pixel of an event over a picture of the whole image.
    function pixel(event) {
        const picture = event.currentTarget;
        const box = picture.getBoundingClientRect();
        const share = [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
        // A map of tiles reaches beyond the image where the last ones are cut.
        const { naturalWidth = size[0], naturalHeight } = picture;
        const extent = naturalWidth === size[0] ? size : [naturalWidth * tile, naturalHeight * tile];
        return share.map((part, i) => Math.min(size[i] - 1, Math.max(0, Math.floor(part * extent[i]))));
    }

    canvas.width = width;
    canvas.height = height;
    stage.style.maxWidth = `calc(75vh * ${size[0] / size[1]})`;
    for (const picture of [stage, ...document.querySelectorAll(".map img")]) {
        picture.addEventListener("pointermove", (event) => read(pixel(event)));
        picture.addEventListener("click", (event) => {
            read(pixel(event));
            // A finger that reads a value should not lead away: it has the link below the image.
            if (event.pointerType === "touch") outline(area(row(at)));
            else toRow(at);
        });
    }
    stage.addEventListener("keydown", (event) => {
        const moves = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
        const move = moves[event.key];
        if (move) read(at.map((place, i) => place + move[i] * (event.shiftKey ? tile : step)));
        else if (event.key === "Enter") toRow(at);
        else return;
        event.preventDefault();
    });
    document.addEventListener("keydown", (event) => {
        if (event.ctrlKey || event.metaKey || event.altKey) return;
        const stops = Number(slider.value);
        const keys = { f: () => show(1 - shown), "+": () => expose(stops + 0.5), "=": () => expose(stops + 0.5), "-": () => expose(stops - 0.5) };
        keys[event.key.toLowerCase()]?.();
    });
    byId("show-a").addEventListener("click", () => show(0));
    byId("show-b").addEventListener("click", () => show(1));
    byId("reset").addEventListener("click", () => expose(exposure));
    slider.addEventListener("input", paint);
    byId("to-row").addEventListener("click", (event) => {
        event.preventDefault();
        toRow(at);
    });
    for (const link of document.querySelectorAll("tr[data-area] a")) {
        link.addEventListener("click", (event) => {
            event.preventDefault();
            toPlace(link.closest("tr"));
        });
    }
    byId("means").hidden = true;
    viewer.hidden = false;
    expose(exposure);
    read(at);
})();
