//! What a file says of the job that made it.

use std::fmt::Write as _;

use whitefurnace::film::Window;

use super::{ConventionName, EstimatorName, Job, PixelName, SamplerName, SceneName, name};

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
        if matches!(self.estimator, EstimatorName::Light | EstimatorName::Mis) {
            line("light-sampling", &name(self.light_sampling));
        }
        if self.estimator == EstimatorName::Mis {
            line("heuristic", &name(self.heuristic));
        }
        if self.scene == SceneName::Report && self.convention != ConventionName::Published {
            line("diffuse", &name(self.diffuse));
        }
        if self.splits() {
            line("rays", &self.rays.to_string());
        }
        if self.uses_photons() {
            self.photons.provenance(self.keeps_one_map(), &mut line);
        }
        if self.estimator == EstimatorName::Radiosity {
            line("patches", &self.patches.to_string());
        }
        line("pixel", &name(self.pixel));
        if matches!(self.pixel, PixelName::Grid | PixelName::Jitter) {
            line("grid", &self.grid.to_string());
        }
        line("sampler", &name(self.sampler));
        if self.sampler == SamplerName::Sobol {
            line("scrambles", &self.scrambles.to_string());
        }
        line("size", &format!("{width}x{height}"));
        if let Some(Window {
            corner: [x, y],
            size: [w, h],
        }) = self.window
        {
            line("window", &format!("{w}x{h}+{x}+{y}"));
        }
        line("spp", &self.spp.to_string());
        line("seed", &self.seed.to_string());
        line("complete", if complete { "yes" } else { "no" });
        text
    }
}
