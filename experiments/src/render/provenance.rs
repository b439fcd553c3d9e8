//! What a file says of the job that made it.

use std::fmt::Write as _;

use whitefurnace::film::Window;

use super::{Job, name};

impl Job {
    /// Key=value lines of all that decides the pixels, for the EXR's attribute.
    pub fn provenance(&self, complete: bool) -> String {
        let mut text = format!(
            "program=whitefurnace\nversion={}\ncommit={}\n",
            env!("CARGO_PKG_VERSION"),
            env!("WHITEFURNACE_COMMIT")
        );
        let [width, height] = self.size;
        let mut line = |key: &str, value: &str| {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{key}={value}");
        };
        line("scene", &name(self.scene));
        line("convention", &name(self.convention));
        line("estimator", &name(self.estimator));
        if self.takes("light-sampling") {
            line("light-sampling", &name(self.light_sampling));
        }
        if self.takes("heuristic") {
            line("heuristic", &name(self.heuristic));
        }
        if self.takes("diffuse") {
            line("diffuse", &name(self.diffuse));
        }
        if self.takes("rays") {
            line("rays", &self.rays.to_string());
        }
        if self.uses_photons() {
            self.photons.provenance(self.keeps_one_map(), &mut line);
        }
        if self.takes("patches") {
            line("patches", &self.patches.to_string());
        }
        line("pixel", &name(self.pixel));
        if self.takes("grid") {
            line("grid", &self.grid.to_string());
        }
        line("sampler", &name(self.sampler));
        if self.takes("scrambles") {
            line("scrambles", &self.scrambles.to_string());
        }
        line("size", &format!("{width}x{height}"));
        if let Some(Window { corner: [x, y], size: [w, h] }) = self.window {
            line("window", &format!("{w}x{h}+{x}+{y}"));
        }
        line("spp", &self.spp.to_string());
        line("seed", &self.seed.to_string());
        line("complete", if complete { "yes" } else { "no" });
        text
    }
}
