//! Tests of the files and messages of a render that receives a signal.

use std::path::Path;
use std::process::Command;

use experiments::run::signals;

use crate::{folder, renders};

/// A running program, and its standard error.
pub struct Running {
    child: std::process::Child,
    lines: std::io::Lines<std::io::BufReader<std::process::ChildStderr>>,
}

impl Running {
    /// Starts a program with these arguments in a folder.
    pub fn start(program: &str, words: &[&str], folder: &Path) -> Self {
        use std::io::BufRead as _;
        let mut child = Command::new(program)
            .args(words)
            .current_dir(folder)
            .stdout(std::process::Stdio::null())
            .stderr(std::process::Stdio::piped())
            .spawn()
            .expect("the program starts");
        let errors = child.stderr.take().expect("a pipe");
        Self {
            child,
            lines: std::io::BufReader::new(errors).lines(),
        }
    }

    /// Starts `render` with these options in a folder.
    pub fn render(options: &str, folder: &Path) -> Self {
        let words: Vec<&str> = options.split_whitespace().collect();
        Self::start(env!("CARGO_BIN_EXE_render"), &words, folder)
    }

    /// Waits for a line that contains the text, without a time limit.
    pub fn wait_for(&mut self, text: &str) -> String {
        loop {
            let line = self.lines.next().expect("it goes on").expect("a line");
            if line.contains(text) {
                return line;
            }
        }
    }

    pub fn signal(&self, name: &str) {
        let id = self.child.id().to_string();
        assert!(
            Command::new("kill")
                .args([name, &id])
                .status()
                .expect("kill")
                .success()
        );
    }

    pub fn has_ended(&mut self) -> bool {
        self.child.try_wait().expect("a state").is_some()
    }

    pub fn end(mut self) -> Option<i32> {
        self.child.wait().expect("the program ends").code()
    }
}

/// Options for more samples than any machine renders before the test ends it.
pub const ENDLESS: &str = "--size 64x48 --spp 4000000000 --out a.exr --threads ";

pub fn endless(folder: &Path, threads: usize) -> Running {
    Running::render(&format!("{ENDLESS}{threads}"), folder)
}

#[test]
fn signals_write_what_is_done_beside_what_was_finished() {
    let folder = folder("signals");
    for (signal, code) in [("-INT", 130), ("-TERM", 143), ("-HUP", 129)] {
        // Tests in the background, or under nohup, inherit ignored signals.
        if signals::is_ignored(code - 128) {
            eprintln!("{signal} is ignored by who started the tests");
            continue;
        }
        renders(&folder, "--size 8x6 --spp 1 --out a.exr");
        let finished =
            ["a.exr", "a.png"].map(|file| std::fs::read(folder.join(file)).expect("there"));
        let mut render = endless(&folder, 1);
        let line = render.wait_for("% of 12.3 trillion samples");
        assert!(line.contains("/s") && line.contains("left"), "{line}");
        render.signal(signal);
        render.wait_for("interrupted");
        assert_eq!(render.end(), Some(code), "{signal}");
        let now = ["a.exr", "a.png"].map(|file| std::fs::read(folder.join(file)).expect("there"));
        assert!(now == finished, "{signal} changed what was finished");
        for file in ["a.partial.exr", "a.partial.png"] {
            std::fs::remove_file(folder.join(file)).expect("a partial image");
        }
        assert_eq!(
            std::fs::read_dir(&folder).expect("the folder").count(),
            2,
            "{signal}"
        );
    }
}

/// The number of computing threads is as requested.
#[cfg(target_os = "linux")]
#[test]
fn threads_are_as_many_as_asked_for() {
    let folder = folder("pool");
    for threads in [2, 9] {
        let mut render = endless(&folder, threads);
        render.wait_for("% of");
        let is_worker = |task: &std::io::Result<std::fs::DirEntry>| {
            // Threads that end meanwhile have no name.
            std::fs::read_to_string(task.as_ref().expect("a task").path().join("comm"))
                .is_ok_and(|name| name.starts_with(experiments::run::cli::WORKER))
        };
        let tasks = std::fs::read_dir(format!("/proc/{}/task", render.child.id())).expect("tasks");
        let workers = tasks.filter(|task| is_worker(task)).count();
        render.signal("-TERM");
        assert_eq!(render.end(), Some(143));
        assert_eq!(workers, threads);
    }
}

/// As under `nohup`: a hangup is ignored, another signal is not.
#[test]
fn a_signal_that_was_ignored_stays_ignored() {
    let folder = folder("nohup");
    let script = format!(
        "trap '' HUP; exec {} {ENDLESS} 1",
        env!("CARGO_BIN_EXE_render")
    );
    let mut render = Running::start("sh", &["-c", &script], &folder);
    render.wait_for("% of");
    render.signal("-HUP");
    render.signal("-TERM");
    render.wait_for("interrupted");
    assert_eq!(render.end(), Some(143));
}
