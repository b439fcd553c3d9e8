//! The list of directives.

use whitefurnace::suggest::did_you_mean;

/// A directive that pages may use.
pub struct DirectiveKind {
    /// Name after `#`.
    pub name: &'static str,
    /// Arguments, as in the usage line.
    pub arguments: &'static str,
    /// True if it belongs in running text; the others stand alone on their lines.
    pub inline: bool,
}

pub const ALL: [DirectiveKind; 19] = [
    kind("eq", "ID", false),
    kind("ref", "ID", true),
    kind("equations", "", false),
    kind("tally", "", false),
    kind("result", "EXPERIMENT.KEY [FORMAT]", true),
    kind("figure", "EXPERIMENT/NAME.svg \"caption\"", false),
    kind(
        "compare",
        "EXPERIMENT/LEFT.png EXPERIMENT/RIGHT.png \"caption\"",
        false,
    ),
    kind("code", "PATH ITEM...", false),
    kind("cite", "KEY", true),
    kind("bibliography", "", false),
    kind("experiments", "", false),
    kind("trial", "NAME", true),
    kind("trials", "", false),
    kind("faults", "", false),
    kind("question", "\"FAMILY: FAULT\" TRIAL TRIAL...", false),
    kind("traceability", "", false),
    kind("models", "", false),
    kind("mutants", "", false),
    kind("run", "", false),
];

const fn kind(name: &'static str, arguments: &'static str, inline: bool) -> DirectiveKind {
    DirectiveKind {
        name,
        arguments,
        inline,
    }
}

impl DirectiveKind {
    /// Returns the usage line.
    pub fn usage(&self) -> String {
        let text = format!("{} {}", self.name, self.arguments);
        format!("{{{{#{}}}}}", text.trim_end())
    }
}

pub fn find(name: &str) -> Result<&'static DirectiveKind, String> {
    let found = ALL.iter().find(|kind| kind.name == name);
    found.ok_or_else(|| {
        format!(
            "unknown directive \"{name}\"{}",
            did_you_mean(name, ALL.iter().map(|kind| kind.name))
        )
    })
}
