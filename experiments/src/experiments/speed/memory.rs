//! Memory of programs, where the system reports it in `/proc`; elsewhere nothing is recorded.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;
use std::{env, fs, process, thread};

use crate::experiments::prelude::*;

/// Records the peak memory of the program `render` for a large image, if it lies beside this
/// program.
pub(super) fn of_an_image(run: &mut Run) -> Result<(), Error> {
    let [width, height] = run.with_run_options(Job::default()).size;
    let folder = env::temp_dir().join(format!("whitefurnace-speed-{}", process::id()));
    // Long enough that the image is saved in the meantime, as in any longer run.
    let time = run.by_tier("2s", "5s");
    let peak = peak_of_render(
        &folder,
        ["--size", &format!("{width}x{height}"), "--time", time],
    )?;
    // The folder does not exist if the program could not be started.
    let _ = fs::remove_dir_all(folder);
    if let Some(peak) = peak {
        run.number("memory.image", peak);
        run.note(
            "memory.image",
            format!("{peak:.0} MB at most, to render and write {width} x {height} pixels"),
        );
    }
    Ok(())
}

/// Returns the peak memory of an image with these options, in MB; `None` if the program is missing,
/// fails, or the system does not report it.
fn peak_of_render(folder: &Path, options: [&str; 4]) -> Result<Option<f64>, Error> {
    let program = env::current_exe()
        .map(|own| own.with_file_name(format!("render{}", env::consts::EXE_SUFFIX)));
    let Some(program) = program
        .ok()
        .filter(|program| program.is_file() && resident().is_some())
    else {
        return Ok(None);
    };
    let mut command = Command::new(program);
    command
        .args(options)
        .arg("--out")
        .arg(folder.join("image.exr"));
    let Ok(mut child) = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn() else {
        return Ok(None);
    };
    let mut peak = None;
    loop {
        // The system keeps the maximum itself: only growth in the last moments is missed.
        peak = megabytes(child.id(), "VmHWM:").or(peak);
        if let Ok(Some(status)) = child.try_wait() {
            return Ok(peak.filter(|_| status.success()));
        }
        if interrupted() {
            // The program may have ended in the meantime.
            let _ = child.kill().and_then(|()| child.wait());
            return Err(Error::Interrupted);
        }
        thread::sleep(Duration::from_millis(1));
    }
}

/// Returns the current memory of this program, in MB.
pub(super) fn resident() -> Option<f64> {
    megabytes(process::id(), "VmRSS:")
}

/// Returns a line of a process's status, in MB.
fn megabytes(process: u32, line: &str) -> Option<f64> {
    let status = fs::read_to_string(PathBuf::from(format!("/proc/{process}/status"))).ok()?;
    let value = status.lines().find_map(|text| text.strip_prefix(line))?;
    let kibibytes: f64 = value.trim().strip_suffix(" kB")?.parse().ok()?;
    Some(kibibytes * 1024.0 / 1e6)
}
