// The mathematics of the explorables: one function per equation. The book's builder evaluates the
// library's functions, and `check` in page.js compares these with them.
globalThis.explore = (() => {
    const TURN = 2 * Math.PI;

    // Random numbers: xoshiro256++ on 64-bit words in halves, the library's `stream`.
    const GOLDEN = 0x9e3779b97f4a7c15n;
    const mix = (z) => {
        z = BigInt.asUintN(64, (z ^ (z >> 30n)) * 0xbf58476d1ce4e5b9n);
        z = BigInt.asUintN(64, (z ^ (z >> 27n)) * 0x94d049bb133111ebn);
        return z ^ (z >> 31n);
    };

    // Returns a function that returns uniform numbers in [0, 1).
    function stream(seed, high, low) {
        const counter = (BigInt(high) << 32n) | BigInt(low);
        const words = [1n, 2n, 3n, 4n].map((i) => mix(counter ^ mix(BigInt.asUintN(64, BigInt(seed) + GOLDEN * i))));
        let [l0, l1, l2, l3] = words.map((word) => Number(word & 0xffffffffn) | 0);
        let [h0, h1, h2, h3] = words.map((word) => Number(word >> 32n) | 0);
        return () => {
            // s0 + s3, turned by 23 bits, plus s0
            let low = (l0 >>> 0) + (l3 >>> 0);
            let high = (h0 + h3 + (low >= 2 ** 32)) | 0;
            const turned = [(low << 23) | (high >>> 9), (high << 23) | (low >>> 9)];
            low = (turned[0] >>> 0) + (l0 >>> 0);
            high = (turned[1] + h0 + (low >= 2 ** 32)) >>> 0;
            // t = s1 << 17
            const [lt, ht] = [l1 << 17, (h1 << 17) | (l1 >>> 15)];
            l2 ^= l0; h2 ^= h0;
            l3 ^= l1; h3 ^= h1;
            l1 ^= l2; h1 ^= h2;
            l0 ^= l3; h0 ^= h3;
            l2 ^= lt; h2 ^= ht;
            // s3 turned by 45 bits
            [l3, h3] = [(h3 << 13) | (l3 >>> 19), (l3 << 13) | (h3 >>> 19)];
            return (high * 2 ** 21 + (low >>> 11)) * 2 ** -53;
        };
    }

    // Returns the first numbers of a stream.
    const uniforms = (seed, high, low, count) => Array.from({ length: count }, stream(seed, high, low));

    const spherical = (theta, phi) => [Math.sin(theta) * Math.cos(phi), Math.sin(theta) * Math.sin(phi), Math.cos(theta)];

    // Maps from two random numbers to a direction [x, y, z]; z is the normal.
    const directions = {
        // (18) and (19): cos θ = 1 − r₁, φ = 2πr₂
        uniform: ([r1, r2]) => spherical(Math.acos(1 - r1), TURN * r2),
        // sin² θ = r₁
        cosine: ([r1, r2]) => spherical(Math.asin(Math.sqrt(r1)), TURN * r2),
        // (18) and (19) as printed, one r for both angles
        printed: ([r]) => spherical(Math.acos(1 - r), TURN * r),
        // a mistake: θ = r₁π/2
        linear: ([r1, r2]) => spherical((r1 * Math.PI) / 2, TURN * r2),
    };

    const turns = ([x, y]) => {
        const turns = Math.atan2(y, x) / TURN;
        return turns < 0 ? turns + 1 : turns;
    };

    // Densities: pdf per solid angle at cos θ, and the two numbers that belong to a direction: the
    // share of the density between the pole and it, and its azimuth in turns.
    const densities = {
        uniform: { pdf: () => 1 / TURN, inverse: (w) => [1 - w[2], turns(w)] },
        cosine: { pdf: (z) => z / Math.PI, inverse: (w) => [w[0] * w[0] + w[1] * w[1], turns(w)] },
    };

    const direction = (name, random) => directions[name](random);
    const pdf = (name, z) => densities[name].pdf(z);
    const inverse = (name, w) => densities[name].inverse(w);

    // Environments: radiance from a direction, and what a white Lambert surface reflects.
    const environments = {
        white: { radiance: () => 1, reflected: 1 },
        zenith: { radiance: (w) => w[2], reflected: 2 / 3 },
        side: { radiance: (w) => 1 + w[1], reflected: 1 },
    };

    // One value of the estimator (16): L f cos θ/p with f = 1/π.
    const estimate = (environment, density, w) =>
        (environments[environment].radiance(w) * (w[2] / Math.PI)) / pdf(density, w[2]);

    // Running mean and variance, by Welford.
    class Moments {
        count = 0;
        mean = 0;
        squares = 0;
        push(value) {
            this.count += 1;
            const deviation = value - this.mean;
            this.mean += deviation / this.count;
            this.squares += deviation * (value - this.mean);
        }
        get variance() {
            return this.squares / (this.count - 1);
        }
        get error() {
            return Math.sqrt(this.variance / this.count);
        }
    }

    // Cells of equal probability: rings of inclination, and sectors of azimuth.
    const CELLS = [5, 9];
    const cell = ([share, turns]) => {
        const [ring, sector] = [share, turns].map((x, i) => Math.min(Math.floor(x * CELLS[i]), CELLS[i] - 1));
        return ring * CELLS[1] + sector;
    };

    // P(X ≥ x) of chi-square with an even number of degrees of freedom 2m: the Poisson sum
    // e^(−x/2) Σ (x/2)^k/k! over k < m, its terms by logarithms.
    function chiSquareTail(x, degrees) {
        let [sum, logarithm] = [0, -x / 2];
        for (let k = 0; k < degrees / 2; k++) {
            sum += Math.exp(logarithm);
            logarithm += Math.log(x / 2) - Math.log(k + 1);
        }
        return Math.min(sum, 1);
    }

    // Samples directions and tests them: counts per cell, chi-square against the claimed density
    // with its p-value, and the furnaces.
    function hemisphere(name, density, seed, count) {
        const random = stream(seed, 0, 0);
        const samples = Array.from({ length: count }, () => direction(name, [random(), random()]));
        const counts = new Array(CELLS[0] * CELLS[1]).fill(0);
        const furnaces = Object.fromEntries(Object.keys(environments).map((key) => [key, new Moments()]));
        for (const w of samples) {
            counts[cell(inverse(density, w))] += 1;
            for (const key in furnaces) furnaces[key].push(estimate(key, density, w));
        }
        const expected = count / counts.length;
        const chiSquare = counts.reduce((sum, n) => sum + (n - expected) ** 2 / expected, 0);
        const degrees = counts.length - 1;
        return { samples, counts, expected, chiSquare, degrees, p: chiSquareTail(chiSquare, degrees), furnaces };
    }

    // Roulette in the closed furnace: every surface emits 1 and reflects the fraction a.
    function walk(random, a, q) {
        let [radiance, throughput, vertices] = [1, 1, 1];
        const weight = a * (1 / q);
        while (random() < q) {
            throughput *= weight;
            radiance += throughput;
            vertices += 1;
        }
        return [radiance, vertices];
    }

    const mean = (a) => 1 / (1 - a);
    const vertices = (q) => 1 / (1 - q);

    // Infinite for q ≤ a²; from X = 1 + (a/q) X′ for survivors.
    function variance(a, q) {
        if (q <= a * a) return Infinity;
        return (1 + 2 * a * mean(a)) / (1 - (a * a) / q) - mean(a) ** 2;
    }

    // What the check compares as numbers: statistic, p-value, mean and standard error of each furnace.
    function hemisphereNumbers(...settings) {
        const { chiSquare, p, furnaces } = hemisphere(...settings);
        return [chiSquare, p, ...Object.values(furnaces).flatMap((moments) => [moments.mean, moments.error])];
    }

    // Mean and standard error of walks.
    function walks(a, q, seed, count) {
        const [random, moments] = [stream(seed, 0, 0), new Moments()];
        for (let i = 0; i < count; i++) moments.push(walk(random, a, q)[0]);
        return [moments.mean, moments.error];
    }

    return {
        CELLS, Moments, chiSquareTail, direction, environments, hemisphere, hemisphereNumbers,
        inverse, mean, pdf, stream, uniforms, variance, vertices, walk, walks,
    };
})();
