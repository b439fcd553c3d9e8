//! Registry of the report's equations and of those it lacks: id, number, LaTeX, source, assessment.
//!
//! Code cites an equation by an intra-doc link to its constant, trials and experiments by value,
//! the book by `id`. A wrong name is an error of the documentation, of the compiler or of the book.

/// Assessment, from trials and the literature, of an equation or method as the report prints it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Assessment {
    /// Right as printed.
    Correct,
    /// Right, but silent on a case or an assumption that breaks a literal implementation.
    Trap,
    /// Wrong as printed.
    Error,
    /// Not in the report; added because the report needs it.
    Added,
}

/// One entry of the registry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Equation {
    /// Name of its constant.
    pub name: &'static str,
    /// Stable id, used by the book and in messages.
    pub id: &'static str,
    /// Number or section in the report; empty for additions.
    pub number: &'static str,
    /// Title.
    pub title: &'static str,
    /// Form that the program uses.
    pub latex: &'static str,
    /// Form that the report prints, where it differs.
    pub printed: Option<&'static str>,
    /// Source in the literature.
    pub source: &'static str,
    /// Assessment of the printed form.
    pub verdict: Assessment,
    /// Reason for the assessment, in one sentence.
    pub finding: &'static str,
}

macro_rules! equations {
    ($($name:ident = $id:literal, $number:literal, $title:literal, $latex:literal, $printed:expr,
       $source:literal, $verdict:ident, $finding:literal;)*) => {
        $(
            #[doc = concat!($title, " (", $number, ").\n\n`", $latex, "`\n\n", $finding)]
            pub const $name: Equation = Equation {
                name: stringify!($name), id: $id, number: $number, title: $title, latex: $latex, printed: $printed,
                source: $source, verdict: Assessment::$verdict, finding: $finding,
            };
        )*
        /// All equations, in the order of the report.
        pub const ALL: &[Equation] = &[$($name),*];
    };
}

equations! {
    WHITTED = "whitted", "2.1", "Whitted ray tracing",
        r"L(\omega) = L_e + L_{\mathrm{direct}} + k_r L(\omega_r) + k_t L(\omega_t)", None,
        "Whitted, CACM 23(6), 343-349, 1980", Trap,
        "Keeps emission and the direct light of the first diffuse surface: caustics and light between diffuse surfaces are missing. The report misspells the author and year.";
    RAY = "ray", "1", "Ray",
        r"R(t) = O + tD", None,
        "Möller and Trumbore, J. Graphics Tools 2(1), 21-28, 1997", Correct,
        "The direction is a unit vector; t is a distance, not a vector.";
    TRIANGLE_POINT = "triangle.point", "2", "Point of a triangle",
        r"T(u,v) = (1-u-v)V_0 + uV_1 + vV_2", None,
        "Möller and Trumbore 1997", Correct,
        "Barycentric coordinates with u, v ≥ 0 and u + v ≤ 1.";
    TRIANGLE_SYSTEM = "triangle.system", "3", "Ray-triangle intersection, linear system",
        r"\begin{bmatrix} -D & V_1-V_0 & V_2-V_0 \end{bmatrix} \begin{bmatrix} t \\ u \\ v \end{bmatrix} = O - V_0", None,
        "Möller and Trumbore 1997", Correct,
        "Three linear equations in t, u, v.";
    TRIANGLE_SOLUTION = "triangle.solution", "4", "Ray-triangle intersection, solution of Möller and Trumbore",
        r"\begin{bmatrix} t \\ u \\ v \end{bmatrix} = \frac{1}{P \cdot E_1} \begin{bmatrix} Q \cdot E_2 \\ P \cdot T \\ Q \cdot D \end{bmatrix}", None,
        "Möller and Trumbore 1997; watertight form: Woop, Benthin and Wald, JCGT 2(1), 2013", Trap,
        "No test of the determinant, and rays aimed at a shared edge may miss both triangles.";
    SPHERE = "sphere", "5", "Sphere",
        r"\lVert \mathbf{x} - \mathbf{c} \rVert^2 = r^2", None,
        "analytic geometry", Correct,
        "The set of points at distance r from c.";
    SPHERE_RAY = "sphere.ray", "6", "Ray in the sphere's notation",
        r"\mathbf{x} = \mathbf{o} + d\,\mathbf{l}", None,
        "as (1)", Correct,
        "The same ray as (1) under other names.";
    SPHERE_DISTANCE = "sphere.distance", "7", "Ray-sphere intersection",
        r"d = -\mathbf{l}\cdot(\mathbf{o}-\mathbf{c}) \pm \sqrt{(\mathbf{l}\cdot(\mathbf{o}-\mathbf{c}))^2 - \lVert\mathbf{o}-\mathbf{c}\rVert^2 + r^2}",
        Some(r"d = -\frac{2\mathbf{l}(\mathbf{o}-\mathbf{c})}{2} \pm \sqrt{\left(\frac{2\mathbf{l}(\mathbf{o}-\mathbf{c})}{2}\right)^2 - ((\mathbf{o}-\mathbf{c})^2 - r^2)}"),
        "stable form: Haines, Günther and Akenine-Möller, Ray Tracing Gems, ch. 7, 2019", Trap,
        "Assumes a unit direction, does not say which root is meant, and cancels for far spheres.";
    RENDERING = "rendering", "8", "Rendering equation",
        r"L(x \leftarrow \omega) = L_e(x \leftarrow \omega) + \int_{\Omega} f^*(x_1,-\omega,\omega_1)\, L(x_1 \leftarrow \omega_1)\, d\omega_1", None,
        "Kajiya, SIGGRAPH 1986; Dutré, Bala and Bekaert 2006", Trap,
        "x₁ is the point that x sees along ω; the domain is the hemisphere of x₁, the full sphere for glass.";
    COSINE = "cosine", "9", "Cosine term",
        r"f^*(x_1,-\omega,\omega_1) = f_r(x_1,-\omega,\omega_1)\cos\theta_1", None,
        "Dutré, Bala and Bekaert 2006", Correct,
        "f* is not reciprocal, f_r is; the cosine is zero below the surface.";
    FRESNEL_S = "fresnel.s", "10", "Fresnel, perpendicular",
        r"R_s = \left(\frac{n_1\cos\theta_1 - n_2\sqrt{1-(\frac{n_1}{n_2}\sin\theta_1)^2}}{n_1\cos\theta_1 + n_2\sqrt{1-(\frac{n_1}{n_2}\sin\theta_1)^2}}\right)^2", None,
        "Born and Wolf, Principles of Optics, 1.5", Trap,
        "Past the critical angle the radicand is negative: total reflection, R = 1, is not mentioned.";
    FRESNEL_P = "fresnel.p", "11", "Fresnel, parallel",
        r"R_p = \left(\frac{n_1\sqrt{1-(\frac{n_1}{n_2}\sin\theta_1)^2} - n_2\cos\theta_1}{n_1\sqrt{1-(\frac{n_1}{n_2}\sin\theta_1)^2} + n_2\cos\theta_1}\right)^2", None,
        "Born and Wolf, Principles of Optics, 1.5", Trap,
        "As (10); zero at Brewster's angle.";
    FRESNEL = "fresnel", "12", "Fresnel, unpolarised",
        r"R = \frac{R_s + R_p}{2}, \quad L_t = (1-R)\left(\frac{n_2}{n_1}\right)^2 L_i",
        Some(r"R = \frac{R_s + R_p}{2}, \quad T = 1 - R \text{ (of radiance)}"),
        "Veach, thesis, 5.2, 1997", Error,
        "1 - R is the share of flux; transmitted radiance also scales with the squared ratio of indices.";
    LAMBERT = "lambert", "13", "Lambert",
        r"f_r = \frac{\rho}{\pi}", None,
        "Lambert, Photometria, 1760", Correct,
        "Energy conserving for 0 ≤ ρ ≤ 1.";
    OREN_NAYAR = "oren-nayar", "14", "Oren-Nayar",
        r"f_r = \frac{\rho}{\pi}\left(A + B\max(0,\cos(\phi_i-\phi_o))\sin\alpha\tan\beta\right)",
        Some(r"f_r = \frac{\rho}{\pi}\left(A + B\max(0,\cos(\phi_i-\phi_o))\sin\alpha\sin\beta\right)"),
        "Oren and Nayar, SIGGRAPH 1994", Error,
        "The report prints sin β for tan β, which removes the flat look at grazing angles that the model is for.";
    OREN_NAYAR_CONSTANTS = "oren-nayar.constants", "15", "Oren-Nayar constants",
        r"A = 1 - \frac{\sigma^2}{2(\sigma^2+0.33)}, \quad B = \frac{0.45\,\sigma^2}{\sigma^2+0.09}", None,
        "Oren and Nayar, SIGGRAPH 1994", Correct,
        "σ is the standard deviation of the facets' slope angle in radians, which the report does not say.";
    EON_SINGLE = "eon.single", "", "EON, single scattering",
        r"\begin{aligned} f_1 &= \frac{\rho}{\pi} A \left(1 + r\,\frac{s}{t}\right), & A &= \frac{1}{1 + \left(\frac12 - \frac{2}{3\pi}\right) r} \\ s &= \omega_i\cdot\omega_o - \cos\theta_i\cos\theta_o, & t &= \begin{cases} \max(\cos\theta_i, \cos\theta_o) & s > 0 \\ 1 & s \le 0 \end{cases} \end{aligned}", None,
        "Fujii 2013; Portsmouth, Kutz and Hill, JCGT 14(1), 2025", Added,
        "Its directional albedo is never above 1 and is 1 at grazing, for every roughness r in [0, 1].";
    EON_ALBEDO = "eon.albedo", "", "EON, directional albedo",
        r"E(\theta) = A\left(1 + \frac{r}{\pi}\,G(\theta)\right), \quad G(\theta) = \sin\theta\left(\theta - \sin\theta\cos\theta - \tfrac23\right) + \tfrac23 \tan\theta\,(1 - \sin^3\theta)", None,
        "Portsmouth, Kutz and Hill, JCGT 14(1), 2025", Added,
        "The exact integral of single scattering with ρ = 1; its average is A(1 + r(2/3 − 28/(15π))).";
    EON_MULTIPLE = "eon.multiple", "", "EON, multiple scattering",
        r"f_2 = \frac{\rho_m}{\pi}\,\frac{(1 - E(\theta_i))(1 - E(\theta_o))}{1 - \bar E}, \quad \rho_m = \frac{\rho^2 \bar E}{1 - \rho(1 - \bar E)}", None,
        "Portsmouth, Kutz and Hill, JCGT 14(1), 2025; Kulla and Conty, SIGGRAPH course, 2017", Added,
        "With it a white surface reflects all light, whatever its roughness: neither form of (14) does.";
    GGX_NORMALS = "ggx.normals", "", "GGX, distribution of normals",
        r"D(m) = \frac{\alpha^2}{\pi\,(1 + (\alpha^2 - 1)\cos^2\theta_m)^2}, \quad f_r = \frac{F\,D\,G_2}{4\cos\theta_i\cos\theta_o}", None,
        "Walter et al., EGSR 2007", Added,
        "A rough conductor that loses the light that meets a second facet.";
    GGX_MASKING = "ggx.masking", "", "GGX, height-correlated masking and shadowing",
        r"G_2 = \frac{1}{1 + \Lambda(\omega_o) + \Lambda(\omega_i)}, \quad \Lambda = \frac{\sqrt{1 + \alpha^2\tan^2\theta} - 1}{2}", None,
        "Heitz, JCGT 3(2), 2014", Added,
        "Masking of one side only is not reciprocal.";
    GGX_VISIBLE = "ggx.visible", "", "GGX, pdf by visible normals",
        r"D_o(m) = \frac{D(m)\,\max(0, \omega_o \cdot m)}{(1 + \Lambda(\omega_o))\cos\theta_o}, \quad p(\omega_i) = \frac{D_o(m)}{4\,\omega_o \cdot m}", None,
        "Heitz, JCGT 7(4), 2018", Added,
        "The Jacobian 1/(4 ω_o · m) turns a pdf of half vectors into one of directions.";
    ROUGH_GLASS = "rough-glass", "", "Rough dielectric",
        r"f = \left(F\,J_r + (1 - F)\,J_t\right)\frac{D(m)\,G_2\,(\omega_o \cdot m)}{\cos\theta_o\,\lvert\cos\theta_i\rvert}", None,
        "Walter et al., EGSR 2007", Added,
        "For radiance divided by n²: the factor of radiance is separate. J_r holds above the surface, J_t below.";
    ROUGH_GLASS_REFRACTION = "rough-glass.refraction", "", "Rough dielectric, normal and Jacobian of refraction",
        r"m \propto \pm(\omega_o + n\,\omega_i), \quad J_t = \frac{n^2\,\lvert\omega_i \cdot m\rvert}{\lVert\omega_o + n\,\omega_i\rVert^2}, \quad J_r = \frac{1}{4\,\omega_o \cdot m}", None,
        "Walter et al., EGSR 2007", Added,
        "n is the index beyond the surface to that on the side of ω_o; m points to that side.";
    ROUGH_GLASS_MASKING = "rough-glass.masking", "", "Rough dielectric, masking and shadowing",
        r"G_2 = \int_0^1 u^{\Lambda(\omega_o)} (1 - u)^{\Lambda(\omega_i)}\, du = B(1 + \Lambda(\omega_o), 1 + \Lambda(\omega_i))", None,
        "Heitz, JCGT 3(2), 2014; Heitz, Hanika, d'Eon and Dachsbacher, ACM TOG 35(4), 2016", Added,
        "u is the quantile of a facet's height: high facets are visible from above and hidden from below; for reflection they are visible from both directions.";
    ROUGH_GLASS_PDF = "rough-glass.pdf", "", "Rough dielectric, pdf by visible normals",
        r"p(\omega_i) = D_o(m)\left(F\,J_r + (1 - F)\,J_t\right)", None,
        "Walter et al., EGSR 2007; Heitz, JCGT 7(4), 2018", Added,
        "A facet is chosen among those that are seen, then reflection with its own probability F: the weight is G₂ (1 + Λ(ω_o)).";
    ESTIMATOR = "estimator", "16", "Monte Carlo estimator",
        r"\langle E \rangle = \frac{1}{N}\sum_{i=1}^{N}\frac{f(X_i)}{p(X_i)}", None,
        "Dutré, Bala and Bekaert 2006", Correct,
        "Unbiased for every N if p > 0 wherever f ≠ 0.";
    HEMISPHERE_PDF = "hemisphere.pdf", "17", "Uniform pdf of the hemisphere",
        r"\int_{\Omega} p\, d\omega = 2\pi p = 1 \Leftrightarrow p = \frac{1}{2\pi}",
        Some(r"\int_{\omega}^{2\pi} p\, d\omega = p(2\pi - 0) = 1 \Leftrightarrow p = \frac{1}{2\pi}"),
        "solid-angle measure", Correct,
        "The limits of the integral are misprinted, the result is right.";
    HEMISPHERE_THETA = "hemisphere.theta", "18", "Uniform inclination",
        r"\theta = \arccos(1 - r_1)", Some(r"\theta = \arccos(1 - r)"),
        "inversion of the distribution function", Error,
        "The report calls this importance sampling; it is the uniform hemisphere of (17).";
    HEMISPHERE_PHI = "hemisphere.phi", "19", "Uniform azimuth",
        r"\phi = 2\pi r_2", Some(r"\phi = r \cdot 2\pi"),
        "inversion of the distribution function", Error,
        "With the same r in (18) and (19), as printed, all directions lie on one curve.";
    COSINE_HEMISPHERE = "hemisphere.cosine", "", "Cosine-weighted hemisphere",
        r"\theta = \arccos\sqrt{1 - r_1}, \quad \phi = 2\pi r_2, \quad p = \frac{\cos\theta}{\pi}", None,
        "Malley's method; Pharr, Jakob and Humphreys, 4th ed., A.5.3", Added,
        "Importance sampling of the cosine in (9).";
    SOBOL = "sobol", "", "Low-discrepancy points",
        r"\#\left\{ i < 2^m : \left(\tfrac{j}{2^a}, \tfrac{k}{2^{m-a}}\right) \le (x_i, y_i) < \left(\tfrac{j+1}{2^a}, \tfrac{k+1}{2^{m-a}}\right) \right\} = 1", None,
        "Sobol' 1967; Joe and Kuo, SIAM J. Sci. Comput. 30(5), 2008; Owen 1995; Burley, JCGT 9(4), 2020", Added,
        "Points of one scramble repel each other: the error of smooth integrands falls faster, and error bars come from several scrambles.";
    ROULETTE = "roulette", "2.6.2", "Russian roulette",
        r"L' = \begin{cases} L/(1-\alpha) & r \le 1-\alpha \\ 0 & \text{otherwise} \end{cases}", None,
        "Arvo and Kirk, SIGGRAPH 1990", Trap,
        "Only the rest of the path is divided by the survival probability; one below the squared albedo has infinite variance.";
    PATH_LENGTH = "path.length", "3.1", "Limit of seven bounces",
        r"L_b = L\,(1 - a^{b+1})", Some(r"b \le 7 \text{, called unbiased}"),
        "Neumann series of the closed furnace", Error,
        "Cutting the path after b bounces is a relative bias of −a^(b+1) in a furnace of albedo a.";
    SUPERSAMPLING = "supersampling", "2.7", "Supersampling on a grid",
        r"I = \frac{1}{n^2}\sum_{j,k} L\!\left(\frac{j+\frac12}{n}, \frac{k+\frac12}{n}\right)", None,
        "report, 2.7", Trap,
        "Deterministic: its error is systematic on edges along the axes.";
    RANDOMISATION = "randomisation", "2.7", "Ray randomisation",
        r"I = \frac{1}{N}\sum_{i} L(\xi_i, \eta_i), \quad \text{jittered: } L\!\left(\frac{j+\xi}{n}, \frac{k+\eta}{n}\right)", None,
        "report, 2.7; Cook, ACM TOG 5(1), 1986", Trap,
        "Grid and randomness together are the jittered grid, whose error falls faster than that of random rays.";
    ADAPTIVE = "adaptive", "", "Adaptive sampling",
        r"n_i = m + (n - m)(1 + s_i - \langle s\rangle), \quad s_i = \min\!\left(\frac{\tilde\sigma_i^{3/4}}{\langle\tilde\sigma^{3/4}\rangle}, 8\right), \quad I_i = \frac{1}{n_i}\sum_{j \le n_i} L_{ij}", None,
        "Neyman, J. Royal Statistical Society 97(4), 558-625, 1934; Kirk and Arvo, SIGGRAPH 1991", Added,
        "Unbiased if no sample of a pixel decides its n: the noise σ̃ is that of the first samples of other pixels, averaged over neighbours.";
    SINGLE_PRECISION = "single", "", "Rounding to single precision",
        r"\mathrm{fl}(a \mathbin{\mathrm{op}} b) = (a \mathbin{\mathrm{op}} b)(1 + \delta), \quad \lvert\delta\rvert \le 2^{-24}", None,
        "IEEE 754-2019; Higham, Accuracy and Stability of Numerical Algorithms, SIAM, 2002", Added,
        "Each result of +, −, ×, ÷ and √ is the nearest number: thousands of roundings in a path hardly change its radiance, unless they change its course.";
    GEOMETRY = "geometry", "", "Geometry term",
        r"G(x,y) = \frac{\cos\theta_x\cos\theta_y}{\lVert x-y\rVert^2}", None,
        "Kajiya 1986; Dutré, Bala and Bekaert 2006", Added,
        "Changes the measure of (8) from solid angle to area, as every shadow ray needs.";
    REFRACTION = "refraction", "", "Refraction and its radiance factor",
        r"n_1\sin\theta_1 = n_2\sin\theta_2, \quad \frac{L_1}{n_1^2} = \frac{L_2}{n_2^2}", None,
        "Snell; Veach, thesis, 5.2, 1997", Added,
        "A camera path from n₁ into n₂ multiplies its throughput by (n₁/n₂)².";
    MIS = "mis", "", "Multiple importance sampling",
        r"w_s = \frac{p_s}{\sum_k p_k}", None,
        "Veach and Guibas, SIGGRAPH 1995", Added,
        "Counts light that is both hit and sampled once.";
    MIS_POWER = "mis.power", "", "Power heuristic",
        r"w_s = \frac{p_s^2}{\sum_k p_k^2}", None,
        "Veach and Guibas, SIGGRAPH 1995", Added,
        "Weights the better strategy more strongly; the mean is that of every heuristic.";
    SOLID_ANGLE = "solid-angle", "", "Solid angle of a triangle",
        r"\tan\frac{\Omega}{2} = \frac{a \cdot (b \times c)}{1 + a \cdot b + b \cdot c + c \cdot a}", None,
        "van Oosterom and Strackee, IEEE Trans. Biomed. Eng. 30(2), 125-126, 1983", Added,
        "For unit vectors to the vertices; no sum of angles cancels.";
    LIGHT_TRIANGLE = "light.triangle", "", "Uniform sampling of a triangle by solid angle",
        r"\Omega(A, B, C') = r_1\Omega, \quad \cos(B, P) = 1 - r_2(1 - B \cdot C'), \quad p = \frac{1}{\Omega}", None,
        "Arvo, SIGGRAPH 1995", Added,
        "C' on the arc AC solves the solid angle's formula for the tangent of half its arc: no cancellation.";
    LIGHT_RECTANGLE = "light.rectangle", "", "Uniform sampling of a rectangle by solid angle",
        r"\Omega = \sum_{i=0}^{3}\arcsin(z_i z_{i+1}), \quad p = \frac{1}{\Omega}", None,
        "Ureña, Fajardo and King, Computer Graphics Forum 32(4), 2013", Added,
        "z are the components, along the rectangle's normal, of the unit normals of the planes through its edges.";
    LIGHT_SPHERE = "light.sphere", "", "Uniform sampling of a sphere by solid angle",
        r"\Omega = \frac{2\pi\sin^2\theta}{1 + \cos\theta}, \quad \sin\theta = \frac{R}{d}, \quad p = \frac{1}{\Omega}", None,
        "Shirley, Wang and Zimmerman, ACM TOG 15(1), 1996", Added,
        "The form 2π(1 - cos θ) loses all digits for far spheres; half of the points uniform in area are unseen.";
    LIGHT_PICK = "light.pick", "", "Selection of an emitter",
        r"p_i = (1 - \varepsilon)\frac{C_i}{\sum_k C_k} + \frac{\varepsilon\,[C_i > 0]}{\#\{k : C_k > 0\}}, \quad C = L_e A \left(\frac{h + a}{d^2 + a^2}\right)^2, \quad a^2 = \frac{A}{\pi}", None,
        "Shirley, Wang and Zimmerman, ACM TOG 15(1), 1996, with C and ε of our own", Added,
        "The importance of an emitter, at distance d and height h over its plane, must be above 0 wherever it is visible.";
    SPECULAR_ANGLE = "specular.angle", "", "Specular connections at a sphere",
        r"f(\alpha) = 2\alpha - 2\beta - \arcsin\frac{\sin\alpha}{X} - \arcsin\frac{\sin\alpha}{Y} = \tau, \quad \sin\beta = \frac{\sin\alpha}{n}", None,
        "Mitchell and Hanrahan, SIGGRAPH 1992; Walter, Zhao, Holzschuch and Bala, ACM TOG 28(3), 2009", Added,
        "Between points at distances X and Y of the centre, in radii, an angle Θ apart. A reflection has β = 0, τ = Θ and one root; light through glass has τ = ±(π − Θ) and up to three. As f is convex, Newton's steps find all.";
    SPECULAR_SPREAD = "specular.spread", "", "Geometry term of a specular connection",
        r"\frac{d\omega}{dA_\perp} = \frac{\sin\alpha\cos\alpha}{r^2\,X Y \sin\Theta\,\sqrt{X^2 - \sin^2\alpha}\,\sqrt{Y^2 - \sin^2\alpha}\,\lvert f'(\alpha)\rvert}", None,
        "Walter, Zhao, Holzschuch and Bala, ACM TOG 28(3), 2009", Added,
        "Replaces the 1/d² of a straight connection. It is the same from either end, and unbounded where f' = 0: the caustic.";
    PHOTON_FLUX = "photon.flux", "", "Flux of a photon",
        r"\Delta\Phi = \frac{L_e \cos\theta}{N\, p_A\, p_\omega}", None,
        "Jensen, EGWR 1996", Added,
        "N counts the particles that were emitted, not the photons that were stored.";
    PHOTON_DENSITY = "photon.density", "", "Radiance from photons",
        r"L_r(x, \omega) \approx \frac{1}{\pi r^2} \sum_{\lVert x_p - x\rVert \le r} f_r(x, \omega_p, \omega)\,\Delta\Phi_p", None,
        "Jensen, EGWR 1996", Added,
        "The mean over a disc in place of the point: on a plane a bias of order r² and no other.";
    PHOTON_RADIUS = "photon.radius", "", "Radius of pass i",
        r"r_{i+1}^2 = \frac{i + \alpha}{i + 1}\, r_i^2, \quad \alpha = \tfrac{2}{3}", None,
        "Hachisuka and Jensen, ACM TOG 28(5), 2009; Knaus and Zwicker, ACM TOG 30(3), 2011", Added,
        "Bias and variance of the mean of the passes both go to zero for 0 < α < 1.";
    IMPORTANCE = "importance", "", "Importance of a pixel",
        r"W(\omega) = \frac{1}{A\cos^3\theta}", None,
        "Veach, thesis, 8.2, 1997; Pharr, Jakob and Humphreys, 4th ed., 5.4", Added,
        "Response to radiance of a pixel of area A at distance 1; particles need it, camera rays include it.";
    PATH_DENSITY = "path.density", "", "Density of a whole path",
        r"p_s = \prod_{i<s} p_L(x_i)\, \prod_{i \ge s} p_E(x_i), \quad w_s = \frac{p_s}{\sum_k p_k}", None,
        "Veach, thesis, 10.2, 1997; Lafortune and Willems, Compugraphics, 145-153, 1993", Added,
        "All densities are with respect to area, so that every split of one path can be compared. A single vertex from the light has the density with which a shadow ray picks it.";
    FORM_FACTOR = "form-factor", "", "Form factor of a polygon",
        r"F_{x \to P} = \frac{1}{\pi}\int_P G(x,y)\, dA_y = -\frac{1}{2\pi}\sum_k \Gamma_k\, \mathbf{n}_x\cdot\frac{\mathbf{v}_k\times\mathbf{v}_{k+1}}{\lVert\mathbf{v}_k\times\mathbf{v}_{k+1}\rVert}", None,
        "Lambert, Photometria, 1760; Baum, Rushmeier and Winget, SIGGRAPH 1989", Added,
        "Exact for a polygon above the horizon that nothing hides; Γ is the angle that an edge subtends, and the corners run counter-clockwise from the front.";
    RADIOSITY = "radiosity", "", "Radiosity",
        r"B_i = E_i + \rho_i \sum_j F_{ij} B_j", None,
        "Goral, Torrance, Greenberg and Battaile, SIGGRAPH 1984", Added,
        "The rendering equation for Lambert surfaces, radiosity constant over each patch: its error falls as the patches do.";
}

/// Returns the equation with this id.
pub fn by_id(id: &str) -> Option<&'static Equation> {
    ALL.iter().find(|equation| equation.id == id)
}
